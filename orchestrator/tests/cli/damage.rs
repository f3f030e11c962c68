//! A point that ends badly spoils no other one, and what ends plainly but spoils others is found as often as it is said.

use std::fmt::Write as _;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::durability::{is_of_point, killed};
use crate::isolation::STUDY;
use crate::support::{Bench, Said, model};

/// The traces that a point leaves, by the numbers of `damage.c`.
const WHAT: [&str; 37] = [
    "nothing",
    "static memory",
    "a table",
    "a function",
    "heap",
    "freed memory",
    "shared memory",
    "memory of the thread",
    "environment",
    "time zone",
    "a thread",
    "a slow thread",
    "a thread that goes on",
    "a process",
    "a signal handler",
    "a timer",
    "an ignored signal",
    "a blocked signal",
    "a descriptor",
    "a closed descriptor",
    "a file's offset",
    "a file",
    "the working directory",
    "the locale",
    "the rounding mode",
    "a limit",
    "the mask of modes",
    "a function at exit",
    "random numbers",
    "a lock",
    "a mapping",
    "the thread's name",
    "the priority",
    "the signal stack",
    "the allocator",
    "an alarm",
    "a folder of the library",
];

/// How it ends, likewise.
const HOW: [&str; 6] =
    ["plainly", "with a warning", "with discard", "with an error", "with NaN", "with a logged error"];
const PLAINLY: usize = 0;

/// The trace that the library makes when it is loaded, in a fixture of its own.
const IN_MADE: usize = 36;

/// Traces that are seen however the point ends. A thread is not, where it has ended before anyone looks.
const SEEN: [&str; 4] = ["a thread that goes on", "a process", "a signal handler", "a timer"];

/// The trace that is seen by looking at signals.
const SIGNALS: &str = "an ignored signal";

/// The outcome of a study of which one point in `every` spoils what it leaves.
#[derive(Debug, PartialEq)]
struct Outcome {
    /// Healthy points with wrong results.
    wrong: usize,
    /// All points.
    points: usize,
    isolation: String,
    mismatches: u64,
    audits: u64,
    reproducible: serde_json::Value,
}

fn study(bench: &Bench, what: usize, how: usize, every: usize, points: usize) -> Outcome {
    let study = format!(
        r#"
fmu = "damage.fmu"
[fixed]
what = {what}
how = {how}
[parameters.rate]
distribution = "uniform"
min = 1
max = 2
[parameters.now]
distribution = "uniform"
min = 0
max = 1
[criteria.y]
variable = "y"
nominal = 1.5
tolerance = 1
"#
    );
    bench.write("study.toml", &study);
    let mut table = String::from("point,rate,now\n");
    let rate = |point: usize| 1.0 + point as f64 / 4096.0;
    for point in 0..points {
        let now = usize::from(point % every == every / 2);
        writeln!(table, "{point},{},{now}", rate(point)).unwrap();
    }
    bench.write("points-in.csv", &table);
    let said = bench.run(&[
        "verify",
        "study.toml",
        "--points-from",
        "points-in.csv",
        "--output",
        "out",
        "--jobs",
        "2",
        "--extra-runs",
        "0",
        // A lock that is never given back costs a point this long.
        "--point-timeout",
        "5",
    ]);
    assert!(said.code < 2, "{}{}", said.out, said.err);
    let table = bench.read("out/points.csv");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let mut wrong = 0;
    for (row, point) in rows.records().map(Result::unwrap).zip(0..) {
        if &row[row.len() - 1] == "ok" {
            let y: f64 = row[3].parse().unwrap();
            wrong += usize::from(y.to_bits() != rate(point).to_bits());
        }
    }
    let summary = bench.summary("out");
    fs::remove_dir_all(bench.path("out")).unwrap();
    Outcome {
        wrong,
        points,
        isolation: summary["isolation"].as_str().unwrap().to_owned(),
        mismatches: summary["audit_mismatches"].as_u64().unwrap(),
        audits: summary["audits_of_shared"].as_u64().unwrap(),
        reproducible: summary["reproducible"].clone(),
    }
}

fn number(names: &[&str], name: &str) -> usize {
    names.iter().position(|own| *own == name).unwrap()
}

#[test]
fn a_point_that_does_not_end_plainly_spoils_no_other() {
    let bench = Bench::empty();
    bench.damage(&[]);
    for (what, how) in [
        ("static memory", "with an error"),
        ("heap", "with a warning"),
        ("a table", "with NaN"),
        ("the working directory", "with discard"),
        ("environment", "with a logged error"),
    ] {
        let found = study(&bench, number(&WHAT, what), number(&HOW, how), 400, 2400);
        let shared = (found.wrong, &*found.isolation, found.mismatches);
        assert_eq!(shared, (0, "audited", 0), "{what}, {how}: {found:?}");
        assert_eq!(found.reproducible, true);
    }
}

