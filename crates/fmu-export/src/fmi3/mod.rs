//! The FMI 3.0 boundary, Co-Simulation and Model Exchange, generic over any [`Model`](crate::model::Model).
//!
//! From the outside in, [`calls`]: the C functions, generic over the model, and which of them may be called when. Raw pointers
//! end here, and [`export!`](crate::export) defines them for one model.
//!
//! Value references are those of FMI 2.0. Reals are `Float64`, integers `Int32`; an [array](crate::model::Variable::array) has one
//! dimension of constant size. A host may look into the steps of a model with [inner steps](crate::model::Model::INNER_STEP), and
//! use the event mode of Co-Simulation with one that has [events](crate::model::Model::EVENTS), which may let output clocks tick.
//! Everything else is the same for all versions: see `boundary`.

pub mod calls;
pub mod types;
