//! An FMU as the model that identification asks for predictions.

use std::sync::{Arc, Mutex, PoisonError};

use super::bind::Bound;
use super::problem::Simulate;
use crate::fmu::Library;
use crate::run::Runner;

/// An FMU with its cases; it keeps as many instances as simulations run at a time.
#[derive(Debug)]
pub struct FmuModel<'a> {
    bound: &'a Bound,
    library: Arc<Library>,
    idle: Mutex<Vec<Runner>>,
}

impl<'a> FmuModel<'a> {
    /// A model of an FMU.
    pub fn new(bound: &'a Bound, library: Arc<Library>) -> Self {
        Self {
            bound,
            library,
            idle: Mutex::new(Vec::new()),
        }
    }

    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Runner>> {
        // A list of idle runners is sound whatever interrupted its last user.
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Simulate for FmuModel<'_> {
    fn simulate(&self, case: usize, free: &[f64], latents: &[f64]) -> Result<Vec<f64>, String> {
        let bound = self.bound;
        let found = free.iter().chain(latents).zip(&bound.inputs);
        let found = found.map(|(&value, conversion)| conversion.value(value));
        let values: Vec<f64> = bound.known[case].iter().copied().chain(found).collect();
        let runner = self.idle().pop();
        let mut runner =
            runner.unwrap_or_else(|| Runner::new(Arc::clone(&self.library), bound.task.clone()));
        let results = runner.run(&values).map_err(|failure| failure.to_string())?;
        let predicted = results.iter().zip(&bound.outputs);
        let predicted = predicted
            .map(|(&value, conversion)| conversion.value(value))
            .collect();
        self.idle().push(runner);
        Ok(predicted)
    }
}
