//! Cuts the points into batches that take a worker a moment: long enough to cost nothing, short
//! enough that all workers end together.

use std::time::{Duration, Instant};

use crate::points::Job;

/// How long a batch should take.
const MOMENT: Duration = Duration::from_millis(50);
/// The largest batch, which limits the memory.
const MOST: usize = 1024;

/// How fast a worker is.
#[derive(Debug, Default)]
pub(crate) struct Pace {
    begun: Option<Instant>,
    size: usize,
}

impl Pace {
    pub(crate) fn begin(&mut self) {
        self.begun = Some(Instant::now());
    }

    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss
    )]
    pub(crate) fn end(&mut self, jobs: usize) {
        let Some(begun) = self.begun.take() else {
            return;
        };
        let each = begun.elapsed().as_secs_f64().max(1e-9) / jobs.max(1) as f64;
        let wanted = (MOMENT.as_secs_f64() / each) as usize;
        // At most fourfold at a time: the first points may be unusual.
        self.size = wanted.min(4 * jobs).clamp(1, MOST);
    }
}

/// The points that are left.
pub(crate) struct Batches<I> {
    jobs: I,
    workers: usize,
}

impl<I: Iterator<Item = Job>> Batches<I> {
    pub(crate) fn new(jobs: I, workers: usize) -> Self {
        Self { jobs, workers }
    }

    /// Takes the next batch; `false` when nothing is left.
    pub(crate) fn take(&mut self, pace: &Pace, batch: &mut Vec<Job>) -> bool {
        // Towards the end, what is left is shared.
        let fair = self
            .jobs
            .size_hint()
            .1
            .map_or(MOST, |left| left / (2 * self.workers.max(1)));
        let size = pace.size.min(fair).max(1);
        batch.clear();
        batch.extend(self.jobs.by_ref().take(size));
        !batch.is_empty()
    }

    /// How many points are left, as far as that is known.
    pub(crate) fn left(&self) -> Option<usize> {
        self.jobs.size_hint().1
    }
}
