//! The distinct minima among the ends of local searches, and how much of the posterior each of them holds.
//!
//! Two ends are at one minimum when a way leads from one to the other that never rises much: near each other, in units
//! of the posterior; else along the straight line; else, as a valley may be curved, through the minimum that is found
//! from the middle of the line, and so on with both halves. However narrow a smooth valley is, half a line rises little above it
//! against the whole one (a 16th: the distance goes with the square of the length, the rise with the square of that); between
//! two different minima it does not. Equal sums of squares say nothing of that: they are just as equal at two
//! different exact solutions.
//!
//! The mass of each minimum is that of its Gaussian approximation (Laplace's method; Tierney & Kadane 1986, Accurate
//! approximations for posterior moments and marginal densities, J. American Statistical Association 81, 82-86), of
//! which only the part between the bounds counts.

use nalgebra::DMatrix;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

use super::{
    errors::Errors,
    failures::Edge,
    local::{Limits, Minimum, minimise},
    objective::{Differences, Misfit, Objective},
    posterior::Posterior,
    problem::NoPrediction,
};

/// Minima whose sum of squares is larger than the least by more have a density of less than 1e-4 of the greatest.
const RELEVANT: f64 = 18.5;

/// A way between two places of one minimum may rise by so much: the density falls to 0.6 of the lower end's.
const BARRIER: f64 = 1.0;

/// Points on the line between two optima where we look for a barrier.
const BETWEEN: usize = 7;

/// How often a way may be bent in its middle.
const BENDS: usize = 3;

/// After the last bend a line may rise by this part of what the line rose from which it was bent.
const SMOOTH: f64 = 1.0 / 8.0;

/// Steps down from the middle of a straight line into the valley beside it. Few are enough to fall into it; along it the
/// way leads back to one of the ends.
const STEPS_DOWN: usize = 8;

/// A minimum with its part of the posterior.
#[derive(Clone, Debug)]
pub struct Optimum {
    /// The minimum.
    pub minimum: Minimum,
    /// The posterior around it.
    pub posterior: Posterior,
    /// How many local searches ended at it.
    pub reached: usize,
    /// Its part of the posterior probability of all minima.
    pub weight: f64,
    /// Failed runs around it.
    pub edge: Edge,
    /// The free parameters' intervals of 95 %, as places, after a look at their ends.
    pub intervals: Vec<Local>,
}

/// A free parameter's interval around an optimum.
#[derive(Clone, Copy, Debug)]
pub struct Local {
    /// The ends, as places.
    pub ends: [f64; 2],
    /// What the sum of squares there says of the normal approximation.
    pub approximation: Approximation,
}

/// Whether the normal approximation holds at the ends of an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approximation {
    /// The sum of squares rises about as much as it says, or nobody has looked.
    #[default]
    Holds,
    /// It rises less, so the interval was lengthened.
    Lengthened,
    /// It rises much more: the other unknowns go another way.
    Bends,
}

impl Local {
    /// Compares the rise of the sum of squares at an end with the predicted one, and notes whether the approximation holds.
    /// Returns by which factor the end should be farther away, if the rise is too small.
    fn take(&mut self, rise: f64, predicted: f64) -> Option<f64> {
        /// Standard deviations at the end, over those predicted: within these the approximation serves.
        const CLOSE: [f64; 2] = [0.9, 1.5];
        /// A smaller difference of the sum of squares matters to no probability.
        const LITTLE: f64 = 0.5;
        /// The most at a time.
        const FARTHEST: f64 = 2.0;
        let part = (rise.max(0.0) / predicted).sqrt();
        if (rise - predicted).abs() <= LITTLE || (CLOSE[0]..=CLOSE[1]).contains(&part) {
            return None;
        }
        if part > 1.0 {
            if self.approximation == Approximation::Holds {
                self.approximation = Approximation::Bends;
            }
            return None;
        }
        self.approximation = Approximation::Lengthened;
        Some(part.recip().min(FARTHEST))
    }
}

impl Optimum {
    pub(crate) fn new(objective: &Objective, minimum: Minimum, reached: usize) -> Result<Self, NoPrediction> {
        let posterior = Posterior::at(objective, &minimum)?;
        let free = 0..objective.problem.free.len();
        let intervals =
            free.map(|index| Local { ends: posterior.interval(index), approximation: Approximation::Holds });
        Ok(Self { intervals: intervals.collect(), posterior, minimum, reached, weight: 0.0, edge: Edge::default() })
    }

