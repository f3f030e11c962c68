//! Criteria on whole curves, against the closed form of the fixture: y = 1 - exp(-rate t) at its communication points.

use std::fmt::Write;

use crate::support::{Bench, Said};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.05
[design]
points = 6
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
[criteria.Y]
variable = "lag.y"
reference = { file = "measured.csv", time = "t", column = "y" }
metric = "rmse"
tolerance = 0.02
[criteria.T]
variable = "lag.temperature"
reference = { file = "measured.csv", time = "t", column = "T", unit = "degC", uncertainty = "0.2 degC" }
metric = "corridor"
least = "80 %"
unit = "degC"
[criteria.W]
variable = "lag.y"
reference = { file = "measured.csv", time = "t", column = "y" }
metric = "max-error"
delay = "100 ms"
tolerance = 0.1
"#;

/// The measurement: uneven times, and the curve of another rate.
fn times() -> Vec<f64> {
    (0..40).map(|k| 0.11 + 0.04 * f64::from(k) + 0.003 * f64::from(k % 3)).collect()
}

fn measured(time: f64) -> f64 {
    1.0 - (-1.1 * time).exp()
}

/// The model at a time: the closed form at the steps, straight lines between them.
fn model(rate: f64, time: f64) -> f64 {
    let at = |step: f64| 1.0 - (-rate * 0.05 * step).exp();
    let step = (time / 0.05).floor();
    at(step) + (time / 0.05 - step) * (at(step + 1.0) - at(step))
}

fn bench(study: &str) -> Bench {
    let bench = Bench::new();
    let mut table = String::from("t,y,T,other\n");
    for time in times() {
        let y = measured(time);
        writeln!(table, "{time},{y},{},1", 10.0 * y).unwrap();
    }
    bench.write("measured.csv", &table);
    bench.write("study.toml", study);
    bench
}

/// Rows of points.csv: the rate, and the values of the criteria.
fn rows(bench: &Bench, names: &[&str]) -> Vec<Vec<f64>> {
    let text = bench.read("out/points.csv");
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| header.iter().position(|column| *column == name).unwrap();
    let places: Vec<usize> = ["lag.rate"].iter().chain(names).map(|name| place(name)).collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        places.iter().map(|&place| cells[place].parse().unwrap()).collect()
    };
    lines.map(row).collect()
}

fn verify(bench: &Bench) -> Said {
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--verbose"]);
    assert!(said.code < 2, "{}", said.err);
    said
}

#[test]
fn curves_are_compared_while_the_model_steps() {
    let bench = bench(STUDY);
    let said = verify(&bench);
    assert!(said.out.contains("Y  rmse at most 0.02"), "{}", said.out);
    let rows = rows(&bench, &["Y", "T", "W"]);
    assert_eq!(rows.len(), 6);
    for row in rows {
        let [rate, y, t, w] = row[..] else { panic!() };
        let late = |delay: f64| times().into_iter().map(move |time| model(rate, time - delay) - measured(time));
        let squares: f64 = late(0.0).map(|deviation| deviation * deviation).sum();
        assert!((y - (squares / 40.0).sqrt()).abs() < 1e-12, "{rate} {y}");
        let inside = late(0.0).filter(|deviation| 10.0 * deviation.abs() <= 0.2).count();
        assert!((t - inside as f64 / 40.0).abs() < 1e-12, "{rate} {t}");
        let most = late(0.1).map(f64::abs).fold(0.0, f64::max);
        assert!((w - most).abs() < 1e-12, "{rate} {w}");
    }
}

#[test]
fn windows_cut_the_measurement() {
    let late = STUDY.replace("tolerance = 0.02", "tolerance = 0.02\nwindow = { from = \"1 s\", to = \"1.5 s\" }");
    let warm = STUDY.replace("stop = 2", "stop = 2\nwarm-up = 1");
    for (study, until) in [(late, 1.5), (warm, 2.0)] {
        let bench = bench(&study);
        verify(&bench);
        for row in rows(&bench, &["Y"]) {
            let inside = || times().into_iter().filter(|time| (1.0..=until).contains(time));
            let squares: f64 = inside().map(|time| (model(row[0], time) - measured(time)).powi(2)).sum();
            let expected = (squares / inside().count() as f64).sqrt();
            assert!((row[1] - expected).abs() < 1e-12, "{row:?} {expected}");
        }
    }
}

