//! Mixtures of normal distributions, fitted to weighted points by expectation and maximisation (Dempster, Laird and Rubin
//! 1977); in many dimensions after Papaioannou, Geyer and Straub 2019, "Improved cross entropy-based importance sampling
//! with a flexible mixture model".
//!
//! Parameters that do not matter keep their standard normal distribution. So a variance is taken from the points only
//! where it differs from 1 by more than chance explains (Marchenko and Pastur 1967); all others are 1.

use std::f64::consts::TAU;

use super::scatter::{Scatter, effective};
use crate::distribution::ln_sum;
use crate::random::Random;

/// A normal distribution with variance 1 but along some axes.
#[derive(Clone, Debug)]
struct Component {
    mean: Vec<f64>,
    axes: Vec<Vec<f64>>,
    variances: Vec<f64>,
}

impl Component {
    fn fit(points: &[Vec<f64>], weights: &[f64]) -> Self {
        // Chance goes a little further than the limit for many points.
        const SLACK: f64 = 1.1;
        let scatter = Scatter::of(points, weights);
        let ratio = (scatter.mean.len() as f64 / scatter.effective.max(1.0)).sqrt();
        let low = (1.0 - ratio).max(0.0).powi(2) / SLACK;
        let high = (1.0 + ratio).powi(2) * SLACK;
        let pairs = scatter.axes.into_iter().zip(scatter.variances);
        let (axes, variances) = pairs.filter(|(_, v)| !(low..=high).contains(v)).unzip();
        Self {
            mean: scatter.mean,
            axes,
            variances,
        }
    }

    fn ln_density(&self, point: &[f64]) -> f64 {
        let offset: Vec<f64> = point.iter().zip(&self.mean).map(|(x, m)| x - m).collect();
        let mut sum: f64 = offset.iter().map(|o| o * o).sum();
        let mut ln_volume = 0.0;
        for (axis, variance) in self.axes.iter().zip(&self.variances) {
            let place: f64 = axis.iter().zip(&offset).map(|(a, o)| a * o).sum();
            sum += place * place * (1.0 / variance - 1.0);
            ln_volume += variance.ln();
        }
        -0.5 * (sum + ln_volume + point.len() as f64 * TAU.ln())
    }

    fn draw(&self, random: &mut Random) -> Vec<f64> {
        let noise = random.normals(self.mean.len());
        let mut point: Vec<f64> = self.mean.iter().zip(&noise).map(|(m, z)| m + z).collect();
        for (axis, variance) in self.axes.iter().zip(&self.variances) {
            let place: f64 = axis.iter().zip(&noise).map(|(a, z)| a * z).sum();
            let more = (variance.sqrt() - 1.0) * place;
            for (x, a) in point.iter_mut().zip(axis) {
                *x += more * a;
            }
        }
        point
    }

    fn wider(&self, factor: f64) -> Self {
        let variances = self.variances.iter().map(|v| v * factor * factor);
        Self {
            variances: variances.collect(),
            ..self.clone()
        }
    }
}

/// A mixture; each of its components belongs to a region.
#[derive(Clone, Debug, Default)]
pub(super) struct Mixture {
    parts: Vec<Component>,
    weights: Vec<f64>,
    /// The region of each component.
    regions: Vec<usize>,
}

/// The logarithm of a standard normal density.
pub(super) fn ln_standard(point: &[f64]) -> f64 {
    let squares: f64 = point.iter().map(|x| x * x).sum();
    -0.5 * (squares + point.len() as f64 * TAU.ln())
}

impl Mixture {
    /// The mixture of at most so many components that explains the points best, by Schwarz's criterion (1978).
    pub(super) fn fit(
        points: &[Vec<f64>],
        weights: &[f64],
        most: usize,
        random: &mut Random,
    ) -> Self {
        let one = Self {
            parts: vec![Component::fit(points, weights)],
            weights: vec![1.0],
            regions: vec![0],
        };
        let mut best = (one.criterion(points, weights), one);
        for count in 2..=most {
            let Some(mixture) = Self::of(count, points, weights, random) else {
                continue;
            };
            let criterion = mixture.criterion(points, weights);
            if criterion < best.0 {
                best = (criterion, mixture);
            }
        }
        best.1
    }

    /// A mixture of so many components; none where some of them would rest on too few points.
    fn of(count: usize, points: &[Vec<f64>], weights: &[f64], random: &mut Random) -> Option<Self> {
        const STEPS: usize = 40;
        let mut parts = beginning(count, points, weights, random);
        let mut last = f64::NEG_INFINITY;
        for _ in 0..STEPS {
            let mixture = Self::of_parts(points, &parts)?;
            let (next, fit) = mixture.shares(points, weights);
            if fit - last < 1e-4 {
                return Some(mixture);
            }
            (parts, last) = (next, fit);
        }
        Self::of_parts(points, &parts)
    }

    /// A component for each part of the points' weights; none where one of them rests on too few points.
    fn of_parts(points: &[Vec<f64>], parts: &[Vec<f64>]) -> Option<Self> {
        if parts.iter().any(|part| effective(part) < fewest(points)) {
            return None;
        }
        let mut mixture = Self {
            parts: parts.iter().map(|p| Component::fit(points, p)).collect(),
            weights: parts.iter().map(|p| p.iter().sum()).collect(),
            regions: vec![0; parts.len()],
        };
        mixture.normalise();
        Some(mixture)
    }

