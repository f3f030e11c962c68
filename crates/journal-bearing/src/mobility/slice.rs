//! The map at one width-to-diameter ratio, for use in every time step.

use nalgebra::Vector2;
use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

use super::blend::Blend;
use super::coordinates::Point;
use crate::spline::hermite;
use super::table::{Lattice, Node};

/// The mobility of bearings of one `B/D`: the map's quantities over eccentricity ratio and load direction, with a
/// continuous first derivative.
#[derive(Clone, Debug)]
pub struct MobilitySlice {
    lattice: Lattice,
    /// One row per `u`. A journal visits few of them, so each is made on first use.
    rows: Vec<OnceLock<Box<[Node]>>>,
    blend: Blend,
}

/// One place of the map, located once; each quantity is interpolated only when it is asked for.
///
/// From [`MobilitySlice::look_up`].
#[derive(Clone, Copy, Debug)]
pub struct LookUp<'a> {
    slice: &'a MobilitySlice,
    place: Place,
    direction: Vector2<f64>,
    /// Sign of the angle from the eccentricity to the load.
    sign: f64,
}

impl LookUp<'_> {
    /// The mobility vector `M`, 1, in the frame in which the load's direction was given.
    #[inline]
    pub fn mobility(&self) -> Vector2<f64> {
        let [log_mobility, lead] = self.slice.pair::<0>(&self.place);
        // A lead beyond a right angle would mean that the film drives the journal. Only extrapolation beyond the table
        // can suggest that.
        let lead = lead.clamp(-FRAC_PI_2, FRAC_PI_2);
        // The lead is an odd function of the angle from eccentricity to load.
        let (sin, cos) = (self.sign * lead).sin_cos();
        let (x, y) = (self.direction.x, self.direction.y);
        Vector2::new(x * cos - y * sin, x * sin + y * cos) * log_mobility.exp()
    }

    /// The largest film pressure over `F / (B D)`, 1.
    pub fn max_pressure(&self) -> f64 {
        self.slice.pair::<1>(&self.place)[0].exp()
    }

    /// The oil flow out of both ends together over `F c^3 / (3 eta B^2)`, 1.
    #[inline]
    pub fn side_flow(&self) -> f64 {
        self.slice.pair::<1>(&self.place)[1].exp()
    }
}

/// A place in the table: indices of its cell's first node, and the weight of each number stored at its four corners.
#[derive(Clone, Copy, Debug)]
struct Place {
    near: [usize; 2],
    /// First index: corner; second index: number within a [`Node`].
    weights: [[f64; 4]; 4],
}

impl MobilitySlice {
    /// A slice whose rows `blend` makes.
    pub(super) fn new(lattice: Lattice, blend: Blend) -> Self {
        Self {
            lattice,
            rows: vec![OnceLock::new(); lattice.last_u as usize + 1],
            blend,
        }
    }

    /// The nodes of row `i`: one `u`, all `s`.
    #[inline]
    pub(super) fn row(&self, i: usize) -> &[Node] {
        self.rows[i].get_or_init(|| self.blend.row(i))
    }

    /// The components of the mobility along the eccentricity and 90 degrees ahead of it, 1.
    ///
    /// `e` is the eccentricity ratio, 0 <= e < 1; `cos` and `sin` belong to the angle by which the load is ahead of
    /// the eccentricity. A ratio of 1 or more is taken as just below 1.
    pub fn mobility(&self, e: f64, cos: f64, sin: f64) -> (f64, f64) {
        let mobility = self.mobility_vector(Vector2::new(e, 0.0), Vector2::new(cos, sin));
        (mobility.x, mobility.y)
    }

    /// The mobility vector `M`, 1, at the eccentricity-ratio vector `eps` under a load along the unit vector
    /// `direction`, in the frame of both.
    pub fn mobility_vector(&self, eps: Vector2<f64>, direction: Vector2<f64>) -> Vector2<f64> {
        self.look_up(eps, eps.norm(), direction).mobility()
    }

    /// Locates the eccentricity-ratio vector `eps`, whose length is `e`, under a load along the unit vector `direction`.
    ///
    /// # Examples
    /// The velocity (1/s) with which 750 N press the journal through the oil of a bearing at rest (Booker 1965):
    /// ```
    /// use journal_bearing::mobility::{MobilityMap, SliceFamily};
    /// use journal_bearing::nalgebra::Vector2;
    ///
    /// let (width, diameter, clearance, viscosity) = (0.019, 0.025, 20e-6, 0.02);
    /// let slice = SliceFamily::new(&MobilityMap::built_in()?).slice(width / diameter);
    /// let eps = Vector2::new(0.8, 0.3);
    /// let film = slice.look_up(eps, eps.norm(), Vector2::x());
    /// let psi = clearance / (0.5 * diameter);
    /// let velocity = film.mobility() * (750.0 * psi * psi / (viscosity * width * diameter));
    /// assert!(velocity.x > 0.0);
    /// assert!(film.max_pressure() * 750.0 / (width * diameter) > 2e6); // Pa
    /// # Ok::<(), journal_bearing::mobility::MapError>(())
    /// ```
    #[inline]
    pub fn look_up(&self, eps: Vector2<f64>, e: f64, direction: Vector2<f64>) -> LookUp<'_> {
        let (cos, sin) = if e > 0.0 {
            let inverse = 1.0 / e;
            (
                eps.dot(&direction) * inverse,
                eps.perp(&direction) * inverse,
            )
        } else {
            (1.0, 0.0)
        };
        LookUp {
            slice: self,
            place: self.place(Point::new(e, cos, sin)),
            direction,
            sign: if sin < 0.0 { -1.0 } else { 1.0 },
        }
    }

    #[inline]
    fn place(&self, point: Point) -> Place {
        let lattice = &self.lattice;
        let position = point.u * lattice.per_u;
        let across = (point.s * lattice.last_s).clamp(0.0, lattice.last_s);
        let inside = position.min(lattice.last_u);
        let i = (inside as usize).min(lattice.last_u as usize - 1);
        let j = (across as usize).min(lattice.ss - 2);
        // Beyond the last node over u, the surface continues along its tangent.
        let x = inside - i as f64;
        let excess = position - inside;
        let [a0, a1, b0, b1] = hermite(x);
        let along = [a0, a1, b0, b1 + excess];
        let wide = hermite(across - j as f64);
        let corner = |k: usize| {
            let (value, slope) = (along[k & 1], along[2 + (k & 1)]);
            let (wide_value, wide_slope) = (wide[k >> 1], wide[2 + (k >> 1)]);
            [
                wide_value * value,
                wide_value * slope,
                wide_slope * value,
                wide_slope * slope,
            ]
        };
        Place {
            near: [i, j],
            weights: [corner(0), corner(1), corner(2), corner(3)],
        }
    }

    /// Interpolates two of the four quantities: `PAIR` 0 is `ln |M|` and the lead, 1 is largest pressure and side flow.
    #[inline]
    fn pair<const PAIR: usize>(&self, place: &Place) -> [f64; 2] {
        let [i, j] = place.near;
        let (near, far) = (&self.row(i)[j..=j + 1], &self.row(i + 1)[j..=j + 1]);
        let corners = [&near[0], &far[0], &near[1], &far[1]];
        let mut sum = [0.0; 2];
        for (node, weights) in corners.into_iter().zip(&place.weights) {
            for (kind, weight) in node.iter().zip(weights) {
                sum[0] += weight * kind[2 * PAIR];
                sum[1] += weight * kind[2 * PAIR + 1];
            }
        }
        sum
    }
}
