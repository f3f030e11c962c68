//! `sensitivity`: which parameter matters. The crate `sensitivity` has the methods; here they meet a study's points.

mod document;
mod failures;
mod from_points;
mod outputs;

use std::path::{Path, PathBuf};

use clap::Args;

use super::asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes};
use crate::{
    error::{Error, Result},
    options::Work,
    results::{points, table},
    session::{Request, Session},
};
use ::sensitivity::{
    RUNS,
    method::{FromRuns, Settled},
    named,
};
use number_tables::csv_file;
use outputs::from_runs;
use parameter_regions::table::PointTable;
use point_journal::{
    files::{make_output, write_table},
    pipeline::Pipeline,
};
use study::Study;

pub use document::document;
pub use outputs::Sensitivity;

/// The result's file in a folder of results.
pub const FILE: &str = "sensitivity.json";

/// Options of `sensitivity`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator sensitivity studies/paper-table3.toml --base 256")]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// Indices by a surrogate of the points of a finished study, without a further run
    #[arg(long, value_name = "DIR", conflicts_with_all = ["base", "morris"])]
    pub from: Option<PathBuf>,
    /// The same from at most N runs of the FMU in all: those of `verify --budget N` in this folder, where they are there
    #[arg(long, value_name = "N", conflicts_with_all = ["from", "base", "morris"])]
    pub budget: Option<u64>,
    /// Sobol indices from N base points: N (d + 2) runs for d parameters [default: what the study says, or 256]
    #[arg(long, value_name = "N", conflicts_with = "morris")]
    pub base: Option<u64>,
    /// Morris screening with R trajectories: R (d + 1) runs
    #[arg(long, value_name = "R")]
    pub morris: Option<u64>,
    /// The seed [default: the study's, or 1]
    #[arg(long, value_name = "S")]
    pub seed: Option<u64>,
}

/// Runs the command.
///
/// # Errors
/// When the options, the study or its points cannot be used.
pub fn run(options: &Options) -> Result<Delivery> {
    let study = Study::read(&options.work.study)?;
    let analysis = Asked::new(options, &study)?;
    if let Some(from) = &options.from {
        return of_points(options, from, analysis.settled.seed);
    }
    let session = asking::open(&options.work, &analysis)?;
    asking::run(session, &analysis, &options.work, options.work.folder())
}

/// Indices from the points in a folder.
fn of_points(options: &Options, from: &Path, seed: u64) -> Result<Delivery> {
    let work = &options.work;
    let session =
        asking::session(asking::request(&work.study, &work.means), Takes { correlations: true, samples: false })?;
    let result = from_points::find(&session, from, seed)?;
    let folder = work.output.clone().unwrap_or_else(|| from.to_owned());
    let result = AnalysisResult::new(&result, asking::origin(&session)?, &document(&result), FILE);
    Delivery::without_runs(result, &work.study, work.resuming.earlier(), folder)
}

/// An analysis by runs of its own.
pub struct Asked {
    method: &'static dyn FromRuns,
    settled: Settled,
}

impl Asked {
    /// The settings from the options, else from the study, else the defaults.
    fn new(options: &Options, study: &Study) -> Result<Self> {
        let said = &study.sensitivity;
        let method = said.method.as_ref().map(|name| {
            named(name.as_ref()).map_err(|message| {
                let elsewhere =
                    if name.as_ref() == "shapley" { "; --budget N and --from DIR tell Shapley effects" } else { "" };
                study.error_at(name, message + elsewhere)
            })
        });
        let usual = method.transpose()?.unwrap_or(RUNS[0]);
        let sizes = [("base", options.base), ("morris", options.morris)];
        let asked = sizes.iter().find_map(|(option, size)| {
            let method = RUNS.iter().find(|method| method.facts().option == *option)?;
            Some((*method, Some((*size)?)))
        });
        let (method, size) = match asked {
            Some(asked) => asked,
            None => {
                if let Some(size) = &said.size {
                    enough(*size.as_ref()).map_err(|message| study.error_at(size, message))?;
                }
                (usual, said.size.as_ref().map(|size| *size.as_ref()))
            }
        };
        let size = size.unwrap_or(method.facts().usual_size);
        Ok(Self { method, settled: Settled { size, seed: options.seed.or(said.seed).unwrap_or(1) } })
    }
}

impl Analysis for Asked {
    const NAME: &'static str = "sensitivity";

    type Source = Session;

    fn open(&self, request: Request) -> Result<Session> {
        asking::session(request, Takes { correlations: false, samples: false })
    }

    fn points(&self, session: &Session) -> Result<PointSet> {
        let Self { method, settled: Settled { size, seed } } = *self;
        enough(size).map_err(|message| Error::option(method.facts().option, message))?;
        Ok(PointSet {
            seed,
            points: Some(method.runs(session.plan.varied().len(), size)),
            method: method.title(size),
            table: None,
        })
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline, folder: &Path) -> Result<AnalysisResult> {
        let method = self.method;
        let design = method
            .design(session.plan.varied().len(), &self.settled)
            .map_err(|message| Error::option(method.facts().option, message))?;
        let plan = &session.plan;
        let points: Vec<Vec<f64>> = design.iter().map(|u| plan.from_cube(u)).collect();
        let outcomes = pipeline.ask(&points)?;
        let rows = table::from_runs(plan, &plan.varied(), &session.judge, &points, outcomes);
        keep_runs(folder, &rows)?;
        let result = from_runs(method, &design, &rows, &self.settled);
        Ok(AnalysisResult::new(&result, asking::origin(session)?, &document(&result), FILE))
    }
}

/// One base point or trajectory tells nothing of how sure it is.
fn enough(size: u64) -> Result<(), String> {
    if size < 2 { Err(format!("{size} is too few; at least 2 are needed")) } else { Ok(()) }
}

/// Writes the runs in the order of their design, for other programs to analyse.
fn keep_runs(folder: &Path, rows: &PointTable) -> Result {
    make_output(folder)?;
    let parameters = rows.parameters.iter().map(|p| (&*p.name, &*p.values));
    let criteria = rows.criteria.iter().map(|c| (&*c.name, &*c.values));
    let columns: Vec<(&str, &[f64])> = parameters.chain(criteria).collect();
    let head = columns.iter().map(|(name, _)| *name).chain(["verified", "status"]);
    let path = folder.join("sensitivity-runs.csv");
    Ok(write_table(&path, head, |table| {
        for row in 0..rows.len() {
            let cell = |(_, values): &(&str, &[f64])| match values[row] {
                value if value.is_finite() => points::number(value),
                _ => String::new(),
            };
            let status = csv_file::cell(&rows.status[row]).into_owned();
            let verdict = [rows.verified[row].to_string(), status];
            table.write_record(columns.iter().map(cell).chain(verdict))?;
        }
        Ok(())
    })?)
}
