//! Points of a finished study that are run once more, longer or finer: the best one for its picture, and to see whether its
//! values had settled, and some for the numerical error. None of them changes the verdict, and what fails costs itself alone.

mod best;
mod budget;
mod finer;
mod measured;
mod numerical;
mod settled;

use std::{
    fmt,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
    time::{Duration, Instant},
};

use crate::{error::Error, results::Summary, session::Verification};
use budget::Budget;
use fmu_import::{Content, Handle, Package, Value};
use fmu_points::{
    PointLimits, PointResult,
    failure::Failure,
    scratch::Scratch,
    single::Recorder,
    stop,
    task::{Case, Task},
    working_directory,
};
use point_journal::files::write_json;
use study::plan::Plan;

/// The runs that are to be made once more.
#[derive(Clone, Copy)]
pub struct Wish {
    /// So many points at the most.
    pub most: usize,
    /// Whether the numerical uncertainty is asked for.
    pub validation: bool,
    /// Whether a run is dear, so that each kind takes one at the most.
    pub dear: bool,
    /// Limits of each run.
    pub limits: PointLimits,
    /// How many runs at a time.
    pub jobs: usize,
}

/// Runs points of a finished study once more; the folder gets what they tell, and so does its summary.
///
/// # Errors
/// When the FMU cannot be unpacked, and when the summary cannot be written.
pub fn run(verification: &mut Verification, folder: &Path, summary: &mut Summary, wish: &Wish) -> Result<(), Error> {
    let reruns = Reruns::new(verification, summary, wish)?;
    let mut left_out = best::write(&reruns, folder, summary);
    left_out.extend(settled::observe(&reruns, folder, summary));
    left_out.extend(measured::write(reruns.plan(), folder, summary));
    left_out.extend(numerical::observe(&reruns, summary));
    summary.left_out = (!left_out.is_empty()).then(|| left_out.join("; "));
    Ok(write_json(&folder.join("summary.json"), summary)?)
}

/// Takes the time, s, and the signals' values then.
type Row<'a> = &'a mut dyn FnMut(f64, &[f64]) -> Result<(), Halt>;

/// Why a run has no end.
enum Halt {
    /// The time is up.
    Late,
    /// The user has ended the program.
    Interrupted,
    Failed(String),
}

impl fmt::Display for Halt {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(match self {
            Self::Late => "it would take longer than the study's points did",
            Self::Interrupted => "it was interrupted",
            Self::Failed(reason) => reason,
        })
    }
}

impl<E: std::error::Error> From<E> for Halt {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Where points are run once more.
struct Reruns<'a> {
    verification: &'a Verification,
    fmu: PathBuf,
    scratch: Scratch,
    /// Whether each run needs an unpacked FMU of its own, since it changes that.
    apart: bool,
    wish: Wish,
    /// How long a simulation of the study took.
    usual: Duration,
    budget: Budget,
}

/// Signals of a case that are read at every communication point.
struct Signals {
    /// The numbers of their criteria.
    criteria: Vec<usize>,
    handles: Vec<Handle>,
}

impl<'a> Reruns<'a> {
    fn new(verification: &'a mut Verification, summary: &Summary, wish: &Wish) -> Result<Self, Error> {
        let scratch = stop::scratch()?;
        let fmu = verification.session.package.unpack(scratch.path())?;
        let conduct = summary.conduct.as_ref();
        let verification: &Verification = verification;
        let mut reruns = Self {
            verification,
            fmu,
            scratch,
            apart: conduct.is_some_and(|conduct| conduct.changed_file.is_some()),
            wish: *wish,
            usual: Duration::ZERO,
            budget: Budget::new(Duration::ZERO),
        };
        let all = summary.points as f64;
        let run = summary.run.as_ref().filter(|run| run.computed > 0);
        let [each, took] = match run {
            // Of a study that was resumed, only some points were computed in this time.
            Some(run) => {
                let busy = run.wall_seconds * run.jobs as f64;
                let computed = run.computed as f64;
                [busy / computed, run.wall_seconds * all / computed]
            }
            None => {
                let each = reruns.time_of_a_point(summary);
                [each, each * all / wish.jobs.max(1) as f64]
            }
        };
        let seconds = |time| Duration::try_from_secs_f64(time).unwrap_or_default();
        let cases = verification.session.plan.cases.len().max(1);
        reruns.usual = seconds(each / cases as f64);
        reruns.budget = Budget::new(seconds(took));
        Ok(reruns)
    }

