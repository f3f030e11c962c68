//! Points in processes of their own, so that whatever an FMU does costs its own point only.
//!
//! - [`ControlGroup`]: processes that end together, where the system allows such groups;
//! - [`frame`]: bytes between processes, with length and checksum;
//! - [`keeper`]: a process that starts children, watches them and outlives whatever they do;
//! - `offspring`: what an FMU leaves running is found and ended (Unix);
//! - [`watch`]: whether anything was changed in a folder that points share;
//! - `words`: what children print, as far as it is worth keeping.
//!
//! On Unix a child is a fork, and signals and process groups end it with what it has started. Windows has neither:
//! there a child is a program of its own, and a job object ends it.

#[cfg(unix)]
mod birth;
mod child;
#[cfg(unix)]
mod control_group;
pub mod frame;
#[cfg(unix)]
pub mod keeper;
mod loss;
#[cfg(unix)]
pub mod offspring;
#[cfg(unix)]
mod system;
mod tail;
pub mod watch;
#[cfg(windows)]
mod windows;
#[cfg(unix)]
pub mod words;

#[cfg(unix)]
pub use birth::ChildEnd;
pub use child::Child;
#[cfg(unix)]
pub use control_group::ControlGroup;
pub use frame::Broken;
pub use keeper::Keeper;
pub use loss::{Bounds, Loss, Parting};
#[cfg(windows)]
pub use windows::birth::ChildEnd;
#[cfg(windows)]
pub use windows::job::ControlGroup;
#[cfg(windows)]
pub use windows::{keeper, pipe, process};
