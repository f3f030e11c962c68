//! The steady start: `thermal.initialization = SteadyState`.

use fmu_export::model::{Experiment, Fault, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::sensors::Readings;
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::thermal::Initialization;
use std::f64::consts::TAU;

const NO_FILES: Experiment<'static> = Experiment { start: 0.0, stop: None, tolerance: None, resources: None };

fn start(mut stand: Stand, initialization: Initialization) -> Stand {
    stand.thermal.initialization = initialization;
    stand.initialise(&NO_FILES, &mut ()).unwrap();
    stand
}

/// The temperatures of film, bush, shaft and oil, K.
fn temperatures(r: &Readings) -> [f64; 4] {
    [r.film_temperature, r.bearing_temperature, r.shaft_temperature, r.oil_temperature]
}

/// The time after which speed and load repeat themselves.
fn period(stand: &Stand) -> f64 {
    let speed = stand.inputs.speed.value.abs();
    f64::from(stand.drive.common_turns(speed).unwrap()) * TAU / speed
}

/// Means over the period that follows.
fn means<const N: usize>(stand: &mut Stand, begin: f64, get: impl Fn(&Readings) -> [f64; N]) -> [f64; N] {
    const PARTS: usize = 400;
    let step = period(stand) / PARTS as f64;
    let mut sums = [0.0; N];
    for i in 0..PARTS {
        stand.advance(begin + i as f64 * step, step, &mut ()).unwrap();
        for (sum, value) in sums.iter_mut().zip(get(stand.readings())) {
            *sum += value / PARTS as f64;
        }
    }
    sums
}

/// Numbers between 0 and 1 that look random: the additive recurrence of Roberts (2018) in fifteen dimensions.
fn draw(number: usize) -> impl FnMut(f64, f64) -> f64 {
    // The root of x^16 = x + 1.
    const ROOT: f64 = 1.0457510242;
    let mut place = 0;
    move |from, to| {
        place += 1;
        let x = (0.5 + number as f64 * ROOT.powi(-place)).fract();
        from + x * (to - from)
    }
}

/// A stand with parameters far from those of the rig, but with smaller masses, so that its slowest time constant is some
/// minutes.
fn random(number: usize) -> Stand {
    let mut draw = draw(number);
    let mut stand = Stand::default();
    stand.bearing.radial_clearance = draw(1.2e-5, 3.5e-5);
    stand.bearing.surface.roughness = draw(0.0, 6e-6);
    stand.oil.viscosity_scale = 10f64.powf(draw(-0.3, 1.5));
    stand.inputs.speed.value = draw(15.0, 80.0);
    stand.load.preload = draw(25.0, 80.0);
    stand.load.eccentricity = draw(0.0, 1e-3);
    stand.thermal.film_capacity = 10f64.powf(draw(0.0, 1.5));
    stand.thermal.bush_capacity = draw(5.0, 40.0);
    stand.thermal.shaft_capacity = draw(5.0, 40.0);
    stand.thermal.oil_volume = draw(1e-5, 5e-5);
    stand.thermal.fresh_oil = draw(0.0, 1.0);
    stand.thermal.oil_ambient = draw(0.3, 2.0);
    stand.thermal.bush_ambient = draw(0.0, 0.5);
    stand.thermal.initial_bearing = draw(300.0, 370.0);
    stand.thermal.initial_oil = draw(295.0, 340.0);
    stand
}

/// The same with a speed that fluctuates, and repeats itself after four turns.
fn fluctuating(number: usize) -> Stand {
    let mut stand = random(number);
    stand.drive.fluctuation_amplitude = draw(number)(0.02, 0.3);
    stand.drive.fluctuation_frequency = 0.25 * stand.inputs.speed.value / TAU;
    stand
}

/// The steady start of a stand against a run with every turn resolved, over twenty time constants.
fn check_against_resolved_turns(number: usize, stand: Stand) {
    let mut given = stand.clone();
    let mut steady = start(stand, Initialization::SteadyState);
    let slowest = steady.slowest_time_constant();
    given.solver.multirate = false;
    given.solver.tolerance = 1e-8;
    let mut given = start(given, Initialization::Given);
    let period = period(&given);
    let turns = (20.0 * slowest / period).ceil();
    let mut time = 0.0;
    for _ in 0..20 {
        let step = (turns / 20.0).ceil() * period;
        given.advance(time, step, &mut ()).unwrap();
        time += step;
    }
    let expected = means(&mut given, time, temperatures);
    let reached = means(&mut steady, 0.0, temperatures);
    for (mean, expected) in reached.into_iter().zip(expected) {
        assert!((mean - expected).abs() < 1e-5, "set {number}: {mean} K, {expected} K");
    }
}

#[test]
fn the_steady_start_is_where_resolved_turns_end() {
    for number in [1, 2] {
        check_against_resolved_turns(number, random(number));
    }
}

#[test]
#[ignore = "takes a minute: scripts/test --long"]
fn ten_steady_starts_are_where_resolved_turns_end() {
    for number in 1..=10 {
        check_against_resolved_turns(number, random(number));
        check_against_resolved_turns(number, fluctuating(number));
    }
}

#[test]
fn the_steady_start_of_a_fluctuating_speed_is_where_resolved_turns_end() {
    check_against_resolved_turns(3, fluctuating(3));
}

/// Table 2 of the paper: the rig's measured values and their accuracies.
#[test]
fn the_rigs_steady_state_is_the_measured_one() {
    let mut stand = start(Stand::default(), Initialization::SteadyState);
    let [force, torque, coefficient, oil, bearing] = means(&mut stand, 0.0, |r| {
        [
            r.load_force,
            r.friction_torque,
            r.friction_coefficient,
            r.oil_temperature - 273.15,
            r.bearing_temperature - 273.15,
        ]
    });
    assert!((force - 750.0).abs() < 0.01 * 750.0, "{force}");
    assert!((torque - 0.443).abs() < 0.01 * 0.443, "{torque}");
    assert!((coefficient - 0.046).abs() < 0.002, "{coefficient}");
    assert!((oil - 48.0).abs() < 0.05, "{oil}");
    assert!((bearing - 82.0).abs() < 0.1, "{bearing}");
}

/// A small deviation shrinks by e in the slowest time constant, or grows by e where that is negative.
#[test]
fn deviations_decay_with_the_slowest_time_constant() {
    let stand = start(Stand::default(), Initialization::SteadyState);
    let time_constant = stand.slowest_time_constant();
    let steady = *stand.readings();
    let mut given = Stand::default();
    given.solver.tolerance = 1e-8;
    given.thermal.initial_bearing = steady.bearing_temperature + 1.0;
    given.thermal.initial_oil = steady.oil_temperature + 1.0;
    let mut given = start(given, Initialization::Given);
    let span = 0.2 * (5.0 * time_constant).round();
    let mut deviations = Vec::new();
    for i in 0..4 {
        given.advance(f64::from(i) * span, span, &mut ()).unwrap();
        deviations.push(given.readings().bearing_temperature - steady.bearing_temperature);
    }
    println!("{time_constant} {deviations:?} {}", span / (deviations[2] / deviations[3]).ln());
    let slowest = span / (deviations[2] / deviations[3]).ln();
    assert!((slowest / time_constant - 1.0).abs() < 0.02, "{slowest} {time_constant}");
}

/// It follows from the state, and not from when it was read before: a stand brought back to a saved state reads the same.
#[test]
fn the_slowest_time_constant_follows_from_the_state_alone() {
    let mut stand = Stand::default();
    stand.bearing.wear.coefficient = 1e-12;
    let mut stand = start(stand, Initialization::Given);
    for i in 0..30 {
        stand.advance(0.013 * f64::from(i), 0.013, &mut ()).unwrap();
        let read_before = stand.slowest_time_constant();
        // A clone remembers nothing.
        assert_eq!(read_before, stand.clone().slowest_time_constant(), "{i}");
    }
}

/// Boundary friction of 0.105 on smoother surfaces: around 85 degC it grows by more watts per kelvin than the losses.
fn bistable(celsius: f64) -> Stand {
    let mut stand = Stand::default();
    stand.bearing.surface.boundary_friction = 0.105;
    stand.bearing.surface.roughness = 2.4e-6;
    stand.thermal.initial_bearing = 273.15 + celsius;
    stand
}

/// The reference is a long run from the given temperatures.
#[test]
fn of_several_equilibria_the_given_temperatures_choose() {
    let mut temperatures = Vec::new();
    for celsius in [50.0, 105.0, 120.0] {
        let steady = start(bistable(celsius), Initialization::SteadyState);
        let mut given = start(bistable(celsius), Initialization::Given);
        for i in 0..10 {
            given.advance(1e4 * f64::from(i), 1e4, &mut ()).unwrap();
        }
        let steady = steady.readings().bearing_temperature;
        let expected = given.readings().bearing_temperature;
        assert!((steady - expected).abs() < 0.02, "{steady} {expected}");
        temperatures.push(steady);
    }
    assert!(temperatures[0] < 310.0 && temperatures[1] > 380.0, "{temperatures:?}");
    assert!((temperatures[1] - temperatures[2]).abs() < 1e-5, "{temperatures:?}");
}

#[test]
fn isothermal_temperatures_stay_and_the_journal_is_on_its_orbit() {
    let mut stand = Stand::default();
    stand.thermal.isothermal = true;
    let mut stand = start(stand, Initialization::SteadyState);
    assert_eq!(temperatures(stand.readings()), [355.15, 355.15, 355.15, 321.15]);
    assert_eq!(stand.slowest_time_constant(), 0.0);
    let before = stand.readings().eccentricity_ratio;
    stand.advance(0.0, period(&stand), &mut ()).unwrap();
    let after = stand.readings().eccentricity_ratio;
    assert!((after - before).abs() < 1e-5, "{before} {after}");
}

/// Point 96 of paper-table3.toml: in thick oil the journal whirls at half the shaft's speed, and hardly forgets where it was.
#[test]
fn a_whirling_journal_is_on_its_orbit_too() {
    let mut stand = Stand::default();
    stand.solver.tolerance = 1e-9;
    stand.bearing.surface.roughness = 0.0;
    stand.bearing.radial_clearance = 8.875e-6;
    stand.load.eccentricity = 3.54e-4;
    stand.oil.viscosity_scale = 70.71;
    stand.thermal.fresh_oil = 0.0;
    stand.thermal.film_capacity = 116.0;
    stand.thermal.film_bush = 0.1034;
    stand.thermal.film_shaft = 0.2951;
    stand.thermal.bush_oil = 0.02625;
    stand.thermal.shaft_oil = 0.39;
    let mut stand = start(stand, Initialization::SteadyState);
    let before = *stand.readings();
    stand.advance(0.0, period(&stand), &mut ()).unwrap();
    let after = *stand.readings();
    for (before, after) in temperatures(&before).into_iter().zip(temperatures(&after)) {
        assert!((before - after).abs() < 1e-7, "{before} K, {after} K");
    }
    let place = |r: &Readings| r.eccentricity_ratio * r.attitude_angle.sin();
    assert!((place(&before) - place(&after)).abs() < 1e-6);
    assert!((before.eccentricity_ratio - after.eccentricity_ratio).abs() < 1e-6);
}

fn refusal(set: impl FnOnce(&mut Stand)) -> String {
    let mut stand = Stand::default();
    stand.thermal.initialization = Initialization::SteadyState;
    set(&mut stand);
    match stand.initialise(&NO_FILES, &mut ()) {
        Err(Fault::Invalid(why)) => why,
        other => unreachable!("{other:?}"),
    }
}

#[test]
fn a_refusal_names_its_cause() {
    let no_loss = |stand: &mut Stand| stand.thermal.oil_ambient = 0.0;
    assert!(refusal(no_loss).contains("no heat can leave: thermal.bushAmbientConductance"));
    let still = |stand: &mut Stand| stand.inputs.speed.value = 0.0;
    assert!(refusal(still).contains("drive.speed is 0"));
    let swinging = |stand: &mut Stand| {
        stand.drive.fluctuation_amplitude = 0.025;
        stand.drive.fluctuation_frequency = 0.5 * std::f64::consts::SQRT_2;
    };
    assert!(refusal(swinging).contains("drive.fluctuationFrequency = 0.707"));
    let thin = |stand: &mut Stand| {
        stand.bearing.surface.roughness = 0.0;
        stand.oil.viscosity_scale = 1e-3;
        stand.bearing.radial_clearance = 3e-4;
    };
    let why = refusal(thin);
    assert!(why.contains("check oil.viscosityScale: it is 0.001"), "{why}");
    let insulated = |stand: &mut Stand| stand.thermal.oil_ambient = 1e-3;
    let why = refusal(insulated);
    assert!(why.contains("still warming") && why.contains("thermal.oilAmbientConductance"), "{why}");
}

/// The longest time constant of the start values' conductances (58, 58, 0.126, 0.127 and 0.532 W/K) and capacities (2, 200
/// and 200 J/K, 0.3 l of oil at 22 degC), s: from the eigenvalues of their matrix, by numpy.
const NETWORK: f64 = 2734.36;

/// The slowest time constant in a state that is not steady, and where friction grows faster than the losses.
#[test]
fn the_time_constant_of_any_state() {
    let time_constant = |celsius| start(bistable(celsius), Initialization::Given).slowest_time_constant();
    assert!(time_constant(31.0) > 1000.0);
    assert!(time_constant(65.0) < -1000.0);
    let mut still = Stand::default();
    still.inputs.speed.value = 0.0;
    still.thermal.initial_bearing = 295.15;
    still.thermal.initial_oil = 295.15;
    // Without friction heat: the network's own, from its conductances and capacities.
    let network = start(still, Initialization::Given).slowest_time_constant();
    assert!((network / NETWORK - 1.0).abs() < 1e-3, "{network}");
}

/// A period of the Reynolds film from its steady start stores nothing: less than 1e-6 of the friction power.
fn check_the_turn_of_a_reynolds_film(number: usize, mut stand: Stand) {
    stand.film.model = FilmModel::Reynolds;
    let mut stand = start(stand, Initialization::SteadyState);
    let before = temperatures(stand.readings());
    let period = period(&stand);
    stand.advance(0.0, period, &mut ()).unwrap();
    let after = temperatures(stand.readings());
    // Cragoe (1929).
    let celsius = after[3] - 273.15;
    let heat_capacity = (1685.0 + 3.4 * celsius) / (stand.oil.density_15 / 999.1).sqrt();
    let capacities = [
        stand.thermal.film_capacity,
        stand.thermal.bush_capacity,
        stand.thermal.shaft_capacity,
        stand.thermal.oil_volume * stand.oil.density_15 * heat_capacity,
    ];
    let stored: f64 = (0..4).map(|i| (capacities[i] * (after[i] - before[i])).abs()).sum();
    let power = stand.readings().friction_power;
    assert!(power > 0.1, "set {number}: {power} W");
    assert!(stored / period < 1e-6 * power, "set {number}: {} of {power} W", stored / period);
}

#[test]
fn the_turn_of_a_reynolds_film_is_balanced() {
    check_the_turn_of_a_reynolds_film(10, random(10));
}

#[test]
#[ignore = "takes minutes: scripts/test --long"]
fn ten_turns_of_reynolds_films_are_balanced() {
    for number in 1..=10 {
        check_the_turn_of_a_reynolds_film(number, random(number));
        check_the_turn_of_a_reynolds_film(number, fluctuating(number));
    }
}

/// Asperities carry a heavy load where the surfaces' mean planes cross: the eccentricity ratio is beyond 1 then. What the drive
/// does leaves as heat.
#[test]
fn rough_surfaces_that_cross_are_steady_too() {
    for load in [1.4e4, 1.5e4, 2e4] {
        let mut stand = Stand::default();
        stand.load.lever_ratio = 0.0;
        stand.load.eccentricity = 0.0;
        stand.thermal.bush_ambient = 5.0;
        stand.inputs.external_force.value = load;
        let stand = start(stand, Initialization::SteadyState);
        let r = stand.readings();
        assert_eq!(r.eccentricity_ratio > 1.0, load > 1.4e4, "{load} N");
        assert!((r.friction_power / r.ambient_heat_flow - 1.0).abs() < 1e-5, "{load} N");
    }
}
