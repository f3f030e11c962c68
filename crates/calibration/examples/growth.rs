//! Fits a saturating growth to five measured values and prints what the data tell, in words.

use calibration::objective::Objective;
use calibration::outcome::IdentificationOutcome;
use calibration::problem::{Case, Free, Problem, Quantity, Spacing, UncertainValue};
use calibration::search::{Effort, SearchError, search};
use calibration::text;

const TIMES: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 16.0];
const LEVELS: [f64; 5] = [1.9, 3.4, 5.4, 7.3, 8.0];

fn growth(case: usize, p: &[f64], _: &[f64]) -> Result<Vec<f64>, String> {
    Ok(vec![p[0] * (1.0 - (-TIMES[case] / p[1]).exp())])
}

fn main() -> Result<(), SearchError> {
    let free = |name: &str, min: f64, max: f64| Free {
        name: name.into(),
        unit: None,
        scale: Spacing::Log,
        min,
        max,
        prior: None,
    };
    let case = |(time, level): (&f64, &f64)| Case {
        label: format!("{time} s"),
        latents: Vec::new(),
        measured: vec![UncertainValue { value: *level, accuracy: 0.1 }],
    };
    let problem = Problem {
        free: vec![free("final level", 1.0, 100.0), free("time constant", 0.1, 100.0)],
        quantities: vec![Quantity { name: "level".into(), unit: None }],
        cases: TIMES.iter().zip(&LEVELS).map(case).collect(),
        ..Problem::default()
    };
    let objective = Objective::new(&problem, &growth, 1e-4);
    let starts: Vec<Vec<f64>> = (1..16).map(|k| vec![f64::from(k) / 16.0, (f64::from(k) * 0.618).fract()]).collect();
    let effort = Effort { descents: 4, iterations: 60 };
    let (optima, progress) = search(&objective, &starts, &effort, &|_| ())?;
    let outcome = IdentificationOutcome::new(&problem, &optima, &progress);
    for free in &outcome.free {
        let [low, high] = free.interval;
        println!("{}: {:.3} ({low:.3} .. {high:.3}, 95 %)", free.name, free.value);
    }
    println!("{}", text::open(&outcome).join("\n"));
    Ok(())
}
