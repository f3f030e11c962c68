//! `verify --rare`: shares that are too small to be counted among sampled points.

mod statement;

use std::collections::HashMap;
use std::path::Path;
use std::process::ExitCode;

use clap::ValueEnum;
use serde::Serialize;

use super::asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes, exit_code};
use crate::error::Error;
use crate::judge::Judge;
use crate::options::Work;
use crate::results::points::number;
use crate::session::{Request, Session};
use number_tables::csv_file;
use point_journal::Outcome;
use point_journal::files::write_table;
use point_journal::pipeline::Pipeline;
use sampling::rare::{self, Answer, FEWEST_RUNS, Judged, Search};
use sampling::word;
use statement::{Statement, confidence};

const FILE: &str = "rare.json";
const TABLE: &str = "rare.csv";
const USUAL_RUNS: u64 = 100_000;

/// A share that `verify --rare` finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ValueEnum)]
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
    /// The largest number of runs.
    pub points: Option<u64>,
    /// The seed, instead of the study's.
    pub seed: Option<u64>,
}

/// Runs the search.
///
/// # Errors
/// When the options or the study cannot be used.
pub fn run(options: &Options) -> Result<Delivery, Error> {
    let points = options.points.unwrap_or(USUAL_RUNS);
    if points < FEWEST_RUNS {
        let message = format!("a rare share takes at least {FEWEST_RUNS} runs; give more, or leave it out");
        return Err(Error::option("points", message));
    }
    let mut analysis = Rare { event: options.event, points, seed: 1 };
    let session = asking::open(&options.work, &analysis)?;
    analysis.seed = options.seed.unwrap_or(session.study.design.seed);
    // A refusal is one line, without doubts before it.
    analysis.check(&session)?;
    asking::warn(&session.judge);
    let folder = options.work.folder(None)?;
    asking::run(session, &analysis, &options.work, folder)
}

/// Refuses studies of which a rare share says nothing.
fn refuse(session: &Session, event: RareEvent) -> Result<(), Error> {
    if event != RareEvent::Failed && session.judge.has_own_values() {
        let message =
            "a share of verified points needs measured values; write them as `nominal` and remove `nominal-from`";
        return Err(session.study.error(message).into());
    }
    if let Some(joint) = session.plan.joints.first() {
        let name = &session.plan.inputs[joint.lead()].name;
        let message = format!(
            "{name} is drawn from a sample of {} rows, which knows nothing as rare as --rare looks for; give the \
             parameters of the sample other distributions, or leave out --rare",
            joint.count()
        );
        return Err(session.study.error(message).into());
    }
    if session.judge.is_guarded() {
        let message = "--rare counts points by their tolerances alone, and a guard band decides otherwise; remove `risk` \
                       and `guard-band` under [verdict]";
        return Err(session.study.error(message).into());
    }
    Ok(())
}

/// A search for a rare share.
#[derive(Debug, Serialize)]
struct Rare {
    event: RareEvent,
    /// The largest number of runs.
    points: u64,
    seed: u64,
}

impl Rare {
    /// The meaning of a run for the search.
    fn judge(&self, judge: &Judge, outcome: &Outcome) -> Judged {
        let values = outcome.as_deref().ok();
        let verified = judge.verdict(values).verified();
        let failed = values.is_none();
        let deviation = values.map_or(f64::INFINITY, |values| deviation(judge, values));
        match self.event {
            RareEvent::Verified => Judged { level: deviation, met: verified, failed },
            RareEvent::NotConforming => Judged { level: -deviation, met: !failed && !verified, failed },
            RareEvent::Failed => Judged { level: 0.0, met: failed, failed },
        }
    }
}

/// The largest deviation from a measured value, in its tolerance.
fn deviation(judge: &Judge, values: &[f64]) -> f64 {
    let pairs = judge.criteria.iter().zip(values);
    pairs.map(|(criterion, &value)| criterion.level(value)).fold(f64::NAN, f64::max)
}

impl Analysis for Rare {
    const NAME: &'static str = "rare";

    type Source = Session;

    fn points(&self, _: &Session) -> Result<PointSet, Error> {
        Ok(PointSet {
            seed: self.seed,
            // The search ends when it knows enough.
            points: None,
            method: format!("{} with at most {} runs", word(&self.event), self.points),
            table: None,
        })
    }

    fn one_piece(&self) -> Option<&'static str> {
        Some("each set of points depends on the ones before; run it in one piece")
    }

    fn open(&self, request: Request) -> Result<Session, Error> {
        // `check` refuses samples with a reason of its own.
        asking::session(request, Takes::ALL)
    }

    fn check(&self, session: &Session) -> Result<(), Error> {
        refuse(session, self.event)
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline<'_>, folder: &Path) -> Result<AnalysisResult, Error> {
        let Session { plan, judge, .. } = session;
        let search = Search {
            dimensions: plan.varied().len(),
            runs: self.points,
            seed: self.seed,
            confidence: confidence(self.event, judge.rule),
            is_binary: self.event == RareEvent::Failed,
        };
        // The outcomes at points of the event, which go into the table.
        let mut met: HashMap<Vec<u64>, Outcome> = HashMap::new();
        let mut ask = |scores: &[Vec<f64>]| -> Result<Vec<Judged>, Error> {
            let points: Vec<Vec<f64>> = scores.iter().map(|scores| plan.at_scores(scores)).collect();
            let outcomes = pipeline.ask(&points)?;
            let mut results = Vec::with_capacity(outcomes.len());
            for (scores, outcome) in scores.iter().zip(outcomes) {
                let judged = self.judge(judge, &outcome);
                if judged.met {
                    met.insert(bits(scores), outcome);
                }
                results.push(judged);
            }
            Ok(results)
        };
        let answer = rare::share(&search, &mut ask)?;
        write_points(&folder.join(TABLE), session, &answer, &met)?;
        let statement = Statement::new(self.event, &search, &answer, session);
        let origin = asking::origin(session)?;
        let mut result = AnalysisResult::new(&statement, origin, statement.document().as_text(), FILE);
        result.code = match (statement.verdict, self.event) {
            (Some(verdict), _) => exit_code(Some(verdict)),
            // One verified point is enough.
            (None, RareEvent::Verified) if answer.sample.is_empty() => exit_code(None),
            (None, _) => ExitCode::SUCCESS,
        };
        Ok(result)
    }
}

fn bits(scores: &[f64]) -> Vec<u64> {
    scores.iter().map(|score| score.to_bits()).collect()
}

/// The points of the event that the share rests on, each with the share that it stands for.
fn write_points(
    path: &Path,
    session: &Session,
    answer: &Answer,
    outcomes: &HashMap<Vec<u64>, Outcome>,
) -> Result<(), Error> {
    let Session { plan, judge, .. } = session;
    let parameters = plan.inputs.iter().map(|input| input.name.as_str());
    let names = parameters.chain(judge.names().map(String::as_str));
    let head = ["weight"].into_iter().chain(names).chain(["status"]);
    Ok(write_table(path, head, |table| {
        for point in &answer.sample {
            let mut record = vec![number(point.weight)];
            record.extend(plan.at_scores(&point.scores).into_iter().map(number));
            match outcomes.get(&bits(&point.scores)) {
                Some(Ok(values)) => {
                    record.extend(values.iter().map(|&value| number(value)));
                    record.push("ok".to_owned());
                }
                Some(Err(failure)) => {
                    record.extend(judge.criteria.iter().map(|_| String::new()));
                    record.push(csv_file::cell(&failure.to_string()).into_owned());
                }
                None => continue,
            }
            table.write_record(record)?;
        }
        Ok(())
    })?)
}
