//! The most probable point: that with the largest product of prior density and likelihood.

use super::summary::Kept;
use crate::judge::Judge;
use conformity::likelihood::Likelihood;
use point_journal::Outcome;
use study::plan::Plan;

/// Looks for the most probable of the points that are shown to it.
///
/// The *nearest* point is another one: it agrees best with the measurement, however improbable its parameters are.
#[derive(Debug)]
pub(super) struct MostProbable<'a> {
    plan: &'a Plan,
    likelihood: Likelihood,
    best: Option<(f64, Kept)>,
}

impl<'a> MostProbable<'a> {
    /// `None` where not every measured value has an uncertainty, or a parameter comes from a sample, whose density is
    /// unknown.
    pub(super) fn new(judge: &Judge, plan: &'a Plan) -> Option<Self> {
        plan.has_density().then_some(())?;
        Some(Self { plan, likelihood: Likelihood::new(&judge.measurement)?, best: None })
    }

    /// Takes a point; of equally probable ones the first stays.
    pub(super) fn add(&mut self, label: u64, parameters: &[f64], outcome: &Outcome) {
        let Ok(values) = outcome else { return };
        let probability = self.plan.ln_prior(parameters) + self.likelihood.ln(values);
        let better = self.best.as_ref().is_none_or(|(most, _)| probability > *most);
        if better && probability > f64::NEG_INFINITY {
            self.best = Some((probability, Kept::new(label, parameters, values)));
        }
    }

    pub(super) fn best(&self) -> Option<&Kept> {
        self.best.as_ref().map(|(_, kept)| kept)
    }
}
