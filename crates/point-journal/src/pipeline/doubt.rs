//! Points of an earlier part of the run that shared processes.
//!
//! A killed run had not re-checked its last points. So some of them are computed again before any of
//! them counts.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use super::Pipeline;
use crate::{Error, Note, Outcome};
use fmu_points::stop;
use fmu_points::{Event, Isolation, Job, Post, RunError, Separation, Worker};

/// So many points are audited where that takes little time: they find 95 % of the FMUs that err in 5 % of theirs.
const AUDITS: usize = 60;
/// So many are audited however long it takes, the latest ones: an effect that accumulates shows best there.
const LATEST: usize = 3;
const LITTLE: Duration = Duration::from_secs(1);

/// The state from which points of an earlier part of the run are audited.
pub(super) struct Doubt {
    auditor: Box<dyn Worker>,
    /// The points that shared processes, the latest first; not known at first.
    used: Option<Vec<u64>>,
    /// How long the audits took so far.
    spent: Duration,
}

/// A point of an index that is known.
type Known<'a> = &'a dyn Fn(u64) -> Job;

impl Doubt {
    pub(super) fn new(auditor: Box<dyn Worker>) -> Self {
        Self { auditor, used: None, spent: Duration::ZERO }
    }
}

impl Pipeline<'_> {
    /// Forgets points of the journal because they shared processes: all where the user wishes none to do so, and all where
    /// one of them proves wrong. The points of a set are known; outcomes of earlier sets have been used already.
    pub(super) fn doubt_set(&mut self, set: Range<u64>, job: Known<'_>) -> Result<(), Error> {
        let Some(mut doubt) = self.doubt.take() else {
            return Ok(());
        };
        let used = self.used_before(&mut doubt);
        let within: Vec<u64> = used.iter().copied().filter(|index| set.contains(index)).collect();
        if self.are_sound(&mut doubt, &within, job)? {
            if set.end < used.iter().max().map_or(0, |last| last + 1) {
                self.doubt = Some(doubt);
            }
            return Ok(());
        }
        self.drop_used()?;
        if used.iter().any(|index| *index < set.start) && !self.wants_fresh() {
            return Err(RunError::Refuted.into());
        }
        Ok(())
    }

    fn wants_fresh(&self) -> bool {
        self.crew.is_some_and(|crew| crew.wish() == Isolation::Fresh)
    }

    /// The points that shared processes before this run began, the latest first.
    fn used_before(&self, doubt: &mut Doubt) -> Vec<u64> {
        let finished = self.finished.as_ref();
        let find = || finished.map_or_else(Vec::new, |finished| finished.latest_used());
        doubt.used.get_or_insert_with(find).clone()
    }

    /// Whether points count that shared processes, as far as some of them tell.
    fn are_sound(&mut self, doubt: &mut Doubt, points: &[u64], job: Known<'_>) -> Result<bool, Error> {
        match self.crew.map(|crew| crew.wish()) {
            _ if points.is_empty() => Ok(true),
            Some(Isolation::Fresh) => Ok(false),
            Some(Isolation::Audited) => self.agree(doubt, points, job),
            _ => Ok(true),
        }
    }

    fn drop_used(&mut self) -> Result<(), Error> {
        self.journal.note(&Note::Void(Separation::Used))?;
        self.journal.flush()?;
        if let Some(finished) = &mut self.finished {
            Arc::make_mut(finished).forget_used();
            self.before = super::count_known(finished, &self.part, None);
        }
        Ok(())
    }

    /// Whether points give the same alone, as far as some of them tell.
    fn agree(&mut self, doubt: &mut Doubt, points: &[u64], job: Known<'_>) -> Result<bool, Error> {
        let (Some(crew), Some(finished)) = (self.crew, self.finished.clone()) else {
            return Ok(true);
        };
        let all = doubt.used.as_deref().unwrap_or_default();
        let latest = &all[..LATEST.min(all.len())];
        let (mut latest, mut others): (Vec<u64>, Vec<u64>) = points.iter().partition(|index| latest.contains(index));
        // Those that the seed has chosen were audited before.
        others.sort_by_cached_key(|&index| (self.repeats.has(index), self.repeats.rank(index)));
        others.truncate((AUDITS * points.len()).div_ceil(all.len()));
        let must = latest.len();
        latest.append(&mut others);
        let mut known = finished.outcomes()?;
        let stopped = || stop::flag().load(Ordering::Relaxed);
        for (number, index) in latest.into_iter().enumerate() {
            if stopped() || number >= must && doubt.spent > LITTLE {
                break;
            }
            let begun = Instant::now();
            let mut answer = None;
            let mut take = |event| {
                if let Event::Answer(_, result, _) = event {
                    answer = Some(result);
                }
                ControlFlow::Continue(())
            };
            let mut post = Post::new(&mut take, &stopped, Some(0));
            doubt.auditor.run(&[job(index)], &mut post)?;
            doubt.spent += begun.elapsed();
            let (Some(answer), Some(then)) = (answer, known.get(index)?) else {
                continue;
            };
            let now = self.model.outcome(answer.map(|result| result.values));
            let agreed = is_same(&now, &then);
            crew.note_audit(index, agreed);
            if !agreed {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

/// Whether two outcomes are results that are the same to the last bit.
fn is_same(one: &Outcome, other: &Outcome) -> bool {
    let (Ok(one), Ok(other)) = (one, other) else {
        return false;
    };
    let bits = |values: &[f64]| -> Vec<u64> { values.iter().map(|value| value.to_bits()).collect() };
    bits(one) == bits(other)
}
