//! Ties a study to an FMU: names become variables, units convert, numbers are checked.

use crate::{Result, cases::SEPARATOR, concern::Concern};
use std::{collections::HashSet, sync::Arc};

use toml::Spanned;

use super::{
    CaseText, CriterionText, Detail, Name, ParameterText, Study,
    input::Input,
    inputs::{self, Recordings},
    limit::limit,
    measured::{self, Binder as CurveBinder},
    samples::{self, Together},
    ssv,
    values::{find, size_of, slot_of, value_of},
};
use fmu_import::{Content, Description, Handle, Value, Variable, quantity::Scale, units::Conversion};
use fmu_points::task::{InnerExchange, Measure, MeasuredCurve, Probe, Product, Schedule, ScheduleError, Slot, Task};
use sampling::{design::Joint, statistics::Statistic};

/// Finds variables and checks values for one FMU.
pub struct Binder<'a> {
    pub study: &'a Study,
    pub fmu: &'a Description,
}

/// A simulation with what belongs to it.
pub struct Bound {
    /// From the FMU's units to the study's, a criterion each.
    pub outputs: Vec<Conversion>,
    /// The simulation.
    pub task: Task,
    /// The errors of its inputs' sensors.
    pub errors: Vec<inputs::InputError>,
    /// Doubts about its inputs.
    pub concerns: Vec<Concern>,
}

