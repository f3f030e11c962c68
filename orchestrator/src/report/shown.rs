//! The first two lines of the page: what the study has shown, and what it has not.

use super::judgement::Judgement;
use conformity::decision::{Decision, Rule};
use result_document::format::{count, number, percent};
use sampling::statistics::share::Fraction;
use serde::Serialize;

/// Two sentences for a reader who reads no further.
#[derive(Debug, Serialize)]
pub(super) struct Shown {
    shown: String,
    not_shown: String,
}

impl Shown {
    /// From the verdict and the share of points that meet all criteria; `failed` points have no result.
    pub(super) fn new(
        decision: Decision,
        judgement: &Judgement,
        meets_all: &Fraction,
        failed: usize,
    ) -> Self {
        if failed == meets_all.of {
            return Self {
                shown: "nothing, since no point could be simulated.".to_owned(),
                not_shown: "whether the model agrees with the measurement.".to_owned(),
            };
        }
        match judgement.required() {
            Some((required, accepted)) => {
                let counts = [accepted, meets_all.of];
                by_share(decision, judgement, required.rule, counts)
            }
            None => by_one_point(judgement, meets_all),
        }
    }

    /// Where the model is compared with its own values.
    pub(super) fn of_own_values(meets_all: &Fraction) -> Self {
        let [hits, points] = [meets_all.count, meets_all.of].map(count);
        Self {
            shown: format!(
                "how far the model's outputs move with its parameters: {hits} of {points} points stay within the tolerances of values \
                 that a run of the model itself gave."
            ),
            not_shown:
                "whether the model agrees with a measurement, which the study does not have yet."
                    .to_owned(),
        }
    }
}

fn by_one_point(judgement: &Judgement, meets_all: &Fraction) -> Shown {
    let (hits, points) = (meets_all.count, count(meets_all.of));
    if hits == 0 {
        return Shown {
            shown: format!(
                "none of the {points} points meets all criteria: with none of them the model agrees with the measurement."
            ),
            not_shown: "that no parameter set agrees. Parameter sets between the points were not simulated.".to_owned(),
        };
    }
    Shown {
        shown: format!(
            "{} of {points} points meet all criteria: there are parameter sets that the study allows with which the model \
             agrees with the measurement within the tolerances.",
            count(hits)
        ),
        not_shown: format!(
            "that the model is right. {} % is the fraction of the sampled parameter sets that pass. It does not grade the \
             model; another one may agree as well.{}",
            percent(meets_all.value()),
            doubt(judgement, hits)
        ),
    }
}

fn by_share(
    decision: Decision,
    judgement: &Judgement,
    rule: Rule,
    [accepted, points]: [usize; 2],
) -> Shown {
    let [required, confidence] = [rule.share, rule.confidence].map(|part| number(100.0 * part, 4));
    let within = match judgement.guard {
        Some(_) => "within the tolerances less the guard bands",
        None => "within the tolerances",
    };
    let (shown, not_shown) = match decision {
        Decision::Verified => (
            format!(
                "at least the required {required} % of the sampled parameter space agrees with the measurement {within}, \
                 at a confidence of {confidence} %: {} of {} points do.",
                count(accepted),
                count(points)
            ),
            format!(
                "that the model is right, or agrees with every parameter set. The share is the fraction of \
                 the sampled parameter sets that pass. It does not grade the model.{}",
                doubt(judgement, accepted)
            ),
        ),
        Decision::NotVerified => (
            format!(
                "less than the required {required} % of the sampled parameter space agrees with the measurement {within}, \
                 at a confidence of {confidence} %: {} of {} points do.",
                count(accepted),
                count(points)
            ),
            "that the model is wrong with every parameter set, or which of model, distributions and measurement is at fault."
                .to_owned(),
        ),
        Decision::Inconclusive => (
            format!(
                "{} of {} points agree with the measurement {within}, which decides nothing.",
                count(accepted),
                count(points)
            ),
            format!(
                "whether the required {required} % of the sampled parameter space agree, at a confidence of {confidence} %."
            ),
        ),
    };
    Shown { shown, not_shown }
}

