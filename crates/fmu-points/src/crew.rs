//! The workers of a study: how many, and where they run its points.

use std::path::Path;
use std::sync::Arc;

use crate::conduct::{Conduct, Isolation, Separation};
use crate::ground::Ground;
use crate::isolated::Isolated;
use crate::local::Local;
use crate::points::Worker;
use crate::policy::Policy;
use crate::process::Limits;
use crate::repeats::Repeats;
use crate::task::Case;
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
    policy: Arc<Policy>,
}

#[derive(Debug)]
enum Way {
    Here(Arc<Library>),
    Processes {
        ground: Arc<Ground>,
        /// For points with a folder of their own.
        apart: Arc<Policy>,
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
        let tool = capabilities.needs_execution_tool;
        Ok(match place {
            Place::Here => {
                let once = capabilities.can_be_instantiated_only_once_per_process;
                let size = if once { 1 } else { jobs };
                Self {
                    way: Way::Here(package.load()?),
                    size,
                    policy: Arc::new(Policy::new(Isolation::InProcess, tool)),
                }
            }
            Place::Processes(limits, isolation) => Self {
                way: Way::Processes {
                    ground: Arc::new(Ground::new(
                        package.unpack(scratch)?,
                        package.path(),
                        scratch,
                    )),
                    apart: Arc::new(Policy::apart(tool).in_company(jobs > 1)),
                    here: working_directory::named_by(package.description()),
                    limits,
                },
                size: jobs,
                policy: Arc::new(Policy::new(isolation, tool).in_company(jobs > 1)),
            },
        })
    }

    /// How many points it runs at a time.
    pub fn size(&self) -> usize {
        self.size
    }

    /// How its points were computed so far.
    pub fn conduct(&self) -> Conduct {
        if let Way::Processes { ground, apart, .. } = &self.way
            && let Some(changed) = ground.changed()
        {
            // Nothing that was computed before counts.
            return Conduct {
                changed_file: Some(changed),
                ..apart.conduct()
            };
        }
        self.policy.conduct()
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
            self.policy.refute(separation);
        }
        if !reproducible {
            self.policy.give_up_reproducing();
            if let Way::Processes { apart, .. } = &self.way {
                apart.give_up_reproducing();
            }
        }
    }

    /// How the user wishes points to share processes.
    pub fn wish(&self) -> Isolation {
        self.policy.wish()
    }

    /// Chooses the points that are computed twice in any case.
    pub fn repeat(&self, repeats: &Repeats) {
        self.policy.repeat(repeats);
        if let Way::Processes { apart, .. } = &self.way {
            apart.repeat(repeats);
        }
    }

    /// Notes the audit of a point that an earlier part of the run computed in a used process.
    pub fn note_audit(&self, index: u64, agreed: bool) {
        self.policy.audited(index, agreed, Separation::Used);
        if !agreed {
            self.policy.refute(Separation::Used);
        }
    }

    /// A worker that computes points again as an audit does.
    pub fn auditor(&self, cases: &[Case]) -> Box<dyn Worker> {
        match &self.way {
            Way::Here(_) => self.worker(cases),
            Way::Processes { apart, .. } => {
                let alone = Arc::new(Policy::auditing());
                self.isolated(alone, apart, cases)
            }
        }
    }

    /// One worker.
    pub fn worker(&self, cases: &[Case]) -> Box<dyn Worker> {
        match &self.way {
            Way::Here(library) => Box::new(Local::new(library, cases)),
            Way::Processes { apart, .. } => self.isolated(Arc::clone(&self.policy), apart, cases),
        }
    }

    fn isolated(
        &self,
        policy: Arc<Policy>,
        apart: &Arc<Policy>,
        cases: &[Case],
    ) -> Box<dyn Worker> {
        match &self.way {
            Way::Here(library) => Box::new(Local::new(library, cases)),
            Way::Processes {
                ground,
                here,
                limits,
                ..
            } => {
                let named = |case: &Case| working_directory::named_in(&case.task);
                let here = *here || cases.iter().any(named);
                let home = (!here).then_some(&*ground.scratch);
                Box::new(Isolated::new(
                    [policy, Arc::clone(apart)],
                    Arc::clone(ground),
                    home,
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
