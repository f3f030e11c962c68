//! Progress on standard error, when that is a terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar with rate, remaining time and the share of verified points so far.
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Begins at `done` of `points`. Without a terminal nothing is shown.
    pub(super) fn new(points: u64, done: u64) -> Self {
        const LINE: &str = "{bar:30} {pos}/{len} points, {per_sec}, {eta} left, {msg}";
        let target = ProgressDrawTarget::stderr_with_hz(5);
        let bar = ProgressBar::with_draw_target(Some(points), target).with_position(done);
        if let Ok(style) = ProgressStyle::with_template(LINE) {
            bar.set_style(style);
        }
        bar.reset_eta();
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(500));
        }
        Self { bar }
    }

    /// One more point is done.
    pub(super) fn step(&self, verified: u64, failed: u64, points: u64) {
        self.bar.inc(1);
        if self.bar.is_hidden() {
            return;
        }
        const RARELY: u64 = 64;
        if points.is_power_of_two() || points.is_multiple_of(RARELY) {
            self.bar.set_message(message(verified, failed, points));
        }
    }

    /// Takes the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

#[allow(clippy::cast_precision_loss)]
fn message(verified: u64, failed: u64, points: u64) -> String {
    let share = 100.0 * verified as f64 / points.max(1) as f64;
    let failed = if failed > 0 {
        format!(", {failed} failed")
    } else {
        String::new()
    };
    format!("{share:.1} % verified{failed}")
}
