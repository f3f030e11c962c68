//! The data from which the page judges its points anew: criteria, rule and distributions, with all their digits.

use crate::results::{Summary, summary::CriterionCount};
use conformity::{
    measured::Limits,
    uncertainty::{Law, Uncertainty},
};
use serde::Serialize;
use study::{Study, judge::share};

/// The study as the page's script changes it.
#[derive(Clone, Debug, Serialize)]
pub struct WhatIf {
    /// Randomisations of the design to which the points belong in turn.
    samples: u64,
    /// Whether the points are no sample, so that shares have no interval.
    grid: bool,
    /// Whether the study was looked at more than once, so that a verdict from one look is too sure.
    looked_again: bool,
    /// The rule of the verdict; none where one point is enough.
    rule: Option<Rule>,
    criteria: Vec<Criterion>,
    /// Whether the criteria are those of cases, with the names `CASE/NAME`.
    cases: bool,
    /// Which measured values' errors are correlated, by the criteria's numbers.
    correlations: Vec<(usize, usize, f64)>,
    /// The parameters' distributions as `summary.json` has them.
    parameters: Vec<serde_json::Map<String, serde_json::Value>>,
    /// Why no other distributions of the parameters can be asked for, where that is so.
    fixed: Option<&'static str>,
    /// The study as it was run, to be changed.
    text: String,
}

#[derive(Clone, Debug, Serialize)]
struct Rule {
    share: f64,
    confidence: f64,
    /// The guard band in expanded uncertainties, where the study gives it.
    #[serde(skip_serializing_if = "Option::is_none")]
    band: Option<f64>,
    /// The largest probability that an accepted point does not conform, where that sets the guard band.
    #[serde(skip_serializing_if = "Option::is_none")]
    risk: Option<f64>,
}

#[derive(Clone, Debug, Serialize)]
struct Criterion {
    name: String,
    unit: String,
    /// The measured value, or the limit that stands alone.
    nominal: f64,
    /// How far down and up from there values are accepted; none where there is no such limit.
    minus: Option<f64>,
    plus: Option<f64>,
    /// Of a limit without a measured value: the scale of distances from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit_of_distance: Option<f64>,
    uncertainty: Option<Uncertain>,
    /// Whether its error follows from those of others.
    derived: bool,
    group: Option<String>,
    /// Whether it is that of a whole curve, whose measured values are no number to change.
    curve: bool,
}

#[derive(Clone, Debug, Serialize)]
struct Uncertain {
    expanded: f64,
    coverage: f64,
    /// Where the error is not normal, its distribution with an expanded uncertainty of 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    law: Option<Law>,
    /// The parts that the study states, by their keys, in the criterion's unit.
    parts: Vec<(&'static str, f64)>,
}

impl WhatIf {
    /// The study of a summary; `study` is its text, as far as it could be read, `shown` the number of points in the page's
    /// table. None where the rule is not known, or the table is no fair choice of the points.
    pub fn new(summary: &Summary, study: Option<&Study>, shown: usize) -> Option<Self> {
        if summary.points > shown as u64 {
            return None;
        }
        // Without a measured value there is nothing to judge by, and points that were chosen stand for no share.
        if summary.has_own_values() || summary.surrogate.is_some() {
            return None;
        }
        let required = summary.conclusion.as_ref()?.required.as_ref();
        let rule = match required {
            None => None,
            Some(required) => {
                let stated = study?.verdict.as_ref()?.as_ref();
                // The page knows guard bands only.
                if stated.point_risk.is_some() {
                    return None;
                }
                let risk = stated.risk.as_ref();
                let risk = risk.and_then(|risk| share(risk.as_ref()));
                let band = stated.guard_band.as_ref().map_or(0.0, |band| *band.as_ref());
                Some(Rule {
                    share: required.rule.share,
                    confidence: required.rule.confidence,
                    band: risk.is_none().then_some(band),
                    risk,
                })
            }
        };
        let correlations = summary.uncertainty_correlations.iter().map(|entry| {
            let [a, b] = entry.between.each_ref().map(|name| summary.criteria.get_index_of(name));
            Some((a?, b?, entry.coefficient))
        });
        let parameters = summary.parameters.iter();
        Some(Self {
            samples: summary.provenance.replicates.unwrap_or(1).max(1),
            grid: summary.verified_interval.is_none(),
            looked_again: required.is_some_and(|r| r.looks > 1 || r.method.contains("look")),
            rule,
            criteria: summary.criteria.iter().map(criterion).collect(),
            cases: !summary.cases.is_empty(),
            correlations: correlations.collect::<Option<_>>()?,
            parameters: parameters.map(|p| p.distribution.clone()).collect(),
            fixed: fixed(summary, study),
            text: study.map(|study| study.text().to_owned()).unwrap_or_default(),
        })
    }

    /// The points that the page holds are a choice, in no order of the design: of nets nothing tells any more which belong
    /// together.
    pub fn of_some(mut self) -> Self {
        self.grid |= self.samples > 1;
        self.samples = 1;
        self
    }
}

fn criterion((name, count): (&String, &CriterionCount)) -> Criterion {
    let criterion = &count.criterion;
    let Limits { about, minus, plus } = criterion.limits;
    let [minus, plus] = [minus, plus].map(|side| Some(side).filter(|side| side.is_finite()));
    let uncertain = |(stated, law): (Uncertainty, Law)| Uncertain {
        expanded: law.expanded,
        coverage: stated.coverage,
        law: (!law.is_normal()).then(|| law.times(1.0 / law.expanded)),
        parts: stated.parts(),
    };
    Criterion {
        name: name.clone(),
        unit: criterion.unit.clone().unwrap_or_default(),
        nominal: about,
        minus,
        plus,
        unit_of_distance: criterion.distance_unit,
        derived: criterion.derived_from.is_some(),
        uncertainty: criterion.uncertainty.zip(criterion.measured().error).map(uncertain),
        group: criterion.group.clone(),
        curve: criterion.metric.is_some(),
    }
}

/// Weights need points that were drawn from the stated distributions, each parameter on its own.
fn fixed(summary: &Summary, study: Option<&Study>) -> Option<&'static str> {
    let method = summary.provenance.method.as_str();
    if summary.parameters.is_empty() || method == "table" {
        return Some("the points come from a table, whose distributions are not known");
    }
    if summary.verified_interval.is_none() || summary.provenance.replicates.is_some() {
        return Some("the points depend on each other, so that nothing tells the error of a weighted share");
    }
    match study {
        None => Some("the study's text cannot be read"),
        Some(study) if !study.correlations.is_empty() => {
            Some("the parameters are correlated, and weights of one would change the others")
        }
        Some(_) => None,
    }
}
