//! The largest part of the parameter space with a verification probability above a level.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng, rngs::StdRng};
use sampling::statistics::moments::{mean, quantile, sorted};
use sampling::statistics::share::Fraction;
use serde::{Deserialize, Serialize};

/// How many of the study's own points a region holds, and how many of them are verified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Confirmed {
    /// Points inside.
    pub points: usize,
    /// Number of these points that are verified.
    pub verified: usize,
    /// 95 % interval of the verified share.
    pub interval: [f64; 2],
}

impl Confirmed {
    /// Whether the interval holds a stated probability.
    pub fn holds(&self, stated: f64) -> bool {
        self.interval[0] <= stated && stated <= self.interval[1]
    }

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
        Self {
            points,
            verified,
            interval: [share.low, share.high],
        }
    }
}

/// Results of earlier versions have no interval.
pub(super) const fn unknown() -> [f64; 2] {
    [0.0, 1.0]
}

/// A box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Least and greatest value of every parameter.
    pub limits: Vec<[f64; 2]>,
    /// The part of the sampled probability that lies inside.
    pub share: f64,
    /// The part of it that is verified: by the surrogates, corrected by the study's own points.
    pub probability: f64,
    /// Its 95 % interval.
    #[serde(default = "unknown")]
    pub interval: [f64; 2],
    /// Check against the study's own points.
    pub confirmed: Confirmed,
    /// Check against fresh runs, where some were made.
    #[serde(default)]
    pub fresh: Option<Confirmed>,
}

impl Region {
    /// Whether a point lies inside.
    pub fn contains(&self, x: &[f64]) -> bool {
        x.iter()
            .zip(&self.limits)
            .all(|(v, [low, high])| v >= low && v <= high)
    }

    /// Share and probability by a sample and the surrogates alone, as a search needs them.
    pub fn state(&mut self, cloud: &[Vec<f64>], verdicts: &[f64]) {
        (self.share, self.probability) = stated(cloud, verdicts, |x| self.contains(x));
    }

    /// Counts points inside.
    pub fn confirm(&self, points: &[Vec<f64>], verified: &[bool]) -> Confirmed {
        let points = points.iter().zip(verified);
        Confirmed::count(points.filter(|(x, _)| self.contains(x)).map(|(_, v)| *v))
    }
}

/// An ellipsoid: (x - centre)' shape (x - centre) <= 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ellipsoid {
    /// Centre of the ellipsoid.
    pub centre: Vec<f64>,
    /// Matrix of the ellipsoid, row by row.
    pub shape: Vec<Vec<f64>>,
    /// The part of the sampled probability that lies inside.
    pub share: f64,
    /// The part of it that is verified: by the surrogates, corrected by the study's own points.
    pub probability: f64,
    /// Its 95 % interval.
    #[serde(default = "unknown")]
    pub interval: [f64; 2],
    /// Check against the study's own points.
    pub confirmed: Confirmed,
    /// Check against fresh runs, where some were made.
    #[serde(default)]
    pub fresh: Option<Confirmed>,
}

impl Ellipsoid {
    /// Whether a point lies inside.
    pub fn contains(&self, x: &[f64]) -> bool {
        let off: Vec<f64> = x.iter().zip(&self.centre).map(|(a, b)| a - b).collect();
        let sum: f64 = self
            .shape
            .iter()
            .zip(&off)
            .map(|(row, a)| a * row.iter().zip(&off).map(|(s, b)| s * b).sum::<f64>())
            .sum();
        sum <= 1.0
    }

    /// Share and probability by a sample and the surrogates alone, as a search needs them.
    pub fn state(&mut self, cloud: &[Vec<f64>], verdicts: &[f64]) {
        (self.share, self.probability) = stated(cloud, verdicts, |x| self.contains(x));
    }

    /// Counts points inside.
    pub fn confirm(&self, points: &[Vec<f64>], verified: &[bool]) -> Confirmed {
        let points = points.iter().zip(verified);
        Confirmed::count(points.filter(|(x, _)| self.contains(x)).map(|(_, v)| *v))
    }
}

/// The part of a sample that lies inside, and its mean probability.
fn stated(cloud: &[Vec<f64>], verdicts: &[f64], contains: impl Fn(&[f64]) -> bool) -> (f64, f64) {
    let held: Vec<f64> = cloud
        .iter()
        .zip(verdicts)
        .filter(|(x, _)| contains(x))
        .map(|(_, v)| *v)
        .collect();
    (held.len() as f64 / cloud.len() as f64, mean(&held))
}

/// A large sample of the parameter space from the study's points: every parameter from a point of
/// its own, which keeps the distributions and, as they were sampled, their independence.
pub fn cloud(points: &[Vec<f64>], seed: u64) -> Vec<Vec<f64>> {
    const SIZE: usize = 40_000;
    let mut random = StdRng::seed_from_u64(seed);
    let d = points.first().map_or(0, Vec::len);
    let columns: Vec<Vec<f64>> = (0..d)
        .map(|k| sorted(points.iter().map(|p| p[k]).collect()))
        .collect();
    // Between the samples: the smoothed distribution, so that few points do not leave gaps.
    (0..SIZE)
        .map(|_| {
            columns
                .iter()
                .map(|c| quantile(c, random.random::<f64>()))
                .collect()
        })
        .collect()
}

/// The ellipsoid with centre and shape of the verified points, as large as the level allows.
pub fn largest_ellipsoid(cloud: &[Vec<f64>], verdicts: &[f64], level: f64) -> Option<Ellipsoid> {
    const FEWEST: usize = 100;
    let d = cloud.first()?.len();
    let weight: f64 = verdicts.iter().sum();
    if weight <= 0.0 {
        return None;
    }
    let centre = DVector::from_fn(d, |k, _| {
        cloud
            .iter()
            .zip(verdicts)
            .map(|(x, v)| v * x[k])
            .sum::<f64>()
            / weight
    });
    let covariance = DMatrix::from_fn(d, d, |a, b| {
        cloud
            .iter()
            .zip(verdicts)
            .map(|(x, v)| v * (x[a] - centre[a]) * (x[b] - centre[b]))
            .sum::<f64>()
            / weight
    });
    let inverse = covariance.cholesky()?.inverse();
    let distance = |x: &Vec<f64>| {
        let off = DVector::from_fn(d, |k, _| x[k] - centre[k]);
        (off.transpose() * &inverse * off)[0]
    };
    let mut order: Vec<(f64, f64)> = cloud
        .iter()
        .map(distance)
        .zip(verdicts.iter().copied())
        .collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut size) = (0.0, None);
    for (k, (distance, v)) in order.iter().enumerate() {
        sum += v;
        if k + 1 >= FEWEST && sum / (k + 1) as f64 >= level {
            size = Some(*distance);
        }
    }
    let size = size?;
    let mut ellipsoid = Ellipsoid {
        centre: centre.iter().copied().collect(),
        shape: (0..d)
            .map(|a| (0..d).map(|b| inverse[(a, b)] / size).collect())
            .collect(),
        share: 0.0,
        probability: 0.0,
        interval: unknown(),
        confirmed: Confirmed::default(),
        fresh: None,
    };
    ellipsoid.state(cloud, verdicts);
    Some(ellipsoid)
}
