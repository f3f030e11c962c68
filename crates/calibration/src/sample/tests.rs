//! Samples against exact posteriors: a linear model's, one with six modes, and a curved valley.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, Normal};

use super::super::local::minimise;
use super::super::objective::{Differences, Objective};
use super::super::optima::{Optima, Optimum};
use super::super::problem::{Interval, Prediction, Prior, Problem, Simulate};
use super::super::testing::{limits, named, one_case, settings};
use super::{Sample, SampleError, Settings, sample};
use super::{evidence::Evidence, outcome::PosteriorOutcome};

/// The optima below some starts.
fn optima(objective: &Objective, starts: &[Vec<f64>]) -> Vec<Optimum> {
    let limits = limits(100, 1e-8);
    let mut optima = Optima::new(objective, limits);
    for start in starts {
        let near = minimise(objective, start.clone(), &[], Differences::Central, &limits).unwrap();
        optima.add(&near).unwrap();
    }
    optima.weighed()
}

fn sampled(problem: &Problem, model: &dyn Simulate, starts: &[Vec<f64>], seed: u64) -> (Sample, PosteriorOutcome) {
    let objective = Objective::new(problem, model, 1e-5);
    let optima = optima(&objective, starts);
    let settings = settings(1000, seed);
    let sample = sample(&objective, &optima, &settings, &|_, _| ()).unwrap();
    let outcome = PosteriorOutcome::new(&objective, &optima, &sample);
    (sample, outcome)
}

/// Three parameters, four measured values, one prior; correlated posterior.
fn linear() -> (Problem, DMatrix<f64>) {
    let measured = [(2.1, 0.05), (1.2, 0.1), (0.3, 0.08), (1.9, 0.2)];
    let mut problem = one_case(&[(-5.0, 5.0), (-5.0, 5.0), (-5.0, 5.0)], &measured);
    problem.free[2].prior = Some(Prior { centre: 0.4, spread: 0.3 });
    let rows = [1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, -1.0, 0.0, 0.5, 1.0, 2.0];
    (problem, DMatrix::from_row_slice(4, 3, &rows))
}

/// Mean, covariance and the logarithm of the evidence of a linear model.
fn exact(problem: &Problem, a: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>, f64) {
    let measured = &problem.cases[0].measured;
    let weight = DMatrix::from_diagonal(&DVector::from_iterator(4, measured.iter().map(|m| m.accuracy.powi(-2))));
    let y = DVector::from_iterator(4, measured.iter().map(|m| m.value));
    let mut precision = a.transpose() * &weight * a;
    let mut right = a.transpose() * &weight * &y;
    let prior = problem.free[2].prior.unwrap();
    precision[(2, 2)] += prior.spread.powi(-2);
    right[2] += prior.centre / prior.spread.powi(2);
    let covariance = precision.clone().try_inverse().unwrap();
    let mean = &covariance * right;
    // The evidence is the density of prior and likelihood over that of the posterior, at any place.
    let tau = std::f64::consts::TAU;
    let misfit = a * &mean - &y;
    let normal = |squares: f64, deviation: f64| -0.5 * squares - deviation.ln() - 0.5 * tau.ln();
    let likelihood: f64 =
        (0..4).map(|k| normal((misfit[k] / measured[k].accuracy).powi(2), measured[k].accuracy)).sum();
    let before = normal(((mean[2] - prior.centre) / prior.spread).powi(2), prior.spread);
    let uniform = -2.0 * 10.0_f64.ln();
    let posterior = -0.5 * (3.0 * tau.ln() + covariance.determinant().ln());
    let evidence = likelihood + before + uniform - posterior;
    (mean, covariance, evidence)
}

