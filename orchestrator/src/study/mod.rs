//! A study: what is simulated, what is uncertain, and what the measurement says.
//!
//! [`Study`] is the content of the TOML file, [`plan`] ties it to an FMU.

mod bind;
pub mod cases;
mod curves;
mod detail;
pub mod dossier;
mod error;
pub mod identification;
mod input;
pub(crate) mod inputs;
pub(crate) mod limit;
mod once;
pub mod plan;
pub mod points;
mod reference;
mod samples;
#[cfg(test)]
mod schema_tests;
mod sections;
mod shape;
pub mod ssv;
#[cfg(test)]
mod tests;
mod tolerance;
pub mod values;
mod window;

use std::fmt::Display;
use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use sha2::{Digest, Sha256};
use toml::Spanned;

pub use detail::first_wrong;
pub use dossier::Dossier;
pub use error::BOTH_SIDES;
pub use identification::Identification;
pub use reference::{DelayText, EstimateText, Normalise, ReferenceText};
pub use sections::{RobustnessText, SensitivityText, TolerancesText};
pub use tolerance::ToleranceText;
pub use window::Window;

use crate::error::Error;
use crate::error::unusable;
use ::curves::Metric;
use conformity::uncertainty::Distribution;
use error::Place;
use fmu_import::quantity::Quantity;
use fmu_import::{ArchiveError, FmuError, FmuFault, Package, digest, sha256};
use number_tables::files;
use number_tables::files::FileError;
use sampling::design::Sampling;
use sampling::statistics::{Direction, Statistic};

/// A name with its place in the file.
pub type Name = Spanned<String>;

/// The content of a study file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Study {
    /// The title of the report.
    pub title: Option<String>,
    /// Purpose of the study, for people.
    pub about: Option<String>,
    /// The FMU, relative to the study file.
    pub fmu: Spanned<PathBuf>,
    /// How long and in which steps.
    #[serde(default)]
    pub simulation: Simulation,
    /// The design: method, number and seed of the points.
    #[serde(default)]
    pub design: Sampling,
    /// The uncertain parameters by the names of FMU variables.
    #[serde(default)]
    pub parameters: IndexMap<Name, ParameterText>,
    /// Correlations between parameters.
    #[serde(default)]
    pub correlations: Vec<Spanned<Pair>>,
    /// Start values that stay as they are, by the names of FMU variables.
    #[serde(default)]
    pub fixed: IndexMap<Name, Spanned<Setting>>,
    /// An SSP parameter set with further start values; those of the study itself count more.
    pub fixed_from: Option<Spanned<PathBuf>>,
    /// Inputs that follow a recording, by the names of FMU variables.
    #[serde(default)]
    pub inputs: IndexMap<Name, RecordingText>,
    /// The criteria: measured values with their tolerances.
    #[serde(default)]
    pub criteria: IndexMap<Name, CriterionText>,
    /// Operating points or tests of the model, each with inputs, fixed values and criteria of its own. Where there are
    /// any, the criteria stand in [`criteria`](Self::criteria), case by case, with names such as `CASE/NAME`.
    #[serde(default)]
    pub cases: Vec<CaseText>,
    /// Which measured values' errors are correlated, and how.
    #[serde(default)]
    pub uncertainty_correlations: Vec<Spanned<Pair>>,
    /// The section `[verdict]`: the share that is required of the model; without it, one point that meets all criteria.
    pub verdict: Option<Spanned<Required>>,
    /// Who answers for the verdict, and on which test it rests.
    pub dossier: Option<Dossier>,
    /// Other readings of the tolerances, judged beside the criteria's own.
    #[serde(default)]
    pub variants: IndexMap<String, VariantText>,
    /// The section `[identify]`: unknowns, measurements, effort of the search.
    pub identify: Option<Identification>,
    /// The section `[sensitivity]`: defaults for the options of that command.
    #[serde(default)]
    pub sensitivity: SensitivityText,
    /// The section `[robustness]`: defaults for the options of that command.
    #[serde(default)]
    pub robustness: RobustnessText,
    /// The goal of `tolerances`.
    #[serde(default)]
    pub tolerances: TolerancesText,
    /// File from which the study was read.
    #[serde(skip)]
    path: PathBuf,
    /// The text of the file.
    #[serde(skip)]
    text: String,
    /// The folder of the files that it names, where that is not its own.
    #[serde(skip)]
    base: Option<PathBuf>,
}

