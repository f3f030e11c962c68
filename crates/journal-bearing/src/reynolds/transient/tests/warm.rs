//! Films with a temperature around the bearing.

use nalgebra::Vector2;

use crate::reynolds::{Drive, Feed, FeedShape, FilmError, FilmSettings, HeatExchange, ReynoldsFilm};

fn smooth(_: f64) -> f64 {
    0.0
}

/// An oil of 20 mPa.s at 350 K that thins by 4 % a kelvin.
fn thinning(temperature: f64) -> f64 {
    0.02 * (0.04 * (350.0 - temperature)).exp()
}

fn exchange(conductance: f64) -> HeatExchange<'static> {
    HeatExchange {
        bush: 350.0,
        shaft: 350.0,
        bath: 320.0,
        feed: 310.0,
        start: 350.0,
        conductance: [conductance; 2],
        fresh: 0.8,
        capacity: 1.7e6,
        viscosity: &thinning,
    }
}

fn drive(load: f64) -> Drive {
    Drive::steady(Vector2::new(load, 0.0), 150.0, 0.02)
}

fn film(feed: Option<Feed>) -> ReynoldsFilm {
    let settings = FilmSettings { feed, ..FilmSettings::new(0.019, 0.025, 20e-6) };
    ReynoldsFilm::new(settings).unwrap()
}

/// Friction heat goes to the surfaces, to the bath, against the feed, or stays in the film: in every interval, while the load swings.
#[test]
fn no_heat_is_lost() {
    let groove = Feed {
        shape: FeedShape::Axial,
        angle: std::f64::consts::PI,
        extent: 0.4,
        length: 0.012,
        count: 1,
        pressure: 1e5,
    };
    for feed in [None, Some(groove)] {
        let mut film = film(feed);
        for k in 0..80 {
            let load = |k: i32| 700.0 + 300.0 * (0.3 * f64::from(k)).sin();
            let drive = Drive {
                load_before: Vector2::new(load(k), 0.0),
                load_after: Vector2::new(load(k + 1), 0.0),
                ..drive(0.0)
            };
            let report = film.advance_warm(1e-3, &drive, &smooth, &exchange(5.0)).unwrap();
            let given = report.given;
            let left = report.mean_heat - given.bush - given.shaft - given.bath - given.feed - given.film;
            // A squeezed film may start cold: its exchange is the scale.
            let scale = report.mean_heat + given.bush.abs() + given.film.abs();
            assert!(left.abs() < 1e-8 * scale, "{k}: {left} W of {report:?}");
            assert!(report.energy_error < 1e-8 && report.mass_error < 1e-10, "{k}: {report:?}");
        }
    }
}

/// Surfaces that take all heat hold the film at their temperature; then it is the film without a temperature of its own.
#[test]
fn cold_surfaces_hold_the_film() {
    let (mut warm, mut plain) = (film(None), film(None));
    warm.advance_warm(1.0, &drive(500.0), &smooth, &exchange(1e6)).unwrap();
    plain.advance(1.0, &drive(500.0), &smooth).unwrap();
    assert!((warm.temperature().unwrap() - 350.0).abs() < 1e-3);
    assert!((warm.eccentricity() - plain.eccentricity()).norm() < 1e-5);
}

/// The oil warms on its way into the narrow gap, is warmest there, and carries less than if it were as cold as the surfaces.
#[test]
fn oil_is_warmest_in_the_narrow_gap() {
    let (mut warm, mut plain) = (film(None), film(None));
    warm.advance_warm(1.0, &drive(800.0), &smooth, &exchange(2.0)).unwrap();
    plain.advance(1.0, &drive(800.0), &smooth).unwrap();
    let grid = warm.grid().clone();
    let hottest = (warm.temperatures().enumerate()).max_by(|a, b| a.1.total_cmp(&b.1));
    let (column, temperature) = hottest.unwrap();
    let e = warm.eccentricity();
    let behind = grid.theta_centre(column) - e.y.atan2(e.x);
    println!("{temperature} K {} degrees behind the narrowest gap", behind.to_degrees());
    assert!(temperature > 351.0 && (-0.2..1.2).contains(&behind));
    assert!(e.norm() > plain.eccentricity().norm());
}

#[test]
fn oil_that_is_not_accounted_for_has_no_heat() {
    let settings =
        FilmSettings { cavitation: crate::reynolds::Cavitation::NonNegative, ..FilmSettings::new(0.019, 0.025, 20e-6) };
    let mut film = ReynoldsFilm::new(settings).unwrap();
    let refused = film.advance_warm(1e-3, &drive(500.0), &smooth, &exchange(5.0));
    assert!(matches!(refused, Err(FilmError::Setting { name: "cavitation condition", .. })));
}
