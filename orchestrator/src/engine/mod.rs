//! Runs many points on all cores.
//!
//! Points are handed to workers in batches; a worker is anything that can run a batch. Results come back to the
//! calling thread in whatever order they finish.
//!
//! Where points run, from the outside in: this process has slots, each with its [guards](process); a
//! [guard] is a process of its own whose children run the FMU. How far points may share a process is
//! what the slots find out together ([policy]).

mod batch;
pub mod birth;
mod company;
pub mod conduct;
pub mod crew;
mod ground;
pub mod guard;
mod join;
pub mod local;
pub mod policy;
pub mod process;
pub mod repeats;
mod servant;
pub mod single;
mod slot;
pub(crate) mod system;
mod wire;
pub mod working_directory;

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

use thiserror::Error;

use crate::failure::Failure;
use crate::notices::Notices;
use batch::Batches;
use process::Gone;
use wire::Trouble;

pub use company::Company;
pub use conduct::{Conduct, Isolation, Separation};

/// Why a run cannot go on at all. What happens to a single point is a [`Failure`].
#[derive(Debug, Error)]
pub enum EngineError {
    /// A worker cannot be started.
    #[error("cannot start a worker: {0}")]
    Start(String),
    /// The FMU cannot be loaded.
    #[error("{0}")]
    Unloadable(String),
    /// A worker was lost and cannot be replaced.
    #[error("a worker was lost: {0}")]
    Lost(String),
    /// Points were computed again, and no result counted.
    #[error(
        "points were computed again, and no result counted, because processes of the FMU differ; go on with --resume"
    )]
    Circling,
    /// Earlier results, which have been used already, do not count any more.
    #[error(
        "the FMU gives other results in a process that has computed points before; use --isolation fresh"
    )]
    Refuted,
    /// The same, because the FMU has changed its own folder, which all points shared.
    #[error(
        "the FMU changes files in its own folder, so points on which others were built do not count; --resume computes them again, each with a folder of its own"
    )]
    Disturbed,
}

/// A point to run: its index, and its parameters in the FMU's units.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The index of the point.
    pub index: u64,
    /// The parameters.
    pub values: Vec<f64>,
}

/// The results of a point in the FMU's units, or why there are none.
pub type Answer = Result<Vec<f64>, Failure>;

/// A simulated point.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The results in the FMU's units.
    pub values: Vec<f64>,
    /// The FMU's remarks beside them, if there were any.
    pub notices: Option<Box<Notices>>,
}

impl From<Vec<f64>> for Simulated {
    fn from(values: Vec<f64>) -> Self {
        let notices = None;
        Self { values, notices }
    }
}

impl Simulated {
    /// Results with what was said beside them.
    fn new(values: &[f64], notices: &Notices) -> Self {
        Self {
            values: values.to_vec(),
            notices: (!notices.is_empty()).then(|| Box::new(notices.clone())),
        }
    }
}

/// Events of a run.
#[derive(Debug)]
pub enum Event {
    /// The FMU's warnings in the point of this index, of which the next event will be that it failed.
    Said(u64, Box<Notices>),
    /// The point of this index is done, in such a process.
    Answer(u64, Result<Simulated, Failure>, Separation),
    /// Points that were computed in such processes, or less strictly separated ones, do not count any more:
    /// they will come again.
    Void(Separation),
    /// The point of this index gave results in one try and none in another, while others ran.
    Fickle(u64),
    /// From now on nothing else runs while a point does: some of those that failed come again.
    Alone,
    /// Points that failed do not come again.
    Settled,
    /// All answers so far have been handed over; the next one is waited for.
    Idle,
}

/// The connection of a running worker: its instructions, and the place for its answers.
pub struct Post<'a> {
    /// Takes what happens; breaks where nothing further is wanted.
    pub take: &'a mut dyn FnMut(Event) -> ControlFlow<()>,
    /// Whether the run is to end at once.
    pub stopped: &'a dyn Fn() -> bool,
    /// How many points are left besides the batch, as far as that is known.
    pub left: Option<usize>,
    over: bool,
}

impl<'a> Post<'a> {
    /// Hands everything to `take`.
    pub fn new(
        take: &'a mut dyn FnMut(Event) -> ControlFlow<()>,
        stopped: &'a dyn Fn() -> bool,
        left: Option<usize>,
    ) -> Self {
        Self {
            take,
            stopped,
            left,
            over: false,
        }
    }

    /// Reports what happened.
    pub fn send(&mut self, event: Event) {
        self.over |= (self.take)(event).is_break();
    }

    /// Whether nothing further is wanted.
    pub fn is_over(&self) -> bool {
        self.over || (self.stopped)()
    }

