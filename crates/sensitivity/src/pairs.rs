//! Two independent samples that fill the space evenly.

use nalgebra::DMatrix;
use sampling::random::{Purpose, Random};

/// Orders of the coordinates of which the best is taken.
const ORDERS: usize = 200;

/// Rows of two samples A and B in the unit cube: the first `parameters` numbers of a row are A's, the others B's.
///
/// All are one scrambled net, which fills the space more evenly than several small ones of as many points together. But some
/// two of its coordinates lie badly together at some numbers of points, with errors of several times those of independent
/// points. Were these two the places of one parameter in A and B, its indices would have such an error. So the coordinates
/// are dealt out at random, in the best of 200 orders: the one whose worst parameter has the most even pair. At random,
/// because no measure finds all bad places, and a fixed order would make the same parameter pay every time.
///
/// # Errors
///
/// The net has too few coordinates or points.
pub fn pairs(parameters: usize, rows: u64, seed: u64) -> Result<Vec<Vec<f64>>, String> {
    let net = sampling::design::cube(2 * parameters, rows, seed, 1)?;
    let badness = badness(&net, 2 * parameters);
    let mut random = Random::new(seed, Purpose::Deal, 0);
    let mut order: Vec<usize> = (0..2 * parameters).collect();
    let mut best = (f64::INFINITY, order.clone());
    for _ in 0..ORDERS {
        random.shuffle(&mut order);
        let (of_a, of_b) = order.split_at(parameters);
        let each = of_a.iter().zip(of_b).map(|(&a, &b)| badness[(a, b)]);
        let worst = each.fold(0.0, f64::max);
        if worst < best.0 {
            best = (worst, order.clone());
        }
    }
    let dealt = |point: &Vec<f64>| best.1.iter().map(|&k| point[k]).collect();
    Ok(net.iter().map(dealt).collect())
}

/// How badly any two coordinates lie together: the sum of the squared means of the products of their first two Legendre
/// polynomials, which are 0 over the whole square.
fn badness(net: &[Vec<f64>], coordinates: usize) -> DMatrix<f64> {
    let of_degree =
        |degree: fn(f64) -> f64| DMatrix::from_fn(net.len(), coordinates, |point, k| degree(net[point][k] - 0.5));
    let first = of_degree(|u| 12.0_f64.sqrt() * u);
    let second = of_degree(|u| 180.0_f64.sqrt() * (u * u - 1.0 / 12.0));
    let square = |a: &DMatrix<f64>, b: &DMatrix<f64>| {
        let means = a.transpose() * b / net.len() as f64;
        means.map(|mean| mean * mean)
    };
    let mixed = square(&first, &second);
    square(&first, &first) + square(&second, &second) + mixed.transpose() + mixed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each coordinate of the net comes once, in an order that depends on the seed alone.
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
        assert_eq!(pairs(4, 32, 5).unwrap(), dealt);
        let places = |seed: u64| {
            let net = sampling::design::cube(8, 32, seed, 1).unwrap();
            let row = pairs(4, 32, seed).unwrap();
            let place = |value: &f64| net[0].iter().position(|v| v == value);
            row[0].iter().map(place).collect::<Vec<_>>()
        };
        assert!((1..5).any(|seed| places(seed) != places(5)));
    }

    /// Four points at the corners of a cross lie well together, those of a diagonal badly. By hand: the first two polynomials
    /// are sqrt(12) u and sqrt(180) (u^2 - 1/12) about the middle.
    #[test]
    fn coordinates_on_a_diagonal_lie_badly_together() {
        let cross = [[0.25, 0.25], [0.25, 0.75], [0.75, 0.25], [0.75, 0.75]].map(Vec::from);
        let even = 180.0 * f64::powi(1.0 / 16.0 - 1.0 / 12.0, 2);
        assert!((badness(&cross, 2)[(0, 1)] - even.powi(2)).abs() < 1e-12);
        let diagonal = [[0.25, 0.25], [0.75, 0.75]].map(Vec::from);
        let odd = 12.0 / 16.0;
        let expected = f64::powi(odd, 2) + even.powi(2);
        assert!((badness(&diagonal, 2)[(0, 1)] - expected).abs() < 1e-12);
    }

    /// Of the first fourteen coordinates some lie together worse than at random: with 512 points, their products have means
    /// of several standard errors of independent points (0.044). No parameter gets such a pair.
    #[test]
    fn no_parameter_has_a_bad_pair() {
        for seed in 1..20 {
            let rows = pairs(7, 512, seed).unwrap();
            let badness = badness(&rows, 14);
            for i in 0..7 {
                assert!(badness[(i, 7 + i)] < 0.044_f64.powi(2), "{seed} {i}");
            }
        }
    }
}
