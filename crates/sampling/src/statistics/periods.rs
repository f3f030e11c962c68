//! The mean over whole periods of a signal.

use super::turns::SCALE;

/// A value, and the signal whose periods count, over time; both on straight lines.
///
/// A period goes from one rise of the signal through the middle of its range to the next. A rise counts once the signal has
/// come from the lowest quarter of its range to the highest one: noise and smaller waves are no periods. Where it passes the
/// middle more than once on its way, the last time counts. The range is known at the end only, so everything is kept.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanOverPeriods {
    /// Time since the first row, the value, the signal.
    rows: Vec<[f64; 3]>,
}

impl MeanOverPeriods {
    /// Takes a value and the signal at it, `elapsed` after the one before; the first one after zero.
    pub fn add(&mut self, elapsed: f64, value: f64, signal: f64) {
        let time = self.rows.last().map_or(0.0, |[time, ..]| time + elapsed);
        self.rows.push([time, SCALE * value, SCALE * signal]);
    }

    /// The mean from the first rise to the last one; not a number where there are not two of them (one alone makes 0 / 0), and
    /// where a value or the signal is none.
    pub fn result(&self) -> f64 {
        let Some([from, to]) = self.ends() else { return f64::NAN };
        let pieces = self.rows.windows(2).filter_map(|pair| {
            let ([before, low, _], [after, high, _]) = (pair[0], pair[1]);
            let (begin, end) = (before.max(from), after.min(to));
            let middle = (0.5 * (begin + end) - before) / (after - before);
            (begin < end).then_some((end - begin) * (low + middle * (high - low)))
        });
        pieces.sum::<f64>() / (to - from) / SCALE
    }

    /// The first rise and the last one.
    fn ends(&self) -> Option<[f64; 2]> {
        const ROUNDING: f64 = 1e-12;
        if self.rows.iter().flatten().any(|number| !number.is_finite()) {
            return None;
        }
        let signal = || self.rows.iter().map(|row| row[2]);
        let least = signal().fold(f64::INFINITY, f64::min);
        let most = signal().fold(f64::NEG_INFINITY, f64::max);
        let (middle, range) = (0.5 * (least + most), most - least);
        if range <= ROUNDING * least.abs().max(most.abs()) {
            return None;
        }
        let [low, high] = [middle - 0.25 * range, middle + 0.25 * range];
        let (mut was_low, mut passed) = (false, None);
        let mut ends: Option<[f64; 2]> = None;
        for (k, [time, _, now]) in self.rows.iter().enumerate() {
            if let Some([before, _, last]) = k.checked_sub(1).map(|k| self.rows[k])
                && last < middle
                && *now >= middle
            {
                passed = Some(before + (middle - last) / (now - last) * (time - before));
            }
            if *now <= low {
                was_low = true;
            } else if *now >= high && was_low {
                was_low = false;
                let rise = passed?;
                ends = Some([ends.map_or(rise, |[first, _]| first), rise]);
            }
        }
        ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn mean(periods: f64, value: impl Fn(f64) -> f64, signal: impl Fn(f64) -> f64) -> f64 {
        let mut mean = MeanOverPeriods::default();
        let count = (2000.0 * periods) as u32;
        for k in 0..=count {
            let turned = f64::from(k) / 2000.0;
            let elapsed = if k == 0 { 0.0 } else { 0.01 };
            mean.add(elapsed, value(turned), signal(turned));
        }
        mean.result()
    }

    /// Over whole periods the mean of a harmonic is zero, wherever the run begins and ends. The range that the run shows of
    /// the signal moves the middle, but all rises alike.
    #[test]
    fn the_part_of_a_period_does_not_count() {
        for (periods, phase) in [(3.7, 0.0), (9.2, 1.3), (2.9, 4.0)] {
            let value = |t: f64| 5.0 + (TAU * t).cos() + 0.5 * (2.0 * TAU * t).sin();
            let mean = mean(periods, value, |t| 7.0 + 2.0 * (TAU * t + phase).sin());
            assert!((mean - 5.0).abs() < 1e-6, "{periods}: {mean}");
        }
    }

    /// A line over whole periods has the value in the middle between the first rise and the last one: with a sine from its
    /// rise on these are at 1 and 4.
    #[test]
    fn a_line_has_its_value_in_the_middle() {
        let mean = mean(4.6, |t| 3.0 * t, |t| (TAU * (t - 1e-9)).sin());
        assert!((mean - 7.5).abs() < 1e-6, "{mean}");
    }

    /// A signal of few rows, with 30 in its middle, 15 a quarter above its least value and 45 a quarter below its most.
    #[test]
    fn rises_lie_between_rows() {
        let mut mean = MeanOverPeriods::default();
        let mut add = |rows: &[(f64, f64, f64)]| {
            for (elapsed, value, signal) in rows {
                mean.add(*elapsed, *value, *signal);
            }
            mean.result()
        };
        // It passes the middle at 1.75 s, falls back without a low, and passes it again: the last time counts, 2.75 s.
        let first = [
            (0.0, 7.0, 20.0),
            (1.0, 1.0, 0.0),
            (1.0, 3.0, 40.0),
            (0.5, 8.0, 20.0),
            (0.5, 0.0, 40.0),
            (0.5, 2.0, 60.0),
            (0.0, 5.0, 60.0),
        ];
        assert!(add(&first).is_nan());
        // It comes to the middle at 6 s, and stands still there.
        let second = [
            (1.0, 5.0, 15.0),
            (1.0, 5.0, 20.0),
            (0.5, 1.0, 30.0),
            (0.25, 3.0, 30.0),
            (0.25, 1.0, 45.0),
            (0.0, 2.0, 60.0),
        ];
        assert_eq!(add(&second), (0.5 + 0.5 + 5.0 + 5.0 + 1.5) / 3.25);
        // It passes the middle at 8 s.
        let third = [(1.0, 4.0, 10.0), (1.0, 9.0, 50.0)];
        let expected = (12.5 + 0.5 + 0.5 + 3.0 + 2.625) / 5.25;
        assert_eq!(add(&third), expected);
        // It falls, but not to the lowest quarter.
        assert_eq!(add(&[(1.0, 4.0, 20.0), (1.0, 9.0, 50.0)]), expected);
    }

    /// A second wave of 0.4 of the first one's amplitude, and noise at each row, make no periods.
    #[test]
    fn small_waves_are_no_periods() {
        let noise = |t: f64| 0.1 * ((7919.0 * t).sin() * 43_758.5).fract();
        let signal = |t: f64| (TAU * t).sin() + 0.4 * (3.0 * TAU * t).sin() + noise(t);
        let mean = mean(6.3, |t| (TAU * t).sin(), signal);
        assert!(mean.abs() < 5e-3, "{mean}");
    }

    #[test]
    fn without_two_rises_there_is_no_mean() {
        for signal in [
            |_: f64| 2.0,
            |t: f64| t,
            |t: f64| -t,
            |t: f64| (0.2 * TAU * t).sin(),
            |t: f64| if t > 1.0 { f64::NAN } else { (9.0 * t).sin() },
            // A constant but for rounding.
            |t: f64| 7.0 + 5e-13 * (TAU * t).sin(),
        ] {
            assert!(mean(4.0, |t| t, signal).is_nan());
        }
        assert!(!mean(4.0, |t| t, |t| 7.0 + 5e-11 * (TAU * t).sin()).is_nan());
        assert!(MeanOverPeriods::default().result().is_nan());
        let broken = |t: f64| if t > 1.0 { f64::INFINITY } else { t };
        assert!(mean(4.0, broken, |t| (TAU * t).sin()).is_nan());
    }
}
