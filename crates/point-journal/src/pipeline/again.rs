//! Points that run a second time, at the end, and are compared with what is recorded.
//!
//! An FMU may take something from the clock, from its address, or from what other points have left outside of its process.
//! Points that run twice right after each other would not show it. So some of the first points run again as late as the run
//! allows, and some drawn from all: in a new process whose unwritten memory holds other bytes, from another path, and on another host
//! where there is one.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::ControlFlow,
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use rand::{RngExt, SeedableRng, rngs::StdRng, seq::SliceRandom};

use crate::{PointOutcome, Result, pipeline::Model};
use fmu_points::{Conduct, Event, Job, Post, Simulated, Worker, crew::Crew, failure::Failure, stop, task::Case};

/// A point of an index that is known.
pub type JobOfIndex<'a> = &'a dyn Fn(u64) -> Job;

/// So many of the first points run again, of an earlier part of the run and of this one.
pub const EARLIER: usize = 3;
const FIRST: usize = 4;
/// They run again while that takes less than this together, or than this part of the time of the run; one runs in any case.
const LITTLE: Duration = Duration::from_secs(2);
const PART: u32 = 50;
/// So many points run again for that time on a machine that has no other work: on a busy one no fewer do.
const FEWEST: usize = 24;
/// So many points drawn from all that each host has answered run again, while all that takes less than this together and than this
/// part of the time of the run, or than the lesser part: what spoils one point in twenty shows among them.
const DRAWN: usize = 60;
const LITTLE_OF_DRAWN: Duration = Duration::from_millis(200);
const PART_OF_SHORT: u32 = 4;
const PART_OF_DRAWN: u32 = 20;

/// A point with what is recorded of it.
#[derive(Debug)]
struct RecordedPoint {
    job: Job,
    outcome: PointOutcome,
    /// When this run recorded it; none where an earlier one did.
    when: Option<Instant>,
    /// The host that answered it, where there are several.
    host: Option<String>,
}

/// Points drawn from all that a host has answered, each with the same probability.
#[derive(Debug, Default)]
struct Draw {
    answered: u64,
    points: Vec<RecordedPoint>,
}

/// Points that will run again, and what came of those that did.
#[derive(Debug)]
pub struct Again {
    cases: Vec<Case>,
    begun: Instant,
    points: Vec<RecordedPoint>,
    /// How many came from an earlier part of the run.
    earlier: usize,
    drawn: BTreeMap<Option<String>, Draw>,
    random: StdRng,
    /// No more of them run again.
    pub most: usize,
    found: Option<(bool, String)>,
}

impl Again {
    pub fn new(cases: &[Case]) -> Self {
        Self {
            cases: cases.to_vec(),
            begun: Instant::now(),
            points: Vec::new(),
            earlier: 0,
            drawn: BTreeMap::new(),
            random: StdRng::seed_from_u64(0),
            most: usize::MAX,
            found: None,
        }
    }

    /// Takes a point that an earlier part of the run has recorded.
    pub fn recall(&mut self, job: Job, outcome: PointOutcome) {
        if self.earlier < EARLIER && outcome.is_ok() && self.points.iter().all(|point| point.job.index != job.index) {
            self.earlier += 1;
            self.points.push(RecordedPoint { job, outcome, when: None, host: None });
        }
    }

    /// Takes a point that was just recorded, if it is one of the first, or drawn.
    pub fn note(&mut self, crew: &Crew, index: u64, outcome: &PointOutcome, job: JobOfIndex) {
        let host = crew.take_host(index);
        if outcome.is_err() {
            return;
        }
        let when = Some(Instant::now());
        let recorded = |host| RecordedPoint { job: job(index), outcome: outcome.clone(), when, host };
        if self.points.len() - self.earlier < FIRST {
            self.points.push(recorded(host));
            return;
        }
        let draw = self.drawn.entry(host.clone()).or_default();
        draw.answered += 1;
        // Reservoir sampling, algorithm R (Vitter, ACM Transactions on Mathematical Software 11 (1985) 37).
        match draw.points.len() {
            fewer if fewer < DRAWN => draw.points.push(recorded(host)),
            _ => {
                let place = self.random.random_range(0..draw.answered);
                if let Some(place) = usize::try_from(place).ok().and_then(|place| draw.points.get_mut(place)) {
                    *place = recorded(host);
                }
            }
        }
    }

    /// Runs the points again and compares. Those of a run that is to end at once do not.
    pub fn run(&mut self, crew: &Crew, model: &dyn Model) -> Result {
        let stopped = || stop::flag().load(Ordering::Relaxed);
        let (begun, whole) = (Instant::now(), self.begun.elapsed());
        let first = std::mem::take(&mut self.points);
        let mut drawn = std::mem::take(&mut self.drawn);
        // There may be no time for all, and the first that were drawn are mostly the first that were answered.
        drawn.values_mut().for_each(|draw| draw.points.shuffle(&mut self.random));
        let drawn = in_turn(drawn);
        let is_first = std::iter::repeat_n(true, first.len()).chain(std::iter::repeat(false));
        let mut tally = Tally::default();
        let mut workers = BTreeMap::new();
        for (point, is_first) in first.into_iter().chain(drawn).zip(is_first) {
            let is_late = tally.count > 0 && begun.elapsed() > time_for(whole, is_first || tally.count < FEWEST);
            if stopped() || is_late || tally.count >= self.most {
                break;
            }
            if !workers.contains_key(&point.host) {
                let Some(worker) = crew.again(&self.cases, point.host.as_deref()) else { return Ok(()) };
                workers.insert(point.host.clone(), worker);
            }
            let worker = workers.get_mut(&point.host).expect("it was just put there");
            let later = point.when.map(|when| when.elapsed());
            let Some(result) = run_one(worker.as_mut(), &point.job, &stopped)? else { break };
            let now = model.outcome(result.map(|result| result.values));
            tally.add(&point, later, crew.take_host(point.job.index), &now);
        }
        if tally.count > 0 {
            self.found = Some(tally.verdict(self.earlier > 0));
        }
        Ok(())
    }

