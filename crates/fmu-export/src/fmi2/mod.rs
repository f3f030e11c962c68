//! The FMI 2.0 Co-Simulation boundary: generic over any [`crate::model::Model`].
//!
//! From the outside in:
//! - [`exports`]: the C functions, made for one model by [`export!`](crate::export);
//! - [`calls`]: the same functions, generic over the model; raw pointers end here;
//! - `guard`: what every call passes (handle, turn, state machine, panics), and `raw`, its pointers;
//! - `instance`: one instance, in safe Rust, with `values`, `snapshot` and `derivatives`;
//! - [`description`]: the model description, generated from the variable table.
//!
//! An instance owns all its data; the boundary has no globals, so that any number of instances
//! can run in any number of threads, each instance in one thread at a time.

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
