#![doc = include_str!("../README.md")]

pub mod pareto;
pub mod robustness;
pub mod table;
pub mod tolerances;
