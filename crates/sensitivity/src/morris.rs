//! Morris screening: elementary effects, a cheap order of importance.
//!
//! Morris (1991), "Factorial sampling plans for preliminary computational experiments",
//! Technometrics 33, 161-174; mu* after Campolongo, Cariboni & Saltelli (2007),
//! "An effective screening design for sensitivity analysis of large models",
//! Environmental Modelling & Software 22, 1509-1518.

use crate::method::{Facts, FromRuns, KeyedResults, Measure, Settled, read};
use conformity::interval::clopper_pearson;
use sampling::{
    random::{Purpose, Random},
    statistics::{
        estimate::Estimate,
        moments::{deviation, mean},
    },
};
use serde::{Deserialize, Serialize};
use serde_json::json;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Levels of the grid.
const LEVELS: usize = 4;

/// Morris screening by runs of its own.
#[derive(Clone, Copy, Debug)]
pub struct Morris;

impl FromRuns for Morris {
    fn facts(&self) -> Facts {
        Facts {
            name: "morris",
            option: "morris",
            words: ["Morris screening by", "trajectories"],
            usual_size: 20,
            tried_size: 10,
        }
    }

    fn runs(&self, parameters: usize, size: u64) -> u64 {
        size * (parameters as u64 + 1)
    }

    /// The ends of a distribution may reach far; the grid covers its middle 98 %.
    fn design(&self, parameters: usize, settled: &Settled) -> Result<Vec<Vec<f64>>, String> {
        let trajectories = usize::try_from(settled.size).map_err(|error| error.to_string())?;
        Ok(design(parameters, trajectories, LEVELS, settled.seed)
            .iter()
            .map(|row| row.iter().map(|u| 0.01 + 0.98 * u).collect())
            .collect())
    }

    fn done(&self, runs: usize, _: &Settled) -> String {
        format!("Morris screening, {runs} runs")
    }

    fn tell(&self, rows: &[Vec<f64>], values: &[f64], settled: &Settled) -> KeyedResults {
        // The effects are those of a parameter's whole range, which the grid of the design is.
        let parameters = rows.first().map_or(0, Vec::len);
        let trajectories = rows.len() / (parameters + 1);
        let cube = design(parameters, trajectories, LEVELS, settled.seed);
        let effects = effects(&cube, values);
        KeyedResults::from_iter([("morris".to_owned(), json!(effects))])
    }

    fn shown(&self, told: &KeyedResults) -> Vec<Measure> {
        let Some(effects) = read::<Vec<Effect>>(told, "morris") else { return Vec::new() };
        let alone = |value| Estimate::around(value, f64::NAN);
        vec![
            Measure::drawn("mu*", effects.iter().map(|e| e.mu_star).collect()),
            Measure::listed("sigma", effects.iter().map(|e| alone(e.sigma)).collect()),
        ]
    }
}

/// Trajectories in the unit cube: each has `parameters + 1` points, and one parameter changes a step,
/// by delta = levels / (2 (levels - 1)) on a grid of that many levels (an even number).
pub fn design(parameters: usize, trajectories: usize, levels: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random::new(seed, Purpose::Trajectory, 0);
    let levels = levels.max(2) & !1;
    let jump = levels / 2;
    let grid = |k: usize| k as f64 / (levels - 1) as f64;
    let mut rows = Vec::with_capacity(trajectories * (parameters + 1));
    for _ in 0..trajectories {
        let mut place: Vec<usize> = (0..parameters).map(|_| random.below(levels)).collect();
        let mut order: Vec<usize> = (0..parameters).collect();
        random.shuffle(&mut order);
        rows.push(place.iter().map(|&k| grid(k)).collect());
        for i in order {
            // Up from the lower half of the grid, down from the upper one.
            place[i] = (place[i] + jump) % levels;
            rows.push(place.iter().map(|&k| grid(k)).collect());
        }
    }
    rows
}

/// Elementary effects of one parameter on one output.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Mean effect: the output's change for a parameter's change over its whole range.
    #[serde(deserialize_with = "sampling::statistics::estimate::or_not_a_number")]
    pub mu: f64,
    /// Mean of the effects' magnitudes: importance, with its interval.
    pub mu_star: Estimate,
    /// Standard deviation of the effects: large where the parameter interacts or acts non-linearly.
    #[serde(deserialize_with = "sampling::statistics::estimate::or_not_a_number")]
    pub sigma: f64,
    /// The number of effects; steps from or to a failed run have none.
    pub used: usize,
}

