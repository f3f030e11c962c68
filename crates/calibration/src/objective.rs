//! How improbable a set of unknowns is: weighted squares of the misfit and of the distance from
//! what was known before.
//!
//! With Gaussian errors and priors, half this sum of squares is the negative logarithm of the
//! posterior density but for a constant, so its least value is the most probable one (Tarantola
//! 2005, Inverse Problem Theory, section 3.2). The unknowns are places between their bounds, from
//! 0 to 1, so that all are of one size.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};

use super::{
    errors::Errors,
    failures::Failures,
    problem::{NoPrediction, Prediction, Problem, Query, Simulate},
};

/// How derivatives are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differences {
    /// One simulation per unknown.
    Forward,
    /// Two simulations an unknown, with an error of second order.
    Central,
}

/// The sum of squares.
pub struct Objective<'a> {
    /// The unknown parameters.
    pub problem: &'a Problem,
    /// The errors of its measured values.
    pub(crate) errors: Errors,
    simulate: &'a dyn Simulate,
    /// The step of finite differences, as a part of the distance between the bounds.
    difference: f64,
    failures: RefCell<Failures>,
}

/// The misfit at a set of unknowns.
#[derive(Clone, Debug)]
pub struct Misfit {
    /// Predictions, case by case.
    pub predicted: Vec<Vec<f64>>,
    /// Misfit over accuracy, case by case, without what shared errors explain; then these errors in standard uncertainties;
    /// then the distance from each prior's centre.
    pub residuals: DVector<f64>,
}

impl Misfit {
    /// The shared errors, in standard uncertainties, that explain most of the misfit.
    pub fn sources(&self, problem: &Problem) -> &[f64] {
        &self.residuals.as_slice()[problem.values()..][..problem.sources.len()]
    }

    /// The part of the sum of squares that is the data's, shared errors included.
    pub fn data_cost(&self, problem: &Problem) -> f64 {
        let rows = problem.values() + problem.sources.len();
        self.residuals.rows(0, rows).norm_squared()
    }

    /// The sum of squares.
    pub fn cost(&self) -> f64 {
        self.residuals.norm_squared()
    }
}

/// The linearised problem: `J'J` and `J'r`.
#[derive(Clone, Debug)]
pub struct Linear {
    /// The Gauss-Newton approximation of half the second derivative.
    pub curvature: DMatrix<f64>,
    /// Half the gradient.
    pub gradient: DVector<f64>,
    /// How the misfits' derivatives lie along the shared errors: `V'J`, a row a source, where `V` has the effects of each
    /// source in a column.
    pub shared: DMatrix<f64>,
    /// The misfits' derivatives `J`, case by case.
    pub slopes: DMatrix<f64>,
    /// The unknowns without a derivative, as runs fail on both sides: rows and columns above are those of an output that
    /// does not depend on them.
    pub surrounded: Vec<usize>,
}

impl Linear {
    /// By how much the sum of squares falls with a step.
    pub fn fall(&self, step: &DVector<f64>) -> f64 {
        -(2.0 * self.gradient.dot(step) + (&self.curvature * step).dot(step))
    }

    /// The same with a part of the largest curvature added to that of all unknowns.
    pub fn damped(&self, part: f64) -> Self {
        let mut damped = self.clone();
        let largest = self.curvature.diagonal().amax().max(f64::MIN_POSITIVE);
        for index in 0..self.gradient.len() {
            damped.curvature[(index, index)] += part * largest;
        }
        damped
    }
}

/// One simulation for a derivative: the case, the unknown, and its displaced place.
struct Displaced {
    case: usize,
    unknown: usize,
    place: f64,
}

impl<'a> Objective<'a> {
    /// The objective of a problem.
    pub fn new(problem: &'a Problem, simulate: &'a dyn Simulate, difference: f64) -> Self {
        Self { errors: Errors::new(problem), problem, simulate, difference, failures: RefCell::default() }
    }

    /// The places that were asked for so far, and those at which a run failed.
    pub fn failures(&self) -> Failures {
        self.failures.borrow().clone()
    }

    fn query(&self, case: usize, places: &[f64]) -> Query {
        Query { case, free: self.problem.free_values(places), latents: self.problem.latent_values(case, places) }
    }

