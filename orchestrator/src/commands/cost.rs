//! Estimates the time of a study: runs some points and assumes that the others take as long.

use conformity::conclusion::grouped;

use crate::{
    error::{Error, Result},
    options::Means,
    session::Verification,
};
use fmu_points::{
    Event, Job, PointLimits, Post,
    crew::{Crew, WorkerSite},
    stop,
};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// How long the point may take; nobody waits longer for an estimate.
const PATIENCE: Duration = Duration::from_secs(60);

/// At most so many points are run for the estimate, for so long.
const POINTS: usize = 1024;
const ENOUGH: Duration = Duration::from_secs(3);

/// The estimate for people, or why there is none.
pub fn of(verification: &mut Verification, means: &Means, jobs: usize) -> Result<String> {
    let scratch = stop::scratch()?;
    let place = match means.place(jobs)? {
        WorkerSite::Processes(limits, isolation) => {
            let time = limits.time.min(PATIENCE);
            WorkerSite::Processes(PointLimits { time, ..limits }, isolation)
        }
        other => other,
    };
    let session = &mut verification.session;
    let crew = Crew::new(&mut session.package, place, scratch.path(), 1)?;
    let mut worker = crew.worker(&session.plan.cases);
    let Some(index) = verification.indexes().next() else { return Ok(String::new()) };
    let mut run = |points: usize, most| {
        let points: Vec<Job> = verification.indexes().take(points).map(|index| verification.job(index)).collect();
        let (begun, mut count, mut took, mut failure) = (Instant::now(), 0_u32, Duration::ZERO, None);
        let mut take = |event| {
            if let Event::Answer(_, answer) = event {
                (count, took) = (count + 1, begun.elapsed());
                failure = failure.take().or(answer.err());
            }
            ControlFlow::Continue(())
        };
        worker.run(&points, &mut Post::new(&mut take, &|| begun.elapsed() > most))?;
        Ok::<_, Error>((took.as_secs_f64() / f64::from(count.max(1)), count, failure))
    };
    // The first run starts the worker and loads the FMU.
    let (first, _, failure) = run(1, Duration::MAX)?;
    if let Some(failure) = failure {
        let label = verification.source.label(index);
        return Ok(format!("point {label} fails: {failure}\n"));
    }
    let (point, count, _) = run(POINTS, ENOUGH)?;
    let point = if count > 0 { point } else { first };
    Ok(text(point, verification.expected(), jobs))
}

fn text(point: f64, points: u64, jobs: usize) -> String {
    let all = point * points as f64 / jobs as f64;
    format!("about {} in all: a point takes {}, {jobs} at a time\n", span(all), span(point))
}

/// A time in the unit that people would use.
pub fn span(seconds: f64) -> String {
    const UNITS: [(f64, &str); 6] =
        [(1e-6, "us"), (1e-3, "ms"), (1.0, "s"), (60.0, "min"), (3600.0, "h"), (86400.0, "days")];
    // Two of a unit are the least, so that the number tells enough.
    let fitting = UNITS.iter().rfind(|(size, _)| seconds >= 2.0 * size);
    let (size, unit) = fitting.unwrap_or(&UNITS[0]);
    let number = seconds / size;
    let digits = usize::from(number < 10.0);
    format!("{number:.digits$} {unit}")
}

/// Says what a budget would give, where so many points take long.
pub fn remark(point: Duration, left: usize, jobs: usize) {
    const DEAR: f64 = 1.0;
    const LONG: f64 = 3600.0;
    const RUNS: f64 = 100.0;
    let point = point.as_secs_f64();
    let of = |points: f64| point * points / jobs as f64;
    if point > DEAR && of(left as f64) > LONG {
        fmu_points::tell::line!(
            "note: a point takes {}, so {} of them take about {}; `--budget {RUNS}` takes about {} and tells the share by a \
             surrogate, with an interval, where that holds",
            span(point),
            grouped(left),
            span(of(left as f64)),
            span(of(RUNS))
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_readable() {
        assert_eq!(text(6.2e-5, 1_000_000, 2), "about 31 s in all: a point takes 62 us, 2 at a time\n");
        assert_eq!(span(1.5), "1500 ms");
        assert_eq!(span(1200.0), "20 min");
        assert_eq!(span(7.5e4), "21 h");
        assert_eq!(span(1e9), "11574 days");
    }
}
