//! The slices of a map, prepared once, from which the slice of any `B/D` is quickly made.

use super::map::{CHANNELS, MobilityMap};
use super::slice::{MobilitySlice, Node, Tabulated};
use super::spline::{End, Spline, hermite};
use std::sync::Arc;

/// A map's slices with their slopes over `ln(B/D)`.
#[derive(Clone, Debug)]
pub struct SliceFamily {
    /// `ln(B/D)` of the first slice.
    first: f64,
    /// Distance of the slices in `ln(B/D)`.
    spacing: f64,
    slices: Vec<Tabulated>,
    /// Slopes of each slice's nodes per spacing, of the twice differentiable spline over all slices.
    slopes: Vec<Vec<Node>>,
}

/// How the nodes of a slice between two tabulated ones are made of these.
#[derive(Clone, Debug)]
pub(super) struct Blend {
    family: Arc<SliceFamily>,
    cell: usize,
    /// Of both slices and of their slopes.
    weights: [f64; 4],
}

impl Blend {
    /// The nodes of a row over `s`.
    pub(super) fn row(&self, i: usize) -> Box<[Node]> {
        let (family, cell) = (&*self.family, self.cell);
        let row = family.slices[cell].grid.row(i);
        let near = &family.slices[cell].nodes[row.clone()];
        let far = &family.slices[cell + 1].nodes[row.clone()];
        let near_slope = &family.slopes[cell][row.clone()];
        let far_slope = &family.slopes[cell + 1][row];
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
                node
            })
            .collect()
    }
}

impl SliceFamily {
    /// Prepares a map.
    pub fn new(map: &MobilityMap) -> Arc<Self> {
        let slices = map.slices();
        let (count, nodes) = (slices.len(), slices[0].nodes.len());
        let spline = Spline::new(count, [End::Free; 2]);
        let mut over_width = vec![vec![Node::default(); nodes]; count];
        let (mut line, mut slope) = (vec![0.0; count], vec![0.0; count]);
        for node in 0..nodes {
            for kind in 0..4 {
                for channel in 0..CHANNELS {
                    for (value, slice) in line.iter_mut().zip(&slices) {
                        *value = slice.nodes[node][kind][channel];
                    }
                    spline.slopes(&line, &mut slope);
                    for (nodes, slope) in over_width.iter_mut().zip(&slope) {
                        nodes[node][kind][channel] = *slope;
                    }
                }
            }
        }
        Arc::new(Self {
            first: map.width(0).ln(),
            spacing: (map.width(1) / map.width(0)).ln(),
            slices,
            slopes: over_width,
        })
    }

    /// The map at one width-to-diameter ratio `B/D > 0`, prepared for fast look-ups.
    ///
    /// The table reaches from 0.1 to 4. Narrower bearings continue with the power of `B/D` found
    /// at its end (the short bearing's, `|M| ~ (D/B)^2`); wider ones are taken as 4.
    pub fn slice(self: &Arc<Self>, width_to_diameter: f64) -> MobilitySlice {
        let last = (self.slices.len() - 1) as f64;
        let position = (width_to_diameter.ln() - self.first) / self.spacing;
        let position = if position.is_nan() {
            last
        } else {
            position.min(last)
        };
        let cell = (position.max(0.0) as usize).min(self.slices.len() - 2);
        let weights = if position < 0.0 {
            [1.0 - position, position, 0.0, 0.0]
        } else {
            hermite(position - cell as f64)
        };
        let blend = Blend {
            family: Arc::clone(self),
            cell,
            weights,
        };
        MobilitySlice::new(self.slices[cell].grid, blend)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_widths_come_back() {
        let map = MobilityMap::built_in().unwrap();
        let family = SliceFamily::new(&map);
        for (k, slice) in map.slices().iter().enumerate() {
            let made = family.slice(map.width(k));
            for i in [0, 7, 40] {
                let tabulated = &slice.nodes[slice.grid.row(i)];
                for (a, b) in made.row(i).iter().flatten().zip(tabulated.iter().flatten()) {
                    for (a, b) in a.iter().zip(b) {
                        assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn narrow_bearings_go_on_as_short_ones() {
        let family = SliceFamily::new(&MobilityMap::built_in().unwrap());
        let at = |width: f64| family.slice(width).mobility(0.6, 1.0, 0.0).0;
        let power = (at(0.02) / at(0.05)).ln() / (0.02f64 / 0.05).ln();
        assert!((power + 2.0).abs() < 0.05, "{power}");
    }
}
