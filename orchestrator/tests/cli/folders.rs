//! A folder of results belongs to one study and to one run at a time, and to whom the user wants it to.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::support::{Bench, Said, model};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[design]
method = "sobol"
points = 16
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.3
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.1
"#;

const FIT: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[identify]
starts = 4
descents = 1
[identify.free."lag.rate"]
min = 0.1
max = 10
[identify.measured.Y]
variable = "lag.y"
value = 0.86
accuracy = 0.01
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    bench.write("fit.toml", FIT);
    bench
}

fn verify(bench: &Bench, study: &str, more: &[&str]) -> Said {
    bench.run(&[&["verify", study, "--output", "out"], more].concat())
}

/// All files and folders in a folder.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let inner = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let inner = inner.flat_map(|path| match path.is_dir() {
        true => entries(&path),
        false => vec![path],
    });
    [folder.to_owned()].into_iter().chain(inner).collect()
}

#[test]
fn the_umask_decides_who_may_read_every_file() {
    let bench = bench();
    bench.write("table.csv", "point,Y\n1,0.86\n");
    let program = env!("CARGO_BIN_EXE_orchestrator");
    for (umask, file, folder) in [("027", 0o640, 0o750), ("077", 0o600, 0o700), ("002", 0o664, 0o775)] {
        let commands = [
            format!("verify study.toml --output {umask}"),
            format!("replay {umask} 2"),
            format!("sensitivity study.toml --base 4 --output {umask}"),
            format!("identify fit.toml --output {umask}/fit"),
            format!("judge study.toml table.csv --output {umask}/judged"),
        ];
        for command in commands {
            let script = format!("umask {umask}; exec {program} {command}");
            let mut shell = Command::new("sh");
            let said: Said = shell.args(["-c", &script]).current_dir(bench.path("")).output().unwrap().into();
            assert!(said.code < 2, "{command}: {}", said.err);
        }
        let all = entries(&bench.path(umask));
        assert!(all.len() > 20, "{all:?}");
        for path in all {
            let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o777;
            let usual = if path.is_dir() { folder } else { file };
            assert_eq!(mode, usual, "{}: {mode:o}", path.display());
        }
    }
}

#[test]
fn another_study_file_or_fmu_needs_force() {
    let bench = bench();
    bench.write("other.toml", STUDY);
    bench.write("table.csv", "point,Y\n1,0.86\n");
    fs::copy(bench.path("lag.fmu"), bench.path("copy.fmu")).unwrap();
    assert_eq!(verify(&bench, "study.toml", &[]).code, 0);
    let before = bench.read("out/summary.json");
    let refused = |said: Said, what: &str| {
        said.is_mistake(&["out holds results of", what, "--force", "another --output"]);
        assert_eq!(bench.read("out/summary.json"), before);
    };
    refused(verify(&bench, "other.toml", &[]), "another study file, /");
    refused(verify(&bench, "other.toml", &["--resume"]), "another study file");
    refused(verify(&bench, "study.toml", &["--fmu", "copy.fmu"]), "another FMU, /");
    for command in [
        &["judge", "other.toml", "table.csv"][..],
        &["sensitivity", "other.toml", "--base", "4"],
        &["robustness", "other.toml", "--from", "out"],
        &["identify", "fit.toml"],
    ] {
        let command = [command, &["--output", "out"]].concat();
        refused(bench.run(&command), "another study file");
    }
    let shard = ["--output", "part", "--shard", "1/1"];
    assert_eq!(bench.run(&[&["verify", "other.toml"], &shard[..]].concat()).code, 0);
    refused(bench.run(&["merge", "part", "--output", "out"]), "another study file");
    // The same path by another name is the same file.
    let here = bench.path("lag.fmu");
    let same = ["--fmu", here.to_str().unwrap()];
    assert_eq!(verify(&bench, "./study.toml", &same).code, 0);
    assert_eq!(verify(&bench, "study.toml", &["--fmu", "copy.fmu", "--force"]).code, 0);
    // Without the option it is another FMU again.
    verify(&bench, "study.toml", &[]).is_mistake(&["another FMU, /", "copy.fmu"]);
    let said = bench.run(&["judge", "other.toml", "table.csv", "--output", "out", "--force"]);
    assert_eq!(said.code, 0, "{}", said.err);
    verify(&bench, "study.toml", &[]).is_mistake(&["another study file", "other.toml"]);
    assert_eq!(bench.run(&["merge", "part", "--output", "out", "--force"]).code, 0);
    assert_eq!(bench.summary("out")["provenance"]["study"], "other.toml");
}