/// An operating point or a test of the model. The parameters are common to all cases; what a case gives itself counts more
/// than what the study gives for all.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CaseText {
    /// Its name, which begins the names of its criteria.
    pub name: Name,
    /// A remark for people.
    pub about: Option<String>,
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
        match ends[0] < ends[1] && ends.iter().all(|end| end.is_finite()) {
            true => Ok(ends),
            false => Err(format!(
                "the lags from {} to {} are no range",
                self.min, self.max
            )),
        }
    }
}

/// How long and in which steps.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Simulation {
    /// Start time, s; the FMU's default experiment otherwise.
    pub start: Option<f64>,
    /// Stop time, s; the FMU's default experiment otherwise.
    pub stop: Option<f64>,
    /// Communication step, s; the FMU's default experiment otherwise.
    pub step: Option<f64>,
    /// Relative tolerance passed to the FMU.
    pub tolerance: Option<f64>,
    /// Statistics leave out this long at the start, s.
    pub warm_up: Option<f64>,
    /// Statistics take this long at the end, s.
    pub window: Option<f64>,
    /// Cover the time before the window of the statistics in a single communication step; no otherwise.
    pub leap: Option<bool>,
}

/// The name of a distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
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
    /// How many levels it has in a full factorial.
    pub levels: Option<Spanned<u64>>,
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
    /// How much all its rows together may be off, expanded (k = 2): the zero error of the sensor. `identify` finds it with the
    /// parameters; other commands take the recording as it is.
    pub uncertainty: Option<Quantity>,
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
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Extrapolate {
    /// The first and the last value.
    Hold,
}

/// Two correlated parameters, or criteria with correlated errors of the measured values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pair {
    /// Their names.
    #[serde(deserialize_with = "exactly_two")]
    pub between: [Name; 2],
    /// The correlation coefficient of their normal scores, from -1 to 1: for normal parameters the usual one.
    pub coefficient: f64,
    /// A remark for people.
    pub about: Option<String>,
}

/// Reads a list of two. Without this, further entries would be lost without a word.
///
/// # Errors
/// When there are fewer or more.
pub fn exactly_two<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
    text: D,
) -> Result<[T; 2], D::Error> {
    let entries = Vec::deserialize(text)?;
    entries.try_into().map_err(|entries: Vec<T>| {
        let count = entries.len();
        D::Error::custom(format!(
            "a list of two is needed here, and this one has {count}"
        ))
    })
}

/// A start value.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "a start value is a number, true or false, or a text such as \"14 N.s/m\""
)]
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
    expecting = "a section with variable, nominal and tolerance"
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
    /// The variable over whose whole periods the mean is taken.
    pub periods: Option<Spanned<String>>,
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
    pub delay: Option<DelayText>,
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

/// Where a nominal value comes from, where that is no measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NominalFrom {
    /// A run of the model itself, as in a study that `init` writes.
    Model,
}

/// A measured value that is the product of two others, so that its error follows from theirs.
#[derive(Clone, Debug, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "the factors, such as { from = \"torque\", by = \"drive.speed\" }"
)]
pub struct DerivedText {
    /// The criterion with the first factor.
    pub from: Name,
    /// The criterion with the other one, or an input or a parameter, which is known exactly.
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
    /// The guard band of every criterion, in expanded uncertainties.
    pub guard_band: Option<Spanned<f64>>,
}

/// Another reading of the tolerances.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VariantText {
    /// Its meaning, and why it is there.
    pub about: Option<String>,
    /// Tolerances by the names of criteria; the others stay.
    #[serde(default)]
    pub tolerance: IndexMap<Name, ToleranceText>,
    /// Upper limits that stand alone, likewise.
    #[serde(default)]
    pub at_most: IndexMap<Name, Quantity>,
    /// Lower limits that stand alone, likewise.
    #[serde(default)]
    pub at_least: IndexMap<Name, Quantity>,
}

