//! Regional sensitivity: how much a parameter decides between pass and fail, as the distance between its distribution
//! over the points that pass and over the points that fail.
//!
//! Hornberger & Spear (1981), "An approach to the preliminary analysis of environmental systems",
//! J. Environmental Management 12, 7-18.

use sampling::statistics::moments::{ks_distance, ks_probability, quantile, sorted};
use serde::{Deserialize, Serialize};

/// How far one parameter decides between pass and fail.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// Kolmogorov-Smirnov distance between the two distributions: 0 nothing, 1 decides alone.
    pub distance: f64,
    /// Probability of a distance as large by chance.
    pub chance: f64,
    /// Median of the parameter over the points that pass.
    pub passing: f64,
    /// Median of the parameter over the points that do not.
    pub failing: f64,
}

/// Compares every parameter over points that pass and that do not, failed runs among them. `None` where either side has no
/// point.
pub fn split(parameters: &[&[f64]], pass: &[bool]) -> Option<Vec<Split>> {
    let split = |values: &&[f64]| {
        let side = |wanted: bool| -> Vec<f64> {
            let pairs = values.iter().zip(pass);
            let of_side = pairs.filter(|(value, ok)| **ok == wanted && value.is_finite());
            sorted(of_side.map(|(value, _)| *value).collect())
        };
        let (yes, no) = (side(true), side(false));
        if yes.is_empty() || no.is_empty() {
            return None;
        }
        let distance = ks_distance(&yes, &no);
        Some(Split {
            distance,
            chance: ks_probability(distance, yes.len(), no.len()),
            passing: quantile(&yes, 0.5),
            failing: quantile(&no, 0.5),
        })
    };
    parameters.iter().map(split).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::near;

    #[test]
    fn the_deciding_parameter_is_found() {
        let decides: Vec<f64> = (0..200).map(f64::from).collect();
        let other: Vec<f64> = (0..200).map(|k| f64::from(k * 37 % 200)).collect();
        let pass: Vec<bool> = decides.iter().map(|v| *v < 60.0).collect();
        let s = split(&[&decides, &other], &pass).unwrap();
        assert_eq!(s[0].distance, 1.0);
        assert!(s[0].chance < 1e-9 && s[0].passing < s[0].failing);
        assert!(s[1].distance < 0.15 && s[1].chance > 0.3, "{s:?}");
        assert_eq!(split(&[&decides], &[true; 200]), None);
    }

    /// scipy's `ks_2samp` has the distance. A point without a value of the parameter counts on neither side.
    #[test]
    fn the_sides_are_those_that_pass_and_that_do_not() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, f64::NAN, f64::NAN];
        let pass = [1, 1, 0, 1, 1, 0, 0, 1, 0, 1, 0].map(|pass| pass == 1);
        let sides = split(&[&values], &pass).unwrap()[0];
        near([sides.distance], [0.55]);
        assert_eq!((sides.passing, sides.failing), (4.0, 6.5));
        assert!(sides.chance > 0.3, "{sides:?}");
        assert_eq!(split(&[&values[..2]], &[false; 2]), None);
    }
}
