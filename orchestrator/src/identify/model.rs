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
            predicted.map(|(&value, conversion)| conversion.value(value)).collect()
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
        Self { bound, pipeline: RefCell::new(pipeline), halted: RefCell::new(None) }
    }

    /// Says how far the search has got.
    pub fn say(&self, text: String) {
        self.pipeline.borrow().say(text);
    }

    /// The communication steps of its simulations, s: each size once.
    pub fn steps(&self) -> Vec<f64> {
        let simulations = self.bound.simulations.iter();
        let mut steps: Vec<f64> = simulations.map(|case| case.task.schedule.step).collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup();
        steps
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

    /// The predictions of queries, given the outcomes of their points.
    fn predicted(
        &self,
        queries: &[Query],
        outcomes: Result<Vec<Outcome>, point_journal::Error>,
    ) -> Result<Vec<Prediction>, NoPrediction> {
        let outcomes = outcomes.map_err(|halt| {
            *self.halted.borrow_mut() = Some(halt.into());
            NoPrediction::Stopped
        })?;
        let predicted = |(query, outcome): (&Query, Outcome)| {
            let readings = outcome.map_err(|failure| failure.to_string())?;
            let values = self.bound.readings.iter();
            Ok(values.map(|reading| reading.value(&readings, &query.free)).collect())
        };
        Ok(queries.iter().zip(outcomes).map(predicted).collect())
    }

    fn points(&self, queries: &[Query]) -> Vec<Vec<f64>> {
        queries.iter().map(|query| self.point(query)).collect()
    }
}

impl Simulate for FmuModel<'_, '_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let asked = self.pipeline.borrow_mut().ask(&self.points(queries));
        self.predicted(queries, asked)
    }
}

/// The same FMU with half the communication steps; its runs are in no journal.
pub struct Finer<'a, 'b, 'c>(pub &'a FmuModel<'b, 'c>);

impl Simulate for Finer<'_, '_, '_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let Self(model) = self;
        let mut cases = model.bound.simulations.clone();
        for case in &mut cases {
            case.task.schedule.step *= 0.5;
        }
        let pipeline = model.pipeline.borrow();
        match pipeline.apart(&cases, &model.points(queries)).transpose() {
            Some(outcomes) => model.predicted(queries, outcomes),
            None => Err(NoPrediction::Here("the FMU gives other results each time".to_owned())),
        }
    }
}
