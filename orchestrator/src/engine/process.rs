//! Runs points in a process of its own, so that whatever an FMU does, only its point is lost.
//!
//! A worker that dies, hangs or swells is replaced, and the point that it was at is tried once
//! more on the fresh one; the second time it is marked. The worker notes the point at hand in a
//! small file, so that it is known however suddenly the process ends.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::ops::ControlFlow;
use std::os::fd::AsRawFd;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::last_words::LastWords;
use super::wire::{Reader, Setup, put_job, read_frame, write_frame};
use super::{Answer, EngineError, Job, Worker};
use crate::failure::Failure;
use crate::task::{Record, Task};

/// The hidden command that makes this program a worker.
pub const COMMAND: &str = "worker";

/// How often a waiting supervisor looks at time and memory.
const LOOK: Duration = Duration::from_millis(10);

/// What a point may use.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// The longest time that a point may take.
    pub time: Duration,
    /// The most memory that a worker may occupy, bytes.
    pub memory: u64,
}

impl Limits {
    /// No limits: for a single point, while a person is watching.
    pub const NONE: Self = Self {
        time: Duration::MAX,
        memory: u64::MAX,
    };
}

/// A worker process, replaced as needed.
#[derive(Debug)]
pub struct Process {
    program: PathBuf,
    setup: Setup,
    limits: Limits,
    child: Option<Running>,
    /// The point at which a worker was lost; the next loss at it counts.
    struck: Option<u64>,
    /// Whether what the FMU prints is shown.
    echo: bool,
}

#[derive(Debug)]
pub(super) struct Running {
    child: Child,
    jobs: ChildStdin,
    pub(super) answers: BufReader<ChildStdout>,
    pub(super) last_words: Arc<LastWords>,
}

/// Why a worker has to be replaced.
pub(super) enum Loss {
    Ended,
    Timeout,
    OutOfMemory,
}

impl Process {
    /// A worker that runs points of the FMU unpacked in `fmu`; `scratch` is a folder for its notes.
    ///
    /// # Errors
    /// When this program cannot be found, or the scratch file not be written.
    pub fn new(
        fmu: &Path,
        task: &Task,
        limits: Limits,
        scratch: &Path,
        number: usize,
    ) -> Result<Self, EngineError> {
        let start = |error: io::Error| EngineError::Start(error.to_string());
        let place = scratch.join(format!("place-{number}"));
        File::create(&place).map_err(start)?;
        let setup = Setup {
            fmu: std::path::absolute(fmu).map_err(start)?,
            task: task.clone(),
            place: std::path::absolute(place).map_err(start)?,
            supervisor: std::process::id(),
            name: fmu.to_owned(),
            record: None,
            candid: false,
        };
        Ok(Self {
            program: program().map_err(start)?,
            setup,
            limits,
            child: None,
            struck: None,
            echo: false,
        })
    }

    /// Says what the user calls the FMU, and whether what it prints is shown on standard error.
    pub(super) fn name(&mut self, name: &Path, echo: bool) {
        self.setup.name = name.to_owned();
        self.echo = echo;
    }

    /// Takes a reset at its word, and its failure as the next point's.
    pub fn be_candid(&mut self) {
        self.setup.candid = true;
    }

    /// Lets the worker run one point with its trajectory, instead of jobs.
    pub(super) fn record(&mut self, record: Record) {
        self.setup.record = Some(record);
    }

    /// The present process, started if there is none.
    pub(super) fn running(&mut self) -> Result<&mut Running, EngineError> {
        if self.child.is_none() {
            let mut running = self
                .start()
                .map_err(|error| EngineError::Start(error.to_string()))?;
            running.await_readiness(self.limits)?;
            self.child = Some(running);
        }
        let missing = || EngineError::Start("no worker".to_owned());
        self.child.as_mut().ok_or_else(missing)
    }

    fn start(&self) -> io::Result<Running> {
        let mut child = Command::new(&self.program)
            .arg0("orchestrator")
            .arg(COMMAND)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            // Ctrl-C is for the supervisor, which lets points be finished.
            .process_group(0)
            .spawn()?;
        let gone = || io::Error::other("a pipe to the worker is missing");
        let mut jobs = child.stdin.take().ok_or_else(gone)?;
        let answers = BufReader::new(child.stdout.take().ok_or_else(gone)?);
        let last_words = LastWords::listen(child.stderr.take().ok_or_else(gone)?, self.echo);
        write_frame(&mut jobs, &serde_json::to_vec(&self.setup)?)?;
        Ok(Running {
            child,
            jobs,
            answers,
            last_words,
        })
    }

