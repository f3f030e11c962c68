//! Runs one point after another on one instance of an FMU.
//!
//! A used instance is reset for the next point, or given back its first state where it cannot be reset;
//! else it is replaced. The first point on a used instance runs on a fresh one too: an FMU that forgets
//! to reset something is found out, and gets a fresh instance for every point from then on.

use std::sync::Arc;

use crate::failure::Failure;
use crate::fmu::{Call, Instance, Library, State};
use crate::statistics::Accumulator;
use crate::study::Statistic;
use crate::task::{Storage, Task};

/// Runs points, reusing the instance where the FMU can be reset.
#[derive(Debug)]
pub struct Runner {
    library: Arc<Library>,
    task: Task,
    used: Option<Held>,
    reuse: Reuse,
    /// Whether a reused instance has been compared with a fresh one.
    trusted: bool,
    /// Numbers of the probes whose real values are read in one call, and their references.
    watched: Watched,
    /// The other probes that are read at every communication point.
    slow: Vec<usize>,
    accumulators: Vec<Accumulator>,
    results: Vec<f64>,
}

#[derive(Debug, Default)]
struct Watched {
    probes: Vec<usize>,
    references: Vec<u32>,
    values: Vec<f64>,
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
            self.instance.forget(state);
        }
    }
}

impl Runner {
    /// A runner of points of this task.
    pub fn new(library: Arc<Library>, task: Task) -> Self {
        let over_time: Vec<usize> = (0..task.observed.len())
            .filter(|&index| task.observed[index].statistic != Statistic::Final)
            .collect();
        let (probes, slow): (Vec<usize>, Vec<usize>) = over_time
            .into_iter()
            .partition(|&index| task.observed[index].storage == Storage::Real);
        let references: Vec<u32> = probes
            .iter()
            .map(|&index| task.observed[index].reference)
            .collect();
        Self {
            used: None,
            reuse: Reuse::Reset,
            // Where there can be one instance only, there is none to compare with.
            trusted: library.once,
            library,
            watched: Watched {
                values: vec![0.0; probes.len()],
                probes,
                references,
            },
            slow,
            accumulators: vec![Accumulator::default(); task.observed.len()],
            results: vec![0.0; task.observed.len()],
            task,
        }
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
            for index in 0..schedule.steps() {
                read(advance(&self.task, instance, index)?, instance)?;
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
        let schedule = self.task.schedule;
        let steps = schedule.steps();
        if self.watched.probes.is_empty() && self.slow.is_empty() {
            for index in 0..steps {
                advance(&self.task, instance, index)?;
            }
        } else {
            self.accumulators.fill(Accumulator::default());
            if schedule.window_start <= schedule.start {
                self.watch(instance, schedule.start)?;
            }
            for index in 0..steps {
                let next = advance(&self.task, instance, index)?;
                if next >= schedule.window_start {
                    self.watch(instance, next)?;
                }
            }
        }
        self.finish(instance)
    }

    /// Reads what has a statistic over time.
    #[inline]
    fn watch(&mut self, instance: &mut Instance, time: f64) -> Result<(), Call> {
        let watched = &mut self.watched;
        if !watched.probes.is_empty() {
            instance.reals(&watched.references, &mut watched.values)?;
            for (&probe, &value) in watched.probes.iter().zip(&watched.values) {
                self.accumulators[probe].add(time, value);
            }
        }
        for &probe in &self.slow {
            let value = self.task.observed[probe].read(instance)?;
            self.accumulators[probe].add(time, value);
        }
        Ok(())
    }

    fn finish(&mut self, instance: &mut Instance) -> Result<(), Call> {
        for (index, probe) in self.task.observed.iter().enumerate() {
            self.results[index] = match probe.statistic {
                Statistic::Final => probe.read(instance)?,
                other => self.accumulators[index].value(other),
            };
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
        instance.set(slot.reference, &slot.value(value))?;
    }
    feed(task, instance, schedule.start)?;
    instance.initialise()
}

/// Sets the inputs that change over time.
#[inline]
fn feed(task: &Task, instance: &mut Instance, time: f64) -> Result<(), Call> {
    for series in &task.inputs {
        instance.set(series.slot.reference, &series.slot.value(series.at(time)))?;
    }
    Ok(())
}

/// Does the step after the `index`th communication point and returns the time at its end.
#[inline]
fn advance(task: &Task, instance: &mut Instance, index: u64) -> Result<f64, Call> {
    let schedule = &task.schedule;
    let (time, next) = (schedule.time(index), schedule.time(index + 1));
    feed(task, instance, time)?;
    instance.step(time, next - time)?;
    Ok(next)
}

impl crate::task::Probe {
    /// The variable's present value as a number.
    pub(crate) fn read(&self, instance: &mut Instance) -> Result<f64, Call> {
        match self.storage {
            Storage::Real => {
                let mut value = [0.0];
                instance.reals(&[self.reference], &mut value)?;
                Ok(value[0])
            }
            Storage::Integer => instance.integer(self.reference).map(f64::from),
            Storage::Boolean => instance
                .boolean(self.reference)
                .map(|yes| f64::from(u8::from(yes))),
        }
    }
}
