//! Runs points in this process: the fastest way, for an FMU that is trusted.

use std::sync::Arc;

use super::{EngineError, Event, Job, Post, Separation, Simulated, Worker};
use crate::run::Runner;
use crate::task::Task;
use fmu_import::Library;

/// Runs points on an instance of its own.
#[derive(Debug)]
pub struct Local {
    runner: Runner,
}

impl Local {
    /// A worker with an instance of its own.
    pub fn new(library: &Arc<Library>, task: &Task) -> Self {
        Self {
            runner: Runner::new(Arc::clone(library), task.clone()),
        }
    }
}

impl Worker for Local {
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), EngineError> {
        for job in jobs {
            let answer = self.runner.run(&job.values).map(<[f64]>::to_vec);
            let answer = answer.map(|values| Simulated::new(&values, self.runner.notices()));
            post.send(Event::Answer(job.index, answer, Separation::Used));
            if post.is_over() {
                break;
            }
        }
        Ok(())
    }
}