    /// The predictions; one that is not finite is none.
    fn predict(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        let predictions = self.simulate.simulate(queries)?;
        assert_eq!(predictions.len(), queries.len(), "each query has its prediction");
        Ok(predictions.into_iter().map(finite).collect())
    }

    /// The misfit at a set of unknowns.
    ///
    /// # Errors
    /// When a simulation fails.
    pub fn misfit(&self, places: &[f64]) -> Result<Misfit, NoPrediction> {
        let mut misfits = self.misfits(std::slice::from_ref(&places))?;
        misfits.pop().expect("one set has one misfit").map_err(NoPrediction::Here)
    }

    /// The misfits at several sets of unknowns, or why there is none.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn misfits<P: AsRef<[f64]>>(&self, sets: &[P]) -> Result<Vec<Result<Misfit, String>>, NoPrediction> {
        let cases = self.problem.cases.len();
        let queries = sets.iter().flat_map(|places| {
            let places = places.as_ref();
            (0..cases).map(move |case| self.query(case, places))
        });
        let mut predictions = self.predict(&queries.collect::<Vec<_>>())?.into_iter();
        Ok(sets
            .iter()
            .map(|places| {
                let of_set: Vec<Prediction> = predictions.by_ref().take(cases).collect();
                let predicted: Result<_, String> = of_set.into_iter().collect();
                self.note(places.as_ref(), &predicted);
                Ok(self.of_predicted(places.as_ref(), predicted?))
            })
            .collect())
    }

    fn note<T>(&self, places: &[f64], predicted: &Result<T, String>) {
        let failure = predicted.as_ref().err().map(String::as_str);
        let mut failures = self.failures.borrow_mut();
        failures.note(self.problem, places, failure);
    }

    fn of_predicted(&self, places: &[f64], predicted: Vec<Vec<f64>>) -> Misfit {
        let residuals: Vec<f64> = self
            .errors
            .residuals(self.problem, &predicted)
            .iter()
            .copied()
            .chain(self.prior_residuals(places))
            .collect();
        Misfit { predicted, residuals: DVector::from_vec(residuals) }
    }

    fn prior_residuals(&self, places: &[f64]) -> impl Iterator<Item = f64> {
        self.problem.free.iter().zip(places).filter_map(|(free, place)| {
            let (centre, deviation) = free.prior_place()?;
            Some((place - centre) / deviation)
        })
    }

    /// The linearised problem at a set of unknowns. A latent parameter touches its own case only.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn linear(&self, places: &[f64], misfit: &Misfit, differences: Differences) -> Result<Linear, NoPrediction> {
        let n = self.problem.unknowns();
        let jobs = self.displacements(places);
        let columns = self.derivatives(&jobs, places, misfit, differences)?;
        let mut linear = Linear {
            curvature: DMatrix::zeros(n, n),
            gradient: DVector::zeros(n),
            shared: DMatrix::zeros(self.errors.sources(), n),
            slopes: DMatrix::zeros(self.problem.values(), n),
            surrounded: surrounded(&jobs, &columns),
        };
        let quantities = self.problem.quantities.len();
        let per_case = self.problem.free.len() + self.problem.latents.len();
        let cases = jobs.chunks(per_case).zip(columns.chunks(per_case));
        for (case, (jobs, columns)) in cases.enumerate() {
            let residuals = misfit.residuals.rows(case * quantities, quantities);
            // A place counts only where the runs of all cases end, so one that fails hides the others' slopes, too.
            let known: Vec<(usize, &DVector<f64>)> = jobs
                .iter()
                .zip(columns)
                .filter_map(|(job, column)| Some((job.unknown, column.as_ref()?)))
                .filter(|(unknown, _)| !linear.surrounded.contains(unknown))
                .collect();
            for &(a, first) in &known {
                let place = (case * quantities, a);
                linear.slopes.view_mut(place, (quantities, 1)).copy_from(first);
                linear.gradient[a] += first.dot(&residuals);
                let mut along = linear.shared.column_mut(a);
                along += self.errors.onto(case, first.as_slice());
                for &(b, second) in &known {
                    linear.curvature[(a, b)] += first.dot(second);
                }
            }
        }
        if linear.shared.nrows() > 0 {
            let along = self.errors.halved(linear.shared.clone());
            linear.curvature -= along.tr_mul(&along);
        }
        for (index, free) in self.problem.free.iter().enumerate() {
            if let Some((centre, deviation)) = free.prior_place() {
                let weight = deviation.powi(-2);
                linear.curvature[(index, index)] += weight;
                linear.gradient[index] += weight * (places[index] - centre);
            }
        }
        Ok(linear)
    }

    /// All simulations for derivatives, case by case. Towards the middle, where there is room.
    fn displacements(&self, places: &[f64]) -> Vec<Displaced> {
        let sign = |place: f64| if place > 0.5 { -1.0 } else { 1.0 };
        (0..self.problem.cases.len())
            .flat_map(|case| {
                (0..self.problem.free.len()).chain(self.problem.latents_of(case)).map(move |unknown| Displaced {
                    case,
                    unknown,
                    place: places[unknown] + sign(places[unknown]) * self.difference,
                })
            })
            .collect()
    }

    /// Derivatives of the cases' weighted misfits, each over the place of one unknown; `None` where runs fail on both sides.
    fn derivatives(
        &self,
        jobs: &[Displaced],
        places: &[f64],
        misfit: &Misfit,
        differences: Differences,
    ) -> Result<Vec<Option<DVector<f64>>>, NoPrediction> {
        let moved = |job: &Displaced, place: f64| {
            let mut places = places.to_vec();
            places[job.unknown] = place;
            places
        };
        let at = |job: &Displaced, place: f64| self.query(job.case, &moved(job, place));
        let mirrored = |job: &Displaced| 2.0 * places[job.unknown] - job.place;
        let inside = |job: &&Displaced| (0.0..=1.0).contains(&mirrored(job));
        let there: Vec<Query> = jobs.iter().map(|job| at(job, job.place)).collect();
        let there = self.predict(&there)?;
        for (job, there) in jobs.iter().zip(&there) {
            self.note(&moved(job, job.place), there);
        }
        // Where both sides are wanted from the start, and where the first one failed.
        let wanted = |(job, there): &(&Displaced, &Prediction)| {
            inside(job) && (differences == Differences::Central || there.is_err())
        };
        let opposite: Vec<Query> =
            jobs.iter().zip(&there).filter(wanted).map(|(job, _)| at(job, mirrored(job))).collect();
        let mut opposite = self.predict(&opposite)?.into_iter();
        Ok(jobs
            .iter()
            .zip(&there)
            .map(|(job, there)| {
                let opposite = wanted(&(job, there)).then(|| opposite.next()).flatten();
                let here = &misfit.predicted[job.case];
                let distance = job.place - places[job.unknown];
                self.derivative(job, here, there, opposite.as_ref(), distance)
            })
            .collect())
    }

    /// Derivatives of a case's weighted misfits over the place of one unknown, from the predictions `here`, at
    /// `distance`, and as far on the opposite side.
    fn derivative(
        &self,
        job: &Displaced,
        here: &[f64],
        there: &Prediction,
        opposite: Option<&Prediction>,
        distance: f64,
    ) -> Option<DVector<f64>> {
        let (ahead, behind, distance) = match (there, opposite) {
            (Ok(ahead), Some(Ok(behind))) => (&ahead[..], &behind[..], 2.0 * distance),
            (Ok(ahead), _) => (&ahead[..], here, distance),
            (Err(_), Some(Ok(behind))) => (here, &behind[..], distance),
            (Err(_), _) => return None,
        };
        let slopes = ahead
            .iter()
            .zip(behind)
            .enumerate()
            .map(|(k, (a, b))| (a - b) / distance / self.errors.accuracy(job.case, k));
        Some(DVector::from_iterator(here.len(), slopes))
    }
}

/// The prediction, where its values are finite.
pub(super) fn finite(prediction: Prediction) -> Prediction {
    let predicted = prediction?;
    match predicted.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("a prediction is {value}")),
        None => Ok(predicted),
    }
}

/// The unknowns of which a derivative is missing.
fn surrounded(jobs: &[Displaced], columns: &[Option<DVector<f64>>]) -> Vec<usize> {
    let mut unknowns: Vec<usize> =
        jobs.iter().zip(columns).filter(|(_, column)| column.is_none()).map(|(job, _)| job.unknown).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    unknowns
}
