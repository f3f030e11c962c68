//! Fresh runs of the model inside the box.

use super::{Points, joint};
use crate::{
    error::{Error, Result},
    results::table,
    session::Session,
};
use parameter_regions::robustness::{Robustness, rows};
use point_journal::pipeline::Pipeline;

/// The most draws to search for points inside a small region.
const MOST_DRAWS: u64 = 4_000_000;

/// Statements to confirm, and the means to do so.
pub struct Confirmation<'a, 'b> {
    pub session: &'a Session,
    pub pipeline: &'a mut Pipeline<'b>,
    pub known: &'a Points,
    /// Fresh points in the box.
    pub points: usize,
    pub seed: u64,
}

impl Confirmation<'_, '_> {
    /// Runs independent points of the study's distributions inside the box, and notes the outcome.
    pub fn of(&mut self, mut result: Robustness) -> Result<Robustness> {
        let parameters = &self.known.all.parameters;
        let inputs = self.session.plan.inputs.iter().map(|input| &input.name);
        if !inputs.eq(parameters.iter().map(|p| &p.name)) {
            return Err(Error::option("confirm", "the study's parameters are not those of the points"));
        }
        let places: Vec<usize> =
            (0..parameters.len()).filter(|&k| result.parameters.contains(&parameters[k].name)).collect();
        let varying = |x: &[f64]| -> Vec<f64> { places.iter().map(|&k| x[k]).collect() };
        if let Some(region) = &mut result.region {
            let points = self.inside(|x| region.contains(&varying(x)))?;
            let outcomes = self.pipeline.ask(&points)?;
            let Session { plan, judge, .. } = self.session;
            let runs = table::from_runs(plan, &places, judge, &points, outcomes);
            region.fresh = Some(region.confirm(&rows(&runs), &runs.verified));
            result.answer = result.answer.clone().after(region, result.level);
        }
        Ok(result)
    }

    /// The first points of a sequence of independent ones that lie inside.
    fn inside(&self, inside: impl Fn(&[f64]) -> bool) -> Result<Vec<Vec<f64>>> {
        let plan = &self.session.plan;
        // Far from the seeds that people give to studies.
        let points = joint(plan, MOST_DRAWS, !self.seed).map_err(|message| Error::option("confirm", message))?;
        Ok((0..MOST_DRAWS).map(|index| points.point(index)).filter(|x| inside(x)).take(self.points).collect())
    }
}
