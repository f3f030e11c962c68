#![doc = include_str!("../README.md")]

mod fit;
mod kernel;
mod output;
mod process;
mod surrogate;

pub use output::{Check, Functions};
pub use surrogate::{Run, Surrogate, Unfit};
