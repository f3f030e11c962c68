//! Interpolation over `B/D`: a slice between two tabulated ones, made row by row.

use std::sync::Arc;

use super::table::{CHANNELS, MOBILITY, Node, Tabulated, VALUE};

/// The map's slices and their slopes over `ln(B/D)`: what every blend is made from.
#[derive(Clone, Debug)]
pub struct Sources {
    pub slices: Vec<Tabulated>,
    /// Per slice, the slope of each node per slice spacing, from the spline over all slices.
    pub slopes: Vec<Vec<Node>>,
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
        let (sources, cell) = (&*self.sources, self.cell);
        let row = sources.slices[cell].lattice.row(i);
        let near = &sources.slices[cell].nodes[row.clone()];
        let far = &sources.slices[cell + 1].nodes[row.clone()];
        let near_slope = &sources.slopes[cell][row.clone()];
        let far_slope = &sources.slopes[cell + 1][row];
        let sources = near.iter().zip(far).zip(near_slope.iter().zip(far_slope));
        let [a, b, c, d] = self.weights;
        sources
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
