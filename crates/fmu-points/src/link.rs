//! The connection to a worker that a launcher has started: its messages, its silence, and how it ended.
//!
//! Two threads serve a link. One owns the launcher's standard input and writes orders there until the link drops its end of their
//! queue. The other one owns its standard error and ends when that is closed. The link joins neither: a process that the launcher
//! leaves behind may hold these pipes for ever.

mod last_line;

use std::{
    process::{Child, ChildStdin, Stdio},
    sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use fmu_import::isolation::frame::{self, Inbox};

use crate::{
    dispatch::{Greeting, Order, Report, WorkerFault, beat},
    launcher::{Launcher, RemoteAddress},
    process, system,
    wire::{bytes, read},
};
use last_line::LastLine;

/// The argument that makes this program a worker for a supervisor elsewhere.
pub const REMOTE: &str = "fmu-points-remote";

/// How often a waiting supervisor looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(100);
/// So many bytes of what a launcher prints before a worker's greeting are looked through at a time.
const NOISE: usize = 1 << 16;
/// How long a launcher may take to end once its worker has nobody to serve.
const PARTING: Duration = Duration::from_secs(2);
/// How long it may take when it is asked to.
const FAREWELL: Duration = Duration::from_millis(500);

/// The message for bytes that are no frame. Only the worker's own code writes to its output, so the connection has changed them or
/// added some.
const MIXED: &str = "what came is not what a worker sends: the launcher must start one worker, and pass on its input and \
                     output unchanged, without a terminal or labels";

/// A ticket and the payload that goes under it. The first frame, which names the ticket of all others, goes under 0.
type Frame = (u64, Vec<u8>);

/// A worker's connection.
#[derive(Debug)]
pub struct Link {
    launcher: Child,
    /// Frames on their way; none when the worker is to end.
    orders: Option<Sender<Frame>>,
    reports: Inbox<system::ReplyPipe>,
    ticket: u64,
    said: LastLine,
    patience: Duration,
    heard: Instant,
}

impl Link {
    /// Starts a worker. It has not answered yet.
    pub fn start(place: &RemoteAddress, launcher: &Launcher) -> Result<Self, String> {
        let mut command = place.command(launcher, REMOTE);
        let mut child = system::set_apart(&mut command)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{}: {error}", command.get_program().display()))?;
        let streams = (child.stdin.take(), child.stdout.take(), child.stderr.take());
        let (Some(input), Some(output), Some(errors)) = streams else { unreachable!("each is a pipe") };
        process::launchers().insert(child.id());
        let (orders, frames) = channel();
        let mut link = Self {
            launcher: child,
            orders: Some(orders),
            reports: Inbox::new(system::source(output), 0),
            ticket: 0,
            said: LastLine::default(),
            patience: launcher.patience,
            heard: Instant::now(),
        };
        // Where a thread cannot be had, the link is dropped, which ends the launcher.
        link.said.listen(errors)?;
        let beat = beat(launcher.patience);
        thread(move || write(input, &frames, beat))?;
        Ok(link)
    }

    /// Waits for the worker's greeting, whatever the launcher prints before it; none while there is none.
    pub fn greeting(&mut self) -> Result<Option<Greeting>, String> {
        if !system::is_ready(&mut self.reports, LOOK) {
            return Ok(None);
        }
        let is_open = self.reports.read().unwrap_or(false);
        let seen = self.reports.seen();
        if let Some((greeting, end)) = Greeting::find(seen) {
            self.reports.skip(end);
            return Ok(Some(greeting));
        }
        if !is_open {
            self.said.hear(seen);
            return Err(self.ending());
        }
        if seen.len() > NOISE {
            // The second half may end with the beginning of a greeting.
            let passed = seen.len() - NOISE / 2;
            self.said.hear(&seen[..passed]);
            self.reports.skip(passed);
        }
        Ok(None)
    }

    /// What a launcher that has started no worker has printed so far.
    pub fn last_words(&self) -> String {
        self.said.told(self.reports.seen())
    }

    /// Sends the first message; all further ones have this ticket.
    pub fn open(&mut self, terms: Vec<u8>, ticket: u64) {
        self.send(terms);
        self.ticket = ticket;
        self.reports.expect(ticket);
        self.order(&Order::Beat);
    }

    pub fn order(&mut self, order: &Order) {
        self.send(bytes(order));
        self.heard = Instant::now();
    }

    fn send(&mut self, payload: Vec<u8>) {
        if let Some(orders) = &self.orders {
            // Where that fails the connection is lost, which shows when an answer is waited for.
            let _ = orders.send((self.ticket, payload));
        }
    }

    /// The next message that says something; none where nobody waits for it any more.
    pub fn wait(&mut self, stopped: &dyn Fn() -> bool) -> Result<Option<Report>, WorkerFault> {
        loop {
            match self.arrived().map_err(WorkerFault::passing)? {
                Some(Report::Beat) => continue,
                None if stopped() => return Ok(None),
                None => self.read().map_err(WorkerFault::passing)?,
                report => return Ok(report),
            }
        }
    }

    /// The next message that has come whole.
    fn arrived(&mut self) -> Result<Option<Report>, &'static str> {
        // A worker ends each frame with a line break.
        while self.reports.seen().first() == Some(&b'\n') {
            self.reports.skip(1);
        }
        let payload = self.reports.arrived().map_err(|_| MIXED)?;
        payload.map(|payload| read(&payload).ok_or("its answer is damaged")).transpose()
    }

    /// Reads what comes next, unless nothing comes for a moment.
    fn read(&mut self) -> Result<(), String> {
        if system::is_ready(&mut self.reports, LOOK) {
            self.heard = Instant::now();
            if !self.reports.read().unwrap_or(false) {
                return Err(self.ending());
            }
        } else if self.is_silent() {
            return Err(format!("nothing came from it for {} s", self.patience.as_secs_f64()));
        }
        Ok(())
    }

    fn is_silent(&self) -> bool {
        self.heard.elapsed() > self.patience
    }

    /// How the launcher ended, whose output is closed.
    fn ending(&mut self) -> String {
        let status = process::wait_for_end(&mut self.launcher, Duration::from_secs(1));
        self.said.settle();
        let status = status.map_or_else(|| "its output was closed".to_owned(), |status| status.to_string());
        format!("the launcher ended ({status}){}", self.last_words())
    }

    /// Lets the worker end: it does, with all that it has started, when nobody can send it orders any more.
    pub fn part(&mut self) {
        self.orders = None;
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        self.part();
        // A launcher without a worker, or with a silent one, is not waited for.
        let patience = if self.ticket == 0 || self.is_silent() { Duration::ZERO } else { PARTING };
        if process::wait_for_end(&mut self.launcher, patience).is_none() {
            system::ask_to_end(self.launcher.id());
        }
        if process::wait_for_end(&mut self.launcher, FAREWELL).is_none() {
            system::kill_group(self.launcher.id());
            let _ = self.launcher.kill();
            let _ = self.launcher.wait();
        }
        process::launchers().remove(&self.launcher.id());
    }
}

fn thread(work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, String> {
    thread::Builder::new().spawn(work).map_err(|error| format!("no thread for the launcher's pipes: {error}"))
}

/// Writes frames, and signs of life between them once there was one; ends with their sender, or when nobody reads them.
fn write(mut to: ChildStdin, frames: &Receiver<Frame>, beat: Duration) {
    let mut last = 0;
    loop {
        let (ticket, payload) = match frames.recv_timeout(beat) {
            Ok(frame) => frame,
            Err(RecvTimeoutError::Timeout) if last != 0 => (last, bytes(&Order::Beat)),
            Err(RecvTimeoutError::Timeout) => continue,
            Err(RecvTimeoutError::Disconnected) => return,
        };
        last = ticket;
        if frame::write(&mut to, ticket, &payload).is_err() {
            return;
        }
    }
}
