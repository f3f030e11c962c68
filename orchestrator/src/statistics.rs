//! Statistics of a signal over time, and of counts.

use crate::study::Statistic;

/// Collects a signal value by value, in constant memory.
///
/// Means are integrals over time by the trapezoidal rule, divided by the time: over whole periods
/// of a periodic signal that is exact to all orders.
#[derive(Clone, Copy, Debug)]
pub struct Accumulator {
    first: f64,
    time: f64,
    value: f64,
    integral: f64,
    square: f64,
    min: f64,
    max: f64,
    empty: bool,
}

impl Default for Accumulator {
    fn default() -> Self {
        Self {
            first: 0.0,
            time: 0.0,
            value: 0.0,
            integral: 0.0,
            square: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            empty: true,
        }
    }
}

impl Accumulator {
    /// Takes the value at a time not before the last one.
    #[inline]
    pub fn add(&mut self, time: f64, value: f64) {
        if self.empty {
            self.first = time;
            self.empty = false;
        } else {
            let half = 0.5 * (time - self.time);
            self.integral += half * (self.value + value);
            self.square += half * (self.value * self.value + value * value);
        }
        self.time = time;
        self.value = value;
        // A value that is not a number must not get lost.
        self.min = if value < self.min || value.is_nan() {
            value
        } else {
            self.min
        };
        self.max = if value > self.max || value.is_nan() {
            value
        } else {
            self.max
        };
    }

    /// A statistic of the values so far; not a number without any.
    pub fn value(&self, statistic: Statistic) -> f64 {
        let span = self.time - self.first;
        let over_time = |integral: f64, single: f64| {
            if span > 0.0 { integral / span } else { single }
        };
        match statistic {
            _ if self.empty => f64::NAN,
            Statistic::Final => self.value,
            Statistic::Mean => over_time(self.integral, self.value),
            Statistic::Min => self.min,
            Statistic::Max => self.max,
            Statistic::Rms => over_time(self.square, self.value * self.value)
                .max(0.0)
                .sqrt(),
            Statistic::Amplitude => 0.5 * (self.max - self.min),
        }
    }
}

/// The 95 % interval of a probability of which `hits` of `total` trials are known
/// (Wilson 1927, eq. 4: the probabilities within 1.96 standard deviations of the observed share).
#[allow(clippy::cast_precision_loss)]
pub fn wilson(hits: u64, total: u64) -> [f64; 2] {
    const Z: f64 = 1.959_963_984_540_054;
    if total == 0 {
        return [0.0, 1.0];
    }
    let (n, share) = (total as f64, hits as f64 / total as f64);
    let centre = share + Z * Z / (2.0 * n);
    let spread = Z * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    let scale = 1.0 + Z * Z / n;
    let low = if hits == 0 {
        0.0
    } else {
        (centre - spread) / scale
    };
    let high = if hits == total {
        1.0
    } else {
        (centre + spread) / scale
    };
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine(periods: f64) -> Accumulator {
        let mut accumulator = Accumulator::default();
        for index in 0..=1000 {
            let t = f64::from(index) / 1000.0;
            let phase = std::f64::consts::TAU * periods * t;
            accumulator.add(t, 3.0 + 2.0 * phase.sin());
        }
        accumulator
    }

    #[test]
    fn statistics_of_a_sine_are_exact_over_whole_periods() {
        let sine = sine(5.0);
        let close = |statistic, expected: f64| {
            let value = sine.value(statistic);
            assert!((value - expected).abs() < 1e-12, "{statistic:?} {value}");
        };
        close(Statistic::Mean, 3.0);
        close(Statistic::Rms, 11.0_f64.sqrt());
        close(Statistic::Amplitude, 2.0);
        close(Statistic::Min, 1.0);
        close(Statistic::Max, 5.0);
        close(Statistic::Final, 3.0);
    }

    #[test]
    fn a_single_value_is_its_own_mean() {
        let mut one = Accumulator::default();
        one.add(7.0, -2.0);
        assert_eq!(one.value(Statistic::Mean), -2.0);
        assert_eq!(one.value(Statistic::Rms), 2.0);
    }

    #[test]
    fn not_a_number_is_not_lost() {
        let mut broken = sine(1.0);
        broken.add(2.0, f64::NAN);
        broken.add(3.0, 1.0);
        assert!(broken.value(Statistic::Mean).is_nan());
    }

    #[test]
    fn wilson_matches_published_values() {
        // Newcombe (1998), table I: 81 of 263 gives 0.2553..0.3662, 15 of 148 gives 0.0624..0.1605.
        let close = |hits, total, expected: [f64; 2]| {
            let interval = wilson(hits, total);
            for (value, expected) in interval.iter().zip(expected) {
                assert!((value - expected).abs() < 5e-5, "{interval:?}");
            }
        };
        close(81, 263, [0.2553, 0.3662]);
        close(15, 148, [0.0624, 0.1605]);
        assert_eq!(wilson(0, 20)[0], 0.0);
        assert_eq!(wilson(20, 20)[1], 1.0);
    }
}
