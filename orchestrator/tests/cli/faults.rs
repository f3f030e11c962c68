//! Whatever an FMU does, only its points are lost.

use crate::support::Bench;

/// Points of which number 5 has the given fault; the rate tells the points apart.
fn verify(bench: &Bench, fmu: &str, fault: u32, options: &[&str]) -> crate::support::Said {
    let study = format!(
        r#"
fmu = "{fmu}"
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 2
column = "rate"
[parameters."lag.fault"]
distribution = "uniform"
min = 0
max = 12
column = "fault"
[criteria.Y]
variable = "lag.y"
nominal = 0.8
tolerance = 0.1
[criteria.mean]
variable = "lag.y"
statistic = "mean"
at-most = 10.5
"#
    );
    bench.write("study.toml", &study);
    let mut table = String::from("point,rate,fault\n");
    for point in 1..=20 {
        let fault = if point == 5 { fault } else { 0 };
        table += &format!("{point},{},{fault}\n", 0.5 + 0.07 * f64::from(point));
    }
    bench.write("points.csv", &table);
    let command = ["verify", "study.toml", "--points-from", "points.csv", "--verbose", "--output", "out"];
    bench.run(&[&command, options].concat())
}

/// The status of point 5, after checking that all others are right.
fn status(bench: &Bench, said: &crate::support::Said) -> String {
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let table = bench.read("out/points.csv");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let mut status = String::new();
    let number = |cell: &str| cell.parse::<f64>().unwrap_or(f64::NAN);
    for (row, point) in rows.records().map(Result::unwrap).zip(1..) {
        if point == 5 {
            status = row[row.len() - 1].to_owned();
            continue;
        }
        assert_eq!(&row[row.len() - 1], "ok", "point {point}");
        let (rate, y) = (number(&row[1]), number(&row[3]));
        let exact = 1.0 - (-2.0 * rate).exp();
        assert!((y - exact).abs() < 1e-9, "point {point}: {y} {exact}");
    }
    status
}

fn fault(number: u32, options: &[&str]) -> (String, serde_json::Value) {
    let bench = Bench::new();
    let said = verify(&bench, "lag.fmu", number, options);
    (status(&bench, &said), bench.summary("out"))
}

fn is_confined(number: u32, options: &[&str], class: &str, words: &str) {
    let (status, summary) = fault(number, options);
    assert!(status.starts_with(class) && status.contains(words), "{status}");
    assert_eq!(summary["failed"], 1);
    assert_eq!(summary["failures"][class], 1);
    assert_eq!(summary["points"], 20);
}

#[test]
fn a_crash() {
    is_confined(1, &[], "crashed", "SIGSEGV");
}

#[test]
fn an_abort_with_its_last_words() {
    is_confined(2, &[], "crashed", "SIGABRT: lag: assertion failed");
}

#[test]
fn an_endless_loop() {
    is_confined(3, &["--point-timeout", "1"], "timeout", "");
}

#[test]
fn a_small_leak_costs_nothing() {
    let (status, summary) = fault(4, &["--memory-limit", "60MB", "--jobs", "1"]);
    assert_eq!(status, "ok");
    assert_eq!(summary["failed"], 0);
}

#[test]
fn exit_is_called() {
    is_confined(5, &[], "exited", "code 3");
}

#[test]
fn an_error_with_its_message() {
    is_confined(6, &[], "fmi2Error", "the spring broke (fmi2DoStep)");
    is_confined(6, &["--isolation", "none"], "fmi2Error", "the spring broke (fmi2DoStep)");
}

#[test]
fn a_step_is_refused() {
    is_confined(7, &[], "fmi2Discard", "fmi2DoStep");
}

#[test]
fn a_fatal_error() {
    is_confined(8, &[], "fmi2Fatal", "beyond repair");
}

#[test]
fn not_a_number() {
    is_confined(9, &[], "not finite", "lag.y");
}

#[test]
fn a_flood_of_messages() {
    let (status, summary) = fault(10, &[]);
    assert_eq!(status, "ok");
    assert_eq!(summary["failed"], 0);
}

#[test]
fn too_much_memory() {
    is_confined(11, &["--memory-limit", "300MB"], "out of memory", "");
}

#[test]
fn a_warning_is_no_failure() {
    assert_eq!(fault(12, &[]).0, "ok");
}

#[test]
fn warnings_before_a_failure_are_counted() {
    const FAIL: u32 = 6;
    let bench = Bench::empty();
    bench.fmu("warning.fmu", &["WARNS"], &crate::support::model("", ""));
    for isolation in ["fresh", "shared"] {
        let said = verify(&bench, "warning.fmu", FAIL, &["--isolation", isolation]);
        assert!(status(&bench, &said).starts_with("fmi2Error"));
        let warnings = &bench.summary("out")["warnings"];
        assert_eq!((&warnings["points"], &warnings["first"]["point"]), (&1.into(), &5.into()));
        // Once a step, up to the one that failed.
        assert!(warnings["count"].as_u64().unwrap() > 1, "{warnings}");
        assert!(said.out.contains("the oil is warm"), "{}", said.out);
    }
}

#[test]
fn an_fmu_without_reset() {
    let bench = Bench::empty();
    bench.fmu("plain.fmu", &["NO_RESET"], &crate::support::model("", ""));
    let said = verify(&bench, "plain.fmu", 0, &[]);
    assert_eq!(status(&bench, &said), "ok");
}

