//! How often the stated 95 % intervals hold the truth: 100 simulated records of a decay, also with weak data.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

use super::super::objective::Objective;
use super::super::outcome::IdentificationOutcome;
use super::super::search::search;
use super::super::testing::{decay, effort, measured, problem, settings, unknown_decay};
use super::outcome::PosteriorOutcome;
use super::sample;

/// How many of the truths of some records are in the intervals: of the normal approximation at the best optimum, and of the sample; for
/// each parameter.
fn held(records: u64, accuracy: f64, seed: u64) -> [[u32; 2]; 2] {
    let mut random = StdRng::seed_from_u64(seed);
    let mut held = [[0; 2]; 2];
    for record in 0..records {
        let places = [random.random::<f64>(), random.random()];
        let truth = problem(unknown_decay(), vec![]).free_values(&places);
        let noise = |value: f64, random: &mut StdRng| value + accuracy * random.sample::<f64, _>(StandardNormal);
        let exact = decay(&truth).into_iter();
        let values: Vec<f64> = exact.map(|value| noise(value, &mut random)).collect();
        let problem = problem(unknown_decay(), vec![measured(&values, accuracy)]);
        let model = |_: usize, p: &[f64], _: &[f64]| Ok(decay(p));
        let objective = Objective::new(&problem, &model, 1e-4);
        let starts: Vec<Vec<f64>> = (0..32).map(|_| vec![random.random(), random.random()]).collect();
        let (optima, progress) = search(&objective, &starts, &effort(8, 40), &|_| ()).unwrap();
        let outcome = IdentificationOutcome::new(&problem, &optima, &progress);
        let settings = settings(400, record);
        let sample = sample(&objective, &optima, &settings, &|_, _| ()).unwrap();
        let posterior = PosteriorOutcome::new(&objective, &optima, &sample);
        for k in 0..2 {
            let inside = |[low, high]: &[f64; 2]| (*low..=*high).contains(&truth[k]);
            held[0][k] += u32::from(inside(&outcome.free[k].interval));
            held[1][k] += u32::from(posterior.free[k].intervals.iter().any(inside));
        }
    }
    held
}

/// Of 10 intervals that hold with 95 %, 7 or more hold with a probability of 99.9 %.
#[test]
fn some_intervals_hold_as_often_as_they_say() {
    let held = held(10, 0.1, 12);
    assert!(held.as_flattened().iter().all(|count| *count >= 7), "{held:?}");
}

/// Of 100 intervals that hold with 95 %, 88 or more hold with a probability of 99.9 %.
#[test]
#[ignore = "long: run by scripts/test --long"]
fn intervals_hold_as_often_as_they_say() {
    for (accuracy, seed) in [(0.01, 11), (0.1, 12), (0.5, 13)] {
        let [normal, sampled] = held(100, accuracy, seed);
        println!("accuracy {accuracy}: normal approximation {normal:?}, sample {sampled:?} of 100");
        assert!(sampled.iter().all(|count| *count >= 88), "{sampled:?}");
        assert!(normal.iter().all(|count| *count >= 88), "{normal:?}");
    }
}
