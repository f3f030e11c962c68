//! Measured curves beside the results.

use std::{fs, path::Path};

use crate::{report::history, results::Summary};
use number_tables::csv_file;
use point_journal::files::write_table;
use study::plan::Plan;

/// Writes the measured curves, where there are any, and returns a sentence where that fails.
pub fn write(plan: &Plan, folder: &Path, summary: &Summary) -> Option<String> {
    let path = folder.join(history::MEASURED);
    if plan.probes().all(|probe| probe.measure.curve().is_none()) {
        // An earlier run may have left one.
        let _ = fs::remove_file(&path);
        return None;
    }
    write_table(&path, history::MEASURED_COLUMNS, |table| {
        for (probe, name) in plan.probes().zip(summary.criteria.keys()) {
            let Some(curve) = probe.measure.curve() else { continue };
            for (row, (time, value)) in curve.shown_times().zip(&curve.values).enumerate() {
                let uncertainty = curve.expanded(row).map(|width| width.to_string()).unwrap_or_default();
                table.write_record([&*csv_file::cell(name), &time.to_string(), &value.to_string(), &uncertainty])?;
            }
        }
        Ok(())
    })
    .err()
    .map(|error| error.to_string())
}
