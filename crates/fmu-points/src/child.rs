//! A worker's child, in which the FMU runs.

use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    time::{Duration, Instant},
};

use crate::{
    failure::Failure,
    join,
    notices::Notices,
    points::{Job, Simulated},
    runner::Runner,
    single::ERRAND,
    system,
    wire::{Order, Origin, Reply, Said, Setup, Trouble, bytes, read},
};
use fmu_import::{Handle, Package, Value, archive::names_in, isolation::ChildEnd};

/// Replies of many points are held back for this time at most, when the next point is done.
const HOLD: Duration = Duration::from_millis(1);

/// All that a worker gives its children.
pub struct Estate<'a> {
    pub setup: &'a mut Setup,
    pub package: Option<&'a mut Package>,
    /// What runs points, where the worker has loaded the FMU for them: a fork has a copy of its own.
    pub runner: &'a mut Option<Box<Runner>>,
}

/// A worker's child.
pub struct Child<'a> {
    pub place: ChildEnd,
    pub estate: Estate<'a>,
}

impl Child<'_> {
    /// Does what the worker wants.
    pub fn obey(mut self, order: &Order) {
        let alone = match order {
            Order::New(jobs) | Order::Forked(jobs) => jobs.first(),
            Order::Used(_) | Order::Recorded(..) | Order::Errand(_) => None,
        };
        if let (Some(_), Some(byte)) = (alone, self.estate.setup.fill) {
            paint_stack(byte);
        }
        if let Order::Errand(task) = order {
            return self.run_errand(task);
        }
        let Some(mut runner) = self.estate.runner.take().or_else(|| self.loaded()) else {
            return;
        };
        match (order, alone) {
            (Order::Used(_), _) => self.serve(runner),
            (Order::Recorded(values, columns), _) => self.record(runner, values, columns),
            (_, Some(job)) => {
                runner.turn_to(join::case_of(job.index, self.estate.setup.cases.len()));
                self.alone(runner, job);
            }
            (_, None) => {}
        }
    }

    /// Lets the program do what it wants of the FMU. It loads that itself, so that it can tell how far it came.
    fn run_errand(&mut self, task: &[u8]) {
        self.say(&Said::Loaded(false));
        if let (Some(errand), Some(package)) = (ERRAND.get(), self.estate.package.take()) {
            errand(package, task, &mut |told| self.say(&Said::Told(told)));
        }
        self.say(&Said::Ended(None));
    }

    fn say(&mut self, said: &Said) {
        self.place.send(&bytes(said));
    }

    /// Runs one point, and tells its answer before the instance is ended.
    fn alone(&mut self, mut runner: Box<Runner>, job: &Job) {
        let instance = runner.alone(&job.values, |runner, answer| {
            self.say(&Said::Replies(vec![reply(job.index, runner, answer)]));
        });
        let notices = &runner.notices;
        if notices.unfinished.is_some() || notices.version.is_some() {
            self.say(&Said::Farewell(notices.clone()));
        }
        drop(instance);
    }

    /// Runs points until there are no further ones, or until one fails.
    fn serve(&mut self, mut runner: Box<Runner>) {
        let cases = self.estate.setup.cases.len();
        let mut replies = Vec::new();
        while let Some(jobs) = self.place.receive().and_then(|jobs| read::<Vec<Job>>(&jobs)) {
            let mut sent = Instant::now();
            let last = jobs.len();
            for (job, begun) in jobs.iter().zip(1..) {
                runner.turn_to(join::case_of(job.index, cases));
                let failure = runner.run(&job.values).err();
                let answer = failure.as_ref().map_or(Ok(runner.results()), Err);
                replies.push(reply(job.index, &runner, answer));
                if failure.is_none() && begun < last && sent.elapsed() <= HOLD {
                    continue;
                }
                self.say(&Said::Replies(std::mem::take(&mut replies)));
                if failure.is_some() {
                    return;
                }
                sent = Instant::now();
            }
        }
    }

    /// Runs a point and sends its trajectory.
    fn record(&mut self, mut runner: Box<Runner>, values: &[f64], columns: &[Handle]) {
        const FULL: usize = 1 << 13;
        let (mut rows, mut sent) = (Vec::new(), Instant::now());
        let ended = runner.trajectory(values, |time, instance| {
            rows.push(Value::Real(time));
            for &column in columns {
                rows.push(instance.value(column)?);
            }
            if rows.len() > FULL || sent.elapsed() > HOLD {
                self.say(&Said::Rows(std::mem::take(&mut rows)));
                sent = Instant::now();
            }
            Ok(())
        });
        // The last row has no end where one of its values could not be read.
        rows.truncate(rows.len() - rows.len() % (1 + columns.len()));
        self.say(&Said::Rows(rows));
        if ended.is_ok() {
            tell(&runner.notices);
        }
        self.say(&Said::Ended(ended.err()));
        runner.end();
        if let Some(error) = &runner.notices.unfinished {
            crate::tell::line!("note: the simulation is whole, but its end failed: {error}");
        }
    }

    /// What runs points, with the FMU loaded here; the worker is told.
    fn loaded(&mut self) -> Option<Box<Runner>> {
        let before = Belongings::now();
        match self.estate.package.as_mut()?.load() {
            Ok(library) => {
                let forkable = before.allow_forks(&Belongings::now());
                self.say(&Said::Loaded(forkable));
                Runner::new(library, &self.estate.setup.cases)
            }
            Err(error) => {
                self.say(&Said::Unloadable(error.at(&self.estate.setup.name).to_string()));
                None
            }
        }
    }
}

/// The reply on a point.
fn reply(index: u64, runner: &Runner, answer: Result<&[f64], &Failure>) -> Reply {
    let notices = &runner.notices;
    let answer = answer.map(|values| Simulated::new(values.to_vec(), notices));
    let answer = answer.map_err(|failure| Trouble {
        from: if runner.refused { Origin::Refusal { licence: false } } else { Origin::Fmu },
        failure: failure.clone(),
        notices: Box::new(Notices {
            warnings: notices.warnings,
            first_warning: notices.first_warning.clone(),
            beyond: notices.beyond.clone(),
            ..Notices::default()
        }),
        passing: false,
    });
    Reply::new(index, answer)
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
        crate::tell::line!("note: warnings of the FMU: {}; the first: {first}", notices.warnings);
    }
    for limit in &notices.beyond {
        crate::tell::line!("note: beyond what the model is valid for, as the FMU says: {limit}");
    }
}

/// Whether a line of a process's maps is that of a device, or of memory mapped for several processes.
fn is_shared(line: &&str) -> bool {
    line.split(' ').nth(1).is_some_and(|access| access.ends_with('s'))
        || line.contains(" /dev/") && !line.contains(" /dev/shm")
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
        let names = |folder: &'static str| names_in(Path::new(folder));
        let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
        Self {
            threads: names("/proc/self/task").count(),
            descriptors: names("/proc/self/fd").collect(),
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
pub fn fill_memory(byte: u8) {
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
    fn a_device_is_shared_and_a_library_is_not() {
        let mapped = |access: &str, path: &str| format!("7f00-7f01 {access} 00000000 00:1a 77          {path}");
        for (access, path, shared) in [
            ("rw-s", "/tmp/numbers", true),
            ("rw-s", "/dev/shm/numbers", true),
            ("rw-p", "/dev/nvidia0", true),
            ("r-xp", "/dev/shm/fmu/lag.so", false),
            ("r-xp", "/home/dev/lag.so", false),
            ("rw-p", "", false),
        ] {
            assert_eq!(is_shared(&&*mapped(access, path)), shared, "{access} {path}");
        }
    }
}