impl Binder<'_> {
    /// The simulation of a point, or of one of its cases.
    pub fn task(&self, case: Option<&CaseText>, varied: Vec<Slot>) -> Result<Bound> {
        let mut schedule = self.schedule().map_err(|error| match case {
            None => self.study.error_in("simulation", error.settings, error),
            Some(case) => {
                let name = case.name.as_ref();
                self.study.error_at(&case.name, format!("the simulation of the case `{name}`: {error}"))
            }
        })?;
        let (outputs, observed) = self.criteria(&schedule)?;
        let observed = self.windows(&mut schedule, observed)?;
        let Recordings { series: inputs, errors, mut concerns } = inputs::series(self.study, self.fmu, &schedule)?;
        let curves = self.study.criteria.iter().zip(&observed);
        concerns.extend(curves.filter_map(|((name, text), probe)| {
            let curve = probe.measure.curve()?;
            let scale = text.scale(Some((self.fmu, self.variable(&text.variable).ok()?))).ok()?;
            measured::doubt(name.as_ref(), curve, limit(text, curve.metric, &scale).ok()?)
        }));
        let (sizes, fixed, exchange) = (self.fmu.sizes.clone(), self.fixed()?, self.exchange());
        let task = Task { schedule, sizes, fixed, exchange, varied, inputs, observed };
        Ok(Bound { outputs, task, errors, concerns })
    }

    fn variable<T: AsRef<str>>(&self, name: &Spanned<T>) -> Result<&Variable> {
        find(self.fmu, name.as_ref().as_ref()).map_err(|message| self.study.error_at(name, message))
    }

    pub fn parameters(&self) -> Result<(Vec<Input>, Vec<Slot>)> {
        self.study
            .parameters
            .iter()
            .map(|(name, parameter)| {
                let variable = self.variable(name)?;
                let at = |message| self.study.error_of(name, message);
                let slot = slot_of(variable).map_err(at)?;
                let input = self.parameter(variable, parameter).map_err(at)?;
                Ok((input, slot))
            })
            .collect()
    }

    /// Reads the parameters that come from samples, and gives each its distribution.
    pub fn samples(&self, inputs: &mut [Input]) -> Result<Vec<Joint>> {
        let samples = samples::read(self.study, inputs)?;
        let mut joints = Vec::new();
        for Together { joint, alone } in samples {
            for (index, distribution) in alone {
                inputs[index].distribution = distribution;
            }
            joints.push(joint);
        }
        Ok(joints)
    }

    /// Checks that the FMU takes the middle of each distribution.
    pub fn within(&self, inputs: &[Input], slots: &[Slot]) -> Result {
        let pairs = inputs.iter().zip(slots);
        for ((input, slot), name) in pairs.zip(self.study.parameters.keys()) {
            let value = input.conversion.value(input.distribution.median());
            slot.check(value).map_err(|message| self.study.error_of(name, message))?;
        }
        Ok(())
    }

    fn parameter(&self, variable: &Variable, parameter: &ParameterText) -> Result<Input, String> {
        let unit = parameter.unit.as_deref().or(parameter.first_unit());
        let scale = Scale::new(unit, self.fmu, variable)?;
        let distribution = parameter.distribution(&scale)?;
        let is_whole = variable.handle().content == Content::Integer;
        let distribution = if is_whole { distribution.whole() } else { distribution };
        distribution.check()?;
        Ok(Input {
            name: variable.name.clone(),
            unit: scale.unit.clone(),
            distribution,
            is_whole,
            conversion: scale.conversion,
        })
    }

    fn criteria(&self, schedule: &Schedule) -> Result<(Vec<Conversion>, Vec<Probe>)> {
        self.study
            .criteria
            .iter()
            .map(|(name, criterion)| {
                let variable = self.variable(&criterion.variable)?;
                let at = |message| self.study.error_at(&criterion.variable, message);
                let probe = Probe::of(variable, criterion.statistic.unwrap_or_default())
                    .ok_or_else(|| at("a text cannot be compared with a measurement".to_owned()))?;
                let scale = criterion.scale(Some((self.fmu, variable))).map_err(at)?;
                let curve = self.curve(name, criterion, &scale, &probe.handle, schedule)?;
                let number = self.measure(name, criterion, variable, schedule)?;
                let probe = Probe {
                    measure: curve.map_or(number, Measure::Curve),
                    product: self.product(criterion, variable),
                    ..probe
                };
                Ok((scale.conversion.inverse(), probe))
            })
            .collect()
    }

    /// What a derived criterion is the product of, where one factor is a recorded input.
    fn product(&self, text: &CriterionText, variable: &Variable) -> Option<Product> {
        let derived = text.derived.as_ref()?;
        let [from, by] = [&derived.from, &derived.by].map(|key| key.as_ref().as_str());
        self.study.inputs.get(by)?;
        // Other statistics of a product do not follow from those of its factors.
        let is_linear = matches!(text.statistic.unwrap_or_default(), Statistic::Mean | Statistic::Final);
        if !is_linear || text.percent.is_some() || text.level.is_some() {
            return None;
        }
        let is_factor =
            |name: &str| name == from || text.case.is_some() && name.ends_with(&format!("{SEPARATOR}{from}"));
        let mut criteria = self.study.criteria.iter();
        let (_, factor) = criteria.find(|(name, _)| is_factor(name.as_ref()))?;
        let of = find(self.fmu, factor.variable.as_ref()).ok()?;
        let by = find(self.fmu, by).ok()?;
        let to_base = |variable: &Variable| match variable.unit() {
            None => Some(1.0),
            Some(unit) => self.fmu.units.0.get(unit)?.base.map(|base| base.to_base.factor),
        };
        // Without the units' definitions they count as coherent.
        let factor = to_base(of).zip(to_base(by)).zip(to_base(variable)).map_or(1.0, |((of, by), own)| of * by / own);
        Some(Product { of: of.number_handle()?, by: by.number_handle()?, factor })
    }

    /// What turns a criterion's signal into one number, but for a measured curve.
    fn measure(&self, name: &Name, text: &CriterionText, variable: &Variable, schedule: &Schedule) -> Result<Measure> {
        let named = |message| self.study.error_of(name, message);
        let detail = text.detail().map_err(named)?;
        let needs_lines =
            detail.is_some() || text.turns.is_some() || text.statistic.is_some_and(Statistic::needs_lines);
        if needs_lines && variable.handle().content != Content::Real {
            return Err(named(
                "this statistic follows straight lines, and the variable is not real; take final, mean, min or max"
                    .to_owned(),
            ));
        }
        if let Some(angle) = &text.turns {
            return self.turns(angle, variable);
        }
        match detail {
            Some(Detail::Level(number, direction)) => {
                let unit = text.level.as_ref().and_then(|level| level.as_ref().unit.as_deref());
                let level = Scale::new(unit, self.fmu, variable).map_err(named)?.conversion.value(number);
                Ok(Measure::Crossing { level, direction })
            }
            Some(Detail::At(time)) if !(schedule.start..=schedule.stop).contains(&time) => Err(named(format!(
                "at = {time} s is not within the run from {} s to {} s; correct it, or start and stop under [simulation]",
                schedule.start, schedule.stop
            ))),
            Some(Detail::At(time)) => Ok(Measure::At(time)),
            Some(Detail::Percent(percent)) => Ok(Measure::Percentile(percent)),
            None => Ok(Measure::Statistic(text.statistic.unwrap_or_default())),
        }
    }

    /// The angle over whose whole turns the mean of a variable is taken.
    fn turns(&self, name: &Spanned<String>, of: &Variable) -> Result<Measure> {
        let at = |message| self.study.error_at(name, message);
        let angle = self.variable(name)?;
        let handle = angle.number_handle();
        let handle = handle
            .filter(|handle| handle.content == Content::Real && angle.name != of.name)
            .ok_or_else(|| at("turns must name another real variable, an angle".to_owned()))?;
        let turn = Scale::new(Some("rad"), self.fmu, angle)
            .map_err(|message| at(format!("turns must name an angle: {message}")))?
            .conversion
            .difference(std::f64::consts::TAU);
        Ok(Measure::MeanOverTurns { angle: handle, turn: turn.abs() })
    }

    /// The measured curve of a criterion, where it has one.
    fn curve(
        &self,
        name: &Name,
        text: &CriterionText,
        scale: &Scale,
        handle: &Handle,
        schedule: &Schedule,
    ) -> Result<Option<Arc<MeasuredCurve>>> {
        let (Some(reference), Some(metric)) = (&text.reference, text.metric) else { return Ok(None) };
        if handle.content != Content::Real {
            return Err(self.study.error_at(&text.variable, "only real variables can be compared with a curve"));
        }
        let run = [schedule.start, schedule.stop];
        let general = [schedule.window_start, schedule.stop];
        let stated = self.stated_window(text, run)?;
        let binder = CurveBinder {
            study: self.study,
            name,
            text,
            reference,
            metric,
            scale,
            run,
            window: stated.or((general != run).then_some(general)),
        };
        binder.bind().map(|curve| Some(Arc::new(curve)))
    }

    /// The part of the run that a criterion looks at by itself, s.
    fn stated_window(&self, text: &CriterionText, run: [f64; 2]) -> Result<Option<[f64; 2]>> {
        let Some(window) = &text.window else { return Ok(None) };
        window.as_ref().times(run).map(Some).map_err(|message| self.study.error_at(window, message))
    }

    /// The probes with their windows; what lies before the first window may be leapt over.
    fn windows(&self, schedule: &mut Schedule, mut observed: Vec<Probe>) -> Result<Vec<Probe>> {
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
        let points = schedule.points();
        for (probe, criterion) in observed.iter().zip(criteria()) {
            let (Some([from, to]), Some(stated)) = (probe.window, &criterion.window) else { continue };
            let rounding = 1e-9 * (from.abs() + to.abs());
            if points.at(points.from(from - rounding)) > to + rounding {
                return Err(self.study.error_at(stated, format!(
                    "no communication point lies in the window from {from} s to {to} s; make `step` under [simulation] \
                     smaller"
                )));
            }
        }
        Ok(observed)
    }

    /// The variable by which a container of FMUs, as fmu-manipulation-toolbox makes them, multiplies its step.
    fn exchange(&self) -> Option<InnerExchange> {
        let variable = self.fmu.variables.get("container.ts_multiplier")?;
        let start = match variable.kind.start_value() {
            Some(Value::Integer(steps)) => Some(steps),
            _ => None,
        };
        Some(InnerExchange { reference: variable.handle().reference, start })
    }

    fn fixed(&self) -> Result<Vec<(u32, Value)>> {
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

    fn schedule(&self) -> Result<Schedule, ScheduleError> {
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
        if !inputs::takes_any_step(self.fmu) {
            schedule = schedule.in_whole_steps();
        }
        let stop = schedule.stop;
        schedule.window_start = match (simulation.warm_up, simulation.window) {
            (Some(_), Some(_)) => {
                let message = "there are both warm-up and window; keep one".to_owned();
                return Err(ScheduleError { settings: &["warm-up"], message });
            }
            (Some(warm_up), None) => start + warm_up,
            (None, Some(window)) => stop - window,
            (None, None) => start,
        };
        schedule.check()?;
        if simulation.step.is_none() {
            schedule
                .check_suggested()
                .map_err(|error| ScheduleError { message: format!("{error} under [simulation]"), ..error })?;
        }
        Ok(schedule)
    }
}
