//! Batch verification of FMI 2.0 Co-Simulation FMUs against measurements when both the
//! parameters and the measurement are uncertain.

/// Writes a line to standard error. Where nobody reads that any more it is lost, and the work goes on; `eprintln!` would
/// panic.
#[macro_export]
macro_rules! tell {
    ($($what:tt)*) => {{
        let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("{}\n", format_args!($($what)*)));
    }};
}

pub mod analysis;
pub mod cli;
pub mod commands;
pub mod engine;
pub mod failure;
pub mod identify;
pub mod judge;
pub mod names;
pub mod notices;
pub mod pipeline;
pub mod report;
pub mod results;
pub mod run;
pub mod session;
pub mod source;
pub mod study;
pub mod table;
pub mod task;
