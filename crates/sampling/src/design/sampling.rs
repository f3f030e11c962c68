//! The `[design]` section of a study: method, number of points, seed.

use serde::Deserialize;

use super::Method;

/// Which points are simulated: the section `[design]` of a study.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Sampling {
    /// How they are chosen.
    pub method: Method,
    /// How many.
    pub points: u64,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Of a Sobol net: how many nets, scrambled independently of each other, the points belong to
    /// in turn. Their scatter says how sure the counts are.
    pub replicates: u64,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { method: Method::default(), points: 50, seed: 1, replicates: 1 }
    }
}
