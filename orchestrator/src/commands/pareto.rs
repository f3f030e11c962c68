//! `pareto`: what the criteria cost each other.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::{Deserialize, Serialize};

use super::CommandError;
use super::asking::{self, Analysis, PointSet};
use super::finding::{self, AnalysisResult};
use crate::analysis::from_results;
use crate::cli;
use crate::pipeline::Pipeline;
use crate::report::format::number;
use crate::report::pareto as page;
use crate::results::Outcome;
use crate::results::origin::Origin;
use crate::session::Session;
use crate::study::Study;
use parameter_regions::pareto::nsga2;
use parameter_regions::pareto::study::{CONFLICT, Member, Pareto, trade_off};
use parameter_regions::table::PointTable;

pub(super) const NAME: &str = "pareto";

pub(super) fn run(options: &cli::Pareto) -> Result<ExitCode, CommandError> {
    let cli::Work { study, output, .. } = &options.work;
    let from = || {
        let folder = options.from.clone();
        folder.unwrap_or_else(|| finding::folder_of(study))
    };
    let analysis = match options.generations {
        Some(generations) => Front::Search {
            generations,
            population: options.population,
            seed: options.seed,
        },
        None => Front::Points {
            from: absolute(from()),
        },
    };
    let folder = output.clone().unwrap_or_else(from);
    let run = |session| asking::run(session, &analysis, &options.work, &folder);
    match asking::open(&options.work, &analysis).and_then(run) {
        // Without the FMU the front is the same, but the nominal design cannot be run.
        Err(CommandError::Session(_) | CommandError::Study(_) | CommandError::Fmu(_))
            if options.generations.is_none() =>
        {
            let study = Study::read(study)?;
            asking::check(&options.work, &folder)?;
            of_points(&from(), &study, |_| Ok(None))?.tell(&folder)
        }
        other => other,
    }
}

fn absolute(path: PathBuf) -> PathBuf {
    std::path::absolute(&path).unwrap_or(path)
}

/// Where the points come from of which the front is chosen.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Front {
    /// From a search by runs of its own.
    Search {
        generations: usize,
        population: usize,
        seed: u64,
    },
    /// From a finished study; the nominal design is run to be compared.
    Points { from: PathBuf },
}

pub(super) fn kept(options: serde_json::Value) -> serde_json::Result<Box<dyn Analysis>> {
    Ok(Box::new(serde_json::from_value::<Front>(options)?))
}

