//! The sections of a study as they are written.

use std::path::PathBuf;

use ::curves::Metric;
use conformity::uncertainty::Distribution;
use fmu_import::quantity::Quantity;
use indexmap::IndexMap;
use sampling::statistics::{Direction, Statistic};
use serde::{Deserialize, Serialize};
use toml::Spanned;

use crate::{
    name::Name,
    reference::{Normalise, ReferenceText},
    tolerance::ToleranceText,
    window::{self, Window},
};

/// An operating point or a test of the model. The parameters are common to all cases; what a case gives itself counts more
/// than what the study gives for all.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CaseText {
    /// Its name, which begins the names of its criteria.
    pub name: Name,
    /// A remark for people.
    pub about: Option<String>,
    /// What is doubtful about its recordings: a verdict says it, too.
    #[serde(default)]
    pub concerns: Vec<String>,
    /// How long and in which steps, as far as that differs from the section `[simulation]`.
    #[serde(default)]
    pub simulation: Simulation,
    /// Start values, by the names of FMU variables.
    #[serde(default)]
    pub fixed: IndexMap<Name, Spanned<Setting>>,
    /// Inputs that follow a recording, by the names of FMU variables.
    #[serde(default)]
    pub inputs: IndexMap<Name, RecordingText>,
    /// The criteria.
    #[serde(default)]
    pub criteria: IndexMap<Name, CriterionText>,
    /// Whether the case is judged as any other one, but never fitted.
    #[serde(default)]
    pub held_out: bool,
    /// By how much its measured curves may be later than they state: `identify` finds it.
    pub lag: Option<LagText>,
}

/// The range of an unknown lag.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LagText {
    /// The least one: `-2 ms`.
    pub min: Quantity,
    /// The largest one.
    pub max: Quantity,
}

impl LagText {
    /// The ends in seconds.
    ///
    /// # Errors
    /// When they are no times, or no range.
    pub fn ends(&self) -> Result<[f64; 2], String> {
        let ends = [window::seconds(&self.min)?, window::seconds(&self.max)?];
        if ends[0] < ends[1] && ends.iter().all(|end| end.is_finite()) {
            Ok(ends)
        } else {
            Err(format!("the lags from {} to {} are no range: `min` is the smaller one", self.min, self.max))
        }
    }
}

/// How long and in which steps.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Simulation {
    /// Start time, s; the FMU's default experiment otherwise.
    #[serde(default, deserialize_with = "window::time")]
    pub start: Option<f64>,
    /// Stop time, s; the FMU's default experiment otherwise.
    #[serde(default, deserialize_with = "window::time")]
    pub stop: Option<f64>,
    /// Communication step, s; the FMU's default experiment otherwise.
    #[serde(default, deserialize_with = "window::time")]
    pub step: Option<f64>,
    /// Relative tolerance passed to the FMU.
    pub tolerance: Option<f64>,
    /// Statistics leave out this long at the start, s.
    #[serde(default, deserialize_with = "window::time")]
    pub warm_up: Option<f64>,
    /// Statistics take this long at the end, s.
    #[serde(default, deserialize_with = "window::time")]
    pub window: Option<f64>,
    /// Cover the time before the window of the statistics in a single communication step; no otherwise.
    pub leap: Option<bool>,
}

/// The name of a distribution.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// `mean`, `deviation`.
    Normal,
    /// `mean`, `deviation` of the whole bell, cut at `min` and/or `max`.
    TruncatedNormal,
    /// `min`, `max`.
    Uniform,
    /// `min`, `mode`, `max`.
    Triangular,
    /// `mean`, `deviation` of the quantity itself, not of its logarithm.
    Lognormal,
    /// `file`: a column of a sample, such as `posterior.csv`; parameters from one file are drawn together.
    Sample,
    /// `value`.
    Fixed,
}

/// From where to where a parameter varies.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Varies {
    /// From case to case, such as one specimen each.
    Case,
}