#[test]
fn replay_and_judge_say_the_same() {
    let bench = bench(STUDY);
    verify(&bench);
    let first = &rows(&bench, &["Y"])[0];
    let said = bench.run(&["replay", "out", "1"]);
    let value: f64 = {
        let line = said.out.lines().find(|line| line.trim_start().starts_with("Y = ")).unwrap();
        line.split_whitespace().nth(2).unwrap().parse().unwrap()
    };
    assert!((value - first[1]).abs() < 1e-5, "{}", said.out);
    let judged = bench.run(&["judge", "study.toml", "out/points.csv", "--output", "judged", "--verbose"]);
    assert!(judged.code < 2, "{}", judged.err);
    for key in ["points", "verified", "criteria"] {
        let passed = |folder: &str| {
            let summary = bench.summary(folder);
            match key {
                "criteria" => ["Y", "T", "W"].map(|name| summary[key][name]["passed"].clone()).to_vec(),
                _ => vec![summary[key].clone()],
            }
        };
        assert_eq!(passed("judged"), passed("out"));
    }
}

#[test]
fn a_curve_has_a_rating() {
    let rated = STUDY.replace("metric = \"corridor\"\nleast = \"80 %\"", "metric = \"iso18571\"\nleast = 0.8");
    let bench = bench(&rated);
    verify(&bench);
    for row in rows(&bench, &["T"]) {
        assert!(row[1] > 0.5 && row[1] <= 1.0, "{row:?}");
    }
}

#[test]
fn mistakes_of_curves() {
    let mistake = |from: &str, to: &str, words: &[&str]| {
        assert!(STUDY.contains(from), "{from}");
        let bench = bench(&STUDY.replacen(from, to, 1));
        bench.run(&["verify", "study.toml", "--output", "out"]).is_mistake(words);
    };
    mistake("unit = \"degC\",", "unit = \"mm\",", &["study.toml:17:", "mm"]);
    mistake("column = \"y\"", "column = \"z\"", &["study.toml:14:", "measured.csv", "no column `z`", "t, y, T"]);
    mistake("file = \"measured.csv\"", "file = \"none.csv\"", &["study.toml:14:", "none.csv"]);
    mistake("stop = 2", "stop = 1", &["study.toml:14:", "not within the run", "window"]);
    mistake("\"100 ms\"", "\"200 ms\"", &["study.toml:25:", "delay of 0.2 s", "not within the run"]);
    mistake("metric = \"rmse\"", "metric = \"rmsd\"", &["study.toml:15:", "`rmse`"]);
    mistake("tolerance = 0.02", "tolerance = 0.02\nnominal = 1", &["study.toml:12:", "no place"]);
    mistake(", uncertainty = \"0.2 degC\"", "", &["study.toml:17:", "band"]);
    mistake(
        "tolerance = 0.02",
        "tolerance = 0.02\nwindow = { from = 1.9 }",
        &["study.toml:14:", "0 rows lie in the window"],
    );
    let bench = bench(STUDY);
    for (cell, words) in [("nan", "row 2"), ("broken", "is not a number")] {
        let table = bench.read("measured.csv");
        let second = table.lines().nth(2).unwrap();
        let time = second.split(',').next().unwrap();
        bench.write("broken.csv", &table.replace(second, &format!("{time},{cell},1,1")));
        bench.write("broken.toml", &STUDY.replace("measured.csv", "broken.csv"));
        let said = bench.run(&["verify", "broken.toml", "--output", "out"]);
        said.is_mistake(&["broken.toml:14:", "broken.csv", words]);
    }
}

const UNCERTAIN: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.05
[design]
points = 24
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
[criteria.Y]
variable = "lag.y"
reference = { file = "measured.csv", time = "t", column = "y", uncertainty = 0.04 }
metric = "rmse"
tolerance = 0.03
[criteria.T]
variable = "lag.temperature"
nominal = 8.9
tolerance = 0.3
uncertainty = 0.2
unit = "degC"
"#;

