//! The largest part of the parameter space with a verification probability above a level.

use sampling::{
    random::{Purpose, Random},
    statistics::{
        moments::{mean, quantile, sorted},
        share::Fraction,
    },
};
use serde::{Deserialize, Serialize};

/// How many of the study's own points a region holds, and how many of them are verified.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Confirmed {
    /// Points inside.
    pub points: usize,
    /// Number of these points that are verified.
    pub verified: usize,
    /// 95 % interval of the verified share.
    pub interval: [f64; 2],
}

impl Confirmed {
    /// Whether the interval meets a stated one.
    pub fn agrees(&self, [low, high]: [f64; 2]) -> bool {
        self.interval[0] <= high && low <= self.interval[1]
    }

    /// Check of a stated interval against fresh runs.
    pub fn on(&self, [low, high]: [f64; 2]) -> &'static str {
        if self.interval[0] > high {
            "more than stated: the surrogates' errors make the statement cautious"
        } else if self.interval[1] < low {
            "LESS than stated: the surrogates mislead there, verify more points"
        } else {
            "the stated probability holds"
        }
    }

    pub(super) fn count(inside: impl Iterator<Item = bool>) -> Self {
        let (mut points, mut verified) = (0, 0);
        for ok in inside {
            points += 1;
            verified += usize::from(ok);
        }
        let share = Fraction::wilson(verified, points);
        Self { points, verified, interval: [share.low, share.high] }
    }
}

/// A sample of the space, with the probability of verification at each point.
#[derive(Clone, Copy)]
pub struct Sample<'a> {
    /// The points.
    pub points: &'a [Vec<f64>],
    /// Their probabilities.
    pub verdicts: &'a [f64],
}

/// The statement on the verified part of a region.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoxStatement {
    /// The part of the sampled probability that lies inside.
    pub share: f64,
    /// The part of the region that is verified.
    pub probability: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
}

/// A box in the parameter space, and how much of it is verified.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Region {
    /// Least and greatest value of every parameter.
    pub limits: Vec<[f64; 2]>,
    /// The part of the sampled probability that lies inside.
    pub share: f64,
    /// The part of it that is verified: by the surrogates, corrected by the study's own points.
    pub probability: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// Check against the study's own points.
    pub confirmed: Confirmed,
    /// Check against fresh runs, where some were made.
    pub fresh: Option<Confirmed>,
}

impl Region {
    /// A box with share and probability by a sample and the surrogates alone, as a search needs them.
    pub(super) fn new(limits: Vec<[f64; 2]>, sample: &Sample) -> Self {
        let pairs = sample.points.iter().zip(sample.verdicts);
        let inside = pairs.filter(|(x, _)| within(x, &limits));
        let held: Vec<f64> = inside.map(|(_, v)| *v).collect();
        Self {
            limits,
            share: held.len() as f64 / sample.points.len() as f64,
            probability: mean(&held),
            interval: [0.0, 1.0],
            confirmed: Confirmed::default(),
            fresh: None,
        }
    }

    /// Whether a point lies inside.
    pub fn contains(&self, x: &[f64]) -> bool {
        within(x, &self.limits)
    }

    /// Takes over what is stated of it.
    pub(super) fn note(&mut self, statement: BoxStatement) {
        (self.share, self.probability) = (statement.share, statement.probability);
        self.interval = statement.interval;
    }

    /// Counts points inside.
    pub fn confirm(&self, points: &[Vec<f64>], verified: &[bool]) -> Confirmed {
        let points = points.iter().zip(verified);
        Confirmed::count(points.filter(|(x, _)| self.contains(x)).map(|(_, v)| *v))
    }
}

/// Whether a point lies between limits of each parameter.
pub fn within(x: &[f64], limits: &[[f64; 2]]) -> bool {
    let mut sides = x.iter().zip(limits);
    sides.all(|(v, [low, high])| v >= low && v <= high)
}

/// A large sample of the parameter space from the study's points: every parameter from a point of
/// its own, which keeps the distributions and, as they were sampled, their independence.
pub fn cloud(points: &[Vec<f64>], seed: u64) -> Vec<Vec<f64>> {
    const SIZE: usize = 40_000;
    let mut random = Random::new(seed, Purpose::Between, 0);
    let d = points.first().map_or(0, Vec::len);
    let columns: Vec<Vec<f64>> = (0..d).map(|k| sorted(points.iter().map(|p| p[k]).collect())).collect();
    // Between the samples: the smoothed distribution, so that few points do not leave gaps.
    (0..SIZE).map(|_| columns.iter().map(|c| quantile(c, random.unit())).collect()).collect()
}
