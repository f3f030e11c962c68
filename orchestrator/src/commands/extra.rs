//! Extra runs of some points of a study, with finer communication steps and a later end, to see whether the values
//! that were judged had come to rest.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::CommandError;
use crate::engine::process::Limits;
use crate::engine::single::Recorder;
use crate::engine::working_directory;
use crate::engine::{EngineError, Job};
use crate::failure::Failure;
use crate::pipeline::stop;
use crate::results::Summary;
use crate::session::Verification;
use crate::study::plan::Plan;
use crate::task::{Schedule, Task};
use fmu_import::{Content, Handle, Package, Value};

/// The extra runs take no more than this part of the study's time, but may take [`PATIENCE`].
const PART: f64 = 0.2;
/// So long the extra runs of a short study may take, s, and all of those of which the study's time is not known.
const PATIENCE: f64 = 30.0;
/// The fewest communication steps of the study's part of a run.
const FEWEST: u64 = 5000;
/// The most: more would only take memory.
const MOST: u64 = 500_000;

/// A run with the signals of the criteria, in the criteria's units.
#[derive(Debug, Default)]
pub(super) struct Watched {
    /// The point's number.
    pub(super) point: u64,
    /// When, s.
    pub(super) time: Vec<f64>,
    /// A signal for each of the plan's probes; empty for those that are no real numbers.
    pub(super) signals: Vec<Vec<f64>>,
}

/// The extra runs of a study.
#[derive(Debug, Default)]
pub(super) struct Extra {
    /// The communication step, s.
    pub(super) step: f64,
    /// Those that came at least as far as the study's end, in the order in which the points were chosen.
    pub(super) runs: Vec<Watched>,
    /// Why others are missing.
    pub(super) reason: Option<String>,
}

/// Why a run ended.
#[derive(Debug)]
enum Halt {
    /// The time is up.
    Late,
    Failed(String),
}

impl From<Failure> for Halt {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure.to_string())
    }
}

