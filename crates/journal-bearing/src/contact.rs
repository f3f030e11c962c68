//! Asperity contact of journal and bush (Greenwood & Tripp 1970, "The contact of two nominally flat rough surfaces", Proc.
//! IMechE 185, 625-633).
//!
//! # Examples
//! ```
//! use journal_bearing::contact::{ContactTable, Surface};
//!
//! let surface = Surface { roughness: 1e-6, ..Surface::default() };
//! // Clearance, width and diameter in m.
//! let table = ContactTable::new(&surface, 20e-6, 0.019, 0.025);
//! assert_eq!(table.at(0.5).force, 0.0); // 10 um apart, ten times the roughness
//! assert!(table.at(0.95).force > 100.0); // N
//! ```

mod clearances;
mod friction;
mod integral;

pub use crate::roughness::NO_CONTACT;
use crate::{
    roughness::{Reach, resistance},
    spline::hermite,
};
pub use clearances::{ContactAt, ContactFamily};
pub use friction::direction;
pub use integral::f_5_2;
use integral::f_5_2_log;
use serde::{Deserialize, Serialize};
use std::{
    f64::consts::{PI, SQRT_2},
    sync::{LazyLock, OnceLock},
};

/// The asperities of both surfaces together, and their boundary friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Composite rms roughness and waviness sigma of both surfaces, m. Zero switches contact off.
    pub roughness: f64,
    /// `eta*beta*sigma`: asperities per area times summit radius times roughness, 1.
    pub asperity_density: f64,
    /// `sigma/beta`: roughness over summit radius, 1.
    pub asperity_slope: f64,
    /// Composite elastic modulus `E* = 1/((1-nu1^2)/E1 + (1-nu2^2)/E2)`, Pa.
    pub composite_modulus: f64,
    /// Friction coefficient of asperities that slide, 1.
    pub boundary_friction: f64,
    /// Their friction at breakaway over that, 1.
    pub breakaway_ratio: f64,
    /// Sliding speed over which friction falls from breakaway to boundary friction, m/s.
    pub transition_speed: f64,
}

impl Default for Surface {
    fn default() -> Self {
        Self {
            roughness: 5.13e-6,
            asperity_density: 0.05,
            asperity_slope: 0.01,
            composite_modulus: 80e9,
            boundary_friction: 0.05,
            breakaway_ratio: 1.0,
            transition_speed: 1e-3,
        }
    }
}

impl Surface {
    /// Whether the surfaces have asperities that bear load.
    pub fn touches(&self) -> bool {
        self.roughness > 0.0 && self.pressure_scale() > 0.0
    }

    /// Contact pressure over the nominal area at `F_5/2 = 1`, Pa:
    /// `16*sqrt(2)*pi/15 * (eta*beta*sigma)^2 * sqrt(sigma/beta) * E*` (Greenwood & Tripp 1970, eq. 12).
    pub fn pressure_scale(&self) -> f64 {
        16.0 * SQRT_2 * PI / 15.0 * self.asperity_density.powi(2) * self.asperity_slope.sqrt() * self.composite_modulus
    }

    /// Logarithm of the contact force, N, over its integral around a bearing of width and diameter in m.
    fn log_force_scale(&self, width: f64, diameter: f64) -> f64 {
        let area = 0.5 * diameter * width;
        (self.pressure_scale() * area).ln()
    }
}

/// Contact forces of an aligned, round journal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Resultant force on the journal, directed against the eccentricity, N.
    pub force: f64,
    /// The contact pressure integrated over the surface, N: the normal force of boundary friction.
    pub normal: f64,
}

/// Contact and film of an aligned, round journal whose asperities touch the bush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// The contact's forces.
    pub contact: Contact,
    /// The film's shear, 1: its friction torque, when it is full, over `eta (omega_journal - omega_bush) R^3 B/c`. It is
    /// `2 pi/sqrt(1 - e^2)` between smooth surfaces (Sommerfeld 1904).
    pub shear: f64,
    /// The relative gap of the smooth bearing to which the film's mobility is compared, 1.
    pub room: f64,
    /// The place in the table of rough films, from 0 where contact begins to 1 at its end.
    pub place: f64,
}

