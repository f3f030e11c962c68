//! From measured time series to criteria.

pub mod delay;
pub mod signal;
pub mod smooth;
