//! How long the points of a finished study may be run once more.

use std::time::{Duration, Instant};

/// All that comes after a study's points takes no longer than these did; but it may take so long.
const LEAST: Duration = Duration::from_secs(2);
/// No study takes a century, and clocks hold that.
const MOST: Duration = Duration::from_secs(100 * 365 * 86_400);

/// Time that may be spent, all in all.
pub struct Budget {
    until: Instant,
}

impl Budget {
    /// As much as the points of a study took.
    pub fn new(points_took: Duration) -> Self {
        Self { until: Instant::now() + points_took.clamp(LEAST, MOST) }
    }

    /// The rest of it.
    pub fn left(&self) -> Duration {
        self.until.saturating_duration_since(Instant::now())
    }

    /// A part of what is left.
    pub fn part(&self, share: f64) -> Self {
        Self { until: Instant::now() + self.left().mul_f64(share) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As long as the test takes less than a second.
    #[test]
    fn it_is_as_much_as_the_points_took_or_two_seconds() {
        let nearly = |budget: &Budget, seconds: f64| (seconds - 1.0..=seconds).contains(&budget.left().as_secs_f64());
        let [short, long] = [1, 60].map(|took| Budget::new(Duration::from_secs(took)));
        assert!(nearly(&short, 2.0) && nearly(&long, 60.0) && nearly(&long.part(0.5), 30.0));
        assert!(nearly(&Budget::new(Duration::MAX), MOST.as_secs_f64()));
        let none = long.part(0.0);
        assert_eq!([none.left(), none.part(0.5).left()], [Duration::ZERO; 2]);
    }
}
