#![doc = include_str!("../README.md")]

mod arithmetic;
mod campaign;
mod doubt;
mod fit;
mod indices;
mod kernel;
mod limit;
mod output;
mod possible;
mod process;
mod rare;
mod refine;
mod share;
mod surrogate;

pub use campaign::Campaign;
pub use doubt::{Doubt, doubt};
pub use indices::{Design, Explained, Index, indices, measures};
pub use limit::{Event, Limit};
pub use output::{Check, Functions};
pub use rare::{RareAnswer, Search, Unknown};
pub use refine::most_open;
pub use share::{Answers, Basis, Share};
pub use surrogate::{LEAST, Run, Surrogate, Unfit};
