//! `sensitivity`: which parameter matters.

use std::path::Path;
use std::process::ExitCode;

use serde::{Deserialize, Serialize};

use super::asking::{self, Analysis, PointSet};
use super::finding::{self, Finding};
use super::{CommandError, cube};
use crate::analysis::from_results;
use crate::analysis::sensitivity::sobol::FirstOrder;
use crate::analysis::sensitivity::study::{
    Output, Sensitivity, from_morris, from_points, from_sobol,
};
use crate::analysis::sensitivity::{morris, sobol};
use crate::analysis::table::PointTable;
use crate::cli;
use crate::pipeline::Pipeline;
use crate::report::format::number;
use crate::report::sensitivity;
use crate::results::origin::Origin;
use crate::results::{ResultsError, points, write_atomically};
use crate::session::Session;
use crate::study::Study;
use crate::table::csv_file;

pub(super) const NAME: &str = "sensitivity";

pub(super) fn run(options: &cli::Sensitivity) -> Result<ExitCode, CommandError> {
    let cli::Sensitivity {
        study,
        means,
        parts,
        output,
        ..
    } = options;
    if let Some(folder) = &options.from {
        let (summary, table) = finding::points_of(folder, &Study::read(study)?)?;
        let result = from_points(&table, options.seed);
        let text = text(&result);
        let finding = Finding::new(
            &result,
            Origin::of_points(&summary),
            text,
            sensitivity::FILE,
        )?;
        return finding.tell(output.as_ref().unwrap_or(folder));
    }
    let analysis = Runs {
        base: options.base,
        morris: options.morris,
        estimator: options.estimator,
        seed: options.seed,
    };
    let session = asking::open(study, means, parts, &analysis)?;
    let folder = asking::folder(output.as_deref(), study, parts, Some(NAME));
    asking::run(session, &analysis, means, parts, &folder)
}

/// An analysis by runs of its own.
#[derive(Debug, Serialize, Deserialize)]
struct Runs {
    /// Base points of the Sobol indices.
    base: u64,
    /// Trajectories of a screening, instead of Sobol indices.
    morris: Option<usize>,
    /// How first-order indices are estimated.
    estimator: FirstOrder,
    seed: u64,
}

pub(super) fn kept(options: serde_json::Value) -> serde_json::Result<Box<dyn Analysis>> {
    Ok(Box::new(serde_json::from_value::<Runs>(options)?))
}

impl Analysis for Runs {
    fn name(&self) -> &'static str {
        NAME
    }

    fn options(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn points(&self, session: &Session) -> Result<PointSet, CommandError> {
        let dimensions = session.plan.varied().len() as u64;
        let (points, method) = match self.morris {
            Some(trajectories) => {
                at_least_two("morris", trajectories as u64)?;
                let points = trajectories as u64 * (dimensions + 1);
                (
                    points,
                    format!("Morris screening by {trajectories} trajectories"),
                )
            }
            None => {
                at_least_two("base", self.base)?;
                let points = self.base * (dimensions + 2);
                (
                    points,
                    format!("Sobol indices from {} base points", self.base),
                )
            }
        };
        Ok(PointSet {
            seed: self.seed,
            points: Some(points),
            method,
            table: None,
        })
    }

    fn find(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        folder: &Path,
    ) -> Result<Finding, CommandError> {
        let result = match self.morris {
            Some(trajectories) => self.screen(session, pipeline, trajectories, folder)?,
            None => self.indices(session, pipeline, folder)?,
        };
        let origin = asking::origin(session)?;
        Finding::new(&result, origin, text(&result), sensitivity::FILE)
    }
}

impl Runs {
    fn indices(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        folder: &Path,
    ) -> Result<Sensitivity, CommandError> {
        let replicates = sobol::replicates(self.base);
        let dimensions = 2 * session.plan.varied().len();
        let pairs = cube::points(dimensions, self.base, self.seed, replicates)
            .map_err(|message| option("base", message))?;
        let rows = simulate(session, pipeline, &sobol::design(&pairs))?;
        keep_runs(folder, &rows)?;
        Ok(from_sobol(&rows, self.estimator, replicates, self.seed))
    }

    fn screen(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        trajectories: usize,
        folder: &Path,
    ) -> Result<Sensitivity, CommandError> {
        const LEVELS: usize = 4;
        // The ends of a distribution may reach far; the grid covers its middle 98 %.
        let cube = morris::design(session.plan.varied().len(), trajectories, LEVELS, self.seed);
        let middle: Vec<Vec<f64>> = cube
            .iter()
            .map(|row| row.iter().map(|u| 0.01 + 0.98 * u).collect())
            .collect();
        let rows = simulate(session, pipeline, &middle)?;
        keep_runs(folder, &rows)?;
        Ok(from_morris(&cube, &rows, self.seed))
    }
}

