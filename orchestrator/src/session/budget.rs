//! `--budget N`: a share from few runs, by points that are chosen while they come in.
//!
//! The points are those of one scrambled net over the parameters' distributions, taken in batches that depend on the study, the
//! seed and the outcomes of earlier batches alone: a run that was killed asks for the same ones again, and a larger budget goes
//! on behind them.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::{Session, Until, account::Account};
use crate::{
    error::{Error, Result},
    results::{
        Summary,
        surrogate::{Evidence, limits},
    },
};
use conformity::{
    decision::{Decision, Rule},
    looks::{History, spent},
    risk::Guard,
};
use point_journal::{PointOutcome, pipeline::Pipeline};
use run_budget::{Answers, Campaign, Share};
use sampling::design::{Design, Method, Sampling};
use study::{judge::Judge, plan::Plan};

/// How the journal's header names such a run.
pub const ANALYSIS: &str = "verify by a budget of runs";
/// The points of the sample that the surrogate is asked for: they tell a share to 1.3 points, if it knew all else.
const SAMPLE: u64 = 4096;
/// Plain points before any is chosen, and the least of a batch.
const START: usize = 20;
const LEAST_BATCH: usize = 10;
/// Runs of each case beside the points: one before the first, one point once more, the best one for its picture and with half its steps.
const BESIDE: u64 = 4;
/// Fewer runs leave nothing to choose; with more of them a fit takes minutes.
const RUNS: [u64; 2] = [20, 1000];
/// Looks while a study waits for its answer: the first at so many points, each later one at so many times as many.
const FIRST_LOOK: f64 = 30.0;
const GROWTH: f64 = 1.4;

/// A number of runs, and what has become of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Budget {
    /// All runs of the FMU.
    pub runs: u64,
    /// The least size of a batch, so that all workers of the first run had something to do.
    pub batch: usize,
    /// How many points there were when this budget, and earlier ones that it goes on from, were spent.
    pub ends: Vec<u64>,
    /// Simulations beside the points, for earlier budgets and this one.
    pub beside: u64,
    /// The points, as places in the net, once the folder is complete.
    pub places: Vec<u64>,
}

impl Budget {
    /// Refuses what cannot be spent on a study of so many cases, each of which is a run.
    ///
    /// # Errors
    /// Names what can.
    pub fn check(account: &Account, cases: u64) -> Result {
        let [least, most] = RUNS;
        let of_each = account.left() / cases;
        if (least..=most).contains(&of_each) {
            return Ok(());
        }
        if of_each < least && account.left() < account.runs {
            return Err(account.too_few(least * cases, ""));
        }
        let each = if cases > 1 { format!(" of each of the {cases} cases") } else { String::new() };
        let message =
            format!("a budget has {least} to {most} runs{each}; fewer tell nothing, and for more there is --points");
        Err(Error::option("budget", message))
    }

    /// What is left of a budget; `then` is what the folder holds that this goes on from.
    ///
    /// # Errors
    /// When it is none that can be spent.
    pub fn new(account: &Account, jobs: usize, cases: usize, then: Option<Self>) -> Result<Self> {
        let (runs, cases) = (account.left(), cases as u64);
        Self::check(account, cases)?;
        match then {
            Some(then) if then.runs == runs && [0, then.points()].contains(&then.places.len()) => Ok(then),
            then => {
                let mut budget = then.unwrap_or_else(|| Self { batch: jobs.max(LEAST_BATCH), ..Self::default() });
                if budget.runs == runs {
                    // It ended early, and its end is not reached.
                    budget.ends.pop();
                }
                let beside = budget.beside.saturating_add(BESIDE * cases);
                let (before, end) = (budget.points() as u64, runs.saturating_sub(beside) / cases);
                if end <= before {
                    let [then, more] =
                        [budget.runs, beside.saturating_add(cases * (before + 1))].map(|own| account.with_others(own));
                    let message = format!("{then} runs are in this folder already; give as many, or {more} or more");
                    return Err(Error::option("budget", message + &account.told()));
                }
                (budget.runs, budget.beside) = (runs, beside);
                budget.places.clear();
                budget.ends.push(end);
                Ok(budget)
            }
        }
    }

    /// The points that it pays for.
    pub fn points(&self) -> usize {
        self.ends.last().map_or(0, |end| *end as usize)
    }

