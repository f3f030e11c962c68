//! Shapley effects: the output's variance, divided among the parameters. They sum to 1 and are none negative, also where
//! parameters are correlated, for which Sobol indices mean nothing.
//!
//! Owen (2014), "Sobol' indices and Shapley value", SIAM/ASA J. Uncertainty Quantification 2, 245-251; Song, Nelson & Staum
//! (2016), "Shapley effects for global sensitivity analysis", same journal 4, 1060-1083; for dependent parameters Owen &
//! Prieur (2017), same journal 5, 986-1002.
//!
//! Design: two independent samples A and B. For an order of the parameters, and each beginning u of it, a run at the point
//! whose parameters u are those of A, and whose others are distributed as B given these. In normal scores that point is
//! b + S_u (S_uu)^-1 (a_u - b_u) with the correlations S (Matheron's rule; Chilès & Delfiner 2012, "Geostatistics", section
//! 7.3), so that one run serves all orders with the same beginning. The parameter that the order adds to u explains the
//! difference of (f_A - f_u)^2 / 2 before and after. Where parameters are independent, B serves as a base, too, and the mean
//! of both is (f_after - f_before) (f_A - f_B) / 2, after Goda (2021), "A simple algorithm for global sensitivity analysis with
//! Shapley effects", Reliability Engineering & System Safety 213, 107702.

use crate::{
    method::{Facts, FromRuns, Measure, Settled, Space, Told, read},
    pairs::pairs,
    ratio::{self, Parts},
};
use nalgebra::{DMatrix, DVector};
use sampling::{
    random::{Purpose, Random},
    statistics::estimate::Estimate,
};
use serde::{Deserialize, Serialize};
use serde_json::json;
use statrs::distribution::{ContinuousCDF, Normal};

/// Up to so many correlated parameters, each base point has all their orders.
const ALL_ORDERS: usize = 3;

/// Shapley effects by runs of its own.
#[derive(Clone, Copy, Debug)]
pub struct Shapley;

impl FromRuns for Shapley {
    fn facts(&self) -> Facts {
        Facts {
            name: "shapley",
            option: "shapley",
            words: ["Shapley effects from", "base points"],
            usual_size: 256,
            tried_size: 64,
            takes_correlations: true,
        }
    }

    fn runs(&self, space: &Space, size: u64) -> u64 {
        size * width(space.parameters, space.correlation.is_some()) as u64
    }

    fn design(&self, space: &Space, settled: &Settled) -> Result<Vec<Vec<f64>>, String> {
        let pairs = pairs(space.parameters, settled.size, settled.seed)?;
        design(&pairs, space.correlation.as_ref(), settled.seed)
    }

    fn tell(&self, design: &[Vec<f64>], values: &[f64], settled: &Settled) -> Told {
        let effects = effects(values, design.first().map_or(0, Vec::len), settled);
        Told::from_iter([("shapley".to_owned(), json!(effects))])
    }

    fn shown(&self, told: &Told) -> Vec<Measure> {
        let effects: Option<Effects> = read(told, "shapley");
        // Beside totals, which tell importance, they stand in the table.
        let measure =
            if told.get("sobol").is_some_and(|sobol| !sobol.is_null()) { Measure::listed } else { Measure::drawn };
        effects.map(|effects| measure("Shapley effect", effects.effects)).into_iter().collect()
    }
}

/// Runs of each base point.
fn width(parameters: usize, correlated: bool) -> usize {
    match (correlated, parameters) {
        (true, ..=ALL_ORDERS) => 1 << parameters,
        (true, d) => 2 * d,
        (false, d) => d + 1,
    }
}

/// The orders of a base point: a random one, where parameters are correlated with its reverse, or all if they are few.
fn orders(parameters: usize, correlated: bool, random: &mut Random) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> = (0..parameters).collect();
    if correlated && parameters <= ALL_ORDERS {
        return permutations(&order);
    }
    random.shuffle(&mut order);
    let reverse: Vec<usize> = order.iter().rev().copied().collect();
    if correlated { vec![order, reverse] } else { vec![order] }
}

fn permutations(of: &[usize]) -> Vec<Vec<usize>> {
    if of.is_empty() {
        return vec![Vec::new()];
    }
    of.iter()
        .flat_map(|&first| {
            let rest: Vec<usize> = of.iter().copied().filter(|&k| k != first).collect();
            let rest = permutations(&rest).into_iter();
            rest.map(move |rest| [vec![first], rest].concat())
        })
        .collect()
}

