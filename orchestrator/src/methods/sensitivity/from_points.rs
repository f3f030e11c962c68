//! Sobol indices and Shapley effects from the points of a finished study, by a surrogate of them.

use std::path::Path;

use super::failures;
use super::outputs::{Sensitivity, by_surrogate};
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
use study::{judge::Judge, plan::Plan};

/// A fit takes the cube of the number of points; more of them tell little more.
const MOST: usize = 250;
/// Pairs of points at which the surrogate is asked, and those of them that tell Shapley effects.
const PAIRS: u64 = 8192;
const OF_SHAPLEY: usize = 4096;
const CONFIDENCE: f64 = 0.95;
/// The meaning of the numbers where parameters are correlated.
const CORRELATED: &str = "the parameters are correlated, so Shapley effects divide among them what they explain together: one \
    without any influence on the model has a part of what its partners explain";

/// Sobol indices, where parameters are independent, and Shapley effects of an output; or why there are none.
type Found = Result<(Option<Indices>, Effects), String>;

/// The result of a finished study's points in `folder`.
pub fn find(session: &Session, folder: &Path, seed: u64) -> Result<Sensitivity, Error> {
    let Session { study, plan, judge, .. } = session;
    let (_, table) = known::points_of(folder, study)?;
    let runs = runs(plan, &table);
    let asked = Pairs::new(plan, seed).map_err(|message| study.error(message))?;
    let study = study.path().display();
    let found = match Surrogate::fit(&runs, &asked.like(), None, seed) {
        Ok(surrogate) => asked.found(&surrogate, judge, &runs),
        Err(Unfit::TooFew { runs, needed }) => {
            let message = format!(
                "{runs} points in {} have values, and {needed} are needed for indices of {} parameters: `orchestrator verify {study} \
                 --resume --points {needed}` adds the others, or `orchestrator sensitivity {study} --base 256` runs a design",
                folder.display(),
                asked.varied.len()
            );
            return Err(Error::option("from", message));
        }
        Err(unfit) => vec![Err(unfit.to_string()); judge.criteria.len() + 1],
    };
    let failed = runs.iter().filter(|run| run.values.is_none()).count();
    let mut warnings = Vec::from_iter(asked.correlation.as_ref().map(|_| CORRELATED.to_owned()));
    if failed > 0 {
        warnings.push(format!(
            "{failed} of {} points failed: indices are of the criteria as the others continue them into where runs fail, which only \
             `verified` counts, as not verified",
            runs.len()
        ));
    }
    let inputs = asked.varied.iter().map(|&k| (&plan.inputs[k].name, &plan.inputs[k].unit));
    let criteria = judge.criteria.iter().map(|criterion| (&criterion.name, &criterion.unit));
    let parameters: Vec<String> = inputs.clone().map(|(name, _)| name.clone()).collect();
    // A run that failed is not verified.
    let missing = table.criteria.iter().map(|column| failures::missing(&column.values[..runs.len()])).chain([0]);
    let names = criteria.clone().map(|(name, _)| &**name).chain(["verified"]);
    let mut outputs = Vec::new();
    for ((name, missing), found) in names.zip(missing).zip(found) {
        if let Err(why) = &found {
            warnings.push(format!(
                "{name}: no indices from these points: {why}; verify twice as many (`--resume --points {}`), or run a design \
                 (`orchestrator sensitivity {study} --base 256`)",
                2 * table.len()
            ));
        }
        outputs.push(by_surrogate(name.to_owned(), missing, found.ok(), &parameters, seed));
    }
    let of_what = if asked.correlation.is_some() { "Shapley effects" } else { "Sobol indices and Shapley effects" };
    let of_all = match runs.len() < table.len() {
        true => format!("{} of the {} points", runs.len(), grouped(table.len())),
        false => format!("the {} points", runs.len()),
    };
    let units = inputs.chain(criteria).filter_map(|(name, unit)| Some((name.clone(), unit.clone()?)));
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

/// The points of a study as runs. A parameter that the table lacks has its median.
fn runs(plan: &Plan, table: &PointTable) -> Vec<Run> {
    let columns: Vec<(Option<&[f64]>, f64)> = plan
        .inputs
        .iter()
        .map(|input| {
            let column = table.parameters.iter().find(|column| column.name == input.name);
            (column.map(|column| &*column.values), input.distribution.quantile(0.5))
        })
        .collect();
    let run = |row: usize| {
        let point: Vec<f64> =
            columns.iter().map(|(column, median)| column.map_or(*median, |values| values[row])).collect();
        let values: Vec<f64> = table.criteria.iter().map(|criterion| criterion.values[row]).collect();
        let is_whole = values.iter().all(|value| value.is_finite());
        Run { point: plan.coordinates(&point), values: is_whole.then_some(values) }
    };
    (0..MOST.min(table.len())).map(run).collect()
}

/// Where the surrogate is asked.
struct Pairs<'a> {
    plan: &'a Plan,
    /// The parameters that vary, by their places in the plan.
    varied: Vec<usize>,
    correlation: Option<DMatrix<f64>>,
    /// Pairs of independent points in the unit cube, each in a row.
    net: Vec<Vec<f64>>,
    /// What is made of the first pairs for Shapley effects, as many points of each.
    of_shapley: Vec<Vec<f64>>,
    seed: u64,
}

