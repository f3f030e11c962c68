//! Interpolation over `B/D`: a slice between two tabulated ones, made row by row.

use std::sync::{Arc, OnceLock};

use super::table::{Along, CHANNELS, MOBILITY, Node, Tabulated, VALUE, splines_over_s};
use crate::spline::{Spline, SplineEnd};

/// The map's slices and their slopes over `ln(B/D)`: what every blend is made from.
#[derive(Clone, Debug)]
pub struct Sources {
    pub slices: Vec<Tabulated>,
    over_s: Along,
    over_width: Spline,
    /// One per row. A journal visits few of them, and a process may live for one simulation only, so each is made on
    /// first use.
    rows: Vec<OnceLock<SourceRow>>,
}

/// The nodes of one row in all slices.
#[derive(Clone, Debug)]
struct SourceRow {
    /// By slice, then `s`.
    nodes: Vec<Node>,
    /// The slope of each node per slice spacing, from the spline over all slices.
    slopes: Vec<Node>,
}

impl Sources {
    /// Sources from slices that have the same lattice.
    pub fn new(slices: Vec<Tabulated>) -> Self {
        let lattice = slices[0].lattice;
        Self {
            over_s: splines_over_s(lattice.ss),
            over_width: Spline::new(slices.len(), [SplineEnd::Free; 2]),
            rows: vec![OnceLock::new(); lattice.last_u as usize + 1],
            slices,
        }
    }

    fn row(&self, i: usize) -> &SourceRow {
        self.rows[i].get_or_init(|| {
            let rows = self.slices.iter().map(|slice| slice.row(i, &self.over_s));
            let nodes: Vec<Node> = rows.flatten().collect();
            let mut slopes = vec![Node::default(); nodes.len()];
            let many = self.slices[0].lattice.ss * 4 * CHANNELS;
            let values = nodes.as_flattened().as_flattened();
            let over_width = slopes.as_flattened_mut().as_flattened_mut();
            self.over_width.slopes_of_many(many, values, over_width);
            SourceRow { nodes, slopes }
        })
    }
}

/// A slice at any `B/D` as a weighted sum of two neighbouring tabulated slices and their slopes.
#[derive(Clone, Debug)]
pub struct Blend {
    pub sources: Arc<Sources>,
    /// Index of the narrower of both slices.
    pub cell: usize,
    /// Weights of the narrower and the wider slice, then of their slopes.
    pub weights: [f64; 4],
    /// Added to `ln |M|` where the bearing is narrower than the table's first slice.
    pub rise: f64,
}

impl Blend {
    /// The nodes of row `i`: one `u`, all `s`.
    pub fn row(&self, i: usize) -> Box<[Node]> {
        let ss = self.sources.slices[0].lattice.ss;
        let source = self.sources.row(i);
        let slice = |k: usize| k * ss..(k + 1) * ss;
        let (near, far) = (slice(self.cell), slice(self.cell + 1));
        let nodes = source.nodes[near.clone()].iter().zip(&source.nodes[far.clone()]);
        let slopes = source.slopes[near].iter().zip(&source.slopes[far]);
        let [a, b, c, d] = self.weights;
        nodes
            .zip(slopes)
            .map(|((near, far), (near_slope, far_slope))| {
                let mut node = Node::default();
                for kind in 0..4 {
                    for channel in 0..CHANNELS {
                        node[kind][channel] = a * near[kind][channel]
                            + b * far[kind][channel]
                            + c * near_slope[kind][channel]
                            + d * far_slope[kind][channel];
                    }
                }
                node[VALUE][MOBILITY] += self.rise;
                node
            })
            .collect()
    }
}
