//! Shapley effects: the output's variance, divided among the parameters. They sum to 1 and are none negative, also where
//! parameters are correlated, for which Sobol indices mean nothing.
//!
//! Owen (2014), "Sobol' indices and Shapley value", SIAM/ASA J. Uncertainty Quantification 2, 245-251; Song, Nelson & Staum
//! (2016), "Shapley effects for global sensitivity analysis", same journal 4, 1060-1083; for dependent parameters Owen &
//! Prieur (2017), same journal 5, 986-1002.
//!
//! Design: two independent samples A and B. For an order of the parameters, and each beginning u of it, a point
//! whose parameters u are those of A, and whose others are distributed as B given these. In normal scores that point is
//! b + S_u (S_uu)^-1 (a_u - b_u) with the correlations S (Matheron's rule; Chilès & Delfiner 2012, "Geostatistics", section
//! 7.3), so that one point serves all orders with the same beginning. The parameter that the order adds to u explains the
//! difference of (f_A - f_u)^2 / 2 before and after. Where parameters are independent, B serves as a base, too, and the mean
//! of both is (f_after - f_before) (f_A - f_B) / 2, after Goda (2021), "A simple algorithm for global sensitivity analysis with
//! Shapley effects", Reliability Engineering & System Safety 213, 107702.

use crate::method::{KeyedResults, Measure, read};
use nalgebra::{DMatrix, DVector};
use sampling::{
    random::{Purpose, Random},
    statistics::estimate::Estimate,
};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// Up to so many correlated parameters, each pair has all their orders.
const ALL_ORDERS: usize = 3;

/// The orders of a pair: a random one, where parameters are correlated with its reverse, or all if they are few.
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
    /// Each parameter's part of the variance. They sum to 1.
    pub effects: Vec<Estimate>,
}

/// Where effects stand in what was told of an output.
pub const KEY: &str = "shapley";

/// The effects that were told of an output, as they are shown: beside Sobol's totals, which tell importance, in the table alone.
pub fn shown(told: &KeyedResults) -> Option<Measure> {
    let effects: Effects = read(told, KEY)?;
    let measure =
        if told.get("sobol").is_some_and(|sobol| !sobol.is_null()) { Measure::listed } else { Measure::drawn };
    Some(measure("Shapley effect", effects.effects))
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
    use crate::pairs::pairs;

    /// Effects by runs of the function itself.
    fn run(
        parameters: usize,
        correlation: Option<&DMatrix<f64>>,
        [count, seed]: [u64; 2],
        function: impl Fn(&[f64]) -> f64,
    ) -> Vec<f64> {
        let rows = design(&pairs(parameters, count, seed).unwrap(), correlation, seed).unwrap();
        let explained = Explained::new(parameters, count as usize, correlation.is_some(), seed);
        let outputs: Vec<f64> = rows.iter().map(|u| function(u)).collect();
        let (mut sums, mut variance) = (vec![0.0; parameters], 0.0);
        for (pair, values) in outputs.chunks(rows.len() / count as usize).enumerate() {
            sums.iter_mut().zip(explained.at(pair, values)).for_each(|(sum, term)| *sum += term);
            variance += 0.5 * (values[0] - values[1]).powi(2);
        }
        sums.iter().map(|sum| sum / variance).collect()
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

    fn sum(effects: &[f64]) -> f64 {
        effects.iter().sum()
    }

    /// Independent: half of first-order and total indices, since Ishigami's function has interactions of two only.
    #[test]
    fn effects_of_independent_parameters_are_those_of_their_interactions() {
        let shapley = run(3, None, [8192, 3], ishigami);
        let (first, total) = ishigami_indices();
        for ((effect, first), total) in shapley.iter().zip(first).zip(total) {
            assert!((effect - (first + total) / 2.0).abs() < 0.02, "{effect:?}");
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
        let shapley = run(2, Some(&chain(2, r)), [8192, 1], function);
        let variance = 2.0 + r * r;
        let exact = [1.5 / variance, (0.5 + r * r) / variance];
        for (effect, exact) in shapley.iter().zip(exact) {
            assert!((effect - exact).abs() < 0.02, "{effect:?} {exact}");
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
        let shapley = run(6, Some(&matrix), [4096, 2], function);
        let [a, b]: [f64; 2] = [2.0, 1.0];
        let rest = (1.0 - r * r) * (a * a - b * b) / 2.0;
        let joint = a * a + b * b + 2.0 * r * a * b;
        let variance = 6.0 + joint;
        let exact = [1.0, 4.0, 0.0, 1.0, joint / 2.0 + rest, joint / 2.0 - rest];
        for (effect, exact) in shapley.iter().zip(exact) {
            assert!((effect - exact / variance).abs() < 0.015, "{effect:?} {}", exact / variance);
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

    /// A normal score of the ends of the cube would be infinite. Scores that are as far as numbers tell stand for them.
    #[test]
    fn correlated_points_at_the_ends_of_the_cube_stay_in_it() {
        let ends = [vec![0.0, 1.0, 1.0, 0.0], vec![1.0, 1.0, 0.0, 0.0]];
        let rows = design(&ends, Some(&chain(2, 0.5)), 1).unwrap();
        let inside = |place: &f64| (0.0..=1.0).contains(place);
        assert!(rows.iter().flatten().all(inside), "{rows:?}");
        assert!(rows[0][0] < 1e-9 && rows[4][1] > 1.0 - 1e-9, "{rows:?}");
    }
}