impl Study {
    /// Reads a study file.
    ///
    /// # Errors
    /// When it cannot be read, with line and column when it is not understood.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let is_fmu = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("fmu"));
        let message = if is_fmu {
            let path = path.display();
            format!("is an FMU, where a study is needed: `orchestrator init {path}` writes one")
        } else if number_tables::is_table(path) {
            "is a table, where a study (a TOML file) is needed".to_owned()
        } else {
            return Self::parse(path, files::text(path)?);
        };
        Err(FileError::new(path, message))
    }

    /// Reads the text of a study that stands, or would stand, at `path`.
    ///
    /// # Errors
    /// With line and column when the text is not understood.
    pub fn parse(path: &Path, text: String) -> Result<Self, FileError> {
        let place = Place { path, text: &text };
        let mut study: Self = toml::from_str(&text).map_err(|error| place.toml(&error))?;
        study.path = path.to_owned();
        study.text = text;
        study.spread_criteria()?;
        Ok(study)
    }

    /// Reads the text once more for what another command wants of it: a type with the sections that it
    /// knows, with places for its errors.
    ///
    /// # Errors
    /// With line and column when the text is not understood.
    pub fn section<T: serde::de::DeserializeOwned>(&self) -> Result<T, FileError> {
        toml::from_str(&self.text).map_err(|error| self.place().toml(&error))
    }

    /// File from which the study was read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The FMU's path, as seen from here.
    pub fn fmu_path(&self) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        folder.join(self.fmu.as_ref())
    }

    /// Opens its FMU, or another one instead.
    ///
    /// # Errors
    /// When it cannot be used; where there is none, with the place in the study that names it.
    pub fn open_fmu(&self, instead: Option<&Path>) -> Result<Package, Error> {
        let named = self.fmu_path();
        Package::open(instead.unwrap_or(&named)).map_err(|error| match error {
            FmuError {
                fault: FmuFault::Archive(ArchiveError::Missing),
                ..
            } if instead.is_none() => self.error_at(&self.fmu, unusable(&error)).into(),
            other => other.into(),
        })
    }

    /// Finds the files that the study names as if it still stood in this folder.
    pub fn rebase(&mut self, folder: PathBuf) {
        self.base = Some(folder);
    }

    /// The path of a file that the study names, as seen from here.
    pub fn path_of(&self, file: &Path) -> PathBuf {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        self.base.as_deref().unwrap_or(folder).join(file)
    }

    /// The same, in one spelling: two names of one file, such as `a.csv` and `./a.csv`, have one path.
    pub(super) fn one_path(&self, file: &Path) -> PathBuf {
        let path = self.path_of(file);
        path.canonicalize().unwrap_or(path)
    }

    /// Whether a sample gives several parameters, which are drawn together.
    pub fn binds_by_samples(&self) -> bool {
        let files = self.parameters.values().filter_map(|p| p.file.as_ref());
        let mut files: Vec<PathBuf> = files.map(|file| self.one_path(file.as_ref())).collect();
        files.sort_unstable();
        files.windows(2).any(|pair| pair[0] == pair[1])
    }

    /// The SHA-256 digest of the study's text, and of the inputs, samples and parameter sets that it names, as
    /// hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut bytes = self.text.clone().into_bytes();
        for file in self.named() {
            // An unreadable file is reported where it is used.
            let hash = files::open(&self.path_of(file)).and_then(sha256);
            bytes.extend(hash.unwrap_or_else(|_| Sha256::digest([]).into()));
        }
        digest(&bytes)
    }

    /// All files that the study names, but the FMU.
    pub fn files(&self) -> Vec<&Path> {
        let identify = self.identify.as_ref();
        let cases = identify.and_then(|identify| identify.cases.as_ref());
        self.named()
            .chain(cases.map(|file| file.as_ref().as_path()))
            .collect()
    }

    /// The files that a verdict depends on.
    fn named(&self) -> impl Iterator<Item = &Path> {
        let of_cases = self.cases.iter().flat_map(|case| case.inputs.values());
        let inputs = self.inputs.values().chain(of_cases);
        let inputs = inputs.map(|input| &input.file);
        let criteria = self.criteria.values();
        let curves = criteria.filter_map(|text| Some(&text.reference.as_ref()?.file));
        let samples = self.parameters.values();
        let samples = samples.filter_map(|parameter| parameter.file.as_ref());
        let named = inputs.chain(curves).chain(samples);
        let named = named.chain(&self.fixed_from);
        named.map(|file| file.as_ref().as_path())
    }

    /// The study's text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// An error at a place in the file.
    pub fn error_at<T>(&self, at: &Spanned<T>, message: impl Into<String>) -> FileError {
        self.place().error(at.span().start, message.into())
    }

    fn place(&self) -> Place<'_> {
        Place {
            path: &self.path,
            text: &self.text,
        }
    }

    /// An error of what a name in the file stands for.
    pub fn error_of(&self, name: &Name, message: impl Display) -> FileError {
        self.error_at(name, format!("{}: {message}", name.as_ref()))
    }

    /// An error of a section, or of the study as a whole: at the key that the message names, where the file has it.
    pub fn error(&self, message: impl Into<String>) -> FileError {
        self.place().named(message.into())
    }
}
