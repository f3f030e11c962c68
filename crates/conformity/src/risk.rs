//! Global risks over the points of a study, and the guard band that limits them.
//!
//! Points stand for parameter sets that manufacturing leaves open; each is accepted or rejected by
//! the measured values. *Global* risks are joint over points and the measured values' errors
//! (JCGM 106:2012, 9.5): the consumer's that a point is accepted and does not conform, the
//! producer's that it is rejected and conforms.

use serde::{Deserialize, Serialize};

use super::{
    interval::Moments,
    measured::{Assessed, Conformity, Measured, Measurement},
};
use acceptance::Acceptance;

pub use bands::Bands;

mod acceptance;
mod bands;

/// How far the acceptance interval is drawn in from the tolerance interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guard {
    /// By this multiple of each criterion's expanded uncertainty; 0 is simple acceptance.
    Given(f64),
    /// By the smallest multiple of which the points show that it keeps the probability of an accepted point not to conform
    /// at or below `risk`.
    Limiting {
        /// The largest probability.
        risk: f64,
    },
    /// As far as it takes at each point: one is accepted if the probability that it does not conform is at or below `risk`
    /// (ISO 14253-1: 5 %).
    EachPoint {
        /// The largest probability.
        risk: f64,
    },
}

impl Guard {
    /// Guard bands are looked for in these steps, in expanded uncertainties.
    const STEP: f64 = 1e-3;
    /// Margins above this many steps count as equal.
    const MOST_STEPS: f64 = 1e4;

    /// Whether a model value can be accepted at all: a guard band as wide as a tolerance leaves nothing
    /// of it.
    pub fn leaves_something(self, measurement: &Measurement) -> bool {
        let mut criteria = measurement.criteria().iter();
        criteria.all(|criterion| match self {
            Self::Given(factor) => factor == 0.0 || criterion.largest_margin() > factor,
            Self::Limiting { .. } => true,
            Self::EachPoint { risk } => {
                criterion.most_not_conforming(criterion.largest_margin()).is_some_and(|least| least <= risk)
            }
        })
    }

    /// Whether a point is accepted; `band` is the guard band that limits the risk (see [`RiskStatement::guard`]).
    pub fn accepts(self, point: Assessed, band: Option<f64>) -> bool {
        let from = match self {
            Self::Given(_) | Self::EachPoint { .. } => 0,
            // A multiple of the step, but for rounding.
            Self::Limiting { .. } => match band {
                Some(factor) => (factor / Self::STEP).round() as usize,
                None => return false,
            },
        };
        self.widest_passed(point).is_some_and(|step| step >= from)
    }

    /// The number of the widest guard band, of those that come into question, that lets a point
    /// pass.
    fn widest_passed(self, Assessed { margin, probability }: Assessed) -> Option<usize> {
        match self {
            Self::Given(factor) => (margin >= factor).then_some(0),
            Self::Limiting { .. } => {
                let steps = (margin / Self::STEP).min(Self::MOST_STEPS);
                (steps >= 0.0).then_some(steps as usize)
            }
            Self::EachPoint { risk } => {
                (margin >= 0.0 && probability.is_some_and(|conforms| conforms >= 1.0 - risk)).then_some(0)
            }
        }
    }
}

/// The global risks of a decision rule, with their 95 % intervals from the sample of points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Risk {
    /// R_C, that a point is accepted and does not conform.
    pub consumer: f64,
    /// R_P, that a point is rejected and conforms.
    pub producer: f64,
    /// The probability that a point conforms.
    pub conformance_probability: f64,
    /// The probability that an accepted point does not conform; none where no point is accepted.
    pub not_conforming_given_accepted: Option<f64>,
    /// Their intervals; none of points that depend on each other.
    pub intervals: Option<RiskIntervals>,
}

/// The intervals of the numbers in [`Risk`], which have the same names.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct RiskIntervals {
    pub consumer: [f64; 2],
    pub producer: [f64; 2],
    pub conformance_probability: [f64; 2],
    pub not_conforming_given_accepted: [f64; 2],
}

/// Why a measurement cannot decide on any point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unfit {
    /// Whatever the guard band, more of the accepted points do not conform than may.
    Risk {
        /// The largest probability that may be.
        limit: f64,
        /// The least probability that a guard band comes to.
        least: f64,
    },
    /// The guard band is as wide as a tolerance.
    Guard,
    /// No value conforms as surely as each accepted point must.
    Point {
        /// The largest probability not to conform that may be.
        limit: f64,
    },
}

/// Result over all points.
#[derive(Clone, Debug, PartialEq)]
pub struct RiskStatement {
    /// The guard band in expanded uncertainties; none where the points show of none that it limits the risk as wanted, and
    /// nothing is accepted.
    pub guard: Option<f64>,
    /// Points that are accepted: within all tolerances less the guard bands.
    pub accepted: u64,
    /// The same for each of the independent samples.
    pub accepted_by_sample: Vec<u64>,
    /// The guard bands that may be the right one for the whole population, with what they accept.
    pub bands: Bands,
    /// Why no point can be accepted, although some are within all tolerances.
    pub unfit: Option<Unfit>,
    /// Points within all tolerances, whatever the guard band, for each of the independent samples.
    pub within_by_sample: Vec<u64>,
    /// How many points are expected to conform.
    pub expected_conforming: Option<f64>,
    /// Risks of each criterion alone, where its uncertainty is known.
    pub criteria: Vec<Option<Risk>>,
    /// Risks of all criteria together, where all uncertainties are known.
    pub all: Option<Risk>,
}

