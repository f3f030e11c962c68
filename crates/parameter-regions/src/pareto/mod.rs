//! Many criteria at once: which points no other point beats in everything.
//!
//! The objectives are the normalised deviations of the criteria; all are minimised.

mod front;
pub mod study;

pub use front::{dominates, front};

use crate::table::PointTable;

/// The Pareto front of a study's points: no other point is closer to the measurement in every criterion.
pub fn unbeaten(table: &PointTable, candidates: &[usize]) -> Vec<bool> {
    let deviations = |i: usize| table.deviations(i).collect::<Vec<f64>>();
    let points: Vec<Vec<f64>> = candidates.iter().map(|&i| deviations(i)).collect();
    let mut unbeaten = vec![true; candidates.len()];
    for other in (0..table.len()).map(deviations) {
        for (flag, point) in unbeaten.iter_mut().zip(&points) {
            *flag &= !dominates(&other, point);
        }
    }
    unbeaten
}
