//! The sensitivity of all outputs of a study in one result: of every criterion, and of "is verified".

use super::{Estimate, dominant, morris, pawn, rank, regional, sobol};
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
    /// Sobol indices, where there are runs of their design.
    pub sobol: Option<sobol::Indices>,
    /// Total indices by growing parts of the design: base points and indices.
    pub convergence: Vec<(usize, Vec<f64>)>,
    /// Elementary effects, where there are runs of their design.
    pub morris: Option<Vec<morris::Effect>>,
    /// Rank correlations.
    pub ranks: Option<rank::Correlations>,
    /// PAWN indices.
    pub pawn: Option<pawn::Pawn>,
    /// The parameter that matters most, where the intervals allow to say so.
    pub dominant: Option<String>,
}

const RESAMPLES: usize = 200;
const SLICES: usize = 10;

/// Everything that existing points tell, whatever their design.
pub fn from_points(table: &PointTable, seed: u64) -> Sensitivity {
    let columns: Vec<&[f64]> = table
        .parameters
        .iter()
        .map(|p| p.values.as_slice())
        .collect();
    let completed: Vec<bool> = (0..table.len()).map(|i| table.completed(i)).collect();
    let outputs = outputs(table)
        .into_iter()
        .map(|(name, values)| {
            let ranks = rank::correlations(&columns, &values);
            let pawn = pawn::pawn(&columns, &values, SLICES, RESAMPLES, seed);
            let by_pawn = pawn.as_ref().and_then(|p| dominant(&p.median));
            Output {
                dominant: by_pawn.map(|i| table.parameters[i].name.clone()),
                name,
                ranks,
                pawn,
                ..Output::default()
            }
        })
        .collect();
    Sensitivity {
        parameters: table.parameters.iter().map(|p| p.name.clone()).collect(),
        method: "Rank correlations and PAWN of existing points".into(),
        runs: table.len(),
        failed: completed.iter().filter(|c| !**c).count(),
        outputs,
        verdict: regional::split(&columns, &table.verified, &completed).unwrap_or_default(),
    }
}

/// Sobol indices from the rows of [`sobol::design`], and everything that points as they are tell:
/// that from the rows of A and B, which are a plain sample. The base points belong to `replicates`
/// independent randomisations in turn.
pub fn from_sobol(
    rows: &PointTable,
    estimator: sobol::FirstOrder,
    replicates: u64,
    seed: u64,
) -> Sensitivity {
    let d = rows.parameters.len();
    let width = d + 2;
    let plain: Vec<usize> = (0..rows.len())
        .filter(|k| k % width == 0 || k % width == width - 1)
        .collect();
    let mut result = from_points(&rows.subset(&plain), seed);
    for (output, (_, values)) in result.outputs.iter_mut().zip(outputs(rows)) {
        output.sobol = sobol::indices(&values, d, estimator, replicates);
        output.convergence = sobol::convergence(&values, d, estimator, replicates)
            .into_iter()
            .map(|(n, s)| (n, s.total.iter().map(|e| e.value).collect()))
            .collect();
        let total = output
            .sobol
            .as_ref()
            .map_or(&[] as &[Estimate], |s| &s.total);
        output.dominant = dominant(total).map(|i| rows.parameters[i].name.clone());
    }
    result.runs = rows.len();
    result.failed = (0..rows.len()).filter(|&k| !rows.completed(k)).count();
    result.method = format!(
        "Sobol indices from {} base points in {replicates} randomisations ({} runs); rank correlations and PAWN of their plain sample",
        rows.len() / width,
        rows.len()
    );
    result
}

/// Elementary effects from the rows of [`morris::design`] in the unit cube.
pub fn from_morris(cube: &[Vec<f64>], rows: &PointTable, seed: u64) -> Sensitivity {
    let outputs = outputs(rows)
        .into_iter()
        .map(|(name, values)| {
            let effects = morris::effects(cube, &values, RESAMPLES, seed);
            let sizes: Vec<Estimate> = effects.iter().flatten().map(|e| e.mu_star).collect();
            let dominant = dominant(&sizes).map(|i| rows.parameters[i].name.clone());
            Output {
                name,
                morris: effects,
                dominant,
                ..Output::default()
            }
        })
        .collect();
    Sensitivity {
        parameters: rows.parameters.iter().map(|p| p.name.clone()).collect(),
        method: format!("Morris screening, {} runs", rows.len()),
        runs: rows.len(),
        failed: (0..rows.len()).filter(|&k| !rows.completed(k)).count(),
        outputs,
        verdict: vec![],
    }
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
