//! Cuts the points into batches that take a worker a moment: long enough to cost nothing, short
//! enough that all workers end together.

use std::time::{Duration, Instant};

use crate::points::Job;

/// How long a batch should take.
const MOMENT: Duration = Duration::from_millis(50);
/// The largest batch, which limits the memory.
const MOST: usize = 1024;
/// Where handing over a batch takes time of its own, the batch takes so many times as long, up to this time, and may be this
/// large.
const TIMES: u32 = 30;
const LONGEST: Duration = Duration::from_secs(2);
const MOST_AFAR: usize = 16_384;

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
    /// Notes that a batch is done, which took so long beyond its computation.
    pub(crate) fn end(&mut self, jobs: usize, overhead: Duration) {
        let Some(begun) = self.begun.take() else {
            return;
        };
        let (moment, most) = match overhead.is_zero() {
            true => (MOMENT, MOST),
            false => ((overhead * TIMES).clamp(MOMENT, LONGEST), MOST_AFAR),
        };
        let computed = begun.elapsed().saturating_sub(overhead);
        let each = computed.as_secs_f64().max(1e-9) / jobs.max(1) as f64;
        let wanted = (moment.as_secs_f64() / each) as usize;
        // At most fourfold at a time: the first points may be unusual.
        self.size = wanted.min(4 * jobs).clamp(1, most);
    }
}

/// The points that are left.
pub(crate) struct Batches<I> {
    jobs: I,
    workers: usize,
    /// Points that a worker gave back. Each is handed out alone: it may be the one that cost that worker.
    returned: Vec<Job>,
    /// How many batches are with a worker.
    out: usize,
    /// Whether there are no points but those that were handed out before.
    dry: bool,
}

impl<I: Iterator<Item = Job>> Batches<I> {
    pub(crate) fn new(jobs: I, workers: usize) -> Self {
        Self {
            jobs,
            workers,
            returned: Vec::new(),
            out: 0,
            dry: false,
        }
    }

    /// Takes the next batch; `false` when there is none at the moment.
    pub(crate) fn take(&mut self, pace: &Pace, batch: &mut Vec<Job>) -> bool {
        // Towards the end, what is left is shared.
        let fair = self
            .jobs
            .size_hint()
            .1
            .map_or(MOST_AFAR, |left| left / (2 * self.workers.max(1)));
        let size = pace.size.min(fair).max(1);
        batch.clear();
        match self.returned.pop() {
            Some(job) => batch.push(job),
            None => batch.extend(self.jobs.by_ref().take(size)),
        }
        self.dry |= batch.is_empty();
        self.out += usize::from(!batch.is_empty());
        !batch.is_empty()
    }

    /// Notes that a batch is done but for these points.
    pub(crate) fn end(&mut self, returned: Vec<Job>) {
        self.out -= 1;
        self.returned.extend(returned);
    }

    /// Whether no more points will be handed out.
    pub(crate) fn is_over(&self) -> bool {
        self.dry && self.out == 0 && self.returned.is_empty()
    }

    /// How many points are left, as far as that is known.
    pub(crate) fn left(&self) -> Option<usize> {
        let left = self.jobs.size_hint().1?;
        Some(left + self.returned.len())
    }
}
