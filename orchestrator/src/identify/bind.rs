//! Ties the section `[identify]` of a study to its FMU and its table.

use super::late::Reading;
use calibration::problem::{
    Case, Channel, Effect, Free, Interval, Latent, Prior, Problem, Quantity, SharedKind, Source, Spacing,
    UncertainValue,
};
use conformity::uncertainty::Uncertainty;
use fmu_import::{
    Description,
    quantity::{Quantity as Text, Scale, Sense},
    units::Conversion,
};
use fmu_points::{
    task::{Case as Simulation, Probe, Slot, Task},
    tell,
};
use indexmap::IndexMap;
use number_tables::files::FileError;
use sampling::statistics::Statistic;
use study::{
    Name, Result, Study,
    case_table::CaseTable,
    identification::{Exception, FreeText, Identification, LatentText, MeasuredText},
    inputs::taken_as_exact,
    judge::sense,
    limit::gain,
    plan::{Plan, find, slot_of},
};

/// How far the bounds of a normal parameter are from its mean, in standard deviations.
pub(super) const REACH: f64 = 5.0;

/// An identification in terms of an FMU.
#[derive(Debug, Default)]
pub struct Bound {
    /// The unknown parameters.
    pub problem: Problem,
    /// The simulations of a query: that of a case of the table, or those of all cases of the study that are fitted.
    pub simulations: Vec<Simulation>,
    /// Each case's known parameters, in the FMU's units.
    pub known: Vec<Vec<f64>>,
    /// To the FMU's units: the free parameters, then the latent ones.
    pub inputs: Vec<Conversion>,
    /// From the FMU's units: the measured quantities.
    pub outputs: Vec<Conversion>,
    /// The measured curves, whose rows are quantities.
    pub curves: Vec<BoundCurve>,
    /// How readings become the measured quantities' predictions.
    pub readings: Vec<Reading>,
    /// The free parameters that are lags of curves, and none of the FMU's.
    pub lags: Vec<String>,
    /// The free parameters that are errors of recorded inputs, with the offset and the gain that were taken off before.
    pub offsets: IndexMap<String, [f64; 2]>,
    /// What is assumed beyond what the study states, a sentence each.
    pub notes: Vec<String>,
}

/// A measured curve.
#[derive(Debug)]
pub struct BoundCurve {
    /// Its criterion.
    pub name: String,
    /// The unit of its values.
    pub unit: Option<String>,
    /// Its rows among the quantities.
    pub quantities: std::ops::Range<usize>,
    /// Their times, s.
    pub times: Vec<f64>,
}

impl Bound {
    /// Ties everything together.
    ///
    /// # Errors
    /// When a name, a unit, a number or a column does not fit.
    pub fn new(study: &Study, settings: &Identification, fmu: &Description) -> Result<Self> {
        Binder { study, settings, fmu, table: CaseTable::read(study, settings)? }.bind()
    }

    /// What is simulated in the cases.
    pub fn tasks(&self) -> impl Iterator<Item = &Task> {
        self.simulations.iter().map(|simulation| &simulation.task)
    }

    /// Lets a variable take a value of each query.
    pub(super) fn vary(&mut self, slot: Slot) {
        for simulation in &mut self.simulations {
            simulation.task.varied.push(slot.clone());
        }
    }

    /// Adds an unknown parameter.
    pub(super) fn add_free(
        &mut self,
        study: &Study,
        name: &Name,
        free: Free,
        slot: Slot,
        conversion: Conversion,
    ) -> Result {
        for end in [free.min, free.max] {
            slot.check(conversion.value(end)).map_err(|message| study.error_of(name, message))?;
        }
        self.problem.free.push(free);
        self.inputs.push(conversion);
        self.vary(slot);
        Ok(())
    }

    /// The free parameters that are none of the FMU's.
    pub fn others(&self) -> Vec<String> {
        self.lags.iter().chain(self.offsets.keys()).cloned().collect()
    }

    fn observe(&mut self, probe: Probe) {
        for simulation in &mut self.simulations {
            simulation.task.observed.push(probe.clone());
        }
    }
}

/// A parameter of the FMU: how it is set, and its unit in the study.
pub(super) struct Input<'a> {
    pub slot: Slot,
    pub scale: Scale<'a>,
}

