//! Joint probabilities of many correlated normal numbers, and of such that nearly follow from others, by a lattice rule.

use std::sync::LazyLock;

use super::tabulated;

/// Independent copies of the lattice; their scatter tells the error.
const SHIFTS: usize = 8;
const FIRST_POINTS: u64 = 16;
const MOST_POINTS: u64 = 1 << 14;
/// Beyond this many of its standard deviations a number adds nothing.
const FAR: f64 = 5.5;
/// A number that follows from an earlier one, but for this part of the earlier one's scatter, cuts its range.
const SHARP: f64 = 0.5;
/// A product below this adds nothing.
const NOTHING: f64 = 1e-10;
/// The generating vector of the lattice; its order of dimensions does not matter much here.
const GENERATORS: [u64; 10] = [1, 182_667, 469_891, 498_753, 110_745, 446_247, 250_185, 118_627, 245_333, 283_199];

/// A box whose numbers are conditioned on those before them (Genz 1992): the factor of their correlations and their
/// limits, in the order of the integral.
pub struct Lattice {
    factor: Vec<Vec<f64>>,
    limits: Vec<[f64; 2]>,
    /// For each number those after it that nearly follow from it and earlier ones, with their standard deviations given
    /// these.
    followers: Vec<Vec<(usize, f64)>>,
}

impl Lattice {
    pub fn new(factor: Vec<Vec<f64>>, limits: Vec<[f64; 2]>) -> Self {
        let size = factor.len();
        let left = |row: &[f64]| row.iter().map(|part| part * part).sum::<f64>().sqrt();
        let of = |k: usize| {
            (k + 1..size)
                .map(|j| (j, left(&factor[j][k + 1..=j])))
                .filter(|(j, left)| *left < SHARP * factor[*j][k].abs())
                .collect()
        };
        Self { followers: (0..size).map(of).collect(), factor, limits }
    }

    /// The probability with about this error, on a lattice that grows (Cools, Kuo and Nuyens 2006, "Constructing
    /// embedded lattice rules for multivariate integration", SIAM J. Scientific Computing 28) with the tent
    /// transformation (Hickernell 2002). Its shifts are random but always the same, so that equal boxes have equal
    /// probabilities.
    pub fn probability(&self, accuracy: f64) -> f64 {
        let first = self.first_points();
        let mut sums = [0.0; SHIFTS];
        let mut points = first;
        let mut known = vec![0.0; self.factor.len()];
        loop {
            // The even points of a lattice are those of the one with half as many.
            let (from, every) = if points == first { (0, 1) } else { (1, 2) };
            for (shifts, sum) in SHIFT.iter().zip(&mut sums) {
                let new = (from..points).step_by(every);
                *sum += new.map(|point| self.at(shifts, point, points, &mut known)).sum::<f64>();
            }
            let n = SHIFTS as f64;
            let means = sums.map(|sum| sum / points as f64);
            let mean = means.iter().sum::<f64>() / n;
            let squares: f64 = means.iter().map(|m| (m - mean).powi(2)).sum();
            let error = 3.0 * (squares / (n * (n - 1.0))).sqrt();
            if error < accuracy || points >= MOST_POINTS {
                return mean;
            }
            points *= 2;
        }
    }

    /// So many points that some fall where a number that nearly follows from others leaves its limits: fewer could all
    /// miss it, and would agree on a wrong result.
    fn first_points(&self) -> u64 {
        let followers = self.followers.iter().enumerate();
        let sharpest = followers
            .flat_map(|(k, followers)| followers.iter().map(move |&(j, left)| left / self.factor[j][k].abs()))
            .fold(1.0, f64::min);
        let wanted = (1.0 / sharpest).ceil() as u64;
        wanted.next_power_of_two().clamp(FIRST_POINTS, MOST_POINTS)
    }

    /// The integrand at a point of a shifted lattice: the product of the conditional probabilities. `known` is the part
    /// of each number that the ones before it explain.
    fn at(&self, shifts: &[f64], point: u64, points: u64, known: &mut [f64]) -> f64 {
        known.fill(0.0);
        let (size, of_one) = (self.factor.len(), 1.0 / points as f64);
        let mut product = 1.0;
        for k in 0..size {
            let [lower, upper] = self.range(k, known, self.factor[k][k]);
            if lower >= upper {
                return 0.0;
            }
            let [below, to] = [tabulated::cdf(lower), tabulated::cdf(upper)];
            product *= to - below;
            if k + 1 == size || product < NOTHING {
                return product;
            }
            // The number of points is a power of two.
            let turn = (GENERATORS[k % GENERATORS.len()] * point) & (points - 1);
            let place = turn as f64 * of_one + shifts[k % shifts.len()];
            let tent = (2.0 * place.fract() - 1.0).abs();
            let score = tabulated::quantile(below + tent * (to - below)).max(lower).min(upper);
            for (row, known) in self.factor.iter().zip(known.iter_mut()).skip(k + 1) {
                *known += row[k] * score;
            }
        }
        product
    }

    /// Between which scores a number lies within its limits, and those within theirs that nearly follow from it. Without
    /// the latter nearly all points of the lattice would find nothing.
    fn range(&self, k: usize, known: &[f64], deviation: f64) -> [f64; 2] {
        let [mut lower, mut upper] = self.limits[k].map(|limit| (limit - known[k]) / deviation);
        for &(j, left) in &self.followers[k] {
            let part = self.factor[j][k];
            let [a, b] = self.limits[j].map(|limit| (limit - known[j]) / part);
            let room = FAR * left / part.abs();
            lower = lower.max(a.min(b) - room);
            upper = upper.min(a.max(b) + room);
        }
        [lower, upper]
    }
}

/// Shifts in [0, 1) for so many dimensions (SplitMix64 of Steele, Lea and Flood 2014); more use them again.
static SHIFT: LazyLock<[[f64; 64]; SHIFTS]> = LazyLock::new(|| {
    let of = |shift: usize, k: usize| {
        let mut x = (((shift as u64) << 32) | (k as u64 + 1)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
    };
    std::array::from_fn(|shift| std::array::from_fn(|k| of(shift, k)))
});
