//! How often the stated 95 % intervals hold where the model has a discrepancy of its own: 60 simulated records a setting.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

use super::super::discrepancy::Unknown;
use super::super::objective::Objective;
use super::super::problem::{Problem, Spacing};
use super::super::rounds::{Task, searched};
use super::super::testing::{self, effort, free, measured};
use super::outcome::PosteriorOutcome;
use super::{Settings, sample};

const ACCURACY: f64 = 0.1;

/// One setting: number of cases, and the true discrepancy; one from the prior for each record where there is none.
struct Setting {
    cases: usize,
    discrepancy: Option<f64>,
    seed: u64,
}

/// How many of 60 truths the intervals hold: amplitude and rate in the normal approximation, both in the sample, and the
/// discrepancy in the sample.
#[derive(Debug, Default)]
struct Held {
    normal: [u32; 2],
    sampled: [u32; 2],
    discrepancy: u32,
    told: u32,
}

fn time(case: usize, cases: usize) -> f64 {
    3.0 * (case as f64 + 0.5) / cases as f64
}

fn decay(p: &[f64], time: f64) -> f64 {
    p[0] * (-p[1] * time).exp()
}

fn problem(values: &[f64]) -> Problem {
    let free = vec![free("amplitude", Spacing::Linear, 0.0, 5.0), free("rate", Spacing::Linear, 0.0, 2.0)];
    let cases = values.iter().map(|&value| measured(&[value], ACCURACY));
    testing::problem(free, cases.collect())
}

/// A record: its truths, and what the search and the sample tell of it.
struct Record {
    values: Vec<f64>,
    truth: Vec<f64>,
    discrepancy: f64,
    told: bool,
    /// The normal approximation's intervals.
    normal: [[f64; 2]; 2],
    posterior: PosteriorOutcome,
    /// The discrepancy's median and interval in the sample.
    sampled: (f64, [f64; 2]),
}

fn record(setting: &Setting, random: &mut StdRng, seed: u64) -> Record {
    let places = [random.random::<f64>(), random.random()];
    let truth = problem(&[]).free_values(&places);
    let prior = Unknown { quantity: 0, scale: ACCURACY };
    let drawn = prior.deviation(random.random());
    let discrepancy = setting.discrepancy.unwrap_or(drawn);
    let spread = ACCURACY.hypot(discrepancy);
    let cases = setting.cases;
    let value = |case| {
        let exact = decay(&truth, time(case, cases));
        exact + spread * random.sample::<f64, _>(StandardNormal)
    };
    let values: Vec<f64> = (0..cases).map(value).collect();
    let problem = problem(&values);
    let model = |case: usize, p: &[f64], _: &[f64]| Ok(vec![decay(p, time(case, cases))]);
    let starts = (0..32).map(|_| vec![random.random(), random.random()]);
    let starts: Vec<Vec<f64>> = starts.collect();
    let unknown = [Unknown::of(&problem, 0)];
    let task = Task { problem: &problem, unknown: &unknown, difference: 1e-4, starts: &starts, effort: effort(8, 40) };
    let searched = searched(&task, &model, &|_| ()).unwrap();
    let outcome = searched.outcome();
    let known = [(unknown[0], searched.discrepancies[0].deviation)];
    let settings = Settings { discrepancies: &known, ..testing::settings(400, seed) };
    let objective = Objective::new(&problem, &model, 1e-4);
    let sample = sample(&objective, &searched.optima, &settings, &|_, _| ()).unwrap();
    Record {
        truth,
        discrepancy,
        told: searched.discrepancies[0].told,
        normal: [0, 1].map(|k| outcome.free[k].interval),
        posterior: PosteriorOutcome::new(&objective, &searched.optima, &sample),
        sampled: PosteriorOutcome::discrepancy(&problem, &sample, &unknown[0], 0),
        values,
    }
}