/// An uncertain parameter.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename_all = "kebab-case",
    expecting = "a distribution, such as { distribution = \"normal\", mean = 1, deviation = 0.1 }"
)]
pub struct ParameterText {
    /// The distribution.
    pub distribution: Shape,
    /// The mean.
    pub mean: Option<Quantity>,
    /// The standard deviation.
    pub deviation: Option<Quantity>,
    /// The smallest value.
    pub min: Option<Quantity>,
    /// The most probable value of a triangle.
    pub mode: Option<Quantity>,
    /// The largest value.
    pub max: Option<Quantity>,
    /// The value that is fixed.
    pub value: Option<Quantity>,
    /// The sample that it is drawn from, relative to the study file.
    pub file: Option<Spanned<PathBuf>>,
    /// The unit of the numbers, and of the column in `points.csv`.
    pub unit: Option<String>,
    /// Its column in a table of points, and in the sample; its own name otherwise.
    pub column: Option<String>,
    /// Whether each case has its own value, from a common mean and spread, which `identify` estimates.
    pub varies: Option<Spanned<Varies>>,
    /// A remark for people.
    pub about: Option<String>,
}

/// An input over time, from a table.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename_all = "kebab-case",
    expecting = "a table of values, such as { file = \"drive.csv\" }"
)]
pub struct RecordingText {
    /// The table, relative to the study file.
    pub file: Spanned<PathBuf>,
    /// Its column; the input's own name otherwise.
    pub column: Option<String>,
    /// The column of the time, s; `time` otherwise.
    pub time: Option<String>,
    /// The unit of the column.
    pub unit: Option<String>,
    /// How much all its rows together may be off, expanded (k = 2): the zero error of the sensor. Like a parameter it is drawn, and
    /// found by `identify`; so is the error of its gain.
    pub uncertainty: Option<Quantity>,
    /// The expanded uncertainty of its gain, as a part of the value.
    pub gain_uncertainty: Option<Quantity>,
    /// The standard deviation of the errors of single rows, which are drawn.
    pub noise: Option<Quantity>,
    /// By how much all its rows are known to be too high: it is taken off them. `identify` writes the one that it finds.
    pub offset: Option<Quantity>,
    /// By what part of the value they are known to be too high, likewise.
    pub gain: Option<Quantity>,
    /// Whether a value holds until the next row; straight lines otherwise.
    #[serde(default)]
    pub hold: bool,
    /// Whether the FMU lets it vary along a straight line within a step.
    #[serde(default)]
    pub ramp: bool,
    /// Whether the first and the last value hold where the run is longer; such a recording is refused otherwise.
    pub extrapolate: Option<Extrapolate>,
    /// A remark for people.
    pub about: Option<String>,
}

/// An input's value beyond the ends of its recording.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extrapolate {
    /// The first and the last value.
    Hold,
}

/// A start value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "a start value is a number, true or false, or a text such as \"14 N.s/m\"")]
pub enum Setting {
    /// Yes or no.
    Boolean(bool),
    /// A number, in the variable's unit.
    Integer(i64),
    /// A number, in the variable's unit.
    Number(f64),
    /// A number with a unit, an item's name, or a text.
    Text(String),
}

