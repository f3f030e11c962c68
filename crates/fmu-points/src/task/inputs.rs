//! Inputs that follow a recording.

use serde::{Deserialize, Serialize};

use super::{
    schedule::{CommunicationPoints, Schedule},
    slot::Slot,
};

/// Rows within this part of a step of a communication point count as on it: times in a file are rounded.
const NEAR: f64 = 1e-3;
/// The last sample of an even recording holds for one interval: so much of a run may lie beyond the rows.
const MOST_BEYOND: f64 = 0.01;

/// An input over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// The input that takes the values.
    pub slot: Slot,
    /// Whether a value holds until the next one; straight lines otherwise.
    pub hold: bool,
    /// Whether the input varies linearly within a step; otherwise the FMU sees new values at communication points only.
    pub ramp: bool,
    /// Whether the FMU takes a step to each row, wherever it lies between communication points.
    pub each_row: bool,
    /// The times of the values, s, growing; at least one.
    pub times: Vec<f64>,
    /// The values then, in the FMU's unit.
    pub values: Vec<f64>,
}

impl Series {
    /// The value at a time; before the first and after the last one these hold.
    pub fn at(&self, time: f64) -> f64 {
        // At equal times, the last value counts.
        self.between(self.times.partition_point(|&other| other <= time), time)
    }

    /// The rate at which it gets from its value at one time to that just before another one, 1/s.
    pub fn slope(&self, time: f64, next: f64) -> f64 {
        let end = self.times.partition_point(|&other| other < next);
        (self.between(end, next) - self.at(time)) / (next - time)
    }

    /// The value at a time before the `after`th row, and not before the row ahead of that.
    fn between(&self, after: usize, time: f64) -> f64 {
        let Some(before) = after.checked_sub(1) else { return self.values[0] };
        if self.hold || after == self.times.len() {
            return self.values[before];
        }
        let share = (time - self.times[before]) / (self.times[after] - self.times[before]);
        self.values[before] + share * (self.values[after] - self.values[before])
    }

    /// The first part of a run, s, that the rows do not cover. They may begin late or end early by one interval between rows
    /// where that is a hundredth of the run at most, and by a rounding of times.
    pub fn uncovered(&self, schedule: &Schedule) -> Option<[f64; 2]> {
        let Schedule { start, stop, .. } = *schedule;
        let [first, last] = self.span();
        let interval = (last - first) / (self.times.len() as f64 - 1.0).max(1.0);
        let may_miss = interval.min(MOST_BEYOND * (stop - start)).max(NEAR * schedule.step);
        if first > start + may_miss {
            Some([start, first.min(stop)])
        } else if last < stop - may_miss {
            Some([last.max(start), stop])
        } else {
            None
        }
    }

    /// The times of the first and the last row, s.
    pub fn span(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }
}

/// Rows of a recording that an FMU cannot follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unseen {
    /// How many rows between communication points the FMU gets other values at.
    pub rows: usize,
    /// By how much at most, in the FMU's unit.
    pub most: f64,
    /// When that is, s.
    pub at: f64,
}

impl Series {
    /// Moves rows next to communication points, or to other times of steps, to these. The times keep their order.
    fn settle(&mut self, points: &CommunicationPoints, stops: &[f64], near: f64) {
        let mut before = f64::NEG_INFINITY;
        for time in &mut self.times {
            let index = points.from(*time);
            let around = [index.saturating_sub(1), index].map(|index| points.at(index));
            let place = stops.partition_point(|stop| stop < time);
            let known = stops[place.saturating_sub(1)..].iter().take(2).copied();
            let settled = around.into_iter().chain(known).find(|other| (other - *time).abs() <= near);
            before = settled.unwrap_or(*time).max(before);
            *time = before;
        }
    }

