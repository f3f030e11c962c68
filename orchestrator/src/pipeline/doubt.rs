//! Points of an earlier part of the run that shared processes.
//!
//! A run that was killed still owed audits for its last points. So some of them are computed again before any of
//! them counts.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use rand::seq::SliceRandom;

use super::{Halt, Pipeline, stop};
use crate::engine::{Event, Isolation, Job, Post, Separation, Worker};
use crate::results::Outcome;
use crate::results::note::Note;

/// So many points are audited where that takes little time: they find 95 % of the FMUs that err in 5 % of theirs.
const AUDITS: usize = 60;
/// So many are audited however long it takes, the latest ones: an effect that accumulates shows best there.
const LATEST: usize = 3;
const LITTLE: Duration = Duration::from_secs(1);

impl Pipeline<'_> {
    /// Points of the journal that have to be computed again, because they shared processes: all where the user wishes
    /// none to do so, and all where one of them proves wrong.
    pub(super) fn doubted(
        &mut self,
        job: Option<&(dyn Fn(u64) -> Job + Sync)>,
    ) -> Result<Vec<u64>, Halt> {
        let (Some(mut auditor), Some(crew)) = (self.auditor.take(), self.crew) else {
            return Ok(Vec::new());
        };
        let used = match &self.finished {
            Some(finished) => finished.latest_used(),
            None => Vec::new(),
        };
        let sound = match (crew.wish(), job) {
            _ if used.is_empty() => true,
            (Isolation::Fresh, _) => false,
            (Isolation::Audited, Some(job)) => self.agree(&used, auditor.as_mut(), job)?,
            _ => true,
        };
        if sound {
            return Ok(Vec::new());
        }
        self.journal.note(&Note::Void(Separation::Used))?;
        if let Some(finished) = &mut self.finished {
            Arc::make_mut(finished).forget_used();
        }
        self.before -= used.len() as u64;
        Ok(used)
    }

    /// Whether points give the same alone, as far as some of them tell.
    fn agree(
        &mut self,
        used: &[u64],
        auditor: &mut dyn Worker,
        job: &(dyn Fn(u64) -> Job + Sync),
    ) -> Result<bool, Halt> {
        let (Some(crew), Some(finished)) = (self.crew, self.finished.clone()) else {
            return Ok(true);
        };
        let (latest, others) = used.split_at(LATEST.min(used.len()));
        let mut others = others.to_vec();
        others.shuffle(&mut rand::rng());
        others.truncate(AUDITS);
        let mut known = finished.outcomes()?;
        let begun = Instant::now();
        let stopped = || stop::flag().load(Ordering::Relaxed);
        for (number, &index) in latest.iter().chain(&others).enumerate() {
            if stopped() || number >= LATEST && begun.elapsed() > LITTLE {
                break;
            }
            let mut answer = None;
            let mut take = |event| {
                if let Event::Answer(_, found, _) = event {
                    answer = Some(found);
                }
                ControlFlow::Continue(())
            };
            auditor.run(&[job(index)], &mut Post::new(&mut take, &stopped, Some(0)))?;
            let (Some(answer), Some(then)) = (answer, known.get(index)?) else {
                continue;
            };
            let now = self.model.outcome(answer.map(|found| found.values));
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
    let bits =
        |values: &[f64]| -> Vec<u64> { values.iter().map(|value| value.to_bits()).collect() };
    bits(one) == bits(other)
}
