//! A plain-bearing test stand: drive, load mechanism, bearing, oil, heat transfer and sensors,
//! and its export as an FMI 2.0 Co-Simulation FMU.
//!
//! The physics (all modules but [`fmi2`]) never knows FMI; the boundary never knows bearings.
//! What they share is [`model`]: a model with variables. Start reading at [`stand`].

pub mod bearing;
pub mod documentation;
pub mod drive;
pub mod load;
pub mod multirate;
pub mod oil;
pub mod sensors;
pub mod solver;
pub mod stand;
pub mod thermal;
pub mod variables;

fmu_export::export!(stand::Stand);
