//! A model that answers so many questions and no more.

use std::cell::Cell;

use super::problem::{NoPrediction, Prediction, Query, Simulate};

/// A model with the number of its runs that are left.
pub struct Capped<'a> {
    model: &'a dyn Simulate,
    left: Cell<u64>,
    refused: Cell<bool>,
}

impl<'a> Capped<'a> {
    /// A model that runs so often.
    pub fn new(model: &'a dyn Simulate, runs: u64) -> Self {
        Self { model, left: Cell::new(runs), refused: Cell::new(false) }
    }

    /// How many runs are left.
    pub fn left(&self) -> u64 {
        self.left.get()
    }

    /// Whether it was asked for more than it had.
    pub fn has_refused(&self) -> bool {
        self.refused.get()
    }
}

impl Simulate for Capped<'_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let count = queries.len().min(usize::try_from(self.left.get()).unwrap_or(usize::MAX));
        self.left.set(self.left.get() - count as u64);
        let mut predictions = self.model.simulate(&queries[..count])?;
        if count < queries.len() {
            self.refused.set(true);
            predictions.resize(queries.len(), Err("the budget is spent".to_owned()));
        }
        Ok(predictions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_runs_than_there_are() {
        let model = |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0]]);
        let capped = Capped::new(&model, 3);
        let query = |x| Query { case: 0, free: vec![x], latents: Vec::new() };
        assert!(capped.simulate(&[query(1.0), query(2.0)]).unwrap().iter().all(Result::is_ok));
        assert!(!capped.has_refused());
        let last = capped.simulate(&[query(3.0), query(4.0)]).unwrap();
        assert!(last[0].is_ok() && last[1].is_err() && capped.has_refused() && capped.left() == 0);
    }
}
