//! Mixtures of normal distributions: where a sample starts, and how its particles move.
//!
//! A mixture fitted to the particles near each of some anchors follows several modes and curved valleys alike: each of
//! its parts has the shape that the sample has there.

use nalgebra::{Cholesky, DMatrix, DVector};
use sampling::{distribution::ln_sum, random::Random};

/// One normal distribution.
#[derive(Clone, Debug)]
struct Component {
    weight: f64,
    mean: Vec<f64>,
    /// Cholesky factor of the covariance, row by row up to the diagonal, and its inverse.
    factor: Vec<Vec<f64>>,
    inverse: Vec<Vec<f64>>,
    /// The logarithm of the density at the mean.
    peak: f64,
}

impl Component {
    fn new(weight: f64, mean: &DVector<f64>, covariance: DMatrix<f64>) -> Option<Self> {
        let factor = Cholesky::new(covariance)?.l();
        let inverse = factor.clone().try_inverse()?;
        let volume: f64 = factor.diagonal().iter().map(|v| v.ln()).sum();
        let peak = -volume - 0.5 * mean.len() as f64 * std::f64::consts::TAU.ln();
        peak.is_finite().then(|| Self {
            weight,
            mean: mean.iter().copied().collect(),
            factor: rows(&factor),
            inverse: rows(&inverse),
            peak,
        })
    }

    /// The logarithm of the density of a step, with all deviations `scale` times as large.
    fn log_between(&self, from: &[f64], to: &[f64], scale: f64) -> f64 {
        let squares = squared(&self.inverse, from, to) / (scale * scale);
        self.peak - 0.5 * squares - from.len() as f64 * scale.ln()
    }

    /// A place from a normal distribution of this shape about another centre.
    fn draw(&self, centre: &[f64], scale: f64, random: &mut Random) -> Vec<f64> {
        let normal = random.normals(centre.len());
        centre
            .iter()
            .zip(&self.factor)
            .map(|(centre, row)| {
                let step = row.iter().zip(&normal).map(|(a, z)| a * z);
                centre + scale * step.sum::<f64>()
            })
            .collect()
    }
}

/// The rows of a lower triangular matrix, up to the diagonal.
fn rows(triangle: &DMatrix<f64>) -> Vec<Vec<f64>> {
    (0..triangle.nrows()).map(|i| (0..=i).map(|j| triangle[(i, j)]).collect()).collect()
}

/// The squared length of a way that a triangular matrix is applied to.
fn squared(triangle: &[Vec<f64>], from: &[f64], to: &[f64]) -> f64 {
    let entry = |row: &Vec<f64>| -> f64 { row.iter().zip(from).zip(to).map(|((a, from), to)| a * (to - from)).sum() };
    triangle.iter().map(|row| entry(row).powi(2)).sum()
}

/// A mixture of normal distributions.
#[derive(Clone, Debug)]
pub struct Mixture {
    parts: Vec<Component>,
}

/// The largest number of parts that are fitted to particles.
const MOST_PARTS: f64 = 32.0;

/// Particles for each unknown that the covariance of a part needs.
const PARTICLES: f64 = 3.0;

/// Parts overlap: each is fitted to this many times its share of the particles.
const OVERLAP: f64 = 1.5;

impl Mixture {
    /// Normal distributions with weights, means and covariances; those that are no covariances are left out.
    pub fn new(parts: Vec<(f64, DVector<f64>, DMatrix<f64>)>) -> Option<Self> {
        let mut parts: Vec<Component> = parts
            .into_iter()
            .filter_map(|(weight, mean, covariance)| Component::new(weight, &mean, covariance))
            .filter(|part| part.weight > 0.0)
            .collect();
        let all: f64 = parts.iter().map(|part| part.weight).sum();
        parts.iter_mut().for_each(|part| part.weight /= all);
        (!parts.is_empty()).then_some(Self { parts })
    }

    /// Whether weighted points are enough for one part at least.
    pub fn enough(points: &[&[f64]], weights: &[f64]) -> bool {
        points.first().is_some_and(|point| effective(weights) >= PARTICLES * (point.len() + 1) as f64)
    }

    /// A mixture that has the shape of weighted points: each part has mean and covariance of the points nearest to one
    /// of them.
    pub fn fitted(points: &[&[f64]], weights: &[f64], random: &mut Random) -> Option<Self> {
        let d = points.first()?.len();
        let effective = effective(weights);
        let count = (effective / (PARTICLES * (d + 1) as f64)).floor();
        let count = count.clamp(1.0, MOST_PARTS) as usize;
        let all: Vec<usize> = (0..points.len()).collect();
        let (_, whole) = moments(points, weights, &all);
        let least = (effective.min(2.0 * (d + 1) as f64)) as usize;
        let share = (OVERLAP / count as f64).min(1.0);
        let metric = Cholesky::new(floored(whole.clone(), &whole)).and_then(|factor| factor.l().try_inverse())?;
        let metric = rows(&metric);
        let parts = anchors(weights, count, random).into_iter().map(|anchor| {
            let near = nearest(points, weights, &metric, anchor, share, least);
            let (mean, covariance) = moments(points, weights, &near);
            (1.0, mean, floored(covariance, &whole))
        });
        Self::new(parts.collect())
    }

