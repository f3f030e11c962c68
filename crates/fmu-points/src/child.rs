//! A worker's child, in which the FMU runs.

use std::collections::BTreeSet;
use std::fs;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::join;
use crate::notices::Notices;
use crate::points::Job;
use crate::runner::{Habit, Runner};
use crate::system::{self, Shared};
use crate::task::Record;
use crate::wire::{
    End, Odd, Reader, Setup, Trouble, mark, put_end, put_results, put_trouble, put_value, speech,
};
#[cfg(any(windows, test))]
use crate::wire::{Way, put_job};
use fmu_import::isolation::{Place, Traces};
use fmu_import::{Library, Package, Value, complaints};

/// Answers of many points are sent after this time at the latest, when the next point is done.
const HOLD: Duration = Duration::from_millis(1);

/// What a worker wants of its child.
#[derive(Debug)]
pub(crate) enum Work {
    /// One point.
    Alone(Job),
    /// All points that come.
    Serve(Habit),
    /// One point with its trajectory.
    Record(Record),
}

/// A child that is not a fork is told its work.
#[cfg(any(windows, test))]
impl Work {
    pub(crate) fn put(&self, into: &mut Vec<u8>) -> std::io::Result<()> {
        match self {
            Self::Alone(job) => {
                Way::New.put(into);
                put_job(job.index, &job.values, into);
            }
            Self::Serve(habit) => Way::Used(*habit).put(into),
            Self::Record(record) => {
                Way::Recorded.put(into);
                into.extend(serde_json::to_vec(record)?);
            }
        }
        Ok(())
    }

    pub(crate) fn of(order: &[u8]) -> std::io::Result<Self> {
        let damaged = || std::io::Error::other("an order is damaged");
        let mut reader = Reader(order);
        Ok(match reader.way().ok_or_else(damaged)? {
            Way::New | Way::Forked => Self::Alone(reader.job().ok_or_else(damaged)?),
            Way::Used(habit) => Self::Serve(habit),
            Way::Recorded => Self::Record(serde_json::from_slice(reader.0)?),
        })
    }
}

/// Does the work of a worker's child.
pub(crate) fn work(
    place: Place,
    setup: &Setup,
    package: Option<&mut Package>,
    library: Option<Arc<Library>>,
    progress: &Shared,
    work: &Work,
) {
    match work {
        Work::Alone(job) => alone(place, setup, package, library, job),
        Work::Serve(habit) => serve(place, setup, package, library, *habit, progress),
        Work::Record(values) => record(place, setup, package, values),
    }
}

/// Runs one point, and tells its answer before the instance is ended.
fn alone(
    mut place: Place,
    setup: &Setup,
    package: Option<&mut Package>,
    library: Option<Arc<Library>>,
    job: &Job,
) {
    let begun = Instant::now();
    if let Some(byte) = setup.fill {
        paint_stack(byte);
    }
    let Some(library) = loaded(&mut place, setup, package, library) else {
        return;
    };
    let Some(case) = setup.cases.get(join::case_of(job.index, setup.cases.len())) else {
        return;
    };
    let mut runner = Runner::new(library, case.task.clone());
    let before = Before::now();
    let instance = runner.alone(&job.values, |runner, answer| {
        let times = runner.ready().map_or([0.0; 2], |ready| {
            [ready - begun, ready.elapsed()].map(|time| time.as_secs_f32())
        });
        let odd = before.odd(runner, answer.err(), true);
        let mut said = vec![speech::REPLIES];
        match answer {
            Ok(values) => put_results(job.index, times, values, Some(runner.notices()), &mut said),
            Err(failure) => put(job.index, times, failure, runner, &mut said),
        }
        mark(odd, &mut said[1..]);
        place.send(&said);
    });
    let notices = runner.notices();
    if notices.unfinished.is_some() || notices.version.is_some() {
        let mut said = vec![speech::FAREWELL];
        said.extend(serde_json::to_vec(notices).unwrap_or_default());
        place.send(&said);
    }
    drop(instance);
}

/// What this process was like before a point.
struct Before {
    traces: Traces,
    complaints: u64,
}

impl Before {
    fn now() -> Self {
        Self {
            traces: Traces::now(),
            complaints: complaints(),
        }
    }

