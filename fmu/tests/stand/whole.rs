//! The stand as a whole, without FMI.

use fmu_export::model::{Access, Experiment, Fault, Kind, Log, Model, Quantity, Role};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use proptest::prelude::*;

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

/// A stand at its start.
fn start(set: impl FnOnce(&mut Stand)) -> Stand {
    let mut stand = Stand::default();
    set(&mut stand);
    stand.initialise(&NO_FILES, &mut ()).unwrap();
    stand
}

/// Its readings after `stop` seconds in communication steps of `step`.
fn run(stand: &mut Stand, stop: f64, step: f64) -> Readings {
    let steps = (stop / step).round() as usize;
    for i in 0..steps {
        stand.advance(i as f64 * step, step, &mut ()).unwrap();
    }
    *stand.readings()
}

fn relative(a: f64, b: f64) -> f64 {
    (a - b).abs() / b.abs()
}

#[test]
fn results_do_not_depend_on_the_communication_step() {
    let reference = run(&mut start(|_| ()), 20.0, 1e-3);
    for step in [1e-4, 1e-2, 1e-1, 1.0 / 60.0] {
        let other = run(&mut start(|_| ()), 20.0, step);
        for (name, get) in [
            ("F_N", (|r| r.load_force) as fn(&Readings) -> f64),
            ("M", |r| r.friction_torque),
            ("T_oil", |r| r.oil_temperature - 273.15),
            ("T_bearing", |r| r.bearing_temperature - 273.15),
            ("e", |r| r.eccentricity_ratio),
        ] {
            let difference = relative(get(&other), get(&reference));
            assert!(difference < 1e-5, "{name} at a step of {step} s differs by {difference:e}");
        }
    }
}

#[test]
fn a_leap_ends_where_the_resolved_turns_end() {
    // The rig's mixed lubrication; more of it; films that are thicker and thicker, in which the journal
    // keeps whirling; a film whose oil is renewed slowly; temperatures that stay.
    let cases: [fn(&mut Stand); 7] = [
        |_| (),
        |stand| stand.bearing.radial_clearance = 1.4e-5,
        |stand| stand.oil.viscosity_scale = 7.0,
        |stand| stand.oil.viscosity_scale = 60.0,
        |stand| {
            stand.oil.viscosity_scale = 70.0;
            stand.bearing.surface.roughness = 0.0;
            stand.thermal.film_capacity = 116.0;
            stand.thermal.film_bush = 0.1;
            stand.thermal.film_shaft = 0.3;
        },
        |stand| stand.thermal.fresh_oil = 0.1,
        |stand| stand.thermal.isothermal = true,
    ];
    for (number, case) in cases.into_iter().enumerate() {
        let set = |multirate| {
            move |stand: &mut Stand| {
                stand.solver.multirate = multirate;
                // Far from the steady state, so that the temperatures move.
                stand.thermal.initial_bearing = 330.0;
                case(stand);
            }
        };
        // A whole number of turns, and not.
        let stop = [150.0, 149.87][number % 2];
        let leaped = run(&mut start(set(true)), stop, stop);
        let resolved = run(&mut start(set(false)), stop, stop);
        // One percent of the paper's tolerances (Table 2).
        let apart = |get: fn(&Readings) -> f64| (get(&leaped) - get(&resolved)).abs();
        assert!(apart(|r| r.oil_temperature) < 0.005, "case {number}");
        assert!(apart(|r| r.bearing_temperature) < 0.00615, "case {number}");
        assert!(apart(|r| r.friction_power) < 0.03, "case {number}");
        assert!(apart(|r| r.eccentricity_ratio) < 2e-3, "case {number}");
        assert!(relative(leaped.load_force, resolved.load_force) < 1e-9, "case {number}");
    }
}

