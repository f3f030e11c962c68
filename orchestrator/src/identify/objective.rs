//! How improbable a set of unknowns is: weighted squares of the misfit and of the distance from
//! what was known before.
//!
//! With Gaussian errors and priors, half this sum of squares is the negative logarithm of the
//! posterior density but for a constant, so its least value is the most probable one (Tarantola
//! 2005, Inverse Problem Theory, section 3.2). The unknowns are places between their bounds, from
//! 0 to 1, so that all are of one size.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::problem::{Problem, Simulate};

/// How derivatives are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differences {
    /// One simulation an unknown.
    Forward,
    /// Two simulations an unknown, with an error of second order.
    Central,
}

/// The sum of squares.
pub struct Objective<'a> {
    /// What is to be found.
    pub problem: &'a Problem,
    simulate: &'a dyn Simulate,
    /// How far apart simulations stand for a derivative, as a part of the distance between the bounds.
    difference: f64,
}

/// The misfit at a set of unknowns.
#[derive(Clone, Debug)]
pub struct Misfit {
    /// Predictions, case by case.
    pub predicted: Vec<Vec<f64>>,
    /// Misfit over accuracy, case by case, and then the distance from each prior's centre.
    pub residuals: DVector<f64>,
}

impl Misfit {
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
        Self {
            problem,
            simulate,
            difference,
        }
    }

    fn case(&self, case: usize, places: &[f64]) -> Result<Vec<f64>, String> {
        let free = self.problem.free_values(places);
        let latents = self.problem.latent_values(case, places);
        let predicted = self.simulate.simulate(case, &free, &latents)?;
        match predicted.iter().find(|value| !value.is_finite()) {
            Some(value) => Err(format!("a prediction is {value}")),
            None => Ok(predicted),
        }
    }

    /// The misfit at a set of unknowns.
    ///
    /// # Errors
    /// When a simulation fails.
    pub fn misfit(&self, places: &[f64]) -> Result<Misfit, String> {
        let cases = 0..self.problem.cases.len();
        let predicted: Vec<Vec<f64>> = cases
            .into_par_iter()
            .map(|case| self.case(case, places))
            .collect::<Result<_, _>>()?;
        let pairs = self.problem.cases.iter().zip(&predicted);
        let data = pairs.flat_map(|(case, predicted)| {
            let pairs = case.measured.iter().zip(predicted);
            pairs.map(|(measured, predicted)| (predicted - measured.value) / measured.accuracy)
        });
        let residuals: Vec<f64> = data.chain(self.prior_residuals(places)).collect();
        Ok(Misfit {
            predicted,
            residuals: DVector::from_vec(residuals),
        })
    }

    fn prior_residuals(&self, places: &[f64]) -> impl Iterator<Item = f64> {
        let pairs = self.problem.free.iter().zip(places);
        pairs.filter_map(|(free, place)| {
            let (centre, deviation) = free.prior_place()?;
            Some((place - centre) / deviation)
        })
    }

    /// The linearised problem at a set of unknowns. A latent parameter touches its own case only.
    ///
    /// # Errors
    /// When a simulation fails on both sides of a place.
    pub fn linear(
        &self,
        places: &[f64],
        misfit: &Misfit,
        differences: Differences,
    ) -> Result<Linear, String> {
        let n = self.problem.unknowns();
        let jobs = self.displacements(places);
        let columns: Vec<DVector<f64>> = jobs
            .par_iter()
            .map(|job| self.derivative(job, places, &misfit.predicted[job.case], differences))
            .collect::<Result<_, _>>()?;
        let mut linear = Linear {
            curvature: DMatrix::zeros(n, n),
            gradient: DVector::zeros(n),
        };
        let quantities = self.problem.quantities.len();
        let per_case = self.problem.free.len() + self.problem.latents.len();
        for (case, (jobs, columns)) in jobs
            .chunks(per_case)
            .zip(columns.chunks(per_case))
            .enumerate()
        {
            let residuals = misfit.residuals.rows(case * quantities, quantities);
            for (a, first) in jobs.iter().zip(columns) {
                linear.gradient[a.unknown] += first.dot(&residuals);
                for (b, second) in jobs.iter().zip(columns) {
                    linear.curvature[(a.unknown, b.unknown)] += first.dot(second);
                }
            }
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
        let displaced = |case| {
            let unknowns = (0..self.problem.free.len()).chain(self.problem.latents_of(case));
            unknowns.map(move |unknown| Displaced {
                case,
                unknown,
                place: places[unknown]
                    + if places[unknown] > 0.5 {
                        -self.difference
                    } else {
                        self.difference
                    },
            })
        };
        (0..self.problem.cases.len()).flat_map(displaced).collect()
    }

    /// Derivatives of a case's weighted misfits over the place of one unknown.
    fn derivative(
        &self,
        job: &Displaced,
        places: &[f64],
        here: &[f64],
        differences: Differences,
    ) -> Result<DVector<f64>, String> {
        let at = |place: f64| {
            let mut places = places.to_vec();
            places[job.unknown] = place;
            self.case(job.case, &places)
        };
        let there = at(job.place);
        let mirrored = 2.0 * places[job.unknown] - job.place;
        let inside = (0.0..=1.0).contains(&mirrored);
        let opposite = (inside && (differences == Differences::Central || there.is_err()))
            .then(|| at(mirrored));
        let distance = job.place - places[job.unknown];
        let (ahead, behind, distance) = match (there, opposite) {
            (Ok(ahead), Some(Ok(behind))) => (ahead, behind, 2.0 * distance),
            (Ok(ahead), _) => (ahead, here.to_vec(), distance),
            (Err(_), Some(Ok(behind))) => (here.to_vec(), behind, distance),
            (Err(error), _) => return Err(error),
        };
        let measured = &self.problem.cases[job.case].measured;
        let slopes = ahead.iter().zip(&behind).zip(measured);
        let slopes = slopes.map(|((a, b), measured)| (a - b) / distance / measured.accuracy);
        Ok(DVector::from_iterator(measured.len(), slopes))
    }
}
