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
    searched(bench, lines, "20000", options)
}

fn searched(bench: &Bench, lines: &str, points: &str, options: &[&str]) -> Said {
    bench.write("study.toml", &format!("{STUDY}{lines}"));
    let common = [
        "verify",
        "study.toml",
        "--output",
        "out",
        "--points",
        points,
        // The FMU is known to keep nothing from one point to the next.
        "--isolation",
        "shared",
    ];
    bench.run(&[&common, options].concat())
}

fn found(bench: &Bench) -> serde_json::Value {
    serde_json::from_str(&bench.read("out/rare.json")).unwrap()
}

/// The share lies within twice the stated interval, and the points of the table stand for all of it.
fn holds(bench: &Bench, exact: f64) -> serde_json::Value {
    let found = found(bench);
    let share = found["share"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|k| found["interval"][k].as_f64().unwrap());
    assert!(low < share && share < high);
    assert!(low * low / share < exact && exact < high * high / share, "{exact}: {found}");
    let text = bench.read("out/rare.csv");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let weights = table.records().map(|row| row.unwrap()[0].parse::<f64>().unwrap());
    assert!((weights.sum::<f64>() / share - 1.0).abs() < 1e-6);
    found
}

/// Beyond 5 deviations, where all points seem equally far from a limit in whose unit they lie hundreds inside: 2.866516e-7.
#[test]
fn points_far_inside_of_a_limit_lead_to_it() {
    let bench = Bench::functions();
    let lines = "[criteria.C]\nvariable = \"first\"\nat-most = 5\nmeasured = 0\nuncertainty = 0.01\n";
    let said = searched(&bench, lines, "40000", &["--rare", "not-conforming"]);
    assert!(said.out.contains("e−7 of the space"), "{}{}", said.out, said.err);
    holds(&bench, 2.866_516e-7);
}

/// Between 6 and 6.2 deviations: 7.042718e-10.
#[test]
fn a_share_of_verified_points_is_told() {
    let bench = Bench::functions();
    let lines = criterion("first", 6.1, 0.1);
    let said = searched(&bench, &lines, "40000", &["--rare"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("e−10 of the space"), "{}", said.out);
    assert!(said.out.contains("nothing shows regions that none of them reached"), "{}", said.out);
    let found = holds(&bench, 7.042_718e-10);
    assert_eq!(found["event"], "verified");
    assert_eq!(found["method"], "weighted draws");
    let centre = found["regions"][0]["centre"]["x1"].as_f64().unwrap();
    assert!((6.0..6.2).contains(&centre), "{found}");
    let text = bench.read("out/rare.csv");
    assert!(text.starts_with("weight,x1,x2,C,status\n"), "{text}");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    for row in table.records() {
        let value: f64 = row.unwrap()[3].parse().unwrap();
        assert!((value - 6.1).abs() <= 0.1);
    }
}

/// Beyond 6 deviations on both sides: 1.973175e-9, in two regions.
#[test]
fn points_that_miss_a_criterion_lie_on_both_sides() {
    let bench = Bench::functions();
    // 400 plain points and the failed runs among them leave as much as 2.2 %.
    let verdict = "[verdict]\nshare = \"95 %\"\n";
    let lines = format!("{verdict}{}", criterion("first", 0.0, 6.0));
    let said = rare(&bench, &lines, &["--rare", "not-conforming"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let found = holds(&bench, 1.973_175e-9);
    assert_eq!(found["regions"].as_array().unwrap().len(), 2);
    assert_eq!(found["verdict"], "verified");
    assert_eq!(found["confidence"], 0.975);
    // How many runs fail is known from the plain points only.
    let lines = lines.replace("95 %", "99.9999 %");
    let said = rare(&bench, &lines, &["--rare", "not-conforming"]);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    // The same criterion, seen from the other side, is met nearly everywhere: that is counted.
    let said = rare(&bench, &lines, &["--rare", "verified"]);
    assert_eq!(found_method(&bench), "counted", "{}{}", said.out, said.err);
}

fn found_method(bench: &Bench) -> String {
    found(bench)["method"].as_str().unwrap().to_owned()
}

/// No number beyond 4.75 deviations: 1.017083e-6.
#[test]
fn runs_that_fail_are_found_by_wider_draws() {
    let bench = Bench::functions();
    let lines = criterion("gap", 0.0, 9.0);
    // Each run that fails is made once more, alone: fewer of them take less time.
    let said = searched(&bench, &lines, "5000", &["--rare", "failed"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let found = holds(&bench, 1.017_083e-6);
    assert!(found["wider"][1].as_u64().unwrap() > 0);
    assert!(bench.read("out/rare.csv").contains("not finite"));
    // What fails meets no criterion, and misses none either.
    let lines = criterion("gap", 0.0, 4.5);
    let said = rare(&bench, &lines, &["--rare", "not-conforming"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    // 2 x 3.397673e-6 - 1.017083e-6.
    holds(&bench, 5.778_263e-6);
}

#[test]
fn what_is_not_found_is_not_called_impossible() {
    let bench = Bench::functions();
    // The distance from a place is never negative.
    let said = rare(&bench, &criterion("radius", -1.0, 0.5), &["--rare"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    for words in ["verified: not told", "at most", "More --points go deeper"] {
        assert!(said.out.contains(words), "{}", said.out);
    }
    let found_nothing = found(&bench);
    assert!(found_nothing["share"].is_null());
    assert_eq!(found_nothing["interval"][0], 0.0);
    let said = rare(&bench, &criterion("first", 0.0, 1.0), &["--rare", "failed"]);
    assert!(said.out.contains("failed: not told; 0 of "), "{}", said.out);
    // 3.69 of all plain points, at 95 % on both sides.
    let found = found(&bench);
    let (runs, high) = (&found["plain"]["runs"], &found["interval"][1]);
    let product = runs.as_f64().unwrap() * high.as_f64().unwrap();
    assert!((product - 3.69).abs() < 0.01, "{found}");
}

#[test]
fn mistakes_are_one_line_with_a_remedy() {
    let bench = Bench::functions();
    let lines = criterion("first", 6.1, 0.1);
    bench.write("study.toml", &format!("{STUDY}{lines}"));
    let few = bench.run(&["verify", "study.toml", "--rare", "--points", "100"]);
    few.is_mistake(&["--points", "5000"]);
    let guard = "[verdict]\nshare = \"5 %\"\nguard-band = 0.5\n";
    let said = rare(&bench, &format!("{guard}{lines}uncertainty = 0.05\n"), &["--rare"]);
    said.is_mistake(&["guard-band", "remove"]);
    let said = rare(&bench, &lines, &["--rare", "often"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("not-conforming"), "{}", said.err);
}
