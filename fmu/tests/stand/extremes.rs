//! Parameters from anywhere in their ranges: a step is made, or refused soon with a message that names what is
//! unusual. How much work "soon" is, the solver's budget says, and its own tests.

use fmu_export::model::{Experiment, Fault, Kind, Model, Quantity, Variable};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;
use proptest::prelude::*;
use proptest::sample::Index;
use std::f64::consts::SQRT_2;

const EXPERIMENT: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

fn set(stand: &mut Stand, name: &str, value: f64) {
    let variable = Stand::variables().iter().find(|v| v.name == name).unwrap();
    if let Kind::Real(Quantity { access, .. }) = &variable.kind {
        access.set.unwrap()(stand, &value);
    }
}

/// The stand with some variables set, and what became of its steps.
fn run(settings: &[(&str, f64)], steps: &[f64]) -> Result<Stand, Fault> {
    let mut stand = Stand::default();
    for (name, value) in settings {
        set(&mut stand, name, *value);
    }
    stand.initialise(&EXPERIMENT, &mut ())?;
    let mut time = 0.0;
    for step in steps {
        stand.advance(time, *step, &mut ())?;
        time += step;
    }
    Ok(stand)
}

/// A variable that can be set, and its range.
fn settable(variable: &Variable<Stand>) -> Option<(&'static str, f64, f64)> {
    match &variable.kind {
        Kind::Real(Quantity { access, min: Some(min), max: Some(max), .. }) if access.set.is_some() => {
            Some((variable.name, *min, *max))
        }
        _ => None,
    }
}

/// One end of a range, evenly from within it, or of any magnitude.
fn anywhere(way: u8, part: f64, min: f64, max: f64) -> f64 {
    let value = match way {
        0 => min,
        1 => max,
        2 => min + part * (max - min),
        _ if min > 0.0 => min * (max / min).powf(part),
        _ => max * 1e-9_f64.powf(part) * if way == 3 { 1.0 } else { -1.0 },
    };
    value.clamp(min, max)
}

fn corners() -> impl Strategy<Value = Vec<(&'static str, f64)>> {
    let variables: Vec<_> = Stand::variables().iter().filter_map(settable).collect();
    let setting = (any::<Index>(), 0..5_u8, 0.0..=1.0).prop_map(move |(index, way, part)| {
        let (name, min, max) = *index.get(&variables);
        (name, anywhere(way, part, min, max))
    });
    prop::collection::vec(setting, 1..10)
}

fn names_a_variable(fault: &Fault) -> bool {
    let message = fault.to_string();
    Stand::variables().iter().any(|v| message.contains(v.name))
}

