//! The shipped studies and their calibrations.

mod calibration;
mod identify;
