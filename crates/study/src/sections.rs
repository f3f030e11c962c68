//! Sections of a study with defaults for the options of single commands.

use indexmap::IndexMap;
use serde::Deserialize;
use toml::Spanned;

use super::Name;
use fmu_import::quantity::Quantity;

/// The section `[sensitivity]`: defaults for the options of that command.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SensitivityText {
    /// The method: `sobol` or `morris`.
    pub method: Option<Spanned<String>>,
    /// How much is run: base points of `sobol`, trajectories of `morris`.
    pub size: Option<Spanned<u64>>,
    /// The seed of the runs.
    pub seed: Option<u64>,
}

/// The section `[robustness]`: defaults for the options of that command.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RobustnessText {
    /// The verification probability that the box must hold, between 0 and 1.
    pub level: Option<Spanned<f64>>,
    /// New runs in each, by which they are confirmed.
    pub confirm: Option<usize>,
    /// The seed of samples and runs.
    pub seed: Option<u64>,
}

/// The section `[tolerances]`: what that command looks for.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TolerancesText {
    /// The share of accepted points that must hold; that of `[verdict]` otherwise.
    pub share: Option<Spanned<Quantity>>,
    /// The conformance probability that must hold instead.
    pub conformance: Option<Spanned<Quantity>>,
    /// Relative cost of a narrower tolerance of a parameter; 1 where none is given.
    #[serde(default)]
    pub costs: IndexMap<Name, Spanned<f64>>,
    /// The widest tolerance that is looked at, in those of the study; 3 otherwise.
    pub limit: Option<Spanned<f64>>,
    /// Points of each round of the search.
    pub points: Option<u64>,
    /// Fresh runs that confirm the result.
    pub confirm: Option<u64>,
    /// The seed of the runs.
    pub seed: Option<u64>,
}
