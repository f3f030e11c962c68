//! What the data say of the errors that a channel's values share: plain data that becomes JSON.

use serde::Serialize;

use super::problem::{Channel, SharedKind};

/// A shared error of a measured channel, as the data prefer it.
#[derive(Clone, Debug, Serialize)]
pub struct SharedOutcome {
    /// The channel.
    pub name: String,
    /// What its values share.
    pub kind: SharedKind,
    /// The unit of an offset.
    pub unit: Option<String>,
    /// The mean, which a normal approximation has at its most probable value.
    pub value: f64,
    /// The interval that holds it with 95 % probability.
    pub interval: [f64; 2],
    /// How large it may be, as stated.
    pub limit: f64,
    /// The stated limit over the standard uncertainty: the coverage factor k, or the root of 3 of a limit of error.
    pub coverage: f64,
    /// The part of its standard uncertainty that the data leave.
    pub left: f64,
}

impl SharedOutcome {
    /// A channel's error with this mean, standard deviation and interval.
    pub fn new(channel: &Channel, [value, deviation]: [f64; 2], interval: [f64; 2]) -> Self {
        Self {
            name: channel.name.clone(),
            kind: channel.kind,
            unit: channel.unit.clone(),
            value,
            interval,
            limit: channel.limit,
            coverage: channel.limit / channel.standard(),
            left: deviation / channel.standard(),
        }
    }
}
