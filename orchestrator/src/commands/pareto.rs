//! `pareto`: what the criteria cost each other.

use std::process::ExitCode;

use super::batch::Batch;
use super::{CommandError, finding};
use crate::analysis::from_results;
use crate::analysis::pareto::nsga2;
use crate::analysis::pareto::study::{CONFLICT, Member, Pareto, trade_off};
use crate::analysis::table::PointTable;
use crate::cli;
use crate::report::format::number;
use crate::report::pareto as page;
use crate::results::Outcome;
use crate::results::origin::Origin;

pub(super) fn run(options: &cli::Pareto) -> Result<ExitCode, CommandError> {
    let folder = options
        .from
        .clone()
        .unwrap_or_else(|| finding::folder_of(&options.study));
    let batch = Batch::new(&options.study, &options.means);
    let (origin, result) = match options.generations {
        Some(generations) => {
            let batch = batch?;
            let table = search(&batch, options, generations)?;
            let method = format!(
                "NSGA-II over {generations} generations of {}",
                options.population
            );
            let origin = batch.origin.clone();
            (
                origin,
                trade_off(&table, false, Some(nominal(&batch)?), method),
            )
        }
        None => {
            let (summary, table) = finding::points_of(&folder, &options.study)?;
            // Without the FMU the front is the same, but the nominal design cannot be run.
            let nominal = batch.ok().map(|batch| nominal(&batch)).transpose()?;
            let nominal = nominal.filter(|own| own.parameters.len() == table.parameters.len());
            let result = trade_off(&table, true, nominal, "the study's points".to_owned());
            (Origin::of_points(&summary), result)
        }
    };
    let result = result.ok_or_else(|| CommandError::Search("no point has values".to_owned()))?;
    let target = options.output.clone().unwrap_or(folder);
    finding::tell(&result, &origin, &text(&result), &target, page::FILE)
}

/// The parameters at the medians of their distributions.
fn nominal(batch: &Batch) -> Result<Member, CommandError> {
    let middle = vec![0.5; batch.varied().len()];
    let point = batch.parameters(&middle);
    let outcomes = batch.run(std::slice::from_ref(&point))?;
    Ok(Member::of(&table(batch, &[point], outcomes), 0))
}

/// All runs of a search over the middle 99.8 % of every distribution.
fn search(
    batch: &Batch,
    options: &cli::Pareto,
    generations: usize,
) -> Result<PointTable, CommandError> {
    let settings = nsga2::Settings {
        population: options.population,
        generations,
        seed: options.seed,
    };
    let limits = vec![[0.001, 0.999]; batch.varied().len()];
    let (mut points, mut outcomes) = (Vec::new(), Vec::new());
    nsga2::minimise(&limits, settings, |cube| {
        let own: Vec<Vec<f64>> = cube.iter().map(|u| batch.parameters(u)).collect();
        let found = batch.run(&own)?;
        let table = table(batch, &own, found.clone());
        points.extend(own);
        outcomes.extend(found);
        Ok::<_, CommandError>(
            (0..cube.len())
                .map(|i| Member::of(&table, i).deviations)
                .collect(),
        )
    })?;
    Ok(table(batch, &points, outcomes))
}

fn table(batch: &Batch, points: &[Vec<f64>], outcomes: Vec<Outcome>) -> PointTable {
    let inputs = &batch.plan.inputs;
    let all: Vec<usize> = (0..inputs.len()).collect();
    from_results::from_runs(inputs, &all, &batch.judge, points, outcomes)
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
