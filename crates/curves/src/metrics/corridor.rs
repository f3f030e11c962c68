//! The share of the reference's times at which the model lies inside the corridor.

use super::Pair;

/// `|m - r| <= band`; the edges belong to the corridor.
pub fn corridor(pair: &Pair) -> f64 {
    let inside = pair.deviations().zip(pair.band).filter(|(off, band)| off.abs() <= **band);
    inside.count() as f64 / pair.reference.len() as f64
}
