//! Probabilities that three or more correlated normal errors lie between limits.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use super::normal::{GaussLegendre, between};
use super::tabulated::Tabulated;

/// The aim for the error of a probability.
const ACCURACY: f64 = 2e-5;
/// The most errors that are integrated by nested quadrature; more are integrated on a lattice.
const NESTED: usize = 6;
/// Independent copies of the lattice; their scatter tells the error.
const SHIFTS: u64 = 8;
/// A part below this adds nothing.
const NOTHING: f64 = 1e-10;
/// Beyond this many standard deviations a number adds nothing.
const FAR: f64 = 5.0;
const MOST_NODES: usize = 64;
const FIRST_POINTS: u64 = 16;
const MOST_POINTS: u64 = 1 << 13;
/// Where less than this is left of a variance of 1 given the others, an error follows from them.
const SINGULAR: f64 = 1e-9;
/// The generating vector of the lattice; its order of dimensions does not matter much here.
const GENERATORS: [u64; 10] = [
    1, 182_667, 469_891, 498_753, 110_745, 446_247, 250_185, 118_627, 245_333, 283_199,
];

/// The lower triangle of the Cholesky factor of a correlation matrix. `None` when no random numbers
/// have such correlations, or when one of them follows from the others.
pub(super) fn cholesky(matrix: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
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
/// before it. The number with the least probable interval comes first (Gibson, Glasbey and Elston
/// 1994), which leaves the least variation to the integral.
///
/// Few numbers are integrated one after the other by Gauss-Legendre rules, more of them on a lattice
/// that can grow (Cools, Kuo and Nuyens 2006, "Constructing embedded lattice rules for multivariate
/// integration", SIAM J. Scientific Computing 28) with the tent transformation (Hickernell 2002). Its
/// shifts are random but always the same, so that equal boxes have equal probabilities.
pub(super) fn probability(correlation: &[Vec<f64>], lower: &[f64], upper: &[f64]) -> f64 {
    let alone: Vec<f64> = lower
        .iter()
        .zip(upper)
        .map(|(&a, &b)| between(a, b))
        .collect();
    let most = alone.iter().copied().fold(1.0, f64::min);
    let least = 1.0 - alone.iter().map(|p| 1.0 - p).sum::<f64>();
    if most - least.max(0.0) < ACCURACY {
        // Bonferroni's bounds leave nothing open.
        return 0.5 * (most + least.max(0.0));
    }
    let mut order: Vec<usize> = (0..lower.len()).collect();
    order.sort_by(|&i, &j| alone[i].total_cmp(&alone[j]));
    let pick = |values: &[f64]| order.iter().map(|&i| values[i]).collect::<Vec<f64>>();
    let matrix: Vec<Vec<f64>> = order.iter().map(|&i| pick(&correlation[i])).collect();
    let Some(factor) = cholesky(&matrix) else {
        // The matrix was accepted in another order: only rounding can get here.
        return 0.5 * (most + least.max(0.0));
    };
    let cube = Cube {
        factor: &factor,
        lower: pick(lower),
        upper: pick(upper),
        normal: Tabulated::get(),
    };
    let small = order.len() <= NESTED;
    let found = if small { cube.nested() } else { cube.lattice() };
    found.clamp(least.max(0.0), most)
}

/// The rules with so many nodes.
static RULES: LazyLock<Vec<Vec<[f64; 2]>>> = LazyLock::new(|| {
    let rule = |nodes: usize| {
        GaussLegendre::new(nodes.max(2))
            .on_unit_interval()
            .collect()
    };
    (0..=MOST_NODES).map(rule).collect()
});

/// The box as a unit cube.
struct Cube<'a> {
    factor: &'a [Vec<f64>],
    lower: Vec<f64>,
    upper: Vec<f64>,
    normal: Tabulated,
}

