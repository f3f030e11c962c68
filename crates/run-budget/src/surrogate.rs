//! The surrogate of all outputs of a model, and of whether a run succeeds.

use crate::output::{Check, Functions, Output};
use nalgebra::DMatrix;
use rayon::prelude::*;
use sampling::random::{Purpose, Random};
use thiserror::Error;

/// Runs without which nothing is fitted.
pub const LEAST: usize = 12;
/// Failed runs from which on they are taken as a region of their own.
const LEAST_FAILED: usize = 2;

/// One run of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The parameters.
    pub point: Vec<f64>,
    /// What came out; `None`: it failed.
    pub values: Option<Vec<f64>>,
}

impl Run {
    /// The values, where there are some and all of them are numbers.
    pub fn finite(&self) -> Option<&[f64]> {
        self.values.as_deref().filter(|values| values.iter().all(|v| v.is_finite()))
    }
}

/// Why there is no surrogate.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Unfit {
    /// Too few runs gave values.
    #[error("{runs} runs gave values; a surrogate needs {needed}")]
    TooFew {
        /// Those that did.
        runs: usize,
        /// Those that are needed.
        needed: usize,
    },
    /// The matrix of an output is singular whatever its length scales.
    #[error("no Gaussian process fits output {0}")]
    Output(usize),
}

/// The fitted surrogate.
#[derive(Clone, Debug)]
pub struct Surrogate {
    centre: Vec<f64>,
    deviation: Vec<f64>,
    pub(crate) outputs: Vec<Output>,
    pub(crate) success: Option<Output>,
    seed: u64,
}

impl Surrogate {
    /// Fits runs. Coordinates are scaled by the deviations of a plain sample of the parameters, `like`; a parameter that is the
    /// same in all of it takes no part. `earlier`, a fit to fewer runs, saves time.
    ///
    /// # Errors
    /// See [`Unfit`].
    pub fn fit(runs: &[Run], like: &[Vec<f64>], earlier: Option<&Self>, seed: u64) -> Result<Self, Unfit> {
        let d = like.first().map_or(0, Vec::len);
        let n = like.len() as f64;
        let mean = |k: usize| like.iter().map(|x| x[k]).sum::<f64>() / n;
        let centre: Vec<f64> = (0..d).map(mean).collect();
        let spread = |k: usize| (like.iter().map(|x| (x[k] - centre[k]).powi(2)).sum::<f64>() / n).sqrt();
        let deviation: Vec<f64> = (0..d).map(spread).collect();
        let good: Vec<(&Run, &[f64])> = runs.iter().filter_map(|run| Some((run, run.finite()?))).collect();
        let needed = LEAST.max(2 + d / 2);
        if good.len() < needed {
            return Err(Unfit::TooFew { runs: good.len(), needed });
        }
        let mut surrogate = Self { centre, deviation, outputs: Vec::new(), success: None, seed };
        let points: Vec<&[f64]> = good.iter().map(|(run, _)| run.point.as_slice()).collect();
        let points = surrogate.standard(&points);
        let width = good[0].1.len();
        let fit = |k: usize| {
            let values: Vec<f64> = good.iter().map(|(_, values)| values[k]).collect();
            let before = earlier.and_then(|e| e.outputs.get(k));
            Output::fit(points.clone(), &values, before, seed, k as u32).ok_or(Unfit::Output(k))
        };
        surrogate.outputs = (0..width).into_par_iter().map(fit).collect::<Result<_, _>>()?;
        if runs.len() - good.len() >= LEAST_FAILED {
            let points: Vec<&[f64]> = runs.iter().map(|run| run.point.as_slice()).collect();
            let succeeded: Vec<f64> = runs.iter().map(|run| if run.finite().is_some() { 1.0 } else { -1.0 }).collect();
            let before = earlier.and_then(|e| e.success.as_ref());
            surrogate.success = Output::fit(surrogate.standard(&points), &succeeded, before, seed, 1000);
        }
        Ok(surrogate)
    }

    /// What leaving runs out says, output by output.
    pub fn checks(&self) -> Vec<Check> {
        self.outputs.iter().map(|output| output.check).collect()
    }

    /// Means and deviations of an output at points: over all members, without noise.
    pub fn predict(&self, output: usize, points: &[Vec<f64>]) -> Vec<[f64; 2]> {
        let members = self.outputs[output].predict(&self.standard(points));
        let count = members.len() as f64;
        let one = |i: usize| {
            let mean = members.iter().map(|m| m[i][0]).sum::<f64>() / count;
            let square = |m: &Vec<[f64; 2]>| m[i][1].powi(2) + (m[i][0] - mean).powi(2);
            [mean, (members.iter().map(square).sum::<f64>() / count).sqrt()]
        };
        (0..points.len()).map(one).collect()
    }

    /// Means of all outputs by their most probable members; `None` at a point where a run is expected to fail. For many points:
    /// [`Self::predict`] asks all members, and for deviations.
    pub fn means(&self, points: &[Vec<f64>]) -> Vec<Option<Vec<f64>>> {
        let points = self.standard(points);
        let outputs: Vec<Vec<f64>> = self.outputs.iter().map(|output| output.means(&points)).collect();
        let success = self.success.as_ref().map(|success| success.means(&points));
        let one = |i: usize| {
            let fails = success.as_ref().is_some_and(|success| success[i] < 0.0);
            (!fails).then(|| outputs.iter().map(|output| output[i]).collect())
        };
        (0..points.ncols()).map(one).collect()
    }

    /// So many functions that an output may be from each member of its sample.
    pub fn functions(&self, output: usize, each: usize) -> Functions<'_> {
        self.outputs[output].functions(each, self.seed, 2000 + output as u32)
    }

    /// The same for success: a run is expected to fail where a function is below 0. `None` where hardly any run failed.
    pub fn success(&self, each: usize) -> Option<Functions<'_>> {
        self.success.as_ref().map(|output| output.functions(each, self.seed, 3000))
    }

    /// The deviation of an output among its runs; 1 where they are all the same.
    pub fn spread(&self, output: usize) -> f64 {
        self.outputs[output].unit
    }

    /// Mean and deviation (with noise) of an output at each successful run by the others.
    pub fn left_out(&self, output: usize) -> &[[f64; 2]] {
        &self.outputs[output].left_out
    }

    /// Random numbers of a stream of its own.
    pub(crate) fn random(&self, stream: u32) -> Random {
        Random::new(self.seed, Purpose::Surrogate, stream)
    }

    /// Standardised coordinates of the parameters that vary, one point a column.
    pub(crate) fn standard(&self, points: &[impl AsRef<[f64]>]) -> DMatrix<f64> {
        let varied: Vec<usize> = (0..self.deviation.len()).filter(|k| self.deviation[*k] > 0.0).collect();
        DMatrix::from_fn(varied.len(), points.len(), |k, i| {
            let k = varied[k];
            (points[i].as_ref()[k] - self.centre[k]) / self.deviation[k]
        })
    }
}
