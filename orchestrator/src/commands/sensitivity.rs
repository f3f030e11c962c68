//! `sensitivity`: which parameter matters.

use std::path::Path;
use std::process::ExitCode;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::CommandError;
use super::asking::{self, Analysis, PointSet};
use super::finding::{self, AnalysisResult};
use crate::analysis::from_results;
use crate::analysis::sensitivity::study::{Output, Sensitivity, from_points, from_runs};
use crate::cli;
use crate::pipeline::Pipeline;
use crate::report::format::number;
use crate::report::sensitivity as shown;
use crate::results::origin::Origin;
use crate::results::{make_folder, points, write_atomically};
use crate::session::Session;
use crate::study::Study;
use crate::study::plan::Plan;
use crate::table::csv_file;
use ::sensitivity::Estimate;
use ::sensitivity::method::{self, FirstOrder, Measure, Settled, Space};
use ::sensitivity::methods::{RUNS, named};
use parameter_regions::table::PointTable;

pub(super) const NAME: &str = "sensitivity";

/// The meaning of the numbers from points of correlated parameters.
const CORRELATED: &str = "the parameters are correlated, so PAWN, rank correlations and the distance of verified points tell \
    how much the value of a parameter says of the output, with all that it says of the parameters that it is correlated with: \
    one without any influence may be called the most important. Partial correlations (PRCC) take the others' linear relation \
    between ranks away, and no other. Shapley effects (`sensitivity STUDY --shapley N`) divide the variance among correlated \
    parameters";

/// The same where parameters come together from a sample.
const SAMPLED: &str = "parameters are drawn together from a sample, so PAWN, rank correlations and the distance of verified \
    points tell how much the value of a parameter says of the output, with all that it says of the others in its row: one \
    without any influence may be called the most important. Partial correlations (PRCC) take the others' linear relation \
    between ranks away, and no other";

pub(super) fn run(options: &cli::Sensitivity) -> Result<ExitCode, CommandError> {
    let cli::Work {
        study: path,
        output,
        parts,
        ..
    } = &options.work;
    let study = Study::read(path)?;
    let analysis = Runs::new(options, &study)?;
    if let Some(folder) = &options.from {
        let (summary, table) = finding::every_value_of(folder, &study)?;
        let mut result = from_points(&table, analysis.seed);
        if !study.correlations.is_empty() {
            result.warnings.insert(0, CORRELATED.to_owned());
        }
        if study.binds_by_samples() {
            result.warnings.insert(0, SAMPLED.to_owned());
        }
        let text = text(&result);
        let finding = AnalysisResult::new(&result, Origin::of_points(&summary), text, shown::FILE)?;
        let folder = output.as_ref().unwrap_or(folder);
        asking::check(&options.work, folder)?;
        return finding.tell(folder);
    }
    let session = asking::open(&options.work, &analysis)?;
    let folder = asking::folder(output.as_deref(), path, parts, Some(NAME))?;
    asking::run(session, &analysis, &options.work, &folder)
}

/// An analysis by runs of its own.
#[derive(Debug, Serialize, Deserialize)]
struct Runs {
    method: String,
    size: u64,
    estimator: FirstOrder,
    seed: u64,
}

pub(super) fn kept(options: serde_json::Value) -> serde_json::Result<Box<dyn Analysis>> {
    Ok(Box::new(serde_json::from_value::<Runs>(options)?))
}

impl Runs {
    /// The settings from the options, else from the study, else the defaults.
    fn new(options: &cli::Sensitivity, study: &Study) -> Result<Self, CommandError> {
        let said = &study.sensitivity;
        let estimator = said.estimator.as_ref().map(|name| {
            FirstOrder::named(name.as_ref()).ok_or_else(|| {
                let [others @ .., last] =
                    &FirstOrder::ALL.map(|known| format!("`{}`", known.name()));
                let known = format!("{} and {last}", others.join(", "));
                study.error_at(name, format!("the estimators are {known}"))
            })
        });
        let method = said.method.as_ref().map(|name| {
            let known = named(name.as_ref());
            known.map_err(|message| study.error_at(name, message))
        });
        let (in_study, asked) = (method.transpose()?, options.method_and_size()?);
        let usual = in_study.unwrap_or(RUNS[0]);
        let (method, size) = match asked {
            // The study's size is that of its own method.
            (Some(method), size) if method.name() != usual.name() => (method, size),
            (_, Some(size)) => (usual, Some(size)),
            (_, None) => {
                if let Some(size) = &said.size {
                    enough(*size.as_ref()).map_err(|message| study.error_at(size, message))?;
                }
                (usual, said.size.as_ref().map(|size| *size.as_ref()))
            }
        };
        if options.estimator.is_some() && method.name() != RUNS[0].name() {
            let message = format!("{} has no estimators to choose from", method.name());
            return Err(option("estimator", message));
        }
        Ok(Self {
            method: method.name().to_owned(),
            size: size.unwrap_or(method.usual_size()),
            estimator: match options.estimator {
                Some(estimator) => estimator,
                None => estimator.transpose()?.unwrap_or_default(),
            },
            seed: options.seed.or(said.seed).unwrap_or(1),
        })
    }

