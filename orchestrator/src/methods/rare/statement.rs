//! The result of a search for a rare share: as numbers for `rare.json`, and for people.

use indexmap::IndexMap;
use serde::Serialize;

use super::RareEvent;
use crate::session::Session;
use conformity::decision::{Decision, Rule};
use conformity::interval::clopper_pearson;
use result_document::Document;
use result_document::format::number;
use sampling::rare::{Answer, Method, Plain, Search};

const USUAL: f64 = 0.95;

/// The probability with which the interval of the share shall hold it. The verdict on a share of not conforming points
/// needs the share of failed runs, too, so each of both has half of the probability of a wrong verdict.
pub(super) fn confidence(event: RareEvent, rule: Option<Rule>) -> f64 {
    match (event, rule) {
        (RareEvent::NotConforming, Some(rule)) => 0.5 + 0.5 * rule.confidence,
        (_, Some(rule)) => rule.confidence,
        (_, None) => USUAL,
    }
}

/// A region of the event.
#[derive(Debug, Serialize)]
struct Region {
    share: f64,
    /// Its point that is nearest to the mean of all: parameters in the study's units.
    centre: IndexMap<String, f64>,
}

/// A level on the way to the event.
#[derive(Debug, Serialize)]
struct Level {
    /// The largest deviation in its tolerance.
    deviation: f64,
    /// The share of the space that reaches it, roughly.
    share: f64,
}

/// Counts among plain points.
#[derive(Debug, Serialize)]
struct Counted {
    runs: u64,
    met: u64,
    failed: u64,
    /// The interval of the share of failed runs.
    failed_interval: [f64; 2],
}

/// The statement.
#[derive(Debug, Serialize)]
pub(super) struct Statement {
    event: RareEvent,
    share: Option<f64>,
    /// Holds the share with the probability `confidence`.
    interval: [f64; 2],
    confidence: f64,
    relative_error: Option<f64>,
    effective: Option<f64>,
    method: &'static str,
    /// A number without an interval, where the share could not be told.
    rough: Option<f64>,
    /// The results of the draws and of the levels, where they do not agree.
    disagree: Option<[f64; 2]>,
    runs: u64,
    plain: Counted,
    /// Draws wider than the study's distribution, and how many of them met the event.
    wider: [u64; 2],
    levels: Vec<Level>,
    regions: Vec<Region>,
    /// The assumptions of the interval.
    assumes: &'static str,
    /// The share of verified points that the study requires.
    required: Option<f64>,
    pub(super) verdict: Option<Decision>,
}

impl Statement {
    pub(super) fn new(event: RareEvent, search: &Search, answer: &Answer, session: &Session) -> Self {
        let Search { confidence, .. } = *search;
        let Plain { runs, met, failed } = answer.plain;
        let of_plain = |count: u64| clopper_pearson(count as f64, runs as f64, confidence);
        let share = answer.share.as_ref();
        let interval = share.and_then(|share| share.interval).unwrap_or_else(|| of_plain(met));
        let rule = session.judge.rule;
        let failed_interval = of_plain(failed);
        let plan = &session.plan;
        let centre = |scores: &[f64]| {
            let values = plan.at_scores(scores);
            let names = plan.inputs.iter().map(|input| input.name.clone());
            names.zip(values).collect()
        };
        let sign = if event == RareEvent::NotConforming { -1.0 } else { 1.0 };
        Self {
            event,
            share: share.map(|share| share.value),
            interval,
            confidence,
            relative_error: share.map(|share| share.error),
            effective: share.map(|share| share.effective),
            method: match share.map(|share| share.method) {
                Some(Method::Counted) => "counted",
                Some(Method::Weighted) => "weighted draws",
                Some(Method::Bridged) => "weighted draws and searches",
                None => "not reached",
            },
            rough: answer.rough,
            disagree: answer.disagree,
            runs: answer.runs,
            plain: Counted { runs, met, failed, failed_interval },
            wider: [answer.wider.runs, answer.wider.met],
            levels: answer.levels.iter().map(|&(level, share)| Level { deviation: sign * level, share }).collect(),
            regions: answer
                .regions
                .iter()
                .map(|region| Region { share: region.share, centre: centre(&region.centre) })
                .collect(),
            assumes: match share.map(|share| share.method) {
                Some(Method::Counted) | None => "Plain points are counted, so the interval assumes nothing",
                Some(_) => {
                    "The interval holds if the searches reached all regions of the event; nothing shows regions that none of \
                     them reached, so a verdict takes from plain points how large the share may be"
                }
            },
            required: rule.map(|rule| rule.share),
            verdict: rule.map(|rule| {
                // That there is no more of the event than was found, only plain points show.
                let sure = [interval[0], interval[1].max(of_plain(met)[1])];
                rule.decide(verified(event, sure, failed_interval))
            }),
        }
    }