    fn answer(&mut self, index: u64, found: Result<Simulated, Trouble>, separation: Separation) {
        if let Some(notices) = found.as_ref().err().and_then(Trouble::notices) {
            self.send(Event::Said(index, Box::new(notices.clone())));
        }
        let answer = found.map_err(Trouble::failure);
        self.send(Event::Answer(index, answer, separation));
    }

    /// Waits, unless the run is to end.
    fn pause(&self, pause: Duration) -> Result<(), Gone> {
        let until = std::time::Instant::now() + pause;
        while std::time::Instant::now() < until {
            if (self.stopped)() {
                return Err(Gone::Stopped);
            }
            thread::sleep(pause.min(Duration::from_millis(20)));
        }
        Ok(())
    }
}

/// Something that runs points one after another.
pub trait Worker: Send {
    /// Runs the jobs and reports each one as soon as it is done, exactly once; may stop early
    /// when the post says so.
    ///
    /// # Errors
    /// When no further point can be run.
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), EngineError>;

    /// Runs a point while no other worker does anything.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    fn run_alone(&mut self, job: &Job, post: &mut Post<'_>) -> Result<(), EngineError> {
        self.run(std::slice::from_ref(job), post)
    }

    /// Gives back what it keeps for further points, and others may need.
    fn rest(&mut self) {}
}

/// Runs the points `open` on the workers, and hands each answer to `receive` on the calling thread. Setting `stop`,
/// or a `Break` from `receive`, ends the run early; points that have begun are given up.
///
/// Where it turns out that points cannot be computed as they were, those of this run and of `earlier` ones (given
/// by their separation) are computed again after the others. Points that failed while others ran are then run
/// alone, as far as `company` sees that it matters.
///
/// # Errors
/// When a worker cannot start, and what `receive` returns.
pub fn run<E: From<EngineError>>(
    workers: &mut [Box<dyn Worker>],
    open: impl Iterator<Item = u64> + Send,
    job: &(dyn Fn(u64) -> Job + Sync),
    earlier: &dyn Fn(Separation) -> Vec<u64>,
    company: &mut Company,
    stop: &AtomicBool,
    mut receive: impl FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<(), E> {
    let mut ledger = Ledger::default();
    let crowded = workers.len() > 1;
    let mut watch = |event, ledger: &mut Ledger, company: Option<&mut Company>| match ledger
        .enter(event, earlier)
    {
        Some(event) => {
            company.into_iter().for_each(|company| company.heed(&event));
            receive(event)
        }
        None => Ok(ControlFlow::Continue(())),
    };
    let mut over = pass(workers, open, job, stop, &mut |event| {
        watch(event, &mut ledger, crowded.then_some(&mut *company))
    })?;
    while !over {
        if let Some(again) = ledger.open() {
            let (left, void) = (again.len(), ledger.void);
            over = pass(workers, again.into_iter(), job, stop, &mut |event| {
                watch(event, &mut ledger, crowded.then_some(&mut *company))
            })?;
            // A run that gets nowhere would never end.
            let still_open = ledger.open().map_or(0, |again| again.len());
            if !over && ledger.void == void && still_open >= left {
                return Err(EngineError::Circling.into());
            }
        } else if company.is_settled() {
            break;
        } else {
            over = company.settle(workers, job, stop, &mut |event| {
                watch(event, &mut ledger, None)
            })?;
        }
    }
    Ok(())
}

/// Runs points once; whether the run has been ended early.
fn pass<E: From<EngineError>>(
    workers: &mut [Box<dyn Worker>],
    open: impl Iterator<Item = u64> + Send,
    job: &(dyn Fn(u64) -> Job + Sync),
    stop: &AtomicBool,
    receive: &mut dyn FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<bool, E> {
    // Bounded, so that slow storage holds the workers back instead of filling the memory.
    const WAITING: usize = 16_384;
    let jobs = Mutex::new(Batches::new(open.map(job), workers.len()));
    let done = AtomicBool::new(false);
    let stopped = || stop.load(Ordering::Relaxed) || done.load(Ordering::Relaxed);
    let (send, receiver) = sync_channel(WAITING);
    thread::scope(|scope| {
        for worker in workers {
            let (send, jobs, stopped) = (send.clone(), &jobs, &stopped);
            scope.spawn(move || {
                let mut pace = batch::Pace::default();
                let mut batch = Vec::new();
                loop {
                    let taken = jobs.lock().map(|mut jobs| {
                        let taken = jobs.take(&pace, &mut batch);
                        taken.then(|| jobs.left())
                    });
                    let Ok(Some(left)) = taken else { return };
                    if stopped() {
                        return;
                    }
                    pace.begin();
                    let mut take = |event| match send.send(Ok(event)) {
                        Ok(()) => ControlFlow::Continue(()),
                        Err(_) => ControlFlow::Break(()),
                    };
                    let result = worker.run(&batch, &mut Post::new(&mut take, stopped, left));
                    pace.end(batch.len());
                    if let Err(error) = result {
                        // The receiver may have gone; then nobody waits for the error either.
                        let _ = send.send(Err(error));
                        return;
                    }
                }
            });
        }
        drop(send);
        collect(&receiver, &done, receive)
    })?;
    Ok(stopped())
}

/// Which points were computed how, and which of them have to be computed again.
#[derive(Debug, Default)]
struct Ledger {
    new: Indexes,
    forked: Indexes,
    used: Indexes,
    again: Indexes,
    /// Results from such processes are void.
    void: Option<Separation>,
}

impl Ledger {
    /// Notes an event; `None` where it does not count.
    fn enter(&mut self, event: Event, earlier: &dyn Fn(Separation) -> Vec<u64>) -> Option<Event> {
        match event {
            Event::Answer(index, _, separation)
                if self.void.is_some_and(|void| separation >= void) =>
            {
                self.again.insert(index);
                return None;
            }
            Event::Answer(index, _, separation) => {
                self.again.remove(index);
                self.new.set(index, separation == Separation::New);
                self.forked.set(index, separation == Separation::Forked);
                self.used.set(index, separation == Separation::Used);
            }
            Event::Void(separation) => {
                if self.void.is_some_and(|void| void <= separation) {
                    return None;
                }
                self.void = Some(separation);
                for index in earlier(separation) {
                    self.again.insert(index);
                }
                self.again.take(&mut self.used);
                if separation <= Separation::Forked {
                    self.again.take(&mut self.forked);
                }
                if separation <= Separation::New {
                    self.again.take(&mut self.new);
                }
            }
            Event::Said(..) | Event::Fickle(_) | Event::Alone | Event::Settled | Event::Idle => {}
        }
        Some(event)
    }

    /// The points to compute again, if there are any.
    fn open(&mut self) -> Option<Vec<u64>> {
        let open: Vec<u64> = self.again.iter().collect();
        (!open.is_empty()).then_some(open)
    }
}

/// A set of indexes, a bit each.
#[derive(Clone, Debug, Default)]
pub struct Indexes(Vec<u64>);

impl Indexes {
    fn set(&mut self, index: u64, present: bool) {
        let place = usize::try_from(index / 64).unwrap_or(usize::MAX);
        if place >= self.0.len() {
            if !present {
                return;
            }
            self.0.resize(place + 1, 0);
        }
        let bit = 1 << (index % 64);
        if present {
            self.0[place] |= bit;
        } else {
            self.0[place] &= !bit;
        }
    }

    /// Adds an index.
    pub fn insert(&mut self, index: u64) {
        self.set(index, true);
    }

    /// Takes an index away.
    pub fn remove(&mut self, index: u64) {
        self.set(index, false);
    }

    /// Takes all of another set.
    fn take(&mut self, other: &mut Self) {
        self.0.resize(self.0.len().max(other.0.len()), 0);
        for (own, other) in self.0.iter_mut().zip(other.0.drain(..)) {
            *own |= other;
        }
    }

    /// Its indexes in their order.
    pub fn iter(&self) -> impl Iterator<Item = u64> + '_ {
        let words = self.0.iter().zip(0_u64..);
        words.flat_map(|(word, place)| {
            (0..64)
                .filter(move |bit| word >> bit & 1 == 1)
                .map(move |bit| 64 * place + bit)
        })
    }
}

/// How long answers are gathered before they are handed over, at first and in the long run: to wake up
/// and to write costs the workers a little each time. A set of few points should not wait for it.
const GATHERING: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(8)];

