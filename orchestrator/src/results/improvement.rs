//! Improvements by their effect: how verdict and risks would change if one measured value's uncertainty, or one parameter's
//! tolerance, were half of what it is.
//!
//! Nothing is simulated again. Another uncertainty changes only how the same points are judged; another tolerance
//! changes how probable they are, which importance weights tell (Owen 2013, "Monte Carlo theory, methods and examples",
//! chapter 9). The effective number of points says how much the weights leave of the sample.

use serde::{Deserialize, Serialize};

use super::Row;
use crate::judge::Judge;
use conformity::decision::Decision;
use conformity::gain::{self, Pair};
use conformity::interval::clopper_pearson;
use conformity::measured::Assessed;
use conformity::risk::Guard;
use sampling::distribution::Distribution;
use study::plan::Plan;

/// So many points tell enough; of a larger study the first ones are taken. With many criteria they are fewer, as each of them
/// is judged once for each criterion.
pub(super) fn most_points(criteria: usize) -> usize {
    const MOST: usize = 4096;
    const MOST_VALUES: usize = 1 << 20;
    const FEWEST: usize = 100;
    (MOST_VALUES / criteria.max(1)).clamp(FEWEST, MOST)
}

/// The confidence of intervals where the study requires none.
const USUAL: f64 = 0.95;

/// The changes, and what they are compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Improvements {
    /// How many of the study's first points were used.
    pub points: u64,
    /// As it is, by the same points.
    pub now: Prospect,
    /// One change at a time: first the gains that are more than chance, the surest first; then those that may be 0; last
    /// the losses.
    pub changes: Vec<Change>,
}

/// One change and what it leads to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// The uncertainty or tolerance that is halved.
    pub halved: Halved,
    /// The criterion, or the parameter.
    pub name: String,
    /// By how much the probability grows that a point is accepted and conforms; where an uncertainty is not known, that
    /// it is accepted.
    pub gain: f64,
    /// The interval of the gain, from the difference at each point. All intervals of a study hold together with 95 %. None
    /// of points that are no sample, such as those of a grid.
    pub gain_interval: Option<[f64; 2]>,
    /// Verdict and risks that would follow.
    #[serde(flatten)]
    pub prospect: Prospect,
}

/// A gain against chance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sign {
    /// It is a loss.
    Loss,
    /// The points don't tell it from 0.
    Open,
    /// It is a gain.
    Gain,
}

impl Change {
    /// Whether the points tell the gain from 0.
    pub fn sign(&self) -> Sign {
        match self.gain_interval {
            Some([low, _]) if low > 0.0 => Sign::Gain,
            Some([_, high]) if high < 0.0 => Sign::Loss,
            _ => Sign::Open,
        }
    }
}

/// The uncertainty or tolerance that is halved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Halved {
    /// The uncertainty of a measured value.
    Uncertainty,
    /// The tolerance of a parameter: the spread of its distribution.
    Tolerance,
}

/// Shares of the points and what follows from them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prospect {
    /// The share of accepted points.
    pub accepted: f64,
    /// Its interval, with the confidence that the study requires, or 95 %; none of points that are no sample.
    pub interval: Option<[f64; 2]>,
    /// That a point conforms; none unless every criterion has an uncertainty. So the following ones.
    pub conformance_probability: Option<f64>,
    /// That a point is accepted and does not conform.
    pub consumer: Option<f64>,
    /// That a point is rejected and conforms.
    pub producer: Option<f64>,
    /// That an accepted point does not conform; none where nothing is accepted.
    pub not_conforming_given_accepted: Option<f64>,
    /// The verdict; only where a share is required.
    pub verdict: Option<Decision>,
    /// The effective sample size.
    pub effective_points: f64,
}

impl Prospect {
    /// What is to be large: points that are accepted and conform, or accepted ones where it is not known how many conform.
    pub fn worth(&self) -> &'static str {
        match self.conformance_probability {
            Some(_) => "probability that a point is accepted and conforms",
            None => "share of accepted points",
        }
    }
}

