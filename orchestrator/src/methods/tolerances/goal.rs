//! The goal of the tolerances.

use crate::{
    error::{Error, Result},
    results::table,
};
use conformity::risk::Guard;
use parameter_regions::tolerances::stated::Wanted;
use std::path::Path;
use study::{
    Study,
    judge::{Judge, share},
};

/// A share of accepted points, or a conformance probability.
pub struct Goal<'a> {
    judge: &'a Judge,
    /// Which of both.
    pub wanted: Wanted,
    /// The least share or probability that is required.
    pub target: f64,
    /// With which confidence.
    pub confidence: f64,
    /// The guard band, in expanded uncertainties.
    guard: f64,
}

impl<'a> Goal<'a> {
    /// The study's goal; a guard band that limits a risk is that of the finished study in `from`.
    pub fn new(study: &Study, judge: &'a Judge, from: &Path) -> Result<Self> {
        const USUAL: f64 = 0.95;
        let said = &study.tolerances;
        let required = judge.rule.map(|rule| rule.share);
        let (wanted, stated) = match (&said.share, &said.conformance) {
            (Some(_), Some(both)) => {
                return Err(study.error_at(both, "[tolerances] has both share and conformance; keep one").into());
            }
            (share, None) => (Wanted::Accepted, share),
            (None, conformance) => (Wanted::Conforming, conformance),
        };
        if let (Wanted::Conforming, Some(stated), false) = (wanted, stated, judge.measurement.complete()) {
            return Err(study
                .error_at(
                    stated,
                    "a conformance probability needs the uncertainty of every measured value; add `uncertainty` \
                           to the criteria, or want a `share`",
                )
                .into());
        }
        let target = match stated {
            Some(stated) => share(stated.as_ref()).ok_or_else(|| {
                study.error_at(stated, format!("{} must be more than 0 % and less than 100 %", stated.as_ref()))
            })?,
            None => required.ok_or_else(|| {
                let section = if study.verdict.is_some() { "verdict" } else { "tolerances" };
                study.error_near(
                    section,
                    "it does not say what the tolerances must achieve: add `share` under [verdict], or `share` or \
                     `conformance` under [tolerances], such as \"95 %\"",
                )
            })?,
        };
        Ok(Self {
            judge,
            wanted,
            target,
            confidence: judge.rule.map_or(USUAL, |rule| rule.confidence),
            guard: guard(study, judge, from)?,
        })
    }

    /// How good points are.
    pub fn goods(&self, outcomes: &[Option<Vec<f64>>]) -> Vec<f64> {
        outcomes.iter().map(|one| self.good(one.as_deref())).collect()
    }

    /// How good a point is, from 0 to 1; one that failed is not at all.
    pub fn good(&self, values: Option<&[f64]>) -> f64 {
        let Some(values) = values else { return 0.0 };
        let measurement = &self.judge.measurement;
        match self.wanted {
            Wanted::Accepted => f64::from(u8::from(match self.judge.guard {
                Guard::EachPoint { .. } => self.judge.guard.accepts(measurement.assess(values).all, None),
                _ => measurement.margin(values) >= self.guard,
            })),
            Wanted::Conforming => {
                measurement.assess(values).all.probability.expect("`new` refuses criteria without an uncertainty")
            }
        }
    }
}

fn guard(study: &Study, judge: &Judge, from: &Path) -> Result<f64> {
    let band = match judge.guard {
        Guard::Given(factor) => Some(factor),
        Guard::EachPoint { .. } => Some(0.0),
        Guard::Limiting { .. } => {
            let summary = match table::summary(from) {
                Err(Error::Missing(_)) => None,
                summary => Some(summary?),
            };
            let conclusion =
                summary.filter(|s| s.provenance.study_sha256 == study.digest()).and_then(|summary| summary.conclusion);
            conclusion.and_then(|conclusion| conclusion.guard_band)
        }
    };
    Ok(band.ok_or_else(|| {
        study.error_in(
            "verdict",
            &["risk"],
            "risk sets a guard band from the points of a finished study: verify the study first, or state \
             `guard-band` instead",
        )
    })?)
}
