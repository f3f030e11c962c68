//! `pareto`: what the criteria cost each other.

mod document;

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::asking::{self, Analysis, AnalysisResult, Delivery, PointSet, Takes};
use super::known::{self, Finished};
use crate::error::Error;
use crate::options::Work;
use crate::results::origin::Origin;
use crate::results::table;
use crate::session::{Request, Session};
use parameter_regions::pareto::nsga2;
use parameter_regions::pareto::study::{Member, Pareto, trade_off};
use parameter_regions::table::PointTable;
use point_journal::pipeline::Pipeline;
use result_document::Document;
use study::Study;

pub use document::document;

/// The result's file in a folder of results.
pub const FILE: &str = "pareto.json";

/// Options of `pareto`.
#[derive(Debug, Args)]
#[command(after_help = "Examples: orchestrator pareto studies/paper-table3.toml --from results/paper-table3\n\
    \u{20}         orchestrator pareto studies/paper-table3.toml --generations 50")]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR", conflicts_with = "generations")]
    pub from: Option<PathBuf>,
    /// Search by new runs (NSGA-II) over G generations, instead of using existing points
    #[arg(long, value_name = "G")]
    pub generations: Option<usize>,
    /// Runs in a generation
    #[arg(long, value_name = "N", default_value_t = 100, requires = "generations")]
    pub population: usize,
    /// The seed of the search
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
}

/// A result in the folder of a finished study, as its page shows it.
pub(super) fn shown(study: &Finished<'_>) -> Option<Document> {
    study.result(FILE).map(|result| document(&result))
}

/// Runs the command.
///
/// # Errors
/// When the options, the study or its points cannot be used.
pub fn run(options: &Options) -> Result<Delivery, Error> {
    let Work { study, output, .. } = &options.work;
    let from = known::from(options.from.as_deref(), study);
    let analysis = match options.generations {
        Some(generations) => Asked::Search { generations, population: options.population, seed: options.seed },
        None => Asked::Points { from: known::absolute(&from) },
    };
    let folder = output.clone().unwrap_or_else(|| from.clone());
    let session = asking::open(&options.work, &analysis);
    let bound = !matches!(session, Err(Error::File(_)));
    let run = |session| asking::run(session, &analysis, &options.work, folder.clone());
    match session.and_then(run) {
        // Without the FMU the front is the same, but the nominal design cannot be run.
        Err(error) if options.generations.is_none() && (!bound || matches!(error, Error::Fmu(_))) => {
            let result = of_points(&from, &Study::read(study)?, |_| Ok(None))?;
            Delivery::without_runs(result, &options.work, folder)
        }
        other => other,
    }
}

/// Where the points come from of which the front is chosen.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Asked {
    /// From a search by runs of its own.
    Search {
        /// How many generations.
        generations: usize,
        /// Runs in each.
        population: usize,
        /// The seed.
        seed: u64,
    },
    /// From a finished study; the nominal design is run to be compared.
    Points {
        /// Its folder.
        from: PathBuf,
    },
}

impl Analysis for Asked {
    const NAME: &'static str = "pareto";

    type Source = Session;

    fn open(&self, request: Request) -> Result<Session, Error> {
        asking::session(request, Takes::default())
    }

    fn points(&self, _: &Session) -> Result<PointSet, Error> {
        // A search over more generations begins as one over fewer, so their number is left out.
        Ok(match self {
            Self::Search { population, seed, .. } => PointSet {
                seed: *seed,
                points: None,
                method: format!("NSGA-II in generations of {population}"),
                table: None,
            },
            Self::Points { from } => PointSet {
                seed: 0,
                points: Some(1),
                method: "the nominal design".to_owned(),
                table: Some(known::digest_of(from)?),
            },
        })
    }

    fn one_piece(&self) -> Option<&'static str> {
        Some(match self {
            Self::Search { .. } => {
                "each generation depends on the one before, so a search has no parts; --resume goes on with one"
            }
            Self::Points { .. } => "a single point is run; there are no parts of it",
        })
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline<'_>, _: &Path) -> Result<AnalysisResult, Error> {
        match *self {
            Self::Search { generations, population, seed } => {
                let settings = nsga2::Evolution { population, generations, seed };
                let table = search(session, pipeline, settings)?;
                let nominal = nominal(session, pipeline)?;
                let inputs = &session.plan.inputs;
                let cut = inputs.iter().filter(|input| input.distribution.reach() != [0.0, 1.0]);
                let cut: Vec<&str> = cut.map(|input| input.name.as_str()).collect();
                let within = match cut[..] {
                    [] => String::new(),
                    _ => format!(
                        " (within the quantiles 0.001 and 0.999 where a distribution has no end: {})",
                        cut.join(", ")
                    ),
                };
                let method = format!("NSGA-II over {generations} generations of {population}{within}");
                let result = trade_off(&table, false, Some(nominal), method);
                result_of(result, asking::origin(session)?)
            }
            Self::Points { ref from } => of_points(from, &session.study, |table| {
                let same_count = session.plan.inputs.len() == table.parameters.len();
                same_count.then(|| nominal(session, pipeline)).transpose()
            }),
        }
    }
}

/// The front of a finished study's points, with the nominal design where that can be run.
fn of_points(
    from: &Path,
    study: &Study,
    nominal: impl FnOnce(&PointTable) -> Result<Option<Member>, Error>,
) -> Result<AnalysisResult, Error> {
    let (summary, table) = known::points_of(from, study, table::read)?;
    let nominal = nominal(&table)?;
    let result = trade_off(&table, true, nominal, "the study's points".to_owned());
    result_of(result, Origin::of_points(&summary))
}

fn result_of(result: Option<Pareto>, origin: Origin) -> Result<AnalysisResult, Error> {
    let result = result.ok_or_else(|| Error::Search("no point has values".to_owned()))?;
    Ok(AnalysisResult::new(&result, origin, document(&result).as_text(), FILE))
}

/// The parameters at the medians of their distributions.
fn nominal(session: &Session, pipeline: &mut Pipeline<'_>) -> Result<Member, Error> {
    let middle = vec![0.5; session.plan.varied().len()];
    let points = [session.plan.from_cube(&middle)];
    let outcomes = pipeline.ask(&points)?;
    Ok(Member::of(&asking::table(session, &points, outcomes), 0))
}

/// All runs of a search, to the ends of bounded distributions and over the middle of others.
fn search(session: &Session, pipeline: &mut Pipeline<'_>, settings: nsga2::Evolution) -> Result<PointTable, Error> {
    let varied = session.plan.varied();
    let limits: Vec<[f64; 2]> = (varied.iter()).map(|&k| session.plan.inputs[k].distribution.reach()).collect();
    let (mut points, mut outcomes) = (Vec::new(), Vec::new());
    nsga2::minimise(&limits, settings, |cube| {
        let asked: Vec<Vec<f64>> = cube.iter().map(|u| session.plan.from_cube(u)).collect();
        let answers = pipeline.ask(&asked)?;
        let table = asking::table(session, &asked, answers.clone());
        points.extend(asked);
        outcomes.extend(answers);
        Ok::<_, Error>((0..cube.len()).map(|i| Member::of(&table, i).deviations).collect())
    })?;
    Ok(asking::table(session, &points, outcomes))
}
