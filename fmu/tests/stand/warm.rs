//! The stand whose film has a temperature around the bearing.

use fmu_export::model::{Experiment, Fault, Model};
use plain_bearing_stand::bearing::{FilmEnergy, FilmModel};
use plain_bearing_stand::stand::Stand;
use plain_bearing_stand::thermal::Initialization;

fn stand(energy: FilmEnergy) -> Stand {
    let mut stand = Stand::default();
    stand.film.model = FilmModel::Reynolds;
    stand.bearing.resolution.energy = energy;
    stand
}

#[test]
fn films_without_heat_of_their_own_refuse() {
    for (change, remedy) in [
        ((|stand| stand.film.model = FilmModel::Mobility) as fn(&mut Stand), "bearing.film = Reynolds"),
        (|stand| stand.bearing.resolution.mass_conserving = false, "bearing.massConserving = true"),
        (|stand| stand.thermal.isothermal = true, "thermal.isothermal = false"),
    ] {
        let mut stand = stand(FilmEnergy::Circumferential);
        change(&mut stand);
        let refused = stand.initialise(&Experiment::default(), &mut ());
        let Err(Fault::Invalid(why)) = refused else {
            panic!("{refused:?}");
        };
        assert!(why.contains("bearing.filmEnergy") && why.contains(remedy), "{why}");
    }
}

/// What friction heats beyond what leaves to the surroundings is stored.
#[test]
fn the_stand_s_energy_is_closed() {
    let mut stand = stand(FilmEnergy::Circumferential);
    stand.initialise(&Experiment::default(), &mut ()).unwrap();
    stand.advance(0.0, 0.2, &mut ()).unwrap();
    let before = *stand.readings();
    let (mut heat, mut lost) = (0.0, 0.0);
    // Whole turns, after which the film holds the same heat as before.
    let (turns, steps) = (5, 200);
    let step = 0.2 / f64::from(steps);
    for k in 0..turns * steps {
        let time = 0.2 + f64::from(k) * step;
        stand.advance(time, step, &mut ()).unwrap();
        heat += step * stand.heat();
        lost += step * stand.readings().ambient_heat_flow;
    }
    let (after, thermal) = (stand.readings(), &stand.thermal);
    let gained = thermal.bush_capacity * (after.bearing_temperature - before.bearing_temperature)
        + thermal.shaft_capacity * (after.shaft_temperature - before.shaft_temperature)
        + before.oil_bath_capacity * (after.oil_temperature - before.oil_temperature);
    println!("heat {heat} J, lost {lost} J, stored {gained} J");
    assert!((heat - lost - gained).abs() < 2e-3 * heat);
}

#[test]
fn the_steady_start_of_few_columns_knows_the_warm_film() {
    warm_start([48, 4]);
}

/// Prints what the temperature around the bearing changes on the rig.
#[test]
#[ignore = "takes a while: scripts/test --long"]
fn the_steady_start_knows_the_warm_film() {
    // 0: as many columns and rows as the width needs.
    warm_start([0, 0]);
}

/// The steady start stays where it is.
fn warm_start(cells: [i32; 2]) {
    let of = |energy: FilmEnergy| {
        let mut stand = stand(energy);
        [stand.bearing.resolution.columns, stand.bearing.resolution.rows] = cells;
        stand.thermal.initialization = Initialization::SteadyState;
        let begun = std::time::Instant::now();
        stand.initialise(&Experiment::default(), &mut ()).unwrap();
        let took = begun.elapsed();
        let start = *stand.readings();
        for k in 0..10 {
            stand.advance(0.2 * f64::from(k), 0.2, &mut ()).unwrap();
        }
        let [end, means] = [stand.readings().bearing_temperature, stand.means()[1]];
        println!(
            "{energy:?}: bush {:.3} K, film {:.3} K, oil {:.3} K, torque {means:.5} N.m, film thickness {:.4} um, started in {took:?}",
            start.bearing_temperature,
            start.film_temperature,
            start.oil_temperature,
            1e6 * start.min_film_thickness,
        );
        assert!((end - start.bearing_temperature).abs() < 1e-3, "{energy:?}");
    };
    of(FilmEnergy::Lumped);
    of(FilmEnergy::Circumferential);
}
