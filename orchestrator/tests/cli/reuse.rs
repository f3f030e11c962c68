//! An instance is used again where the FMU can go back to its beginning, and replaced where it cannot.

use std::fs;

use crate::support::{Bench, model};

const STUDY: &str = r#"
fmu = "lag.fmu"
[design]
points = 12
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 2
[criteria.Y]
variable = "lag.y"
nominal = 0.8
tolerance = 1
"#;

/// How many instances 12 points took with one worker, and the points.
fn instances(macros: &[&str], description: &str) -> (usize, String) {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", macros, description);
    bench.write("study.toml", STUDY);
    let count = bench.path("instances");
    let command = ["verify", "study.toml", "--output", "out", "--jobs", "1"];
    let in_process = bench
        .command(&[&command[..], &["--isolation", "none"]].concat())
        .env("LAG_INSTANCES", &count)
        .output()
        .unwrap();
    assert!(in_process.status.success(), "{}", String::from_utf8_lossy(&in_process.stderr));
    // One more runs the report's best point, and one the extra run with finer steps: one for ten points.
    let instances = fs::read(count).unwrap().len() - 2;
    let points = bench.read("out/points.csv");
    let said = bench.run(&command);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(bench.read("out/points.csv"), points);
    (instances, points)
}

#[test]
fn a_reset_instance_is_compared_with_a_fresh_one_once() {
    assert_eq!(instances(&[], &model("", "")).0, 2);
}

#[test]
fn without_a_sound_reset_every_point_gets_an_instance() {
    let (_, right) = instances(&[], &model("", ""));
    for macros in [["NO_RESET"], ["FAILING_RESET"]] {
        assert_eq!(instances(&macros, &model("", "")), (12, right.clone()), "{macros:?}");
    }
    // Found out by the second point, which ran twice.
    assert_eq!(instances(&["BROKEN_RESET"], &model("", "")), (12, right));
}

#[test]
fn an_fmu_that_allows_one_instance_is_not_compared() {
    let once = model("canHandle", "canBeInstantiatedOnlyOncePerProcess=\"true\" canHandle");
    assert_eq!(instances(&[], &once).0, 1);
}
