//! Statistics of plain samples: moments, ranks, correlation, quantiles, the Kolmogorov-Smirnov distance.

use super::collect::LARGE;

/// The mean; not a number of nothing.
pub fn mean(values: &[f64]) -> f64 {
    let (sum, count) = (values.iter().sum::<f64>(), values.len() as f64);
    if sum.is_infinite() { values.iter().map(|value| value / count).sum() } else { sum / count }
}

/// The standard deviation, of which the variance may be beyond all numbers.
pub fn deviation(values: &[f64], freedom: usize) -> f64 {
    let deviation = variance(values, freedom).sqrt();
    if deviation.is_infinite() {
        let values: Vec<f64> = values.iter().map(|value| value / LARGE).collect();
        LARGE * variance(&values, freedom).sqrt()
    } else {
        deviation
    }
}

/// The root of the sum of the squares, which may be beyond all numbers themselves.
pub fn length(parts: impl Iterator<Item = f64> + Clone) -> f64 {
    let in_units = |unit: f64| {
        let squares = parts.clone().map(|part| (part / unit).powi(2));
        unit * squares.sum::<f64>().sqrt()
    };
    let length = in_units(1.0);
    if length.is_infinite() { in_units(LARGE) } else { length }
}

/// A power of two in units of which the values' squares, and the squares of these, are numbers other than 0: 1 for usual
/// values.
pub fn moderate_unit(values: impl Iterator<Item = f64>) -> f64 {
    const USUAL: std::ops::Range<f64> = 1e-60..1e60;
    const MANTISSA: u64 = (1 << 52) - 1;
    let largest = values.filter(|value| value.is_finite()).map(f64::abs).fold(0.0, f64::max);
    if largest == 0.0 || USUAL.contains(&largest) {
        1.0
    } else {
        f64::from_bits(largest.to_bits() & !MANTISSA).max(f64::MIN_POSITIVE)
    }
}

/// The variance about the mean, divided by the number of values less `freedom`.
pub fn variance(values: &[f64], freedom: usize) -> f64 {
    let m = mean(values);
    values.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (values.len() as f64 - freedom as f64)
}

/// Pearson's correlation coefficient; 0 where one of the columns is constant.
pub fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let (ma, mb) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        aa += (x - ma).powi(2);
        bb += (y - mb).powi(2);
        ab += (x - ma) * (y - mb);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// The quantile of sorted values, linear between them (Hyndman & Fan 1996, type 7).
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = q.clamp(0.0, 1.0) * last as f64;
    let (below, part) = (place.floor() as usize, place.fract());
    sorted[below] + part * (sorted[(below + 1).min(last)] - sorted[below])
}

/// The largest distance between the empirical distribution functions of two sorted samples, and the value up to which they differ so.
pub fn ks_distance(a: &[f64], b: &[f64]) -> (f64, f64) {
    let (mut i, mut j, mut most) = (0, 0, (0.0, f64::NAN));
    while i < a.len() && j < b.len() {
        let x = a[i].min(b[j]);
        while i < a.len() && a[i] <= x {
            i += 1;
        }
        while j < b.len() && b[j] <= x {
            j += 1;
        }
        let distance = (i as f64 / a.len() as f64 - j as f64 / b.len() as f64).abs();
        if distance > most.0 {
            most = (distance, x);
        }
    }
    most
}

/// Sorted copy.
pub fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn moments_of_a_few_numbers() {
        let values = [1.0, 2.0, 6.0];
        assert_eq!(mean(&values), 3.0);
        assert_eq!(variance(&values, 1), 7.0);
        assert_eq!(variance(&values, 0), 14.0 / 3.0);
        for large in [1e160, 2e307] {
            let values = values.map(|value| large * value);
            assert!((mean(&values) / large - 3.0).abs() < 1e-12);
            assert!((deviation(&values, 1) / large - 7.0_f64.sqrt()).abs() < 1e-12);
            assert!((length(values.into_iter()) / large - 41.0_f64.sqrt()).abs() < 1e-12);
        }
    }

    /// The value of `scipy.stats.pearsonr`.
    #[test]
    fn correlation_of_a_few_numbers() {
        let (a, b) = ([1.0, 2.0, 4.0, 5.0, 9.0], [2.0, -1.0, 4.0, 3.0, 7.0]);
        assert!((pearson(&a, &b) - 0.8535055952315547).abs() < 1e-15);
        assert!((pearson(&a, &b.map(|v| -1e3 * v)) + 0.8535055952315547).abs() < 1e-15);
    }

    /// Far from zero, what is left of a mean after rounding must not count.
    #[test]
    fn correlation_does_not_see_a_common_offset() {
        const FAR: f64 = 1e10;
        let a = [1.0, 2.0, 4.0, 5.0, 9.0].map(|v| v + FAR);
        let b = [2.0, -1.0, 4.0, 3.0, 7.0].map(|v| v + FAR);
        for coefficient in [pearson(&a, &b), pearson(&b, &a)] {
            assert!((coefficient - 0.8535055952315547).abs() < 1e-9, "{coefficient}");
        }
    }

    #[test]
    fn a_constant_is_correlated_with_nothing() {
        let (varied, constant) = ([1.0, 2.0, 4.0], [3.0; 3]);
        assert_eq!(pearson(&varied, &constant), 0.0);
        assert_eq!(pearson(&constant, &varied), 0.0);
    }

    #[test]
    fn sorting_loses_nothing() {
        assert_eq!(sorted(vec![3.0, -1.0, 2.0]), [-1.0, 2.0, 3.0]);
    }

    #[test]
    fn quantiles_interpolate() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.5), 2.0);
        assert_eq!(quantile(&[1.0, 2.0, 5.0], 0.75), 3.5);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn ks_of_separate_and_equal_samples() {
        assert_eq!(ks_distance(&[1.0, 2.0], &[3.0, 4.0]), (1.0, 2.0));
        assert_eq!(ks_distance(&[1.0, 2.0], &[1.0, 2.0]).0, 0.0);
    }

    #[test]
    fn ks_of_samples_with_ties_and_other_sizes() {
        let distance = |a: &[f64], b: &[f64]| [ks_distance(a, b).0, ks_distance(b, a).0];
        // At 2 all of the first sample has been seen, and two of five of the second.
        assert_eq!(distance(&[1.0, 2.0], &[1.0, 1.0, 3.0, 3.0, 3.0]), [0.6; 2]);
        // The steps are 0 - 1/4, 3/4 - 1/4, 3/4 - 2/4, 1 - 2/4.
        assert_eq!(distance(&[1.0, 1.0, 1.0, 5.0], &[0.0, 2.0, 6.0, 7.0]), [0.5; 2]);
    }

    proptest! {
        #[test]
        fn ks_is_a_distance(a in prop::collection::vec(-5.0..5.0f64, 1..40), b in prop::collection::vec(-5.0..5.0f64, 1..40)) {
            let (a, b) = (sorted(a), sorted(b));
            let d = ks_distance(&a, &b).0;
            prop_assert!((0.0..=1.0).contains(&d));
            prop_assert!((d - ks_distance(&b, &a).0).abs() < 1e-12);
        }
    }
}
