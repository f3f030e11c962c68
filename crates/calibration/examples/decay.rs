//! Amplitude and rate of a decay, from five measured values.

use calibration::objective::Objective;
use calibration::problem::{Case, Free, Measured, Problem, Quantity, Spacing};
use calibration::search::{Effort, search};

fn decay(case: usize, p: &[f64], _: &[f64]) -> Result<Vec<f64>, String> {
    Ok(vec![p[0] * (-p[1] * case as f64).exp()])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let free =
        |name: &str, min, max| Free { name: name.into(), unit: None, scale: Spacing::Linear, min, max, prior: None };
    let measured = [10.1, 5.9, 3.75, 2.2, 1.4].map(|value| Measured { value, accuracy: 0.1 });
    let case = |(k, value): (usize, Measured)| Case { label: format!("{k} s"), latents: vec![], measured: vec![value] };
    let problem = Problem {
        free: vec![free("amplitude", 1.0, 20.0), free("rate", 0.01, 2.0)],
        quantities: vec![Quantity { name: "level".into(), unit: None }],
        cases: measured.into_iter().enumerate().map(case).collect(),
        ..Problem::default()
    };
    let objective = Objective::new(&problem, &decay, 1e-4);
    let starts: Vec<Vec<f64>> = (1..8).map(|k| vec![k as f64 / 8.0, 1.0 - k as f64 / 8.0]).collect();
    let effort = Effort { descents: 3, iterations: 50, deadline: None };

    let (optima, _) = search(&objective, &starts, &effort, &|_| ())?;
    let best = &optima[0];
    let found = problem.free_values(&best.minimum.places);
    let deviation = problem.free[1].spread(best.posterior.deviation(1));
    println!("rate {:.3} +- {:.3}", found[1], deviation);
    assert!((found[1] - 0.5).abs() < 3.0 * deviation);
    Ok(())
}