#[test]
fn changed_contents_of_the_same_files_replace_a_finished_run_and_say_so() {
    let bench = bench();
    assert_eq!(verify(&bench, "study.toml", &[]).err, "");
    assert_eq!(verify(&bench, "study.toml", &[]).err, "");
    bench.write("study.toml", &STUDY.replace("tolerance = 0.1", "tolerance = 0.2"));
    let said = verify(&bench, "study.toml", &[]);
    assert_eq!((said.code, said.err.lines().count()), (0, 1), "{}", said.err);
    assert!(said.err.contains("another study (") && said.err.contains("they are replaced"), "{}", said.err);
    bench.fmu("lag.fmu", &["OTHER"], &model("A first-order lag", "Another lag"));
    verify(&bench, "study.toml", &["--resume"]).is_mistake(&["another FMU (", "--force instead of --resume"]);
    let said = verify(&bench, "study.toml", &[]);
    assert_eq!((said.code, said.err.lines().count()), (0, 1), "{}", said.err);
    assert!(said.err.contains("another FMU ("), "{}", said.err);
    // A study that names another FMU has changed, no more.
    fs::copy(bench.path("lag.fmu"), bench.path("copy.fmu")).unwrap();
    bench.write("study.toml", &STUDY.replace("lag.fmu", "copy.fmu"));
    assert_eq!(verify(&bench, "study.toml", &[]).code, 0);
    // One that has begun is not lost, but with force.
    fs::remove_file(bench.path("out/summary.json")).unwrap();
    verify(&bench, "study.toml", &[]).is_mistake(&["begun already", "--resume", "--force"]);
    assert_eq!(verify(&bench, "study.toml", &["--force"]).code, 0);
    assert_eq!(verify(&bench, "study.toml", &["--force", "--resume"]).code, 2);
}

#[test]
fn files_that_no_run_has_written_need_force() {
    let bench = bench();
    bench.write("table.csv", "point,Y\n1,0.86\n");
    for file in ["report.html", "points.csv", "summary.json", "study.toml"] {
        let place = format!("{file}.out");
        fs::create_dir(bench.path(&place)).unwrap();
        let path = format!("{place}/{file}");
        bench.write(&path, "precious");
        for command in [&["verify", "study.toml"][..], &["judge", "study.toml", "table.csv"]] {
            let command = [command, &["--output", &place]].concat();
            bench.run(&command).is_mistake(&[&path, "before any run wrote", "--force"]);
        }
        assert_eq!(bench.read(&path), "precious");
        let said = bench.run(&["verify", "study.toml", "--output", &place, "--force"]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert_ne!(bench.read(&path), "precious");
    }
    // The study itself is none.
    let said = bench.run(&["verify", "study.toml", "--output", "."]);
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn a_folder_that_is_gone_is_told_before_all_that_follows_from_it() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["NAP=3000"], &model("", ""));
    bench.write("study.toml", STUDY);
    let command = ["verify", "study.toml", "--output", "out"];
    let mut command = bench.command(&command);
    let child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn();
    let child = child.unwrap();
    while !bench.path("out/study.toml").exists() {
        sleep(Duration::from_millis(1));
    }
    fs::rename(bench.path("out"), bench.path("elsewhere")).unwrap();
    let said: Said = child.wait_with_output().unwrap().into();
    said.is_mistake(&["out: this folder, or the journal in it, was removed or moved"]);
}

