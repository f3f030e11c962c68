//! Runs without values: how many there are of each output, and what the numbers mean without them.

use parameter_regions::table::{CriterionColumn, PointTable};
use sensitivity::method::FromRuns;

/// The output that tells whether a run failed.
pub(super) const OUTPUT: &str = "failed";

/// How many runs did not give all results.
pub(super) fn failed(table: &PointTable) -> usize {
    (0..table.len()).filter(|&k| !table.completed(k)).count()
}

/// How many runs have no value of an output.
pub(super) fn missing(values: &[f64]) -> usize {
    values.iter().filter(|value| !value.is_finite()).count()
}

/// Warns of failed runs: a sentence for each output that misses values, and one that says where to look.
pub(super) fn warnings(table: &PointTable, method: Option<&dyn FromRuns>) -> Vec<String> {
    if failed(table) == 0 {
        return Vec::new();
    }
    let affected = table.criteria.iter().filter(|c| missing(&c.values) > 0);
    let warnings = affected.map(|criterion| warning(criterion, method));
    let share = |count: usize| 100.0 * count as f64 / table.len() as f64;
    let all = format!(
        "{} of {} runs failed ({:.2} %): `{OUTPUT}` tells which parameters make them fail, and `verified` counts them as not \
         verified",
        failed(table),
        table.len(),
        share(failed(table)),
    );
    warnings.chain([all]).collect()
}

fn warning(criterion: &CriterionColumn, method: Option<&dyn FromRuns>) -> String {
    let (name, values) = (&criterion.name, &criterion.values);
    let known = || values.iter().copied().filter(|value| value.is_finite());
    let count = format!(
        "{name}: {} of {} runs have no value of it ({:.2} %)",
        missing(values),
        values.len(),
        100.0 * missing(values) as f64 / values.len() as f64,
    );
    if known().next().is_none() {
        return format!("{count}, so nothing can be said of it");
    }
    let meaning = format!(
        "{count}; its numbers and intervals are those of the runs that have one, and would be others if the model had values \
         everywhere"
    );
    if method.is_none() {
        return meaning;
    }
    format!(
        "{meaning}: the bounds in braces hold if those values lie between {:.4} and {:.4}, as all others do",
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    )
}