    /// The statement for people.
    pub(super) fn document(&self) -> Document {
        let mut told = Document::new("rare", "Rare", "A share that is too small to be counted");
        let event = sampling::word(&self.event).replace('-', " ");
        let percent = number(100.0 * self.confidence, 4);
        let [low, high] = self.interval.map(|end| number(end, 3));
        let Counted { runs, met, failed, failed_interval } = &self.plain;
        match self.share {
            Some(share) => told.say(format!(
                "{event}: {} of the space in the regions that were found, {percent} % interval {low} to {high} ({})",
                number(share, 3),
                self.method
            )),
            None => {
                told.say(format!(
                    "{event}: not told; {met} of {runs} plain points, which shows a share of at most {high} ({percent} %)"
                ));
                self.say_why_not(&mut told);
            }
        }
        told.say(match self.effective {
            Some(effective) => {
                format!("{} runs, an effective sample size of {effective:.0} points of the event", self.runs)
            }
            None => format!("{} runs", self.runs),
        });
        for (k, region) in self.regions.iter().enumerate() {
            let centre = region.centre.iter();
            let centre = centre.map(|(name, value)| format!("{name} {}", number(*value, 4)));
            told.say(format!(
                "region {}: {} near {}",
                k + 1,
                number(region.share, 3),
                centre.collect::<Vec<_>>().join(", ")
            ));
        }
        if self.event != RareEvent::Failed {
            let [low, high] = failed_interval.map(|end| number(end, 3));
            told.say(format!(
                "{failed} of {runs} plain runs failed (share {low} to {high}); they count as neither verified nor not conforming"
            ));
        }
        told.say(format!("{}.", self.assumes));
        if let (Some(required), Some(verdict)) = (self.required, self.verdict) {
            let required = number(required, 4);
            told.say(format!("{verdict}: a share of {required} must be verified"));
        }
        told
    }

    /// How far the search came, where it did not reach the event.
    fn say_why_not(&self, told: &mut Document) {
        if let Some([one, other]) = self.disagree.map(|both| both.map(|share| number(share, 2))) {
            told.say(format!(
                "The draws came to {one} and the levels to {other} and do not agree, so a part of the event may be lost. More \
                 --points may tell."
            ));
        } else if let Some(rough) = self.rough {
            told.say(format!(
                "The search came to about {}, without an interval: the last search still came upon new parts of the event, or \
                 the draws scatter too much. More --points may tell.",
                number(rough, 2)
            ));
        } else if let Some(deepest) = self.levels.last() {
            told.say(format!(
                "The search stopped at points within {} tolerances, a share of about {}. More --points go deeper, unless the \
                 outputs are flat there.",
                number(deepest.deviation, 4),
                number(deepest.share, 2)
            ));
        }
        let [drawn, met] = self.wider;
        if drawn > 0 {
            told.say(format!("{met} of {drawn} runs drawn wider than the study's distribution met the event"));
        }
    }
}

/// The interval of the share of verified points that follows from that of the event.
fn verified(event: RareEvent, [low, high]: [f64; 2], failed: [f64; 2]) -> [f64; 2] {
    match event {
        RareEvent::Verified => [low, high],
        RareEvent::NotConforming => [(1.0 - high - failed[1]).max(0.0), 1.0 - low - failed[0]],
        // A run that ends may still miss a criterion.
        RareEvent::Failed => [0.0, 1.0 - low],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_verdict_on_points_that_do_not_conform_counts_failures_as_not_verified() {
        let shares = verified(RareEvent::NotConforming, [1e-6, 2e-6], [0.0, 1e-3]);
        assert!((shares[0] - (1.0 - 2e-6 - 1e-3)).abs() < 1e-15);
        assert!((shares[1] - (1.0 - 1e-6)).abs() < 1e-15);
        let rule = Rule { share: 0.9, confidence: 0.95 };
        // Two statements, each wrong in half of 5 %.
        assert_eq!(confidence(RareEvent::NotConforming, Some(rule)), 0.975);
        assert_eq!(confidence(RareEvent::Verified, Some(rule)), 0.95);
        assert_eq!(verified(RareEvent::Failed, [0.2, 0.3], [0.2, 0.3]), [0.0, 0.8]);
    }
}
