//! Turns a simulation model written in Rust into an FMU of FMI 2.0 for Co-Simulation.
//!
//! A [`model::Model`] declares its variables once, in a table. The model description, the value references and the
//! C functions of the standard follow from that table: see [`export!`].
//!
//! The physics of a model never sees FMI; the boundary in [`fmi2`] never sees physics.

pub mod declare;
pub mod fmi2;
pub mod model;
pub mod units;
