//! The workers of a study: how many, and where they run its points.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use crate::company::Company;
use crate::conduct::{Conduct, Isolation, Separation};
use crate::ground::Ground;
use crate::isolated::Isolated;
use crate::launcher::Launcher;
use crate::local::Local;
use crate::locked::locked;
use crate::points::{Answer, Event, Job, Limits, RunError, Worker};
use crate::policy::{Found, Policy};
use crate::pool;
use crate::remote::{Remote, Team};
use crate::repeats::Repeats;
use crate::task::{Case, Task};
use crate::working_directory;
use fmu_import::{FmuError, Library, Package};

/// Where points are run.
#[derive(Clone, Debug)]
pub enum Place {
    /// In this process.
    Here,
    /// In processes of their own, within limits.
    Processes(Limits, Isolation),
    /// The same on other machines.
    Elsewhere(Limits, Isolation, Launcher),
}

/// Starts workers for one FMU.
#[derive(Debug)]
pub struct Crew {
    way: Way,
    size: usize,
    policy: Arc<Mutex<Policy>>,
    /// For points with a folder of their own.
    apart: Arc<Mutex<Policy>>,
}

#[derive(Debug)]
enum Way {
    Here(Arc<Library>),
    Processes {
        ground: Arc<Ground>,
        /// Whether a start value names a file in the working directory, so that points need that directory.
        here: bool,
        limits: Limits,
    },
    Elsewhere(Arc<Team>),
}

impl Crew {
    /// A crew for `jobs` points at a time; `scratch` is a folder for its files.
    ///
    /// # Errors
    /// When the FMU cannot be unpacked or loaded.
    pub fn new(package: &mut Package, place: Place, scratch: &Path, jobs: usize) -> Result<Self, FmuError> {
        let capabilities = package.description().capabilities;
        let (tool, company) = (capabilities.needs_execution_tool, jobs > 1);
        let policies = |wish| {
            let policy = Arc::new(Mutex::new(Policy::new(wish, tool, company)));
            [policy, Arc::new(Mutex::new(Policy::apart(tool, company)))]
        };
        let once = capabilities.can_be_instantiated_only_once_per_process;
        let (way, size, [policy, apart]) = match place {
            Place::Here => {
                let size = if once { 1 } else { jobs };
                (Way::Here(package.load()?), size, policies(Isolation::InProcess))
            }
            Place::Elsewhere(limits, wish, launcher) => {
                let (size, policies) = (launcher.slots(), policies(wish));
                let team = Team::new(package, launcher, limits, wish, policies.clone())?;
                (Way::Elsewhere(Arc::new(team)), size, policies)
            }
            Place::Processes(limits, wish) => {
                let unpacked = package.unpack(scratch)?;
                let way = Way::Processes {
                    ground: Arc::new(Ground::new(unpacked, package.path(), scratch)),
                    here: working_directory::named_by(package.description()),
                    limits,
                };
                (way, jobs, policies(wish))
            }
        };
        Ok(Self { way, size, policy, apart })
    }

    /// Runs points of a task; an answer for each, in their order. Some of them are computed twice, as an audit.
    ///
    /// # Errors
    /// When the FMU cannot be loaded, and when no worker can be started.
    ///
    /// # Panics
    /// When a point has not as many values as the task has varied variables.
    pub fn answers(&self, task: &Task, points: &[Vec<f64>]) -> Result<Vec<Answer>, RunError> {
        let all = 0..points.len() as u64;
        self.repeat(&Repeats::among(0, all.end, all.clone()));
        let mut answers = vec![None; points.len()];
        let job = |index: u64| Job { index, values: points[index as usize].clone() };
        pool::run(
            &mut self.workers(&[Case::only(task.clone())]),
            all,
            &job,
            &|_| Vec::new(),
            &mut Company::default(),
            &AtomicBool::new(false),
            |event| {
                if let Event::Answer(index, answer, _) = event {
                    answers[index as usize] = Some(answer.map(|simulated| simulated.values));
                }
                Ok::<_, RunError>(ControlFlow::Continue(()))
            },
        )?;
        let all = answers.into_iter().map(|answer| answer.expect("a run that was not stopped has answered all"));
        Ok(all.collect())
    }

