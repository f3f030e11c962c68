//! The check by ISO 7902.

use fmu_export::model::{Experiment, Model};
use plain_bearing_stand::bearing::FilmModel;
use plain_bearing_stand::stand::Stand;
use std::f64::consts::{PI, TAU};

/// A smooth bearing of this width, diameter and clearance, m, under a load, N, at a speed, rpm, with oil of this viscosity, Pa.s.
fn bearing([width, diameter, clearance]: [f64; 3], [load, rpm, viscosity]: [f64; 3]) -> Stand {
    let mut stand = Stand::default();
    stand.thermal.isothermal = true;
    stand.load.lever_ratio = 0.0;
    stand.bearing.surface.roughness = 0.0;
    (stand.bearing.width, stand.bearing.diameter, stand.bearing.radial_clearance) = (width, diameter, clearance);
    stand.inputs.external_force.value = load;
    stand.inputs.speed.value = rpm * PI / 30.0;
    let probe = after(1e-4, stand.clone()).readings().film_viscosity;
    stand.oil.viscosity_scale = viscosity / probe;
    stand
}

fn after(seconds: f64, mut stand: Stand) -> Stand {
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand.advance(0.0, seconds, &mut ()).unwrap();
    stand
}

/// Textbooks, which read Raimondi & Boyd's table and charts; their S is 1/(2 pi So).
///
/// U. C. Jindal, Machine Design, examples 17-2 (60 mm by 60 mm, clearance 0.04 mm, 6,000 N, 1,260 rpm; S 0.0446 and a film of 0.008 mm
/// need 6.293 mPa.s) and 17-5 (96 mm by 96 mm, 22 kN, 960 rpm, 20 mPa.s; at S 0.0446 the film is 0.0166 mm), to their digits. Shigley,
/// Mechanical Engineering Design, example 12-1 (1.5 in by 1.5 in, clearance 0.0015 in, 500 lbf, 30 rev/s, 4 ureyn; 222 psi, S 0.135, and
/// from a chart 0.00063 in, eccentricity ratio 0.58), one off in the chart's last digits.
#[test]
fn textbooks_examples_come_out_to_their_digits() {
    let run = |size: [f64; 3], at: [f64; 3]| {
        let stand = after(2.0, bearing(size, at));
        let (told, readings) = (stand.operation(), *stand.readings());
        (told.specific_load, 1.0 / (TAU * told.sommerfeld), readings.min_film_thickness, readings.eccentricity_ratio)
    };
    let (p, s, film, _) = run([0.06, 0.06, 40e-6], [6000.0, 1260.0, 6.293e-3]);
    let told = format!("{:.3} MPa, S {s:.4}, {:.3} mm", p / 1e6, film * 1e3);
    println!("Jindal 17-2: {told}");
    assert_eq!(told, "1.667 MPa, S 0.0446, 0.008 mm");

    let clearance = 48e-3 * (0.02_f64 * 16.0 / (0.0446 * 22e3 / 0.096_f64.powi(2))).sqrt();
    let (p, s, film, _) = run([0.096, 0.096, clearance], [22e3, 960.0, 0.02]);
    let told = format!("{:.3} MPa, S {s:.4}, {:.4} mm", p / 1e6, film * 1e3);
    println!("Jindal 17-5: {told}");
    assert_eq!(told, "2.387 MPa, S 0.0446, 0.0166 mm");

    const INCH: f64 = 0.0254;
    const PSI: f64 = 6894.757;
    let size = [1.5 * INCH, 1.5 * INCH, 0.0015 * INCH];
    let (p, s, film, ratio) = run(size, [500.0 * 4.448_222, 1800.0, 4e-6 * PSI]);
    println!("Shigley 12-1: {:.0} psi, S {s:.3}, {:.5} in, {ratio:.2}", p / PSI, film / INCH);
    assert_eq!(format!("{:.0} {s:.3}", p / PSI), "222 0.135");
    assert!((film / INCH - 0.00063).abs() < 1.5e-5 && (ratio - 0.58).abs() < 0.015);
}

/// At the speed that is told, the film of a smooth bearing has the thickness at which mixed friction begins, in both films.
#[test]
fn the_film_at_the_transition_speed_has_the_transition_s_thickness() {
    for model in [FilmModel::Mobility, FilmModel::Reynolds] {
        for gap in [1e-6, 8e-6] {
            let mut stand = bearing([0.0125, 0.025, 20e-6], [500.0, 1000.0, 0.02]);
            stand.film.model = model;
            stand.bearing.resolution.mass_conserving = false;
            stand.permitted.transition_gap = gap;
            stand.inputs.speed.value = after(1e-3, stand.clone()).operation().transition_speed;
            let stand = after(2.0, stand);
            let (film, told) = (stand.readings().min_film_thickness, stand.operation());
            assert!((film / gap - 1.0).abs() < 5e-3, "{model:?} {gap}: {film}");
            // The bush's speed draws in as much.
            let mut shared = stand.clone();
            shared.inputs.bush_speed.value = 0.5 * stand.inputs.speed.value;
            shared.inputs.speed.value *= 0.5;
            let shared = after(1e-3, shared).operation();
            assert!((shared.transition_speed / told.transition_speed - 1.0).abs() < 1e-9);
        }
    }
}

