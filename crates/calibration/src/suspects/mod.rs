//! What would explain a misfit: one thing at a time that the search took as given.
//!
//! A fit that misses names no culprit: all unknowns bend as far as they may. So each suspect gets free play alone: a parameter
//! beyond its range, the offset, gain or delay of a sensor, a constant of the model, another unit. Around the optimum the
//! problem is linear, and the score test (Rao 1948, Proc. Camb. Phil. Soc. 44, 50-57; "modification index" in Sorbom 1989,
//! Psychometrika 54, 371-384) says by how much the sum of squares would fall. The most promising ones are then fitted by runs:
//! what is told has been simulated.

mod constant;
mod inquiry;
mod linear;
mod range;
mod sensor;
#[cfg(test)]
mod tests;
mod unit;

use std::{collections::HashSet, mem::discriminant};

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::problem::NoPrediction;
pub use inquiry::{Confusion, Constant, Inquiry, Sensor, Suspect, Suspicion};
use linear::Linear;

/// So many suspects are fitted.
const FITTED: usize = 6;

impl Inquiry<'_> {
    /// What would explain the misfit, the likeliest first; none where nothing does much.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn suspects(&self) -> Result<Vec<Suspect>, NoPrediction> {
        let Some(linear) = Linear::new(self) else { return Ok(Vec::new()) };
        let mut candidates = self.ranges(&linear);
        candidates.extend(self.of_sensors(&linear));
        candidates.extend(self.of_constants(&linear));
        let units = self.units()?;
        let tried = (candidates.len() + units.len()).max(1);
        candidates.sort_by(|a, b| b.fall.total_cmp(&a.fall));
        candidates.truncate(FITTED);
        candidates.extend(units);
        let mut suspects = Vec::new();
        for candidate in candidates {
            match (candidate.fit)() {
                Err(NoPrediction::Here(_)) => {}
                ended => suspects.push(ended?),
            }
        }
        let excess = |cost: f64| cost - linear.freedom;
        let chance = |fall: f64| ChiSquared::new(1.0).map_or(1.0, |law| law.sf(fall.max(0.0)));
        suspects.retain(|suspect: &Suspect| {
            let [before, after] = suspect.cost;
            chance(before - after) * (tried as f64) < 0.01 && excess(after) < 0.5 * excess(before)
        });
        suspects.sort_by(|a, b| a.rank().total_cmp(&b.rank()));
        // A delay is looked for by rows and by slopes.
        let mut seen = HashSet::new();
        suspects.retain(|suspect| seen.insert((discriminant(&suspect.fault), suspect.name.clone())));
        Ok(suspects)
    }
}
