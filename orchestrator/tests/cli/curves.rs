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
    (0..40)
        .map(|k| 0.11 + 0.04 * f64::from(k) + 0.003 * f64::from(k % 3))
        .collect()
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
    let places: Vec<usize> = ["lag.rate"]
        .iter()
        .chain(names)
        .map(|name| place(name))
        .collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        places
            .iter()
            .map(|&place| cells[place].parse().unwrap())
            .collect()
    };
    lines.map(row).collect()
}

fn verify(bench: &Bench) -> Said {
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
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
        let late = |delay: f64| {
            times()
                .into_iter()
                .map(move |time| model(rate, time - delay) - measured(time))
        };
        let squares: f64 = late(0.0).map(|deviation| deviation * deviation).sum();
        assert!((y - (squares / 40.0).sqrt()).abs() < 1e-12, "{rate} {y}");
        let inside = late(0.0)
            .filter(|deviation| 10.0 * deviation.abs() <= 0.2)
            .count();
        assert!((t - inside as f64 / 40.0).abs() < 1e-12, "{rate} {t}");
        let most = late(0.1).map(f64::abs).fold(0.0, f64::max);
        assert!((w - most).abs() < 1e-12, "{rate} {w}");
    }
}

#[test]
fn windows_cut_the_measurement() {
    let late = STUDY.replace(
        "tolerance = 0.02",
        "tolerance = 0.02\nwindow = { from = \"1 s\", to = \"1.5 s\" }",
    );
    let warm = STUDY.replace("stop = 2", "stop = 2\nwarm-up = 1");
    for (study, until) in [(late, 1.5), (warm, 2.0)] {
        let bench = bench(&study);
        verify(&bench);
        for row in rows(&bench, &["Y"]) {
            let inside = || {
                times()
                    .into_iter()
                    .filter(|time| (1.0..=until).contains(time))
            };
            let squares: f64 = inside()
                .map(|time| (model(row[0], time) - measured(time)).powi(2))
                .sum();
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
        let line = said
            .out
            .lines()
            .find(|line| line.trim_start().starts_with("Y = "))
            .unwrap();
        line.split_whitespace().nth(2).unwrap().parse().unwrap()
    };
    assert!((value - first[1]).abs() < 1e-5, "{}", said.out);
    let judged = bench.run(&[
        "judge",
        "study.toml",
        "out/points.csv",
        "--output",
        "judged",
    ]);
    assert!(judged.code < 2, "{}", judged.err);
    for key in ["points", "verified", "criteria"] {
        let passed = |folder: &str| {
            let summary = bench.summary(folder);
            match key {
                "criteria" => ["Y", "T", "W"]
                    .map(|name| summary[key][name]["passed"].clone())
                    .to_vec(),
                _ => vec![summary[key].clone()],
            }
        };
        assert_eq!(passed("judged"), passed("out"));
    }
}

#[test]
fn an_aligned_curve_and_a_rating() {
    let found = STUDY
        .replace(
            "delay = \"100 ms\"",
            "delay = { from = \"-100 ms\", to = \"50 ms\" }",
        )
        .replace("metric = \"max-error\"", "metric = \"rmse\"")
        .replace(
            "metric = \"corridor\"\nleast = \"80 %\"",
            "metric = \"iso18571\"\nleast = 0.8",
        );
    let bench = bench(&found);
    verify(&bench);
    for row in rows(&bench, &["Y", "T", "W"]) {
        assert!(row[2] > 0.5 && row[2] <= 1.0, "{row:?}");
        // The least rmse among 3001 delays.
        let rmse = |delay: f64| {
            let late = |time: f64| model(row[0], time - delay) - measured(time);
            let squares: f64 = times().into_iter().map(|time| late(time).powi(2)).sum();
            (squares / 40.0).sqrt()
        };
        let tried = (0..=3000).map(|k| rmse(-0.1 + 5e-5 * f64::from(k)));
        let least = tried.fold(f64::INFINITY, f64::min);
        assert!(
            row[3] <= least + 1e-12 && row[3] > least - 1e-6,
            "{row:?} {least}"
        );
        assert!(row[3] < row[1], "{row:?}");
    }
}

#[test]
fn mistakes_of_curves() {
    let mistake = |from: &str, to: &str, words: &[&str]| {
        assert!(STUDY.contains(from), "{from}");
        let bench = bench(&STUDY.replacen(from, to, 1));
        bench
            .run(&["verify", "study.toml", "--output", "out"])
            .is_mistake(words);
    };
    mistake(
        "unit = \"degC\",",
        "unit = \"mm\",",
        &["study.toml:17:", "mm"],
    );
    mistake(
        "column = \"y\"",
        "column = \"z\"",
        &["study.toml:14:", "measured.csv", "no column `z`", "t, y, T"],
    );
    mistake(
        "file = \"measured.csv\"",
        "file = \"none.csv\"",
        &["study.toml:14:", "none.csv"],
    );
    mistake(
        "stop = 2",
        "stop = 1",
        &["study.toml:14:", "not within the run", "window"],
    );
    mistake(
        "\"100 ms\"",
        "\"200 ms\"",
        &["study.toml:25:", "delay of 0.2 s", "not within the run"],
    );
    mistake(
        "metric = \"rmse\"",
        "metric = \"rmsd\"",
        &["study.toml:15:", "`rmse`"],
    );
    mistake(
        "tolerance = 0.02",
        "tolerance = 0.02\nnominal = 1",
        &["study.toml:12:", "no place"],
    );
    mistake(
        ", uncertainty = \"0.2 degC\"",
        "",
        &["study.toml:17:", "band"],
    );
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
        bench.write(
            "broken.csv",
            &table.replace(second, &format!("{time},{cell},1,1")),
        );
        bench.write("broken.toml", &STUDY.replace("measured.csv", "broken.csv"));
        let said = bench.run(&["verify", "broken.toml", "--output", "out"]);
        said.is_mistake(&["broken.toml:14:", "broken.csv", words]);
    }
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
    for (study, from) in [
        (begin.to_owned() + &general, 0.0),
        (begin.to_owned() + &windows, 0.0),
        (warm + &windows, 1.0),
    ] {
        let bench = bench(&study);
        verify(&bench);
        let has_own = study.contains("[criteria.W]");
        let names = if has_own {
            &["P", "A", "W"][..]
        } else {
            &["P", "A"]
        };
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
    for (keys, message) in [
        ("statistic = \"percentile\"", "needs `percent`"),
        ("at = \"3 s\"", "not within the run from 0 s to 2 s"),
    ] {
        let study = format!(
            "{begin}[criteria.P]\nvariable = \"lag.y\"\nnominal = 1\ntolerance = 0.1\n{keys}\n"
        );
        let line = 1 + begin.lines().count();
        let said = bench(&study).run(&["verify", "study.toml", "--output", "out"]);
        assert_eq!(said.code, 2);
        assert!(said.err.contains(message), "{}", said.err);
        assert!(
            said.err.contains(&format!("study.toml:{line}:")),
            "{}",
            said.err
        );
    }
}

/// An FMU that ends the simulation before the last row of a reference is not judged by the rows before.
#[test]
fn a_run_that_ends_before_the_reference_fails() {
    let early = STUDY.replace("[design]", "[fixed]\n\"lag.fault\" = \"End\"\n[design]");
    let found = "[criteria.Y]\ndelay = { from = \"-20 ms\", to = \"20 ms\" }";
    for study in [early.clone(), early.replace("[criteria.Y]", found)] {
        let bench = bench(&study);
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
}
