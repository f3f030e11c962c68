//! Runs points, for every analysis in the same way.
//!
//! An analysis is a set of points, or several sets one after the other, where a later one may depend on what came
//! of the earlier ones. What is in the journal is read, what is not is computed and noted at once. So a run that
//! was interrupted is simply begun again: the same analysis asks for the same points, and the journal answers
//! those that it knows.

mod again;
pub mod folder;
mod progress;
mod shard;

use std::{
    collections::{BTreeMap, HashMap},
    ops::{ControlFlow, Range},
    sync::Arc,
    time::{Duration, Instant},
};

use crate::{Error, Finished, Journal, Note, PointOutcome, Result};
use again::{Again, JobOfIndex};
use fmu_points::{Conduct, Event, Isolation, Job, PointResult, Worker, crew::Crew, notices::Notices, stop, task::Case};
use progress::Progress;

pub use again::difference;
pub use shard::{Shard, ShardPart};

/// Points of one model in the units of the study.
pub trait Model {
    /// A point in the FMU's units.
    fn values(&self, point: &[f64]) -> Vec<f64>;

    /// An answer of the FMU in the study's units.
    fn outcome(&self, answer: PointResult) -> PointOutcome;

    /// Whether the outcome meets all criteria.
    fn is_verified(&self, outcome: &PointOutcome) -> bool;
}

/// Hands points to the workers, and writes every outcome into the journal.
pub struct Pipeline<'a> {
    model: &'a dyn Model,
    /// Knows how the points are computed.
    crew: &'a Crew,
    workers: Vec<Box<dyn Worker>>,
    /// Points that will run again at the end.
    again: Again,
    journal: Journal,
    finished: Option<Arc<Finished>>,
    /// How the points were computed, as far as the journal says it.
    noted: Option<Conduct>,
    /// How many points all sets have together, where that is known beforehand.
    expected: Option<u64>,
    /// Points that were asked for so far.
    asked: u64,
    /// Points computed in this run.
    computed: u64,
    /// Points that earlier runs computed.
    before: u64,
    /// Warnings in points of which the next event is that they failed.
    said: HashMap<u64, Box<Notices>>,
    progress: Progress,
    synced: Instant,
}

