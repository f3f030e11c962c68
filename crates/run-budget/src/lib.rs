#![doc = include_str!("../README.md")]

mod fit;
mod indices;
mod kernel;
mod output;
mod process;
mod share;
mod surrogate;

pub use indices::{Index, indices};
pub use output::{Check, Functions};
pub use share::{Basis, Campaign, Doubt, Limit, Share, doubt, share, undecided};
pub use surrogate::{Run, Surrogate, Unfit};
