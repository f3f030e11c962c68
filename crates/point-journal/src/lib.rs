#![doc = include_str!("../README.md")]

mod error;
pub mod files;
mod finished;
mod header;
pub mod journal;
pub mod lines;
mod lock;
mod note;
pub mod pipeline;

pub use error::{Error, Result, going_on};
pub use finished::Finished;
pub use header::{Form, Header};
pub use journal::Journal;
pub use lock::Lock;
pub use note::{Note, PointOutcome};
pub use pipeline::Pipeline;
