//! Polynomials in place of a model: one for each measured value, in layers that come nearer to the posterior.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::super::problem::{NoPrediction, Prediction, Problem, Query, Simulate};
use parameter_regions::robustness::region::within;
use parameter_regions::robustness::surrogate::Surrogate;

/// The highest total degree of a polynomial.
const DEGREE: usize = 12;

/// A place at which the model was run, and what it said of all cases.
#[derive(Clone, Debug)]
pub(super) struct Run {
    /// The unknowns, as places between their bounds.
    pub(super) places: Vec<f64>,
    /// Predictions, case by case; or why a run failed.
    pub(super) predicted: Result<Vec<Vec<f64>>, String>,
}

/// The ends of a box, an unknown each.
pub(super) type Bounds = Vec<[f64; 2]>;

/// Polynomials that were fitted to the runs within a box.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    /// The box.
    pub(super) region: Bounds,
    /// Case by case, one a measured value.
    fits: Vec<Vec<Surrogate>>,
    /// The largest eigenvalue of the errors' correlations: with this factor independent errors are nowhere smaller than those
    /// of the polynomials, which go together.
    pub(super) together: f64,
}

impl Layer {
    /// Fits the runs within a box; `None` where they are too few.
    fn fit(problem: &Problem, runs: &[Run], region: Bounds) -> Option<Self> {
        let within = |run: &&Run| run.predicted.is_ok() && within(&run.places, &region);
        let runs: Vec<&Run> = runs.iter().filter(within).collect();
        let value = |case: usize, quantity: usize| -> Option<Surrogate> {
            let inputs = runs.iter().map(|run| of_case(problem, case, &run.places));
            let ended = runs.iter().filter_map(|run| run.predicted.as_ref().ok());
            let outputs = ended.map(|predicted| predicted[case][quantity]);
            let (inputs, outputs): (Vec<_>, Vec<_>) = (inputs.collect(), outputs.collect());
            Surrogate::fit_to(&inputs, &outputs, DEGREE)
        };
        let quantities = problem.quantities.len();
        let all: Vec<(usize, usize)> =
            (0..problem.cases.len()).flat_map(|case| (0..quantities).map(move |quantity| (case, quantity))).collect();
        let fits: Option<Vec<Surrogate>> = all.par_iter().map(|&(case, quantity)| value(case, quantity)).collect();
        let fits: Vec<Vec<Surrogate>> = fits?.chunks(quantities).map(<[_]>::to_vec).collect();
        Some(Self { together: together(&fits), region, fits })
    }

    /// Root mean square and largest leave-one-out error of each measured value, case by case.
    pub(super) fn errors(&self) -> Vec<Vec<[f64; 2]>> {
        let errors = |fit: &Surrogate| {
            let largest = fit.errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
            [fit.quality.error, largest]
        };
        let cases = self.fits.iter();
        cases.map(|fits| fits.iter().map(errors).collect()).collect()
    }
}

/// Of something for each unknown that for those which a case depends on: the free parameters and its own latent ones.
fn of_case<T: Copy>(problem: &Problem, case: usize, all: &[T]) -> Vec<T> {
    let free = &all[..problem.free.len()];
    [free, &all[problem.latents_of(case)]].concat()
}

/// The largest eigenvalue of the correlations of the errors.
fn together(fits: &[Vec<Surrogate>]) -> f64 {
    let columns: Vec<Vec<f64>> = fits
        .iter()
        .flatten()
        .filter_map(|fit| {
            let size = fit.errors.iter().map(|e| e * e).sum::<f64>().sqrt();
            (size > 0.0).then(|| fit.errors.iter().map(|e| e / size).collect())
        })
        .collect();
    let Some(first) = columns.first() else {
        return 1.0;
    };
    let matrix = DMatrix::from_fn(first.len(), columns.len(), |j, k| columns[k][j]);
    // Both products have the same eigenvalues but for zeros.
    let product = match first.len() < columns.len() {
        true => &matrix * matrix.transpose(),
        false => matrix.transpose() * &matrix,
    };
    product.symmetric_eigenvalues().max().max(1.0)
}

/// The surrogates of all measured values.
#[derive(Clone, Debug)]
pub struct Surrogates {
    problem: Problem,
    /// The first one is of the whole space, each next one nearer to the posterior.
    layers: Vec<Layer>,
    /// Places at which the model was run, and why a run failed there.
    ended: Vec<(Vec<f64>, Option<String>)>,
}

impl Surrogates {
    pub(super) fn new(problem: &Problem) -> Self {
        Self { problem: problem.clone(), layers: Vec::new(), ended: Vec::new() }
    }

    /// Adds a layer from the runs within a box. False where they are too few.
    pub(super) fn refine(&mut self, runs: &[Run], region: Bounds) -> bool {
        let reason = |run: &Run| run.predicted.as_ref().err().cloned();
        let ended = runs.iter().map(|run| (run.places.clone(), reason(run)));
        self.ended = ended.collect();
        let layer = Layer::fit(&self.problem, runs, region);
        let fits = layer.is_some();
        self.layers.extend(layer);
        fits
    }

    /// The layer that is nearest to the posterior.
    pub(super) fn last(&self) -> &Layer {
        self.layers.last().expect("surrogates are asked after the first fit")
    }

    /// Where a query stands between the bounds.
    fn places(&self, query: &Query) -> Vec<f64> {
        let free = self.problem.free.iter().zip(&query.free);
        let free = free.map(|(free, value)| free.place(*value));
        let intervals = self.problem.cases[query.case].latents.iter();
        let latents = intervals.zip(&query.latents);
        let latents = latents.map(|(interval, value)| (value - interval.min) / (interval.max - interval.min));
        free.chain(latents).collect()
    }

    /// Why the run failed that is nearest to a place of a case, if it did.
    fn failure(&self, case: usize, places: &[f64]) -> Option<String> {
        if self.ended.iter().all(|(_, reason)| reason.is_none()) {
            return None;
        }
        let square = |other: &[f64]| -> f64 {
            let other = of_case(&self.problem, case, other);
            let pairs = places.iter().zip(&other);
            pairs.map(|(a, b)| (a - b).powi(2)).sum()
        };
        let ended = self.ended.iter().map(|run| (square(&run.0), &run.1));
        let nearest = ended.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.and_then(|(_, reason)| reason.clone())
    }

    fn predict(&self, query: &Query) -> Prediction {
        let places = self.places(query);
        if let Some(reason) = self.failure(query.case, &places) {
            return Err(reason);
        }
        let inside = |layer: &&Layer| {
            let region = of_case(&self.problem, query.case, &layer.region);
            within(&places, &region)
        };
        let layer = self.layers.iter().rev().find(inside);
        let layer = layer.unwrap_or(&self.layers[0]);
        let fits = layer.fits[query.case].iter();
        Ok(fits.map(|fit| fit.at(&places)).collect())
    }
}

impl Simulate for Surrogates {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        // Fewer would not pay for another thread.
        const TOGETHER: usize = 64;
        let queries = queries.par_iter().with_min_len(TOGETHER);
        Ok(queries.map(|query| self.predict(query)).collect())
    }
}