/// The contact of an aligned, round journal, tabulated over its eccentricity ratio.
///
/// Resultant and normal force are integrals of the contact pressure around the circumference. They span many decades, so
/// the table interpolates the logarithms of resultant force over eccentricity ratio and of normal force, by cubic Hermite
/// polynomials with exact slopes. It reaches from where the asperities meet to where the mean planes have crossed by three
/// roughnesses; beyond, the logarithms go on along their tangents, and far beyond the forces do, so that they stay finite.
#[derive(Clone, Debug, Default)]
pub struct ContactTable {
    /// Eccentricity ratio of the first node: where contact begins.
    start: f64,
    /// Distance of the nodes in the eccentricity ratio.
    spacing: f64,
    /// Nodes per eccentricity ratio.
    per_spacing: f64,
    /// Clearance over roughness, 1.
    ratio: f64,
    /// Logarithm of the force over the integrals, N.
    scale: f64,
    /// A journal visits few of them, so each is made on first use.
    nodes: Vec<OnceLock<Node>>,
}

/// Logarithms of resultant and normal force; shear, room and place of the film: their values at a node, and their slopes times
/// the spacing.
type Node = [[f64; QUANTITIES]; 2];

const QUANTITIES: usize = 5;
/// The first quantities are logarithms.
const LOGARITHMS: usize = 2;

const NODES: usize = 93;
/// Quadrature points over half the circumference (trapezoidal rule: spectral for a periodic integrand).
const QUADRATURE: usize = 64;

/// Squares of cosine and sine of half the angles of an even spacing.
static HALVES: LazyLock<[[f64; 2]; QUADRATURE + 1]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let (sin, cos) = (0.5 * PI * k as f64 / QUADRATURE as f64).sin_cos();
        [cos * cos, sin * sin]
    })
});

/// Cosine and weight of each point. They crowd about the narrowest place, `tan(theta/2) = b tan(phi/2)` over even `phi`, as
/// the patch where fine asperities touch is short.
fn points(ratio: f64) -> impl Iterator<Item = [f64; 2]> {
    let b2 = (5.0 / ratio).min(1.0);
    let even = b2.sqrt() * PI / QUADRATURE as f64;
    HALVES.iter().enumerate().map(move |(k, [cos2, sin2])| {
        let end = k == 0 || k == QUADRATURE;
        let sum = cos2 + b2 * sin2;
        [(cos2 - b2 * sin2) / sum, even / sum * if end { 1.0 } else { 2.0 }]
    })
}

impl ContactTable {
    /// Tabulates the contact of a bearing with radial clearance, width and diameter in m, all positive.
    pub fn new(surface: &Surface, clearance: f64, width: f64, diameter: f64) -> Self {
        if !surface.touches() {
            return Self::default();
        }
        Self { scale: surface.log_force_scale(width, diameter), ..Self::of_integrals(surface.roughness, clearance) }
    }

    /// Tabulates the integrals alone, which depend on roughness and clearance (m) only.
    fn of_integrals(roughness: f64, clearance: f64) -> Self {
        let reach = Reach::new(roughness / clearance);
        let spacing = reach.length / (NODES - 1) as f64;
        Self {
            start: reach.start,
            spacing,
            per_spacing: 1.0 / spacing,
            ratio: clearance / roughness,
            scale: 0.0,
            nodes: vec![OnceLock::new(); NODES],
        }
    }

    /// The knots at both ends of a cell.
    #[inline]
    fn ends(&self, cell: usize) -> [&Node; 2] {
        let [left, right] = [cell, cell + 1];
        let nodes = &self.nodes[left..=right];
        [nodes[0].get_or_init(|| self.node(left)), nodes[1].get_or_init(|| self.node(right))]
    }

