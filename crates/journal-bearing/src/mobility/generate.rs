//! Direct solutions of the quasi-static film, and the map that is made of them.

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
struct Station(QuasiStatic);

impl Station {
    fn new(width_to_diameter: f64, e: f64, cells: [usize; 2]) -> Self {
        Self::between(0.0, width_to_diameter, e, cells)
    }

    /// The same between rough surfaces; `roughness` over clearance.
    fn between(roughness: f64, width_to_diameter: f64, e: f64, cells: [usize; 2]) -> Self {
        // Between rough surfaces the film varies over the patch that touches.
        let narrowest = if roughness > 0.0 { Reach::new(roughness).room(e)[0] + PATCH * roughness } else { 1.0 - e };
        let grid = Grid::clustered(cells[0], cells[1], 1.0 - narrowest, width_to_diameter);
        let mut film = QuasiStatic::between(roughness, grid, width_to_diameter, Boundary::Free);
        film.place(Vector2::new(e, 0.0));
        Self(film)
    }

    fn under(&mut self, angle: f64) -> Result<Sample, NotConverged> {
        let load = Vector2::new(angle.cos(), angle.sin());
        let carried = self.0.velocity_under(load).or_else(|_| {
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
    Station::between(roughness, width_to_diameter, e, cells).under(angle)
}

/// Makes the map: solves the film directly at every node, on all cores.
///
/// # Errors
/// Returns [`NotConverged`] when a pressure field does not settle.
pub fn generate() -> Result<MobilityMap<'static>, NotConverged> {
    let mut map = MobilityMap::empty();
    let [widths, us, ss] = map.nodes();
    let mut values = vec![0.0_f32; widths * us * ss * CHANNELS];
    let rows = values.chunks_exact_mut(ss * CHANNELS).collect();
    share(rows, |number, row| fill(&map, number / us, number % us, row))?;
    map.values = values.into_iter().flat_map(f32::to_le_bytes).collect();
    Ok(map)
}

/// Makes the table of rough films' corrections, as `rough.bin` holds it.
///
/// # Errors
/// Returns [`NotConverged`] when a pressure field does not settle.
pub fn generate_rough() -> Result<Vec<u8>, NotConverged> {
    let [widths, roughnesses, places, directions] = rough::SIZE;
    let mut values = vec![0.0_f32; widths * roughnesses * places * directions * CHANNELS];
    let rows = values.chunks_exact_mut(directions * CHANNELS).collect();
    share(rows, |number, row| {
        let (place, rest) = (number % places, number / places);
        let width = rough::width(rest / roughnesses);
        fill_rough(width, rough::roughness(rest % roughnesses), place, row)
    })?;
    Ok(values.into_iter().flat_map(f32::to_le_bytes).collect())
}

/// Fills numbered rows on all cores.
fn share<T: Send>(
    rows: Vec<&mut [T]>,
    fill: impl Fn(usize, &mut [T]) -> Result<(), NotConverged> + Sync,
) -> Result<(), NotConverged> {
    let queue = std::sync::Mutex::new(rows.into_iter().enumerate());
    let next = || queue.lock().ok().and_then(|mut left| left.next());
    let work = || std::iter::from_fn(&next).try_for_each(|(number, row)| fill(number, row));
    std::thread::scope(|scope| {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(work)).collect();
        workers
            .into_iter()
            .try_for_each(|worker| worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Solves for the directions at a place in contact: by how much the rough film differs from the smooth one with its room.
fn fill_rough(width: f64, roughness: f64, place: usize, row: &mut [f32]) -> Result<(), NotConverged> {
    let reach = Reach::new(roughness);
    let e = rough::eccentricity(&reach, place);
    let [room, _] = reach.room(e);
    if place == 0 && reach.start > 0.0 {
        return Ok(());
    }
    let mut of_rough = Station::between(roughness, width, e, ROUGH_CELLS);
    let mut smooth = Station::new(width, 1.0 - room, ROUGH_CELLS);
    let last = row.len() / CHANNELS - 1;
    for (k, node) in row.chunks_exact_mut(CHANNELS).enumerate() {
        let angle = rough::angle(room, k);
        let aligned = k == 0 || k == last;
        let [of_rough, smooth] = [&mut of_rough, &mut smooth]
            .map(|station| station.under(angle).map(|sample| quantities(sample, angle, aligned)));
        let (of_rough, smooth) = (of_rough?, smooth?);
        for (value, (of_rough, smooth)) in node.iter_mut().zip(of_rough.iter().zip(smooth)) {
            *value = (of_rough - smooth) as f32;
        }
    }
    Ok(())
}

/// A sample's quantities as the map holds them. `aligned`: the load is along the line of centres, and the mobility too, by
/// symmetry.
fn quantities(sample: Sample, angle: f64, aligned: bool) -> [f64; CHANNELS] {
    let ahead = Vector2::new(angle.cos(), angle.sin());
    let lead = if aligned { 0.0 } else { ahead.perp(&sample.mobility).atan2(ahead.dot(&sample.mobility)) };
    [sample.mobility.norm().ln(), lead, sample.max_pressure.ln(), sample.side_flow.ln()]
}

/// Solves for the nodes of slice `k` and eccentricity ratio `i`.
fn fill(map: &MobilityMap, k: usize, i: usize, row: &mut [f32]) -> Result<(), NotConverged> {
    let e = map.point(i, 0).eccentricity();
    let mut station = Station::new(map.width(k), e, CELLS);
    let ss = row.len() / CHANNELS;
    for (j, node) in row.chunks_exact_mut(CHANNELS).enumerate() {
        let angle = map.point(i, j).angle();
        let quantities = quantities(station.under(angle)?, angle, j == 0 || j + 1 == ss);
        for (value, quantity) in node.iter_mut().zip(quantities) {
            *value = quantity as f32;
        }
    }
    Ok(())
}