    /// The rows at which what the FMU gets changes, and that lie between communication points.
    fn turns<'a>(&'a self, points: &'a CommunicationPoints) -> impl Iterator<Item = usize> + 'a {
        let values = &self.values;
        let changes = move |row: usize| {
            let next = values.get(row + 1).is_some_and(|next| *next != values[row]);
            row > 0 && values[row - 1] != values[row] || self.ramp && next
        };
        let [start, stop] = [0, points.steps].map(|index| points.at(index));
        (0..values.len()).filter(move |&row| {
            let time = self.times[row];
            start < time && time < stop && points.at(points.from(time)) != time && changes(row)
        })
    }

    /// The part of it that an FMU misses which takes steps from one communication point to the next only.
    pub fn unseen(&self, schedule: &Schedule) -> Option<Unseen> {
        const ROUNDING: f64 = 1e-9;
        let (mut settled, points) = (self.clone(), schedule.points());
        settled.settle(&points, &[], NEAR * schedule.step);
        let of_both = |(low, high): (f64, f64), &value: &f64| (low.min(value), high.max(value));
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = self.values.iter().fold(ends, of_both);
        let mut unseen = Unseen { rows: 0, most: ROUNDING * (high - low), at: f64::NAN };
        let least = unseen.most;
        for row in settled.turns(&points) {
            let time = settled.times[row];
            let index = points.from(time);
            let (begin, end) = (points.at(index - 1), points.at(index));
            let slope = if self.ramp { settled.slope(begin, end) } else { 0.0 };
            let got = settled.at(begin) + slope * (time - begin);
            let missed = (self.values[row] - got).abs();
            unseen.rows += usize::from(missed > least);
            if missed > unseen.most {
                (unseen.most, unseen.at) = (missed, self.times[row]);
            }
        }
        (unseen.rows > 0).then_some(unseen)
    }
}

