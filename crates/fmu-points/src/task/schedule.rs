//! When a simulation begins, ends, and communicates.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use fmu_import::Description;

/// A remainder of the run of less than this part of a step is rounding.
const ROUNDING: f64 = 1e-6;

/// The times of a simulation, s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// Start.
    pub start: f64,
    /// Stop.
    pub stop: f64,
    /// Communication step; the last one may be shorter.
    pub step: f64,
    /// Time from which statistics count, s.
    pub window_start: f64,
    /// Go there in a single step.
    pub leap: bool,
    /// Relative tolerance for the FMU.
    pub tolerance: Option<f64>,
}

impl Schedule {
    /// The experiment that the FMU suggests; 1 s and 500 steps where it suggests nothing.
    pub fn suggested(fmu: &Description) -> Self {
        const STEPS: f64 = 500.0;
        let experiment = &fmu.default_experiment;
        let start = experiment.start.unwrap_or(0.0);
        let stop = experiment.stop.unwrap_or(start + 1.0);
        Self {
            start,
            stop,
            step: experiment.step.unwrap_or((stop - start) / STEPS),
            window_start: start,
            leap: false,
            tolerance: experiment.tolerance,
        }
    }

    /// The same for an FMU whose steps all have one size: it ends with the last whole step, and goes nowhere in a leap.
    #[must_use]
    pub fn in_whole_steps(self) -> Self {
        let steps = (self.stop - self.start) / self.step;
        let whole = (steps + ROUNDING).floor();
        let stop = if steps - whole > ROUNDING && whole > 0.0 { self.start + whole * self.step } else { self.stop };
        Self { stop, leap: false, ..self }
    }

    /// Whether the step that the FMU suggests can be meant: some suggest the step of their solver.
    ///
    /// # Errors
    /// Says how many steps it makes.
    pub fn check_suggested(&self) -> Result<(), ScheduleError> {
        const MOST: u64 = 100_000_000;
        let Self { start, stop, step, .. } = *self;
        match self.steps() {
            steps if steps > MOST => wrong(
                &[],
                format!(
                    "the FMU suggests a step of {step:?} s, which makes {steps:.0e} steps from {start:?} s to {stop:?} s; give a step",
                    steps = steps as f64
                ),
            ),
            _ => Ok(()),
        }
    }

    /// Whether the times make sense.
    ///
    /// # Errors
    /// Says which one does not.
    pub fn check(&self) -> Result<(), ScheduleError> {
        const MOST_STEPS: f64 = 1e12;
        let Self { start, stop, step, .. } = *self;
        if !(start.is_finite() && stop.is_finite() && stop > start) {
            return wrong(
                &["stop", "start"],
                format!("the stop time {stop:?} s must be later than the start {start:?} s"),
            );
        }
        if !(step > 0.0 && (stop - start) / step < MOST_STEPS) {
            return wrong(&["step"], format!("the step {step:?} s must be positive, and not absurdly small"));
        }
        // What an FMU suggests for longer runs is cut to the run before.
        if step > (stop - start) * (1.0 + 1e-9) {
            return wrong(
                &["step", "stop"],
                format!(
                    "the step {step:?} s is longer than the run from {start:?} s to {stop:?} s; make the step smaller, or stop later"
                ),
            );
        }
        if !(self.window_start >= start && self.window_start <= stop) {
            let at = self.window_start;
            return wrong(
                &["warm-up", "window"],
                format!("statistics would begin at {at} s, outside the simulation; correct warm-up or window"),
            );
        }
        if self.tolerance.is_some_and(|tolerance| tolerance.is_nan() || tolerance <= 0.0) {
            return wrong(&["tolerance"], "the tolerance must be positive".to_owned());
        }
        Ok(())
    }

    /// The number of steps. A remainder shorter than a millionth of a step is rounding and gets no step of its own.
    pub fn steps(&self) -> u64 {
        let (leap, even) = self.even();
        let steps = leap + ((self.stop - even) / self.step - ROUNDING).ceil().max(0.0) as u64;
        steps.max(1)
    }

