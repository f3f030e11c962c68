//! A table that says in which slice of every input each point lies.

use super::rule::Rule;
use crate::{
    distribution::BELOW_ONE,
    random::{self, Purpose},
};

/// A table of slices: a Latin hypercube when each column is a permutation.
#[derive(Clone, Debug)]
pub(super) struct Slices {
    seed: u64,
    points: usize,
    /// The slice of each point, input after input.
    columns: Vec<Vec<u32>>,
}

impl Slices {
    pub(super) fn new(seed: u64, points: usize, columns: Vec<Vec<u32>>) -> Self {
        Self { seed, points, columns }
    }

    /// The place in (0, 1) that belongs to a slice of an input. It belongs to the slice and not to the point, so that the
    /// places of an input stay the same when points exchange slices.
    pub(super) fn place(seed: u64, points: usize, slice: u32, dimension: u32) -> f64 {
        let within = random::uniform(seed, Purpose::Jitter, slice.into(), dimension);
        coordinate(slice.into(), within, points as f64)
    }

    #[cfg(test)]
    pub(super) fn columns(&self) -> &[Vec<u32>] {
        &self.columns
    }
}

impl Rule for Slices {
    fn uniform(&self, index: u64, dimension: u32) -> f64 {
        let point = usize::try_from(index).unwrap_or(0) % self.points;
        Self::place(self.seed, self.points, self.columns[dimension as usize][point], dimension)
    }
}

/// The coordinate below 1 at a place within one of N slices; rounding must not reach 1.
pub(super) fn coordinate(slice: f64, within: f64, points: f64) -> f64 {
    ((slice + within) / points).min(BELOW_ONE)
}

/// The ranks of numbers, from 0; of equal ones the first comes first.
pub(super) fn ranks(values: &[f64]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..).take(values.len()).collect();
    order.sort_by(|&a, &b| values[a as usize].total_cmp(&values[b as usize]));
    let mut ranks = vec![0; order.len()];
    for (rank, point) in (0..).zip(order) {
        ranks[point as usize] = rank;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_numbers_are_ranked_as_they_come() {
        assert_eq!(ranks(&[0.3, -1.0, 7.0, 0.3]), [1, 0, 3, 2]);
        assert!(ranks(&[]).is_empty());
    }

    #[test]
    fn a_point_lies_in_its_slice_at_a_place_of_the_slice_s_own() {
        let table = Slices::new(5, 4, vec![vec![2, 0, 3, 1], vec![1, 2, 0, 3]]);
        for (dimension, column) in (0..).zip(table.columns()) {
            for (index, &slice) in (0..).zip(column) {
                let u = table.uniform(index, dimension);
                let within = 4.0 * u - f64::from(slice);
                let expected = random::uniform(5, Purpose::Jitter, slice.into(), dimension);
                assert!((within - expected).abs() < 1e-14, "{dimension} {index}");
            }
        }
        assert_eq!(table.uniform(6, 0), table.uniform(2, 0));
    }

    #[test]
    fn rounding_never_reaches_one() {
        assert_eq!(coordinate(1.0, 0.5, 4.0), 0.375);
        assert_eq!(2.0 + BELOW_ONE, 3.0);
        assert_eq!(coordinate(2.0, BELOW_ONE, 3.0), BELOW_ONE);
    }
}