    /// Which of the points are a plain sample of the space: those of the net's first half ([`Campaign`]). The others were chosen.
    pub fn plain(&self) -> impl Iterator<Item = bool> + '_ {
        self.places.iter().map(|place| *place < SAMPLE / 2)
    }

    /// How many of the points that are not run yet form the next batch behind `done`.
    fn batch(&self, done: usize) -> usize {
        let whole = if done == 0 { START.max(self.batch) } else { self.batch.max(done / 5) };
        let end = self.ends.iter().map(|end| *end as usize).find(|end| *end > done).unwrap_or(done);
        whole.min(end - done)
    }
}

/// The net over the parameters of a study.
///
/// # Errors
/// When there is none of so many dimensions.
pub fn sample(session: &Session) -> Result<Design> {
    let design = &session.study.design;
    let net = Sampling { method: Method::Sobol, points: SAMPLE, seed: design.seed, replicates: 1 };
    session.plan.design(&net).map_err(|message| session.study.error_in("design", &[], message).into())
}

/// The factor of the guard band.
///
/// # Errors
/// When the study gives none.
pub fn guard(judge: &Judge) -> Result<f64, String> {
    match judge.guard {
        Guard::Given(factor) => Ok(factor),
        Guard::Limiting { .. } | Guard::EachPoint { .. } => {
            Err("`risk` and `point-risk` decide by all points, which chosen ones do not stand for; give `guard-band` under \
                 [verdict] instead"
                .to_owned())
        }
    }
}

/// The values of a run as a surrogate sees it: none of one that failed or has no number.
fn values(outcome: &PointOutcome) -> Option<Vec<f64>> {
    outcome.as_ref().ok().cloned()
}

/// What the points of a budget tell.
pub struct ChosenPoints {
    /// The points, as places in the net.
    pub places: Vec<u64>,
    /// What they say of the sample.
    pub answers: Answers,
    /// Whether the study waited for its answer.
    pub awaited: bool,
}

impl ChosenPoints {
    /// Puts into the summary of the points what they tell of the space.
    pub fn complete(&self, session: &Session, history: &History, summary: &mut Summary) {
        let Session { judge, plan, request, .. } = session;
        let confidence = judge.rule.map_or(0.95, |rule| {
            confidence(rule.confidence, history, summary.points, self.awaited, 1 + look(summary.points as usize))
        });
        let beside = request.budget.as_ref().map_or(0, |budget| budget.beside);
        let evidence = Evidence {
            judge,
            answers: &self.answers,
            runs: summary.points * plan.cases.len().max(1) as u64 + beside,
            verdict: [guard(judge).unwrap_or(0.0), confidence],
        };
        evidence.complete(summary);
    }
}

/// Runs the points of a budget, in batches that do not depend on the order in which their points finish.
///
/// # Errors
/// Those of the pipeline.
pub fn run(
    session: &Session,
    net: &Design,
    pipeline: &mut Pipeline,
    until: Option<(Until, &History)>,
) -> Result<ChosenPoints> {
    let budget = session.request.budget.clone().unwrap_or_default();
    let Session { plan, judge, .. } = session;
    let sample: Vec<Vec<f64>> = (0..net.len()).map(|index| net.point(index)).collect();
    let coordinates: Vec<Vec<f64>> = sample.iter().map(|point| plan.coordinates(point)).collect();
    let accepted = limits(judge, guard(judge).unwrap_or(0.0));
    let mut campaign = Campaign::new(accepted.clone(), coordinates, START.max(budget.batch), session.study.design.seed);
    let mut places: Vec<u64> = Vec::new();
    pipeline.repeat_at_most(1);
    while places.len() < budget.points() {
        let done = places.len();
        let batch = campaign.next(budget.batch(done));
        if batch.is_empty() {
            break;
        }
        let points: Vec<Vec<f64>> = batch.iter().map(|place| sample[*place].clone()).collect();
        let outcomes: VecDeque<PointOutcome> = pipeline.ask(&points)?.into();
        for (k, outcome) in outcomes.iter().enumerate() {
            campaign.tell(done + k, values(outcome));
        }
        places.extend(batch.into_iter().map(|place| place as u64));
        pipeline.say(format!("{} of {} points", places.len(), budget.points()));
        let due = look(places.len()) > look(done) && places.len() < budget.points();
        if let (true, Some((until, history))) = (due, until) {
            let share = campaign.answers().share(&accepted);
            if is_enough(until, judge.rule, &share, history, places.len()) {
                break;
            }
        }
    }
    Ok(ChosenPoints { places, answers: campaign.answers(), awaited: until.is_some() })
}

/// The number of the look at so many points, of a study that waits for its answer.
fn look(points: usize) -> u32 {
    let ratio = points as f64 / FIRST_LOOK;
    if ratio < 1.0 { 0 } else { 1 + (ratio.ln() / GROWTH.ln()) as u32 }
}

