//! Runs one point after another on one instance of an FMU.
//!
//! A used instance is reset for the next point, or given back its first state where it cannot be reset;
//! else it is replaced. The first point on a used instance runs on a fresh one too: an FMU that forgets
//! to reset something is found out, and gets a fresh instance for every point from then on.

mod steps;
mod watched;

use std::sync::Arc;

use crate::failure::Failure;
use crate::statistics::Accumulator;
use crate::study::Statistic;
use crate::task::Task;
use fmu_import::{Call, Content, Instance, Library, State};
use watched::Watched;

/// Runs points, reusing the instance where the FMU can be reset.
#[derive(Debug)]
pub struct Runner {
    library: Arc<Library>,
    task: Task,
    used: Option<Held>,
    reuse: Reuse,
    /// Whether a reused instance has been compared with a fresh one.
    trusted: bool,
    /// Whether a reset that fails is a failure.
    candid: bool,
    /// The real variables that are read at every communication point.
    watched: Watched,
    /// The numbers of the other probes that are read there.
    slow: Vec<(usize, Accumulator)>,
    results: Vec<f64>,
}

/// How a used instance gets ready for the next point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reuse {
    Reset,
    Restore,
    Never,
}

/// An instance, and its first state where that is needed.
#[derive(Debug)]
struct Held {
    instance: Instance,
    first: Option<State>,
    /// Whether another point ran on it before.
    reused: bool,
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(state) = self.first.take() {
            // An instance that ended keeps it: nothing may be called any more.
            let _ = self.instance.forget(state);
        }
    }
}

impl Runner {
    /// A runner of points of this task.
    pub fn new(library: Arc<Library>, task: Task) -> Self {
        let over_time = (0..task.observed.len())
            .filter(|&index| task.observed[index].statistic != Statistic::Final);
        let (probes, slow): (Vec<_>, Vec<_>) =
            over_time.partition(|&index| task.observed[index].handle.content == Content::Real);
        Self {
            used: None,
            reuse: Reuse::Reset,
            // Where there can be one instance only, there is none to compare with.
            trusted: library.is_for_one_instance(),
            candid: false,
            library,
            watched: Watched::new(&task, probes),
            slow: slow
                .into_iter()
                .map(|index| (index, Accumulator::new(task.observed[index].statistic)))
                .collect(),
            results: vec![0.0; task.observed.len()],
            task,
        }
    }

    /// The same, but a reset is taken at its word, and its failure is the next point's.
    pub fn candid(mut self) -> Self {
        self.trusted = true;
        self.candid = true;
        self
    }

    /// Simulates one point. The values are in the FMU's units, one for each of
    /// [`Task::varied`]; so are the results, one for each of [`Task::observed`].
    ///
    /// # Errors
    /// When a value is not allowed, or the simulation fails.
    pub fn run(&mut self, values: &[f64]) -> Result<&[f64], Failure> {
        for (slot, &value) in self.task.varied.iter().zip(values) {
            slot.check(value).map_err(Failure::OutOfRange)?;
        }
        let held = self.prepared()?;
        let compare = held.reused && !self.trusted;
        let outcome = self.once(held, values);
        if compare {
            self.compare(values, outcome)?;
        } else {
            outcome?;
        }
        let bad = self.results.iter().position(|value| !value.is_finite());
        match bad {
            Some(index) => Err(Failure::NotFinite(self.task.observed[index].name.clone())),
            None => Ok(&self.results),
        }
    }

    /// Simulates a point on an instance, and keeps that.
    fn once(&mut self, mut held: Held, values: &[f64]) -> Result<(), Failure> {
        // An instance that failed is not used again.
        self.simulate(&mut held.instance, values)
            .map_err(|call| Failure::from_call(&call))?;
        held.instance.terminate();
        self.used = Some(held);
        Ok(())
    }

    /// Simulates a point again on a fresh instance, whose results count.
    fn compare(&mut self, values: &[f64], reused: Result<(), Failure>) -> Result<(), Failure> {
        let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        let before = reused.as_ref().map(|()| bits(&self.results));
        if self
            .used
            .as_ref()
            .is_some_and(|used| used.instance.is_dead())
        {
            return reused;
        }
        self.used = None;
        let fresh = self.prepared().and_then(|held| self.once(held, values));
        let after = fresh.as_ref().map(|()| bits(&self.results));
        if before != after {
            self.reuse = Reuse::Never;
        }
        self.trusted = true;
        fresh
    }

    /// Simulates one point and hands over the values of the given real variables at every
    /// communication point.
    ///
    /// # Errors
    /// As [`run`](Self::run), and what `sink` returns.
    pub fn trajectory<E: From<Failure>>(
        &mut self,
        values: &[f64],
        mut read: impl FnMut(f64, &mut Instance) -> Result<(), Trouble<E>>,
    ) -> Result<(), E> {
        for (slot, &value) in self.task.varied.iter().zip(values) {
            slot.check(value).map_err(Failure::OutOfRange)?;
        }
        let mut held = self.prepared()?;
        let instance = &mut held.instance;
        let schedule = self.task.schedule;
        let mut run = || -> Result<(), Trouble<E>> {
            start(&self.task, instance, values)?;
            read(schedule.start, instance)?;
            let (points, mut time) = (schedule.points(), schedule.start);
            for index in 1..=points.steps {
                let next = points.at(index);
                feed(&self.task, instance, time)?;
                ramp(&self.task, instance, time, next)?;
                instance.step(time, next - time)?;
                read(next, instance)?;
                time = next;
            }
            Ok(())
        };
        match run() {
            Ok(()) => {
                instance.terminate();
                self.used = Some(held);
                Ok(())
            }
            Err(Trouble::Call(call)) => Err(Failure::from_call(&call).into()),
            Err(Trouble::Other(error)) => Err(error),
        }
    }