    /// Sends jobs and reports answers until all are answered or the worker is lost.
    fn attempt(
        &mut self,
        jobs: &mut VecDeque<&Job>,
        report: &mut dyn FnMut(u64, Answer) -> ControlFlow<()>,
    ) -> Result<ControlFlow<(), Option<Loss>>, EngineError> {
        let limits = self.limits;
        let running = self.running()?;
        let mut payload = Vec::new();
        jobs.iter().for_each(|job| put_job(job, &mut payload));
        if write_frame(&mut running.jobs, &payload).is_err() {
            return Ok(ControlFlow::Continue(Some(Loss::Ended)));
        }
        let mut enough = false;
        while !jobs.is_empty() {
            if let Some(loss) = running.wait(limits) {
                return Ok(ControlFlow::Continue(Some(loss)));
            }
            match read_frame(&mut running.answers, &mut payload) {
                Ok(true) => {}
                Ok(false) | Err(_) => return Ok(ControlFlow::Continue(Some(Loss::Ended))),
            }
            let mut reader = Reader(&payload);
            while let Some((index, answer)) = reader.answer() {
                if jobs.pop_front().is_none_or(|job| job.index != index) {
                    return Err(EngineError::Lost("its answers are out of order".to_owned()));
                }
                enough |= report(index, answer).is_break();
            }
            if enough {
                // What it still works on is not wanted any more.
                self.replace();
                return Ok(ControlFlow::Break(()));
            }
        }
        Ok(ControlFlow::Continue(None))
    }

    /// What became of the point at which the worker was lost.
    pub(super) fn failure(&mut self, loss: &Loss) -> Failure {
        let Some(running) = &mut self.child else {
            return Failure::Crashed("the worker is gone".to_owned());
        };
        match loss {
            Loss::Timeout => Failure::Timeout,
            Loss::OutOfMemory => Failure::OutOfMemory,
            Loss::Ended => running.ending(),
        }
    }

    /// The index that the worker noted last.
    fn place(&self) -> Option<u64> {
        let bytes = fs::read(&self.setup.place).ok()?;
        Some(u64::from_le_bytes(bytes.try_into().ok()?))
    }

    /// Ends the present process; the next point gets a fresh one.
    fn replace(&mut self) {
        if let Some(mut running) = self.child.take() {
            let _ = running.child.kill();
            let _ = running.child.wait();
        }
    }

    /// Handles the loss of a worker; a point that lost two is answered with the failure.
    fn mourn(
        &mut self,
        loss: &Loss,
        jobs: &mut VecDeque<&Job>,
        report: &mut dyn FnMut(u64, Answer) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let failure = self.failure(loss);
        self.replace();
        let place = self.place();
        let Some(job) = place.and_then(|place| jobs.iter().position(|job| job.index == place))
        else {
            // It ended between points, as after fmi2Fatal.
            return ControlFlow::Continue(());
        };
        let index = jobs[job].index;
        if self.struck.replace(index) != Some(index) {
            return ControlFlow::Continue(());
        }
        self.struck = None;
        jobs.remove(job);
        report(index, Err(failure))
    }
}

impl Worker for Process {
    fn run(
        &mut self,
        jobs: &[Job],
        report: &mut dyn FnMut(u64, Answer) -> ControlFlow<()>,
    ) -> Result<(), EngineError> {
        let mut jobs: VecDeque<&Job> = jobs.iter().collect();
        // A worker that dies again and again before its first point will never do.
        let mut in_vain = 0;
        while !jobs.is_empty() {
            let before = jobs.len();
            match self.attempt(&mut jobs, report)? {
                ControlFlow::Break(()) => return Ok(()),
                ControlFlow::Continue(None) => {}
                ControlFlow::Continue(Some(loss)) => {
                    if self.mourn(&loss, &mut jobs, report).is_break() {
                        return Ok(());
                    }
                }
            }
            in_vain = if jobs.len() == before { in_vain + 1 } else { 0 };
            const TOO_OFTEN: u32 = 5;
            if in_vain == TOO_OFTEN {
                return Err(EngineError::Lost("it ends again and again".to_owned()));
            }
        }
        // A leak costs a restart now and then, long before it costs a point.
        let swollen = |running: &Running| running.memory() > self.limits.memory / 2;
        if self.child.as_ref().is_some_and(swollen) {
            self.replace();
        }
        Ok(())
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.replace();
    }
}