    /// Fits the components to weighted points, beginning from what they are; none gets lost.
    pub(super) fn refit(&mut self, points: &[Vec<f64>], weights: &[f64]) {
        const STEPS: usize = 12;
        const LEAST: f64 = 0.02;
        let count = self.parts.len() as f64;
        for _ in 0..STEPS {
            let (parts, _) = self.shares(points, weights);
            let sum: f64 = weights.iter().sum();
            for (k, part) in parts.iter().enumerate() {
                if effective(part) >= fewest(points) {
                    self.parts[k] = Component::fit(points, part);
                }
                let share = part.iter().sum::<f64>() / sum;
                self.weights[k] = share.max(LEAST / count);
            }
            self.normalise();
        }
    }

    /// The part of each point's weight that belongs to each component, and the mean logarithm of the density.
    fn shares(&self, points: &[Vec<f64>], weights: &[f64]) -> (Vec<Vec<f64>>, f64) {
        let mut shares = vec![vec![0.0; points.len()]; self.parts.len()];
        let (mut fit, sum) = (0.0, weights.iter().sum::<f64>());
        for (i, (point, weight)) in points.iter().zip(weights).enumerate() {
            let terms = self.terms(point);
            let all = ln_sum(&terms);
            fit += weight / sum * all;
            for (share, term) in shares.iter_mut().zip(&terms) {
                share[i] = weight * (term - all).exp();
            }
        }
        (shares, fit)
    }

    /// How badly the mixture explains the points, its numbers counted against it.
    fn criterion(&self, points: &[Vec<f64>], weights: &[f64]) -> f64 {
        let effective = effective(weights);
        let numbers = |part: &Component| 1 + part.mean.len() * (1 + part.axes.len());
        let numbers: usize = self.parts.iter().map(numbers).sum();
        -2.0 * effective * self.shares(points, weights).1 + numbers as f64 * effective.ln()
    }

    /// Scales the weights to the sum 1.
    pub(super) fn normalise(&mut self) {
        let sum: f64 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|w| *w /= sum);
    }

    fn terms(&self, point: &[f64]) -> Vec<f64> {
        let pairs = self.parts.iter().zip(&self.weights);
        pairs
            .map(|(part, weight)| weight.ln() + part.ln_density(point))
            .collect()
    }

    pub(super) fn ln_density(&self, point: &[f64]) -> f64 {
        ln_sum(&self.terms(point))
    }

    /// The component that most probably drew the point.
    pub(super) fn nearest(&self, point: &[f64]) -> usize {
        let terms = self.terms(point);
        (0..terms.len())
            .max_by(|&a, &b| terms[a].total_cmp(&terms[b]))
            .expect("a mixture has a component")
    }

    /// The region to which a point most probably belongs.
    pub(super) fn region(&self, point: &[f64]) -> usize {
        self.regions[self.nearest(point)]
    }

    pub(super) fn draw(&self, random: &mut Random) -> Vec<f64> {
        self.parts[random.pick(&self.weights)].draw(random)
    }

    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Takes the components of another mixture for a region, with this weight in all.
    pub(super) fn add(&mut self, other: Self, weight: f64, region: usize) {
        self.parts.extend(other.parts);
        self.weights
            .extend(other.weights.iter().map(|w| weight * w));
        self.regions.resize(self.parts.len(), region);
    }

    /// The mixture with a part of it drawn wider, so that no weight becomes large where its own tails are too light.
    pub(super) fn defended(&self) -> Self {
        const WIDER: [(f64, f64); 2] = [(0.2, 1.7), (0.05, 3.0)];
        let rest = 1.0 - WIDER.iter().map(|(share, _)| share).sum::<f64>();
        let mut all = Self::default();
        for (share, factor) in [(rest, 1.0)].into_iter().chain(WIDER) {
            all.parts.extend(self.parts.iter().map(|p| p.wider(factor)));
            all.weights.extend(self.weights.iter().map(|w| share * w));
            all.regions.extend(&self.regions);
        }
        all
    }
}

/// A component rests on as many effective points at least.
fn fewest(points: &[Vec<f64>]) -> f64 {
    let dimensions = points.first().map_or(0, Vec::len);
    (2 * dimensions).max(15) as f64
}

/// Points that lie far apart, and to each the points that are nearest to it (Arthur and Vassilvitskii 2007, "k-means++").
fn beginning(
    count: usize,
    points: &[Vec<f64>],
    weights: &[f64],
    random: &mut Random,
) -> Vec<Vec<f64>> {
    let square = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>()
    };
    let mut centres = vec![random.pick(weights)];
    let nearest = |centres: &[usize], point: &[f64]| {
        let distances = centres.iter().map(|&c| square(&points[c], point));
        distances
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("the first centre was chosen above")
    };
    while centres.len() < count {
        let pairs = points.iter().zip(weights);
        let chances: Vec<f64> = pairs.map(|(p, w)| w * nearest(&centres, p).1).collect();
        centres.push(random.pick(&chances));
    }
    let mut parts = vec![vec![0.0; points.len()]; count];
    for (i, point) in points.iter().enumerate() {
        parts[nearest(&centres, point).0][i] = weights[i];
    }
    parts
}
