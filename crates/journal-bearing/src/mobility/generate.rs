//! Direct solutions of the quasi-static film, and the map that is made of them.

use std::{array, panic::resume_unwind, sync::Mutex, thread};

use nalgebra::Vector2;

use super::{map::MobilityMap, rough, table::CHANNELS};
use crate::{
    reynolds::{Boundary, Grid, NotConverged, QuasiStatic},
    roughness::Reach,
};

/// Columns around the bush and rows over the half width on which the map is made.
const CELLS: [usize; 2] = [160, 14];

/// The same for the table of rough films, whose narrowest part is longer.
const ROUGH_CELLS: [usize; 2] = [240, 14];
/// Added to a rough bearing's narrowest gap for its cells, in roughnesses.
const PATCH: f64 = 2.0;

/// One direct solution, in the quantities of the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Mobility along the eccentricity and 90 degrees ahead of it, 1.
    pub mobility: Vector2<f64>,
    /// The largest pressure over `F / (B D)`, 1.
    pub max_pressure: f64,
    /// The oil flow out of both ends together over `F c^3 / (3 eta B^2)`, 1.
    pub side_flow: f64,
}

/// A journal held at `(e, 0)` in a bearing of one width, for loads of any direction.
struct HeldJournal(QuasiStatic);

impl HeldJournal {
    /// One between surfaces of this roughness over clearance; 0 for smooth ones.
    fn between(roughness: f64, width_to_diameter: f64, e: f64, cells: [usize; 2]) -> Self {
        // Between rough surfaces the film varies over the patch that touches.
        let narrowest = if roughness > 0.0 { Reach::new(roughness).room(e)[0] + PATCH * roughness } else { 1.0 - e };
        let grid = Grid::clustered(cells[0], cells[1], 1.0 - narrowest, width_to_diameter);
        let mut film = QuasiStatic::between(roughness, grid, width_to_diameter, Boundary::Free);
        film.place(Vector2::new(e, 0.0));
        Self(film)
    }

    /// The solution under a load at this angle from the eccentricity.
    fn under(&mut self, angle: f64) -> Result<Sample, NotConverged> {
        let load = Vector2::new(angle.cos(), angle.sin());
        let carried = self.0.velocity_under(load).or_else(|_| {
            // The last direction's pressure may be a bad start.
            self.0.reset();
            self.0.velocity_under(load)
        })?;
        // With |F| = 12 eta (R/c)^2 R B |W|, the factor |F| (c/R)^2 / (eta B D) of the mobility is 6 |W|.
        Ok(Sample {
            mobility: carried.velocity / 6.0,
            max_pressure: 2.0 * carried.max_pressure,
            side_flow: carried.end_flow,
        })
    }

    /// The same in the quantities of a node. `aligned`: the load is along the line of centres, and the mobility too, by symmetry.
    fn quantities(&mut self, angle: f64, aligned: bool) -> Result<[f64; CHANNELS], NotConverged> {
        let Sample { mobility, max_pressure, side_flow } = self.under(angle)?;
        let ahead = Vector2::new(angle.cos(), angle.sin());
        let lead = if aligned { 0.0 } else { ahead.perp(&mobility).atan2(ahead.dot(&mobility)) };
        Ok([mobility.norm().ln(), lead, max_pressure.ln(), side_flow.ln()])
    }
}

/// Solves the quasi-static film directly: for `B/D`, an eccentricity ratio `0 <= e < 1` and a load `angle` rad ahead
/// of the eccentricity, on `[columns, rows]` cells around the bush and over the half width.
///
/// # Errors
/// Returns [`NotConverged`] when the pressure field does not settle.
pub fn exact(width_to_diameter: f64, e: f64, angle: f64, cells: [usize; 2]) -> Result<Sample, NotConverged> {
    exact_between(0.0, width_to_diameter, e, angle, cells)
}

/// The same between rough surfaces, which the film sees as [`RoughFilm::MeanGap`](crate::reynolds::RoughFilm) says:
/// `roughness` is the composite rms roughness over the clearance, and `e` may exceed 1.
///
/// # Errors
/// Returns [`NotConverged`] when the pressure field does not settle.
pub fn exact_between(
    roughness: f64,
    width_to_diameter: f64,
    e: f64,
    angle: f64,
    cells: [usize; 2],
) -> Result<Sample, NotConverged> {
    HeldJournal::between(roughness, width_to_diameter, e, cells).under(angle)
}

/// Makes the map: solves the film directly at every node, on all cores.
///
/// # Errors
/// Returns [`NotConverged`] when a pressure field does not settle.
pub fn generate() -> Result<MobilityMap<'static>, NotConverged> {
    let mut map = MobilityMap::empty();
    let [widths, us, ss] = map.nodes();
    map.values = tabulated(widths * us, ss, |row, nodes| fill(&map, row / us, row % us, nodes))?.into();
    Ok(map)
}

