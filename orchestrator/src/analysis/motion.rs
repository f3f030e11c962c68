//! Whether a signal has come to rest at the end of a run: how far it swings there, and how far it still drifts.

/// The motion of a signal at the end of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// From the least to the greatest value within the last period, freed from the drift; 0 without a period.
    pub swing: f64,
    /// How far it would go on in a time as long as the run, at the rate of the last fifth; 0 where the trend cannot be
    /// told from swing and scatter.
    pub drift: f64,
}

/// A run of fewer values tells nothing.
const FEWEST: usize = 10;
/// The part of the run that is looked at.
const PART: f64 = 0.2;

/// The motion of a signal, given its values over time; `None` where there are too few.
pub fn motion(time: &[f64], values: &[f64]) -> Option<Motion> {
    let (start, end) = (*time.first()?, *time.last()?);
    let from = time.partition_point(|&t| t < end - PART * (end - start));
    let (time, values) = (&time[from..], values.get(from..)?);
    if time.len() < FEWEST || values.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let span = end - time[0];
    let line = Line::through(time, values)?;
    let rest: Vec<f64> = time
        .iter()
        .zip(values)
        .map(|(&t, &value)| value - line.at(t))
        .collect();
    let turns = crossings(&rest);
    let period = 2.0 * span / turns.max(1) as f64;
    let last = time.partition_point(|&t| t < end - period);
    let swing = if turns < 4 { 0.0 } else { range(&rest[last..]) };
    let run = end - start;
    let drift = line.slope * run;
    // A trend over a part of a period, or over scatter, is none.
    let by_swing = 3.0 * swing * run / span / turns.max(1) as f64;
    let by_scatter = 4.0 * line.deviation * run;
    let sure = drift.abs() > by_swing && drift.abs() > by_scatter;
    Some(Motion {
        swing,
        drift: if sure { drift } else { 0.0 },
    })
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
        let pairs = || {
            time.iter()
                .zip(values)
                .map(|(t, v)| (t - centre[0], v - centre[1]))
        };
        let spread: f64 = pairs().map(|(t, _)| t * t).sum();
        let slope = pairs().map(|(t, v)| t * v).sum::<f64>() / spread;
        let rest: f64 = pairs().map(|(t, v)| (v - slope * t).powi(2)).sum();
        (spread > 0.0).then(|| Self {
            centre,
            slope,
            deviation: (rest / (n - 2.0) / spread).sqrt(),
        })
    }

    fn at(&self, time: f64) -> f64 {
        self.centre[1] + self.slope * (time - self.centre[0])
    }
}

/// How often numbers go from one side of 0 to the other, by more than a tenth of their range.
fn crossings(numbers: &[f64]) -> usize {
    let enough = 0.1 * range(numbers);
    let sides = numbers
        .iter()
        .filter(|number| number.abs() > enough)
        .map(|number| *number > 0.0);
    let sides: Vec<bool> = sides.collect();
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
        motion(&time, &values).unwrap()
    }

    #[test]
    fn a_swing_is_that_of_the_last_period() {
        let found = of(|t| 750.0 + 3.0 * (TAU * t / 1.7).sin());
        assert!((found.swing - 6.0).abs() < 0.05, "{found:?}");
        assert_eq!(found.drift, 0.0);
        // It has died away before the end.
        let found = of(|t| 750.0 + 3.0 * (TAU * t / 1.7).sin() * (-t / 10.0).exp());
        assert!(found.swing < 1e-4, "{found:?}");
    }

    #[test]
    fn a_drift_is_that_over_the_length_of_the_run() {
        let found = of(|t| 82.0 + 0.02 * t + 0.5 * (TAU * t / 0.2).sin());
        assert!(
            (found.drift - 3.0).abs() < 0.1 && (found.swing - 1.0).abs() < 0.05,
            "{found:?}"
        );
        let found = of(|t| 82.0 - 5.0 * (-t / 300.0).exp());
        assert!((1.3..1.8).contains(&found.drift), "{found:?}");
        assert_eq!(found.swing, 0.0);
    }

    #[test]
    fn a_signal_at_rest_does_not_move() {
        assert_eq!(of(|_| 82.0), Motion::default());
        assert!(of(|t| 82.0 - 5.0 * (-t / 3.0).exp()).drift.abs() < 1e-9);
        assert_eq!(motion(&[0.0, 1.0], &[1.0, 2.0]), None);
    }

    /// Scatter without a trend: a sequence without a regularity.
    #[test]
    fn scatter_is_no_drift() {
        for seed in 1..=20_u32 {
            let noise =
                |t: f64| ((t * 12_989.8 + f64::from(seed) * 78.2).sin() * 43_758.545).fract();
            assert_eq!(of(noise).drift, 0.0, "{seed}");
        }
    }
}
