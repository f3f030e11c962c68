//! The connection to a worker that a launcher has started: its messages, its silence, and its last words.

use std::{
    collections::VecDeque,
    io::{BufRead, BufReader, Read},
    process::{Child, ChildStderr, ChildStdin, Stdio},
    sync::{
        Arc, Mutex,
        mpsc::{Receiver, RecvTimeoutError, Sender, channel},
    },
    thread,
    time::{Duration, Instant},
};

use fmu_import::{
    isolation::frame::{self, Inbox},
    locked,
};

use crate::{
    dispatch::{Greeting, MAGIC, Order, Report, beat},
    launcher::{Launcher, RemoteAddress},
    process, system,
    wire::{bytes, read},
};

/// The argument that makes this program a worker for a supervisor elsewhere.
pub const REMOTE: &str = "fmu-points-remote";

/// How often a waiting supervisor looks whether it is to stop.
const LOOK: Duration = Duration::from_millis(100);
/// So much of what a launcher prints before a worker's greeting is looked through at a time.
const NOISE: usize = 1 << 16;
/// How long a launcher may take to end once its worker has nobody to serve.
const PARTING: Duration = Duration::from_secs(2);
/// How long it may take when it is asked to.
const FAREWELL: Duration = Duration::from_millis(500);

/// The message for bytes that are no frame. Only the worker's own code writes to its output, so the connection has changed them or
/// added some.
const MIXED: &str = "what came is not what a worker sends: the launcher must start one worker, and pass on its input and \
                     output unchanged, without a terminal or labels";

/// Why no message comes any more.
#[derive(Debug)]
pub enum Cut {
    /// The wait is over for another reason than the connection.
    Stopped,
    /// The connection is lost: how.
    Lost(String),
}

/// A ticket and the payload that goes under it. The first frame, which names the ticket of all others, goes under 0.
type Frame = (u64, Vec<u8>);

/// The lines that a launcher printed last.
type Words = Arc<Mutex<VecDeque<String>>>;

/// A worker's connection.
#[derive(Debug)]
pub struct Link {
    child: Child,
    /// Frames on their way; gone when the worker is to end.
    orders: Option<Sender<Frame>>,
    reports: Inbox<system::ReplyPipe>,
    ticket: u64,
    words: Words,
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
        let (Some(orders), Some(reports), Some(errors)) = streams else { unreachable!("each is a pipe") };
        process::launchers().insert(child.id());
        let words = Words::default();
        let (send, frames) = channel();
        // Where a thread cannot be had, what is dropped ends the launcher.
        let link = Self {
            child,
            orders: Some(send),
            reports: Inbox::new(system::source(reports), 0),
            ticket: 0,
            words: Arc::clone(&words),
            patience: launcher.patience,
            heard: Instant::now(),
        };
        let thread = |work: Box<dyn FnOnce() + Send>| {
            thread::Builder::new().spawn(work).map_err(|error| format!("no thread for the launcher's output: {error}"))
        };
        thread(Box::new(move || listen(errors, &words)))?;
        let beat = beat(launcher.patience);
        thread(Box::new(move || write(orders, &frames, beat)))?;
        Ok(link)
    }

    /// Waits for the worker's greeting, whatever the launcher prints before it; none while there is none.
    pub fn greeting(&mut self) -> Result<Option<Greeting>, String> {
        if !system::is_ready(&mut self.reports, LOOK) {
            return Ok(None);
        }
        let open = self.reports.read().unwrap_or(false);
        let seen = self.reports.seen();
        // The launcher may print the same word.
        let line = (0..seen.len()).filter(|&at| seen[at..].starts_with(MAGIC.as_bytes())).find_map(|at| {
            let rest = &seen[at + MAGIC.len()..];
            let end = find(rest, b"\n")?;
            Some((at + MAGIC.len() + end + 1, serde_json::from_slice(&rest[..end]).ok()?))
        });
        if let Some((length, greeting)) = line {
            self.reports.skip(length);
            return Ok(Some(greeting));
        }
        if seen.len() > NOISE || !open {
            // The beginning of a greeting may be its end.
            let passed = if open { seen.len() - NOISE / 2 } else { seen.len() };
            String::from_utf8_lossy(&seen[..passed]).lines().for_each(|line| keep(&self.words, line));
            self.reports.skip(passed);
        }
        if open { Ok(None) } else { Err(self.ending()) }
    }

    /// What a launcher that has started no worker has printed so far.
    pub fn last_words(&self) -> String {
        let words = locked(&self.words);
        let text = String::from_utf8_lossy(self.reports.seen());
        let printed = text.lines().rev().find(|line| !line.trim().is_empty());
        let said = words.back().map(String::as_str).or(printed);
        said.map(|said| format!(": {}", said.trim())).unwrap_or_default()
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

    /// The next message that says something.
    pub fn wait(&mut self, stopped: &dyn Fn() -> bool) -> Result<Report, Cut> {
        loop {
            while self.reports.seen().first() == Some(&b'\n') {
                // Each frame ends its line.
                self.reports.skip(1);
            }
            match self.reports.arrived() {
                Ok(Some(payload)) => match read(&payload) {
                    Some(Report::Beat) => continue,
                    Some(report) => return Ok(report),
                    None => return Err(Cut::Lost("its answer is damaged".to_owned())),
                },
                Ok(None) => {}
                Err(_) => return Err(Cut::Lost(MIXED.to_owned())),
            }
            if stopped() {
                return Err(Cut::Stopped);
            }
            if system::is_ready(&mut self.reports, LOOK) {
                self.heard = Instant::now();
                if !self.reports.read().unwrap_or(false) {
                    return Err(Cut::Lost(self.ending()));
                }
            } else if self.heard.elapsed() > self.patience {
                let silent = self.patience.as_secs_f64();
                return Err(Cut::Lost(format!("nothing came from it for {silent} s")));
            }
        }
    }

    /// How the launcher ended, whose output is closed.
    fn ending(&mut self) -> String {
        let status = process::wait_for_end(&mut self.child, Duration::from_secs(1));
        // Its last words are on their way.
        thread::sleep(Duration::from_millis(20));
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
        // One without a worker, or with a silent one, is not waited for.
        let silent = self.ticket == 0 || self.heard.elapsed() > self.patience;
        let patience = if silent { Duration::ZERO } else { PARTING };
        if process::wait_for_end(&mut self.child, patience).is_none() {
            system::ask_to_end(self.child.id());
        }
        if process::wait_for_end(&mut self.child, FAREWELL).is_none() {
            system::kill_group(self.child.id());
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        process::launchers().remove(&self.child.id());
    }
}

/// Sends frames, and a sign of life where there are none; ends with their sender.
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

/// Keeps the last lines of what a launcher says.
fn listen(from: ChildStderr, words: &Words) {
    let mut from = BufReader::new(from);
    let mut line = Vec::new();
    // What breaks no line is cut: it must not fill the memory.
    while (&mut from).take(NOISE as u64).read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
        keep(words, &String::from_utf8_lossy(&line));
        line.clear();
    }
}

fn keep(words: &Words, line: &str) {
    const LINES: usize = 8;
    const LONGEST: usize = 400;
    let line = line.trim();
    if line.is_empty() {
        return;
    }
    let mut words = locked(words);
    if words.len() == LINES {
        words.pop_front();
    }
    words.push_back(line.chars().take(LONGEST).collect());
}

fn find(text: &[u8], part: &[u8]) -> Option<usize> {
    text.windows(part.len()).position(|window| window == part)
}
