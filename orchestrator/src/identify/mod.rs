//! Identification of an FMU's parameters: the crate `calibration`, tied to a study and an FMU.
//!
//! - [`bind`] ties the section `[identify]` of a study to an FMU and a table;
//! - [`from_study`] takes the cases of the study as the data;
//! - [`model`] asks the FMU for predictions.

pub mod bind;
mod fitted;
pub mod from_study;
pub mod late;
pub mod model;
pub mod offsets;
mod shared;
mod unknowns;
