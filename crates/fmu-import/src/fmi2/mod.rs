//! FMI 2.0: the functions of a binary, and one component of it.

mod functions;
mod simulation;
mod steps;

pub(crate) use functions::Functions;
pub(crate) use simulation::Model;
