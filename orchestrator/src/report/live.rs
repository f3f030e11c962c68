//! The FMU's WebAssembly module and a point's simulation, with which the page simulates points by itself.

use curves::Metric;
use fmu_import::units::Conversion;
use fmu_import::{Content, Interface, Package, Value, Version};
use fmu_points::task::{Delay, Detail, MeasuredCurve, Probe, Schedule, Series, Slot, Task, place};
use parameter_regions::table::PointTable;
use sampling::statistics::Statistic;
use serde::Serialize;
use study::plan::Plan;

/// How many of the study's points the page compares with the module's.
const COMPARED: usize = 24;

/// How far its results may be from the study's, as a part of the tolerance. The last digits differ, since functions such as `exp` are
/// rounded otherwise, and where a step's size hangs on them, some digits more.
const WITHIN: f64 = 1e-4;

/// A module, and how a point is simulated with it.
#[derive(Clone, Debug, Serialize)]
pub struct Live {
    /// The module, compressed by gzip.
    module: String,
    guid: String,
    varied: Vec<Varied>,
    /// The simulations of a point: one, or one a case.
    cases: Vec<Scene>,
    /// Points of the study with their results: a module that gives others is not believed.
    own: Vec<Own>,
}

/// One of the simulations of a point.
#[derive(Clone, Debug, Serialize)]
struct Scene {
    /// Relative tolerance for the FMU.
    tolerance: Option<f64>,
    times: Times,
    /// Times between communication points to which the FMU takes a step.
    stops: Vec<f64>,
    /// Start values that stay as they are: value reference, type, number.
    fixed: Vec<(u32, Content, f64)>,
    inputs: Vec<Series>,
    observed: Vec<Observed>,
}

/// The communication points, as [`Schedule`] has them.
#[derive(Clone, Debug, Serialize)]
struct Times {
    start: f64,
    stop: f64,
    step: f64,
    steps: u64,
    /// Steps before the even ones, and where those begin.
    leap: u64,
    even: f64,
}

#[derive(Clone, Debug, Serialize)]
struct Varied {
    #[serde(flatten)]
    slot: Slot,
    /// Factor and offset from the study's unit to the FMU's.
    unit: [f64; 2],
}

#[derive(Clone, Debug, Serialize)]
struct Observed {
    reference: u32,
    content: Content,
    statistic: Statistic,
    /// The first and the last communication point that it sees.
    seen: [u64; 2],
    /// The time of its value, where it is one between communication points.
    at: Option<f64>,
    curve: Option<Curve>,
    /// Factor and offset from the FMU's unit to the study's: of the result, and of the signal.
    unit: [f64; 2],
    signal: [f64; 2],
}

/// A measured curve, as [`MeasuredCurve`] has it, at the model's times.
#[derive(Clone, Debug, Serialize)]
struct Curve {
    metric: Metric,
    times: Vec<f64>,
    values: Vec<f64>,
    band: Vec<f64>,
    normaliser: f64,
}

/// A point of the study, in its units.
#[derive(Clone, Debug, Serialize)]
struct Own {
    id: u64,
    values: Vec<f64>,
    results: Vec<f64>,
    /// How far the module's results may be from these.
    within: Vec<f64>,
}

impl Live {
    /// The simulation of a study's points with the module of its FMU; `table` has points to compare with.
    ///
    /// # Errors
    /// When the FMU has no module, or the study needs more than the page can do: the message says which.
    pub fn new(plan: &Plan, package: &mut Package, table: &PointTable) -> Result<Self, String> {
        for case in &plan.cases {
            possible(&case.task)?;
        }
        let module = module(package)?;
        let varied = plan.slots.iter().zip(&plan.inputs);
        let scene = |number: usize| {
            let outputs = &plan.outputs[plan.criteria_of(number)];
            Scene::new(plan.cases[number].task.clone(), outputs)
        };
        Ok(Self {
            module: super::packed(&module).map_err(|error| error.to_string())?,
            guid: package.description().guid.clone(),
            varied: varied.map(|(slot, input)| Varied { slot: slot.clone(), unit: line(input.conversion) }).collect(),
            cases: (0..plan.cases.len()).map(scene).collect(),
            own: compared(table)?,
        })
    }
}

impl Scene {
    fn new(mut task: Task, outputs: &[Conversion]) -> Self {
        let stops = place(&mut task.inputs, &task.schedule);
        let observed = task.observed.iter().zip(outputs);
        let fixed = task.fixed.iter();
        Self {
            tolerance: task.schedule.tolerance,
            times: times(&task.schedule),
            stops,
            fixed: fixed.map(|(reference, value)| (*reference, content(value), value.number())).collect(),
            observed: observed.map(|(probe, conversion)| Observed::new(probe, *conversion, &task.schedule)).collect(),
            inputs: task.inputs,
        }
    }
}

impl Observed {
    fn new(probe: &Probe, conversion: Conversion, schedule: &Schedule) -> Self {
        let [factor, offset] = line(conversion);
        let difference = probe.statistic.is_difference();
        Self {
            reference: probe.handle.reference,
            content: probe.handle.content,
            statistic: probe.statistic,
            seen: seen(probe, schedule),
            at: match probe.detail {
                Some(Detail::At(time)) => Some(time),
                _ => None,
            },
            curve: probe.curve.as_deref().map(Curve::new),
            unit: [factor, if difference { 0.0 } else { offset }],
            signal: match &probe.curve {
                Some(curve) => [curve.factor, curve.offset],
                None => [factor, offset],
            },
        }
    }
}

