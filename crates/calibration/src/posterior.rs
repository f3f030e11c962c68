//! How well the measurement determines the parameters.
//!
//! Around the most probable values the posterior is nearly Gaussian, with the inverse of the
//! curvature as its covariance (Tarantola 2005, Inverse Problem Theory, section 3.2). Latent
//! parameters are integrated out. What the data add is seen where posterior and prior are compared
//! direction by direction: the eigenvectors of the posterior covariance in units of the prior's
//! (Spantini et al. 2015, SIAM J. Sci. Comput. 37, A2451-A2487, section 2).

use nalgebra::{Cholesky, DMatrix, DVector};

use sampling::{
    distribution::Distribution,
    statistics::moments::{mean, variance},
};

use super::{
    local::Minimum,
    objective::{Differences, Objective},
    problem::NoPrediction,
};

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
    pub precision: DMatrix<f64>,
    /// The misfits' derivatives over the places, case by case, and how they lie along the shared errors.
    pub slopes: [DMatrix<f64>; 2],
    /// The logarithm of the posterior's volume (the root of the covariance's determinant) but for a constant.
    pub log_volume: f64,
    /// Precision of the free parameters' places before the measurement.
    pub prior: Vec<f64>,
    /// Directions in the space of the free parameters, the least determined first.
    pub directions: Vec<Direction>,
    /// Precision of each unknown's place that stands for its bounds in the covariance.
    bounds: Vec<f64>,
    /// The minimum.
    places: Vec<f64>,
    /// Where the unconstrained normal approximation has its mean: elsewhere than the minimum where that is at a bound.
    centre: Vec<f64>,
    /// Each channel's shared error: the most probable one and its standard deviation.
    pub shared: Vec<[f64; 2]>,
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
    pub fn at(objective: &Objective, minimum: &Minimum) -> Result<Self, NoPrediction> {
        let linear = objective.linear(&minimum.places, &minimum.misfit, Differences::Central)?;
        let problem = objective.problem;
        let n = problem.free.len();
        let mut precision = linear.curvature.clone();
        let mut prior = vec![UNIFORM; n];
        let mut bounds = vec![UNIFORM; problem.unknowns()];
        for (index, free) in problem.free.iter().enumerate() {
            if let Some((_, deviation)) = free.prior_place() {
                // The curvature has it already; where it is wider than the bounds, they count.
                prior[index] = deviation.powi(-2).max(UNIFORM);
                bounds[index] = prior[index] - deviation.powi(-2);
            }
        }
        for (index, bounds) in bounds.iter().enumerate() {
            precision[(index, index)] += bounds;
        }
        let rough = "the curvature at the minimum is not positive: the simulations are too rough";
        let factor = Cholesky::new(precision.clone()).ok_or_else(|| NoPrediction::Here(rough.to_owned()))?;
        let covariance = factor.inverse();
        let directions = directions(&covariance, &prior);
        let away = &covariance * &linear.gradient;
        let centre = minimum.places.iter().zip(&away);
        Ok(Self {
            centre: centre.map(|(place, away)| place - away).collect(),
            places: minimum.places.clone(),
            shared: shared(objective, minimum, &linear.shared, &covariance),
            slopes: [linear.slopes, linear.shared],
            bounds,
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

    /// The interval of an unknown's place that holds it with 95 % probability, between the bounds: of the normal
    /// approximation cut there and at the bounds at which other unknowns are; the bounds of all others count as their
    /// variance. Where most of it lies at a bound, it begins there (see [`interval`]). It always holds the minimum's place.
    pub fn interval(&self, unknown: usize) -> [f64; 2] {
        let mut chosen = self.at_bounds();
        chosen.retain(|&other| other != unknown);
        chosen.push(unknown);
        let last = chosen.len() - 1;
        let mut covariance = self.covariance.select_rows(&chosen).select_columns(&chosen);
        let mut means = DVector::from_iterator(chosen.len(), chosen.iter().map(|&k| self.centre[k]));
        for (k, &other) in chosen[..last].iter().enumerate() {
            // What follows is linear in this one, of which the bound cuts most away.
            let [mean, variance] = moments(self.cut(other, means[k], covariance[(k, k)]));
            let slopes = covariance.column(k) / covariance[(k, k)];
            let [less, change] = [variance - covariance[(k, k)], mean - means[k]];
            covariance += less * &slopes * slopes.transpose();
            means += change * slopes;
        }
        let [low, high] = interval([0.0, 1.0], self.cut(unknown, means[last], covariance[(last, last)]));
        let place = self.places[unknown];
        [low.min(place), high.max(place)]
    }

    /// The unknowns that only a bound keeps where they are.
    fn at_bounds(&self) -> Vec<usize> {
        let all = 0..self.places.len();
        all.filter(|k| match self.places[*k] {
            0.0 => self.centre[*k] < 0.0,
            1.0 => self.centre[*k] > 1.0,
            _ => false,
        })
        .collect()
    }

    /// The quantiles of an unknown's place between its bounds, given mean and variance with its bounds as a variance.
    fn cut(&self, unknown: usize, mean: f64, variance: f64) -> impl Fn(f64) -> f64 + use<> {
        // What the data and a normal prior say of it. Next to nothing is as good as nothing.
        const NEXT_TO_NOTHING: f64 = 1e-3;
        let precision = (variance.recip() - self.bounds[unknown]).max(NEXT_TO_NOTHING);
        let deviation = precision.powf(-0.5);
        // Farther from the bounds, in standard deviations, the normal distribution's tail is 0 in floating-point numbers.
        const FAR: f64 = 30.0;
        // The variance that stands for the bounds is about the minimum's place.
        let place = self.places[unknown];
        let mean = place + (mean - place) / (precision * variance);
        let mean = mean.clamp(-FAR * deviation, 1.0 + FAR * deviation);
        // Quantiles keep their digits in the lower tail alone.
        let mirrored = mean < 0.5;
        let distribution = Distribution::TruncatedNormal {
            mean: if mirrored { 1.0 - mean } else { mean },
            deviation,
            min: Some(0.0),
            max: Some(1.0),
        };
        move |part| if mirrored { 1.0 - distribution.quantile(1.0 - part) } else { distribution.quantile(part) }
    }

    /// By how much the sum of squares rises between two sets of places, by the normal approximation.
    pub fn rise(&self, from: &[f64], to: &[f64]) -> f64 {
        let (step, away) = (difference(to, from), difference(from, &self.centre));
        let bounds = step.iter().zip(&self.bounds).map(|(step, bounds)| bounds * step * step);
        (&self.precision * &step).dot(&(&step + 2.0 * away)) - bounds.sum::<f64>()
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
        self.directions.iter().flat_map(|direction| [-1.0, 1.0].map(|side| end(direction, side))).collect()
    }

    /// The squared distance of two sets of places, in standard deviations of the posterior.
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let way = difference(a, b);
        (&self.precision * &way).dot(&way)
    }

    /// The correlation of two unknowns.
    pub fn correlation(&self, a: usize, b: usize) -> f64 {
        self.covariance[(a, b)] / (self.deviation(a) * self.deviation(b))
    }
}

/// One set of places less another.
fn difference(a: &[f64], b: &[f64]) -> DVector<f64> {
    DVector::from_iterator(a.len(), a.iter().zip(b).map(|(a, b)| a - b))
}

/// Mean and variance, given the quantiles.
fn moments(quantile: impl Fn(f64) -> f64) -> [f64; 2] {
    const PARTS: usize = 256;
    let values: Vec<f64> = (0..PARTS).map(|k| quantile((k as f64 + 0.5) / PARTS as f64)).collect();
    [mean(&values), variance(&values, 0)]
}

/// The interval that holds a number between bounds with 95 % probability, given its quantiles: from the 2.5 % quantile to the
/// 97.5 % quantile, or from a bound on where that is clearly shorter and the number may well be at the bound: an interval
/// with two ends inside would never hold a truth there.
pub fn interval(bounds: [f64; 2], quantile: impl Fn(f64) -> f64) -> [f64; 2] {
    /// So much shorter is clearly shorter; of what is known by its bounds alone, none is.
    const SHORTER: f64 = 0.97;
    /// Near a bound the probability grows like the distance from it where there is a density, and like a power of the
    /// distance above this one where it vanishes.
    const VANISHES: f64 = 1.5;
    let tails = [[0.025, 0.1], [0.975, 0.9]].map(|parts| parts.map(&quantile));
    let central = [tails[0][0], tails[1][0]];
    let from = |side: usize| {
        let [near, far] = tails[side].map(|end| (end - bounds[side]).abs());
        let power = 4.0_f64.ln() / (far / near).ln();
        let ends = match side {
            0 => [bounds[0], quantile(0.95)],
            _ => [quantile(0.05), bounds[1]],
        };
        (power < VANISHES).then_some(ends)
    };
    let width = |ends: &[f64; 2]| ends[1] - ends[0];
    [0, 1]
        .into_iter()
        .filter_map(from)
        .min_by(|a, b| width(a).total_cmp(&width(b)))
        .filter(|ends| width(ends) < SHORTER * width(&central))
        .unwrap_or(central)
}

/// Mean and standard deviation of each channel's shared error, where the unknowns are as uncertain as their covariance says.
fn shared(objective: &Objective, minimum: &Minimum, along: &DMatrix<f64>, covariance: &DMatrix<f64>) -> Vec<[f64; 2]> {
    let (problem, errors) = (objective.problem, &objective.errors);
    let known = errors.channels(problem, minimum.misfit.sources(problem));
    let marginal = problem.channels.iter().zip(known).map(|(channel, [mean, deviation])| {
        // The sources' values for given unknowns are -M^-1 V'r, with the derivative -M^-1 V'J.
        let slope = along.tr_mul(&errors.solved(&channel.weights(errors.sources())));
        let more = (covariance * &slope).dot(&slope);
        [mean, deviation.hypot(more.max(0.0).sqrt())]
    });
    marginal.collect()
}

fn directions(covariance: &DMatrix<f64>, prior: &[f64]) -> Vec<Direction> {
    let n = prior.len();
    let eigen = DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] * (prior[i] * prior[j]).sqrt()).symmetric_eigen();
    let mut directions: Vec<Direction> = (0..n)
        .map(|index| {
            let vector = eigen.eigenvectors.column(index);
            let sign = vector[vector.icamax()].signum();
            Direction {
                left: eigen.eigenvalues[index].max(0.0).sqrt(),
                weights: vector.iter().map(|weight| weight * sign).collect(),
            }
        })
        .collect();
    directions.sort_by(|a, b| b.left.total_cmp(&a.left));
    directions
}
