//! Runs without values: how many there are of each output, and what the numbers mean without them.

use parameter_regions::table::{CriterionColumn, PointTable};

/// The output that tells whether a run failed.
pub const OUTPUT: &str = "failed";

/// How many runs did not give all results.
pub fn failed(table: &PointTable) -> usize {
    (0..table.len()).filter(|&k| !table.completed(k)).count()
}

/// How many runs have no value of an output.
pub fn missing(values: &[f64]) -> usize {
    values.iter().filter(|value| !value.is_finite()).count()
}

/// Warns of failed runs: a sentence for each output that misses values, and one that says where to look.
pub fn warnings(table: &PointTable) -> Vec<String> {
    if failed(table) == 0 {
        return Vec::new();
    }
    let warnings = table.criteria.iter().filter(|c| missing(&c.values) > 0).map(warning);
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

fn warning(criterion: &CriterionColumn) -> String {
    let (name, values) = (&criterion.name, &criterion.values);
    let count = format!(
        "{name}: {} of {} runs have no value of it ({:.2} %)",
        missing(values),
        values.len(),
        100.0 * missing(values) as f64 / values.len() as f64,
    );
    if missing(values) == values.len() {
        return format!("{count}, so nothing can be said of it");
    }
    format!(
        "{count}; its numbers and intervals are those of the runs that have one, and would be others if the model had values \
         everywhere"
    )
}
