//! What stands in for the model: Gaussian processes of the criteria, with the errors that leaving points out shows.

use super::rows;
use crate::table::{CriterionColumn, PointTable};
use run_budget::{Run, Surrogate};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

/// A fit takes the cube of the number of points; of more, so many are taken evenly.
const MOST_POINTS: usize = 200;

/// How well a surrogate predicts points that it was not fitted to.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Quality {
    /// Points fitted.
    pub points: usize,
    /// Root mean square of the leave-one-out errors, in the output's unit.
    pub error: f64,
    /// Part of the variance that is predicted, by leave-one-out: 1 perfect, 0 no better than the mean.
    pub predicted: f64,
}

/// The model's stand-in.
pub struct Stand {
    /// The criteria, without their values.
    pub criteria: Vec<CriterionColumn>,
    /// How well each of them is predicted.
    pub qualities: Vec<Quality>,
    surrogate: Surrogate,
    /// Predictions at each point of the table by a fit without it.
    left_out: Vec<Vec<f64>>,
}

impl Stand {
    /// Fits all criteria; `None` where one of them cannot be.
    pub fn fit(table: &PointTable) -> Option<Self> {
        let inputs = rows(table);
        let values = |i: usize| -> Vec<f64> { table.criteria.iter().map(|c| c.values[i]).collect() };
        let finite = |i: &usize| values(*i).iter().chain(&inputs[*i]).all(|v| v.is_finite());
        let complete: Vec<usize> = (0..table.len()).filter(finite).collect();
        let every = complete.len().div_ceil(MOST_POINTS).max(1);
        let taken: Vec<usize> = complete.into_iter().step_by(every).collect();
        let run = |i: &usize| Run { point: inputs[*i].clone(), values: Some(values(*i)) };
        let runs: Vec<Run> = taken.iter().map(run).collect();
        const SEED: u64 = 1;
        let surrogate = Surrogate::fit(&runs, &inputs, None, SEED).ok()?;
        let quality = |check: run_budget::Check| Quality {
            points: taken.len(),
            error: check.error,
            predicted: 1.0 - check.relative.powi(2),
        };
        let qualities = surrogate.checks().into_iter().map(quality).collect();
        let mut left_out = means(&surrogate, &inputs);
        for (number, i) in taken.into_iter().enumerate() {
            left_out[i] = (0..table.criteria.len()).map(|k| surrogate.left_out(k)[number][0]).collect();
        }
        let emptied = |c: &CriterionColumn| CriterionColumn { values: vec![], ok: vec![], ..c.clone() };
        Some(Self { criteria: table.criteria.iter().map(emptied).collect(), qualities, surrogate, left_out })
    }

    /// The predicted values of all criteria at points.
    pub fn values(&self, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
        means(&self.surrogate, points)
    }

    /// The probability that each criterion is met where the surrogates say so much, given their errors.
    fn each<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let normal = Normal::standard();
        let one = move |((c, quality), value): ((&CriterionColumn, &Quality), &f64)| {
            let least = (1e-12 * c.nominal.abs()).max(f64::MIN_POSITIVE);
            let error = quality.error.max(least);
            normal.cdf((c.upper - value) / error) - normal.cdf((c.lower - value) / error)
        };
        self.criteria.iter().zip(&self.qualities).zip(values).map(one)
    }

    /// The name of the criterion with the least probability over some points.
    pub(super) fn least_met(&self, points: &[Vec<f64>]) -> String {
        let mut sums = vec![0.0; self.criteria.len()];
        for values in self.values(points) {
            sums.iter_mut().zip(self.each(&values)).for_each(|(sum, met)| *sum += met);
        }
        let least = (0..sums.len()).min_by(|&a, &b| sums[a].total_cmp(&sums[b]));
        least.map_or_else(String::new, |k| self.criteria[k].name.clone())
    }

    /// The probability that all criteria are met at points.
    pub fn probabilities(&self, points: &[Vec<f64>]) -> Vec<f64> {
        self.values(points).iter().map(|values| self.each(values).product()).collect()
    }

    /// The probability that all criteria are met at each of the first points that were fitted, by surrogates without it.
    pub(super) fn foretold(&self, points: usize) -> Vec<f64> {
        self.left_out[..points].iter().map(|values| self.each(values).product()).collect()
    }
}

/// Means at points, of which none is expected to fail: failed points were not fitted.
fn means(surrogate: &Surrogate, points: &[Vec<f64>]) -> Vec<Vec<f64>> {
    surrogate.means(points).into_iter().flatten().collect()
}
