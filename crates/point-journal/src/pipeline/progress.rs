//! Progress on standard error, when that is a terminal.

use std::{collections::BTreeMap, time::Duration};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar with rate, remaining time and the share of verified points so far.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    verified: u64,
    failed: u64,
    points: u64,
}

impl Progress {
    /// Begins at `done` of `points`, where their number is known. Without a terminal nothing is shown.
    pub fn new(points: Option<u64>, done: u64) -> Self {
        const LINE: &str = "{bar:30} {pos}/{len} points, {per_sec}, {eta} left, {msg}";
        const OPEN: &str = "{pos} points, {per_sec}, {elapsed}, {msg}";
        let bar = ProgressBar::with_draw_target(points, ProgressDrawTarget::stderr_with_hz(5)).with_position(done);
        if let Ok(style) = ProgressStyle::with_template(points.map_or(OPEN, |_| LINE)) {
            bar.set_style(style);
        }
        bar.reset_eta();
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(500));
        }
        Self { bar, verified: 0, failed: 0, points: 0 }
    }

    /// One more point is done; `answered` says how many points each host has answered, where there are several.
    pub fn step(&mut self, verified: bool, failed: bool, answered: impl FnOnce() -> BTreeMap<String, u64>) {
        const RARELY: u64 = 64;
        self.verified += u64::from(verified);
        self.failed += u64::from(failed);
        self.points += 1;
        self.bar.inc(1);
        let shown = self.points.is_power_of_two() || self.points.is_multiple_of(RARELY);
        if shown && !self.bar.is_hidden() {
            let text = message(self.verified, self.failed, self.points) + &hosts(&answered());
            self.bar.set_message(text);
        }
    }

    /// Shows a text of the analysis' own.
    pub fn say(&self, text: String) {
        self.bar.set_message(text);
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

fn message(verified: u64, failed: u64, points: u64) -> String {
    let share = 100.0 * verified as f64 / points.max(1) as f64;
    let failed = if failed > 0 { format!(", {failed} failed") } else { String::new() };
    format!("{share:.1} % verified{failed}")
}

/// The hosts with the fewest and the most points.
fn hosts(answered: &BTreeMap<String, u64>) -> String {
    let fewest = answered.iter().min_by_key(|(_, points)| **points);
    let most = answered.iter().max_by_key(|(_, points)| **points);
    match (fewest, most) {
        (Some((slow, few)), Some((fast, many))) if slow != fast => {
            let count = answered.len();
            format!(", {count} hosts: {slow} {few} .. {fast} {many}")
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_told_where_there_are_several() {
        let answered = [("a", 7), ("b", 2), ("c", 9)].map(|(host, points)| (host.to_owned(), points));
        assert_eq!(hosts(&answered.clone().into()), ", 3 hosts: b 2 .. c 9");
        assert_eq!(hosts(&answered.into_iter().take(1).collect()), "");
    }
}
