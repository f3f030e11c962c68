#![doc = include_str!("../README.md")]

mod fit;
mod indices;
mod kernel;
mod output;
mod process;
mod refine;
mod share;
mod surrogate;

pub use indices::{Index, indices, indices_of_good};
pub use output::{Check, Functions};
pub use refine::most_open;
pub use share::{Answers, Basis, Campaign, Doubt, Limit, Share, doubt};
pub use surrogate::{LEAST, Run, Surrogate, Unfit};
