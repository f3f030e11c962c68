//! The workers of a study: how many, and where they run its points.

use std::{
    collections::BTreeMap,
    ops::ControlFlow,
    path::Path,
    sync::{Arc, atomic::AtomicBool},
};

use crate::{
    conduct::Conduct,
    ground::Ground,
    isolated::{CrewState, Isolated},
    isolation::Isolation,
    launcher::Launcher,
    local::Local,
    points::{Event, Job, PointLimits, PointResult, RunError, Worker},
    pool,
    remote::Remote,
    task::{Case, Task},
    team::Team,
    working_directory,
};
use fmu_import::{FmuError, Library, Package};

/// Where points are run.
#[derive(Clone, Debug)]
pub enum WorkerSite {
    /// In this process.
    Here,
    /// In processes of their own, within limits.
    Processes(PointLimits, Isolation),
    /// The same on other machines.
    Elsewhere(PointLimits, Isolation, Launcher),
}

/// Starts workers for one FMU.
#[derive(Debug)]
pub struct Crew {
    way: WorkerSource,
    size: usize,
    isolation: Isolation,
}

#[derive(Debug)]
enum WorkerSource {
    Here(Arc<Library>),
    Processes {
        common: Arc<CrewState>,
        /// Whether a start value names a file in the working directory, so that points need that directory.
        here: bool,
        limits: PointLimits,
    },
    Elsewhere(Arc<Team>),
}

impl Crew {
    /// A crew for `jobs` points at a time; `scratch` is a folder for its files.
    ///
    /// # Errors
    /// When the FMU cannot be unpacked or loaded.
    pub fn new(package: &mut Package, place: WorkerSite, scratch: &Path, jobs: usize) -> Result<Self, FmuError> {
        let capabilities = package.description().capabilities;
        let (tool, company) = (capabilities.needs_execution_tool, jobs > 1);
        let once = capabilities.can_be_instantiated_only_once_per_process;
        let (way, size, isolation) = match place {
            WorkerSite::Here => {
                let size = if once { 1 } else { jobs };
                (WorkerSource::Here(package.load()?), size, Isolation::None)
            }
            WorkerSite::Elsewhere(limits, isolation, launcher) => {
                let size = launcher.slots();
                (WorkerSource::Elsewhere(Arc::new(Team::new(package, launcher, limits, isolation)?)), size, isolation)
            }
            WorkerSite::Processes(limits, isolation) => {
                let unpacked = package.unpack(scratch)?;
                let ground = Ground::new(unpacked, package.path(), scratch);
                let way = WorkerSource::Processes {
                    common: Arc::new(CrewState::new(ground, isolation == Isolation::Shared, tool, company)),
                    here: working_directory::named_by(package.description()),
                    limits,
                };
                (way, jobs, isolation)
            }
        };
        Ok(Self { way, size, isolation })
    }

    /// Runs points of a task; an answer for each, in their order.
    ///
    /// # Errors
    /// When the FMU cannot be loaded, and when no worker can be started.
    ///
    /// # Panics
    /// When a point has not as many values as the task has varied variables.
    pub fn answers(&self, task: &Task, points: &[Vec<f64>]) -> Result<Vec<PointResult>, RunError> {
        let mut answers = vec![None; points.len()];
        let job = |index: u64| Job { index, values: points[index as usize].clone() };
        let mut workers = self.workers(&[Case::only(task.clone())]);
        pool::run(&mut workers, 0..points.len() as u64, &job, &AtomicBool::new(false), |event| {
            if let Event::Answer(index, answer) = event {
                answers[index as usize] = Some(answer.map(|simulated| simulated.values));
            }
            Ok::<_, RunError>(ControlFlow::Continue(()))
        })?;
        Ok(answers.into_iter().map(|answer| answer.expect("a run that was not stopped has answered all")).collect())
    }

    /// How many points it runs at a time.
    pub fn size(&self) -> usize {
        self.size
    }

    /// How its points are computed, as far as that is known without running any again.
    pub fn conduct(&self) -> Conduct {
        let changed_file = match &self.way {
            WorkerSource::Here(_) => None,
            WorkerSource::Processes { common, .. } => common.ground.changed(),
            WorkerSource::Elsewhere(team) => team.changed(),
        };
        Conduct { isolation: self.isolation, changed_file, ..Conduct::default() }
    }

    /// Gives each point an unpacked FMU of its own from the beginning, since it was found that the FMU changes this file.
    pub fn part(&self, changed: &str) {
        match &self.way {
            WorkerSource::Here(_) => {}
            WorkerSource::Processes { common, .. } => common.ground.know(changed),
            WorkerSource::Elsewhere(team) => team.know(changed),
        }
    }

    /// How many points each host has answered, where there are several.
    pub fn answered(&self) -> BTreeMap<String, u64> {
        match &self.way {
            WorkerSource::Elsewhere(team) => team.answered(),
            _ => BTreeMap::new(),
        }
    }

    /// The host that answered a point last, where there are several; it is asked for once.
    pub fn take_host(&self, index: u64) -> Option<String> {
        match &self.way {
            WorkerSource::Elsewhere(team) => team.take_host(index),
            _ => None,
        }
    }

    /// A worker that runs points again, to compare them with what is recorded: in new processes whose unwritten memory holds
    /// other bytes, from another path, and not on the host `but` where there is another one. None where points run in this
    /// process.
    pub fn again(&self, cases: &[Case], but: Option<&str>) -> Option<Box<dyn Worker>> {
        match &self.way {
            WorkerSource::Here(_) => None,
            WorkerSource::Elsewhere(team) => Some(Box::new(Remote::again(team, cases, but))),
            WorkerSource::Processes { .. } => Some(self.isolated(cases, true)),
        }
    }

    /// One worker.
    pub fn worker(&self, cases: &[Case]) -> Box<dyn Worker> {
        match &self.way {
            WorkerSource::Here(library) => Box::new(Local::new(library, cases)),
            WorkerSource::Elsewhere(team) => Box::new(Remote::new(team, None, cases)),
            WorkerSource::Processes { .. } => self.isolated(cases, false),
        }
    }

    fn isolated(&self, cases: &[Case], again: bool) -> Box<dyn Worker> {
        let WorkerSource::Processes { common, here, limits } = &self.way else {
            unreachable!("only asked where points run in processes here");
        };
        let here = *here || cases.iter().any(|case| working_directory::is_named_in(&case.task));
        Box::new(Isolated::new(common, here, cases, *limits, again))
    }

    /// All workers.
    pub fn workers(&self, cases: &[Case]) -> Vec<Box<dyn Worker>> {
        (0..self.size)
            .map(|number| match &self.way {
                WorkerSource::Elsewhere(team) => Box::new(Remote::new(team, Some(number), cases)),
                _ => self.worker(cases),
            })
            .collect()
    }
}
