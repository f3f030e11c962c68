//! Ties a study to an FMU: names become variables, units convert, numbers are checked.

use std::ops::Range;

use serde::Serialize;
use toml::Spanned;

use super::curves::Binder as CurveBinder;
use super::quantity::Scale;
use super::{
    CaseText, CriterionText, Name, ParameterText, Setting, Study, StudyError, inputs, points,
    samples, ssv,
};
use fmu_import::units::Conversion;
use fmu_import::{Content, Description, Handle, Value, Variable};
use fmu_points::task::{Case, Detail, MeasuredCurve, Probe, Schedule, Slot, Task};
use sampling::design::correlation::Correlation;
use sampling::design::{self, Design, Joint, Sampling};
use sampling::distribution::Distribution;
use sampling::statistics::Statistic;

pub use super::values::{bare, find, slot_of, value_of};

/// A study that fits an FMU.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The simulations of a point, in the FMU's own terms: one, or one a case of the study. Their results, one after the
    /// other, are those of the criteria in the order of the study.
    pub cases: Vec<Case>,
    /// The variables that take the parameters' values.
    pub slots: Vec<Slot>,
    /// The parameters, in the order of the study.
    pub inputs: Vec<Input>,
    /// From the FMU's unit to the study's, a criterion each.
    pub outputs: Vec<Conversion>,
    /// The levels of the parameters in a full factorial.
    levels: Vec<Option<u64>>,
    /// How the parameters are correlated, if they are.
    correlation: Option<Correlation>,
    /// Parameters that are drawn together from samples.
    joints: Vec<Joint>,
    /// Doubts about the inputs that follow recordings, a sentence each.
    of_inputs: Vec<String>,
}

/// One uncertain parameter.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// The FMU's variable.
    pub name: String,
    /// The unit of the study's numbers.
    pub unit: Option<String>,
    /// The distribution, in that unit.
    #[serde(flatten)]
    pub distribution: Distribution,
    /// From that unit to the FMU's.
    #[serde(skip)]
    pub conversion: Conversion,
}

impl Plan {
    /// Ties the study to the FMU.
    ///
    /// # Errors
    /// With line and column, when a name, a unit or a number of the study doesn't fit.
    pub fn new(study: &Study, fmu: &Description) -> Result<Self, StudyError> {
        points::check(study)?;
        let binder = Binder { study, fmu };
        let (mut inputs, varied) = binder.parameters()?;
        let joints = binder.samples(&mut inputs)?;
        binder.within(&inputs, &varied)?;
        let (mut cases, mut outputs, mut of_inputs) = (Vec::new(), Vec::new(), Vec::new());
        for (case, study) in study.by_case() {
            study.once(fmu, study.set())?;
            let binder = Binder { study: &study, fmu };
            let (own, task, doubts) = binder.task(case, varied.clone())?;
            outputs.extend(own);
            of_inputs.extend(doubts.into_iter().map(|doubt| match case {
                Some(case) => format!("case {}: {doubt}", case.name.as_ref()),
                None => doubt,
            }));
            cases.push(Case {
                name: case.map(|case| case.name.as_ref().clone()),
                task,
            });
        }
        Ok(Self {
            cases,
            slots: varied,
            inputs,
            outputs,
            levels: study
                .parameters
                .values()
                .map(|p| p.levels.as_ref().map(|levels| *levels.as_ref()))
                .collect(),
            correlation: points::correlation(study)?,
            joints,
            of_inputs,
        })
    }

    /// Leaves out the draws of measured curves, which nothing but the risk of a verdict needs.
    pub fn forget_resampling(&mut self) {
        let observed = self
            .cases
            .iter_mut()
            .flat_map(|case| &mut case.task.observed);
        for curve in observed.filter_map(|probe| probe.curve.as_mut()) {
            curve.resampling = None;
        }
    }

