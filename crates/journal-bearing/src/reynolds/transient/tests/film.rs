//! Tests of motion, friction, contact and geometry.

use nalgebra::Vector2;

use crate::{
    contact::Surface,
    mobility::{MobilityMap, SliceFamily},
    reynolds::{Boundary, Cavitation, Drive, FilmError, FilmSettings, QuasiStatic, ReynoldsFilm, RoughFilm},
};

/// The bearing of a test stand, 19 x 25 mm with 20 um of clearance; the tests use oil of 0.02 Pa.s.
fn stand(cavitation: Cavitation) -> ReynoldsFilm {
    let settings = FilmSettings { cavitation, ..FilmSettings::new(0.019, 0.025, 20e-6) };
    ReynoldsFilm::new(settings).unwrap()
}

const SPEED: f64 = 31.416;
const VISCOSITY: f64 = 0.02;

fn smooth(_: f64) -> f64 {
    0.0
}

/// An independent grid-converged solution of this case has eccentricity ratio 0.891, a smallest gap of 2.2 um and a torque
/// of 0.019 N.m in the full film.
#[test]
fn the_stand_at_rest() {
    let drive = Drive::steady(Vector2::new(750.0, 0.0), SPEED, VISCOSITY);
    let mut film = stand(Cavitation::NonNegative);
    let report = film.advance(1.5, &drive, &smooth).unwrap();
    let e = film.eccentricity();
    assert!((e.norm() - 0.891).abs() < 1e-3, "{e}");
    assert!((film.smallest_gap() - 2.2e-6).abs() < 0.05e-6);
    assert!((report.journal_torque - 0.019).abs() < 2e-4);
    assert!((report.film_load - drive.load_after).norm() < 1e-3);

    // With conserved mass the film is shorter: nearly the same position, but less oil to shear.
    let mut conserving = stand(Cavitation::MassConserving);
    let report = conserving.advance(1.5, &drive, &smooth).unwrap();
    assert!((conserving.eccentricity().norm() / e.norm() - 1.0).abs() < 0.01);
    assert!(report.journal_torque < 0.019);
    assert!((report.inflow / report.outflow - 1.0).abs() < 1e-3);
}

/// Under 750 N +- 20 % once a turn, mass is conserved and energy balances in every step, and both films and the mobility
/// method follow nearly the same orbit.
#[test]
fn the_stand_s_cycle() {
    let load = |t: f64| Vector2::new(750.0 * (1.0 + 0.2 * (SPEED * t).sin()), 0.0);
    let map = SliceFamily::new(&MobilityMap::built_in().unwrap());
    let slice = map.slice(0.76);
    let mut films = [stand(Cavitation::NonNegative), stand(Cavitation::MassConserving)];
    let mut eps = Vector2::new(0.85, 0.3);
    for film in &mut films {
        film.place(eps).unwrap();
    }
    let step = 2e-3;
    for k in 0..300 {
        let t = step * f64::from(k);
        let drive = Drive {
            load_before: load(t),
            load_after: load(t + step),
            ..Drive::steady(Vector2::zeros(), SPEED, VISCOSITY)
        };
        for film in &mut films {
            let report = film.advance(step, &drive, &smooth).unwrap();
            assert!(report.mass_error < 1e-10, "{} at {t}", report.mass_error);
            assert!(report.energy_error < 1e-8, "{} at {t}", report.energy_error);
        }
        // The mobility method (Booker 1965), by the classical Runge-Kutta method.
        let psi = 20e-6 / 0.0125_f64;
        let rate = |eps: Vector2<f64>, t: f64| {
            let scale = load(t).norm() * psi * psi / (VISCOSITY * 0.019 * 0.025);
            slice.mobility_vector(eps, Vector2::new(1.0, 0.0)) * scale + Vector2::new(-eps.y, eps.x) * (0.5 * SPEED)
        };
        let parts = 20;
        let h = step / f64::from(parts);
        for part in 0..parts {
            let t = t + h * f64::from(part);
            let a = rate(eps, t);
            let b = rate(eps + a * (0.5 * h), t + 0.5 * h);
            let c = rate(eps + b * (0.5 * h), t + 0.5 * h);
            let d = rate(eps + c * h, t + h);
            eps += (a + b * 2.0 + c * 2.0 + d) * (h / 6.0);
        }
        // In the last turn.
        if t > 0.4 {
            let [free, conserving] = [0, 1].map(|k: usize| films[k].eccentricity().norm());
            assert!((free / eps.norm() - 1.0).abs() < 2e-3, "{t}: {free} {}", eps.norm());
            assert!((conserving / free - 1.0).abs() < 0.01, "{t}: {free} {conserving}");
        }
    }
}

