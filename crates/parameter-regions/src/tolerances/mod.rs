//! The widest tolerances of the parameters at which a share still holds.
//!
//! A tolerance is widened or narrowed by scaling the spread of its distribution about its centre. What a share would be
//! at other tolerances is told by importance weights on points that were drawn at known ones (the balance heuristic of
//! Veach and Guibas 1995, "Optimally combining sampling techniques for Monte Carlo rendering"): so every point that was
//! ever run counts. Where the weights leave too few effective points, fresh ones are drawn near the answer.
//!
//! Of all tolerances at which the share holds, those are taken that cost least. A tolerance costs in inverse proportion
//! to its width (Chase and Greenwood 1988, "Design issues in mechanical tolerance analysis").

mod sample;
pub mod stated;
#[cfg(test)]
mod tests;

use conformity::{
    decision::Rule,
    interval::{Moments, of_mean},
};
use sampling::{
    design::{Design, Joint, Method, Sampling, cube},
    distribution::Distribution,
    statistics::share::wilson,
};

pub use sample::{Estimate, Sample};
use stated::{Confirmed, Stated};

/// The task: goal, parameters, costs.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The parameters that have a tolerance, as the study states them.
    pub distributions: Vec<Distribution>,
    /// Parameters that come from samples, which have none: their rows follow in a point.
    pub samples: Vec<Joint>,
    /// Relative cost of a narrower tolerance, for each parameter.
    pub costs: Vec<f64>,
    /// The share that must hold.
    pub target: f64,
    /// With which confidence.
    pub confidence: f64,
    /// The widest tolerances that are looked at, in those of the study.
    pub limit: f64,
    /// Points of a round.
    pub points: u64,
    /// Fresh runs that will confirm the result.
    pub confirm: u64,
    /// The seed of the rounds.
    pub seed: u64,
}

/// The answer; tolerances in those of the study.
#[derive(Clone, Debug)]
pub struct Widest {
    /// Tolerances at which the share is just the wanted one, as far as the points tell.
    pub scales: Vec<f64>,
    /// The share there.
    pub at_scales: Stated,
    /// Somewhat narrower ones, at which as many fresh runs as will be made should show that it holds.
    pub safe: Vec<f64>,
    /// The share there.
    pub at_safe: Stated,
}

/// Tolerances narrower than this are none that one could make.
const NARROWEST: f64 = 1e-3;
const MOST_ROUNDS: u64 = 10;
/// Fewer effective points tell too little.
const FEWEST: f64 = 100.0;
/// The next tolerances that are tried, in the last ones: so near that few shares hold only in between.
const SHRINK: f64 = 0.95;
/// So much wider than the present answer the next points are drawn, so that weights stay bounded.
const WIDER: f64 = 1.25;

impl Problem {
    /// Looks for the widest tolerances. `sample` has points drawn at the study's own, to which those of further rounds are
    /// added; `run` tells how good points are, from 0 to 1, of which the share is the mean.
    ///
    /// # Errors
    /// The return value of `run`.
    pub fn search<E>(
        &self,
        sample: &mut Sample,
        mut run: impl FnMut(Vec<Vec<f64>>) -> Result<Vec<f64>, E>,
    ) -> Result<Widest, E> {
        let ones = vec![1.0; self.distributions.len()];
        let mut scales = self.least_cost(sample, ones);
        for round in 1..=MOST_ROUNDS {
            if self.settled(sample, &scales) {
                break;
            }
            let near: Vec<f64> = scales.iter().map(|s| (WIDER * s).min(self.limit)).collect();
            let points = self.draw(&near, self.seed.wrapping_add(round));
            let goods = run(points.clone())?;
            sample.extend(&near, points, goods);
            scales = self.least_cost(sample, scales);
        }
        let safe = self.safe(sample, &scales);
        Ok(Widest {
            at_scales: self.stated(sample.estimate(&scales)),
            at_safe: self.stated(sample.estimate(&safe)),
            scales,
            safe,
        })
    }

    /// Independent runs at these tolerances, and whether they show that the share holds.
    ///
    /// # Errors
    /// The return value of `run`.
    pub fn confirm<E>(
        &self,
        scales: &[f64],
        run: impl FnOnce(Vec<Vec<f64>>) -> Result<Vec<f64>, E>,
    ) -> Result<Confirmed, E> {
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let sampling = Sampling {
            method: Method::MonteCarlo,
            points: self.confirm,
            // Far from the seeds of the rounds.
            seed: !self.seed,
            ..Sampling::default()
        };
        let places = Design::new(&sampling, vec![unit; self.dimensions()]);
        let places = places.expect("random points are there in any number of dimensions");
        let mut moments = Moments::default();
        for good in run(self.points_of(&places, scales))? {
            moments.add(good);
        }
        let rule = Rule { share: self.target, confidence: self.confidence };
        let interval = of_mean(&[moments], self.confidence);
        Ok(Confirmed { runs: self.confirm, share: moments.mean(), interval, decision: rule.decide(interval) })
    }

