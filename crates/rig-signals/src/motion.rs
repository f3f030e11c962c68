//! Whether a signal has come to rest at the end of a run: how far it swings there, and how far it still drifts.

/// The movement of a signal at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// From the least to the greatest value within the last period before the end, freed from the drift; 0 without a
    /// period.
    pub swing: f64,
    /// How far it goes on in a time as long as the run; 0 where a trend cannot be told from swing and scatter.
    pub drift: f64,
}

/// A run of fewer values tells nothing.
const FEWEST: usize = 10;
/// The part of the run that is looked at.
const PART: f64 = 0.2;
/// So many values at the least show a swing: the period may lie between two communication points.
const SHOWN: usize = 20;
/// Changes of side in two periods: with fewer, a swing cannot be told from a trend by its crossings.
const TWO_PERIODS: usize = 4;

/// The motion of a signal about the end of a run from one time to another; the values may go on after the end.
/// `None` where there are too few.
pub fn motion(time: &[f64], values: &[f64], [start, end]: [f64; 2]) -> Option<Motion> {
    let run = end - start;
    let rounding = 1e-9 * (start.abs() + end.abs());
    let after = time.partition_point(|&t| t <= end + rounding);
    let from = time.partition_point(|&t| t < end - PART * run);
    let values = values.get(..time.len())?;
    if after < from + FEWEST || values[from..].iter().any(|value| !value.is_finite()) {
        return None;
    }
    let last = Stretch::new(&time[from..after], &values[from..after])?;
    // Stairs that go one way cross the line through them at each step; that is no swing.
    if last.turns < TWO_PERIODS || goes_one_way(&values[from..after]) {
        return Some(slow(&time[from..], &values[from..], after - from, run));
    }
    let swing = last.swing();
    // Of two stretches of the same length, the means differ by the drift from one to the other.
    let until = time[time.len() - 1];
    let begin = time.partition_point(|&t| t < until - PART * run);
    let further = (begin >= after).then(|| Stretch::new(&time[begin..], &values[begin..]));
    let (drift, unsure) = match further.flatten() {
        Some(further) => {
            let longer = run / (further.line.centre[0] - last.line.centre[0]);
            let moved = further.line.centre[1] - last.line.centre[1];
            (moved * longer, (last.doubt() + further.doubt()) * longer)
        }
        None => last.extrapolated(run, swing),
    };
    let sure = drift.abs() > unsure;
    Some(Motion { swing, drift: if sure { drift } else { 0.0 } })
}

/// The motion of a signal with less than two periods in its last part: it goes one way, or it turns.
fn slow(time: &[f64], values: &[f64], end: usize, run: f64) -> Motion {
    // Rounding is no turn.
    let largest = values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let enough = (0.1 * range(values)).max(1e-12 * largest);
    if range(values) <= enough {
        return Motion::default();
    }
    let beyond = further_on(values, end);
    let first = values[beyond.start];
    let (swing, drift) = match turnings(values, enough) {
        0 => {
            let last = beyond.end - 1;
            let longer = run / (time[last] - time[beyond.start]);
            (0.0, (values[last] - first) * longer)
        }
        // One turn makes no period: the value goes so far and comes back.
        1 => {
            let moved = values[beyond].iter().map(|value| value - first);
            let farther = |most: f64, x: f64| if x.abs() > most.abs() { x } else { most };
            (0.0, moved.fold(0.0, farther))
        }
        _ => (range(values), 0.0),
    };
    Motion { swing, drift }
}

fn goes_one_way(values: &[f64]) -> bool {
    values.is_sorted() || values.is_sorted_by(|a, b| a >= b)
}

/// The values after the end of the run, or, where there are none, all of them.
fn further_on(values: &[f64], end: usize) -> std::ops::Range<usize> {
    let from = if end < values.len() { end - 1 } else { 0 };
    from..values.len()
}

/// How often a signal turns: it goes one way and then back, by more than a distance each.
fn turnings(values: &[f64], enough: f64) -> usize {
    let Some(&first) = values.first() else { return 0 };
    // The least and the greatest value since the last turn, and on which way it is by now.
    let (mut low, mut high, mut rises, mut turns) = (first, first, None, 0);
    for &value in values {
        (low, high) = (low.min(value), high.max(value));
        let way = match rises {
            Some(false) | None if value - low > enough => true,
            Some(true) | None if high - value > enough => false,
            _ => continue,
        };
        turns += usize::from(rises.is_some());
        (low, high, rises) = (value, value, Some(way));
    }
    turns
}