    /// The precision of the unknowns and the shared errors, and the places of those that are at no bound.
    pub fn precision(&self, errors: &Errors) -> (DMatrix<f64>, Vec<usize>) {
        let full = errors.with_sources(&self.posterior.precision, &self.posterior.slopes[1]);
        let inside = |k: &usize| self.minimum.places.get(*k).is_none_or(|place| *place > 0.0 && *place < 1.0);
        let open = (0..full.nrows()).filter(inside).collect();
        (full, open)
    }

    /// Runs the model at the ends of the free parameters' intervals, where the other unknowns go with them as the normal
    /// approximation has it. Where the sum of squares has risen less than it says, the interval is lengthened.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn look_at_ends(&mut self, objective: &Objective) -> Result<(), NoPrediction> {
        /// How often an end may be moved.
        const ROUNDS: usize = 4;
        let from = &self.minimum.places;
        let mut open: Vec<(usize, usize, f64)> = (0..self.intervals.len())
            .filter(|index| !self.minimum.surrounded.contains(index))
            .flat_map(|index| [(index, 0), (index, 1)])
            .map(|(index, side)| {
                let to = self.along(index, self.intervals[index].ends[side]);
                (index, side, self.posterior.rise(from, &to))
            })
            .collect();
        for _ in 0..ROUNDS {
            open.retain(|&(index, side, rise)| {
                let end = self.intervals[index].ends[side];
                end > 0.0 && end < 1.0 && rise > 0.0
            });
            let sets = open.iter().map(|&(index, side, _)| self.along(index, self.intervals[index].ends[side]));
            let misfits = objective.misfits(&sets.collect::<Vec<_>>())?;
            let mut short = Vec::new();
            for (&(index, side, predicted), misfit) in open.iter().zip(misfits) {
                // Failed runs have words of their own.
                let Ok(misfit) = misfit else { continue };
                let rise = misfit.cost() - self.minimum.cost();
                let local = &mut self.intervals[index];
                if let Some(by) = local.take(rise, predicted) {
                    let place = self.minimum.places[index];
                    let end = place + by * (local.ends[side] - place);
                    local.ends[side] = end.clamp(0.0, 1.0);
                    short.push((index, side, predicted));
                }
            }
            open = short;
        }
        Ok(())
    }

    /// The unknowns where a free parameter has a place and the others are most probable, by the normal approximation.
    fn along(&self, index: usize, end: f64) -> Vec<f64> {
        let covariance = &self.posterior.covariance;
        let step = (end - self.minimum.places[index]) / covariance[(index, index)];
        self.minimum
            .places
            .iter()
            .enumerate()
            .map(|(k, place)| (place + step * covariance[(k, index)]).clamp(0.0, 1.0))
            .collect()
    }

    /// Looks at the ends of the 95 % region along its axes: do runs fail there?
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn look_around(&mut self, objective: &Objective) -> Result<(), NoPrediction> {
        let ends = self.posterior.ends(&self.minimum.places);
        let misfits = objective.misfits(&ends)?;
        self.edge = Edge {
            blocked: self.minimum.blocked,
            asked: misfits.len(),
            failed: misfits.iter().filter(|misfit| misfit.is_err()).count(),
        };
        Ok(())
    }
}

/// The distinct minima found so far.
pub struct Optima<'a, 'b> {
    objective: &'a Objective<'b>,
    /// How far each minimum is followed down.
    limits: Limits,
    optima: Vec<Optimum>,
}

impl<'a, 'b> Optima<'a, 'b> {
    /// None yet.
    pub fn new(objective: &'a Objective<'b>, limits: Limits) -> Self {
        Self { objective, limits, optima: Vec::new() }
    }

    /// How many minima could be the right one.
    pub fn count(&self) -> usize {
        let least = self.least();
        self.optima.iter().filter(|optimum| optimum.minimum.cost() <= least + RELEVANT).count()
    }

    /// The least sum of squares so far; infinite without a minimum.
    pub fn least(&self) -> f64 {
        self.optima.iter().map(|optimum| optimum.minimum.cost()).fold(f64::INFINITY, f64::min)
    }

