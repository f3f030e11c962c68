//! Surrogates against models whose values are known everywhere.

use std::cell::Cell;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use sampling::design::cube;

use super::super::problem::{Free, Interval, Query, Spacing};
use super::super::sample::outcome::PosteriorOutcome;
use super::super::testing::{decay, effort, free, measured, named, problem, settings, unknown_decay};
use super::*;

/// Surrogates of a model from so many runs.
fn made(problem: &Problem, model: &dyn Simulate, runs: usize, seed: u64) -> Result<Replaced, SearchError> {
    let unknowns = problem.unknowns();
    let spread = |count: usize, round: u64| cube(unknowns, count as u64, 1000 * seed + round, 1).unwrap();
    let starts = spread(64, 99);
    let search = search(problem, &starts);
    let task = Task { search, runs, spread: &spread, seed };
    replaced(&task, model, &|_| ())
}

fn search<'a>(problem: &'a Problem, starts: &'a [Vec<f64>]) -> rounds::Task<'a> {
    rounds::Task { problem, difference: 1e-3, starts, effort: effort(8, 40) }
}

/// A model with unknowns, whose values are measured.
struct Trial {
    unknown: fn() -> Vec<Free>,
    model: fn(&[f64]) -> Vec<f64>,
    accuracy: f64,
    /// At most so many runs.
    runs: usize,
}

const DECAY: Trial = Trial { unknown: unknown_decay, model: decay, accuracy: 0.01, runs: 30 };

/// How many of so many truths are in the sample's intervals, for each parameter; and the mean number of runs.
fn held(trial: &Trial, records: u64, seed: u64) -> (Vec<u32>, f64) {
    let mut random = StdRng::seed_from_u64(seed);
    let unknowns = (trial.unknown)().len();
    let mut held = vec![0; unknowns];
    let asked = Cell::new(0_u64);
    for record in 0..records {
        let places: Vec<f64> = (0..unknowns).map(|_| random.random()).collect();
        let truth = problem((trial.unknown)(), vec![]).free_values(&places);
        let noise = |value: f64| value + trial.accuracy * random.sample::<f64, _>(StandardNormal);
        let values: Vec<f64> = (trial.model)(&truth).into_iter().map(noise).collect();
        let values = measured(&values, trial.accuracy);
        let problem = problem((trial.unknown)(), vec![values]);
        let model = |_: usize, p: &[f64], _: &[f64]| {
            asked.set(asked.get() + 1);
            Ok((trial.model)(p))
        };
        let replaced = made(&problem, &model, trial.runs, record).unwrap();
        let starts = cube(unknowns, 64, record, 1).unwrap();
        let task = search(&replaced.problem, &starts);
        let searched = searched(&task, &replaced.model, &|_| ()).unwrap();
        let objective = Objective::new(&replaced.problem, &replaced.model, 1e-3);
        let settings = settings(400, record);
        let sample = sample(&objective, &searched.optima, &settings, &|_, _| ()).unwrap();
        let posterior = PosteriorOutcome::new(&objective, &searched.optima, &sample);
        for k in 0..unknowns {
            let inside = |[low, high]: &[f64; 2]| (*low..=*high).contains(&truth[k]);
            held[k] += u32::from(posterior.free[k].intervals.iter().any(inside));
        }
    }
    (held, asked.get() as f64 / records as f64)
}

/// Of 4 intervals that hold with 95 %, 2 to 4 hold with a probability of 99.95 %. With few runs the surrogates are rough, and
/// the intervals have to tell.
#[test]
fn intervals_on_rough_surrogates_hold() {
    let (held, _) = held(&DECAY, 4, 22);
    assert!(held.iter().all(|count| *count >= 2), "{held:?}");
}

/// A figure of docs/evidence/coverage.md. Of 60 intervals that hold with 95 %, 51 to 60 hold with a probability of 99.9 %.
fn row(accuracy: f64, runs: usize, seed: u64) {
    let trial = Trial { accuracy, runs, ..DECAY };
    let (held, asked) = held(&trial, 60, seed);
    println!("accuracy {accuracy}, at most {runs} runs: {held:?} of 60, {asked:.0} runs each");
    assert!(held.iter().all(|count| *count >= 51), "{held:?}");
    assert!(asked <= runs as f64);
}