impl<'a> Input<'a> {
    pub fn new(study: &Study, fmu: &'a Description, name: &Name, unit: Option<&str>) -> Result<Self> {
        let variable = find(fmu, name.as_ref()).map_err(|m| study.error_at(name, m))?;
        let input = || {
            let slot = slot_of(variable)?;
            let scale = Scale::new(unit, fmu, variable)?;
            Ok(Self { slot, scale })
        };
        input().map_err(|message: String| study.error_of(name, message))
    }

    /// An unknown parameter of the study.
    pub fn free(study: &Study, fmu: &'a Description, name: &Name, text: &FreeText) -> Result<(Free, Self)> {
        let input = Self::new(study, fmu, name, text.unit.as_deref().or(text.min.unit.as_deref()))?;
        let free = free(name.as_ref(), text, &input.scale).map_err(|message| study.error_of(name, message))?;
        Ok((free, input))
    }

    fn check(&self, value: f64) -> Result<(), String> {
        self.slot.check(self.scale.conversion.value(value))
    }
}

/// How far the FMU lets a value go, in the study's unit.
pub(crate) fn reach(slot: &Slot, conversion: Conversion) -> [f64; 2] {
    let back = conversion.inverse();
    let end = |limit: Option<f64>, otherwise: f64| limit.map_or(otherwise, |limit| back.value(limit));
    [end(slot.min, f64::NEG_INFINITY), end(slot.max, f64::INFINITY)]
}

/// A simulation that takes and gives nothing yet.
pub(super) fn bare(mut case: Simulation) -> Simulation {
    case.task.varied.clear();
    case.task.observed.clear();
    case
}

pub(super) fn check_effort(study: &Study, settings: &Identification) -> Result {
    let numbers = [
        ("starts", settings.starts),
        ("descents", settings.descents as u64),
        ("iterations", settings.iterations as u64),
    ];
    if let Some((key, _)) = numbers.into_iter().find(|(_, number)| *number == 0) {
        return Err(study.error_in("identify", &[key], format!("{key} must be 1 or more")));
    }
    if settings.difference > 0.0 && settings.difference < 0.5 {
        Ok(())
    } else {
        Err(study.error_in("identify", &["difference"], "difference must lie between 0 and 0.5"))
    }
}

struct Binder<'a> {
    study: &'a Study,
    settings: &'a Identification,
    fmu: &'a Description,
    table: CaseTable,
}

