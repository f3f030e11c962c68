//! FMI 3.0: the functions of a binary, and one component of it.

mod element;
mod functions;
mod simulation;
mod values;

pub use element::Element;
pub use functions::Functions;
pub use simulation::Model;