/// Under hardly any load a half-speed whirl dies away slowly, or never. No leap may leave it out: neither after a load that is taken
/// away, nor from the middle of the bearing, nor with the paper's thick oil when it is cold.
#[test]
fn no_leap_leaves_out_a_slow_whirl() {
    let light = |before: f64, force: f64, span: f64, multirate: bool| {
        let mut stand = start(|stand| {
            stand.solver.multirate = multirate;
            stand.load.lever_ratio = 0.0;
            stand.bearing.surface.roughness = 0.0;
            stand.inputs.external_force.value = before;
        });
        let unloading = if force == before { 0.0 } else { 1.0 };
        if unloading > 0.0 {
            stand.advance(0.0, unloading, &mut ()).unwrap();
            stand.inputs.external_force.value = force;
        }
        stand.advance(unloading, span, &mut ()).unwrap();
        *stand.readings()
    };
    let cold = |multirate: bool| {
        let mut stand = start(|stand| {
            stand.solver.multirate = multirate;
            stand.bearing.surface.roughness = 0.0;
            stand.oil.viscosity_scale = 70.71;
            stand.thermal.initial_bearing = 293.15;
            stand.thermal.initial_oil = 293.15;
        });
        run(&mut stand, 5.0, 5.0)
    };
    let mut cases = vec![("cold".to_owned(), [true, false].map(cold))];
    for (before, force, span) in [
        (300.0, 0.0, 30.0),
        (300.0, 0.1, 5.0),
        (300.0, 0.1, 30.0),
        (300.0, 1.0, 5.0),
        (300.0, 1.0, 30.0),
        (0.1, 0.1, 5.0),
        (1.0, 1.0, 5.0),
    ] {
        let name = format!("{before} N, {force} N, {span} s");
        cases.push((name, [true, false].map(|multirate| light(before, force, span, multirate))));
    }
    for (name, [leapt, resolved]) in cases {
        let apart = (leapt.eccentricity_ratio - resolved.eccentricity_ratio).abs();
        assert!(apart < 2e-4, "{name}: {leapt:?} {resolved:?}");
        assert!(relative(leapt.friction_power, resolved.friction_power) < 2e-4, "{name}");
        // One percent of the paper's tolerance (Table 2).
        assert!((leapt.bearing_temperature - resolved.bearing_temperature).abs() < 0.00615, "{name}");
    }
}

/// A tighter tolerance brings the leap closer to the resolved turns.
#[test]
fn a_leaps_error_follows_the_tolerance() {
    let end = |multirate: bool, tolerance: f64| {
        let mut stand = start(|stand| {
            stand.solver.multirate = multirate;
            stand.solver.tolerance = tolerance;
            stand.oil.viscosity_scale = 30.0;
            stand.thermal.initial_bearing = 330.0;
        });
        run(&mut stand, 60.0, 60.0).bearing_temperature
    };
    let exact = end(false, 1e-9);
    let error = |tolerance| (end(true, tolerance) - exact).abs();
    let (loose, tight) = (error(1e-5), error(1e-8));
    assert!(loose < 0.1 && tight < 2e-3 && tight < loose, "{loose} {tight}");
}

/// Vrublevskyi & Skonieczna (2025), Table 3: the load of every row within 0.3 N.
#[test]
fn the_load_of_every_row_of_the_papers_table() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../studies/paper/table3_solutions.csv");
    let mut rows = 0;
    for row in csv::Reader::from_path(file).unwrap().deserialize() {
        let row: std::collections::HashMap<String, f64> = row.unwrap();
        let mut stand = start(|stand| {
            stand.bearing.width = row["B_mm"] * 1e-3;
            stand.bearing.diameter = row["D_mm"] * 1e-3;
            stand.bearing.radial_clearance = row["h_mm"] * 1e-3;
            stand.load.damping = row["beta_Nspm"];
            stand.load.stiffness = row["C_Npm"];
            stand.load.preload = row["F0_N"];
            stand.load.eccentricity = row["eps_mm"] * 1e-3;
        });
        let force = run(&mut stand, 150.0, 150.0).load_force;
        assert!((force - row["F_N_N"]).abs() < 0.3, "point {}: {force} N", row["point"]);
        rows += 1;
    }
    assert_eq!(rows, 12);
}

