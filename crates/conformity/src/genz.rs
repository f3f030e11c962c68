//! Probabilities that three or more correlated normal errors lie between limits.

use std::{f64::consts::TAU, sync::LazyLock};

use super::{
    lattice::Lattice,
    normal::{GaussLegendre, between},
    tabulated,
};

/// The aim for the error of a probability.
const ACCURACY: f64 = 2e-5;
/// The most errors that are integrated by nested quadrature; more are integrated on a lattice.
const NESTED: usize = 6;
/// The aim on a lattice.
const ON_LATTICE: f64 = 5e-5;
/// Where less than this is left of a number's variance given the others, it is too sharp a function of them for nested
/// rules.
const SHARP: f64 = 0.02;
/// A part below this adds nothing.
const NOTHING: f64 = 1e-10;
/// Beyond this many standard deviations a number adds nothing.
const FAR: f64 = 5.0;
const MOST_NODES: usize = 64;
/// Where less than this is left of a variance of 1 given the others, an error follows from them.
const SINGULAR: f64 = 1e-9;

/// The lower triangle of the Cholesky factor of a correlation matrix. `None` when no random numbers
/// have such correlations, or when one of them follows from the others.
pub fn cholesky(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let size = matrix.len();
    let mut factor = vec![vec![0.0; size]; size];
    for j in 0..size {
        for i in j..size {
            let explained: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            let rest = matrix[i][j] - explained;
            factor[i][j] = match i == j {
                true if rest < SINGULAR => return None,
                true => rest.sqrt(),
                false => rest / factor[j][j],
            };
        }
    }
    Some(factor)
}

/// The probability that correlated standard normal numbers all lie between their limits.
///
/// Genz (1992), "Numerical computation of multivariate normal probabilities", J. Computational and
/// Graphical Statistics 1: the box becomes the unit cube by conditioning each number on those
/// before it. Few numbers are integrated one after the other by Gauss-Legendre rules; more of them, and such that nearly
/// follow from others, on a [lattice](Lattice).
pub fn probability(correlation: &[Vec<f64>], lower: &[f64], upper: &[f64]) -> f64 {
    let alone = lower.iter().zip(upper).map(|(&a, &b)| between(a, b));
    let most = alone.clone().fold(1.0, f64::min);
    let least = 1.0 - alone.map(|p| 1.0 - p).sum::<f64>();
    let (least, size) = (least.max(0.0), lower.len());
    if most - least < ACCURACY {
        // Bonferroni's bounds leave nothing open.
        return 0.5 * (most + least);
    }
    let (factor, limits) = ordered(correlation, lower, upper);
    let sharp = (0..size).any(|k| factor[k][k].powi(2) < SHARP);
    let probability = if sharp || size > NESTED {
        Lattice::new(factor, limits).probability(ON_LATTICE)
    } else {
        let cube = Cube { factor, limits };
        cube.inner(&mut Vec::with_capacity(size), &cube.scales(), 1.0)
    };
    probability.clamp(least, most)
}

/// The Cholesky factor of the correlations, and the limits, in the order of the integrals: each number has the least probable
/// interval of those that are left, if those before it have their mean values (Gibson, Glasbey and Elston 1994; Genz and Bretz
/// 2009, "Computation of multivariate normal and t probabilities", 4.1.3). This leaves the least variation to the integral.
fn ordered(correlation: &[Vec<f64>], lower: &[f64], upper: &[f64]) -> (Vec<Vec<f64>>, Vec<[f64; 2]>) {
    let size = lower.len();
    let mut rest: Vec<usize> = (0..size).collect();
    let (mut order, mut means) = (Vec::with_capacity(size), Vec::with_capacity(size));
    let mut rows = vec![vec![0.0; size]; size];
    for k in 0..size {
        let given = |i: usize| {
            let row = &rows[i][..k];
            let known: f64 = row.iter().zip(&means).map(|(c, mean)| c * mean).sum();
            let variance = 1.0 - row.iter().map(|c| c * c).sum::<f64>();
            // The matrix was accepted in another order: only rounding can get below.
            let deviation = variance.max(SINGULAR * SINGULAR).sqrt();
            ([lower[i], upper[i]].map(|limit| (limit - known) / deviation), deviation)
        };
        let (place, chance) = rest
            .iter()
            .map(|&i| {
                let [a, b] = given(i).0;
                between(a, b)
            })
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("a number is left for each place");
        let next = rest.remove(place);
        let ([a, b], pivot) = given(next);
        means.push(mean_between(a, b, chance));
        let before = rows[next][..k].to_vec();
        rows[next][k] = pivot;
        for &i in &rest {
            let explained: f64 = rows[i].iter().zip(&before).map(|(x, y)| x * y).sum();
            rows[i][k] = (correlation[i][next] - explained) / pivot;
        }
        order.push(next);
    }
    let limits = order.iter().map(|&i| [lower[i], upper[i]]).collect();
    (order.into_iter().map(|i| rows[i].clone()).collect(), limits)
}

