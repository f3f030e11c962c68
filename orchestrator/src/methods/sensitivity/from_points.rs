//! Sobol indices from the points of a finished study, by a surrogate of them.

use std::path::Path;

use super::outputs::{Output, Sensitivity, from_indices};
use crate::error::Error;
use crate::methods::known;
use crate::results::surrogate::{limits, reason};
use crate::session::Session;
use ::sensitivity::Estimate;
use ::sensitivity::sobol::Indices;
use conformity::conclusion::grouped;
use parameter_regions::table::PointTable;
use run_budget::{Doubt, Index, Run, Surrogate, Unfit, indices};
use sampling::design;

/// A fit takes the cube of the number of points; more of them tell little more.
const MOST: usize = 250;
/// Pairs of points at which the surrogate is asked.
const PAIRS: u64 = 8192;
const CONFIDENCE: f64 = 0.95;

/// The result of a finished study's points in `folder`.
pub(super) fn find(session: &Session, folder: &Path, seed: u64) -> Result<Sensitivity, Error> {
    let Session { study, plan, judge, .. } = session;
    if !plan.is_independent() {
        let message = format!(
            "the parameters are correlated, or drawn together from a sample, and these indices are those of independent ones; use \
             `orchestrator sensitivity {} --shapley 1000`",
            study.path().display()
        );
        return Err(Error::option("from", message));
    }
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
    let half = |half: usize| -> Vec<Vec<f64>> {
        net.iter().map(|u| plan.coordinates(&plan.from_cube(&u[half * dimensions..][..dimensions]))).collect()
    };
    let [a, b] = [half(0), half(1)];
    let told = |found: Result<Vec<[Index; 2]>, Doubt>| {
        found.map_err(|doubt| reason(judge, doubt)).map(|found| of_varied(&found, &varied, runs.len()))
    };
    let names = judge.criteria.iter().map(|criterion| criterion.name.clone()).chain(["verified".to_owned()]);
    let names: Vec<String> = names.collect();
    let found: Vec<Result<Indices, String>> = match Surrogate::fit(&runs, &a, None, seed) {
        Ok(surrogate) => {
            indices(&surrogate, &limits(judge, 0.0), &runs, [&a, &b], CONFIDENCE).into_iter().map(told).collect()
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
        outputs.push(from_indices(name, found.ok(), &parameters, seed));
    }
    let of_all = match runs.len() < table.len() {
        true => format!("{} of the {} points", runs.len(), grouped(table.len() as u64)),
        false => format!("the {} points", runs.len()),
    };
    let inputs = varied.iter().map(|&k| (&plan.inputs[k].name, plan.inputs[k].unit.clone()));
    let criteria = judge.criteria.iter().map(|criterion| (&criterion.name, criterion.unit.clone()));
    let units = inputs.chain(criteria).filter_map(|(name, unit)| Some((name.clone(), unit?)));
    Ok(Sensitivity {
        units: units.collect(),
        parameters,
        method: format!("Sobol indices by surrogate from {of_all}, no further run"),
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

fn of_varied(found: &[[Index; 2]], varied: &[usize], runs: usize) -> Indices {
    let of = |which: usize| -> Vec<Estimate> {
        let one = |k: &usize| {
            let Index { estimate: value, interval: [low, high] } = found[*k][which];
            Estimate { value, low, high }
        };
        varied.iter().map(one).collect()
    };
    Indices { first: of(0), total: of(1), used: vec![runs; varied.len()], failed: 0 }
}
