//! Points that run a second time, at the end, and are compared with what is recorded.
//!
//! An FMU may take something from the clock, from its address, or from what other points have left outside of its process.
//! Points that run twice right after each other would not show it. So some of the first points run again as late as the run
//! allows: in a new process whose unwritten memory holds other bytes, from another path, and on another host where there is one.

use std::ops::ControlFlow;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use crate::{Error, Outcome, pipeline::Model};
use fmu_points::crew::Crew;
use fmu_points::task::Case;
use fmu_points::{Conduct, Event, Job, Post, stop};

/// A point of an index that is known.
pub(super) type Known<'a> = &'a dyn Fn(u64) -> Job;

/// So many of the first points run again, of an earlier part of the run and of this one.
pub(super) const EARLIER: usize = 3;
const FIRST: usize = 4;
/// They run again while that takes less than this together, or than this part of the time of the run; one runs in any case.
const LITTLE: Duration = Duration::from_secs(2);
const PART: u32 = 50;

/// A point with what is recorded of it.
#[derive(Debug)]
struct Recorded {
    job: Job,
    outcome: Outcome,
    /// When this run recorded it; none where an earlier one did.
    when: Option<Instant>,
}

/// Points that will run again, and what came of those that did.
#[derive(Debug)]
pub(super) struct Again {
    cases: Vec<Case>,
    begun: Instant,
    points: Vec<Recorded>,
    /// How many came from an earlier part of the run.
    earlier: usize,
    found: Option<(bool, String)>,
}

impl Again {
    pub(super) fn new(cases: &[Case]) -> Self {
        Self { cases: cases.to_vec(), begun: Instant::now(), points: Vec::new(), earlier: 0, found: None }
    }

    /// Takes a point that an earlier part of the run has recorded.
    pub(super) fn recall(&mut self, job: Job, outcome: Outcome) {
        if self.earlier < EARLIER && outcome.is_ok() && self.points.iter().all(|point| point.job.index != job.index) {
            self.earlier += 1;
            self.points.push(Recorded { job, outcome, when: None });
        }
    }

    /// Takes a point that was just recorded, if it is one of the first, or of the first of its host.
    pub(super) fn note(&mut self, crew: &Crew, outcome: &Outcome, job: impl FnOnce() -> Job) {
        const HOSTS: usize = 64;
        let few = self.points.len() - self.earlier < FIRST;
        if outcome.is_err() || self.points.len() > HOSTS || !few && crew.answered().len() < 2 {
            return;
        }
        let job = job();
        if few || crew.hosts_of(job.index)[0].is_some() {
            self.points.push(Recorded { job, outcome: outcome.clone(), when: Some(Instant::now()) });
        }
    }

    /// Runs the points again and compares. Those of a run that is to end at once do not.
    pub(super) fn run(&mut self, crew: &Crew, model: &dyn Model) -> Result<(), Error> {
        let stopped = || stop::flag().load(Ordering::Relaxed);
        let (begun, whole) = (Instant::now(), self.begun.elapsed());
        let (mut count, mut differences, mut latest) = (0, Vec::new(), Some(Duration::MAX));
        for point in std::mem::take(&mut self.points) {
            let spent = begun.elapsed();
            if stopped() || count > 0 && spent > LITTLE && spent > whole / PART {
                break;
            }
            let [host, _] = crew.hosts_of(point.job.index);
            let Some(mut worker) = crew.again(&self.cases, host.as_deref()) else { return Ok(()) };
            let later = point.when.map(|when| when.elapsed());
            let mut answer = None;
            let mut take = |event| {
                if let Event::Answer(_, result) = event {
                    answer = Some(result);
                }
                ControlFlow::Continue(())
            };
            worker.run(std::slice::from_ref(&point.job), &mut Post::new(&mut take, &stopped))?;
            let Some(answer) = answer else { break };
            let [_, there] = crew.hosts_of(point.job.index);
            let now = model.outcome(answer.map(|result| result.values));
            count += 1;
            latest = later.zip(latest).map(|(later, latest)| later.min(latest));
            if let Some(text) = difference(&point.outcome, &now) {
                let hosts = match (host, there) {
                    (Some(here), Some(there)) if here != there => format!(" ({here}, then {there})"),
                    (Some(here), _) => format!(" ({here})"),
                    _ => String::new(),
                };
                differences.push(format!("point {}{hosts}: {text}", point.job.index + 1));
            }
        }
        if count == 0 {
            return Ok(());
        }
        let which = match self.earlier {
            0 => format!("{count} of the first points"),
            _ => format!("{count} of the first points of this run and of an earlier one"),
        };
        let later = match latest {
            Some(least) if least < Duration::from_secs(1) => format!("at least {} ms later", least.as_millis()),
            Some(least) => format!("at least {:.0} s later", least.as_secs_f64()),
            None => "after an earlier run".to_owned(),
        };
        self.found = Some(match differences.first() {
            None => (true, format!("{which} ran again, {later}, in new processes: identical to the last bit")),
            Some(first) => {
                let text = format!(
                    "not reproducible: {which} ran again, {later}, and {} gave other results ({first}); they depend on something \
                     beside the parameters: the clock, unwritten memory, random numbers, the path, files or ports outside of \
                     the FMU",
                    differences.len()
                );
                (false, text)
            }
        });
        Ok(())
    }

    /// How points were computed, with what was found.
    pub(super) fn told(&self, conduct: Conduct) -> Conduct {
        match &self.found {
            None => conduct,
            Some((same, text)) => Conduct { reproducible: Some(*same), reproducibility: text.clone(), ..conduct },
        }
    }
}

/// The first value in which two outcomes differ, if they do.
pub fn difference(recorded: &Outcome, now: &Outcome) -> Option<String> {
    match (recorded, now) {
        (Ok(recorded), Ok(now)) => {
            let mut pairs = recorded.iter().zip(now);
            let (then, now) = pairs.find(|(then, now)| then.to_bits() != now.to_bits())?;
            Some(format!("{then} recorded, {now} now"))
        }
        (_, Err(failure)) => Some(format!("it failed now: {failure}")),
        (Err(_), Ok(_)) => Some("it gave results now".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_bit_is_a_difference() {
        let outcome = |value: f64| Ok(vec![1.0, value]);
        assert_eq!(difference(&outcome(0.1), &outcome(0.1)), None);
        let text = difference(&outcome(0.1), &outcome(0.1_f64.next_up())).unwrap();
        assert_eq!(text, "0.1 recorded, 0.10000000000000002 now");
        assert_eq!(difference(&outcome(0.0), &outcome(-0.0)).as_deref(), Some("0 recorded, -0 now"));
    }
}