    /// An instance in its initial state.
    fn prepared(&mut self) -> Result<Held, Failure> {
        if let Some(mut used) = self.used.take() {
            if used.instance.is_dead() {
                return Err(Failure::Fatal(
                    "the FMU cannot go on in this process".to_owned(),
                ));
            }
            let Held {
                instance, first, ..
            } = &mut used;
            if self.candid {
                instance.reset().map_err(|call| Failure::from_call(&call))?;
                return Ok(used);
            }
            let (ready, otherwise) = match (self.reuse, first) {
                (Reuse::Reset, _) => (instance.reset().is_ok(), Reuse::Restore),
                (Reuse::Restore, Some(first)) => (instance.restore(first).is_ok(), Reuse::Never),
                _ => (false, Reuse::Never),
            };
            if ready {
                used.reused = true;
                return Ok(used);
            }
            self.reuse = otherwise;
            // Before there is another one.
            drop(used);
        }
        let instance = Instance::new(&self.library, "point");
        let mut instance = instance.map_err(|call| Failure::from_call(&call))?;
        let first = match self.reuse {
            Reuse::Restore => instance.save(),
            _ => None,
        };
        Ok(Held {
            instance,
            first,
            reused: false,
        })
    }

    fn simulate(&mut self, instance: &mut Instance, values: &[f64]) -> Result<(), Call> {
        start(&self.task, instance, values)?;
        let points = self.task.schedule.points();
        let mut span = 0.0;
        if self.watched.probes.is_empty() && self.slow.is_empty() {
            self.advance::<false>(instance, &points, 0..points.steps)?;
        } else {
            self.forget();
            let from = points.from(self.task.schedule.window_start);
            self.advance::<false>(instance, &points, 0..from)?;
            self.watch(instance, 0.0)?;
            self.advance::<true>(instance, &points, from..points.steps)?;
            span = points.at(points.steps) - points.at(from);
        }
        self.finish(instance, span)
    }

    fn forget(&mut self) {
        let watched = &mut self.watched;
        let watched = watched.probes.iter().zip(&mut watched.accumulators);
        let slow = self.slow.iter_mut();
        for (index, accumulator) in watched.chain(slow.map(|(index, slow)| (&*index, slow))) {
            *accumulator = Accumulator::new(self.task.observed[*index].statistic);
        }
    }

    /// The results, with the statistics taken over `span` seconds.
    fn finish(&mut self, instance: &mut Instance, span: f64) -> Result<(), Call> {
        let watched = self.watched.probes.iter().zip(&self.watched.accumulators);
        let slow = self.slow.iter().map(|(index, slow)| (index, slow));
        for (index, accumulator) in watched.chain(slow) {
            self.results[*index] = accumulator.result(span);
        }
        for (probe, result) in self.task.observed.iter().zip(&mut self.results) {
            if probe.statistic == Statistic::Final {
                *result = probe.read(instance)?;
            }
        }
        Ok(())
    }
}

/// What interrupts a trajectory: the FMU, or who reads it.
#[derive(Debug)]
pub enum Trouble<E> {
    /// A call of the FMU failed.
    Call(Call),
    /// The reader failed.
    Other(E),
}

impl<E> From<Call> for Trouble<E> {
    fn from(call: Call) -> Self {
        Self::Call(call)
    }
}

/// Sets the start values and initialises.
fn start(task: &Task, instance: &mut Instance, values: &[f64]) -> Result<(), Call> {
    let schedule = &task.schedule;
    instance.setup_experiment(schedule.start, schedule.stop, schedule.tolerance)?;
    for (reference, value) in &task.fixed {
        instance.set(*reference, value)?;
    }
    for (slot, &value) in task.varied.iter().zip(values) {
        instance.set(slot.handle.reference, &slot.value(value))?;
    }
    feed(task, instance, schedule.start)?;
    instance.initialise()
}

/// Sets the inputs that change over time.
fn feed(task: &Task, instance: &mut Instance, time: f64) -> Result<(), Call> {
    for series in &task.inputs {
        instance.set(
            series.slot.handle.reference,
            &series.slot.value(series.at(time)),
        )?;
    }
    Ok(())
}

/// Lets those inputs vary within the next step that shall.
fn ramp(task: &Task, instance: &mut Instance, time: f64, next: f64) -> Result<(), Call> {
    for series in task.inputs.iter().filter(|series| series.ramp) {
        instance.set_slope(series.slot.handle.reference, series.slope(time, next))?;
    }
    Ok(())
}

impl crate::task::Probe {
    /// The variable's present value as a number.
    pub(crate) fn read(&self, instance: &mut Instance) -> Result<f64, Call> {
        instance.value(self.handle).map(|value| value.number())
    }
}
