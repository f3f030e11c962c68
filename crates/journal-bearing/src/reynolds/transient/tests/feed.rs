//! Films that are fed through grooves and holes.

use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::reynolds::{Cavitation, Diagnostics, Drive, Feed, FeedShape, FilmError, FilmSettings, ReynoldsFilm};

fn smooth(_: f64) -> f64 {
    0.0
}

/// A groove as long as most of the width, in a place where the film diverges.
fn groove() -> Feed {
    Feed {
        shape: FeedShape::Axial,
        angle: FRAC_PI_2,
        extent: 15f64.to_radians(),
        length: 0.06,
        count: 1,
        pressure: 70e3,
    }
}

/// The film whose journal rests at an eccentricity ratio, under the load that is looked for from a first one, N.
fn held(
    settings: FilmSettings,
    eps: Vector2<f64>,
    first: Vector2<f64>,
    speed: f64,
    viscosity: f64,
) -> (ReynoldsFilm, Diagnostics) {
    let mut film = ReynoldsFilm::new(settings).unwrap();
    let mut load = first;
    for _ in 0..20 {
        let drive = Drive::steady(load, speed, viscosity);
        let report = film.advance(20.0 * TAU / speed, &drive, &smooth).unwrap();
        let off = eps - film.eccentricity();
        if off.norm() < 1e-6 {
            return (film, report);
        }
        let stiffness = film.coefficients(&drive, &smooth).stiffness;
        load += stiffness * off * film.settings().clearance;
    }
    panic!("no load holds the journal at {eps}");
}

/// S. Pfeil (2025), finite volumes for Elrod's equation, 100 x 26 nodes: a journal that is held at half the clearance, a groove at
/// 70 kPa a quarter turn ahead of the smallest gap, cavities and ends at ambient pressure. Content is compared at his nodes, those at
/// the ends among them, which are full.
#[test]
fn the_field_of_a_pressurised_groove_is_pfeil_s() {
    const NODES: [usize; 2] = [100, 26];
    let speed = 3000.0 * TAU / 60.0;
    let settings = FilmSettings {
        side_pressure: 0.0,
        cells: [200, 20],
        feed: Some(groove()),
        ..FilmSettings::new(0.08, 0.1, 150e-6)
    };
    // The search begins near its end.
    let load = Vector2::new(1058.675, -1389.12);
    let (film, report) = held(settings, Vector2::new(0.5, 0.0), load, speed, 0.01);
    let grid = film.grid();
    let (mut least, mut starved) = (1.0_f64, 0);
    for column in (0..NODES[0]).map(|i| 2 * i) {
        for j in 1..NODES[1] - 1 {
            let zeta = (2.0 * j as f64 / (NODES[1] - 1) as f64 - 1.0).abs();
            let row = (0..grid.rows()).rfind(|&row| grid.zeta_edge(row) <= zeta);
            let content = film.content(column, row.unwrap());
            least = least.min(content);
            starved += usize::from(content < 1.0);
        }
    }
    let starved = starved as f64 / (NODES[0] * NODES[1]) as f64;
    let force = report.film_load.norm();
    println!(
        "{:.4} MPa, {force:.1} N, least content {least:.3}, {:.1} % not full",
        1e-6 * report.max_pressure,
        100.0 * starved
    );
    assert!((report.max_pressure / 0.5234e6 - 1.0).abs() < 0.005);
    assert!((force / 1740.0 - 1.0).abs() < 0.01);
    assert!((least - 0.551).abs() < 0.03);
    assert!((starved - 0.357).abs() < 0.02);
}

/// What comes in through the feeds leaves at the ends or fills the gap, and the energy is closed with the power of the supply.
#[test]
fn what_is_fed_leaves_or_stays() {
    let shapes = [
        groove(),
        Feed { shape: FeedShape::Hole, angle: PI, extent: 0.6, length: 0.006, count: 3, pressure: 2e5 },
        Feed { shape: FeedShape::Circumferential, length: 0.003, pressure: 1e5, ..groove() },
    ];
    for feed in shapes {
        for cavitation in [Cavitation::MassConserving, Cavitation::NonNegative] {
            for tilt in [[0.0; 2], [2e-6, 1e-6]] {
                let settings = FilmSettings {
                    cells: [64, 6],
                    cavitation,
                    tilt,
                    feed: Some(Feed { length: feed.length.min(0.015), ..feed.clone() }),
                    ..FilmSettings::new(0.019, 0.025, 20e-6)
                };
                let mut film = ReynoldsFilm::new(settings).unwrap();
                for step in 0..30 {
                    let load = |k: i32| Vector2::new(300.0 + 200.0 * (0.2 * f64::from(k)).sin(), 0.0);
                    let drive = Drive {
                        load_before: load(step),
                        load_after: load(step + 1),
                        ..Drive::steady(Vector2::zeros(), 31.4, 0.02)
                    };
                    let report = film.advance(5e-3, &drive, &smooth).unwrap();
                    let name = format!("{:?} {cavitation:?} {tilt:?} at {step}", feed.shape);
                    assert!(report.mass_error < 1e-10, "{name}: {}", report.mass_error);
                    assert!(report.energy_error < 1e-8, "{name}: {}", report.energy_error);
                }
                let report = film.advance(2.0, &Drive::steady(Vector2::new(300.0, 0.0), 31.4, 0.02), &smooth);
                let report = report.unwrap();
                let enters = report.inflow + report.feed_flow;
                if cavitation == Cavitation::MassConserving {
                    assert!((enters / report.outflow - 1.0).abs() < 1e-4, "{report:?}");
                }
                assert!(report.feed_flow > 0.0, "{report:?}");
            }
        }
    }
}

