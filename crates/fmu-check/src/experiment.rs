//! The probes' simulations: which variables they read, for how long, and which parameters they change.

use fmu_import::{Causality, Description, Handle, Kind, Value, Variability, Variable};
use fmu_points::task::Schedule;

/// All outputs and parameters; without outputs, local variables.
pub fn columns(fmu: &Description) -> Vec<&Variable> {
    const LOCALS: usize = 100;
    let mut columns: Vec<&Variable> = fmu.with(Causality::Output).collect();
    if columns.is_empty() {
        columns = fmu
            .with(Causality::Local)
            .filter(|variable| variable.variability != Variability::Constant)
            .take(LOCALS)
            .collect();
    }
    let numbers = fmu.with(Causality::Parameter).filter(|variable| variable.number_handle().is_some());
    columns.extend(numbers);
    columns
}

/// How many steps a probe takes.
const STEPS: f64 = 10.0;

/// A few steps of an experiment.
pub fn first_steps(whole: Schedule) -> Schedule {
    Schedule { stop: whole.stop.min(whole.start + STEPS * whole.step), ..whole }
}

/// The suggested experiment, or another where that is of no use, with this step or the suggested one.
pub fn schedule(fmu: &Description, step: Option<f64>) -> Schedule {
    let mut schedule = Schedule::suggested(fmu);
    schedule.step = step.unwrap_or(schedule.step);
    let passes = schedule.stop > schedule.start;
    if !passes {
        schedule.stop = schedule.start + 1.0;
    }
    if !(schedule.step > 0.0 && schedule.step.is_finite()) {
        schedule.step = (schedule.stop - schedule.start) / 500.0;
    }
    schedule.tolerance = schedule.tolerance.filter(|tolerance| *tolerance > 0.0);
    if fmu.capabilities.can_handle_variable_communication_step_size { schedule } else { schedule.in_whole_steps() }
}

/// When the last step of a schedule's size ends before the suggested stop time, s: a shorter one may be refused.
pub fn last_whole_step(fmu: &Description, schedule: &Schedule) -> f64 {
    let Schedule { start, step, .. } = *schedule;
    start + ((self::schedule(fmu, None).stop - start) / step + 1e-6).floor() * step
}

/// The same number of steps, of another size.
pub fn with_step(schedule: Schedule, step: f64) -> Schedule {
    Schedule { step, stop: schedule.start + STEPS * step, ..schedule }
}

/// Other values of real parameters: a little more than the start, within the range.
pub fn changed(fmu: &Description) -> Vec<(u32, Value)> {
    const MORE: f64 = 1.01;
    fmu.with(Causality::Parameter)
        .filter(|variable| variable.is_settable())
        .filter_map(|variable| {
            let Kind::Real { start: Some(start), min, max, .. } = variable.kind else { return None };
            let value = [start * MORE, start / MORE].into_iter().find(|value| {
                value.is_finite()
                    && *value != start
                    && min.is_none_or(|min| *value >= min)
                    && max.is_none_or(|max| *value <= max)
            })?;
            let Handle { reference, .. } = variable.handle();
            Some((reference, Value::Real(value)))
        })
        .collect()
}
