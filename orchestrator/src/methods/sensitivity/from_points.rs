//! Sobol indices and Shapley effects from the points of a finished study, by a surrogate of them.

use std::{collections::BTreeMap, path::Path};

use super::outputs::{Sensitivity, by_surrogate};
use crate::{
    error::Error,
    methods::known,
    results::surrogate::{limits, reason},
    session::Session,
};
use ::sensitivity::{
    Estimate,
    shapley::{self, Effects, Explained},
    sobol::Indices,
};
use conformity::conclusion::grouped;
use nalgebra::DMatrix;
use parameter_regions::table::PointTable;
use run_budget::{Design, Doubt, Index, Limit, Run, Surrogate, Unfit, indices, measures};
use sampling::design;
use study::plan::Plan;

/// A fit takes the cube of the number of points; more of them tell little more.
const MOST: usize = 250;
/// Pairs of points at which the surrogate is asked, and those of them that tell Shapley effects.
const PAIRS: u64 = 8192;
const OF_SHAPLEY: usize = 4096;
const CONFIDENCE: f64 = 0.95;
/// The meaning of the numbers where parameters are correlated.
const CORRELATED: &str = "the parameters are correlated, so Shapley effects divide among them what they explain together: one \
    without any influence on the model has a part of what its partners explain";

/// What a surrogate tells of an output, or why it tells nothing.
type Found = Result<(Option<Indices>, Effects), String>;

/// The result of a finished study's points in `folder`.
pub fn find(session: &Session, folder: &Path, seed: u64) -> Result<Sensitivity, Error> {
    let Session { study, plan, judge, .. } = session;
    let (_, table) = known::points_of(folder, study)?;
    let runs = runs(plan, &table);
    let varied = plan.varied();
    let correlation = plan.correlation.as_ref().map(|correlation| {
        DMatrix::from_fn(varied.len(), varied.len(), |a, b| correlation.coefficient(varied[a], varied[b]))
    });
    let asked = Asked::new(session, correlation.as_ref(), seed)?;
    let like: Vec<Vec<f64>> = asked.points.iter().step_by(asked.width()).cloned().collect();
    let found = match Surrogate::fit(&runs, &like, None, seed) {
        Ok(surrogate) => asked.told(session, &surrogate, &runs, seed),
        Err(Unfit::TooFew { runs, needed }) => {
            let (study, dimensions) = (study.path().display(), varied.len());
            let message = format!(
                "{runs} points in {} have values, and {needed} are needed for indices of {dimensions} parameters: `orchestrator verify \
                 {study} --resume --points {needed}` adds the others, or `orchestrator sensitivity {study} --base 256` runs a design",
                folder.display()
            );
            return Err(Error::option("from", message));
        }
        Err(unfit) => vec![Err(unfit.to_string()); judge.criteria.len() + 1],
    };
    let names = judge.criteria.iter().map(|criterion| criterion.name.clone()).chain(["verified".to_owned()]);
    let found: Vec<(String, Found)> = names.zip(found).collect();
    let failed = runs.iter().filter(|run| run.values.is_none()).count();
    let mut warnings: Vec<String> = correlation.iter().map(|_| CORRELATED.to_owned()).collect();
    if failed > 0 {
        warnings.push(format!(
            "{failed} of {} points failed: indices are of the criteria as the others continue them into where runs fail, which only \
             `verified` counts, as not verified",
            runs.len()
        ));
    }
    warnings.extend(found.iter().filter_map(|(name, found)| {
        Some(format!(
            "{name}: no indices from these points: {}; verify twice as many (`--resume --points {}`), or run a design \
             (`orchestrator sensitivity {} --base 256`)",
            found.as_ref().err()?,
            2 * table.len(),
            study.path().display()
        ))
    }));
    let parameters: Vec<String> = varied.iter().map(|&k| plan.inputs[k].name.clone()).collect();
    let of_what = if correlation.is_some() { "Shapley effects" } else { "Sobol indices and Shapley effects" };
    let of_all = match runs.len() < table.len() {
        true => format!("{} of the {} points", runs.len(), grouped(table.len())),
        false => format!("the {} points", runs.len()),
    };
    Ok(Sensitivity {
        units: units(session),
        method: format!("{of_what} by surrogate from {of_all}, no further run"),
        runs: runs.len(),
        failed,
        warnings,
        outputs: found.into_iter().map(|(name, found)| by_surrogate(name, found.ok(), &parameters, seed)).collect(),
        parameters,
    })
}

