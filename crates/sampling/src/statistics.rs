//! Statistics of a signal over time, and of counts.
//!
//! A new statistic of a signal is a file beside `mean` with a type that implements `Collect`, its `mod` line, and its
//! line in `statistics!` below. The name in a study and the JSON Schema follow from that line.

mod collect;
mod crossing;
pub mod estimate;
mod extremes;
mod last;
mod mean;
pub mod moments;
mod oscillation;
mod percentile;
mod rms;
pub mod share;
mod slope;
mod strongest;
mod turns;

use serde::{Deserialize, Serialize};

use collect::{Collect, Scaled};

pub use collect::Trend;
pub use crossing::Direction;
pub use turns::MeanOverTurns;

/// Makes the choice of the statistics from lines of name, type and meaning.
macro_rules! statistics {
    ($($statistic:ident = $collector:ty, $meaning:literal;)*) => {
        /// Statistic that turns a signal over time into one number.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Statistic {
            $(#[doc = $meaning] $statistic,)*
        }

        impl Statistic {
            /// All of them; the first one is the usual one.
            pub const ALL: &[Self] = &[$(Self::$statistic),*];

            /// Its name in a sentence, such as "mean" in "mean of the load".
            pub fn label(self) -> &'static str {
                match self {
                    $(Self::$statistic => <$collector>::LABEL,)*
                }
            }

            /// Whether it is a difference of two values, which has no offset when units convert.
            pub fn is_difference(self) -> bool {
                match self {
                    $(Self::$statistic => <$collector>::DIFFERENCE,)*
                }
            }

            /// Its unit, where that does not follow from the signal's.
            pub fn unit(self) -> Option<&'static str> {
                match self {
                    $(Self::$statistic => <$collector>::UNIT,)*
                }
            }

            /// Whether it is the time since the first value.
            pub fn is_since_first(self) -> bool {
                match self {
                    $(Self::$statistic => <$collector>::SINCE_FIRST,)*
                }
            }

            /// Whether it means nothing for a variable that jumps between whole numbers.
            pub fn needs_lines(self) -> bool {
                match self {
                    $(Self::$statistic => <$collector>::NEEDS_LINES,)*
                }
            }

            /// How it changes when the signal moves on after the last value.
            pub fn trend(self) -> Trend {
                match self {
                    $(Self::$statistic => <$collector>::TREND,)*
                }
            }
        }

        /// Collects what a statistic of a signal needs, value by value; in constant memory, except for percentiles and
        /// oscillations.
        #[derive(Clone, Debug)]
        pub struct Accumulator(Collector);

        #[derive(Clone, Debug)]
        enum Collector {
            $($statistic($collector),)*
        }

        impl Accumulator {
            /// An accumulator for the percentile of so many percent, from 0 to 100.
            pub fn percentile(percent: f64) -> Self {
                Self(Collector::Percentile(percentile::Percentile::new(percent)))
            }

            /// An accumulator for the first crossing of a level.
            pub fn crossing(level: f64, direction: Direction) -> Self {
                Self(Collector::Crossing(crossing::Crossing::new(level, direction)))
            }

            /// An accumulator without values; for a percentile, that of the median, and for a crossing, that of zero.
            pub fn new(statistic: Statistic) -> Self {
                Self(match statistic {
                    $(Statistic::$statistic => Collector::$statistic(Default::default()),)*
                })
            }

            /// Takes values one after another, each with the time since the one before.
            #[inline]
            pub fn add_all(&mut self, values: impl Iterator<Item = (f64, f64)>) {
                match &mut self.0 {
                    $(Collector::$statistic(collector) => collector.add_all(values),)*
                }
            }

            /// The statistic of the values so far, of which there must be one, `span` being the time from the
            /// first to the last.
            pub fn result(&self, span: f64) -> f64 {
                match &self.0 {
                    $(Collector::$statistic(collector) => collector.result(span),)*
                }
            }
        }
    };
}

statistics! {
    Final = last::Last, "The value at the stop time.";
    Mean = Scaled<mean::Mean>, "The mean over time.";
    Min = extremes::Min, "The smallest value.";
    Max = extremes::Max, "The largest value.";
    Rms = Scaled<rms::Rms>, "The root of the mean square over time.";
    Amplitude = extremes::Amplitude, "Half the distance from the smallest to the largest value.";
    Slope = Scaled<slope::Slope>, "The slope of the straight line of least squares, a second.";
    Percentile = percentile::Percentile, "The value that is not exceeded for a share of the time.";
    Crossing = crossing::Crossing, "The time at which the signal first crosses a level, s.";
    Frequency = strongest::Frequency, "The frequency of the strongest oscillation, Hz.";
    OscillationAmplitude = strongest::Amplitude, "The amplitude of the strongest oscillation.";
}

impl Default for Statistic {
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl Statistic {
    /// Its name in a study.
    pub fn name(self) -> String {
        crate::word(&self)
    }
}

impl Accumulator {
    /// Takes a value, `elapsed` after the one before; the first one after zero.
    pub fn add(&mut self, elapsed: f64, value: f64) {
        self.add_all(std::iter::once((elapsed, value)));
    }

