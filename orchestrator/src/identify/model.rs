//! An FMU as the model that identification asks for predictions.

use std::cell::RefCell;

use super::bind::Bound;
use crate::error::Error;
use calibration::problem::{NoPrediction, Prediction, Query, Simulate};
use fmu_points::Answer;
use point_journal::Outcome;
use point_journal::pipeline::{Model, Pipeline};

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
pub struct FmuModel<'a, 'b> {
    bound: &'a Bound,
    pipeline: RefCell<&'a mut Pipeline<'b>>,
    halted: RefCell<Option<Error>>,
}

impl<'a, 'b> FmuModel<'a, 'b> {
    /// A model that asks a pipeline.
    pub fn new(bound: &'a Bound, pipeline: &'a mut Pipeline<'b>) -> Self {
        Self {
            bound,
            pipeline: RefCell::new(pipeline),
            halted: RefCell::new(None),
        }
    }

    /// Says how far the search has got.
    pub fn say(&self, text: String) {
        self.pipeline.borrow().say(text);
    }

    /// Why there are no further predictions, once they were refused.
    pub fn halted(self) -> Option<Error> {
        self.halted.into_inner()
    }

    /// The point of a query, in the FMU's units.
    fn point(&self, query: &Query) -> Vec<f64> {
        // Lags stand last, and the FMU knows nothing of them.
        let free = &query.free[..query.free.len() - self.bound.lags.len()];
        let sought = free.iter().chain(&query.latents);
        let sought = sought.zip(&self.bound.inputs);
        let sought = sought.map(|(&value, conversion)| conversion.value(value));
        let known = self.bound.known[query.case].iter().copied();
        known.chain(sought).collect()
    }
}

impl Simulate for FmuModel<'_, '_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let points: Vec<Vec<f64>> = queries.iter().map(|query| self.point(query)).collect();
        let asked = self.pipeline.borrow_mut().ask(&points);
        match asked {
            Ok(outcomes) => {
                let pairs = queries.iter().zip(outcomes);
                let predicted = |(query, outcome): (&Query, Outcome)| {
                    let readings = outcome.map_err(|failure| failure.to_string())?;
                    let values = self.bound.readings.iter();
                    Ok(values
                        .map(|reading| reading.value(&readings, &query.free))
                        .collect())
                };
                Ok(pairs.map(predicted).collect())
            }
            Err(halt) => {
                *self.halted.borrow_mut() = Some(halt.into());
                Err(NoPrediction::Stopped)
            }
        }
    }
}
