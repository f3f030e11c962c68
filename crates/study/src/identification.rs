//! The section `[identify]` of a study.

use std::path::PathBuf;

use indexmap::IndexMap;
use serde::Deserialize;
use toml::Spanned;

use super::Name;
use calibration::problem::Spacing;
use fmu_import::quantity::Quantity;
use sampling::statistics::Statistic;

/// Unknown parameters, measurements, and the effort of the search.
#[derive(Clone, Debug, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Identification {
    /// The table whose rows are the measured cases, relative to the study; one case otherwise.
    pub cases: Option<Spanned<PathBuf>>,
    /// Starts that are screened.
    pub starts: u64,
    /// Starts that are followed to a minimum.
    pub descents: usize,
    /// The most iterations of each.
    pub iterations: usize,
    /// Seed of the random starts.
    pub seed: u64,
    /// Particles of the posterior's sample; none is made without this.
    pub posterior: Option<Spanned<u64>>,
    /// How far apart simulations stand for a derivative, as a part of the distance between the bounds.
    pub difference: f64,
    /// The parameters to be found, by the names of FMU variables.
    pub free: IndexMap<Name, FreeText>,
    /// The parameters that the table has for each case.
    pub known: IndexMap<Name, KnownText>,
    /// The parameters that each case knows to an interval only.
    pub latent: IndexMap<Name, LatentText>,
    /// Measured values.
    pub measured: IndexMap<Name, MeasuredText>,
}

impl Default for Identification {
    /// The usual effort, and nothing to be found.
    fn default() -> Self {
        Self {
            cases: None,
            starts: 64,
            descents: 8,
            iterations: 40,
            seed: 1,
            posterior: None,
            difference: 1e-3,
            free: IndexMap::new(),
            known: IndexMap::new(),
            latent: IndexMap::new(),
            measured: IndexMap::new(),
        }
    }
}

/// A parameter to be found.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FreeText {
    /// The smallest value.
    pub min: Quantity,
    /// The largest value.
    pub max: Quantity,
    /// How it is measured out between them.
    #[serde(default)]
    pub scale: Spacing,
    /// The most probable value before the measurement, on a linear scale.
    pub mean: Option<Quantity>,
    /// Its standard deviation.
    pub deviation: Option<Quantity>,
    /// The most probable value before the measurement, on a logarithmic scale.
    pub median: Option<Quantity>,
    /// The factor that stands for one standard deviation.
    pub factor: Option<f64>,
    /// The unit of the numbers.
    pub unit: Option<String>,
    /// A remark for people.
    pub about: Option<String>,
}

/// A parameter that the table has for each case.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct KnownText {
    /// Its column.
    pub column: String,
    /// The unit of the column.
    pub unit: Option<String>,
    /// A remark for people.
    pub about: Option<String>,
}

/// A parameter that each case knows to an interval only.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct LatentText {
    /// The column of the intervals' middles.
    pub column: Option<String>,
    /// The middle of the interval, where the table has no column of it.
    pub value: Option<Quantity>,
    /// The distance of the ends from the middle.
    pub within: Quantity,
    /// The unit of the numbers and the column.
    pub unit: Option<String>,
    /// Cases with other intervals.
    #[serde(default)]
    pub except: Vec<Exception>,
    /// A remark for people.
    pub about: Option<String>,
}

/// A case with another interval.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Exception {
    /// The case: its `point` in the table, or its row from 1.
    pub case: Spanned<u64>,
    /// The distance of both ends from the middle.
    pub within: Option<Quantity>,
    /// The distance of the lower end.
    pub below: Option<Quantity>,
    /// The distance of the upper end.
    pub above: Option<Quantity>,
    /// A remark for people.
    pub about: Option<String>,
}

/// Measured values.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct MeasuredText {
    /// The FMU's variable.
    pub variable: Spanned<String>,
    /// Statistic that turns the signal into one number.
    #[serde(default)]
    pub statistic: Statistic,
    /// The column of the measured values.
    pub column: Option<String>,
    /// The measured value, where the table has no column of it.
    pub value: Option<Quantity>,
    /// The standard uncertainty of what is independent from case to case: one standard deviation, or percents of the value.
    pub accuracy: Quantity,
    /// The expanded uncertainty (k = 2) of an offset that the values of all cases share.
    pub uncertainty: Option<Quantity>,
    /// That of a gain that they share, as a part of the value.
    pub gain_uncertainty: Option<Quantity>,
    /// The unit of the numbers and the column.
    pub unit: Option<String>,
    /// A remark for people.
    pub about: Option<String>,
}
