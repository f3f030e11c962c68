//! Helpers of the integration tests.

use std::collections::HashMap;
use std::path::PathBuf;

use calibration::problem::{NoPrediction, Prediction, Query, Simulate};
use fmu_export::model::{Access, Experiment, Kind, Model, Quantity, Variable};
use fmu_import::{Description, Package, Value};
use fmu_points::task::Task;
use orchestrator::identify::bind::Bound;
use plain_bearing_stand::stand::Stand;
use rayon::prelude::*;
use sampling::statistics::Accumulator;

/// A file of the repository.
pub fn file(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

/// The stand's own description, without a binary.
pub fn package() -> Package {
    Package::open(&file("modelDescription")).expect("the committed description is readable")
}

/// The stand without the FMI boundary: an identification's model that needs no packaged FMU.
#[derive(Debug)]
pub struct StandModel<'a> {
    bound: &'a Bound,
    start: Stand,
}

impl<'a> StandModel<'a> {
    /// The stand with the start values that the study fixes.
    pub fn new(bound: &'a Bound, description: &Description) -> Self {
        Self { bound, start: stand(&bound.simulations[0].task, description) }
    }

    /// The stand before one simulation.
    pub fn stand(&self, case: usize, free: &[f64], latents: &[f64]) -> Stand {
        let found = free.iter().chain(latents).zip(&self.bound.inputs);
        let found = found.map(|(&value, conversion)| conversion.value(value));
        let values = self.bound.known[case].iter().copied().chain(found);
        let mut stand = self.start.clone();
        for (slot, value) in self.bound.simulations[0].task.varied.iter().zip(values) {
            set(&mut stand, &slot.name, &Value::Real(value));
        }
        stand
    }
}

impl StandModel<'_> {
    fn predict(&self, query: &Query) -> Prediction {
        let stand = self.stand(query.case, &query.free, &query.latents);
        let results = run(stand, &self.bound.simulations[0].task)?;
        let pairs = results.iter().zip(&self.bound.outputs);
        Ok(pairs.map(|(&value, conversion)| conversion.value(value)).collect())
    }
}

impl Simulate for StandModel<'_> {
    fn simulate(&self, queries: &[Query]) -> Result<Vec<Prediction>, NoPrediction> {
        Ok(queries.par_iter().map(|query| self.predict(query)).collect())
    }
}

/// The stand with the start values that a task fixes.
pub fn stand(task: &Task, description: &Description) -> Stand {
    let variables = description.variables.values();
    let names: HashMap<u32, &str> =
        variables.map(|variable| (variable.value_reference, variable.name.as_str())).collect();
    let mut stand = Stand::default();
    for (reference, value) in &task.fixed {
        set(&mut stand, names[reference], value);
    }
    stand
}

/// Runs a stand as a task says, and returns what it observes, in SI units.
///
/// # Errors
/// Says why the simulation failed.
pub fn run(mut stand: Stand, task: &Task) -> Result<Vec<f64>, String> {
    let schedule = task.schedule;
    let experiment =
        Experiment { start: schedule.start, stop: Some(schedule.stop), tolerance: schedule.tolerance, resources: None };
    stand.initialise(&experiment, &mut ()).map_err(|fault| fault.to_string())?;
    let statistics = task.observed.iter().map(|probe| probe.measure.statistic().map(Accumulator::new));
    let mut accumulators: Vec<_> = statistics.collect::<Option<_>>().ok_or("it is compared with a curve")?;
    let mut observe = |stand: &Stand, elapsed| {
        for (accumulator, probe) in accumulators.iter_mut().zip(&task.observed) {
            accumulator.add(elapsed, get(stand, &probe.name));
        }
    };
    let points = schedule.points();
    let from = points.from(schedule.window_start);
    for index in 0..points.steps {
        if index == from {
            observe(&stand, 0.0);
        }
        let (time, next) = (points.at(index), points.at(index + 1));
        stand.advance(time, next - time, &mut ()).map_err(|fault| fault.to_string())?;
        if index >= from {
            observe(&stand, next - time);
        }
    }
    if from == points.steps {
        observe(&stand, 0.0);
    }
    let span = points.at(points.steps) - points.at(from);
    Ok(accumulators.iter().map(|a| a.result(span)).collect())
}

fn variable(name: &str) -> &'static Variable<Stand> {
    let variable = Stand::variables().iter().find(|variable| variable.name == name);
    variable.expect("the description has the stand's own variables")
}

/// Reads a variable of a stand, in SI units.
pub fn get(stand: &Stand, name: &str) -> f64 {
    match &variable(name).kind {
        Kind::Real(Quantity { access, .. }) => (access.get)(stand),
        _ => panic!("{name} is not a real number"),
    }
}

fn set(stand: &mut Stand, name: &str, value: &Value) {
    match (&variable(name).kind, value) {
        (Kind::Real(Quantity { access: Access { set: Some(set), .. }, .. }), Value::Real(value)) => {
            set(stand, value);
        }
        (Kind::Enumeration { access: Access { set: Some(set), .. }, .. }, Value::Integer(item)) => {
            set(stand, &i32::try_from(*item).expect("an item of an enumeration"));
        }
        _ => panic!("{name} cannot be set to {value:?}"),
    }
}
