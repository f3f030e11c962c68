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
use crate::session::{Request, Session};
use parameter_regions::pareto::study::{Member, trade_off};
use parameter_regions::table::PointTable;
use point_journal::pipeline::Pipeline;
use result_document::Document;
use study::Study;

pub use document::document;

/// The result's file in a folder of results.
pub const FILE: &str = "pareto.json";

/// Options of `pareto`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator pareto studies/paper-table3.toml --from results/paper-table3")]
pub struct Options {
    /// The study, how its points are run, and where the results go
    #[command(flatten)]
    pub work: Work,
    /// The folder of the finished study [default: results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
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
    let analysis = Asked { from: known::absolute(&from) };
    let folder = output.clone().unwrap_or_else(|| from.clone());
    let session = asking::open(&options.work, &analysis);
    let bound = !matches!(session, Err(Error::File(_)));
    let run = |session| asking::run(session, &analysis, &options.work, folder.clone());
    match session.and_then(run) {
        // Without the FMU the front is the same, but the nominal design cannot be run.
        Err(error) if !bound || matches!(error, Error::Fmu(_)) => {
            let result = of_points(&from, &Study::read(study)?, |_| Ok(None))?;
            Delivery::without_runs(result, &options.work, folder)
        }
        other => other,
    }
}

/// The front of a finished study's points; the nominal design is run to be compared.
#[derive(Debug, Serialize, Deserialize)]
pub struct Asked {
    /// The folder of the study.
    from: PathBuf,
}

impl Analysis for Asked {
    const NAME: &'static str = "pareto";

    type Source = Session;

    fn open(&self, request: Request) -> Result<Session, Error> {
        asking::session(request, Takes::default())
    }

    fn points(&self, _: &Session) -> Result<PointSet, Error> {
        Ok(PointSet {
            seed: 0,
            points: Some(1),
            method: "the nominal design".to_owned(),
            table: Some(known::digest_of(&self.from)?),
        })
    }

    fn one_piece(&self) -> Option<&'static str> {
        Some("a single point is run; there are no parts of it")
    }

    fn find(&self, session: &Session, pipeline: &mut Pipeline<'_>, _: &Path) -> Result<AnalysisResult, Error> {
        of_points(&self.from, &session.study, |table| {
            let same_count = session.plan.inputs.len() == table.parameters.len();
            same_count.then(|| nominal(session, pipeline)).transpose()
        })
    }
}

/// The front of a finished study's points, with the nominal design where that can be run.
fn of_points(
    from: &Path,
    study: &Study,
    nominal: impl FnOnce(&PointTable) -> Result<Option<Member>, Error>,
) -> Result<AnalysisResult, Error> {
    let (summary, table) = known::points_of(from, study)?;
    let nominal = nominal(&table)?;
    let result = trade_off(&table, nominal).ok_or_else(|| Error::Search("no point has values".to_owned()))?;
    Ok(AnalysisResult::new(&result, Origin::of_points(&summary), document(&result).as_text(), FILE))
}

/// The parameters at the medians of their distributions.
fn nominal(session: &Session, pipeline: &mut Pipeline<'_>) -> Result<Member, Error> {
    let middle = vec![0.5; session.plan.varied().len()];
    let points = [session.plan.from_cube(&middle)];
    let outcomes = pipeline.ask(&points)?;
    Ok(Member::of(&asking::table(session, &points, outcomes), 0))
}