    /// How points were computed, with what was found.
    pub fn told(&self, conduct: Conduct) -> Conduct {
        match &self.found {
            None => conduct,
            Some((same, text)) => Conduct { reproducible: Some(*same), reproducibility: text.clone(), ..conduct },
        }
    }
}

/// How long points may run again together in a run that has taken so long.
fn time_for(whole: Duration, is_needed: bool) -> Duration {
    if is_needed {
        LITTLE.max(whole / PART)
    } else {
        LITTLE_OF_DRAWN.min(whole / PART_OF_SHORT).max(whole / PART_OF_DRAWN)
    }
}

/// What came of a point; none where it was stopped.
fn run_one(
    worker: &mut dyn Worker,
    job: &Job,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<std::result::Result<Simulated, Failure>>> {
    let mut answer = None;
    let mut take = |event| {
        if let Event::Answer(_, result) = event {
            answer = Some(result);
        }
        ControlFlow::Continue(())
    };
    worker.run(std::slice::from_ref(job), &mut Post::new(&mut take, stopped))?;
    Ok(answer)
}

/// What came of the points that ran again.
#[derive(Default)]
struct Tally {
    count: usize,
    differences: Vec<String>,
    /// How much later each ran again; none for one of an earlier run.
    later: Vec<Option<Duration>>,
    /// How many of the differences involve each host.
    hosts: BTreeMap<String, u64>,
}

impl Tally {
    /// Adds a point that gave this now, so much later, on this host.
    fn add(&mut self, point: &RecordedPoint, later: Option<Duration>, there: Option<String>, now: &PointOutcome) {
        self.count += 1;
        self.later.push(later);
        let Some(text) = difference(&point.outcome, now) else { return };
        let hosts = match (&point.host, &there) {
            (Some(here), Some(there)) if here != there => format!(" ({here}, then {there})"),
            (Some(here), _) => format!(" ({here})"),
            _ => String::new(),
        };
        let involved: BTreeSet<String> = point.host.clone().into_iter().chain(there).collect();
        involved.into_iter().for_each(|host| *self.hosts.entry(host).or_default() += 1);
        self.differences.push(format!("point {}{hosts}: {text}", point.job.index + 1));
    }

    /// Whether all points gave the same again, and a sentence on it.
    fn verdict(&self, has_earlier: bool) -> (bool, String) {
        let count = self.count;
        let which = match has_earlier {
            true => format!("{count} points of this run and of an earlier one"),
            false if count == 1 => "1 point".to_owned(),
            false => format!("{count} points"),
        };
        // That of an earlier run is none, which is less than any.
        let later = match self.later.iter().min().copied().flatten() {
            Some(least) if least < Duration::from_secs(1) => format!("at least {} ms later", least.as_millis()),
            Some(least) => format!("at least {:.0} s later", least.as_secs_f64()),
            None => "after an earlier run".to_owned(),
        };
        let Some(first) = self.differences.first() else {
            return (true, format!("{which} ran again, {later}, in new processes: identical to the last bit"));
        };
        let all = self.differences.len() as u64;
        let mut hosts = self.hosts.iter().filter(|(_, count)| **count == all).map(|(host, _)| host.as_str());
        let cause = match (hosts.next(), hosts.next()) {
            (Some(host), None) if all > 1 => format!("all differences involve {host}: leave that host out"),
            _ => "they depend on something beside the parameters: the clock, unwritten memory, random numbers, the \
                  path, the host, files or ports outside of the FMU"
                .to_owned(),
        };
        let text =
            format!("not reproducible: {which} ran again, {later}, and {all} gave other results ({first}); {cause}");
        (false, text)
    }
}

/// The points of all hosts, one of each in turn, so that the first ones are of all.
fn in_turn(drawn: BTreeMap<Option<String>, Draw>) -> impl Iterator<Item = RecordedPoint> {
    let mut all: Vec<(usize, RecordedPoint)> =
        drawn.into_values().flat_map(|draw| draw.points.into_iter().enumerate()).collect();
    all.sort_by_key(|(place, _)| *place);
    all.into_iter().map(|(_, point)| point)
}

/// The first value or the failure in which two outcomes differ, if they do.
pub fn difference(recorded: &PointOutcome, now: &PointOutcome) -> Option<String> {
    match (recorded, now) {
        (Ok(recorded), Ok(now)) => {
            let mut pairs = recorded.iter().zip(now);
            let (then, now) = pairs.find(|(then, now)| then.to_bits() != now.to_bits())?;
            Some(format!("{then} recorded, {now} now"))
        }
        (Err(then), Err(now)) => (then != now).then(|| format!("{then} recorded, {now} now")),
        (Ok(_), Err(failure)) => Some(format!("it failed now: {failure}")),
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

    #[test]
    fn the_same_failure_is_no_difference() {
        let failed = |why: &str| Err(Failure::Crashed(why.to_owned()));
        assert_eq!(difference(&failed("SIGSEGV"), &failed("SIGSEGV")), None);
        let text = difference(&failed("SIGSEGV"), &failed("SIGBUS")).unwrap();
        assert_eq!(text, "crashed: SIGSEGV recorded, crashed: SIGBUS now");
        assert_eq!(difference(&Ok(vec![]), &failed("SIGBUS")).as_deref(), Some("it failed now: crashed: SIGBUS"));
        assert_eq!(difference(&failed("SIGBUS"), &Ok(vec![])).as_deref(), Some("it gave results now"));
    }
}