/// The probability that the rmse of a point is at most 0.03, where all rows are off by the same error z of standard deviation
/// 0.02: (d - z)^2 = mean((e - z)^2) + (mean e)^2 - mean(e^2), so z lies between two limits.
fn conforms(rate: f64) -> f64 {
    let errors: Vec<f64> = times().into_iter().map(|t| model(rate, t) - measured(t)).collect();
    let mean = errors.iter().sum::<f64>() / 40.0;
    let squares = errors.iter().map(|e| e * e).sum::<f64>() / 40.0;
    let rest = 0.03 * 0.03 + mean * mean - squares;
    match rest > 0.0 {
        true => conformity::normal::between((mean - rest.sqrt()) / 0.02, (mean + rest.sqrt()) / 0.02),
        false => 0.0,
    }
}

#[test]
fn the_risk_of_a_curve_joins_that_of_numbers() {
    let bench = bench(UNCERTAIN);
    let said = verify(&bench);
    let summary = bench.summary("out");
    let risk = &summary["criteria"]["Y"]["risk"];
    let rows = rows(&bench, &["Y", "T"]);
    let mean = |of: &dyn Fn(&[f64]) -> f64| rows.iter().map(|row| of(row)).sum::<f64>() / 24.0;
    let near = |found: &serde_json::Value, expected: f64| {
        let found = found.as_f64().unwrap();
        // A point's probability is one of 256 draws.
        assert!((found - expected).abs() < 1.0 / 256.0, "{found} {expected}");
    };
    near(&risk["conformance_probability"], mean(&|row| conforms(row[0])));
    let consumer = |row: &[f64]| f64::from(u8::from(row[1] <= 0.03)) * (1.0 - conforms(row[0]));
    near(&risk["consumer"], mean(&consumer));
    let number = |value: f64| conformity::normal::between((value - 8.9 - 0.3) / 0.1, (value - 8.9 + 0.3) / 0.1);
    let both = mean(&|row| conforms(row[0]) * number(row[2]));
    near(&summary["risk"]["conformance_probability"], both);
    let expected = summary["expected_verified"].as_f64().unwrap() / 24.0;
    near(&expected.into(), both);
    assert_eq!(summary["criteria"]["Y"]["row_correlation"], 1.0);
    assert!(said.out.contains("risk presumes that all measured rows of Y share one error"), "{}", said.out);
    // The same numbers whatever the processes, and after the run was interrupted.
    for isolation in ["fresh", "shared"] {
        bench.run(&["verify", "study.toml", "--isolation", isolation, "--output", isolation]);
        assert_eq!(bench.summary(isolation)["risk"], summary["risk"]);
    }
    for half in ["1/2", "2/2"] {
        bench.run(&["verify", "study.toml", "--shard", half, "--output", &half[..1]]);
    }
    bench.run(&["merge", "1", "2", "--output", "merged"]);
    assert_eq!(bench.summary("merged")["risk"], summary["risk"]);
    // A table has no curve to compare with.
    let judged = bench.run(&["judge", "study.toml", "out/points.csv", "--output", "judged", "--verbose"]);
    let of_table = bench.summary("judged");
    assert!(of_table["risk"].is_null() && of_table["criteria"]["Y"]["risk"].is_null());
    let reason = of_table["criteria"]["Y"]["risk_not_stated"].as_str().unwrap();
    assert!(reason.contains("a table has the metric's value alone"), "{reason}");
    assert!(judged.out.contains("of the curve Y, the points come without"), "{}", judged.out);
    assert!(!of_table["criteria"]["T"]["risk"].is_null());
}

