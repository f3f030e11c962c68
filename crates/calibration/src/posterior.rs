//! How well the measurement determines the parameters.
//!
//! Around the most probable values the posterior is nearly Gaussian, with the inverse of the
//! curvature as its covariance (Tarantola 2005, Inverse Problem Theory, section 3.2). Latent
//! parameters are integrated out. What the data add is seen where posterior and prior are compared
//! direction by direction: the eigenvectors of the posterior covariance in units of the prior's
//! (Spantini et al. 2015, SIAM J. Sci. Comput. 37, A2451-A2487, section 2).

use nalgebra::{Cholesky, DMatrix, DVector};

use super::local::Minimum;
use super::objective::{Differences, Objective};
use super::problem::NoPrediction;

/// The precision of a place of which only the bounds are known: the inverse variance of the uniform
/// distribution from 0 to 1.
const UNIFORM: f64 = 12.0;

/// A direction counts as undetermined where the data leave more than this part of the prior's
/// standard deviation.
pub const UNDETERMINED: f64 = 0.5;

/// The posterior around the most probable values, in places between the bounds.
#[derive(Clone, Debug)]
pub struct Posterior {
    /// Covariance of all unknowns, the free parameters first.
    pub covariance: DMatrix<f64>,
    /// Its inverse.
    precision: DMatrix<f64>,
    /// The logarithm of the posterior's volume (the root of the covariance's determinant) but for a constant.
    pub log_volume: f64,
    /// Precision of the free parameters' places before the measurement.
    pub prior: Vec<f64>,
    /// Directions in the space of the free parameters, the least determined first.
    pub directions: Vec<Direction>,
}

/// A combination of free parameters that the data determine apart from all others.
#[derive(Clone, Debug)]
pub struct Direction {
    /// Posterior over prior standard deviation: 1 where the data say nothing.
    pub left: f64,
    /// The free parameters' weights, in units of their prior standard deviations; of length 1.
    pub weights: Vec<f64>,
}

impl Posterior {
    /// The posterior at a minimum. Of unknowns on both sides of which runs fail it knows the prior only.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn at(objective: &Objective<'_>, minimum: &Minimum) -> Result<Self, NoPrediction> {
        let linear = objective.linear(&minimum.places, &minimum.misfit, Differences::Central)?;
        let problem = objective.problem;
        let n = problem.free.len();
        let mut precision = linear.curvature;
        let mut prior = vec![UNIFORM; n];
        for (index, free) in problem.free.iter().enumerate() {
            if let Some((_, deviation)) = free.prior_place() {
                // The curvature has it already; where it is wider than the bounds, they count.
                prior[index] = deviation.powi(-2).max(UNIFORM);
                precision[(index, index)] += prior[index] - deviation.powi(-2);
            } else {
                precision[(index, index)] += UNIFORM;
            }
        }
        for index in n..problem.unknowns() {
            precision[(index, index)] += UNIFORM;
        }
        let rough = "the curvature at the minimum is not positive: the simulations are too rough";
        let factor =
            Cholesky::new(precision.clone()).ok_or_else(|| NoPrediction::Here(rough.to_owned()))?;
        let covariance = factor.inverse();
        let directions = directions(&covariance, &prior);
        Ok(Self {
            log_volume: -factor.l_dirty().diagonal().map(f64::ln).sum(),
            precision,
            covariance,
            prior,
            directions,
        })
    }

    /// The standard deviation of an unknown's place.
    pub fn deviation(&self, unknown: usize) -> f64 {
        self.covariance[(unknown, unknown)].sqrt()
    }

    /// The ends of the axes of the region that holds each combination of free parameters with 95 % probability, about these
    /// places and between the bounds. All other unknowns stay.
    pub fn ends(&self, places: &[f64]) -> Vec<Vec<f64>> {
        const NINETY_FIVE: f64 = 1.96;
        let end = |direction: &Direction, side: f64| {
            let mut end = places.to_vec();
            let steps = direction.weights.iter().zip(&self.prior);
            for (place, (weight, prior)) in end.iter_mut().zip(steps) {
                let step = side * NINETY_FIVE * direction.left * weight / prior.sqrt();
                *place = (*place + step).clamp(0.0, 1.0);
            }
            end
        };
        let directions = self.directions.iter();
        directions
            .flat_map(|direction| [-1.0, 1.0].map(|side| end(direction, side)))
            .collect()
    }

    /// The squared distance of two sets of places, in standard deviations of the posterior.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let way = DVector::from_iterator(a.len(), a.iter().zip(b).map(|(a, b)| a - b));
        (&self.precision * &way).dot(&way)
    }

    /// The correlation of two unknowns.
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        self.covariance[(a, b)] / (self.deviation(a) * self.deviation(b))
    }
}

fn directions(covariance: &DMatrix<f64>, prior: &[f64]) -> Vec<Direction> {
    let n = prior.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        covariance[(i, j)] * (prior[i] * prior[j]).sqrt()
    });
    let eigen = scaled.symmetric_eigen();
    let direction = |index: usize| {
        let vector = eigen.eigenvectors.column(index);
        let sign = vector[vector.icamax()].signum();
        Direction {
            left: eigen.eigenvalues[index].max(0.0).sqrt(),
            weights: vector.iter().map(|weight| weight * sign).collect(),
        }
    };
    let mut directions: Vec<Direction> = (0..n).map(direction).collect();
    directions.sort_by(|a, b| b.left.total_cmp(&a.left));
    directions
}
