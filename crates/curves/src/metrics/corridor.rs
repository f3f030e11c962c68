//! The share of the reference's times at which the model lies inside the corridor.

use super::{Compare, Kind, Pair};

/// `|m - r| <= band`; the edges belong to the corridor.
pub(super) struct Corridor;

impl Compare for Corridor {
    const LABEL: &'static str = "share inside the corridor";
    const KIND: Kind = Kind::Rating;

    fn compare(pair: &Pair<'_>) -> f64 {
        let inside = pair
            .deviations()
            .zip(pair.band)
            .filter(|(deviation, band)| deviation.abs() <= **band);
        inside.count() as f64 / pair.reference.len() as f64
    }
}
