//! The mobility of journals whose asperities touch the bush.

use std::sync::{Arc, OnceLock};

use nalgebra::Vector2;

use super::{
    coordinates::Point,
    map::MapError,
    rough::Corrections,
    slice::{LookUp, MobilitySlice, ahead},
};
use crate::{contact::Touch, roughness::NO_CONTACT};

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
/// assert!(rough.with_clearance(c).look_up(eps, eps.x, &touch, load).mobility().x > 0.0);
/// # Ok::<(), journal_bearing::mobility::MapError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RoughSlices {
    smooth: Arc<MobilitySlice>,
    corrections: Arc<Corrections>,
    roughness: f64,
    clearance: f64,
    own: OnceLock<MobilitySlice>,
    /// By number, from `first` on.
    others: Vec<OnceLock<Box<MobilitySlice>>>,
    first: i64,
}

/// Slices in an octave of clearances, evenly spaced; a power of two. Seven roughnesses are a slice.
const PER_OCTAVE: u64 = 64;
/// Bits of a double's mantissa that stand for the place between slices.
const BITS: u32 = 52 - PER_OCTAVE.trailing_zeros();

/// The number of the slice at or below a clearance over seven roughnesses, a positive normal number, and the share of the way to the
/// next one.
#[inline]
fn below(ratio: f64) -> (i64, f64) {
    let bits = ratio.to_bits();
    let share = (bits & ((1 << BITS) - 1)) as f64 / (1_u64 << BITS) as f64;
    ((bits >> BITS) as i64, share)
}

/// The clearance over seven roughnesses of a slice.
fn ratio(number: i64) -> f64 {
    f64::from_bits((number as u64) << BITS)
}

/// The clearances that have slices, over the bearing's own. Beyond them the nearest counts.
const LEAST: f64 = 0.01;
const MOST: f64 = 100.0;

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
        let corrections = Arc::new(Corrections::new(width_to_diameter)?);
        let number = |ratio: f64| below(ratio * clearance / (NO_CONTACT * roughness)).0;
        let (first, last) = (number(LEAST), number(MOST) + 2);
        Ok(Self {
            smooth: Arc::new(smooth.clone()),
            corrections,
            roughness,
            clearance,
            own: OnceLock::new(),
            others: (first..last).map(|_| OnceLock::new()).collect(),
            first,
        })
    }

    /// The film at one radial clearance, m, for many look-ups.
    #[inline]
    pub fn with_clearance(&self, clearance: f64) -> RoughAt<'_> {
        if clearance == self.clearance {
            return RoughAt::Own(self.own.get_or_init(|| self.slice(clearance)));
        }
        let clearance = clearance.clamp(LEAST * self.clearance, MOST * self.clearance);
        let (number, share) = below(clearance / (NO_CONTACT * self.roughness));
        RoughAt::Between([0, 1].map(|k| self.other(number + k)), share)
    }

    /// The slice with a number.
    fn other(&self, number: i64) -> &MobilitySlice {
        let last = self.others.len() - 1;
        let index = usize::try_from(number - self.first).unwrap_or(0).min(last);
        self.others[index].get_or_init(|| {
            let clearance = NO_CONTACT * self.roughness * ratio(self.first + index as i64);
            Box::new(self.slice(clearance))
        })
    }

    #[cold]
    fn slice(&self, clearance: f64) -> MobilitySlice {
        let correction = self.corrections.at(self.roughness / clearance);
        MobilitySlice::corrected(&self.smooth, correction)
    }
}

