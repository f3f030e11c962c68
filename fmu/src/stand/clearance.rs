//! The clearance that the film sees, and its end: the seizure of a bearing whose shaft outgrows its bush.

use super::Stand;
use crate::{Result, thermal::Temperatures};
use fmu_export::model::Fault;

impl Stand {
    /// The clearance that the film sees, m, at these temperatures and a mean wear depth, m. Where it closes, the least positive
    /// one stands in for it until the step is refused.
    #[inline]
    pub(super) fn clearance(&self, temperatures: &Temperatures, worn: f64) -> f64 {
        let at = [temperatures.bush, temperatures.shaft];
        let hot = self.bearing.hot_clearance(at, worn);
        hot.max(self.bearing.closed_clearance())
    }

    /// The seizure at these temperatures and this wear depth, if the clearance closes there.
    pub(super) fn seizure(&self, temperatures: &Temperatures, worn: f64) -> Option<Fault> {
        let Temperatures { bush, shaft, .. } = *temperatures;
        let hot = self.bearing.hot_clearance([bush, shaft], worn);
        let closes = hot.is_nan() || hot <= self.bearing.closed_clearance();
        closes.then(|| {
            Fault::Failed(format!(
                "the bearing seizes: with the bush at {bush:.1} K and the shaft at {shaft:.1} K, thermal expansion leaves {:.2} \
                 um of the {:.2} um of bearing.radialClearance at {:.1} K; raise bearing.radialClearance, or check \
                 bearing.shaftExpansion against bearing.bushExpansion and bearing.housingExpansion, or set \
                 bearing.thermalClearance = Off",
                1e6 * hot,
                1e6 * self.bearing.radial_clearance,
                self.bearing.expansion.reference,
            ))
        })
    }

    /// Refuses a state whose clearance is closed.
    pub(super) fn check_clearance(&self) -> Result {
        let seizure = self.seizure(&self.state.temperatures, self.state.worn);
        seizure.map_or(Ok(()), Err)
    }

    /// Refuses a start whose clearance is closed, and wear whose cause cannot be told.
    pub(super) fn check_wear_and_clearance(&self) -> Result {
        if self.bearing.wear.coefficient > 0.0 && self.bearing.surface.boundary_friction == 0.0 {
            return Err(Fault::Invalid(
                "bearing.wearCoefficient > 0 needs bearing.boundaryFriction > 0: wear follows from the asperities' \
                 friction work"
                    .to_owned(),
            ));
        }
        self.check_clearance().map_err(|why| Fault::Invalid(why.to_string()))
    }
}
