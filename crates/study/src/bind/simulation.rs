//! How the points of a study are simulated: the schedule, the parts of a run that criteria look at, the start values.

use std::collections::HashSet;

use fmu_import::Value;
use fmu_points::task::{InnerExchange, Probe, Schedule, ScheduleError};

use super::Binder;
use crate::{
    CriterionText, Result, Simulation,
    inputs::takes_any_step,
    ssv,
    values::{size_of, value_of},
};

impl Binder<'_> {
    /// The schedule of a study; what it does not say is as the FMU suggests.
    pub(super) fn schedule(&self) -> Result<Schedule, ScheduleError> {
        let simulation = &self.study.simulation;
        let experiment = Schedule::suggested(self.fmu);
        let start = simulation.start.unwrap_or(experiment.start);
        let stop = simulation.stop.unwrap_or(experiment.stop);
        let mut schedule = Schedule {
            start,
            stop,
            step: simulation.step.unwrap_or(experiment.step.min(stop - start)),
            window_start: start,
            leap: simulation.leap.unwrap_or(false),
            tolerance: simulation.tolerance.or(experiment.tolerance),
        };
        if !takes_any_step(self.fmu) {
            schedule = schedule.in_whole_steps();
        }
        schedule.window_start = window_start(simulation, &schedule)?;
        schedule.check()?;
        if simulation.step.is_none() {
            schedule
                .check_suggested()
                .map_err(|error| ScheduleError { message: format!("{error} under [simulation]"), ..error })?;
        }
        Ok(schedule)
    }

    /// The part of the run that a criterion looks at by itself, s.
    pub(super) fn stated_window(&self, text: &CriterionText, run: [f64; 2]) -> Result<Option<[f64; 2]>> {
        let Some(window) = &text.window else { return Ok(None) };
        window.as_ref().times(run).map(Some).map_err(|message| self.study.error_at(window, message))
    }

    /// The probes with their windows; what lies before the first window may be leapt over.
    pub(super) fn windows(&self, schedule: &mut Schedule, mut observed: Vec<Probe>) -> Result<Vec<Probe>> {
        let criteria = || self.study.criteria.values();
        let run = [schedule.start, schedule.stop];
        let general = [schedule.window_start, schedule.stop];
        // A curve has its own times, and looks from the start on; so does the value at a time.
        let is_cut = general != run && observed.iter().any(|probe| probe.measure.has_own_times());
        if criteria().all(|criterion| criterion.window.is_none()) && !is_cut {
            return Ok(observed);
        }
        for (probe, criterion) in observed.iter_mut().zip(criteria()) {
            probe.window = Some(match self.stated_window(criterion, run)? {
                _ if probe.measure.has_own_times() => run,
                Some(window) => window,
                // The final value is that at the end, whatever the others look at.
                None if probe.measure.is_final() => [schedule.stop; 2],
                None => general,
            });
        }
        let begins = observed.iter().filter_map(|probe| probe.window.map(|window| window[0]));
        schedule.window_start = begins.fold(schedule.stop, f64::min);
        self.refuse_empty_windows(schedule, &observed)?;
        Ok(observed)
    }

    /// Refuses stated windows in which the simulation has no communication point.
    fn refuse_empty_windows(&self, schedule: &Schedule, observed: &[Probe]) -> Result {
        let points = schedule.points();
        for (probe, criterion) in observed.iter().zip(self.study.criteria.values()) {
            let (Some([from, to]), Some(stated)) = (probe.window, &criterion.window) else { continue };
            let rounding = 1e-9 * (from.abs() + to.abs());
            if points.at(points.from(from - rounding)) > to + rounding {
                return Err(self.study.error_at(stated, format!(
                    "no communication point lies in the window from {from} s to {to} s; make `step` under [simulation] \
                     smaller"
                )));
            }
        }
        Ok(())
    }

    /// The variable by which a container of FMUs, as fmu-manipulation-toolbox makes them, multiplies its step.
    pub(super) fn exchange(&self) -> Option<InnerExchange> {
        let variable = self.fmu.variables.get("container.ts_multiplier")?;
        let start = match variable.kind.start_value() {
            Some(Value::Integer(steps)) => Some(steps),
            _ => None,
        };
        Some(InnerExchange { reference: variable.handle().reference, start })
    }

    /// The start values of all points.
    pub(super) fn fixed(&self) -> Result<Vec<(u32, Value)>> {
        let mut values = self.set()?;
        for (name, setting) in &self.study.fixed {
            let at = |message| self.study.error_at(setting, message);
            let variable = self.variable(name)?;
            match size_of(self.fmu, variable, setting.as_ref()).map_err(at)? {
                None => {
                    let value = value_of(self.fmu, variable, setting.as_ref()).map_err(at)?;
                    values.push((variable.handle().reference, value));
                }
                // The whole study has it.
                Some(size) if self.fmu.sizes.contains(&size) => {}
                Some(_) => {
                    let why = "it is the size of arrays, which all cases share: set it in the study's own [fixed]";
                    return Err(at(format!("{}: {why}", variable.name)));
                }
            }
        }
        Ok(values)
    }

    /// The start values of a parameter set that the study does not give itself.
    fn set(&self) -> Result<Vec<(u32, Value)>> {
        let Some(file) = &self.study.fixed_from else { return Ok(Vec::new()) };
        let path = self.study.path_of(file.as_ref());
        let named = ssv::read(&path, self.fmu).map_err(|error| self.study.error_at(file, error))?;
        let set: HashSet<&str> = self.study.set().map(|(name, _)| &**name.as_ref()).collect();
        Ok(named
            .into_iter()
            .filter(|(name, ..)| !set.contains(&**name))
            .map(|(_, reference, value)| (reference, value))
            .collect())
    }
}

fn window_start(simulation: &Simulation, schedule: &Schedule) -> Result<f64, ScheduleError> {
    match (simulation.warm_up, simulation.window) {
        (Some(_), Some(_)) => {
            let message = "there are both warm-up and window; keep one".to_owned();
            Err(ScheduleError { settings: &["warm-up"], message })
        }
        (Some(warm_up), None) => Ok(schedule.start + warm_up),
        (None, Some(window)) => Ok(schedule.stop - window),
        (None, None) => Ok(schedule.start),
    }
}
