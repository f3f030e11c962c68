//! The stand against published values.

#![allow(clippy::unwrap_used)]

mod raimondi_boyd;

use plain_bearing_stand::model::{Experiment, Model};
use plain_bearing_stand::stand::Stand;
use raimondi_boyd::RAIMONDI_BOYD;
use std::f64::consts::TAU;

/// Under a constant load, isothermal and smooth, the journal settles at the tabulated eccentricity and
/// friction within 2 %. The table sets the pressure to zero at the widest gap; our immersed film is free to
/// rupture where it will, which is what sets both 1.9 % apart at an eccentricity ratio of 0.1.
#[test]
fn the_settled_journal_is_raimondi_and_boyds() {
    for [e, sommerfeld, _, friction] in RAIMONDI_BOYD {
        let mut stand = Stand::default();
        stand.thermal.isothermal = true;
        stand.bearing.surface.roughness = 0.0;
        stand.bearing.width = stand.bearing.diameter;
        stand.load.eccentricity = 0.0;
        stand.load.preload = 0.0;
        stand.load.stiffness = 0.0;
        let nothing = Experiment {
            start: 0.0,
            stop: None,
            tolerance: None,
            resources: None,
        };
        stand.initialise(&nothing, &mut ()).unwrap();
        let viscosity = stand.readings().film_viscosity;
        let psi = stand.bearing.relative_clearance();
        let turns_per_second = stand.inputs.speed.value / TAU;
        let pressure = viscosity * turns_per_second / (sommerfeld * psi * psi);
        stand.inputs.external_force.value = pressure * stand.bearing.width * stand.bearing.diameter;
        stand.advance(0.0, 20.0, &mut ()).unwrap();
        let r = stand.readings();
        let ratio = r.eccentricity_ratio / e;
        assert!(
            (ratio - 1.0).abs() < 0.02,
            "eccentricity ratio at {e}: {ratio} of the tabulated"
        );
        let ratio = r.friction_coefficient / psi / friction;
        assert!(
            (ratio - 1.0).abs() < 0.02,
            "friction at {e}: {ratio} of the tabulated"
        );
    }
}
