//! The slices of a map, prepared once, from which the slice of any `B/D` is quickly made.

use super::map::{CHANNELS, MobilityMap};
use super::slice::{MobilitySlice, Node};
use super::spline::{End, hermite, slopes};

/// A map's slices with their slopes over `ln(B/D)`.
#[derive(Clone, Debug)]
pub struct SliceFamily {
    /// `ln(B/D)` of the first slice.
    first: f64,
    /// Distance of the slices in `ln(B/D)`.
    spacing: f64,
    slices: Vec<MobilitySlice>,
    /// Slopes of each slice's nodes per spacing, of the twice differentiable spline over all slices.
    slopes: Vec<Vec<Node>>,
}

impl SliceFamily {
    /// Prepares a map.
    pub fn new(map: &MobilityMap) -> Self {
        let slices = map.slices();
        let (count, nodes) = (slices.len(), slices[0].nodes().len());
        let mut over_width = vec![vec![Node::default(); nodes]; count];
        let (mut line, mut slope) = (vec![0.0; count], vec![0.0; count]);
        for node in 0..nodes {
            for kind in 0..4 {
                for channel in 0..CHANNELS {
                    for (value, slice) in line.iter_mut().zip(&slices) {
                        *value = slice.nodes()[node][kind][channel];
                    }
                    slopes(&line, [End::Free; 2], &mut slope);
                    for (nodes, slope) in over_width.iter_mut().zip(&slope) {
                        nodes[node][kind][channel] = *slope;
                    }
                }
            }
        }
        Self {
            first: map.width(0).ln(),
            spacing: (map.width(1) / map.width(0)).ln(),
            slices,
            slopes: over_width,
        }
    }

    /// The map at one width-to-diameter ratio `B/D > 0`, prepared for fast look-ups.
    ///
    /// The table reaches from 0.1 to 4. Narrower bearings continue with the power of `B/D` found
    /// at its end (the short bearing's, `|M| ~ (D/B)^2`); wider ones are taken as 4.
    pub fn slice(&self, width_to_diameter: f64) -> MobilitySlice {
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
        let (near, far) = (&self.slices[cell], &self.slices[cell + 1]);
        let nodes = near
            .nodes()
            .iter()
            .zip(far.nodes())
            .zip(self.slopes[cell].iter().zip(&self.slopes[cell + 1]))
            .map(|((near, far), (near_slope, far_slope))| {
                let mut node = Node::default();
                for kind in 0..4 {
                    for channel in 0..CHANNELS {
                        node[kind][channel] = weights[0] * near[kind][channel]
                            + weights[1] * far[kind][channel]
                            + weights[2] * near_slope[kind][channel]
                            + weights[3] * far_slope[kind][channel];
                    }
                }
                node
            })
            .collect();
        near.with_nodes(nodes)
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
            for (a, b) in [(0.3, 0.5), (0.9, 2.0), (0.99, -0.4)].map(|(e, phi): (f64, f64)| {
                (
                    made.mobility(e, phi.cos(), phi.sin()),
                    slice.mobility(e, phi.cos(), phi.sin()),
                )
            }) {
                assert!((a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-9 * (b.0.abs() + b.1.abs()));
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