#[test]
fn a_linear_models_posterior_is_the_exact_one() {
    let (problem, a) = linear();
    let (mean, covariance, evidence) = exact(&problem, &a);
    let model = |_: usize, p: &[f64], _: &[f64]| -> Prediction {
        let y = &a * DVector::from_column_slice(p);
        Ok(y.iter().copied().collect())
    };
    for starts in [vec![vec![0.5; 3]], Vec::new()] {
        let (sample, outcome) = sampled(&problem, &model, &starts, 1);
        assert!(outcome.trusted, "{:?}", outcome.doubts);
        let n = outcome.effective;
        assert!(n > 200.0, "{n}");
        for k in 0..3 {
            // Four standard errors of as many independent draws as the sample says that it is worth.
            let deviation = covariance[(k, k)].sqrt();
            let marginal = &outcome.free[k];
            let error = (marginal.mean - mean[k]) / deviation * n.sqrt();
            assert!(error.abs() < 4.0, "{k}: {error}");
            let ratio = (marginal.deviation / deviation - 1.0) * (2.0 * n).sqrt();
            assert!(ratio.abs() < 4.0, "{k}: {ratio}");
            for l in 0..k {
                let exact = covariance[(k, l)] / (deviation * covariance[(l, l)].sqrt());
                let error = (outcome.correlations[k][l] - exact) / (1.0 - exact * exact) * n.sqrt();
                assert!(error.abs() < 4.0, "{k} {l}: {error}");
            }
            assert_eq!(marginal.intervals.len(), 1);
        }
        let told = Evidence::new(&problem, &sample, outcome.trusted);
        let error = (told.log - evidence) / told.error;
        assert!(error.abs() < 4.0, "{error}");
        assert!(told.error < 0.1, "{outcome:?}");
        assert_eq!(outcome.evaluated, evaluations(&sample, &outcome));
    }
}

/// Places outside of the bounds are not run; here none of the moves leaves them.
fn evaluations(sample: &Sample, outcome: &PosteriorOutcome) -> u64 {
    let moves: usize = outcome.stages.iter().map(|stage| stage.moves).sum();
    let all = (sample.particles.len() * (moves + 2)) as u64;
    assert!(outcome.evaluated <= all && outcome.evaluated > all / 2);
    outcome.evaluated
}

/// sin(6 x) + 0.3 x = 0.5 +- 0.02 on [0.1, 3.1]: the parts of the six solutions by the trapezoidal rule.
#[test]
fn six_modes_have_their_parts_and_an_interval_each() {
    let problem = one_case(&[(0.1, 3.1)], &[(0.5, 0.02)]);
    let wave = |x: f64| (6.0 * x).sin() + 0.3 * x;
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![wave(p[0])]);
    let edges = [0.1, 0.77, 1.32, 1.82, 2.37, 2.87, 3.1];
    let grid = (0..=300_000).map(|k| 0.1 + 1e-5 * f64::from(k));
    let mut parts = [0.0; 6];
    let part = |x: f64| edges[1..6].iter().filter(|edge| x > **edge).count();
    for x in grid {
        parts[part(x)] += (-0.5 * ((wave(x) - 0.5) / 0.02).powi(2)).exp();
    }
    let all: f64 = parts.iter().sum();
    let roots = [0.462, 1.077, 1.566, 2.074, 2.669, 3.069];
    let starts: Vec<Vec<f64>> = roots.iter().map(|x| vec![(x - 0.1) / 3.0]).collect();
    for starts in [starts, Vec::new()] {
        let (sample, outcome) = sampled(&problem, &model, &starts, 2);
        assert!(outcome.trusted, "{:?}", outcome.doubts);
        let mut counts = [0.0; 6];
        for particle in &sample.particles {
            counts[part(0.1 + 3.0 * particle.places[0])] += 1.0;
        }
        let n = sample.particles.len() as f64;
        for (count, exact) in counts.iter().zip(parts) {
            let exact = exact / all;
            let error = (exact * (1.0 - exact) / n).sqrt();
            assert!((count / n - exact).abs() < 5.0 * error, "{counts:?}");
        }
        let intervals = &outcome.free[0].intervals;
        assert_eq!(intervals.len(), 6, "{intervals:?}");
        for ([low, high], root) in intervals.iter().zip(roots) {
            assert!(*low < root && root < *high && high - low < 0.06, "{low} {high}");
        }
    }
}

