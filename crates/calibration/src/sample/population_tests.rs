//! A parameter that varies from specimen to specimen, with cheap models: how often mean, spread and values are held, and
//! a single data set against an integration on a grid.

use super::super::objective::Objective;
use super::super::problem::{Population, Prediction, Prior, Problem, Spacing};
use super::super::testing::{free, one_case, settings};
use super::outcome::PosteriorOutcome;
use super::{Sample, sample};
use sampling::random::{Purpose, Random};
use statrs::distribution::{ContinuousCDF, Normal};

/// Specimens with clearances between 5 and 35 um, about 20 +- 5 um before the measurement, each measured to `accuracy`.
fn specimens(values: &[f64], accuracy: f64) -> Problem {
    let measured: Vec<(f64, f64)> = values.iter().map(|&value| (value, accuracy)).collect();
    let mut problem = one_case(&[], &measured);
    problem.free = (0..values.len())
        .map(|case| {
            let mut free = free(&format!("{case}/c"), Spacing::Linear, -5.0, 45.0);
            free.prior = Some(Prior { centre: 20.0, spread: 5.0 });
            free
        })
        .collect();
    problem.populations = vec![Population { name: "c".to_owned(), members: (0..values.len()).collect() }];
    problem
}

fn sampled(problem: &Problem, particles: u64, seed: u64) -> (Sample, PosteriorOutcome) {
    let model = |_: usize, p: &[f64], _: &[f64]| -> Prediction { Ok(p.to_vec()) };
    let objective = Objective::new(problem, &model, 1e-5);
    let sample = sample(&objective, &[], &settings(particles, seed), &|_, _| ()).unwrap();
    let outcome = PosteriorOutcome::new(&objective, &[], &sample);
    (sample, outcome)
}

/// Mean and standard deviation of the population's mean and spread by the midpoint rule on a grid. The values are integrated out
/// in closed form: each measured value is normal about the mean with the squares of spread and accuracy added, times the part of
/// the true value's distribution that lies within its bounds, over that before the measurement.
fn on_grid(values: &[f64], accuracy: f64) -> [[f64; 2]; 2] {
    let normal = Normal::standard();
    let within =
        |mean: f64, deviation: f64| normal.cdf((45.0 - mean) / deviation) - normal.cdf((-5.0 - mean) / deviation);
    let mut sums = [0.0; 5];
    for i in 0..200 {
        let mean = 5.0 + 30.0 * (f64::from(i) + 0.5) / 200.0;
        for k in 0..500 {
            let spread = 25.0 * (f64::from(k) + 0.5) / 500.0;
            let variance = spread * spread + accuracy * accuracy;
            let before = within(mean, spread);
            let misfit = values.iter().map(|y| {
                let told = spread * spread / variance;
                let after = within(mean + told * (y - mean), accuracy * told.sqrt());
                (y - mean).powi(2) / variance + variance.ln() - 2.0 * (after / before).ln()
            });
            let squares = misfit.sum::<f64>() + ((mean - 20.0) / 5.0).powi(2) + (spread / 5.0).powi(2);
            let density = (-0.5 * squares).exp();
            for (sum, power) in sums.iter_mut().zip([1.0, mean, mean * mean, spread, spread * spread]) {
                *sum += density * power;
            }
        }
    }
    let [all, m, mm, s, ss] = sums;
    [[m, mm], [s, ss]].map(|[first, second]| {
        let mean = first / all;
        [mean, (second / all - mean * mean).sqrt()]
    })
}

/// Eight specimens with clearances of about 20 um and a spread.
fn drawn(spread: f64, accuracy: f64, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut random = Random::new(seed, Purpose::Search, 1);
    let truths: Vec<f64> = (0..8).map(|_| 20.0 + spread * random.normal()).collect();
    let measured = truths.iter().map(|truth| truth + accuracy * random.normal());
    let measured = measured.collect();
    (truths, measured)
}

#[test]
fn mean_and_spread_are_about_those_of_an_integration() {
    // A quarter of the particles has twice the error.
    as_integrated(1000, 0.1, &[(2.0, 2)]);
}

/// Data that say much of each value, about as much as the spread, and little.
#[test]
#[ignore = "long: run by scripts/test --long"]
fn mean_and_spread_are_those_of_an_integration() {
    as_integrated(4000, 0.05, &[(0.2, 1), (2.0, 2), (6.0, 3)]);
}

fn as_integrated(particles: u64, tolerance: f64, data: &[(f64, u64)]) {
    for &(accuracy, seed) in data {
        let (_, values) = drawn(2.0, accuracy, seed);
        let exact = on_grid(&values, accuracy);
        let (sample, outcome) = sampled(&specimens(&values, accuracy), particles, seed);
        let population = &outcome.populations[0];
        println!(
            "accuracy {accuracy}: exact {exact:?}, effective {}, stages {}, evaluated {} {:?}",
            outcome.effective,
            sample.stages.len(),
            sample.evaluated,
            outcome.doubts
        );
        for ([mean, deviation], marginal) in exact.iter().zip([&population.mean, &population.spread]) {
            println!("  {} +- {}", marginal.mean, marginal.deviation);
            assert!((marginal.mean - mean).abs() < tolerance * mean.min(2.0 * deviation), "{accuracy}");
            assert!((marginal.deviation / deviation - 1.0).abs() < tolerance, "{accuracy}");
        }
        assert!(outcome.trusted);
    }
}

/// Of 2 intervals that hold with 95 %, 1 or 2 hold with a probability of 99.7 %; of 16, 13 or more with 99 %.
#[test]
fn some_intervals_of_mean_spread_and_values_hold() {
    let [means, spreads, all] = held(2, 200);
    assert!(means >= 1 && spreads >= 1 && all >= 13, "{means} {spreads} {all}");
}

/// Of 20 intervals that hold with 95 %, 17 to 20 hold with a probability of 98 %; of 160, 144 or more with 99.8 %.
#[test]
#[ignore = "long: run by scripts/test --long"]
fn intervals_of_mean_spread_and_values_hold() {
    let [means, spreads, all] = held(20, 1000);
    println!("mean {means}, spread {spreads} of 20; values {all} of 160");
    assert!(means >= 17 && spreads >= 17 && all >= 144, "{means} {spreads} {all}");
}

/// How many intervals of mean and spread hold, of as many as there are seeds, and of eight values each.
fn held(seeds: u64, particles: u64) -> [u32; 3] {
    let (mut means, mut spreads, mut all) = (0, 0, 0);
    for seed in 1..=seeds {
        let (truths, values) = drawn(2.0, 0.5, 100 + seed);
        let (_, outcome) = sampled(&specimens(&values, 0.5), particles, seed);
        let inside = |intervals: &[[f64; 2]], truth: f64| {
            u32::from(intervals.iter().any(|[low, high]| (*low..=*high).contains(&truth)))
        };
        let population = &outcome.populations[0];
        means += inside(&population.mean.intervals, 20.0);
        spreads += inside(&population.spread.intervals, 2.0);
        let pairs = outcome.free.iter().zip(&truths);
        all += pairs.map(|(free, &truth)| inside(&free.intervals, truth)).sum::<u32>();
    }
    [means, spreads, all]
}