/// Around a centred journal at rest, a circumferential groove feeds two slots: `q = 2 pi D c^3 p/(12 eta l)`, l the length of a land.
#[test]
fn a_circumferential_groove_feeds_two_slots() {
    let (width, diameter, clearance, viscosity) = (0.02, 0.03, 30e-6, 0.05);
    for length in [0.002, 0.0033, 0.008] {
        let feed = Feed { shape: FeedShape::Circumferential, length, pressure: 3e5, ..Feed::default() };
        let settings = FilmSettings { feed: Some(feed), ..FilmSettings::new(width, diameter, clearance) };
        let mut film = ReynoldsFilm::new(settings).unwrap();
        let drive = Drive::steady(Vector2::zeros(), 0.0, viscosity);
        let report = film.advance(1.0, &drive, &smooth).unwrap();
        let land = 0.5 * (width - length);
        let expected = 2.0 * PI * diameter * clearance.powi(3) * 3e5 / (12.0 * viscosity * land);
        let ratio = report.feed_flow / expected;
        println!("{length}: {ratio}");
        assert!((ratio - 1.0).abs() < 0.02, "{length}: {ratio}");
        assert!((report.outflow / report.feed_flow - 1.0).abs() < 1e-9);
    }
}

/// Around a centred journal a longer groove leaves less to be sheared: the torque falls evenly with its length, wherever its ends lie
/// in the cells.
#[test]
fn shear_ends_at_the_groove() {
    let torque = |length: f64| {
        let feed = Feed { shape: FeedShape::Circumferential, length, pressure: 1e5, ..Feed::default() };
        let settings = FilmSettings { feed: Some(feed), ..FilmSettings::new(0.019, 0.025, 20e-6) };
        let mut film = ReynoldsFilm::new(settings).unwrap();
        let drive = Drive::steady(Vector2::zeros(), 31.4, 0.02);
        let report = film.advance(0.1, &drive, &smooth).unwrap();
        report.journal_torque
    };
    let whole = TAU * 0.02 * 31.4 * 0.0125_f64.powi(3) * 0.019 / 20e-6;
    for length in [0.009, 0.0098, 0.0105, 0.0113, 0.012] {
        let ratio = torque(length) / (whole * (1.0 - length / 0.019));
        println!("{length}: {ratio}");
        assert!((ratio - 1.0).abs() < 0.02, "{length}: {ratio}");
    }
}

/// A groove at the cavities' own pressure is full all the same, and feeds what the film draws in.
#[test]
fn a_groove_without_pressure_feeds() {
    let settings = FilmSettings {
        side_pressure: 0.0,
        feed: Some(Feed { pressure: 0.0, length: 0.015, angle: PI, ..groove() }),
        ..FilmSettings::new(0.019, 0.025, 20e-6)
    };
    let mut film = ReynoldsFilm::new(settings).unwrap();
    let drive = Drive::steady(Vector2::new(300.0, 0.0), 31.4, 0.02);
    let report = film.advance(3.0, &drive, &smooth).unwrap();
    println!("{:e} {:e}", report.feed_flow, report.outflow);
    assert!(report.feed_flow > 1e-8 && (report.outflow / report.feed_flow - 1.0).abs() < 1e-4);
    assert!(report.mass_error < 1e-10 && report.energy_error < 1e-8);
}

#[test]
fn edges_between_middles_count() {
    edges_count(&[0.29]);
}

#[test]
#[ignore = "takes a while: scripts/test --long"]
fn edges_between_middles_count_in_wide_and_narrow_grooves() {
    edges_count(&[0.25, 0.33]);
}

/// A finer grid hardly moves flow and journal of a groove whose edges lie between the cells' middles.
fn edges_count(extents: &[f64]) {
    let flow = |cells: [usize; 2], extent: f64| {
        let settings = FilmSettings {
            cells,
            feed: Some(Feed { extent, length: 0.0121, ..groove() }),
            ..FilmSettings::new(0.019, 0.025, 20e-6)
        };
        let mut film = ReynoldsFilm::new(settings).unwrap();
        let drive = Drive::steady(Vector2::new(400.0, 0.0), 31.4, 0.03);
        let report = film.advance(2.0, &drive, &smooth).unwrap();
        (report.feed_flow, film.eccentricity())
    };
    for &extent in extents {
        let (coarse, fine) = (flow([96, 8], extent), flow([192, 16], extent));
        println!("{extent}: {coarse:?} {fine:?}");
        assert!((coarse.0 / fine.0 - 1.0).abs() < 0.05, "{extent}");
        assert!((coarse.1 - fine.1).norm() < 5e-3, "{extent}");
    }
}

#[test]
fn impossible_feeds_are_refused() {
    let refused = |feed: Feed| {
        let settings = FilmSettings { feed: Some(feed), ..FilmSettings::new(0.08, 0.1, 150e-6) };
        match ReynoldsFilm::new(settings).map(|_| ()) {
            Err(FilmError::Setting { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    let feed = |change: fn(&mut Feed)| {
        let mut feed = groove();
        change(&mut feed);
        feed
    };
    assert_eq!(refused(feed(|f| f.pressure = -1.1e5)), "feed pressure");
    assert_eq!(refused(feed(|f| f.length = 0.08)), "feed length");
    assert_eq!(refused(feed(|f| f.extent = 0.0)), "feed extent");
    assert_eq!(refused(feed(|f| f.extent = 1e-4)), "feed extent");
    assert_eq!(refused(feed(|f| f.count = 30)), "number of feeds");
    assert_eq!(refused(feed(|f| f.length = f64::NAN)), "feed length");
}