#[test]
#[ignore = "takes minutes"]
fn intervals_on_surrogates_hold_with_good_data() {
    row(0.01, 80, 21);
}

#[test]
#[ignore = "takes minutes"]
fn intervals_on_surrogates_hold_though_they_are_rough() {
    row(0.01, 30, 22);
}

#[test]
#[ignore = "takes minutes"]
fn intervals_on_surrogates_hold_with_weak_data() {
    row(0.1, 60, 23);
    row(0.5, 60, 24);
}

/// Figures of docs/evidence/coverage.md for what no polynomial follows: intervals of 95 % that hold less, by how
/// much is what they print.
#[test]
#[ignore = "takes minutes"]
fn kinks_and_jumps() {
    let jump = Trial {
        unknown: || vec![free("x", Spacing::Linear, 0.0, 1.0)],
        model: |p| vec![p[0] + f64::from(u8::from(p[0] > 0.437))],
        accuracy: 0.02,
        runs: 30,
    };
    let ridge = Trial {
        unknown: || ["x1", "x2"].map(|x| free(x, Spacing::Linear, 0.0, 1.0)).to_vec(),
        model: |p| vec![1.0 / (1.0 + (-200.0 * (p[0] + p[1] / 2.0 - 0.7)).exp())],
        accuracy: 0.05,
        runs: 60,
    };
    for (name, trial) in [("jump", jump), ("steep ridge", ridge)] {
        let (held, asked) = held(&trial, 240, 31);
        println!("{name}: {held:?} of 240, {asked:.0} runs each");
        // The docs promise no more: of 240 that hold with 90 %, 201 or more do with a probability of 99.9 %.
        assert!(held.iter().all(|count| *count >= 201), "{held:?}");
    }
}

#[test]
fn the_error_counted_is_that_of_the_posterior() {
    let truth = [1.2, 0.7];
    let problem = problem(unknown_decay(), vec![measured(&decay(&truth), 0.02)]);
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(decay(p));
    let replaced = made(&problem, &model, 100, 5).unwrap();
    assert!(replaced.told.rounds > 1 && replaced.told.checked > 10, "{:?}", replaced.told);
    assert!(replaced.told.largest < 0.2, "{:?}", replaced.told);
    // Places near the truth, about two deviations wide.
    let mut random = StdRng::seed_from_u64(3);
    let mut squares = [0.0; 6];
    for _ in 0..200 {
        let mut near = |value: f64, width: f64| value * (1.0 + width * (random.random::<f64>() - 0.5));
        let free = vec![near(truth[0], 0.08), near(truth[1], 0.12)];
        let query = Query { case: 0, free: free.clone(), latents: Vec::new() };
        let ours = replaced.model.simulate(&[query]).unwrap().remove(0).unwrap();
        for (square, (a, b)) in squares.iter_mut().zip(ours.iter().zip(decay(&free))) {
            *square += (a - b).powi(2) / 200.0;
        }
    }
    for (square, stated) in squares.iter().zip(&replaced.told.errors[0]) {
        assert!(square.sqrt() <= 2.0 * stated.counted, "{} {stated:?}", square.sqrt());
    }
}

/// A wave of half a dozen bends from few runs: no polynomial follows it, and the error counted says so.
#[test]
fn what_cannot_be_followed_is_said() {
    let wave = |_: usize, p: &[f64], _: &[f64]| Ok(vec![(20.0 * p[0]).sin()]);
    let unknown = vec![free("x", Spacing::Linear, 0.0, 3.0)];
    let problem = problem(unknown, vec![measured(&[0.3], 0.02)]);
    let replaced = made(&problem, &wave, 24, 1).unwrap();
    assert!(replaced.told.largest > 5.0, "{:?}", replaced.told);
    assert!(text::sentences(&replaced.told).concat().contains("--surrogate 48"));
}

#[test]
fn errors_that_go_together_count_more() {
    // Six values that miss by the same bend tell no more than one does.
    let bent = |_: usize, p: &[f64], _: &[f64]| Ok(vec![(9.0 * p[0]).sin() + p[0]; 6]);
    let unknown = vec![free("x", Spacing::Linear, 0.0, 3.0)];
    let problem = problem(unknown, vec![measured(&[0.3; 6], 0.5)]);
    let replaced = made(&problem, &bent, 24, 1).unwrap();
    assert!((replaced.told.together - 6.0).abs() < 1e-6, "{}", replaced.told.together);
}

