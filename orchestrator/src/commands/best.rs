//! Writes the best point as an SSP parameter set.

use crate::{error::Result, results::Summary};
use fmu_import::{Description, Value, Variable};
use point_journal::files::write_text;
use std::path::Path;
use study::{plan::Plan, ssv};

const SET: &str = "best.ssv";

/// Writes `best.ssv` with all start values of the best point.
pub fn write(folder: &Path, plan: &Plan, fmu: &Description, summary: &Summary) -> Result {
    let Some(best) = &summary.best_point else {
        // An earlier run may have left one.
        let _ = std::fs::remove_file(folder.join(SET));
        return Ok(());
    };
    let parameters: Vec<f64> = best.parameters.values().copied().collect();
    let mut values = Vec::new();
    plan.to_fmu(&parameters, &mut values);
    // Start values of single cases belong to the tests, not to the model.
    let common = |setting: &(u32, Value)| plan.cases.iter().all(|case| case.task.fixed.contains(setting));
    let fixed =
        plan.cases.first().map_or(&[][..], |case| &case.task.fixed).iter().filter(|setting| common(setting)).cloned();
    // What a sensor reads wrong is no start value of the model.
    let varied = plan
        .slots
        .iter()
        .zip(&values)
        .filter(|(slot, _)| slot.error.is_none())
        .map(|(slot, &value)| (slot.handle.reference, slot.value(value)));
    let named = fixed.chain(varied).filter_map(|(reference, value)| {
        let variable = variable(fmu, reference, &value)?;
        Some((variable, value))
    });
    let title = summary.title.as_deref().unwrap_or(&summary.provenance.study);
    let name = format!("{title}: point {}", best.point);
    let set = ssv::write(&name, fmu, &named.collect::<Vec<_>>());
    Ok(write_text(&folder.join(SET), set)?)
}

/// The variable behind a reference: every type has references of its own.
fn variable<'a>(fmu: &'a Description, reference: u32, value: &Value) -> Option<&'a Variable> {
    fmu.variables.values().find(|variable| {
        let fits = variable.kind.content() == value.content();
        variable.handle().reference == reference && variable.is_settable() && fits
    })
}
