//! Cuts the points into batches that take a worker a moment: long enough to cost nothing, short
//! enough that all workers end together.

use std::time::Duration;

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
pub struct Pace {
    size: usize,
}

impl Pace {
    /// Notes that a batch is done: how long it took, and how much of that beyond its computation.
    pub fn end(&mut self, jobs: usize, took: Duration, overhead: Duration) {
        let (moment, most) =
            if overhead.is_zero() { (MOMENT, MOST) } else { ((overhead * TIMES).clamp(MOMENT, LONGEST), MOST_AFAR) };
        let computed = took.saturating_sub(overhead);
        let each = computed.as_secs_f64().max(1e-9) / jobs.max(1) as f64;
        let wanted = (moment.as_secs_f64() / each) as usize;
        // At most fourfold at a time: the first points may be unusual.
        self.size = wanted.min(4 * jobs).clamp(1, most);
    }
}

/// The points that are left.
pub struct Batches<I> {
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
    pub fn new(jobs: I, workers: usize) -> Self {
        Self { jobs, workers, returned: Vec::new(), out: 0, dry: false }
    }

    /// Takes the next batch; `false` when there is none at the moment.
    pub fn take(&mut self, pace: &Pace, batch: &mut Vec<Job>) -> bool {
        // Towards the end, what is left is shared.
        let fair = self.jobs.size_hint().1.map_or(MOST_AFAR, |left| left / (2 * self.workers.max(1)));
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
    pub fn end(&mut self, returned: Vec<Job>) {
        self.out -= 1;
        self.returned.extend(returned);
    }

    /// Whether no more points will be handed out.
    pub fn is_over(&self) -> bool {
        self.dry && self.out == 0 && self.returned.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    /// How much of their time workers compute such points, where handing over a batch takes so long.
    fn utilisation(points: &[Duration], workers: usize, overhead: Duration) -> f64 {
        let all = (0..points.len() as u64).map(|index| Job { index, values: Vec::new() });
        let mut batches = Batches::new(all, workers);
        let (mut paces, mut batch) = (Vec::from_iter((0..workers).map(|_| Pace::default())), Vec::new());
        let mut free = BinaryHeap::from_iter((0..workers).map(|worker| Reverse((Duration::ZERO, worker))));
        let mut end = Duration::ZERO;
        while let Some(Reverse((now, worker))) = free.pop() {
            if !batches.take(&paces[worker], &mut batch) {
                continue;
            }
            let computed: Duration = batch.iter().map(|job| points[job.index as usize]).sum();
            let took = computed + overhead;
            paces[worker].end(batch.len(), took, overhead);
            end = end.max(now + took);
            free.push(Reverse((now + took, worker)));
        }
        points.iter().sum::<Duration>().as_secs_f64() / end.as_secs_f64() / workers as f64
    }

    /// Points of 1 ms to 1 s, evenly spread in their logarithm, in an order without pattern.
    fn uneven(count: u64) -> Vec<Duration> {
        let place = |k: u64| (k as f64 * 0.618_033_988_75).fract();
        let points = (0..count).map(|k| Duration::from_secs_f64(0.001 * 1000_f64.powf(place(k))));
        points.collect()
    }

    #[test]
    fn uneven_points_leave_no_worker_idle_for_long() {
        let [quick, slow] = [1, 20].map(Duration::from_millis);
        assert!(utilisation(&uneven(1000), 8, quick) > 0.97);
        assert!(utilisation(&uneven(3000), 8, slow) > 0.95);
        assert!(utilisation(&vec![quick; 100_000], 8, slow) > 0.92);
    }
}