    /// Adds the end of a local search: to the minimum that it belongs to, or as a new one. Ends that are too improbable
    /// to matter are left out.
    ///
    /// # Errors
    /// When there are no further predictions.
    pub fn add(&mut self, end: &Minimum) -> Result<(), NoPrediction> {
        let cost = end.cost();
        if cost > self.least() + RELEVANT {
            return Ok(());
        }
        if let Some(known) = self.same(end)?
            && self.optima[known].minimum.cost() <= cost
        {
            self.optima[known].reached += 1;
            return Ok(());
        }
        let (start, limits) = (end.places.clone(), &self.limits);
        let minimum = minimise(self.objective, start, &[], Differences::Central, limits)?;
        let known = self.same(&minimum)?;
        let reached = known.map_or(0, |known| self.optima[known].reached) + 1;
        match known {
            Some(known) if self.optima[known].minimum.cost() <= minimum.cost() => {
                self.optima[known].reached = reached;
            }
            _ => {
                let optimum = Optimum::new(self.objective, minimum, reached)?;
                match known {
                    Some(known) => self.optima[known] = optimum,
                    None => self.optima.push(optimum),
                }
            }
        }
        Ok(())
    }

    /// The minimum that a place belongs to.
    fn same(&self, end: &Minimum) -> Result<Option<usize>, NoPrediction> {
        let distance = |optimum: &Optimum| optimum.posterior.distance(&optimum.minimum.places, &end.places);
        let mut order: Vec<(usize, f64)> = self.optima.iter().map(distance).enumerate().collect();
        order.sort_by(|a, b| a.1.total_cmp(&b.1));
        for (index, distance) in order {
            let minimum = &self.optima[index].minimum;
            if distance <= 1.0 || self.connected(minimum, end, (BENDS, f64::INFINITY))? {
                return Ok(Some(index));
            }
        }
        Ok(None)
    }

    /// Whether a way without a barrier leads from one place to the other, bent so often at most; the line from which this one
    /// was bent rose by `whole`.
    fn connected(&self, a: &Minimum, b: &Minimum, (bends, whole): (usize, f64)) -> Result<bool, NoPrediction> {
        let higher = a.cost().max(b.cost());
        let at = |part: f64| -> Vec<f64> { a.places.iter().zip(&b.places).map(|(a, b)| a + part * (b - a)).collect() };
        let line = (1..=BETWEEN).map(|k| at(k as f64 / (BETWEEN + 1) as f64));
        let misfits = self.objective.misfits(&line.collect::<Vec<_>>())?;
        let rise =
            |misfit: &Result<Misfit, String>| misfit.as_ref().map_or(f64::INFINITY, |misfit| misfit.cost() - higher);
        let rise = misfits.iter().map(rise).fold(0.0, f64::max);
        if rise <= BARRIER || bends == 0 {
            return Ok(rise <= BARRIER || rise.is_finite() && rise <= SMOOTH * whole);
        }
        let limits = Limits { iterations: STEPS_DOWN, decrease: 1e-4 };
        let middle = match minimise(self.objective, at(0.5), &[], Differences::Forward, &limits) {
            Err(NoPrediction::Here(_)) => return Ok(false),
            ended => ended?,
        };
        if middle.cost() > higher + BARRIER || !between(&a.places, &middle.places, &b.places) {
            return Ok(false);
        }
        let left = (bends - 1, rise);
        Ok(self.connected(a, &middle, left)? && self.connected(&middle, b, left)?)
    }

    /// The minima that matter, those with the largest part of the posterior first.
    pub fn weighed(self) -> Vec<Optimum> {
        let least = self.least();
        let mut optima = self.optima;
        optima.retain(|optimum| optimum.minimum.cost() <= least + RELEVANT);
        let mass = |optimum: &Optimum| {
            let density = -0.5 * (optimum.minimum.cost() - least);
            density + optimum.posterior.log_volume + log_inside(optimum)
        };
        let masses: Vec<f64> = optima.iter().map(mass).collect();
        let most = masses.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = masses.iter().map(|mass| (mass - most).exp()).sum();
        for (optimum, mass) in optima.iter_mut().zip(&masses) {
            optimum.weight = (mass - most).exp() / sum;
        }
        optima.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        optima
    }
}

/// Whether a place is on the way between two others: nearer to each than they are to each other, and at neither.
fn between(a: &[f64], middle: &[f64], b: &[f64]) -> bool {
    const AT_AN_END: f64 = 0.05;
    let distance = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
    let way = distance(a, b);
    [distance(a, middle), distance(middle, b)].iter().all(|part| (AT_AN_END * way..way).contains(part))
}

/// The logarithm of the part of a Gaussian posterior that lies between the bounds, one unknown after the other.
fn log_inside(optimum: &Optimum) -> f64 {
    let normal = Normal::standard();
    optimum
        .minimum
        .places
        .iter()
        .enumerate()
        .map(|(unknown, place)| {
            let deviation = optimum.posterior.deviation(unknown);
            normal.cdf((1.0 - place) / deviation) - normal.cdf(-place / deviation)
        })
        .map(f64::ln)
        .sum()
}