/// Computes the effects from the rows of [`design`] and their outputs.
///
/// A parameter with fewer than two effects has no numbers: failed runs took the others. Returns `None` where there is no
/// parameter, the lengths do not match, or no parameter has two effects.
pub fn effects(rows: &[Vec<f64>], outputs: &[f64]) -> Option<Vec<Effect>> {
    let parameters = rows.first()?.len();
    let fits = rows.len() == outputs.len() && rows.len().is_multiple_of(parameters + 1);
    if parameters == 0 || !fits {
        return None;
    }
    let mut all = vec![Vec::new(); parameters];
    for k in (1..rows.len()).filter(|k| k % (parameters + 1) != 0) {
        let changed = (0..parameters).find(|&i| rows[k][i] != rows[k - 1][i])?;
        let step = rows[k][changed] - rows[k - 1][changed];
        let effect = (outputs[k] - outputs[k - 1]) / step;
        if effect.is_finite() {
            all[changed].push(effect);
        }
    }
    // The size of every effect that is not 0, of an output that is pass or fail.
    let known = || outputs.iter().copied().filter(|v| v.is_finite());
    let (low, high) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let pass_or_fail = known().all(|v| v == low || v == high);
    let step = rows[1].iter().zip(&rows[0]).map(|(to, from)| to - from);
    let jump = pass_or_fail.then(|| (high - low) / step.sum::<f64>().abs());
    let effects: Vec<Effect> = all.iter().map(|effects| summary(effects, jump)).collect();
    effects.iter().any(|effect| effect.used >= FEWEST).then_some(effects)
}

/// Fewer effects have no mean with an interval.
const FEWEST: usize = 2;

fn summary(effects: &[f64], jump: Option<f64>) -> Effect {
    let unknown =
        Effect { mu: f64::NAN, mu_star: Estimate::around(f64::NAN, f64::NAN), sigma: f64::NAN, used: effects.len() };
    if effects.len() < FEWEST {
        return unknown;
    }
    let sizes: Vec<f64> = effects.iter().map(|e| e.abs()).collect();
    Effect {
        mu: mean(effects),
        mu_star: match jump {
            Some(jump) => of_jumps(&sizes, jump),
            None => with_interval(&sizes),
        },
        sigma: deviation(effects, 1),
        ..unknown
    }
}

/// The mean of numbers that are 0 or one size: the interval of the share of the latter. They may all be 0 by chance.
fn of_jumps(numbers: &[f64], jump: f64) -> Estimate {
    let count = numbers.iter().filter(|size| **size > 0.0).count() as f64;
    let [low, high] = clopper_pearson(count, numbers.len() as f64, 0.95);
    Estimate { value: mean(numbers), low: low * jump, high: high * jump }
}

