//! Gaussian processes in place of a model: those of each case's values, in layers that come nearer to the posterior.

use nalgebra::{DMatrix, DVector};
use run_budget::{Run as Known, Surrogate, Unfit};

use super::{
    super::problem::{NoPrediction, Prediction, Problem, Query, Simulate},
    components::Components,
};

/// A place at which the model was run, and what it said of all cases.
#[derive(Clone, Debug)]
pub struct Run {
    /// The unknowns, as places between their bounds.
    pub places: Vec<f64>,
    /// Predictions, case by case; or why a run failed.
    pub predicted: Result<Vec<Vec<f64>>, String>,
}

/// The ends of a box, an unknown each.
pub type Bounds = Vec<[f64; 2]>;

fn within(places: &[f64], bounds: &[[f64; 2]]) -> bool {
    places.iter().zip(bounds).all(|(place, [low, high])| (low..=high).contains(&place))
}

/// Of something for each unknown that for those which a case depends on: the free parameters and its own latent ones.
fn of_case<T: Copy>(problem: &Problem, case: usize, all: &[T]) -> Vec<T> {
    let free = &all[..problem.free.len()];
    [free, &all[problem.latents_of(case)]].concat()
}

/// The surrogate of a case.
#[derive(Clone, Debug)]
pub struct CaseSurrogate {
    components: Components,
    pub surrogate: Surrogate,
    /// Errors of the values over their accuracies when each run is left out, a row a run.
    errors: DMatrix<f64>,
}

impl CaseSurrogate {
    fn fit(problem: &Problem, case: usize, runs: &[&Run], region: &Bounds, seed: u64) -> Result<Self, Unfit> {
        let accuracies = problem.cases[case].measured.iter().map(|measured| measured.accuracy);
        let accuracies = DVector::from_iterator(problem.quantities.len(), accuracies);
        let over_accuracy = |run: &&&Run| {
            let values = DVector::from_column_slice(&run.predicted.as_ref().ok()?[case]);
            Some(values.component_div(&accuracies))
        };
        let ended: Vec<DVector<f64>> = runs.iter().filter_map(|run| over_accuracy(&run)).collect();
        let rows = DMatrix::from_fn(ended.len(), accuracies.len(), |i, q| ended[i][q]);
        let components = Components::new(&rows);
        let known = |run: &&Run| Known {
            point: of_case(problem, case, &run.places),
            values: over_accuracy(&run).map(|values| components.scores(&values).as_slice().to_vec()),
        };
        let known: Vec<Known> = runs.iter().map(known).collect();
        // Two points that have mean and deviation of an even distribution in the box.
        let box_sample = [-1.0, 1.0].map(|side| {
            let place = |[low, high]: &[f64; 2]| 0.5 * (low + high) + side * (high - low) / 12.0_f64.sqrt();
            of_case(problem, case, &region.iter().map(place).collect::<Vec<_>>())
        });
        let surrogate = Surrogate::fit(&known, &box_sample, None, seed)?;
        let count = components.vectors.ncols();
        let missed = |i: usize, k: usize| components.scores(&ended[i])[k] - surrogate.left_out(k)[i][0];
        let errors = DMatrix::from_fn(ended.len(), count, missed) * components.vectors.transpose();
        Ok(Self { components, surrogate, errors })
    }

    /// Means of the values over their accuracies.
    fn means(&self, points: &[Vec<f64>]) -> Vec<Option<DVector<f64>>> {
        let Components { centre, vectors, .. } = &self.components;
        let means = self.surrogate.means(points).into_iter();
        means.map(|scores| Some(centre + vectors * DVector::from_vec(scores?))).collect()
    }

    /// Variances of the values over the squares of their accuracies, a row a point.
    fn variances(&self, points: &[Vec<f64>]) -> DMatrix<f64> {
        let Components { vectors, rest, .. } = &self.components;
        let mut scores = DMatrix::zeros(points.len(), vectors.ncols());
        for k in 0..vectors.ncols() {
            for (i, [_, deviation]) in self.surrogate.predict(k, points).into_iter().enumerate() {
                scores[(i, k)] = deviation * deviation;
            }
        }
        let mut variances = scores * vectors.component_mul(vectors).transpose();
        let rest = rest.component_mul(rest).transpose();
        variances.row_iter_mut().for_each(|mut row| row += &rest);
        variances
    }
}

/// Surrogates of all cases from the runs within a box.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The box.
    pub region: Bounds,
    pub cases: Vec<CaseSurrogate>,
    /// The largest eigenvalue of the errors' correlations: with this factor independent errors are nowhere smaller than those
    /// of the surrogates, which go together.
    pub error_correlation: f64,
}

