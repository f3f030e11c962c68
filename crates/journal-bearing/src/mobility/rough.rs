//! How roughness changes the mobility where asperities touch: a table of corrections to the smooth bearing's map.
//!
//! A journal in contact stands beside a smooth one whose relative gap is the [room](Reach::room) that the asperities leave.
//! The table holds by how much the rough film's quantities ([`RoughFilm::MeanGap`](crate::reynolds::RoughFilm)) differ from
//! those of the smooth film there, over `B/D`, over roughness over clearance, over the place between first touch and a crossing
//! of the mean planes by three roughnesses, and over the load's direction. All are zero at first touch.

use std::sync::{Arc, OnceLock};

use super::{
    coordinates::Point,
    map::MapError,
    table::{Along, CHANNELS, NUMBER, Node, level, nodes_of_row, numbers, splines_over_s},
};
use crate::{
    roughness::{NO_CONTACT, Reach},
    spline::{Spline, SplineEnd, hermite, slope_of_hermite},
};

/// Nodes over `ln(B/D)`, roughness, place and direction.
pub const SIZE: [usize; 4] = [5, 9, 21, 25];
/// The first and the last `B/D`.
const WIDTHS: [f64; 2] = [0.1, 4.0];
/// The roughness over clearance at which contact reaches around the bush is node `AROUND`; no polynomial crosses it. Finer ones
/// are smaller by this ratio, each; coarser ones larger.
const AROUND: usize = 5;
const FINER: f64 = 2.5;
const COARSER: f64 = 1.518_294_485_937_831_4;

/// The finest roughness over clearance in the table. Finer surfaces are taken as this.
pub const FINEST: f64 = 1.0 / (NO_CONTACT * FINER * FINER * FINER * FINER * FINER);

/// The committed table: numbers as in the map's.
pub static COMMITTED: &[u8] = include_bytes!("rough.bin");

/// Bytes of the table.
const BYTES: usize = NUMBER * SIZE[0] * SIZE[1] * SIZE[2] * SIZE[3] * CHANNELS;

/// `B/D` of a node.
pub fn width(k: usize) -> f64 {
    let share = k as f64 / (SIZE[0] - 1) as f64;
    WIDTHS[0] * (WIDTHS[1] / WIDTHS[0]).powf(share)
}

/// Roughness over clearance of a node.
pub fn roughness(k: usize) -> f64 {
    let beyond = k as i32 - AROUND as i32;
    if beyond < 0 { FINER.powi(beyond) / NO_CONTACT } else { COARSER.powi(beyond) / NO_CONTACT }
}

/// The eccentricity ratio of a place.
pub fn eccentricity(reach: &Reach, k: usize) -> f64 {
    reach.at(k as f64 / (SIZE[2] - 1) as f64)
}

/// The angle from the eccentricity to the load of a direction, at a room.
pub fn angle(room: f64, k: usize) -> f64 {
    let s = k as f64 / (SIZE[3] - 1) as f64;
    Point { u: -room.ln(), s }.angle()
}

/// The corrections at one `B/D`; beyond the table, its edge counts. Those of a node over roughness are made on first use.
#[derive(Clone, Debug)]
pub struct Corrections {
    /// Weights of the nodes over `B/D`.
    widths: [f64; SIZE[0]],
    nodes: [OnceLock<Sheet>; SIZE[1]],
    along: Along,
}

/// Values by place, then direction, then channel; and their slopes over the place.
type Sheet = [Vec<f64>; 2];

/// The corrections at one `B/D` and one roughness.
#[derive(Clone, Debug)]
pub struct Correction {
    pub reach: Reach,
    corrections: Arc<Corrections>,
    /// The first of the nodes over roughness, and their weights.
    lowest: usize,
    weights: [f64; 4],
}

/// Numbers of one node over `B/D` and roughness.
const SHEET: usize = SIZE[2] * SIZE[3] * CHANNELS;