    /// Points of the parameters' distributions with these tolerances.
    pub fn draw(&self, scales: &[f64], seed: u64) -> Vec<Vec<f64>> {
        let net = self.net(seed).expect("`check` has made such a net");
        self.points_of(&net, scales)
    }

    /// The points of a design in the unit cube, at these tolerances.
    fn points_of(&self, places: &Design, scales: &[f64]) -> Vec<Vec<f64>> {
        let scaled = scaled(&self.distributions, scales);
        let point = |index| self.point(&scaled, &places.point(index));
        (0..places.len()).map(point).collect()
    }

    /// Says what is wrong with the number of points or parameters, if anything is.
    ///
    /// # Errors
    /// When there is no net of so many points and dimensions.
    pub fn check(&self) -> Result<(), String> {
        self.net(self.seed).map(drop)
    }

    fn net(&self, seed: u64) -> Result<Design, String> {
        Design::net(self.dimensions(), self.points, seed, 1)
    }

    /// Numbers from 0 to 1 that choose a point: one a tolerance, and one a sample.
    fn dimensions(&self) -> usize {
        self.distributions.len() + self.samples.len()
    }

    /// The point at such numbers, with distributions that were scaled before.
    fn point(&self, scaled: &[Distribution], place: &[f64]) -> Vec<f64> {
        let (parameters, rows) = place.split_at(scaled.len());
        let quantiles = scaled.iter().zip(parameters);
        let quantiles = quantiles.map(|(distribution, u)| distribution.quantile(u.clamp(1e-12, 1.0 - 1e-12)));
        let rows = self.samples.iter().zip(rows);
        let rows = rows.flat_map(|(sample, &u)| sample.row(u).iter().copied());
        quantiles.chain(rows).collect()
    }

    /// Points with all tolerances at their centres: one, or some over the rows of the samples.
    pub fn centres(&self) -> Vec<Vec<f64>> {
        const ROWS: u64 = 128;
        let centre: Vec<f64> = self.distributions.iter().map(Distribution::centre).collect();
        if self.samples.is_empty() {
            return vec![centre];
        }
        let places = cube(self.samples.len(), ROWS, self.seed, 1);
        let places = places.expect("`check` has made a net of more dimensions");
        let with_rows = |place: &Vec<f64>| {
            let rows = self.samples.iter().zip(place);
            let rows = rows.flat_map(|(sample, &u)| sample.row(u));
            centre.iter().chain(rows).copied().collect()
        };
        places.iter().map(with_rows).collect()
    }

    /// Tolerances of a length in given proportions, but none wider than what was drawn.
    fn at(&self, sample: &Sample, proportions: &[f64], length: f64) -> Vec<f64> {
        let pairs = proportions.iter().zip(&sample.reach);
        let scale = |(p, reach): (&f64, &f64)| (length * p).clamp(NARROWEST, reach.min(self.limit));
        pairs.map(scale).collect()
    }

    /// The length at which the last of the tolerances is as wide as what was drawn.
    fn longest(&self, sample: &Sample, proportions: &[f64]) -> f64 {
        let pairs = proportions.iter().zip(&sample.reach);
        let lengths = pairs.map(|(p, reach)| reach.min(self.limit) / p);
        lengths.fold(0.0, f64::max)
    }

    /// The cost of tolerances.
    fn cost(&self, scales: &[f64]) -> f64 {
        let pairs = self.costs.iter().zip(scales);
        pairs.map(|(cost, scale)| cost / scale).sum()
    }

    /// Whether the points tell enough about these tolerances: many effective ones, and some drawn at wider tolerances,
    /// unless these are the widest that are looked at.
    fn settled(&self, sample: &Sample, scales: &[f64]) -> bool {
        let enough = FEWEST.max(0.25 * self.points as f64);
        let mut pairs = scales.iter().zip(&sample.reach);
        let inside = pairs.all(|(&scale, &reach)| scale < 0.999 * reach || reach >= 0.999 * self.limit);
        inside && sample.estimate(scales).effective >= enough
    }

