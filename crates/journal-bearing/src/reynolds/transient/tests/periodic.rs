//! Tests of the search for a periodic orbit.

use nalgebra::Vector2;

use crate::reynolds::{Cavitation, Drive, FilmSettings, ReynoldsFilm};

const SPEED: f64 = 31.416;
/// Thick oil, which takes long to leave the film.
const VISCOSITY: f64 = 1.5;

fn film(cavitation: Cavitation) -> ReynoldsFilm {
    let settings = FilmSettings { cavitation, cells: [48, 6], ..FilmSettings::new(0.019, 0.025, 12e-6) };
    ReynoldsFilm::new(settings).unwrap()
}

/// A turn under 750 N +- 7 % once a turn. Returns the mean torque, N.m.
fn turn(film: &mut ReynoldsFilm) -> f64 {
    const STEPS: u32 = 32;
    let duration = std::f64::consts::TAU / SPEED / f64::from(STEPS);
    let load = |step: u32| {
        let angle = std::f64::consts::TAU * f64::from(step) / f64::from(STEPS);
        Vector2::new(750.0 * (1.0 + 0.07 * angle.sin()), 0.0)
    };
    let mut torque = 0.0;
    for step in 0..STEPS {
        let drive = Drive { load_after: load(step + 1), ..Drive::steady(load(step), SPEED, VISCOSITY) };
        let report = film.advance(duration, &drive, &|_| 0.0).unwrap();
        torque += report.mean_journal_torque / f64::from(STEPS);
    }
    torque
}

/// The reference is the film itself after 200 turns.
#[test]
fn a_search_ends_where_many_turns_lead() {
    for cavitation in [Cavitation::MassConserving, Cavitation::NonNegative] {
        let mut plain = film(cavitation);
        let expected = (0..200).fold(0.0, |_, _| turn(&mut plain));
        let mut sought = film(cavitation);
        let mut search = sought.seek_orbit();
        let (mut torque, mut turns, mut moved) = (0.0, 0, f64::INFINITY);
        while moved > 1e-4 && turns < 60 {
            torque = turn(&mut sought);
            turns += 1;
            moved = sought.end_turn(&mut search);
        }
        let apart = (sought.eccentricity() - plain.eccentricity()).norm();
        println!("{cavitation:?}: {turns} turns, {apart:.1e} apart, torque {torque} {expected}");
        assert!(turns < 60, "{cavitation:?}: {turns} turns");
        assert!(apart < 1e-3, "{cavitation:?}: {apart}");
        assert!((torque / expected - 1.0).abs() < 2e-4, "{torque} {expected}");
    }
}