impl Curve {
    fn new(measured: &MeasuredCurve) -> Self {
        let delay = match measured.delay {
            Delay::Known(delay) => delay,
            Delay::Within(_) => f64::NAN,
        };
        Self {
            metric: measured.metric,
            times: measured.times.iter().map(|time| time - delay).collect(),
            values: measured.values.clone(),
            band: measured.band.clone(),
            normaliser: measured.normaliser,
        }
    }
}

/// The first and the last communication point that a criterion sees, as `run` has it.
fn seen(probe: &Probe, schedule: &Schedule) -> [u64; 2] {
    let points = schedule.points();
    let Some([from, to]) = probe.window else {
        return match probe.is_final() {
            true => [points.steps; 2],
            false => [points.from(schedule.window_start), points.steps],
        };
    };
    let rounding = 1e-9 * (from.abs() + to.abs());
    let last = points.from(to + rounding);
    let beyond = points.at(last) > to + rounding;
    [points.from(from - rounding), last.saturating_sub(u64::from(beyond))]
}

/// Some of the points that came to their end, evenly chosen.
fn compared(table: &PointTable) -> Result<Vec<Own>, String> {
    let completed: Vec<usize> = (0..table.len()).filter(|&i| table.completed(i)).collect();
    if completed.is_empty() {
        let none = "no point of the study came to its end, with which the page could compare the module's results";
        return Err(none.to_owned());
    }
    let step = completed.len().div_ceil(COMPARED);
    let point = |&i: &usize| Own {
        id: table.ids[i],
        values: table.parameters.iter().map(|p| p.values[i]).collect(),
        results: table.criteria.iter().map(|c| c.values[i]).collect(),
        within: table
            .criteria
            .iter()
            .map(|c| {
                let rooms = [c.upper - c.nominal, c.nominal - c.lower].into_iter();
                let room = rooms.filter(|room| room.is_finite()).fold(0.0, f64::max);
                WITHIN * room + 1e-9 * c.values[i].abs()
            })
            .collect(),
    };
    Ok(completed.iter().step_by(step).map(point).collect())
}

fn line(conversion: Conversion) -> [f64; 2] {
    [conversion.difference(1.0), conversion.value(0.0)]
}

fn times(schedule: &Schedule) -> Times {
    let points = schedule.points();
    let leap = schedule.first_even();
    Times {
        start: schedule.start,
        stop: schedule.stop,
        step: schedule.step,
        steps: points.steps,
        leap,
        even: if leap > 0 { schedule.window_start } else { schedule.start },
    }
}

fn content(value: &Value) -> Content {
    match value {
        Value::Real(_) => Content::Real,
        Value::Integer(_) => Content::Integer,
        Value::Boolean(_) => Content::Boolean,
        Value::String(_) => Content::Text,
    }
}

/// Whether the page's script can do all that a point takes.
fn possible(task: &Task) -> Result<(), String> {
    let cannot = |what: String| Err(format!("the page cannot simulate {what}"));
    if task.fixed.iter().any(|(_, value)| matches!(value, Value::String(_))) {
        return cannot("start values that are texts, such as names of files".to_owned());
    }
    let number = |content| matches!(content, Content::Real | Content::Integer);
    if let Some(slot) = task.varied.iter().find(|slot| !number(slot.handle.content)) {
        return cannot(format!("parameters that are no numbers, such as {}", slot.name));
    }
    if let Some(slot) = task.varied.iter().find(|slot| slot.error.is_some()) {
        return cannot(format!("the errors of a recorded input, {}", slot.name));
    }
    for probe in &task.observed {
        let name = &probe.name;
        match (&probe.curve, probe.detail) {
            (Some(curve), _) if matches!(curve.delay, Delay::Within(_)) => {
                return cannot(format!("curves whose delay is to be found, such as that of {name}"));
            }
            (Some(curve), _) => match curve.metric {
                Metric::Rmse | Metric::Nrmse | Metric::MaxError => continue,
                Metric::Corridor | Metric::Area => continue,
                other => return cannot(format!("the {} of {name}", other.label())),
            },
            (None, Some(Detail::At(_))) => continue,
            (None, Some(detail)) => return cannot(format!("the {} of {name}", detail.label())),
            (None, None) => {}
        }
        match probe.statistic {
            Statistic::Final | Statistic::Mean | Statistic::Min | Statistic::Max => {}
            Statistic::Rms | Statistic::Amplitude => {}
            other => return cannot(format!("the {} of {name}", other.label())),
        }
    }
    Ok(())
}

/// The FMU's module: `extra/FOLDER/MODELIDENTIFIER.wasm`.
fn module(package: &mut Package) -> Result<Vec<u8>, String> {
    let description = package.description();
    let co_simulation = description.interface == Interface::CoSimulation;
    if description.standard != Version::Two || !co_simulation {
        return Err("the page can simulate FMUs of FMI 2.0 for Co-Simulation only".to_owned());
    }
    let file = format!("{}.wasm", description.model_identifier);
    let fits = |entry: &String| {
        let mut parts = entry.split('/');
        parts.next() == Some("extra") && parts.next_back() == Some(&*file)
    };
    let Some(entry) = package.entries().into_iter().find(fits) else {
        return Err(format!(
            "{} has no WebAssembly module, so the page cannot simulate; it would be extra/FOLDER/{file} (docs/evidence/live.md)",
            package.path().display()
        ));
    };
    package.bytes_of(&entry).map_err(|error| error.to_string())
}