#[test]
fn a_snapshot_continues_bit_for_bit() {
    let drive = Drive::steady(Vector2::new(300.0, -80.0), -12.0, 0.03);
    let mut film = stand(Cavitation::MassConserving);
    film.advance(0.013, &drive, &smooth).unwrap();
    let bytes = postcard::to_stdvec(&film).unwrap();
    let mut again: ReynoldsFilm = postcard::from_bytes(&bytes).unwrap();
    let [one, two] = [&mut film, &mut again].map(|film| film.advance(0.02, &drive, &smooth));
    assert_eq!(one, two);
    assert_eq!(film.eccentricity(), again.eccentricity());
    let [one, two] = [&film, &again].map(|film| postcard::to_stdvec(film).unwrap());
    assert_eq!(one, two);
}

/// A vanishing tilt and a profile without deviation change nothing.
#[test]
fn a_vanishing_tilt_and_form_error_change_nothing() {
    let drive = Drive::steady(Vector2::new(300.0, 0.0), SPEED, VISCOSITY);
    let place = |change: &dyn Fn(&mut FilmSettings)| {
        let mut settings = FilmSettings { cells: [48, 6], ..FilmSettings::new(0.019, 0.025, 20e-6) };
        change(&mut settings);
        let mut film = ReynoldsFilm::new(settings).unwrap();
        film.advance(0.1, &drive, &smooth).unwrap();
        film.eccentricity()
    };
    let plain = place(&|_| {});
    let tilted = place(&|settings| settings.tilt = [1e-13, 0.0]);
    let round = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    let formed = place(&|settings| {
        settings.profile = crate::profile::Profile::new(&round).unwrap();
    });
    assert!((tilted - plain).norm() < 1e-4, "{tilted} {plain}");
    assert!((formed - plain).norm() < 2e-3, "{formed} {plain}");
    let leaning = place(&|settings| settings.tilt = [6e-6, 0.0]);
    assert!(leaning.norm() < plain.norm() - 0.01, "{leaning} {plain}");
}

/// In mixed lubrication, asperities evaluated cell by cell carry the force of the aligned journal's table.
#[test]
fn asperities_cell_by_cell_agree_with_the_aligned_journal_s() {
    use crate::contact::ContactTable;
    let surface = Surface::default();
    let table = ContactTable::new(&surface, 20e-6, 0.019, 0.025);
    let drive = Drive::steady(Vector2::new(750.0, 0.0), 5.0, VISCOSITY);
    let mut settings = FilmSettings::new(0.019, 0.025, 20e-6);
    let mut by_table = ReynoldsFilm::new(settings.clone()).unwrap();
    by_table.advance(1.0, &drive, &|e| table.at(e).force).unwrap();
    settings.asperities = Some(surface);
    let mut by_cell = ReynoldsFilm::new(settings).unwrap();
    let report = by_cell.advance(1.0, &drive, &smooth).unwrap();
    let [a, b] = [by_table.eccentricity(), by_cell.eccentricity()];
    assert!((a - b).norm() < 2e-3, "{a} {b}");
    let normal = table.at(b.norm()).normal;
    assert!((report.contact_normal / normal - 1.0).abs() < 0.02);
    assert!(report.film_load.x < 700.0);
}