    #[cold]
    fn node(&self, i: usize) -> Node {
        let e = self.start + i as f64 * self.spacing;
        let mut node = integrals(e, self.ratio, self.spacing);
        for log in &mut node[0][..LOGARITHMS] {
            *log += self.scale;
        }
        node
    }

    /// The contact at an eccentricity ratio.
    pub fn at(&self, eccentricity_ratio: f64) -> Contact {
        let touch = self.touch(eccentricity_ratio);
        touch.map_or_else(Contact::default, |touch| touch.contact)
    }

    /// Contact and film at an eccentricity ratio; `None` where the asperities do not touch.
    #[inline]
    pub fn touch(&self, eccentricity_ratio: f64) -> Option<Touch> {
        let position = (eccentricity_ratio - self.start) * self.per_spacing;
        if self.nodes.is_empty() || position < 0.0 {
            return None;
        }
        let place = TablePlace::new(position);
        let mut quantities = [0.0; QUANTITIES];
        place.add(self.ends(place.cell), 1.0, &mut quantities);
        Some(place.touch(&quantities, eccentricity_ratio, self.start))
    }
}

/// The rise of a force's logarithm beyond the table. Where no surface is left, the force itself goes on along its tangent: a solver
/// looks there for a moment, and must get a number.
fn tamed(rise: f64) -> f64 {
    /// Half a billion times the force at the table's end.
    const STEEPEST: f64 = 20.0;
    if rise > STEEPEST { STEEPEST + (rise - STEEPEST).ln_1p() } else { rise }
}

/// A place in a table.
struct TablePlace {
    cell: usize,
    /// The share of the cell before it, above one beyond the last.
    t: f64,
    /// Weights of the cell's nodes: values, then slopes.
    weights: [f64; 4],
}

impl TablePlace {
    /// The place at a position along the nodes.
    #[inline]
    fn new(position: f64) -> Self {
        let cell = (position as u32).min(NODES as u32 - 2);
        let t = position - f64::from(cell);
        Self { cell: cell as usize, t, weights: hermite(t.min(1.0)) }
    }

    /// Adds a share of the quantities between the nodes of a table's cell. Beyond the table, logarithms go on along their tangents.
    #[inline(always)]
    fn add(&self, [left, right]: [&Node; 2], share: f64, sum: &mut [f64; QUANTITIES]) {
        let [a, b, c, d] = self.weights.map(|weight| share * weight);
        for (k, sum) in sum.iter_mut().enumerate() {
            *sum += a * left[0][k] + b * right[0][k] + c * left[1][k] + d * right[1][k];
        }
        if self.t > 1.0 {
            for (sum, slope) in sum[..LOGARITHMS].iter_mut().zip(&right[1]) {
                *sum += share * tamed((self.t - 1.0) * slope);
            }
        }
    }

    /// Contact and film of these quantities, at an eccentricity ratio in a table that starts at another.
    #[inline]
    fn touch(&self, quantities: &[f64; QUANTITIES], ratio: f64, start: f64) -> Touch {
        let [force, normal, shear, room, place] = *quantities;
        let t = self.t;
        // Where contact begins off the centre it fades in, so that the force has no jump.
        let fades = self.cell == 0 && start > 0.0;
        let fade = if fades { t * t * (3.0 - 2.0 * t) } else { 1.0 };
        Touch {
            contact: Contact { force: fade * ratio * force.exp(), normal: fade * normal.exp() },
            shear,
            room,
            place,
        }
    }
}