    /// The communication points, counted once.
    pub fn points(&self) -> CommunicationPoints {
        let (leap, even) = self.even();
        let steps = self.steps();
        CommunicationPoints { schedule: *self, steps, leap, even, between: steps.saturating_sub(leap + 1) }
    }

    /// The number of the communication point at which the even steps begin.
    pub fn first_even(&self) -> u64 {
        self.even().0
    }

    /// The number of steps before the even ones, and where those begin.
    fn even(&self) -> (u64, f64) {
        if self.leap && self.window_start > self.start { (1, self.window_start) } else { (0, self.start) }
    }
}

/// Why the times of a run make no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct ScheduleError {
    /// The settings of a study on which it depends, the likeliest first.
    pub settings: &'static [&'static str],
    /// What does not make sense.
    pub message: String,
}

fn wrong(settings: &'static [&'static str], message: String) -> Result<(), ScheduleError> {
    Err(ScheduleError { settings, message })
}

/// The communication points of a [`Schedule`].
#[derive(Clone, Copy, Debug)]
pub struct CommunicationPoints {
    schedule: Schedule,
    /// The number of steps.
    pub steps: u64,
    /// Steps before the even ones, and where those begin.
    leap: u64,
    even: f64,
    /// Even steps of which neither end is the stop time.
    between: u64,
}

impl CommunicationPoints {
    /// The `index`th one.
    #[inline]
    pub fn at(&self, index: u64) -> f64 {
        if index >= self.steps {
            self.schedule.stop
        } else if index < self.leap {
            self.schedule.start
        } else {
            // Signed numbers are converted faster, and there are no more steps than those hold.
            self.even + (index - self.leap) as i64 as f64 * self.schedule.step
        }
    }

    /// Steps cut into those before the even ones, the even ones, and those after them.
    pub fn parts(&self, steps: Range<u64>) -> [Range<u64>; 3] {
        let within = |index: u64| index.clamp(steps.start, steps.end.max(steps.start));
        let even = within(self.leap)..within(self.leap + self.between);
        [steps.start..even.start, even.clone(), even.end..steps.end]
    }

    /// Begin and size of even steps from the `first` on: as [`at`](Self::at) has them, but with nothing to decide, so
    /// that the processor computes several at a time. Steps after the even ones mean nothing.
    #[inline]
    pub fn even_steps<const N: usize>(&self, first: u64, begins: &mut [f64; N], sizes: &mut [f64; N]) {
        // A floating-point number counts exactly further than there are steps.
        let first = first.wrapping_sub(self.leap) as i64 as f64;
        let at = |number: usize| self.even + (first + number as f64) * self.schedule.step;
        for (number, (begin, size)) in begins.iter_mut().zip(sizes).enumerate() {
            *begin = at(number);
            *size = at(number + 1) - *begin;
        }
    }

