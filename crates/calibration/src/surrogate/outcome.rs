//! How good the surrogates are: plain data that becomes JSON.

use serde::Serialize;

use super::super::{failures::Range, problem::Problem};
use super::{Fresh, fitted::Surrogates};

/// The surrogates of an identification.
#[derive(Clone, Debug, Serialize)]
pub struct SurrogateOutcome {
    /// At how many places the model was run, all cases each, before the optima.
    pub runs: usize,
    /// So many of them had been run before, for the study's points.
    pub known: usize,
    /// At how many of them a run failed.
    pub failed: u64,
    /// How often the surrogates were fitted, each time nearer to the posterior.
    pub rounds: usize,
    /// Whether the surrogates hold; if not, the model itself was searched with what the budget left.
    pub holds: bool,
    /// The last runs that were compared with surrogates which did not know them.
    pub checked: usize,
    /// Those of them that failed.
    pub check_failed: usize,
    /// By how much the sums of squares of surrogates and model differ at these, in the middle.
    pub apart: Option<f64>,
    /// The box of the last surrogates.
    pub within: Vec<Range>,
    /// The value whose error in the posterior is the largest beside its accuracy.
    pub worst: ValueError,
    /// The optima run in the model.
    pub optima: Vec<RunAgain>,
}

/// A surrogate's error of a measured value, in its unit.
#[derive(Clone, Debug, Serialize)]
pub struct ValueError {
    /// The quantity.
    pub quantity: String,
    /// The standard uncertainty that is counted beside the accuracy.
    pub counted: f64,
    /// The accuracy.
    pub accuracy: f64,
}

impl ValueError {
    /// The error counted as a part of the accuracy.
    pub fn part(&self) -> f64 {
        self.counted / self.accuracy
    }
}

/// An optimum of the surrogates as the model sees it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct RunAgain {
    /// The sum of squares by the surrogates.
    pub surrogate: f64,
    /// The model's; `None` where a run failed.
    pub model: Option<f64>,
}

impl SurrogateOutcome {
    /// Gathers the errors, by case and quantity. `counts` are rounds, runs and those of them that were known, failed ones.
    pub(super) fn new(
        problem: &Problem,
        surrogates: &Surrogates,
        (rounds, [runs, known], failed): (usize, [usize; 2], u64),
        (errors, fresh): (&[Vec<f64>], &Fresh),
        holds: bool,
    ) -> Self {
        let value = |case: usize, quantity: usize| ValueError {
            quantity: problem.quantities[quantity].name.clone(),
            counted: errors[case][quantity],
            accuracy: problem.cases[case].measured[quantity].accuracy,
        };
        let all = (0..errors.len()).flat_map(|case| (0..errors[case].len()).map(move |quantity| value(case, quantity)));
        Self {
            runs,
            known,
            failed,
            rounds,
            holds,
            checked: fresh.compared,
            check_failed: fresh.failed,
            apart: fresh.apart.is_finite().then_some(fresh.apart),
            within: Range::all(problem, &surrogates.last().region),
            worst: all.max_by(|a, b| a.part().total_cmp(&b.part())).expect("a problem has measured values"),
            optima: Vec::new(),
        }
    }
}
