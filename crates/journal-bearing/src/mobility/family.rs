//! The slices of a map, prepared once, from which the slice of any `B/D` is quickly made.

use super::map::{CHANNELS, MobilityMap};
use super::slice::{MobilitySlice, Node, Tabulated};
use super::spline::{End, Spline, hermite};
use std::sync::Arc;

/// Where a node has its values, and among them `ln |M|`.
const VALUE: usize = 0;
const MOBILITY: usize = 0;
/// The power of `B/D` that the mobility of a short bearing goes with.
const SHORT: f64 = -2.0;

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
    /// What is added to `ln |M|`: beyond the narrow end.
    rise: f64,
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
                node[VALUE][MOBILITY] += self.rise;
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
    /// The table reaches from 0.1 to 4. Narrower bearings go on to the short one, `|M| ~ (D/B)^2`: what is left of the
    /// difference to it falls with the square of `B/D`, as does what the Reynolds equation's terms around the bush
    /// change. Wider bearings are taken as 4.
    pub fn slice(self: &Arc<Self>, width_to_diameter: f64) -> MobilitySlice {
        let last = (self.slices.len() - 1) as f64;
        let position = (width_to_diameter.ln() - self.first) / self.spacing;
        let position = if position.is_nan() {
            last
        } else {
            position.min(last)
        };
        let cell = (position.max(0.0) as usize).min(self.slices.len() - 2);
        let (weights, rise) = if position < 0.0 {
            let beyond = position * self.spacing;
            // Half of what falls: for each unit that the slope at the end differs from the short bearing's.
            let fallen = 0.5 * (2.0 * beyond).exp_m1();
            let weights = [1.0, 0.0, fallen / self.spacing, 0.0];
            (weights, SHORT * (beyond - fallen))
        } else {
            (hermite(position - cell as f64), 0.0)
        };
        let blend = Blend {
            family: Arc::clone(self),
            cell,
            weights,
            rise,
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
        assert!((power + 2.0).abs() < 0.01, "{power}");
        // Without a bend at the table's end.
        let powers = [1e-4_f64, -1e-4].map(|d| (at(0.1 * d.exp()) / at(0.1)).ln() / d);
        assert!((powers[0] - powers[1]).abs() < 2e-3, "{powers:?}");
    }

    /// The short bearing's exact mobility along the line of centres, `(D/B)^2 / (2 I)` with the integral `I` of
    /// `cos^2 / (1 - e cos)^3` over the half that closes (Ocvirk's pressure, squeezed: Booker 1965).
    #[test]
    fn narrow_bearings_have_the_short_one_s_mobility() {
        let family = SliceFamily::new(&MobilityMap::built_in().unwrap());
        for width in [0.01_f64, 0.03] {
            for e in [0.0, 0.4, 0.8, 0.9] {
                let n = 4000;
                let d = std::f64::consts::PI / f64::from(n);
                let integrand = |k: i32| {
                    let cos = ((f64::from(k) + 0.5) * d - std::f64::consts::FRAC_PI_2).cos();
                    d * cos * cos / (1.0 - e * cos).powi(3)
                };
                let integral: f64 = (0..n).map(integrand).sum();
                let exact = 0.5 / (integral * width * width);
                let ratio = family.slice(width).mobility(e, 1.0, 0.0).0 / exact;
                assert!((ratio - 1.0).abs() < 0.01, "B/D {width}, e {e}: {ratio}");
            }
        }
    }
}