#[test]
fn the_journal_comes_to_rest_in_mixed_lubrication() {
    let mut stand = start(|stand| stand.inputs.speed.value = 0.0);
    let readings = run(&mut stand, 20.0, 1.0);
    assert!(readings.eccentricity_ratio < 1.0);
    assert!(readings.contact_share > 0.99, "{readings:?}");
    assert_eq!(readings.friction_torque, 0.0);
}

#[test]
fn turning_backwards_mirrors_the_stand() {
    let set = |sign: f64| {
        move |stand: &mut Stand| {
            stand.inputs.speed.value *= sign;
            stand.load.eccentricity = 0.0;
        }
    };
    let forward = run(&mut start(set(1.0)), 2.0, 0.1);
    let backward = run(&mut start(set(-1.0)), 2.0, 0.1);
    assert!((forward.attitude_angle + backward.attitude_angle).abs() < 1e-9);
    assert!(relative(backward.friction_power, forward.friction_power) < 1e-9);
}

#[test]
fn friction_heat_is_the_drives_work() {
    // Constant load, so that the journal comes to rest and no work goes into moving it.
    let mut stand = start(|stand| {
        stand.load.eccentricity = 0.0;
        stand.thermal.isothermal = true;
    });
    let readings = run(&mut stand, 5.0, 0.5);
    let work = readings.friction_torque * readings.shaft_speed;
    assert!(relative(stand.heat(), work) < 1e-5, "{} W, {work} W", stand.heat());
}

#[test]
fn a_restored_state_continues_bit_for_bit() {
    for &film in FilmModel::ALL {
        let mut stand = start(|stand| stand.film.model = film);
        run(&mut stand, 0.1, 0.01);
        let bytes = stand.save().unwrap();
        let expected = run(&mut stand, 0.05, 0.01);
        let mut other = Stand::default();
        other.restore(&bytes).unwrap();
        assert_eq!(run(&mut other, 0.05, 0.01), expected);
        let before = other.save().unwrap();
        assert!(other.restore(&bytes[..bytes.len() / 2]).is_err());
        assert_eq!(other.save().unwrap(), before);
    }
}

/// The end of a tilted journal touches the smooth bush in the middle of the step, after steps of the film that went well.
/// A clone does not know the rates where the last step ended, and computes them anew, whatever has changed since.
#[test]
fn rates_taken_over_from_the_last_step_are_those_computed_anew() {
    let mut stand = start(|stand| stand.drive.fluctuation_amplitude = 0.025);
    for step in 0..40 {
        match step % 5 {
            1 => stand.inputs.speed.value += 1.0,
            2 => stand.inputs.external_force.slope = 1e3,
            3 => {
                stand.oil.viscosity_scale *= 1.01;
                stand.update().unwrap();
            }
            _ => (),
        }
        let mut anew = stand.clone();
        for stand in [&mut stand, &mut anew] {
            stand.advance(f64::from(step) * 1e-3, 1e-3, &mut ()).unwrap();
        }
        assert_eq!(stand.readings(), anew.readings(), "step {step}");
    }
}

#[test]
fn a_failed_step_leaves_the_film_as_it_was() {
    let mut stand = start(|stand| {
        stand.film.model = FilmModel::Reynolds;
        (stand.bearing.resolution.columns, stand.bearing.resolution.rows) = (48, 4);
        stand.bearing.surface.roughness = 0.0;
        stand.bearing.resolution.tilt[0] = 8e-6;
    });
    run(&mut stand, 2e-3, 1e-3);
    let mut untouched = stand.clone();
    let fault = stand.advance(2e-3, 0.5, &mut ()).unwrap_err();
    assert!(fault.to_string().contains("bearing.roughness"), "{fault}");
    assert_eq!(stand.readings(), untouched.readings());
    for stand in [&mut stand, &mut untouched] {
        stand.advance(2e-3, 1e-3, &mut ()).unwrap();
    }
    assert_eq!(stand.readings(), untouched.readings());
}

