#![doc = include_str!("../README.md")]

mod bind;
pub mod case_table;
pub mod cases;
pub mod concern;
mod detail;
mod error;
mod file;
pub mod identification;
mod input;
pub mod inputs;
pub mod judge;
pub mod limit;
mod measured;
mod name;
mod once;
mod opening;
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
mod text;
mod tolerance;
pub mod values;
mod window;

pub use detail::{Detail, first_wrong};
pub use error::BOTH_SIDES;
pub use file::Study;
pub use identification::Identification;
pub use name::{Name, Pair, exactly_two};
pub use opening::{OpenError, unusable};
pub use reference::{EstimateText, Normalise, ReferenceText};
pub use sections::{RobustnessText, SensitivityText, TolerancesText};
pub use text::{
    CaseText, CriterionText, DerivedText, Extrapolate, LagText, NominalFrom, ParameterText, RecordingText, Required,
    Setting, Shape, Simulation, Varies,
};
pub use tolerance::ToleranceText;
pub use window::Window;

pub use number_tables::files::Result;
