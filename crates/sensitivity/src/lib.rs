#![doc = include_str!("../README.md")]

#[cfg(test)]
#[path = "../examples/functions/mod.rs"]
mod functions;
pub mod method;
pub mod morris;
pub mod pairs;
mod ratio;
pub mod shapley;
pub mod sobol;
#[cfg(test)]
mod testing;

pub use sampling::statistics::estimate::Estimate;

use method::FromRuns;

// A new method is a file with a type that implements this trait, its `mod` line above and its place in the list below. The command,
// the terminal and the page show its results.

/// The methods; the first one is the usual one.
pub const RUNS: &[&dyn FromRuns] = &[&sobol::Sobol, &morris::Morris];

/// The method of this name.
///
/// # Errors
/// Lists the names that there are.
pub fn named(name: &str) -> Result<&'static dyn FromRuns, String> {
    RUNS.iter().find(|method| method.facts().name == name).copied().ok_or_else(|| {
        let names: Vec<&str> = RUNS.iter().map(|method| method.facts().name).collect();
        format!("unknown method `{name}`; there are {}", names.join(", "))
    })
}

/// Whether an order of importance can be told: `None` where the interval of the largest estimate
/// overlaps the next one's, else the index of the largest.
pub fn dominant(estimates: &[Estimate]) -> Option<usize> {
    let mut order: Vec<usize> = (0..estimates.len()).filter(|&i| estimates[i].value.is_finite()).collect();
    order.sort_by(|&a, &b| estimates[b].value.total_cmp(&estimates[a].value));
    match order.as_slice() {
        [first, second, ..] => (estimates[*first].low > estimates[*second].high).then_some(*first),
        [only] => Some(*only),
        [] => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functions::{ishigami, ishigami_indices, sobol_g, sobol_g_indices};
    use crate::method::FirstOrder;
    use crate::testing::{lattice, near, settled};

    #[test]
    fn parts_of_a_variance_do_not_depend_on_the_unit() {
        let outputs = |design: Vec<Vec<f64>>| -> Vec<f64> {
            let output = |u: &Vec<f64>| u[0] + 2.0 * u[1] * u[1] - u[2];
            design.iter().map(output).collect()
        };
        let pairs = lattice(64, 6);
        let of_sobol = outputs(sobol::design(&pairs));
        let told = |unit: f64| {
            let in_unit = |values: &[f64]| values.iter().map(|v| unit * v).collect::<Vec<f64>>();
            sobol::indices(&in_unit(&of_sobol), 3, FirstOrder::default())
        };
        let usual = told(1.0);
        assert!(usual.as_ref().is_some_and(|indices| indices.total[0].value > 0.1));
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

    /// The texts that people read and write: names in a study and on the command line, sizes, and how a study is told.
    #[test]
    fn methods_are_called_by_name_and_say_what_they_do() {
        let words = |name: &str| {
            let method = named(name).unwrap();
            let runs = method.runs(4, 7);
            let done = method.done(runs as usize, &settled(7, 1));
            let facts = method.facts();
            assert_eq!(facts.name, name);
            (facts.option, facts.usual_size, runs, method.title(7), done)
        };
        let sobol = "Sobol indices from 7 base points";
        let done = format!("{sobol} (42 runs)");
        assert_eq!(words("sobol"), ("base", 256, 42, sobol.to_owned(), done));
        let morris = "Morris screening by 7 trajectories";
        let done = "Morris screening, 35 runs".to_owned();
        assert_eq!(words("morris"), ("morris", 20, 35, morris.to_owned(), done));
        let unknown = named("Sobol").map(|method| method.facts().name);
        let message = "unknown method `Sobol`; there are sobol, morris";
        assert!(unknown.is_err_and(|error| error.starts_with(message)));
    }

    /// `Ishigami.evaluate` of SALib 1.5. The indices are those that its documentation gives.
    #[test]
    fn ishigami_is_that_of_others() {
        near([ishigami(&[0.6, 0.3, 0.9])], [9.264_535_220_628]);
        let (first, total) = ishigami_indices();
        let rounded = |indices: [f64; 3]| indices.map(|index| (1e4 * index).round() / 1e4);
        assert_eq!(rounded(first), [0.3139, 0.4424, 0.0]);
        assert_eq!(rounded(total), [0.5576, 0.4424, 0.2437]);
    }

    /// `Sobol_G` of SALib 1.5: `evaluate`, `sensitivity_index`, `total_sensitivity_index`.
    #[test]
    fn sobol_g_is_that_of_others() {
        let a = [0.0, 1.0, 4.5, 9.0];
        near([sobol_g(&[0.1, 0.3, 0.8, 0.6], &a)], [1.402_821_818_182]);
        let (first, total) = sobol_g_indices(&a);
        let exact = [0.716_492_934_858, 0.179_123_233_714, 0.023_685_716_855, 0.007_164_929_349];
        near(first.try_into().unwrap(), exact);
        let exact = [0.787_369_701_143, 0.242_267_600_352, 0.034_326_744_464, 0.010_463_384_733];
        near(total.try_into().unwrap(), exact);
    }
}
