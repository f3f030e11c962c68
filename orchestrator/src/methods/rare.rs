//! `verify --rare`: shares that are too small to be counted among sampled points.

use std::{path::Path, process::ExitCode};

use clap::ValueEnum;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::{
    asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes, exit_code},
    known::Finished,
};
use crate::{
    error::Result,
    options::Work,
    results::surrogate::limits,
    session::{Request, Session, account::Account, budget::Budget},
};
use conformity::decision::Decision;
use point_journal::pipeline::Pipeline;
use result_document::{Document, format::number};
use run_budget::{Event, RareAnswer, Search, Unknown};
use sampling::word;

const FILE: &str = "rare.json";
const USUAL_RUNS: u64 = 150;

/// A share that `verify --rare` finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum RareEvent {
    /// Points that meet all criteria
    Verified,
    /// Points whose run ends and that miss a criterion
    NotConforming,
    /// Points whose run fails
    Failed,
}

/// The options of a search.
#[derive(Debug)]
pub struct Options {
    /// The study, how its points are run, and where the results go.
    pub work: Work,
    /// The event whose share is small.
    pub event: RareEvent,
    /// All runs of the FMU.
    pub budget: Option<u64>,
    /// The seed, instead of the study's.
    pub seed: Option<u64>,
}

/// The result in a study's folder, as its page shows it.
pub(super) fn shown(study: &Finished) -> Option<Document> {
    study.result::<RareShare>(FILE).map(|statement| statement.document())
}

/// Runs the search.
///
/// # Errors
/// When the options or the study cannot be used.
pub fn run(options: &Options) -> Result<Delivery> {
    let mut analysis = Rare { event: options.event, account: Account::default(), seed: 1 };
    let mut session = asking::open(&options.work, &analysis)?;
    let folder = options.work.folder();
    let command = (Rare::NAME, options.work.resuming.resume);
    analysis.account = session.account(&folder, command, options.budget.unwrap_or(USUAL_RUNS))?;
    analysis.seed = options.seed.unwrap_or(session.study.design.seed);
    // A refusal is one line, without doubts before it.
    analysis.check(&session)?;
    asking::warn(&session.judge);
    asking::run(session, &analysis, &options.work, folder)
}

/// Refuses studies of which a rare share says nothing.
fn refuse(session: &Session, event: RareEvent) -> Result {
    if event != RareEvent::Failed && session.judge.has_own_values() {
        return Err(session
            .study
            .error(
                "a share of verified points needs measured values; write them as `nominal` and remove `nominal-from`",
            )
            .into());
    }
    if let Some(joint) = session.plan.joints.first() {
        let name = &session.plan.inputs[joint.lead()].name;
        return Err(session
            .study
            .error(format!(
                "{name} is drawn from a sample of {} rows, which knows nothing as rare as --rare looks for; give the \
             parameters of the sample other distributions, or leave out --rare",
                joint.count()
            ))
            .into());
    }
    if session.judge.is_guarded() {
        return Err(session
            .study
            .error_near(
                "verdict",
                "--rare counts points by their tolerances alone, and a guard band decides otherwise; remove `risk` \
                       and `guard-band` under [verdict]",
            )
            .into());
    }
    Ok(())
}

/// A search for a rare share.
#[derive(Debug)]
struct Rare {
    event: RareEvent,
    account: Account,
    seed: u64,
}

impl Analysis for Rare {
    const NAME: &'static str = "rare";

    type Source = Session;

    fn points(&self, _: &Session) -> Result<PointSet> {
        Ok(PointSet {
            seed: self.seed,
            // The search ends when it knows enough.
            points: None,
            method: format!("{} with at most {} runs", word(&self.event), self.account.left()),
            table: None,
        })
    }

    fn open(&self, request: Request) -> Result<Session> {
        // `check` refuses samples with a reason of its own.
        asking::session(request, Takes::ALL)
    }

    fn check(&self, session: &Session) -> Result {
        Budget::check(&self.account, session.plan.cases.len().max(1) as u64)?;
        refuse(session, self.event)
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline, _: &Path) -> Result<AnalysisResult> {
        let Session { plan, judge, .. } = session;
        let limits = limits(judge, 0.0);
        let search = Search {
            event: match self.event {
                RareEvent::Verified => Event::Kept,
                RareEvent::NotConforming => Event::Missed,
                RareEvent::Failed => Event::Failed,
            },
            limits: &limits,
            dimensions: plan.varied().len(),
            coordinates: &|scores| plan.coordinates(&plan.at_scores(scores)),
            runs: self.account.points() as usize,
            seed: self.seed,
        };
        pipeline.repeat_at_most(1);
        let answer = search.answer(&mut |scores| -> Result<_> {
            let points: Vec<Vec<f64>> = scores.iter().map(|scores| plan.at_scores(scores)).collect();
            Ok(pipeline.ask(&points)?.into_iter().map(Result::ok).collect())
        })?;
        let statement = RareShare::new((self.event, &self.account), &answer, session);
        let origin = asking::origin(session)?;
        let mut result = AnalysisResult::new(&statement, origin, &statement.document(), FILE);
        result.code = match (statement.verdict, self.event) {
            (Some(verdict), _) => exit_code(Some(verdict)),
            // One verified point is enough.
            (None, RareEvent::Verified) if answer.inside.is_empty() => exit_code(None),
            (None, _) => ExitCode::SUCCESS,
        };
        Ok(result)
    }
}

