//! `sensitivity`: which parameter matters.

use std::path::Path;
use std::process::ExitCode;

use super::batch::{self, Batch};
use super::{CommandError, finding};
use crate::analysis::from_results;
use crate::analysis::sensitivity::study::{
    Output, Sensitivity, from_morris, from_points, from_sobol,
};
use crate::analysis::sensitivity::{morris, sobol};
use crate::analysis::table::PointTable;
use crate::cli;
use crate::report::format::number;
use crate::report::sensitivity;
use crate::results::origin::Origin;
use crate::results::{ResultsError, points, write_atomically};
use crate::table::csv_file;

pub(super) fn run(options: &cli::Sensitivity) -> Result<ExitCode, CommandError> {
    let (folder, origin, result) = match &options.from {
        Some(folder) => {
            let (summary, table) = finding::points_of(folder, &options.study)?;
            let origin = Origin::of_points(&summary);
            let target = options.output.clone().unwrap_or_else(|| folder.clone());
            (target, origin, from_points(&table, options.seed))
        }
        None => {
            let batch = Batch::new(&options.study, &options.means)?;
            let folder = options
                .output
                .clone()
                .unwrap_or_else(|| finding::folder_of(&options.study));
            let result = match options.morris {
                Some(trajectories) => screen(&batch, trajectories, options.seed, &folder)?,
                None => indices(&batch, options, &folder)?,
            };
            (folder, batch.origin, result)
        }
    };
    finding::tell(&result, &origin, &text(&result), &folder, sensitivity::FILE)
}

fn indices(
    batch: &Batch,
    options: &cli::Sensitivity,
    folder: &Path,
) -> Result<Sensitivity, CommandError> {
    let (base, seed) = (options.base, options.seed);
    at_least_two("base", base)?;
    let varied = batch.varied();
    let replicates = sobol::replicates(base);
    let pairs = batch::cube(2 * varied.len(), base, seed, replicates).map_err(|message| {
        CommandError::Option {
            option: "base",
            message,
        }
    })?;
    let rows = simulate(batch, &sobol::design(&pairs))?;
    keep_runs(folder, &rows)?;
    Ok(from_sobol(&rows, options.estimator, replicates, seed))
}

fn screen(
    batch: &Batch,
    trajectories: usize,
    seed: u64,
    folder: &Path,
) -> Result<Sensitivity, CommandError> {
    const LEVELS: usize = 4;
    at_least_two("morris", trajectories as u64)?;
    // The ends of a distribution may reach far; the grid covers its middle 98 %.
    let cube = morris::design(batch.varied().len(), trajectories, LEVELS, seed);
    let middle: Vec<Vec<f64>> = cube
        .iter()
        .map(|row| row.iter().map(|u| 0.01 + 0.98 * u).collect())
        .collect();
    let rows = simulate(batch, &middle)?;
    keep_runs(folder, &rows)?;
    Ok(from_morris(&cube, &rows, seed))
}

/// One run tells nothing of how sure it is.
fn at_least_two(option: &'static str, number: u64) -> Result<(), CommandError> {
    if number >= 2 {
        return Ok(());
    }
    let message = format!("{number} is too few; at least 2 are needed");
    Err(CommandError::Option { option, message })
}

/// Simulates points of the unit cube of the parameters that vary.
fn simulate(batch: &Batch, cube: &[Vec<f64>]) -> Result<PointTable, CommandError> {
    let points: Vec<Vec<f64>> = cube.iter().map(|u| batch.parameters(u)).collect();
    let outcomes = batch.run(&points)?;
    let varied = batch.varied();
    Ok(from_results::from_runs(
        &batch.plan.inputs,
        &varied,
        &batch.judge,
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
