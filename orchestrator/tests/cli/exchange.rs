//! Exchange of files with other tools: recordings of inputs, SSP parameter sets.

use crate::support::Bench;
use crate::typed;

const STUDY: &str = r#"
fmu = "../lag.fmu"
fixed-from = "start.ssv"
[simulation]
stop = 2
step = 0.01
[design]
points = 10
[inputs."drive.u"]
file = "drive.csv"
column = "n"
time = "t"
[parameters."lag.length"]
distribution = "normal"
mean = 0.02
deviation = 0.001
unit = "mm"
[criteria.Y]
variable = "lag.y"
at-most = 11
[criteria.T]
variable = "lag.temperature"
at-most = 120
unit = "degC"
"#;

const SET: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="start">
  <ssv:Parameters>
    <ssv:Parameter name="lag.rate"><ssv:Real value="2.5" unit="1/s"/></ssv:Parameter>
    <ssv:Parameter name="lag.length"><ssv:Real value="0.5" unit="mm"/></ssv:Parameter>
    <ssv:Parameter name="lag.count"><ssv:Integer value="3"/></ssv:Parameter>
    <ssv:Parameter name="lag.flag"><ssv:Boolean value="true"/></ssv:Parameter>
    <ssv:Parameter name="lag.text"><ssv:String value="a &amp; b"/></ssv:Parameter>
    <ssv:Parameter name="lag.fault"><ssv:Enumeration value="Warn"/></ssv:Parameter>
  </ssv:Parameters>
</ssv:ParameterSet>
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("studies")).unwrap();
    bench.write("studies/study.toml", STUDY);
    bench.write("studies/start.ssv", SET);
    bench.write("studies/drive.csv", "t,n\n0,0\n1,4\n1,-1\n2,-1\n");
    bench
}

/// The lag's answer to the recording, with the input held over every step.
fn expected(rate: f64) -> f64 {
    let mut y = 0.0;
    for k in 0..200 {
        let u = if k < 100 { 0.04 * f64::from(k) } else { -1.0 };
        y += (u - y) * (1.0 - (-rate * 0.01_f64).exp());
    }
    y
}

#[test]
fn inputs_follow_a_recording() {
    let bench = bench();
    let verify = ["verify", "studies/study.toml", "--output", "out"];
    let said = bench.run(&verify);
    assert_eq!(said.code, 0, "{}", said.err);
    let table = bench.read("out/points.csv");
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    for row in rows.records().map(Result::unwrap) {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let y = expected(2.5);
        assert!((number(2) - y).abs() < 1e-12, "{} {y}", number(2));
        // Count and flag come from the parameter set.
        assert!((number(3) - (10.0 * y * 3.0 + 5.0)).abs() < 1e-9);
    }
    // A point runs again wherever the results are, and the recording belongs to the study.
    let replay = bench.run(&["replay", "out", "3"]);
    assert_eq!(replay.code, 0, "{}", replay.err);
    bench.write("studies/drive.csv", "t,n\n0,1\n2,1\n");
    bench.run(&["replay", "out", "3"]).is_mistake(&["another study"]);
    bench.run(&[&verify[..], &["--resume"]].concat()).is_mistake(&["another study"]);
}

#[test]
fn a_recording_that_does_not_cover_its_run_is_refused() {
    let bench = bench();
    let write = |study: &str| bench.write("studies/study.toml", study);
    let run = || bench.run(&["verify", "studies/study.toml", "--output", "out"]);
    bench.write("studies/drive.csv", "t,n\n0,0\n0.05,1\n");
    run().is_mistake(&[
        "study.toml:9:9: drive.u: studies/drive.csv: the recording covers 0 s .. 0.05 s, the run goes from 0 s to 2 s",
        "so 0.05 s .. 2 s is missing",
        "set stop = 0.05",
        "extrapolate = \"hold\" in [inputs.\"drive.u\"]",
    ]);
    write(&STUDY.replace("time = \"t\"", "time = \"t\"\nextrapolate = \"hold\""));
    let said = run();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    write(&STUDY.replace("time = \"t\"", "time = \"t\"\nextrapolate = \"line\""));
    run().is_mistake(&["study.toml:13:15", "hold"]);
    // A case has a run of its own.
    let case = "[[cases]]\nname = \"long\"\nsimulation = { stop = 3 }\n";
    bench.write("studies/drive.csv", "t,n\n0,0\n2,4\n");
    write(&(STUDY.to_owned() + case));
    run().is_mistake(&["drive.csv", "covers 0 s .. 2 s, the run goes from 0 s to 3 s"]);
    // Nothing in common: milliseconds, perhaps.
    bench.write("studies/drive.csv", "t,n\n500,0\n2500,4\n");
    write(STUDY);
    run().is_mistake(&["covers 500 s .. 2500 s", "correct its times, which are in s"]);
}

#[test]
fn a_step_beyond_the_run_is_refused() {
    let bench = bench();
    bench.write("studies/study.toml", &STUDY.replace("step = 0.01", "step = 3"));
    bench
        .run(&["verify", "studies/study.toml", "--output", "out"])
        .is_mistake(&["[simulation] the step 3.0 s is longer than the run from 0.0 s to 2.0 s"]);
}

