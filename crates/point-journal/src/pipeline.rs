//! Runs points, for every analysis in the same way.
//!
//! An analysis is a set of points, or several sets one after the other, where a later one may depend on what came
//! of the earlier ones. What is in the journal is read, what is not is computed and noted at once. So a run that
//! was interrupted is simply begun again: the same analysis asks for the same points, and the journal answers
//! those that it knows.

mod doubt;
pub mod folder;
mod progress;
mod shard;

use std::collections::{BTreeMap, HashMap};
use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::{Error, Finished, Journal, Note, Outcome};
use doubt::Doubt;
use fmu_points::crew::Crew;
use fmu_points::notices::Notices;
use fmu_points::repeats::Repeats;
use fmu_points::task::Case;
use fmu_points::{Answer, Company, Conduct, Event, Isolation, Job, RunError, Separation, Worker, stop};
use progress::Progress;

pub use shard::{Part, Shard};

/// Points of one model in the units of the study.
pub trait Model {
    /// A point in the FMU's units.
    fn values(&self, point: &[f64]) -> Vec<f64>;

    /// An answer of the FMU in the study's units.
    fn outcome(&self, answer: Answer) -> Outcome;

    /// Whether the outcome meets all criteria.
    fn is_verified(&self, outcome: &Outcome) -> bool;
}

/// So many audits are noted at once, further ones with the next sync.
const MANY: u64 = 200;

/// An event of a run for the analysis that asked for its points.
#[derive(Debug)]
pub enum Step {
    /// A point is done.
    Outcome {
        /// The point's index.
        index: u64,
        /// Its values in the study's units, or its failure.
        outcome: Outcome,
        /// The process in which it was computed.
        separation: Separation,
    },
    /// Outcomes from such processes, or from less strictly separated ones, count no more; they come again.
    Void(Separation),
}

/// Hands points to the workers, and writes every outcome into the journal.
pub struct Pipeline<'a> {
    model: &'a dyn Model,
    /// Knows how the points are computed; absent where only the journal is read.
    crew: Option<&'a Crew>,
    workers: Vec<Box<dyn Worker>>,
    /// For audits of points of earlier runs, until these are done.
    doubt: Option<Doubt>,
    /// The points that are computed twice in any case.
    repeats: Repeats,
    /// How the points were computed, as far as the journal says it.
    noted: Option<Conduct>,
    journal: Journal,
    finished: Option<Arc<Finished>>,
    part: Part,
    /// How many points all sets have together, where that is known beforehand.
    expected: Option<u64>,
    /// Points that were asked for so far.
    asked: u64,
    /// Points computed in this run, by the process in which they were computed.
    computed: [u64; Separation::COUNT],
    /// Points that earlier runs computed.
    before: u64,
    /// Points that failed while others ran.
    company: Company,
    /// How many were repeated alone so far, and how many of these passed; none while others run.
    alone: Option<[u64; 2]>,
    /// How many an earlier part of the run has repeated so without telling it, and how many of these passed.
    alone_before: [u64; 2],
    /// Warnings in points of which the next event is that they failed.
    said: HashMap<u64, Box<Notices>>,
    progress: Progress,
    synced: Instant,
}

