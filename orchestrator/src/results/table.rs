//! The table of points from what `verify` leaves behind.

use super::{Summary, points};
use crate::error::{Error, Result};
use parameter_regions::table::{ParameterColumn, PointTable};
use point_journal::PointOutcome;
use std::path::Path;
use study::{
    judge::{Judge, PointVerdict},
    plan::Plan,
};

/// Reads `summary.json` and `points.csv` of a finished study. Points that failed have no values, even of the criteria that
/// their runs have a result of.
///
/// # Errors
/// When there is no finished study in the folder, or one of the files is damaged.
pub fn read(folder: &Path) -> Result<(Summary, PointTable)> {
    let (summary, mut table) = read_some(folder, u64::MAX)?;
    let failed: Vec<usize> = (0..table.len()).filter(|&i| !table.completed(i)).collect();
    for criterion in &mut table.criteria {
        failed.iter().for_each(|&i| criterion.values[i] = f64::NAN);
    }
    Ok((summary, table))
}

/// Reads `summary.json` and an even choice of the rows in `points.csv`, with the best ones. A case that failed has no values; the other
/// cases of its point keep theirs, which count.
///
/// # Errors
/// As [`read`].
pub fn read_some(folder: &Path, most: u64) -> Result<(Summary, PointTable)> {
    let summary = summary(folder)?;
    let mut table = points::read(&folder.join("points.csv"), &summary, most)?;
    let case = |name: &str| match name.split_once('/') {
        Some((case, _)) if summary.cases.contains_key(case) => Some(case.to_owned()),
        _ => None,
    };
    let cases: Vec<Option<String>> = table.criteria.iter().map(|c| case(&c.name)).collect();
    for i in (0..table.len()).filter(|&i| !table.completed(i)).collect::<Vec<_>>() {
        let known: Vec<bool> = table.criteria.iter().map(|c| c.values[i].is_finite()).collect();
        let whole = |case: &Option<String>| {
            let mut members = cases.iter().zip(&known).filter(|(other, _)| *other == case);
            case.is_some() && members.all(|(_, known)| *known)
        };
        for (criterion, case) in table.criteria.iter_mut().zip(&cases) {
            if !whole(case) {
                criterion.values[i] = f64::NAN;
            }
        }
    }
    Ok((summary, table))
}

/// Reads `summary.json` alone.
///
/// # Errors
/// When there is no finished study in the folder, or the file is damaged.
pub fn summary(folder: &Path) -> Result<Summary> {
    let path = folder.join("summary.json");
    let text = std::fs::read_to_string(&path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Error::Missing(folder.to_owned()),
        _ => Error::io(&path)(error),
    })?;
    let version = serde_json::from_str(&text)
        .ok()
        .and_then(|content: serde_json::Value| Some(content["provenance"]["orchestrator"].as_str()?.to_owned()));
    serde_json::from_str(&text).map_err(|error| match version {
        Some(version) if version != env!("CARGO_PKG_VERSION") => {
            Error::content(&path, format!("written by version {version}; verify the study again"))
        }
        _ => Error::content(
            &path,
            format!(
                "damaged ({error}): `verify` of the study with `--output {} --resume` writes it again from the journal",
                folder.display()
            ),
        ),
    })
}

/// The table of runs that an analysis made itself: the parameters that vary, and the criteria.
pub fn from_runs(
    plan: &Plan,
    varied: &[usize],
    judge: &Judge,
    points: &[Vec<f64>],
    outcomes: Vec<PointOutcome>,
) -> PointTable {
    assert_eq!(points.len(), outcomes.len(), "each point has an outcome");
    let verdicts: Vec<PointVerdict> = outcomes.iter().map(|o| judge.verdict(o.as_deref().ok())).collect();
    let parameters = varied.iter().map(|&k| ParameterColumn {
        name: plan.inputs[k].name.clone(),
        unit: plan.inputs[k].unit.clone().unwrap_or_default(),
        values: points.iter().map(|p| p[k]).collect(),
    });
    let criteria = judge.criteria.iter().enumerate().map(|(j, criterion)| {
        let values = outcomes.iter().map(|outcome| match outcome {
            Ok(values) => values[j],
            // Other criteria of the run may have values all the same.
            Err(failure) => failure.value(j).unwrap_or(f64::NAN),
        });
        points::column(criterion, values.collect(), verdicts.iter().map(|v| v.passed[j]).collect())
    });
    PointTable {
        ids: (1..=points.len() as u64).collect(),
        parameters: parameters.collect(),
        criteria: criteria.collect(),
        verified: verdicts.iter().map(PointVerdict::verified).collect(),
        status: outcomes
            .iter()
            .map(|o| o.as_ref().map_or_else(|failure| failure.to_string().into(), |_| "ok".into()))
            .collect(),
    }
}
