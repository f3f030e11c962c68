//! The workers of a study: how many, and where they run its points.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};

use crate::company::Company;
use crate::conduct::{Conduct, Isolation, Separation};
use crate::ground::Ground;
use crate::isolated::{Isolated, locked};
use crate::local::Local;
use crate::points::{Answer, Event, Job, Limits, RunError, Worker};
use crate::policy::Policy;
use crate::pool;
use crate::repeats::Repeats;
use crate::task::{Case, Task};
use crate::working_directory;
use fmu_import::{FmuError, Library, Package};

/// Where points are run.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// In this process.
    Here,
    /// In processes of their own, within limits.
    Processes(Limits, Isolation),
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
        let (tool, company) = (capabilities.needs_execution_tool, jobs > 1);
        let once = capabilities.can_be_instantiated_only_once_per_process;
        let (way, size, wish) = match place {
            Place::Here => {
                let size = if once { 1 } else { jobs };
                (Way::Here(package.load()?), size, Isolation::InProcess)
            }
            Place::Processes(limits, wish) => {
                let unpacked = package.unpack(scratch)?;
                let way = Way::Processes {
                    ground: Arc::new(Ground::new(unpacked, package.path(), scratch)),
                    here: working_directory::named_by(package.description()),
                    limits,
                };
                (way, jobs, wish)
            }
        };
        Ok(Self {
            way,
            size,
            policy: Arc::new(Mutex::new(Policy::new(wish, tool, company))),
            apart: Arc::new(Mutex::new(Policy::apart(tool, company))),
        })
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
        let job = |index: u64| Job {
            index,
            values: points[index as usize].clone(),
        };
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
        let all = answers
            .into_iter()
            .map(|answer| answer.expect("a run that was not stopped has answered all"));
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
        }
    }

    /// How its points were computed so far.
    pub fn conduct(&self) -> Conduct {
        match self.changed() {
            // Nothing that was computed before counts.
            Some(changed) => Conduct {
                changed_file: Some(changed),
                ..locked(&self.apart).conduct()
            },
            None => locked(&self.policy).conduct(),
        }
    }

    /// Gives each point an unpacked FMU of its own from the beginning, since it was found that the FMU changes this file.
    pub fn part(&self, changed: &str) {
        if let Way::Processes { ground, .. } = &self.way {
            ground.know(changed);
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
        self.worker_by(Arc::new(Mutex::new(Policy::auditing())), cases)
    }

    /// One worker.
    pub fn worker(&self, cases: &[Case]) -> Box<dyn Worker> {
        self.worker_by(Arc::clone(&self.policy), cases)
    }

    fn worker_by(&self, policy: Arc<Mutex<Policy>>, cases: &[Case]) -> Box<dyn Worker> {
        match &self.way {
            Way::Here(library) => Box::new(Local::new(library, cases)),
            Way::Processes {
                ground,
                here,
                limits,
            } => {
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
        (0..self.size).map(|_| self.worker(cases)).collect()
    }
}