impl Layer {
    fn fit(problem: &Problem, runs: &[Run], region: Bounds, seed: u64) -> Result<Self, Unfit> {
        let runs: Vec<&Run> = runs.iter().filter(|run| within(&run.places, &region)).collect();
        let case = |case: usize| CaseSurrogate::fit(problem, case, &runs, &region, seed);
        let cases: Vec<CaseSurrogate> = (0..problem.cases.len()).map(case).collect::<Result<_, _>>()?;
        Ok(Self { error_correlation: error_correlation(&cases), region, cases })
    }

    /// Whether places lie in the box.
    pub fn holds(&self, places: &[f64]) -> bool {
        within(places, &self.region)
    }
}

/// The largest eigenvalue of the correlations of the errors.
fn error_correlation(cases: &[CaseSurrogate]) -> f64 {
    let columns = cases.iter().flat_map(|case| case.errors.column_iter());
    let columns: Vec<DVector<f64>> =
        columns.filter(|column| column.norm() > 0.0).map(|column| column.normalize()).collect();
    if columns.is_empty() {
        return 1.0;
    }
    let matrix = DMatrix::from_columns(&columns);
    // Both products have the same eigenvalues but for zeros.
    let product = if matrix.nrows() < matrix.ncols() { &matrix * matrix.transpose() } else { matrix.tr_mul(&matrix) };
    product.symmetric_eigenvalues().max().max(1.0)
}

/// The surrogates of all measured values.
#[derive(Clone, Debug)]
pub struct Surrogates {
    problem: Problem,
    /// The first one is of the whole space, each next one nearer to the posterior.
    layers: Vec<Layer>,
    /// Why the last run failed that did.
    failure: String,
}

impl Surrogates {
    pub(super) fn new(problem: &Problem) -> Self {
        Self { problem: problem.clone(), layers: Vec::new(), failure: String::new() }
    }

    /// Fits the runs within a box, which lies in those of the layers before it; where they are too few, all of the last box.
    pub(super) fn refine(&mut self, runs: &[Run], region: Bounds, seed: u64) -> Result<(), Unfit> {
        if let Some(reason) = runs.iter().rev().find_map(|run| run.predicted.as_ref().err()) {
            self.failure.clone_from(reason);
        }
        match (Layer::fit(&self.problem, runs, region, seed), self.layers.last()) {
            (Ok(layer), _) => self.layers.push(layer),
            (Err(Unfit::TooFew { .. }), Some(last)) => {
                let layer = Layer::fit(&self.problem, runs, last.region.clone(), seed)?;
                *self.layers.last_mut().expect("there is one") = layer;
            }
            (Err(unfit), _) => return Err(unfit),
        }
        Ok(())
    }

    /// Fits all layers to further runs.
    pub(super) fn refit(&mut self, runs: &[Run], seed: u64) {
        for layer in &mut self.layers {
            if let Ok(fitted) = Layer::fit(&self.problem, runs, layer.region.clone(), seed) {
                *layer = fitted;
            }
        }
    }

    /// The layer that is nearest to the posterior.
    pub(super) fn last(&self) -> &Layer {
        self.layers.last().expect("surrogates are asked after the first fit")
    }

    /// Each case's part of places.
    pub(super) fn points(&self, case: usize, places: &[Vec<f64>]) -> Vec<Vec<f64>> {
        places.iter().map(|places| of_case(&self.problem, case, places)).collect()
    }

    /// Variances of a case's values over the squares of their accuracies, a row a place; those of the last layer.
    pub(super) fn variances(&self, case: usize, places: &[Vec<f64>]) -> DMatrix<f64> {
        self.last().cases[case].variances(&self.points(case, places))
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
}

impl Simulate for Surrogates {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let mut predictions: Vec<Prediction> = vec![Err(self.failure.clone()); queries.len()];
        let places: Vec<Vec<f64>> = queries.iter().map(|query| self.places(query)).collect();
        let layer = |number: usize| {
            let case = queries[number].case;
            let inside = |layer: &Layer| within(&places[number], &of_case(&self.problem, case, &layer.region));
            self.layers.iter().rposition(inside).unwrap_or(0)
        };
        let of: Vec<(usize, usize)> = (0..queries.len()).map(|number| (queries[number].case, layer(number))).collect();
        let mut kinds = of.clone();
        kinds.sort_unstable();
        kinds.dedup();
        for (case, layer) in kinds {
            let numbers: Vec<usize> = (0..queries.len()).filter(|number| of[*number] == (case, layer)).collect();
            let points: Vec<Vec<f64>> = numbers.iter().map(|number| places[*number].clone()).collect();
            let measured = &self.problem.cases[case].measured;
            for (number, mean) in numbers.into_iter().zip(self.layers[layer].cases[case].means(&points)) {
                let Some(mean) = mean else { continue };
                predictions[number] = Ok(mean.iter().zip(measured).map(|(mean, m)| mean * m.accuracy).collect());
            }
        }
        Ok(predictions)
    }
}
