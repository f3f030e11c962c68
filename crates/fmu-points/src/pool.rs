//! Runs many points on all cores.
//!
//! Points are handed to workers in batches; a worker is anything that can run a batch. Results come back to the
//! calling thread in whatever order they finish.

use std::{
    ops::ControlFlow,
    sync::{
        Condvar, Mutex,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, SyncSender, TryRecvError, sync_channel},
    },
    thread,
    time::{Duration, Instant},
};

use crate::{
    batch::{Batches, Pace},
    points::{Event, Job, Post, RunError, Worker},
};

/// Runs the points `open` on the workers, and hands each answer to `receive` on the calling thread. Setting `stop`,
/// or a `Break` from `receive`, ends the run early; points that have begun are given up.
///
/// # Errors
/// When a worker cannot start, and what `receive` returns.
pub fn run<E: From<RunError>>(
    workers: &mut [Box<dyn Worker>],
    open: impl Iterator<Item = u64> + Send,
    job: &(dyn Fn(u64) -> Job + Sync),
    stop: &AtomicBool,
    mut receive: impl FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<(), E> {
    // Bounded, so that slow storage holds the workers back instead of filling the memory.
    const WAITING: usize = 16_384;
    let jobs = (Mutex::new(Batches::new(open.map(job), workers.len())), Condvar::new());
    let done = AtomicBool::new(false);
    let stopped = || stop.load(Ordering::Relaxed) || done.load(Ordering::Relaxed);
    let (send, receiver) = sync_channel(WAITING);
    thread::scope(|scope| {
        for worker in workers {
            let (told, jobs, stopped) = (send.clone(), &jobs, &stopped);
            let spawned = thread::Builder::new().spawn_scoped(scope, move || {
                if let Err(error) = work(&mut **worker, jobs, stopped, &told) {
                    // The receiver may have gone; then nobody waits for the error either.
                    let _ = told.send(Err(error));
                }
            });
            if let Err(error) = spawned {
                let _ = send.send(Err(RunError::Lost(format!(
                    "the system has no thread left: {error}; run fewer points at once"
                ))));
            }
        }
        drop(send);
        collect(&receiver, &done, &mut receive)
    })
}

/// Lets a worker take batches as long as there are any.
fn work<I: Iterator<Item = Job>>(
    worker: &mut dyn Worker,
    (jobs, change): &(Mutex<Batches<I>>, Condvar),
    stopped: &dyn Fn() -> bool,
    send: &SyncSender<Result<Event, RunError>>,
) -> Result<(), RunError> {
    /// How often a worker without points looks whether it is to stop.
    const LOOK: Duration = Duration::from_millis(50);
    // Points come from a program's own iterator: if that panics, the run does.
    let lock = || jobs.lock().map_err(|_| RunError::Lost("the points broke off".to_owned()));
    let is_over = || stopped() || jobs.lock().is_ok_and(|jobs| jobs.is_over());
    let (mut pace, mut batch) = (Pace::default(), Vec::new());
    while worker.ready(&is_over)? {
        let mut left = lock()?;
        // Others may give back what they have taken.
        while !left.take(&pace, &mut batch) {
            if left.is_over() || stopped() {
                return Ok(());
            }
            let waited = change.wait_timeout(left, LOOK);
            left = waited.map_err(|_| RunError::Lost("the points broke off".to_owned()))?.0;
        }
        drop(left);
        if stopped() {
            return Ok(());
        }
        let begun = Instant::now();
        let mut take = |event| match send.send(Ok(event)) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        };
        let mut post = Post::new(&mut take, stopped);
        let result = worker.run(&batch, &mut post);
        pace.end(batch.len(), begun.elapsed(), worker.overhead());
        lock()?.end(post.returned);
        change.notify_all();
        result?;
    }
    Ok(())
}

/// How long answers are gathered before they are handed over, at first and in the long run: to wake up
/// and to write costs the workers a little each time. A set of few points should not wait for it.
const GATHERING: [Duration; 2] = [Duration::from_micros(20), Duration::from_millis(8)];

/// Hands over everything that comes, until all workers have ended.
fn collect<E: From<RunError>>(
    receiver: &Receiver<Result<Event, RunError>>,
    done: &AtomicBool,
    receive: &mut dyn FnMut(Event) -> Result<ControlFlow<()>, E>,
) -> Result<(), E> {
    let mut outcome = Ok(());
    let mut handle = |step: Result<Event, RunError>| {
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
