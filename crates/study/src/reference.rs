//! A measured curve as a study states it.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use conformity::uncertainty::Distribution;
use fmu_import::quantity::Quantity;

/// A measured curve.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ReferenceText {
    /// The table, csv or Parquet, relative to the study file.
    pub file: Spanned<PathBuf>,
    /// The column of the time, s; `time` otherwise.
    pub time: Option<String>,
    /// The column of the values; the variable's name otherwise.
    pub column: Option<String>,
    /// The unit of that column; that of the criterion otherwise.
    pub unit: Option<String>,
    /// The expanded uncertainty of each value: `0.01 N.m`, or `2 %` of the value. All rows share this error.
    pub uncertainty: Option<Quantity>,
    /// The column of the expanded uncertainties, in the unit of the values.
    pub uncertainty_column: Option<String>,
    /// How many standard uncertainties these and the gain's are; 2 otherwise.
    pub coverage: Option<Spanned<f64>>,
    /// The distribution of the error that `uncertainty` describes; normal otherwise.
    pub uncertainty_distribution: Option<Distribution>,
    /// The expanded uncertainty of the gain, as a part of each value.
    pub gain_uncertainty: Option<Spanned<Quantity>>,
    /// The standard deviation of one row, which is independent from row to row: `0.003 N.m`, or `2 %` of the value.
    pub noise: Option<Quantity>,
    /// How well a recording told the noise; without it the noise is known.
    pub noise_estimate: Option<Spanned<EstimateText>>,
    /// The correlation of the errors of any two rows, from 0 (noise) to 1 (an offset, or a factor); 1 otherwise.
    pub correlation: Option<Spanned<f64>>,
}

/// How well a recording told its noise.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EstimateText {
    /// The degrees of freedom of its square.
    pub freedom: f64,
    /// The correlation of each row's noise with the next one's.
    #[serde(default)]
    pub correlation: f64,
    /// How many rows count as one with an independent noise of that size.
    #[serde(default = "one")]
    pub rows: f64,
}

fn one() -> f64 {
    1.0
}

impl EstimateText {
    /// Whether the numbers make sense.
    pub fn is_sound(&self) -> bool {
        let is_correlation = (-1.0..=1.0).contains(&self.correlation);
        let finite = self.freedom.is_finite() && self.rows.is_finite();
        finite && self.freedom > 0.0 && self.rows >= 1.0 && is_correlation
    }
}

impl ReferenceText {
    /// The correlation of the errors of any two rows, for the risk.
    ///
    /// Without a word on it all rows share their error, as they do where a sensor is out of calibration; `noise` is what they
    /// do not share.
    pub fn row_correlation(&self) -> f64 {
        let stated = self.correlation.as_ref();
        let noise_alone = !self.has_uncertainty() && self.gain_uncertainty.is_none();
        stated.map_or(f64::from(u8::from(!noise_alone)), |stated| *stated.as_ref())
    }

    /// Whether it states what all or single rows may be off by `uncertainty`.
    pub fn has_uncertainty(&self) -> bool {
        self.uncertainty.is_some() || self.uncertainty_column.is_some()
    }

    /// Whether the risk of a metric can be told.
    pub fn is_uncertain(&self) -> bool {
        self.has_uncertainty() || self.gain_uncertainty.is_some() || self.noise.is_some()
    }
}

/// By what `nrmse` divides the rmse.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged, expecting = "`normalise` is \"range\", \"mean\" or a value such as \"0.2 N.m\"")]
pub enum Normalise {
    /// A number that the reference itself gives.
    Own(OwnNormaliser),
    /// A value.
    Value(Quantity),
}

/// A number of the reference by which an error is divided.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OwnNormaliser {
    /// The largest value less the smallest.
    Range,
    /// The magnitude of the mean.
    Mean,
}