    /// What is odd after a point that ended so; signals take long to look at.
    fn odd(&self, runner: &Runner, failure: Option<&Failure>, signals: bool) -> Option<Odd> {
        let notices = runner.notices();
        let complained = match failure {
            // The FMU was not even asked.
            Some(Failure::OutOfRange(_)) => false,
            Some(_) => true,
            None => notices.ended.is_some() || notices.unfinished.is_some() || notices.warnings > 0,
        };
        if complained || complaints() != self.complaints {
            Some(Odd::Complaint)
        } else if self.traces.has_further_threads() {
            Some(Odd::Threads)
        } else if signals && self.traces.has_other_signals() {
            Some(Odd::Signals)
        } else {
            None
        }
    }
}

/// Runs points until there are no further ones, or until one does not end plainly.
fn serve(
    mut place: Place,
    setup: &Setup,
    package: Option<&mut Package>,
    library: Option<Arc<Library>>,
    habit: Habit,
    progress: &Shared,
) {
    let Some(library) = loaded(&mut place, setup, package, library) else {
        return;
    };
    let mut tasks = setup.cases.iter().map(|case| case.task.clone());
    let Some(first) = tasks.next() else { return };
    let runner = Runner::new(library, first).with_further(tasks);
    let mut runner = runner.with_habit(habit);
    let mut said = vec![speech::REPLIES];
    let before = Before::now();
    while let Some(message) = place.receive() {
        let mut sent = Instant::now();
        let (mut jobs, mut begun, mut first) = (Reader(&message), 0, None);
        while let Some(job) = jobs.job() {
            begun += 1;
            progress.set(begun);
            runner.turn_to(join::case_of(job.index, setup.cases.len()));
            let at = said.len();
            let failure = runner.run(&job.values).err();
            match &failure {
                None => {
                    let (values, notices) = (runner.results(), runner.notices());
                    put_results(job.index, [0.0; 2], values, Some(notices), &mut said);
                }
                Some(failure) => put(job.index, [0.0; 2], failure, &runner, &mut said),
            }
            let end_of_first = *first.get_or_insert(said.len());
            let odd = before.odd(&runner, failure.as_ref(), setup.careful);
            let full = odd.is_some() || jobs.0.is_empty() || sent.elapsed() > HOLD;
            if !full {
                continue;
            }
            if !setup.careful && before.traces.has_other_signals() {
                // Any of the points since the last look may have changed them: only the first of these was surely sound.
                said.truncate(end_of_first);
                mark(Some(Odd::Signals), &mut said[1..]);
                return place.send(&said);
            }
            mark(odd, &mut said[at..]);
            place.send(&said);
            if odd.is_some() {
                return;
            }
            said.truncate(1);
            (sent, first) = (Instant::now(), None);
        }
    }
}

/// Appends why a point has no results.
fn put(index: u64, times: [f32; 2], failure: &Failure, runner: &Runner, said: &mut Vec<u8>) {
    let failure = failure.clone();
    let trouble = if runner.was_refused() {
        let licence = false;
        Trouble::Refused { failure, licence }
    } else {
        let said = runner.notices().clone();
        let notices = Notices {
            warnings: said.warnings,
            first_warning: said.first_warning,
            ..Notices::default()
        };
        let notices = Box::new(notices);
        Trouble::Failed { failure, notices }
    };
    put_trouble(index, times, &trouble, said);
}

/// Runs a point and sends its trajectory.
fn record(mut place: Place, setup: &Setup, package: Option<&mut Package>, record: &Record) {
    const FULL: usize = 1 << 16;
    let Some(library) = loaded(&mut place, setup, package, None) else {
        return;
    };
    let Some(case) = setup.cases.first() else {
        return;
    };
    let mut runner = Runner::new(library, case.task.clone());
    let (mut said, mut sent) = (vec![speech::ROWS], Instant::now());
    put_end(&End::Not, &mut said);
    let empty = said.len();
    let ended = runner.trajectory(&record.values, |time, instance| {
        put_value(&Value::Real(time), &mut said);
        for &column in &record.columns {
            put_value(&instance.value(column)?, &mut said);
        }
        if said.len() > FULL || sent.elapsed() > HOLD {
            place.send(&said);
            said.truncate(empty);
            sent = Instant::now();
        }
        Ok(())
    });
    place.send(&said);
    let end = match ended {
        Ok(()) => {
            tell(runner.notices());
            End::Done
        }
        Err(failure) => End::Failed(failure),
    };
    said.truncate(1);
    put_end(&end, &mut said);
    place.send(&said);
    runner.end();
    if let Some(error) = &runner.notices().unfinished {
        crate::tell::line!("note: the simulation is whole, but its end failed: {error}");
    }
}

