//! The model description of FMI 2.0, `modelDescription.xml`, written from the model's variable table.

use crate::boundary::describe::Interface::{CoSimulation, ModelExchange};
use crate::boundary::description;
use crate::boundary::version::Version::Two;
use crate::model::Model;

/// The GUID of a description with this fingerprint.
pub use crate::boundary::describe::token as guid;

/// The text of `modelDescription.xml` for Co-Simulation.
pub fn xml<M: Model>() -> String {
    description::xml::<M>(Two, CoSimulation)
}

/// The text of `modelDescription.xml` for Model Exchange, of a model with [`Model::EXCHANGE`].
pub fn exchange_xml<M: Model>() -> String {
    description::xml::<M>(Two, ModelExchange)
}

/// A hash of the whole description, GUID apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>() -> u128 {
    description::fingerprint::<M>(Two, CoSimulation)
}

/// The same of the description for Model Exchange.
pub fn exchange_fingerprint<M: Model>() -> u128 {
    description::fingerprint::<M>(Two, ModelExchange)
}