/// A banana, against an integral on a grid. Its normal approximation is far too short.
#[test]
fn a_curved_valley_has_its_moments() {
    let problem = one_case(&[(-3.0, 3.0), (-2.0, 6.0)], &[(0.0, 1.0), (0.0, 0.1)]);
    let banana = |p: &[f64]| vec![p[0], p[1] - p[0] * p[0]];
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(banana(p));
    let (mut sums, steps) = ([0.0; 5], 1500);
    for i in 0..steps {
        for j in 0..steps {
            let place = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let p = [-3.0 + 6.0 * place(i), -2.0 + 8.0 * place(j)];
            let y = banana(&p);
            let density = (-0.5 * (y[0] * y[0] + (y[1] / 0.1).powi(2))).exp();
            for (sum, f) in sums.iter_mut().zip([1.0, p[0], p[1], p[0] * p[0], p[1] * p[1]]) {
                *sum += density * f;
            }
        }
    }
    let moment = |k: usize| sums[k] / sums[0];
    for starts in [vec![vec![0.6, 0.2]], Vec::new()] {
        let (_, outcome) = sampled(&problem, &model, &starts, 3);
        assert!(outcome.trusted, "{:?}", outcome.doubts);
        for k in 0..2 {
            let marginal = &outcome.free[k];
            let deviation = (moment(k + 3) - moment(k + 1).powi(2)).sqrt();
            let error = (marginal.mean - moment(k + 1)) / deviation * outcome.effective.sqrt();
            assert!(error.abs() < 4.0, "{k}: {error} {outcome:?}");
            assert!((marginal.deviation / deviation - 1.0).abs() < 0.12, "{k}: {marginal:?} {deviation}");
        }
    }
}