/// Forks of a process that has loaded the library share what it made then.
#[test]
fn behind_an_odd_point_the_library_is_loaded_anew() {
    let bench = Bench::empty();
    let place = bench.path("made-XXXXXX");
    bench.damage(&[&format!("MADE={:?}", place.to_str().unwrap())]);
    // So many odd ones leave nothing but forks.
    let found = study(&bench, IN_MADE, number(&HOW, "with an error"), 6, 600);
    assert_eq!((found.wrong, found.mismatches), (0, 0), "{found:?}");
    assert_eq!(found.reproducible, true);
}

#[test]
fn what_still_runs_or_handles_signals_is_followed_by_a_fresh_process() {
    let bench = Bench::empty();
    bench.damage(&[]);
    for what in ["a thread that goes on", "a process", "a timer"] {
        let found = study(&bench, number(&WHAT, what), PLAINLY, 400, 2400);
        let shared = (found.wrong, &*found.isolation, found.mismatches);
        assert_eq!(shared, (0, "audited", 0), "{what}: {found:?}");
    }
}

#[test]
fn points_that_always_warn_run_alone_and_the_files_say_why() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["FAULT=WARN"], &model("", ""));
    bench.write("study.toml", &STUDY.replace("1000", "700"));
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--verbose"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let summary = bench.summary("out");
    assert_eq!(summary["isolation"], "fresh");
    assert_eq!(summary["isolation_reason"], "complaints");
    assert!(said.out.contains("many points ended with a warning"), "{}", said.out);
    assert!(bench.read("out/report.html").contains("any points ended with a warning"));
}

/// All behaviours: prints a table.
#[test]
#[ignore = "takes minutes"]
fn all_behaviours() {
    let bench = Bench::empty();
    bench.damage(&[]);
    let (mut plain, mut found, mut expected) = (0, 0, 0.0);
    let mut spoilt = Vec::new();
    for every in [10, 50, 500] {
        let points = 2000.max(6 * every);
        for (what, name) in WHAT.iter().enumerate().take(IN_MADE).skip(1) {
            for (how, end) in HOW.iter().enumerate() {
                let outcome = study(&bench, what, how, every, points);
                println!("{name}, {end}, one in {every}: {outcome:?}");
                if how != PLAINLY || SEEN.contains(name) || *name == SIGNALS {
                    if outcome.wrong > 0 {
                        spoilt.push(format!("{name}, {end}, one in {every}: {outcome:?}"));
                    }
                } else if outcome.wrong > 0 || outcome.mismatches > 0 {
                    plain += 1;
                    found += usize::from(outcome.mismatches > 0);
                    if outcome.mismatches == 0 {
                        let share = outcome.wrong as f64 / points as f64;
                        expected += (1.0 - share).powf(outcome.audits as f64);
                    }
                }
            }
        }
    }
    println!("of {plain} that ended plainly {found} were found by audits; {expected:.2} chance of the others");
    assert!(spoilt.is_empty(), "{}", spoilt.join("\n"));
}

/// A stall while reuse is tried must not cost the whole study: a trivial FMU runs in few processes whatever the clock says.
#[test]
fn a_stall_of_the_clock_does_not_decide_how_processes_are_shared() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["STALLS"], &model("", ""));
    bench.write("study.toml", &STUDY.replace("1000", "3000"));
    for jobs in ["1", "2", "16"] {
        let count = bench.path("instances");
        let mut command = bench.command(&["verify", "study.toml", "--verbose", "--output", jobs, "--jobs", jobs]);
        let output = command.env("LAG_INSTANCES", &count).output().unwrap();
        assert!(output.status.success());
        let instances = fs::read(&count).unwrap().len();
        fs::remove_file(&count).unwrap();
        // How many audits there are besides depends on how quick the machine is; each point alone would be 3000 instances.
        assert!(instances < 3000, "{jobs} workers: {instances} instances");
        assert_eq!(bench.summary(jobs)["isolation"], "audited");
    }
}

/// A worker that ignores SIGCHLD, since it has loaded an FMU that does, never learns how its children end.
#[test]
fn an_fmu_that_ignores_its_children_has_no_say_in_its_worker() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["IGNORES_CHILDREN"], &model("", ""));
    bench.write("study.toml", &STUDY.replace("1000", "8"));
    let mut command =
        bench.command(&["verify", "study.toml", "--output", "out", "--jobs", "1", "--point-timeout", "2"]);
    let said: Said = command.env("LAG_LOADS", bench.path("ignores")).output().unwrap().into();
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!bench.path("ignores").exists());
}

/// While a worker loads the FMU it looks at nothing, and ends with its supervisor all the same.
#[test]
fn a_worker_ends_with_its_supervisor_while_it_loads() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["SLEEPS_WHEN_LOADED"], &model("", ""));
    bench.write("study.toml", STUDY);
    let mut command = bench.command(&["verify", "study.toml", "--output", "out", "--jobs", "1"]);
    command.env("LAG_LOADS", bench.path("loads")).stdout(Stdio::null()).stderr(Stdio::null());
    let mut run = command.spawn().unwrap();
    let pid = loop {
        assert!(run.try_wait().unwrap().is_none());
        let pid = fs::read_to_string(bench.path("loads.pid")).unwrap_or_default();
        if let Some(pid) = pid.strip_suffix('\n') {
            break pid.to_owned();
        }
        sleep(Duration::from_millis(5));
    };
    run.kill().unwrap();
    run.wait().unwrap();
    // It would sleep for a minute.
    let begun = Instant::now();
    let runs = || fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| !stat.contains(") Z"));
    while runs() && begun.elapsed() < Duration::from_secs(20) {
        sleep(Duration::from_millis(5));
    }
    assert!(!runs());
}

