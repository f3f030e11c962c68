//! `robustness`: how far the parameters may go.

mod confirm;
mod document;

use std::path::{Path, PathBuf};

use clap::Args;

use super::{
    asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes},
    known,
};
use crate::{
    error::{Error, Result},
    options::Work,
    results::origin::Origin,
    session::{Request, Session, absolute},
};
use confirm::Confirmation;
use parameter_regions::{
    robustness::{Robustness, region, robustness, rows},
    table::PointTable,
};
use point_journal::pipeline::Pipeline;
use sampling::design::{Design, Method, Sampling, cube};
use study::{Study, plan::Plan};

pub use document::document;

/// The result's file in a folder of results.
pub const FILE: &str = "robustness.json";

/// Options of `robustness`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator robustness studies/paper-table3.toml \
    --from results/paper-table3 --level 0.9")]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study [default: --output, if it is there, or results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// The share of the box that must be verified [default: the study's, or 0.9]
    #[arg(long, value_name = "P")]
    pub level: Option<f64>,
    /// Confirm the box by N new runs [default: the study's, or 0]
    #[arg(long, value_name = "N")]
    pub confirm: Option<usize>,
    /// The same with at most N runs, those of other budgets in the folder included
    #[arg(long, value_name = "N", conflicts_with = "confirm")]
    pub budget: Option<u64>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When the options, the study or its points cannot be used.
pub fn run(options: &Options) -> Result<Delivery> {
    let work = &options.work;
    let from = known::from(options.from.as_deref(), work.output.as_deref(), &work.study);
    let study = Study::read(&work.study)?;
    let said = &study.robustness;
    let mut analysis = Asked {
        from: absolute(&from),
        level: level(options, &study)?,
        confirm: options.confirm.or(said.confirm).unwrap_or(0),
        seed: options.seed.or(said.seed).unwrap_or(1),
    };
    let mut session = asking::open(work, &analysis);
    let folder = work.output.clone().unwrap_or(from);
    if let Some(runs) = options.budget {
        let mut opened = session?;
        analysis.confirm = opened.account(&folder, (Asked::NAME, work.resuming.resume), runs)?.points() as usize;
        session = Ok(opened);
    }
    if analysis.confirm > 0 {
        return asking::run(session?, &analysis, work, folder);
    }
    if work.resuming.resume && options.budget.is_none() {
        return Err(Error::option("confirm", "without new runs there is nothing to resume; add --confirm N"));
    }
    // Without the FMU there are no new runs, but all else can be told, unless it takes what binds the study's parameters.
    let session = match session {
        Err(error) if !study.correlations.is_empty() || study.binds_by_samples() => {
            return Err(error);
        }
        other => other.ok(),
    };
    let plan = session.as_ref().map(|session| &session.plan);
    let (origin, points, cloud) = analysis.known(&study, plan)?;
    let mut result = analysis.stated(&points, &cloud)?;
    if let Some(plan) = plan {
        result.keep_together(&plan.together());
    }
    let mut told = AnalysisResult::new(&result, origin, &document(&result), FILE);
    if let Some(account) = session.as_ref().and_then(|session| session.request.account.as_ref()) {
        told.text += &format!("note: the budget has no run left to confirm the box{}\n", account.told());
    }
    Delivery::without_runs(told, &work.study, work.resuming.earlier(), folder)
}

/// The probability that the box must hold.
fn level(options: &Options, study: &Study) -> Result<f64> {
    const MESSAGE: &str = "must lie between 0 and 1";
    let inside = |level: f64| level > 0.0 && level < 1.0;
    match (options.level, &study.robustness.level) {
        (Some(level), _) if inside(level) => Ok(level),
        (Some(_), _) => Err(Error::option("level", MESSAGE)),
        (None, Some(level)) if inside(*level.as_ref()) => Ok(*level.as_ref()),
        (None, Some(level)) => Err(study.error_at(level, format!("level {MESSAGE}")).into()),
        (None, None) => Ok(0.9),
    }
}

