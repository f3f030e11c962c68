//! The supervisor's side of a worker.
//!
//! A worker answers for all that becomes of its children. What may become of the worker itself (an FMU may kill its
//! parent, or stop it) is noticed here: it is looked at while it is silent, and each of its answers has a deadline.

use std::{
    collections::{BTreeMap, BTreeSet},
    io,
    path::Path,
    process::{Child, ChildStdin, Command, ExitStatus, Stdio},
    sync::{Arc, Mutex, MutexGuard, OnceLock, TryLockError},
    time::{Duration, Instant},
};

use crate::{
    failure::Failure,
    join::{Join, split},
    points::{Job, PointLimits, RunError},
    room::Room,
    system,
    task::Case,
    wire::{Order, Reply, Said, Setup, bytes, read},
    working_directory,
};
use fmu_import::{
    isolation::{
        ControlGroup, Loss,
        frame::{self, Inbox},
        keeper::signal_name,
    },
    locked,
};

/// The argument that makes this program a worker.
pub const WORKER: &str = "fmu-points-worker";

/// How often a waiting supervisor looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(20);
/// How much longer than a point, and the end of its instance, a worker's answer may take: it waits for children to end,
/// and for room to fork.
const MARGIN: Duration = Duration::from_secs(20);

/// Why a worker gives no further answers.
#[derive(Debug)]
pub enum Gone {
    /// It was lost; what becomes of the point that it was at.
    Lost(Failure),
    /// The run is to end.
    Stopped,
    /// It could not be started.
    Start(String),
    /// The FMU cannot be loaded.
    Unloadable(String),
    /// The FMU has changed the folder that points share, so its answers do not count.
    Disturbed,
}

impl Gone {
    /// What becomes of the only point of a worker, for which its end is the end of its time.
    pub fn failure(self) -> Result<Failure, RunError> {
        match self {
            Self::Stopped => Ok(Failure::Timeout),
            Self::Lost(failure) => Ok(failure),
            gone => Err(gone.into()),
        }
    }
}

impl From<Gone> for RunError {
    fn from(gone: Gone) -> Self {
        match gone {
            Gone::Lost(failure) => Self::Lost(failure.to_string()),
            Gone::Stopped => Self::Lost("the run was ended".to_owned()),
            Gone::Start(reason) => Self::Start(reason),
            Gone::Unloadable(reason) => Self::Unloadable(reason),
            Gone::Disturbed => Self::Lost("the FMU has changed its own folder".to_owned()),
        }
    }
}

/// A worker, started when it is needed and replaced when it is lost.
#[derive(Debug)]
pub struct Process {
    pub setup: Setup,
    /// The folders that its points have for themselves, once it has any.
    room: Option<Arc<Room>>,
    /// Whether it is for many points: it gets a control group where there can be such, which takes the system longer than
    /// most points.
    pub lasting: bool,
    running: Option<Running>,
}

#[derive(Debug)]
struct Running {
    child: Child,
    orders: Option<ChildStdin>,
    replies: Inbox<system::ReplyPipe>,
    ticket: u64,
    /// Whether it has ever answered.
    answered: bool,
}

impl Process {
    /// A worker for the FMU unpacked in `fmu`, which the user calls `name`.
    pub fn new(fmu: &Path, name: &Path, cases: &[Case], limits: PointLimits) -> Self {
        let setup = Setup {
            fmu: std::path::absolute(fmu).unwrap_or_else(|_| fmu.to_owned()),
            name: name.to_owned(),
            temporary: None,
            place: None,
            cases: cases.to_vec(),
            limits,
            ticket: 0,
            fill: None,
            echo: false,
        };
        Self { setup, room: None, lasting: false, running: None }
    }

    /// Gives its points folders of their own: one for temporary files, and a working directory unless they keep the user's.
    pub fn live_in(&mut self, room: &Arc<Room>, here: bool) {
        self.setup.temporary = Some(room.temporary());
        self.setup.place = (!here).then(|| room.work());
        self.room = Some(Arc::clone(room));
    }

