//! Batch verification of FMUs of FMI 2.0 and 3.0 against measurements when both the
//! parameters and the measurement are uncertain.

pub mod cli;
pub mod commands;
pub mod compare;
pub mod error;
pub mod identify;
pub mod junit;
pub mod methods;
pub mod options;
pub mod packed;
pub(crate) mod plain;
pub mod recording;
pub mod report;
pub mod reruns;
pub mod results;
pub mod session;
pub mod source;