    /// The points of a design over the parameters.
    ///
    /// # Errors
    /// When the method cannot serve this number of parameters or points.
    pub fn design(&self, design: &Sampling) -> Result<Design, String> {
        let distributions = self.inputs.iter().map(|input| input.distribution.clone());
        let inputs = design::Inputs {
            distributions: distributions.collect(),
            levels: self.levels.clone(),
            correlation: self.correlation.clone(),
            joints: self.joints.clone(),
        };
        Design::new(design, inputs)
    }

    /// The parameters that vary, by their places among the inputs.
    pub fn varied(&self) -> Vec<usize> {
        (0..self.inputs.len())
            .filter(|&k| self.inputs[k].distribution.varies())
            .collect()
    }

    /// The parameters at a point of the unit cube of those that vary; the others have their medians.
    pub fn from_cube(&self, cube: &[f64]) -> Vec<f64> {
        // Away from the ends of the unit interval, where a distribution may reach to infinity.
        let mut given = cube.iter().map(|u| u.clamp(1e-6, 1.0 - 1e-6));
        let place = |input: &Input| {
            let varies = input.distribution.varies();
            let own = varies.then(|| {
                given
                    .next()
                    .expect("a place for each parameter that varies")
            });
            own.unwrap_or(0.5)
        };
        let places: Vec<f64> = self.inputs.iter().map(place).collect();
        let pairs = self.inputs.iter().zip(&places);
        let mut point: Vec<f64> = pairs
            .map(|(input, &u)| input.distribution.quantile(u))
            .collect();
        self.fill(&places, &mut point);
        point
    }

    /// Puts the rows of the samples into a point.
    fn fill(&self, places: &[f64], point: &mut [f64]) {
        for joint in &self.joints {
            joint.fill(places, point);
        }
    }

    /// The parameters at independent standard normal scores of those that vary, correlated as the study says.
    pub fn at_scores(&self, scores: &[f64]) -> Vec<f64> {
        let mut given = scores.iter().copied();
        let score = |input: &Input| {
            let varies = input.distribution.varies();
            let own = varies.then(|| {
                given
                    .next()
                    .expect("a score for each parameter that varies")
            });
            own.unwrap_or(0.0)
        };
        let all: Vec<f64> = self.inputs.iter().map(score).collect();
        let inputs = || self.inputs.iter().map(|input| input.distribution.clone());
        let mut point: Vec<f64> = match &self.correlation {
            Some(correlation) => correlation.at_scores(&all, &inputs().collect::<Vec<_>>()),
            None => {
                let pairs = inputs().zip(&all);
                pairs.map(|(input, &z)| input.at_score(z)).collect()
            }
        };
        let unit = Distribution::Uniform { min: 0.0, max: 1.0 };
        let places: Vec<f64> = all.iter().map(|&z| unit.at_score(z)).collect();
        self.fill(&places, &mut point);
        point
    }

    /// How the parameters are correlated, if they are, by their places among the inputs.
    pub fn correlation(&self) -> Option<&Correlation> {
        self.correlation.as_ref()
    }

    /// Whether every parameter varies on its own.
    pub fn is_independent(&self) -> bool {
        self.correlation.is_none() && !self.joints.iter().any(Joint::binds)
    }

    /// The parameters that are drawn from samples, by file; those of one file together.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The names of parameters that are drawn together with others from a sample.
    pub fn together(&self) -> Vec<&str> {
        let bound = self.joints.iter().filter(|joint| joint.binds());
        bound
            .flat_map(Joint::inputs)
            .map(|&k| self.inputs[k].name.as_str())
            .collect()
    }

    /// Whether the parameters' joint density is known: that of what a sample was drawn from is not.
    pub fn has_density(&self) -> bool {
        self.joints.is_empty()
    }

    /// The logarithm of the parameters' joint density at a point, without that of samples.
    pub fn ln_prior(&self, parameters: &[f64]) -> f64 {
        let pairs = self.inputs.iter().zip(parameters);
        let alone: f64 = pairs
            .map(|(input, &x)| input.distribution.ln_density(x))
            .sum();
        let correlated = self.correlation.as_ref().map_or(0.0, |correlation| {
            let inputs = self.inputs.iter().map(|input| input.distribution.clone());
            correlation.ln_density(parameters, &inputs.collect::<Vec<_>>())
        });
        alone + correlated
    }

