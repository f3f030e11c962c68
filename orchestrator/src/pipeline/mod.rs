//! Runs points, for every analysis in the same way.
//!
//! An analysis is a set of points, or several sets one after the other, where a later one may depend on what came
//! of the earlier ones. What is in the journal is read, what is not is computed and noted at once. So a run that
//! was interrupted is simply begun again: the same analysis asks for the same points, and the journal answers
//! those that it knows.

pub mod folder;
mod progress;
mod shard;
pub mod stop;

use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::{Duration, Instant};

use thiserror::Error;

use crate::engine::{self, Answer, EngineError, Event, Job, Worker};
use crate::results::finished::Finished;
use crate::results::{Journal, Outcome, ResultsError};
use progress::Progress;

pub use shard::Shard;

/// Points of one model in the units of the study.
pub trait Model {
    /// A point in the FMU's units.
    fn values(&self, point: &[f64]) -> Vec<f64>;

    /// An answer of the FMU in the study's units.
    fn outcome(&self, answer: Answer) -> Outcome;

    /// Whether the outcome meets all criteria.
    fn is_verified(&self, outcome: &Outcome) -> bool;
}

/// Why a run has no outcome for every point that was asked for.
#[derive(Debug, Error)]
pub enum Halt {
    /// Ctrl-C.
    #[error("interrupted: {} done; --resume goes on", share(*.done, *.of))]
    Interrupted {
        /// Points that are done.
        done: u64,
        /// How many there are, where that is known.
        of: Option<u64>,
    },
    /// The points of this run's shard are done; those of the others are not its task.
    #[error("{0} points of this shard are done")]
    Shard(u64),
    /// Only the journal is read, and it does not hold all points.
    #[error("{missing} of {of} points are missing")]
    Missing {
        /// How many are missing.
        missing: u64,
        /// Of how many.
        of: u64,
    },
    /// The journal cannot be read or written.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The points cannot be run.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

fn share(done: u64, of: Option<u64>) -> String {
    match of {
        Some(of) => format!("{done} of {of} points are"),
        None => format!("{done} points are"),
    }
}

/// Runs points and keeps what comes of them.
pub struct Pipeline<'a> {
    model: &'a dyn Model,
    /// None where only the journal is read.
    workers: Vec<Box<dyn Worker>>,
    journal: Journal,
    finished: Option<Arc<Finished>>,
    shard: Option<Shard>,
    /// How many points all sets have together, where that is known beforehand.
    expected: Option<u64>,
    /// Points that were asked for so far.
    asked: u64,
    /// Points computed in this run.
    computed: u64,
    progress: Progress,
    synced: Instant,
}

impl fmt::Debug for Pipeline<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Pipeline")
            .field("journal", &self.journal)
            .field("asked", &self.asked)
            .field("computed", &self.computed)
            .finish_non_exhaustive()
    }
}

impl<'a> Pipeline<'a> {
    /// A pipeline that notes points in a journal; `finished` is what that holds already.
    pub fn new(
        model: &'a dyn Model,
        workers: Vec<Box<dyn Worker>>,
        journal: Journal,
        finished: Option<Finished>,
        shard: Option<Shard>,
        points: Option<u64>,
    ) -> Self {
        let expected = points.map(|points| shard.unwrap_or(Shard::WHOLE).count(points));
        let before = finished.as_ref().map_or(0, |finished| finished.count);
        let progress = Progress::new(expected, before);
        Self {
            model,
            workers,
            journal,
            finished: finished.map(Arc::new),
            shard,
            expected,
            asked: 0,
            computed: 0,
            progress,
            synced: Instant::now(),
        }
    }

    /// How many points this run has computed.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// How many points are done, in this run or before.
    pub fn done(&self) -> u64 {
        self.computed + self.finished.as_ref().map_or(0, |finished| finished.count)
    }

    /// What the journal held when this run began.
    pub fn finished(&self) -> Option<Arc<Finished>> {
        self.finished.clone()
    }

    /// Says how far the analysis has got, beside the number of points.
    pub fn say(&self, text: String) {
        self.progress.say(text);
    }

    /// The reason to give when Ctrl-C has ended the run.
    pub fn interrupted(&self) -> Halt {
        Halt::Interrupted {
            done: self.done(),
            of: self.expected,
        }
    }