/// The mobility of a rough bearing at one clearance, from [`RoughSlices::with_clearance`].
#[derive(Clone, Copy, Debug)]
pub enum RoughAt<'a> {
    /// The slice of that clearance.
    Own(&'a MobilitySlice),
    /// Two slices about it, and the share of the way between them: quantities are compared at the same place between first touch
    /// and the end of the reach, and in the same direction.
    Between([&'a MobilitySlice; 2], f64),
}

impl RoughAt<'_> {
    /// Locates the eccentricity-ratio vector `eps`, whose length is `e`, of a journal that touches so, under a load along the unit
    /// vector `direction`: [`MobilitySlice::look_up`] of a rough bearing.
    #[inline]
    pub fn look_up(&self, eps: Vector2<f64>, e: f64, touch: &Touch, direction: Vector2<f64>) -> LookUp {
        let [cos, sin] = ahead(eps, e, direction);
        let point = Point { u: touch.place, s: Point::direction(touch.room, cos, sin) };
        match *self {
            Self::Own(slice) => slice.look_up_at(point, direction, sin),
            Self::Between(slices, share) => LookUp::of(MobilitySlice::between(slices, share, point), direction, sin),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{MobilityMap, SliceFamily};
    use super::*;
    use crate::contact::{ContactTable, Surface};
    use crate::roughness::Reach;

    /// Against the slice of that clearance: far less apart than the table of rough films from direct solutions.
    #[test]
    fn other_clearances_have_the_film_of_their_own_slices() {
        let family = SliceFamily::new(&MobilityMap::built_in().unwrap());
        let mut clearances = (1..).map(|n| 0.8 + 0.4 * (0.618 * f64::from(n)).fract());
        let (mut sum, mut count) = (0.0, 0.0);
        for width in [0.3, 0.76, 1.5] {
            let smooth = family.slice(width);
            for roughness in [0.003, 0.02, 0.1, 0.25, 0.35] {
                let surface = Surface { roughness, ..Surface::default() };
                let slices = RoughSlices::new(&smooth, width, roughness, 1.0).unwrap();
                for place in [0.05, 0.3, 0.55, 0.8, 0.95] {
                    let clearance = clearances.next().unwrap();
                    let own = RoughSlices::new(&smooth, width, roughness, clearance).unwrap();
                    let table = ContactTable::new(&surface, clearance, width, 1.0);
                    let e = Reach::new(roughness / clearance).at(place);
                    let touch = table.touch(e).unwrap();
                    for angle in [0.03_f64, 0.4, 1.3, 2.9] {
                        let load = Vector2::new(angle.cos(), angle.sin());
                        let [film, expected] = [&slices, &own].map(|slices| {
                            slices.with_clearance(clearance).look_up(Vector2::new(e, 0.0), e, &touch, load)
                        });
                        let size = expected.mobility().norm();
                        let apart = (film.mobility() - expected.mobility()).norm() / size;
                        let pressure = film.max_pressure() / expected.max_pressure() - 1.0;
                        let flow = film.side_flow() / expected.side_flow() - 1.0;
                        let worst = apart.max(pressure.abs()).max(flow.abs());
                        assert!(
                            worst < 2e-4,
                            "{width} {roughness} {clearance} {place} {angle}: {apart:e} {pressure:e} {flow:e}"
                        );
                        sum += apart;
                        count += 1.0;
                    }
                }
            }
        }
        assert!(sum / count < 2e-5, "mean {:e}", sum / count);
    }

    #[test]
    fn a_clearance_lies_between_its_slices() {
        for clearance in [1e-9, 0.3, 1.0, 1.01, 1.999, 2.0, 77.0] {
            let (number, share) = below(clearance);
            let [near, far] = [number, number + 1].map(ratio);
            assert!(near <= clearance && clearance < far && far < 1.02 * near);
            assert!((near + share * (far - near) - clearance).abs() < 1e-15 * clearance);
        }
        assert_eq!(below(1.0).1, 0.0);
    }

    /// The order in which clearances were visited does not matter.
    #[test]
    fn a_film_does_not_depend_on_earlier_ones() {
        let smooth = SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(0.76);
        let surface = Surface { roughness: 0.1, ..Surface::default() };
        let fresh = || RoughSlices::new(&smooth, 0.76, 0.1, 1.0).unwrap();
        let touch = ContactTable::new(&surface, 1.07, 0.76, 1.0);
        let touch = touch.touch(0.8).unwrap();
        let at = |slices: &RoughSlices, clearance: f64| {
            let slices = slices.with_clearance(clearance);
            let film = slices.look_up(Vector2::new(0.8, 0.0), 0.8, &touch, Vector2::x());
            film.mobility()
        };
        let used = fresh();
        for clearance in [1.3, 0.7, 1.02, 1e-4, 1e4] {
            assert!(at(&used, clearance).x > 0.0, "{clearance}");
        }
        assert_eq!(at(&used, 1.07), at(&fresh(), 1.07));
    }
}