    /// The least costly tolerances at which the share holds, from a first guess of their proportions.
    ///
    /// At the optimum no tolerance can be exchanged for another: cost over width is proportional to how fast the share
    /// falls with each (Lagrange). For a share that depends on sums of squares a third of the logarithmic step leads
    /// there at once, elsewhere in a few.
    fn least_cost(&self, sample: &Sample, first: Vec<f64>) -> Vec<f64> {
        const STEPS: usize = 12;
        let mut scales = self.along(sample, &first);
        let mut best = scales.clone();
        for _ in 0..STEPS {
            let falls = self.falls(sample, &scales);
            let largest = falls.iter().copied().fold(0.0, f64::max);
            if largest <= 0.0 {
                break;
            }
            let wanted = self.costs.iter().zip(&falls).map(|(cost, &fall)| {
                // A parameter without influence may become as wide as it likes.
                cost / fall.max(1e-6 * largest)
            });
            let ratios: Vec<f64> = wanted.zip(&scales).map(|(w, s)| (w / s).ln()).collect();
            // The common factor is found along the ray.
            let common = ratios.iter().copied().fold(f64::INFINITY, f64::min);
            let pairs = scales.iter().zip(&ratios);
            let moved = pairs.map(|(scale, r)| scale * ((r - common) / 3.0).min(1.0).exp());
            let next = self.along(sample, &moved.collect::<Vec<f64>>());
            let change = next.iter().zip(&scales).map(|(a, b)| (a / b).ln().abs());
            let change = change.fold(0.0, f64::max);
            scales = next;
            if self.cost(&scales) < self.cost(&best) {
                best.clone_from(&scales);
            }
            if change < 3e-3 {
                break;
            }
        }
        best
    }

    /// How fast the share falls with the logarithm of each tolerance.
    fn falls(&self, sample: &Sample, scales: &[f64]) -> Vec<f64> {
        const STEP: f64 = 0.1;
        let at = |k: usize, factor: f64| {
            let mut moved = scales.to_vec();
            moved[k] *= factor;
            sample.estimate(&moved).share
        };
        let fall = |k: usize| {
            let down = at(k, (-STEP).exp());
            // At the limit of what was drawn only the narrower side is known.
            if scales[k] * STEP.exp() <= sample.reach[k] {
                (down - at(k, STEP.exp())) / (2.0 * STEP)
            } else {
                (down - at(k, 1.0)) / STEP
            }
        };
        (0..scales.len()).map(|k| fall(k).max(0.0)).collect()
    }

    /// The widest tolerances in given proportions at which the share is the wanted one.
    fn along(&self, sample: &Sample, proportions: &[f64]) -> Vec<f64> {
        let holds = |estimate: Estimate| estimate.share >= self.target;
        self.ray(sample, proportions, holds)
    }

    /// The widest tolerances in given proportions at which a condition holds, but none wider than what was drawn, and none
    /// of which the points know too little.
    fn ray(&self, sample: &Sample, proportions: &[f64], holds: impl Fn(Estimate) -> bool) -> Vec<f64> {
        let at = |length: f64| self.at(sample, proportions, length);
        let mut long = self.longest(sample, proportions);
        let mut short = long;
        loop {
            let estimate = sample.estimate(&at(short));
            if holds(estimate) || !is_known(estimate) || at(short).iter().all(|s| *s <= NARROWEST) {
                break;
            }
            (long, short) = (short, SHRINK * short);
        }
        for _ in 0..20 {
            let middle = 0.5 * (short + long);
            let estimate = sample.estimate(&at(middle));
            if holds(estimate) || !is_known(estimate) {
                short = middle;
            } else {
                long = middle;
            }
        }
        at(short)
    }

    /// Tolerances in the same proportions at which even the lower limit of what fresh runs may show is the wanted share.
    fn safe(&self, sample: &Sample, scales: &[f64]) -> Vec<f64> {
        let confirm = self.confirm as f64;
        let mut safe = self.ray(sample, scales, |estimate| {
            let low = wilson(estimate.share, estimate.trials, self.confidence)[0];
            wilson(low, confirm, self.confidence)[0] >= self.target
        });
        for (safe, widest) in safe.iter_mut().zip(scales) {
            *safe = safe.min(*widest);
        }
        safe
    }

    /// The share that the fresh runs will show, with a probability of 99 %: the uncertainty of the estimate and the chance
    /// of these runs come together.
    fn stated(&self, estimate: Estimate) -> Stated {
        const PROBABILITY: f64 = 0.99;
        let trials = 1.0 / (1.0 / estimate.trials.max(1.0) + 1.0 / self.confirm as f64);
        Stated {
            share: estimate.share,
            interval: wilson(estimate.share, trials, PROBABILITY),
            effective_points: estimate.effective,
        }
    }
}

fn scaled(distributions: &[Distribution], scales: &[f64]) -> Vec<Distribution> {
    let pairs = distributions.iter().zip(scales);
    pairs.map(|(distribution, &scale)| distribution.scaled(scale)).collect()
}

/// Whether the points tell enough about the tolerances of an estimate to search there.
fn is_known(estimate: Estimate) -> bool {
    estimate.effective >= 0.5 * FEWEST
}