/// The first points of a table as runs. Parameters that it lacks have their medians.
fn runs(plan: &Plan, table: &PointTable) -> Vec<Run> {
    let inputs = plan.inputs.iter();
    let columns = inputs.map(|input| {
        let column = table.parameters.iter().find(|p| p.name == input.name);
        (column.map(|column| &*column.values), input.distribution.quantile(0.5))
    });
    let columns: Vec<(Option<&[f64]>, f64)> = columns.collect();
    let run = |row: usize| {
        let cells = columns.iter().map(|(column, median)| column.map_or(*median, |values| values[row]));
        Run { point: plan.coordinates(&cells.collect::<Vec<_>>()), values: values(table, row) }
    };
    (0..MOST.min(table.len())).map(run).collect()
}

/// Points at which the surrogate is asked.
struct Asked {
    /// Pairs of independent points in the unit cube.
    net: Vec<Vec<f64>>,
    /// Those that tell Shapley effects, as coordinates.
    points: Vec<Vec<f64>>,
    is_correlated: bool,
}

impl Asked {
    fn new(session: &Session, correlation: Option<&DMatrix<f64>>, seed: u64) -> Result<Self, Error> {
        let Session { study, plan, .. } = session;
        let wrong = |message| study.error(message);
        let net = design::cube(2 * plan.varied().len(), PAIRS, seed, 1).map_err(wrong)?;
        let rows = shapley::design(&net[..OF_SHAPLEY], correlation, seed).map_err(wrong)?;
        let points = rows.iter().map(|u| plan.coordinates(&plan.from_cube(u))).collect();
        Ok(Self { net, points, is_correlated: correlation.is_some() })
    }

    /// Points of each pair.
    fn width(&self) -> usize {
        self.points.len() / OF_SHAPLEY
    }

    /// What the surrogate of some runs tells of each output.
    fn told(&self, session: &Session, surrogate: &Surrogate, runs: &[Run], seed: u64) -> Vec<Found> {
        let judge = &session.judge;
        let limits = limits(judge, 0.0);
        let explained = Explained::new(session.plan.varied().len(), OF_SHAPLEY, self.is_correlated, seed);
        let explained = |pair, values: &[f64]| explained.at(pair, values).into_iter().map(|x| [x, 0.0]).collect();
        let (points, width) = (&self.points, self.width());
        let design = Design { points, width, drawn: OF_SHAPLEY / 8, explained: &explained };
        let sobol = match self.is_correlated {
            true => vec![None; judge.criteria.len() + 1],
            false => self.sobol(&session.plan, surrogate, &limits, runs),
        };
        let told = |(found, sobol): (Result<Vec<Index>, Doubt>, _)| match found {
            Ok(found) => Ok((sobol, Effects { effects: found.iter().map(estimate).collect() })),
            Err(doubt) => Err(reason(judge, doubt)),
        };
        measures(surrogate, &limits, runs, &design, CONFIDENCE).into_iter().zip(sobol).map(told).collect()
    }

    /// The Sobol indices of each output.
    fn sobol(&self, plan: &Plan, surrogate: &Surrogate, limits: &[Limit], runs: &[Run]) -> Vec<Option<Indices>> {
        let varied = plan.varied();
        let half = |half: usize| -> Vec<Vec<f64>> {
            let places = self.net.iter().map(|u| &u[half * varied.len()..][..varied.len()]);
            places.map(|u| plan.coordinates(&plan.from_cube(u))).collect()
        };
        let found = indices(surrogate, limits, runs, [&half(0), &half(1)], CONFIDENCE);
        found.into_iter().map(|found| Some(of_varied(&found.ok()?, &varied, runs.len()))).collect()
    }
}

/// The units of what varies and of the criteria, by name.
fn units(Session { plan, judge, .. }: &Session) -> BTreeMap<String, String> {
    let inputs = plan.varied().into_iter().map(|k| (&plan.inputs[k].name, &plan.inputs[k].unit));
    let criteria = judge.criteria.iter().map(|criterion| (&criterion.name, &criterion.unit));
    inputs.chain(criteria).filter_map(|(name, unit)| Some((name.clone(), unit.clone()?))).collect()
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
