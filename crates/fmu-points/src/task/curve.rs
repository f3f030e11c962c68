//! A measured curve with which a variable is compared.

use serde::{Deserialize, Serialize};

use curves::Metric;

/// A measured curve in the criterion's unit, and the way to compare with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredCurve {
    /// Turns both curves into one number.
    pub metric: Metric,
    /// When it was measured, s, growing.
    pub times: Vec<f64>,
    /// The values then.
    pub values: Vec<f64>,
    /// The half width of the corridor at these times; empty for other metrics.
    pub band: Vec<f64>,
    /// The expanded uncertainty of each value; empty where it is not stated.
    #[serde(default)]
    pub uncertainty: Vec<f64>,
    /// The true curves that its uncertainty allows, and when the model conforms to one; none where that is not asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resampling: Option<Resampling>,
    /// By what a normalised metric divides.
    pub normaliser: f64,
    /// By how much the measurement is late.
    pub delay: Delay,
    /// From the FMU's unit to the criterion's: `factor * value + offset`.
    pub factor: f64,
    /// See `factor`.
    pub offset: f64,
    /// Whether the result is the model's value at the first of the times, in the criterion's unit, and no metric of both
    /// curves.
    #[serde(default)]
    pub reads: bool,
}

/// How a measured curve is drawn anew within its uncertainty, and which of the draws the model conforms to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resampling {
    /// The standard uncertainty of each value; empty where it is not known, as between the rows of an uneven curve.
    pub standard: Vec<f64>,
    /// The correlation of the errors of any two rows.
    pub correlation: f64,
    /// The seed of the errors: one for each recorded column.
    pub seed: u64,
    /// The row of the recording from which the values come first.
    pub first: u64,
    /// The metric's value of equal curves.
    pub ideal: f64,
    /// How far from it a metric's value may be.
    pub tolerance: f64,
}

/// By how much a measurement is late: its value at `t` belongs to the model's at `t - delay`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Delay {
    /// So many seconds.
    Known(f64),
    /// The delay with the least rmse between two, s.
    Within([f64; 2]),
}

impl MeasuredCurve {
    /// The times on the model's clock, as pictures have them; those of the measurement where the delay is to be found.
    pub fn shown_times(&self) -> impl Iterator<Item = f64> + '_ {
        let delay = match self.delay {
            Delay::Known(delay) => delay,
            Delay::Within(_) => 0.0,
        };
        self.times.iter().map(move |time| time - delay)
    }

    /// The first and the last time at which the model's value is needed, s.
    pub fn needs(&self) -> [f64; 2] {
        let [least, most] = match self.delay {
            Delay::Known(delay) => [delay; 2],
            Delay::Within(range) => range,
        };
        let ends = [self.times.first(), self.times.last()];
        let [first, last] = ends.map(|time| *time.expect("a measured curve has samples"));
        [first - most, last - least]
    }
}