/// Roughness resists sliding the more, the thinner the film is relative to it; and energy balances whichever surface is
/// rough.
#[test]
fn roughness_raises_the_film_s_friction() {
    let drive = Drive::steady(Vector2::new(750.0, 0.0), 10.0, VISCOSITY);
    let torque = |roughness: f64, rough_film: RoughFilm| {
        let surface = Surface { roughness, ..Surface::default() };
        let mut film = ReynoldsFilm::new(FilmSettings {
            asperities: Some(surface),
            rough_film,
            cells: [64, 6],
            ..FilmSettings::new(0.019, 0.025, 20e-6)
        })
        .unwrap();
        let report = film.advance(1.0, &drive, &smooth).unwrap();
        assert!(report.energy_error < 1e-8, "{}", report.energy_error);
        report.journal_torque
    };
    let factors = |journal_share| RoughFilm::FlowFactors { journal_share };
    for rough_film in [factors(0.5), RoughFilm::MeanGap] {
        let ratio = |roughness| torque(roughness, rough_film) / torque(roughness, RoughFilm::Nominal);
        let [fine, medium, coarse] = [1e-9, 0.2e-6, 0.4e-6].map(ratio);
        assert!((fine - 1.0).abs() < 1e-5, "{fine}");
        assert!(medium > 1.0 && coarse > medium, "{medium} {coarse}");
    }
    for share in [0.0, 1.0] {
        torque(0.4e-6, factors(share));
    }
}

/// The torque of a heavily loaded film, ruptured behind its narrowest place, hardly depends on the grid or on the direction
/// of rotation. An independent solution on 96, 192 and 384 even columns extrapolates to 0.0392 N.m.
#[test]
fn ruptured_oil_is_sheared_on_few_cells() {
    let torque = |columns: usize, speed: f64| {
        let mut film =
            ReynoldsFilm::new(FilmSettings { cells: [columns, 8], ..FilmSettings::new(0.025, 0.025, 20e-6) }).unwrap();
        film.place(Vector2::new(0.93, 0.27 * speed.signum())).unwrap();
        let drive = Drive::steady(Vector2::new(3700.0, 0.0), speed, VISCOSITY);
        film.advance(0.3, &drive, &smooth).unwrap().journal_torque
    };
    let [coarse, fine, back] = [(96, SPEED), (384, SPEED), (96, -SPEED)].map(|(columns, speed)| torque(columns, speed));
    assert!((coarse / fine - 1.0).abs() < 0.003, "{coarse} {fine}");
    assert!((coarse / 0.0392 - 1.0).abs() < 0.005, "{coarse}");
    assert!((back / coarse + 1.0).abs() < 1e-6, "{coarse} {back}");
}

/// In a full film between round surfaces, shear contributes Sommerfeld's torque (1904) and pressure half the moment of the
/// load about the bush's centre, also on few cells.
#[test]
fn a_full_film_has_sommerfeld_s_friction() {
    for load in [750.0, 3700.0] {
        let mut film = stand(Cavitation::NonNegative);
        film.place(Vector2::new(0.93, 0.27)).unwrap();
        let drive = Drive::steady(Vector2::new(load, 0.0), SPEED, VISCOSITY);
        let torque = film.advance(0.3, &drive, &smooth).unwrap().journal_torque;
        let e = film.eccentricity();
        let couette = std::f64::consts::TAU * VISCOSITY * SPEED * 0.0125_f64.powi(3) * 0.019
            / (20e-6 * (1.0 - e.norm_squared()).sqrt());
        let expected = couette + 0.5 * 20e-6 * load * e.y;
        assert!((torque / expected - 1.0).abs() < 1e-5, "{torque} {expected} at {e}");
    }
}

