//! Inputs that follow a recording.

use super::quantity::Scale;
use super::values::{find, slot_of};
use super::{Name, RecordingText, Study, StudyError};
use crate::table::Table;
use crate::task::{Schedule, Series, Slot};
use fmu_import::units::Conversion;
use fmu_import::{Causality, Content, Description, Variability, Variable};

/// The recordings of a study for an FMU.
pub(super) fn series(
    study: &Study,
    fmu: &Description,
    schedule: &Schedule,
) -> Result<Vec<Series>, StudyError> {
    let bind = |(name, recording): (&Name, &RecordingText)| {
        let wrong = |message: String| study.error_at(name, message);
        let key = name.as_ref().as_str();
        let named = |message: String| wrong(format!("{key}: {message}"));
        if study.parameters.contains_key(key) || study.fixed.contains_key(key) {
            let message = "is under [parameters] or [fixed] too; keep one";
            return Err(wrong(format!("{key} {message}")));
        }
        if schedule.leap {
            return Err(named(
                "leap would hold the input; remove one of them".to_owned(),
            ));
        }
        let variable = find(fmu, key).map_err(wrong)?;
        let slot = slot_while_running(variable).map_err(named)?;
        if recording.ramp {
            can_ramp(recording, fmu, &slot).map_err(named)?;
        }
        let scale = Scale::new(recording.unit.as_deref(), fmu, variable).map_err(named)?;
        let path = study.beside(recording.file.as_ref());
        let column = |name: &Option<String>, usual: &str| name.clone().unwrap_or(usual.to_owned());
        let columns = [
            (vec![column(&recording.time, "time")], "the time".to_owned()),
            (
                vec![column(&recording.column, key)],
                format!("the input {key}"),
            ),
        ];
        let table = Table::read(&path, &columns);
        let table = table.map_err(|error| study.error_at(&recording.file, error.to_string()))?;
        let mut series = follow(&table, &columns[0].0[0], slot, scale.conversion)
            .map_err(|message| named(format!("{}: {message}", path.display())))?;
        series.hold = recording.hold;
        series.ramp = recording.ramp;
        Ok(series)
    };
    study.inputs.iter().map(bind).collect()
}

/// How a variable takes numbers between the steps of a simulation.
///
/// # Errors
/// When it can only be set before, or not at all: FMI 2.0.5, 4.2.4, lets inputs and tunable parameters change.
pub(crate) fn slot_while_running(variable: &Variable) -> Result<Slot, String> {
    let slot = slot_of(variable)?;
    let tunable = variable.variability == Variability::Tunable;
    match variable.causality {
        Causality::Input => Ok(slot),
        Causality::Parameter if tunable => Ok(slot),
        Causality::Parameter => Err(
            "it is a fixed parameter, which cannot change while the simulation runs; set it once, before the start"
                .to_owned(),
        ),
        _ => Err("it is no input, so it can only be set once, before the start".to_owned()),
    }
}

/// An input that follows a table of times and values, along straight lines; `time_column` names the times in messages.
///
/// # Errors
/// When the times do not grow, or the FMU does not allow a value.
pub(crate) fn follow(
    table: &Table,
    time_column: &str,
    slot: Slot,
    conversion: Conversion,
) -> Result<Series, String> {
    let [mut times, mut values] = [Vec::new(), Vec::new()];
    for row in &table.rows {
        let (time, value) = (row[0], conversion.value(row[1]));
        let after = times.last().is_none_or(|&last| time >= last);
        if !(time.is_finite() && after) {
            return Err(format!(
                "{time_column} = {time} is not later than the time before"
            ));
        }
        slot.check(value)
            .map_err(|message| format!("{time_column} = {time}: {message}"))?;
        times.push(time);
        values.push(value);
    }
    Ok(Series {
        slot,
        hold: false,
        ramp: false,
        times,
        values,
    })
}

/// Whether an input can vary within a step.
fn can_ramp(recording: &RecordingText, fmu: &Description, slot: &Slot) -> Result<(), String> {
    let why = if recording.hold {
        "hold keeps the value between rows"
    } else if slot.handle.content != Content::Real {
        "the variable is not a Real"
    } else if !fmu.capabilities.can_interpolate_inputs {
        "the FMU does not interpolate inputs (canInterpolateInputs)"
    } else {
        return Ok(());
    };
    Err(format!("ramp = true, but {why}; remove ramp"))
}
