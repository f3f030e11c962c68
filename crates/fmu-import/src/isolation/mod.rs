//! Points in processes of their own, so that whatever an FMU does costs its own point only.
//!
//! - [`ControlGroup`]: processes that end together, where the system allows such groups;
//! - [`frame`]: bytes between processes, with length and checksum;
//! - [`keeper`]: a process that forks children, watches them and outlives whatever they do;
//! - [`offspring`]: what an FMU leaves running is found and ended;
//! - [`watch`]: whether anything was changed in a folder that points share;
//! - [`words`]: what children print, as far as it is worth keeping.

mod birth;
mod control_group;
pub mod frame;
pub mod keeper;
pub mod offspring;
mod system;
pub mod watch;
pub mod words;

pub use control_group::ControlGroup;
pub use frame::Broken;
pub use keeper::{Bounds, Child, Keeper, Loss, Parting, Place};