/// The mean of independent numbers that are none negative, with its interval: Student's on the scale on which the mean of
/// skewed numbers is nearly symmetrical (Hall 1992, "On the removal of skewness by transformation", J. Royal Statistical
/// Society B 54, 221-228, the cubic transformation). Of effects that scatter over decades 95 % hold only with narrower tails: for
/// exp(2 (x1 + ... + x4)) the plain ones held in 89 % of 10 trajectories, and these in 93.5 % or more of 5 to 200.
fn with_interval(numbers: &[f64]) -> Estimate {
    let n = numbers.len() as f64;
    let student = StudentsT::new(0.0, 1.0, n - 1.0).expect("there are two numbers");
    let (centre, spread) = (mean(numbers), deviation(numbers, 0));
    let cubes = numbers.iter().map(|x| ((x - centre) / spread).powi(3));
    let skewness = cubes.sum::<f64>() / n;
    // How far the mean may lie above the true one, in standard deviations of a number.
    let above = |quantile: f64| {
        let plain = quantile / n.sqrt();
        let skewed = 1.0 + skewness * (plain - skewness / (6.0 * n));
        // The same for numbers without skewness, where the quotient would be lost in rounding; and for equal numbers.
        if skewness.abs() > 1e-6 { 3.0 * (skewed.cbrt() - 1.0) / skewness } else { plain }
    };
    let quantile = student.inverse_cdf(if numbers.len() < 20 { 0.995 } else { 0.9875 });
    let deviation = deviation(numbers, 1);
    Estimate {
        value: centre,
        low: (centre - deviation * above(quantile)).max(0.0),
        high: centre - deviation * above(-quantile),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{holds, near, settled};

    /// Hall's cubic solved by scipy's `brentq`, with Student's quantile of four degrees of freedom. No mean of magnitudes is
    /// negative: the lower end would be -1.810.
    #[test]
    fn the_interval_of_skewed_numbers_leans_to_where_the_rare_ones_are() {
        let estimate = with_interval(&[0.0, 1.0, 2.0, 3.0, 10.0]);
        assert_eq!(estimate.value, 3.2);
        assert_eq!(estimate.low, 0.0);
        assert!((estimate.high - 24.370_364_415).abs() < 1e-8, "{estimate:?}");
        // The same turned round, above 0.
        let turned = with_interval(&[30.0, 29.0, 28.0, 27.0, 20.0]);
        assert!((turned.low - (30.0 - 24.370_364_415)).abs() < 1e-8, "{turned:?}");
        assert!((turned.high - 31.809_839_569).abs() < 1e-8, "{turned:?}");
        // Without skewness it is Student's: 4.604 095 standard errors, sqrt(2.5 / 5) each.
        let even = with_interval(&[1.0, 2.0, 3.0, 4.0, 5.0]);
        assert!((even.high - 3.0 - 4.604_094_871 * 0.5_f64.sqrt()).abs() < 1e-8);
    }

    /// One of ten effects of a verdict is not 0: Clopper and Pearson's interval of 1 in 10 (scipy: 0.002 529, 0.445 016),
    /// times the size of an effect, 1 / (2 / 3).
    #[test]
    fn effects_of_a_verdict_are_counted() {
        let rows = design(1, 10, 4, 3);
        let mut outputs = vec![0.0; 20];
        outputs[7] = 1.0;
        let mu_star = effects(&rows, &outputs).unwrap()[0].mu_star;
        assert!((mu_star.value - 0.15).abs() < 1e-12);
        assert!((mu_star.low - 1.5 * 0.002_528_579).abs() < 1e-8, "{mu_star:?}");
        assert!((mu_star.high - 1.5 * 0.445_016_117).abs() < 1e-8, "{mu_star:?}");
    }

    /// The trajectories of a seed, for all time: their places and orders by a program of its own in Python.
    #[test]
    fn a_seed_gives_the_same_trajectories_for_ever() {
        let rows = design(3, 2, 4, 5);
        assert_eq!(rows[0], [0.0, 1.0, 1.0 / 3.0]);
        assert_eq!(rows[4], [1.0, 1.0, 1.0 / 3.0]);
        for trajectory in rows.chunks(4) {
            for (step, changed) in trajectory.windows(2).zip([2, 0, 1]) {
                assert!((0..3).all(|k| (step[0][k] != step[1][k]) == (k == changed)));
            }
        }
    }

    #[test]
    fn a_linear_function_has_its_slopes_as_effects() {
        let rows = design(3, 10, 4, 1);
        let y: Vec<f64> = rows.iter().map(|u| 2.0 * u[0] - 5.0 * u[1] + 1.0).collect();
        let e = effects(&rows, &y).unwrap();
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
        let e = effects(&rows, &y).unwrap();
        assert!(e.iter().all(|e| e.sigma > 0.3 && e.mu.abs() < 0.25));
    }

    #[test]
    fn a_failed_run_costs_its_two_steps_only() {
        let rows = design(3, 10, 4, 1);
        let mut y: Vec<f64> = rows.iter().map(|u| u[0]).collect();
        y[1] = f64::NAN;
        let e = effects(&rows, &y).unwrap();
        assert_eq!(e.iter().map(|e| e.used).sum::<usize>(), 28);
        assert!((e[0].mu - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_parameter_without_effects_leaves_the_others_theirs() {
        let rows = design(2, 20, 4, 1);
        // Every step of the first parameter leads into failure or out of it.
        let output = |u: &Vec<f64>| if u[0] < 0.5 { f64::NAN } else { 3.0 * u[1] };
        let outputs: Vec<f64> = rows.iter().map(output).collect();
        let told = KeyedResults::from_iter([("morris".to_owned(), json!(effects(&rows, &outputs)))]);
        let [mu_star, sigma] = &Morris.shown(&told)[..] else { panic!("two measures") };
        assert!(mu_star.estimates[0].value.is_nan() && sigma.estimates[0].value.is_nan());
        assert!((mu_star.estimates[1].value - 3.0).abs() < 1e-9);
        assert_eq!(effects(&rows, &vec![f64::NAN; rows.len()]), None);
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

    /// From the design to the results: the grid covers the middle 98 % of the cube, and an effect is the change from one
    /// end of the grid to the other.
    #[test]
    fn a_study_of_a_linear_function_shows_its_slopes() {
        let rows = Morris.design(2, &settled(10, 3)).unwrap();
        assert_eq!(rows.len() as u64, Morris.runs(2, 10));
        let on_grid = |u: &f64| {
            let place = 3.0 * (u - 0.01) / 0.98;
            (place - place.round()).abs() < 1e-9 && (0.0..=3.0).contains(&place.round())
        };
        assert!(rows.iter().flatten().all(on_grid));
        let [least, most] =
            [f64::min as fn(f64, f64) -> f64, f64::max].map(|end| rows.iter().flatten().copied().fold(0.5, end));
        near([least, most], [0.01, 0.99]);
        let outputs: Vec<f64> = rows.iter().map(|u| 0.98 * (4.0 * u[0] - u[1])).collect();
        let told = Morris.tell(&rows, &outputs, &settled(10, 3));
        let [importance, spread] = &Morris.shown(&told)[..] else { panic!("two measures") };
        assert_eq!((importance.name, importance.drawn), ("mu*", true));
        let exact = 0.98 * 0.98;
        holds(importance.estimates[0], [4.0 * exact; 3]);
        holds(importance.estimates[1], [exact; 3]);
        assert_eq!((spread.name, spread.drawn), ("sigma", false));
        near([0, 1].map(|i| spread.estimates[i].value), [0.0; 2]);
        assert!(spread.estimates.iter().all(|e| e.low.is_nan() && e.high.is_nan()));
        assert_eq!(Morris.shown(&Morris.tell(&rows, &[], &settled(10, 3))), []);
    }

    /// Seven steps of 2/3, three from or to a failed run: Hall's interval of the four effects, by scipy's `brentq`.
    #[test]
    fn effects_are_those_of_the_runs_that_have_values() {
        const LOST: f64 = f64::NAN;
        let outputs = [[1.0, 2.0], [2.0, 5.0], [LOST, 2.0], [3.0, 3.5], [4.0, 3.0], [LOST, LOST], [3.5, LOST]].concat();
        let rows = vec![vec![vec![0.0], vec![2.0 / 3.0]]; 7].concat();
        let [effect] = effects(&rows, &outputs).unwrap()[..] else { panic!("one parameter") };
        near([effect.mu, effect.sigma], [1.3125, 2.478_028_450_2]);
        holds(effect.mu_star, [2.0625, 0.0, 13.354_350_913_7]);
        assert_eq!(effect.used, 4);
    }

    /// An output of two values, 2 and 5: the size of an effect is 3 over the step. One of three effects is not 0:
    /// Clopper and Pearson's interval, scipy.
    #[test]
    fn a_verdict_has_effects_of_one_size() {
        let [third, two_thirds] = [1.0 / 3.0, 2.0 / 3.0];
        let rows = [[1.0, 0.0], [1.0, two_thirds], [third, two_thirds]].repeat(4);
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.to_vec()).collect();
        let mut outputs = vec![2.0; 12];
        outputs[1] = 5.0;
        outputs[2] = 5.0;
        outputs[9] = f64::NAN;
        let effect = effects(&rows, &outputs).unwrap()[1];
        holds(effect.mu_star, [1.5, 4.5 * 0.008_403_758_66, 4.5 * 0.905_700_675_95]);
        // One that is the same everywhere has none.
        let none = effects(&rows, &[5.0; 12]).unwrap();
        none.iter().for_each(|effect| holds(effect.mu_star, [0.0; 3]));
    }

    /// Two effects have a mean and a spread, one has not.
    #[test]
    fn nothing_is_told_from_a_single_effect() {
        let rows = vec![vec![vec![0.0], vec![1.0]]; 2].concat();
        assert!(effects(&rows, &[0.0, 1.0, 0.0, 2.0]).is_some());
        assert_eq!(effects(&rows, &[0.0, 1.0, 0.0, f64::NAN]), None);
        // Nor from rows of another design, or none.
        assert_eq!(effects(&rows, &[0.0, 1.0]), None);
        assert_eq!(effects(&rows[..3], &[0.0, 1.0, 0.0]), None);
        assert_eq!(effects(&vec![vec![]; 4], &[0.0; 4]), None);
        assert_eq!(effects(&[], &[]), None);
    }
}