impl<'a> Pairs<'a> {
    fn new(plan: &'a Plan, seed: u64) -> Result<Self, String> {
        let varied = plan.varied();
        let dimensions = varied.len();
        let correlation = plan.correlation.as_ref().map(|correlation| {
            DMatrix::from_fn(dimensions, dimensions, |a, b| correlation.coefficient(varied[a], varied[b]))
        });
        let net = design::cube(2 * dimensions, PAIRS, seed, 1)?;
        let rows = shapley::design(&net[..OF_SHAPLEY], correlation.as_ref(), seed)?;
        let of_shapley = rows.iter().map(|u| plan.coordinates(&plan.from_cube(u))).collect();
        Ok(Self { plan, varied, correlation, net, of_shapley, seed })
    }

    /// Points of each pair that tell Shapley effects.
    fn width(&self) -> usize {
        self.of_shapley.len() / OF_SHAPLEY
    }

    /// A plain sample of the parameters.
    fn like(&self) -> Vec<Vec<f64>> {
        self.of_shapley.iter().step_by(self.width()).cloned().collect()
    }

    /// What a surrogate of runs tells of each criterion, and last of being verified.
    fn found(&self, surrogate: &Surrogate, judge: &Judge, runs: &[Run]) -> Vec<Found> {
        let limits = limits(judge, 0.0);
        let is_correlated = self.correlation.is_some();
        let explained = Explained::new(self.varied.len(), OF_SHAPLEY, is_correlated, self.seed);
        let explained = |pair, values: &[f64]| explained.at(pair, values).into_iter().map(|x| [x, 0.0]).collect();
        let points = &self.of_shapley;
        let design = Design { points, width: self.width(), drawn: OF_SHAPLEY / 8, explained: &explained };
        let effects = measures(surrogate, &limits, runs, &design, CONFIDENCE);
        let sobol = match is_correlated {
            true => Vec::new(),
            false => indices(surrogate, &limits, runs, [&self.half(0), &self.half(1)], CONFIDENCE),
        };
        let mut sobol = sobol.into_iter().map(|found| found.ok().map(|found| self.of_varied(&found, runs.len())));
        let told = |found: Result<Vec<Index>, Doubt>| {
            let sobol = sobol.next().flatten();
            let effects = found.map_err(|doubt| reason(judge, doubt))?.iter().map(estimate).collect();
            Ok((sobol, Effects { effects }))
        };
        effects.into_iter().map(told).collect()
    }

    /// The first or the second points of all pairs.
    fn half(&self, half: usize) -> Vec<Vec<f64>> {
        let dimensions = self.varied.len();
        let point = |u: &Vec<f64>| self.plan.coordinates(&self.plan.from_cube(&u[half * dimensions..][..dimensions]));
        self.net.iter().map(point).collect()
    }

    fn of_varied(&self, found: &[[Index; 2]], runs: usize) -> Indices {
        let of = |which: usize| self.varied.iter().map(|k| estimate(&found[*k][which])).collect();
        Indices { first: of(0), total: of(1), used: vec![runs; self.varied.len()], failed: 0 }
    }
}

fn estimate(index: &Index) -> Estimate {
    let Index { estimate: value, interval: [low, high] } = *index;
    Estimate { value, low, high }
}