/// Fits inputs to a schedule: rows that lie next to a communication point move there (a thousandth of a step at most).
/// Returns the times between communication points to which the FMU takes a step, growing, so that it gets the inputs as
/// they were recorded: a line cut short at a bend, or a value that jumps late, would be another input.
pub fn place(inputs: &mut [Series], schedule: &Schedule) -> Vec<f64> {
    let points = schedule.points();
    let mut stops: Vec<f64> = Vec::new();
    for series in inputs {
        series.settle(&points, &stops, NEAR * schedule.step);
        if series.each_row {
            stops.extend(series.turns(&points).map(|row| series.times[row]));
            stops.sort_unstable_by(f64::total_cmp);
            stops.dedup();
        }
    }
    stops
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_import::{Content, Handle};

    fn series(times: &[f64], values: &[f64]) -> Series {
        let handle = Handle { reference: 1, content: Content::Real };
        Series {
            slot: Slot {
                name: "u".to_owned(),
                handle,
                min: None,
                max: None,
                items: Vec::new(),
                idle: false,
                error: None,
            },
            hold: false,
            ramp: true,
            each_row: true,
            times: times.to_vec(),
            values: values.to_vec(),
        }
    }

    /// Steps of 1 s from 0 to 4.
    fn schedule() -> Schedule {
        Schedule { start: 0.0, stop: 4.0, step: 1.0, window_start: 0.0, leap: false, tolerance: None }
    }

    #[test]
    fn inputs_over_time() {
        let mut series = series(&[0.0, 1.0, 1.0, 3.0], &[5.0, 7.0, -1.0, 1.0]);
        let at = |series: &Series| [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(|t| series.at(t));
        assert_eq!(at(&series), [5.0, 5.0, 6.0, -1.0, 0.0, 1.0, 1.0]);
        // A jump belongs to the step after it; before and after the recording nothing changes.
        assert_eq!(series.slope(0.5, 1.0), 2.0);
        assert_eq!(series.slope(1.0, 3.0), 1.0);
        assert_eq!(series.slope(-2.0, -1.0), 0.0);
        assert_eq!(series.slope(3.0, 4.0), 0.0);
        series.hold = true;
        assert_eq!(at(&series), [5.0, 5.0, 5.0, -1.0, -1.0, 1.0, 1.0]);
    }

    /// Rows before the start, after the stop, at communication points, and where nothing changes, need no step.
    #[test]
    fn bends_between_communication_points_are_steps() {
        let times = [-0.5, 0.25, 0.5, 0.75, 1.0, 1.9995, 2.5, 2.5, 3.0005, 4.5];
        let values = [0.0, 1.0, 1.0, 1.0, 5.0, 6.0, 7.0, 8.0, 9.0, 1.0];
        let mut inputs = [series(&times, &values)];
        assert_eq!(place(&mut inputs, &schedule()), [0.25, 0.75, 2.5]);
        assert_eq!(inputs[0].times[5..], [2.0, 2.5, 2.5, 3.0, 4.5]);
        // A value that is held changes at the rows alone, not before them.
        let mut held = [series(&times, &values)];
        (held[0].hold, held[0].ramp) = (true, false);
        assert_eq!(place(&mut held, &schedule()), [0.25, 2.5]);
        held[0].each_row = false;
        assert!(place(&mut held, &schedule()).is_empty());
    }

    #[test]
    fn rows_of_two_recordings_share_a_step() {
        let mut inputs =
            [series(&[0.0, 0.3, 4.0], &[0.0, 1.0, 0.0]), series(&[0.0, 0.2995, 0.8, 0.9995], &[0.0, 1.0, 0.0, 3.0])];
        assert_eq!(place(&mut inputs, &schedule()), [0.3, 0.8]);
        assert_eq!(inputs[1].times, [0.0, 0.3, 0.8, 1.0]);
    }

    #[test]
    fn a_recording_covers_its_run_but_for_one_interval() {
        let run = Schedule { step: 0.01, ..schedule() };
        let covers = |times: &[f64]| series(times, &vec![0.0; times.len()]).uncovered(&run);
        let even = |first: i32, last: i32| {
            let times: Vec<f64> = (first..=last).map(|k| 0.02 * f64::from(k)).collect();
            covers(&times)
        };
        assert_eq!(even(0, 200), None);
        // A sample holds for an interval; two are missing rows.
        assert_eq!(even(1, 199), None);
        assert_eq!(even(0, 198), Some([3.96, 4.0]));
        assert_eq!(even(2, 200), Some([0.0, 0.04]));
        // Few rows must reach the ends, but for rounding.
        assert_eq!(covers(&[0.0, 3.999_99]), None);
        assert_eq!(covers(&[0.0, 3.9]), Some([3.9, 4.0]));
        assert_eq!(covers(&[0.0]), Some([0.0, 4.0]));
        assert_eq!(covers(&[5.0, 9.0]), Some([0.0, 4.0]));
        assert_eq!(covers(&[-3.0, -1.0]), Some([0.0, 4.0]));
    }

    #[test]
    fn what_an_fmu_of_fixed_steps_misses_is_counted() {
        let mut recorded = series(&[0.0, 1.5, 1.75, 2.0, 4.0], &[0.0, 3.0, 3.5, 0.0, 8.0]);
        // From 2 at 1 s to 0 at 2 s.
        let unseen = Unseen { rows: 2, most: 3.0, at: 1.75 };
        assert_eq!(recorded.unseen(&schedule()), Some(unseen));
        (recorded.ramp, recorded.hold) = (false, true);
        let unseen = Unseen { rows: 2, most: 3.5, at: 1.75 };
        assert_eq!(recorded.unseen(&schedule()), Some(unseen));
        let straight = series(&[0.0, 0.5, 1.0, 4.0], &[0.0, 1.0, 2.0, 8.0]);
        let fine = Schedule { step: 0.5, ..schedule() };
        assert_eq!(straight.unseen(&schedule()), None);
        assert_eq!(recorded.unseen(&fine).map(|unseen| unseen.rows), Some(1));
    }
}