#[test]
fn latent_parameters_of_several_cases_have_surrogates_of_their_own() {
    let model =
        |case: usize, p: &[f64], latent: &[f64]| Ok(vec![p[0] * (1.0 + case as f64) / latent[0], p[0] * latent[0]]);
    let values = (0..4).map(|case| measured(&[2.0 * (1.0 + f64::from(case)), 2.0], 0.05));
    let mut problem = problem(vec![free("p", Spacing::Log, 1.0, 4.0)], values.collect());
    problem.latents = vec![named("c")];
    for case in &mut problem.cases {
        case.latents = vec![Interval { min: 0.8, max: 1.2 }];
    }
    let replaced = made(&problem, &model, 80, 2).unwrap();
    // The rounds ended before the runs were spent, so the errors left out widen no accuracy by more than `SMALL`.
    assert!(replaced.told.runs < 80, "{:?}", replaced.told);
    let part = ((1.0 + SMALL).powi(2) - 1.0).sqrt();
    for error in replaced.told.errors.iter().flatten() {
        let left_out = replaced.told.together.sqrt() * error.leave_one_out;
        assert!(left_out <= part * error.accuracy, "{error:?}");
        // The root mean square of twelve fresh runs scatters by a fifth about the true one.
        assert!(error.counted <= 2.0 * part * error.accuracy, "{error:?}");
    }
    let query = Query { case: 2, free: vec![2.0], latents: vec![1.1] };
    let predicted = replaced.model.simulate(&[query]).unwrap().remove(0).unwrap();
    let pairs = predicted.iter().zip([6.0 / 1.1, 2.2]);
    for ((predicted, exact), error) in pairs.zip(&replaced.told.errors[2]) {
        let off = (predicted - exact).abs();
        assert!(off <= 4.0 * error.counted, "{off} {error:?}");
    }
}

/// Stripes so narrow that no run tells of its neighbours: what the fresh runs meet is told.
#[test]
fn a_sample_at_which_the_model_fails_is_told() {
    let stripes = |_: usize, p: &[f64], _: &[f64]| match (500.0 * p[0]).fract() < 0.4 {
        true => Ok(vec![p[0]]),
        false => Err("too thin".to_owned()),
    };
    let unknown = vec![free("x", Spacing::Linear, 0.0, 1.0)];
    let problem = problem(unknown, vec![measured(&[0.4], 0.1)]);
    let told = made(&problem, &stripes, 60, 1).unwrap().told;
    assert!(told.check_failed > 0, "{told:?}");
    let text = text::sentences(&told).join("\n");
    assert!(text.contains("intervals of the sample do not hold"), "{text}");
}

#[test]
fn where_the_nearest_run_failed_there_is_no_surrogate() {
    let holed = |_: usize, p: &[f64], _: &[f64]| match p[0] > 2.4 && p[1] > 0.5 {
        true => Err("too thin".to_owned()),
        false => Ok(vec![p[0] + p[1]]),
    };
    let unknown = vec![free("x", Spacing::Linear, 0.0, 3.0), free("y", Spacing::Linear, 0.0, 1.0)];
    let problem = problem(unknown, vec![measured(&[1.0], 0.05)]);
    let replaced = made(&problem, &holed, 80, 1).unwrap();
    let at = |x: f64, y: f64| {
        let query = Query { case: 0, free: vec![x, y], latents: Vec::new() };
        replaced.model.simulate(&[query]).unwrap().remove(0)
    };
    assert_eq!(at(2.8, 0.9), Err("too thin".to_owned()));
    assert!((at(0.5, 0.5).unwrap()[0] - 1.0).abs() < 1e-6);
    assert!(replaced.failures.failed > 0 && replaced.screened.iter().any(|ended| !ended));
    let never = |_: usize, _: &[f64], _: &[f64]| Err("too thin".to_owned());
    let error = made(&problem, &never, 80, 1).err().unwrap().to_string();
    assert!(error.contains("too few") && error.contains("too thin"), "{error}");
}
