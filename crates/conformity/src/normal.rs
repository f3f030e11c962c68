//! Probabilities that one or two normal errors lie between limits.

use std::{
    f64::consts::{FRAC_PI_2, SQRT_2, TAU},
    sync::LazyLock,
};

/// The probability that a standard normal number is below `z`.
pub fn cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

/// The probability that a standard normal number lies between two limits, either of which may be
/// infinite.
pub fn between(lower: f64, upper: f64) -> f64 {
    if lower >= upper {
        0.0
    } else if lower > 0.0 {
        // Far above the mean both distribution functions round to 1: subtract the small tails.
        cdf(-lower) - cdf(-upper)
    } else {
        cdf(upper) - cdf(lower)
    }
}

/// The logarithm of the probability that a standard normal number lies between two limits, also where it is too small for a
/// number.
pub fn ln_between(lower: f64, upper: f64) -> f64 {
    if lower >= upper {
        return f64::NEG_INFINITY;
    }
    // The lower tail keeps its digits.
    let [lower, upper] = if lower > 0.0 { [-upper, -lower] } else { [lower, upper] };
    let most = ln_cdf(upper);
    most + (-(ln_cdf(lower) - most).exp_m1()).ln()
}

/// The logarithm of the probability that a standard normal number is below `z`.
fn ln_cdf(z: f64) -> f64 {
    /// Farther below, four terms of the asymptotic series give all digits (Abramowitz & Stegun 1964, 26.2.12).
    const FAR: f64 = -30.0;
    if z > FAR {
        return cdf(z).ln();
    }
    let square = z.powi(-2);
    let series = square * (-1.0 + square * (3.0 + square * (-15.0 + 105.0 * square)));
    series.ln_1p() - 0.5 * z * z - (-z * TAU.sqrt()).ln()
}

/// The probability that both of two standard normal numbers with this correlation lie between
/// their limits.
///
/// The derivative of a bivariate normal probability with respect to the correlation is the density
/// at the corner (Plackett 1954, "A reduction formula for normal multivariate integrals",
/// Biometrika 41). It is integrated from independence over the arcsine of the correlation, where it
/// is smooth (Drezner and Wesolowsky 1990, "On the computation of the bivariate normal integral",
/// J. Statistical Computation and Simulation 35).
pub fn between_both(lower: [f64; 2], upper: [f64; 2], correlation: f64) -> f64 {
    if correlation.abs() >= 1.0 {
        return identical(lower, upper, correlation > 0.0);
    }
    let alone = [0, 1].map(|k| between(lower[k], upper[k]));
    if alone[0].min(alone[1]) < NOTHING {
        return 0.0;
    }
    let independent = alone[0] * alone[1];
    let mut dependent = 0.0;
    for [sine, cosine, weight] in angles(correlation) {
        let density = |h, k| weight * density(h, k, sine, cosine);
        dependent += density(upper[0], upper[1]) - density(lower[0], upper[1]);
        dependent += density(lower[0], lower[1]) - density(upper[0], lower[1]);
    }
    (independent + dependent).clamp(0.0, 1.0)
}

/// Less than the rounding of a joint probability.
const NOTHING: f64 = 1e-17;

/// The same of two numbers that are equal, or opposite.
fn identical(lower: [f64; 2], upper: [f64; 2], equal: bool) -> f64 {
    let second = if equal { [lower[1], upper[1]] } else { [-upper[1], -lower[1]] };
    between(lower[0].max(second[0]), upper[0].min(second[1]))
}

/// The density of the two numbers at a correlation, times the cosine of its arcsine.
fn density(h: f64, k: f64, correlation: f64, cosine: f64) -> f64 {
    if !(h.is_finite() && k.is_finite()) {
        return 0.0;
    }
    // h^2 - 2 h k r + k^2 without the cancellation at correlations near -1 and 1.
    let side = correlation.signum();
    let square = (h - side * k).powi(2) + 2.0 * h * k * (side - correlation);
    (-square / (2.0 * cosine * cosine)).exp() / TAU
}

/// Sines, cosines and weights of an integral over the angle from 0 to the arcsine of a correlation.
fn angles(correlation: f64) -> impl Iterator<Item = [f64; 3]> {
    let (end, side) = (correlation.abs().asin(), correlation.signum());
    let first = Some([0.0, 0.0]);
    // The density changes ever faster near a correlation of 1: the pieces shrink towards it.
    std::iter::successors(first, move |[_, start]| {
        let stop = end.min(start + 0.6 * (FRAC_PI_2 - start));
        (*start < end).then_some([*start, stop])
    })
    .skip(1)
    .flat_map(move |[start, stop]| {
        let (middle, half) = (0.5 * (start + stop), 0.5 * (stop - start));
        TWENTY.0.iter().map(move |[node, weight]| {
            let (sine, cosine) = (middle + half * node).sin_cos();
            [side * sine, cosine, side * half * weight]
        })
    })
}

static TWENTY: LazyLock<GaussLegendre> = LazyLock::new(|| GaussLegendre::new(20));

/// Nodes and weights of a Gauss-Legendre rule on (-1, 1).
pub(super) struct GaussLegendre(Vec<[f64; 2]>);

