//! Mobility of a journal bearing: how fast a load moves the journal.
//!
//! In the frame of [`reynolds`](super::reynolds), a bearing has radial clearance `c`, radius `R`, width `B`, diameter
//! `D` and oil of viscosity `eta`. A load `F` moves its journal with (Booker 1965, J. Basic Eng. 87, 537-546; 1971,
//! J. Lubr. Technol. 93, 168-176)
//!
//! ```text
//! d eps/dt = |F| (c/R)^2 / (eta B D) * M + omega z x eps
//! ```
//!
//! The mobility `M` depends only on the eccentricity ratio, on the direction of the load relative to the eccentricity,
//! and on `B/D`. `omega = (omega_journal + omega_bush) / 2` is the *mean* rotation of both surfaces, because a turning
//! bush drags as much oil along as a turning journal. The relation is exact for an oil film whose pressure is nowhere
//! below ambient.
//!
//! # Source of the numbers
//! Goenka's curve-fit coefficients (1984, J. Tribol. 106) were not found in any public source. The table here
//! is no such fit: it holds solutions of this crate's [`QuasiStatic`](super::reynolds::QuasiStatic) film, made by
//! [`generate`] (`cargo run --release -p journal-bearing --example mobility-map`), and is interpolated with a continuous
//! first derivative.
//!
//! # Interpolation
//! The logarithm of `|M|` and the angle by which `M` leads the load are interpolated over `u = -ln(1 - e)`, over the
//! load direction stretched by `1 - e` (module `coordinates`), and over `ln(B/D)`. In lubrication theory, `|M|` tends to
//! powers of the smallest gap and of `B/D`. Powers are straight lines in these coordinates and are continued as such
//! beyond the table, so that under a finite load the journal never reaches the bush.

mod blend;
mod coordinates;
mod family;
mod generate;
mod map;
mod rough;
mod slice;
mod table;
mod touching;