impl Improvements {
    /// The same without intervals and the verdicts that rest on them, of points that depend on each other.
    pub(super) fn without_intervals(mut self) -> Self {
        let prospects = self.changes.iter_mut().map(|change| {
            change.gain_interval = None;
            &mut change.prospect
        });
        for prospect in prospects.chain([&mut self.now]) {
            (prospect.interval, prospect.verdict) = (None, None);
        }
        self
    }
}

/// A point as the changes see it: its weight, and what the measurement says of it.
#[derive(Clone, Copy)]
struct Seen {
    weight: f64,
    margin: f64,
    conforms: Option<f64>,
}

impl Seen {
    fn new(assessed: Assessed) -> Self {
        Self { weight: 1.0, margin: assessed.margin, conforms: assessed.probability }
    }
}

/// The improvements by points given as parameters and values; `None` where a point failed. Without a plan, or where
/// the parameters are correlated, only the measured values' uncertainties are looked at.
pub(super) fn improvements(judge: &Judge, plan: Option<&Plan>, points: &[Row]) -> Option<Improvements> {
    if points.len() < 2 {
        return None;
    }
    // Means over so many points need no exact probability of each.
    let measurement = judge.measurement.clone().roughly();
    let failed = Assessed { margin: f64::NEG_INFINITY, probability: measurement.complete().then_some(0.0) };
    let of = |values: &Option<Vec<f64>>| {
        let all = values.as_ref().map(|values| measurement.assess(values).all);
        Seen::new(all.unwrap_or(failed))
    };
    let base: Vec<Seen> = points.iter().map(|(_, values)| of(values)).collect();
    let now = prospect(judge, &base);
    let mut halved: Vec<Vec<Seen>> = vec![Vec::new(); judge.criteria.len()];
    for (_, values) in points {
        let each = values.as_ref().map(|values| measurement.with_other_uncertainty(values, 0.5));
        for (k, seen) in halved.iter_mut().enumerate() {
            seen.push(Seen::new(each.as_ref().map_or(failed, |each| each[k])));
        }
    }
    let mut halvings: Vec<(Halved, String, Vec<Seen>)> = Vec::new();
    let criteria = judge.names().zip(measurement.criteria());
    for (k, ((name, measured), seen)) in criteria.zip(halved).enumerate() {
        // An error that follows from others has no uncertainty of its own to halve.
        if measured.error.is_none() || judge.criteria[k].derived_from.is_some() {
            continue;
        }
        let seen = match judge.with_half_uncertainty(k) {
            Some(measurement) => {
                let measurement = measurement.roughly();
                let all = |values: &Vec<f64>| measurement.assess(values).all;
                let each = points.iter().map(|(_, values)| values.as_ref().map_or(failed, all));
                each.map(Seen::new).collect()
            }
            None => seen,
        };
        halvings.push((Halved::Uncertainty, name.clone(), seen));
    }
    if let Some(plan) = plan.filter(|plan| plan.correlation.is_none()) {
        for k in plan.with_tolerances() {
            let input = &plan.inputs[k];
            let seen = reweighted(&base, points, k, &input.distribution);
            halvings.push((Halved::Tolerance, input.name.clone(), seen));
        }
    }
    // All intervals hold together (Bonferroni): of many changes without effect one would seem to gain otherwise.
    let confidence = 1.0 - (1.0 - USUAL) / halvings.len().max(1) as f64;
    let worth = worths(judge, &base);
    let change = |(halved, name, seen): (Halved, String, Vec<Seen>)| {
        let changed = worths(judge, &seen);
        let pairs = seen.iter().zip(changed.iter().zip(&worth));
        let pairs: Vec<Pair> =
            pairs.map(|(seen, (&changed, &now))| Pair { weight: seen.weight, changed, now }).collect();
        let prospect = prospect(judge, &seen);
        let total = |p: &Prospect| p.accepted - p.consumer.unwrap_or(0.0);
        Change {
            halved,
            name,
            gain: total(&prospect) - total(&now),
            gain_interval: Some(gain::interval(&pairs, confidence)),
            prospect,
        }
    };
    let mut changes: Vec<Change> = halvings.into_iter().map(change).collect();
    changes.sort_by(|a, b| {
        let low = |change: &Change| change.gain_interval.map_or(change.gain, |[low, _]| low);
        let surest = low(b).total_cmp(&low(a));
        b.sign().cmp(&a.sign()).then(surest)
    });
    (!changes.is_empty()).then_some(Improvements { points: points.len() as u64, now, changes })
}