/// The smallest gap of a tilted journal is at its very end, not in the middle of the last cells. When that end meets a smooth
/// bush, the error names the remedy.
#[test]
fn a_tilted_journal_is_nearest_at_its_end() {
    let tilted = |tilt: f64| {
        let settings = FilmSettings::new(0.019, 0.025, 20e-6);
        ReynoldsFilm::new(FilmSettings { tilt: [tilt, 0.0], cells: [48, 4], ..settings }).unwrap()
    };
    for tilt in [4e-6, -4e-6] {
        let mut film = tilted(tilt);
        film.place(Vector2::new(0.3, 0.4)).unwrap();
        let expected = 20e-6 * (1.0 - (0.5_f64 * 0.5 + 0.4 * 0.4).sqrt());
        assert!((film.smallest_gap() / expected - 1.0).abs() < 1e-9);
    }
    let drive = Drive::steady(Vector2::new(750.0, 0.0), SPEED, VISCOSITY);
    let mut film = tilted(8e-6);
    let error = film.advance(0.5, &drive, &smooth).unwrap_err();
    assert!(matches!(error, FilmError::Touches(_)), "{error}");
    assert!(error.to_string().contains("give the surfaces a roughness"));
}

/// A film whose clearance changes comes to rest where one that always had that clearance does. A clearance that leaves a tilted
/// journal no room is refused, and changes nothing.
#[test]
fn a_film_takes_another_clearance() {
    let drive = Drive::steady(Vector2::new(750.0, 0.0), SPEED, VISCOSITY);
    let mut film = stand(Cavitation::MassConserving);
    film.advance(1.5, &drive, &smooth).unwrap();
    film.set_clearance(26e-6).unwrap();
    film.advance(1.5, &drive, &smooth).unwrap();
    let settings = FilmSettings::new(0.019, 0.025, 26e-6);
    let mut other = ReynoldsFilm::new(settings).unwrap();
    other.advance(1.5, &drive, &smooth).unwrap();
    let apart = (film.eccentricity() - other.eccentricity()).norm();
    assert!(apart < 1e-4, "{apart}");
    assert!((film.smallest_gap() / other.smallest_gap() - 1.0).abs() < 2e-3);

    let tilted = FilmSettings { tilt: [8e-6, 0.0], ..FilmSettings::new(0.019, 0.025, 20e-6) };
    let mut film = ReynoldsFilm::new(tilted).unwrap();
    let before = film.smallest_gap();
    assert!((before - 12e-6).abs() < 1e-9, "{before}");
    film.set_clearance(16e-6).unwrap();
    assert!((film.smallest_gap() - 8e-6).abs() < 1e-9);
    for closed in [7e-6, 0.0, f64::NAN] {
        film.set_clearance(closed).unwrap_err();
        assert!((film.smallest_gap() - 8e-6).abs() < 1e-9);
    }
}

/// Numbers that no bearing has are refused at once, by name, and leave the film as it was.
#[test]
fn a_drive_that_cannot_be_is_refused() {
    let mut film = stand(Cavitation::MassConserving);
    let usual = Drive::steady(Vector2::new(750.0, 0.0), SPEED, VISCOSITY);
    let nan = f64::NAN;
    let with = |change: fn(&mut Drive, f64), value| {
        let mut drive = usual;
        change(&mut drive, value);
        drive
    };
    let at = film.eccentricity();
    for (interval, drive, told) in [
        (0.0, usual, "the film's interval is 0.0; it must be at least 1e-250 s"),
        (5e-324, usual, "the film's interval is 5e-324; it must be at least 1e-250 s"),
        (-0.1, usual, "the film's interval is -0.1; it must be at least 1e-250 s"),
        (nan, usual, "the film's interval is NaN; it must be at least 1e-250 s"),
        (
            1e-3,
            with(|drive, value| drive.viscosity = value, -0.02),
            "the film's viscosity is -0.02; it must be a positive number",
        ),
        (
            1e-3,
            with(|drive, value| drive.load_after.y = value, nan),
            "the film's load is NaN; it must be a finite number",
        ),
        (
            1e-3,
            with(|drive, value| drive.journal_speed = value, nan),
            "the film's speed of the journal is NaN; it must be a finite number",
        ),
    ] {
        let refused = film.advance(interval, &drive, &smooth).map_err(|error| error.to_string());
        assert_eq!(refused.err().as_deref(), Some(told));
        assert_eq!(film.eccentricity(), at);
    }
    let settings = |change: fn(&mut FilmSettings)| {
        let mut settings = FilmSettings::new(0.019, 0.025, 20e-6);
        change(&mut settings);
        ReynoldsFilm::new(settings).err().map(|error| error.to_string())
    };
    let few = settings(|settings| settings.cells = [3, 4]);
    let told = "the film's number of columns is 3.0; it must be at least 4";
    assert_eq!(few.as_deref(), Some(told));
    let tilted = settings(|settings| settings.tilt = [0.0, f64::NAN]);
    let told = "the film's tilt is NaN; it must be a finite number";
    assert_eq!(tilted.as_deref(), Some(told));
    let pressed = settings(|settings| settings.side_pressure = -1.0);
    let told = "the film's side pressure is -1.0; it must be 0 or more";
    assert_eq!(pressed.as_deref(), Some(told));
}