impl Binder<'_> {
    fn bind(&self) -> Result<Bound> {
        let settings = self.settings;
        if !self.study.parameters.is_empty() {
            return Err(self.study.error_near(
                "parameters",
                "identify does not use [parameters]: give each under [fixed], \
                           [identify.free], [identify.known] or [identify.latent]",
            ));
        }
        if settings.free.is_empty() || settings.measured.is_empty() {
            return Err(self
                .study
                .error("identify needs at least one [identify.free.NAME] and one [identify.measured.NAME]"));
        }
        check_effort(self.study, settings)?;
        self.refuse_doubles()?;
        let plan = Plan::new(self.study, self.fmu)?;
        plan.tell_of_inputs();
        for error in &plan.input_errors {
            tell::line!("note: {}", taken_as_exact(&error.name, "the cases of a table"));
        }
        let mut bound = Bound {
            simulations: plan.cases.into_iter().map(bare).collect(),
            known: vec![Vec::new(); self.table.cases()],
            ..Bound::default()
        };
        let labels = self.table.labels.iter();
        bound.problem.cases =
            labels.map(|label| Case { label: label.to_string(), latents: Vec::new(), measured: Vec::new() }).collect();
        self.bind_known(&mut bound)?;
        self.bind_free(&mut bound)?;
        self.bind_latent(&mut bound)?;
        self.bind_measured(&mut bound)?;
        Ok(bound)
    }

    fn refuse_doubles(&self) -> Result {
        let Identification { known, free, latent, .. } = self.settings;
        let known = known.keys().map(|name| (name, "[identify.known]"));
        let free = free.keys().map(|name| (name, "[identify.free]"));
        let latent = latent.keys().map(|name| (name, "[identify.latent]"));
        self.study.once(self.fmu, self.study.set().chain(known).chain(free).chain(latent))
    }

    fn at(&self, name: &Name) -> impl Fn(String) -> FileError {
        |message| self.study.error_of(name, message)
    }

    fn input(&self, name: &Name, unit: Option<&str>) -> Result<Input<'_>> {
        Input::new(self.study, self.fmu, name, unit)
    }

    fn bind_known(&self, bound: &mut Bound) -> Result {
        for (name, known) in &self.settings.known {
            let input = self.input(name, known.unit.as_deref())?;
            let values = self.table.column(&known.column);
            for (case, value) in bound.known.iter_mut().zip(values) {
                input.check(value).map_err(self.at(name))?;
                case.push(input.scale.conversion.value(value));
            }
            bound.vary(input.slot);
        }
        Ok(())
    }

    fn bind_free(&self, bound: &mut Bound) -> Result {
        for (name, text) in &self.settings.free {
            let (free, input) = Input::free(self.study, self.fmu, name, text)?;
            bound.add_free(self.study, name, free, input.slot, input.scale.conversion)?;
        }
        Ok(())
    }

    fn bind_latent(&self, bound: &mut Bound) -> Result {
        for (name, text) in &self.settings.latent {
            let input = self.input(name, text.unit.as_deref())?;
            for exception in &text.except {
                if !self.table.labels.contains(exception.case.as_ref()) {
                    return Err(self
                        .study
                        .error_at(&exception.case, format!("there is no case {}", exception.case.as_ref())));
                }
            }
            let of_input = (&input.scale, Sense::Value);
            let middles = self.values(text.column.as_deref(), text.value.as_ref(), of_input).map_err(self.at(name))?;
            let cases = bound.problem.cases.iter_mut().zip(&self.table.labels);
            for ((case, label), middle) in cases.zip(middles) {
                let exception = text.except.iter().find(|e| e.case.as_ref() == label);
                let interval = interval(middle, text, exception, &input.scale).map_err(self.at(name))?;
                for end in [interval.min, interval.max] {
                    input.check(end).map_err(self.at(name))?;
                }
                case.latents.push(interval);
            }
            bound.problem.latents.push(Latent { name: name.as_ref().clone(), unit: input.scale.unit.clone() });
            bound.inputs.push(input.scale.conversion);
            bound.vary(input.slot);
        }
        Ok(())
    }

    fn bind_measured(&self, bound: &mut Bound) -> Result {
        for (name, text) in &self.settings.measured {
            let (probe, scale) = self.probe(text)?;
            let sense = sense(text.statistic);
            let values =
                self.values(text.column.as_deref(), text.value.as_ref(), (&scale, sense)).map_err(self.at(name))?;
            for (case, value) in bound.problem.cases.iter_mut().zip(values) {
                let accuracy = deviation(text, value, &scale).map_err(self.at(name))?;
                case.measured.push(UncertainValue { value, accuracy });
            }
            bound.problem.quantities.push(Quantity { name: name.as_ref().clone(), unit: scale.unit.clone() });
            self.bind_shared(bound, name, text, &scale)?;
            let back = scale.conversion.inverse();
            bound.outputs.push(if text.statistic.is_difference() { back.of_differences() } else { back });
            bound.readings.push(Reading::Value(bound.readings.len()));
            bound.observe(probe);
        }
        Ok(())
    }

    /// The errors that the values of the last quantity share over all cases.
    fn bind_shared(&self, bound: &mut Bound, name: &Name, text: &MeasuredText, scale: &Scale) -> Result {
        let problem = &mut bound.problem;
        let quantity = problem.quantities.len() - 1;
        let errors = [
            ("uncertainty", &text.uncertainty, SharedKind::Offset),
            ("gain-uncertainty", &text.gain_uncertainty, SharedKind::Gain),
        ];
        for (what, stated, kind) in errors {
            let Some(stated) = stated else { continue };
            let expanded = match kind {
                SharedKind::Gain => Some(gain(stated).map_err(self.at(name))?),
                _ if stated.unit.as_deref() == Some("%") => None,
                _ => {
                    Some(scale.number(stated, Sense::Difference).map_err(self.at(name))?).filter(|number| *number > 0.0)
                }
            };
            let expanded = expanded.ok_or_else(|| {
                self.at(name)(format!(
                    "the {what} {stated} must be a positive number in the quantity's unit: a part of the value is `gain-uncertainty`"
                ))
            })?;
            let standard = expanded / Uncertainty::USUAL;
            let effects = problem.cases.iter().enumerate().map(|(case, values)| Effect {
                case,
                quantity,
                change: match kind {
                    SharedKind::Gain => standard * values.measured[quantity].value,
                    _ => standard,
                },
                part: (kind == SharedKind::Gain).then_some(standard),
            });
            problem.channels.push(Channel {
                name: name.as_ref().clone(),
                kind,
                unit: scale.unit.clone(),
                limit: expanded,
                sources: vec![(problem.sources.len(), standard)],
            });
            problem.sources.push(Source { effects: effects.collect(), rectangular: false });
        }
        Ok(())
    }

    fn probe(&self, text: &MeasuredText) -> Result<(Probe, Scale<'_>)> {
        let at = |message| self.study.error_at::<String>(&text.variable, message);
        let variable = find(self.fmu, text.variable.as_ref()).map_err(at)?;
        let probe = Probe::of(variable, text.statistic)
            .ok_or_else(|| at("a text cannot be compared with a measurement".to_owned()))?;
        if text.statistic == Statistic::Percentile || text.statistic.unit().is_some() {
            return Err(at(format!(
                "identify takes no {}; choose another statistic, such as max, or give the data as [[cases]]",
                text.statistic.name()
            )));
        }
        let scale = Scale::new(text.unit.as_deref(), self.fmu, variable).map_err(at)?;
        Ok((probe, scale))
    }

    /// A value for each case, from a column or the same for all.
    fn values(
        &self,
        column: Option<&str>,
        value: Option<&Text>,
        (scale, sense): (&Scale, Sense),
    ) -> Result<Vec<f64>, String> {
        match (column, value) {
            (Some(column), None) => Ok(self.table.column(column)),
            (None, Some(value)) => Ok(vec![scale.number(value, sense)?; self.table.cases()]),
            _ => Err("give either `column` or `value`".to_owned()),
        }
    }
}

