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
    fn fit(points: &[Vec<f64>], weights: &[f64], told: f64) -> Self {
        // Chance goes a little further than the limit for many points.
        const SLACK: f64 = 1.1;
        const NEGLIGIBLE: f64 = 1e-6;
        // Of other components' points there is nothing to tell.
        let most = weights.iter().copied().fold(0.0, f64::max);
        let matter = |&i: &usize| weights[i] > NEGLIGIBLE * most;
        let (points, weights): (Vec<&[f64]>, Vec<f64>) =
            (0..points.len()).filter(matter).map(|i| (points[i].as_slice(), weights[i])).unzip();
        let scatter = Scatter::of(&points, &weights);
        let ratio = (scatter.mean.len() as f64 / (told * scatter.effective).max(1.0)).sqrt();
        let low = (1.0 - ratio).max(0.0).powi(2) / SLACK;
        let high = (1.0 + ratio).powi(2) * SLACK;
        let pairs = scatter.axes.into_iter().zip(scatter.variances);
        let (axes, variances) = pairs.filter(|(_, v)| !(low..=high).contains(v)).unzip();
        Self { mean: scatter.mean, axes, variances }
    }

    /// About the centre, with the points' mean square.
    fn about_centre(points: &[Vec<f64>]) -> Self {
        let dimensions = points.first().map_or(0, Vec::len);
        let squares: f64 = points.iter().flatten().map(|x| x * x).sum();
        let variance = (squares / (points.len() * dimensions).max(1) as f64).max(1.0);
        let axis = |k: usize| (0..dimensions).map(|j| f64::from(u8::from(j == k))).collect();
        Self {
            mean: vec![0.0; dimensions],
            axes: (0..dimensions).map(axis).collect(),
            variances: vec![variance; dimensions],
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
        Self { variances: variances.collect(), ..self.clone() }
    }
}

/// A mixture.
#[derive(Clone, Debug, Default)]
pub(super) struct Mixture {
    parts: Vec<Component>,
    weights: Vec<f64>,
    /// As many independent points tell as much as one that it was fitted to.
    told: f64,
}

/// The logarithm of a standard normal density.
pub(super) fn ln_standard(point: &[f64]) -> f64 {
    let squares: f64 = point.iter().map(|x| x * x).sum();
    -0.5 * (squares + point.len() as f64 * TAU.ln())
}

impl Mixture {
    /// The mixture that explains the points best, by Schwarz's criterion (1978), of those that begin with one component.
    pub(super) fn fit(points: &[Vec<f64>], weights: &[f64], told: f64) -> Self {
        let one = Self { parts: vec![Component::fit(points, weights, told)], weights: vec![1.0], told };
        one.grown(points, weights).1
    }

    /// The same for the points of chains, which resemble each other: so many independent ones tell as much as one.
    pub(super) fn of_chains(points: &[Vec<f64>]) -> Self {
        const CHAINED: f64 = 0.15;
        Self::fit(points, &vec![1.0; points.len()], CHAINED)
    }

    /// How many components of equal weight are as diverse.
    pub(super) fn effective(&self) -> f64 {
        effective(&self.weights)
    }

    /// The same, but beginning with what this is.
    pub(super) fn fit_on(&self, points: &[Vec<f64>], weights: &[f64]) -> Self {
        let this = Self { told: 1.0, ..self.clone() };
        this.grown(points, weights).1
    }

    /// Splits the widest component along its widest axis, again and again: the best mixture on this way, after its
    /// criterion.
    fn grown(mut self, points: &[Vec<f64>], weights: &[f64]) -> (f64, Self) {
        // More components are hardly ever needed, and take long to fit.
        const MOST: usize = 24;
        // Where so many more components are no better, none are; of wide ones so many.
        const PATIENCE: usize = 3;
        const WIDE_PATIENCE: usize = 8;
        // A convex part of a normal distribution is nowhere wider than it (Brascamp and Lieb 1976): a wider component has
        // more than one part of the event.
        const WIDE: f64 = 1.5;
        self.refit(points, weights);
        let mut best = (self.criterion(points, weights), self.clone());
        let mut failed = 0;
        while self.len() < MOST {
            let Some((next, variance)) = self.split(points, weights) else {
                break;
            };
            self = next;
            self.refit(points, weights);
            let criterion = self.criterion(points, weights);
            if criterion < best.0 {
                (best, failed) = ((criterion, self.clone()), 0);
            } else {
                failed += 1;
            }
            if failed >= WIDE_PATIENCE || failed >= PATIENCE && variance < WIDE {
                break;
            }
        }
        best
    }

    /// The mixture with another component, and the variance along the axis where it was split; none where all rest on too
    /// few points.
    fn split(&self, points: &[Vec<f64>], weights: &[f64]) -> Option<(Self, f64)> {
        let (shares, _) = self.shares(points, weights);
        let mut widest: Option<(f64, f64, usize, [Vec<f64>; 2])> = None;
        for (k, (part, share)) in self.parts.iter().zip(&shares).enumerate() {
            for (axis, &variance) in part.axes.iter().zip(&part.variances) {
                let score = variance * self.weights[k];
                if widest.as_ref().is_some_and(|widest| widest.0 >= score) {
                    continue;
                }
                let side = |sign: f64| -> Vec<f64> {
                    let of = |(point, weight): (&Vec<f64>, &f64)| {
                        let triples = point.iter().zip(&part.mean).zip(axis);
                        let place: f64 = triples.map(|((x, m), a)| a * (x - m)).sum();
                        if sign * place > 0.0 { *weight } else { 0.0 }
                    };
                    points.iter().zip(share).map(of).collect()
                };
                let sides = [side(1.0), side(-1.0)];
                if sides.iter().all(|side| self.is_enough(points, side)) {
                    widest = Some((score, variance, k, sides));
                }
            }
        }
        let (_, variance, k, sides) = widest?;
        let mut next = self.clone();
        next.weights[k] *= 0.5;
        next.weights.push(next.weights[k]);
        let [one, other] = sides.map(|side| Component::fit(points, &side, self.told));
        next.parts[k] = one;
        next.parts.push(other);
        Some((next, variance))
    }

