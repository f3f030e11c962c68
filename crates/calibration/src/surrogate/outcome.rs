//! Kind and error of the surrogates: plain data that becomes JSON.

use serde::Serialize;

use super::super::failures::Range;
use super::super::problem::Problem;
use super::fitted::Surrogates;

/// The surrogates of an identification.
#[derive(Clone, Debug, Serialize)]
pub struct SurrogateOutcome {
    /// At how many places the model was run, all cases each; those of the optima, which are run again, come on top.
    pub runs: usize,
    /// At how many of them a run failed.
    pub failed: u64,
    /// How often the surrogates were fitted, each time nearer to the posterior.
    pub rounds: usize,
    /// Fresh places of the posterior at which surrogates and model were compared.
    pub checked: usize,
    /// Fresh places of the posterior at which the model's run failed.
    pub check_failed: usize,
    /// The box of the last surrogates.
    pub within: Vec<Range>,
    /// The factor by which the counted variance is larger than that of each error, as errors of several values go together.
    pub together: f64,
    /// The errors of each measured value, case by case.
    pub errors: Vec<Vec<ValueError>>,
    /// The largest part of an accuracy that an error counted comes to.
    pub largest: f64,
    /// The optima run again in the model.
    pub optima: Vec<RunAgain>,
}

/// A surrogate's error of a measured value, in its unit.
#[derive(Clone, Debug, Serialize)]
pub struct ValueError {
    /// The quantity.
    pub quantity: String,
    /// Root mean square of the leave-one-out errors of the runs in the box.
    pub leave_one_out: f64,
    /// Root mean square at the fresh places; `None` where none could be compared.
    pub held_out: Option<f64>,
    /// The standard uncertainty that is counted beside the accuracy.
    pub counted: f64,
    /// The accuracy.
    pub accuracy: f64,
}

impl ValueError {
    /// The error counted as a part of the accuracy.
    pub(super) fn part(&self) -> f64 {
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
    /// Gathers the errors; `checked` has a row of errors for each fresh place. `counts` are rounds, runs and failed ones.
    pub(super) fn new(
        problem: &Problem,
        surrogates: &Surrogates,
        (rounds, runs, failed): (usize, usize, u64),
        checked: &[Vec<f64>],
    ) -> Self {
        let layer = surrogates.last();
        let held_out = |index: usize| {
            let squares: f64 = checked.iter().map(|row| row[index].powi(2)).sum();
            (!checked.is_empty()).then(|| (squares / checked.len() as f64).sqrt())
        };
        let fits = layer.errors();
        let value = |case: usize, quantity: usize| {
            let [leave_one_out, _] = fits[case][quantity];
            let held_out = held_out(case * problem.quantities.len() + quantity);
            let larger = held_out.map_or(leave_one_out, |error| error.max(leave_one_out));
            ValueError {
                quantity: problem.quantities[quantity].name.clone(),
                leave_one_out,
                held_out,
                counted: layer.together.sqrt() * larger,
                accuracy: problem.cases[case].measured[quantity].accuracy,
            }
        };
        let quantities = 0..problem.quantities.len();
        let case = |case| quantities.clone().map(|q| value(case, q)).collect();
        let errors: Vec<Vec<ValueError>> = (0..fits.len()).map(case).collect();
        let all = errors.iter().flatten();
        Self {
            runs,
            failed,
            rounds,
            checked: checked.len(),
            check_failed: 0,
            within: Range::all(problem, &layer.region),
            together: layer.together,
            largest: all.map(ValueError::part).fold(0.0, f64::max),
            errors,
            optima: Vec::new(),
        }
    }

    /// The problem with the errors counted beside its accuracies.
    pub fn widened(&self, problem: &Problem) -> Problem {
        problem.widened(|case, quantity| self.errors[case][quantity].counted)
    }
}
