//! The Pareto front: points that no other point dominates.
//!
//! Kung, Luccio & Preparata (1975), "On finding the maxima of a set of vectors", J. ACM 22, 469-476: divide and
//! conquer over the points and over the objectives, so that a million points of which most are on the front need
//! seconds. Comparing each with each would need hours.

/// Sets of this size are compared point by point.
const FEW: usize = 32;

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
    // Equal points share their fate; of different ones, no worse in everything means dominating.
    let groups: Vec<&[usize]> = order.chunk_by(|&a, &b| objectives[a] == objectives[b]).collect();
    let points = groups.iter().map(|g| objectives[g[0]].as_slice());
    let kept = Ordered(points.collect()).front(0..groups.len());
    let mut front: Vec<usize> = kept.into_iter().flat_map(|g| groups[g]).copied().collect();
    front.sort_unstable();
    front
}

/// Different points in lexicographic order: one can only be dominated by one before it.
struct Ordered<'a>(Vec<&'a [f64]>);

impl Ordered<'_> {
    /// The points of a range that no other point of the range dominates.
    fn front(&self, range: std::ops::Range<usize>) -> Vec<usize> {
        if range.len() <= FEW {
            let mut kept: Vec<usize> = Vec::new();
            for i in range {
                if !kept.iter().any(|&k| no_worse(self.0[k], self.0[i])) {
                    kept.push(i);
                }
            }
            return kept;
        }
        let middle = range.start + range.len() / 2;
        let mut kept = self.front(range.start..middle);
        let last = self.0[range.start].len().saturating_sub(1);
        let rest = self.unbeaten(&kept, self.front(middle..range.end), last);
        kept.extend(rest);
        kept
    }

    /// The `candidates` that none of `others` dominates, where `others` are known to be no worse in the
    /// objectives after `last` (and in the first).
    fn unbeaten(&self, others: &[usize], mut candidates: Vec<usize>, last: usize) -> Vec<usize> {
        if others.is_empty() || candidates.is_empty() {
            return candidates;
        }
        let value = |i: usize| self.0[i][last];
        if last == 0 {
            return vec![];
        }
        if last == 1 {
            let values = others.iter().map(|&i| value(i));
            let least = values.fold(f64::INFINITY, f64::min);
            candidates.retain(|&i| value(i) < least);
            return candidates;
        }
        let beaten = |i: usize| {
            let covers = |&k: &usize| no_worse(&self.0[k][1..=last], &self.0[i][1..=last]);
            others.iter().any(covers)
        };
        if others.len().min(candidates.len()) <= FEW {
            candidates.retain(|&i| !beaten(i));
            return candidates;
        }
        let Some(limit) = self.between(others, last) else {
            // All of `others` are equal here.
            let only = value(others[0]);
            let (behind, mut kept): (Vec<_>, Vec<_>) = candidates.into_iter().partition(|&i| value(i) >= only);
            kept.extend(self.unbeaten(others, behind, last - 1));
            return kept;
        };
        let split = |i: &usize| value(*i) < limit;
        let (low, high): (Vec<_>, Vec<_>) = others.iter().copied().partition(split);
        let (mut kept, above): (Vec<_>, Vec<_>) = candidates.into_iter().partition(split);
        kept = self.unbeaten(&low, kept, last);
        let above = self.unbeaten(&high, above, last);
        kept.extend(self.unbeaten(&low, above, last - 1));
        kept
    }

    /// A value of an objective that parts the points into two sets, neither of which is empty: those below it, and
    /// the others; none when all are equal.
    fn between(&self, points: &[usize], objective: usize) -> Option<f64> {
        let mut values: Vec<f64> = points.iter().map(|&i| self.0[i][objective]).collect();
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let half = values.len() / 2;
        let (_, median, upper) = values.select_nth_unstable_by(half, f64::total_cmp);
        if *median > least {
            return Some(*median);
        }
        let next = upper.iter().copied().filter(|v| *v > least);
        next.min_by(f64::total_cmp)
    }
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