    /// The mixture that is fitted to points of equal weight, and in equal parts a normal distribution of all of them: the
    /// small parts alone leave out the tails.
    pub fn covering(points: &[&[f64]], random: &mut Random) -> Option<Self> {
        let weights = vec![(points.len() as f64).recip(); points.len()];
        let mut mixture = Self::fitted(points, &weights, random)?;
        let all: Vec<usize> = (0..points.len()).collect();
        let (mean, whole) = moments(points, &weights, &all);
        for part in &mut mixture.parts {
            part.weight *= 0.5;
        }
        mixture.parts.push(Component::new(0.5, &mean, floored(whole.clone(), &whole))?);
        Some(mixture)
    }

    /// The logarithm of each part's share of the density, with all deviations `scale` times as large.
    fn logs(&self, place: &[f64], scale: f64) -> Vec<f64> {
        self.parts.iter().map(|part| part.weight.ln() + part.log_between(&part.mean, place, scale)).collect()
    }

    /// The logarithm of the density, with all deviations `scale` times as large.
    pub fn log_density(&self, place: &[f64], scale: f64) -> f64 {
        ln_sum(&self.logs(place, scale))
    }

    /// The parts that a place belongs to, as logarithms of probabilities. Wider parts than those fitted make the change
    /// from one to the next gentle, so that a move from one to another can be undone.
    fn shares(&self, place: &[f64]) -> Vec<f64> {
        const GENTLE: f64 = 2.0;
        let mut logs = self.logs(place, GENTLE);
        let all = ln_sum(&logs);
        logs.iter_mut().for_each(|log| *log -= all);
        logs
    }

    /// A place from the mixture, with all deviations `scale` times as large; `level` from 0 to 1 chooses the part.
    pub fn draw(&self, level: f64, scale: f64, random: &mut Random) -> Vec<f64> {
        let part = &self.parts[chosen(self.parts.iter().map(|part| part.weight), level)];
        part.draw(&part.mean, scale, random)
    }

    /// A step from a place in the shape that the mixture has there.
    pub fn step(&self, place: &[f64], scale: f64, random: &mut Random) -> Vec<f64> {
        let shares = self.shares(place);
        let part = chosen(shares.iter().map(|log| log.exp()), random.unit());
        self.parts[part].draw(place, scale, random)
    }

    /// The logarithm of the density of such a step.
    pub fn log_step(&self, from: &[f64], to: &[f64], scale: f64) -> f64 {
        let logs =
            self.parts.iter().zip(self.shares(from)).map(|(part, share)| share + part.log_between(from, to, scale));
        ln_sum(&logs.collect::<Vec<_>>())
    }
}

/// How many points of equal weight tell as much; the sum of the weights is 1.
fn effective(weights: &[f64]) -> f64 {
    1.0 / weights.iter().map(|w| w * w).sum::<f64>()
}

/// The index at which the weights' sum reaches a level from 0 to 1.
pub fn chosen(weights: impl Iterator<Item = f64>, level: f64) -> usize {
    let mut sum = 0.0;
    let mut last = 0;
    for (index, weight) in weights.enumerate() {
        if weight > 0.0 {
            last = index;
            sum += weight;
            if sum > level {
                break;
            }
        }
    }
    last
}

/// Points in number `count`, spread evenly over the weights in a random order.
fn anchors(weights: &[f64], count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    random.shuffle(&mut order);
    let first = random.unit();
    (0..count)
        .map(|k| (k as f64 + first) / count as f64)
        .map(|level| order[chosen(order.iter().map(|&index| weights[index]), level)])
        .collect()
}

/// The points nearest to one of them: so many that they hold a share of the weight, and at least `least`.
fn nearest(
    points: &[&[f64]],
    weights: &[f64],
    metric: &[Vec<f64>],
    anchor: usize,
    share: f64,
    least: usize,
) -> Vec<usize> {
    let mut near: Vec<(f64, usize)> = (0..points.len())
        .filter(|&index| weights[index] > 0.0)
        .map(|index| (squared(metric, points[anchor], points[index]), index))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut sum = 0.0;
    let mut kept = Vec::new();
    for (_, index) in near {
        if sum >= share && kept.len() >= least {
            break;
        }
        sum += weights[index];
        kept.push(index);
    }
    kept
}

/// Mean and covariance of some of the weighted points.
fn moments(points: &[&[f64]], weights: &[f64], which: &[usize]) -> (DVector<f64>, DMatrix<f64>) {
    let d = points.first().map_or(0, |point| point.len());
    let all: f64 = which.iter().map(|&index| weights[index]).sum();
    let point = |index: usize| DVector::from_row_slice(points[index]);
    let mean = which.iter().fold(DVector::zeros(d), |sum, &index| sum + point(index) * weights[index] / all);
    let covariance = which.iter().fold(DMatrix::zeros(d, d), |sum, &index| {
        let way = point(index) - &mean;
        sum + &way * way.transpose() * weights[index] / all
    });
    (mean, covariance)
}

/// A covariance that can be inverted, also where points lie on one line.
fn floored(mut covariance: DMatrix<f64>, whole: &DMatrix<f64>) -> DMatrix<f64> {
    for index in 0..covariance.nrows() {
        covariance[(index, index)] *= 1.0 + 1e-9;
        covariance[(index, index)] += 1e-12 * whole[(index, index)] + 1e-28;
    }
    covariance
}
