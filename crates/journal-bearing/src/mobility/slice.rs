//! The map at one width-to-diameter ratio, for use in every time step.

use nalgebra::Vector2;
use std::{
    f64::consts::FRAC_PI_2,
    sync::{Arc, OnceLock},
};

use super::{
    blend::Blend,
    coordinates::Point,
    rough::{Correction, SIZE},
    table::{CHANNELS, Lattice, Node},
};
use crate::spline::{hermite, slope_of_hermite};

/// The mobility of bearings of one `B/D`: the map's quantities over eccentricity ratio and load direction, with a
/// continuous first derivative.
#[derive(Clone, Debug)]
pub struct MobilitySlice {
    lattice: Lattice,
    /// One row per `u`. A journal visits few of them, so each is made on first use.
    rows: Vec<OnceLock<Box<[Node]>>>,
    source: RowSource,
}

/// What the rows are made from.
#[derive(Clone, Debug)]
enum RowSource {
    /// The map of smooth bearings.
    Smooth(Blend),
    /// A smooth bearing's slice, corrected.
    Rough(Box<(Arc<MobilitySlice>, Correction)>),
}

/// The quantities at one place of the map.
///
/// From [`MobilitySlice::look_up`].
#[derive(Clone, Copy, Debug)]
pub struct LookUp {
    values: [f64; CHANNELS],
    direction: Vector2<f64>,
    /// Sign of the angle from the eccentricity to the load.
    sign: f64,
}

impl LookUp {
    /// The quantities under a load along a unit vector at the sine of an angle ahead of the eccentricity.
    #[inline]
    pub(super) fn of(values: [f64; CHANNELS], direction: Vector2<f64>, sin: f64) -> Self {
        Self { values, direction, sign: if sin < 0.0 { -1.0 } else { 1.0 } }
    }

    /// The mobility vector `M`, 1, in the frame in which the load's direction was given.
    #[inline]
    pub fn mobility(&self) -> Vector2<f64> {
        let [log_mobility, lead, ..] = self.values;
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
        self.log_max_pressure().exp()
    }

    /// Its logarithm, which is at hand.
    #[inline]
    pub fn log_max_pressure(&self) -> f64 {
        self.values[2]
    }

    /// The oil flow out of both ends together over `F c^3 / (3 eta B^2)`, 1.
    #[inline]
    pub fn side_flow(&self) -> f64 {
        self.values[3].exp()
    }
}

/// Cosine and sine of the angle by which the load is ahead of the eccentricity.
#[inline]
pub fn ahead(eps: Vector2<f64>, e: f64, direction: Vector2<f64>) -> [f64; 2] {
    if e > 0.0 {
        let inverse = 1.0 / e;
        [eps.dot(&direction) * inverse, eps.perp(&direction) * inverse]
    } else {
        [1.0, 0.0]
    }
}

/// A place in the table: indices of its cell's first node, and the weight of each number stored at its four corners.
#[derive(Clone, Copy, Debug)]
struct SlicePlace {
    near: [usize; 2],
    /// First index: corner; second index: number within a [`Node`].
    weights: [[f64; 4]; 4],
}

impl MobilitySlice {
    /// A slice whose rows `blend` makes.
    pub(super) fn new(lattice: Lattice, blend: Blend) -> Self {
        Self::with_rows(lattice, RowSource::Smooth(blend))
    }

    fn with_rows(lattice: Lattice, source: RowSource) -> Self {
        Self { lattice, rows: vec![OnceLock::new(); lattice.last_u as usize + 1], source }
    }

    /// The slice of rough bearings. It has a row for each place of the corrections, which stands for `u`.
    pub(super) fn corrected(smooth: &Arc<Self>, correction: Correction) -> Self {
        let last = (SIZE[2] - 1) as f64;
        let lattice = Lattice { per_u: last, last_u: last, ..smooth.lattice };
        let source = Box::new((Arc::clone(smooth), correction));
        Self::with_rows(lattice, RowSource::Rough(source))
    }

    /// The nodes of row `i`: one `u`, all `s`.
    #[inline]
    pub(super) fn row(&self, i: usize) -> &[Node] {
        self.rows[i].get_or_init(|| self.make(i))
    }

    #[cold]
    fn make(&self, i: usize) -> Box<[Node]> {
        let (smooth, correction) = match &self.source {
            RowSource::Smooth(blend) => return blend.row(i),
            RowSource::Rough(source) => (&source.0, &source.1),
        };
        let reach = &correction.reach;
        let e = reach.at(i as f64 / self.lattice.last_u);
        let [room, widening] = reach.room(e);
        // The change of the smooth bearing's `u` from place to place.
        let rise = -widening / (room * reach.place(e)[1] * self.lattice.last_u);
        let mut nodes = smooth.row_at(-room.ln());
        for (node, more) in nodes.iter_mut().zip(correction.row(i, self.lattice.ss)) {
            for (kind, (values, more)) in node.iter_mut().zip(more).enumerate() {
                let scale = if kind & 1 == 1 { rise } else { 1.0 };
                for (value, more) in values.iter_mut().zip(more) {
                    *value = *value * scale + more;
                }
            }
        }
        nodes
    }