/// An expected count: of few points a part of one counts, too.
fn expected(points: f64) -> String {
    if points < 1000.0 {
        number(points, 2)
    } else {
        count(points.round() as usize)
    }
}

/// How many of the accepted points are expected not to conform.
fn doubt(judgement: &Judgement, accepted: usize) -> String {
    let conclusion = judgement.conclusion.as_ref();
    let risk = conclusion.and_then(|conclusion| conclusion.risk.as_ref());
    match risk.and_then(|risk| risk.not_conforming_given_accepted) {
        Some(share) if accepted == 1 => format!(
            " The accepted point is outside of the tolerances of the true values with a probability of {} %, since the \
             measured values are uncertain.",
            number(100.0 * share, 2)
        ),
        Some(share) => format!(
            " Of the {} accepted points {} are expected to be outside of the tolerances of the true values, since the \
             measured values are uncertain.",
            count(accepted),
            expected(share * accepted as f64)
        ),
        None => " How far the measured values are from the true ones is not stated for every criterion, so it is not known \
                 how many of the accepted points are right."
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformity::conclusion::{Conclusion, Requirement, RuleName};
    use conformity::risk::Risk;

    fn lines(decision: Decision, judgement: &Judgement, hits: usize) -> [String; 2] {
        let of = Fraction::wilson(hits, 50);
        let Shown { shown, not_shown } = Shown::new(decision, judgement, &of, 0);
        [shown, not_shown]
    }

    fn judgement(by_share: bool) -> Judgement {
        let required = Requirement {
            rule: Rule {
                share: 0.05,
                confidence: 0.95,
            },
            interval: Some([0.058, 0.267]),
            method: String::new(),
            guard_bands: None,
            looks: 1,
            points_needed: None,
            points_needed_going_on: None,
        };
        let conclusion = Conclusion {
            verdict: Decision::Verified,
            rule: match by_share {
                true => RuleName::Share,
                false => RuleName::OnePoint,
            },
            verdict_words: String::new(),
            required: by_share.then_some(required),
            other_verdict_interval: None,
            accepted: 7,
            guard_band: Some(0.0),
            risk: Some(Risk {
                consumer: 0.1,
                producer: 0.1,
                conformance_probability: 0.3,
                not_conforming_given_accepted: Some(0.6),
                intervals: None,
            }),
        };
        Judgement {
            conclusion: Some(conclusion),
            ..Judgement::default()
        }
    }

    #[test]
    fn one_point_shows_that_there_is_one() {
        let [shown, not_shown] = lines(Decision::Verified, &judgement(false), 11);
        assert!(shown.starts_with("11 of 50 points meet all criteria"));
        assert!(
            not_shown.contains("22.0 % is the fraction of the sampled parameter sets that pass")
        );
        assert!(not_shown.contains("Of the 11 accepted points 6.6 are expected to be outside"));
        let [_, not_shown] = lines(Decision::NotVerified, &judgement(false), 0);
        assert!(not_shown.starts_with("that no parameter set agrees"));
    }

    #[test]
    fn a_share_is_shown_at_its_confidence() {
        let [shown, not_shown] = lines(Decision::Verified, &judgement(true), 11);
        assert!(
            shown.contains("at least the required 5 %") && shown.contains("7 of 50"),
            "{shown}"
        );
        assert!(
            not_shown.contains("Of the 7 accepted points 4.2"),
            "{not_shown}"
        );
        let guarded = Judgement {
            guard: Some(0.5),
            ..judgement(true)
        };
        let [shown, _] = lines(Decision::NotVerified, &guarded, 11);
        assert!(shown.starts_with("less than the required 5 %"));
        assert!(
            shown.contains("within the tolerances less the guard bands"),
            "{shown}"
        );
        let [_, not_shown] = lines(Decision::Inconclusive, &judgement(true), 11);
        assert!(not_shown.starts_with("whether the required 5 %"));
    }

    #[test]
    fn without_any_result_nothing_is_shown() {
        let none = Fraction::wilson(0, 3);
        let result = Shown::new(Decision::Inconclusive, &judgement(true), &none, 3);
        assert!(result.shown.starts_with("nothing"));
    }
}