fn held(setting: &Setting) -> Held {
    let mut random = StdRng::seed_from_u64(setting.seed);
    let mut held = Held::default();
    for number in 0..60 {
        let record = record(setting, &mut random, number);
        held.told += u32::from(record.told);
        for (k, truth) in record.truth.iter().enumerate() {
            let inside = |[low, high]: &[f64; 2]| (*low..=*high).contains(truth);
            held.normal[k] += u32::from(inside(&record.normal[k]));
            let sampled = &record.posterior.free[k].intervals;
            held.sampled[k] += u32::from(sampled.iter().any(inside));
        }
        let (_, [low, high]) = record.sampled;
        held.discrepancy += u32::from((low..=high).contains(&record.discrepancy));
    }
    held
}

/// Mean and standard deviation of amplitude and rate, by sums over a grid of all three unknowns.
fn on_a_grid(values: &[f64]) -> [[f64; 2]; 2] {
    const CELLS: [usize; 3] = [200, 160, 60];
    let middle = |k: usize, axis: usize| (k as f64 + 0.5) / CELLS[axis] as f64;
    let prior = Unknown { quantity: 0, scale: ACCURACY };
    let variances = (0..CELLS[2]).map(|k| prior.deviation(middle(k, 2)).powi(2));
    let variances: Vec<f64> = variances.map(|variance| variance + ACCURACY * ACCURACY).collect();
    let mut sums = [[0.0; 3]; 2];
    for i in 0..CELLS[0] {
        for j in 0..CELLS[1] {
            let p = problem(&[]).free_values(&[middle(i, 0), middle(j, 1)]);
            let misfits = values.iter().enumerate();
            let misfits = misfits.map(|(case, value)| decay(&p, time(case, values.len())) - value);
            let squares: f64 = misfits.map(|misfit| misfit * misfit).sum();
            let density =
                |variance: &f64| (-0.5 * squares / variance).exp() * variance.powf(-0.5 * values.len() as f64);
            let density: f64 = variances.iter().map(density).sum();
            for (sums, value) in sums.iter_mut().zip(p) {
                for (power, sum) in sums.iter_mut().enumerate() {
                    *sum += density * value.powi(power as i32);
                }
            }
        }
    }
    sums.map(|[all, first, second]| {
        let mean = first / all;
        [mean, (second / all - mean * mean).sqrt()]
    })
}

/// Where the true discrepancy is five times the accuracy, the sample is still that of the exact posterior.
#[test]
fn the_sample_is_the_posterior_on_a_grid() {
    let setting = Setting { cases: 12, discrepancy: Some(0.5), seed: 24 };
    let mut random = StdRng::seed_from_u64(setting.seed);
    for number in 0..3 {
        let record = record(&setting, &mut random, number);
        let exact = on_a_grid(&record.values);
        let draws = record.posterior.effective;
        for (marginal, [mean, deviation]) in record.posterior.free.iter().zip(exact) {
            let off = (marginal.mean - mean) / deviation * draws.sqrt();
            assert!(off.abs() < 4.0, "record {number}, {}: {off}", marginal.name);
            // A standard deviation of so many draws scatters by about 4 %.
            let ratio = marginal.deviation / deviation;
            assert!((0.82..1.22).contains(&ratio), "record {number}, {}: {ratio}", marginal.name);
        }
    }
}

/// Of 60 intervals that hold with 95 %, 51 to 60 hold with a probability of 99.9 %. That is promised over truths from the
/// prior. With a discrepancy of always five times the accuracy the exact posterior's intervals hold in 93 to 94 %; of 60
/// such, 48 to 60 hold with a probability of 99.9 %.
fn intervals_hold(settings: &[(usize, Option<f64>, u64)]) {
    for &(cases, discrepancy, seed) in settings {
        let held = held(&Setting { cases, discrepancy, seed });
        println!("{cases} cases, discrepancy {discrepancy:?}: {held:?} of 60");
        let least = if discrepancy.is_none() { 51 } else { 48 };
        assert!(held.sampled.iter().all(|count| *count >= least), "{held:?}");
        assert!(held.discrepancy >= least, "{held:?}");
    }
}

#[test]
#[ignore = "takes a minute: scripts/test --long"]
fn intervals_hold_with_an_unknown_discrepancy() {
    intervals_hold(&[(4, None, 22), (12, None, 21), (12, Some(0.5), 23)]);
}
