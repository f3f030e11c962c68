//! The FMI 2.0 boundary, Co-Simulation and Model Exchange, generic over any [`Model`](crate::model::Model).
//!
//! From the outside in:
//! - [`exports`]: the C functions, defined for one model by [`export!`](crate::export);
//! - [`calls`]: the same functions, generic over the model. Raw pointers end here;
//! - `functions`: which of them may be called when;
//! - [`description`]: the model description, written from the variable table.
//!
//! Everything else is the same for all versions of the standard: see `boundary`.

pub mod calls;
pub mod description;
pub mod exports;
pub mod types;

mod functions;
