//! The house without FMI: its declaration, and how it is driven.
#![allow(clippy::unwrap_used)]

use fmu_export::model::{Experiment, Kind, Model, faults};
use thermostat::House;

fn temperature(house: &House) -> f64 {
    let mut variables = House::variables().iter();
    let variable = variables.find(|one| one.name == "temperature[1]").unwrap();
    match &variable.kind {
        Kind::Real(real) => (real.access.get)(house),
        _ => f64::NAN,
    }
}

#[test]
fn the_declaration_is_sound() {
    assert_eq!(faults::<House>(), Vec::<String>::new());
}

/// From 288.15 K towards 308.15 K to 294.15 K, and then back towards 278.15 K: also where one step has all of it.
#[test]
fn a_heater_is_switched_off_within_a_step() {
    let first = 7200.0 * (20.0_f64 / 14.0).ln();
    let expected = 278.15 + 16.0 * (-(3000.0 - first) / 7200.0).exp();
    for steps in [1, 7, 3000] {
        let mut house = House::default();
        house.initialise(&Experiment::default(), &mut ()).unwrap();
        let step = 3000.0 / f64::from(steps);
        for number in 0..steps {
            house.advance(f64::from(number) * step, step, &mut ()).unwrap();
        }
        assert!((temperature(&house) - expected).abs() < 1e-9, "{steps} steps");
    }
}
