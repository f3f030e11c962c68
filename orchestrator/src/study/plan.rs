//! Ties a study to an FMU: names become variables, units convert, numbers are checked.

use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::quantity::{Quantity, Scale, Sense};
use super::{Method, Name, Pair, Parameter, Setting, Shape, Study, StudyError};
use super::{inputs, ssv};
use crate::design::correlation::Correlation;
use crate::design::{self, Design};
use crate::distribution::Distribution;
use crate::fmu::{Description, Kind, Value, Variability, Variable};
use crate::names::{did_you_mean, nearest};
use crate::task::{Probe, Schedule, Slot, Storage, Task};
use crate::units::Conversion;

/// A study that fits an FMU.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What is to be done for each point, in the FMU's own terms.
    pub task: Task,
    /// The parameters, in the order of the study.
    pub inputs: Vec<Input>,
    /// From the FMU's unit to the study's, a criterion each.
    pub outputs: Vec<Conversion>,
    /// The levels of the parameters in a full factorial.
    levels: Vec<Option<u64>>,
    /// How the parameters are correlated, if they are.
    correlation: Option<Correlation>,
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
        let binder = Binder { study, fmu };
        check_points(study)?;
        let (inputs, varied) = binder.parameters()?;
        let (outputs, observed) = binder.criteria()?;
        let schedule = binder.schedule()?;
        let task = Task {
            schedule,
            fixed: binder.fixed()?,
            varied,
            inputs: inputs::series(study, fmu, &schedule)?,
            observed,
        };
        Ok(Self {
            task,
            inputs,
            outputs,
            levels: study.parameters.values().map(|p| p.levels).collect(),
            correlation: correlation(study)?,
        })
    }

    /// The points of a design over the parameters.
    ///
    /// # Errors
    /// When the method cannot serve so many parameters or points.
    pub fn design(&self, design: &super::Design) -> Result<Design, String> {
        let distributions = self.inputs.iter().map(|input| input.distribution);
        let inputs = design::Inputs {
            distributions: distributions.collect(),
            levels: self.levels.clone(),
            correlation: self.correlation.clone(),
        };
        Design::new(design, inputs)
    }

    /// Whether every parameter varies on its own.
    pub fn is_independent(&self) -> bool {
        self.correlation.is_none()
    }

    /// A point's parameters in the FMU's units.
    pub fn to_fmu(&self, parameters: &[f64], into: &mut Vec<f64>) {
        into.clear();
        let pairs = self.inputs.iter().zip(parameters);
        into.extend(pairs.map(|(input, &value)| input.conversion.value(value)));
    }

    /// The FMU's results in the study's units.
    pub fn to_study(&self, values: &mut [f64]) {
        for (value, (conversion, probe)) in values
            .iter_mut()
            .zip(self.outputs.iter().zip(&self.task.observed))
        {
            *value = match probe.statistic {
                super::Statistic::Amplitude => conversion.difference(*value),
                _ => conversion.value(*value),
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
    fn variable<T: AsRef<str>>(&self, name: &Spanned<T>) -> Result<&Variable, StudyError> {
        find(self.fmu, name.as_ref().as_ref()).map_err(|message| self.study.error_at(name, message))
    }

    fn parameters(&self) -> Result<(Vec<Input>, Vec<Slot>), StudyError> {
        let bind = |(name, parameter): (&Name, &Parameter)| {
            let variable = self.variable(name)?;
            let at = |message: String| self.study.error_at(name, message);
            let name = name.as_ref().clone();
            let at = |message: String| at(format!("{name}: {message}"));
            let slot = slot_of(variable).map_err(at)?;
            let input = self.parameter(variable, parameter, &slot).map_err(at)?;
            Ok((input, slot))
        };
        self.study.parameters.iter().map(bind).collect()
    }

    fn parameter(
        &self,
        variable: &Variable,
        parameter: &Parameter,
        slot: &Slot,
    ) -> Result<Input, String> {
        let unit = parameter.unit.as_deref().or(parameter.first_unit());
        let scale = Scale::new(unit, &self.fmu.units, variable.unit())?;
        let distribution = parameter.distribution(&scale)?;
        distribution.check()?;
        slot.check(scale.conversion.value(distribution.median()))?;
        Ok(Input {
            name: variable.name.clone(),
            unit: scale.unit.clone(),
            distribution,
            conversion: scale.conversion,
        })
    }

    fn criteria(&self) -> Result<(Vec<Conversion>, Vec<Probe>), StudyError> {
        let criteria = self.study.criteria.values();
        let bind = |criterion: &super::Criterion| {
            let variable = self.variable(&criterion.variable)?;
            let at = |message| self.study.error_at(&criterion.variable, message);
            let storage = Storage::of(variable)
                .ok_or_else(|| at("a text cannot be compared with a measurement".to_owned()))?;
            let unit = criterion.unit.as_deref();
            let scale = Scale::new(unit, &self.fmu.units, variable.unit()).map_err(at)?;
            let probe = Probe {
                name: variable.name.clone(),
                reference: variable.value_reference,
                storage,
                statistic: criterion.statistic,
            };
            Ok((scale.conversion.inverse(), probe))
        };
        criteria.map(bind).collect()
    }

    fn fixed(&self) -> Result<Vec<(u32, Value)>, StudyError> {
        let settings = self.study.fixed.iter();
        let bind = |(name, setting): (&Name, &Spanned<Setting>)| {
            let variable = self.variable(name)?;
            if self.study.parameters.contains_key(name.as_ref().as_str()) {
                let message = format!("{} is under [parameters] too", name.as_ref());
                return Err(self.study.error_at(name, message));
            }
            let value = value_of(self.fmu, variable, setting.as_ref())
                .map_err(|message| self.study.error_at(setting, message))?;
            Ok((variable.value_reference, value))
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

    fn schedule(&self) -> Result<Schedule, StudyError> {
        let simulation = &self.study.simulation;
        let experiment = Schedule::suggested(self.fmu);
        let start = simulation.start.unwrap_or(experiment.start);
        let stop = simulation.stop.unwrap_or(experiment.stop);
        let mut schedule = Schedule {
            start,
            stop,
            step: simulation.step.unwrap_or(experiment.step),
            window_start: start,
            leap: simulation.leap,
            tolerance: simulation.tolerance.or(experiment.tolerance),
        };
        schedule.window_start = match (simulation.warm_up, simulation.window) {
            (Some(_), Some(_)) => {
                let message = "[simulation] has both warm-up and window; keep one";
                return Err(self.study.error(message));
            }
            (Some(warm_up), None) => start + warm_up,
            (None, Some(window)) => stop - window,
            (None, None) => start,
        };
        schedule
            .check()
            .map_err(|message| self.study.error(format!("[simulation] {message}")))?;
        Ok(schedule)
    }
}

/// A number of points that the design would ignore is an error: it was meant to do something.
fn check_points(study: &Study) -> Result<(), StudyError> {
    #[derive(Deserialize)]
    struct Text {
        #[serde(default)]
        design: Points,
    }
    #[derive(Default, Deserialize)]
    struct Points {
        points: Option<Spanned<u64>>,
    }
    match study.section::<Text>()?.design.points {
        Some(points) if study.design.method == Method::FullFactorial => {
            let message = "a full factorial has as many points as the levels make; remove `points`";
            Err(study.error_at(&points, message))
        }
        _ => Ok(()),
    }
}

/// The correlations of a study's parameters.
fn correlation(study: &Study) -> Result<Option<Correlation>, StudyError> {
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for entry in &study.correlations {
        let Pair {
            between,
            coefficient,
            ..
        } = entry.as_ref();
        let [a, b] = between.each_ref().map(|name| {
            let parameter = study.parameters.get_full(name.as_ref().as_str());
            let (index, _, parameter) = parameter.ok_or_else(|| {
                let names = study.parameters.keys().map(|key| key.as_ref().as_str());
                let suggestion = did_you_mean(nearest(name.as_ref(), names));
                let message = format!("no parameter `{}`{suggestion}", name.as_ref());
                study.error_at(name, message)
            })?;
            if parameter.distribution == Shape::Fixed {
                return Err(study.error_at(name, format!("{} does not vary", name.as_ref())));
            }
            Ok(index)
        });
        let (a, b) = (a?, b?);
        let wrong = |message: &str| Err(study.error_at(entry, message));
        if a == b {
            return wrong("a parameter is not correlated with itself; name two");
        }
        if !(coefficient.abs() < 1.0) {
            return wrong("the coefficient must be more than -1 and less than 1");
        }
        if pairs
            .iter()
            .any(|&(x, y, _)| (x, y) == (a, b) || (x, y) == (b, a))
        {
            return wrong("the correlation of these two stands above already; keep one");
        }
        pairs.push((a, b, *coefficient));
    }
    let Some(first) = study.correlations.first() else {
        return Ok(None);
    };
    let correlation = Correlation::new(study.parameters.len(), &pairs);
    correlation
        .map(Some)
        .map_err(|message| study.error_at(first, message))
}

impl Parameter {
    /// The unit of its first number that has one.
    fn first_unit(&self) -> Option<&str> {
        let numbers = [&self.mean, &self.value, &self.min, &self.mode, &self.max];
        numbers
            .into_iter()
            .flatten()
            .find_map(|number| number.unit.as_deref())
    }

    /// The distribution in the study's unit.
    fn distribution(&self, scale: &Scale<'_>) -> Result<Distribution, String> {
        let shape = self.distribution;
        let maybe = |number: &Option<Quantity>, sense| {
            number
                .as_ref()
                .map(|number| scale.number(number, sense))
                .transpose()
        };
        let need = |number: &Option<Quantity>, key: &str| {
            let sense = if key == "deviation" {
                Sense::Difference
            } else {
                Sense::Value
            };
            maybe(number, sense)?
                .ok_or_else(|| format!("`{key}` is missing for the distribution {}", shape.name()))
        };
        self.refuse_others()?;
        let [mean, deviation] = [(&self.mean, "mean"), (&self.deviation, "deviation")];
        Ok(match shape {
            Shape::Normal => Distribution::Normal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
            },
            Shape::TruncatedNormal => Distribution::TruncatedNormal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
                min: maybe(&self.min, Sense::Value)?,
                max: maybe(&self.max, Sense::Value)?,
            },
            Shape::Uniform => Distribution::Uniform {
                min: need(&self.min, "min")?,
                max: need(&self.max, "max")?,
            },
            Shape::Triangular => Distribution::Triangular {
                min: need(&self.min, "min")?,
                mode: need(&self.mode, "mode")?,
                max: need(&self.max, "max")?,
            },
            Shape::Lognormal => Distribution::Lognormal {
                mean: need(mean.0, mean.1)?,
                deviation: need(deviation.0, deviation.1)?,
            },
            Shape::Fixed => Distribution::Fixed {
                value: need(&self.value, "value")?,
            },
        })
    }

    /// A number that the distribution would ignore is an error: it was meant to do something.
    fn refuse_others(&self) -> Result<(), String> {
        let wanted: &[&str] = match self.distribution {
            Shape::Normal | Shape::Lognormal => &["mean", "deviation"],
            Shape::TruncatedNormal => &["mean", "deviation", "min", "max"],
            Shape::Uniform => &["min", "max"],
            Shape::Triangular => &["min", "mode", "max"],
            Shape::Fixed => &["value"],
        };
        let given = [
            ("mean", &self.mean),
            ("deviation", &self.deviation),
            ("min", &self.min),
            ("mode", &self.mode),
            ("max", &self.max),
            ("value", &self.value),
        ];
        let stray = given
            .iter()
            .find(|(key, number)| number.is_some() && !wanted.contains(key));
        match stray {
            Some((key, _)) => Err(format!(
                "the distribution {} does not use `{key}`; it takes {}",
                self.distribution.name(),
                wanted.join(", ")
            )),
            None => Ok(()),
        }
    }
}

impl Shape {
    fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::TruncatedNormal => "truncated-normal",
            Self::Uniform => "uniform",
            Self::Triangular => "triangular",
            Self::Lognormal => "lognormal",
            Self::Fixed => "fixed",
        }
    }
}