impl<'a> Pipeline<'a> {
    /// A pipeline that notes points in a journal; `finished` is what that holds already.
    pub fn new(
        model: &'a dyn Model,
        (crew, cases): (&'a Crew, &[Case]),
        journal: Journal,
        finished: Option<Finished>,
        part: ShardPart,
    ) -> Self {
        let expected = part.count();
        let before =
            finished.as_ref().map_or(0, |finished| finished.points().filter(|index| part.has(*index)).count() as u64);
        let progress = Progress::new(expected, before);
        if let Some(file) = finished.as_ref().and_then(Finished::changed_file) {
            crew.part(file);
        }
        Self {
            model,
            crew,
            again: Again::new(cases),
            workers: crew.workers(cases),
            journal,
            finished: finished.map(Arc::new),
            noted: None,
            expected,
            asked: 0,
            computed: 0,
            before,
            said: HashMap::new(),
            progress,
            synced: Instant::now(),
        }
    }

    /// No more points than this run a second time at the end.
    pub fn repeat_at_most(&mut self, points: usize) {
        self.again.most = points;
    }

    /// How many points this run has computed.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// How many points the analysis has asked for, in this run and before.
    pub fn asked(&self) -> u64 {
        self.asked
    }

    /// How many points each host has answered, where they ran on other machines.
    pub fn answered(&self) -> BTreeMap<String, u64> {
        self.crew.answered()
    }

    /// How many points are done, in this run or before.
    pub fn done(&self) -> u64 {
        self.computed + self.before
    }

    /// The content of the journal when this run began.
    pub fn finished(&self) -> Option<Arc<Finished>> {
        self.finished.clone()
    }

    /// Says how far the analysis has got, beside the number of points.
    pub fn say(&self, text: String) {
        self.progress.say(text);
    }

    /// The reason to give when Ctrl-C has ended the run.
    pub fn interrupted(&self) -> Error {
        Error::Interrupted { done: self.done(), of: self.expected }
    }

    /// Runs the points `open`, which `job` makes of their indexes. Each outcome goes to the journal and then to
    /// `receive`, in the order in which points finish. Ends early with Ctrl-C and where `receive` breaks.
    ///
    /// # Errors
    /// When no worker can be started, and when the journal cannot be written.
    pub fn compute(
        &mut self,
        open: impl Iterator<Item = u64> + Send,
        job: &(dyn Fn(u64) -> Job + Sync),
        receive: impl FnMut(u64, PointOutcome) -> ControlFlow<()>,
    ) -> Result {
        self.recall(0..u64::MAX, job)?;
        self.run(open, job, receive)
    }

    /// The same without points that an earlier part of the run has recorded.
    fn run(
        &mut self,
        open: impl Iterator<Item = u64> + Send,
        job: &(dyn Fn(u64) -> Job + Sync),
        mut receive: impl FnMut(u64, PointOutcome) -> ControlFlow<()>,
    ) -> Result {
        // Points that share processes are known from the beginning, even if the run is killed.
        if self.crew.conduct().isolation != Isolation::Fresh {
            self.note_conduct()?;
        }
        let mut workers = std::mem::take(&mut self.workers);
        let result = fmu_points::run(&mut workers, open, job, stop::flag(), |event| {
            Ok::<_, Error>(match self.take(event, job)? {
                Some((index, outcome)) => receive(index, outcome),
                None => ControlFlow::Continue(()),
            })
        });
        self.workers = workers;
        result?;
        self.settle()
    }

    /// Chooses some of the first points `of` these that an earlier part of the run has recorded: they run again at the end.
    fn recall(&mut self, of: Range<u64>, job: JobOfIndex) -> Result {
        let Some(finished) = self.finished.clone() else { return Ok(()) };
        let mut outcomes = finished.outcomes()?;
        for index in finished.points().filter(|index| of.contains(index)).take(again::EARLIER) {
            if let Some(outcome) = outcomes.get(index)? {
                self.again.recall(job(index), outcome);
            }
        }
        Ok(())
    }

    /// Notes an event in the journal; the point that is done, if one is.
    fn take(&mut self, event: Event, job: JobOfIndex) -> Result<Option<(u64, PointOutcome)>> {
        Ok(match event {
            Event::Answer(index, mut answer) => {
                let result = answer.as_mut().ok();
                let said = result.and_then(|result| result.notices.take());
                let mut notices = self.said.remove(&index).or(said);
                // A point beside which none runs can hold what it likes.
                if let (Some(notices), 1) = (&mut notices, self.crew.size()) {
                    notices.held = None;
                }
                let outcome = self.model.outcome(answer.map(|result| result.values));
                self.journal.append(index, &outcome, notices.as_deref())?;
                self.computed += 1;
                self.again.note(self.crew, index, &outcome, job);
                self.progress.step(self.model.is_verified(&outcome), outcome.is_err(), || self.crew.answered());
                Some((index, outcome))
            }
            Event::Said(index, notices) => {
                self.said.insert(index, notices);
                None
            }
            Event::Idle => {
                self.settle()?;
                None
            }
        })
    }

    /// Hands everything to the operating system, so that it survives the end of this process; now and then to the
    /// disk.
    fn settle(&mut self) -> Result {
        const OFTEN: Duration = Duration::from_secs(5);
        if self.synced.elapsed() < OFTEN {
            return self.journal.flush();
        }
        self.synced = Instant::now();
        self.note_conduct()?;
        self.journal.sync()
    }

    /// Notes how the points were computed.
    fn note_conduct(&mut self) -> Result {
        let conduct = self.again.told(self.crew.conduct());
        if self.noted.replace(conduct.clone()).as_ref() == Some(&conduct) {
            return Ok(());
        }
        self.journal.note(&Note::Conduct(conduct))
    }

    /// The outcomes of a set of points, given in the study's units. What the journal knows is read from it, all
    /// else is computed.
    ///
    /// # Errors
    /// When not all points have an outcome: see [`Error`].
    pub fn ask(&mut self, points: &[Vec<f64>]) -> Result<Vec<PointOutcome>> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let first = self.asked;
        self.asked += points.len() as u64;
        self.begin_set(first, points)?;
        let mut outcomes = self.known(first, points.len())?;
        let open: Vec<usize> = (0..points.len()).filter(|&k| outcomes[k].is_none()).collect();
        if !open.is_empty() {
            self.fill(first, points, &open, &mut outcomes)?;
        }
        outcomes.into_iter().collect::<Option<_>>().ok_or_else(|| self.interrupted())
    }