/// An unknown parameter as the study states it.
///
/// # Errors
/// When its numbers or their units do not fit.
fn free(name: &str, text: &FreeText, scale: &Scale) -> Result<Free, String> {
    let number = |quantity: &Text, sense| scale.number(quantity, sense);
    let prior = match (text.scale, &text.mean, &text.deviation, &text.median, text.factor) {
        (_, None, None, None, None) => None,
        (Spacing::Linear, Some(mean), Some(deviation), None, None) => {
            Some(Prior { centre: number(mean, Sense::Value)?, spread: number(deviation, Sense::Difference)? })
        }
        (Spacing::Log, None, None, Some(median), Some(factor)) => {
            Some(Prior { centre: number(median, Sense::Value)?, spread: factor })
        }
        (Spacing::Linear, ..) => {
            return Err("a prior on a linear scale has `mean` and `deviation`".to_owned());
        }
        (Spacing::Log, ..) => {
            return Err("a prior on a logarithmic scale has `median` and `factor`".to_owned());
        }
    };
    let free = Free {
        name: name.to_owned(),
        unit: scale.unit.clone(),
        scale: text.scale,
        min: number(&text.min, Sense::Value)?,
        max: number(&text.max, Sense::Value)?,
        prior,
    };
    free.check()?;
    Ok(free)
}

fn interval(middle: f64, text: &LatentText, exception: Option<&Exception>, scale: &Scale) -> Result<Interval, String> {
    let distance = |side: Option<&Text>| {
        let within = exception.and_then(|e| e.within.as_ref());
        let distance = scale.number(side.or(within).unwrap_or(&text.within), Sense::Difference)?;
        if distance > 0.0 {
            Ok(distance)
        } else {
            Err(format!("an interval's end must be more than {distance} away from its middle"))
        }
    };
    Ok(Interval {
        min: middle - distance(exception.and_then(|e| e.below.as_ref()))?,
        max: middle + distance(exception.and_then(|e| e.above.as_ref()))?,
    })
}

/// The standard deviation of measured values.
fn deviation(text: &MeasuredText, value: f64, scale: &Scale) -> Result<f64, String> {
    let number = &text.accuracy;
    let deviation = match number.unit.as_deref() {
        Some("%") => {
            let written = text.value.clone().unwrap_or(value.into());
            scale.part(0.01 * number.number, &written)?
        }
        _ => scale.number(number, Sense::Difference)?,
    };
    if deviation > 0.0 && deviation.is_finite() {
        Ok(deviation)
    } else {
        Err(format!("the accuracy {number} of {value} must be positive"))
    }
}
