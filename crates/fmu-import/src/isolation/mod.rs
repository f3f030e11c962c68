//! Points in processes of their own, so that whatever an FMU does costs its own point only.
//!
//! - [`frame`]: bytes between processes, with length and checksum;
//! - [`fork`]: one piece of work in a forked child;
//! - [`offspring`]: what an FMU leaves running is found and ended.

pub mod fork;
pub mod frame;
pub mod offspring;