/// A part of a signal with the straight line through it.
struct Stretch<'a> {
    time: &'a [f64],
    line: Line,
    /// The values less those of the line.
    rest: Vec<f64>,
    /// How often the rest changes sides: twice a period.
    turns: usize,
}

impl<'a> Stretch<'a> {
    fn new(time: &'a [f64], values: &[f64]) -> Option<Self> {
        let line = Line::through(time, values)?;
        let rest: Vec<f64> = time.iter().zip(values).map(|(&t, &value)| value - line.at(t)).collect();
        let turns = crossings(&rest);
        Some(Self { time, line, rest, turns })
    }

    fn span(&self) -> f64 {
        self.time[self.time.len() - 1] - self.time[0]
    }

    /// From the least to the greatest rest within the last period.
    fn swing(&self) -> f64 {
        let end = self.time[self.time.len() - 1];
        let period = 2.0 * self.span() / self.turns.max(1) as f64;
        let begin = self.time.partition_point(|&t| t < end - period);
        range(&self.rest[begin.min(self.rest.len().saturating_sub(SHOWN))..])
    }

    /// How far its mean may be from the middle of what swings and scatters.
    fn doubt(&self) -> f64 {
        let incomplete = range(&self.rest) / self.turns.max(1) as f64;
        let squares: f64 = self.rest.iter().map(|rest| rest * rest).sum();
        incomplete + 4.0 * squares.sqrt() / self.rest.len() as f64
    }

    /// The drift over a time at the rate of the line, and how much of that may be swing and scatter.
    fn extrapolated(&self, run: f64, swing: f64) -> (f64, f64) {
        let by_swing = 3.0 * swing * run / self.span() / self.turns.max(1) as f64;
        let by_scatter = 4.0 * self.line.deviation * run;
        (self.line.slope * run, by_swing.max(by_scatter))
    }
}

/// A straight line by least squares.
struct Line {
    centre: [f64; 2],
    slope: f64,
    /// The standard deviation of the slope.
    deviation: f64,
}

impl Line {
    fn through(time: &[f64], values: &[f64]) -> Option<Self> {
        let n = time.len() as f64;
        let centre = [time, values].map(|numbers| numbers.iter().sum::<f64>() / n);
        let pairs = || time.iter().zip(values).map(|(t, v)| (t - centre[0], v - centre[1]));
        let spread: f64 = pairs().map(|(t, _)| t * t).sum();
        let slope = pairs().map(|(t, v)| t * v).sum::<f64>() / spread;
        let rest: f64 = pairs().map(|(t, v)| (v - slope * t).powi(2)).sum();
        (spread > 0.0).then(|| Self { centre, slope, deviation: (rest / (n - 2.0) / spread).sqrt() })
    }

    fn at(&self, time: f64) -> f64 {
        self.centre[1] + self.slope * (time - self.centre[0])
    }
}

/// How often numbers go from one side of 0 to the other, by more than a tenth of their range.
fn crossings(numbers: &[f64]) -> usize {
    let enough = 0.1 * range(numbers);
    let sides: Vec<bool> = numbers.iter().filter(|number| number.abs() > enough).map(|number| *number > 0.0).collect();
    sides.windows(2).filter(|pair| pair[0] != pair[1]).count()
}