/// The mean of a normal number between two limits, given the probability of that.
fn mean_between(lower: f64, upper: f64, chance: f64) -> f64 {
    let density = |z: f64| (-0.5 * z * z).exp() / TAU.sqrt();
    let mean = (density(lower) - density(upper)) / chance;
    if mean.is_finite() { mean.clamp(lower, upper) } else { 0.0_f64.clamp(lower, upper) }
}

/// The rules with so many nodes.
static RULES: LazyLock<Vec<Vec<[f64; 2]>>> = LazyLock::new(|| {
    (0..=MOST_NODES).map(|nodes| GaussLegendre::new(nodes.max(2)).on_unit_interval().collect()).collect()
});

/// The box as a unit cube.
struct Cube {
    factor: Vec<Vec<f64>>,
    limits: Vec<[f64; 2]>,
}

impl Cube {
    /// Over which length of each number the conditional probability of those after it changes.
    fn scales(&self) -> Vec<f64> {
        let size = self.factor.len();
        (0..size)
            .map(|k| {
                self.factor[k + 1..]
                    .iter()
                    .map(|row| {
                        let left: f64 = row[k + 1..].iter().map(|part| part * part).sum();
                        left.sqrt() / row[k].abs()
                    })
                    .fold(1.0, f64::min)
            })
            .collect()
    }

    /// The conditional probability of the remaining numbers by nested quadrature, given the first ones, which have this
    /// weight.
    ///
    /// The nodes are as many as the interval needs: measured on a thousand random boxes of three to five numbers, the
    /// largest error is 1e-5.
    fn inner(&self, scores: &mut Vec<f64>, scales: &[f64], weight: f64) -> f64 {
        let [lower, upper] = self.limits(scores);
        let done = scores.len();
        if done + 1 == self.factor.len() {
            return (tabulated::cdf(upper) - tabulated::cdf(lower)).max(0.0);
        }
        let (lower, width) = (lower.max(-FAR), upper.min(FAR) - lower.max(-FAR));
        if width <= 0.0 {
            return 0.0;
        }
        let nodes = (3.0 + 1.2 * width / scales[done]).ceil() as usize;
        let mut sum = 0.0;
        for &[share, part] in &RULES[nodes.min(MOST_NODES)] {
            let score = lower + share * width;
            let part = part * width * (-0.5 * score * score).exp() / TAU.sqrt();
            if part * weight >= NOTHING {
                scores.push(score);
                sum += part * self.inner(scores, scales, part * weight);
                scores.pop();
            }
        }
        sum
    }

