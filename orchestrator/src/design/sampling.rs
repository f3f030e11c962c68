//! What a study says of its points: the method, how many, the seed.

use serde::{Deserialize, Serialize};

/// How points are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Independent random points.
    #[default]
    MonteCarlo,
    /// One point in each of N equally probable slices of every parameter.
    LatinHypercube,
    /// A Latin hypercube whose slices are paired so that the points spread evenly.
    OptimisedLatinHypercube,
    /// A scrambled Sobol net.
    Sobol,
    /// A scrambled Halton sequence.
    Halton,
    /// Every combination of the parameters' levels.
    FullFactorial,
}

impl Method {
    /// Whether the first points stay the same when there are more: then fewer may be enough.
    pub fn is_extensible(self) -> bool {
        matches!(self, Self::MonteCarlo | Self::Sobol | Self::Halton)
    }
}

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
        Self {
            method: Method::default(),
            points: 50,
            seed: 1,
            replicates: 1,
        }
    }
}
