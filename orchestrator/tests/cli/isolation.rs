//! Every result is what the FMU gives alone, unless the user trusts it; what runs again is compared with what is recorded.

use std::fs;
use std::process::Command;

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

fn bench(macros: &[&str]) -> Bench {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", macros, &model("", ""));
    bench.write("study.toml", &STUDY.replace("1000", "60"));
    bench
}

fn verify(bench: &Bench, folder: &str, options: &[&str]) -> Said {
    let said =
        bench.run(&[&["verify", "study.toml", "--verbose", "--jobs", "2", "--output", folder], options].concat());
    // An FMU that tells the time misses every tolerance.
    assert!(said.code < 2, "{}{}", said.out, said.err);
    said
}

#[test]
fn points_run_alone_unless_the_user_trusts_the_fmu() {
    let right = bench(&[]);
    verify(&right, "out", &[]);
    assert_eq!(right.summary("out")["isolation"], "fresh");
    // From the second point of a process on the results are wrong.
    let drifting = bench(&["DRIFT=1"]);
    verify(&drifting, "out", &[]);
    assert_eq!(drifting.summary("out")["reproducible"], true);
    assert_eq!(drifting.read("out/points.csv"), right.read("out/points.csv"));
    for isolation in ["shared", "none"] {
        verify(&right, isolation, &["--isolation", isolation]);
        assert_eq!(right.read(&format!("{isolation}/points.csv")), right.read("out/points.csv"));
    }
    // Whoever wants that gets it, and is told.
    let said = verify(&drifting, "shared", &["--isolation", "shared"]);
    assert!(said.out.contains("points share processes, as you asked"), "{}", said.out);
    assert_eq!(drifting.summary("shared")["isolation"], "shared");
    assert_eq!(drifting.summary("shared")["reproducible"], false);
    assert_ne!(drifting.read("shared/points.csv"), right.read("out/points.csv"));
}

#[test]
fn words_of_earlier_versions_are_answered_by_the_new_ones() {
    let bench = bench(&[]);
    let ask = |options: &[&str]| bench.run(&[&["verify", "study.toml"], options].concat());
    ask(&["--isolation", "reuse"]).is_mistake(&["`shared`"]);
    ask(&["--isolation", "audited"]).is_mistake(&["has no audits"]);
    ask(&["--in-process"]).is_mistake(&["--isolation none"]);
    ask(&["--isolation", "none", "--launcher", "env"]).is_mistake(&["--isolation", "launcher"]);
}

/// What an FMU takes from the clock, from an address, from its process or from its path is told by every run, by `replay` and
/// by `check`; so is memory that it never wrote.
#[test]
fn what_depends_on_more_than_the_parameters_is_told() {
    for (seed, points) in [
        ("SEED=({ struct timespec now; clock_gettime(CLOCK_REALTIME, &now); now.tv_nsec / 1000; })", "4"),
        ("SEED=(uintptr_t)i / 16 % 65536", "20"),
        ("SEED=getpid()", "4"),
        ("PATH_MATTERS", "20"),
        ("UNWRITTEN", "20"),
    ] {
        let bench = bench(&[seed]);
        let said = verify(&bench, "out", &["--points", points]);
        let remark = said.out.lines().find(|line| line.contains("not reproducible: "));
        let remark = remark.unwrap_or_else(|| panic!("{seed}: {}", said.out));
        assert!(remark.contains("Warning: not reproducible: ") && remark.contains(" recorded, "), "{remark}");
        assert!(bench.read("out/report.html").contains("Not reproducible: "));
        assert_eq!(bench.summary("out")["reproducible"], false, "{seed}");
        // What lies in unwritten memory may be the same by chance where one point runs again.
        if seed != "UNWRITTEN" {
            let said = bench.run(&["replay", "out", "2"]);
            assert!(said.out.contains("warning: these are not the results that out holds: "), "{seed}: {}", said.out);
        }
        let said = bench.run(&["check", "lag.fmu", "--format", "json"]);
        let rule = if seed == "UNWRITTEN" { "\"memory-written\"" } else { "\"reproducible\"" };
        assert!(said.out.contains(rule), "{seed}: {}", said.out);
    }
}

/// What only one process of a machine can hold is told where points run beside each other, and by `check`.
#[cfg(target_os = "linux")]
#[test]
fn what_points_meet_at_is_told() {
    let lock = |file: &str, way: &str| format!("flock(open({file}, O_RDWR | O_CREAT, 0600), {way} | LOCK_NB)");
    let file = "getenv(\"LAG_HELD\")";
    for (holds, told) in [
        ("waits(AF_INET, SOCK_STREAM)".to_owned(), "TCP port "),
        ("waits(AF_INET, SOCK_DGRAM)".to_owned(), "UDP port "),
        ("waits(AF_UNIX, SOCK_STREAM)".to_owned(), "socket \"lag "),
        (lock(file, "LOCK_EX"), "lock of held.txt"),
        // Others may have these, too.
        (lock(file, "LOCK_SH"), ""),
        (lock("\"own.txt\"", "LOCK_EX"), ""),
        ("socket(AF_INET, SOCK_STREAM, 0)".to_owned(), ""),
    ] {
        let bench = bench(&[&format!("HOLDS={holds}")]);
        let run = |arguments: &[&str]| -> Said {
            bench.command(arguments).env("LAG_HELD", bench.path("held.txt")).output().unwrap().into()
        };
        // Alone no point meets another, whatever it holds.
        let jobs: &[&str] = if ["TCP", "lock"].iter().any(|way| told.starts_with(way)) { &["2", "1"] } else { &["2"] };
        for jobs in jobs {
            let said = run(&["verify", "study.toml", "--points", "4", "--verbose", "--jobs", jobs, "--output", jobs]);
            let held = bench.summary(jobs)["held"]["first"]["message"].as_str().unwrap_or_default().to_owned();
            let is_told = !told.is_empty() && *jobs == "2";
            assert!(if is_told { held.starts_with(told) } else { held.is_empty() }, "{holds}, {jobs}: {held}");
            let words = ": the FMU holds a port, a socket or a lock of this machine";
            assert_eq!(said.out.contains(words), is_told, "{holds}, {jobs}: {}", said.out);
        }
        let said = run(&["check", "lag.fmu", "--format", "json"]);
        assert_eq!(said.out.contains("\"held\""), !told.is_empty(), "{holds}: {}", said.out);
        assert!(said.out.contains(&told.replace('"', "\\\"")), "{}", said.out);
    }
}

#[test]
fn replay_of_what_is_recorded_warns_of_nothing() {
    let sound = bench(&[]);
    verify(&sound, "out", &["--points", "4"]);
    let said = sound.run(&["replay", "out", "2"]);
    assert!(!said.out.contains("warning"), "{}", said.out);
}

#[test]
fn a_label_says_what_was_compared() {
    let bench = bench(&[]);
    let basis = |folder: &str, options: &[&str]| {
        let said = verify(&bench, folder, &[&["--points", "20"], options].concat());
        let basis = bench.summary(folder)["reproducibility"].as_str().unwrap().to_owned();
        assert!(said.out.contains(&basis), "{}", said.out);
        basis
    };
    for isolation in ["fresh", "shared"] {
        let basis = basis(isolation, &["--isolation", isolation]);
        assert!(basis.contains(" points ran again, ") && basis.contains("s later"), "{basis}");
    }
    assert!(basis("here", &["--isolation", "none"]).contains("not known"));
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
