//! The bearing: film, asperity contact and friction of the journal in its bush.

pub mod mobility;
pub mod reynolds;
