//! Sections of a study with defaults for the options of single commands.

use serde::Deserialize;
use toml::Spanned;

/// The section `[sensitivity]`: defaults for the options of that command.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SensitivityText {
    /// The method: `sobol`, or `morris`.
    pub method: Option<Spanned<String>>,
    /// How much is run: base points of `sobol`, trajectories of `morris`.
    pub size: Option<u64>,
    /// How first-order Sobol indices are estimated: `jansen`, or `saltelli`.
    pub estimator: Option<Spanned<String>>,
    /// The seed of the runs.
    pub seed: Option<u64>,
}

/// The section `[robustness]`: defaults for the options of that command.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RobustnessText {
    /// The verification probability that box and ellipsoid must hold, between 0 and 1.
    pub level: Option<Spanned<f64>>,
    /// New runs in each, by which they are confirmed.
    pub confirm: Option<usize>,
    /// The seed of samples and runs.
    pub seed: Option<u64>,
}
