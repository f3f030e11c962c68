//! `verify --rare` on analytic functions: shares that are known exactly.

use crate::support::{Bench, Said};

/// Two normal parameters; the criterion is completed by each test.
const STUDY: &str = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[parameters.x1]
distribution = "normal"
mean = 0
deviation = 1
[parameters.x2]
distribution = "normal"
mean = 0
deviation = 1
"#;

fn criterion(variable: &str, nominal: f64, tolerance: f64) -> String {
    format!("[criteria.C]\nvariable = \"{variable}\"\nnominal = {nominal}\ntolerance = {tolerance}\n")
}

/// A study with these further lines, run with these further options.
fn rare(bench: &Bench, lines: &str, options: &[&str]) -> Said {
    bench.write("study.toml", &format!("{STUDY}{lines}"));
    bench.run(&[&["verify", "study.toml", "--output", "out"], options].concat())
}

fn found(bench: &Bench) -> serde_json::Value {
    serde_json::from_str(&bench.read("out/rare.json")).unwrap()
}

/// The share lies within a tenth of the exact one and within twice the stated interval, and runs show the event.
fn holds(bench: &Bench, exact: f64) -> serde_json::Value {
    let found = found(bench);
    let surrogate = &found["surrogate"];
    let share = surrogate["share"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|k| surrogate["interval"][k].as_f64().unwrap());
    assert!(low < share && share < high);
    assert!(low * low / share < exact && exact < high * high / share, "{exact}: {found}");
    assert!((share / exact - 1.0).abs() < 0.1, "{exact}: {found}");
    assert!(found["inside"].as_array().unwrap().len() >= 3);
    found
}

/// Beyond 3.719 deviations: 1e-4.
#[test]
fn points_that_miss_a_criterion_are_found_by_few_runs() {
    let bench = Bench::functions();
    let limit = "[criteria.C]\nvariable = \"first\"\nat-most = 3.719016485\nmeasured = 0\nuncertainty = 0.01\n";
    let lines = format!("[verdict]\nshare = \"99.999 %\"\n{limit}");
    let said = rare(&bench, &lines, &["--rare", "not-conforming", "--budget", "60"]);
    // More than one in 100,000 are not verified.
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.contains("(by surrogate)"), "{}", said.out);
    let found = holds(&bench, 1e-4);
    assert!(found["surrogate"]["runs"].as_u64().unwrap() <= 60);
    assert!(found["inside"][0]["x1"].as_f64().unwrap() > 3.719);
    assert_eq!(found["verdict"], "not verified");
}

/// Between 3 and 3.2 deviations: 1.349898e-3 - 6.871379e-4.
#[test]
fn a_share_of_verified_points_is_told() {
    let bench = Bench::functions();
    let said = rare(&bench, &criterion("first", 3.1, 0.1), &["--rare", "--budget", "60"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let found = holds(&bench, 6.627_6e-4);
    assert_eq!(found["event"], "verified");
    for point in found["inside"].as_array().unwrap() {
        assert!((point["x1"].as_f64().unwrap() - 3.1).abs() <= 0.1);
    }
}

#[test]
fn what_is_not_found_is_not_called_impossible() {
    let bench = Bench::functions();
    // The distance from a place is never negative.
    let said = rare(&bench, &criterion("radius", -1.0, 0.5), &["--rare", "--budget", "40"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.contains("verified: not told by 40 runs, as 0 of them"), "{}", said.out);
    assert!(found(&bench)["surrogate"]["share"].is_null());
    let said = rare(&bench, &criterion("first", 0.0, 1.0), &["--rare", "failed", "--budget", "40"]);
    assert!(said.out.contains("failed: not told"), "{}", said.out);
    assert!(found(&bench)["surrogate"]["interval"].is_null());
}

#[test]
fn mistakes_are_one_line_with_a_remedy() {
    let bench = Bench::functions();
    let lines = criterion("first", 6.1, 0.1);
    let said = rare(&bench, &lines, &["--rare", "--budget", "5"]);
    said.is_mistake(&["--budget", "20 to 1000"]);
    let guard = "[verdict]\nshare = \"5 %\"\nguard-band = 0.5\n";
    let said = rare(&bench, &format!("{guard}{lines}uncertainty = 0.05\n"), &["--rare"]);
    said.is_mistake(&["guard-band", "remove"]);
    let said = rare(&bench, &lines, &["--rare", "often"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("not-conforming"), "{}", said.err);
}