/// The same points with the weights that half the tolerance of a parameter gives them.
fn reweighted(base: &[Seen], points: &[Row], k: usize, wide: &Distribution) -> Vec<Seen> {
    let narrow = wide.scaled(0.5);
    let weighted = base.iter().zip(points).map(|(seen, (parameters, _))| {
        let value = parameters[k];
        Seen { weight: (narrow.ln_density(value) - wide.ln_density(value)).exp(), ..*seen }
    });
    weighted.collect()
}

/// The worth of each point: the probability that it is accepted and conforms.
fn worths(judge: &Judge, points: &[Seen]) -> Vec<f64> {
    let accepts = acceptance(judge.guard, points);
    let worth = |point: &Seen| {
        if accepts(point) { point.conforms.unwrap_or(1.0) } else { 0.0 }
    };
    points.iter().map(worth).collect()
}

/// Verdict and risks over weighted points.
fn prospect(judge: &Judge, points: &[Seen]) -> Prospect {
    let accepts = acceptance(judge.guard, points);
    let accepted = |point: &&Seen| accepts(point);
    let sum = |of: &dyn Fn(&Seen) -> f64| points.iter().map(|p| p.weight * of(p)).sum::<f64>();
    let all = sum(&|_| 1.0).max(f64::MIN_POSITIVE);
    let effective = all * all / sum(&|p| p.weight).max(f64::MIN_POSITIVE);
    let share = points.iter().filter(accepted).map(|p| p.weight).sum::<f64>() / all;
    let known = points.iter().all(|p| p.conforms.is_some());
    let conforming = |p: &Seen| p.conforms.unwrap_or(0.0);
    let consumer = sum(&|p| {
        if accepted(&p) { 1.0 - conforming(p) } else { 0.0 }
    }) / all;
    let producer = sum(&|p| if accepted(&p) { 0.0 } else { conforming(p) }) / all;
    let confidence = judge.rule.map_or(USUAL, |rule| rule.confidence);
    let interval = clopper_pearson(share * effective, effective, confidence);
    Prospect {
        accepted: share,
        interval: Some(interval),
        conformance_probability: known.then(|| sum(&conforming) / all),
        consumer: known.then_some(consumer),
        producer: known.then_some(producer),
        not_conforming_given_accepted: (known && share > 0.0).then(|| consumer / share),
        verdict: judge.rule.map(|rule| rule.decide(interval)),
        effective_points: effective,
    }
}

/// Which points are accepted.
fn acceptance(guard: Guard, points: &[Seen]) -> impl Fn(&Seen) -> bool {
    let least = least_margin(guard, points);
    move |&Seen { margin, conforms, .. }| match guard {
        Guard::EachPoint { .. } => guard.accepts(Assessed { margin, probability: conforms }, None),
        _ => margin >= least,
    }
}

/// The least margin with which a point is accepted, where that is enough.
fn least_margin(guard: Guard, points: &[Seen]) -> f64 {
    let risk = match guard {
        Guard::Given(factor) => return factor,
        Guard::EachPoint { .. } => return 0.0,
        Guard::Limiting { risk } => risk,
    };
    let mut within: Vec<&Seen> = points.iter().filter(|p| p.margin >= 0.0).collect();
    within.sort_by(|a, b| b.margin.total_cmp(&a.margin));
    let (mut weight, mut wrong, mut least) = (0.0, 0.0, f64::INFINITY);
    for point in within {
        weight += point.weight;
        wrong += point.weight * (1.0 - point.conforms.unwrap_or(0.0));
        if wrong <= risk * weight {
            least = point.margin;
        }
    }
    least
}
