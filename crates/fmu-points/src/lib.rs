//! Points of any FMU in isolated processes.

mod batch;
mod birth;
mod child;
pub mod company;
pub mod conduct;
pub mod crew;
pub mod failure;
mod ground;
pub mod indexes;
mod isolated;
mod join;
mod local;
pub mod names;
pub mod notices;
pub mod points;
mod policy;
pub mod pool;
pub mod process;
pub mod repeats;
mod runner;
pub mod scratch;
pub mod single;
pub mod stop;
pub mod system;
pub mod task;
pub mod tell;
mod wire;
pub mod worker;
pub mod working_directory;

use std::ffi::OsString;

pub use company::Company;
pub use conduct::{Conduct, Isolation, Separation};
pub use indexes::Indexes;
pub use points::{Answer, Event, Job, Post, RunError, Simulated, Worker};
pub use pool::run;

/// Makes this process a worker, or a worker's child, where a supervisor has started it as such, and does not return then.
/// A program that runs points in processes calls this first in `main`: its workers are the same program once more.
pub fn serve_if_worker() {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let mut arguments = arguments.iter().filter_map(|argument| argument.to_str());
    match arguments.next() {
        Some(process::WORKER) => worker::end(worker::serve()),
        #[cfg(windows)]
        Some(birth::CHILD) => worker::end(birth::serve(arguments.next().unwrap_or_default())),
        _ => {}
    }
}
