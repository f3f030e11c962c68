#![doc = include_str!("../README.md")]

pub mod conclusion;
pub mod decision;
pub mod interval;
mod joint;
pub mod looks;
pub mod measured;
pub mod normal;
pub mod risk;
mod sequence;
pub mod uncertainty;
pub mod validation;

mod genz;
mod lattice;
mod one_factor;
mod tabulated;