impl GaussLegendre {
    /// The rule with this number of nodes: the zeros of the Legendre polynomial, by Newton's method.
    pub fn new(nodes: usize) -> Self {
        Self(
            (0..nodes)
                .map(|i| {
                    let guess = std::f64::consts::PI * (i as f64 + 0.75) / (nodes as f64 + 0.5);
                    let mut node = guess.cos();
                    let mut slope = 0.0;
                    for _ in 0..8 {
                        let value;
                        [value, slope] = legendre(nodes, node);
                        node -= value / slope;
                    }
                    [node, 2.0 / ((1.0 - node * node) * slope * slope)]
                })
                .collect(),
        )
    }

    /// The same on (0, 1).
    pub fn on_unit_interval(&self) -> impl Iterator<Item = [f64; 2]> {
        self.0.iter().map(|[node, weight]| [0.5 * (1.0 + node), 0.5 * weight])
    }
}

/// The Legendre polynomial of a degree of at least 2, and its derivative.
fn legendre(degree: usize, x: f64) -> [f64; 2] {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=degree {
        let n = k as f64;
        let next = ((2.0 * n - 1.0) * x * value - (n - 1.0) * before) / n;
        (before, value) = (value, next);
    }
    [value, degree as f64 * (x * value - before) / (x * x - 1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_of_one_number() {
        // Abramowitz and Stegun (1964), table 26.1.
        assert!((cdf(1.96) - 0.975_002_104_851_779_5).abs() < 1e-15);
        assert!((between(-2.0, 2.0) - 0.954_499_736_103_642).abs() < 1e-14);
        let tail = between(10.0, 11.0);
        assert!((tail / 7.619_853_024_160_593e-24 - 1.0).abs() < 1e-3);
        assert_eq!(between(-11.0, -10.0), tail);
        assert_eq!(between(f64::NEG_INFINITY, f64::INFINITY), 1.0);
        assert_eq!(between(1.0, 1.0), 0.0);
        assert_eq!(between(1.0, -1.0), 0.0);
    }

    /// The probability of the quadrant is 1/4 + asin(correlation) / (2 pi) (Sheppard 1899).
    #[test]
    fn quadrants_have_sheppards_probability() {
        const FREE: f64 = f64::INFINITY;
        for correlation in [-0.999_999, -0.95, -0.3, 0.0, 0.5, 0.925, 0.99, 0.999_999_9] {
            let expected = 0.25 + f64::asin(correlation) / TAU;
            let probability = between_both([0.0, 0.0], [FREE, FREE], correlation);
            assert!((probability - expected).abs() < 1e-14, "{correlation}: {probability}");
        }
    }

    /// Conditional on the first number the second one is normal: one integral remains, here by
    /// Simpson's rule.
    #[test]
    fn two_numbers_agree_with_the_integral_over_the_first() {
        let limits = [
            ([-1.0, -2.0], [0.5, 1.0]),
            ([0.3, 0.2], [0.9, 2.5]),
            ([-3.0, 1.0], [-1.0, 1.5]),
            ([-2.0, -2.0], [2.0, 2.0]),
            ([1.0, -4.0], [4.0, -0.5]),
        ];
        for (lower, upper) in limits {
            for correlation in [-0.99, -0.9, -0.4, 0.1, 0.6, 0.93, 0.995] {
                let spread = f64::sqrt(1.0 - correlation * correlation);
                let integrand = |x: f64| {
                    let limit = |bound: f64| (bound - correlation * x) / spread;
                    (-0.5 * x * x).exp() / TAU.sqrt() * between(limit(lower[1]), limit(upper[1]))
                };
                let expected = simpson(integrand, lower[0], upper[0], 20_000);
                let probability = between_both(lower, upper, correlation);
                let error = (probability - expected).abs();
                assert!(error < 1e-12, "{lower:?} {upper:?} {correlation}: {error}");
            }
        }
    }

    #[test]
    fn boxes_beyond_all_rounding_have_no_probability() {
        assert_eq!(between_both([9.0, -1.0], [10.0, 1.0], 0.5), 0.0);
        assert_eq!(between_both([-1.0, 9.0], [1.0, 10.0], 0.5), 0.0);
    }

    /// A Gauss-Legendre rule of five nodes is exact to the ninth power: the integral of x^k from 0 to 1 is 1 / (k + 1).
    #[test]
    fn five_nodes_integrate_the_ninth_power() {
        let rule: Vec<[f64; 2]> = GaussLegendre::new(5).on_unit_interval().collect();
        for power in 0..10 {
            let integral: f64 = rule.iter().map(|[x, weight]| weight * x.powi(power)).sum();
            let expected = 1.0 / f64::from(power + 1);
            assert!((integral - expected).abs() < 1e-14, "{power}: {integral}");
        }
    }

    #[test]
    fn equal_and_opposite_numbers() {
        let (lower, upper) = ([-1.0, 0.2], [0.5, 3.0]);
        assert_eq!(between_both(lower, upper, 1.0), between(0.2, 0.5));
        assert_eq!(between_both(lower, upper, -1.0), between(-1.0, -0.2));
        let near = between_both(lower, upper, 1.0 - 1e-12);
        assert!((near - between(0.2, 0.5)).abs() < 1e-6, "{near}");
    }

    fn simpson(f: impl Fn(f64) -> f64, from: f64, to: f64, intervals: usize) -> f64 {
        let h = (to - from) / intervals as f64;
        let weight = |i: usize| match i {
            0 => 1.0,
            i if i == intervals => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let sum: f64 = (0..=intervals).map(|i| weight(i) * f(from + i as f64 * h)).sum();
        sum * h / 3.0
    }
}