    /// Runs jobs. Each outcome goes to the journal, and then to `receive` with whether it meets all criteria, in
    /// the order in which points finish. Ends early with Ctrl-C and where `receive` breaks.
    ///
    /// # Errors
    /// When a worker is lost, and when the journal cannot be written.
    pub fn compute(
        &mut self,
        jobs: impl Iterator<Item = Job> + Send,
        mut receive: impl FnMut(u64, Outcome, bool) -> ControlFlow<()>,
    ) -> Result<(), Halt> {
        let Self {
            model,
            workers,
            journal,
            computed,
            progress,
            synced,
            ..
        } = self;
        let result = engine::run(workers, jobs, stop::flag(), |event| {
            let (index, answer) = match event {
                Event::Answer(index, answer) => (index, answer),
                Event::Idle => {
                    settle(journal, synced)?;
                    return Ok(ControlFlow::Continue(()));
                }
            };
            let outcome = model.outcome(answer);
            journal.append(index, &outcome)?;
            *computed += 1;
            let verified = model.is_verified(&outcome);
            progress.step(verified, outcome.is_err());
            Ok::<_, Halt>(receive(index, outcome, verified))
        });
        result?;
        Ok(settle(journal, synced)?)
    }

    /// The outcomes of a set of points, given in the study's units. What the journal knows is read from it, all
    /// else is computed.
    ///
    /// # Errors
    /// When not all points have an outcome: see [`Halt`].
    pub fn ask(&mut self, points: &[Vec<f64>]) -> Result<Vec<Outcome>, Halt> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let first = self.asked;
        self.asked += points.len() as u64;
        self.begin_set(first, points)?;
        let mut outcomes = self.known(first, points.len())?;
        let shard = self.shard.unwrap_or(Shard::WHOLE);
        let open: Vec<usize> = (0..points.len())
            .filter(|&k| outcomes[k].is_none() && shard.has(first + k as u64))
            .collect();
        if !open.is_empty() {
            if self.workers.is_empty() {
                return Err(Halt::Missing {
                    missing: open.len() as u64,
                    of: points.len() as u64,
                });
            }
            let jobs: Vec<Job> = open.iter().map(|&k| self.job(first, points, k)).collect();
            let mut left = open.len();
            self.compute(jobs.into_iter(), |index, outcome, _| {
                let place = usize::try_from(index - first).ok();
                if let Some(place) = place.and_then(|place| outcomes.get_mut(place)) {
                    *place = Some(outcome);
                    left -= 1;
                }
                ControlFlow::Continue(())
            })?;
            if left > 0 {
                return Err(self.interrupted());
            }
        }
        let complete: Option<Vec<Outcome>> = outcomes.into_iter().collect();
        complete.ok_or_else(|| Halt::Shard(self.done()))
    }

    fn job(&self, first: u64, points: &[Vec<f64>], place: usize) -> Job {
        Job {
            index: first + place as u64,
            values: self.model.values(&points[place]),
        }
    }

    /// The outcomes that the journal knows of the set that begins with this index.
    fn known(&self, first: u64, count: usize) -> Result<Vec<Option<Outcome>>, Halt> {
        let Some(finished) = &self.finished else {
            return Ok(vec![None; count]);
        };
        let mut outcomes = finished.outcomes()?;
        let known = (0..count as u64).map(|k| Ok(outcomes.get(first + k)?));
        known.collect()
    }

    /// Notes which points a set has. Where the journal has answers for other points, these count no more: a search
    /// that ended in time may go another way when there is more of it.
    fn begin_set(&mut self, first: u64, points: &[Vec<f64>]) -> Result<(), Halt> {
        let sum = checksum(points);
        if let Some(finished) = self.finished.as_mut().and_then(Arc::get_mut) {
            match finished.sets.get(&first) {
                Some(then) if *then == sum => return Ok(()),
                Some(_) => finished.forget_from(first),
                None => {}
            }
        }
        Ok(self.journal.append_set(first, &sum)?)
    }

    /// Ends the run: everything is on the disk, and the journal says that the analysis needs no further points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn end(mut self) -> Result<(), ResultsError> {
        self.progress.finish();
        self.journal.append_end();
        self.journal.sync()
    }

    /// Ends a run that may need further points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn pause(mut self) -> Result<(), ResultsError> {
        self.progress.finish();
        self.journal.sync()
    }
}

/// Hands everything to the operating system, so that it survives the end of this process; now and then to the disk.
fn settle(journal: &mut Journal, synced: &mut Instant) -> Result<(), ResultsError> {
    const OFTEN: Duration = Duration::from_secs(5);
    if synced.elapsed() > OFTEN {
        *synced = Instant::now();
        journal.sync()
    } else {
        journal.flush()
    }
}

/// What tells a set of points from another one: their number and a checksum of all their digits.
fn checksum(points: &[Vec<f64>]) -> String {
    let mut sum = crc32fast::Hasher::new();
    for value in points.iter().flatten() {
        sum.update(&value.to_bits().to_le_bytes());
    }
    format!("{} {:08x}", points.len(), sum.finalize())
}
