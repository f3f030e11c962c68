//! How long the points of a finished study may be run once more.

use std::{
    sync::LazyLock,
    time::{Duration, Instant},
};

/// All that comes after a study's points takes no longer than these did; but it may take so long.
const LEAST: Duration = Duration::from_secs(2);

/// Time that may be spent, all in all.
pub struct Budget {
    until: Duration,
    clock: fn() -> Duration,
}

impl Budget {
    /// As much as the points of a study took.
    pub fn new(points_took: Duration) -> Self {
        static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
        Self::by(points_took, || BEGUN.elapsed())
    }

    fn by(points_took: Duration, clock: fn() -> Duration) -> Self {
        Self { until: clock().saturating_add(points_took.max(LEAST)), clock }
    }

    /// The rest of it.
    pub fn left(&self) -> Duration {
        self.until.saturating_sub((self.clock)())
    }

    /// A part of what is left.
    pub fn part(&self, share: f64) -> Self {
        let left = self.left().mul_f64(share);
        Self { until: (self.clock)() + left, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    thread_local! {
        static NOW: Cell<u64> = const { Cell::new(100) };
    }

    fn now() -> Duration {
        Duration::from_secs(NOW.get())
    }

    #[test]
    fn it_is_as_much_as_the_points_took_or_two_seconds() {
        let seconds = Duration::from_secs;
        let [short, long] = [seconds(1), seconds(60)].map(|took| Budget::by(took, now));
        assert_eq!([short.left(), long.left()], [LEAST, seconds(60)]);
        NOW.set(110);
        let half = long.part(0.5);
        assert_eq!([short.left(), long.left(), half.left()], [Duration::ZERO, seconds(50), seconds(25)]);
        NOW.set(140);
        assert_eq!([long.left(), half.left()], [seconds(20), Duration::ZERO]);
    }
}
