//! An FMU as the model that identification asks for predictions.

use std::cell::RefCell;

use super::bind::Bound;
use crate::pipeline::{Halt, Model, Pipeline};
use crate::results::Outcome;
use calibration::problem::{NoPrediction, Prediction, Query, Simulate};
use fmu_points::Answer;

impl Model for Bound {
    fn values(&self, point: &[f64]) -> Vec<f64> {
        point.to_vec()
    }

    fn outcome(&self, answer: Answer) -> Outcome {
        answer.map(|results| {
            let predicted = results.iter().zip(&self.outputs);
            predicted
                .map(|(&value, conversion)| conversion.value(value))
                .collect()
        })
    }

    fn is_verified(&self, _: &Outcome) -> bool {
        false
    }
}

/// An FMU with its cases.
#[derive(Debug)]
pub struct FmuModel<'a, 'b> {
    bound: &'a Bound,
    state: RefCell<State<'a, 'b>>,
}

#[derive(Debug)]
struct State<'a, 'b> {
    pipeline: &'a mut Pipeline<'b>,
    halted: Option<Halt>,
}

impl<'a, 'b> FmuModel<'a, 'b> {
    /// A model that asks a pipeline.
    pub fn new(bound: &'a Bound, pipeline: &'a mut Pipeline<'b>) -> Self {
        let halted = None;
        Self {
            bound,
            state: RefCell::new(State { pipeline, halted }),
        }
    }

    /// Says how far the search has got.
    pub fn say(&self, text: String) {
        self.state.borrow().pipeline.say(text);
    }

    /// Why there are no further predictions, once they were refused.
    pub fn halted(self) -> Option<Halt> {
        self.state.into_inner().halted
    }

    /// The point of a query, in the FMU's units.
    fn point(&self, query: &Query) -> Vec<f64> {
        let found = query.free.iter().chain(&query.latents);
        let found = found.zip(&self.bound.inputs);
        let found = found.map(|(&value, conversion)| conversion.value(value));
        let known = self.bound.known[query.case].iter().copied();
        known.chain(found).collect()
    }
}

impl Simulate for FmuModel<'_, '_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let points: Vec<Vec<f64>> = queries.iter().map(|query| self.point(query)).collect();
        let mut state = self.state.borrow_mut();
        match state.pipeline.ask(&points) {
            Ok(outcomes) => {
                let outcomes = outcomes.into_iter();
                let named = |outcome: Outcome| outcome.map_err(|failure| failure.to_string());
                Ok(outcomes.map(named).collect())
            }
            Err(halt) => {
                state.halted = Some(halt);
                Err(NoPrediction::Stopped)
            }
        }
    }
}
