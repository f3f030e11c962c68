//! Normal numbers that are correlated through one common part: given that part they are independent, so that one integral
//! is left, however many they are and however strongly they are correlated.

use std::{f64::consts::TAU, sync::LazyLock};

use super::normal::{GaussLegendre, between};

/// Beyond this many standard deviations nothing is left.
const FAR: f64 = 9.0;
/// A piece that a rule integrates to 1e-12: so many standard deviations of the common part.
const PIECE: f64 = 3.0;
/// The step from 0 to 1 of a probability is cut here, in its own standard deviations.
const STEP: [f64; 5] = [-FAR, -3.5, 0.0, 3.5, FAR];

static RULE: LazyLock<Vec<[f64; 2]>> = LazyLock::new(|| GaussLegendre::new(20).on_unit_interval().collect());

/// Standard normal numbers, each the common part times its loading plus an independent part.
#[derive(Clone, Debug)]
pub struct OneFactor {
    loadings: Vec<f64>,
}

impl OneFactor {
    /// The common part of numbers with these correlations; none if there is no such one. Correlations of three numbers
    /// have one if the product of the three is positive and each product of two is no larger than the third.
    pub fn of(correlation: &[Vec<f64>]) -> Option<Self> {
        const ROUNDING: f64 = 1e-12;
        let [first, second, _, ..] = correlation else { return None };
        // Each correlation is the product of two loadings.
        let square = first[1] * first[2] / second[2];
        if !(square > 0.0 && square <= 1.0 + ROUNDING) {
            return None;
        }
        let loading = square.sqrt().min(1.0);
        let loadings: Vec<f64> = (0..first.len()).map(|k| if k == 0 { loading } else { first[k] / loading }).collect();
        let is_product =
            |i: usize, j: usize| i == j || (correlation[i][j] - loadings[i] * loadings[j]).abs() <= ROUNDING;
        let all = 0..loadings.len();
        let fits = all.clone().all(|i| all.clone().all(|j| is_product(i, j)))
            && loadings.iter().all(|l| l.abs() <= 1.0 + ROUNDING && *l != 0.0);
        fits.then(|| Self { loadings: loadings.iter().map(|l| l.clamp(-1.0, 1.0)).collect() })
    }

    /// The probability that every one of the correlated numbers lies between its own limits.
    pub fn probability(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let numbers = || self.loadings.iter().zip(lower.iter().zip(upper));
        let (mut from, mut to) = (-FAR, FAR);
        let mut cuts: Vec<f64> = Vec::new();
        for (&loading, (&lower, &upper)) in numbers() {
            let width = deviation(loading) / loading.abs();
            let [a, b] = [lower / loading, upper / loading];
            from = from.max(a.min(b) - FAR * width);
            to = to.min(a.max(b) + FAR * width);
            if width < 1.0 {
                let steps = [a, b].into_iter().filter(|edge| edge.is_finite());
                cuts.extend(steps.flat_map(|edge| STEP.map(|part| edge + part * width)));
            }
        }
        cuts.extend((0..=6).map(|k| -FAR + PIECE * f64::from(k)));
        cuts.retain(|cut| *cut > from && *cut < to);
        cuts.extend([from, to]);
        cuts.sort_by(f64::total_cmp);
        let given = |common: f64| {
            let each = numbers().map(|(&loading, (&lower, &upper))| match deviation(loading) {
                // The number is the common part, or its opposite; the cuts lie at its limits.
                0.0 => 1.0,
                deviation => between((lower - loading * common) / deviation, (upper - loading * common) / deviation),
            });
            each.product::<f64>() * (-0.5 * common * common).exp()
        };
        let piece = |[start, end]: [f64; 2]| {
            let width = (end - start).max(0.0);
            let sum: f64 = RULE.iter().map(|[at, weight]| weight * given(start + at * width)).sum();
            sum * width
        };
        let pieces = cuts.windows(2).map(|ends| piece([ends[0], ends[1]]));
        (pieces.sum::<f64>() / TAU.sqrt()).clamp(0.0, 1.0)
    }
}

