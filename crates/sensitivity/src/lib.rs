#![doc = include_str!("../README.md")]

pub mod functions;
pub mod lost;
pub mod method;
pub mod methods;
pub mod morris;
pub mod pairs;
pub mod pawn;
pub mod rank;
mod rare;
pub mod ratio;
pub mod regional;
pub mod shapley;
pub mod sobol;
#[cfg(test)]
mod testing;

pub use sampling::statistics::estimate::Estimate;

/// Whether an order of importance can be told: `None` where the interval of the largest estimate
/// overlaps the next one's, else the index of the largest.
pub fn dominant(estimates: &[Estimate]) -> Option<usize> {
    let mut order: Vec<usize> = (0..estimates.len())
        .filter(|&i| estimates[i].value.is_finite())
        .collect();
    order.sort_by(|&a, &b| estimates[b].value.total_cmp(&estimates[a].value));
    match order.as_slice() {
        [first, second, ..] => (estimates[*first].low > estimates[*second].high).then_some(*first),
        [only] => Some(*only),
        [] => None,
    }
}

/// The least and the largest of the values that are numbers; none where none is.
pub(crate) fn range(values: &[f64]) -> Option<[f64; 2]> {
    let known = values.iter().copied().filter(|value| value.is_finite());
    known.fold(None, |ends, value| {
        let [low, high] = ends.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_verdict_on_overlapping_intervals() {
        let sure = [Estimate::around(0.8, 0.1), Estimate::around(0.3, 0.1)];
        let unsure = [Estimate::around(0.8, 0.3), Estimate::around(0.5, 0.2)];
        assert_eq!(dominant(&sure), Some(0));
        assert_eq!(dominant(&unsure), None);
        assert_eq!(dominant(&[]), None);
        // Intervals that touch overlap; a number that is none has no place in the order.
        let touching = [Estimate::around(0.5, 0.25), Estimate::around(1.0, 0.25)];
        assert_eq!(dominant(&touching), None);
        let nothing = Estimate::around(f64::NAN, 0.0);
        assert_eq!(dominant(&[nothing, sure[1], sure[0]]), Some(2));
        assert_eq!(dominant(&[nothing, sure[1]]), Some(1));
    }
}