impl From<EngineError> for Halt {
    fn from(error: EngineError) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Runs the points that the summary names once more, but at most so many. Points run in processes of their own, as many at a time as in the
/// study.
pub(super) fn runs(
    verification: &mut Verification,
    summary: &Summary,
    most: usize,
) -> Result<Extra, CommandError> {
    let points = summary.rest.as_ref().map(|rest| &rest.points[..]);
    let points = points.unwrap_or_default();
    if points.is_empty() {
        return Ok(Extra::default());
    }
    if most == 0 {
        return Ok(Extra {
            reason: Some("--extra-runs 0 asked for none".to_owned()),
            ..Extra::default()
        });
    }
    let points = &points[..most.min(points.len())];
    let cases = verification.session.plan.cases.iter();
    let schedules: Option<Vec<Schedule>> = cases.map(|case| finer(&case.task.schedule)).collect();
    let Some(finer) = schedules else {
        return Ok(Extra {
            reason: Some("its communication steps are too many to be made finer".to_owned()),
            ..Extra::default()
        });
    };
    let scratch = stop::scratch()?;
    let fmu = verification.session.package.unpack(scratch.path())?;
    let stage = Stage {
        verification,
        fmu: &fmu,
        scratch: scratch.path(),
        apart: summary
            .conduct
            .as_ref()
            .is_some_and(|conduct| conduct.changed_file.is_some()),
        finer,
        deadline: Instant::now() + allowance(summary),
    };
    let jobs = summary.run.as_ref().map_or(1, |run| run.jobs).max(1);
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..jobs.min(points.len()) {
            scope.spawn(|| {
                loop {
                    // Every case of a point is a run.
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    let count = stage.finer.len().max(1);
                    let Some(&point) = points.get(number / count) else {
                        return;
                    };
                    let run = stage.run(point, number % count);
                    if let Ok(mut found) = found.lock() {
                        found.push((number, run));
                    }
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap_or_default();
    found.sort_by_key(|(number, _)| *number);
    let steps = stage.finer.iter().map(|schedule| schedule.step);
    let mut extra = Extra {
        step: steps.fold(0.0, f64::max),
        ..Extra::default()
    };
    for (_, run) in found {
        match run {
            Ok(run) => extra.runs.push(run),
            Err(halt) => {
                extra.reason.get_or_insert(match halt {
                    Halt::Late => {
                        "the extra runs would take more than a fifth of the study's time".to_owned()
                    }
                    Halt::Failed(failure) => {
                        format!("with steps of {:.4} s the FMU fails: {failure}", extra.step)
                    }
                });
            }
        }
    }
    Ok(extra)
}

/// How long all extra runs may take.
fn allowance(summary: &Summary) -> Duration {
    let part = summary.run.as_ref().filter(|run| run.computed > 0);
    let part = part.map_or(0.0, |run| {
        // Of a study that was resumed, only a part was computed in this time.
        PART * run.wall_seconds * summary.points as f64 / run.computed as f64
    });
    Duration::from_secs_f64(part.max(PATIENCE))
}

/// Finer steps than those of a study: shorter by the golden ratio at least. A period of which the study's step is a
/// multiple is then met at all its phases, as no ratio is worse approximated by a fraction (Hurwitz 1891).
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss
)]
fn finer(schedule: &Schedule) -> Option<Schedule> {
    let mut schedule = *schedule;
    // Where only the final value counts, a leap may leave nothing to look at.
    schedule.leap &= schedule.window_start < schedule.stop;
    let begin = schedule.points().at(schedule.first_even());
    let even = schedule.stop - begin;
    let steps = (schedule.steps() - schedule.first_even()) as f64;
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    // The least power of the golden ratio that makes the steps many enough.
    let mut ratio = golden;
    while steps * ratio < FEWEST as f64 {
        ratio *= golden;
    }
    let count = (steps * ratio).round() as u64;
    let valid = even > 0.0 && count <= MOST;
    // All steps are equal up to the study's end, as some FMUs want it.
    valid.then(|| Schedule {
        step: even / count as f64,
        ..schedule
    })
}

/// The same steps up to a later end: twice as late, or so that the steps are three times as many.
fn longer(schedule: &Schedule) -> Schedule {
    const LONGER: f64 = 3.0;
    let begin = schedule.points().at(schedule.first_even());
    let further = (schedule.stop - schedule.start).min(LONGER * (schedule.stop - begin));
    let further = (further / schedule.step).round() * schedule.step;
    Schedule {
        stop: schedule.stop + further,
        ..*schedule
    }
}

/// Where the extra runs are made.
struct Stage<'a> {
    verification: &'a Verification,
    fmu: &'a Path,
    /// For folders of single runs.
    scratch: &'a Path,
    /// Whether each run needs an unpacked FMU of its own, since it changes that.
    apart: bool,
    /// By case.
    finer: Vec<Schedule>,
    deadline: Instant,
}

impl Stage<'_> {
    /// Runs a point in one case with finer steps: on to a later end where the FMU allows it, else to its own.
    fn run(&self, point: u64, case: usize) -> Result<Watched, Halt> {
        let Some(index) = self.verification.source.index_of(point) else {
            return Err(Halt::Failed(format!("there is no point {point}")));
        };
        let job = self.verification.job(index);
        let plan = &self.verification.session.plan;
        // After the end of a recording its last value would hold for ever.
        let (own, finer) = (&plan.cases[case].task, self.finer[case]);
        let ends = match own.inputs.is_empty() {
            true => vec![longer(&finer), finer],
            false => vec![finer],
        };
        let mut failure = Halt::Late;
        for schedule in ends {
            let task = Task {
                schedule,
                ..own.clone()
            };
            let mut watched = Watched {
                point,
                ..Watched::default()
            };
            let ended = self.record(&task, &job, (plan, case), &mut watched);
            let last = watched.time.last().copied().unwrap_or(f64::NEG_INFINITY);
            // Further than the study is enough, whatever becomes of the run then.
            if ended.is_ok() || last >= finer.stop * (1.0 - 1e-9) {
                return Ok(watched);
            }
            failure = ended.err().unwrap_or(Halt::Late);
            if self.is_late() {
                break;
            }
        }
        Err(failure)
    }

    fn is_late(&self) -> bool {
        Instant::now() >= self.deadline || stop::flag().load(Ordering::Relaxed)
    }

    fn record(
        &self,
        task: &Task,
        job: &Job,
        (plan, case): (&Plan, usize),
        watched: &mut Watched,
    ) -> Result<(), Halt> {
        let left = self.deadline.saturating_duration_since(Instant::now());
        if left.is_zero() || self.is_late() {
            return Err(Halt::Late);
        }
        let package = &self.verification.session.package;
        let own = self.apart.then(|| {
            let again = Package::open(package.path());
            again.and_then(|mut again| again.unpack_anew(self.scratch))
        });
        let own = own.transpose();
        let own = own.map_err(|error| Failure::Unloadable(error.to_string()))?;
        let recorder = Recorder {
            fmu: own.as_ref().map_or(self.fmu, |own| own.path()),
            name: package.path(),
            home: working_directory::home(self.scratch, package.description(), [task]),
            limits: Limits {
                time: left,
                memory: 16 << 30,
            },
            echo: false,
        };
        let probes: Vec<usize> = (0..task.observed.len())
            .filter(|&k| task.observed[k].handle.content == Content::Real)
            .collect();
        let columns: Vec<Handle> = probes.iter().map(|&k| task.observed[k].handle).collect();
        // Those of other cases stay empty.
        let first = plan.criteria_of(case).start;
        watched.signals = vec![Vec::new(); plan.outputs.len()];
        recorder.record(task, &job.values, &columns, |time, row| {
            if self.is_late() {
                return Err(Halt::Late);
            }
            watched.time.push(time);
            for (value, &k) in row.iter().zip(&probes) {
                let Value::Real(value) = value else { continue };
                watched.signals[first + k].push(plan.outputs[first + k].value(*value));
            }
            Ok(())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finer_steps_are_no_fraction_of_the_study_s() {
        for (stop, step) in [(1000.0, 1.0), (150.0, 150.0), (15_000.0, 1.0), (2.0, 0.01)] {
            let study = Schedule {
                start: 0.0,
                stop,
                step,
                window_start: 0.0,
                leap: false,
                tolerance: None,
            };
            let fine = finer(&study).unwrap();
            assert!(fine.steps() >= FEWEST && fine.step < step / 1.6, "{fine:?}");
            // Of the phases that a period has which is a fraction of the study's step, none is far from those seen.
            for part in [1.0, 2.0, 7.0] {
                let phases = (0..200).map(|k| (f64::from(k) * fine.step * part / step).fract());
                let mut phases: Vec<f64> = phases.collect();
                if fine.step * part * 200.0 < step {
                    continue;
                }
                phases.sort_by(f64::total_cmp);
                let gap = phases.windows(2).map(|pair| pair[1] - pair[0]);
                assert!(gap.fold(0.0, f64::max) < 0.1, "{stop} {step} {part}");
            }
            let on = longer(&fine);
            assert!((on.stop / stop - 2.0).abs() < 1e-9);
            assert_eq!(on.steps(), 2 * fine.steps());
        }
        let leap = Schedule {
            start: 0.0,
            stop: 1000.0,
            step: 0.1,
            window_start: 999.0,
            leap: true,
            tolerance: None,
        };
        let fine = finer(&leap).unwrap();
        assert_eq!(longer(&fine).stop, 1003.0);
        let many = Schedule {
            step: 1e-4,
            window_start: 0.0,
            ..leap
        };
        assert_eq!(finer(&many), None);
    }
}
