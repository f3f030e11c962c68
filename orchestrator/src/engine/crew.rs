//! The workers of a task: how many, and where they run its points.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::local::Local;
use super::process::{Limits, Process};
use super::{EngineError, Worker};
use crate::task::Task;
use fmu_import::{FmuError, Library, Package};

/// Where points are run.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// In this process.
    Here,
    /// In worker processes, within limits.
    Workers(Limits),
}

/// Starts workers for one FMU.
#[derive(Debug)]
pub struct Crew {
    way: Way,
    size: usize,
}

#[derive(Debug)]
enum Way {
    Here(Arc<Library>),
    Processes {
        fmu: PathBuf,
        limits: Limits,
        scratch: PathBuf,
    },
}

impl Crew {
    /// A crew for `jobs` points at a time; `scratch` is a folder for its files.
    ///
    /// # Errors
    /// When the FMU cannot be unpacked or loaded.
    pub fn new(
        package: &mut Package,
        place: Place,
        scratch: &Path,
        jobs: usize,
    ) -> Result<Self, FmuError> {
        let capabilities = package.description().capabilities;
        let once = capabilities.can_be_instantiated_only_once_per_process;
        Ok(match place {
            Place::Here => Self {
                way: Way::Here(package.load()?),
                size: if once { 1 } else { jobs },
            },
            Place::Workers(limits) => Self {
                way: Way::Processes {
                    fmu: package.unpack(scratch)?,
                    limits,
                    scratch: scratch.to_owned(),
                },
                size: jobs,
            },
        })
    }

    /// How many points it runs at a time.
    pub fn size(&self) -> usize {
        self.size
    }

    /// One worker; `number` is unlike those of the others.
    ///
    /// # Errors
    /// When the system says no.
    pub fn worker(&self, task: &Task, number: usize) -> Result<Box<dyn Worker>, EngineError> {
        Ok(match &self.way {
            Way::Here(library) => Box::new(Local::new(library, task)),
            Way::Processes {
                fmu,
                limits,
                scratch,
            } => Box::new(Process::new(fmu, task, *limits, scratch, number)?),
        })
    }

    /// All workers.
    ///
    /// # Errors
    /// When the system says no.
    pub fn workers(&self, task: &Task) -> Result<Vec<Box<dyn Worker>>, EngineError> {
        (0..self.size)
            .map(|number| self.worker(task, number))
            .collect()
    }
}
