//! Where a journal between two axial grooves rests under a steady load, with its eight coefficients, by the quasi-static film, and
//! the time that finding them takes.
//!
//!     cargo run --release -p journal-bearing --example static_point -- WIDTH/DIAMETER SOMMERFELD-NUMBER GROOVES SEARCHES
//!
//! The grooves stand at right angles to the load; GROOVES is the extent of each in degrees. SEARCHES are timed together. It prints eccentricity ratio, attitude
//! angle (degrees), Kxx, Kxy, Kyx, Kyy in loads over the clearance, Bxx, Bxy, Byx, Byy in loads over clearance and speed, and
//! seconds per search. `scripts/evidence/bench-ross` uses it; for people, `steady_bearing` is the better start.

use journal_bearing::reynolds::{Boundary, Coefficients, Grid, Groove, NotConverged, QuasiStatic};
use nalgebra::Vector2;
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Instant;

/// Cells around the bearing, and over half its width.
const CELLS: [usize; 2] = [96, 8];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|a| a.parse::<f64>().map_err(|error| format!("{a}: {error}")))
        .collect::<Result<_, _>>()?;
    let [width, number, extent, searches] = numbers[..] else {
        return Err("four numbers are needed: WIDTH/DIAMETER SOMMERFELD-NUMBER GROOVES SEARCHES".into());
    };
    let start = Instant::now();
    for _ in 1..searches as u32 {
        rest(std::hint::black_box(width), number, extent)?;
    }
    let (eps, film) = rest(width, number, extent)?;
    let seconds = start.elapsed().as_secs_f64() / searches;
    print!("{} {}", eps.norm(), eps.y.atan2(eps.x).to_degrees());
    for matrix in [film.stiffness, film.damping] {
        for entry in matrix.transpose().iter() {
            print!(" {entry}");
        }
    }
    println!(" {seconds}");
    Ok(())
}

/// The eccentricity ratio under a load along `x`, and the coefficients in loads, by Newton's method from a cold start.
fn rest(width: f64, number: f64, extent: f64) -> Result<(Vector2<f64>, Coefficients), NotConverged> {
    let grooves = [-FRAC_PI_2, FRAC_PI_2].map(|angle| Groove { angle, extent: extent.to_radians() });
    let grid = Grid::standard(CELLS[0], CELLS[1], width);
    let mut film = QuasiStatic::new(grid, width, Boundary::Free).with_grooves(&grooves);
    // At a mean rotation of 1 rad/s.
    let load = 1.0 / (6.0 * PI * number);
    let mut eps = Vector2::new(0.3, 0.3);
    loop {
        film.place(eps);
        let (carried, found) = film.coefficients(1.0)?;
        let missing = Vector2::new(load, 0.0) - carried.load;
        if missing.norm() < 1e-8 * load {
            let scaled = Coefficients {
                stiffness: found.stiffness / load,
                // The journal turns twice as fast as the mean.
                damping: found.damping * (2.0 / load),
            };
            return Ok((eps, scaled));
        }
        let step = found.stiffness.try_inverse().unwrap_or_default() * missing;
        let room = 0.5 * (1.0 - eps.norm());
        eps += step * (room / step.norm()).min(1.0);
    }
}
