//! The nearest minimum: Levenberg-Marquardt between bounds.
//!
//! Marquardt 1963 (SIAM J. Appl. Math. 11), with the damping of Nielsen (Madsen, Nielsen, Tingleff
//! 2004, Methods for Non-Linear Least Squares Problems, section 3.2). Bounds enter each step as an
//! active set: an unknown that the step would push out stays on its bound, and the others are solved for again.

use super::{
    objective::{Differences, Linear, Misfit, Objective},
    problem::NoPrediction,
};
use nalgebra::{Cholesky, DVector};

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The most linearisations.
    pub iterations: usize,
    /// The least relative decrease of the sum of squares that is worth another iteration.
    pub decrease: f64,
}

/// Why the search for the minimum ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// At a minimum, as far as the simulations resolve one.
    Converged,
    /// After the given number of iterations.
    Iterations,
    /// When the runs of a budget were spent.
    Budget,
}

/// A minimum.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The unknowns, as places between their bounds.
    pub places: Vec<f64>,
    /// The misfit there.
    pub misfit: Misfit,
    /// Why the search ended.
    pub end: End,
    /// Whether the way down leads to where runs fail: the sum of squares may be less beyond.
    pub blocked: bool,
    /// The unknowns on both sides of which runs fail: nothing is known of what they change.
    pub surrounded: Vec<usize>,
}

impl Minimum {
    /// The sum of squares there.
    pub fn cost(&self) -> f64 {
        self.misfit.cost()
    }
}

/// Looks for the minimum nearest to a start. Unknowns that are `held` stay where they are, as do those on both sides of
/// which runs fail.
///
/// # Errors
/// When a simulation fails at the start.
pub fn minimise(
    objective: &Objective,
    start: Vec<f64>,
    held: &[usize],
    differences: Differences,
    limits: &Limits,
) -> Result<Minimum, NoPrediction> {
    let misfit = objective.misfit(&start)?;
    let mut at = Minimum { places: start, misfit, end: End::Iterations, blocked: false, surrounded: Vec::new() };
    let mut damping = Damping { value: 1e-3, growth: 2.0 };
    for _ in 0..limits.iterations {
        let linear = objective.linear(&at.places, &at.misfit, differences)?;
        let before = at.cost();
        at.blocked |= !linear.surrounded.is_empty();
        let held = [held, &linear.surrounded].concat();
        if !descend(objective, &linear, &held, &mut damping, &mut at)? || before - at.cost() < limits.decrease * before
        {
            at.end = End::Converged;
            break;
        }
    }
    at.blocked = at.blocked && goes_on(objective, held, differences, &mut at)?;
    Ok(at)
}

/// Whether the linearised problem goes on down to a place where a run fails, or is unknown as runs fail all around.
fn goes_on(
    objective: &Objective,
    held: &[usize],
    differences: Differences,
    at: &mut Minimum,
) -> Result<bool, NoPrediction> {
    /// A smaller decrease of the sum of squares matters to no probability.
    const LITTLE: f64 = 0.01;
    let mut linear = objective.linear(&at.places, &at.misfit, differences)?;
    at.surrounded = std::mem::take(&mut linear.surrounded);
    at.surrounded.retain(|unknown| !held.contains(unknown));
    if !at.surrounded.is_empty() {
        return Ok(true);
    }
    let linear = linear.damped(1e-9);
    let step = bounded_step(&linear, &at.places, held);
    if linear.fall(&step) < LITTLE {
        return Ok(false);
    }
    match objective.misfit(&moved(&at.places, &step)) {
        Err(NoPrediction::Here(_)) => Ok(true),
        ended => ended.map(|_| false),
    }
}

/// Places after a step, between the bounds.
fn moved(places: &[f64], step: &DVector<f64>) -> Vec<f64> {
    places.iter().zip(step).map(|(place, step)| (place + step).clamp(0.0, 1.0)).collect()
}

/// Levenberg's damping after Nielsen: little where the linearised problem predicts well.
struct Damping {
    value: f64,
    growth: f64,
}

impl Damping {
    const MOST: f64 = 1e12;
    const LEAST: f64 = 1e-15;

    fn accept(&mut self, gain: f64) {
        self.value *= (1.0 - (2.0 * gain - 1.0).powi(3)).max(1.0 / 3.0);
        self.value = self.value.max(Self::LEAST);
        self.growth = 2.0;
    }

    fn refuse(&mut self) {
        self.value *= self.growth;
        self.growth *= 2.0;
    }
}

/// Goes down one step; false where no step goes down.
fn descend(
    objective: &Objective,
    linear: &Linear,
    held: &[usize],
    damping: &mut Damping,
    at: &mut Minimum,
) -> Result<bool, NoPrediction> {
    while damping.value < Damping::MOST {
        let step = bounded_step(&linear.damped(damping.value), &at.places, held);
        if step.amax() < 1e-10 {
            return Ok(false);
        }
        let places = moved(&at.places, &step);
        match objective.misfit(&places) {
            Ok(misfit) if misfit.cost() < at.cost() => {
                let decrease = at.cost() - misfit.cost();
                damping.accept(decrease / linear.fall(&step).max(f64::MIN_POSITIVE));
                at.places = places;
                at.misfit = misfit;
                return Ok(true);
            }
            Ok(_) => damping.refuse(),
            Err(NoPrediction::Here(_)) => {
                at.blocked = true;
                damping.refuse();
            }
            Err(stopped) => return Err(stopped),
        }
    }
    damping.value = Damping::MOST.sqrt();
    Ok(false)
}