/// The variable of this name.
///
/// # Errors
/// Suggests the nearest name.
pub fn find<'a>(fmu: &'a Description, name: &str) -> Result<&'a Variable, String> {
    fmu.variables.get(name).ok_or_else(|| {
        let suggestion = did_you_mean(fmu.nearest(name));
        format!("the FMU has no variable `{name}`{suggestion}")
    })
}

/// The smallest and largest value that the FMU's description allows, in the FMU's unit.
fn limits(variable: &Variable) -> (Option<f64>, Option<f64>) {
    match &variable.kind {
        Kind::Real { min, max, .. } => (*min, *max),
        Kind::Integer { min, max, .. } => (min.map(f64::from), max.map(f64::from)),
        _ => (None, None),
    }
}

/// How a variable takes a number before a simulation.
///
/// # Errors
/// When it cannot be set, or is a text.
pub fn slot_of(variable: &Variable) -> Result<Slot, String> {
    settable(variable)?;
    let storage = Storage::of(variable).ok_or("a text cannot vary; set it under [fixed]")?;
    let (min, max) = limits(variable);
    Ok(Slot {
        name: variable.name.clone(),
        reference: variable.value_reference,
        storage,
        min,
        max,
    })
}

fn settable(variable: &Variable) -> Result<(), String> {
    if variable.is_settable() {
        return Ok(());
    }
    let reason = match variable.variability {
        Variability::Constant => "a constant",
        _ => "computed by the FMU",
    };
    Err(format!(
        "it is {reason}; only parameters and inputs can be set"
    ))
}

