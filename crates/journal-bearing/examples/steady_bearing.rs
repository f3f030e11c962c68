//! A plain bearing under steady loads: where its journal runs, and what that costs.
//!
//!     cargo run --release -p journal-bearing --example steady_bearing
//!
//! For a row of loads it prints the Sommerfeld number; eccentricity ratio and attitude angle by three films: the mobility
//! method, the Reynolds equation with `p >= 0`, and the Reynolds equation with mass-conserving cavitation; and of the last,
//! smallest gap, largest pressure, friction coefficient and oil flow.
//!
//! The first two agree with the tables of Raimondi & Boyd (1958) but for the attitude angle, about two degrees, since in
//! those the pressure is zero where the gap is widest. The
//! mass-conserving film has no supply groove here: oil enters only at the ends, from a bath 1 bar above the cavities. It runs
//! starved at light loads, closer to the load line. Change the constants to your bearing.

use std::error::Error;
use std::f64::consts::TAU;

use journal_bearing::mobility::{MobilityMap, MobilitySlice, SliceFamily};
use journal_bearing::nalgebra::Vector2;
use journal_bearing::reynolds::{Cavitation, Diagnostics, Drive, FilmError, FilmSettings, ReynoldsFilm};

/// Width, diameter and radial clearance, m.
const WIDTH: f64 = 0.025;
const DIAMETER: f64 = 0.025;
const CLEARANCE: f64 = 20e-6;
/// Speed of the journal in revolutions per second, and viscosity of the oil in the film, Pa.s.
const REVOLUTIONS: f64 = 25.0;
const VISCOSITY: f64 = 0.02;
/// Loads, N.
const LOADS: [f64; 5] = [500.0, 1000.0, 2000.0, 4000.0, 8000.0];
/// Turns after which the journal has come to rest.
const TURNS: f64 = 40.0;

fn main() -> Result<(), Box<dyn Error>> {
    let slice = SliceFamily::new(&MobilityMap::built_in()?).slice(WIDTH / DIAMETER);
    println!("                 |   mobility  |    p >= 0   | mass-conserving");
    println!("load  Sommerfeld |  e/c  angle |  e/c  angle |  e/c  angle   gap  pressure  friction   flow");
    println!("   N           1 |    1    deg |    1    deg |    1    deg    um       MPa         1  mm3/s");
    for load in LOADS {
        print!("{load:4} {:11.4}", sommerfeld_number(load));
        let (free, _) = settle(load, Cavitation::NonNegative)?;
        let (conserving, report) = settle(load, Cavitation::MassConserving)?;
        for eps in [rest(&slice, load), free, conserving] {
            let angle = eps.y.atan2(eps.x).to_degrees();
            print!(" | {:.2} {angle:6.1}", eps.norm());
        }
        println!(
            " {:5.1} {:9.2} {:9.5} {:6.0}",
            report.smallest_gap * 1e6,
            report.max_pressure * 1e-6,
            report.journal_torque / (0.5 * DIAMETER * load),
            report.outflow * 1e9,
        );
    }
    Ok(())
}

/// The eccentricity ratio at which the journal comes to rest by the transient Reynolds equation, and the film there.
fn settle(load: f64, cavitation: Cavitation) -> Result<(Vector2<f64>, Diagnostics), FilmError> {
    let mut film = ReynoldsFilm::new(FilmSettings { cavitation, ..FilmSettings::new(WIDTH, DIAMETER, CLEARANCE) })?;
    let drive = Drive::steady(Vector2::new(load, 0.0), TAU * REVOLUTIONS, VISCOSITY);
    let report = film.advance(TURNS / REVOLUTIONS, &drive, &|_| 0.0)?;
    Ok((film.eccentricity(), report))
}

/// `S = eta N D B (R/c)^2 / F`.
fn sommerfeld_number(load: f64) -> f64 {
    let ratio = 0.5 * DIAMETER / CLEARANCE;
    VISCOSITY * REVOLUTIONS * DIAMETER * WIDTH * ratio * ratio / load
}

/// The eccentricity ratio at which the journal comes to rest by the mobility method (Booker 1965): the squeeze velocity
/// balances the mean rotation. Explicit steps, shorter where the film is stiffer.
fn rest(slice: &MobilitySlice, load: f64) -> Vector2<f64> {
    let psi = CLEARANCE / (0.5 * DIAMETER);
    let scale = load * psi * psi / (VISCOSITY * DIAMETER * WIDTH);
    let rotation = 0.5 * TAU * REVOLUTIONS;
    let mut eps = Vector2::new(0.1, 0.1);
    let mut time = 0.0;
    while time < TURNS / REVOLUTIONS {
        let velocity = slice.mobility_vector(eps, Vector2::x()) * scale + Vector2::new(-eps.y, eps.x) * rotation;
        let step = (1e-2 * (1.0 - eps.norm()) / velocity.norm()).min(1e-2 / rotation);
        eps += velocity * step;
        time += step;
    }
    eps
}
