//! All slices of a map, prepared once; from them a slice for any `B/D` is made quickly.

use std::sync::Arc;

use super::{
    blend::{Blend, Sources},
    map::MobilityMap,
    slice::MobilitySlice,
};
use crate::spline::hermite;

/// The mobility of a short bearing goes with this power of `B/D`.
const SHORT: f64 = -2.0;

/// A [`MobilityMap`] prepared for every `B/D`: its slices, and their slopes over `ln(B/D)` where they are needed.
///
/// Prepare a map once; clones share the prepared numbers.
///
/// # Examples
/// ```
/// use journal_bearing::mobility::{MobilityMap, SliceFamily};
///
/// let family = SliceFamily::new(&MobilityMap::built_in()?);
/// let slice = family.slice(0.76);
/// // A load along the eccentricity moves the journal along itself.
/// let (along, across) = slice.mobility(0.6, 1.0, 0.0);
/// assert!(along > 0.0 && across.abs() < 1e-9);
/// # Ok::<(), journal_bearing::mobility::MapError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SliceFamily {
    /// `ln(B/D)` of the first slice.
    first: f64,
    /// Distance between slices in `ln(B/D)`.
    spacing: f64,
    sources: Arc<Sources>,
}

impl SliceFamily {
    /// Prepares a map.
    pub fn new(map: &MobilityMap<'static>) -> Self {
        Self {
            first: map.width(0).ln(),
            spacing: (map.width(1) / map.width(0)).ln(),
            sources: Arc::new(Sources::new(map.slices())),
        }
    }

    /// The map at one width-to-diameter ratio `B/D > 0`, ready for look-ups.
    ///
    /// The table covers `B/D` from 0.1 to 4. Narrower bearings approach the short bearing, `|M| ~ (D/B)^2` (Ocvirk 1952):
    /// the remaining difference falls with the square of `B/D`, as do the terms of the Reynolds equation that the
    /// short-bearing theory neglects. Wider bearings are taken as `B/D = 4`.
    ///
    /// # Panics
    /// When `B/D` is not positive, or no number.
    pub fn slice(&self, width_to_diameter: f64) -> MobilitySlice {
        assert!(width_to_diameter > 0.0, "B/D is {width_to_diameter:?}, and must be positive");
        let slices = &self.sources.slices;
        let last = (slices.len() - 1) as f64;
        let position = ((width_to_diameter.ln() - self.first) / self.spacing).min(last);
        let cell = (position.max(0.0) as usize).min(slices.len() - 2);
        let (weights, rise) = if position < 0.0 {
            let beyond = position * self.spacing;
            // Integral of the remaining slope difference, which decays as (B/D)^2, from the table's end to here.
            let fallen = 0.5 * (2.0 * beyond).exp_m1();
            let weights = [1.0, 0.0, fallen / self.spacing, 0.0];
            (weights, SHORT * (beyond - fallen))
        } else {
            (hermite(position - cell as f64), 0.0)
        };
        let blend = Blend { sources: Arc::clone(&self.sources), cell, weights, rise };
        MobilitySlice::new(slices[cell].lattice, blend)
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::splines_over_s;
    use super::*;

    #[test]
    fn tabulated_widths_come_back() {
        let map = MobilityMap::built_in().unwrap();
        let family = SliceFamily::new(&map);
        for (k, slice) in map.slices().iter().enumerate() {
            let made = family.slice(map.width(k));
            for i in [0, 7, 40] {
                let tabulated = slice.row(i, &splines_over_s(slice.lattice.ss));
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
        // The slope has no kink at the table's end.
        let powers = [1e-4_f64, -1e-4].map(|d| (at(0.1 * d.exp()) / at(0.1)).ln() / d);
        assert!((powers[0] - powers[1]).abs() < 2e-3, "{powers:?}");
    }

    #[test]
    fn a_bearing_without_width_is_refused() {
        let family = SliceFamily::new(&MobilityMap::built_in().unwrap());
        for width in [0.0, -0.76, f64::NAN] {
            let slice = std::panic::catch_unwind(|| family.slice(width));
            assert!(slice.is_err(), "{width}");
        }
        assert_eq!(family.slice(f64::INFINITY).mobility(0.6, 1.0, 0.0), family.slice(4.0).mobility(0.6, 1.0, 0.0));
    }

    /// The short bearing's exact mobility along the line of centres is `(D/B)^2 / (2 I)`, where `I` is the integral of
    /// `cos^2 / (1 - e cos)^3` over the half that closes (Ocvirk's pressure under squeeze: Booker 1965).
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
