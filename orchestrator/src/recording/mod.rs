//! The recording of a rig for `synchronise`: its table, and the settings that say what stands in it.

mod recorded;
pub mod settings;

pub use settings::Settings;
