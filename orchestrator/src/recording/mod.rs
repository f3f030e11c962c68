//! The recording of a rig for `synchronise`: its table, and the settings that say what stands in it.

mod mistake;
mod recorded;
pub mod settings;

pub use mistake::SettingsError;
pub use settings::Settings;
