//! Batch verification of FMUs of FMI 2.0 and 3.0 against measurements when both the
//! parameters and the measurement are uncertain.

pub mod cli;
pub mod commands;
mod compare;
mod error;
pub mod identify;
mod junit;
pub mod methods;
mod options;
mod packed;
mod plain;
mod recording;
pub mod report;
mod reruns;
pub mod results;
mod session;
pub mod source;
