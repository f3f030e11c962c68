//! Errors as they are stated, for the posterior's sample: the search takes normal ones where they are not.
//!
//! A value with an error of its own, which it shares with no other, has that error's density in place of the normal one.
//!
//! A rectangular source is integrated out between its limits. Given the unknowns, normal errors leave it a normal distribution
//! with mean `m` and variance `v`, which has the normal prior in it; so the likelihood grows by the mean over it of the
//! rectangular prior over the normal one. That is the integral of a normal density with mean `m / (1 - v)` and variance
//! `v / (1 - v)` between the limits. Sources that the data tell only together with another rectangular one stay normal.

use std::f64::consts::TAU;

use nalgebra::DVector;

use conformity::normal::ln_between;

use super::{
    errors::Errors,
    problem::{NotNormal, Problem},
};

/// The limits of a rectangular source, whose standard deviation is 1.
const LIMIT: f64 = 1.732_050_807_568_877_2;

/// What is beyond normal errors.
pub struct Stated {
    values: Vec<NotNormal>,
    rectangles: Vec<Rectangle>,
}

/// A rectangular source.
struct Rectangle {
    source: usize,
    /// Its covariances with all sources, given the unknowns, if all were normal.
    covariances: DVector<f64>,
}

impl Stated {
    /// That of a problem: of the values without a shared part, and of the rectangular sources.
    pub fn new(problem: &Problem, errors: &Errors) -> Self {
        /// The ends of a rectangle are rounded by this part of its half-width: a sample cannot find its way to where the
        /// density is 0 almost everywhere.
        const ROUNDED: f64 = 0.02;
        let alone = |value: &&NotNormal| errors.effects(value.case, value.quantity).iter().all(|effect| *effect == 0.0);
        let means = problem.not_normal.iter().filter(|value| value.law.student > 0.0).count();
        let values = problem.not_normal.iter().filter(alone).map(|value| {
            let mut law = value.law.among(means);
            law.normal = law.normal.hypot(ROUNDED * law.half_width);
            NotNormal { law, ..*value }
        });
        Self { values: values.collect(), rectangles: rectangles(problem, errors) }
    }

    /// What the logarithm of the likelihood has beyond that of normal errors, given the sources' most probable values by these.
    pub fn ln_beyond(&self, problem: &Problem, errors: &Errors, predicted: &[Vec<f64>], sources: &[f64]) -> f64 {
        self.values
            .iter()
            .map(|value| {
                let (case, quantity) = (value.case, value.quantity);
                let error = problem.cases[case].measured[quantity].value - predicted[case][quantity];
                let accuracy = errors.accuracy(case, quantity);
                let normal = -0.5 * (error / accuracy).powi(2) - accuracy.ln();
                value.law.ln_density(error) - normal + 0.5 * TAU.ln()
            })
            .chain(self.rectangles.iter().map(|rectangle| rectangle.ln_ratio(sources)))
            .sum()
    }

    /// Mean and standard deviation of each channel's error, given those by normal errors.
    pub fn channels(&self, problem: &Problem, mut known: Vec<[f64; 2]>, sources: &[f64]) -> Vec<[f64; 2]> {
        for rectangle in &self.rectangles {
            let normal = [sources[rectangle.source], rectangle.variance()];
            let cut = rectangle.moments(sources);
            for (channel, [mean, deviation]) in problem.channels.iter().zip(&mut known) {
                let weights = channel.weights(sources.len());
                let slope = weights.dot(&rectangle.covariances) / rectangle.variance();
                *mean += slope * (cut[0] - normal[0]);
                let variance = deviation.powi(2) + slope.powi(2) * (cut[1] - normal[1]);
                *deviation = variance.max(0.0).sqrt();
            }
        }
        known
    }
}

/// The rectangular sources that the data tell apart.
fn rectangles(problem: &Problem, errors: &Errors) -> Vec<Rectangle> {
    /// A smaller covariance is rounding.
    const NOTHING: f64 = 1e-9;
    let numbers: Vec<usize> =
        problem.sources.iter().enumerate().filter(|(_, source)| source.rectangular).map(|(number, _)| number).collect();
    numbers
        .iter()
        .map(|&source| {
            let mut unit = DVector::zeros(errors.sources());
            unit[source] = 1.0;
            Rectangle { source, covariances: errors.solved(&unit) }
        })
        .filter(|rectangle| {
            let mut others = numbers.iter().filter(|&&other| other != rectangle.source);
            others.all(|&other| rectangle.covariances[other].abs() <= NOTHING)
        })
        .collect()
}

impl Rectangle {
    fn variance(&self) -> f64 {
        self.covariances[self.source]
    }

    /// The limits as a standard normal number has them, where the source is one, with mean and standard deviation, that is
    /// cut there; none where the data say nothing of it.
    fn cut(&self, sources: &[f64]) -> Option<([f64; 2], [f64; 2])> {
        /// A smaller part of the variance that the data take is rounding.
        const NOTHING: f64 = 1e-12;
        let taken = 1.0 - self.variance();
        let mean = sources[self.source] / taken;
        let deviation = (self.variance() / taken).sqrt();
        let ends = [-LIMIT, LIMIT].map(|limit| (limit - mean) / deviation);
        (taken > NOTHING).then_some((ends, [mean, deviation]))
    }

    /// The logarithm of the mean of the rectangular prior over the normal one.
    fn ln_ratio(&self, sources: &[f64]) -> f64 {
        let Some(([low, high], [mean, _])) = self.cut(sources) else { return 0.0 };
        let taken = 1.0 - self.variance();
        let priors = 0.5 * TAU.ln() - (2.0 * LIMIT).ln();
        priors - 0.5 * taken.ln() + 0.5 * mean * mean * taken + ln_between(low, high)
    }

    /// Mean and variance between the limits.
    fn moments(&self, sources: &[f64]) -> [f64; 2] {
        let Some(([low, high], [mean, deviation])) = self.cut(sources) else { return [0.0, 1.0] };
        let inside = ln_between(low, high);
        let density = |z: f64| (-0.5 * (z * z + TAU.ln()) - inside).exp();
        let shift = density(low) - density(high);
        let variance = 1.0 + low * density(low) - high * density(high) - shift * shift;
        [(mean + deviation * shift).clamp(-LIMIT, LIMIT), deviation.powi(2) * variance.clamp(0.0, 1.0)]
    }
}
