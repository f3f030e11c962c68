//! Points that failed while others ran.
//!
//! An FMU may need what only one process can have at a time: a port, a file, the only licence. Then a point fails because
//! of another one. So when all else is done, points that failed are run again while nothing else runs. A study may have very
//! many points that fail for reasons of their own: of each kind of failure a few are repeated, and more only as
//! long as that changes something.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::points::{Event, Job, Post, RunError, Worker};

/// So many points of a kind are repeated at first; of those that took too long, one.
const FIRST: usize = 3;
/// So many kinds are told apart; further ones only by their class.
const KINDS: usize = 32;
/// The kind of points that gave results in one try and none in another.
const FICKLE: &str = "fickle";

/// Points that failed while others ran, by the kind of their failure, and the kinds that come of the points alone.
#[derive(Debug, Default)]
pub struct Company {
    failed: BTreeMap<String, BTreeSet<u64>>,
    /// These fail alone, too.
    sound: BTreeSet<String>,
    /// Points that were repeated alone in an earlier part of the run: of which kind they failed then, if they did.
    repeated: BTreeMap<u64, Option<String>>,
}

impl Company {
    /// Notes a point that failed while others ran, or gave results in one try and none in another.
    pub fn note(&mut self, index: u64, failure: Option<&Failure>) {
        let kind = match failure.map(|failure| (failure, failure.cause())) {
            None => FICKLE.to_owned(),
            // The FMU was not even asked, or would say the same of all.
            Some((_, Failure::OutOfRange(_) | Failure::Unloadable(_))) => return,
            Some((failure, _)) => {
                let kind = kind(failure);
                let many = self.failed.len() + self.sound.len() >= KINDS;
                match many && !self.failed.contains_key(&kind) {
                    true => failure.class().to_owned(),
                    false => kind,
                }
            }
        };
        if !self.sound.contains(&kind) {
            self.failed.entry(kind).or_default().insert(index);
        }
    }

    /// Notes what came of a point that an earlier part of the run has repeated alone: it does not come again.
    pub fn recall(&mut self, index: u64, failure: Option<&Failure>) {
        self.repeated.insert(index, failure.map(kind));
    }

    /// Notes what happened while others ran.
    pub(crate) fn heed(&mut self, event: &Event) {
        match event {
            Event::Answer(index, answer, _) => {
                let known = self.failed.iter_mut().filter(|(kind, _)| *kind != FICKLE);
                known.for_each(|(_, points)| {
                    points.remove(index);
                });
                if let Err(failure) = answer {
                    self.note(*index, Some(failure));
                }
            }
            Event::Fickle(index) => self.note(*index, None),
            _ => {}
        }
    }

    /// Whether no point is to be repeated.
    pub fn is_settled(&self) -> bool {
        self.failed.values().all(BTreeSet::is_empty)
    }

    /// Repeats points one by one while nothing else runs; whether that was ended early.
    pub(crate) fn settle<E: From<RunError>>(
        &mut self,
        workers: &mut [Box<dyn Worker>],
        job: &(dyn Fn(u64) -> Job + Sync),
        stop: &AtomicBool,
        receive: &mut dyn FnMut(Event) -> Result<ControlFlow<()>, E>,
    ) -> Result<bool, E> {
        let stopped = || stop.load(Ordering::Relaxed);
        workers.iter_mut().for_each(|worker| worker.rest());
        let Some(worker) = workers.first_mut() else {
            return Ok(true);
        };
        let mut over = receive(Event::Alone)?.is_break();
        for (kind, points) in std::mem::take(&mut self.failed) {
            let mut open: Vec<u64> = points.into_iter().collect();
            let mut count = if kind == Failure::Timeout.class() { 1 } else { FIRST };
            loop {
                let mut changed = false;
                for index in spread(&mut open, count) {
                    if let Some(known) = self.repeated.remove(&index) {
                        changed |= kind != FICKLE && known.as_ref() != Some(&kind);
                        continue;
                    }
                    let mut outcome = Ok(());
                    let mut take = |event| {
                        if let Event::Answer(_, answer, _) = &event {
                            let same = |failure| self::kind(failure) == kind;
                            changed |= kind != FICKLE && !answer.as_ref().is_err_and(same);
                        }
                        match receive(event) {
                            Ok(flow) => {
                                over |= flow.is_break();
                                flow
                            }
                            Err(error) => {
                                outcome = Err(error);
                                ControlFlow::Break(())
                            }
                        }
                    };
                    worker.run_alone(&job(index), &mut Post::new(&mut take, &stopped, None))?;
                    outcome?;
                    if over || stopped() {
                        return Ok(true);
                    }
                }
                if !changed {
                    break;
                }
                count *= 2;
            }
            self.sound.insert(kind);
        }
        Ok(receive(Event::Settled)?.is_break())
    }
}