    /// The nodes at any `u`, with slopes per unit of `u`.
    fn row_at(&self, u: f64) -> Box<[Node]> {
        let (i, x, excess) = self.lattice.locate(u);
        let scale = self.lattice.per_u;
        let [values, mut slopes] = [hermite(x), slope_of_hermite(x).map(|slope| slope * scale)];
        let mut values = values;
        values[3] += excess;
        if excess > 0.0 {
            slopes = [0.0, 0.0, 0.0, scale];
        }
        let nodes = self.row(i).iter().zip(self.row(i + 1));
        let between = |(near, far): (&Node, &Node)| {
            let sum = |kind: usize, channel: usize| {
                let [a, b, c, d] = if kind & 1 == 0 { values } else { slopes };
                let [value, slope] = [kind & 2, kind | 1];
                a * near[value][channel] + b * far[value][channel] + c * near[slope][channel] + d * far[slope][channel]
            };
            std::array::from_fn(|kind| std::array::from_fn(|channel| sum(kind, channel)))
        };
        nodes.map(between).collect()
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

    /// The Sommerfeld number of ISO 7902, `F psi^2/(B D eta omega)` with the sum `omega` of the surfaces' speeds, 1, under which a
    /// journal rests at the eccentricity ratio `e`: there the mobility has no part along the eccentricity, and the other one
    /// undoes the mean rotation.
    pub fn sommerfeld(&self, e: f64) -> f64 {
        const HALVINGS: usize = 40;
        let at = |angle: f64| self.mobility(e, angle.cos(), angle.sin());
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let outwards = at(middle).0 > 0.0;
            *(if outwards { &mut low } else { &mut high }) = middle;
        }
        0.5 * e / at(high).1
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
    pub fn look_up(&self, eps: Vector2<f64>, e: f64, direction: Vector2<f64>) -> LookUp {
        let [cos, sin] = ahead(eps, e, direction);
        self.look_up_at(Point::new(1.0 - e, cos, sin), direction, sin)
    }

    /// Locates a point, under a load along a unit vector with this sine of the angle ahead of the eccentricity.
    #[inline]
    pub(super) fn look_up_at(&self, point: Point, direction: Vector2<f64>, sin: f64) -> LookUp {
        LookUp::of(self.at(&self.place(point)), direction, sin)
    }

    #[inline(always)]
    fn place(&self, point: Point) -> SlicePlace {
        let lattice = &self.lattice;
        let across = (point.s * lattice.last_s).clamp(0.0, lattice.last_s);
        let (i, x, excess) = lattice.locate(point.u);
        let j = (across as u32).min(lattice.ss as u32 - 2);
        let [a0, a1, b0, b1] = hermite(x);
        let along = [a0, a1, b0, b1 + excess];
        let wide = hermite(across - f64::from(j));
        let corner = |k: usize| {
            let (value, slope) = (along[k & 1], along[2 + (k & 1)]);
            let (wide_value, wide_slope) = (wide[k >> 1], wide[2 + (k >> 1)]);
            [wide_value * value, wide_value * slope, wide_slope * value, wide_slope * slope]
        };
        SlicePlace { near: [i, j as usize], weights: [corner(0), corner(1), corner(2), corner(3)] }
    }

    /// All quantities at a point and a share of the way from one slice to another of the same lattice.
    #[inline(never)]
    pub(super) fn between(slices: [&Self; 2], share: f64, point: Point) -> [f64; CHANNELS] {
        let place = slices[0].place(point);
        let [near, far] = slices.map(|slice| slice.corners(&place));
        let mut sums = [[0.0; CHANNELS]; 2];
        for ((near, far), weights) in near.into_iter().zip(far).zip(&place.weights) {
            for ((near, far), weight) in near.iter().zip(far).zip(weights) {
                for channel in 0..CHANNELS {
                    sums[0][channel] += weight * near[channel];
                    sums[1][channel] += weight * far[channel];
                }
            }
        }
        std::array::from_fn(|channel| sums[0][channel] + share * (sums[1][channel] - sums[0][channel]))
    }

    /// The nodes about a place.
    #[inline(always)]
    fn corners(&self, place: &SlicePlace) -> [&Node; 4] {
        let [i, j] = place.near;
        let (near, far) = (&self.row(i)[j..=j + 1], &self.row(i + 1)[j..=j + 1]);
        [&near[0], &far[0], &near[1], &far[1]]
    }

    /// Interpolates the quantities.
    #[inline]
    fn at(&self, place: &SlicePlace) -> [f64; CHANNELS] {
        let mut sums = [0.0; CHANNELS];
        for (node, weights) in self.corners(place).into_iter().zip(&place.weights) {
            for (kind, weight) in node.iter().zip(weights) {
                for (sum, quantity) in sums.iter_mut().zip(kind) {
                    *sum += weight * quantity;
                }
            }
        }
        sums
    }
}