#[test]
fn rates_are_those_of_the_outputs() {
    for &film in FilmModel::ALL {
        let mut stand = start(|stand| stand.film.model = film);
        run(&mut stand, 0.1, 0.01);
        stand.differentiate().unwrap();
        for get in [
            (|r| r.shaft_angle) as fn(&Readings) -> f64,
            |r| r.load_force,
            |r| r.film_temperature,
            |r| r.friction_torque,
            |r| r.max_film_pressure,
        ] {
            let rate = get(stand.rates());
            let mut ahead = stand.clone();
            let [begin, end] = [0.1, 0.1 + 1e-5].map(|time| {
                ahead.advance(time, 1e-5, &mut ()).unwrap();
                get(ahead.readings())
            });
            let expected = (end - begin) / 1e-5;
            assert!((rate - expected).abs() < 1e-2 * expected.abs() + 1e-3, "{rate} {expected}");
        }
    }
}

/// Hosts look for algebraic loops between coupled FMUs by these dependencies, at the start and later.
#[test]
fn outputs_follow_at_once_only_the_inputs_that_they_name() {
    for (film, time) in [
        (FilmModel::Mobility, 0.0),
        (FilmModel::Mobility, 0.1),
        (FilmModel::Reynolds, 0.0),
        (FilmModel::Reynolds, 0.02),
    ] {
        let configured = |set: &dyn Fn(&mut Stand)| {
            start(|stand| {
                stand.film.model = film;
                if time == 0.0 {
                    set(stand);
                }
            })
        };
        let readings = |stand: &Stand| {
            let outputs = Stand::variables().iter().filter(|v| v.role == Role::Output);
            Vec::from_iter(outputs.filter_map(|variable| match &variable.kind {
                Kind::Real(Quantity { access, .. }) => Some((variable, (access.get)(stand))),
                _ => None,
            }))
        };
        let mut stand = configured(&|_| ());
        run(&mut stand, time, 0.01);
        for input in Stand::variables().iter().filter(|v| v.role == Role::Input) {
            let Kind::Real(Quantity { access: Access { get, set: Some(set) }, .. }) = input.kind else {
                unreachable!("{} is no Real", input.name);
            };
            let other = 1.3 * get(&stand) + 7.0;
            let mut changed = configured(&|stand| set(stand, &other));
            if time > 0.0 {
                changed = stand.clone();
                set(&mut changed, &other);
                changed.update().unwrap();
            }
            for ((variable, before), (_, after)) in readings(&stand).into_iter().zip(readings(&changed)) {
                let named = variable.depends_on.contains(&input.name);
                assert!(named || before == after, "{} follows {}", variable.name, input.name);
            }
        }
    }
}

struct Messages(Vec<String>);

impl Log for Messages {
    fn log(&mut self, category: &'static str, message: std::fmt::Arguments<'_>) {
        self.0.push(format!("{category}: {message}"));
    }
}

/// A speed that swings by half of itself once a turn heats the film too unevenly for a leap.
#[test]
fn the_log_says_why_there_is_no_leap() {
    let mut stand = start(|stand| {
        stand.drive.fluctuation_amplitude = 0.5;
        stand.drive.fluctuation_frequency = 5.0;
    });
    let mut log = Messages(Vec::new());
    stand.advance(0.0, 4.0, &mut log).unwrap();
    let said = "logEvents: no leap over 18 turns, they are resolved: the fluctuation of the speed swings";
    assert!(log.0.len() > 1 && log.0[1].starts_with(said), "{:?}", log.0);
}

/// The asperities carry all of this load, and hold the journal so stiffly that a turn takes tens of thousands of explicit steps: a
/// leap takes implicit ones, and comes to what resolved turns come to.
#[test]
fn a_stiff_contact_leaps() {
    let loaded = |multirate: bool| {
        let mut stand = start(|stand| {
            stand.solver.multirate = multirate;
            stand.bearing.surface.roughness = 1e-5;
            stand.bearing.radial_clearance = 1e-4;
            stand.load.preload = 3e3;
        });
        let mut log = Messages(Vec::new());
        stand.advance(0.0, 3.0, &mut log).unwrap();
        assert_eq!(log.0[0].contains("in a leap"), multirate, "{:?}", log.0);
        *stand.readings()
    };
    let [leapt, resolved] = [true, false].map(loaded);
    let warmer = leapt.bearing_temperature - resolved.bearing_temperature;
    assert!(warmer.abs() < 0.0375, "{warmer} K");
    let torque = leapt.friction_torque / resolved.friction_torque;
    assert!((torque - 1.0).abs() < 2e-4, "{torque}");
}