/// Densities 1 / cosh x have deviations of pi / 2, and normal approximations at their optimum of 1: what the start has of
/// their tails is little, and moves shaped by the particles that they move lose it.
#[test]
fn tails_beyond_the_normal_approximation_are_sampled() {
    let problem = one_case(&[(-15.0, 15.0); 4], &[(0.0, 1.0); 4]);
    let model =
        |_: usize, p: &[f64], _: &[f64]| Ok(p.iter().map(|x| x.signum() * (2.0 * x.cosh().ln()).sqrt()).collect());
    let objective = Objective::new(&problem, &model, 1e-5);
    let optima = optima(&objective, &[vec![0.45; 4]]);
    let mut ratios = Vec::new();
    for seed in 0..4 {
        let sample = sample(&objective, &optima, &settings(1000, seed), &|_, _| ()).unwrap();
        for k in 0..4 {
            // The mean is 0.
            let squares = sample.places(k).map(|place| (30.0 * place - 15.0).powi(2));
            ratios.push((squares.sum::<f64>() / sample.particles.len() as f64).sqrt() / std::f64::consts::FRAC_PI_2);
        }
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((mean - 1.0).abs() < 0.03, "{mean} {ratios:?}");
}

#[test]
fn latent_unknowns_are_sampled_within_their_intervals() {
    // y = a + l with a within 0 and 10, l within 2 and 3, y = 7 +- 0.01: a + l is known, l is not.
    let mut problem = one_case(&[(0.0, 10.0)], &[(7.0, 0.01)]);
    problem.latents = vec![named("l")];
    problem.cases[0].latents = vec![Interval { min: 2.0, max: 3.0 }];
    let model = |_: usize, p: &[f64], l: &[f64]| Ok(vec![p[0] + l[0]]);
    let (sample, outcome) = sampled(&problem, &model, &[vec![0.5, 0.5]], 4);
    assert!(outcome.trusted, "{:?}", outcome.doubts);
    let uniform = 1.0 / 12.0_f64.sqrt();
    for marginal in [&outcome.free[0], &outcome.latents[0][0]] {
        assert!((marginal.deviation / uniform - 1.0).abs() < 0.1, "{marginal:?}");
    }
    let [low, high] = outcome.latents[0][0].intervals[0];
    assert!((low - 2.025).abs() < 0.02 && (high - 2.975).abs() < 0.02, "{low} {high}");
    for particle in &sample.particles {
        let sum = problem.free_values(&particle.places)[0] + problem.latent_values(0, &particle.places)[0];
        assert!((sum - 7.0).abs() < 0.05);
    }
}

#[test]
fn failed_runs_count_as_impossible_and_are_counted() {
    // Half of the normal posterior around 0.5 cannot be run.
    let problem = one_case(&[(0.0, 1.0)], &[(0.5, 0.1)]);
    let model = |_: usize, p: &[f64], _: &[f64]| {
        if p[0] > 0.5 { Err("too far".to_owned()) } else { Ok(vec![p[0]]) }
    };
    let (sample, outcome) = sampled(&problem, &model, &[], 5);
    assert!(outcome.trusted, "{:?}", outcome.doubts);
    assert!(sample.particles.iter().all(|particle| particle.places[0] <= 0.5));
    // The mean of half a normal distribution is sqrt(2 / pi) deviations from its edge.
    let exact = 0.5 - 0.1 * (2.0 / std::f64::consts::PI).sqrt();
    assert!((outcome.free[0].mean - exact).abs() < 0.01, "{outcome:?}");
    assert!(outcome.failed > 100 && outcome.notes[0].contains("runs failed at"));
    // Where nothing can be run there is no sample.
    let never = |_: usize, _: &[f64], _: &[f64]| -> Prediction { Err("never".to_owned()) };
    let objective = Objective::new(&problem, &never, 1e-5);
    let none = sample_of(&objective, &settings(200, 1));
    assert_eq!(none, Err(SampleError::NoStart(200)));
}

fn sample_of(objective: &Objective, settings: &Settings) -> Result<usize, SampleError> {
    sample(objective, &[], settings, &|_, _| ()).map(|sample| sample.particles.len())
}

/// Three particles in 10,000 of the prior come near a peak beside a broad hill. The search knows it; a sample from the
/// prior alone that has not found it says so.
#[test]
fn a_sample_without_a_known_optimum_says_so_and_one_that_starts_there_has_it() {
    let problem = one_case(&[(0.0, 1.0); 6], &[(0.0, 1.0); 7]);
    // Whichever is the more probable of a hill and a peak that is exp(12.7) times as high.
    let model = |_: usize, p: &[f64], _: &[f64]| {
        let about = |centre: f64, deviation: f64, less: f64| -> Vec<f64> {
            let distances = p.iter().map(|x| (x - centre) / deviation);
            distances.chain([(2.0 * less).sqrt()]).collect()
        };
        let [hill, peak] = [about(0.3, 0.3, 12.7), about(0.85, 0.03, 0.0)];
        let squares = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
        Ok(if squares(&hill) < squares(&peak) { hill } else { peak })
    };
    // The peak's part of the posterior; the hill is cut at the bounds, the peak is not.
    let normal = Normal::standard();
    let inside = normal.cdf(0.7 / 0.3) - normal.cdf(-1.0);
    let (peak, hill) = (12.7_f64.exp() * 0.03_f64.powi(6), (0.3 * inside).powi(6));
    let part = peak / (peak + hill);
    assert!((0.3..0.7).contains(&part), "{part}");
    let objective = Objective::new(&problem, &model, 1e-5);
    let optima = optima(&objective, &[vec![0.3; 6], vec![0.85; 6]]);
    assert_eq!(optima.len(), 1, "{optima:?}");
    for (seeds, from_optima) in [(&optima[..], true), (&[][..], false)] {
        let sample = sample(&objective, seeds, &settings(1000, 1), &|_, _| ()).unwrap();
        let outcome = PosteriorOutcome::new(&objective, &optima, &sample);
        let near = sample.particles.iter().filter(|particle| particle.places[0] > 0.7);
        let share = near.count() as f64 / sample.particles.len() as f64;
        println!("{share} {part} {} {:?}", outcome.effective, outcome.doubts);
        assert_eq!(outcome.trusted, from_optima, "{share} {outcome:?}");
        assert!(!from_optima || (share - part).abs() < 0.1, "{share} {part}");
    }
}
