//! How far the numerical error of a model goes into a fit. A run with half the steps shows it, as it halves with the steps or
//! falls faster: twice the change is the error. What that moves is one step of Gauss and Newton from the optimum, with the
//! derivatives from which the intervals come.

use nalgebra::DVector;
use result_document::format::{shown, significant};
use serde::Serialize;

use super::{objective::Misfit, optima::Optimum, problem::Problem};

/// A larger part of half an interval, or of two standard uncertainties of a value, is notable.
const PART: f64 = 1.0 / 3.0;

/// The numerical error of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct NumericalError {
    /// The communication steps of the fit, s: one, or those of the cases.
    pub steps: Vec<f64>,
    /// The sum of squares with half of them.
    pub cost: f64,
    /// The free parameters.
    pub free: Vec<Moved>,
    /// The measured value whose misfit half the steps change most, in its accuracies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Changed>,
}

/// A free parameter with finer steps.
#[derive(Clone, Debug, Serialize)]
pub struct Moved {
    /// Its name.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// By how much its most probable value would be higher, about.
    pub higher: f64,
    /// Half the length of its interval.
    pub half_interval: f64,
    /// The one as a part of the other, as the search measures both.
    pub part: f64,
}

/// A measured value with half the steps.
#[derive(Clone, Debug, Serialize)]
pub struct Changed {
    /// The quantity.
    pub quantity: String,
    /// The case, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// What the model predicts.
    pub predicted: f64,
    /// What it predicts with half the steps.
    pub finer: f64,
    /// Twice the change of the misfit as a part of two standard uncertainties, shared errors taken out.
    pub part: f64,
}

impl NumericalError {
    /// That of an optimum, from the model's misfit there with half of these steps.
    pub fn new(problem: &Problem, optimum: &Optimum, finer: &Misfit, steps: Vec<f64>) -> Self {
        let minimum = &optimum.minimum;
        let rows = problem.values();
        let change = finer.residuals.rows(0, rows) - minimum.misfit.residuals.rows(0, rows);
        let posterior = &optimum.posterior;
        let newton: DVector<f64> = -(&posterior.covariance * posterior.slopes[0].tr_mul(&change));
        let free = problem.free.iter().enumerate().map(|(index, free)| {
            let place = minimum.places[index];
            let moved = (place + 2.0 * newton[index]).clamp(0.0, 1.0);
            let [low, high] = optimum.intervals[index].ends;
            Moved {
                name: free.name.clone(),
                unit: free.unit.clone(),
                higher: free.value(moved) - free.value(place),
                half_interval: 0.5 * (free.value(high) - free.value(low)),
                part: (moved - place).abs() / (0.5 * (high - low)),
            }
        });
        let value = (0..rows).max_by(|&a, &b| change[a].abs().total_cmp(&change[b].abs())).map(|row| {
            let (case, k) = (row / problem.quantities.len(), row % problem.quantities.len());
            let several = problem.cases.len() > 1;
            Changed {
                quantity: problem.quantities[k].name.clone(),
                case: several.then(|| problem.cases[case].label.clone()),
                unit: problem.quantities[k].unit.clone(),
                predicted: minimum.misfit.predicted[case][k],
                finer: finer.predicted[case][k],
                part: change[row].abs(),
            }
        });
        Self { steps, cost: finer.cost(), free: free.collect(), value }
    }

    /// What to do about steps that are too coarse.
    pub const REMEDY: &'static str = "Choose a shorter `step` under [simulation], for a system `--step` of `system`.";

    /// What speaks against the steps; none where the error is small.
    pub fn doubt(&self) -> Option<String> {
        let moved: Vec<String> = self.free.iter().filter(|moved| moved.part > PART).map(Moved::words).collect();
        let changed = self.value.as_ref().filter(|value| value.part > PART);
        let told = match (&moved[..], changed) {
            ([], None) => return None,
            ([], Some(changed)) => format!("half of it changes {}", changed.words()),
            (moved, _) => format!("with finer ones {}, which the intervals leave out", moved.join(", ")),
        };
        let steps: Vec<String> = self.steps.iter().map(f64::to_string).collect();
        Some(format!("the communication step of {} s is too coarse: {told}", steps.join(" and ")))
    }
}

impl Moved {
    fn words(&self) -> String {
        let [by, half] = [self.higher.abs(), self.half_interval].map(|v| significant(v, 2));
        let side = if self.higher < 0.0 { "lower" } else { "higher" };
        let unit = shown(&self.unit);
        let number = format!("{by} {unit}");
        format!("{} would be about {} {side} (interval +-{half})", self.name, number.trim_end())
    }
}

impl Changed {
    fn words(&self) -> String {
        let [from, to] = [self.predicted, self.finer].map(|v| significant(v, 4));
        let case = self.case.as_ref();
        let case = case.map(|case| format!(" of case {case}")).unwrap_or_default();
        format!("{}{case} from {from} to {to} {}", self.quantity, shown(&self.unit)).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::super::objective::Objective;
    use super::super::problem::Spacing;
    use super::super::search::search;
    use super::super::testing::{effort, free, measured, problem, starts};
    use super::*;

    /// The model with the error `e` is `p + e` and `2 p - e`: by hand the optimum of the exact one, `(y1 + 2 y2) / 5`, is higher
    /// by `-e / 5`, and a deviation is the accuracy over the root of 5.
    fn error(of: f64, accuracy: f64) -> NumericalError {
        let problem = problem(vec![free("p", Spacing::Linear, -10.0, 10.0)], vec![measured(&[1.0, 2.0], accuracy)]);
        let coarse = move |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] + of, 2.0 * p[0] - of]);
        let half = move |_: usize, p: &[f64], _: &[f64]| Ok(vec![p[0] + 0.5 * of, 2.0 * p[0] - 0.5 * of]);
        let objective = Objective::new(&problem, &coarse, 1e-4);
        let (optima, _) = search(&objective, &starts(1, 4), &effort(2, 40), &|_| ()).unwrap();
        let places = &optima[0].minimum.places;
        let finer = Objective::new(&problem, &half, 1e-4).misfit(places);
        NumericalError::new(&problem, &optima[0], &finer.unwrap(), vec![0.5])
    }

    #[test]
    fn a_parameter_moves_as_far_as_the_exact_fit_is_away() {
        let found = error(0.5, 0.1);
        let [moved] = &found.free[..] else { panic!("{found:?}") };
        assert!((moved.higher + 0.1).abs() < 1e-4, "{moved:?}");
        let half = 1.96 * 0.1 / 5.0_f64.sqrt();
        assert!((moved.half_interval - half).abs() < 1e-3, "{moved:?}");
        assert_eq!(
            found.doubt().unwrap(),
            "the communication step of 0.5 s is too coarse: with finer ones p would be about 0.1 lower (interval +-0.088), which the \
             intervals leave out"
        );
    }

    #[test]
    fn a_value_that_no_parameter_follows_is_a_doubt_and_a_small_error_is_none() {
        let found = error(0.05, 0.06);
        let part = found.free[0].part;
        assert!(part < PART, "{part}");
        let told = found.doubt().unwrap();
        assert!(told.contains("half of it changes y"), "{told}");
        assert!(error(0.005, 0.06).doubt().is_none());
    }
}
