//! Tests of the film with compressible oil.

use nalgebra::Vector2;
use std::f64::consts::TAU;

use crate::{
    reynolds::{Cavitation, Drive, FilmSettings, ReynoldsFilm},
    rheology::{DensityLaw, Rheology},
};

fn settings(width: f64, density: DensityLaw) -> FilmSettings {
    FilmSettings {
        rheology: Rheology { density_law: density, ..Rheology::default() },
        ..FilmSettings::new(width, 0.025, 20e-6)
    }
}

/// The pressure (1/s) around an infinitely wide bearing with mean rotation `rotation`, whose journal stays in place. The flow
/// `rho (omega H - H^3 P')` is the same at every angle. The classical Runge-Kutta method integrates the pressure from zero at
/// the angle `start`; bisection finds the start at which the pressure returns to zero after one turn, its least value.
fn wide_bearing(e: f64, rotation: f64, density: impl Fn(f64) -> f64) -> Vec<f64> {
    let parts = 4000;
    let d = TAU / f64::from(parts);
    let gap = |angle: f64| 1.0 + e * angle.cos();
    let around = |start: f64| {
        let slope = |angle: f64, p: f64| rotation * (gap(angle) - gap(start) / density(p)) / gap(angle).powi(3);
        let mut p = vec![0.0];
        for k in 0..parts {
            let (angle, now) = (start + d * f64::from(k), p[p.len() - 1]);
            let a = slope(angle, now);
            let b = slope(angle + 0.5 * d, now + 0.5 * d * a);
            let c = slope(angle + 0.5 * d, now + 0.5 * d * b);
            let f = slope(angle + d, now + d * c);
            p.push(now + d * (a + 2.0 * b + 2.0 * c + f) / 6.0);
        }
        p
    };
    // The start lies upstream of the widest gap; the farther upstream, the more oil flows.
    let (mut near, mut far) = (-0.5 * TAU, 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if around(middle).last() > Some(&0.0) {
            near = middle;
        } else {
            far = middle;
        }
    }
    around(0.5 * (near + far))
}

fn largest(p: &[f64]) -> f64 {
    p.iter().copied().fold(0.0, f64::max)
}

/// Sommerfeld (1904): the pressure of an incompressible film is `6 eta omega_j (R/c)^2 e sin phi (2 + e cos phi) /
/// ((2 + e^2)(1 + e cos phi)^2)` plus a constant.
#[test]
fn the_reference_is_sommerfelds() {
    let e = 0.6_f64;
    let p = |angle: f64| {
        let h = 1.0 + e * angle.cos();
        e * angle.sin() * (2.0 + e * angle.cos()) / ((2.0 + e * e) * h * h)
    };
    let range = (0..10_000).map(|k| p(TAU * f64::from(k) / 1e4));
    let range = range.fold([0.0_f64; 2], |[a, b], p| [a.min(p), b.max(p)]);
    let rise = largest(&wide_bearing(e, 2.0, |_| 1.0));
    assert!((rise / (2.0 * (range[1] - range[0])) - 1.0).abs() < 1e-4);
}

/// Compares a bearing seventy times as wide as its diameter, at 280 MPa, with the infinitely wide one at the same
/// eccentricity. With `p >= 0` both films fill the whole ring. The ends' influence reaches far, hence the width.
#[test]
fn a_wide_bearing_has_the_reference_s_pressure() {
    let (speed, viscosity) = (300.0, 0.2);
    let width = 70.0 * 0.025;
    for law in [DensityLaw::Constant, DensityLaw::DowsonHigginson] {
        let settings = FilmSettings { cavitation: Cavitation::NonNegative, cells: [192, 8], ..settings(width, law) };
        let unit = settings.pressure_scale(viscosity);
        let mut film = ReynoldsFilm::new(settings).unwrap();
        let load = Vector2::new(150e6 * width * 0.025, 0.0);
        let drive = Drive::steady(load, speed, viscosity);
        let report = film.advance(3.0, &drive, &|_| 0.0).unwrap();
        assert!(report.velocity.norm() < 1e-4, "{}", report.velocity);
        assert!(report.energy_error < 1e-7, "{}", report.energy_error);
        let e = film.eccentricity().norm();
        let reference = |law: DensityLaw| {
            let p = wide_bearing(e, 0.5 * speed, |p| law.ratio(p * unit)[0]);
            largest(&p) * unit
        };
        let ratio = report.max_pressure / reference(law);
        assert!((ratio - 1.0).abs() < 5e-4, "{law:?}: {ratio}");
        // The effect of the density must be well above the tolerance.
        let effect = reference(DensityLaw::Constant) / reference(law) - 1.0;
        assert!(law == DensityLaw::Constant || effect > 0.007, "{effect}");
    }
}

/// Under 50 MPa +- 50 %, mass is conserved and energy balances with what the compression stores and returns.
#[test]
fn a_heavy_cycle_conserves_mass_and_energy() {
    let speed = 300.0_f64;
    let mut film = ReynoldsFilm::new(settings(0.019, DensityLaw::DowsonHigginson)).unwrap();
    let load = |t: f64| Vector2::new(25e3 * (1.0 + 0.5 * (speed * t).sin()), 0.0);
    let step = 5e-4;
    for k in 0..100 {
        let t = step * f64::from(k);
        // The oil warms, so the unit of the dimensionless pressure changes from step to step.
        let viscosity = 0.1 - 0.5 * t;
        let drive = Drive {
            load_before: load(t),
            load_after: load(t + step),
            ..Drive::steady(Vector2::zeros(), speed, viscosity)
        };
        let report = film.advance(step, &drive, &|_| 0.0).unwrap();
        assert!(report.mass_error < 1e-10, "{} at {t}", report.mass_error);
        assert!(report.energy_error < 1e-7, "{} at {t}", report.energy_error);
    }
}

#[test]
fn a_snapshot_of_compressed_oil_continues_bit_for_bit() {
    let drive = Drive::steady(Vector2::new(20e3, -8e3), 200.0, 0.1);
    let mut film = ReynoldsFilm::new(settings(0.019, DensityLaw::DowsonHigginson)).unwrap();
    film.advance(0.013, &drive, &|_| 0.0).unwrap();
    let bytes = postcard::to_stdvec(&film).unwrap();
    let mut again: ReynoldsFilm = postcard::from_bytes(&bytes).unwrap();
    let drive = Drive::steady(Vector2::new(20e3, -8e3), 200.0, 0.07);
    let [one, two] = [&mut film, &mut again].map(|film| film.advance(0.02, &drive, &|_| 0.0));
    assert_eq!(one, two);
    assert_eq!(film.eccentricity(), again.eccentricity());
}