/// Criteria on one recorded column share its errors; independent errors of 40 rows add their variance.
#[test]
fn curves_of_one_recording_share_their_errors() {
    let twice = UNCERTAIN.replace("[criteria.T]", "[criteria.Z]\nvariable = \"lag.y\"\nreference = { file = \"measured.csv\", time = \"t\", column = \"y\", uncertainty = 0.04 }\nmetric = \"rmse\"\ntolerance = 0.03\n[criteria.T]");
    let bench_of_two = bench(&twice);
    verify(&bench_of_two);
    let alone = bench(UNCERTAIN);
    verify(&alone);
    assert_eq!(bench_of_two.summary("out")["risk"], alone.summary("out")["risk"]);
    let noise = UNCERTAIN.replace("uncertainty = 0.04 }", "uncertainty = 0.04, correlation = 0 }");
    let of_noise = bench(&noise);
    verify(&of_noise);
    let risk = &of_noise.summary("out")["criteria"]["Y"]["risk"];
    // sqrt(rmse^2 + 0.02^2) <= 0.03 leaves the points with an rmse below 0.0224.
    let near = rows(&of_noise, &["Y"]).iter().filter(|row| row[1] < 0.0224).count();
    let found = 24.0 * risk["conformance_probability"].as_f64().unwrap();
    assert!((found - near as f64).abs() < 2.0, "{found} {near}");
    let wrong = bench(&noise.replace("correlation = 0", "correlation = 1.5"));
    wrong.run(&["verify", "study.toml", "--output", "out"]).is_mistake(&["study.toml:14:", "from 0 (noise) to 1"]);
    let guarded = bench(&format!("{UNCERTAIN}[verdict]\nshare = 0.1\nrisk = 0.05\n"));
    guarded.run(&["verify", "study.toml", "--output", "out"]).is_mistake(&["study.toml:25:", "curve Y", "remove risk"]);
}

/// The model rises, so its percentiles are its values after so much of the time, on straight lines between its steps.
#[test]
fn percentiles_and_values_at_a_time_lie_between_steps() {
    let begin = STUDY.split("[criteria.Y]").next().unwrap();
    let criterion = |name: &str, keys: &str| {
        format!("[criteria.{name}]\nvariable = \"lag.y\"\nnominal = 0.5\ntolerance = 0.1\n{keys}\n")
    };
    let percentile = |percent: f64| format!("statistic = \"percentile\"\npercent = {percent}\n");
    let own = percentile(30.0) + "window = { from = \"1 s\", to = \"1.5 s\" }";
    let general = criterion("P", &percentile(95.0)) + &criterion("A", "at = \"320 ms\"");
    let windows = general.clone() + &criterion("W", &own);
    let warm = begin.replace("stop = 2", "stop = 2\nwarm-up = 1\nleap = true");
    for (study, from) in
        [(begin.to_owned() + &general, 0.0), (begin.to_owned() + &windows, 0.0), (warm + &windows, 1.0)]
    {
        let bench = bench(&study);
        verify(&bench);
        let has_own = study.contains("[criteria.W]");
        let names = if has_own { &["P", "A", "W"][..] } else { &["P", "A"] };
        for row in rows(&bench, names) {
            let close = |value: f64, time: f64| {
                let expected = model(row[0], time);
                assert!((value - expected).abs() < 1e-12, "{row:?} {expected}");
            };
            close(row[1], from + 0.95 * (2.0 - from));
            close(row[2], 0.32);
            if has_own {
                close(row[3], 1.0 + 0.3 * 0.5);
            }
        }
    }
}

#[test]
fn a_percentile_without_percent_is_refused_with_its_line() {
    let begin = STUDY.split("[criteria.Y]").next().unwrap();
    for (keys, message) in
        [("statistic = \"percentile\"", "needs `percent`"), ("at = \"3 s\"", "not within the run from 0 s to 2 s")]
    {
        let study = format!("{begin}[criteria.P]\nvariable = \"lag.y\"\nnominal = 1\ntolerance = 0.1\n{keys}\n");
        let line = 1 + begin.lines().count();
        let said = bench(&study).run(&["verify", "study.toml", "--output", "out"]);
        assert_eq!(said.code, 2);
        assert!(said.err.contains(message), "{}", said.err);
        assert!(said.err.contains(&format!("study.toml:{line}:")), "{}", said.err);
    }
}

/// An FMU that ends the simulation before the last row of a reference is not judged by the rows before.
#[test]
fn a_run_that_ends_before_the_reference_fails() {
    let early = STUDY.replace("[design]", "[fixed]\n\"lag.fault\" = \"End\"\n[design]");
    let bench = bench(&early);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    // Of points that all fail nothing is known.
    assert_eq!(said.code, 3, "{}", said.err);
    let points = bench.read("out/points.csv");
    for line in points.lines().skip(1) {
        let why = "not finite: lag.y (the FMU ended the simulation at 1 s)";
        assert!(line.ends_with(why), "{line}");
        assert!(!line.contains("true"), "{line}");
    }
}
