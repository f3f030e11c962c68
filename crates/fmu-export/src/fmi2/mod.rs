//! The FMI 2.0 boundary, Co-Simulation and Model Exchange, generic over any [`Model`](crate::model::Model).
//!
//! From the outside in, [`calls`]: the C functions, generic over the model, and which of them may be called when. Raw pointers
//! end here, and [`export!`](crate::export) defines them for one model.
//!
//! Everything else is the same for all versions of the standard: see `boundary`.

pub mod calls;
pub mod types;