/// The first `count` parameters of an order, as a set.
fn beginning(order: &[usize], count: usize) -> Vec<usize> {
    let mut set = order[..count].to_vec();
    set.sort_unstable();
    set
}

/// The distinct beginnings of some orders, but for the empty one and the whole.
fn beginnings(orders: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = Vec::new();
    for order in orders {
        for count in 1..order.len() {
            let set = beginning(order, count);
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
    }
    sets
}

/// The rows of the design in the unit cube, for every pair in the order A, B, mixed points.
///
/// `pairs` are points of a sample of 2 d dimensions: the first d are A's, the last d are B's. The correlations are those of
/// normal scores.
///
/// # Errors
/// When the correlations contradict each other.
pub fn design(pairs: &[Vec<f64>], correlation: Option<&DMatrix<f64>>, seed: u64) -> Result<Vec<Vec<f64>>, String> {
    let mut random = Random::new(seed, Purpose::Order, 0);
    const CONTRADICTION: &str = "the correlations contradict each other";
    let factor = correlation.map(|matrix| matrix.clone().cholesky().ok_or(CONTRADICTION));
    let factor = factor.transpose()?.map(|factor| factor.l());
    let mut rows = Vec::new();
    for pair in pairs {
        let (a, b) = pair.split_at(pair.len() / 2);
        let sets = beginnings(&orders(a.len(), correlation.is_some(), &mut random));
        let (Some(matrix), Some(factor)) = (correlation, &factor) else {
            rows.extend([a.to_vec(), b.to_vec()]);
            rows.extend(sets.iter().map(|set| {
                let mut mixed = b.to_vec();
                set.iter().for_each(|&k| mixed[k] = a[k]);
                mixed
            }));
            continue;
        };
        let [a, b] = [a, b].map(|u| factor * DVector::from_iterator(u.len(), u.iter().map(score)));
        rows.extend([places(&a), places(&b)]);
        for set in &sets {
            let mixed = conditional(&a, &b, set, matrix).ok_or(CONTRADICTION)?;
            rows.push(places(&mixed));
        }
    }
    Ok(rows)
}

/// The normal score of a place in the unit interval.
fn score(place: &f64) -> f64 {
    const END: f64 = 1e-12;
    Normal::standard().inverse_cdf(place.clamp(END, 1.0 - END))
}

/// The places of normal scores in the unit cube.
fn places(scores: &DVector<f64>) -> Vec<f64> {
    let normal = Normal::standard();
    scores.iter().map(|&score| normal.cdf(score)).collect()
}

/// Scores that are those of `a` in a set, and elsewhere those of `b` moved by what the correlations make of the difference.
fn conditional(a: &DVector<f64>, b: &DVector<f64>, set: &[usize], matrix: &DMatrix<f64>) -> Option<DVector<f64>> {
    let known = DVector::from_iterator(set.len(), set.iter().map(|&k| a[k] - b[k]));
    let weights = DMatrix::from_fn(set.len(), set.len(), |i, j| matrix[(set[i], set[j])]).cholesky()?.solve(&known);
    let mut mixed = b + matrix.select_columns(set) * weights;
    set.iter().for_each(|&k| mixed[k] = a[k]);
    Some(mixed)
}

/// Shapley effects of one output.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effects {
    /// Each parameter's part of the variance. Without failed runs they sum to 1. They have no intervals where few runs carry it.
    pub effects: Vec<Estimate>,
    /// Base points of which all runs that the parameter's effect needs have values.
    pub used: Vec<usize>,
    /// Runs without a finite value.
    pub failed: usize,
}

/// Computes the effects from the outputs of the rows of a [`design`] with the same size and seed, in its order. All effects of
/// a constant output are 0.
///
/// `None` where the number of outputs fits no such design, or too few runs have values.
pub fn effects(outputs: &[f64], parameters: usize, settled: &Settled) -> Option<Effects> {
    let outputs = &ratio::moderate(outputs);
    let width = outputs.len().checked_div(settled.size as usize)?;
    if parameters == 0 || width * settled.size as usize != outputs.len() {
        return None;
    }
    let correlated = width != self::width(parameters, false);
    if width != self::width(parameters, correlated) {
        return None;
    }
    let explained = Explained::new(parameters, settled.size as usize, correlated, settled.seed);
    let (mut terms, mut ends) = (vec![Vec::new(); parameters], Vec::new());
    for (pair, values) in outputs.chunks(width).enumerate() {
        ends.push([values[0], values[1]]);
        terms.iter_mut().zip(explained.at(pair, values)).for_each(|(terms, term)| terms.push(term));
    }
    let (variance, carriers) = (ratio::paired_variance(&ends), ratio::carriers(outputs, &ends));
    let failed = outputs.iter().filter(|v| !v.is_finite()).count();
    let mut result = Effects { effects: vec![], used: vec![], failed };
    for terms in &terms {
        let part = Parts::of(terms.iter().copied());
        result.used.push(part.used());
        result.effects.push(ratio::estimate(&part, &variance, 0.0, carriers)?);
    }
    Some(result)
}