#[test]
fn the_log_tells_what_is_done() {
    let mut log = Messages(Vec::new());
    let mut stand = Stand::default();
    stand.initialise(&NO_FILES, &mut log).unwrap();
    stand.advance(0.0, 0.5, &mut log).unwrap();
    stand.advance(0.5, 50.0, &mut log).unwrap();
    let told = [
        "set up at 0.0 s: Mobility film",
        "0.5 s from 0.0 s with every turn resolved",
        "the journal does not rest at 0.5 s",
        "50.0 s from 0.5 s in a leap",
    ];
    assert_eq!(log.0.len(), told.len(), "{:?}", log.0);
    for (message, told) in log.0.iter().zip(told) {
        assert!(message.starts_with(&format!("logEvents: {told}")), "{message}");
    }
}

/// Both film models under the rig's load. In the full film of a journal that is heavily loaded, mass
/// conservation matters little; without it, hardly anything differs but the grid.
#[test]
fn both_film_models_agree_over_the_cycle() {
    let mobility = run(&mut start(|_| ()), 0.4, 0.02);
    let resolved = run(&mut start(|stand| stand.film.model = FilmModel::Reynolds), 0.4, 0.02);
    assert!(relative(resolved.eccentricity_ratio, mobility.eccentricity_ratio) < 0.01);
    assert!(relative(resolved.friction_torque, mobility.friction_torque) < 0.03);
    assert!(relative(resolved.max_film_pressure, mobility.max_film_pressure) < 0.05);
}

#[test]
fn form_error_and_tilt_reach_the_film() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("profile.csv");
    let rows: String =
        (0..72).map(|i| format!("{},{},0\n", 5 * i, 4.0 * (2.0 * f64::from(5 * i).to_radians()).cos())).collect();
    std::fs::write(&file, format!("angle,bush,journal\n{rows}")).unwrap();
    let film = |stand: &mut Stand| stand.film.model = FilmModel::Reynolds;
    let plain = run(&mut start(film), 0.05, 0.01);
    let tilted = run(
        &mut start(|stand| {
            film(stand);
            stand.bearing.resolution.tilt[0] = 5e-6;
        }),
        0.05,
        0.01,
    );
    let formed = run(
        &mut start(|stand| {
            film(stand);
            stand.bearing.profile_file = file.to_str().unwrap().into();
        }),
        0.05,
        0.01,
    );
    assert!(tilted.min_film_thickness < plain.min_film_thickness);
    assert!(relative(formed.min_film_thickness, plain.min_film_thickness) > 0.05);
}

/// The cavities' absolute pressure sets how far the bath, at ambient pressure, is above them.
#[test]
fn cavities_have_an_absolute_pressure() {
    let end = |set: fn(&mut Stand)| {
        let film = |stand: &mut Stand| {
            stand.film.model = FilmModel::Reynolds;
            stand.bearing.surface.roughness = 0.0;
            stand.load.eccentricity = 0.0;
            stand.thermal.isothermal = true;
            set(stand);
        };
        // Until the journal is at rest, its squeezing drives the side flow.
        run(&mut start(film), 2.0, 0.5)
    };
    let vacuum = end(|_| ());
    let same = end(|stand| stand.bearing.resolution.cavity_pressure = 1325.0);
    assert_eq!(same, vacuum);
    let ambient = end(|stand| stand.bearing.resolution.cavity_pressure = 101_325.0);
    let level = end(|stand| stand.bearing.resolution.side_pressure = 0.0);
    assert_eq!(ambient, level);
    // The bath presses oil into the film, which carries it out again.
    let gas = end(|stand| stand.bearing.resolution.cavity_pressure = 90e3);
    let flows = [vacuum, gas, ambient].map(|readings| readings.side_flow);
    assert!(flows.is_sorted_by(|more, less| more > less), "{flows:?}");
}

