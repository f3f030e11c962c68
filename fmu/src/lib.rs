//! A plain-bearing test stand: drive, load mechanism, bearing, oil, heat transfer and sensors, exported as a
//! Co-Simulation FMU of FMI 2.0 and 3.0.
//!
//! The modules compute in SI units and know nothing of FMI, which comes from [`fmu_export`]. Start reading at [`stand`],
//! where the blocks are wired, and at [`variables`], which names all that hosts can set and read.

pub mod bearing;
pub mod documentation;
pub mod drive;
pub mod load;
#[cfg(any(target_os = "linux", target_os = "macos", windows))]
mod load_time;
pub mod multirate;
pub mod oil;
#[cfg(target_family = "wasm")]
pub mod picture;
pub mod sensors;
pub mod solver;
pub mod stand;
pub mod thermal;
pub mod variables;

/// What a block has computed, or why it cannot.
pub type Result<T = (), E = fmu_export::model::Fault> = std::result::Result<T, E>;

fmu_export::export!(stand::Stand);
