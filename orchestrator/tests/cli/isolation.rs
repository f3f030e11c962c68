//! Points share processes only where that is proven, and every result is what the FMU gives alone.

use std::fs;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Bench, Said, model};

pub const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 1
step = 0.1
[design]
points = 1000
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 2
[criteria.Y]
variable = "lag.y"
nominal = 0.6
tolerance = 0.2
"#;

/// An FMU whose start takes so long that reuse pays.
fn bench(macros: &[&str]) -> Bench {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &[&["SLOW_START"], macros].concat(), &model("", ""));
    bench.write("study.toml", STUDY);
    bench
}

fn verify(bench: &Bench, folder: &str, options: &[&str]) -> Said {
    let said =
        bench.run(&[&["verify", "study.toml", "--verbose", "--jobs", "2", "--output", folder], options].concat());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    said
}

#[test]
fn reuse_is_audited() {
    let bench = bench(&[]);
    let said = verify(&bench, "shared", &[]);
    let summary = bench.summary("shared");
    assert_eq!(summary["isolation"], "audited");
    assert!(summary["audits_of_shared"].as_u64().unwrap() > 0);
    assert_eq!(summary["audit_mismatches"], 0);
    assert!(said.out.contains("\npoints shared processes; "), "{}", said.out);
    assert!(bench.read("shared/report.html").contains("1-(1-f)^"));
    verify(&bench, "fresh", &["--isolation", "fresh"]);
    assert_eq!(bench.summary("fresh")["isolation"], "fresh");
    assert_eq!(bench.read("shared/points.csv"), bench.read("fresh/points.csv"));
}

#[test]
fn reuse_that_errs_later_is_found_and_undone() {
    let right = bench(&[]);
    verify(&right, "out", &["--isolation", "fresh"]);
    // Later than any trial.
    let drifting = bench(&["DRIFT=100"]);
    let said = verify(&drifting, "out", &[]);
    let summary = drifting.summary("out");
    assert_eq!(summary["isolation"], "fresh");
    assert!(summary["audit_mismatches"].as_u64().unwrap() > 0);
    assert_eq!(summary["reproducible"], true);
    assert!(said.out.contains("all points were computed again, each alone"), "{}", said.out);
    assert_eq!(drifting.read("out/points.csv"), right.read("out/points.csv"));
    // Whoever wants that gets it.
    verify(&drifting, "reuse", &["--isolation", "reuse"]);
    assert_eq!(drifting.summary("reuse")["isolation"], "reuse");
    assert_ne!(drifting.read("reuse/points.csv"), right.read("out/points.csv"));
}

#[test]
fn a_resumed_run_does_not_share_processes_again_after_a_refutation() {
    let bench = bench(&["DRIFT=100"]);
    verify(&bench, "right", &["--isolation", "fresh"]);
    let refutations = || {
        let journal = fs::read_to_string(bench.path("killed/journal.txt")).unwrap_or_default();
        journal.matches(r#"note {"Void":"Used"}"#).count()
    };
    let mut command = bench.command(&["verify", "study.toml", "--jobs", "2", "--output", "killed"]);
    let mut run = command.stdout(Stdio::null()).spawn().unwrap();
    while refutations() == 0 {
        assert!(run.try_wait().unwrap().is_none());
        sleep(Duration::from_millis(2));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    verify(&bench, "killed", &["--resume"]);
    assert_eq!(refutations(), 1);
    assert_eq!(bench.summary("killed")["isolation"], "fresh");
    assert_eq!(bench.read("killed/points.csv"), bench.read("right/points.csv"));
}

#[test]
fn a_trial_finds_what_errs_at_once() {
    let bench = bench(&["DRIFT=1"]);
    verify(&bench, "out", &[]);
    let summary = bench.summary("out");
    assert_eq!(summary["isolation"], "fresh");
    assert_eq!(summary["audits_of_shared"], 0);
}

#[test]
fn an_fmu_that_differs_in_few_points_is_found_however_points_are_run() {
    // 5 % of the points.
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["UNWRITTEN_ABOVE=1.925"], &model("", ""));
    bench.write("study.toml", STUDY);
    for isolation in ["audited", "fresh"] {
        let options = ["--points", "200", "--isolation", isolation];
        let labels = ["once", "again"].map(|folder| {
            let said = verify(&bench, folder, &options);
            let mut lines = said.out.lines();
            let remark = lines.find(|line| line.contains("not reproducible: "));
            let remark = remark.unwrap();
            let report = bench.read(&format!("{folder}/report.html"));
            let summary = bench.summary(folder);
            assert!(remark.contains("Warning: not reproducible: "), "{remark}");
            assert!(report.contains("Not reproducible: "));
            assert!(summary["audit_mismatches"].as_u64().unwrap() > 0);
            summary["reproducible"].clone()
        });
        assert_eq!(labels, [false, false]);
    }
}

#[test]
fn a_label_says_on_how_many_points_it_rests() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let basis = |folder: &str, options: &[&str]| {
        let said = verify(&bench, folder, &[&["--points", "20"], options].concat());
        let summary = bench.summary(folder);
        let basis = summary["reproducibility"].as_str().unwrap().to_owned();
        assert!(said.out.contains(&basis), "{}", said.out);
        // There it is a sentence of its own.
        let page = bench.read(&format!("{folder}/report.html"));
        assert!(page.contains(&basis[1..]) && !page.contains(&basis));
        (summary["audits"].as_u64().unwrap(), basis)
    };
    for isolation in ["audited", "fresh"] {
        let (audits, basis) = basis(isolation, &["--isolation", isolation]);
        assert!((1..=20).contains(&audits));
        assert!(basis.starts_with(&format!("reproducible: {audits} point")));
    }
    let (audits, basis) = basis("here", &["--in-process"]);
    assert!(audits == 0 && basis.contains("not known"), "{basis}");
}

/// Points have a working directory of their own, and what the environment names is relative to the user's.
#[test]
fn libraries_are_found_by_relative_paths() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["UNLOADABLE"], &model("", ""));
    bench.write("study.toml", STUDY);
    bench.write("helper.c", "int lag_absent;\n");
    fs::create_dir(bench.path("own")).unwrap();
    let compiled = Command::new("cc")
        .args(["-shared", "-fPIC", "helper.c", "-o", "own/libhelper.so"])
        .current_dir(bench.path(""))
        .status();
    assert!(compiled.unwrap().success());
    let study = ["verify", "study.toml", "--points", "4", "--output"];
    bench.run(&[&study[..], &["without"]].concat()).is_mistake(&["lag_absent"]);
    for (folder, library) in [("path", "libhelper.so"), ("file", "own/libhelper.so")] {
        let said: Said = bench
            .command(&[&study[..], &[folder]].concat())
            .env("LD_LIBRARY_PATH", "own")
            .env("LD_PRELOAD", library)
            .output()
            .unwrap()
            .into();
        assert_eq!(said.code, 0, "{}", said.err);
    }
}
