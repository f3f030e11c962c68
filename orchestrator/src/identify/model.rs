//! An FMU as the model that identification asks for predictions.

use std::cell::RefCell;

use super::bind::Bound;
use crate::error::Error;
use calibration::problem::{NoPrediction, Prediction, Query, Simulate};
use fmu_points::{
    PointResult,
    task::{Slot, Task},
};
use point_journal::{
    PointOutcome,
    pipeline::{Model, Pipeline},
};
use sampling::statistics::moments::sorted;

impl Model for Bound {
    fn values(&self, point: &[f64]) -> Vec<f64> {
        point.to_vec()
    }

    fn outcome(&self, answer: PointResult) -> PointOutcome {
        answer.map(|results| {
            results.iter().zip(&self.outputs).map(|(&value, conversion)| conversion.value(value)).collect()
        })
    }

    fn is_verified(&self, _: &PointOutcome) -> bool {
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
        let mut steps = sorted(self.bound.tasks().map(|task| task.schedule.step).collect());
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
        let sought = free
            .iter()
            .chain(&query.latents)
            .zip(&self.bound.inputs)
            .map(|(&value, conversion)| conversion.value(value));
        self.bound.known[query.case].iter().copied().chain(sought).collect()
    }

    /// The predictions of queries, given the outcomes of their points.
    fn predicted(
        &self,
        queries: &[Query],
        outcomes: Result<Vec<PointOutcome>, point_journal::Error>,
    ) -> Result<Vec<Prediction>, NoPrediction> {
        let outcomes = outcomes.map_err(|halt| {
            *self.halted.borrow_mut() = Some(halt.into());
            NoPrediction::Stopped
        })?;
        Ok(queries
            .iter()
            .zip(outcomes)
            .map(|(query, outcome)| {
                let readings = outcome.map_err(|failure| failure.to_string())?;
                Ok(self.bound.readings.iter().map(|reading| reading.value(&readings, &query.free)).collect())
            })
            .collect())
    }

    /// The predictions of queries by other simulations, whose runs are in no journal.
    fn apart(
        &self,
        change: impl Fn(&mut Task),
        queries: &[Query],
        points: Vec<Vec<f64>>,
    ) -> Result<Vec<Prediction>, NoPrediction> {
        let mut cases = self.bound.simulations.clone();
        cases.iter_mut().for_each(|case| change(&mut case.task));
        let outcomes = self.pipeline.borrow().apart(&cases, &points);
        self.predicted(queries, outcomes)
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
        model.apart(|task| task.halve_steps(1), queries, model.points(queries))
    }
}

/// The same FMU with further variables, in its own units, that take the last of a query's free values; its runs are in no journal.
pub struct Extended<'a, 'b, 'c> {
    /// The FMU.
    pub model: &'a FmuModel<'b, 'c>,
    /// The variables.
    pub slots: Vec<Slot>,
}

impl Simulate for Extended<'_, '_, '_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let (queries, further): (Vec<Query>, Vec<Vec<f64>>) = queries
            .iter()
            .map(|query| {
                let own = query.free.len() - self.slots.len();
                let (free, further) = query.free.split_at(own);
                (Query { free: free.to_vec(), ..query.clone() }, further.to_vec())
            })
            .unzip();
        let points =
            self.model.points(&queries).into_iter().zip(further).map(|(point, further)| [point, further].concat());
        self.model.apart(
            |task| {
                let is_further = |reference: u32| self.slots.iter().any(|slot| slot.handle.reference == reference);
                task.fixed.retain(|(reference, _)| !is_further(*reference));
                task.varied.extend(self.slots.iter().cloned());
            },
            &queries,
            points.collect(),
        )
    }
}