    /// The outcomes of points whose simulations are others, each in a new process; the journal does not have them.
    ///
    /// # Errors
    /// When no worker can be started, and when Ctrl-C has ended the run.
    pub fn apart(&self, cases: &[Case], points: &[Vec<f64>]) -> Result<Vec<PointOutcome>> {
        let size = self.crew.size().min(points.len());
        let mut workers: Vec<_> = (0..size).map(|_| self.crew.worker(cases)).collect();
        let values: Vec<Vec<f64>> = points.iter().map(|point| self.model.values(point)).collect();
        let job = |index: u64| Job { index, values: values[index as usize].clone() };
        let mut outcomes = vec![None; points.len()];
        fmu_points::run(&mut workers, 0..points.len() as u64, &job, stop::flag(), |event| {
            if let Event::Answer(index, answer) = event {
                outcomes[index as usize] = Some(self.model.outcome(answer.map(|result| result.values)));
            }
            Ok::<_, Error>(ControlFlow::Continue(()))
        })?;
        outcomes.into_iter().collect::<Option<_>>().ok_or_else(|| self.interrupted())
    }

    /// Computes the open points of a set.
    fn fill(
        &mut self,
        first: u64,
        points: &[Vec<f64>],
        open: &[usize],
        outcomes: &mut [Option<PointOutcome>],
    ) -> Result {
        let model = self.model;
        let values: Vec<Vec<f64>> = points.iter().map(|point| model.values(point)).collect();
        let job = |index: u64| Job { index, values: values[(index - first) as usize].clone() };
        let open: Vec<u64> = open.iter().map(|&k| first + k as u64).collect();
        // Of other sets nobody has the points here.
        self.recall(first..first + points.len() as u64, &job)?;
        self.run(open.into_iter(), &job, |index, outcome| {
            outcomes[(index - first) as usize] = Some(outcome);
            ControlFlow::Continue(())
        })
    }

    /// The outcomes that the journal knows of the set that begins with this index.
    fn known(&self, first: u64, count: usize) -> Result<Vec<Option<PointOutcome>>> {
        let Some(finished) = &self.finished else { return Ok(vec![None; count]) };
        let mut outcomes = finished.outcomes()?;
        (0..count as u64).map(|k| outcomes.get(first + k)).collect()
    }

    /// Notes which points a set has. Where the journal has answers for other points, these count no more: a search
    /// that ended in time may go another way when there is more of it.
    fn begin_set(&mut self, first: u64, points: &[Vec<f64>]) -> Result {
        let sum = checksum(points);
        if let Some(finished) = &mut self.finished {
            if finished.sets.get(&first) == Some(&sum) {
                self.journal.hold_set(first, &sum);
                return Ok(());
            }
            Arc::make_mut(finished).begin_set(first, &sum);
        }
        self.journal.append_set(first, &sum)
    }

    /// Ends the run: everything is on the disk, and the journal says that the analysis needs no further points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn end(mut self) -> Result {
        self.journal.append_end();
        self.pause()
    }

    /// Ends a run that may need further points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn pause(mut self) -> Result {
        self.again.run(self.crew, self.model)?;
        self.progress.finish();
        self.note_conduct()?;
        self.journal.sync()
    }
}

/// Identifies a set of points: their number and a checksum of all their digits.
fn checksum(points: &[Vec<f64>]) -> String {
    let mut sum = crc32fast::Hasher::new();
    for value in points.iter().flatten() {
        sum.update(&value.to_bits().to_le_bytes());
    }
    format!("{} {:08x}", points.len(), sum.finalize())
}