    /// The limits of the next number, given those before it.
    fn limits(&self, scores: &[f64]) -> [f64; 2] {
        let next = scores.len();
        let row = &self.factor[next];
        let known: f64 = row.iter().zip(scores).map(|(c, y)| c * y).sum();
        self.limits[next].map(|limit| (limit - known) / row[next])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::cdf;

    fn equicorrelated(size: usize, correlation: f64) -> Vec<Vec<f64>> {
        let entry = |i, j| if i == j { 1.0 } else { correlation };
        let row = |i| (0..size).map(|j| entry(i, j)).collect();
        (0..size).map(row).collect()
    }

    /// Reference for equal positive correlations: given a common part the numbers are independent; one integral is left.
    #[test]
    fn equal_correlations_agree_with_the_integral_over_the_common_part() {
        let lower = [-1.0, -2.0, -0.3, -1.5, -3.0, -2.0, -2.5, -1.2];
        let upper = [1.5, 0.7, 2.0, 1.0, 1.2, 0.9, 3.0, 1.1];
        for size in 3..=8 {
            for correlation in [0.1, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.999_999_f64] {
                let spread = (1.0 - correlation).sqrt();
                let given = |z: f64| {
                    let limit = |bound: f64| (bound - correlation.sqrt() * z) / spread;
                    let each = |k| between(limit(lower[k]), limit(upper[k]));
                    (0..size).map(each).product::<f64>() * (-0.5 * z * z).exp()
                };
                // Four steps or more for the width in which a limit is passed, which is that of a normal distribution.
                let steps = if correlation > 0.99 { 64_000 } else { 2_000 };
                let sum: f64 = (0..=steps).map(|i| given(-8.0 + 16.0 * f64::from(i) / f64::from(steps))).sum();
                let expected = sum * 16.0 / f64::from(steps) / TAU.sqrt();
                let matrix = equicorrelated(size, correlation);
                let probability = probability(&matrix, &lower[..size], &upper[..size]);
                let error = (probability - expected).abs();
                let aim = if size > NESTED || correlation > 0.98 { ON_LATTICE } else { ACCURACY };
                assert!(error < aim, "{size} {correlation}: {probability} {expected}");
            }
        }
    }

    /// Random correlations, weak and strong: given two of four numbers, the other two have a bivariate probability that
    /// is known to 1e-12, and a fine rule integrates it over the first two.
    #[test]
    fn four_numbers_agree_with_the_integral_over_two_of_them() {
        use crate::normal::between_both;
        use rand::{RngExt, SeedableRng, rngs::StdRng};
        let mut random = StdRng::seed_from_u64(1);
        let fine = GaussLegendre::new(40);
        let on = |[from, to]: [f64; 2]| {
            let [from, to] = [from.max(-7.0), to.min(7.0).max(from.max(-7.0))];
            let scale = move |[x, w]: [f64; 2]| {
                let z = from + x * (to - from);
                [z, w * (to - from) * (-0.5 * z * z).exp() / TAU.sqrt()]
            };
            fine.on_unit_interval().map(scale).collect::<Vec<_>>()
        };
        for trial in 0..60 {
            let (common, single) = (random.random_range(0.0..2.0), 0.3);
            let directions: Vec<Vec<f64>> =
                (0..4).map(|_| (0..3).map(|_| common * random.random_range(-1.0..1.0)).collect()).collect();
            let covariance = |i: usize, j: usize| {
                let shared: f64 = (0..3).map(|k| directions[i][k] * directions[j][k]).sum();
                shared + if i == j { single } else { 0.0 }
            };
            let entry = |i, j| covariance(i, j) / f64::sqrt(covariance(i, i) * covariance(j, j));
            let row = |i| (0..4).map(|j| entry(i, j)).collect();
            let matrix: Vec<Vec<f64>> = (0..4).map(row).collect();
            let lower: Vec<f64> = (0..4).map(|_| random.random_range(-3.0..0.5)).collect();
            let upper: Vec<f64> = lower.iter().map(|a| a + random.random_range(0.5..4.0)).collect();
            let l = cholesky(&matrix).unwrap();
            let spread = l[3][2].hypot(l[3][3]);
            let mut expected = 0.0;
            for [x, weight_x] in on([lower[0], upper[0]]) {
                let limit = |bound: f64| (bound - l[1][0] * x) / l[1][1];
                for [y, weight_y] in on([limit(lower[1]), limit(upper[1])]) {
                    let rest = |bounds: &[f64]| {
                        let rest = |k: usize| bounds[k] - l[k][0] * x - l[k][1] * y;
                        [rest(2) / l[2][2], rest(3) / spread]
                    };
                    let both = between_both(rest(&lower), rest(&upper), l[3][2] / spread);
                    expected += weight_x * weight_y * both;
                }
            }
            let probability = probability(&matrix, &lower, &upper);
            let error = (probability - expected).abs();
            assert!(error < 2e-5, "{trial}: {probability} {expected}");
        }
    }

    /// Numbers of a few common parts and next to nothing of their own nearly follow from each other. Simulated draws tell
    /// their probability.
    fn simulated(draws: u32, own_parts: &[f64], accuracy: f64) {
        use rand::{RngExt, SeedableRng, rngs::StdRng};
        use rand_distr::{Distribution, StandardNormal};
        let mut random = StdRng::seed_from_u64(3);
        for (trial, &part) in own_parts.iter().enumerate() {
            let (size, parts) = (3 + trial % 6, 2 + trial % 3);
            let mut rows: Vec<Vec<f64>> =
                (0..size).map(|_| (0..parts).map(|_| random.random_range(-1.0..1.0)).collect()).collect();
            for row in &mut rows {
                let length = (row.iter().map(|x| x * x).sum::<f64>() + part * part).sqrt();
                row.iter_mut().for_each(|x| *x /= length);
            }
            let rest = |row: &[f64]| (1.0 - row.iter().map(|x| x * x).sum::<f64>()).sqrt();
            let entry =
                |i: usize, j: usize| if i == j { 1.0 } else { rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum() };
            let row = |i| (0..size).map(|j| entry(i, j)).collect();
            let matrix: Vec<Vec<f64>> = (0..size).map(row).collect();
            let lower: Vec<f64> = (0..size).map(|_| random.random_range(-3.0..-0.5)).collect();
            let upper: Vec<f64> = lower.iter().map(|a| a + random.random_range(1.0..4.0)).collect();
            let mut inside = 0_u32;
            for _ in 0..draws {
                let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
                let common: Vec<f64> = (0..parts).map(|_| normal()).collect();
                let within = rows.iter().zip(lower.iter().zip(&upper)).all(|(row, (a, b))| {
                    let shared: f64 = row.iter().zip(&common).map(|(x, z)| x * z).sum();
                    let value = shared + rest(row) * normal();
                    *a < value && value < *b
                });
                inside += u32::from(within);
            }
            let expected = f64::from(inside) / f64::from(draws);
            let fine = probability(&matrix, &lower, &upper);
            let chance = (expected * (1.0 - expected) / f64::from(draws)).sqrt();
            let error = (fine - expected).abs();
            println!("{size} {parts} {part}: {fine:.6}, {error:.1e}, by chance {chance:.1e}");
            assert!(error < 4.0 * chance + accuracy, "{size} {part}: {fine} {expected}");
        }
    }

    #[test]
    fn numbers_that_nearly_follow_from_others_agree_with_simulated_ones() {
        simulated(200_000, &[0.3, 0.1, 0.03, 0.01, 0.003, 0.001], ON_LATTICE);
    }

    #[test]
    #[ignore = "ten million draws for each of 24 matrices; run by scripts/test --long"]
    fn numbers_that_nearly_follow_from_others_agree_with_ten_million_draws() {
        let own_parts: Vec<f64> = (0..24).map(|k| 10.0_f64.powf(-0.15 * f64::from(k))).collect();
        simulated(10_000_000, &own_parts, ON_LATTICE);
    }

    /// The probability of the octant is 1/8 + the sum of the arcsines / (4 pi) (Sheppard 1899).
    #[test]
    fn octants_have_their_known_probability() {
        let [a, b, c] = [0.4, -0.3, 0.6_f64];
        let matrix = vec![vec![1.0, a, b], vec![a, 1.0, c], vec![b, c, 1.0]];
        let expected = 0.125 + (a.asin() + b.asin() + c.asin()) / (4.0 * std::f64::consts::PI);
        let probability = probability(&matrix, &[0.0; 3], &[f64::INFINITY; 3]);
        assert!((probability - expected).abs() < ACCURACY, "{probability} {expected}");
    }

    #[test]
    fn contradictions_have_no_factor() {
        let mut matrix = equicorrelated(3, 0.9);
        (matrix[0][2], matrix[2][0]) = (-0.9, -0.9);
        assert!(cholesky(&matrix).is_none());
        assert!(cholesky(&equicorrelated(3, 0.999)).is_some());
        assert!(cholesky(&equicorrelated(3, -0.499)).is_some());
        assert!(cholesky(&equicorrelated(3, -0.5)).is_none());
    }

    #[test]
    fn boxes_far_away_or_wide_need_no_integral() {
        let matrix = equicorrelated(4, 0.5);
        assert!(probability(&matrix, &[9.0; 4], &[10.0; 4]) < 1e-12);
        let wide = probability(&matrix, &[-5.0; 4], &[5.0; 4]);
        let bound = 1.0 - 8.0 * cdf(-5.0);
        assert!(wide >= bound && wide <= 1.0, "{wide}");
    }
}