    /// How many points it runs at a time.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The change that the FMU has made in its folder, if any.
    fn changed(&self) -> Option<String> {
        match &self.way {
            Way::Here(_) => None,
            Way::Processes { ground, .. } => ground.changed(),
            Way::Elsewhere(team) => team.changed(),
        }
    }

    /// How its points were computed so far.
    pub fn conduct(&self) -> Conduct {
        match self.changed() {
            // Nothing that was computed before counts.
            Some(changed) => Conduct { changed_file: Some(changed), ..locked(&self.apart).conduct() },
            None => locked(&self.policy).conduct(),
        }
    }

    /// Gives each point an unpacked FMU of its own from the beginning, since it was found that the FMU changes this file.
    pub fn part(&self, changed: &str) {
        match &self.way {
            Way::Here(_) => {}
            Way::Processes { ground, .. } => ground.know(changed),
            Way::Elsewhere(team) => team.know(changed),
        }
    }

    /// Begins with what an earlier part of the run found: which processes change results, and whether new ones agree.
    pub fn recall(&self, refuted: Option<Separation>, reproducible: bool) {
        // Whoever wants used processes gets them.
        if self.wish() == Isolation::Reuse {
            return;
        }
        if let Some(separation) = refuted {
            locked(&self.policy).refute(separation);
        }
        if !reproducible {
            locked(&self.policy).give_up_reproducing();
            locked(&self.apart).give_up_reproducing();
        }
    }

    /// How many points each host has answered, where there are several.
    pub fn answered(&self) -> BTreeMap<String, u64> {
        match &self.way {
            Way::Elsewhere(team) => team.answered(),
            _ => BTreeMap::new(),
        }
    }

    /// What a supervisor elsewhere should know of the FMU.
    pub(crate) fn found(&self) -> Found {
        let changed = self.changed();
        let policy = if changed.is_some() { &self.apart } else { &self.policy };
        let mut found = locked(policy).found();
        found.changed = changed;
        found
    }

    /// Takes over what a supervisor elsewhere knows of the FMU.
    pub(crate) fn adopt(&self, found: &Found) {
        if let Some(changed) = &found.changed {
            self.part(changed);
        }
        Policy::adopt_in([&self.policy, &self.apart], found);
    }

    /// How the user wishes points to share processes.
    pub fn wish(&self) -> Isolation {
        locked(&self.policy).wish
    }

    /// Chooses the points that are computed twice in any case.
    pub fn repeat(&self, repeats: &Repeats) {
        locked(&self.policy).repeat(repeats);
        locked(&self.apart).repeat(repeats);
    }

    /// Notes the audit of a point that an earlier part of the run computed in a used process.
    pub fn note_audit(&self, index: u64, agreed: bool) {
        let mut policy = locked(&self.policy);
        policy.audited(index, agreed, true);
        if !agreed {
            policy.refute(Separation::Used);
        }
    }

    /// A worker that computes points again as an audit does.
    pub fn auditor(&self, cases: &[Case]) -> Box<dyn Worker> {
        if let Way::Elsewhere(team) = &self.way {
            return Box::new(Remote::new(team, None, cases, true));
        }
        self.worker_by(Arc::new(Mutex::new(Policy::auditing())), cases)
    }

    /// One worker.
    pub fn worker(&self, cases: &[Case]) -> Box<dyn Worker> {
        self.worker_by(Arc::clone(&self.policy), cases)
    }

    fn worker_by(&self, policy: Arc<Mutex<Policy>>, cases: &[Case]) -> Box<dyn Worker> {
        match &self.way {
            Way::Here(library) => Box::new(Local::new(library, cases)),
            Way::Elsewhere(team) => Box::new(Remote::new(team, None, cases, false)),
            Way::Processes { ground, here, limits } => {
                let named = |case: &Case| working_directory::named_in(&case.task);
                let here = *here || cases.iter().any(named);
                Box::new(Isolated::new(
                    [policy, Arc::clone(&self.apart)],
                    Arc::clone(ground),
                    (!here).then_some(&*ground.scratch),
                    cases,
                    *limits,
                ))
            }
        }
    }

    /// All workers.
    pub fn workers(&self, cases: &[Case]) -> Vec<Box<dyn Worker>> {
        let worker = |number| match &self.way {
            Way::Elsewhere(team) => Box::new(Remote::new(team, Some(number), cases, false)),
            _ => self.worker(cases),
        };
        (0..self.size).map(worker).collect()
    }
}
