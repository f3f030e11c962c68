//! Bands of published functions at points that were not run.

use run_budget::{Run, Surrogate};
use sampling::design::cube;

/// Output voltage of a push-pull circuit without transformer, 6 parameters (Ben-Ari & Steinberg 2007, "Modeling data from
/// computer experiments", Quality Engineering 19, 327-338), from the unit cube.
fn circuit(u: &[f64]) -> f64 {
    let x = |k: usize, low: f64, high: f64| low + (high - low) * u[k];
    let (b1, b2, f) = (x(0, 50.0, 150.0), x(1, 25.0, 70.0), x(2, 0.5, 3.0));
    let (c1, c2, gain) = (x(3, 1.2, 2.5), x(4, 0.25, 1.2), x(5, 50.0, 300.0));
    let base = 12.0 * b2 / (b1 + b2);
    let turned = gain * (c2 + 9.0);
    ((base + 0.74) * turned + 11.35 * f) / (turned + f) + 0.74 * f * turned / ((turned + f) * c1)
}

/// Ishigami & Homma (1990), from the unit cube.
fn ishigami(u: &[f64]) -> f64 {
    let x: Vec<f64> = u.iter().map(|v| std::f64::consts::PI * (2.0 * v - 1.0)).collect();
    x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
}

/// A jump of 2 at a slanted edge.
fn jump(u: &[f64]) -> f64 {
    u[0] + u[1] * u[2] + if u[0] + 0.5 * u[1] > 0.8 { 2.0 } else { 0.0 }
}

type Model = fn(&[f64]) -> f64;

/// Root mean square error over the output's deviation, and the part of new points that the 95 % band holds.
fn tried(model: Model, dimensions: usize, runs: u64, seed: u64) -> [f64; 2] {
    let points = cube(dimensions, runs, seed, 1).expect("the function has such a net and such runs");
    let run = |point: Vec<f64>| Run { values: Some(vec![model(&point)]), point };
    let runs: Vec<Run> = points.into_iter().map(run).collect();
    let others = cube(dimensions, 1024, seed + 1000, 1).expect("the function has such a net and such runs");
    let surrogate = Surrogate::fit(&runs, &others, None, seed).expect("the function has such a net and such runs");
    let truth: Vec<f64> = others.iter().map(|point| model(point)).collect();
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    let spread = truth.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
    let predicted = surrogate.predict(0, &others);
    let pairs = || truth.iter().zip(&predicted);
    let error = pairs().map(|(t, [m, _])| (t - m).powi(2)).sum::<f64>();
    let held = pairs().filter(|(t, [m, s])| (*t - m).abs() <= 1.96 * s).count();
    [(error / spread).sqrt(), held as f64 / truth.len() as f64]
}

#[test]
fn a_smooth_function_is_followed_within_its_band() {
    let [error, held] = tried(circuit, 6, 50, 1);
    assert!(error < 0.03 && held > 0.9, "{error} {held}");
}

/// Prints error and coverage: `cargo test -p run-budget --release --test bands -- --ignored --nocapture`.
#[test]
#[ignore = "takes 15 s of CPU"]
fn bands_hold_on_published_functions() {
    let models: [(&str, Model, usize); 3] = [("circuit", circuit, 6), ("ishigami", ishigami, 3), ("jump", jump, 3)];
    for (name, model, dimensions) in models {
        for runs in [50, 100, 200] {
            let seeds = 5;
            let (mut error, mut held, mut least) = (0.0, 0.0, 1.0_f64);
            for seed in 1..=seeds {
                let [e, h] = tried(model, dimensions, runs, seed);
                error += e / seeds as f64;
                held += h / seeds as f64;
                least = least.min(h);
            }
            println!(
                "{name:10} {runs:4} runs: error {error:.4}, held {:.1} %, least {:.1} %",
                100.0 * held,
                100.0 * least
            );
        }
    }
}