impl<'a> Pipeline<'a> {
    /// A pipeline that notes points in a journal; `finished` is what that holds already. Without a crew it only
    /// reads.
    pub fn new(
        model: &'a dyn Model,
        crew: Option<(&'a Crew, &[Case])>,
        journal: Journal,
        finished: Option<Finished>,
        part: Part,
    ) -> Self {
        let expected = part.count();
        let before = finished.as_ref().map_or(0, |finished| count_known(finished, &part, None));
        let progress = Progress::new(expected, before);
        if let Some(((crew, _), finished)) = crew.zip(finished.as_ref()) {
            finished.changed_file().into_iter().for_each(|file| crew.part(file));
            let differs = finished.conduct().reproducible == Some(false);
            crew.recall(finished.refuted, !differs);
        }
        let alone_before = finished.as_ref().map_or([0; 2], |finished| finished.alone);
        Self {
            model,
            crew: crew.map(|(crew, _)| crew),
            doubt: crew.map(|(crew, cases)| Doubt::new(crew.auditor(cases))),
            repeats: Repeats::endless(0),
            workers: crew.map_or_else(Vec::new, |(crew, cases)| crew.workers(cases)),
            noted: None,
            journal,
            finished: finished.map(Arc::new),
            part,
            expected,
            asked: 0,
            computed: [0; Separation::COUNT],
            before,
            company: Company::default(),
            alone: None,
            alone_before,
            said: HashMap::new(),
            progress,
            synced: Instant::now(),
        }
    }

    /// Lets some points be computed twice, chosen by the seed, from the first ones on where it is `open` how many points
    /// there will be.
    pub fn repeating(mut self, seed: u64, open: bool) -> Self {
        self.repeats = match self.part.count() {
            Some(count) if !open => Repeats::among(seed, count, (0..).filter(|&k| self.part.has(k))),
            _ => Repeats::endless(seed),
        };
        if let Some(crew) = self.crew {
            crew.repeat(&self.repeats);
        }
        self
    }

    /// How many points this run has computed.
    pub fn computed(&self) -> u64 {
        self.computed.iter().sum()
    }

    /// How many points each host has answered, where they ran on other machines.
    pub fn answered(&self) -> BTreeMap<String, u64> {
        self.crew.map_or_else(BTreeMap::new, Crew::answered)
    }

    /// How many points are done, in this run or before.
    pub fn done(&self) -> u64 {
        self.computed() + self.before
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

    /// Audits points of earlier runs that shared processes, all of which `job` must know. Where these processes changed the
    /// results, the points are open again.
    ///
    /// # Errors
    /// When no worker can be started, and when the journal cannot be written.
    pub fn doubt(&mut self, job: &(dyn Fn(u64) -> Job + Sync)) -> Result<(), Error> {
        let every = 0..u64::MAX;
        self.doubt_set(every, job)
    }

    /// Reads the journal again: points that count no more are open from here on.
    ///
    /// # Errors
    /// When the journal cannot be written or read.
    pub fn read_again(&mut self) -> Result<(), Error> {
        self.journal.flush()?;
        let finished = Finished::read(self.journal.folder())?;
        let known = count_known(&finished, &self.part, None);
        self.before = known.saturating_sub(self.computed());
        self.finished = Some(Arc::new(finished));
        Ok(())
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
        receive: impl FnMut(Step) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        let finished = self.finished.clone();
        self.note_crowded(0..u64::MAX)?;
        let earlier = |separation| {
            let finished = finished.as_ref();
            finished.map_or_else(Vec::new, |finished| finished.of(separation))
        };
        self.run(open, job, &earlier, receive)
    }

    /// Notes the points of a set that failed in an earlier part of the run, while others ran; whether there are any.
    fn note_crowded(&mut self, set: Range<u64>) -> Result<bool, Error> {
        if let Some(finished) = &self.finished {
            let mut outcomes = finished.outcomes()?;
            for index in finished.crowded().filter(|index| set.contains(index)) {
                if let Some(answer) = outcomes.first(index)? {
                    self.company.note(index, answer.as_ref().err());
                }
                if finished.was_repeated(index)
                    && let Some(alone) = outcomes.get(index)?
                {
                    self.company.recall(index, alone.as_ref().err());
                }
            }
        }
        Ok(!self.company.is_settled())
    }

    fn run(
        &mut self,
        open: impl Iterator<Item = u64> + Send,
        job: &(dyn Fn(u64) -> Job + Sync),
        earlier: &dyn Fn(Separation) -> Vec<u64>,
        mut receive: impl FnMut(Step) -> ControlFlow<()>,
    ) -> Result<(), Error> {
        // Points that share processes without audits are known from the beginning, even if the run is killed.
        let conduct = self.crew.map(|crew| crew.conduct().isolation);
        if let Some(Isolation::InProcess | Isolation::Reuse) = conduct {
            self.note_conduct()?;
        }
        let mut workers = std::mem::take(&mut self.workers);
        let mut company = std::mem::take(&mut self.company);
        let open_ended = &mut company;
        let flag = stop::flag();
        let result = fmu_points::run(&mut workers, open, job, earlier, open_ended, flag, |event| {
            Ok::<_, Error>(match self.take(event)? {
                Some(step) => receive(step),
                None => ControlFlow::Continue(()),
            })
        });
        self.workers = workers;
        self.company = company;
        let ended_alone = self.alone.take().is_some();
        result?;
        self.settle()?;
        if flag.load(Ordering::Relaxed) && (ended_alone || !self.company.is_settled()) {
            // All points may be there, but not as they will be.
            self.note_conduct()?;
            self.journal.flush()?;
            return Err(self.interrupted());
        }
        Ok(())
    }

    /// Notes an event in the journal.
    fn take(&mut self, event: Event) -> Result<Option<Step>, Error> {
        Ok(match event {
            Event::Answer(index, mut answer, separation) => {
                let result = answer.as_mut().ok();
                let said = result.and_then(|result| result.notices.take());
                let notices = self.said.remove(&index).or(said);
                let outcome = self.model.outcome(answer.map(|result| result.values));
                let notices = notices.as_deref();
                self.journal.append(index, &outcome, separation, notices)?;
                let verified = self.model.is_verified(&outcome);
                if let Some([repeated, passed]) = &mut self.alone {
                    // It was counted before.
                    *repeated += 1;
                    *passed += u64::from(outcome.is_ok());
                } else {
                    if outcome.is_err() && self.crew.is_some_and(|crew| crew.size() > 1) {
                        self.journal.note(&Note::Crowded(index))?;
                    }
                    self.computed[separation as usize] += 1;
                    let answered = || self.crew.map_or_else(BTreeMap::new, Crew::answered);
                    self.progress.step(verified, outcome.is_err(), answered);
                }
                Some(Step::Outcome { index, outcome, separation })
            }
            Event::Void(separation) => {
                self.journal.note(&Note::Void(separation))?;
                if separation <= Separation::New {
                    // Neither do the audits of earlier points.
                    self.noted = None;
                }
                self.note_conduct()?;
                self.computed[separation as usize..].fill(0);
                let finished = self.finished.as_ref();
                let left = finished.map_or(0, |finished| count_known(finished, &self.part, Some(separation)));
                self.before = self.before.min(left);
                Some(Step::Void(separation))
            }
            Event::Said(index, notices) => {
                self.said.insert(index, notices);
                None
            }
            Event::Fickle(index) => {
                self.journal.note(&Note::Crowded(index))?;
                None
            }
            Event::Alone => {
                self.alone = Some(std::mem::take(&mut self.alone_before));
                None
            }
            Event::Settled => {
                let [repeated, passed] = self.alone.take().unwrap_or_default();
                self.journal.note(&Note::Settled { repeated, passed })?;
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
    fn settle(&mut self) -> Result<(), Error> {
        const OFTEN: Duration = Duration::from_secs(5);
        if self.synced.elapsed() < OFTEN {
            self.note_audits()?;
            return self.journal.flush();
        }
        self.synced = Instant::now();
        self.note_conduct()?;
        self.journal.sync()
    }

    /// Notes the first audits at once: a run that is killed must not forget them.
    fn note_audits(&mut self) -> Result<(), Error> {
        let audits = |conduct: &Conduct| (conduct.audits, conduct.audit_mismatches);
        let now = self.crew.map_or((0, 0), |crew| audits(&crew.conduct()));
        let noted = self.noted.as_ref().map_or((0, 0), audits);
        if now == noted || noted.0 > MANY {
            return Ok(());
        }
        self.note_conduct()
    }

    /// Notes how the points since the last such note were computed.
    fn note_conduct(&mut self) -> Result<(), Error> {
        let Some(crew) = self.crew else {
            return Ok(());
        };
        let conduct = crew.conduct();
        let before = self.noted.replace(conduct.clone());
        let since = conduct.since(before.as_ref());
        self.journal.note(&Note::Conduct(since))
    }

    /// The outcomes of a set of points, given in the study's units. What the journal knows is read from it, all
    /// else is computed.
    ///
    /// # Errors
    /// When not all points have an outcome: see [`Error`].
    pub fn ask(&mut self, points: &[Vec<f64>]) -> Result<Vec<Outcome>, Error> {
        if points.is_empty() {
            return Ok(Vec::new());
        }
        let first = self.asked;
        self.asked += points.len() as u64;
        self.begin_set(first, points)?;
        let model = self.model;
        let job = |index: u64| Job { index, values: model.values(&points[(index - first) as usize]) };
        self.doubt_set(first..self.asked, &job)?;
        let mut outcomes = self.known(first, points.len())?;
        let open: Vec<usize> =
            (0..points.len()).filter(|&k| outcomes[k].is_none() && self.part.has(first + k as u64)).collect();
        let crowded = !self.workers.is_empty() && self.note_crowded(first..self.asked)?;
        if crowded || !open.is_empty() {
            if self.workers.is_empty() {
                return Err(Error::Unknown { missing: open.len() as u64, of: points.len() as u64 });
            }
            self.fill(first, points, &open, &mut outcomes)?;
            if open.iter().any(|&k| outcomes[k].is_none()) {
                return Err(self.interrupted());
            }
        }
        let complete: Option<Vec<Outcome>> = outcomes.into_iter().collect();
        complete.ok_or_else(|| Error::Shard(self.done()))
    }

    /// The outcomes of points whose simulations are others, each in a new process; the journal does not have them. None where
    /// the FMU gives other results in every process, since theirs would tell nothing.
    ///
    /// # Errors
    /// When no worker can be started, and when Ctrl-C has ended the run.
    pub fn apart(&self, cases: &[Case], points: &[Vec<f64>]) -> Result<Option<Vec<Outcome>>, Error> {
        let reproducible = |crew: &&Crew| crew.conduct().reproducible != Some(false);
        let Some(crew) = self.crew.filter(reproducible) else {
            return Ok(None);
        };
        let size = crew.size().min(points.len());
        let mut workers: Vec<_> = (0..size).map(|_| crew.auditor(cases)).collect();
        let values = points.iter().map(|point| self.model.values(point));
        let values: Vec<Vec<f64>> = values.collect();
        let job = |index: u64| Job { index, values: values[index as usize].clone() };
        let mut outcomes = vec![None; points.len()];
        fmu_points::run(
            &mut workers,
            0..points.len() as u64,
            &job,
            &|_| Vec::new(),
            &mut Company::default(),
            stop::flag(),
            |event| {
                if let Event::Answer(index, answer, _) = event {
                    let outcome = self.model.outcome(answer.map(|result| result.values));
                    outcomes[index as usize] = Some(outcome);
                }
                Ok::<_, Error>(ControlFlow::Continue(()))
            },
        )?;
        let all: Option<Vec<Outcome>> = outcomes.into_iter().collect();
        all.map(Some).ok_or_else(|| self.interrupted())
    }

    /// Computes the open points of a set.
    fn fill(
        &mut self,
        first: u64,
        points: &[Vec<f64>],
        open: &[usize],
        outcomes: &mut [Option<Outcome>],
    ) -> Result<(), Error> {
        let model = self.model;
        let values: Vec<Vec<f64>> = points.iter().map(|point| model.values(point)).collect();
        let job = |index: u64| Job { index, values: values[(index - first) as usize].clone() };
        let finished = self.finished.clone();
        let earlier = |separation| {
            let finished = finished.as_ref();
            finished.map_or_else(Vec::new, |finished| finished.of(separation))
        };
        let set = first..first + points.len() as u64;
        let within = |separation| -> Vec<u64> {
            let mut earlier = earlier(separation);
            earlier.retain(|index| set.contains(index));
            earlier
        };
        // Outcomes of earlier sets have been used already: where they count no more, the analysis must begin again.
        let built_upon = |separation: Separation, computed: &[u64]| {
            let mut computed = computed[separation as usize..].iter();
            let is_earlier = |&index: &u64| index < first;
            earlier(separation).iter().any(is_earlier) || computed.any(|&count| count > 0)
        };
        let computed = self.computed;
        let mut spoilt = None;
        let open: Vec<u64> = open.iter().map(|&k| first + k as u64).collect();
        let mut origins = vec![None; points.len()];
        self.run(open.into_iter(), &job, &within, |step| {
            match step {
                Step::Outcome { index, outcome, separation, .. } => {
                    let place = (index - first) as usize;
                    outcomes[place] = Some(outcome);
                    origins[place] = Some(separation);
                }
                Step::Void(separation) => {
                    let error = match separation {
                        Separation::Apart | Separation::New => RunError::Disturbed,
                        Separation::Forked | Separation::Used => RunError::Refuted,
                    };
                    spoilt = spoilt.take().or(built_upon(separation, &computed).then_some(error));
                    for (outcome, origin) in outcomes.iter_mut().zip(&mut origins) {
                        if origin.is_some_and(|origin| origin >= separation) {
                            (*outcome, *origin) = (None, None);
                        }
                    }
                    for index in within(separation) {
                        outcomes[(index - first) as usize] = None;
                    }
                }
            }
            match spoilt {
                Some(_) => ControlFlow::Break(()),
                None => ControlFlow::Continue(()),
            }
        })?;
        spoilt.map_or(Ok(()), |error: RunError| Err(error.into()))
    }

    /// The outcomes that the journal knows of the set that begins with this index.
    fn known(&self, first: u64, count: usize) -> Result<Vec<Option<Outcome>>, Error> {
        let Some(finished) = &self.finished else {
            return Ok(vec![None; count]);
        };
        let mut outcomes = finished.outcomes()?;
        let known = (0..count as u64).map(|k| outcomes.get(first + k));
        known.collect()
    }

    /// Notes which points a set has. Where the journal has answers for other points, these count no more: a search
    /// that ended in time may go another way when there is more of it.
    fn begin_set(&mut self, first: u64, points: &[Vec<f64>]) -> Result<(), Error> {
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
    pub fn end(mut self) -> Result<(), Error> {
        self.journal.append_end();
        self.pause()
    }

    /// Ends a run that may need further points.
    ///
    /// # Errors
    /// When the system says no.
    pub fn pause(mut self) -> Result<(), Error> {
        self.progress.finish();
        self.note_conduct()?;
        self.journal.sync()
    }
}

/// How many points of a part a journal knows, but for those from such processes or from less strictly separated ones.
fn count_known(finished: &Finished, part: &Part, void: Option<Separation>) -> u64 {
    let of = |separation| {
        let points = finished.of(separation).into_iter();
        points.filter(|index| part.has(*index)).count() as u64
    };
    of(Separation::Apart) - void.map_or(0, of)
}

/// Identifies a set of points: their number and a checksum of all their digits.
fn checksum(points: &[Vec<f64>]) -> String {
    let mut sum = crc32fast::Hasher::new();
    for value in points.iter().flatten() {
        sum.update(&value.to_bits().to_le_bytes());
    }
    format!("{} {:08x}", points.len(), sum.finalize())
}
