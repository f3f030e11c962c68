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

use method::{FromPoints, FromRuns};
use sampling::statistics::moments::moderate_unit;

// A new method is a file with a type that implements one of these traits, its `mod` line above and its line in a list below. The
// command, the terminal and the page show its results.

/// Methods that need runs of their own; the first one is the usual one.
pub const RUNS: &[&dyn FromRuns] = &[&sobol::Sobol, &morris::Morris, &shapley::Shapley];

/// Methods for any points.
pub const VIEWS: &[&dyn FromPoints] = &[&rank::Ranks, &pawn::Slices];

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

/// Outputs in a unit in which their squares are numbers: no part of a variance depends on the unit.
pub(crate) fn moderate(outputs: &[f64]) -> Vec<f64> {
    let unit = moderate_unit(outputs.iter().copied());
    outputs.iter().map(|value| value / unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::FirstOrder;
    use crate::testing::{lattice, settled};

    #[test]
    fn parts_of_a_variance_do_not_depend_on_the_unit() {
        let outputs = |design: Vec<Vec<f64>>| -> Vec<f64> {
            let output = |u: &Vec<f64>| u[0] + 2.0 * u[1] * u[1] - u[2];
            design.iter().map(output).collect()
        };
        let settled = settled(64, 1);
        let pairs = lattice(64, 6);
        let of_sobol = outputs(sobol::design(&pairs));
        let of_shapley = outputs(shapley::design(&pairs, None, 1).expect("they are independent"));
        let told = |unit: f64| {
            let in_unit = |values: &[f64]| values.iter().map(|v| unit * v).collect::<Vec<f64>>();
            (
                sobol::indices(&in_unit(&of_sobol), 3, FirstOrder::default()),
                shapley::effects(&in_unit(&of_shapley), 3, &settled),
            )
        };
        let usual = told(1.0);
        assert!(
            usual
                .0
                .as_ref()
                .is_some_and(|indices| indices.total[0].value > 0.1)
        );
        // Powers of two, so that no digit changes.
        assert_eq!(told(2.0_f64.powi(1000)), usual);
        assert_eq!(told(2.0_f64.powi(-900)), usual);
    }

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