#[test]
fn the_dry_run_shows_the_units_of_bare_numbers() {
    let bench = bench();
    let fixed = "[fixed]\n\"lag.rate\" = 2\n\"lag.length\" = 0.02\n[parameters.\"lag.count\"]\ndistribution = \"uniform\"\n\
        min = 1\nmax = 2\n[criteria.Y]";
    let study = STUDY.split("[parameters").next().unwrap().to_owned();
    let criteria = STUDY.split("[criteria.Y]").nth(1).unwrap();
    bench.write("studies/study.toml", &format!("{study}{fixed}{criteria}"));
    let said = bench.run(&["verify", "studies/study.toml", "--dry-run"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("  lag.length = 0.02 m; its display unit is mm"), "{}", said.out);
    assert!(!said.out.contains("lag.rate ="), "{}", said.out);
    assert!(said.out.contains("  drive.u -1.00000 .. 4.00000 (recorded)"), "{}", said.out);
}

/// With the slopes, the lag follows the recording exactly, whatever the step: also where the jump lies within one.
#[test]
fn an_input_ramps_within_a_step() {
    let bench = bench();
    // y' = (u - y) r: along u = 4 t to t = 1, then towards -1.
    let r: f64 = 2.5;
    let gone = (-r).exp();
    let middle = 4.0 * (1.0 - (1.0 - gone) / r);
    let expected = -1.0 + (middle + 1.0) * gone;
    for step in ["0.25", "0.01", "0.3", "2"] {
        let step_line = format!("step = {step}");
        bench.write("studies/study.toml", &ramping().replace("step = 0.01", &step_line));
        let said = bench.run(&["verify", "studies/study.toml", "--output", step]);
        assert_eq!(said.code, 0, "{}", said.err);
        let table = bench.read(&format!("{step}/points.csv"));
        let mut rows = csv::Reader::from_reader(table.as_bytes());
        for row in rows.records().map(Result::unwrap) {
            let y: f64 = row[2].parse().unwrap();
            assert!((y - expected).abs() < 1e-12, "{step}: {y} {expected}");
        }
    }
}

/// A value that is held changes when it was recorded, also within a step, and in windows.
#[test]
fn held_values_change_at_their_rows() {
    let bench = bench();
    bench.write("studies/drive.csv", "t,n\n0,4\n0.7,-1\n1.0001,2\n");
    let held = STUDY.replace("time = \"t\"", "time = \"t\"\nhold = true\nextrapolate = \"hold\"");
    // The last row counts as at 1 s: it lies within a thousandth of the step.
    let r: f64 = 2.5;
    let towards = |y: f64, u: f64, time: f64| u + (y - u) * (-r * time).exp();
    let expected = towards(towards(towards(0.0, 4.0, 0.7), -1.0, 0.3), 2.0, 1.0);
    for (step, window) in [("0.5", ""), ("1", ""), ("0.5", "\nwindow = { from = \"1 s\" }")] {
        let study = held
            .replace("step = 0.01", &format!("step = {step}"))
            .replace("unit = \"degC\"", &format!("unit = \"degC\"{window}"));
        bench.write("studies/study.toml", &study);
        let folder = format!("{step}{}", window.len());
        let said = bench.run(&["verify", "studies/study.toml", "--output", &folder]);
        assert_eq!(said.code, 0, "{}", said.err);
        let table = bench.read(&format!("{folder}/points.csv"));
        let mut rows = csv::Reader::from_reader(table.as_bytes());
        for row in rows.records().map(Result::unwrap) {
            let y: f64 = row[2].parse().unwrap();
            assert!((y - expected).abs() < 1e-12, "{folder}: {y} {expected}");
        }
    }
}

/// Rows that an FMU of fixed steps cannot follow are told, with their size.
#[test]
fn rows_that_an_fmu_cannot_follow_are_told() {
    let bench = bench();
    bench.write("studies/drive.csv", "t,n\n0,0\n0.5,4\n0.7,9\n0.75,1\n1,4\n2,-1\n");
    let study = ramping().replace("step = 0.01", "step = 0.5");
    bench.write("studies/study.toml", &study);
    let any = " canHandleVariableCommunicationStepSize=\"true\"";
    let concerns = |folder: &str| {
        let said = bench.run(&["verify", "studies/study.toml", "--output", folder, "--verbose"]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(!said.out.contains("another input") || folder == "fixed", "{}", said.out);
        bench.summary(folder)["concerns"].to_string()
    };
    assert!(!concerns("any").contains("another input"));
    bench.fmu("lag.fmu", &[], &crate::support::model(any, ""));
    let told = concerns("fixed");
    assert!(told.contains("drive.u: the FMU gets another input than the recorded one at 2 rows"), "{told}");
    assert!(told.contains("by up to 5 (at 0.7 s)"), "{told}");
}

/// Where a recording is finer than the steps by far, the run tells what that costs.
#[test]
fn many_rows_between_communication_points_are_told() {
    let bench = bench();
    let rows: String = (0..2000).map(|k| format!("{},{}\n", 1e-3 * f64::from(k), k % 7)).collect();
    bench.write("studies/drive.csv", &format!("t,n\n{rows}"));
    bench.write("studies/study.toml", &ramping().replace("step = 0.01", "step = 0.5"));
    let said = bench.run(&["verify", "studies/study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let told = bench.summary("out")["concerns"].to_string();
    assert!(told.contains("2000 steps rather than 4"), "{told}");
}

#[test]
fn only_an_fmu_that_interpolates_can_ramp() {
    let bench = bench();
    let verify = ["verify", "studies/study.toml", "--output", "out"];
    bench.write("studies/study.toml", &ramping().replace("ramp = true", "ramp = true\nhold = true"));
    bench.run(&verify).is_mistake(&["study.toml:", "drive.u: ramp = true, but hold"]);
    bench.write("studies/study.toml", &ramping());
    bench.fmu("lag.fmu", &[], &crate::support::model(" canInterpolateInputs=\"true\"", ""));
    bench.run(&verify).is_mistake(&["canInterpolateInputs", "remove ramp"]);
}

fn ramping() -> String {
    STUDY.replace("time = \"t\"", "time = \"t\"\nramp = true")
}

#[test]
fn the_best_point_is_a_parameter_set() {
    let bench = bench();
    assert_eq!(bench.run(&["verify", "studies/study.toml", "--output", "out"]).code, 0);
    let summary = bench.summary("out");
    let set = bench.read("out/best.ssv");
    let set: String = set.lines().map(str::trim).collect();
    for part in [
        "name=\"lag.rate\"><ssv:Real value=\"2.5e0\" unit=\"1/s\"/>",
        "value=\"Warn\"",
        "\"a &amp; b\"",
        "<ssc:BaseUnit m=\"1\"/>",
    ] {
        assert!(set.contains(part), "no {part} in {set}");
    }
    // Another program may use it; ours gets the same point from it.
    let said = bench.run(&[
        "simulate",
        "lag.fmu",
        "--set-from",
        "out/best.ssv",
        "--set",
        "lag.count=1",
        "--output",
        "run.csv",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    let length = summary["best_point"]["parameters"]["lag.length"].as_f64().unwrap();
    let shown = said.out.lines().find_map(|line| line.strip_prefix("lag.micrometres = ")).unwrap();
    assert!((shown.trim().parse::<f64>().unwrap() - 1e3 * length).abs() < 1e-9);
}

#[test]
fn points_come_in_as_parquet() {
    let bench = bench();
    let verify = |more: &[&str]| bench.run(&[&["verify", "studies/study.toml"], more].concat());
    assert_eq!(verify(&["--output", "out"]).code, 0);
    typed::convert(&bench.path("out/points.csv"), &bench.path("points.parquet"));
    let said = verify(&["--output", "again", "--points-from", "points.parquet"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(bench.read("again/points.csv"), bench.read("out/points.csv"));
    let judged = |table: &str| bench.run(&["judge", "studies/study.toml", table]).out;
    assert_eq!(judged("points.parquet"), judged("out/points.csv"));
    let bytes = std::fs::read(bench.path("points.parquet")).unwrap();
    std::fs::write(bench.path("cut.parquet"), &bytes[..bytes.len() / 2]).unwrap();
    verify(&["--output", "cut", "--points-from", "cut.parquet"]).is_mistake(&["cut.parquet"]);
    bench.run(&["judge", "studies/study.toml", "none.parquet"]).is_mistake(&["none.parquet"]);
}

#[test]
fn mistakes_in_files_of_others() {
    let bench = bench();
    let verify = || bench.run(&["verify", "studies/study.toml", "--output", "out"]);
    let set = |from: &str, to: &str| {
        bench.write("studies/start.ssv", &SET.replace(from, to));
        verify()
    };
    set("lag.rate", "lag.rato").is_mistake(&["study.toml:3:14", "start.ssv:4", "did you mean `lag.rate`?"]);
    set("1/s", "mm").is_mistake(&["start.ssv:4", "`mm`"]);
    set("\"3\"", "\"x\"").is_mistake(&["start.ssv:6", "whole number"]);
    set("</ssv:Parameters>", "").is_mistake(&["start.ssv"]);
    bench.write("studies/start.ssv", SET);
    let drive = |text: &str| {
        bench.write("studies/drive.csv", text);
        verify()
    };
    drive("t,m\n0,1\n").is_mistake(&["study.toml:10:8", "drive.csv", "no column `n`"]);
    drive("t,n\n0,1\n2,1\n1,1\n").is_mistake(&["study.toml:9:9", "t = 1", "not later"]);
    drive("t,n\n0,inf\n").is_mistake(&["drive.u", "not a finite number"]);
    drive("t,n\n0,1\n");
    bench.write("studies/study.toml", &STUDY.replace("stop = 2", "stop = 2\nwindow = 1\nleap = true"));
    verify().is_mistake(&["drive.u", "leap"]);
    bench.run(&["simulate", "lag.fmu", "--set-from", "none.ssv"]).is_mistake(&["none.ssv"]);
}
