//! Runs points in this process: the fastest way, for an FMU that is trusted.

use std::sync::Arc;

use crate::conduct::Separation;
use crate::failure::Failure;
use crate::join::{Part, joined, parts};
use crate::points::{Event, Job, Post, RunError, Simulated, Worker};
use crate::runner::Runner;
use crate::task::Case;
use crate::wire::{Origin, Trouble};
use fmu_import::Library;

/// Runs points on an instance of its own.
#[derive(Debug)]
pub struct Local {
    /// None where there is no case.
    runner: Option<Runner>,
    cases: Vec<Part>,
}

impl Local {
    /// A worker with an instance of its own.
    pub fn new(library: &Arc<Library>, cases: &[Case]) -> Self {
        let mut tasks = cases.iter().map(|case| case.task.clone());
        let first = tasks.next();
        let runner = first.map(|task| Runner::new(Arc::clone(library), task).with_further(tasks));
        Self {
            runner,
            cases: parts(cases),
        }
    }

    /// A point in one case.
    fn run_case(runner: &mut Runner, values: &[f64]) -> Result<Simulated, Failure> {
        let answer = runner.run(values).map(<[f64]>::to_vec);
        answer.map(|values| Simulated::new(&values, runner.notices()))
    }

    /// A point in all its cases.
    fn run_cases(
        runner: &mut Runner,
        cases: &[Part],
        values: &[f64],
    ) -> Result<Simulated, Failure> {
        let runs = (0..cases.len()).map(|case| {
            runner.turn_to(case);
            let failed = |failure| Trouble::new(Origin::Fmu, failure);
            Self::run_case(runner, values).map_err(failed)
        });
        let runs: Vec<_> = runs.collect();
        joined(cases, runs).map_err(|trouble| trouble.failure)
    }
}

impl Worker for Local {
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
        let Some(runner) = &mut self.runner else {
            return Ok(());
        };
        for job in jobs {
            let answer = match &self.cases[..] {
                [_] => Self::run_case(runner, &job.values),
                cases => Self::run_cases(runner, cases, &job.values),
            };
            post.send(Event::Answer(job.index, answer, Separation::Used));
            if post.is_over() {
                break;
            }
        }
        Ok(())
    }
}
