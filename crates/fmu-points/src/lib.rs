//! Points of any FMU in isolated processes. A point is a simulation with values of its own for some parameters; its answer
//! is a few numbers, or why there are none.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! use fmu_import::Package;
//! use fmu_points::task::{Probe, Schedule, Slot, Statistic, Task};
//! use fmu_points::{Crew, Isolation, PointLimits, WorkerSite, stop};
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     // The processes in which the FMU runs are this program once more.
//!     fmu_points::serve_if_worker();
//!     let mut package = Package::open("pendulum.fmu".as_ref())?;
//!     let fmu = package.description();
//!     let task = Task {
//!         varied: Slot::of(&fmu.variables["length"]).into_iter().collect(),
//!         observed: Probe::of(&fmu.variables["angle"], Statistic::Max).into_iter().collect(),
//!         ..Task::new(Schedule::suggested(fmu))
//!     };
//!     let limits = PointLimits { time: Duration::from_secs(60), memory: 1 << 30 };
//!     let place = WorkerSite::Processes(limits, Isolation::Fresh);
//!     let folder = stop::scratch()?;
//!     let crew = Crew::new(&mut package, place, folder.path(), 4)?;
//!     for answer in crew.answers(&task, &[vec![0.5], vec![1.0]])? {
//!         match answer {
//!             Ok(values) => println!("{values:?}"),
//!             Err(failure) => println!("{failure}"),
//!         }
//!     }
//!     Ok(())
//! }
//! ```
//!
//! # Processes
//!
//! The *supervisor* is the program that asks for points. Each of its [workers](Worker) is a process of the same program,
//! which loads the FMU and never instantiates it. A worker's *children* run the FMU. Whether a child has
//! run other points before is a matter of the [`Isolation`] that the user wants.
//!
//! A simulation is plain data, which the processes send each other:
//!
//! ```
//! use fmu_points::task::Schedule;
//!
//! let (start, stop, step) = (0.0, 1.0, 0.3);
//! let schedule = Schedule { start, stop, step, window_start: start, leap: false, tolerance: None };
//! assert_eq!(schedule.check(), Ok(()));
//! // The last step is shorter.
//! assert_eq!((schedule.steps(), schedule.points().at(4)), (4, 1.0));
//! ```

mod as_json;
mod batch;
mod birth;
mod child;
mod conduct;
pub mod crew;
mod dispatch;
pub mod failure;
mod ground;
mod isolated;
mod isolation;
mod join;
mod launcher;
mod licences;
mod link;
mod local;
pub mod names;
pub mod notices;
mod points;
mod pool;
mod process;
mod quiet;
mod remote;
mod room;
mod runner;
pub mod scratch;
pub mod single;
mod station;
pub mod stop;
pub mod system;
pub mod task;
mod team;
pub mod tell;
mod wire;
mod worker;
pub mod working_directory;

use std::ffi::OsString;

pub use conduct::Conduct;
pub use crew::{Crew, WorkerSite};
pub use isolation::Isolation;
pub use launcher::Launcher;
pub use points::{Event, Job, PointLimits, PointResult, Post, RunError, Simulated, Worker};
pub use pool::run;

/// Makes this process a worker, or a worker's child, where a supervisor has started it as such, and does not return then.
/// A program that runs points in processes calls this first in `main`: its workers are the same program once more.
pub fn serve_if_worker() {
    serve_if_worker_with(|_, _, _| {});
}

/// The same for a program that runs [errands](single::Recorder::send) in processes.
pub fn serve_if_worker_with(errand: single::Errand) {
    single::ERRAND.get_or_init(|| errand);
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let mut arguments = arguments.iter().filter_map(|argument| argument.to_str());
    match arguments.next() {
        Some(process::WORKER) => worker::end(worker::serve()),
        Some(link::REMOTE) => worker::end(station::serve()),
        #[cfg(windows)]
        Some(birth::CHILD) => worker::end(birth::serve()),
        _ => {}
    }
}