#[test]
fn impossible_parameters_are_named() {
    let mut stand = Stand::default();
    stand.bearing.radial_clearance = -1e-5;
    let Err(Fault::Invalid(message)) = stand.initialise(&NO_FILES, &mut ()) else {
        panic!("accepted");
    };
    assert!(message.starts_with("bearing.radialClearance = -1e-5 m"), "{message}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn any_bearing_stays_finite(
        clearance in -5.3..-4.0f64,
        width_to_diameter in 0.2..1.6f64,
        viscosity in -1.0..2.0f64,
        roughness in prop_oneof![Just(0.0), 1e-7..5e-6f64],
        speed in prop_oneof![Just(0.0), -300.0..300.0f64],
        force in -5e3..5e3f64,
        eccentricity in 0.0..2e-3f64,
    ) {
        let mut stand = start(|stand| {
            stand.bearing.radial_clearance = 10f64.powf(clearance);
            stand.bearing.width = width_to_diameter * stand.bearing.diameter;
            stand.oil.viscosity_scale = 10f64.powf(viscosity);
            stand.bearing.surface.roughness = roughness;
            stand.inputs.speed.value = speed;
            stand.inputs.external_force.value = force;
            stand.load.eccentricity = eccentricity;
        });
        for i in 0..5 {
            stand.advance(0.01 * i as f64, 0.01, &mut ()).unwrap();
            let r = stand.readings();
            // The mean planes of rough surfaces may cross.
            let crossing = 6.0 * roughness / 10f64.powf(clearance);
            prop_assert!(r.eccentricity_ratio < 1.0 + crossing);
            prop_assert!([r.friction_torque, r.film_temperature, r.bearing_temperature, r.attitude_angle]
                .iter()
                .all(|value| value.is_finite()), "{r:?}");
        }
    }
}

/// Within such a step rounding moves the journal more than the film does.
#[test]
fn a_vanishing_step_of_a_transient_film_changes_nothing() {
    let mut stand = start(|stand| stand.film.model = FilmModel::Reynolds);
    let before = run(&mut stand, 2e-3, 1e-3);
    for step in [5e-324, 1e-310, 1e-16] {
        stand.advance(2e-3, step, &mut ()).unwrap();
        let now = *stand.readings();
        assert_eq!(before.friction_torque, now.friction_torque);
        assert_eq!(before.max_film_pressure, now.max_film_pressure);
        assert_eq!(before.eccentricity_ratio, now.eccentricity_ratio);
    }
    // The next step goes on from there.
    let mut untouched = start(|stand| stand.film.model = FilmModel::Reynolds);
    run(&mut untouched, 2e-3, 1e-3);
    for stand in [&mut stand, &mut untouched] {
        stand.advance(2e-3, 1e-3, &mut ()).unwrap();
    }
    // The shaft has turned by the rest of the time, some 1e-15 rad.
    let torques = [&stand, &untouched].map(|stand| stand.readings().friction_torque);
    assert!(relative(torques[0], torques[1]) < 1e-12, "{torques:?}");
}

#[test]
fn messages_write_numbers_shortly() {
    let mut stand = start(|_| ());
    stand.inputs.speed.slope = 1e300;
    let fault = stand.advance(0.0, 1e-200, &mut ()).unwrap_err();
    let text = fault.to_string();
    assert!(text.contains("over 1e-200 s would take drive.speed to 1e100"), "{text}");
    assert!(text.len() < 250, "{text}");
}

#[test]
fn rates_that_cannot_be_computed_are_a_fault() {
    for &film in FilmModel::ALL {
        let mut stand = start(|stand| stand.film.model = film);
        run(&mut stand, 2e-3, 1e-3);
        stand.inputs.speed.slope = 1e12;
        let fault = stand.differentiate().unwrap_err();
        assert!(fault.to_string().contains("no time derivatives"), "{fault}");
        stand.inputs.speed.slope = 0.0;
        stand.differentiate().unwrap();
    }
}
