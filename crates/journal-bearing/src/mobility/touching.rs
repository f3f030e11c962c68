//! The mobility of journals whose asperities touch the bush.

use std::sync::OnceLock;

use nalgebra::Vector2;

use super::coordinates::Point;
use super::map::MapError;
use super::rough::{Correction, weights};
use super::slice::{LookUp, MobilitySlice, ahead};
use super::table::CHANNELS;
use crate::contact::Touch;
use crate::roughness::NO_CONTACT;

/// The slices of a rough bearing: one at its own clearance, and others of equal ratios for a clearance that changes. Each is
/// made on first use.
///
/// # Examples
/// ```
/// use journal_bearing::contact::{ContactTable, Surface};
/// use journal_bearing::mobility::{MobilityMap, RoughSlices, SliceFamily};
/// use journal_bearing::nalgebra::Vector2;
///
/// // Clearance, width, diameter and roughness in m: the mean planes have crossed by a tenth of the roughness.
/// let (c, width, diameter, roughness) = (20e-6, 0.019, 0.025, 1e-6);
/// let (eps, load) = (Vector2::new(1.005, 0.0), Vector2::x());
/// let smooth = SliceFamily::new(&MobilityMap::built_in()?).slice(width / diameter);
/// let rough = RoughSlices::new(&smooth, width / diameter, roughness, c)?;
/// let surface = Surface { roughness, ..Surface::default() };
/// let touch = ContactTable::new(&surface, c, width, diameter).touch(eps.x).unwrap();
/// assert!(touch.contact.force > 1000.0); // N
/// // The film still lets the journal move.
/// assert!(rough.look_up(eps, eps.x, &touch, c, load).mobility().x > 0.0);
/// # Ok::<(), journal_bearing::mobility::MapError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RoughSlices {
    smooth: MobilitySlice,
    width_to_diameter: f64,
    roughness: f64,
    clearance: f64,
    own: OnceLock<MobilitySlice>,
    /// Numbered by clearance, counted from `first`; number 0 stands where contact reaches around the bush.
    others: Vec<OnceLock<MobilitySlice>>,
    first: i32,
}

/// Ratio of neighbouring clearances, as a logarithm.
const SPACING: f64 = 0.1;
/// The clearances that have slices, over the bearing's own. Beyond them the nearest counts.
const LEAST: f64 = 0.01;
const MOST: f64 = 100.0;
/// Slices that a polynomial passes through.
const THROUGH: i32 = 4;

impl RoughSlices {
    /// The slices of a bearing of `width_to_diameter`, with the composite rms roughness and the radial clearance in m. `smooth`
    /// is its slice without roughness.
    ///
    /// # Errors
    /// When the table of rough films is damaged; a test rules that out.
    pub fn new(
        smooth: &MobilitySlice,
        width_to_diameter: f64,
        roughness: f64,
        clearance: f64,
    ) -> Result<Self, MapError> {
        Correction::check()?;
        let middle = (clearance / (NO_CONTACT * roughness)).ln();
        let bound = |ratio: f64| ((middle + ratio.ln()) / SPACING).floor() as i32;
        let (first, last) = (bound(LEAST) - THROUGH, bound(MOST) + THROUGH + 1);
        Ok(Self {
            smooth: smooth.clone(),
            width_to_diameter,
            roughness,
            clearance,
            own: OnceLock::new(),
            others: (first..last).map(|_| OnceLock::new()).collect(),
            first,
        })
    }

    /// Locates the eccentricity-ratio vector `eps`, whose length is `e`, of a journal that touches so, at a radial clearance (m)
    /// and under a load along the unit vector `direction`: [`MobilitySlice::look_up`] of a rough bearing.
    #[inline]
    pub fn look_up(
        &self,
        eps: Vector2<f64>,
        e: f64,
        touch: &Touch,
        clearance: f64,
        direction: Vector2<f64>,
    ) -> LookUp<'_> {
        let [cos, sin] = ahead(eps, e, direction);
        let point = Point {
            u: touch.place,
            s: Point::direction(touch.room, cos, sin),
        };
        if clearance == self.clearance {
            let own = self.own.get_or_init(|| self.slice(clearance));
            return own.look_up_at(point, direction, sin);
        }
        LookUp::of(self.between(point, clearance), direction, sin)
    }

    /// The quantities between slices: at the same place between first touch and the end of the reach, and in the same direction.
    #[inline(never)]
    fn between(&self, point: Point, clearance: f64) -> [f64; CHANNELS] {
        let clearance = clearance.clamp(LEAST * self.clearance, MOST * self.clearance);
        let x = (clearance / (NO_CONTACT * self.roughness)).ln() / SPACING;
        let below = x.floor() as i32;
        let lowest = if below >= 0 {
            (below - 1).max(0)
        } else {
            (below - 1).min(1 - THROUGH)
        };
        let slices = std::array::from_fn(|k| self.other(lowest + k as i32));
        MobilitySlice::between(slices, weights::<4>(x - f64::from(lowest)), point)
    }

    /// The slice with a number.
    fn other(&self, number: i32) -> &MobilitySlice {
        let last = self.others.len() - 1;
        let index = usize::try_from(number - self.first).unwrap_or(0).min(last);
        let clearance = NO_CONTACT * self.roughness * (f64::from(number) * SPACING).exp();
        self.others[index].get_or_init(|| self.slice(clearance))
    }

    #[cold]
    fn slice(&self, clearance: f64) -> MobilitySlice {
        let correction = Correction::new(self.width_to_diameter, self.roughness / clearance);
        self.smooth
            .corrected(correction.expect("the table was checked"))
    }
}
