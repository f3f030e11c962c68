//! `--until "ci 0.01"` and `--until verdict`: as many points as are needed.

use std::str::FromStr;

use conformity::{
    decision::{Decision, Rule, randomised},
    looks::{History, Looks, Way},
    risk::Guard,
};
use point_journal::PointOutcome;
use sampling::design::Method;
use study::judge::Judge;

/// The condition that ends sampling, as the option gives it.
#[derive(Clone, Copy, Debug)]
pub enum Until {
    /// A 95 % interval of the verified share that is no wider than this.
    Width(f64),
    /// A verdict other than inconclusive.
    Verdict,
}

impl FromStr for Until {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        if text == "verdict" {
            return Ok(Self::Verdict);
        }
        let width = text.strip_prefix("ci").and_then(|width| width.trim().parse().ok());
        match width {
            Some(width) if width > 0.0 && width < 1.0 => Ok(Self::Width(width)),
            _ => Err(format!("`{text}` is neither `verdict` nor a width of the interval such as \"ci 0.01\"")),
        }
    }
}

/// When a study may end before its last point.
#[derive(Debug)]
pub struct Ending {
    condition: Condition,
    guard: Guard,
}

#[derive(Clone, Copy, Debug)]
enum Condition {
    Width(f64),
    Verdict(Rule, Looks),
}

/// With a width, only every so many points are looked at, so that chance does not decide alone; nor does it where so many have
/// failed, and no other.
const ROUND: u64 = 100;

impl Ending {
    /// The meaning of an option for a study whose points come from a design with so many replicates, or from a table.
    ///
    /// # Errors
    /// When the points allow no such ending; says what to do.
    /// `history` are the verdicts that were drawn from points of this study before.
    pub fn new(until: Until, judge: &Judge, design: Option<Method>, history: &History) -> Result<Self, String> {
        if design.is_some_and(|method| !method.is_extensible()) {
            let with = Method::named(Method::is_extensible);
            return Err(format!("this design needs all its points; use {with}"));
        }
        let condition = match until {
            Until::Width(width) => {
                if design.is_some() {
                    way(design)?;
                }
                Condition::Width(width)
            }
            Until::Verdict => {
                let rule =
                    judge.rule.ok_or("there is no verdict to wait for: add [verdict] with the required share")?;
                if let Guard::Limiting { .. } = judge.guard {
                    return Err("`risk` finds the guard band from all points, so that accepted points \
                                change while they come in; give `guard-band` under [verdict] instead, \
                                such as a run with a fixed number of points has found it"
                        .to_owned());
                }
                if !judge.guard.leaves_something(&judge.measurement) {
                    return Err(
                        "the guard band is as wide as a tolerance, or no value conforms as surely as `point-risk` \
                                asks, so that no point can be accepted and no verdict comes; change [verdict]"
                            .to_owned(),
                    );
                }
                Condition::Verdict(rule, history.awaiting(way(design)?))
            }
        };
        Ok(Self { condition, guard: judge.guard })
    }

    /// How the verdict has to be found, where the study waits for it: it then has an interval of its own.
    pub fn looks(&self) -> Option<Looks> {
        match self.condition {
            Condition::Width(_) => None,
            Condition::Verdict(_, looks) => Some(looks),
        }
    }

    /// Whether a point counts for the share that is waited for.
    pub fn counts(&self, judge: &Judge, outcome: &PointOutcome) -> Seen {
        let Ok(values) = outcome.as_deref() else { return Seen::Failed };
        let counts = match (self.condition, self.guard) {
            (Condition::Verdict(..), Guard::Given(band)) => judge.measurement.margin(values) >= band,
            (Condition::Verdict(..), guard) => guard.accepts(judge.measurement.assess(values).all, None),
            _ => judge.verdict(Some(values)).verified(),
        };
        if counts { Seen::Counts } else { Seen::Misses }
    }

    fn holds(&self, count: u64, points: u64) -> bool {
        const CONFIDENCE: f64 = 0.95;
        match self.condition {
            Condition::Width(width) => {
                let [low, high] = randomised(&[count], points, CONFIDENCE);
                points > 0 && points.is_multiple_of(ROUND) && high - low <= width
            }
            Condition::Verdict(rule, looks) => looks.decide(rule, &[count], points) != Decision::Inconclusive,
        }
    }
}

/// How points of a design may be looked at while they come in.
fn way(design: Option<Method>) -> Result<Way, String> {
    match design {
        Some(method) if method.is_independent(0, false) => Ok(Way::EveryPoint),
        Some(_) => {
            Err("the points of this design depend on each other, and while they come in nothing tells how much; use \
             method = \"monte-carlo\""
                .to_owned())
        }
        None => Err("the points of a table need not be random in their order; sample them".to_owned()),
    }
}

/// A point, for the share that is waited for.
#[derive(Clone, Debug, PartialEq)]
pub enum Seen {
    /// It has no result.
    Failed,
    /// It has one, and does not count.
    Misses,
    /// It counts.
    Counts,
}

/// Follows the points in their order, although they finish in another one.
pub struct Front<'a> {
    ending: &'a Ending,
    /// The points; `None` while one is not finished.
    seen: Vec<Option<Seen>>,
    /// How many of those before `front` count.
    count: u64,
    /// Whether any has a result: a study without one has no verdict, and a few failures say little about the FMU.
    compared: bool,
    /// The points before this one are finished and counted.
    front: usize,
}

impl<'a> Front<'a> {
    /// No points yet.
    pub fn new(ending: &'a Ending) -> Self {
        Self { ending, seen: Vec::new(), count: 0, compared: false, front: 0 }
    }

    /// Notes a finished point; says whether the points up to some index are enough.
    pub fn add(&mut self, index: u64, seen: Seen) -> bool {
        let Ok(index) = usize::try_from(index) else { return false };
        if index >= self.seen.len() {
            self.seen.resize(index + 1, None);
        }
        self.seen[index] = Some(seen);
        while let Some(Some(seen)) = self.seen.get(self.front) {
            self.count += u64::from(*seen == Seen::Counts);
            self.compared |= *seen != Seen::Failed;
            self.front += 1;
            let points = self.front as u64;
            if (self.compared || points >= ROUND) && self.ending.holds(self.count, points) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod rates_tests;
#[cfg(test)]
mod tests;
