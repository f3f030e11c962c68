//! Statistics of a signal over time, and of counts.

pub mod moments;
pub mod share;

use serde::{Deserialize, Serialize};

pub use share::wilson;

/// Statistic that turns a signal over time into one number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// The value at the stop time.
    #[default]
    Final,
    /// The mean over time.
    Mean,
    /// The smallest value.
    Min,
    /// The largest value.
    Max,
    /// The root of the mean square over time.
    Rms,
    /// Half the distance from the smallest to the largest value.
    Amplitude,
}

/// Collects what a statistic of a signal needs, value by value, in constant memory.
///
/// Means are integrals over time by the trapezoidal rule, divided by the time: over whole periods
/// of a periodic signal that is exact to all orders.
#[derive(Clone, Copy, Debug)]
pub struct Accumulator {
    statistic: Statistic,
    /// The last value, or its square where squares are integrated.
    last: f64,
    /// Twice the integral.
    integral: f64,
    min: f64,
    max: f64,
}

impl Accumulator {
    /// An accumulator without values.
    pub fn new(statistic: Statistic) -> Self {
        Self {
            statistic,
            last: 0.0,
            integral: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
        }
    }

    /// Takes a value, `elapsed` after the one before; the first one after zero.
    pub fn add(&mut self, elapsed: f64, value: f64) {
        self.add_all(std::iter::once((elapsed, value)));
    }

    /// Takes values one after another, each with the time since the one before.
    #[inline]
    pub fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        match self.statistic {
            Statistic::Mean => self.integrate(values),
            Statistic::Rms => self.integrate(values.map(|(elapsed, v)| (elapsed, v * v))),
            _ => values.for_each(|(_, value)| self.bound(value)),
        }
    }

    #[inline]
    fn integrate(&mut self, values: impl Iterator<Item = (f64, f64)>) {
        let (mut integral, mut last) = (self.integral, self.last);
        for (elapsed, value) in values {
            integral += elapsed * (last + value);
            last = value;
        }
        (self.integral, self.last) = (integral, last);
    }

    fn bound(&mut self, value: f64) {
        self.last = value;
        // A value that is not a number must not get lost.
        if value < self.min || value.is_nan() {
            self.min = value;
        }
        if value > self.max || value.is_nan() {
            self.max = value;
        }
    }

    /// The statistic of the values so far, of which there must be one, `span` being the time from the
    /// first to the last.
    pub fn result(&self, span: f64) -> f64 {
        let mean = if span > 0.0 {
            0.5 * self.integral / span
        } else {
            self.last
        };
        match self.statistic {
            Statistic::Final => self.last,
            Statistic::Mean => mean,
            Statistic::Min => self.min,
            Statistic::Max => self.max,
            Statistic::Rms => mean.sqrt(),
            Statistic::Amplitude => 0.5 * (self.max - self.min),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean and rms of a sine with this many periods in one second.
    fn of_sine(periods: f64, statistic: Statistic) -> Accumulator {
        let mut accumulator = Accumulator::new(statistic);
        for index in 0..=1000 {
            let t = f64::from(index) / 1000.0;
            let phase = std::f64::consts::TAU * periods * t;
            let elapsed = if index == 0 { 0.0 } else { 1e-3 };
            accumulator.add(elapsed, 3.0 + 2.0 * phase.sin());
        }
        accumulator
    }

    #[test]
    fn statistics_of_a_sine_are_exact_over_whole_periods() {
        let close = |statistic, expected: f64| {
            let value = of_sine(5.0, statistic).result(1.0);
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
        let of_one = |statistic| {
            let mut one = Accumulator::new(statistic);
            one.add(0.0, -2.0);
            one.result(0.0)
        };
        assert_eq!(of_one(Statistic::Mean), -2.0);
        assert_eq!(of_one(Statistic::Rms), 2.0);
    }

    #[test]
    fn not_a_number_is_not_lost() {
        for statistic in [Statistic::Mean, Statistic::Rms, Statistic::Amplitude] {
            let mut broken = of_sine(1.0, statistic);
            broken.add(1.0, f64::NAN);
            broken.add(1.0, 1.0);
            assert!(broken.result(3.0).is_nan(), "{statistic:?}");
        }
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
