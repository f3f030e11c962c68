#![doc = include_str!("../README.md")]

pub mod capped;
mod errors;
mod expected;
pub mod failures;
pub mod fit;
pub mod influence;
pub mod local;
pub mod numerical;
pub mod objective;
pub mod optima;
#[cfg(test)]
mod optima_tests;
mod order;
pub mod outcome;
mod posterior;
pub mod problem;
#[cfg(test)]
mod recovery_tests;
pub mod remembered;
pub mod rounds;
pub mod sample;
pub mod search;
mod shared;
#[cfg(test)]
mod shared_tests;
mod stated;
#[cfg(test)]
mod stated_tests;
pub mod surrogate;
pub mod suspects;
#[cfg(test)]
mod testing;
pub mod text;
