//! The conclusion from all points together: the verdict by its rule, and the risks of accepting.

use serde::{Deserialize, Serialize};

use conformity::decision::{Decision, Rule, other_verdict};
use conformity::looks::Looks;
use conformity::risk::{Risk, Statement};
use conformity::sequence::points_needed;

/// The verdict on the model, with what it rests on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Conclusion {
    /// The verdict.
    pub verdict: Decision,
    /// How it was found.
    pub rule: RuleName,
    /// Both in words.
    pub verdict_words: String,
    /// The required share and the one found; only for the rule `share`.
    pub required: Option<Requirement>,
    /// The probability that another seed comes to the other verdict, as if its points were independent; only of the
    /// rule `one point`.
    #[serde(default)]
    pub other_verdict_probability: Option<f64>,
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

/// The required value of a share, and its interval from the points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// The required share and the confidence.
    #[serde(flatten)]
    pub rule: Rule,
    /// The interval of the share of accepted points, at that confidence.
    pub interval: [f64; 2],
    /// How the interval was computed.
    #[serde(default)]
    pub method: String,
    /// Where the verdict is inconclusive: about how many independent points would decide, if the share stays what it
    /// is; none where it is so near to the required one that no number of points would.
    #[serde(default)]
    pub points_needed: Option<u64>,
}

impl Conclusion {
    /// Draws it from what is known of so many points; without a rule one point is enough.
    pub fn new(rule: Option<Rule>, looks: Looks, statement: &Statement, points: u64) -> Self {
        let accepted = statement.accepted;
        let samples = &statement.accepted_by_sample;
        let (verdict, required, words) = match rule {
            Some(rule) => {
                let verdict = looks.decide(rule, samples, points);
                let share = accepted as f64 / points.max(1) as f64;
                let open = verdict == Decision::Inconclusive;
                let required = Requirement {
                    rule,
                    interval: looks.interval(samples, points, rule.confidence),
                    method: method(looks, samples.len()),
                    points_needed: points_needed(rule, share).filter(|_| open),
                };
                let words = by_share(verdict, &required);
                (verdict, Some(required), words)
            }
            None => {
                let any = accepted > 0;
                let verdict = if any {
                    Decision::Verified
                } else {
                    Decision::NotVerified
                };
                let words = format!("{verdict} by the one-point rule: {}", of(accepted, points));
                (verdict, None, words)
            }
        };
        Self {
            verdict,
            rule: rule.map_or(RuleName::OnePoint, |_| RuleName::Share),
            verdict_words: words,
            required,
            other_verdict_probability: rule.is_none().then(|| other_verdict(accepted, points)),
            accepted,
            guard_band: statement.guard,
            risk: statement.all.clone(),
        }
    }
}

fn method(looks: Looks, samples: usize) -> String {
    match (looks, samples) {
        (Looks::Once, 1) => "Clopper and Pearson's".to_owned(),
        (Looks::Once, n) => format!(
            "Student's over {n} replicates; Clopper and Pearson's where their counts hardly differ"
        ),
        (Looks::EveryPoint, _) => {
            "a confidence sequence, which may be looked at after every point".to_owned()
        }
        (Looks::Doublings, n) => format!(
            "Student's over {n} replicates, with the probability of a wrong verdict divided among the looks"
        ),
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
    let plural = if total == 1 { "" } else { "s" };
    format!("{} of {} point{plural}", grouped(number), grouped(total))
}

/// A count with commas between thousands.
pub fn grouped(number: u64) -> String {
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
        let found = Conclusion::new(None, Looks::Once, &statement(1), 10_000);
        assert_eq!(found.verdict, Decision::Verified);
        assert_eq!(
            found.verdict_words,
            "verified by the one-point rule: 1 of 10,000 points"
        );
        let found = Conclusion::new(None, Looks::Once, &statement(0), 50);
        assert_eq!(found.verdict, Decision::NotVerified);
        assert_eq!(
            found.verdict_words,
            "not verified by the one-point rule: 0 of 50 points"
        );
        let other = found.other_verdict_probability.unwrap();
        assert!((other - 0.29).abs() < 0.01, "{other}");
    }

    /// Who ends a study when it suits needs a wider interval.
    #[test]
    fn a_verdict_that_was_waited_for_has_an_interval_of_its_own() {
        let rule = Rule {
            share: 0.05,
            confidence: 0.95,
        };
        let found = |looks| Conclusion::new(Some(rule), looks, &statement(11), 100);
        assert_eq!(found(Looks::Once).verdict, Decision::Verified);
        let waited = found(Looks::EveryPoint);
        assert_eq!(waited.verdict, Decision::Inconclusive);
        let required = waited.required.unwrap();
        assert!(required.interval[0] < 0.05 && required.method.contains("sequence"));
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
            let found = Conclusion::new(rule, Looks::Once, &statement(accepted), 100);
            assert_eq!(found.verdict, verdict);
            assert!(
                found
                    .verdict_words
                    .starts_with(&format!("{verdict}: required are 5 %"))
            );
        }
        let open = Conclusion::new(rule, Looks::Once, &statement(6), 100);
        let needed = open.required.unwrap().points_needed.unwrap();
        assert!((2_000..10_000).contains(&needed), "{needed}");
        let text =
            serde_json::to_value(Conclusion::new(rule, Looks::Once, &statement(0), 100)).unwrap();
        assert_eq!(text["verdict"], "not verified");
        assert_eq!(text["rule"], "share");
        assert_eq!(text["required"]["share"], 0.05);
        assert!(text["risk"].is_null());
    }
}