    fn method(&self) -> Result<&'static dyn method::FromRuns, CommandError> {
        named(&self.method).map_err(|message| option("method", message))
    }

    fn settled(&self) -> Settled {
        Settled {
            size: self.size,
            estimator: self.estimator,
            seed: self.seed,
        }
    }
}

impl cli::Sensitivity {
    /// Method and size from the command line.
    fn method_and_size(
        &self,
    ) -> Result<(Option<&'static dyn method::FromRuns>, Option<u64>), CommandError> {
        let sizes = [
            ("sobol", self.base),
            ("morris", self.morris),
            ("shapley", self.shapley),
        ];
        let by_size = sizes.into_iter().find(|(_, size)| size.is_some());
        let chosen = match (&self.method, by_size) {
            (Some(name), _) => (Some(name.as_str()), self.size),
            (None, Some((name, size))) => (Some(name), size),
            (None, None) => (None, self.size),
        };
        let method = chosen.0.map(named).transpose();
        Ok((
            method.map_err(|message| option("method", message))?,
            chosen.1,
        ))
    }
}

impl Analysis for Runs {
    fn name(&self) -> &'static str {
        NAME
    }

    fn options(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn takes_correlations(&self) -> bool {
        self.method()
            .is_ok_and(|method| method.takes_correlations())
    }

    fn points(&self, session: &Session) -> Result<PointSet, CommandError> {
        let method = self.method()?;
        enough(self.size).map_err(|message| option(method.option(), message))?;
        Ok(PointSet {
            seed: self.seed,
            points: Some(method.runs(&space(&session.plan), self.size)),
            method: method.title(self.size),
            table: None,
        })
    }

    fn find(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        folder: &Path,
    ) -> Result<AnalysisResult, CommandError> {
        let method = self.method()?;
        let design = method
            .design(&space(&session.plan), &self.settled())
            .map_err(|message| option(method.option(), message))?;
        let rows = simulate(session, pipeline, &design)?;
        keep_runs(folder, &rows)?;
        let mut result = from_runs(method, &design, &rows, &self.settled());
        if !session.plan.is_independent() {
            result.warnings.insert(0, CORRELATED.to_owned());
        }
        let origin = asking::origin(session)?;
        AnalysisResult::new(&result, origin, text(&result), shown::FILE)
    }
}

/// One base point or trajectory tells nothing of how sure it is.
fn enough(size: u64) -> Result<(), String> {
    match size < 2 {
        true => Err(format!("{size} is too few; at least 2 are needed")),
        false => Ok(()),
    }
}

fn option(option: &'static str, message: String) -> CommandError {
    CommandError::Option { option, message }
}

/// The parameters that vary, with their correlations.
fn space(plan: &Plan) -> Space {
    let varied = plan.varied();
    let correlation = plan.correlation().map(|correlation| {
        DMatrix::from_fn(varied.len(), varied.len(), |a, b| {
            correlation.coefficient(varied[a], varied[b])
        })
    });
    Space {
        parameters: varied.len(),
        correlation,
    }
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
    make_folder(folder)?;
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

/// A table per output.
fn text(result: &Sensitivity) -> String {
    let mut out = format!("{}\n", result.method);
    for warning in &result.warnings {
        out += &format!("warning: {warning}\n");
    }
    for output in &result.outputs {
        out += &format!("\n{}\n", output.name);
        out += &rows(&result.parameters, output);
        out += &match &output.dominant {
            Some(name) => format!("most important: {name}\n"),
            None => format!("{}\n", output.undecided()),
        };
    }
    out
}

fn rows(parameters: &[String], output: &Output) -> String {
    let width = parameters.iter().map(String::len).max().unwrap_or(0);
    let interval = |e: &Estimate| match e.low.is_nan() {
        true => number(e.value, 3),
        false => format!(
            "{:>8} [{}, {}]",
            number(e.value, 3),
            number(e.low, 3),
            number(e.high, 3)
        ),
    };
    let shown = output.shown();
    let bounds = |m: &Measure, k: usize| {
        let bounds = m.bounds.as_ref().map(|bounds| bounds[k]);
        let bounds = bounds.filter(|[low, _]| !low.is_nan());
        bounds.map_or_else(String::new, |[low, high]| {
            format!(" {{{} .. {}}}", number(low, 3), number(high, 3))
        })
    };
    let row = |(k, name): (usize, &String)| {
        let cells = shown.iter().map(|m| {
            let interval = interval(&m.estimates[k]);
            format!("  {} {interval}{}", m.name, bounds(m, k))
        });
        format!("  {name:width$}{}\n", cells.collect::<String>())
    };
    parameters.iter().enumerate().map(row).collect()
}
