//! A bush that turns: a floating bush, a planet's bearing.

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;

const SPEED: f64 = 100.0;

/// A smooth bearing under a constant load after two seconds at these speeds of shaft and bush.
fn stand(model: FilmModel, load: f64, speeds: [f64; 2]) -> Stand {
    let mut stand = Stand::default();
    stand.film.model = model;
    stand.bearing.resolution.mass_conserving = false;
    stand.bearing.surface.roughness = 0.0;
    stand.thermal.isothermal = true;
    stand.load.lever_ratio = 0.0;
    stand.inputs.external_force.value = load;
    [stand.inputs.speed.value, stand.inputs.bush_speed.value] = speeds;
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand.advance(0.0, 2.0, &mut ()).unwrap();
    stand
}

fn run(model: FilmModel, load: f64, speeds: [f64; 2]) -> Readings {
    *stand(model, load, speeds).readings()
}

const FILMS: [FilmModel; 2] = [FilmModel::Mobility, FilmModel::Reynolds];

/// Bush and journal that turn together carry twice the load of a journal in a bush at rest (Booker 1965: only the mean speed against
/// the load counts), and do not shear the film: half the moment of the load is left on the journal.
#[test]
fn equal_speeds_double_the_capacity() {
    for model in FILMS {
        let [alone, both] = [run(model, 1000.0, [SPEED, 0.0]), run(model, 2000.0, [SPEED; 2])];
        let apart = (alone.eccentricity_ratio - both.eccentricity_ratio).abs();
        assert!(apart < 1e-4, "{model:?}: {alone:?} {both:?}");
        assert!((alone.attitude_angle - both.attitude_angle).abs() < 1e-3);
        assert!((both.max_film_pressure / alone.max_film_pressure - 2.0).abs() < 1e-2);
        let [e, angle] = [both.eccentricity_ratio, both.attitude_angle];
        let moment = 0.5 * both.hot_radial_clearance * 2000.0 * e * angle.sin();
        assert!((both.friction_torque / moment - 1.0).abs() < 1e-2, "{model:?} {} {moment}", both.friction_torque);
    }
}

/// A rotor whirls with the film's mean rotation (Newkirk & Taylor 1925: half the shaft's speed in a bush at rest), so that a film draws
/// in oil by the sum of the speeds: with a bush that turns along it begins to whirl at half the shaft's speed, at the same sum.
#[test]
fn a_rotor_whirls_at_the_same_sum_of_the_speeds() {
    for model in FILMS {
        let [alone, both] = [(100.0, [SPEED, 0.0]), (200.0, [SPEED; 2])].map(|(load, speeds)| {
            let resting = stand(model, load, speeds).resting();
            (resting.threshold, resting.coefficients)
        });
        assert!(alone.0 > 0.0 && (2.0 * both.0 / alone.0 - 1.0).abs() < 5e-3, "{model:?} {} {}", alone.0, both.0);
        // Twice the stiffness, the same damping.
        assert!((both.1.stiffness - 2.0 * alone.1.stiffness).norm() < 5e-3 * both.1.stiffness.norm(), "{model:?}");
        assert!((both.1.damping - alone.1.damping).norm() < 5e-3 * alone.1.damping.norm(), "{model:?}");
        println!("| {model:?} | {:.1} | {:.1} |", alone.0, both.0);
    }
}

/// Against each other they draw no oil in: the journal sinks as in a bearing at rest, and both shear the film.
#[test]
fn counter_rotation_carries_nothing() {
    for model in FILMS {
        let [against, still] = [run(model, 1000.0, [SPEED, -SPEED]), run(model, 1000.0, [0.0; 2])];
        assert!(
            (against.eccentricity_ratio - still.eccentricity_ratio).abs() < 1e-4,
            "{model:?} {against:?} {still:?}"
        );
        assert!(against.attitude_angle.abs() < 1e-3 && against.eccentricity_ratio > 0.98);
        assert!(against.friction_torque > 0.0);
    }
}

/// A shaft at rest in a bush that turns: the film of the turning shaft, with the opposite friction but for the moment of the load.
#[test]
fn a_turning_bush_does_as_the_shaft_does() {
    for model in FILMS {
        let [shaft, bush] = [run(model, 1000.0, [SPEED, 0.0]), run(model, 1000.0, [0.0, SPEED])];
        assert!((shaft.eccentricity_ratio - bush.eccentricity_ratio).abs() < 1e-4, "{model:?} {shaft:?} {bush:?}");
        let moment = shaft.hot_radial_clearance * 1000.0 * shaft.eccentricity_ratio * shaft.attitude_angle.sin();
        let sum = shaft.friction_torque + bush.friction_torque;
        assert!((sum / moment - 1.0).abs() < 1e-2, "{model:?}: {sum} {moment}");
    }
}