    fn plan(&self) -> &'a Plan {
        &self.verification.session.plan
    }

    /// How long a point takes, s, where all of them were computed by other runs.
    fn time_of_a_point(&self, summary: &Summary) -> f64 {
        let best = summary.best_point.as_ref();
        let values = best.and_then(|best| self.values(best.point));
        let begun = Instant::now();
        values
            .and_then(|values| self.answer(&self.plan().cases, values).ok())
            .map_or(0.0, |_| begun.elapsed().as_secs_f64())
    }

    /// The values of a point in the FMU's units.
    fn values(&self, point: u64) -> Option<Vec<f64>> {
        let index = self.verification.source.index_of(point)?;
        Some(self.verification.job(index).values)
    }

    fn recorder<'b>(&'b self, fmu: &'b Path) -> Recorder<'b> {
        let package = &self.verification.session.package;
        let tasks = self.plan().cases.iter().map(|case| &case.task);
        Recorder {
            fmu,
            name: package.path(),
            scratch: self.scratch.path(),
            here: working_directory::is_kept(package.description(), tasks),
            limits: self.wish.limits,
            echo: false,
        }
    }

    /// Hands over where an unpacked FMU is for a run.
    fn with_fmu<T>(&self, run: impl FnOnce(&Path) -> Result<T, Halt>) -> Result<T, Halt> {
        if !self.apart {
            return run(&self.fmu);
        }
        let again = Package::open(self.verification.session.package.path());
        let copy = again
            .and_then(|mut again| again.unpack_anew(self.scratch.path()))
            .map_err(|error| Failure::Unloadable(error.to_string()))?;
        run(copy.path())
    }

    /// Runs a point as the study does.
    fn answer(&self, cases: &[Case], values: Vec<f64>) -> Result<PointResult, Halt> {
        let job = fmu_points::Job { index: 0, values };
        self.with_fmu(|fmu| Ok(self.recorder(fmu).run(cases, &job)?))
    }

    /// The signals of a case that are real numbers, of criteria that are wanted.
    fn signals(&self, case: usize, is_wanted: impl Fn(usize) -> bool) -> Signals {
        let plan = self.plan();
        let (criteria, handles) = plan
            .criteria_of(case)
            .zip(&plan.cases[case].task.observed)
            .filter(|(criterion, probe)| probe.handle.content == Content::Real && is_wanted(*criterion))
            .map(|(k, probe)| (k, probe.handle))
            .unzip();
        Signals { criteria, handles }
    }

    /// Runs a point, and hands over time and signals, in the FMU's units, at every communication point. Without a budget it takes
    /// its time.
    fn record(
        &self,
        task: &Task,
        values: &[f64],
        signals: &Signals,
        budget: Option<&Budget>,
        row: Row,
    ) -> Result<(), Halt> {
        let left = budget.map_or(Duration::MAX, Budget::left);
        let until = Instant::now().checked_add(left.min(self.wish.limits.time));
        let in_time = || match stop::flag().load(Ordering::Relaxed) {
            true => Err(Halt::Interrupted),
            false if until.is_some_and(|until| Instant::now() >= until) => Err(Halt::Late),
            false => Ok(()),
        };
        in_time()?;
        // A finer or longer run takes no less than one of the study.
        if self.usual > left {
            return Err(Halt::Late);
        }
        let mut numbers = Vec::with_capacity(signals.handles.len());
        let mut row = |time: f64, cells: &[Value]| {
            in_time()?;
            numbers.clear();
            numbers.extend(cells.iter().map(|cell| match cell {
                Value::Real(value) => *value,
                _ => f64::NAN,
            }));
            row(time, &numbers)
        };
        let handles = &signals.handles;
        let ended = self.with_fmu(|fmu| self.recorder(fmu).of(task)?.record(values, handles, until, &mut row));
        // A point that has failed because its time was up has not failed.
        ended.map_err(|halt| in_time().err().unwrap_or(halt))
    }
}
