//! FMI 2.0: the functions of a binary, and one component of it.

mod functions;
mod simulation;
mod steps;

pub use functions::Functions;
pub use simulation::Model;