/// One run tells nothing of how sure it is.
fn at_least_two(name: &'static str, number: u64) -> Result<(), CommandError> {
    if number >= 2 {
        return Ok(());
    }
    let message = format!("{number} is too few; at least 2 are needed");
    Err(option(name, message))
}

fn option(option: &'static str, message: String) -> CommandError {
    CommandError::Option { option, message }
}

/// Simulates points of the unit cube of the parameters that vary.
fn simulate(
    session: &Session,
    pipeline: &mut Pipeline<'_>,
    cube: &[Vec<f64>],
) -> Result<PointTable, CommandError> {
    let plan = &session.plan;
    let points: Vec<Vec<f64>> = cube.iter().map(|u| plan.from_cube(u)).collect();
    let outcomes = pipeline.ask(&points)?;
    let varied = plan.varied();
    Ok(from_results::from_runs(
        &plan.inputs,
        &varied,
        &session.judge,
        &points,
        outcomes,
    ))
}

/// Writes the runs in the order of their design, for other programs to analyse.
fn keep_runs(folder: &Path, rows: &PointTable) -> Result<(), CommandError> {
    std::fs::create_dir_all(folder).map_err(ResultsError::io(folder))?;
    let parameters = rows
        .parameters
        .iter()
        .map(|p| (p.name.as_str(), p.values.as_slice()));
    let criteria = rows
        .criteria
        .iter()
        .map(|c| (c.name.as_str(), c.values.as_slice()));
    let columns: Vec<(&str, &[f64])> = parameters.chain(criteria).collect();
    write_atomically(&folder.join("sensitivity-runs.csv"), |out| {
        let mut table = csv::Writer::from_writer(out);
        let names = columns.iter().map(|(name, _)| *name);
        let names = names.chain(["verified", "status"]);
        table.write_record(names.map(|name| csv_file::cell(name).into_owned()))?;
        for row in 0..rows.len() {
            let cell = |(_, values): &(&str, &[f64])| match values[row] {
                value if value.is_finite() => points::number(value),
                _ => String::new(),
            };
            let status = csv_file::cell(&rows.status[row]).into_owned();
            let verdict = [rows.verified[row].to_string(), status];
            table.write_record(columns.iter().map(cell).chain(verdict))?;
        }
        table.flush()
    })?;
    Ok(())
}

/// A table an output.
fn text(result: &Sensitivity) -> String {
    let mut out = format!("{}\n", result.method);
    if result.failed > 0 {
        out += &format!(
            "{} of {} runs failed; their comparisons are left out\n",
            result.failed, result.runs
        );
    }
    for output in &result.outputs {
        out += &format!("\n{}\n", output.name);
        out += &rows(&result.parameters, output);
        out += &match &output.dominant {
            Some(name) => format!("most important: {name}\n"),
            None => {
                "the intervals overlap: no parameter can be called the most important\n".to_owned()
            }
        };
    }
    out
}

fn rows(parameters: &[String], output: &Output) -> String {
    let width = parameters.iter().map(String::len).max().unwrap_or(0);
    let interval = |e: &crate::analysis::sensitivity::Estimate| {
        format!(
            "{:>8} [{}, {}]",
            number(e.value, 3),
            number(e.low, 3),
            number(e.high, 3)
        )
    };
    let row = |(k, name): (usize, &String)| {
        let mut line = format!("  {name:width$}");
        if let Some(s) = &output.sobol {
            line += &format!(
                "  first {}  total {}",
                interval(&s.first[k]),
                interval(&s.total[k])
            );
        }
        if let Some(effects) = &output.morris {
            line += &format!(
                "  mu* {}  sigma {}",
                interval(&effects[k].mu_star),
                number(effects[k].sigma, 3)
            );
        }
        if let (None, None, Some(p)) = (&output.sobol, &output.morris, &output.pawn) {
            line += &format!("  PAWN {}", interval(&p.median[k]));
        }
        if let (None, Some(partial)) = (
            &output.morris,
            output.ranks.as_ref().and_then(|r| r.partial.get(k)),
        ) {
            line += &format!("  PRCC {}", interval(partial));
        }
        line + "\n"
    };
    parameters.iter().enumerate().map(row).collect()
}
