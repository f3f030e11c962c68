//! An FMU as the model that identification asks for predictions.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use super::bind::Bound;
use super::problem::Simulate;
use crate::engine::crew::Crew;
use crate::engine::{Answer, EngineError, Event, Job, Post, Worker};

/// An FMU with its cases; it keeps as many workers as simulations run at a time.
pub struct FmuModel<'a> {
    bound: &'a Bound,
    crew: &'a Crew,
    idle: Mutex<Vec<Box<dyn Worker>>>,
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
        }
    }

    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Box<dyn Worker>>> {
        // A list of idle workers is sound whatever interrupted its last user.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, values: Vec<f64>) -> Result<Answer, String> {
        let idle = self.idle().pop();
        let mut worker = idle.unwrap_or_else(|| self.crew.worker(&self.bound.task));
        let (mut answer, mut void) = (None, false);
        let mut take = |event| {
            match event {
                Event::Answer(_, own, _) => answer = Some(own),
                Event::Void(_) => void = true,
                Event::Idle => {}
            }
            ControlFlow::Continue(())
        };
        let mut post = Post::new(&mut take, &|| false, None);
        let run = worker.run(&[Job { index: 0, values }], &mut post);
        run.map_err(|error| error.to_string())?;
        if void {
            // The command looks at this before it believes anything, and begins again.
            return Err(EngineError::Refuted.to_string());
        }
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