/// What the parameters explain at each pair of a [`design`] with the same seed.
#[derive(Clone, Debug)]
pub struct Explained {
    correlated: bool,
    /// By pair, parameter and order: the places, among the values of the pair, of the points before and after it is added.
    steps: Vec<Vec<Vec<[usize; 2]>>>,
}

impl Explained {
    /// Of so many pairs.
    pub fn new(parameters: usize, pairs: usize, correlated: bool, seed: u64) -> Self {
        let mut random = Random::new(seed, Purpose::Order, 0);
        let steps = (0..pairs).map(|_| steps(&orders(parameters, correlated, &mut random))).collect();
        Self { correlated, steps }
    }

    /// What each parameter explains of the variance, by the values of a pair, in its mean over the orders.
    pub fn at(&self, pair: usize, values: &[f64]) -> Vec<f64> {
        let [a, b] = [values[0], values[1]];
        let one = |[before, after]: &[usize; 2]| {
            let [before, after] = [values[*before], values[*after]];
            if self.correlated {
                (after - before) * (a - (after + before) / 2.0)
            } else {
                (after - before) * (a - b) / 2.0
            }
        };
        self.steps[pair].iter().map(|steps| steps.iter().map(one).sum::<f64>() / steps.len() as f64).collect()
    }
}

