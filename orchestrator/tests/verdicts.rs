//! Tolerance and measurement uncertainty through the command line: verdicts, risks, exit codes.
#![allow(clippy::unwrap_used)]

mod support;

use std::fmt::Write;

use serde_json::Value;
use statrs::distribution::{ContinuousCDF, Normal};
use support::Bench;

const STUDY: &str = r#"
fmu = "none.fmu"
[parameters.p]
distribution = "uniform"
min = 0
max = 1
[criteria.T_bearing]
variable = "T"
nominal = 82
tolerance = "0.75 %"
uncertainty = "0.615 degC"
unit = "degC"
[criteria.F_N]
variable = "F"
nominal = 750
tolerance = "7 %"
uncertainty = "7 %"
unit = "N"
"#;

/// Judges points at the quantiles of the two populations of `studies/paper-table3.toml`.
fn judge(study: &str, rows: u32) -> (i32, Value) {
    let bench = Bench::empty();
    let temperature = Normal::new(81.486_108, 0.345_215).unwrap();
    let load = Normal::new(769.503_815, 89.266_864).unwrap();
    let mut table = String::from("point,T,F\n");
    for i in 0..rows {
        let u = (f64::from(i) + 0.5) / f64::from(rows);
        // The loads in an order of their own, as good as independent of the temperatures.
        let v = (f64::from(i) * 0.618_033_988_749_894_9 + 0.5 / f64::from(rows)).fract();
        let (t, f) = (temperature.inverse_cdf(u), load.inverse_cdf(v));
        writeln!(table, "{},{t},{f}", i + 1).unwrap();
    }
    bench.write("study.toml", study);
    bench.write("table.csv", &table);
    let said = bench.run(&["judge", "study.toml", "table.csv", "--output", "out"]);
    assert!(said.code != 2, "{}", said.err);
    (said.code, bench.summary("out"))
}

fn numbers(rows: u32) {
    let precise = STUDY
        .replace("\"0.615 degC\"", "\"0.15375 degC\"")
        .replace("uncertainty = \"7 %\"", "uncertainty = \"13.125 N\"");
    for (study, expected) in [
        (STUDY, [[0.1338, 0.0984], [0.0837, 0.0685]]),
        (&precise, [[0.0351, 0.0322], [0.0199, 0.0188]]),
    ] {
        let (code, summary) = judge(study, rows);
        assert_eq!(code, 0);
        for (name, [consumer, producer]) in ["T_bearing", "F_N"].into_iter().zip(expected) {
            let risk = &summary["criteria"][name]["risk"];
            let found = |key: &str| risk[key].as_f64().unwrap();
            assert!(
                (found("consumer") - consumer).abs() < 1e-4,
                "{name}: {risk}"
            );
            assert!(
                (found("producer") - producer).abs() < 1e-4,
                "{name}: {risk}"
            );
        }
        let expected = summary["expected_verified"].as_f64().unwrap() / f64::from(rows);
        let joint = summary["risk"]["conformance_probability"].as_f64().unwrap();
        assert!((expected - joint).abs() < 1e-12);
    }
}

#[test]
fn risks_of_a_table_at_the_quantiles() {
    numbers(100_000);
}

#[test]
#[ignore = "takes a minute; run by scripts/test --long"]
fn risks_of_a_million_rows_at_the_quantiles() {
    numbers(1_000_000);
}

#[test]
fn nothing_is_stated_without_uncertainties() {
    let study = STUDY.replacen("uncertainty = \"0.615 degC\"\n", "", 1);
    let (code, summary) = judge(&study, 200);
    assert_eq!(code, 0);
    assert_eq!(summary["verdict"], "verified");
    assert_eq!(summary["rule"], "one point");
    assert!(summary["risk"].is_null() && summary["expected_verified"].is_null());
    assert!(summary["criteria"]["T_bearing"].get("risk").is_none());
    assert!(summary["criteria"]["F_N"]["risk"]["consumer"].is_number());
    assert_eq!(summary["accepted"], summary["verified"]);
}

/// About 29 % of the points meet both criteria.
#[test]
fn verdicts_have_their_exit_codes() {
    for (share, code, verdict) in [
        ("10 %", 0, "verified"),
        ("60 %", 1, "not verified"),
        ("28 %", 3, "inconclusive"),
    ] {
        let (found, summary) = judge(&format!("{STUDY}[verdict]\nshare = \"{share}\"\n"), 200);
        assert_eq!(
            (found, summary["verdict"].as_str()),
            (code, Some(verdict)),
            "{summary}"
        );
        assert_eq!(summary["rule"], "share");
    }
}

#[test]
fn the_risk_sets_the_guard_band() {
    let guarded = format!("{STUDY}[verdict]\nshare = \"1 %\"\nrisk = \"30 %\"\n");
    let (_, summary) = judge(&guarded, 2000);
    let band = summary["guard_band"].as_f64().unwrap();
    let share = summary["risk"]["not_conforming_given_accepted"]
        .as_f64()
        .unwrap();
    assert!(band > 0.0 && share <= 0.3 && share > 0.29, "{band} {share}");
    assert!(summary["accepted"].as_u64() < summary["verified"].as_u64());
    let given = guarded.replace("risk = \"30 %\"", &format!("guard-band = {band}"));
    assert_eq!(judge(&given, 2000).1["accepted"], summary["accepted"]);
}
