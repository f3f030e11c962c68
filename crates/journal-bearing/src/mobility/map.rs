//! The tabulated mobility and its file.

use std::f64::consts::LN_10;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::coordinates::Point;
use super::slice::Tabulated;

/// The committed table, made by [`generate`](super::generate).
static COMMITTED: &[u8] = include_bytes!("map.bin");

/// Quantities in the table: `ln |M|`, the angle by which `M` leads the load, `ln` of the largest
/// pressure over `F/(B D)`, and `ln` of the side flow over `F c^3 / (3 eta B^2)`.
pub(super) const CHANNELS: usize = 4;

/// Mobility, largest pressure and side flow over `B/D`, eccentricity ratio and load direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MobilityMap {
    /// `ln(B/D)` of the first and the last slice.
    widths: [f64; 2],
    /// The largest `u = -ln(1 - e)`; the smallest is 0.
    last_u: f64,
    /// Nodes over `ln(B/D)`, `u` and `s`.
    nodes: [u16; 3],
    /// By `ln(B/D)`, then `u`, then `s`, then channel.
    values: Vec<f32>,
}

/// The bytes are no mobility map.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "the mobility map is damaged ({0}); make it again with `cargo run --release -p journal-bearing --bin mobility-map`"
)]
pub struct MapError(String);

impl MobilityMap {
    /// The map's extent: `B/D` from 0.1 to 4, eccentricity ratio from 0 to 0.9999.
    pub(super) fn empty() -> Self {
        let nodes = [13, 41, 33];
        Self {
            widths: [0.1_f64.ln(), 4.0_f64.ln()],
            last_u: 4.0 * LN_10,
            nodes,
            values: Vec::new(),
        }
    }

    /// The map that is built into this library.
    ///
    /// # Errors
    /// When the built-in table does not read, which a test excludes.
    pub fn built_in() -> Result<Self, MapError> {
        Self::from_bytes(COMMITTED)
    }

    /// Reads a map that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// When the bytes are no map.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, MapError> {
        let map: Self = postcard::from_bytes(bytes).map_err(|error| MapError(error.to_string()))?;
        let count: usize = map.nodes.iter().map(|&n| usize::from(n)).product();
        let ordered = map.widths[0] < map.widths[1] && map.last_u > 0.0;
        if map.nodes.iter().any(|&n| n < 4) || map.values.len() != count * CHANNELS || !ordered {
            return Err(MapError("its extent does not fit its values".to_owned()));
        }
        if map.values.iter().any(|value| !value.is_finite()) {
            return Err(MapError("a value is not finite".to_owned()));
        }
        Ok(map)
    }

    /// The map as bytes.
    ///
    /// # Errors
    /// When serialisation fails, which it does not for a map in memory.
    pub fn to_bytes(&self) -> Result<Vec<u8>, MapError> {
        postcard::to_stdvec(self).map_err(|error| MapError(error.to_string()))
    }

    /// The tabulated slices, by `B/D`.
    pub(super) fn slices(&self) -> Vec<Tabulated> {
        let [_, us, ss] = self.nodes.map(usize::from);
        self.values
            .chunks_exact(us * ss * CHANNELS)
            .map(|values| Tabulated::new(values, us, ss, self.last_u))
            .collect()
    }

    /// `B/D` of the slice `k`.
    pub(super) fn width(&self, k: usize) -> f64 {
        (self.widths[0] + k as f64 * self.width_spacing()).exp()
    }

    /// Nodes over `ln(B/D)`, `u` and `s`.
    pub(super) fn nodes(&self) -> [usize; 3] {
        self.nodes.map(usize::from)
    }

    /// The point of node `(i, j)` over `u` and `s`.
    pub(super) fn point(&self, i: usize, j: usize) -> Point {
        let [_, us, ss] = self.nodes.map(usize::from);
        Point {
            u: self.last_u * i as f64 / (us - 1) as f64,
            s: j as f64 / (ss - 1) as f64,
        }
    }

    /// Fills in the values.
    pub(super) fn with_values(self, values: Vec<f32>) -> Self {
        Self { values, ..self }
    }

    fn width_spacing(&self) -> f64 {
        (self.widths[1] - self.widths[0]) / f64::from(self.nodes[0] - 1)
    }
}