/// Logarithms of the integrals of `F_5/2(H)*cos(theta)/e` and of `F_5/2(H)` over the circumference, the integral of the
/// film's resistance to sliding, room and place, with their slopes over `e`: `H = ratio*(1 - e*cos(theta))`.
fn integrals(e: f64, ratio: f64, spacing: f64) -> Node {
    // All are even functions of e. At e = 0 the first is a quotient of zeros, so it is evaluated close by.
    let near_centre = e < 1e-5;
    let reach = Reach::new(1.0 / ratio);
    let [room, place] = [reach.room(e), reach.place(e)];
    let e = e.max(1e-5);
    // Values are relative to the largest, which may underflow by itself.
    let reference = f_5_2_log(ratio * (1.0 - e)).0;
    let (mut sums, mut slopes) = ([0.0; 3], [0.0; 3]);
    for [cos, weight] in points(ratio) {
        let h = ratio * (1.0 - e * cos);
        let (exponent, slope) = f_5_2_log(h);
        let pressure = weight * (exponent - reference).exp();
        let [resistance, easing] = resistance(h).map(|of| of * weight * ratio);
        let opening = -ratio * cos;
        for (j, factor) in [cos, 1.0].into_iter().enumerate() {
            sums[j] += pressure * factor;
            slopes[j] += pressure * slope * opening * factor;
        }
        sums[2] += resistance;
        slopes[2] += easing * opening;
    }
    let even = if near_centre { 0.0 } else { spacing };
    [
        [reference + (sums[0] / e).ln(), reference + sums[1].ln(), sums[2], room[0], place[0]],
        [
            (slopes[0] / sums[0] - 1.0 / e) * even,
            slopes[1] / sums[1] * even,
            slopes[2] * even,
            room[1] * spacing,
            place[1] * spacing,
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_the_integral_of_the_pressure() {
        let surface = Surface::default();
        let (width, diameter) = (0.019, 0.025);
        for (c, eccentricities) in [
            (2e-5, &[0.5, 0.7, 0.83, 0.9, 0.95, 0.99, 0.9999][..]),
            (8e-6, &[1e-3, 0.01, 0.02, 0.1, 0.5, 0.9, 0.9999]),
            (2e-6, &[1e-3, 0.3, 0.9]),
        ] {
            let table = ContactTable::new(&surface, c, width, diameter);
            for &e in eccentricities {
                let n = 4000;
                let (mut force, mut normal) = (0.0, 0.0);
                for k in 0..n {
                    let cos = (2.0 * PI * k as f64 / n as f64).cos();
                    let ratio = c * (1.0 - e * cos) / surface.roughness;
                    let p = surface.pressure_scale() * f_5_2(ratio).0;
                    force += p * cos;
                    normal += p;
                }
                let element = 2.0 * PI / n as f64 * 0.5 * diameter * width;
                let contact = table.at(e);
                let apart = (contact.force / (force * element) - 1.0).abs();
                assert!(apart < 1e-5, "c = {c}, e = {e}: {contact:?}");
                assert!((contact.normal / (normal * element) - 1.0).abs() < 1e-5);
            }
        }
    }

    /// Closed forms on both sides of the change, and a number everywhere.
    #[test]
    fn far_beyond_the_table_forces_grow_evenly() {
        assert_eq!([-3.0, 0.0, 19.0, 20.0].map(tamed), [-3.0, 0.0, 19.0, 20.0]);
        let force = |rise: f64| tamed(rise).exp() / 20.0_f64.exp();
        assert!((force(20.0 + 1e-6) - force(20.0 - 1e-6) - 2e-6).abs() < 1e-11);
        assert!((force(1020.0) - 1001.0).abs() < 1e-9);
        let surface = Surface { roughness: 1e-7, ..Surface::default() };
        let (table, family) =
            (ContactTable::new(&surface, 20e-6, 0.019, 0.025), ContactFamily::new(&surface, 20e-6, 0.019, 0.025));
        for e in [2.0, 42.7, 1e6] {
            for contact in [table.at(e), family.at(e, 21e-6)] {
                assert!(contact.force.is_finite() && contact.normal.is_finite(), "{e}: {contact:?}");
                assert!(contact.force > table.at(1.0).force);
            }
        }
    }

    #[test]
    fn smooth_surfaces_do_not_touch() {
        let surface = Surface { roughness: 0.0, ..Surface::default() };
        let table = ContactTable::new(&surface, 2e-5, 0.019, 0.025);
        assert_eq!(table.at(0.999), Contact::default());
    }
}