/// A start value for a variable.
///
/// # Errors
/// When the type, the unit or the number doesn't fit.
pub fn value_of(
    fmu: &Description,
    variable: &Variable,
    setting: &Setting,
) -> Result<Value, String> {
    let named = |message: String| format!("{}: {message}", variable.name);
    settable(variable).map_err(named)?;
    value(fmu, variable, setting).map_err(named)
}

fn value(fmu: &Description, variable: &Variable, setting: &Setting) -> Result<Value, String> {
    let text = match setting {
        Setting::Boolean(flag) => flag.to_string(),
        Setting::Integer(number) => number.to_string(),
        Setting::Number(number) => number.to_string(),
        Setting::Text(text) => text.clone(),
    };
    let whole = || {
        let number = text.trim().parse::<i32>();
        number.map_err(|_| format!("`{text}` is not a whole number"))
    };
    match &variable.kind {
        Kind::Real { unit, .. } => {
            let quantity: Quantity = text.parse()?;
            let scale = Scale::new(None, &fmu.units, unit.as_deref())?;
            let number = scale.number(&quantity, Sense::Value)?;
            check_limits(variable, number)?;
            Ok(Value::Real(number))
        }
        Kind::Integer { .. } => {
            let number = whole()?;
            check_limits(variable, f64::from(number))?;
            Ok(Value::Integer(number))
        }
        Kind::Boolean { .. } => match text.trim() {
            "true" | "1" => Ok(Value::Boolean(true)),
            "false" | "0" => Ok(Value::Boolean(false)),
            _ => Err(format!("`{text}` is neither true nor false")),
        },
        Kind::String { .. } => Ok(Value::String(text)),
        Kind::Enumeration { items, .. } => {
            if let Some((_, number)) = items.iter().find(|(name, _)| *name == text.trim()) {
                return Ok(Value::Integer(*number));
            }
            let number = whole().ok();
            let known =
                |number: &i32| items.is_empty() || items.iter().any(|(_, value)| value == number);
            number.filter(known).map(Value::Integer).ok_or_else(|| {
                let names: Vec<&str> = items.iter().map(|(name, _)| name.as_str()).collect();
                format!("`{text}` is none of {}", names.join(", "))
            })
        }
    }
}

fn check_limits(variable: &Variable, number: f64) -> Result<(), String> {
    let unit = variable
        .unit()
        .map_or_else(String::new, |unit| format!(" {unit}"));
    match limits(variable) {
        _ if !number.is_finite() => Err(format!("{number} is not a finite number")),
        (Some(min), _) if number < min => Err(format!(
            "{number}{unit} is less than the smallest value {min}{unit}"
        )),
        (_, Some(max)) if number > max => Err(format!(
            "{number}{unit} is more than the largest value {max}{unit}"
        )),
        _ => Ok(()),
    }
}
