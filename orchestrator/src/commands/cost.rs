//! What a study would cost: one point is run, and the others are taken to last as long.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use super::CommandError;
use super::limits::place;
use crate::cli::Means;
use crate::engine::crew::Place;
use crate::engine::process::Limits;
use crate::results::ResultsError;
use crate::session::Session;

/// How long the point may take; nobody waits longer for an estimate.
const PATIENCE: Duration = Duration::from_secs(60);

/// The estimate for people, or why there is none.
pub(super) fn of(
    session: &mut Session,
    means: &Means,
    jobs: usize,
) -> Result<String, CommandError> {
    let scratch = tempfile::tempdir().map_err(ResultsError::io(&std::env::temp_dir()))?;
    let place = match place(means, jobs)? {
        Place::Workers(limits) => Place::Workers(Limits {
            time: limits.time.min(PATIENCE),
            ..limits
        }),
        Place::Here => Place::Here,
    };
    let mut workers = session.workers(place, scratch.path(), 1)?;
    let (Some(worker), Some(index)) = (workers.first_mut(), session.indexes().next()) else {
        return Ok(String::new());
    };
    let job = session.job(index);
    let mut once = || {
        let begun = Instant::now();
        let mut failure = None;
        worker.run(std::slice::from_ref(&job), &mut |_, answer| {
            failure = answer.err();
            ControlFlow::Continue(())
        })?;
        Ok::<_, CommandError>((failure, begun.elapsed()))
    };
    // The first run starts the worker and loads the FMU.
    let (failure, first) = once()?;
    if let Some(failure) = failure {
        let label = session.source.label(index);
        return Ok(format!("point {label} fails: {failure}\n"));
    }
    let point = match first {
        long if long > Duration::from_secs(1) => long,
        _ => once()?.1,
    };
    Ok(text(point.as_secs_f64(), session.expected(), jobs))
}

#[allow(clippy::cast_precision_loss)]
fn text(point: f64, points: u64, jobs: usize) -> String {
    let all = point * points as f64 / jobs as f64;
    format!(
        "about {} in all: a point takes {}, {jobs} at a time\n",
        span(all),
        span(point)
    )
}

/// A time in the unit that people would use.
fn span(seconds: f64) -> String {
    const UNITS: [(f64, &str); 6] = [
        (1e-6, "us"),
        (1e-3, "ms"),
        (1.0, "s"),
        (60.0, "min"),
        (3600.0, "h"),
        (86400.0, "days"),
    ];
    // Two of a unit are the least, so that the number tells enough.
    let fitting = UNITS.iter().rfind(|(size, _)| seconds >= 2.0 * size);
    let (size, unit) = fitting.unwrap_or(&UNITS[0]);
    let number = seconds / size;
    let digits = usize::from(number < 10.0);
    format!("{number:.digits$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_readable() {
        assert_eq!(
            text(6.2e-5, 1_000_000, 2),
            "about 31 s in all: a point takes 62 us, 2 at a time\n"
        );
        assert_eq!(span(1.5), "1500 ms");
        assert_eq!(span(1200.0), "20 min");
        assert_eq!(span(7.5e4), "21 h");
        assert_eq!(span(1e9), "11574 days");
    }
}
