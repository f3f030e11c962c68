//! The Pareto front: points that no other point dominates.

fn no_worse(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| x <= y)
}

/// Points that no other one dominates, in order. Points with a value that is not finite never are.
pub fn front(objectives: &[Vec<f64>]) -> Vec<usize> {
    let finite = |i: &usize| objectives[*i].iter().all(|v| v.is_finite());
    let mut order: Vec<usize> = (0..objectives.len()).filter(finite).collect();
    order.sort_by(|&a, &b| {
        let mut pairs = objectives[a].iter().zip(&objectives[b]);
        // 0 and -0 are equal.
        let first = pairs.find_map(|(x, y)| x.partial_cmp(y).filter(|o| o.is_ne()));
        first.unwrap_or_else(|| a.cmp(&b))
    });
    // In this order a point can only be dominated by one before it. Equal points share their fate; of different ones, no worse in
    // everything means dominating.
    let mut kept: Vec<&[usize]> = Vec::new();
    for group in order.chunk_by(|&a, &b| objectives[a] == objectives[b]) {
        if !kept.iter().any(|before| no_worse(&objectives[before[0]], &objectives[group[0]])) {
            kept.push(group);
        }
    }
    let mut front = kept.concat();
    front.sort_unstable();
    front
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_front_of_a_few_points() {
        let points =
            [vec![1.0, 4.0], vec![2.0, 2.0], vec![3.0, 3.0], vec![4.0, 1.0], vec![f64::NAN, 0.0], vec![2.0, 2.0]];
        assert_eq!(front(&points), [0, 1, 3, 5]);
        assert_eq!(front(&[]), [0usize; 0]);
        assert_eq!(front(&[vec![2.0], vec![1.0], vec![1.0]]), [1, 2]);
        assert_eq!(front(&[vec![0.0, 1.0], vec![-0.0, 1.0]]), [0, 1]);
    }

    /// Whether `a` is at least as good as `b` in every objective and better in one.
    fn dominates(a: &[f64], b: &[f64]) -> bool {
        no_worse(a, b) && a.iter().zip(b).any(|(x, y)| x < y)
    }

    /// Values of a few steps, so that many are equal.
    fn points() -> impl Strategy<Value = Vec<Vec<f64>>> {
        (1..6usize, 2..30u8).prop_flat_map(|(objectives, steps)| {
            let value = (0..steps).prop_map(f64::from);
            prop::collection::vec(prop::collection::vec(value, objectives), 1..400)
        })
    }

    proptest! {
        #[test]
        fn exactly_the_points_that_nothing_dominates(points in points()) {
            let indices = front(&points);
            let unbeaten = |i: &usize| !points.iter().any(|p| dominates(p, &points[*i]));
            let expected: Vec<usize> = (0..points.len()).filter(unbeaten).collect();
            prop_assert_eq!(indices, expected);
        }
    }
}
