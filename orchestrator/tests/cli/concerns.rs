//! Doubts about a verdict are told; criteria look at their own part of the run; tolerances are found.

use std::fmt::Write;

use crate::support::Bench;
use serde_json::Value;

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.01
[design]
points = 40
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.02
uncertainty = 0.01
"#;

fn verified(study: &str) -> (Bench, Value) {
    let bench = Bench::new().in_process();
    bench.write("study.toml", study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    let summary = bench.summary("out");
    (bench, summary)
}

fn concerns(summary: &Value) -> Vec<String> {
    let found = summary["concerns"].as_array().unwrap().iter();
    found.map(|concern| concern["text"].as_str().unwrap().to_owned()).collect()
}

/// 1 - exp(-2) is on its way to 1: at t = 2 it still moves by 2 exp(-2) = 0.27 in another two seconds.
#[test]
fn a_value_that_still_moves_is_warned_of() {
    let (bench, summary) = verified(STUDY);
    let found = concerns(&summary);
    assert!(found.iter().any(|c| c.starts_with("Y: its value still moves")), "{found:?}");
    assert!(bench.read("out/report.html").contains("its value still moves"));
    let later = STUDY.replace("stop = 2", "stop = 15").replace("0.86", "1");
    assert_eq!(concerns(&verified(&later).1), [""; 0]);
}

/// Euler's method on a lag: the error goes with the step.
#[test]
fn a_communication_step_that_is_too_coarse_is_warned_of() {
    let bench = Bench::empty();
    let description = crate::support::model("Lag", "Lag");
    bench.fmu("lag.fmu", &["EULER"], &description);
    bench.fmu("exact.fmu", &[], &description);
    let coarse = STUDY.replace("step = 0.01", "step = 0.25");
    let enough = coarse.replace("points = 40", "points = 50");
    let of = |name: &str, study: &str, options: &[&str]| {
        bench.write("study.toml", study);
        let arguments = [&["verify", "study.toml", "--output", name], options].concat();
        let said = bench.run(&arguments);
        assert!(said.code < 2, "{}", said.err);
        let found = concerns(&bench.summary(name));
        let found = found.into_iter().filter(|text| text.contains("communication step"));
        found.collect::<Vec<String>>()
    };
    let found = of("coarse", &enough, &[]);
    let said = "Y: the communication step of 0.25 s is too coarse: with half of it point ";
    assert!(found[0].starts_with(said), "{found:?}");
    assert!(found[0].ends_with(" (tolerance 0.02)"), "{found:?}");
    // Shards, other numbers of workers and a run that goes on tell the same.
    assert_eq!(of("jobs", &enough, &["--jobs", "1"]), found);
    for part in ["1/2", "2/2"] {
        let arguments = ["verify", "study.toml", "--shard", part, "--output"];
        bench.run(&[&arguments[..], &[&format!("part{}", &part[..1])]].concat());
    }
    bench.run(&["merge", "part1", "part2", "--output", "merged"]);
    assert_eq!(concerns(&bench.summary("merged"))[0], found[0]);
    assert_eq!(of("coarse", &enough, &["--resume"]), found);
    // A run is dear beside a few points, but not to who asks for it.
    assert_eq!(of("few", &coarse, &[]), [""; 0]);
    assert_eq!(of("validation", &coarse, &["--validation"]).len(), 1);
    assert_eq!(of("none", &enough, &["--extra-runs", "0"]), [""; 0]);
    // Where the step is short enough, or the FMU solves by itself, nothing is said.
    assert_eq!(of("fine", &enough.replace("step = 0.25", "step = 0.002"), &[]), [""; 0]);
    assert_eq!(of("exact", &enough.replace("lag.fmu", "exact.fmu"), &[]), [""; 0]);
}

#[test]
fn a_final_value_of_a_signal_that_swings_is_warned_of() {
    let study = STUDY.replace("stop = 2", "stop = 20").replace("mean = 1", "mean = 50")
        + "[inputs.\"drive.u\"]\nfile = \"u.csv\"\ncolumn = \"u\"\n";
    let mut table = String::from("time,u\n");
    for k in 0..=2000 {
        let t = f64::from(k) * 0.01;
        writeln!(table, "{t},{}", 0.86 + 0.01 * (8.0 * t).sin()).unwrap();
    }
    let run = |study: &str| {
        let bench = Bench::new().in_process();
        bench.write("study.toml", study);
        bench.write("u.csv", &table);
        let said = bench.run(&["verify", "study.toml", "--output", "out", "--verbose"]);
        assert!(said.code < 2, "{}", said.err);
        assert!(said.out.contains("swings") == concerns(&bench.summary("out")).iter().any(|c| c.contains("swings")));
        concerns(&bench.summary("out"))
    };
    assert!(run(&study).iter().any(|c| c.starts_with("Y: its signal swings by 0.0")));
    let mean = study.replace("nominal = 0.86", "nominal = 0.86\nstatistic = \"mean\"\nwindow = 5");
    assert!(run(&mean).iter().all(|c| !c.contains("swings")));
}

/// A study of the lag with another end, step and statistic, run with an FMU of its own: its summary and its page.
fn of_the_lag(macros: &[&str], changes: &[(&str, &str)]) -> (Bench, Value) {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", macros, &crate::support::model("Lag", "Lag"));
    let study = changes.iter().fold(STUDY.to_owned(), |study, (from, to)| {
        assert!(study.contains(from), "{from}");
        study.replace(from, to)
    });
    bench.write("study.toml", &study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    let summary = bench.summary("out");
    (bench, summary)
}

/// y = 1 + 0.5 sin(2 pi t) has the same value at every whole second.
#[test]
fn a_swing_is_seen_although_the_steps_are_multiples_of_its_period() {
    for (stop, step) in [("1000", "1"), ("1000", "0.5"), ("2000", "2"), ("50", "50")] {
        let changes =
            [("stop = 2", &*format!("stop = {stop}")), ("step = 0.01", &*format!("step = {step}")), ("0.86", "1")];
        let (bench, summary) = of_the_lag(&["SWING=0.5"], &changes);
        let seen = &summary["rest"]["criteria"]["Y"];
        let swing = seen["swing"].as_f64().unwrap();
        assert!((swing - 1.0).abs() < 0.05, "{stop} {step}: {seen}");
        assert_eq!(seen["drift"], 0.0);
        let found = concerns(&summary);
        assert!(found.iter().any(|c| c.starts_with("Y: its signal swings by")), "{found:?}");
        assert!(bench.read("out/report.html").contains("its signal swings by"));
        let rest = &summary["rest"];
        assert_eq!(rest["point"], summary["best_point"]["point"]);
        assert_eq!(rest["until"].as_f64().unwrap(), 2.0 * stop.parse::<f64>().unwrap());
    }
}

/// A run of 1.2 periods ends on its way, but does not go on.
#[test]
fn a_part_of_a_swing_is_called_no_drift() {
    for stop in ["1.2", "0.8", "2.3"] {
        let changes = [("stop = 2", &*format!("stop = {stop}")), ("mean = 1", "mean = 100")];
        let (_, summary) = of_the_lag(&["SWING=0.5"], &changes);
        let found = concerns(&summary);
        assert!(found.iter().any(|c| c.contains("swings by")), "{stop}: {found:?}");
        assert!(found.iter().all(|c| !c.contains("still moves")), "{stop}: {found:?}");
    }
}

/// 1 - exp(-t / 1000 s) moves by exp(-1) - exp(-2) from 1,000 to 2,000 s, in one long step or in many.
#[test]
fn a_slow_drift_is_measured_after_the_end() {
    let expected = (-1.0_f64).exp() - (-2.0_f64).exp();
    let common = [
        ("stop = 2", "stop = 1000"),
        ("mean = 1", "mean = 0.001"),
        ("deviation = 0.1", "deviation = 1e-9"),
        ("0.86", "0.63"),
    ];
    for (step, statistic) in [("1000", "final"), ("1", "final"), ("1", "mean"), ("1", "max")] {
        let (step, statistic) =
            (format!("step = {step}"), format!("variable = \"lag.y\"\nstatistic = \"{statistic}\""));
        let mut changes = common.to_vec();
        changes.push(("step = 0.01", &step));
        changes.push(("variable = \"lag.y\"", &statistic));
        let (_, summary) = of_the_lag(&[], &changes);
        let drift = summary["rest"]["criteria"]["Y"]["drift"].as_f64().unwrap();
        assert!((drift / expected - 1.0).abs() < 0.01, "{statistic}: {drift} {expected}");
        assert!(concerns(&summary).iter().any(|c| c.contains("still moves")));
    }
    let mut least = common.to_vec();
    least.push(("step = 0.01", "step = 1"));
    least.push(("variable = \"lag.y\"", "variable = \"lag.y\"\nstatistic = \"min\""));
    let (_, summary) = of_the_lag(&[], &least);
    assert_eq!(summary["rest"]["criteria"]["Y"]["drift"], 0.0);
}

/// An FMU that ends where the study ends is looked at up to there; one that takes no finer steps, or ends after so many, is not.
#[test]
fn what_the_fmu_does_not_allow_is_not_claimed() {
    let (_, summary) = of_the_lag(&["LIMITED=2"], &[]);
    assert_eq!(summary["rest"]["until"], 2.0);
    assert!(concerns(&summary).iter().any(|c| c.contains("still moves")));
    let coarse = [("stop = 2", "stop = 20"), ("step = 0.01", "step = 0.5")];
    let (_, summary) = of_the_lag(&["REFUSES"], &coarse);
    assert_eq!(summary["rest"]["until"], Value::Null);
    let found = concerns(&summary);
    assert!(
        found
            .iter()
            .any(|c| c.contains("the best point was not re-run longer and finer") && c.contains("the FMU fails")),
        "{found:?}"
    );
    let (bench, summary) = of_the_lag(&["ENDS=10"], &[("step = 0.01", "step = 0.4")]);
    let rest = &summary["rest"];
    assert!(rest["until"].is_null() && rest["criteria"].as_object().unwrap().is_empty(), "{rest}");
    let found = concerns(&summary);
    let told = |c: &String| c.contains("not known: with steps of 0.0008 s the FMU ends at 0.00");
    assert!(found.iter().any(told), "{found:?}");
    assert_eq!(bench.read("out/best-point.csv").lines().count(), 1 + 6, "the study's own steps");
    assert!(
        summary["left_out"].as_str().unwrap().contains("the FMU fails in finer ones: it ends at 0.0018 s"),
        "{summary}"
    );
}

/// With no extra runs the summary says that nothing was observed.
#[test]
fn extra_runs_are_as_many_as_asked_for() {
    let bench = Bench::new().in_process();
    bench.write("study.toml", STUDY);
    for runs in ["0", "3"] {
        let said = bench.run(&["verify", "study.toml", "--output", runs, "--extra-runs", runs]);
        assert!(said.code < 2, "{}", said.err);
        let summary = bench.summary(runs);
        assert_eq!(summary["rest"]["until"].is_null(), runs == "0");
        let told = "swing or had settled is not known: --extra-runs 0";
        let found = concerns(&summary).iter().any(|c| c.contains(told));
        assert_eq!(found, runs == "0");
    }
}

#[test]
fn a_measured_value_in_another_unit_and_a_distribution_outside_the_range_are_warned_of() {
    let study = STUDY.replace("nominal = 0.86", "nominal = 860").replace("tolerance = 0.02", "tolerance = 20");
    let found = concerns(&verified(&study).1);
    assert!(
        found[0].starts_with("Y: no point reaches the measured value 860") && found[0].contains("unit"),
        "{found:?}"
    );
    let study = STUDY.replace("mean = 1\ndeviation = 0.1", "mean = 1\ndeviation = 1");
    let found = concerns(&verified(&study).1);
    assert!(found.iter().any(|c| c.starts_with("lag.rate: 16 % of the distribution")), "{found:?}");
}

/// A point is run with the items of an enumeration only, as one of a Real within its range.
#[test]
fn a_value_that_is_no_item_of_an_enumeration_is_out_of_range() {
    let declared = "<SimpleType name=\"Count\"><Enumeration><Item name=\"One\" value=\"1\"/><Item name=\"Two\" \
                    value=\"2\"/><Item name=\"Three\" value=\"3\"/></Enumeration></SimpleType></TypeDefinitions>";
    let description = crate::support::model(
        "</TypeDefinitions> && <Integer start=\"1\" min=\"0\" max=\"9\"/>",
        &format!("{declared} && <Enumeration declaredType=\"Count\" start=\"1\"/>"),
    );
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &[], &description);
    let study = format!("{STUDY}[parameters.\"lag.count\"]\ndistribution = \"uniform\"\nmin = 0.5\nmax = 4.5\n");
    let study = study.replace("points = 40", "points = 40\nmethod = \"latin-hypercube\"");
    bench.write("study.toml", &study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    let summary = bench.summary("out");
    // A Latin hypercube puts a quarter of its points into the last quarter.
    assert_eq!(summary["failures"]["out of range"], 10);
    let found = concerns(&summary);
    let share = "lag.count: 25 % of the distribution lies outside of what the FMU allows (1, 2, 3)";
    assert!(found.iter().any(|c| c.starts_with(share)), "{found:?}");
    let failed = "10 of 40 points failed (out of range: 10), mostly where lag.count is above 3 (so are 100 % of these and 0 % of the others)";
    assert!(found.iter().any(|c| c.starts_with(failed)), "{found:?}");
    assert!(bench.read("out/report.html").contains("those of the 30 points that have a result; 10 failed"));
}

/// Where nothing was compared, nothing is contradicted either.
#[test]
fn a_study_whose_points_all_fail_is_inconclusive() {
    let bench = Bench::new().in_process();
    let verdict = "[verdict]\nshare = \"5 %\"\n";
    for study in [STUDY.to_owned(), format!("{STUDY}{verdict}")] {
        bench.write("study.toml", &format!("{study}[fixed]\n\"lag.fault\" = \"Fail\"\n"));
        let said = bench.run(&["verify", "study.toml", "--output", "out"]);
        assert_eq!(said.code, 3, "{}{}", said.out, said.err);
        let summary = bench.summary("out");
        assert_eq!(summary["verdict"], "inconclusive");
        for unknown in ["risk", "expected_verified"] {
            assert!(summary[unknown].is_null(), "{unknown}");
        }
        assert_eq!(summary["validation"], serde_json::json!({}));
        assert!(concerns(&summary).iter().any(|c| c.starts_with("no point has a result (fmi2Error: 40)")));
        let words = "All 40 points failed, so nothing was compared with the measurement";
        assert!(said.out.contains(words), "{}", said.out);
        assert!(!said.out.contains("expected to be"), "{}", said.out);
        std::fs::remove_dir_all(bench.path("out")).unwrap();
    }
}

/// An empty line of a table of one column is a failed point.
#[test]
fn an_empty_line_of_a_table_is_a_failed_point() {
    let bench = Bench::new().in_process();
    bench.write("study.toml", STUDY);
    bench.write("table.csv", "Y\n0.86\n\n0.861\n0.5\n\n");
    let said = bench.run(&["judge", "study.toml", "table.csv", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let summary = bench.summary("out");
    assert_eq!((&summary["points"], &summary["failed"]), (&4.into(), &1.into()));
    assert_eq!(summary["failure_kinds"][0]["point"], 2);
}

/// `judge` looks at a table as `verify` looks at its points: a mistaken unit shows at three of them, and rows that were
/// written twice are named.
#[test]
fn a_table_is_looked_at_as_the_points_of_a_study() {
    let bench = Bench::new().in_process();
    let concerns_of = |study: &str, table: &str| {
        bench.write("study.toml", study);
        bench.write("table.csv", table);
        let said = bench.run(&["judge", "study.toml", "table.csv", "--output", "out"]);
        assert!(said.code < 2, "{}", said.err);
        concerns(&bench.summary("out"))
    };
    let celsius = STUDY.replace("nominal = 0.86", "nominal = 82").replace("tolerance = 0.02", "tolerance = 1");
    let kelvin = "Y\n355.15\n355.9\n354\n";
    let found = concerns_of(&celsius, kelvin);
    assert!(found.iter().any(|c| c.contains("degC and K were mixed up")), "{found:?}");
    assert_eq!(concerns_of(&celsius, "Y\n81.9\n82.3\n81.2\n"), [""; 0]);
    // Rounded values repeat by chance.
    assert_eq!(concerns_of(STUDY, "Y\n0.861\n0.862\n0.861\n"), [""; 0]);
    let found = concerns_of(STUDY, "Y\n0.861273\n0.862051\n0.861273\n");
    assert!(found[0].starts_with("1 of 3 rows have the same values"), "{found:?}");
}

#[test]
fn a_criterion_that_no_parameter_reaches_is_warned_of() {
    let study = STUDY
        .replace("lag.rate", "lag.length")
        .replace("mean = 1\ndeviation = 0.1", "mean = 0.02\ndeviation = 0.001\nunit = \"mm\"");
    let found = concerns(&verified(&study).1);
    assert!(found.iter().any(|c| c.starts_with("Y: the value is 0.86466 at all 40 points")), "{found:?}");
}

/// y = 1 - exp(-rate t): its values at three times and its mean over one second are known.
#[test]
fn each_criterion_has_its_own_window() {
    let study = STUDY.replace("deviation = 0.1", "deviation = 1e-9").replace("step = 0.01", "step = 0.01\nleap = true")
        + r#"
window = { from = "1 s", to = 1.5 }
[criteria.mean]
variable = "lag.y"
statistic = "mean"
nominal = 0.75
tolerance = 1
window = 1
[criteria.end]
variable = "lag.y"
nominal = 0.86
tolerance = 1
[criteria.least]
variable = "lag.y"
statistic = "min"
nominal = 0.5
tolerance = 1
window = { from = 0.5, to = "700 ms" }
"#;
    let bench = Bench::new().in_process();
    bench.write("study.toml", &study);
    for place in [&["--isolation", "none"][..], &["--isolation", "fresh"]] {
        let arguments = [&["verify", "study.toml", "--output", "out"], place].concat();
        let said = bench.run(&arguments);
        assert!(said.code < 2, "{}", said.err);
        let values = &bench.summary("out")["best_point"]["values"];
        let close = |name: &str, expected: f64| {
            let found = values[name].as_f64().unwrap();
            assert!((found - expected).abs() < 1e-3, "{name}: {found}");
        };
        let y = |t: f64| 1.0 - (-t).exp();
        close("Y", y(1.5));
        close("mean", 1.0 - ((-1.0_f64).exp() - (-2.0_f64).exp()));
        close("end", y(2.0));
        close("least", y(0.5));
        std::fs::remove_dir_all(bench.path("out")).unwrap();
    }
    for (window, words) in [
        ("window = { from = 1, to = 3 }", "study.toml:15:10: the window from 1 s to 3 s must lie between"),
        ("window = { from = 1.001, to = 1.002 }", "study.toml:15:10: no communication point lies in the window"),
    ] {
        bench.write(
            "study.toml",
            &STUDY.replace("tolerance = 0.02\nuncertainty = 0.01", &format!("{window}\ntolerance = 0.02")),
        );
        bench.run(&["verify", "study.toml", "--output", "out"]).is_mistake(&[words]);
    }
}

#[test]
fn the_comparison_names_the_largest_uncertainty() {
    let study = STUDY.replace("points = 40", "points = 2000").replace("tolerance = 0.02", "tolerance = 0.01");
    let (_, summary) = verified(&study);
    let number = |value: &Value| value.as_f64().unwrap();
    let compared = &summary["validation"]["Y"];
    assert!(compared["u_num"].is_null() && compared["u_num_note"] == "not observed");
    let error = number(&compared["model"]) - 0.86;
    assert!((number(&compared["error"]) - error).abs() < 1e-12);
    assert_eq!(number(&compared["u_d"]), 0.005);
    assert_eq!(compared["dominant"], "input");
}

/// The lag holds its input over a step, so that a ramp comes half a step late: an error of the first order.
#[test]
fn the_numerical_uncertainty_is_that_of_the_step() {
    let study = STUDY.replace("points = 40", "points = 4").replace("step = 0.01", "step = 0.1").replace("0.86", "1.13")
        + "[inputs.\"drive.u\"]\nfile = \"u.csv\"\ncolumn = \"u\"\n";
    let bench = Bench::new().in_process();
    bench.write("study.toml", &study);
    bench.write("u.csv", "time,u\n0,0\n2,2\n");
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--validation"]);
    assert!(said.code < 2, "{}", said.err);
    let found = bench.summary("out")["validation"]["Y"].clone();
    // y = t - 1 + exp(-t) comes half a step late: by 0.05 (1 - exp(-2)).
    let expected = 0.05 * (1.0 - (-2.0_f64).exp()) * 1.25 / 1.15;
    let u_num = found["u_num"].as_f64().unwrap();
    assert!((u_num / expected - 1.0).abs() < 0.15, "{found}");
    // A curve before it has no comparison, and takes none away.
    let curve = "[criteria.A]\nvariable = \"lag.y\"\nreference = { file = \"u.csv\", column = \"u\" }\n\
        metric = \"rmse\"\ntolerance = 9\n[criteria.Y]";
    assert!(study.contains("[criteria.Y]"));
    bench.write("study.toml", &study.replace("[criteria.Y]", curve));
    let said = bench.run(&["verify", "study.toml", "--output", "both", "--validation"]);
    assert!(said.code < 2, "{}", said.err);
    assert_eq!(bench.summary("both")["validation"]["Y"], found);
    // An error of three tolerances, where the study states one.
    bench.fmu("lag.fmu", &["TOLERANT=3"], &crate::support::model("Lag", "Lag"));
    bench.write("study.toml", &STUDY.replace("step = 0.01", "step = 0.01\ntolerance = 1e-3"));
    let said = bench.run(&["verify", "study.toml", "--output", "tolerant", "--validation"]);
    assert!(said.code < 2, "{}", said.err);
    let found = bench.summary("tolerant")["validation"]["Y"].clone();
    let u_num = found["u_num"].as_f64().unwrap();
    assert!((u_num / (3e-3 * 1.25 / 1.15) - 1.0).abs() < 1e-3, "{found}");
    let note = found["u_num_note"].as_str().unwrap();
    assert!(note.contains("step") && note.contains("refining the tolerance"), "{note}");
    bench.fmu("lag.fmu", &[], &crate::support::model("Lag", "Lag"));
    // Without an input that changes, every step is exact.
    bench.write("study.toml", STUDY);
    let said = bench.run(&["verify", "study.toml", "--output", "exact", "--validation"]);
    assert!(said.code < 2, "{}", said.err);
    let found = bench.summary("exact")["validation"]["Y"].clone();
    assert!(found["u_num"].is_null(), "{found}");
    assert!(found["u_num_note"].as_str().unwrap().starts_with("not observable"), "{found}");
}

const LINEAR: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 1
step = 1
[design]
points = 512
[parameters."lag.length"]
distribution = "normal"
mean = 0.02
deviation = 0.002
unit = "mm"
[criteria.L]
variable = "lag.micrometres"
nominal = 20
tolerance = 2.4
[verdict]
share = "95 %"
"#;

/// The output is the length in micrometres: 95 % lie within 1.96 deviations.
#[test]
fn tolerances_of_a_linear_model_are_found_and_confirmed() {
    let bench = Bench::new().in_process();
    bench.write("study.toml", LINEAR);
    let said = bench.run(&["tolerances", "study.toml", "--points", "1024", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let found: Value = serde_json::from_str(&bench.read("out/tolerances.json")).unwrap();
    let known = 2.4 / (1.959_964 * 2.0);
    let length = &found["parameters"][0];
    let scale = length["widest_scale"].as_f64().unwrap();
    assert!((scale / known - 1.0).abs() < 0.01, "{found}");
    assert!(length["scale"].as_f64().unwrap() < scale);
    let share = found["confirmed"]["share"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|k| found["stated"]["interval"][k].as_f64().unwrap());
    assert!((low..=high).contains(&share), "{found}");
    assert_eq!(found["confirmed"]["decision"], "verified");
    assert!(said.out.contains("widest tolerances") && said.out.contains("confirmed"), "{}", said.out);
    // Points of a finished study are used first; the same again changes nothing.
    assert!(bench.run(&["verify", "study.toml", "--output", "known"]).code != 2);
    let again = ["tolerances", "study.toml", "--from", "known", "--output", "known"];
    let said = bench.run(&again);
    assert_eq!(said.code, 0, "{}", said.err);
    let first = bench.read("known/tolerances.json");
    assert!(bench.read("known/report.html").contains("Widest tolerances"));
    let said = bench.run(&[&again[..], &["--resume"]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(bench.read("known/tolerances.json"), first);
}

#[test]
fn tolerances_say_why_none_would_do() {
    let bench = Bench::new().in_process();
    bench.write("study.toml", &LINEAR.replace("nominal = 20", "nominal = 30"));
    let said = bench.run(&["tolerances", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("No tolerances would do.") && said.out.contains("shift a parameter's nominal"),
        "{}",
        said.out
    );
    bench.write("study.toml", &LINEAR.replace("[verdict]\nshare = \"95 %\"\n", ""));
    bench.run(&["tolerances", "study.toml"]).is_mistake(&["what the tolerances must achieve"]);
    bench.write("study.toml", &(LINEAR.to_owned() + "[tolerances]\ncosts.\"lag.lenght\" = 2\n"));
    // The results of the run before stay, and nothing says that they are replaced.
    let before = bench.read("out/tolerances/journal.txt");
    bench.run(&["tolerances", "study.toml", "--output", "out"]).is_mistake(&["study.toml:20:7", "lag.lenght"]);
    assert_eq!(bench.read("out/tolerances/journal.txt"), before);
}