    /// Lets points be run, and hands over what comes of each while all is `sound`. `way` makes the order of the simulations of
    /// all cases.
    pub fn run(
        &mut self,
        way: impl FnOnce(Vec<Job>) -> Order,
        jobs: &[Job],
        stopped: &dyn Fn() -> bool,
        sound: &dyn Fn() -> bool,
        answer: &mut dyn FnMut(Reply),
    ) -> Result<(), Gone> {
        let mut join = Join::new(&self.setup.cases);
        let count = self.setup.cases.len();
        let runs: Vec<Job> = jobs.iter().flat_map(|job| split(job, count)).collect();
        let (mut left, mut spoilt) = (runs.len(), false);
        let ran = self.order(&way(runs), stopped, &mut |said| {
            spoilt = !sound();
            if spoilt {
                return false;
            }
            if let Said::Replies(replies) = said {
                left = left.saturating_sub(replies.len());
                replies.into_iter().filter_map(|reply| join.add(reply)).for_each(&mut *answer);
            }
            left > 0
        });
        // What the FMU has changed may have cost the process, too.
        if spoilt || matches!(ran, Err(Gone::Lost(_))) && !sound() {
            self.end();
            return Err(Gone::Disturbed);
        }
        ran
    }

    /// Sends an order, and hands over what is said to it, while `more` says that more is to come.
    pub fn order(
        &mut self,
        order: &Order,
        stopped: &dyn Fn() -> bool,
        more: &mut dyn FnMut(Said) -> bool,
    ) -> Result<(), Gone> {
        let mut running = match self.running.take() {
            Some(running) => running,
            None => Running::start(&self.setup, self.lasting)?,
        };
        running.order(&bytes(order))?;
        while more(running.wait(self.setup.limits, stopped)?) {}
        self.running = Some(running);
        Ok(())
    }

    /// Ends the worker with all its children; the next order gets another one.
    pub fn end(&mut self) {
        self.running = None;
    }
}

impl Running {
    fn start(setup: &Setup, lasting: bool) -> Result<Self, Gone> {
        let start = |error: io::Error| Gone::Start(error.to_string());
        let mut family = family();
        system::adopt_orphans();
        let mut command = Command::new(system::program().map_err(start)?);
        setup.clear().map_err(start)?;
        if let Some(folder) = &setup.temporary {
            command.envs(["TMPDIR", "TMP", "TEMP"].map(|name| (name, folder)));
        }
        if let Some(place) = &setup.place {
            command.current_dir(place).env("PWD", place);
            command.envs(working_directory::lists_for_elsewhere());
        }
        // Ctrl-C is for the supervisor.
        let mut child = system::detach(&mut command)
            .arg(WORKER)
            .env(MARK, mark())
            // An FMU that runs Python would leave compiled modules in its own folder.
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(if setup.echo { Stdio::inherit() } else { Stdio::null() })
            .spawn()
            .map_err(start)?;
        family.insert(child.id(), None);
        drop(family);
        if lasting || system::GROUPS_ARE_NEEDED {
            // Whatever it starts will be in the group from the beginning: it waits for its first order.
            let group = ControlGroup::new().filter(|group| group.take(child.id()));
            self::family().insert(child.id(), group);
        }
        let ticket = rand::random();
        let orders = child.stdin.take();
        let replies = child.stdout.take().map(system::source);
        let replies = replies.map(|replies| Inbox::new(replies, ticket));
        let Some(replies) = replies else { return Err(Gone::Start("a pipe to the worker is missing".to_owned())) };
        let mut running = Self { child, orders, replies, ticket: 0, answered: false };
        let setup = Setup { ticket, ..setup.clone() };
        let text = serde_json::to_vec(&setup).map_err(|error| start(error.into()))?;
        running.order(&text)?;
        running.ticket = ticket;
        Ok(running)
    }

    fn order(&mut self, order: &[u8]) -> Result<(), Gone> {
        let sent = self.orders.as_mut().map(|orders| frame::write(orders, self.ticket, order));
        match sent {
            Some(Ok(())) => Ok(()),
            _ => Err(Gone::Lost(self.ending())),
        }
    }

    /// Waits for what is said next, or until the worker is given up.
    fn wait(&mut self, limits: PointLimits, stopped: &dyn Fn() -> bool) -> Result<Said, Gone> {
        let begun = Instant::now();
        loop {
            match self.replies.arrived() {
                Ok(Some(payload)) => {
                    self.answered = true;
                    return read(&payload)
                        .ok_or_else(|| Gone::Lost(Failure::Crashed("its answer is damaged".to_owned())));
                }
                Ok(None) => {}
                Err(broken) => return Err(Gone::Lost(Failure::Crashed(broken.to_string()))),
            }
            if stopped() {
                return Err(Gone::Stopped);
            }
            if system::is_ready(&mut self.replies, LOOK) {
                if !self.replies.read().unwrap_or(false) {
                    return Err(Gone::Lost(self.ending()));
                }
            } else if begun.elapsed() > limits.time.saturating_mul(2).saturating_add(MARGIN) {
                return Err(Gone::Lost(Failure::Timeout));
            } else if system::is_stopped(self.child.id()) {
                return Err(Gone::Lost(Failure::Crashed("the FMU stopped the process that watches it".to_owned())));
            }
        }
    }