#[test]
fn a_link_is_replaced_and_what_it_leads_to_is_not_touched() {
    let bench = bench();
    assert_eq!(verify(&bench, "study.toml", &[]).code, 0);
    let files = ["report.html", "points.csv", "summary.json", "point-2.csv", "plots/margins.svg"];
    fs::create_dir_all(bench.path("out/plots")).unwrap();
    for file in files {
        let path = bench.path(&format!("out/{file}"));
        let _ = fs::remove_file(&path);
        bench.write("precious", "precious");
        std::os::unix::fs::symlink(bench.path("precious"), &path).unwrap();
    }
    assert_eq!(verify(&bench, "study.toml", &["--force"]).code, 0);
    assert!(bench.run(&["replay", "out", "2"]).code < 2);
    assert_eq!(bench.run(&["report", "out"]).code, 0);
    assert_eq!(bench.read("precious"), "precious");
    let elsewhere = bench.path("elsewhere");
    fs::create_dir(&elsewhere).unwrap();
    fs::remove_dir_all(bench.path("out/plots")).unwrap();
    std::os::unix::fs::symlink(&elsewhere, bench.path("out/plots")).unwrap();
    assert_eq!(bench.run(&["report", "out"]).code, 0);
    assert_eq!(fs::read_dir(&elsewhere).unwrap().count(), 0);
    for file in &files[..4] {
        let path = bench.path(&format!("out/{file}"));
        assert!(!fs::symlink_metadata(path).unwrap().is_symlink(), "{file}");
    }
}

/// A command that has come to its finale and stands still there; and a second one that is to be refused meanwhile.
fn in_its_finale(bench: &Bench, command: &[&str], folder: &str) -> Child {
    loop {
        let _ = fs::remove_dir_all(bench.path(folder));
        let mut child = bench.command(command).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !bench.path(&format!("{folder}/summary.json")).exists() && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_micros(200));
        }
        signal(&child, "-STOP");
        if child.try_wait().unwrap().is_none() {
            return child;
        }
    }
}

fn signal(child: &Child, name: &str) {
    let number = child.id().to_string();
    // It may have ended by now.
    let _ = Command::new("kill").args([name, &number]).stderr(Stdio::null()).status();
}

fn hidden(bench: &Bench, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(bench.path(folder)).unwrap().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.starts_with('.')).collect();
    names.sort();
    names
}

#[test]
fn a_folder_is_one_runs_until_the_end_of_its_finale() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["SLOW"], &model("", ""));
    bench.write("study.toml", STUDY);
    let part = ["verify", "study.toml", "--output", "part", "--shard", "1/1"];
    assert_eq!(bench.run(&part).code, 0);
    for command in [&["verify", "study.toml", "--output", "out"][..], &["merge", "part", "--output", "out"]] {
        let mut first = in_its_finale(&bench, command, "out");
        let marks = hidden(&bench, "out");
        bench.run(command).is_mistake(&["another run is writing its results here"]);
        assert_eq!(hidden(&bench, "out"), marks, "{command:?}");
        signal(&first, "-CONT");
        assert_eq!(first.wait().unwrap().code(), Some(0));
        assert_eq!(hidden(&bench, "out"), Vec::<String>::new());
        // What a killed one leaves is in nobody's way, and goes with the next one.
        for name in ["-KILL", "-TERM"] {
            let mut first = in_its_finale(&bench, command, "out");
            signal(&first, name);
            signal(&first, "-CONT");
            first.wait().unwrap();
            assert_eq!(bench.run(&[command, &["--force"]].concat()).code, 0);
            assert_eq!(hidden(&bench, "out"), Vec::<String>::new());
        }
    }
}

#[test]
fn a_long_text_of_a_failure_costs_a_line() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["WORDY=1000000", "FAULT=FAIL"], &model("", ""));
    bench.write("study.toml", STUDY);
    assert_ne!(verify(&bench, "study.toml", &[]).code, 2);
    for file in ["journal.txt", "points.csv", "summary.json"] {
        let size = fs::metadata(bench.path(&format!("out/{file}"))).unwrap().len();
        assert!(size < 12_000, "{file}: {size}");
    }
    let points = bench.read("out/points.csv");
    let row = points.lines().nth(1).unwrap();
    for part in ["fmi2Error: begun xxx", " characters left out] xxx", "xxx (fmi2DoStep)"] {
        assert!(row.contains(part), "{row}");
    }
}