impl Running {
    fn await_readiness(&mut self, limits: Limits) -> Result<(), EngineError> {
        let mut reason = Vec::new();
        let lost = self.wait(limits);
        if lost.is_some() || !read_frame(&mut self.answers, &mut reason).unwrap_or(false) {
            let _ = self.child.kill();
            let ending = match lost {
                Some(Loss::OutOfMemory) => format!(
                    "it takes more memory than the {:.0} MB that a worker may; raise \
                     --memory-limit or use fewer --jobs",
                    limits.memory as f64 / f64::from(1 << 20)
                ),
                Some(Loss::Timeout) => "it takes longer than --point-timeout".to_owned(),
                Some(Loss::Ended) | None => self.ending().to_string(),
            };
            return Err(EngineError::Start(format!("loading the FMU: {ending}")));
        }
        if reason.is_empty() {
            Ok(())
        } else {
            Err(EngineError::Start(
                String::from_utf8_lossy(&reason).into_owned(),
            ))
        }
    }

    /// Waits until there is something to read, or a limit is exceeded.
    pub(super) fn wait(&mut self, limits: Limits) -> Option<Loss> {
        if !self.answers.buffer().is_empty() {
            return None;
        }
        let begun = Instant::now();
        let mut poll = libc::pollfd {
            fd: self.answers.get_ref().as_raw_fd(),
            events: libc::POLLIN,
            revents: 0,
        };
        let look = i32::try_from(LOOK.as_millis()).unwrap_or(1);
        loop {
            // SAFETY: one valid descriptor, which `self` keeps open.
            let ready = unsafe { libc::poll(&raw mut poll, 1, look) };
            if ready > 0 {
                return None;
            }
            if begun.elapsed() > limits.time {
                return Some(Loss::Timeout);
            }
            if self.memory() > limits.memory {
                return Some(Loss::OutOfMemory);
            }
        }
    }

    /// The memory that the process occupies, bytes; 0 where that is not known.
    fn memory(&self) -> u64 {
        // The second number is the resident set in pages (proc(5)).
        const PAGE: u64 = 4096;
        let text = fs::read_to_string(format!("/proc/{}/statm", self.child.id()));
        let pages = text
            .ok()
            .and_then(|text| text.split(' ').nth(1)?.parse::<u64>().ok());
        pages.unwrap_or(0) * PAGE
    }

    /// How the process ended.
    fn ending(&mut self) -> Failure {
        // Its pipes are closed, so it is ending; but one that only closed them must not hold us up.
        let deadline = Instant::now() + Duration::from_secs(5);
        let status = loop {
            match self.child.try_wait() {
                Ok(Some(status)) => break Some(status),
                Ok(None) if Instant::now() < deadline => std::thread::sleep(LOOK),
                _ => break None,
            }
        };
        let words = self.last_words.text();
        match status
            .as_ref()
            .map(|status| (status.signal(), status.code()))
        {
            Some((Some(signal), _)) => {
                let name = signal_name(signal);
                Failure::Crashed(if words.is_empty() {
                    name
                } else {
                    format!("{name}: {words}")
                })
            }
            Some((None, code)) => Failure::Exited(code.unwrap_or(-1)),
            None => Failure::Crashed("the worker closed its pipes".to_owned()),
        }
    }
}

/// This program, even when its file has been replaced since.
fn program() -> io::Result<PathBuf> {
    let own = Path::new("/proc/self/exe");
    if own.exists() {
        Ok(own.to_owned())
    } else {
        std::env::current_exe()
    }
}

/// The name of a signal that ends processes.
fn signal_name(signal: i32) -> String {
    let name = match signal {
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGABRT => "SIGABRT",
        libc::SIGFPE => "SIGFPE",
        libc::SIGILL => "SIGILL",
        libc::SIGBUS => "SIGBUS",
        libc::SIGKILL => "SIGKILL",
        libc::SIGTERM => "SIGTERM",
        libc::SIGTRAP => "SIGTRAP",
        libc::SIGPIPE => "SIGPIPE",
        other => return format!("signal {other}"),
    };
    name.to_owned()
}