/// The step to the minimum of the quadratic model within the bounds, by an active set (Nocedal and Wright 2006, Numerical
/// Optimization, algorithm 16.3): it goes as far as the first bound, and lets go of one from which the sum of squares falls.
pub(crate) fn bounded_step(linear: &Linear, places: &[f64], held: &[usize]) -> DVector<f64> {
    let n = places.len();
    let mut step = DVector::zeros(n);
    let mut fixed: Vec<bool> = (0..n).map(|index| held.contains(&index)).collect();
    // Each pass fixes or releases one; where rounding does both in turn, the step so far is one that goes down.
    for _ in 0..10 * (n + 1) {
        let open: Vec<usize> = (0..n).filter(|&index| !fixed[index]).collect();
        let pull = &linear.curvature * &step + &linear.gradient;
        let matrix = linear.curvature.select_rows(&open).select_columns(&open);
        let Some(further) = Cholesky::new(matrix).map(|factor| factor.solve(&-pull.select_rows(&open))) else {
            return step;
        };
        let first = open
            .iter()
            .zip(&further)
            .filter_map(|(&index, &change)| {
                let end = if change > 0.0 { 1.0 } else { 0.0 };
                let part = (end - places[index] - step[index]) / change;
                (change != 0.0 && part < 1.0).then_some((part.max(0.0), index, end))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        for (&index, &change) in open.iter().zip(&further) {
            step[index] += first.map_or(1.0, |(part, ..)| part) * change;
        }
        if let Some((_, index, end)) = first {
            (step[index], fixed[index]) = (end - places[index], true);
            continue;
        }
        let pull = &linear.curvature * &step + &linear.gradient;
        let inward = |&index: &usize| match places[index] + step[index] {
            place if place <= 0.0 => -pull[index],
            _ => pull[index],
        };
        let closed = (0..n).filter(|index| fixed[*index] && !held.contains(index) && inward(index) > 0.0);
        match closed.max_by(|a, b| inward(a).total_cmp(&inward(b))) {
            Some(index) => fixed[index] = false,
            None => break,
        }
    }
    step
}

#[cfg(test)]
mod tests {
    use super::super::testing::{limits, one_case};
    use super::*;

    #[test]
    fn finds_the_bottom_of_rosenbrocks_valley() {
        let problem = one_case(&[(-2.0, 2.0), (-2.0, 2.0)], &[(0.0, 1.0), (1.0, 1.0)]);
        let valley = |_: usize, p: &[f64], _: &[f64]| Ok(vec![10.0 * (p[1] - p[0] * p[0]), p[0]]);
        let objective = Objective::new(&problem, &valley, 1e-6);
        let start = vec![0.2, 0.9];
        let minimum = minimise(&objective, start, &[], Differences::Central, &limits(200, 1e-12)).unwrap();
        let values = problem.free_values(&minimum.places);
        assert!((values[0] - 1.0).abs() < 1e-6 && (values[1] - 1.0).abs() < 1e-6, "{values:?}");
    }

    #[test]
    fn a_minimum_outside_is_found_on_the_bound() {
        // The least of (x + y - 3)^2 + (x - y)^2 + ... lies at x = y = 1.5; x may go to 1 only.
        let problem = one_case(&[(0.0, 1.0), (0.0, 4.0)], &[(3.0, 1.0), (0.0, 1.0)]);
        let plane = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] + p[1], p[0] - p[1]]);
        let objective = Objective::new(&problem, &plane, 1e-4);
        let start = vec![0.3, 0.3];
        let minimum = minimise(&objective, start, &[], Differences::Forward, &limits(200, 1e-12)).unwrap();
        let values = problem.free_values(&minimum.places);
        // With x = 1: (y - 2)^2 + (1 - y)^2 is least at y = 1.5.
        assert!((values[0] - 1.0).abs() < 1e-12 && (values[1] - 1.5).abs() < 1e-6, "{values:?}");
    }

    #[test]
    fn keeps_away_from_where_the_simulation_fails() {
        let problem = one_case(&[(0.0, 10.0)], &[(2.0, 1.0)]);
        let fragile = |_: usize, p: &[f64], _: &[f64]| {
            if p[0] < 1.0 { Err("too thin".to_owned()) } else { Ok(vec![p[0].ln() * 3.0]) }
        };
        let objective = Objective::new(&problem, &fragile, 1e-5);
        let minimum = minimise(&objective, vec![0.95], &[], Differences::Central, &limits(200, 1e-12)).unwrap();
        let values = problem.free_values(&minimum.places);
        assert!((values[0] - (2.0_f64 / 3.0).exp()).abs() < 1e-5, "{values:?}");
        assert!(!minimum.blocked);
    }

    #[test]
    fn says_where_failing_simulations_end_the_way_down() {
        let problem = one_case(&[(0.0, 10.0)], &[(2.0, 1.0)]);
        let fragile =
            |_: usize, p: &[f64], _: &[f64]| if p[0] < 3.0 { Err("too thin".to_owned()) } else { Ok(vec![p[0]]) };
        let objective = Objective::new(&problem, &fragile, 1e-5);
        let minimum = minimise(&objective, vec![0.9], &[], Differences::Central, &limits(200, 1e-12)).unwrap();
        let values = problem.free_values(&minimum.places);
        assert!(minimum.blocked && values[0] >= 3.0 && values[0] < 3.1, "{values:?}");
        let failures = objective.failures();
        assert!(failures.failed > 0 && failures.failed < failures.asked);
    }
}