/// Measured value of one quantity with its tolerance.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename_all = "kebab-case",
    expecting = "a section with a name, [criteria.NAME], and variable, nominal, tolerance"
)]
pub struct CriterionText {
    /// The FMU's variable.
    pub variable: Spanned<String>,
    /// Statistic that turns the signal into one number.
    pub statistic: Option<Statistic>,
    /// The percent of the time that a percentile leaves below.
    pub percent: Option<Spanned<f64>>,
    /// The time of the value, in place of a statistic.
    pub at: Option<Spanned<Quantity>>,
    /// The angle over whose whole turns the mean is taken.
    pub turns: Option<Spanned<String>>,
    /// The level that a signal crosses.
    pub level: Option<Spanned<Quantity>>,
    /// The way in which it crosses the level; either one otherwise.
    pub direction: Option<Spanned<Direction>>,
    /// The measured value.
    pub nominal: Option<Quantity>,
    /// Where that comes from as long as nothing is measured.
    pub nominal_from: Option<NominalFrom>,
    /// The accuracy to both sides: `0.5 degC`, or `0.75 %` of the nominal value in the
    /// criterion's unit. Of a curve, the largest error.
    pub tolerance: Option<ToleranceText>,
    /// The largest value that is accepted, in place of a measured value and its tolerance.
    pub at_most: Option<Quantity>,
    /// The least value that is accepted, likewise.
    pub at_least: Option<Quantity>,
    /// The measured value beside such a limit, for the comparison with the model.
    pub measured: Option<Quantity>,
    /// The criterion whose measured value this one's is a multiple of.
    pub derived: Option<DerivedText>,
    /// The measured curve, in place of a measured value.
    pub reference: Option<ReferenceText>,
    /// How the curves are compared.
    pub metric: Option<Metric>,
    /// By what a normalised error is divided; the range of the reference otherwise.
    pub normalise: Option<Normalise>,
    /// The half width of a corridor: `0.02 N.m`, or `5 %` of each value.
    pub band: Option<Quantity>,
    /// The least share inside the corridor, or the least rating.
    pub least: Option<Quantity>,
    /// By how much the measured curve is late.
    pub delay: Option<Quantity>,
    /// By how much it may be later than that: `identify` finds it.
    pub lag: Option<LagText>,
    /// The expanded uncertainty of the measured value, given like the tolerance.
    pub uncertainty: Option<Spanned<Quantity>>,
    /// How many standard uncertainties that is; 2 otherwise.
    pub coverage: Option<Spanned<f64>>,
    /// The distribution of the measured value's offset, which `uncertainty` describes; normal otherwise.
    pub uncertainty_distribution: Option<Distribution>,
    /// The expanded uncertainty of the gain, as a part of the value.
    pub gain_uncertainty: Option<Spanned<Quantity>>,
    /// The standard deviation of one reading, which is independent from reading to reading.
    pub noise: Option<Spanned<Quantity>>,
    /// Of how many readings the measured value is the mean.
    pub repeats: Option<f64>,
    /// The part of the run that it looks at; that of `[simulation]` otherwise.
    pub window: Option<Spanned<Window>>,
    /// The unit of the numbers, and of the column in `points.csv`.
    pub unit: Option<String>,
    /// The group in which it is counted.
    pub group: Option<String>,
    /// Its column in a table of results; its own name, or the variable's, otherwise.
    pub column: Option<String>,
    /// The unit of that column, where it is another one.
    pub column_unit: Option<String>,
    /// A remark for people.
    pub about: Option<String>,
    /// The number of its case, where the study has cases.
    #[serde(skip)]
    pub case: Option<usize>,
}

impl CriterionText {
    /// The column of its measured curve in the recording: that of the variable's name where none is stated.
    pub fn recorded_column(&self) -> &String {
        let stated = self.reference.as_ref().and_then(|reference| reference.column.as_ref());
        stated.unwrap_or_else(|| self.variable.as_ref())
    }

    /// Whether another criterion judges the same number of the same run, in the same unit.
    pub fn judges_as(&self, other: &Self) -> bool {
        let is_curve = self.reference.is_some() || other.reference.is_some();
        !is_curve
            && (self.case, &self.variable, &self.unit) == (other.case, &other.variable, &other.unit)
            && self.statistic.unwrap_or_default() == other.statistic.unwrap_or_default()
            && self.window == other.window
            && (&self.percent, &self.at, &self.level) == (&other.percent, &other.at, &other.level)
            && (&self.direction, &self.turns) == (&other.direction, &other.turns)
    }
}

/// Where a nominal value comes from, where that is no measurement.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NominalFrom {
    /// A run of the model itself, as in a study that `init` writes.
    Model,
}

/// A measured value that is the product of two others, so that its error follows from theirs.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, expecting = "the factors, such as { from = \"torque\", by = \"drive.speed\" }")]
pub struct DerivedText {
    /// The criterion with the first factor.
    pub from: Name,
    /// The criterion with the other one, an input or a parameter. An input counts with what its sensor read.
    pub by: Name,
}

/// The rule for the model as a whole.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Required {
    /// The share of the sampled space that must meet all criteria: `5 %`, or `0.05`.
    pub share: Spanned<Quantity>,
    /// How sure that must be; 0.95 otherwise.
    pub confidence: Option<Spanned<f64>>,
    /// The largest probability that an accepted point does not conform; sets the guard band.
    pub risk: Option<Spanned<Quantity>>,
    /// The largest probability not to conform of each accepted point.
    pub point_risk: Option<Spanned<Quantity>>,
    /// The guard band of every criterion, in expanded uncertainties.
    pub guard_band: Option<Spanned<f64>>,
}
