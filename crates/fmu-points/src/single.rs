//! Single points in a process of their own: what the FMU does to it is one clear failure.

use std::{
    cell::Cell,
    path::Path,
    sync::{Arc, OnceLock},
    time::{Duration, Instant},
};

pub use crate::wire::{bytes, read};
use crate::{
    failure::Failure,
    points::{Job, PointLimits, PointResult, RunError},
    process::{Gone, Process},
    room::Room,
    task::{Case, Task},
    wire::{Order, Origin, Said},
};
use fmu_import::{Handle, Package, Value};

/// Takes a row of a trajectory: the time, s, and the values then.
type Row<'a, E> = &'a mut dyn FnMut(f64, &[Value]) -> Result<(), E>;

/// What a program wants of an FMU in a process of its own, which may be lost: it gets the FMU and its task, and tells what
/// it sees as it goes. [`bytes`] and [`read`] make messages of plain data.
pub type Errand = fn(&mut Package, &[u8], &mut dyn FnMut(Vec<u8>));

/// The errand of this program, where it has one.
pub(crate) static ERRAND: OnceLock<Errand> = OnceLock::new();

/// Where and within which limits single points are run.
#[derive(Clone, Copy, Debug)]
pub struct Recorder<'a> {
    /// The folder of the unpacked FMU.
    pub fmu: &'a Path,
    /// The FMU's path as the user gave it.
    pub name: &'a Path,
    /// Where folders are made for the FMU's temporary files, and for its working directory unless it has this process's own.
    pub scratch: &'a Path,
    /// Whether it has this process's working directory.
    pub here: bool,
    /// Limits of the point; the time limit is for each wait between two messages of the process.
    pub limits: PointLimits,
    /// Whether what the FMU prints is shown on standard error.
    pub echo: bool,
}

impl Recorder<'_> {
    fn process(&self, cases: &[Case]) -> Result<Process, RunError> {
        let mut process = Process::new(self.fmu, self.name, cases, self.limits);
        process.setup.echo = self.echo;
        let room = Room::take(self.scratch).map_err(|error| RunError::Start(error.to_string()))?;
        process.live_in(&Arc::new(room), self.here);
        Ok(process)
    }

    /// Runs a point as a study does, each case in a new process; a point that fails is tried once more.
    ///
    /// # Errors
    /// When no process can be started, or the FMU cannot be loaded.
    pub fn run(&self, cases: &[Case], job: &Job) -> Result<PointResult, RunError> {
        let first = self.answer(cases, job)?;
        match first {
            Ok(_) => Ok(first),
            Err(_) => self.answer(cases, job),
        }
    }

    fn answer(&self, cases: &[Case], job: &Job) -> Result<PointResult, RunError> {
        let mut answer = None;
        let mut process = self.process(cases)?;
        let run = process.run(Order::New, std::slice::from_ref(job), &|| false, &|| true, &mut |reply| {
            answer = Some(reply.answer);
        });
        match (answer, run) {
            (Some(Err(trouble)), _) if trouble.from == Origin::Loading => {
                Err(RunError::Unloadable(trouble.failure.to_string()))
            }
            // An FMU that breaks its process at the end costs no answer.
            (Some(answer), Ok(()) | Err(Gone::Lost(_))) => {
                Ok(answer.map(|simulated| simulated.values).map_err(|trouble| trouble.failure))
            }
            (None, Err(Gone::Lost(failure))) => Ok(Err(failure)),
            (None, Ok(())) => Err(RunError::Lost("it gave no answer".to_owned())),
            (_, Err(gone)) => Err(gone.into()),
        }
    }

    /// Sends this program on its errand in a new process, and hands over what that tells. The limit of the time is that of
    /// the whole; `fill` is what fills fresh and freed memory. How the process failed, if it did.
    ///
    /// # Errors
    /// When no process can be started.
    pub fn send(
        &self,
        task: Vec<u8>,
        fill: Option<u8>,
        mut take: impl FnMut(&[u8]),
    ) -> Result<Option<Failure>, RunError> {
        let until = Instant::now().checked_add(self.limits.time);
        let is_late = || until.is_some_and(|until| Instant::now() >= until);
        let mut process = self.process(&[])?;
        process.setup.fill = fill;
        let mut outcome = None;
        let ended = process.order(&Order::Errand(task), &is_late, &mut |said| {
            match said {
                Said::Told(told) => {
                    take(&told);
                    return true;
                }
                Said::Ended(failure) => outcome = failure,
                _ => outcome = Some(Failure::Crashed("its answer is damaged".to_owned())),
            }
            false
        });
        match ended {
            Ok(()) => Ok(outcome),
            Err(gone) => gone.failure().map(Some),
        }
    }

    /// Records trajectories of a task's points, one after the other.
    ///
    /// # Errors
    /// When the system gives no folder.
    pub fn of(&self, task: &Task) -> Result<Recording, RunError> {
        Ok(Recording(self.process(&[Case::only(task.clone())])?))
    }
}