/// Lets the journal come to rest.
fn rest(film: &mut ReynoldsFilm, load: Vector2<f64>) -> Vector2<f64> {
    let drive = Drive::steady(load, SPEED, VISCOSITY);
    for _ in 0..40 {
        film.advance(2.0, &drive, &smooth).unwrap();
    }
    film.eccentricity() * film.settings().clearance
}

/// Stiffness tells the differences of resting places, and damping by how much the journal stays behind a load that grows
/// slowly: by `B K^-1` times the rate in force.
#[test]
fn coefficients_tell_resting_places_and_slow_motions() {
    const PUSH: f64 = 0.02;
    let load = Vector2::new(200.0, 0.0);
    for cavitation in [Cavitation::NonNegative, Cavitation::MassConserving] {
        let mut film = stand(cavitation);
        let resting = rest(&mut film, load);
        let all = film.coefficients(&Drive::steady(load, SPEED, VISCOSITY), &smooth);
        for towards in [Vector2::x(), Vector2::y()] {
            let push = PUSH * towards;
            let places = [push, -push].map(|push| rest(&mut film.clone(), load + push));
            let answer = all.stiffness * (places[0] - places[1]) * 0.5;
            assert!((answer - push).norm() < 1e-5 * PUSH, "{cavitation:?}: {answer}");

            let (mut film, interval, count) = (film.clone(), 0.01, 200);
            for k in 0..count {
                let grown = [k, k + 1].map(|k| load + push * (f64::from(k) / f64::from(count)));
                let drive =
                    Drive { load_before: grown[0], load_after: grown[1], ..Drive::steady(load, SPEED, VISCOSITY) };
                film.advance(interval, &drive, &smooth).unwrap();
            }
            let rate = push / (interval * f64::from(count));
            let behind = all.damping * (all.stiffness.try_inverse().unwrap() * rate);
            let moved = film.eccentricity() * film.settings().clearance - resting;
            let answer = push - all.stiffness * moved;
            assert!((answer - behind).norm() < 0.02 * behind.norm(), "{cavitation:?}: {answer}, {behind}");
        }
    }
}

/// Without memory both films are the same, up to how they see a cell's gap; the quasi-static one's coefficients are checked
/// against published ones.
#[test]
fn coefficients_are_those_of_the_quasi_static_film() {
    let load = Vector2::new(200.0, 0.0);
    let mut film = stand(Cavitation::NonNegative);
    rest(&mut film, load);
    let all = film.coefficients(&Drive::steady(load, SPEED, VISCOSITY), &smooth);
    let width_to_diameter = 0.019 / 0.025;
    let mut other = QuasiStatic::new(film.grid().clone(), width_to_diameter, Boundary::Free);
    other.place(film.eccentricity());
    let (_, other) = other.coefficients(0.5 * SPEED).unwrap();
    let scale = film.settings().force_scale(VISCOSITY) / film.settings().clearance;
    for (one, other) in [(all.stiffness, other.stiffness), (all.damping, other.damping)] {
        assert!((one - other * scale).norm() < 2e-3 * one.norm(), "{one} {other}");
    }
}
