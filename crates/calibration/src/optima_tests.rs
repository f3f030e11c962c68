//! Several minima: all of them, with their parts of the posterior, and a curved valley for the one that it is.

use statrs::distribution::{ContinuousCDF, Normal};

use super::{
    objective::Objective,
    optima::Optimum,
    outcome::IdentificationOutcome,
    problem::{Problem, Simulate},
    search::search,
    testing::{effort, one_case, said, starts},
};

/// The optima in the order of the first parameter, and the outcome.
fn solved(problem: &Problem, model: &dyn Simulate) -> (Vec<Optimum>, IdentificationOutcome) {
    let objective = Objective::new(problem, model, 1e-4);
    let starts = starts(problem.free.len(), 64);
    let (mut optima, progress) = search(&objective, &starts, &effort(8, 60), &|_| ()).unwrap();
    let outcome = IdentificationOutcome::new(problem, &optima, &progress);
    optima.sort_by(|a, b| a.minimum.places[0].total_cmp(&b.minimum.places[0]));
    (optima, outcome)
}

/// p0 + p1 = 5 +- 0.1, and by a wrong datum p1 = -8 +- 1 where p1 cannot be less than 0: p1 has next to an exponential
/// distribution from 0 on, and p0 is about 5 less p1, not about 13 as without the bound.
#[test]
fn an_interval_holds_its_value_where_a_bound_stops_another_unknown() {
    let problem = one_case(&[(0.0, 10.0), (0.0, 10.0)], &[(5.0, 0.1), (-8.0, 1.0)]);
    let sum = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] + p[1], p[1]]);
    let (_, outcome) = solved(&problem, &sum);
    let [first, second] = &outcome.free[..] else { unreachable!("there are two") };
    assert_eq!(second.at_bound, Some("lower"));
    assert!((first.value - 5.0).abs() < 1e-6, "{first:?}");
    // Quantiles of 5 + N(0, 0.1) - X, where X has the density exp(-(x + 8)^2 / 2) above 0.
    let steps = || (0..4000).map(|k| 0.0005 * (f64::from(k) + 0.5));
    let density = |x: f64| (-0.5 * ((x + 8.0).powi(2) - 64.0)).exp();
    let below = |value: f64| {
        let part = |x: f64| density(x) * Normal::standard().cdf((value - 5.0 + x) / 0.1);
        steps().map(part).sum::<f64>() / steps().map(density).sum::<f64>()
    };
    let [low, high] = first.interval;
    let held = below(high) - below(low);
    assert!((0.94..0.975).contains(&held), "{held}: {low} .. {high}");
    assert!(low < 5.0 && 5.0 < high, "{low} .. {high}");
}

#[test]
fn all_six_solutions_of_a_wave_are_found_with_their_parts() {
    // sin(6 x) + 0.3 x = 0.5 +- 0.02 on [0.1, 3.1]. Where a solution is sharp, its part of the posterior is
    // proportional to the width of its valley, 1 / |6 cos(6 x) + 0.3|.
    let problem = one_case(&[(0.1, 3.1)], &[(0.5, 0.02)]);
    let wave = |_: usize, p: &[f64], _: &[f64]| Ok(vec![(6.0 * p[0]).sin() + 0.3 * p[0]]);
    let (optima, outcome) = solved(&problem, &wave);
    let slope = |x: f64| (6.0 * (6.0 * x).cos() + 0.3).abs();
    let exact: Vec<f64> = (0..3000)
        .map(|k| 0.1 + 0.001 * f64::from(k))
        .filter_map(|x| root(x, x + 0.001, |x| (6.0 * x).sin() + 0.3 * x - 0.5))
        .collect();
    assert_eq!(exact.len(), 6);
    assert_eq!(optima.len(), 6, "{optima:?}");
    let all: f64 = exact.iter().map(|&x| 1.0 / slope(x)).sum();
    for (optimum, &x) in optima.iter().zip(&exact) {
        let value = problem.free_values(&optimum.minimum.places)[0];
        assert!((value - x).abs() < 1e-6, "{value} {x}");
        let part = 1.0 / slope(x) / all;
        assert!((optimum.weight / part - 1.0).abs() < 0.02, "{} {part}", optimum.weight);
        // The reported 95 % interval is that of a straight line through the solution.
        let mut places = outcome.optima.iter();
        let same = |optimum: &&super::outcome::OptimumOutcome| (optimum.free[0].value - x).abs() < 1e-3;
        let [low, high] = places.find(same).unwrap().free[0].interval;
        let width = 2.0 * 1.959_964 * 0.02 / slope(x);
        assert!(((high - low) / width - 1.0).abs() < 0.02, "{low} {high}");
    }
    assert!((optima.iter().map(|optimum| optimum.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    assert!(outcome.ambiguous);
    assert!(outcome.optima.windows(2).all(|two| two[0].weight >= two[1].weight));
    let text = said(&outcome);
    assert!(text.contains("6 distinct sets of parameters fit"), "{text}");
    assert!(!text.contains("determine every parameter"), "{text}");
}

/// The root between two places, by halving.
fn root(mut a: f64, mut b: f64, f: impl Fn(f64) -> f64) -> Option<f64> {
    if f(a) * f(b) > 0.0 {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        (a, b) = if f(a) * f(middle) <= 0.0 { (a, middle) } else { (middle, b) };
    }
    Some(a)
}

#[test]
fn a_curved_valley_is_one_optimum_that_is_not_determined() {
    // Only the product is measured: its solutions are one connected curve, whose ends are far apart, however narrow it is.
    for accuracy in [5e-3, 1e-4, 1e-6] {
        let problem = one_case(&[(0.1, 2.0), (0.1, 2.0)], &[(0.5, accuracy)]);
        let product = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] * p[1]]);
        let (optima, outcome) = solved(&problem, &product);
        assert_eq!(optima.len(), 1, "{accuracy}: {optima:?}");
        assert!(!outcome.ambiguous && outcome.directions[0].undetermined, "{accuracy}");
    }
}