fn is_made_or_refused(settings: &[(&'static str, f64)]) -> Result<(), TestCaseError> {
    match run(settings, &[1e-3, 0.1]) {
        Ok(stand) => {
            for variable in Stand::variables() {
                if let Kind::Real(Quantity { access, min, max, .. }) = &variable.kind {
                    let value = (access.get)(&stand);
                    let (least, most) = (min.unwrap_or(f64::MIN), max.unwrap_or(f64::MAX));
                    // Written so that what is no number fails, too.
                    let within = least <= value && value <= most;
                    prop_assert!(within, "{} = {value}", variable.name);
                }
            }
        }
        Err(fault) => prop_assert!(names_a_variable(&fault), "{fault}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 15, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_step_is_made_or_refused_with_a_name(settings in corners()) {
        is_made_or_refused(&settings)?;
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// The seed comes from `PROPTEST_RNG_SEED`, which `scripts/test --long` draws.
    #[test]
    #[ignore = "takes minutes: scripts/test --long"]
    fn thousands_of_steps_are_made_or_refused_with_a_name(settings in corners()) {
        is_made_or_refused(&settings)?;
    }
}

#[test]
fn what_makes_a_step_impossible_is_named() {
    let cases: [(&[(&str, f64)], &str); 6] = [
        (&[("load.preload", 1e5), ("thermal.filmCapacity", 1e-3)], "the film's temperature settles within"),
        (
            &[("load.preload", 1e5), ("thermal.filmCapacity", 1e-3)],
            "check load.preload: it is 100000.0 N, by default 48.0 N",
        ),
        (
            &[("bearing.width", 1e-4), ("bearing.asperityDensity", 1.0)],
            "check bearing.width: it is 0.0001 m, by default 0.019 m",
        ),
        (&[("oil.kinematicViscosity100", 2e-4)], "must not be greater than oil.kinematicViscosity40"),
        (&[("thermal.initialFilmRise", -300.0)], "raise thermal.initialBearingTemperature or thermal.initialFilmRise"),
        (
            &[("thermal.initialBearingTemperature", 290.0), ("thermal.initialShaftRise", -300.0)],
            "the shaft would start at -10.0 K, which is not above absolute zero: raise",
        ),
    ];
    for (settings, expected) in cases {
        let message = match run(settings, &[0.1]) {
            Ok(_) => "a step was made".to_owned(),
            Err(fault) => fault.to_string(),
        };
        assert!(message.contains(expected), "{settings:?}: {message}");
    }
}

/// A part of the model that settles within nanoseconds only follows the rest; implicit steps need not resolve it.
#[test]
fn stiffness_alone_refuses_no_step() {
    let usual = run(&[], &[0.1]).unwrap().readings().film_temperature;
    let massless = [("thermal.filmCapacity", 1e-3), ("thermal.filmBushConductance", 1e4)];
    let film = run(&massless, &[0.1]).unwrap().readings().film_temperature;
    // So closely tied to the bush, it has the bush's temperature.
    assert!((film - 355.15).abs() < 0.01 && film != usual, "{film}");
    // The asperities alone carry 13 kN on a pin of 1 mm: the mean planes have crossed.
    let pin = |diameter| {
        let hard = [("bearing.diameter", diameter), ("load.leverRatio", 300.0)];
        run(&hard, &[0.1])
    };
    let pressed = *pin(1e-3).unwrap().readings();
    assert!((2.0..3.0).contains(&pressed.contact_reach), "{pressed:?}");
    let dry = Stand::default().bearing.surface.boundary_friction;
    let share = pressed.friction_coefficient / dry;
    assert!((1.0..1.1).contains(&share), "{share}");
}

/// On a pin of 0.1 mm, 7 GPa press the surfaces far through each other's heights: beyond their law, and beyond any bearing.
#[test]
fn what_no_surface_bears_is_refused_with_a_name() {
    let hard = [("bearing.diameter", 1e-4), ("load.leverRatio", 300.0)];
    let fault = run(&hard, &[0.1]).unwrap_err().to_string();
    let why = "faster than in any bearing";
    assert!(fault.contains(why) && fault.contains("bearing.diameter"), "{fault}");
}

#[test]
fn no_step_takes_an_input_out_of_its_range() {
    let mut stand = Stand::default();
    stand.initialise(&EXPERIMENT, &mut ()).unwrap();
    stand.inputs.speed.slope = 1e6;
    let before = stand.save().unwrap();
    let Err(Fault::Failed(message)) = stand.advance(0.0, 0.01, &mut ()) else {
        panic!("the step was made");
    };
    assert!(message.contains("take drive.speed to 10031.4"), "{message}");
    assert!(message.contains("set a smaller input derivative"), "{message}");
    assert_eq!(stand.save().unwrap(), before);
    // A shorter step does; and a ramp may end at the bound.
    stand.advance(0.0, 1e-4, &mut ()).unwrap();
    stand.inputs.speed.value = 0.3;
    stand.inputs.speed.slope = (2000.0 - 0.3) / 0.07;
    stand.advance(1e-4, 0.07, &mut ()).unwrap();
}

/// A fluctuation with no common period with the turns, so that every one of them is resolved.
const RESOLVED: [(&str, f64); 2] = [("drive.fluctuationAmplitude", 0.02), ("drive.fluctuationFrequency", 0.5 * SQRT_2)];

#[test]
fn a_thousand_seconds_are_one_step() {
    let stand = run(&RESOLVED, &[1000.0]).unwrap();
    assert!((stand.readings().shaft_angle / (1000.0 * stand.inputs.speed.value) - 1.0).abs() < 1e-3);
}

#[test]
fn a_step_of_years_is_refused() {
    let Err(Fault::Failed(message)) = run(&RESOLVED, &[1e9]) else {
        panic!("the step was made");
    };
    assert!(message.contains("take shorter communication steps"), "{message}");
}

/// Far from zero, the phase of the fluctuation would be no number.
#[test]
fn times_that_no_clock_reaches_are_refused() {
    let mut stand = Stand::default();
    set(&mut stand, "drive.fluctuationAmplitude", 0.02);
    let far = |start| Experiment { start, ..EXPERIMENT };
    for start in [1.1e12, -1e300, f64::MAX] {
        let Err(Fault::Invalid(message)) = stand.initialise(&far(start), &mut ()) else {
            panic!("a start at {start} s was accepted");
        };
        assert!(message.contains("between -1e12 and 1e12 s"), "{message}");
    }
    stand.initialise(&far(1e12), &mut ()).unwrap();
    let before = stand.save().unwrap();
    let refused = stand.advance(1e12, 0.01, &mut ());
    assert!(matches!(refused, Err(Fault::Failed(_))), "{refused:?}");
    assert_eq!(stand.save().unwrap(), before);
    assert!(stand.readings().shaft_speed.is_finite());
}

/// Thirty bearings from all over: radial clearances of 1 um to 0.5 mm, 0.1 mPa.s to 10 Pa.s, 1 to 15,000 rpm, up to 50 kN, B/D of 0.1
/// to 2, smooth and rough. Where neither film says that it is beyond its limits, or refuses, both are the same.
#[test]
#[ignore = "takes minutes: scripts/test --long"]
fn thirty_extreme_bearings_are_right_or_flagged_or_refused() {
    let mut same = 0;
    for k in 1..=30 {
        // Even and irregular numbers (Roberts 2018) in six dimensions.
        let ratio: f64 = (0..100).fold(1.0, |g: f64, _| (1.0 + g).powf(1.0 / 7.0));
        let at = |n: i32| (0.5 + f64::from(k) / ratio.powi(n)).fract();
        let between = |low: f64, high: f64, n: i32| low * (high / low).powf(at(n));
        let (clearance, viscosity) = (between(1e-6, 5e-4, 1), between(1e-4, 10.0, 2));
        let speed = between(1.0, 15_000.0, 3) * std::f64::consts::PI / 30.0;
        let load = 50_000.0 * at(4).powi(4);
        let width = 0.025 * between(0.1, 2.0, 5);
        let roughness = [0.0, 3e-7, 1e-6][(3.0 * at(6)) as usize];
        let seconds = (40.0 * std::f64::consts::PI / speed).clamp(0.5, 20.0);
        let of = |film: FilmModel| {
            let mut stand = Stand::default();
            stand.film.model = film;
            // As in the map, cavities have the bath's pressure.
            stand.bearing.resolution.mass_conserving = false;
            stand.thermal.isothermal = true;
            stand.load.lever_ratio = 0.0;
            stand.bearing.radial_clearance = clearance;
            stand.bearing.width = width;
            stand.bearing.surface.roughness = roughness;
            stand.oil.viscosity_scale = viscosity / 0.0187;
            stand.inputs.speed.value = speed;
            stand.inputs.external_force.value = load;
            stand.initialise(&EXPERIMENT, &mut ())?;
            stand.advance(0.0, seconds, &mut ())?;
            Ok::<_, Fault>((*stand.readings(), stand.validity()))
        };
        let films = [FilmModel::Mobility, FilmModel::Reynolds].map(of);
        print!(
            "{k}: {clearance:.1e} m, {viscosity:.1e} Pa.s, {speed:.3} rad/s, {load:.0} N, {width:.4} m, {roughness:e} m:"
        );
        for film in &films {
            match film {
                Ok((film, validity)) => {
                    print!(" {:.4} {:.4e} N.m, validity {validity};", film.eccentricity_ratio, film.friction_torque)
                }
                Err(fault) => print!(" refused: {fault};"),
            }
        }
        println!();
        if let [Ok((mobility, 0)), Ok((reynolds, 0))] = films {
            let apart = [
                mobility.friction_torque / reynolds.friction_torque - 1.0,
                mobility.min_film_thickness / reynolds.min_film_thickness - 1.0,
            ];
            assert!(apart.iter().all(|apart| apart.abs() < 0.03), "{apart:?}");
            same += 1;
        }
    }
    assert!(same >= 15, "{same}");
}