fn steps(orders: &[Vec<usize>]) -> Vec<Vec<[usize; 2]>> {
    let sets = beginnings(orders);
    let mut steps = vec![Vec::new(); orders[0].len()];
    for order in orders {
        // From B to the whole set, which is A.
        let mut before = 1;
        for (count, &added) in (1..).zip(order) {
            let place = sets.iter().position(|set| *set == beginning(order, count));
            let after = place.map_or(0, |place| 2 + place);
            steps[added].push([before, after]);
            before = after;
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::{ishigami, ishigami_indices};
    use crate::testing::{holds, holds_nearly, lattice, of_corners, settled};

    fn run(
        parameters: usize,
        correlation: Option<&DMatrix<f64>>,
        settled: &Settled,
        function: impl Fn(&[f64]) -> f64,
    ) -> Effects {
        let pairs = pairs(parameters, settled.size, settled.seed).unwrap();
        let rows = design(&pairs, correlation, settled.seed).unwrap();
        let width = width(parameters, correlation.is_some());
        assert_eq!(rows.len(), settled.size as usize * width);
        let outputs: Vec<f64> = rows.iter().map(|u| function(u)).collect();
        effects(&outputs, parameters, settled).unwrap()
    }

    fn scores(u: &[f64]) -> Vec<f64> {
        u.iter().map(score).collect()
    }

    /// Neighbours have the correlation r.
    fn chain(parameters: usize, r: f64) -> DMatrix<f64> {
        DMatrix::from_fn(parameters, parameters, |a, b| match a.abs_diff(b) {
            0 => 1.0,
            1 => r,
            _ => 0.0,
        })
    }

    fn sum(shapley: &Effects) -> f64 {
        shapley.effects.iter().map(|e| e.value).sum()
    }

    /// Independent: half of first-order and total indices, since Ishigami's function has interactions of two only.
    #[test]
    fn effects_of_independent_parameters_are_those_of_their_interactions() {
        let shapley = run(3, None, &settled(8192, 3), ishigami);
        let (first, total) = ishigami_indices();
        for ((effect, first), total) in shapley.effects.iter().zip(first).zip(total) {
            assert!((effect.value - (first + total) / 2.0).abs() < 0.02, "{effect:?}");
        }
        assert!((sum(&shapley) - 1.0).abs() < 1e-12);
    }

    /// z1 z2 + z1 with the correlation r: V = 2 + r^2, of which z1 explains 1 + 2 r^2 and z2 3 r^2.
    #[test]
    fn effects_of_two_correlated_parameters_are_the_exact_ones() {
        let r = 0.7;
        let function = |u: &[f64]| {
            let z = scores(u);
            z[0] * z[1] + z[0]
        };
        let shapley = run(2, Some(&chain(2, r)), &settled(8192, 1), function);
        let variance = 2.0 + r * r;
        let exact = [1.5 / variance, (0.5 + r * r) / variance];
        for (effect, exact) in shapley.effects.iter().zip(exact) {
            assert!((effect.value - exact).abs() < 0.02, "{effect:?} {exact}");
        }
        assert!((sum(&shapley) - 1.0).abs() < 1e-12);
    }

    /// Owen & Prieur (2017), section 4.2: a linear function of normal numbers; z5 and z6 are correlated, the others free, so
    /// that each of the two has its own part, and half of what they share and of their interplay.
    #[test]
    fn effects_of_a_linear_function_are_those_of_the_closed_form() {
        let (r, weights) = (0.6, [1.0, 2.0, 0.0, 1.0, 2.0, 1.0]);
        let mut matrix = DMatrix::identity(6, 6);
        (matrix[(4, 5)], matrix[(5, 4)]) = (r, r);
        let function = |u: &[f64]| scores(u).iter().zip(weights).map(|(z, w)| z * w).sum();
        let shapley = run(6, Some(&matrix), &settled(4096, 2), function);
        let [a, b]: [f64; 2] = [2.0, 1.0];
        let rest = (1.0 - r * r) * (a * a - b * b) / 2.0;
        let joint = a * a + b * b + 2.0 * r * a * b;
        let variance = 6.0 + joint;
        let exact = [1.0, 4.0, 0.0, 1.0, joint / 2.0 + rest, joint / 2.0 - rest];
        for (effect, exact) in shapley.effects.iter().zip(exact) {
            assert!((effect.value - exact / variance).abs() < 0.015, "{effect:?} {}", exact / variance);
        }
        assert!((sum(&shapley) - 1.0).abs() < 1e-12);
    }

    /// Points whose scores in a set are given have the distribution of all: the means and products of scores tell.
    #[test]
    fn mixed_points_are_distributed_as_all_others() {
        let matrix = chain(4, 0.5);
        let pairs = pairs(4, 4096, 9).unwrap();
        let rows = design(&pairs, Some(&matrix), 9).unwrap();
        for place in [0, 1, 2, 4, 7] {
            let rows: Vec<Vec<f64>> = rows.iter().skip(place).step_by(8).map(|u| scores(u)).collect();
            for a in 0..4 {
                for b in 0..4 {
                    let mean = rows.iter().map(|z| z[a] * z[b]).sum::<f64>() / rows.len() as f64;
                    assert!((mean - matrix[(a, b)]).abs() < 0.05, "{place} {a} {b} {mean}");
                }
            }
        }
    }

    #[test]
    fn a_constant_output_depends_on_nothing() {
        let shapley = run(3, None, &settled(64, 1), |_| 7.1);
        assert!(shapley.effects.iter().all(|e| e.value == 0.0 && e.low == 0.0));
        assert_eq!(effects(&[1.0; 65], 3, &settled(64, 1)), None);
        assert_eq!(effects(&[], 0, &settled(0, 1)), None);
    }

    /// The way of a study: the design has A, B and the mixed points; what is told comes back when it is shown.
    #[test]
    fn a_study_shows_the_effects_of_its_design() {
        let space = Space { parameters: 3, correlation: None };
        let settled = settled(32, 5);
        let rows = Shapley.design(&space, &settled).unwrap();
        assert_eq!(rows.len() as u64, Shapley.runs(&space, 32));
        for (pair, rows) in pairs(3, 32, 5).unwrap().iter().zip(rows.chunks(4)) {
            assert_eq!(*pair, rows[..2].concat());
        }
        let outputs: Vec<f64> = rows.iter().map(|u| ishigami(u)).collect();
        let told = Shapley.tell(&rows, &outputs, &settled);
        let shapley = effects(&outputs, 3, &settled).unwrap();
        assert_eq!(shapley.failed, 0);
        let shown = Measure::drawn("Shapley effect", shapley.effects);
        assert_eq!(Shapley.shown(&told), [shown]);
        let failed = Shapley.tell(&rows, &[f64::NAN; 128], &settled);
        assert_eq!(Shapley.shown(&failed), []);
        // Correlated parameters stay together: all orders of three, two opposite ones of more.
        let correlated = |parameters: usize| Space { parameters, correlation: Some(chain(parameters, 0.5)) };
        let runs = [1, 2, 3, 4, 5].map(|d| Shapley.runs(&correlated(d), 10));
        assert_eq!(runs, [20, 40, 80, 80, 100]);
        assert!(Shapley.facts().takes_correlations);
    }

    /// Two correlated parameters, with failed runs: effects and their intervals, in numpy.
    #[test]
    fn effects_and_their_intervals_are_those_of_numpy() {
        let mut outputs = Vec::new();
        for u in lattice(64, 4) {
            let mixed = [0.7 * u[0] + 0.3 * u[1] + 0.02 * u[2], 0.4 * u[0] + 0.6 * u[1] - 0.03 * u[3]];
            outputs.extend([u[0], u[1], mixed[0], mixed[1]].map(|value| 3.0 + value));
        }
        let whole = effects(&outputs, 2, &settled(64, 1)).unwrap();
        // 62.7 of 128 runs carry the variance, and 61.9 of 125: the interval is so much wider.
        let wider = |more: f64, [value, low, high]: [f64; 3]| {
            [value, value + more * (low - value), value + more * (high - value)]
        };
        holds(whole.effects[0], wider(1.255_080_775_3, [0.634_247_770_2, 0.626_262_001_2, 0.642_233_539_3]));
        holds(whole.effects[1], wider(1.255_080_775_3, [0.365_752_229_8, 0.357_766_460_7, 0.373_737_998_8]));
        for (point, run) in [(3, 2), (17, 0), (40, 1)] {
            outputs[4 * point + run] = f64::NAN;
        }
        let shapley = effects(&outputs, 2, &settled(64, 1)).unwrap();
        assert_eq!((shapley.failed, &shapley.used), (3, &vec![61, 61]));
        holds(shapley.effects[0], wider(1.258_313_216_7, [0.638_470_768_5, 0.624_475_505_1, 0.652_466_032_0]));
        holds(shapley.effects[1], wider(1.258_313_216_7, [0.370_226_265_5, 0.359_609_159_2, 0.380_843_371_8]));
    }

    /// A verdict that is the same wherever there is one.
    #[test]
    fn a_constant_output_with_failed_runs_has_no_effects() {
        let settled = settled(32, 1);
        let mut outputs = vec![1.0; 32 * 4];
        outputs[6] = f64::NAN;
        let shapley = effects(&outputs, 3, &settled).unwrap();
        shapley.effects.iter().for_each(|effect| holds(*effect, [0.0; 3]));
        let told = Shapley.tell(&[vec![0.5; 3]], &outputs, &settled);
        assert_eq!(Shapley.shown(&told)[0].estimates, shapley.effects);
    }

    /// Of outputs that are 1 where each of the first `of` parameters of three lies above a limit, so that they have equal effects:
    /// how many of these seeds state an interval, and in how many of them each holds.
    fn held_of_corner(base: u64, of: usize, share: f64, seeds: u64) -> (u64, Vec<u64>) {
        let limit = 1.0 - share.powf(1.0 / of as f64);
        let (mut stated, mut held) = (0, vec![0; 3]);
        for seed in 0..seeds {
            let flag = |u: &[f64]| f64::from(u8::from(u[..of].iter().all(|u| *u > limit)));
            let found = run(3, None, &settled(base, 5000 + seed), flag).effects;
            // Nothing is told, or that all runs are the same.
            if found[0].low.is_nan() || found.iter().all(|effect| effect.value == 0.0) {
                continue;
            }
            stated += 1;
            for (k, effect) in found.iter().enumerate() {
                held[k] += u64::from(holds_nearly(effect, if k < of { 1.0 / of as f64 } else { 0.0 }));
            }
        }
        println!("base {base}, corner of {of}, share {share}: {stated} of {seeds} stated, held {held:?}");
        (stated, held)
    }

    #[test]
    #[ignore = "takes minutes; run by scripts/test --long"]
    fn effects_of_two_values_hold() {
        of_corners(held_of_corner);
    }

    /// A normal score of the ends of the cube would be infinite. Scores that are as far as numbers tell stand for them.
    #[test]
    fn correlated_points_at_the_ends_of_the_cube_stay_in_it() {
        let ends = [vec![0.0, 1.0, 1.0, 0.0], vec![1.0, 1.0, 0.0, 0.0]];
        let rows = design(&ends, Some(&chain(2, 0.5)), 1).unwrap();
        let inside = |place: &f64| (0.0..=1.0).contains(place);
        assert!(rows.iter().flatten().all(inside), "{rows:?}");
        assert!(rows[0][0] < 1e-9 && rows[4][1] > 1.0 - 1e-9, "{rows:?}");
    }

    #[test]
    fn nothing_is_told_of_outputs_of_another_design() {
        assert_eq!(effects(&[1.0; 6], 0, &settled(6, 1)), None);
        assert_eq!(effects(&[1.0; 160], 3, &settled(32, 1)), None);
    }
}