#[test]
fn an_fmu_that_is_not_thread_safe() {
    let bench = Bench::empty();
    bench.fmu("global.fmu", &["GLOBAL"], &crate::support::model("", ""));
    let said = verify(&bench, "global.fmu", 0, &["--jobs", "4"]);
    assert_eq!(status(&bench, &said), "ok");
}

#[test]
fn all_kinds_at_once() {
    let bench = Bench::new();
    verify(&bench, "lag.fmu", 0, &[]);
    let mut table = String::from("point,rate,fault\n");
    for point in 0..120 {
        let fault = if point % 10 == 3 { point / 10 + 1 } else { 0 };
        table += &format!("{point},1,{fault}\n");
    }
    bench.write("points.csv", &table);
    let limits = ["--point-timeout", "2", "--memory-limit", "300MB", "--jobs", "3"];
    let command = ["verify", "study.toml", "--points-from", "points.csv", "--output", "all"];
    let said = bench.run(&[&command[..], &limits].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    let summary = bench.summary("all");
    // Leak, flood and warning do no harm.
    assert_eq!((&summary["points"], &summary["failed"]), (&120.into(), &9.into()), "{}", said.out);
    assert!(summary["concerns"].to_string().contains("out of time need a longer `--point-timeout`"), "{summary}");
}

#[test]
fn single_simulations_fail_with_one_line() {
    let bench = Bench::new();
    let crash = bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Crash"]);
    crash.is_mistake(&["the simulation failed: crashed: SIGSEGV"]);
    assert!(crash.out.starts_with("time,lag.y"), "{}", crash.out);
    let exit = bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Exit", "--output", "run.csv"]);
    exit.is_mistake(&["the simulation failed: exited", "code 3"]);
    let error = bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Fail"]);
    error.is_mistake(&["the simulation failed: fmi2Error: the spring broke"]);
}

#[test]
fn what_the_fmu_prints_is_shown_and_kept_out_of_the_table() {
    let bench = Bench::new();
    let said = bench.run(&["simulate", "lag.fmu", "--set", "lag.fault=Chatter"]);
    assert_eq!(said.code, 0);
    assert!(said.err.contains("line 19999 of a flood on stdout"));
    assert!(said.err.contains("line 19999 of a flood on stderr"));
    assert_eq!(said.out.lines().count(), 202);
}

#[test]
fn a_crash_is_replayed_without_crashing() {
    let bench = Bench::new();
    verify(&bench, "lag.fmu", 1, &[]);
    let said = bench.run(&["replay", "out", "5"]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.out.contains("failed: crashed: SIGSEGV") && !said.out.contains("warning"), "{}", said.out);
    assert!(bench.read("out/point-5.csv").starts_with("time,"));
}

#[test]
fn a_crash_of_the_best_points_trajectory_takes_nothing_away() {
    let bench = Bench::empty();
    bench.fmu("coarse.fmu", &["COARSE"], &crate::support::model("", ""));
    let said = verify(&bench, "coarse.fmu", 0, &[]);
    assert_eq!(status(&bench, &said), "ok");
    assert_eq!(said.err, "");
    let left_out =
        "left out: best-point.csv holds the study's own steps: the FMU fails in finer ones: crashed: SIGSEGV";
    let told = said.out.lines().filter(|line| line.contains(left_out));
    assert_eq!(told.count(), 1, "{}", said.out);
    assert_eq!(bench.summary("out")["failed"], 0);
    assert!(bench.path("out/report.html").exists());
    assert_eq!(bench.read("out/best-point.csv").lines().count(), 1 + 201);
}

/// A study of which a part of the points crashes.
const PARTLY_DEADLY: &str = r#"
fmu = "lag.fmu"
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 2
[parameters."lag.fault"]
distribution = "uniform"
min = 0
max = 1.4
[criteria.Y]
variable = "lag.y"
nominal = 0.8
tolerance = 0.1
[criteria.mean]
variable = "lag.y"
statistic = "mean"
nominal = 0.5
tolerance = 1
"#;

#[test]
fn analyses_survive_crashes_too() {
    let bench = Bench::new();
    bench.write("study.toml", PARTLY_DEADLY);
    let sobol = ["sensitivity", "study.toml", "--base", "16", "--output", "s"];
    let said = bench.run(&sobol);
    assert_eq!(said.code, 0, "{}", said.err);
    let runs = bench.read("s/sensitivity-runs.csv");
    let crashed = runs.lines().filter(|line| line.ends_with("crashed: SIGSEGV")).count();
    assert!(crashed > 8 && crashed < 56, "{runs}");
}

#[test]
fn an_identification_says_that_the_model_crashes() {
    let bench = Bench::new();
    let study = r#"
fmu = "lag.fmu"
[fixed]
"lag.fault" = 1
[identify.free."lag.rate"]
min = 0.5
max = 2
[identify.measured.Y]
variable = "lag.y"
value = 0.8
accuracy = 0.01
"#;
    bench.write("study.toml", study);
    let said = bench.run(&["identify", "study.toml", "--output", "i"]);
    assert_eq!(said.code, 2, "{}{}", said.out, said.err);
    assert!(said.err.contains("SIGSEGV"), "{}", said.err);
}
