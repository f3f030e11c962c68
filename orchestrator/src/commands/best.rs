//! The best point as a parameter set of SSP, with its provenance.

use crate::error::Error;
use crate::results::{Summary, traceability};
use fmu_import::{Description, Value, Variable, digest};
use fmu_points::task::Case;
use point_journal::files::write_text;
use std::path::Path;
use study::plan::Plan;
use study::ssv;

const SET: &str = "best.ssv";
const PROVENANCE: &str = "best.srmd";

/// Writes `best.ssv` with all start values of the best point, and `best.srmd` with where they come from.
pub(super) fn write(folder: &Path, plan: &Plan, fmu: &Description, summary: &Summary) -> Result<(), Error> {
    let Some(best) = &summary.best_point else {
        for file in [SET, PROVENANCE] {
            // An earlier run may have left one.
            let _ = std::fs::remove_file(folder.join(file));
        }
        return Ok(());
    };
    let parameters: Vec<f64> = best.parameters.values().copied().collect();
    let mut values = Vec::new();
    plan.to_fmu(&parameters, &mut values);
    // Start values of single cases belong to the tests, not to the model.
    let common = |setting: &(u32, Value)| {
        let has = |case: &Case| case.task.fixed.contains(setting);
        plan.cases.iter().all(has)
    };
    let first = plan.cases.first().map_or(&[][..], |case| &case.task.fixed);
    let fixed = first.iter().filter(|setting| common(setting)).cloned();
    // What a sensor reads wrong is no start value of the model.
    let varied = plan.slots.iter().zip(&values).filter(|(slot, _)| slot.error.is_none());
    let varied = varied.map(|(slot, &value)| (slot.handle.reference, slot.value(value)));
    let named = fixed.chain(varied).filter_map(|(reference, value)| {
        let variable = variable(fmu, reference, &value)?;
        Some((variable, value))
    });
    let title = summary.title.as_deref().unwrap_or(&summary.provenance.study);
    let name = format!("{title}: point {}", best.point);
    let set = ssv::write(&name, fmu, &named.collect::<Vec<_>>());
    let provenance = traceability::resource(&name, SET, &entries(summary, best.point, &set));
    for (file, text) in [(SET, set), (PROVENANCE, provenance)] {
        write_text(&folder.join(file), text)?;
    }
    Ok(())
}

/// The variable behind a reference: every type has references of its own.
fn variable<'a>(fmu: &'a Description, reference: u32, value: &Value) -> Option<&'a Variable> {
    fmu.variables.values().find(|variable| {
        let fits = variable.kind.content() == value.content();
        variable.handle().reference == reference && variable.is_settable() && fits
    })
}

/// Everything needed to compute the same point again.
fn entries(summary: &Summary, point: u64, set: &str) -> Vec<traceability::Entry> {
    let mut entries = traceability::origin(summary);
    entries.push(("point".to_owned(), point.to_string()));
    entries.push(("data.sha256".to_owned(), digest(set.as_bytes())));
    entries
}
