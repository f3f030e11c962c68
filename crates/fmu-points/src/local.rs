//! Runs points in this process: the fastest way, for an FMU that is trusted.

use std::sync::Arc;

use crate::{
    join::{CasePart, joined, parts},
    points::{Event, Job, Post, RunError, Simulated, Worker},
    runner::Runner,
    task::Case,
    wire::{Origin, Trouble},
};
use fmu_import::Library;

/// Runs points on an instance of its own.
#[derive(Debug)]
pub struct Local {
    /// None where there is no case.
    runner: Option<Box<Runner>>,
    cases: Vec<CasePart>,
}

impl Local {
    /// A worker with an instance of its own.
    pub fn new(library: &Arc<Library>, cases: &[Case]) -> Self {
        Self { runner: Runner::new(Arc::clone(library), cases), cases: parts(cases) }
    }
}

impl Worker for Local {
    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        let Some(runner) = &mut self.runner else { return Ok(()) };
        for job in jobs {
            let runs = (0..self.cases.len()).map(|case| {
                runner.turn_to(case);
                runner
                    .run(&job.values)
                    .map(<[f64]>::to_vec)
                    .map(|values| Simulated::new(values, &runner.notices))
                    .map_err(|failure| Trouble::new(Origin::Fmu, failure))
            });
            let answer = joined(&self.cases, runs.collect()).map_err(|trouble| trouble.failure);
            post.send(Event::Answer(job.index, answer));
            if post.is_over() {
                break;
            }
        }
        Ok(())
    }
}
