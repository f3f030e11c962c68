//! The sensitivity of all outputs of a study in one result: of every criterion, and of "is verified".

use super::method::{FromRuns, Measure, Settled, Told};
use super::methods::{RUNS, VIEWS};
use super::sobol::FirstOrder;
use super::{dominant, regional};
use crate::analysis::table::PointTable;
use serde::{Deserialize, Serialize};

/// The sensitivity of a study's outputs to its parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sensitivity {
    /// The parameters, in the order of all lists below.
    pub parameters: Vec<String>,
    /// Description of the method and its cost, for people.
    pub method: String,
    /// Runs that it rests on.
    pub runs: usize,
    /// Runs without a result.
    pub failed: usize,
    /// The criteria, and at the end `verified`.
    pub outputs: Vec<Output>,
    /// What decides pass or fail: distance, chance, medians. Empty where all points pass or none does.
    pub verdict: Vec<regional::Split>,
}

/// The sensitivity of one output.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// The output's name.
    pub name: String,
    /// What the methods tell, by their keys; null where one was not used or cannot tell.
    #[serde(flatten)]
    pub told: Told,
    /// The parameter that matters most, where the intervals allow to say so.
    pub dominant: Option<String>,
}

impl Output {
    /// What is shown of it: what is drawn of one method first, and then what only stands in the table.
    pub fn shown(&self) -> Vec<Measure> {
        let runs = RUNS.iter().map(|method| method.shown(&self.told));
        let views = VIEWS.iter().map(|view| view.shown(&self.told));
        let mut principal: Option<usize> = None;
        let mut shown = Vec::new();
        for (number, measures) in runs.chain(views).enumerate() {
            for measure in measures {
                if !measure.drawn || *principal.get_or_insert(number) == number {
                    shown.push(measure);
                }
            }
        }
        // Stable: what is drawn keeps its order.
        shown.sort_by_key(|measure| !measure.drawn);
        shown
    }
}

/// The parameter of which the first measure is surely the largest.
fn most_important(shown: &[Measure], parameters: &[String]) -> Option<String> {
    let first = shown.iter().find(|measure| measure.drawn)?;
    Some(parameters[dominant(&first.estimates)?].clone())
}

/// Everything that existing points tell, whatever their design.
pub fn from_points(table: &PointTable, seed: u64) -> Sensitivity {
    let columns: Vec<&[f64]> = table
        .parameters
        .iter()
        .map(|p| p.values.as_slice())
        .collect();
    let completed: Vec<bool> = (0..table.len()).map(|i| table.completed(i)).collect();
    let parameters: Vec<String> = table.parameters.iter().map(|p| p.name.clone()).collect();
    let output = |(name, values): (String, Vec<f64>)| {
        let views = VIEWS.iter().map(|view| view.tell(&columns, &values, seed));
        let mut output = Output {
            name,
            told: unused(seed),
            dominant: None,
        };
        output.told.extend(views.flatten());
        output.dominant = most_important(&output.shown(), &parameters);
        output
    };
    Sensitivity {
        outputs: outputs(table).into_iter().map(output).collect(),
        method: "Rank correlations and PAWN of existing points".into(),
        runs: table.len(),
        failed: failed(table),
        verdict: regional::split(&columns, &table.verified, &completed).unwrap_or_default(),
        parameters,
    }
}

/// The keys of the methods that were not used, without values.
fn unused(seed: u64) -> Told {
    let settled = Settled {
        size: 0,
        estimator: FirstOrder::default(),
        seed,
    };
    let keys = RUNS.iter().map(|method| method.tell(&[], &[], &settled));
    keys.flatten().collect()
}

/// What the rows of a design tell, and everything that its plain sample tells.
pub fn from_runs(
    method: &dyn FromRuns,
    design: &[Vec<f64>],
    rows: &PointTable,
    settled: &Settled,
) -> Sensitivity {
    let parameters = rows.parameters.len();
    let plain = method.plain_sample(parameters, rows.len());
    let mut result = from_points(&rows.subset(&plain), settled.seed);
    for (output, (_, values)) in result.outputs.iter_mut().zip(outputs(rows)) {
        let told = method.tell(design, &values, settled);
        output.dominant = most_important(&method.shown(&told), &result.parameters);
        output.told.extend(told);
    }
    result.runs = rows.len();
    result.failed = failed(rows);
    result.method = method.done(parameters, rows.len(), settled);
    result
}

fn failed(table: &PointTable) -> usize {
    (0..table.len()).filter(|&k| !table.completed(k)).count()
}

/// The criteria's values, and 1 or 0 for verified or not; not a number for failed runs.
fn outputs(table: &PointTable) -> Vec<(String, Vec<f64>)> {
    let verdict = |i: usize| {
        if table.completed(i) {
            f64::from(u8::from(table.verified[i]))
        } else {
            f64::NAN
        }
    };
    let criteria = table
        .criteria
        .iter()
        .map(|c| (c.name.clone(), c.values.clone()));
    criteria
        .chain([(
            "verified".to_owned(),
            (0..table.len()).map(verdict).collect(),
        )])
        .collect()
}