    /// How the worker ended, whose pipes are closed.
    fn ending(&mut self) -> Failure {
        let status = wait_for_end(&mut self.child, Duration::from_secs(1));
        let reason = match status.map(system::loss) {
            Some(Loss::Signal(signal)) => signal_name(signal),
            // An emulator, for one, cannot start the program again: then no FMU has been loaded yet.
            Some(Loss::Exit(code)) if !self.answered => {
                return Failure::Crashed(format!(
                    "the process that watches the FMU ended before its first answer, with exit code {code}; where every point \
                     says so, the program cannot start itself here: try isolation `none`"
                ));
            }
            Some(Loss::Exit(code)) => format!("exit code {code}"),
            _ => "its pipes are closed".to_owned(),
        };
        Failure::Crashed(format!("the FMU ended the process that watches it: {reason}"))
    }
}

/// Waits for a process to end.
pub fn wait_for_end(child: &mut Child, patience: Duration) -> Option<ExitStatus> {
    let deadline = Instant::now() + patience;
    let mut pause = Duration::from_micros(50);
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if Instant::now() < deadline => std::thread::sleep(pause),
            _ => return None,
        }
        pause = (pause * 2).min(Duration::from_millis(5));
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A worker ends its children and itself when nobody can send it orders any more.
        self.orders = None;
        let sound = wait_for_end(&mut self.child, Duration::from_millis(300)).is_some_and(|end| end.success());
        if !sound {
            system::kill_group(self.child.id());
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        let group = family().remove(&self.child.id());
        // All that is still in it ends.
        drop(group);
        if !sound {
            let family = family();
            let mark = format!("{MARK}={}", mark());
            system::end_marked(&mark, |pid| family.contains_key(&pid));
        }
    }
}

/// The environment variable by which the processes of a run are known.
const MARK: &str = "FMU_POINTS_RUN";

/// Its value for the processes of this supervisor.
fn mark() -> &'static str {
    static OWN: OnceLock<String> = OnceLock::new();
    OWN.get_or_init(|| format!("{}-{:016x}", std::process::id(), rand::random::<u64>()))
}

/// The workers of this process, with their control groups where there can be such: its other children with the mark
/// have outlived theirs.
static WORKERS: Mutex<Family> = Mutex::new(Family::new());

type Family = BTreeMap<u32, Option<ControlGroup>>;

fn family() -> MutexGuard<'static, Family> {
    locked(&WORKERS)
}

/// The launchers of workers elsewhere, which end with this process's own workers.
static LAUNCHERS: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

pub fn launchers() -> MutexGuard<'static, BTreeSet<u32>> {
    locked(&LAUNCHERS)
}

/// Ends all workers of this process at once, with everything that they have started: for a process that is about to end
/// itself, whatever its threads are waiting for.
pub fn abandon_all() {
    const PATIENCE: Duration = Duration::from_millis(100);
    // Killed, a scheduler's command would leave its job in the queue.
    launchers().iter().copied().for_each(system::ask_to_end);
    let until = Instant::now() + PATIENCE;
    // A thread that is starting a worker holds the set for a moment.
    let workers = loop {
        match WORKERS.try_lock() {
            Ok(mut workers) => break std::mem::take(&mut *workers),
            Err(TryLockError::Poisoned(broken)) => break std::mem::take(&mut *broken.into_inner()),
            Err(TryLockError::WouldBlock) if Instant::now() > until => break Family::new(),
            Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(1)),
        }
    };
    for (&worker, group) in &workers {
        system::kill_worker(worker);
        group.iter().for_each(ControlGroup::end);
    }
    // Processes that a worker has adopted become this process's own when the worker ends, so look for them again then.
    let mark = format!("{MARK}={}", mark());
    while Instant::now() < until && system::end_marked(&mark, |_| false) {
        std::thread::sleep(Duration::from_millis(1));
    }
}
