//! Sobol indices and Shapley effects from the points of a finished study, by a surrogate of them.

use std::path::Path;

use super::outputs::{Output, Sensitivity, by_surrogate};
use crate::error::Error;
use crate::methods::known;
use crate::results::surrogate::{limits, reason};
use crate::session::Session;
use ::sensitivity::Estimate;
use ::sensitivity::shapley::{self, Effects, Explained};
use ::sensitivity::sobol::Indices;
use conformity::conclusion::grouped;
use nalgebra::DMatrix;
use parameter_regions::table::PointTable;
use run_budget::{Design, Doubt, Index, Run, Surrogate, Unfit, indices, measures};
use sampling::design;

/// A fit takes the cube of the number of points; more of them tell little more.
const MOST: usize = 250;
/// Pairs of points at which the surrogate is asked, and those of them that tell Shapley effects.
const PAIRS: u64 = 8192;
const OF_SHAPLEY: usize = 4096;
const CONFIDENCE: f64 = 0.95;
/// The meaning of the numbers where parameters are correlated.
const CORRELATED: &str = "the parameters are correlated, so Shapley effects divide among them what they explain together: one \
    without any influence on the model has a part of what its partners explain";

/// The result of a finished study's points in `folder`.
pub fn find(session: &Session, folder: &Path, seed: u64) -> Result<Sensitivity, Error> {
    let Session { study, plan, judge, .. } = session;
    let (_, table) = known::points_of(folder, study)?;
    let varied = plan.varied();
    let inputs = plan.inputs.iter().map(|input| table.parameters.iter().find(|p| p.name == input.name));
    let columns: Vec<Option<&[f64]>> = inputs.map(|column| column.map(|column| &*column.values)).collect();
    let median: Vec<f64> = plan.inputs.iter().map(|input| input.distribution.quantile(0.5)).collect();
    let point = |row: usize| -> Vec<f64> {
        let cells = columns.iter().zip(&median);
        plan.coordinates(
            &cells.map(|(column, median)| column.map_or(*median, |values| values[row])).collect::<Vec<_>>(),
        )
    };
    let run = |row: usize| Run { point: point(row), values: values(&table, row) };
    let runs: Vec<Run> = (0..MOST.min(table.len())).map(run).collect();
    let dimensions = varied.len();
    let net = design::cube(2 * dimensions, PAIRS, seed, 1).map_err(|message| study.error(message))?;
    let of_cube = |u: &[f64]| plan.coordinates(&plan.from_cube(u));
    let correlation = plan.correlation.as_ref().map(|correlation| {
        DMatrix::from_fn(dimensions, dimensions, |a, b| correlation.coefficient(varied[a], varied[b]))
    });
    let pairs = &net[..OF_SHAPLEY];
    let rows = shapley::design(pairs, correlation.as_ref(), seed).map_err(|message| study.error(message))?;
    let points: Vec<Vec<f64>> = rows.iter().map(|u| of_cube(u)).collect();
    let explained = Explained::new(dimensions, pairs.len(), correlation.is_some(), seed);
    let explained = |pair, values: &[f64]| explained.at(pair, values).into_iter().map(|x| [x, 0.0]).collect();
    let design =
        Design { points: &points, width: points.len() / pairs.len(), drawn: OF_SHAPLEY / 8, explained: &explained };
    let like: Vec<Vec<f64>> = points.iter().step_by(design.width).cloned().collect();
    let names = judge.criteria.iter().map(|criterion| criterion.name.clone()).chain(["verified".to_owned()]);
    let names: Vec<String> = names.collect();
    let limits = limits(judge, 0.0);
    let found: Vec<Result<(Option<Indices>, Effects), String>> = match Surrogate::fit(&runs, &like, None, seed) {
        Ok(surrogate) => {
            let half = |half: usize| -> Vec<Vec<f64>> {
                net.iter().map(|u| of_cube(&u[half * dimensions..][..dimensions])).collect()
            };
            let sobol = match correlation {
                Some(_) => vec![None; names.len()],
                None => {
                    let found = indices(&surrogate, &limits, &runs, [&half(0), &half(1)], CONFIDENCE);
                    found.into_iter().map(|found| Some(of_varied(&found.ok()?, &varied, runs.len()))).collect()
                }
            };
            let told = |(found, sobol): (Result<Vec<Index>, Doubt>, _)| match found {
                Ok(found) => {
                    let effects = found.iter().map(estimate).collect();
                    Ok((sobol, Effects { effects }))
                }
                Err(doubt) => Err(reason(judge, doubt)),
            };
            let effects = measures(&surrogate, &limits, &runs, &design, CONFIDENCE);
            effects.into_iter().zip(sobol).map(told).collect()
        }
        Err(Unfit::TooFew { runs, needed }) => {
            let study = study.path().display();
            let message = format!(
                "{runs} points in {} have values, and {needed} are needed for indices of {dimensions} parameters: `orchestrator verify \
                 {study} --resume --points {needed}` adds the others, or `orchestrator sensitivity {study} --base 256` runs a design",
                folder.display()
            );
            return Err(Error::option("from", message));
        }
        Err(unfit) => vec![Err(unfit.to_string()); names.len()],
    };
    let mut outputs: Vec<Output> = Vec::new();
    let failed = runs.iter().filter(|run| run.values.is_none()).count();
    let mut warnings = Vec::new();
    if correlation.is_some() {
        warnings.push(CORRELATED.to_owned());
    }
    if failed > 0 {
        warnings.push(format!(
            "{failed} of {} points failed: indices are of the criteria as the others continue them into where runs fail, which only \
             `verified` counts, as not verified",
            runs.len()
        ));
    }
    let parameters: Vec<String> = varied.iter().map(|&k| plan.inputs[k].name.clone()).collect();
    for (name, found) in names.into_iter().zip(found) {
        if let Err(why) = &found {
            warnings.push(format!(
                "{name}: no indices from these points: {why}; verify twice as many (`--resume --points {}`), or run a design \
                 (`orchestrator sensitivity {} --base 256`)",
                2 * table.len(),
                study.path().display()
            ));
        }
        outputs.push(by_surrogate(name, found.ok(), &parameters, seed));
    }
    let of_what = if correlation.is_some() { "Shapley effects" } else { "Sobol indices and Shapley effects" };
    let of_all = match runs.len() < table.len() {
        true => format!("{} of the {} points", runs.len(), grouped(table.len())),
        false => format!("the {} points", runs.len()),
    };
    let inputs = varied.iter().map(|&k| (&plan.inputs[k].name, plan.inputs[k].unit.clone()));
    let criteria = judge.criteria.iter().map(|criterion| (&criterion.name, criterion.unit.clone()));
    let units = inputs.chain(criteria).filter_map(|(name, unit)| Some((name.clone(), unit?)));
    Ok(Sensitivity {
        units: units.collect(),
        parameters,
        method: format!("{of_what} by surrogate from {of_all}, no further run"),
        runs: runs.len(),
        failed,
        warnings,
        outputs,
    })
}

fn values(table: &PointTable, row: usize) -> Option<Vec<f64>> {
    let values: Vec<f64> = table.criteria.iter().map(|criterion| criterion.values[row]).collect();
    values.iter().all(|value| value.is_finite()).then_some(values)
}

fn estimate(index: &Index) -> Estimate {
    let Index { estimate: value, interval: [low, high] } = *index;
    Estimate { value, low, high }
}

fn of_varied(found: &[[Index; 2]], varied: &[usize], runs: usize) -> Indices {
    let of = |which: usize| varied.iter().map(|k| estimate(&found[*k][which])).collect();
    Indices { first: of(0), total: of(1), used: vec![runs; varied.len()], failed: 0 }
}
