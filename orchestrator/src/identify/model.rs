//! An FMU as the model that identification asks for predictions.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use super::bind::Bound;
use super::problem::Simulate;
use crate::engine::crew::Crew;
use crate::engine::{Answer, Job, Worker};

/// An FMU with its cases; it keeps as many workers as simulations run at a time.
pub struct FmuModel<'a> {
    bound: &'a Bound,
    crew: &'a Crew,
    idle: Mutex<Vec<Box<dyn Worker>>>,
    started: AtomicUsize,
}

impl fmt::Debug for FmuModel<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = f.debug_struct("FmuModel");
        text.field("crew", self.crew).finish_non_exhaustive()
    }
}

impl<'a> FmuModel<'a> {
    /// A model of an FMU.
    pub fn new(bound: &'a Bound, crew: &'a Crew) -> Self {
        Self {
            bound,
            crew,
            idle: Mutex::new(Vec::new()),
            started: AtomicUsize::new(0),
        }
    }

    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Box<dyn Worker>>> {
        // A list of idle workers is sound whatever interrupted its last user.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, values: Vec<f64>) -> Result<Answer, String> {
        let idle = self.idle().pop();
        let mut worker = match idle {
            Some(worker) => worker,
            None => {
                let number = self.started.fetch_add(1, Ordering::Relaxed);
                let worker = self.crew.worker(&self.bound.task, number);
                worker.map_err(|error| error.to_string())?
            }
        };
        let mut answer = None;
        let run = worker.run(&[Job { index: 0, values }], &mut |_, own| {
            answer = Some(own);
            ControlFlow::Continue(())
        });
        run.map_err(|error| error.to_string())?;
        self.idle().push(worker);
        answer.ok_or_else(|| "the worker gave no answer".to_owned())
    }
}

impl Simulate for FmuModel<'_> {
    fn simulate(&self, case: usize, free: &[f64], latents: &[f64]) -> Result<Vec<f64>, String> {
        let bound = self.bound;
        let found = free.iter().chain(latents).zip(&bound.inputs);
        let found = found.map(|(&value, conversion)| conversion.value(value));
        let values = bound.known[case].iter().copied().chain(found).collect();
        let results = self.run(values)?.map_err(|failure| failure.to_string())?;
        let predicted = results.iter().zip(&bound.outputs);
        Ok(predicted
            .map(|(&value, conversion)| conversion.value(value))
            .collect())
    }
}