impl Corrections {
    /// The corrections at `B/D`.
    ///
    /// # Errors
    /// When the table is damaged: it has another size than it should.
    pub fn new(width_to_diameter: f64) -> Result<Self, MapError> {
        if COMMITTED.len() != BYTES {
            return Err(MapError("the table of rough films has another size".to_owned()));
        }
        let wide = (width_to_diameter / WIDTHS[0]).ln() / (WIDTHS[1] / WIDTHS[0]).ln();
        let last = (SIZE[0] - 1) as f64;
        Ok(Self {
            widths: weights((wide * last).clamp(0.0, last)),
            nodes: Default::default(),
            along: splines_over_s(SIZE[3]),
        })
    }

    /// Those of a node over roughness.
    fn node(&self, j: usize) -> &Sheet {
        self.nodes[j].get_or_init(|| {
            let mut values = vec![0.0; SHEET];
            for (k, weight) in self.widths.into_iter().enumerate() {
                let first = (k * SIZE[1] + j) * SHEET * NUMBER;
                let of = numbers(&COMMITTED[first..first + SHEET * NUMBER]);
                for (value, number) in values.iter_mut().zip(of) {
                    *value += weight * number;
                }
            }
            let mut over_place = vec![0.0; SHEET];
            // Even in the eccentricity ratio at the first place.
            let spline = Spline::new(SIZE[2], [SplineEnd::Even, SplineEnd::Free]);
            spline.slopes_of_many(SIZE[3] * CHANNELS, &values, &mut over_place);
            // In the centre where contact reaches around the bush; else these are zero.
            level(&mut values[..SIZE[3] * CHANNELS]);
            [values, over_place]
        })
    }

    /// The corrections at a roughness over clearance.
    pub fn at(self: &Arc<Self>, roughness_ratio: f64) -> Correction {
        let log = (NO_CONTACT * roughness_ratio).ln();
        let base = if log < 0.0 { FINER } else { COARSER };
        let last = (SIZE[1] - 1) as f64;
        let rough = (AROUND as f64 + log / base.ln()).clamp(0.0, last);
        let lowest = if rough >= AROUND as f64 { AROUND } else { (rough as usize).saturating_sub(1).min(AROUND - 3) };
        Correction {
            reach: Reach::new(roughness_ratio),
            corrections: Arc::clone(self),
            lowest,
            weights: weights(rough - lowest as f64),
        }
    }
}

impl Correction {
    /// The corrections at place `i` in `count` even directions, with slopes over places and directions per their spacing.
    pub fn row(&self, i: usize, count: usize) -> impl Iterator<Item = Node> {
        let per_direction = (SIZE[3] - 1) as f64 / (count - 1) as f64;
        let row = i * SIZE[3] * CHANNELS..(i + 1) * SIZE[3] * CHANNELS;
        let sheets: [&Sheet; 4] = std::array::from_fn(|k| self.corrections.node(self.lowest + k));
        let [a, b, c, d] = self.weights;
        let blend = |kind: usize| -> Vec<f64> {
            let [p, q, r, s] = sheets.map(|sheet| &sheet[kind][row.clone()]);
            (0..p.len()).map(|n| a * p[n] + b * q[n] + c * r[n] + d * s[n]).collect()
        };
        let nodes = nodes_of_row([&blend(0), &blend(1)], &self.corrections.along);
        (0..count).map(move |k| {
            let position = k as f64 * per_direction;
            let j = (position as usize).min(SIZE[3] - 2);
            let x = position - j as f64;
            let weights = [hermite(x), slope_of_hermite(x).map(|w| w * per_direction)];
            std::array::from_fn(|kind| {
                let [a, b, c, d] = weights[kind >> 1];
                let [value, slope] = [kind & 1, kind | 2];
                let (near, far) = (&nodes[j], &nodes[j + 1]);
                std::array::from_fn(|channel| {
                    a * near[value][channel]
                        + b * far[value][channel]
                        + c * near[slope][channel]
                        + d * far[slope][channel]
                })
            })
        })
    }
}

/// Lagrange's weights of `N` nodes at the place `x`.
fn weights<const N: usize>(x: f64) -> [f64; N] {
    std::array::from_fn(|i| {
        let others = (0..N).filter(|&j| j != i);
        others.fold(1.0, |product, j| product * (x - j as f64) / (i as f64 - j as f64))
    })
}
