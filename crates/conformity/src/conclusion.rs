//! The conclusion from all points together: the verdict by its rule, and the risks of accepting.

use serde::{Deserialize, Serialize};

use crate::{
    decision::{Decision, Rule},
    looks::{Looks, Way},
    risk::{Bands, Risk, RiskStatement, Unfit},
    sequence::{points_needed, points_needed_once},
};

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
    /// How many points are accepted: within all tolerances less the guard bands.
    pub accepted: u64,
    /// The guard band of every criterion, in expanded uncertainties; none where the points show of none that it limits the
    /// risk as required, and nothing is accepted.
    pub guard_band: Option<f64>,
    /// The largest probability not to conform of an accepted point, where each has to keep it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub point_risk: Option<f64>,
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
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Requirement {
    /// The required share and the confidence.
    #[serde(flatten)]
    pub rule: Rule,
    /// The interval of the share of accepted points, at that confidence; none where the measurement cannot decide on
    /// any point.
    pub interval: Option<[f64; 2]>,
    /// How the interval was computed.
    #[serde(default)]
    pub method: String,
    /// Where `risk` sets the guard band: the narrowest and the widest one that may be the right one of the whole space;
    /// none for the latter where the points show of no band that it is enough. The interval of the share is right for all
    /// of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub guard_bands: Option<[Option<f64>; 2]>,
    /// How many verdicts were drawn from points of this study, with this one.
    #[serde(default = "one")]
    pub looks: u64,
    /// Where the verdict is inconclusive: about how many independent points another study would have to have that is
    /// judged once, if the share stays what it is; none where it is so near to the required one that no number of points
    /// would decide.
    pub points_needed: Option<u64>,
    /// The same if this study is extended: its points count, and it is allowed for that people look at it repeatedly.
    pub points_needed_going_on: Option<u64>,
}

impl Requirement {
    /// What is required, while nothing is known of the share.
    pub fn open(rule: Rule, looks: u64) -> Self {
        Self {
            rule,
            interval: None,
            method: String::new(),
            guard_bands: None,
            looks,
            points_needed: None,
            points_needed_going_on: None,
        }
    }
}

fn one() -> u64 {
    1
}

/// A rule, with how the study was looked at so far.
#[derive(Clone, Copy, Debug)]
pub struct Ruling {
    /// The rule.
    pub rule: Rule,
    /// How the points are looked at.
    pub looks: Looks,
    /// How many verdicts were drawn from points of this study, with this one.
    pub count: u64,
}

impl Ruling {
    /// The verdict with its words.
    fn verdict(self, statement: &RiskStatement, points: u64) -> (Decision, Requirement, String) {
        let Self { rule, looks, count } = self;
        let method = method(looks.way, statement.accepted_by_sample.len());
        let mut required = Requirement { method, ..Requirement::open(rule, count) };
        if let Some(unfit) = statement.unfit {
            return undecided(self, unfit, statement, points, required);
        }
        let samples = &statement.accepted_by_sample;
        let verdict = looks.decide_by_bands(rule, &statement.bands, points);
        let share = statement.accepted as f64 / points.max(1) as f64;
        let open = verdict == Decision::Inconclusive;
        let interval = looks.interval_of_bands(&statement.bands, points, rule.confidence);
        let given = looks.interval(samples, points, rule.confidence);
        // What the guard band leaves open shrinks with the number of points as the interval for a given one does.
        let widening = ((interval[1] - interval[0]) / (given[1] - given[0])).powi(2);
        let needed = |points: Option<u64>| {
            let points = points.filter(|_| open)?;
            Some((points as f64 * widening).ceil() as u64)
        };
        required.interval = Some(interval);
        required.guard_bands = guard_bands(&statement.bands);
        required.points_needed = needed(points_needed_once(rule, share));
        required.points_needed_going_on = needed(points_needed(looks.going_on(rule), share));
        let words = by_share(verdict, &required, "");
        (verdict, required, words)
    }
}

