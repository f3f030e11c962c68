//! A plain-bearing test stand: drive, load mechanism, bearing, oil, heat transfer and sensors,
//! and its export as an FMI 2.0 Co-Simulation FMU.
//!
//! The physics (all modules but [`fmi2`]) never knows FMI; the boundary never knows bearings.
//! What they share is [`model`]: a model with variables.

pub mod bearing;
pub mod fmi2;
pub mod model;