/// Takes some of the points, evenly spread.
fn spread(points: &mut Vec<u64>, count: usize) -> Vec<u64> {
    let step = points.len().div_ceil(count.max(1)).max(1);
    let chosen: Vec<u64> = points.iter().copied().step_by(step).collect();
    let mut place = 0;
    points.retain(|_| {
        place += 1;
        (place - 1) % step != 0
    });
    chosen
}

/// Failures with the same words are of one kind, whatever numbers stand in them.
fn kind(failure: &Failure) -> String {
    const ENOUGH: usize = 80;
    let text = failure.cause().to_string();
    let words = text.chars().filter(|letter| !letter.is_ascii_digit());
    words.take(ENOUGH).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conduct::Separation;

    type Again = (u64, Option<Failure>);

    /// Alone, the points below this number fail for a reason of their own.
    struct Shy(u64);

    impl Worker for Shy {
        fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
            for job in jobs {
                post.send(answer(job.index, self.0, 0));
            }
            Ok(())
        }
    }

    /// Points below `failing` fail, and others below `crowded` while others run.
    fn answer(index: u64, failing: u64, crowded: u64) -> Event {
        let answer = match index {
            index if index < failing => Err(Failure::Error(format!("{index} is too large"))),
            index if index < crowded => Err(Failure::Error(format!("port {index} in use"))),
            _ => Ok(vec![1.0].into()),
        };
        Event::Answer(index, answer, Separation::New)
    }

    /// How many points came again, and how many of them passed.
    fn repeated(failing: u64, crowded: u64) -> (usize, usize) {
        let again = settled(failing, crowded, &[]);
        let passed = again.iter().filter(|(_, failure)| failure.is_none());
        (again.len(), passed.count())
    }

    /// The points that come again, in their order, and why they fail alone; an earlier part of the run has repeated some.
    fn settled(failing: u64, crowded: u64, before: &[Again]) -> Vec<Again> {
        let mut company = Company::default();
        (0..crowded + 10).for_each(|index| company.heed(&answer(index, failing, crowded)));
        for (index, failure) in before {
            company.recall(*index, failure.as_ref());
        }
        let mut workers: Vec<Box<dyn Worker>> = vec![Box::new(Shy(failing))];
        let job = |index| Job { index, values: Vec::new() };
        let mut again = Vec::new();
        let never = AtomicBool::new(false);
        let over = company.settle::<RunError>(&mut workers, &job, &never, &mut |event| {
            if let Event::Answer(index, answer, _) = event {
                again.push((index, answer.err()));
            }
            Ok(ControlFlow::Continue(()))
        });
        assert!(!over.unwrap() && company.is_settled());
        // What is known of a kind is not tried again.
        company.heed(&answer(0, failing, crowded));
        assert!(company.is_settled());
        again
    }

    /// Wherever the repetition was interrupted, what follows is what would have followed.
    #[test]
    fn what_was_repeated_before_does_not_come_again() {
        for (failing, crowded) in [(0, 30), (30, 30), (10, 40)] {
            let whole = settled(failing, crowded, &[]);
            for begun in 0..=whole.len() {
                let (before, after) = whole.split_at(begun);
                assert_eq!(settled(failing, crowded, before), after, "{failing} {crowded}");
            }
        }
    }

    #[test]
    fn all_come_again_that_pass_alone_and_few_that_do_not() {
        assert_eq!(repeated(0, 100), (100, 100));
        assert_eq!(repeated(100_000, 100_000), (FIRST, 0));
        assert_eq!(repeated(5000, 5100), (FIRST + 100, 100));
    }
}
