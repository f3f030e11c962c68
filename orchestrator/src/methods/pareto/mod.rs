//! `pareto`: what the criteria cost each other.

mod document;

use std::path::PathBuf;

use clap::Args;

use super::{
    asking::{AnalysisResult, Delivery},
    known,
};
use crate::{
    error::{Error, Result},
    results::origin::Origin,
};
use parameter_regions::pareto::study::trade_off;
use point_journal::pipeline::folder::Earlier;
use study::Study;

pub use document::document;

/// The result's file in a folder of results.
pub const FILE: &str = "pareto.json";

/// Options of `pareto`.
#[derive(Debug, Args)]
#[command(after_help = "Example: orchestrator pareto studies/paper-table3.toml --from results/paper-table3")]
pub struct Options {
    /// The study, a TOML file
    pub study: PathBuf,
    /// The folder of the finished study [default: --output, if it is there, or results/ and the study's name]
    #[arg(long, value_name = "DIR")]
    pub from: Option<PathBuf>,
    /// The folder for the results [default: that of the finished study]
    #[arg(long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Replace the results of another study there
    #[arg(long)]
    pub force: bool,
}

/// Runs the command.
///
/// # Errors
/// When the study or its points cannot be used.
pub fn run(options: &Options) -> Result<Delivery> {
    let from = known::from(options.from.as_deref(), options.output.as_deref(), &options.study);
    let (summary, table) = known::points_of(&from, &Study::read(&options.study)?)?;
    let result = trade_off(&table).ok_or_else(|| Error::Search("no point has values".to_owned()))?;
    let result = AnalysisResult::new(&result, Origin::of_points(&summary), &document(&result), FILE);
    let earlier = if options.force { Earlier::Replaced } else { Earlier::Complete };
    Delivery::without_runs(result, &options.study, earlier, options.output.clone().unwrap_or(from))
}
