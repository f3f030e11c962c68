//! A percentile over time.

use super::collect::Collect;

/// A signal of straight lines, and the share of its time that the percentile leaves below. An exact quantile needs all
/// values, so they are kept until the result is known.
#[derive(Clone, Debug)]
pub struct Percentile {
    share: f64,
    /// Time since the value before, and the value.
    values: Vec<(f64, f64)>,
}

impl Default for Percentile {
    /// The median.
    fn default() -> Self {
        Self::new(50.0)
    }
}

impl Percentile {
    /// The percentile of so many percent, from 0 (the smallest value) to 100 (the greatest one).
    pub fn new(percent: f64) -> Self {
        Self { share: 0.01 * percent, values: Vec::new() }
    }

    /// The time for which the signal is at most `level`, or below it.
    fn time_below(&self, level: f64, or_equal: bool) -> f64 {
        self.values
            .windows(2)
            .map(|pair| {
                let ((_, begin), (elapsed, end)) = (pair[0], pair[1]);
                let (low, high) = (begin.min(end), begin.max(end));
                if high < level || or_equal && high == level {
                    elapsed
                } else if low >= level {
                    0.0
                } else {
                    elapsed * ((level - low) / (high - low))
                }
            })
            .sum()
    }
}

impl Collect for Percentile {
    const LABEL: &'static str = "percentile";

    fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        self.values.extend(values);
    }

    /// The least value for which the signal is at most as large for the share of the time.
    ///
    /// Between neighbours among the values that the signal takes at the ends of its lines, the time below a level grows
    /// linearly with the level. So bisection finds these neighbours, and a straight line the level. A line that is level
    /// makes the time jump.
    fn result(&self, _: f64) -> f64 {
        let mut levels: Vec<f64> = self.values.iter().map(|(_, value)| *value).collect();
        if levels.iter().any(|level| level.is_nan()) {
            return f64::NAN;
        }
        levels.sort_unstable_by(f64::total_cmp);
        levels.dedup();
        let (Some(&least), Some(&greatest)) = (levels.first(), levels.last()) else { return f64::NAN };
        if (greatest - least).is_infinite() && least.is_finite() && greatest.is_finite() {
            let values = self.values.iter().map(|(elapsed, value)| (*elapsed, 0.25 * value)).collect();
            return 4.0 * Self { values, ..*self }.result(0.0);
        }
        let wanted = self.share * self.time_below(greatest, true);
        let place = levels.partition_point(|&level| self.time_below(level, true) < wanted);
        let Some(before) = place.checked_sub(1) else { return least };
        let Some(&high) = levels.get(place) else { return greatest };
        let low = levels[before];
        let [at_low, at_high] = [self.time_below(low, true), self.time_below(high, false)];
        if wanted >= at_high {
            return high;
        }
        low + (high - low) * ((wanted - at_low) / (at_high - at_low))
    }
}
