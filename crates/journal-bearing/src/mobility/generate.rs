//! Direct solutions of the quasi-static film, and the map that is made of them.

use nalgebra::Vector2;

use super::map::MobilityMap;
use super::table::CHANNELS;
use crate::reynolds::{Boundary, Grid, NotConverged, QuasiStatic};

/// Columns around the bush and rows over the half width on which the map is made.
const CELLS: [usize; 2] = [160, 14];

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
        let grid = Grid::clustered(cells[0], cells[1], e, width_to_diameter);
        let mut film = QuasiStatic::new(grid, width_to_diameter, Boundary::Free);
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
pub fn exact(
    width_to_diameter: f64,
    e: f64,
    angle: f64,
    cells: [usize; 2],
) -> Result<Sample, NotConverged> {
    Station::new(width_to_diameter, e, cells).under(angle)
}

/// Makes the map: solves the film directly at every node, on `threads` threads. `progress` receives the share done, 0..1.
///
/// # Errors
/// Returns [`NotConverged`] when a pressure field does not settle.
pub fn generate(
    threads: usize,
    progress: impl Fn(f64) + Sync,
) -> Result<MobilityMap<'static>, NotConverged> {
    let mut map = MobilityMap::empty();
    let [widths, us, ss] = map.nodes();
    let mut values = vec![0.0_f32; widths * us * ss * CHANNELS];
    let stations: Vec<_> = values.chunks_exact_mut(ss * CHANNELS).enumerate().collect();
    let total = stations.len() as f64;
    let queue = std::sync::Mutex::new(stations);
    let work = || -> Result<(), NotConverged> {
        loop {
            let next = queue.lock().ok().and_then(|mut left| {
                let next = left.pop();
                progress(1.0 - left.len() as f64 / total);
                next
            });
            let Some((number, row)) = next else {
                return Ok(());
            };
            let (k, i) = (number / us, number % us);
            fill(&map, k, i, row)?;
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(work)).collect();
        for worker in workers {
            match worker.join() {
                Ok(result) => result?,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        Ok(())
    })?;
    map.values = values.into_iter().flat_map(f32::to_le_bytes).collect();
    Ok(map)
}

/// Solves for the nodes of slice `k` and eccentricity ratio `i`.
fn fill(map: &MobilityMap<'_>, k: usize, i: usize, row: &mut [f32]) -> Result<(), NotConverged> {
    let e = map.point(i, 0).eccentricity();
    let mut station = Station::new(map.width(k), e, CELLS);
    let ss = row.len() / CHANNELS;
    for (j, node) in row.chunks_exact_mut(CHANNELS).enumerate() {
        let angle = map.point(i, j).angle();
        let sample = station.under(angle)?;
        let ahead = Vector2::new(angle.cos(), angle.sin());
        // With the load along the line of centres, the mobility is along it too, by symmetry.
        let lead = if j == 0 || j + 1 == ss {
            0.0
        } else {
            ahead
                .perp(&sample.mobility)
                .atan2(ahead.dot(&sample.mobility))
        };
        let quantities = [
            sample.mobility.norm().ln(),
            lead,
            sample.max_pressure.ln(),
            sample.side_flow.ln(),
        ];
        for (value, quantity) in node.iter_mut().zip(quantities) {
            *value = quantity as f32;
        }
    }
    Ok(())
}
