//! Many criteria at once: which points no other point beats in everything.
//!
//! The objectives are the normalised deviations of the criteria; all are minimised.

pub mod nsga2;
pub mod study;

use crate::analysis::table::PointTable;

/// Whether `a` is at least as good as `b` in every objective and better in one.
pub fn dominates(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| x <= y) && a.iter().zip(b).any(|(x, y)| x < y)
}

/// Points that no other one dominates, in order. Points with a value that is not finite never are.
///
/// Kung, Luccio & Preparata (1975): after sorting by the first objective, a point can only be
/// dominated by one before it.
pub fn front(objectives: &[Vec<f64>]) -> Vec<usize> {
    let finite = |i: &usize| objectives[*i].iter().all(|v| v.is_finite());
    let mut order: Vec<usize> = (0..objectives.len()).filter(finite).collect();
    order.sort_by(|&a, &b| {
        let pairs = objectives[a].iter().zip(&objectives[b]);
        pairs
            .map(|(x, y)| x.total_cmp(y))
            .find(|o| o.is_ne())
            .unwrap_or(a.cmp(&b))
    });
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if !kept
            .iter()
            .any(|&k| dominates(&objectives[k], &objectives[i]))
        {
            kept.push(i);
        }
    }
    kept.sort_unstable();
    kept
}

/// Which of some points of a study no other point of it dominates, by their deviations.
pub fn unbeaten(table: &PointTable, candidates: &[usize]) -> Vec<bool> {
    let deviations = |i: usize| -> Vec<f64> {
        table
            .criteria
            .iter()
            .map(|c| c.deviation(c.values[i]))
            .collect()
    };
    let own: Vec<Vec<f64>> = candidates.iter().map(|&i| deviations(i)).collect();
    let mut unbeaten = vec![true; candidates.len()];
    for other in (0..table.len()).map(deviations) {
        for (flag, point) in unbeaten.iter_mut().zip(&own) {
            *flag &= !dominates(&other, point);
        }
    }
    unbeaten
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_front_of_a_few_points() {
        let points = [
            vec![1.0, 4.0],
            vec![2.0, 2.0],
            vec![3.0, 3.0],
            vec![4.0, 1.0],
            vec![f64::NAN, 0.0],
            vec![2.0, 2.0],
        ];
        assert_eq!(front(&points), [0, 1, 3, 5]);
    }

    proptest! {
        #[test]
        fn exactly_the_points_that_nothing_dominates(points in prop::collection::vec(prop::collection::vec(0.0..4.0f64, 3), 1..40)) {
            let found = front(&points);
            for i in 0..points.len() {
                let beaten = points.iter().any(|p| dominates(p, &points[i]));
                prop_assert_eq!(found.contains(&i), !beaten);
            }
        }
    }
}
