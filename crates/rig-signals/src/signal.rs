//! A signal as samples over time, and its resampling to even steps.

use sampling::statistics::moments::sorted;
use thiserror::Error;

/// Why a signal cannot be used.
#[derive(Debug, PartialEq, Error)]
pub enum SignalError {
    /// Fewer samples than needed.
    #[error("signal '{name}' has {usable} usable samples, {needed} are needed: record a longer window")]
    TooShort {
        /// The signal.
        name: String,
        /// Finite samples.
        usable: usize,
        /// Samples needed.
        needed: usize,
    },
    /// Times that do not increase.
    #[error("the time of signal '{name}' does not increase at {time} s: remove the row that repeats a time")]
    Unsorted {
        /// The signal.
        name: String,
        /// Where.
        time: f64,
    },
    /// A hole in the record.
    #[error("signal '{name}' has no samples from {from} s to {to} s: choose a window without this gap")]
    Gap {
        /// The signal.
        name: String,
        /// Last time before the gap, s.
        from: f64,
        /// First time after it, s.
        to: f64,
    },
    /// A setting that does not suit the signal.
    #[error("{0}")]
    Setting(String),
}

/// A natural cubic spline through samples (de Boor, "A Practical Guide to Splines", chapter IV).
#[derive(Debug)]
pub struct Spline {
    time: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the samples.
    bend: Vec<f64>,
}

impl Spline {
    /// A spline through finite samples at increasing times; samples that are not finite are left out.
    /// A gap longer than `longest_gap` steps (of median length) is refused.
    pub fn new(name: &str, time: &[f64], values: &[f64], longest_gap: f64) -> Result<Self, SignalError> {
        const LEAST: usize = 8;
        let (time, values): (Vec<f64>, Vec<f64>) =
            time.iter().zip(values).filter(|(t, v)| t.is_finite() && v.is_finite()).unzip();
        if time.len() < LEAST {
            return Err(SignalError::TooShort { name: name.into(), usable: time.len(), needed: LEAST });
        }
        if let Some(w) = time.windows(2).find(|w| w[1] <= w[0]) {
            return Err(SignalError::Unsorted { name: name.into(), time: w[1] });
        }
        let steps = sorted(time.windows(2).map(|w| w[1] - w[0]).collect());
        let longest = longest_gap * steps[steps.len() / 2];
        if let Some(w) = time.windows(2).find(|w| w[1] - w[0] > longest) {
            return Err(SignalError::Gap { name: name.into(), from: w[0], to: w[1] });
        }
        let bend = bends(&time, &values);
        Ok(Self { time, values, bend })
    }

    /// First and last time, s.
    pub fn span(&self) -> (f64, f64) {
        (self.time[0], self.time[self.time.len() - 1])
    }

    /// The mean step, s, where a gap counts as the samples that are missing: even samples at this step are those that were
    /// recorded, and not values between them, of which a spline makes the noise smaller.
    pub fn step(&self) -> f64 {
        let (start, end) = self.span();
        let steps: Vec<f64> = self.time.windows(2).map(|w| w[1] - w[0]).collect();
        let usual = sorted(steps.clone())[steps.len() / 2];
        let counts = steps.iter().map(|step| (step / usual).round().max(1.0));
        (end - start) / counts.sum::<f64>()
    }

    /// The value at a time; outside the span the end segments continue.
    pub fn at(&self, t: f64) -> f64 {
        let k = self.time.partition_point(|&x| x <= t).saturating_sub(1).min(self.time.len() - 2);
        let h = self.time[k + 1] - self.time[k];
        let (a, b) = ((self.time[k + 1] - t) / h, (t - self.time[k]) / h);
        a * self.values[k]
            + b * self.values[k + 1]
            + ((a.powi(3) - a) * self.bend[k] + (b.powi(3) - b) * self.bend[k + 1]) * h * h / 6.0
    }
}

/// Second derivatives of the natural spline: a tridiagonal system, solved by elimination.
fn bends(time: &[f64], values: &[f64]) -> Vec<f64> {
    let n = time.len();
    let (mut diagonal, mut right) = (vec![1.0; n], vec![0.0; n]);
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let (h0, h1) = (time[i] - time[i - 1], time[i + 1] - time[i]);
        let lower = h0 / 6.0;
        let ratio = lower / diagonal[i - 1];
        diagonal[i] = (h0 + h1) / 3.0 - ratio * upper[i - 1];
        upper[i] = h1 / 6.0;
        right[i] = (values[i + 1] - values[i]) / h1 - (values[i] - values[i - 1]) / h0 - ratio * right[i - 1];
    }
    let mut bend = vec![0.0; n];
    for i in (1..n - 1).rev() {
        bend[i] = (right[i] - upper[i] * bend[i + 1]) / diagonal[i];
    }
    bend
}

/// A signal at even steps.
#[derive(Clone, Debug)]
pub struct Even {
    /// Time of the first sample, s.
    pub start: f64,
    /// Time between samples, s.
    pub step: f64,
    /// The samples.
    pub values: Vec<f64>,
}

impl Even {
    /// Resamples a spline from `start` at steps of `step` up to `end`.
    pub fn from_spline(spline: &Spline, start: f64, end: f64, step: f64) -> Self {
        let n = ((end - start) / step * (1.0 + 1e-12)).floor() as usize + 1;
        let values = (0..n).map(|k| spline.at(start + k as f64 * step)).collect();
        Self { start, step, values }
    }

    /// The times of the samples, s.
    pub fn times(&self) -> Vec<f64> {
        (0..self.values.len()).map(|k| self.start + k as f64 * self.step).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_follows_a_sine_between_uneven_samples() {
        let time: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.01 + 0.003 * f64::from(k % 3)).collect();
        let values: Vec<f64> = time.iter().map(|t| (8.0 * t).sin()).collect();
        let spline = Spline::new("s", &time, &values, 5.0).unwrap();
        for k in 1..180 {
            let t = 0.05 + f64::from(k) * 0.0101;
            assert!((spline.at(t) - (8.0 * t).sin()).abs() < 1e-5, "{t}");
        }
    }

    #[test]
    fn gaps_and_disorder_are_named() {
        let time: Vec<f64> = (0..20).map(|k| f64::from(k) + if k > 9 { 30.0 } else { 0.0 }).collect();
        assert_eq!(
            Spline::new("load", &time, &time, 5.0).unwrap_err(),
            SignalError::Gap { name: "load".into(), from: 9.0, to: 40.0 }
        );
        let mut back = time.clone();
        back[5] = 2.0;
        assert!(matches!(Spline::new("load", &back, &time, 50.0), Err(SignalError::Unsorted { .. })));
        assert!(matches!(Spline::new("load", &time[..3], &time, 50.0), Err(SignalError::TooShort { .. })));
    }
}