/// Makes the table of rough films' corrections, as `rough.bin` holds it.
///
/// # Errors
/// Returns [`NotConverged`] when a pressure field does not settle.
pub fn generate_rough() -> Result<Vec<u8>, NotConverged> {
    let [widths, roughnesses, places, directions] = rough::SIZE;
    tabulated(widths * roughnesses * places, directions, |row, nodes| {
        let (sheet, place) = (row / places, row % places);
        let (width, roughness) = (rough::width(sheet / roughnesses), rough::roughness(sheet % roughnesses));
        fill_rough(width, roughness, place, nodes)
    })
}

/// The quantities of a node as a table holds them.
type TableNode = [f32; CHANNELS];

/// The bytes of a table of so many rows with so many nodes each; `fill` makes the nodes of a row of this number. All cores work.
fn tabulated(
    rows: usize,
    nodes_of_row: usize,
    fill: impl Fn(usize, &mut [TableNode]) -> Result<(), NotConverged> + Sync,
) -> Result<Vec<u8>, NotConverged> {
    let mut nodes = vec![TableNode::default(); rows * nodes_of_row];
    let queue = Mutex::new(nodes.chunks_exact_mut(nodes_of_row).enumerate());
    let next = || queue.lock().ok().and_then(|mut left| left.next());
    let work = || std::iter::from_fn(next).try_for_each(|(row, nodes)| fill(row, nodes));
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })?;
    Ok(nodes.into_iter().flatten().flat_map(f32::to_le_bytes).collect())
}

/// Solves for the nodes of slice `k` and eccentricity ratio `i`.
fn fill(map: &MobilityMap, k: usize, i: usize, nodes: &mut [TableNode]) -> Result<(), NotConverged> {
    let mut journal = HeldJournal::between(0.0, map.width(k), map.point(i, 0).eccentricity(), CELLS);
    let last = nodes.len() - 1;
    for (j, node) in nodes.iter_mut().enumerate() {
        let angle = map.point(i, j).angle();
        *node = journal.quantities(angle, j == 0 || j == last)?.map(|quantity| quantity as f32);
    }
    Ok(())
}

/// Solves for the directions at a place in contact: by how much the rough film differs from the smooth one with its room.
fn fill_rough(width: f64, roughness: f64, place: usize, nodes: &mut [TableNode]) -> Result<(), NotConverged> {
    let reach = Reach::new(roughness);
    // At first touch the two are the same, unless that is in the centre.
    if place == 0 && reach.start > 0.0 {
        return Ok(());
    }
    let e = rough::eccentricity(&reach, place);
    let [room, _] = reach.room(e);
    let mut rough_journal = HeldJournal::between(roughness, width, e, ROUGH_CELLS);
    let mut smooth_journal = HeldJournal::between(0.0, width, 1.0 - room, ROUGH_CELLS);
    let last = nodes.len() - 1;
    for (k, node) in nodes.iter_mut().enumerate() {
        let (angle, aligned) = (rough::angle(room, k), k == 0 || k == last);
        let of_rough = rough_journal.quantities(angle, aligned)?;
        let of_smooth = smooth_journal.quantities(angle, aligned)?;
        *node = array::from_fn(|channel| (of_rough[channel] - of_smooth[channel]) as f32);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mobility::table::numbers;

    /// One row of each table, made again: a change of the film or of these functions would leave the committed tables behind.
    #[test]
    fn rows_are_as_the_committed_tables_hold_them() {
        let close = |made: &[TableNode], committed: &[u8]| {
            for (made, committed) in made.iter().flatten().zip(numbers(committed)) {
                assert!((f64::from(*made) - committed).abs() < 1e-4, "{made} {committed}");
            }
        };
        let map = MobilityMap::built_in().unwrap();
        let [_, us, ss] = map.nodes();
        let (k, i) = (6, 12);
        let mut row = vec![TableNode::default(); ss];
        fill(&map, k, i, &mut row).unwrap();
        close(&row, &map.values[(k * us + i) * ss * size_of::<TableNode>()..]);
        let [_, roughnesses, places, directions] = rough::SIZE;
        let (width, roughness, place) = (2, 3, 9);
        let mut row = vec![TableNode::default(); directions];
        fill_rough(rough::width(width), rough::roughness(roughness), place, &mut row).unwrap();
        let number = (width * roughnesses + roughness) * places + place;
        close(&row, &rough::COMMITTED[number * directions * size_of::<TableNode>()..]);
    }
}