/// Records trajectories of a task's points: each in a process of its own, which all have the same worker.
#[derive(Debug)]
pub struct Recording(Process);

impl Recording {
    /// Simulates a point and hands over time and columns at every communication point. One that fails is tried
    /// once more; what has been handed over is not handed over again. At `until` it has failed.
    ///
    /// # Errors
    /// When no process can be started, when the simulation fails, and what `row` returns.
    pub fn record<E: From<Failure> + From<RunError>>(
        &mut self,
        values: &[f64],
        columns: &[Handle],
        until: Option<Instant>,
        mut row: impl FnMut(f64, &[Value]) -> Result<(), E>,
    ) -> Result<(), E> {
        let order = Order::Recorded(values.to_vec(), columns.to_vec());
        let is_late = || until.is_some_and(|until| Instant::now() >= until);
        let mut handed_over = 0;
        for last in [false, true] {
            let mut number = 0;
            let mut keep = |time: f64, values: &[Value]| {
                number += 1;
                if number <= handed_over {
                    return Ok(());
                }
                handed_over = number;
                row(time, values)
            };
            let attempt = self.attempt(&order, columns.len(), &is_late, &mut keep);
            if !matches!(attempt, Ok(None)) {
                // It may be at the point still.
                self.0.end();
            }
            match attempt? {
                None => return Ok(()),
                Some(failure) if last || is_late() => return Err(failure.into()),
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// One try: the failure, if there is one.
    fn attempt<E: From<RunError>>(
        &mut self,
        order: &Order,
        columns: usize,
        is_late: &dyn Fn() -> bool,
        row: Row<'_, E>,
    ) -> Result<Option<Failure>, E> {
        // After the last result, the FMU's own end is waited for no longer than this, so that a crash in it is told. The
        // worker says a second time that it is done when the FMU has ended.
        const FAREWELL: Duration = Duration::from_secs(62);
        let mut outcome = Ok(None);
        let done: Cell<Option<Instant>> = Cell::new(None);
        let enough = || match done.get() {
            Some(done) => done.elapsed() > FAREWELL,
            None => is_late(),
        };
        let echo = self.0.setup.echo;
        let ended = self.0.order(order, &enough, &mut |said| {
            match said {
                Said::Rows(values) => {
                    let mut rows = values.chunks(1 + columns);
                    return rows
                        .try_for_each(|values| row(values[0].number(), &values[1..]))
                        .map_err(|error| outcome = Err(error))
                        .is_ok();
                }
                Said::Ended(None) => {
                    let ended = done.replace(Some(Instant::now())).is_some();
                    return echo && !ended;
                }
                Said::Ended(failure) => outcome = Ok(failure),
                _ => outcome = Err(RunError::Lost("its answer is damaged".to_owned()).into()),
            }
            false
        });
        match ended {
            Ok(()) => outcome,
            Err(_) if done.get().is_some() => outcome,
            Err(gone) => Ok(Some(gone.failure()?)),
        }
    }
}