    /// The number of the first one that is not before a time; the last one's where all are.
    pub fn from(&self, time: f64) -> u64 {
        let (mut before, mut end) = (0, self.steps);
        while before < end {
            let middle = before + (end - before) / 2;
            if self.at(middle) < time {
                before = middle + 1;
            } else {
                end = middle;
            }
        }
        end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Begin and size.
    fn step(points: &CommunicationPoints, index: u64) -> (f64, f64) {
        let begin = points.at(index);
        (begin, points.at(index + 1) - begin)
    }

    fn even_steps<const N: usize>(points: &CommunicationPoints, first: u64) -> [(f64, f64); N] {
        let (mut begins, mut sizes) = ([0.0; N], [0.0; N]);
        points.even_steps(first, &mut begins, &mut sizes);
        std::array::from_fn(|index| (begins[index], sizes[index]))
    }

    /// Steps by the dozen begin and end at the bits of the communication points, wherever they begin and however
    /// many there are.
    #[test]
    fn even_steps_are_those_between_communication_points() {
        for (start, stop, size) in [(0.0, 1e4, 1e-3), (-3.7, 1e6 / 3.0, 1.0 / 60.0), (5.0, 1e11, 0.1)] {
            let points =
                Schedule { start, stop, step: size, window_start: start, leap: false, tolerance: None }.points();
            let [before, even, _] = points.parts(0..points.steps);
            assert!(before.is_empty() && even.end > 1_000_000, "{even:?}");
            for first in [0, 1, 4711, 999_983, even.end / 3, even.end - 24] {
                let expected = std::array::from_fn(|index| step(&points, first + index as u64));
                assert_eq!(even_steps::<24>(&points, first), expected, "{start} {size} {first}");
            }
        }
    }

    #[test]
    fn communication_points_end_exactly_at_the_stop_time() {
        let schedule =
            |stop, step| Schedule { start: 0.0, stop, step, window_start: 0.0, leap: false, tolerance: None };
        assert_eq!(schedule(1.0, 0.1).steps(), 10);
        assert_eq!(schedule(150.0, 1.0 / 60.0).steps(), 9000);
        assert_eq!(schedule(1.0, 0.3).steps(), 4);
        assert_eq!(schedule(1.0, 0.3).points().at(4), 1.0);
        assert_eq!(schedule(1.0, 5.0).steps(), 1);
        let points = schedule(1.0, 0.3).points();
        assert_eq!(points.parts(0..4), [0..0, 0..3, 3..4]);
        assert_eq!(points.parts(4..4), [4..4, 4..4, 4..4]);
        let steps = even_steps::<2>(&points, 1);
        assert_eq!(steps, [1, 2].map(|index| step(&points, index)));
        let from = [0.0, 0.1, 0.3, 0.95, 1.0, 2.0].map(|time| points.from(time));
        assert_eq!(from, [0, 1, 1, 4, 4, 4]);
    }

    #[test]
    fn steps_of_one_size_end_with_the_last_whole_one() {
        let of = |stop, step| {
            let whole =
                Schedule { start: 0.0, stop, step, window_start: 0.0, leap: true, tolerance: None }.in_whole_steps();
            (whole.stop, whole.steps(), whole.leap)
        };
        let (stop, steps, leap) = of(1.0, 0.3);
        assert!((stop - 0.9).abs() < 1e-15 && steps == 3 && !leap);
        assert_eq!(of(150.0, 1.0 / 60.0), (150.0, 9000, false));
        assert_eq!(of(0.2, 0.3), (0.2, 1, false));
    }

    #[test]
    fn a_suggestion_of_a_thousand_million_steps_is_asked_about() {
        let of = |step| Schedule { start: 0.0, stop: 10.0, step, window_start: 0.0, leap: false, tolerance: None };
        assert!(of(1e-8).check_suggested().unwrap_err().message.contains("1e9 steps"));
        assert_eq!(of(1e-6).check_suggested(), Ok(()));
    }

    #[test]
    fn a_leap_is_one_step() {
        let schedule =
            Schedule { start: 0.0, stop: 100.0, step: 0.25, window_start: 99.0, leap: true, tolerance: None };
        assert_eq!(schedule.steps(), 5);
        let times: Vec<f64> = (0..=5).map(|index| schedule.points().at(index)).collect();
        assert_eq!(times, [0.0, 99.0, 99.25, 99.5, 99.75, 100.0]);
        let points = schedule.points();
        assert_eq!(points.parts(0..5), [0..1, 1..4, 4..5]);
        let steps = even_steps::<3>(&points, 1);
        assert_eq!(steps, [1, 2, 3].map(|index| step(&points, index)));
        let all = Schedule { window_start: 100.0, ..schedule };
        assert_eq!((all.steps(), all.points().at(1)), (1, 100.0));
    }
}
