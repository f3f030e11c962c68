//! No point spoils another one, whatever it leaves in its process and however it ends.

use std::fmt::Write as _;
use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::isolation::STUDY;
use crate::support::{Bench, Said, model};

/// The traces that a point leaves, by the numbers of `damage.c`.
const WHAT: [&str; 36] = [
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
];

/// How it ends, likewise.
const HOW: [&str; 6] =
    ["plainly", "with a warning", "with discard", "with an error", "with NaN", "with a logged error"];

/// How many healthy points are wrong in a study of which one point in `every` leaves a trace.
fn wrong(bench: &Bench, what: usize, how: usize, every: usize, points: usize, jobs: &str) -> usize {
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
        jobs,
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
    assert_eq!(bench.summary("out")["isolation"], "fresh");
    fs::remove_dir_all(bench.path("out")).unwrap();
    wrong
}

fn number(names: &[&str], name: &str) -> usize {
    names.iter().position(|own| *own == name).unwrap()
}

#[test]
fn a_point_spoils_no_other() {
    let bench = Bench::empty();
    bench.damage();
    for (what, how) in [
        ("static memory", "plainly"),
        ("heap", "with a warning"),
        ("a table", "with NaN"),
        ("the working directory", "with discard"),
        ("environment", "with a logged error"),
        ("a thread that goes on", "plainly"),
        ("a process", "plainly"),
        ("a timer", "with an error"),
    ] {
        assert_eq!(wrong(&bench, number(&WHAT, what), number(&HOW, how), 10, 60, "2"), 0, "{what}, {how}");
    }
}

/// All behaviours: prints each as it is done, and how many healthy points are wrong.
#[test]
#[ignore = "takes minutes: cargo test --workspace --test cli all_behaviours -- --ignored --nocapture"]
fn all_behaviours() {
    let bench = Bench::empty();
    bench.damage();
    let mut spoilt = Vec::new();
    for (every, jobs) in [(10, "1"), (10, "2"), (50, "1"), (50, "2"), (500, "1"), (500, "2")] {
        let points = 100.max(2 * every);
        for (what, name) in WHAT.iter().enumerate().skip(1) {
            for (how, end) in HOW.iter().enumerate() {
                let wrong = wrong(&bench, what, how, every, points, jobs);
                println!("{name}, {end}, one in {every}, {jobs} jobs: {wrong} of {points} wrong");
                if wrong > 0 {
                    spoilt.push(*name);
                }
            }
        }
    }
    assert!(spoilt.is_empty(), "{spoilt:?}");
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
fn points_that_fail_because_of_others_run_again_alone() {
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
    }
    assert_eq!(bench.read("1/points.csv"), bench.read("2/points.csv"));
}
