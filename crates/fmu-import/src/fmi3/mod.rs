//! FMI 3.0: the functions of a binary, and one component of it.

mod element;
mod functions;
mod simulation;
mod values;

pub(crate) use element::Element;
pub(crate) use functions::Functions;
pub(crate) use simulation::Model;
