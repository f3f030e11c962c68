//! When a simulation begins, ends, and communicates.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use fmu_import::Description;

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

    /// Whether the times make sense.
    ///
    /// # Errors
    /// Says which one does not.
    pub fn check(&self) -> Result<(), String> {
        const MOST_STEPS: f64 = 1e12;
        let Self {
            start, stop, step, ..
        } = *self;
        if !(start.is_finite() && stop.is_finite() && stop > start) {
            return Err(format!(
                "the stop time {stop} s must be later than the start {start} s"
            ));
        }
        if !(step > 0.0 && (stop - start) / step < MOST_STEPS) {
            return Err(format!(
                "the step {step:?} s must be positive, and not absurdly small"
            ));
        }
        if !(self.window_start >= start && self.window_start <= stop) {
            let seen = "statistics would begin outside the simulation";
            return Err(format!("{seen}: at {} s", self.window_start));
        }
        if self
            .tolerance
            .is_some_and(|tolerance| tolerance.is_nan() || tolerance <= 0.0)
        {
            return Err("the tolerance must be positive".to_owned());
        }
        Ok(())
    }

    /// The number of steps. A last step shorter than a millionth of the others is none.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn steps(&self) -> u64 {
        let (leap, even) = self.even();
        let steps = leap + ((self.stop - even) / self.step - 1e-6).ceil().max(0.0) as u64;
        steps.max(1)
    }

    /// The `index`th communication point: a multiple of the step, so that nothing accumulates.
    pub fn time(&self, index: u64) -> f64 {
        self.points().at(index)
    }

    /// The communication points, counted once.
    pub fn points(&self) -> CommunicationPoints {
        let (leap, even) = self.even();
        let steps = self.steps();
        CommunicationPoints {
            schedule: *self,
            steps,
            leap,
            even,
            between: steps.saturating_sub(leap + 1),
        }
    }

    /// The number of the communication point at which the even steps begin.
    pub fn first_even(&self) -> u64 {
        self.even().0
    }

    /// The number of steps before the even ones, and where those begin.
    fn even(&self) -> (u64, f64) {
        if self.leap && self.window_start > self.start {
            (1, self.window_start)
        } else {
            (0, self.start)
        }
    }
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
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_wrap)]
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

    /// The ends of some of the even steps, one after the other: as [`at`](Self::at) has them, but with
    /// nothing to decide.
    #[inline]
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_wrap)]
    pub fn even_ends(&self, steps: Range<u64>) -> impl Iterator<Item = f64> + use<> {
        let (begin, step) = (self.even, self.schedule.step);
        let number = |index: u64| index.wrapping_sub(self.leap) as i64;
        let numbers = number(steps.start)..number(steps.end);
        numbers.map(move |number| begin + (number + 1) as f64 * step)
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

    #[test]
    fn communication_points_end_exactly_at_the_stop_time() {
        let schedule = |stop, step| Schedule {
            start: 0.0,
            stop,
            step,
            window_start: 0.0,
            leap: false,
            tolerance: None,
        };
        assert_eq!(schedule(1.0, 0.1).steps(), 10);
        assert_eq!(schedule(150.0, 1.0 / 60.0).steps(), 9000);
        assert_eq!(schedule(1.0, 0.3).steps(), 4);
        assert_eq!(schedule(1.0, 0.3).time(4), 1.0);
        assert_eq!(schedule(1.0, 5.0).steps(), 1);
        let points = schedule(1.0, 0.3).points();
        assert_eq!(points.parts(0..4), [0..0, 0..3, 3..4]);
        assert_eq!(points.parts(4..4), [4..4, 4..4, 4..4]);
        let ends: Vec<f64> = points.even_ends(1..3).collect();
        assert_eq!(ends, [points.at(2), points.at(3)]);
        let from = [0.0, 0.1, 0.3, 0.95, 1.0, 2.0].map(|time| points.from(time));
        assert_eq!(from, [0, 1, 1, 4, 4, 4]);
    }

    #[test]
    fn a_leap_is_one_step() {
        let schedule = Schedule {
            start: 0.0,
            stop: 100.0,
            step: 0.25,
            window_start: 99.0,
            leap: true,
            tolerance: None,
        };
        assert_eq!(schedule.steps(), 5);
        let times: Vec<f64> = (0..=5).map(|index| schedule.time(index)).collect();
        assert_eq!(times, [0.0, 99.0, 99.25, 99.5, 99.75, 100.0]);
        let points = schedule.points();
        assert_eq!(points.parts(0..5), [0..1, 1..4, 4..5]);
        assert_eq!(points.even_ends(1..4).collect::<Vec<_>>(), times[2..5]);
        let all = Schedule {
            window_start: 100.0,
            ..schedule
        };
        assert_eq!((all.steps(), all.time(1)), (1, 100.0));
    }
}