fn range(numbers: &[f64]) -> f64 {
    let high = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    (high - low).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn of(signal: impl Fn(f64) -> f64) -> Motion {
        let time: Vec<f64> = (0..=5000).map(|k| f64::from(k) * 0.03).collect();
        let values: Vec<f64> = time.iter().map(|&t| signal(t)).collect();
        motion(&time, &values, [0.0, 150.0]).unwrap()
    }

    /// A run of one second that is watched for another one, with steps of which no period is a multiple.
    fn of_a_second(signal: impl Fn(f64) -> f64) -> Motion {
        let time: Vec<f64> = (0..=10_000).map(|k| f64::from(k) * 2e-4).collect();
        let values: Vec<f64> = time.iter().map(|&t| signal(t)).collect();
        motion(&time, &values, [0.0, 1.0]).unwrap()
    }

    #[test]
    fn a_swing_is_that_of_the_last_period() {
        let moves = of(|t| 750.0 + 3.0 * (TAU * t / 1.7).sin());
        assert!((moves.swing - 6.0).abs() < 0.05, "{moves:?}");
        assert_eq!(moves.drift, 0.0);
        // It has died away before the end.
        let moves = of(|t| 750.0 + 3.0 * (TAU * t / 1.7).sin() * (-t / 10.0).exp());
        assert!(moves.swing < 1e-4, "{moves:?}");
    }

    #[test]
    fn a_drift_is_that_over_the_length_of_the_run() {
        let moves = of(|t| 82.0 + 0.02 * t + 0.5 * (TAU * t / 0.2).sin());
        assert!((moves.drift - 3.0).abs() < 0.1 && (moves.swing - 1.0).abs() < 0.05, "{moves:?}");
        let moves = of(|t| 82.0 - 5.0 * (-t / 300.0).exp());
        assert!((1.3..1.8).contains(&moves.drift), "{moves:?}");
        assert_eq!(moves.swing, 0.0);
    }

    #[test]
    fn a_signal_at_rest_does_not_move() {
        assert_eq!(of(|_| 82.0), Motion::default());
        assert!(of(|t| 82.0 - 5.0 * (-t / 3.0).exp()).drift.abs() < 1e-9);
        assert_eq!(motion(&[0.0, 1.0], &[1.0, 2.0], [0.0, 1.0]), None);
    }

    /// Scatter without a trend: a sequence without a regularity.
    #[test]
    fn scatter_is_no_drift() {
        for seed in 1..=20_u32 {
            let noise = |t: f64| ((t * 12_989.8 + f64::from(seed) * 78.2).sin() * 43_758.545).fract();
            assert_eq!(of(noise).drift, 0.0, "{seed}");
        }
    }

    #[test]
    fn the_drift_is_that_which_comes_after_the_end() {
        // 5 exp(-t) loses 5 (exp(-1) - exp(-2)) in the second after the first one.
        let moves = of_a_second(|t| 82.0 - 5.0 * (-t).exp());
        let expected = 5.0 * ((-1.0_f64).exp() - (-2.0_f64).exp());
        assert!((moves.drift - expected).abs() < 1e-9, "{moves:?}");
        assert_eq!(moves.swing, 0.0);
        let moves = of_a_second(|t| 750.0 + 0.7 * t + (TAU * 50.0 * t).sin());
        assert!((moves.drift - 0.7).abs() < 0.05 && (moves.swing - 2.0).abs() < 0.05, "{moves:?}");
    }

    #[test]
    fn a_part_of_a_swing_is_no_drift() {
        for periods in 2..=60 {
            let periods = 0.6 * f64::from(periods);
            let moves = of_a_second(|t| 5.0 + (TAU * periods * t).sin());
            assert_eq!(moves.drift, 0.0, "{periods} periods: {moves:?}");
            assert!((moves.swing - 2.0).abs() < 0.3, "{periods} periods: {moves:?}");
        }
    }

    /// A value that rises after the end of the run and comes back has no period, but moves.
    #[test]
    fn a_single_turn_is_a_drift_as_far_as_it_goes() {
        let moves = of_a_second(|t| 82.0 - 4.0 * (t - 1.5).powi(2));
        assert!((moves.drift - 1.0).abs() < 1e-3 && moves.swing == 0.0, "{moves:?}");
    }

    /// A sensor that holds its value between its readings.
    #[test]
    fn stairs_that_go_one_way_do_not_swing() {
        let moves = of(|t| 82.0 - 5.0 * (-(t / 3.0).floor() / 100.0).exp());
        assert!(moves.swing == 0.0 && (1.3..1.8).contains(&moves.drift), "{moves:?}");
    }

    /// Steps of the golden ratio times the period see all phases of a swing, even though each is longer than a period.
    #[test]
    fn a_swing_between_communication_points_is_seen() {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        for multiple in [1.0, 2.0, 5.0, 60.0] {
            let time: Vec<f64> = (0..=10_000).map(|k| f64::from(k) / golden).collect();
            let values: Vec<f64> = time.iter().map(|t| (TAU * multiple * t).sin()).collect();
            let run = [0.0, time[5000]];
            let moves = motion(&time, &values, run).unwrap();
            assert!((moves.swing - 2.0).abs() < 0.1, "{multiple}: {moves:?}");
            assert_eq!(moves.drift, 0.0);
        }
    }
}
