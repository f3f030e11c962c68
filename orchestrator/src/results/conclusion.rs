//! What follows from all points together: the verdict by its rule, and the risks of accepting.

use serde::{Deserialize, Serialize};

use crate::conformity::decision::{Decision, Rule, randomised};
use crate::conformity::risk::{Risk, Statement};

/// The verdict on the model, with what it rests on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Conclusion {
    /// The verdict.
    pub verdict: Decision,
    /// How it was found.
    pub rule: RuleName,
    /// Both in words.
    pub verdict_words: String,
    /// What the rule requires and what came out; only of the rule `share`.
    pub required: Option<Requirement>,
    /// How many points are accepted: within all tolerances less the guard bands.
    pub accepted: u64,
    /// The guard band of every criterion, in expanded uncertainties; none where no guard band limits
    /// the risk as required, and nothing is accepted.
    pub guard_band: Option<f64>,
    /// The risks of all criteria together; none unless every criterion has an uncertainty.
    pub risk: Option<Risk>,
}

/// The rule of a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RuleName {
    /// One accepted point is enough, as in the paper.
    #[serde(rename = "one point")]
    OnePoint,
    /// A share of the sampled space must be accepted.
    #[serde(rename = "share")]
    Share,
}

/// What a share is required to be, and what is known of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// The required share and the confidence.
    #[serde(flatten)]
    pub rule: Rule,
    /// The interval of the share of accepted points, at that confidence.
    pub interval: [f64; 2],
}

impl Conclusion {
    /// Draws it from what is known of so many points; without a rule one point is enough.
    pub fn new(rule: Option<Rule>, statement: &Statement, points: u64) -> Self {
        let accepted = statement.accepted;
        let required = rule.map(|rule| Requirement {
            rule,
            interval: randomised(&statement.accepted_by_sample, points, rule.confidence),
        });
        let verdict = match &required {
            Some(required) => required.rule.decide(required.interval),
            None if accepted > 0 => Decision::Verified,
            None => Decision::NotVerified,
        };
        let words = match &required {
            Some(required) => by_share(verdict, required),
            None => format!("{verdict} by the one-point rule: {}", of(accepted, points)),
        };
        Self {
            verdict,
            rule: rule.map_or(RuleName::OnePoint, |_| RuleName::Share),
            verdict_words: words,
            required,
            accepted,
            guard_band: statement.guard,
            risk: statement.all.clone(),
        }
    }
}

fn by_share(verdict: Decision, required: &Requirement) -> String {
    let [low, high] = required.interval.map(|limit| 100.0 * limit);
    let [share, confidence] = [required.rule.share, required.rule.confidence].map(percent);
    format!(
        "{verdict}: required are {share} % of the sampled space, found {low:.2} .. {high:.2} % at a \
         confidence of {confidence} %"
    )
}

/// A share in percent without the digits that only rounding brings.
fn percent(share: f64) -> f64 {
    (1e10 * share).round() / 1e8
}

/// Thousands are set apart: `1 of 10,000`.
fn of(number: u64, total: u64) -> String {
    format!("{} of {} points", grouped(number), grouped(total))
}

fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statement(accepted: u64) -> Statement {
        Statement {
            guard: Some(0.0),
            accepted,
            accepted_by_sample: vec![accepted],
            expected_conforming: None,
            criteria: Vec::new(),
            all: None,
        }
    }

    #[test]
    fn one_point_is_enough_without_a_rule() {
        let found = Conclusion::new(None, &statement(1), 10_000);
        assert_eq!(found.verdict, Decision::Verified);
        assert_eq!(
            found.verdict_words,
            "verified by the one-point rule: 1 of 10,000 points"
        );
        let found = Conclusion::new(None, &statement(0), 50);
        assert_eq!(found.verdict, Decision::NotVerified);
        assert_eq!(
            found.verdict_words,
            "not verified by the one-point rule: 0 of 50 points"
        );
    }

    #[test]
    fn a_share_is_decided_by_its_interval() {
        let rule = Some(Rule {
            share: 0.05,
            confidence: 0.95,
        });
        for (accepted, verdict) in [
            (20, Decision::Verified),
            (6, Decision::Inconclusive),
            (0, Decision::NotVerified),
        ] {
            let found = Conclusion::new(rule, &statement(accepted), 100);
            assert_eq!(found.verdict, verdict);
            assert!(
                found
                    .verdict_words
                    .starts_with(&format!("{verdict}: required are 5 %"))
            );
        }
        let text = serde_json::to_value(Conclusion::new(rule, &statement(0), 100)).unwrap();
        assert_eq!(text["verdict"], "not verified");
        assert_eq!(text["rule"], "share");
        assert_eq!(text["required"]["share"], 0.05);
        assert!(text["risk"].is_null());
    }
}
