//! Batch verification of FMI 2.0 Co-Simulation FMUs against measurements when both the
//! parameters and the measurement are uncertain.

pub mod identify;
