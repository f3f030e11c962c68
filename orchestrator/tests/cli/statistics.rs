//! Statistics of signals as criteria, against the closed form of the fixture: y = 1 - exp(-rate t) at its communication
//! points.

use crate::support::{Bench, model};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.05
[design]
points = 6
[parameters."lag.rate"]
distribution = "uniform"
min = 0.9
max = 1.4
"#;

fn criterion(name: &str, keys: &str) -> String {
    format!("[criteria.{name}]\n{keys}\n")
}

/// Rates, and the values of the criteria, of all points.
fn points(bench: &Bench, study: &str) -> Vec<Vec<f64>> {
    bench.write("study.toml", study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    let text = bench.read("out/points.csv");
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let rows = table.records().map(Result::unwrap);
    // Values come before the first judgement.
    let row = |row: csv::StringRecord| {
        let numbers = row.iter().skip(1).map_while(|cell| cell.parse().ok());
        numbers.collect::<Vec<f64>>()
    };
    let rows: Vec<Vec<f64>> = rows.map(row).collect();
    std::fs::remove_dir_all(bench.path("out")).unwrap();
    rows
}

fn y(rate: f64, step: u32) -> f64 {
    1.0 - (-rate * 0.05 * f64::from(step)).exp()
}

/// When y comes to a level, on straight lines between steps.
fn crossing(rate: f64, level: f64) -> f64 {
    let after = (1..).find(|&k| y(rate, k) >= level).unwrap();
    let [low, high] = [after - 1, after].map(|k| y(rate, k));
    0.05 * (f64::from(after - 1) + (level - low) / (high - low))
}

#[test]
fn the_time_of_an_event_is_judged() {
    let bench = Bench::new();
    let own = "variable = \"lag.y\"\nstatistic = \"crossing\"\nlevel = 0.5\nnominal = \"0.6 s\"\ntolerance = \"50 ms\"";
    let warm = "variable = \"lag.temperature\"\nstatistic = \"crossing\"\nlevel = \"5 degC\"\ndirection = \"rising\"\n\
        nominal = 600\ntolerance = 50\nunit = \"ms\"";
    let once = STUDY.to_owned() + &criterion("T", own) + &criterion("W", warm);
    // In a window of its own it is the same time, and what lies before does not count.
    let windows = once.replace("nominal =", "window = { from = \"0.2 s\" }\nnominal =");
    for study in [&once, &windows] {
        for row in points(&bench, study) {
            let expected = crossing(row[0], 0.5);
            assert!((row[1] - expected).abs() < 1e-12, "{row:?} {expected}");
            assert!((row[2] - 1e3 * expected).abs() < 1e-8, "{row:?} {expected}");
        }
    }
    // What never happens fails.
    bench.write("study.toml", &once.replace("\"rising\"", "\"falling\""));
    let said = bench.run(&["verify", "study.toml", "--output", "never", "--verbose"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.out.contains("not finite: 6"), "{}", said.out);
    let why = "not finite: lag.temperature never falls to 278.15 K, but stays within 273.15 .. ";
    assert!(said.out.contains(&format!("       6 as point 1: {why}")), "{}", said.out);
    assert!(bench.read("never/report.html").contains(why));
    for (keys, words) in [
        (own.replace("level = 0.5\n", ""), "needs `level`"),
        (own.replace("0.6 s", "0.6 K"), "no unit of time"),
        (warm.replace("5 degC", "5 mm"), "`mm`"),
        (warm.replace("\"rising\"", "\"up\""), "`up`"),
    ] {
        bench.write("study.toml", &(STUDY.to_owned() + &criterion("T", &keys)));
        let said = bench.run(&["verify", "study.toml", "--output", "out"]);
        said.is_mistake(&["study.toml:", words]);
    }
}

/// A quick lag follows a sine of 3 Hz, and 0.4 in amplitude.
#[test]
fn the_strongest_oscillation_is_judged() {
    let bench = Bench::new();
    let wave = |time: f64| 1.0 + 0.4 * (std::f64::consts::TAU * 3.0 * time).sin();
    let rows = (0..=2000).map(|k| 1e-3 * f64::from(k));
    let rows: String = rows.map(|time| format!("{time},{}\n", wave(time))).collect();
    bench.write("u.csv", &format!("time,drive.u\n{rows}"));
    let keys = "variable = \"lag.y\"\nwindow = 1.7\nnominal = 3\ntolerance = 0.1";
    let study = STUDY.replace("0.9", "39.9").replace("1.4", "40.1").replace("0.05", "0.01")
        + "[inputs.\"drive.u\"]\nfile = \"u.csv\"\nramp = true\n"
        + &criterion("F", &format!("{keys}\nstatistic = \"frequency\""))
        + &criterion("R", &format!("{keys}\nstatistic = \"frequency\"\nunit = \"rpm\""))
        + &criterion("A", &format!("{keys}\nstatistic = \"oscillation-amplitude\""));
    for row in points(&bench, &study) {
        assert!((row[1] - 3.0).abs() < 1e-4, "{row:?}");
        assert!((row[2] - 60.0 * row[1]).abs() < 1e-9, "{row:?}");
        let gain = 1.0 / (std::f64::consts::TAU * 3.0 / row[0]).hypot(1.0);
        assert!((row[3] / (0.4 * gain) - 1.0).abs() < 1e-4, "{row:?}");
    }
}

/// Ten times y, taken for an angle, makes one turn; y is averaged over it.
#[test]
fn a_mean_goes_over_whole_turns() {
    let bench = Bench::new();
    let angle = model(
        "name=\"K\"><BaseUnit K=\"1\"/><DisplayUnit name=\"degC\" offset=\"-273.15\"/> && unit=\"K\" displayUnit=\"degC\"",
        "name=\"rad\"><BaseUnit rad=\"1\"/> && unit=\"rad\"",
    );
    bench.fmu("lag.fmu", &[], &angle);
    let keys = "variable = \"lag.y\"\nstatistic = \"mean\"\nnominal = 1\ntolerance = 1\n\
        turns = \"lag.temperature\"";
    let study = STUDY.to_owned() + &criterion("M", keys);
    for row in points(&bench, &study) {
        let (rate, turn) = (row[0], std::f64::consts::TAU / 10.0);
        let end = crossing(rate, turn);
        let whole = (end / 0.05) as u32;
        let mut integral: f64 = (0..whole).map(|k| 0.025 * (y(rate, k) + y(rate, k + 1))).sum();
        integral += 0.5 * (end - 0.05 * f64::from(whole)) * (y(rate, whole) + turn);
        assert!((row[1] - integral / end).abs() < 1e-12, "{row:?}");
    }
    // No turn is completed before the stop time.
    bench.write("study.toml", &study.replace("stop = 2", "stop = 0.2"));
    let said = bench.run(&["verify", "study.toml", "--output", "short", "--verbose"]);
    assert!(said.out.contains("not finite: 6"), "{}", said.out);
    bench.fmu("lag.fmu", &[], &model("Lag", "Lag"));
    bench.write("study.toml", &study);
    bench.run(&["verify", "study.toml", "--output", "kelvin"]).is_mistake(&["study.toml:", "turns must name an angle"]);
}
