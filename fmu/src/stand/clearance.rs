//! The clearance that the film sees, and its end: the seizure of a bearing whose shaft outgrows its bush.

use super::Stand;
use super::stuck::Stuck;
use crate::thermal::Temperatures;
use fmu_export::model::Fault;
use std::fmt;

/// A clearance that closes, at the temperatures of bush and shaft.
#[derive(Clone, Copy, Debug)]
pub struct Seizure {
    bush: f64,
    shaft: f64,
    /// The clearance that is left, and the one that was measured, m.
    hot: f64,
    cold: f64,
    /// The temperature at which it was measured, K.
    reference: f64,
}

impl fmt::Display for Seizure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            bush,
            shaft,
            reference,
            ..
        } = self;
        let [hot, cold] = [self.hot, self.cold].map(|metres| metres * 1e6);
        write!(
            f,
            "the bearing seizes: with the bush at {bush:.1} K and the shaft at {shaft:.1} K, thermal expansion leaves \
             {hot:.2} um of the {cold:.2} um of bearing.radialClearance at {reference:.1} K; raise bearing.radialClearance, or \
             check bearing.shaftExpansion against bearing.bushExpansion and bearing.housingExpansion, or set \
             bearing.thermalClearance = Off"
        )
    }
}

impl Stand {
    /// The clearance that the film sees, m, at these temperatures and a mean wear depth, m. Where it closes, the least positive
    /// one stands in for it until the step is refused.
    #[inline]
    pub(super) fn clearance(&self, temperatures: &Temperatures, worn: f64) -> f64 {
        let at = [temperatures.bush, temperatures.shaft];
        let hot = self.bearing.hot_clearance(at, worn);
        hot.max(self.bearing.closed_clearance())
    }

    /// Whether the clearance closes there, and how.
    pub(super) fn seizure(&self, temperatures: &Temperatures, worn: f64) -> Option<Seizure> {
        let Temperatures { bush, shaft, .. } = *temperatures;
        let hot = self.bearing.hot_clearance([bush, shaft], worn);
        (hot.is_nan() || hot <= self.bearing.closed_clearance()).then_some(Seizure {
            bush,
            shaft,
            hot,
            cold: self.bearing.radial_clearance,
            reference: self.bearing.expansion.reference,
        })
    }

    /// Refuses a state whose clearance is closed.
    pub(super) fn check_clearance(&self) -> Result<(), Stuck> {
        let seizure = self.seizure(&self.state.temperatures, self.state.worn);
        seizure.map_or(Ok(()), |seizure| Err(Stuck::Seized(seizure)))
    }

    /// Refuses a start whose clearance is closed, and wear whose cause cannot be told.
    pub(super) fn check_wear_and_clearance(&self) -> Result<(), Fault> {
        if self.bearing.wear.coefficient > 0.0 && self.bearing.surface.boundary_friction == 0.0 {
            return Err(Fault::Invalid(
                "bearing.wearCoefficient > 0 needs bearing.boundaryFriction > 0: wear follows from the asperities' \
                 friction work"
                    .to_owned(),
            ));
        }
        self.check_clearance()
            .map_err(|why| Fault::Invalid(why.to_string()))
    }
}