/// Tells whoever watches what a trajectory does not show. Standard error is shown to the user.
fn tell(notices: &Notices) {
    if let Some(time) = notices.ended {
        crate::tell::line!(
            "note: the FMU ended the simulation at {time} s (fmi2Discard with fmi2Terminated, in FMI 3.0 terminateSimulation)"
        );
    }
    if notices.warnings > 0 {
        let first = notices.first_warning.as_deref().unwrap_or_default();
        crate::tell::line!(
            "note: warnings of the FMU: {}; the first: {first}",
            notices.warnings
        );
    }
}

/// The FMU, loaded here where the worker has not done so; the worker is told.
fn loaded(
    place: &mut Place,
    setup: &Setup,
    package: Option<&mut Package>,
    library: Option<Arc<Library>>,
) -> Option<Arc<Library>> {
    if let Some(library) = library {
        place.send(&[speech::LOADED]);
        return Some(library);
    }
    let package = package?;
    // Only a worker that fills memory is there for finding out.
    let before = setup.fill.map(|_| Belongings::now());
    match package.load() {
        Ok(library) => {
            let mut said = vec![speech::LOADED];
            said.extend(before.map(|before| u8::from(before.allow_forks(&Belongings::now()))));
            place.send(&said);
            Some(library)
        }
        Err(error) => {
            let mut said = vec![speech::UNLOADABLE];
            said.extend(error.at(&setup.name).to_string().bytes());
            place.send(&said);
            None
        }
    }
}

/// Resources of a process that its forks would lack or share.
struct Belongings {
    threads: usize,
    descriptors: BTreeSet<String>,
    /// Names of devices and of memory mapped for several processes.
    shared: BTreeSet<String>,
}

impl Belongings {
    fn now() -> Self {
        let names = |folder: &str| -> BTreeSet<String> {
            let entries = fs::read_dir(folder).into_iter().flatten().flatten();
            entries
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .collect()
        };
        let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
        let is_shared = |line: &&str| {
            let access = line.split(' ').nth(1).unwrap_or("");
            access.ends_with('s') || line.contains("/dev/")
        };
        Self {
            threads: names("/proc/self/task").len(),
            descriptors: names("/proc/self/fd"),
            shared: maps.lines().filter(is_shared).map(str::to_owned).collect(),
        }
    }

    /// Whether loading the FMU has left nothing that a fork would lack or share.
    fn allow_forks(&self, after: &Self) -> bool {
        // Where the system does not tell, there is one thread at least that is not seen.
        system::FORKS
            && self.threads == 1
            && after.threads == 1
            && after.descriptors.is_subset(&self.descriptors)
            && after.shared.is_subset(&self.shared)
    }
}

/// Lets the C library fill memory that is handed out or given back, so that what depends on it shows.
pub(crate) fn fill_memory(byte: u8) {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const M_PERTURB: i32 = -6;
        // SAFETY: sets an option of this process's C library.
        unsafe { libc::mallopt(M_PERTURB, i32::from(byte)) };
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    let _ = byte;
}

/// Fills the part of the stack that the FMU is going to use.
#[inline(never)]
fn paint_stack(byte: u8) {
    const SIZE: usize = 256 << 10;
    let mut paint = [0_u8; SIZE];
    paint.fill(byte);
    std::hint::black_box(&mut paint);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_arrives_as_it_was_sent() {
        let same = |work: &Work| {
            let mut order = Vec::new();
            work.put(&mut order).unwrap();
            assert_eq!(
                format!("{:?}", Work::of(&order).unwrap()),
                format!("{work:?}")
            );
            order
        };
        let values = vec![0.1, f64::INFINITY, -0.0, f64::NAN];
        let order = same(&Work::Alone(Job { index: 7, values }));
        assert!(Work::of(&order[..order.len() - 1]).is_err());
        same(&Work::Serve(Habit::Reset));
        same(&Work::Serve(Habit::Renew));
        let columns = Vec::new();
        same(&Work::Record(Record {
            values: vec![1.0 / 3.0],
            columns,
        }));
        assert!(Work::of(&[]).is_err());
    }
}
