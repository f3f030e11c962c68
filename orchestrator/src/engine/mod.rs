//! Runs many points on all cores.
//!
//! Points are handed to workers in batches; a worker is anything that can run a batch. Results
//! come back to the calling thread in whatever order they finish.

mod batch;
pub mod crew;
mod last_words;
pub mod local;
pub mod process;
pub mod servant;
pub mod trajectory;
mod wire;

use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

use thiserror::Error;

use crate::failure::Failure;
use batch::Batches;

/// Why a run cannot go on at all. What happens to a single point is a [`Failure`].
#[derive(Debug, Error)]
pub enum EngineError {
    /// A worker cannot be started.
    #[error("cannot start a worker: {0}")]
    Start(String),
    /// A worker was lost and cannot be replaced.
    #[error("a worker was lost: {0}")]
    Lost(String),
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

/// What happens while points run.
#[derive(Debug)]
pub enum Event {
    /// The point of this index is done.
    Answer(u64, Answer),
    /// All answers so far have been handed over; the next one is waited for.
    Idle,
}

/// Something that runs points one after another.
pub trait Worker: Send {
    /// Runs the jobs and reports each one as soon as it is done, exactly once; may stop early
    /// when `report` says so.
    ///
    /// # Errors
    /// When no further point can be run.
    fn run(
        &mut self,
        jobs: &[Job],
        report: &mut dyn FnMut(u64, Answer) -> ControlFlow<()>,
    ) -> Result<(), EngineError>;
}

/// Runs all jobs on as many workers as `workers` holds, and hands each answer to `receive` on the
/// calling thread. Setting `stop`, or a `Break` from `receive`, ends the run early; points that
/// have begun are finished.
///
/// # Errors
/// When a worker is lost, and what `receive` returns.
pub fn run<E: From<EngineError>>(
    workers: &mut [Box<dyn Worker>],
    jobs: impl Iterator<Item = Job> + Send,
    stop: &AtomicBool,
    mut receive: impl FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<(), E> {
    // Bounded, so that slow storage holds the workers back instead of filling the memory.
    const WAITING: usize = 16_384;
    let jobs = Mutex::new(Batches::new(jobs, workers.len()));
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
                    let ready = jobs
                        .lock()
                        .is_ok_and(|mut jobs| jobs.take(&pace, &mut batch));
                    if !ready || stopped() {
                        return;
                    }
                    pace.begin();
                    let result = worker.run(&batch, &mut |index, answer| {
                        let sent = send.send(Ok((index, answer)));
                        if sent.is_err() || stopped() {
                            ControlFlow::Break(())
                        } else {
                            ControlFlow::Continue(())
                        }
                    });
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
        collect(&receiver, &done, &mut receive)
    })
}

/// How long answers are gathered before they are handed over, at first and in the long run: to wake up
/// and to write costs the workers a little each time. A set of few points should not wait for it.
const GATHERING: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(8)];

/// Hands over everything that comes, until all workers have ended.
fn collect<E: From<EngineError>>(
    receiver: &Receiver<Result<(u64, Answer), EngineError>>,
    done: &AtomicBool,
    receive: &mut impl FnMut(Event) -> Result<ControlFlow<()>, E>,
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
        handle(message.map(|(index, answer)| Event::Answer(index, answer)));
    }
    outcome
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Doubles its first value; fails where that is negative.
    struct Doubling;

    impl Worker for Doubling {
        fn run(
            &mut self,
            jobs: &[Job],
            report: &mut dyn FnMut(u64, Answer) -> ControlFlow<()>,
        ) -> Result<(), EngineError> {
            for job in jobs {
                let value = job.values[0];
                let answer = if value < 0.0 {
                    Err(Failure::Timeout)
                } else {
                    Ok(vec![2.0 * value])
                };
                if report(job.index, answer).is_break() {
                    break;
                }
            }
            Ok(())
        }
    }

    fn workers(count: usize) -> Vec<Box<dyn Worker>> {
        (0..count)
            .map(|_| Box::new(Doubling) as Box<dyn Worker>)
            .collect()
    }

    #[allow(clippy::cast_precision_loss)]
    fn jobs(count: u64) -> impl Iterator<Item = Job> + Send {
        (0..count).map(|index| Job {
            index,
            values: vec![index as f64 - 3.0],
        })
    }

    #[test]
    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
    fn every_point_is_answered_once() {
        let mut seen = vec![0; 10_000];
        let stop = AtomicBool::new(false);
        run::<EngineError>(&mut workers(3), jobs(10_000), &stop, |event| {
            let Event::Answer(index, answer) = event else {
                return Ok(ControlFlow::Continue(()));
            };
            seen[index as usize] += 1;
            match answer {
                Ok(values) => assert_eq!(values[0], 2.0 * (index as f64 - 3.0)),
                Err(_) => assert!(index < 3),
            }
            Ok(ControlFlow::Continue(()))
        })
        .unwrap();
        assert!(seen.iter().all(|&count| count == 1));
    }

    #[test]
    fn a_run_ends_early_when_asked_to() {
        let stop = AtomicBool::new(false);
        let mut count = 0;
        run::<EngineError>(&mut workers(2), jobs(1_000_000), &stop, |event| {
            count += u64::from(matches!(event, Event::Answer(..)));
            Ok(if count == 10 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            })
        })
        .unwrap();
        assert!((10..900_000).contains(&count), "{count}");
    }
}