#[test]
fn the_parts_of_two_optima_are_those_of_the_integral() {
    // The distance from two places: 4 times as sharp at the one as at the other.
    let problem = one_case(&[(-2.0, 2.0), (-1.0, 1.0)], &[(0.0, 1.0), (0.0, 1.0)]);
    let model = |_: usize, p: &[f64], _: &[f64]| {
        let [x, y] = [p[0], p[1]];
        Ok(if x < 0.0 { vec![(x + 1.0) / 0.1, y / 0.1] } else { vec![(x - 1.0) / 0.2, y / 0.2] })
    };
    let (optima, _) = solved(&problem, &model);
    assert_eq!(optima.len(), 2, "{optima:?}");
    let weights = [optima[0].weight, optima[1].weight];
    assert!((weights[0] - 0.2).abs() < 0.01 && (weights[1] - 0.8).abs() < 0.01, "{weights:?}");
}

#[test]
fn a_minimum_that_is_too_improbable_is_no_solution() {
    // x^2 - 0.02 x is 1 near -0.99 and near 1.01; a second result leaves one of them.
    let one = one_case(&[(-2.0, 2.0)], &[(1.0, 0.01), (1.0, 0.1)]);
    let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] * p[0] - 0.02 * p[0], p[0]]);
    let (optima, outcome) = solved(&one, &model);
    assert_eq!(optima.len(), 1);
    assert!((outcome.free[0].value - 1.01).abs() < 0.01 && !outcome.ambiguous);
    assert!(said(&outcome).contains("these intervals hold; they are normal approximations"));
    // Without it both are.
    let both = one_case(&[(-2.0, 2.0)], &[(1.0, 0.01)]);
    let (optima, _) = solved(&both, &|_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] * p[0] - 0.02 * p[0]]));
    assert_eq!(optima.len(), 2);
}

/// Runs end on a grid of single places only: nothing is known around the best of them.
#[test]
fn an_optimum_amid_failing_runs_is_no_minimum_and_no_error() {
    let problem = one_case(&[(0.0, 1.0), (0.0, 1.0)], &[(0.4, 0.1), (0.5, 0.1)]);
    let stripes = |_: usize, p: &[f64], _: &[f64]| match (p[0] * 1e3).fract() {
        0.2..0.8 => Err("too thin".to_owned()),
        _ => Ok(vec![p[0], p[1]]),
    };
    let starts = starts(2, 64);
    // The starts of which a run ends have failing runs at this distance of a derivative.
    let objective = Objective::new(&problem, &stripes, 5e-4);
    let (optima, progress) = search(&objective, &starts, &effort(8, 60), &|_| ()).unwrap();
    assert!(optima.iter().all(|optimum| optimum.minimum.surrounded == [0] && optimum.edge.blocked));
    let outcome = IdentificationOutcome::new(&problem, &optima, &progress);
    let [first, second] = &outcome.free[..] else { panic!() };
    // The second parameter is found as usual; of the first one the prior is left.
    assert!((second.value - 0.5).abs() < 0.01 && !second.surrounded && second.left < 0.5);
    assert!(first.surrounded && (first.left - 1.0).abs() < 1e-9, "{first:?}");
    let text = said(&outcome);
    for words in ["no minimum is known", "Runs failed at"] {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("determine every parameter"), "{text}");
}