/// Sums up points one by one, in constant memory.
#[derive(Clone, Debug)]
pub struct RiskTally {
    guard: Guard,
    /// Whether the guard band leaves anything of the tolerances.
    possible: bool,
    samples: usize,
    points: u64,
    within: Vec<u64>,
    measured: Vec<Measured>,
    criteria: Vec<Acceptance>,
    all: Acceptance,
}

impl RiskTally {
    /// No points yet of `samples` independent samples, to which the points belong in turn.
    ///
    /// A guard band can only be found while every criterion has an uncertainty; otherwise nothing is
    /// accepted.
    pub fn new(measurement: &Measurement, guard: Guard, samples: u64) -> Self {
        let samples = usize::try_from(samples).unwrap_or(1).max(1);
        let count = measurement.criteria().len();
        let known = (0..count).map(|criterion| measurement.knows(criterion));
        let knows_all = count > 0 && known.clone().all(|known| known);
        Self {
            guard,
            possible: guard.leaves_something(measurement),
            samples,
            points: 0,
            within: vec![0; samples],
            measured: measurement.criteria().to_vec(),
            criteria: known.map(|known| Acceptance::new(samples, known)).collect(),
            all: Acceptance::new(samples, knows_all),
        }
    }

    /// Takes a point; `None` is one that failed, which is never accepted and does not conform.
    pub fn add(&mut self, point: Option<&Conformity>) {
        let sample = (self.points % self.samples as u64) as usize;
        self.points += 1;
        let failed = Assessed { margin: f64::NEG_INFINITY, probability: Some(0.0) };
        for (k, acceptance) in self.criteria.iter_mut().enumerate() {
            let assessed = point.map_or(failed, |point| point.criteria[k]);
            acceptance.add(self.guard, sample, assessed);
        }
        let assessed = point.map_or(failed, |point| point.all);
        self.within[sample] += u64::from(assessed.margin >= 0.0);
        self.all.add(self.guard, sample, assessed);
    }

    /// The result over the points so far; what their guard band limits, it limits with 95 %.
    pub fn statement(&self) -> RiskStatement {
        self.statement_at(0.95)
    }

    /// The same with another confidence of the guard band.
    pub fn statement_at(&self, confidence: f64) -> RiskStatement {
        self.stated(Some(confidence))
    }

    /// The same of points that are no sample: no intervals, and a guard band that is enough for any points.
    pub fn statement_of_no_sample(&self) -> RiskStatement {
        let mut statement = self.stated(None);
        statement.criteria.iter_mut().chain([&mut statement.all]).flatten().for_each(|risk| risk.intervals = None);
        statement
    }

    fn stated(&self, confidence: Option<f64>) -> RiskStatement {
        let any_within = self.within.iter().any(|&n| n > 0);
        let given = match self.guard {
            Guard::Given(factor) => Some(factor),
            Guard::EachPoint { .. } => Some(0.0),
            // Where there is nothing to accept, no guard band is needed.
            Guard::Limiting { .. } if !any_within => Some(0.0),
            Guard::Limiting { .. } => None,
        };
        let allowed = match self.guard {
            Guard::Limiting { risk } if given.is_none() && self.all.known => {
                Some(bands::allowed(&self.all, &self.measured, risk, confidence))
            }
            _ => None,
        };
        let widest = allowed.as_ref().map(|bands| bands.factors[1]);
        let guard = given.or(widest.filter(|factor| factor.is_finite()));
        let from = match (self.guard, guard) {
            (Guard::Limiting { .. }, Some(factor)) => (factor / Guard::STEP).round() as usize,
            (_, Some(_)) => 0,
            (_, None) => usize::MAX,
        };
        let parts = self.all.split(from);
        let [accepted, rejected] = parts.each_ref().map(|parts| Moments::total(parts));
        let conforming = accepted.complement().sum + rejected.complement().sum;
        let accepted_by_sample: Vec<u64> = parts[0].iter().map(|part| part.count).collect();
        let bands = allowed.unwrap_or_else(|| Bands::one(guard.unwrap_or(f64::INFINITY), &accepted_by_sample));
        RiskStatement {
            guard,
            accepted: accepted.count,
            accepted_by_sample,
            bands,
            unfit: self.unfit(any_within, accepted.count),
            within_by_sample: self.within.clone(),
            expected_conforming: self.all.known.then_some(conforming),
            criteria: self.criteria.iter().map(|c| c.risk(from)).collect(),
            all: self.all.risk(from),
        }
    }

    fn unfit(&self, any_within: bool, accepted: u64) -> Option<Unfit> {
        match self.guard {
            Guard::Limiting { risk } if any_within && (!self.all.known || self.all.least_risk() > risk) => {
                Some(Unfit::Risk { limit: risk, least: self.all.least_risk() })
            }
            Guard::Given(_) if any_within && accepted == 0 && !self.possible => Some(Unfit::Guard),
            Guard::EachPoint { risk } if any_within && accepted == 0 && !self.possible => {
                Some(Unfit::Point { limit: risk })
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod bands_tests;

#[cfg(test)]
mod tests;

#[cfg(test)]
mod truth_tests;
