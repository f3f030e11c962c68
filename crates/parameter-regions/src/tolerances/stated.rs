//! The statement about the widest tolerances, as it stands in the result's file.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use conformity::decision::Decision;

/// The goal of the tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wanted {
    /// A share of accepted points.
    #[default]
    Accepted,
    /// A conformance probability.
    Conforming,
}

/// The widest tolerances, or why there are none.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Tolerances {
    /// The required share or probability.
    pub wanted: Wanted,
    /// The least share or probability that is required.
    pub share: f64,
    /// The confidence with which it must hold.
    pub confidence: f64,
    /// Why no tolerances would do; empty where some do.
    pub reasons: Vec<String>,
    /// The parameters with their tolerances.
    pub parameters: Vec<Parameter>,
    /// The share or probability at the widest tolerances, from the weighted points.
    pub widest: Option<Stated>,
    /// The same at the stated ones, which are narrower, so that fresh runs can show it.
    pub stated: Option<Stated>,
    /// The result of the fresh runs at the stated tolerances.
    pub confirmed: Option<Confirmed>,
    /// Points that the weights rest on.
    pub points: u64,
    /// How many runs the surrogate was fitted to that told what came of these points, where there was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surrogate: Option<usize>,
    /// Rounds in which further points were run.
    pub rounds: u64,
}

/// The tolerance of a parameter; scales are in the study's own tolerance.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Parameter {
    /// The FMU's variable.
    pub name: String,
    /// The unit of the study's numbers.
    pub unit: Option<String>,
    /// Relative cost of a narrower tolerance.
    pub cost: f64,
    /// The study's distribution in words.
    pub own: String,
    /// The scale at which the wanted share is just achieved.
    pub widest_scale: f64,
    /// The distribution there.
    pub widest: String,
    /// The scale that is stated.
    pub scale: f64,
    /// The distribution there.
    pub stated: String,
    /// The same as numbers.
    pub distribution: IndexMap<String, serde_json::Value>,
    /// Whether it is only as narrow as the search was limited.
    pub limited: bool,
}

/// A share estimated from weighted points.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Stated {
    /// The share.
    pub share: f64,
    /// The range in which the fresh runs' result falls with a probability of 99 %.
    pub interval: [f64; 2],
    /// The effective sample size.
    pub effective_points: f64,
}

/// The result of the fresh runs.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Confirmed {
    /// How many.
    pub runs: u64,
    /// The share.
    pub share: f64,
    /// Its interval at the wanted confidence.
    pub interval: [f64; 2],
    /// Whether the wanted share holds.
    pub decision: Decision,
}