    /// Fits the components to weighted points, beginning from what they are; none gets lost.
    fn refit(&mut self, points: &[Vec<f64>], weights: &[f64]) {
        const STEPS: usize = 5;
        const LEAST: f64 = 0.02;
        let count = self.parts.len() as f64;
        let sum: f64 = weights.iter().sum();
        let mut last = f64::NEG_INFINITY;
        for _ in 0..STEPS {
            let (parts, fit) = self.shares(points, weights);
            if fit - last < 1e-3 {
                break;
            }
            last = fit;
            for (k, part) in parts.iter().enumerate() {
                if self.is_enough(points, part) {
                    self.parts[k] = Component::fit(points, part, self.told);
                }
                let share = part.iter().sum::<f64>() / sum;
                self.weights[k] = share.max(LEAST / count);
            }
            self.normalise();
        }
    }

    /// Whether a component can rest on these parts of the points.
    fn is_enough(&self, points: &[Vec<f64>], part: &[f64]) -> bool {
        const FEWEST: usize = 15;
        let dimensions = points.first().map_or(0, Vec::len);
        let fewest = if self.told < 1.0 { FEWEST } else { FEWEST.max(dimensions) };
        effective(part) >= fewest as f64
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
        let effective = self.told * effective(weights);
        let numbers = |part: &Component| 1 + part.mean.len() * (1 + part.axes.len());
        let numbers: usize = self.parts.iter().map(numbers).sum();
        -2.0 * effective * self.shares(points, weights).1 + numbers as f64 * effective.ln()
    }

    /// Scales the weights to the sum 1.
    fn normalise(&mut self) {
        let sum: f64 = self.weights.iter().sum();
        self.weights.iter_mut().for_each(|w| *w /= sum);
    }

    fn terms(&self, point: &[f64]) -> Vec<f64> {
        let pairs = self.parts.iter().zip(&self.weights);
        pairs.map(|(part, weight)| weight.ln() + part.ln_density(point)).collect()
    }

    pub(super) fn ln_density(&self, point: &[f64]) -> f64 {
        ln_sum(&self.terms(point))
    }

    pub(super) fn draw(&self, random: &mut Random) -> Vec<f64> {
        self.parts[random.pick(&self.weights)].draw(random)
    }

    pub(super) fn len(&self) -> usize {
        self.parts.len()
    }

    /// Takes the components of another mixture, with this weight in all.
    pub(super) fn add(&mut self, other: Self, weight: f64) {
        self.weights.iter_mut().for_each(|w| *w *= 1.0 - weight);
        self.parts.extend(other.parts);
        self.weights.extend(other.weights.iter().map(|w| weight * w));
    }

    /// The mixture with a part of it drawn wider, so that no weight becomes large where its own tails are too light.
    pub(super) fn widened(&self) -> Self {
        const WIDER: [(f64, f64); 2] = [(0.2, 1.7), (0.05, 3.0)];
        let mut all = self.clone();
        for (share, factor) in WIDER {
            let parts = self.parts.iter().map(|p| p.wider(factor)).collect();
            let weights = self.weights.clone();
            let told = self.told;
            all.add(Self { parts, weights, told }, share);
        }
        all
    }

    /// The same with a part about the centre, as wide as the points lie from it, which covers all sides of a shell.
    pub(super) fn defended(&self, points: &[Vec<f64>]) -> Self {
        const ABOUT_CENTRE: f64 = 0.1;
        let mut all = self.widened();
        let centre = Self { parts: vec![Component::about_centre(points)], weights: vec![1.0], told: 1.0 };
        all.add(centre, ABOUT_CENTRE);
        all
    }

    /// The component of each point, components between which points lie being one.
    pub(super) fn regions(&self, points: &[Vec<f64>], weights: &[f64]) -> Vec<usize> {
        /// Components are one where so much of the lighter one's weight lies between them.
        const BETWEEN: f64 = 1e-3;
        let count = self.parts.len();
        let (shares, _) = self.shares(points, weights);
        let all: Vec<f64> = shares.iter().map(|share| share.iter().sum()).collect();
        let mut owner: Vec<usize> = (0..count).collect();
        for a in 0..count {
            for b in a + 1..count {
                let pairs = shares[a].iter().zip(&shares[b]);
                let between: f64 = pairs.map(|(x, y)| x.min(*y)).sum();
                let (from, to) = (owner[b], owner[a]);
                if from != to && between > BETWEEN * all[a].min(all[b]) {
                    let moved = owner.iter_mut().filter(|o| **o == from);
                    moved.for_each(|o| *o = to);
                }
            }
        }
        let nearest = |i: usize| {
            let largest = (0..count).max_by(|&a, &b| shares[a][i].total_cmp(&shares[b][i]));
            owner[largest.expect("a mixture has a component")]
        };
        (0..points.len()).map(nearest).collect()
    }
}
