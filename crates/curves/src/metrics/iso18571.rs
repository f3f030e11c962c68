//! The objective rating of ISO/TS 18571:2014, "Road vehicles - Objective rating metric for non-ambiguous signals".
//!
//! Four ratings from 0 to 1 are weighted: how far the model leaves two corridors (0.4), how far it must be shifted for the
//! best correlation (0.2), and, for the shifted curves, how far magnitudes (0.2) and slopes (0.2) differ. The standard
//! asks for curves sampled at 10 kHz; here the samples are those given, evenly spaced.

mod corridor;
mod magnitude;
mod phase;
mod slope;

use super::Pair;

/// The fewest samples: after the largest shift the slope's average over nine samples must fit.
pub const LEAST: usize = 11;

/// The most samples: the search for the alignment takes time and memory with their square, 80 MB for so many.
pub const MOST: usize = 20_000;

/// The ratings, each from 0 to 1.
#[derive(Clone, Copy, Debug)]
pub struct Ratings {
    /// How far the model leaves the corridors around the reference.
    pub corridor: f64,
    /// How little it must be shifted.
    pub phase: f64,
    /// How well magnitudes agree after the shift and dynamic time warping.
    pub magnitude: f64,
    /// How well slopes agree after the shift.
    pub slope: f64,
}

impl Ratings {
    /// The weighted sum.
    pub fn overall(&self) -> f64 {
        0.4 * self.corridor + 0.2 * self.phase + 0.2 * self.magnitude + 0.2 * self.slope
    }
}

/// Rates a model's samples against as many of the reference, [`LEAST`] to [`MOST`], evenly spaced; not a number of fewer
/// or more.
pub fn rate(reference: &[f64], model: &[f64]) -> Ratings {
    if !(LEAST..=MOST).contains(&reference.len()) {
        return Ratings { corridor: f64::NAN, phase: f64::NAN, magnitude: f64::NAN, slope: f64::NAN };
    }
    let shift = phase::shift(reference, model);
    let (shifted_reference, shifted_model) = phase::overlap(reference, model, shift);
    Ratings {
        corridor: corridor::rating(reference, model),
        phase: phase::rating(shift, reference.len()),
        magnitude: magnitude::rating(shifted_reference, shifted_model),
        slope: slope::rating(shifted_reference, shifted_model),
    }
}

/// An error as a part of what it is an error of; both of nothing agree.
fn part(error: f64, of: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / of }
}

/// The overall rating.
pub(super) fn iso18571(pair: &Pair) -> f64 {
    rate(pair.reference, pair.model).overall()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(count: i32, late: f64, factor: f64) -> Vec<f64> {
        let value = |k| factor * (0.1 * (f64::from(k) - late)).sin() * (-0.01 * (f64::from(k) - late)).exp();
        (0..count).map(value).collect()
    }

    #[test]
    fn a_late_curve_loses_in_phase_and_corridor_only() {
        // Five samples of a fifth of 200.
        let ratings = rate(&wave(200, 0.0, 1.0), &wave(200, 5.0, 1.0));
        assert!((ratings.phase - (1.0 - 5.0 / 40.0)).abs() < 1e-12, "{ratings:?}");
        assert!((ratings.magnitude - 1.0).abs() < 1e-12 && (ratings.slope - 1.0).abs() < 1e-12);
        assert!(0.5 < ratings.corridor && ratings.corridor < 1.0);
    }

    #[test]
    fn a_curve_of_half_the_size_has_half_the_slope() {
        let ratings = rate(&wave(200, 0.0, 1.0), &wave(200, 0.0, 0.5));
        assert!((ratings.slope - 0.75).abs() < 1e-12, "{ratings:?}");
        assert_eq!(ratings.phase, 1.0);
        assert!(ratings.magnitude < 0.5);
    }

    #[test]
    fn too_few_samples_have_no_rating() {
        assert!(rate(&[1.0; 10], &[1.0; 10]).overall().is_nan());
        assert_eq!(rate(&[1.0; 11], &[1.0; 11]).overall(), 1.0);
    }

    #[test]
    fn opposite_curves_are_rated_low() {
        let ratings = rate(&wave(200, 0.0, 1.0), &wave(200, 0.0, -1.0));
        assert_eq!(ratings.slope, 0.0_f64.max(ratings.slope));
        assert!(ratings.overall() < 0.6, "{ratings:?}");
    }
}