impl Analysis for Front {
    fn name(&self) -> &'static str {
        NAME
    }

    fn options(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn points(&self, _: &Session) -> Result<PointSet, CommandError> {
        // A search over more generations begins as one over fewer, so their number is left out.
        Ok(match self {
            Self::Search {
                population, seed, ..
            } => PointSet {
                seed: *seed,
                points: None,
                method: format!("NSGA-II in generations of {population}"),
                table: None,
            },
            Self::Points { from } => PointSet {
                seed: 0,
                points: Some(1),
                method: "the nominal design".to_owned(),
                table: Some(finding::digest_of(from)?),
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

    fn find(
        &self,
        session: &Session,
        pipeline: &mut Pipeline<'_>,
        _: &Path,
    ) -> Result<AnalysisResult, CommandError> {
        match *self {
            Self::Search {
                generations,
                population,
                seed,
            } => {
                let settings = nsga2::Evolution {
                    population,
                    generations,
                    seed,
                };
                let table = search(session, pipeline, settings)?;
                let nominal = nominal(session, pipeline)?;
                let method = format!("NSGA-II over {generations} generations of {population}");
                let result = trade_off(&table, false, Some(nominal), method);
                finding(result, asking::origin(session)?)
            }
            Self::Points { ref from } => of_points(from, &session.study, |table| {
                let own = session.plan.inputs.len() == table.parameters.len();
                own.then(|| nominal(session, pipeline)).transpose()
            }),
        }
    }
}

/// The front of a finished study's points, with the nominal design where that can be run.
fn of_points(
    from: &Path,
    study: &Study,
    nominal: impl FnOnce(&PointTable) -> Result<Option<Member>, CommandError>,
) -> Result<AnalysisResult, CommandError> {
    let (summary, table) = finding::points_of(from, study)?;
    let nominal = nominal(&table)?;
    let result = trade_off(&table, true, nominal, "the study's points".to_owned());
    finding(result, Origin::of_points(&summary))
}

fn finding(result: Option<Pareto>, origin: Origin) -> Result<AnalysisResult, CommandError> {
    let result = result.ok_or_else(|| CommandError::Search("no point has values".to_owned()))?;
    AnalysisResult::new(&result, origin, text(&result), page::FILE)
}

/// The parameters at the medians of their distributions.
fn nominal(session: &Session, pipeline: &mut Pipeline<'_>) -> Result<Member, CommandError> {
    let middle = vec![0.5; session.plan.varied().len()];
    let points = [session.plan.from_cube(&middle)];
    let outcomes = pipeline.ask(&points)?;
    Ok(Member::of(&table(session, &points, outcomes), 0))
}

/// All runs of a search over the middle 99.8 % of every distribution.
fn search(
    session: &Session,
    pipeline: &mut Pipeline<'_>,
    settings: nsga2::Evolution,
) -> Result<PointTable, CommandError> {
    let limits = vec![[0.001, 0.999]; session.plan.varied().len()];
    let (mut points, mut outcomes) = (Vec::new(), Vec::new());
    nsga2::minimise(&limits, settings, |cube| {
        let own: Vec<Vec<f64>> = cube.iter().map(|u| session.plan.from_cube(u)).collect();
        let found = pipeline.ask(&own)?;
        let table = table(session, &own, found.clone());
        points.extend(own);
        outcomes.extend(found);
        Ok::<_, CommandError>(
            (0..cube.len())
                .map(|i| Member::of(&table, i).deviations)
                .collect(),
        )
    })?;
    Ok(table(session, &points, outcomes))
}

fn table(session: &Session, points: &[Vec<f64>], outcomes: Vec<Outcome>) -> PointTable {
    let inputs = &session.plan.inputs;
    let all: Vec<usize> = (0..inputs.len()).collect();
    from_results::from_runs(inputs, &all, &session.judge, points, outcomes)
}

fn text(result: &Pareto) -> String {
    let mut out = format!(
        "from {}: of {} points {} are beaten by no other in every criterion, {} of these meet all criteria\n",
        result.method, result.points, result.unbeaten, result.unbeaten_verified
    );
    out += &member(
        result,
        "best compromise (the least largest deviation)",
        &result.front[0],
    );
    if result.nearest > 0 {
        let nearest = &result.front[result.nearest];
        out += &member(result, "nearest to the measurement", nearest);
    }
    if let Some(n) = &result.nominal {
        out += &member(result, "nominal design", &n.member);
        out += &format!(
            "  {} points of the front beat it in every criterion; {} from the front\n",
            n.beaten_by,
            number(n.to_front, 3)
        );
    }
    let conflicts = result.conflicts.iter();
    let conflicts = conflicts.filter(|c| c.correlation <= CONFLICT);
    for c in conflicts {
        out += &format!(
            "{} is met better at the expense of {} (rank correlation {})\n",
            result.criteria[c.a],
            result.criteria[c.b],
            number(c.correlation, 2)
        );
    }
    out
}

fn member(result: &Pareto, title: &str, m: &Member) -> String {
    let label = m
        .point
        .map_or_else(String::new, |point| format!(", point {point}"));
    let mut out = format!(
        "\n{title}{label}: largest deviation {}, distance {} (tolerance = 1)\n",
        number(m.largest(), 3),
        number(m.distance(), 3)
    );
    for ((name, value), deviation) in result.criteria.iter().zip(&m.values).zip(&m.deviations) {
        out += &format!(
            "  {name} {}: {} of the tolerance\n",
            number(*value, 5),
            number(*deviation, 2)
        );
    }
    for ((name, unit), value) in result
        .parameters
        .iter()
        .zip(&result.units)
        .zip(&m.parameters)
    {
        out += &format!("  {name} = {} {unit}\n", number(*value, 5));
    }
    out
}
