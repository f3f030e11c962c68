//! Convergence of the film's load with the grid: figures of `docs/evidence/film.md`.
//!
//!     cargo run --release -p journal-bearing --example convergence
//!
//! The journal stays at an eccentricity ratio. Errors are those of the load against an extrapolation from fine grids that
//! crowd where the film varies fast.

use journal_bearing::reynolds::{Boundary, Grid, NotConverged, QuasiStatic};
use nalgebra::Vector2;

/// Eccentricity ratio and B/D.
const CASES: [(f64, f64); 6] = [(0.5, 0.76), (0.9, 0.76), (0.97, 0.76), (0.97, 1.0), (0.9, 0.5), (0.9, 0.25)];

fn main() -> Result<(), NotConverged> {
    println!(
        "| eccentricity ratio | B/D | 96 x 8 even, % | 192 x 16, % | 384 x 32, % | order | film's 96 x 8, % | map's 160 x 14, % |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (e, width) in CASES {
        let clustered = |k: usize| load(Grid::clustered(64 * k, 6 * k, e, width), e, width);
        let (middle, fine) = (clustered(3)?, clustered(6)?);
        let extrapolated = fine + (fine - middle) / 3.0;
        let error = |load: f64| 100.0 * (load / extrapolated - 1.0).abs();
        let mut even = [0.0; 3];
        for (error_of, n) in even.iter_mut().zip([96, 192, 384]) {
            *error_of = error(load(Grid::uniform(n, n / 12), e, width)?);
        }
        let order = 0.5 * (even[0] / even[2]).log2();
        let film = error(load(Grid::standard(96, 8, width), e, width)?);
        let map = error(load(Grid::clustered(160, 14, e, width), e, width)?);
        println!(
            "| {e} | {width} | {:.3} | {:.3} | {:.3} | {order:.1} | {film:.3} | {map:.3} |",
            even[0], even[1], even[2]
        );
    }
    Ok(())
}

/// The dimensionless load at a mean rotation of 1 rad/s, without squeeze.
fn load(grid: Grid, e: f64, width: f64) -> Result<f64, NotConverged> {
    let mut film = QuasiStatic::new(grid, width, Boundary::Free);
    film.place(Vector2::new(e, 0.0));
    Ok(film.load_at(Vector2::new(0.0, -e))?.load.norm())
}