impl Cube<'_> {
    /// The integral by nested quadrature.
    fn nested(&self) -> f64 {
        let mut scores = Vec::with_capacity(self.lower.len());
        self.inner(&mut scores, &self.scales(), 1.0)
    }

    /// Over which length of each number the conditional probability of those after it changes.
    fn scales(&self) -> Vec<f64> {
        let size = self.factor.len();
        let of = |k: usize| {
            let later = self.factor[k + 1..].iter().map(|row| {
                let left: f64 = row[k + 1..].iter().map(|part| part * part).sum();
                left.sqrt() / row[k].abs()
            });
            later.fold(1.0, f64::min)
        };
        (0..size).map(of).collect()
    }

    /// The conditional probability of the remaining numbers, given the first ones, which have this weight.
    ///
    /// The nodes are as many as the interval needs: measured on a thousand random boxes of three to five numbers, the
    /// largest error is 1e-5.
    fn inner(&self, scores: &mut Vec<f64>, scales: &[f64], weight: f64) -> f64 {
        let [lower, upper] = self.limits(scores);
        let done = scores.len();
        if done + 1 == self.factor.len() {
            return (self.normal.cdf(upper) - self.normal.cdf(lower)).max(0.0);
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

    /// The quantile at `share` of the number between two limits, given the probabilities below them.
    fn between(&self, [lower, upper]: [f64; 2], below: [f64; 2], share: f64) -> f64 {
        let place = below[0] + share * (below[1] - below[0]);
        self.normal.quantile(place).max(lower).min(upper)
    }

    /// The limits of the next number, given those before it.
    fn limits(&self, scores: &[f64]) -> [f64; 2] {
        let next = scores.len();
        let row = &self.factor[next];
        let known: f64 = row.iter().zip(scores).map(|(c, y)| c * y).sum();
        [self.lower[next], self.upper[next]].map(|limit| (limit - known) / row[next])
    }

    fn lattice(&self) -> f64 {
        let mut sums = [0.0; SHIFTS as usize];
        let mut points = FIRST_POINTS;
        loop {
            // The even points of a lattice are those of the one with half as many.
            let (first, every) = if points == FIRST_POINTS {
                (0, 1)
            } else {
                (1, 2)
            };
            for (shift, sum) in (0..).zip(&mut sums) {
                let new = (first..points).step_by(every);
                *sum += new.map(|k| self.at(shift, k, points)).sum::<f64>();
            }
            let n = SHIFTS as f64;
            let means = sums.map(|sum| sum / points as f64);
            let mean = means.iter().sum::<f64>() / n;
            let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
            let error = 3.0 * (squares / (n * (n - 1.0))).sqrt();
            if error < ACCURACY || points >= MOST_POINTS {
                return mean;
            }
            points *= 2;
        }
    }

    /// The integrand at a point of a shifted lattice: the product of the conditional probabilities.
    fn at(&self, shift: u64, point: u64, points: u64) -> f64 {
        let mut scores = Vec::with_capacity(self.lower.len());
        let mut product = 1.0;
        loop {
            let limits = self.limits(&scores);
            let below = limits.map(|limit| self.normal.cdf(limit));
            product *= below[1] - below[0];
            let done = scores.len();
            if done + 1 == self.factor.len() || product < NOTHING {
                return product;
            }
            let turn = GENERATORS[done % GENERATORS.len()] * point % points;
            let place = turn as f64 / points as f64 + shift_of(shift, done as u64);
            let tent = (2.0 * place.fract() - 1.0).abs();
            scores.push(self.between(limits, below, tent));
        }
    }
}

/// A number in [0, 1) for each shift and coordinate (SplitMix64 of Steele, Lea and Flood 2014).
fn shift_of(shift: u64, coordinate: u64) -> f64 {
    let mut x = (shift << 32 | (coordinate + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ x >> 31) >> 11) as f64 * 2.0_f64.powi(-53)
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
        let lower = [-1.0, -2.0, -0.3, -1.5, -3.0, -2.0, -2.5];
        let upper = [1.5, 0.7, 2.0, 1.0, 1.2, 0.9, 3.0];
        for size in 3..=7 {
            for correlation in [0.1, 0.5, 0.9, 0.99_f64] {
                let spread = (1.0 - correlation).sqrt();
                let given = |z: f64| {
                    let limit = |bound: f64| (bound - correlation.sqrt() * z) / spread;
                    let each = |k| between(limit(lower[k]), limit(upper[k]));
                    (0..size).map(each).product::<f64>() * (-0.5 * z * z).exp()
                };
                let steps = 20_000;
                let sum: f64 = (0..=steps)
                    .map(|i| given(-8.0 + 16.0 * f64::from(i) / f64::from(steps)))
                    .sum();
                let expected = sum * 16.0 / f64::from(steps) / TAU.sqrt();
                let matrix = equicorrelated(size, correlation);
                let found = probability(&matrix, &lower[..size], &upper[..size]);
                let error = (found - expected).abs();
                let aim = if size > NESTED { 3.0 } else { 1.0 } * ACCURACY;
                assert!(error < aim, "{size} {correlation}: {found} {expected}");
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
            let (common, own) = (random.random_range(0.0..2.0), 0.3);
            let directions: Vec<Vec<f64>> = (0..4)
                .map(|_| {
                    (0..3)
                        .map(|_| common * random.random_range(-1.0..1.0))
                        .collect()
                })
                .collect();
            let covariance = |i: usize, j: usize| {
                let shared: f64 = (0..3).map(|k| directions[i][k] * directions[j][k]).sum();
                shared + if i == j { own } else { 0.0 }
            };
            let entry = |i, j| covariance(i, j) / f64::sqrt(covariance(i, i) * covariance(j, j));
            let row = |i| (0..4).map(|j| entry(i, j)).collect();
            let matrix: Vec<Vec<f64>> = (0..4).map(row).collect();
            let lower: Vec<f64> = (0..4).map(|_| random.random_range(-3.0..0.5)).collect();
            let upper: Vec<f64> = lower
                .iter()
                .map(|a| a + random.random_range(0.5..4.0))
                .collect();
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
            let found = probability(&matrix, &lower, &upper);
            let error = (found - expected).abs();
            assert!(error < 2e-5, "{trial}: {found} {expected}");
        }
    }

    /// The probability of the octant is 1/8 + the sum of the arcsines / (4 pi) (Sheppard 1899).
    #[test]
    fn octants_have_their_known_probability() {
        let [a, b, c] = [0.4, -0.3, 0.6_f64];
        let matrix = vec![vec![1.0, a, b], vec![a, 1.0, c], vec![b, c, 1.0]];
        let expected = 0.125 + (a.asin() + b.asin() + c.asin()) / (4.0 * std::f64::consts::PI);
        let found = probability(&matrix, &[0.0; 3], &[f64::INFINITY; 3]);
        assert!((found - expected).abs() < ACCURACY, "{found} {expected}");
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
