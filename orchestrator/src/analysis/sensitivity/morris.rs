//! Morris screening: elementary effects, a cheap order of importance.
//!
//! Morris (1991), "Factorial sampling plans for preliminary computational experiments",
//! Technometrics 33, 161-174; mu* after Campolongo, Cariboni & Saltelli (2007),
//! "An effective screening design for sensitivity analysis of large models",
//! Environmental Modelling & Software 22, 1509-1518.

use super::Estimate;
use super::method::{FromRuns, Measure, Settled, Told, read};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng, rngs::StdRng};
use sampling::statistics::moments::{mean, variance};
use sampling::statistics::share::Z95;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Levels of the grid.
const LEVELS: usize = 4;
/// Resamples of the intervals.
const RESAMPLES: usize = 200;

/// Morris screening by runs of its own.
#[derive(Clone, Copy, Debug)]
pub struct Morris;

impl FromRuns for Morris {
    fn name(&self) -> &'static str {
        "morris"
    }

    fn option(&self) -> &'static str {
        "morris"
    }

    fn title(&self, size: u64) -> String {
        format!("Morris screening by {size} trajectories")
    }

    fn usual_size(&self) -> u64 {
        20
    }

    fn runs(&self, parameters: u64, size: u64) -> u64 {
        size * (parameters + 1)
    }

    /// The ends of a distribution may reach far; the grid covers its middle 98 %.
    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String> {
        let trajectories = usize::try_from(settled.size).map_err(|error| error.to_string())?;
        let cube = design(parameters, trajectories, LEVELS, settled.seed);
        let middle = |row: &Vec<f64>| row.iter().map(|u| 0.01 + 0.98 * u).collect();
        Ok(cube.iter().map(middle).collect())
    }

    fn plain_sample(&self, _: usize, _: usize) -> Vec<usize> {
        Vec::new()
    }

    fn done(&self, _: usize, runs: usize, _: &Settled) -> String {
        format!("Morris screening, {runs} runs")
    }

    fn tell(&self, rows: &[Vec<f64>], values: &[f64], settled: &Settled) -> Told {
        // The effects are those of a parameter's whole range, which the grid of the design is.
        let parameters = rows.first().map_or(0, Vec::len);
        let trajectories = rows.len() / (parameters + 1);
        let cube = design(parameters, trajectories, LEVELS, settled.seed);
        let effects = effects(&cube, values, RESAMPLES, settled.seed);
        Told::from_iter([("morris".to_owned(), json!(effects))])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let effects: Option<Vec<Effect>> = read(told, "morris");
        effects.map_or_else(Vec::new, |effects| {
            let alone = |value| Estimate::around(value, f64::NAN);
            vec![
                Measure::drawn("mu*", effects.iter().map(|e| e.mu_star).collect()),
                Measure::listed("sigma", effects.iter().map(|e| alone(e.sigma)).collect()),
            ]
        })
    }
}

/// Trajectories in the unit cube: each has `parameters + 1` points, and one parameter changes a step,
/// by delta = levels / (2 (levels - 1)) on a grid of that many levels (an even number).
pub fn design(parameters: usize, trajectories: usize, levels: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = StdRng::seed_from_u64(seed);
    let levels = levels.max(2) & !1;
    let jump = levels / 2;
    let grid = |k: usize| k as f64 / (levels - 1) as f64;
    let mut rows = Vec::with_capacity(trajectories * (parameters + 1));
    for _ in 0..trajectories {
        let mut place: Vec<usize> = (0..parameters)
            .map(|_| random.random_range(0..levels))
            .collect();
        let mut order: Vec<usize> = (0..parameters).collect();
        order.shuffle(&mut random);
        rows.push(place.iter().map(|&k| grid(k)).collect());
        for i in order {
            place[i] = if place[i] < jump {
                place[i] + jump
            } else {
                place[i] - jump
            };
            rows.push(place.iter().map(|&k| grid(k)).collect());
        }
    }
    rows
}