/// Statements from the points of a finished study, confirmed by new runs if wanted.
#[derive(Debug)]
pub struct Asked {
    /// The folder of the finished study.
    from: PathBuf,
    /// The verification probability that the box must hold.
    level: f64,
    /// New runs in it.
    confirm: usize,
    seed: u64,
}

impl Asked {
    /// The points of the finished study, to which results they belong, and a large sample of its distributions.
    fn known(&self, study: &Study, plan: Option<&Plan>) -> Result<(Origin, Points, Vec<Vec<f64>>)> {
        let (summary, table) = known::points_of(&self.from, study)?;
        let cloud = cloud(plan, &table, self.seed)?;
        let sample = known::sample_of(&self.from, &summary, table.len())?;
        let chosen: Vec<usize> = (0..table.len()).filter(|row| sample.binary_search(row).is_err()).collect();
        let rows = [&sample[..], &chosen].concat();
        Ok((Origin::of_points(&summary), Points { sample: table.subset(&sample), all: table.subset(&rows) }, cloud))
    }

    fn stated(&self, points: &Points, cloud: &[Vec<f64>]) -> Result<Robustness> {
        robustness(&points.sample, &points.all, cloud, self.level).ok_or_else(|| {
            Error::option("from", "the points are too few for a surrogate, or no parameter varies: verify more points")
        })
    }
}

/// The points of a study: surrogates are fitted to all, and those that are a sample of the space say how far they are right.
struct Points {
    sample: PointTable,
    /// The sample, and behind it points that `--budget` chose.
    all: PointTable,
}

impl Analysis for Asked {
    const NAME: &'static str = "robustness";

    type Source = Session;

    fn open(&self, request: Request) -> Result<Session> {
        asking::session(request, Takes::ALL)
    }

    fn points(&self, _: &Session) -> Result<PointSet> {
        Ok(PointSet {
            seed: self.seed,
            points: None,
            method: format!("{} runs to confirm the level {}", self.confirm, self.level),
            table: Some(known::digest_of(&self.from)?),
        })
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline, _: &Path) -> Result<AnalysisResult> {
        let (origin, known, cloud) = self.known(&session.study, Some(&session.plan))?;
        let stated = self.stated(&known, &cloud)?;
        if session.request.account.is_some() {
            pipeline.repeat_at_most(1);
        }
        let mut confirmed =
            Confirmation { session, pipeline, known: &known, points: self.confirm, seed: self.seed }.of(stated)?;
        confirmed.keep_together(&session.plan.together());
        Ok(AnalysisResult::new(&confirmed, origin, &document(&confirmed), FILE))
    }
}

/// A large sample from the study's distributions, in the order of the table's parameters; from the
/// points themselves where the FMU is not there to convert units.
fn cloud(plan: Option<&Plan>, table: &PointTable, seed: u64) -> Result<Vec<Vec<f64>>> {
    const SIZE: u64 = 65_536;
    let names = table.parameters.iter().map(|p| &p.name);
    let Some(plan) = plan.filter(|plan| plan.inputs.iter().map(|i| &i.name).eq(names)) else {
        return Ok(region::cloud(&rows(table), seed));
    };
    let wrong = |message| Error::option("seed", message);
    if plan.is_independent() {
        let net = cube(plan.varied().len(), SIZE, seed, 1).map_err(wrong)?;
        return Ok(net.iter().map(|u| plan.from_cube(u)).collect());
    }
    let points = joint(plan, SIZE, seed).map_err(wrong)?;
    Ok((0..SIZE).map(|index| points.point(index)).collect())
}

/// Independent points of the study's joint distribution, correlations included.
fn joint(plan: &Plan, points: u64, seed: u64) -> Result<Design, String> {
    plan.design(&Sampling { method: Method::MonteCarlo, points, seed, ..Sampling::default() })
}
