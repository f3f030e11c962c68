//! Binning: histograms and ranges that keep a plot readable at any number of points.

/// The part of an axis where the points are: the data and the interval that matters, without
/// the few far outliers that would squeeze all else. `None` without any finite value.
///
/// Left off are values further than six interquartile ranges outside the quartiles.
pub fn axis_range(values: impl IntoIterator<Item = f64>, lower: f64, upper: f64) -> Option<[f64; 2]> {
    let mut sorted: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
    if sorted.is_empty() {
        return None;
    }
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |q: f64| sorted[((sorted.len() - 1) as f64 * q).round() as usize];
    let reach = 6.0 * (at(0.75) - at(0.25));
    let (mut low, mut high) = if reach > 0.0 {
        let (a, b) = (at(0.25) - reach, at(0.75) + reach);
        let inside = |v: &&f64| **v >= a && **v <= b;
        (*sorted.iter().find(inside)?, *sorted.iter().rev().find(inside)?)
    } else {
        (sorted[0], sorted[sorted.len() - 1])
    };
    for limit in [lower, upper].into_iter().filter(|l| l.is_finite()) {
        low = low.min(limit);
        high = high.max(limit);
    }
    let margin = if high > low { 0.05 * (high - low) } else { (0.05 * high.abs()).max(1e-12) };
    // Beyond this, the axis would have no length that is a number.
    const WIDEST: f64 = 8e307;
    let range = [(low - margin).max(-WIDEST), (high + margin).min(WIDEST)];
    Some(if range[0] < range[1] { range } else { [-WIDEST, WIDEST] })
}

/// Counts of values in equal bins over a range; what lies outside is not counted.
pub fn histogram<'a>(values: impl Iterator<Item = &'a f64>, range: [f64; 2], bins: usize) -> Vec<usize> {
    let mut counts = vec![0; bins];
    for &v in values {
        if let Some(k) = bin(v, range, bins) {
            counts[k] += 1;
        }
    }
    counts
}

/// The number of bins for a number of values: the Rice rule, within what a small plot can show.
pub fn bins_for(n: usize) -> usize {
    ((2.0 * (n as f64).cbrt()) as usize).clamp(6, 48)
}

/// The bin of a value, if it lies in the range.
pub fn bin(value: f64, [low, high]: [f64; 2], bins: usize) -> Option<usize> {
    if !(value >= low && value <= high) || high <= low {
        return None;
    }
    Some((((value - low) / (high - low) * bins as f64) as usize).min(bins - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn an_outlier_does_not_squeeze_the_axis() {
        let mut values: Vec<f64> = (0..100).map(|i| f64::from(i) / 100.0).collect();
        values.push(1e9);
        values.push(f64::NAN);
        let [low, high] = axis_range(values, -0.5, f64::INFINITY).unwrap();
        assert!(low < -0.5 && high < 2.0);
        assert_eq!(axis_range([f64::NAN], 0.0, 1.0), None);
    }

    #[test]
    fn an_axis_has_a_length_whatever_the_values() {
        for values in [&[1e308, -1e308][..], &[f64::MAX; 3], &[1e160, 0.86], &[5e-324], &[-f64::MAX]] {
            let [low, high] = axis_range(values.iter().copied(), f64::NEG_INFINITY, f64::INFINITY).unwrap();
            assert!(low < high && (high - low).is_finite(), "{values:?}: {low} {high}");
        }
    }

    proptest! {
        #[test]
        fn no_value_on_the_axis_is_lost(values in prop::collection::vec(-1e6..1e6f64, 1..200), bins in 1usize..60) {
            let range = axis_range(values.iter().copied(), f64::NEG_INFINITY, f64::INFINITY).unwrap();
            let on_axis = values.iter().filter(|v| **v >= range[0] && **v <= range[1]).count();
            prop_assert_eq!(histogram(values.iter(), range, bins).iter().sum::<usize>(), on_axis);
        }
    }
}