/// The guard bands that may be the right one, unless there is one only.
fn guard_bands(bands: &Bands) -> Option<[Option<f64>; 2]> {
    let [narrowest, widest] = bands.factors;
    (narrowest < widest).then(|| bands.factors.map(|factor| Some(factor).filter(|f| f.is_finite())))
}

/// Where no point can be accepted, although some are within all tolerances, nothing is known of the share that a better
/// measurement would accept, but that it is no larger than the share within all tolerances.
fn undecided(
    ruling: Ruling,
    unfit: Unfit,
    statement: &RiskStatement,
    points: u64,
    mut required: Requirement,
) -> (Decision, Requirement, String) {
    let Ruling { rule, looks, .. } = ruling;
    let within = &statement.within_by_sample;
    let verdict = Decision::NotVerified;
    if looks.decide(rule, within, points) == verdict {
        let [_, high] = looks.interval(within, points, rule.confidence);
        required.interval = Some([0.0, high]);
        let words = by_share(verdict, &required, " within all tolerances, whatever the guard band");
        return (verdict, required, words);
    }
    let verdict = Decision::Inconclusive;
    let why = match unfit {
        Unfit::Risk { limit, least } => format!(
            "whatever the guard band, at best {:.1} % of the accepted points would conform, {} % are required",
            100.0 * (1.0 - least),
            in_percent(1.0 - limit)
        ),
        Unfit::Point { limit } => {
            format!(
                "no value conforms with the required {} %, as the uncertainties are too large",
                in_percent(1.0 - limit)
            )
        }
        Unfit::Guard => "the guard band is as wide as a tolerance and leaves nothing of it".to_owned(),
    };
    let words = format!("{verdict}: the measurement cannot decide: {why}");
    (verdict, required, words)
}

impl Conclusion {
    /// Draws it from what is known of so many points; without a rule one point is enough.
    pub fn new(ruling: Option<Ruling>, statement: &RiskStatement, points: u64) -> Self {
        let accepted = statement.accepted;
        let (verdict, required, words) = match ruling {
            Some(ruling) => {
                let (verdict, required, words) = ruling.verdict(statement, points);
                (verdict, Some(required), words)
            }
            None => {
                let any = accepted > 0;
                let verdict = if any { Decision::Verified } else { Decision::NotVerified };
                let words = format!("{verdict} by the one-point rule: {}", of(accepted, points));
                (verdict, None, words)
            }
        };
        Self {
            verdict,
            rule: ruling.map_or(RuleName::OnePoint, |_| RuleName::Share),
            verdict_words: words,
            required,
            accepted,
            guard_band: statement.guard,
            point_risk: None,
            risk: statement.all.clone(),
        }
    }
}

fn method(way: Way, samples: usize) -> String {
    let counted = match samples {
        1 => "Clopper and Pearson's".to_owned(),
        n => format!("Clopper and Pearson's with each of {n} replicates as one trial"),
    };
    match way {
        Way::Once => counted,
        Way::EveryPoint => "a confidence sequence, which may be looked at after every point".to_owned(),
        Way::Doublings => format!("{counted}, with the probability of a wrong verdict divided among the looks"),
    }
}

/// The verdict by a share in words; `of_which` says more of what was found.
pub fn by_share(verdict: Decision, required: &Requirement, of_which: &str) -> String {
    let [low, high] = required.interval.unwrap_or([0.0, 1.0]).map(|limit| 100.0 * limit);
    let [share, confidence] = [required.rule.share, required.rule.confidence].map(in_percent);
    format!(
        "{verdict}: required are {share} % of the sampled space, found {low:.2} .. {high:.2} %{of_which} at a \
         confidence of {confidence} %"
    )
}

/// A share in percent without the digits that only rounding brings.
pub fn in_percent(share: f64) -> f64 {
    (1e10 * share).round() / 1e8
}

/// Thousands are set apart: `1 of 10,000`.
fn of(number: u64, total: u64) -> String {
    let plural = if total == 1 { "" } else { "s" };
    format!("{} of {} point{plural}", grouped(number), grouped(total))
}

/// A count with commas between thousands.
pub fn grouped<N: ToString>(number: N) -> String {
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
mod tests;
