//! The part of an FMI boundary that does not depend on the standard's version: one instance, in safe Rust.
//!
//! - `guard`: the checks that every call passes (handle, state machine, panics), and `raw`, the checks of its pointers;
//! - `instance`: one instance, with `values`, `snapshot`, `derivatives`, for Model Exchange `exchange`, and
//!   `intermediate` for hosts that look into communication steps;
//! - `phase`: where an instance is in its life;
//! - `calls`: makes C functions of a version's table of them;
//! - `description`, with `describe` and `xml`: the model descriptions of all versions.
//!
//! An instance owns all its data and the only global is the description's fingerprint, so any number of instances can run in any number of
//! threads. A second call to an instance that is at work is refused.

pub mod calls;
pub mod derivatives;
pub mod describe;
pub mod description;
pub mod exchange;
pub mod guard;
pub mod instance;
pub mod intermediate;
pub mod logger;
pub mod lookup;
pub mod phase;
pub mod raw;
pub mod refusal;
pub mod resources;
pub mod run;
pub mod snapshot;
pub mod types;
pub mod values;
pub mod version;
pub mod watch;
pub mod xml;