/// The standard deviation of the independent part of a number.
fn deviation(loading: f64) -> f64 {
    ((1.0 - loading) * (1.0 + loading)).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::between_both;

    fn matrix(loadings: &[f64]) -> Vec<Vec<f64>> {
        let entry = |i: usize, j: usize| {
            if i == j { 1.0 } else { loadings[i] * loadings[j] }
        };
        let size = loadings.len();
        (0..size).map(|i| (0..size).map(|j| entry(i, j)).collect()).collect()
    }

    #[test]
    fn the_common_part_is_found() {
        let loadings = [0.5, -0.8, 0.3, 0.999, 1.0];
        let factor = OneFactor::of(&matrix(&loadings)).unwrap();
        for (loading, expected) in factor.loadings.iter().zip(loadings) {
            assert!((loading - expected).abs() < 1e-12, "{loading} {expected}");
        }
        for [a, b, c] in [[0.5, 0.5, -0.5], [0.5, 0.5, 0.0], [0.9, 0.9, 0.7], [0.0, 0.5, 0.5]] {
            let other = vec![vec![1.0, a, b], vec![a, 1.0, c], vec![b, c, 1.0]];
            assert!(OneFactor::of(&other).is_none(), "{a} {b} {c}");
        }
        let mut four = matrix(&[0.5, 0.6, 0.7, 0.8]);
        (four[2][3], four[3][2]) = (0.57, 0.57);
        assert!(OneFactor::of(&four).is_none());
        assert!(OneFactor::of(&matrix(&[0.5, 0.5])).is_none());
    }

    /// Of a number without limits nothing remains: two are left, whose probability is known.
    #[test]
    fn two_limited_numbers_have_their_bivariate_probability() {
        let (low, high) = (f64::NEG_INFINITY, f64::INFINITY);
        for loadings in [[0.5, -0.8, 0.3], [0.999, 0.9999, -0.5], [1.0, 0.7, 0.9], [-1.0, 0.999_999, 0.2]] {
            let numbers = OneFactor::of(&matrix(&loadings)).unwrap();
            for (lower, upper) in [
                ([-1.0, -0.4, low], [0.7, 2.0, high]),
                ([0.3, low, low], [high, 0.8, high]),
                ([-0.01, -0.02, low], [0.01, 0.03, high]),
                ([2.0, 1.9, low], [2.5, 2.2, high]),
            ] {
                let [lower, upper]: [[f64; 3]; 2] = [lower, upper];
                let expected = between_both([lower[0], lower[1]], [upper[0], upper[1]], loadings[0] * loadings[1]);
                let probability = numbers.probability(&lower, &upper);
                let error = (probability - expected).abs();
                assert!(error < 1e-11, "{loadings:?} {lower:?}: {probability} {expected}");
            }
        }
    }

    /// The probability of the octant is 1/8 + the sum of the arcsines / (4 pi) (Sheppard 1899), and of equally correlated
    /// numbers with a correlation of 1/2 that of all being positive 1/(n + 1).
    #[test]
    fn octants_have_their_known_probability() {
        let numbers = OneFactor::of(&matrix(&[0.9, -0.7, 0.4])).unwrap();
        let probability = numbers.probability(&[0.0; 3], &[f64::INFINITY; 3]);
        let angles = (-0.63_f64).asin() + 0.36_f64.asin() + (-0.28_f64).asin();
        let expected = 0.125 + angles / (2.0 * TAU);
        assert!((probability - expected).abs() < 1e-12, "{probability} {expected}");
        for size in 3..=12 {
            let numbers = OneFactor::of(&matrix(&vec![0.5_f64.sqrt(); size])).unwrap();
            let probability = numbers.probability(&vec![0.0; size], &vec![f64::INFINITY; size]);
            let expected = 1.0 / (size as f64 + 1.0);
            assert!((probability - expected).abs() < 1e-12, "{size}: {probability}");
        }
    }
}
