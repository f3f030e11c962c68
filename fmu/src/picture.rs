//! The pressure over the bearing, for the page of the stand in a browser (`docs/playground`).

use std::sync::Mutex;

use journal_bearing::{
    nalgebra::Vector2,
    reynolds::{Boundary, Grid, QuasiStatic},
};

/// Cells around the bush, and from the middle to one end.
const CELLS: [usize; 2] = [96, 12];

static FIELD: Mutex<Vec<f64>> = Mutex::new(Vec::new());

/// The pressure `P` of the cells, column by column from `theta = -pi` on, at the eccentricity ratio `(ex, ey)` under the load
/// `(wx, wy)` between surfaces of this roughness over the clearance: `journal_bearing::reynolds` defines all. It stays until the next
/// call; NULL where the film has no solution.
// SAFETY: no other function has this name.
#[unsafe(no_mangle)]
pub extern "C" fn film_pressure(
    ex: f64,
    ey: f64,
    wx: f64,
    wy: f64,
    width_to_diameter: f64,
    roughness: f64,
) -> *const f64 {
    let [columns, rows] = CELLS;
    let eps = Vector2::new(ex, ey);
    let load = Vector2::new(wx, wy);
    let [finite, inside] =
        [load.norm().is_finite() && (0.0..1.0).contains(&roughness), eps.norm() < 1.0 + 3.0 * roughness];
    let sound = finite && inside && width_to_diameter > 0.0;
    let Ok(mut field) = FIELD.lock() else {
        return std::ptr::null();
    };
    if !sound {
        return std::ptr::null();
    }
    let grid = Grid::uniform(columns, rows);
    let mut film = QuasiStatic::between(roughness, grid, width_to_diameter, Boundary::Free);
    film.place(eps);
    if film.velocity_under(load).is_err() {
        return std::ptr::null();
    }
    let cells = (0..columns).flat_map(|i| (0..rows).map(move |j| [i, j]));
    field.clear();
    field.extend(cells.map(|[i, j]| film.pressure(i, j)));
    field.as_ptr()
}