    /// The range of the values so far, where these never crossed the level whose crossing is asked for.
    pub fn uncrossed(&self) -> Option<[f64; 2]> {
        match &self.0 {
            Collector::Crossing(crossing) => crossing.uncrossed(),
            _ => None,
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
    fn the_oscillation_of_a_sine_is_the_sine() {
        let of = |statistic| of_sine(5.0, statistic).result(1.0);
        assert!((of(Statistic::Frequency) - 5.0).abs() < 1e-6);
        assert!((of(Statistic::OscillationAmplitude) - 2.0).abs() < 1e-6);
        let mut line = Accumulator::new(Statistic::OscillationAmplitude);
        line.add_all([(0.0, 3.0), (1.0, 5.0), (2.0, 9.0)].into_iter());
        assert_eq!(line.result(3.0), 0.0);
    }

    /// The studies' units, checks and warnings rest on this.
    #[test]
    fn statistics_say_what_they_are() {
        use Statistic::*;
        let those = |is: fn(Statistic) -> bool| -> Vec<Statistic> {
            Statistic::ALL.iter().copied().filter(|s| is(*s)).collect()
        };
        let differences = [Amplitude, Slope, OscillationAmplitude];
        assert_eq!(those(Statistic::is_difference), differences);
        assert_eq!(those(Statistic::is_since_first), [Crossing]);
        assert_eq!(those(Statistic::needs_lines), [Frequency, OscillationAmplitude]);
        assert_eq!(those(|s| s.unit().is_some()), [Crossing, Frequency]);
        let of_signal = those(|s| s.trend() == Trend::OfSignal);
        assert_eq!(of_signal, [Final, Mean, Rms]);
        let of_extremes = those(|s| s.trend() == Trend::OfExtremes);
        assert_eq!(of_extremes, [Min, Max, Amplitude]);
        assert_eq!([Crossing.unit(), Frequency.unit()], [Some("s"), Some("Hz")]);
    }

    /// Two straight lines, 1 s and 3 s long; the mean of a line's squares is not that of its ends.
    #[test]
    fn statistics_of_a_broken_line_are_those_of_trapezoids() {
        let of_line = |statistic| {
            let mut line = Accumulator::new(statistic);
            line.add_all([(0.0, 3.0), (1.0, 2.0), (3.0, 7.0)].into_iter());
            line.result(4.0)
        };
        assert_eq!(of_line(Statistic::Mean), (2.5 + 3.0 * 4.5) / 4.0);
        assert_eq!(of_line(Statistic::Rms), ((6.5 + 3.0 * 26.5) / 4.0_f64).sqrt());
        assert_eq!(of_line(Statistic::Amplitude), 2.5);
        assert_eq!(of_line(Statistic::Min), 2.0);
        assert_eq!(of_line(Statistic::Max), 7.0);
        assert_eq!(of_line(Statistic::Final), 7.0);
    }

    /// Sums, squares and differences of such values are beyond all numbers.
    #[test]
    fn large_values_have_the_statistics_of_small_ones() {
        let signal = [(0.0, 1.0), (1.0, -1.0), (3.0, 1.0), (2.0, 0.5), (4.0, 1.0)];
        for statistic in
            [Statistic::Mean, Statistic::Rms, Statistic::Amplitude, Statistic::Slope, Statistic::Percentile]
        {
            let of = |unit: f64| {
                let mut collector = Accumulator::new(statistic);
                collector.add_all(signal.iter().map(|&(elapsed, value)| (elapsed, unit * value)));
                collector.result(10.0) / unit
            };
            for unit in [1e160, -1e308, f64::MAX] {
                let (expected, value) = (of(unit.signum()), of(unit));
                assert!((value - expected).abs() < 1e-12, "{statistic:?}: {value}");
            }
            assert!(of(f64::NAN).is_nan());
        }
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

    /// The line of least squares through y = t^2 from 0 to T has the slope T; through |t - 1| from 0 to 4, 12 / 4^3
    /// times the integral of (t - 2) |t - 1|, which is 11 / 3.
    #[test]
    fn slopes_are_those_of_least_squares() {
        let mut line = Accumulator::new(Statistic::Slope);
        line.add_all([(0.0, 1e6), (0.5, 1e6 + 1.0), (2.5, 1e6 + 6.0)].into_iter());
        assert!((line.result(3.0) - 2.0).abs() < 1e-12);
        // A large offset takes nothing from it.
        let mut far = Accumulator::new(Statistic::Slope);
        far.add_all([(0.0, 1e15), (0.5, 1e15 + 1.0), (2.5, 1e15 + 6.0)].into_iter());
        assert_eq!(far.result(3.0), line.result(3.0));
        let mut bend = Accumulator::new(Statistic::Slope);
        bend.add_all([(0.0, 1.0), (1.0, 0.0), (3.0, 3.0)].into_iter());
        assert!((bend.result(4.0) - 0.6875).abs() < 1e-15, "{}", bend.result(4.0));
        let mut parabola = Accumulator::new(Statistic::Slope);
        for k in 0..=3000 {
            let t = 1e-3 * f64::from(k);
            parabola.add(if k == 0 { 0.0 } else { 1e-3 }, t * t);
        }
        assert!((parabola.result(3.0) - 3.0).abs() < 1e-6);
        let mut one = Accumulator::new(Statistic::Slope);
        one.add(0.0, 1.0);
        assert!(one.result(0.0).is_nan());
    }

    /// From 0 to 4 in 1 s, level for 2 s, down to 2 in 1 s, with steps that differ.
    #[test]
    fn percentiles_are_those_of_straight_lines() {
        let of = |percent: f64| {
            let mut signal = Accumulator::percentile(percent);
            let values = [(0.0, 0.0), (0.25, 1.0), (0.75, 4.0), (2.0, 4.0), (1.0, 2.0)];
            signal.add_all(values.into_iter());
            signal.result(4.0)
        };
        // Below 2 for half a second; from there to 4 the time grows by 0.75 s a unit; at 4 for 2 s.
        for (percent, expected) in [
            (0.0, 0.0),
            (6.25, 1.0),
            (9.375, 1.5),
            (12.5, 2.0),
            (12.5 + 75.0 / 4.0, 3.0),
            (50.0, 4.0),
            (75.0, 4.0),
            (100.0, 4.0),
        ] {
            assert!((of(percent) - expected).abs() < 1e-12, "{percent}: {}", of(percent));
        }
        // Where the signal jumps, the least value that it does not exceed for the share counts.
        let mut jump = Accumulator::percentile(25.0);
        jump.add_all([(0.0, 0.0), (1.0, 0.0), (0.0, 4.0), (3.0, 4.0)].into_iter());
        assert_eq!(jump.result(4.0), 0.0);
        let mut one = Accumulator::percentile(95.0);
        one.add(0.0, -3.0);
        assert_eq!(one.result(0.0), -3.0);
    }

    /// Up through 1 at 0.25 s and 3.5 s, down at 2 s; the signal stands at 3 from 1 s to 1.5 s.
    #[test]
    fn crossings_are_those_of_straight_lines() {
        let values = [(0.0, 0.0), (0.75, 3.0), (0.25, 3.0), (0.5, 3.0), (1.0, -1.0), (1.5, 3.0)];
        let at = |level: f64, direction| {
            let mut signal = Accumulator::crossing(level, direction);
            signal.add_all(values.into_iter());
            signal.result(4.0)
        };
        assert_eq!(at(1.0, Direction::Either), 0.25);
        assert_eq!(at(1.0, Direction::Rising), 0.25);
        assert_eq!(at(1.0, Direction::Falling), 2.0);
        assert_eq!(at(-0.5, Direction::Either), 2.375);
        assert_eq!(at(-0.5, Direction::Rising), 2.5 + 0.125 * 1.5);
        // It comes to its highest value without going on, and begins at zero.
        assert_eq!(at(3.0, Direction::Rising), 0.75);
        assert_eq!(at(0.0, Direction::Either), 2.25);
        assert!(at(3.5, Direction::Either).is_nan());
        let mut low = Accumulator::crossing(3.5, Direction::Either);
        low.add_all(values.into_iter());
        assert_eq!(low.uncrossed(), Some([-1.0, 3.0]));
        low.add(1.0, 4.0);
        assert_eq!(low.uncrossed(), None);
        // What comes before a crossing must be known, what comes after need not.
        let broken = |place: usize| {
            let mut signal = Accumulator::crossing(1.0, Direction::Falling);
            let value = |(k, (elapsed, value))| (elapsed, if k == place { f64::NAN } else { value });
            signal.add_all(values.into_iter().enumerate().map(value));
            signal.result(4.0)
        };
        assert!(broken(0).is_nan() && broken(2).is_nan() && broken(4).is_nan());
        assert_eq!(broken(5), 2.0);
        // There is no straight line to an infinite value.
        let mut infinite = Accumulator::crossing(1.0, Direction::Rising);
        infinite.add_all([(0.0, 0.0), (0.5, f64::INFINITY), (0.5, 2.0)].into_iter());
        assert!(infinite.result(1.0).is_nan());
    }

    #[test]
    fn not_a_number_is_not_lost() {
        // The last value, and the first beyond a level, are of one instant.
        let single = [Statistic::Final, Statistic::Crossing];
        for &statistic in Statistic::ALL.iter().filter(|statistic| !single.contains(statistic)) {
            let mut broken = of_sine(1.0, statistic);
            broken.add(1.0, f64::NAN);
            broken.add(1.0, 1.0);
            assert!(broken.result(3.0).is_nan(), "{statistic:?}");
        }
    }

    #[test]
    fn statistics_are_named_as_in_a_study() {
        let names: Vec<String> = Statistic::ALL.iter().map(|statistic| statistic.name()).collect();
        for name in [
            "final",
            "mean",
            "min",
            "max",
            "rms",
            "amplitude",
            "slope",
            "percentile",
            "crossing",
            "frequency",
            "oscillation-amplitude",
        ] {
            assert!(names.iter().any(|known| known == name), "{name}");
        }
        assert_eq!(Statistic::default().name(), "final");
    }
}