    /// Doubts about the study's numbers, a sentence each: parameters of which the FMU refuses a large part of the
    /// distribution, recorded inputs that it cannot follow.
    pub fn concerns(&self) -> Vec<String> {
        const LARGE: f64 = 0.05;
        let concern = |(input, slot): (&Input, &Slot)| {
            let own = input.conversion.inverse();
            let below = |limit: f64| match limit {
                f64::INFINITY => 1.0,
                f64::NEG_INFINITY => 0.0,
                limit => input.distribution.below(own.value(limit)),
            };
            let allowed = slot.allowed().into_iter();
            let inside: f64 = allowed.map(|[low, high]| below(high) - below(low)).sum();
            let unit = input
                .unit
                .as_deref()
                .map_or_else(String::new, |unit| format!(" {unit}"));
            (1.0 - inside >= LARGE && input.distribution.varies()).then(|| {
                format!(
                    "{}: {:.0} % of the distribution lies outside of what the FMU allows ({}{unit}); such points \
                     fail and count as not verified: cut the distribution there (`truncated-normal`), or correct it",
                    input.name,
                    100.0 * (1.0 - inside),
                    slot.allowed_text(|limit| own.value(limit)),
                )
            })
        };
        let pairs = self.inputs.iter().zip(&self.slots);
        let refused = pairs.filter_map(concern);
        refused.chain(self.of_inputs.iter().cloned()).collect()
    }

    /// Tells at once of recorded inputs that the FMU gets otherwise, or at a great cost: every analysis rests on them.
    pub fn tell_of_inputs(&self) {
        for doubt in &self.of_inputs {
            fmu_points::tell::line!("note: {doubt}");
        }
    }

    /// What so many points cannot tell of parameters from samples, a sentence each.
    pub fn concerns_of_samples(&self, points: u64) -> Vec<String> {
        let few = self
            .joints
            .iter()
            .filter(|joint| (joint.count() as u64) < points);
        let concern = |joint: &Joint| {
            let names = joint.inputs().iter().map(|&k| self.inputs[k].name.as_str());
            format!(
                "{}: {points} points repeat the {} rows of the sample; the interval of the verified share takes these rows \
                 for all that there is, and does not count that they are only a sample: give one with more rows",
                names.collect::<Vec<_>>().join(", "),
                joint.count()
            )
        };
        few.map(concern).collect()
    }

    /// What is observed of each criterion, in the order of the study.
    pub fn probes(&self) -> impl Iterator<Item = &Probe> {
        self.cases.iter().flat_map(|case| &case.task.observed)
    }

    /// The same, each with the number of its case.
    pub fn placed_probes(&self) -> impl Iterator<Item = (usize, &Probe)> {
        let cases = self.cases.iter().enumerate();
        cases.flat_map(|(number, case)| case.task.observed.iter().map(move |probe| (number, probe)))
    }

    /// Which of the study's criteria a case has.
    pub fn criteria_of(&self, case: usize) -> Range<usize> {
        let before = self.cases.iter().take(case);
        let first = before.map(|case| case.task.observed.len()).sum();
        first..first + self.cases[case].task.observed.len()
    }

    /// A point's parameters in the FMU's units.
    pub fn to_fmu(&self, parameters: &[f64], into: &mut Vec<f64>) {
        assert_eq!(
            parameters.len(),
            self.inputs.len(),
            "a value for each parameter"
        );
        into.clear();
        let pairs = self.inputs.iter().zip(parameters);
        into.extend(pairs.map(|(input, &value)| input.conversion.value(value)));
    }

    /// The FMU's results in the study's units.
    pub fn to_study(&self, values: &mut [f64]) {
        assert_eq!(
            values.len(),
            self.outputs.len(),
            "a value for each criterion"
        );
        for (value, (conversion, probe)) in values
            .iter_mut()
            .zip(self.outputs.iter().zip(self.probes()))
            // A curve's number is in the study's unit already.
            .filter(|(_, (_, probe))| probe.curve.is_none())
        {
            *value = if probe.statistic.is_difference() {
                conversion.difference(*value)
            } else {
                conversion.value(*value)
            };
        }
    }
}

