//! The FMI 2.0 Co-Simulation boundary, generic over any [`Model`](crate::model::Model).
//!
//! From the outside in:
//! - [`exports`]: the C functions, defined for one model by [`export!`](crate::export);
//! - [`calls`]: the same functions, generic over the model. Raw pointers end here;
//! - `guard`: the checks that every call passes (handle, state machine, panics), and `raw`, the checks of its pointers;
//! - `instance`: one instance, in safe Rust, with `values`, `snapshot` and `derivatives`;
//! - [`description`]: the model description, written from the variable table.
//!
//! An instance owns all its data and the boundary has no globals, so any number of instances can run in any number of
//! threads. A second call to an instance that is at work is refused.

pub mod calls;
pub mod description;
pub mod exports;
pub mod types;

mod derivatives;
mod guard;
mod instance;
mod logger;
mod phase;
mod raw;
mod refusal;
mod resources;
mod snapshot;
mod values;
mod xml;
