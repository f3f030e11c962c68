#![doc = include_str!("../README.md")]

mod arithmetic;
mod fit;
mod indices;
mod kernel;
mod output;
mod process;
mod rare;
mod refine;
mod share;
mod surrogate;

pub use indices::{Design, Explained, Index, indices, measures};
pub use output::{Check, Functions};
pub use rare::{Answer, Search, Unknown};
pub use refine::most_open;
pub use share::{Answers, Basis, Campaign, Doubt, Event, Limit, Share, doubt};
pub use surrogate::{LEAST, Run, Surrogate, Unfit};
