//! Two independent samples that fill the space evenly.

use rand::seq::SliceRandom;
use rand::{SeedableRng, rngs::StdRng};

/// Rows of two samples A and B in the unit cube: the first `parameters` numbers of a row are A's, the others B's.
///
/// All are one scrambled net, which fills the space more evenly than several small ones of as many points together. Its
/// coordinates are dealt out at random: some two of them lie badly together at some numbers of points, with errors up to
/// twice those of independent points, which the runs themselves do not show. Always in the same order, the same parameter
/// would always have too narrow an interval.
///
/// # Errors
///
/// The net has too few coordinates or points.
pub fn pairs(parameters: usize, rows: u64, seed: u64) -> Result<Vec<Vec<f64>>, String> {
    let net = sampling::design::cube(2 * parameters, rows, seed, 1)?;
    let mut order: Vec<usize> = (0..2 * parameters).collect();
    order.shuffle(&mut StdRng::seed_from_u64(seed));
    let dealt = |point: &Vec<f64>| order.iter().map(|&k| point[k]).collect();
    Ok(net.iter().map(dealt).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each coordinate of the net comes once, in an order that depends on the seed alone: more rows leave the first as they
    /// are.
    #[test]
    fn the_coordinates_are_dealt_out_by_the_seed() {
        let net = sampling::design::cube(8, 32, 5, 1).unwrap();
        let dealt = pairs(4, 32, 5).unwrap();
        let sorted = |row: &Vec<f64>| {
            let mut row = row.clone();
            row.sort_by(f64::total_cmp);
            row
        };
        for (point, row) in net.iter().zip(&dealt) {
            assert_eq!(sorted(point), sorted(row));
        }
        assert_eq!(pairs(4, 16, 5).unwrap(), dealt[..16]);
        let places = |seed: u64| {
            let net = sampling::design::cube(8, 1, seed, 1).unwrap();
            let row = pairs(4, 1, seed).unwrap();
            let place = |value: &f64| net[0].iter().position(|v| v == value);
            row[0].iter().map(place).collect::<Vec<_>>()
        };
        assert!((1..5).any(|seed| places(seed) != places(5)));
    }
}