/// Finds variables and checks values for one FMU.
struct Binder<'a> {
    study: &'a Study,
    fmu: &'a Description,
}

impl Binder<'_> {
    /// From the FMU's units to the study's, a criterion each; the simulation of a point; doubts about its inputs.
    fn task(
        &self,
        case: Option<&CaseText>,
        varied: Vec<Slot>,
    ) -> Result<(Vec<Conversion>, Task, Vec<String>), StudyError> {
        let mut schedule = self.schedule().map_err(|message| match case {
            None => self.study.error(format!("[simulation] {message}")),
            Some(case) => {
                let name = case.name.as_ref();
                let message = format!("the simulation of the case `{name}`: {message}");
                self.study.error_at(&case.name, message)
            }
        })?;
        let (outputs, observed) = self.criteria(&schedule)?;
        let observed = self.windows(&mut schedule, observed)?;
        let (inputs, doubts) = inputs::series(self.study, self.fmu, &schedule)?;
        let task = Task {
            schedule,
            fixed: self.fixed()?,
            varied,
            inputs,
            observed,
        };
        Ok((outputs, task, doubts))
    }

    fn variable<T: AsRef<str>>(&self, name: &Spanned<T>) -> Result<&Variable, StudyError> {
        find(self.fmu, name.as_ref().as_ref()).map_err(|message| self.study.error_at(name, message))
    }

    fn parameters(&self) -> Result<(Vec<Input>, Vec<Slot>), StudyError> {
        let bind = |(name, parameter): (&Name, &ParameterText)| {
            let variable = self.variable(name)?;
            let at = |message: String| self.study.error_at(name, message);
            let name = name.as_ref().clone();
            let at = |message: String| at(format!("{name}: {message}"));
            let slot = slot_of(variable).map_err(at)?;
            let input = self.parameter(variable, parameter).map_err(at)?;
            Ok((input, slot))
        };
        self.study.parameters.iter().map(bind).collect()
    }

    /// Reads the parameters that come from samples, and gives each its distribution.
    fn samples(&self, inputs: &mut [Input]) -> Result<Vec<Joint>, StudyError> {
        let known = inputs.iter().map(|input| samples::Known {
            name: &input.name,
            unit: input.unit.as_deref(),
        });
        let found = samples::read(self.study, &known.collect::<Vec<_>>())?;
        for (index, distribution) in found.iter().flat_map(|own| &own.alone) {
            inputs[*index].distribution = distribution.clone();
        }
        Ok(found.into_iter().map(|own| own.joint).collect())
    }

    /// Checks that the FMU takes the middle of each distribution.
    fn within(&self, inputs: &[Input], slots: &[Slot]) -> Result<(), StudyError> {
        let pairs = inputs.iter().zip(slots);
        for ((input, slot), name) in pairs.zip(self.study.parameters.keys()) {
            let value = input.conversion.value(input.distribution.median());
            let at = |message: String| {
                let message = format!("{}: {message}", name.as_ref());
                self.study.error_at(name, message)
            };
            slot.check(value).map_err(at)?;
        }
        Ok(())
    }

    fn parameter(&self, variable: &Variable, parameter: &ParameterText) -> Result<Input, String> {
        let unit = parameter.unit.as_deref().or(parameter.first_unit());
        let scale = Scale::new(unit, self.fmu, variable)?;
        let distribution = parameter.distribution(&scale)?;
        distribution.check()?;
        Ok(Input {
            name: variable.name.clone(),
            unit: scale.unit.clone(),
            distribution,
            conversion: scale.conversion,
        })
    }

    fn criteria(&self, schedule: &Schedule) -> Result<(Vec<Conversion>, Vec<Probe>), StudyError> {
        let bind = |(name, criterion): (&Name, &CriterionText)| {
            let variable = self.variable(&criterion.variable)?;
            let at = |message| self.study.error_at(&criterion.variable, message);
            let handle = variable
                .number_handle()
                .ok_or_else(|| at("a text cannot be compared with a measurement".to_owned()))?;
            let scale = criterion.scale(self.fmu, variable).map_err(at)?;
            let probe = Probe {
                name: variable.name.clone(),
                handle,
                statistic: criterion.statistic.unwrap_or_default(),
                window: None,
                curve: self.curve(name, criterion, &scale, &handle, schedule)?,
                detail: self.detail(name, criterion, variable, schedule)?,
            };
            Ok((scale.conversion.inverse(), probe))
        };
        self.study.criteria.iter().map(bind).collect()
    }

    /// The number that a criterion's statistic needs.
    fn detail(
        &self,
        name: &Name,
        text: &CriterionText,
        variable: &Variable,
        schedule: &Schedule,
    ) -> Result<Option<Detail>, StudyError> {
        let named = |message: String| {
            let message = format!("{}: {message}", name.as_ref());
            self.study.error_at(name, message)
        };
        let detail = text.detail().map_err(named)?;
        let is_whole = text.turns.is_some() || text.periods.is_some();
        let needs_lines =
            detail.is_some() || is_whole || text.statistic.is_some_and(Statistic::needs_lines);
        if needs_lines && variable.handle().content != Content::Real {
            let message = "this statistic follows straight lines, and the variable is not real; take final, mean, min or max";
            return Err(named(message.to_owned()));
        }
        if let Some(angle) = &text.turns {
            return self.turns(angle, variable).map(Some);
        }
        if let Some(signal) = &text.periods {
            let handle = self.variable(signal)?.number_handle();
            let handle = handle.filter(|handle| handle.content == Content::Real);
            let message = "periods must name a real variable, the criterion's own or another";
            let handle = handle.ok_or_else(|| self.study.error_at(signal, message.to_owned()))?;
            return Ok(Some(Detail::Periods(handle)));
        }
        match detail {
            Some(Detail::Level(number, direction)) => {
                let own = text
                    .level
                    .as_ref()
                    .and_then(|level| level.as_ref().unit.as_deref());
                let scale = Scale::new(own, self.fmu, variable).map_err(named)?;
                let level = scale.conversion.value(number);
                Ok(Some(Detail::Level(level, direction)))
            }
            Some(Detail::At(time)) if !(schedule.start..=schedule.stop).contains(&time) => {
                Err(named(format!(
                    "at = {time} s is not within the run from {} s to {} s; correct it, or start and stop under [simulation]",
                    schedule.start, schedule.stop
                )))
            }
            detail => Ok(detail),
        }
    }

    /// The angle over whose whole turns the mean of a variable is taken.
    fn turns(&self, name: &Spanned<String>, of: &Variable) -> Result<Detail, StudyError> {
        let at = |message: String| self.study.error_at(name, message);
        let angle = self.variable(name)?;
        let handle = angle.number_handle();
        let handle =
            handle.filter(|handle| handle.content == Content::Real && angle.name != of.name);
        let handle = handle
            .ok_or_else(|| at("turns must name another real variable, an angle".to_owned()))?;
        let scale = Scale::new(Some("rad"), self.fmu, angle);
        let scale = scale.map_err(|message| at(format!("turns must name an angle: {message}")))?;
        let turn = scale.conversion.difference(std::f64::consts::TAU);
        Ok(Detail::Turns(handle, turn.abs()))
    }

    /// The measured curve of a criterion, where it has one.
    fn curve(
        &self,
        name: &Name,
        text: &CriterionText,
        scale: &Scale<'_>,
        handle: &Handle,
        schedule: &Schedule,
    ) -> Result<Option<Box<MeasuredCurve>>, StudyError> {
        let (Some(reference), Some(metric)) = (&text.reference, text.metric) else {
            return Ok(None);
        };
        if handle.content != Content::Real {
            let message = "only real variables can be compared with a curve";
            return Err(self.study.error_at(&text.variable, message));
        }
        let run = [schedule.start, schedule.stop];
        let general = [schedule.window_start, schedule.stop];
        let window = match &text.window {
            Some(window) => {
                let times = window.as_ref().times(run);
                times.map_err(|message| self.study.error_at(window, message))?
            }
            None => general,
        };
        let binder = CurveBinder {
            study: self.study,
            name,
            text,
            scale,
            run,
            window,
            is_stated: text.window.is_some() || general != run,
        };
        binder
            .bind(reference, metric)
            .map(|curve| Some(Box::new(curve)))
    }

    /// The probes with their windows; what lies before the first window may be leapt over.
    fn windows(
        &self,
        schedule: &mut Schedule,
        mut observed: Vec<Probe>,
    ) -> Result<Vec<Probe>, StudyError> {
        let criteria = || self.study.criteria.values();
        let run = [schedule.start, schedule.stop];
        let general = [schedule.window_start, schedule.stop];
        // A curve has its own times, and looks from the start on; so does the value at a time.
        let is_cut = general != run && observed.iter().any(Probe::has_own_times);
        if criteria().all(|criterion| criterion.window.is_none()) && !is_cut {
            return Ok(observed);
        }
        for (probe, criterion) in observed.iter_mut().zip(criteria()) {
            probe.window = Some(match &criterion.window {
                _ if probe.has_own_times() => run,
                Some(window) => {
                    let times = window.as_ref().times(run);
                    times.map_err(|message| self.study.error_at(window, message))?
                }
                // The final value is that at the end, whatever the others look at.
                None if probe.is_final() => [schedule.stop; 2],
                None => general,
            });
        }
        let begins = observed
            .iter()
            .filter_map(|probe| probe.window.map(|window| window[0]));
        schedule.window_start = begins.fold(schedule.stop, f64::min);
        let points = schedule.points();
        for (probe, criterion) in observed.iter().zip(criteria()) {
            let (Some([from, to]), Some(stated)) = (probe.window, &criterion.window) else {
                continue;
            };
            let rounding = 1e-9 * (from.abs() + to.abs());
            if points.at(points.from(from - rounding)) > to + rounding {
                let message = format!(
                    "no communication point lies in the window from {from} s to {to} s; make `step` under [simulation] \
                     smaller"
                );
                return Err(self.study.error_at(stated, message));
            }
        }
        Ok(observed)
    }

    fn fixed(&self) -> Result<Vec<(u32, Value)>, StudyError> {
        let settings = self.study.fixed.iter();
        let bind = |(name, setting): (&Name, &Spanned<Setting>)| {
            let variable = self.variable(name)?;
            let value = value_of(self.fmu, variable, setting.as_ref())
                .map_err(|message| self.study.error_at(setting, message))?;
            Ok((variable.handle().reference, value))
        };
        let own: Vec<(u32, Value)> = settings.map(bind).collect::<Result<_, _>>()?;
        Ok(self.set()?.into_iter().chain(own).collect())
    }

    /// The start values of a parameter set that the study does not give itself.
    fn set(&self) -> Result<Vec<(u32, Value)>, StudyError> {
        let Some(file) = &self.study.fixed_from else {
            return Ok(Vec::new());
        };
        let path = self.study.beside(file.as_ref());
        let named = ssv::read(&path).and_then(|set| set.named(&path, self.fmu));
        let named = named.map_err(|error| self.study.error_at(file, error.to_string()))?;
        let Study {
            parameters,
            fixed,
            inputs,
            ..
        } = self.study;
        let free = |name: &str| {
            !(parameters.contains_key(name)
                || fixed.contains_key(name)
                || inputs.contains_key(name))
        };
        let free = named.into_iter().filter(|(name, ..)| free(name));
        Ok(free
            .map(|(_, reference, value)| (reference, value))
            .collect())
    }

    fn schedule(&self) -> Result<Schedule, String> {
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
        schedule.window_start = match (simulation.warm_up, simulation.window) {
            (Some(_), Some(_)) => {
                return Err("[simulation] has both warm-up and window; keep one".to_owned());
            }
            (Some(warm_up), None) => start + warm_up,
            (None, Some(window)) => stop - window,
            (None, None) => start,
        };
        schedule.check()?;
        Ok(schedule)
    }
}