/// Elementary effects of one parameter on one output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Mean effect: the output's change for a parameter's change over its whole range.
    pub mu: f64,
    /// Mean of the effects' magnitudes: importance, with a bootstrap interval.
    pub mu_star: Estimate,
    /// Standard deviation of the effects: large where the parameter interacts or acts non-linearly.
    pub sigma: f64,
    /// The number of effects; steps from or to a failed run have none.
    pub used: usize,
}

/// Computes the effects from the rows of [`design`] and their outputs.
///
/// Returns `None` where the lengths do not match, or a parameter has fewer than two effects.
pub fn effects(
    rows: &[Vec<f64>],
    outputs: &[f64],
    resamples: usize,
    seed: u64,
) -> Option<Vec<Effect>> {
    let parameters = rows.first()?.len();
    if rows.len() != outputs.len() || !rows.len().is_multiple_of(parameters + 1) {
        return None;
    }
    let mut found = vec![Vec::new(); parameters];
    for k in (1..rows.len()).filter(|k| k % (parameters + 1) != 0) {
        let changed = (0..parameters).find(|&i| rows[k][i] != rows[k - 1][i])?;
        let effect = (outputs[k] - outputs[k - 1]) / (rows[k][changed] - rows[k - 1][changed]);
        if effect.is_finite() {
            found[changed].push(effect);
        }
    }
    let mut random = StdRng::seed_from_u64(seed);
    found
        .iter()
        .map(|effects| summary(effects, resamples, &mut random))
        .collect()
}

fn summary(effects: &[f64], resamples: usize, random: &mut StdRng) -> Option<Effect> {
    if effects.len() < 2 {
        return None;
    }
    let sizes: Vec<f64> = effects.iter().map(|e| e.abs()).collect();
    let again: Vec<f64> = (0..resamples)
        .map(|_| {
            (0..sizes.len())
                .map(|_| sizes[random.random_range(0..sizes.len())])
                .sum::<f64>()
                / sizes.len() as f64
        })
        .collect();
    Some(Effect {
        mu: mean(effects),
        mu_star: Estimate::around(mean(&sizes), Z95 * variance(&again, 1).sqrt()),
        sigma: variance(effects, 1).sqrt(),
        used: effects.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_has_its_slopes_as_effects() {
        let rows = design(3, 10, 4, 1);
        let y: Vec<f64> = rows.iter().map(|u| 2.0 * u[0] - 5.0 * u[1] + 1.0).collect();
        let e = effects(&rows, &y, 50, 1).unwrap();
        for (effect, slope) in e.iter().zip([2.0, -5.0, 0.0]) {
            assert!((effect.mu - slope).abs() < 1e-12);
            assert!((effect.mu_star.value - f64::abs(slope)).abs() < 1e-12);
            assert!(effect.sigma < 1e-12);
            assert_eq!(effect.used, 10);
        }
    }

    #[test]
    fn an_interaction_shows_as_sigma() {
        let rows = design(2, 40, 4, 2);
        let y: Vec<f64> = rows.iter().map(|u| (u[0] - 0.5) * (u[1] - 0.5)).collect();
        let e = effects(&rows, &y, 50, 1).unwrap();
        assert!(e.iter().all(|e| e.sigma > 0.3 && e.mu.abs() < 0.25));
    }

    #[test]
    fn a_failed_run_costs_its_two_steps_only() {
        let rows = design(3, 10, 4, 1);
        let mut y: Vec<f64> = rows.iter().map(|u| u[0]).collect();
        y[1] = f64::NAN;
        let e = effects(&rows, &y, 50, 1).unwrap();
        assert_eq!(e.iter().map(|e| e.used).sum::<usize>(), 28);
        assert!((e[0].mu - 1.0).abs() < 1e-12);
    }

    #[test]
    fn one_parameter_changes_a_step_and_stays_in_the_cube() {
        let rows = design(5, 20, 6, 3);
        assert_eq!(rows.len(), 120);
        assert!(rows.iter().flatten().all(|u| (0.0..=1.0).contains(u)));
        for k in (1..rows.len()).filter(|k| k % 6 != 0) {
            assert_eq!((0..5).filter(|&i| rows[k][i] != rows[k - 1][i]).count(), 1);
        }
    }
}
