//! The tabulated quantities at one `B/D`, with the slopes that bicubic interpolation needs.

use std::borrow::Cow;

use super::coordinates::Point;
use crate::spline::{Spline, SplineEnd};

/// Quantities per node: `ln |M|`, the angle by which `M` leads the load (rad), `ln` of the largest pressure over
/// `F/(B D)`, and `ln` of the side flow over `F c^3 / (3 eta B^2)`.
pub const CHANNELS: usize = 4;

/// Index of the lead among the quantities. Beyond the ends of `s` it changes its sign with the angle from eccentricity to load,
/// the others do not.
const LEAD: usize = 1;

/// One node: of each quantity the value, the slope over `u`, the slope over `s`, and the mixed derivative ("twist"),
/// all per node spacing.
pub type Node = [[f64; CHANNELS]; 4];

/// Index of the value among a node's four numbers, and of `ln |M|` among the quantities.
pub const VALUE: usize = 0;
pub const MOBILITY: usize = 0;

/// Bytes of a tabulated number.
pub const NUMBER: usize = size_of::<f32>();

/// The numbers that a map's bytes hold.
pub fn numbers(bytes: &[u8]) -> impl Iterator<Item = f64> {
    let (numbers, _) = bytes.as_chunks();
    numbers.iter().map(|&bytes| f64::from(f32::from_le_bytes(bytes)))
}

/// The evenly spaced nodes over `u` and `s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Number of nodes over `s`.
    pub ss: usize,
    /// Index of the last node over `u`.
    pub last_u: f64,
    /// Index of the last node over `s`.
    pub last_s: f64,
    /// Node spacings per unit of `u`.
    pub per_u: f64,
}

impl Lattice {
    /// The row before `u`, the place between it and the next, and how far `u` is beyond the last row, in spacings. There, the
    /// surface continues along its tangent.
    #[inline]
    pub fn locate(&self, u: f64) -> (usize, f64, f64) {
        let position = u * self.per_u;
        let inside = position.min(self.last_u);
        // Conversions of 32 bits take far fewer instructions than those of a `usize`.
        let i = (inside as u32).min(self.last_u as u32 - 1);
        (i as usize, inside - f64::from(i), position - inside)
    }
}

/// The quantities over `u` and `s` at one of the map's `B/D`; the nodes of a row are made when they are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    pub lattice: Lattice,
    /// By `u`, then `s`, then channel, as the map holds them.
    values: Cow<'static, [u8]>,
    /// Their slopes over `u`, per node spacing.
    over_u: Vec<f64>,
}

impl Tabulated {
    /// Makes the table from `us * ss` node values, ordered by `u`, then `s`, then channel; `u` ends at `last_u`.
    pub fn new(values: Cow<'static, [u8]>, us: usize, ss: usize, last_u: f64) -> Self {
        let mut over_u = vec![0.0; values.len() / NUMBER];
        let all: Vec<f64> = numbers(&values).collect();
        Spline::new(us, [SplineEnd::Free; 2]).slopes_of_many(ss * CHANNELS, &all, &mut over_u);
        let last = (us - 1) as f64;
        let lattice = Lattice { ss, last_u: last, last_s: (ss - 1) as f64, per_u: last / last_u };
        Self { lattice, values, over_u }
    }

    /// The nodes of row `i`: one `u`, all `s`.
    pub fn row(&self, i: usize, along: &Along) -> Vec<Node> {
        let ss = self.lattice.ss;
        let (first, last) = (i * ss * CHANNELS, (i + 1) * ss * CHANNELS);
        let mut values: Vec<f64> = numbers(&self.values[first * NUMBER..last * NUMBER]).collect();
        let over_u = &self.over_u[first..last];
        if i > 0 {
            return nodes_of_row([&values, over_u], along);
        }
        level(&mut values);
        nodes_of_row([&values, &tilted(over_u)], along)
    }
}

/// Gives the quantities of a row in the centre one value for all directions of the load, their mean, and no lead. The tabulated
/// ones are 1e-4 apart, which would be a slope without bound to a solver that starts there.
pub fn level(values: &mut [f64]) {
    for channel in 0..CHANNELS {
        let all = || (channel..values.len()).step_by(CHANNELS);
        let sum: f64 = all().map(|k| values[k]).sum();
        let mean = if channel == LEAD { 0.0 } else { sum / all().count() as f64 };
        all().for_each(|k| values[k] = mean);
    }
}

/// Slopes over `u` in the centre as a function has them that is differentiable there: they go with the cosine of the angle from
/// eccentricity to load, the lead's with its sine. The amplitudes are those nearest to the given slopes by least squares.
fn tilted(slopes: &[f64]) -> Vec<f64> {
    let last = (slopes.len() / CHANNELS - 1) as f64;
    let wave = |k: usize| {
        let angle = Point { u: 0.0, s: (k / CHANNELS) as f64 / last }.angle();
        if k % CHANNELS == LEAD { angle.sin() } else { angle.cos() }
    };
    let mut sums = [[0.0; 2]; CHANNELS];
    for (k, slope) in slopes.iter().enumerate() {
        let [product, square] = &mut sums[k % CHANNELS];
        *product += slope * wave(k);
        *square += wave(k).powi(2);
    }
    let amplitudes = sums.map(|[product, square]| product / square);
    (0..slopes.len()).map(|k| amplitudes[k % CHANNELS] * wave(k)).collect()
}

/// Splines over `s`, even and odd at both ends.
pub type Along = [Spline; 2];

/// The splines over `s`, for rows of `ss` nodes.
pub fn splines_over_s(ss: usize) -> Along {
    [SplineEnd::Even, SplineEnd::Odd].map(|end| Spline::new(ss, [end; 2]))
}

/// The nodes of a row from its values and their slopes along the rows, both by `s`, then channel.
pub fn nodes_of_row(row: [&[f64]; 2], along: &Along) -> Vec<Node> {
    let mut slopes = [vec![0.0; row[0].len()], vec![0.0; row[0].len()]];
    let mut nodes = vec![Node::default(); row[0].len() / CHANNELS];
    for (kind, values) in row.into_iter().enumerate() {
        for (spline, slopes) in along.iter().zip(&mut slopes) {
            spline.slopes_of_many(CHANNELS, values, slopes);
        }
        let all = [values, &slopes[0], &slopes[1]].map(|of| of.as_chunks().0);
        for (j, node) in nodes.iter_mut().enumerate() {
            (node[kind], node[2 + kind]) = (all[0][j], all[1][j]);
            node[2 + kind][LEAD] = all[2][j][LEAD];
        }
    }
    nodes
}