#[test]
fn a_licence_is_waited_for_once_and_told() {
    let refused = |says: &str| {
        let bench = Bench::empty();
        bench.fmu("lag.fmu", &[&format!("SAYS=\"{says}\"")], &model("", ""));
        bench.write("study.toml", &STUDY.replace("1000", "6"));
        let said = bench.run(&["verify", "study.toml", "--output", "out", "--point-timeout", "1"]);
        assert_eq!(bench.summary("out")["failed"], 6, "{}", said.err);
        ["waiting for one, up to 1s", "no licence came within 1s"].map(|words| said.err.matches(words).count())
    };
    assert_eq!(refused("no licence is free"), [1, 1]);
    assert_eq!(refused("lag 1.2, MIT License"), [0, 0]);
}

/// Two points at a time want the same port.
#[test]
fn points_that_fail_because_of_others_are_repeated_alone() {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["PORT", "SLOW", "SLOW_START"], &model("", ""));
    bench.write("study.toml", &STUDY.replace("1000", "24"));
    for jobs in ["1", "2"] {
        let mut command = bench.command(&["verify", "study.toml", "--verbose", "--output", jobs, "--jobs", jobs]);
        let port = bench.path("port");
        let said: Said = command.env("LAG_PORT", port).output().unwrap().into();
        assert_eq!(said.code, 0, "{}", said.err);
        let summary = bench.summary(jobs);
        assert_eq!((&summary["failed"], &summary["reproducible"]), (&0.into(), &true.into()), "{}", said.out);
        let told = said.out.contains("passed alone");
        assert_eq!(told, summary["passed_alone"].as_u64().unwrap_or(0) > 0, "{}", said.out);
    }
    assert_eq!(bench.read("1/points.csv"), bench.read("2/points.csv"));
}

/// A run that is killed while points are repeated alone leaves a beginning of its journal. Resumed, it repeats the others
/// and ends with the files of an undisturbed one, also where a verdict is waited for, and in an analysis.
#[test]
fn an_interrupted_repetition_alone_goes_on_as_if_nothing_had_been() {
    let study = STUDY.replace("points = 1000", "method = \"monte-carlo\"\npoints = 24");
    let study = format!("{study}[verdict]\nshare = \"50 %\"\n");
    let verify = ["verify", "study.toml", "--extra-runs", "0"];
    let until = [&verify[..], &["--until", "verdict", "--points", "24"]].concat();
    let analysis = ["sensitivity", "study.toml", "--base", "4"];
    for (command, state, files) in [
        (&verify[..], "", ["points.csv", "summary.json"]),
        (&until, "", ["points.csv", "summary.json"]),
        (&analysis, "/sensitivity", ["sensitivity.json", "sensitivity-runs.csv"]),
    ] {
        let bench = Bench::empty();
        bench.fmu("lag.fmu", &["PORT", "SLOW", "SLOW_START"], &model("", ""));
        bench.write("study.toml", &study);
        let run = |folder: &str, more: &[&str]| {
            let mut command = bench.command(&[command, &["--output", folder], more].concat());
            let port = bench.path("port");
            let said: Said = command.env("LAG_PORT", port).output().unwrap().into();
            assert!([0, 1, 3].contains(&said.code), "{}", said.err);
            let read = |name: &str| bench.read(&format!("{folder}/{name}"));
            let files = files.map(read);
            if files[1].starts_with('{') {
                let summary = bench.summary(folder);
                let told = ["failed", "verified", "repeated_alone", "passed_alone"];
                return [files[0].clone(), told.map(|key| format!("{key} {}; ", summary[key])).concat()];
            }
            files
        };
        let whole = run("whole", &["--jobs", "2"]);
        let journal = bench.read(&format!("whole{state}/journal.txt"));
        let lines: Vec<&str> = journal.lines().collect();
        let settled = lines.iter().position(|line| line.contains("\"Settled\""));
        let settled = settled.expect("two points at a time want the same port");
        let (_, repeated) = lines[settled].split_once("\"repeated\":").unwrap();
        let repeated = repeated.split(|c: char| !c.is_ascii_digit()).next().unwrap();
        let alone = (0..settled).rev().filter(|&k| is_of_point(lines[k]));
        let alone: Vec<usize> = alone.take(repeated.parse().unwrap()).collect();
        let first = alone.last().copied().unwrap();
        for end in [first, alone[alone.len() / 2], settled] {
            let into = format!("killed-{end}");
            killed(&bench, &format!("whole{state}"), &format!("{into}{state}"), |journal| {
                journal.truncate(end);
            });
            assert_eq!(run(&into, &["--jobs", "2", "--resume"]), whole, "{command:?} {end}");
        }
    }
}