/// The answer by a surrogate.
#[derive(Debug, Serialize, Deserialize)]
struct BySurrogate {
    /// All runs of the FMU.
    runs: u64,
    share: Option<f64>,
    /// Holds the share with the probability `confidence`.
    interval: Option<[f64; 2]>,
    /// Why there is no share.
    reason: Option<String>,
}

/// The statement.
#[derive(Debug, Serialize, Deserialize)]
struct RareShare {
    event: RareEvent,
    surrogate: BySurrogate,
    confidence: f64,
    /// Runs of the event: parameters in the study's units.
    inside: Vec<IndexMap<String, f64>>,
    /// The share of verified points that the study requires.
    required: Option<f64>,
    verdict: Option<Decision>,
}

impl RareShare {
    fn new((event, account): (RareEvent, &Account), answer: &RareAnswer, session: &Session) -> Self {
        const USUAL: f64 = 0.95;
        let Session { plan, judge, .. } = session;
        let confidence = judge.rule.map_or(USUAL, |rule| rule.confidence);
        let point = |&run: &usize| {
            plan.inputs.iter().map(|input| input.name.clone()).zip(plan.at_scores(&answer.scores[run])).collect()
        };
        let share = answer.share.as_ref().ok();
        let interval = share.map(|share| share.interval(confidence));
        Self {
            event,
            surrogate: BySurrogate {
                runs: account.of(answer.scores.len() as u64),
                share: share.map(|share| share.estimate),
                interval,
                reason: answer.share.as_ref().err().map(|unknown| reason(*unknown, answer.inside.len())),
            },
            confidence,
            inside: answer.inside.iter().map(point).collect(),
            required: judge.rule.map(|rule| rule.share),
            verdict: judge.rule.map(|rule| rule.decide(verified(event, interval.unwrap_or([0.0, 1.0])))),
        }
    }

    /// The statement for people.
    fn document(&self) -> Document {
        let Self { surrogate, inside, .. } = self;
        let mut told = Document::new("rare", "Rare", "A share that is too small to be counted");
        let event = word(&self.event).replace('-', " ");
        match (surrogate.share, surrogate.interval, &surrogate.reason) {
            (Some(share), Some([low, high]), _) => told.say(format!(
                "{event}: {} of the space, {} % interval {} to {} (by surrogate)",
                number(share, 3),
                number(100.0 * self.confidence, 4),
                number(low, 3),
                number(high, 3)
            )),
            (_, _, reason) => told.say(format!(
                "{event}: not told by {} runs, as {}; a larger --budget may tell",
                surrogate.runs,
                reason.as_deref().unwrap_or_default()
            )),
        }
        told.say(format!("{} runs, of which {} points are {event}", surrogate.runs, inside.len()));
        if let Some(last) = inside.last() {
            let values = last.iter().map(|(name, value)| format!("{name} {}", number(*value, 4)));
            told.say(format!("one of them: {}", values.collect::<Vec<_>>().join(", ")));
        }
        told.say("The interval holds the surrogate's own error, as far as its runs show it; what is far from all of them goes unseen.");
        if let (Some(required), Some(verdict)) = (self.required, self.verdict) {
            let required = number(required, 4);
            told.say(format!("{verdict}: a share of {required} must be verified"));
        }
        told
    }
}

/// Why a share is not told.
fn reason(unknown: Unknown, inside: usize) -> String {
    match unknown {
        Unknown::Unfit => "too few of them have values, or none fails".to_owned(),
        Unknown::Outside => format!("{inside} of them are of the event"),
        Unknown::Contradicted { deviations } => {
            format!("they contradict what the surrogate said of them by {} deviations", number(deviations, 2))
        }
        Unknown::Open { relative } => format!("they leave it open by {} %", number(100.0 * relative, 2)),
    }
}

/// What an interval of an event's share says of the share of verified points.
fn verified(event: RareEvent, [low, high]: [f64; 2]) -> [f64; 2] {
    match event {
        RareEvent::Verified => [low, high],
        // What is neither may be verified or not.
        RareEvent::NotConforming | RareEvent::Failed => [0.0, 1.0 - low],
    }
}