/// Butenschoen's numbers (1976, dissertation, Karlsruhe), from which the standard's function was fitted, as the tests of mboct-mbdyn-pkg
/// quote them. His film begins where the gap is widest, which only a wide bearing under a light load feels.
#[test]
fn the_sommerfeld_number_at_the_transition_is_the_tabulated_one() {
    let table = [
        (0.2, [0.2518, 0.0783, 0.0210, 0.0054]),
        (0.4, [0.6108, 0.2026, 0.0560, 0.0144]),
        (0.6, [1.3146, 0.4982, 0.1476, 0.0390]),
        (0.8, [3.5663, 1.7339, 0.6043, 0.1706]),
        (0.9, [8.4352, 5.0881, 2.1595, 0.6776]),
        (0.95, [18.7895, 13.3083, 6.9248, 2.5202]),
        (0.99, [107.7868, 93.7881, 70.0359, 39.2568]),
    ];
    for (k, slenderness) in [1.0, 0.5, 0.25, 0.125].into_iter().enumerate() {
        let mut stand = bearing([0.1 * slenderness, 0.1, 1e-4], [1e3, 1000.0, 0.02]);
        for (e, tabulated) in table {
            stand.permitted.transition_gap = 1e-4 * (1.0 - e);
            let told = after(1e-4, stand.clone()).operation();
            let sommerfeld = told.sommerfeld * stand.inputs.speed.value / told.transition_speed;
            let (bound, digit) = (if e < 0.4 { 0.013 } else { 0.006 }, 5e-5);
            let apart = (sommerfeld - tabulated[k]).abs();
            println!("B/D {slenderness}, e {e}: So {sommerfeld:.4} for {}", tabulated[k]);
            assert!(apart < bound * tabulated[k] + digit, "B/D {slenderness}, {e}: {sommerfeld} {}", tabulated[k]);
        }
    }
}

/// Each criterion decides where it is the worst, and what the standard does not cover is not safe.
#[test]
fn what_is_worst_decides() {
    let good = bearing([0.06, 0.06, 40e-6], [6000.0, 1260.0, 0.02]);
    let decides = |change: &dyn Fn(&mut Stand)| {
        let mut stand = good.clone();
        change(&mut stand);
        let told = after(1.0, stand).operation();
        (told.decides, told.margin)
    };
    let (.., margin) = decides(&|_| ());
    assert!(margin > 1.0, "{margin}");
    type Change<'a> = &'a dyn Fn(&mut Stand);
    let criteria: [(i32, Change<'_>); 4] = [
        (1, &|stand| stand.permitted.specific_load = 1e6),
        (2, &|stand| stand.oil.viscosity_scale *= 0.15),
        (3, &|stand| stand.thermal.initial_bearing = 373.15),
        (4, &|stand| {
            stand.permitted.transition_gap = 16e-6;
            stand.oil.viscosity_scale *= 0.5;
        }),
    ];
    for (criterion, change) in criteria {
        let (decided, margin) = decides(change);
        assert_eq!(decided, criterion, "{margin}");
        assert!(margin < 1.0, "{criterion}: {margin}");
    }
    let outside: [&dyn Fn(&mut Stand); 4] = [
        &|stand| stand.bearing.diameter = 0.0239,
        &|stand| stand.inputs.speed.value = 0.0,
        &|stand| stand.inputs.external_force.value = 0.0,
        &|stand| (stand.bearing.radial_clearance, stand.oil.viscosity_scale) = (4e-3, 1e-3),
    ];
    for (k, change) in outside.into_iter().enumerate() {
        assert_eq!(decides(change), (5, 0.0), "{k}");
    }
}

/// The table's ends: a diameter or a speed at the end of a row or column belongs to it.
#[test]
fn the_least_film_thickness_follows_size_and_speed() {
    for (diameter, speed, limit) in [
        (0.024, 0.5, 3e-6),
        (0.063, 3.0, 4e-6),
        (0.0631, 3.01, 7e-6),
        (0.12, 12.57, 9e-6),
        (0.4, 30.1, 14e-6),
        (2.5, 1.1, 12e-6),
    ] {
        let mut stand = bearing([0.5 * diameter, diameter, 1e-3 * diameter], [1e3, 60.0, 0.02]);
        stand.inputs.speed.value = 2.0 * speed / diameter;
        let told = after(1e-4, stand.clone()).operation();
        assert!((told.gap_limit / limit - 1.0).abs() < 1e-9, "{diameter} {speed}: {}", told.gap_limit);
        stand.bearing.surface.roughness = 6e-6;
        assert!((after(1e-4, stand).operation().gap_limit - limit.max(18e-6)).abs() < 1e-12);
    }
}

/// Under the rig's load, which swings, the largest of the last turn counts, whatever the communication step.
#[test]
fn the_worst_of_the_last_turn_counts() {
    let mut rig = Stand::default();
    rig.thermal.isothermal = true;
    rig.initialise(&Experiment::default(), &mut ()).unwrap();
    let area = rig.bearing.width * rig.bearing.diameter;
    let (mut long, mut least, mut most) = (rig.clone(), f64::INFINITY, 0.0_f64);
    for k in 0..800 {
        rig.advance(f64::from(k) * 5e-4, 5e-4, &mut ()).unwrap();
        if k >= 400 {
            least = least.min(rig.readings().min_film_thickness);
            most = most.max(rig.readings().load_force);
        }
    }
    long.advance(0.0, 0.4, &mut ()).unwrap();
    let (told, at_once) = (rig.operation(), long.operation());
    assert!((told.specific_load * area / most - 1.0).abs() < 1e-3, "{} {most}", told.specific_load * area);
    assert!((at_once.specific_load / told.specific_load - 1.0).abs() < 2e-3);
    assert_eq!(told.decides, 4);
    assert!(most > 1.05 * rig.means()[0] && least > 0.0);
}