fn is_enough(until: Until, rule: Option<Rule>, share: &Share, history: &History, points: usize) -> bool {
    match (until, rule) {
        (Until::Width(width), _) => {
            let [low, high] = share.interval(0.95);
            high - low <= width
        }
        (Until::Verdict, Some(rule)) => {
            let confidence = confidence(rule.confidence, history, points as u64, true, look(points));
            rule.decide(share.interval(confidence)) != Decision::Inconclusive
        }
        (Until::Verdict, None) => false,
    }
}

/// The confidence of a look's interval, so that all looks together decide wrongly no more often than `confidence` lets them
/// (Bonferroni's inequality, as [`conformity::looks`]): the first verdict without `--until` has it all. `own` is the number of the look
/// of a study that waits.
pub fn confidence(confidence: f64, history: &History, points: u64, awaited: bool, own: u32) -> f64 {
    let before: u32 = history
        .looks
        .iter()
        .take_while(|look| look.points != points)
        .map(|then| if then.awaited { 1 + look(then.points as usize) } else { 1 })
        .sum();
    match (before, awaited) {
        (0, false) => confidence,
        (before, false) => 1.0 - (1.0 - confidence) * spent(before),
        (before, true) => 1.0 - (1.0 - confidence) * spent(before + own),
    }
}

/// What a budget can be expected to answer, in words.
pub fn expected(plan: &Plan, budget: &Budget) -> String {
    let (points, varied) = (budget.points(), plan.varied().len());
    let plain = START + points.saturating_sub(START).div_ceil(2);
    format!(
        "{} runs: {points} points, and {} runs beside them (one before the first, one again, the best one's picture, half its steps)\n\
         a surrogate in {varied} parameters tells the share with an interval, which holds its error; where it does not hold, \
         {plain} plain points are counted, which tell a share to +-{:.0} points at most\n",
        budget.runs,
        budget.beside,
        196.0 * (0.25 / plain as f64).sqrt()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use conformity::looks::{Look, Way};

    #[test]
    fn all_runs_are_counted_and_a_larger_budget_goes_on_behind_the_points_that_are_there() {
        let of = |runs, jobs, cases, then| {
            Budget::new(&Account { runs, ..Account::default() }, jobs, cases, then).map_err(|error| error.to_string())
        };
        let first = of(100, 2, 1, None).unwrap();
        assert_eq!((first.points(), first.beside, first.batch), (96, 4, 10));
        assert_eq!(of(100, 8, 1, Some(first.clone())).unwrap().ends, first.ends);
        let second = of(200, 2, 1, Some(first.clone())).unwrap();
        assert_eq!((second.points(), second.beside), (192, 8));
        let sizes = |budget: &Budget| {
            let mut done = vec![0];
            while *done.last().unwrap() < budget.points() {
                let last = *done.last().unwrap();
                done.push(last + budget.batch(last));
            }
            done
        };
        assert!(sizes(&second).starts_with(&sizes(&first)), "{:?} {:?}", sizes(&first), sizes(&second));
        // As many, or at least one point more beside what each budget takes beside its points.
        for runs in [60, 199, 201, 204] {
            let refused = of(runs, 2, 1, Some(second.clone())).unwrap_err();
            assert!(refused.contains("200 runs are in this folder already; give as many, or 205 or more"), "{refused}");
        }
        assert_eq!(of(205, 2, 1, Some(second)).unwrap().points(), 193);
        assert_eq!(of(100, 2, 3, None).unwrap().points(), 29);
        assert!(of(50, 2, 3, None).unwrap_err().contains("3 cases"));
        assert_eq!(of(100, 32, 1, None).unwrap().batch, 32);
    }

    #[test]
    fn the_looks_of_a_study_share_what_may_be_wrong() {
        let none = History::default();
        assert_eq!(confidence(0.95, &none, 97, false, 0), 0.95);
        let (mut points, mut wrong) = (30, 0.0);
        while points < 100_000 {
            wrong += 1.0 - confidence(0.95, &none, points, true, look(points as usize));
            points = (points as f64 * 1.4).ceil() as u64;
        }
        assert!(wrong < 0.05, "{wrong}");
        let then = Look { points: 97, way: Way::Once, awaited: false };
        let looked = History { looks: vec![then] };
        assert!(confidence(0.95, &looked, 194, false, 0) > 0.99);
        assert_eq!(confidence(0.95, &looked, 97, false, 0), 0.95);
    }
}
