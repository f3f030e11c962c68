//! The tabulated mobility and its file format.

use std::{borrow::Cow, f64::consts::LN_10};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{
    coordinates::Point,
    table::{CHANNELS, NUMBER, Tabulated, numbers},
};

/// The committed table, made by [`generate`](super::generate).
static COMMITTED: &[u8] = include_bytes!("map.bin");

/// Table of mobility, largest pressure and side flow over `B/D`, eccentricity ratio and load direction.
///
/// Prepare it with [`SliceFamily::new`](super::SliceFamily::new) before looking anything up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MobilityMap<'a> {
    /// `ln(B/D)` of the first and the last slice.
    widths: [f64; 2],
    /// The largest `u = -ln(1 - e)`; the smallest is 0.
    last_u: f64,
    /// Nodes over `ln(B/D)`, `u` and `s`.
    nodes: [u16; 3],
    /// Numbers of four bytes, the lowest first; by `ln(B/D)`, then `u`, then `s`, then channel. Borrowed, as a process that
    /// lives for one simulation needs few of them.
    #[serde(borrow)]
    pub(super) values: Cow<'a, [u8]>,
}

/// The bytes are not a mobility map; the text says why.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error(
    "the mobility map is damaged ({0}); make it again with `cargo run --release -p journal-bearing --example mobility-map`"
)]
pub struct MapError(pub(super) String);

impl MobilityMap<'static> {
    /// A map without values that covers `B/D` from 0.1 to 4 and eccentricity ratios from 0 to 0.9999.
    pub(super) fn empty() -> Self {
        Self { widths: [0.1_f64.ln(), 4.0_f64.ln()], last_u: 4.0 * LN_10, nodes: [13, 41, 33], values: Cow::default() }
    }

    /// The map that ships with this library.
    ///
    /// # Errors
    /// Returns [`MapError`] when the built-in table cannot be read; a test rules that out.
    pub fn built_in() -> Result<Self, MapError> {
        Self::from_bytes(COMMITTED)
    }

    /// The tabulated slices in the order of `B/D`.
    pub(super) fn slices(&self) -> Vec<Tabulated> {
        let [slices, us, ss] = self.nodes();
        let size = self.values.len() / slices;
        (0..slices)
            .map(|k| {
                let bytes = k * size..(k + 1) * size;
                let values = match &self.values {
                    Cow::Borrowed(all) => Cow::Borrowed(&all[bytes]),
                    Cow::Owned(all) => Cow::Owned(all[bytes].to_vec()),
                };
                Tabulated::new(values, us, ss, self.last_u)
            })
            .collect()
    }
}

impl<'a> MobilityMap<'a> {
    /// Reads a map that [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// Returns [`MapError`] when the bytes do not decode, do not fit the stated extent, or hold a value that is not finite.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, MapError> {
        let map: Self = postcard::from_bytes(bytes).map_err(|error| MapError(error.to_string()))?;
        let count: usize = map.nodes.iter().map(|&n| usize::from(n)).product();
        let ordered = map.widths[0] < map.widths[1] && map.last_u > 0.0;
        if map.nodes.iter().any(|&n| n < 4) || map.values.len() != count * CHANNELS * NUMBER || !ordered {
            return Err(MapError("its extent does not fit its values".to_owned()));
        }
        if numbers(&map.values).any(|value| !value.is_finite()) {
            return Err(MapError("a value is not finite".to_owned()));
        }
        Ok(map)
    }

    /// The map as bytes, in the format of [`from_bytes`](Self::from_bytes).
    ///
    /// # Errors
    /// Returns [`MapError`] when serialisation fails, which does not happen for a map in memory.
    pub fn to_bytes(&self) -> Result<Vec<u8>, MapError> {
        postcard::to_stdvec(self).map_err(|error| MapError(error.to_string()))
    }

    /// `B/D` of slice `k`.
    pub(super) fn width(&self, k: usize) -> f64 {
        let spacing = (self.widths[1] - self.widths[0]) / f64::from(self.nodes[0] - 1);
        (self.widths[0] + k as f64 * spacing).exp()
    }

    /// Numbers of nodes over `ln(B/D)`, `u` and `s`.
    pub(super) fn nodes(&self) -> [usize; 3] {
        self.nodes.map(usize::from)
    }

    /// The point of node `(i, j)` over `u` and `s`.
    pub(super) fn point(&self, i: usize, j: usize) -> Point {
        let [_, us, ss] = self.nodes();
        Point { u: self.last_u * i as f64 / (us - 1) as f64, s: j as f64 / (ss - 1) as f64 }
    }
}
