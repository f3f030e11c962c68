//! The time of a step of the transient film beside the time that its arithmetic would take at the machine's peak, for
//! `scripts/evidence/bench`.
//!
//! `bound STEPS` prints seconds per step, floating-point operations per step by count, and the most operations per second
//! that this machine reaches with the kind of code that the compiler makes of the film's loops.

use journal_bearing::reynolds::{Cavitation, Drive, FilmSettings, ReynoldsFilm};
use nalgebra::Vector2;
use std::error::Error;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

/// Speed (rad/s), viscosity (Pa.s) and step (s).
const SPEED: f64 = 31.416;
const VISCOSITY: f64 = 0.02;
const STEP: f64 = 1e-3;

fn main() -> ExitCode {
    match run() {
        Ok((seconds, peak)) => {
            println!("{seconds:e} {:e} {peak:e}", operations());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("bound: {error}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(f64, f64), Box<dyn Error>> {
    let steps: u32 = match std::env::args().nth(1) {
        Some(steps) => steps.parse()?,
        None => return Err("usage: bound STEPS".into()),
    };
    Ok((step(steps)?, peak()))
}

/// The least operations of a step with 96 columns of 8 rows: in each of its two implicit stages one assembly, one
/// elimination of the ring of columns, and two solutions.
///
/// - Assembly: 60 operations a cell (gap, mobility of four faces, mass and its derivatives).
/// - Elimination: the pivot block of each column inverted (`2 n^3`), coupled to its neighbours by diagonals
///   (`4 n^2`); the ring's closure is not counted.
/// - Solution: a multiplication by the inverse in the forward and in the backward substitution (`4 n^2`).
fn operations() -> f64 {
    let (columns, rows) = (96.0, 8.0_f64);
    let assembly = 60.0 * rows;
    let elimination = 2.0 * rows.powi(3) + 4.0 * rows.powi(2);
    let solution = 4.0 * rows.powi(2);
    2.0 * columns * (assembly + elimination + 2.0 * solution)
}

/// Seconds per step after a warm-up, over a load cycle of 750 N +- 20 %.
fn step(steps: u32) -> Result<f64, Box<dyn Error>> {
    const WARM: u32 = 400;
    let settings = FilmSettings {
        cavitation: Cavitation::MassConserving,
        tolerance: 1.0,
        ..FilmSettings::new(0.019, 0.025, 20e-6)
    };
    let mut film = ReynoldsFilm::new(settings)?;
    let load = |t: f64| Vector2::new(750.0 * (1.0 + 0.2 * (SPEED * t).sin()), 0.0);
    let mut begun = Instant::now();
    for index in 0..WARM + steps {
        if index == WARM {
            begun = Instant::now();
        }
        let t = f64::from(index) * STEP;
        let drive = Drive {
            load_before: load(t),
            load_after: load(t + STEP),
            ..Drive::steady(Vector2::zeros(), SPEED, VISCOSITY)
        };
        black_box(film.advance(STEP, &drive, &|_| 0.0)?);
    }
    Ok(begun.elapsed().as_secs_f64() / f64::from(steps))
}

/// Multiplications and additions per second on one core, in enough independent chains to fill its pipelines.
fn peak() -> f64 {
    const CHAINS: usize = 24;
    const ROUNDS: u32 = 4_000_000;
    let (factor, summand) = (black_box(0.999_999), black_box(1e-6));
    let once = || {
        let mut values = [1.0_f64; CHAINS];
        let begun = Instant::now();
        for _ in 0..ROUNDS {
            for value in &mut values {
                *value = *value * factor + summand;
            }
        }
        black_box(values);
        2.0 * CHAINS as f64 * f64::from(ROUNDS) / begun.elapsed().as_secs_f64()
    };
    (0..5).map(|_| once()).fold(0.0, f64::max)
}