pub use family::SliceFamily;
pub use generate::{Sample, exact, exact_between, generate, generate_rough};
pub use map::{MapError, MobilityMap};
pub use rough::FINEST;
pub use slice::{LookUp, MobilitySlice};
pub use touching::{RoughAt, RoughSlices};

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use std::f64::consts::PI;

    /// Compares the map with direct solutions on a finer grid, at points between its nodes; the example `mobility-map`
    /// does so at many more points.
    #[test]
    fn agrees_with_direct_solutions() {
        agrees(&[0.05, 0.61, 0.93, 0.98], &[0.03, 1.3, 3.0]);
    }

    #[test]
    #[ignore = "takes a while: scripts/test --long"]
    fn agrees_with_more_direct_solutions() {
        agrees(&[0.05, 0.33, 0.61, 0.85, 0.93, 0.98], &[0.03, -0.4, 1.3, -2.2, 3.0]);
    }

    fn agrees(eccentricities: &[f64], angles: &[f64]) {
        let map = SliceFamily::new(&MobilityMap::built_in().unwrap());
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
        for width in [0.27, 0.5, 0.76, 1.1, 1.47] {
            let slice = map.slice(width);
            for &e in eccentricities {
                for &angle in angles {
                    let direct = exact(width, e, angle, [192, 16]).unwrap().mobility;
                    let (radial, tangential) = slice.mobility(e, angle.cos(), angle.sin());
                    let error = (Vector2::new(radial, tangential) - direct).norm() / direct.norm();
                    sum += error;
                    worst = worst.max(error);
                    count += 1.0;
                }
            }
        }
        assert!(sum / count < 0.003, "mean {}", sum / count);
        assert!(worst < 0.02, "largest {worst}");
    }

    /// Booker (1965): for a short bearing `M = (D/B)^2 (1 - e)^(5/2) / pi` along the line of centres.
    #[test]
    fn a_narrow_bearing_is_a_short_one() {
        let slice = SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(0.02);
        for e in [0.0_f64, 0.4] {
            let short = (1.0 - e).powf(2.5) / (PI * 0.02_f64.powi(2));
            let (radial, tangential) = slice.mobility(e, 1.0, 0.0);
            assert!((radial / short - 1.0).abs() < 0.05, "{e}: {radial} {short}");
            assert!(tangential.abs() < 1e-9 * radial);
        }
    }

    /// In the centre, too: its logarithm falls by 5/2 of the way towards the load and rises by as much away from it, over ways of
    /// all lengths; across the load it stays.
    #[test]
    fn a_narrow_bearing_leaves_the_centre_as_a_short_one() {
        let slice = SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(0.02);
        let size = |e: f64, angle: f64| {
            let (radial, tangential) = slice.mobility(e, angle.cos(), angle.sin());
            radial.hypot(tangential).ln()
        };
        for e in [1e-8, 1e-6, 1e-4] {
            for angle in [0.0, 0.5, 1.57, -2.0, PI] {
                let slope = (size(e, angle) - size(0.0, angle)) / e;
                assert!((slope + 2.5 * angle.cos()).abs() < 0.04, "{e:e} {angle}: {slope}");
            }
        }
    }

    /// Beyond the table the mobility keeps falling with the power 3/2 of the gap, so the journal cannot reach the bush.
    #[test]
    fn the_mobility_vanishes_at_the_bush() {
        let slice = SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(0.76);
        let at = |gap: f64| slice.mobility(1.0 - gap, 1.0, 0.0).0;
        for gap in [1e-4, 1e-6, 1e-8] {
            let power = (at(gap) / at(0.1 * gap)).log10();
            assert!((power - 1.5).abs() < 0.05, "{gap}: {power}");
        }
        assert!(at(0.0) > 0.0 && at(0.0) < 1e-12);
    }

    /// A film only dissipates: no load moves the journal against the load's direction, also beyond the table.
    #[test]
    fn the_film_takes_no_work_from_the_journal() {
        let map = SliceFamily::new(&MobilityMap::built_in().unwrap());
        for width in [0.02, 0.2, 0.7, 1.6] {
            let slice = map.slice(width);
            for k in 0..40 {
                let gap = 10_f64.powf(-0.3 * f64::from(k));
                for angle in (0..=400).map(|i| PI * (f64::from(i) / 400.0).powi(3)) {
                    let (cos, sin) = (angle.cos(), angle.sin());
                    let (x, y) = slice.mobility(1.0 - gap, cos, sin);
                    let along = (x * cos + y * sin) / x.hypot(y);
                    assert!(along > -1e-14, "B/D {width}, gap {gap:e}, {angle}: {along:e}");
                }
            }
        }
    }

    #[test]
    fn values_and_slopes_are_continuous_across_the_nodes() {
        let slice = SliceFamily::new(&MobilityMap::built_in().unwrap()).slice(0.76);
        let of = |e: f64, angle: f64| slice.mobility(e, angle.cos(), angle.sin()).0;
        let node = 1.0 - 1e-4_f64.powf(0.25);
        let step = 1e-5;
        for angle in [0.0, 0.2, PI] {
            let before = (of(node, angle) - of(node - step, angle)) / step;
            let after = (of(node + step, angle) - of(node, angle)) / step;
            assert!((before - after).abs() < 1e-2 * before.abs(), "{before} {after}");
        }
        // The radial mobility is an even function of the angle at the line of centres, so its slope is zero there.
        assert!((of(0.6, 1e-6) - of(0.6, -1e-6)).abs() < 1e-12);
        assert!((of(0.6, PI - 1e-6) - of(0.6, -PI + 1e-6)).abs() < 1e-12);
    }

    #[test]
    fn a_damaged_map_is_refused() {
        let bytes = MobilityMap::built_in().unwrap().to_bytes().unwrap();
        assert!(MobilityMap::from_bytes(&bytes[..bytes.len() - 5]).is_err());
        assert!(MobilityMap::from_bytes(&[]).is_err());
    }
}
