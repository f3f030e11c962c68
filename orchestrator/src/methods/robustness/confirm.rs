//! Fresh runs of the model inside the box.

use super::{super::asking, Points, ROUNDS, joint};
use crate::{
    error::{Error, Result},
    session::Session,
};
use parameter_regions::{
    robustness::{Robustness, rows},
    table::PointTable,
};
use point_journal::pipeline::Pipeline;

/// The most draws to search for points inside a small region.
const MOST_DRAWS: u64 = 4_000_000;

/// Statements to confirm, and the means to do so.
pub(super) struct Confirmation<'a, 'b> {
    pub(super) session: &'a Session,
    pub(super) pipeline: &'a mut Pipeline<'b>,
    pub(super) known: &'a Points,
    pub(super) cloud: &'a [Vec<f64>],
    /// Fresh points in the box, of each round.
    pub(super) points: usize,
    pub(super) rounds: u64,
    pub(super) seed: u64,
}

impl Confirmation<'_, '_> {
    /// Runs independent points of the study's distributions inside the box, and notes the outcome. Where a statement does
    /// not hold, the surrogates learn from these runs, and their new statements are confirmed by new runs: points that
    /// judge a statement must be independent of the points that it was made from.
    pub(super) fn of(&mut self, mut result: Robustness) -> Result<Robustness> {
        let inputs = self.session.plan.inputs.iter().map(|input| &input.name);
        if !inputs.eq(self.known.all.parameters.iter().map(|p| &p.name)) {
            return Err(Error::option("confirm", "the study's parameters are not those of the points"));
        }
        let mut known = self.known.all.clone();
        for round in 0..self.rounds {
            let runs = self.judge(&mut result, round)?;
            if result.region.as_ref().is_none_or(|region| region.agrees(result.level)) {
                break;
            }
            known.extend(&runs);
            match self.known.stated(&known, self.cloud, result.level) {
                Some(better) if round + 1 < self.rounds => result = better,
                _ => break,
            }
        }
        if let Some(region) = &result.region {
            result.answer = result.answer.clone().after(region, result.level);
        }
        Ok(result)
    }

    /// Fresh runs inside the box, noted there.
    fn judge(&mut self, result: &mut Robustness, round: u64) -> Result<PointTable> {
        let parameters = &self.known.all.parameters;
        let places: Vec<usize> =
            (0..parameters.len()).filter(|&k| result.parameters.contains(&parameters[k].name)).collect();
        let varying = |x: &[f64]| -> Vec<f64> { places.iter().map(|&k| x[k]).collect() };
        let Some(region) = &mut result.region else { return self.run(Vec::new()) };
        let runs = self.run(self.inside(round, |x| region.contains(&varying(x)))?)?;
        let inner: Vec<Vec<f64>> = rows(&runs).iter().map(|x| varying(x)).collect();
        region.fresh = Some(region.confirm(&inner, &runs.verified));
        Ok(runs)
    }

    /// The first points of a sequence of independent ones that lie inside.
    fn inside(&self, round: u64, inside: impl Fn(&[f64]) -> bool) -> Result<Vec<Vec<f64>>> {
        let plan = &self.session.plan;
        // Far from the seeds that people give to studies.
        let seed = !self.seed.wrapping_mul(ROUNDS).wrapping_add(round);
        let points = joint(plan, MOST_DRAWS, seed).map_err(|message| Error::option("confirm", message))?;
        Ok((0..MOST_DRAWS).map(|index| points.point(index)).filter(|x| inside(x)).take(self.points).collect())
    }

    fn run(&mut self, points: Vec<Vec<f64>>) -> Result<PointTable> {
        let outcomes = self.pipeline.ask(&points)?;
        Ok(asking::table(self.session, &points, outcomes))
    }
}
