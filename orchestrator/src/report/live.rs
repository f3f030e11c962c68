//! What the page needs to simulate points by itself: the FMU's WebAssembly module, and a point's simulation.

use crate::study::plan::Plan;
use crate::task::{Probe, Schedule, Task};
use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::{Compression, write::GzEncoder};
use fmu_import::units::Conversion;
use fmu_import::{Content, Interface, Package, Value, Version};
use sampling::statistics::Statistic;
use serde::Serialize;
use std::io::Write;

/// A module, and how a point is simulated with it.
#[derive(Clone, Debug, Serialize)]
pub struct Live {
    /// The module, compressed by gzip.
    module: String,
    guid: String,
    /// Relative tolerance for the FMU.
    tolerance: Option<f64>,
    times: Times,
    /// Start values that stay as they are: value reference, type, number.
    fixed: Vec<(u32, Content, f64)>,
    varied: Vec<Varied>,
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
    /// The number of the first communication point that statistics see.
    from: u64,
}

#[derive(Clone, Debug, Serialize)]
struct Varied {
    reference: u32,
    content: Content,
    /// Factor and offset from the study's unit to the FMU's.
    unit: [f64; 2],
    min: Option<f64>,
    max: Option<f64>,
    items: Vec<i64>,
}

#[derive(Clone, Debug, Serialize)]
struct Observed {
    reference: u32,
    content: Content,
    statistic: Statistic,
    /// Factor and offset from the FMU's unit to the study's.
    unit: [f64; 2],
}

impl Live {
    /// The simulation of a study's points with the module of its FMU.
    ///
    /// # Errors
    /// When the FMU has no module, or the study needs more than the page can do: the message says which.
    pub fn new(plan: &Plan, package: &mut Package) -> Result<Self, String> {
        let [case] = plan.cases.as_slice() else {
            return Err("the page cannot simulate studies with cases".to_owned());
        };
        let task = &case.task;
        possible(task)?;
        let module = module(package)?;
        let varied = task.varied.iter().zip(&plan.inputs);
        let observed = task.observed.iter().zip(&plan.outputs);
        Ok(Self {
            module: STANDARD.encode(packed(&module).map_err(|error| error.to_string())?),
            guid: package.description().guid.clone(),
            tolerance: task.schedule.tolerance,
            times: times(&task.schedule),
            fixed: task
                .fixed
                .iter()
                .map(|(reference, value)| (*reference, content(value), value.number()))
                .collect(),
            varied: varied
                .map(|(slot, input)| Varied {
                    reference: slot.handle.reference,
                    content: slot.handle.content,
                    unit: line(input.conversion),
                    min: slot.min,
                    max: slot.max,
                    items: slot.items.clone(),
                })
                .collect(),
            observed: observed
                .map(|(probe, conversion)| Observed::new(probe, *conversion))
                .collect(),
        })
    }
}

impl Observed {
    fn new(probe: &Probe, conversion: Conversion) -> Self {
        let [factor, offset] = line(conversion);
        let difference = probe.statistic.is_difference();
        Self {
            reference: probe.handle.reference,
            content: probe.handle.content,
            statistic: probe.statistic,
            unit: [factor, if difference { 0.0 } else { offset }],
        }
    }
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
        even: if leap > 0 {
            schedule.window_start
        } else {
            schedule.start
        },
        from: points.from(schedule.window_start),
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
    if let Some(series) = task.inputs.first() {
        return cannot(format!("inputs over time, such as {}", series.slot.name));
    }
    if task
        .fixed
        .iter()
        .any(|(_, value)| matches!(value, Value::String(_)))
    {
        return cannot("start values that are texts, such as names of files".to_owned());
    }
    let number = |content| matches!(content, Content::Real | Content::Integer);
    if let Some(slot) = task.varied.iter().find(|slot| !number(slot.handle.content)) {
        return cannot(format!(
            "parameters that are no numbers, such as {}",
            slot.name
        ));
    }
    for probe in &task.observed {
        let name = &probe.name;
        if probe.curve.is_some() {
            return cannot(format!("curves, such as that of {name}"));
        }
        if probe.window.is_some() || probe.detail.is_some() {
            return cannot(format!(
                "criteria with times or percentiles of their own, such as that of {name}"
            ));
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
            "{} has no WebAssembly module, so the page cannot simulate; it would be extra/FOLDER/{file} (docs/live.md)",
            package.path().display()
        ));
    };
    package.bytes_of(&entry).map_err(|error| error.to_string())
}

fn packed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bytes)?;
    packer.finish()
}