/// Hands over everything that comes, until all workers have ended.
fn collect<E: From<EngineError>>(
    receiver: &Receiver<Result<Event, EngineError>>,
    done: &AtomicBool,
    receive: &mut dyn FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<(), E> {
    let mut outcome = Ok(());
    let mut handle = |step: Result<Event, EngineError>| {
        // After an error, answers are only drained.
        if outcome.is_err() {
            return;
        }
        match step.map_err(E::from).and_then(&mut *receive) {
            Ok(ControlFlow::Continue(())) => {}
            Ok(ControlFlow::Break(())) => done.store(true, Ordering::Relaxed),
            Err(error) => {
                done.store(true, Ordering::Relaxed);
                outcome = Err(error);
            }
        }
    };
    let [mut gathering, longest] = GATHERING;
    loop {
        let message = match receiver.try_recv() {
            Ok(message) => message,
            Err(TryRecvError::Disconnected) => break,
            Err(TryRecvError::Empty) => {
                handle(Ok(Event::Idle));
                let Ok(message) = receiver.recv() else { break };
                // Answers of a fast FMU come in company: to wake up for each would cost more than they do.
                thread::sleep(gathering);
                gathering = longest.min(gathering * 9 / 8);
                message
            }
        };
        handle(message);
    }
    outcome
}

#[cfg(test)]
mod tests;
