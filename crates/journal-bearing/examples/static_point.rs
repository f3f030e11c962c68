//! The position of a journal under a steady load, by the quasi-static film, and the time that finding it takes.
//!
//!     cargo run --release -p journal-bearing --example static_point -- WIDTH DIAMETER CLEARANCE LOAD SPEED VISCOSITY
//!
//! in m, N, rad/s (of the journal; the bush is at rest) and Pa.s. It prints eccentricity ratio, attitude angle (rad), largest
//! pressure (Pa) and seconds per search. `scripts/bench-ross` uses it; for people, `steady_bearing` is the better start.

use journal_bearing::reynolds::{Boundary, Carried, Grid, NotConverged, QuasiStatic};
use nalgebra::Vector2;
use std::time::Instant;

/// Number of searches that are timed together.
const REPEATS: u32 = 200;

/// The steady case in the dimensionless quantities of the module `reynolds`.
struct Case {
    /// `B/D`.
    width_to_diameter: f64,
    /// The load `W` over the mean rotation.
    load: f64,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse::<f64>().map_err(|error| format!("{a}: {error}")))
        .collect::<Result<_, _>>()?;
    let [width, diameter, clearance, load, speed, viscosity] = numbers[..] else {
        return Err("six numbers are needed: WIDTH DIAMETER CLEARANCE LOAD SPEED VISCOSITY".into());
    };
    let radius = 0.5 * diameter;
    let scale = 12.0 * viscosity * (radius / clearance).powi(2);
    let rotation = 0.5 * speed;
    let case = Case {
        width_to_diameter: width / diameter,
        load: load / (scale * radius * width * rotation),
    };
    let start = Instant::now();
    for _ in 1..REPEATS {
        rest(std::hint::black_box(&case))?;
    }
    let (eccentricity, carried) = rest(&case)?;
    let seconds = start.elapsed().as_secs_f64() / f64::from(REPEATS);
    let attitude = -carried.load.y.atan2(carried.load.x);
    let pressure = carried.max_pressure * scale * rotation;
    println!("{eccentricity} {attitude} {pressure} {seconds}");
    Ok(())
}

/// Finds the eccentricity ratio at which the film carries the load, from a cold start: the secant method on `ln W` over
/// `ln(1/(1 - e))`, which is nearly a straight line.
fn rest(case: &Case) -> Result<(f64, Carried), NotConverged> {
    let [columns, rows] = Grid::sufficient_cells(case.width_to_diameter);
    let grid = Grid::standard(columns, rows, case.width_to_diameter);
    let mut film = QuasiStatic::new(grid, case.width_to_diameter, Boundary::Free);
    // At a mean rotation of 1 rad/s without squeeze, v = -z x eps.
    let mut carried = |x: f64| {
        let e = -(-x).exp_m1();
        film.place(Vector2::new(e, 0.0));
        film.load_at(Vector2::new(0.0, -e))
            .map(|carried| (e, carried))
    };
    let miss = |carried: &Carried| (carried.load.norm() / case.load).ln();
    let (mut a, mut b) = (0.5, 2.0);
    let mut at_a = miss(&carried(a)?.1);
    loop {
        let (e, film) = carried(b)?;
        let at_b = miss(&film);
        if at_b.abs() < 1e-8 {
            return Ok((e, film));
        }
        let next = (b - at_b * (b - a) / (at_b - at_a)).clamp(1e-3, 12.0);
        (a, at_a, b) = (b, at_b, next);
    }
}
