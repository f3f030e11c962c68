//! A process that starts children, watches them and outlives whatever they do.
//!
//! A child is a program of its own, which takes its [`Place`] from its standard streams. It lies in a job, so that it
//! ends with all that it has started; the keeper's own job ends it when the keeper is gone.

use std::fs::File;
use std::io;
use std::os::windows::io::{AsHandle, AsRawHandle, OwnedHandle};
use std::process::{ChildStdin, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use windows_sys::Win32::System::Console::{STD_INPUT_HANDLE, STD_OUTPUT_HANDLE, SetStdHandle};

use super::job::ControlGroup;
use super::pipe::Arrivals;
use super::process::{self, loss};
use super::words::Words;
use crate::isolation::frame::{self, Inbox};
pub use crate::isolation::loss::{Bounds, Loss, Parting};
use crate::isolation::loss::{DONE, MUTE};

/// How often a silent child is looked at.
const LOOK: Duration = Duration::from_millis(10);
/// How long a child may take to end after it has closed its pipe.
const PATIENCE: Duration = Duration::from_secs(1);

/// A process that keeps children.
#[derive(Debug)]
pub struct Keeper {
    words: Words,
    tickets: u64,
}

impl Keeper {
    /// A keeper; `seed` makes its frames unlike those of other keepers. With `echo`, what children print is repeated
    /// there.
    pub fn new(echo: Option<File>, seed: u64) -> Self {
        process::end_without_words();
        Self {
            words: Words::new(echo),
            tickets: seed,
        }
    }

    /// Does what may take long without a look at the superior: a job object ends this process with that.
    pub fn blindly<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }

    /// Starts a program as a child: it has to begin with [`Place::take`].
    ///
    /// # Errors
    /// When the system has no room for a further process.
    pub fn start(&mut self, command: &mut Command) -> io::Result<Child> {
        // Odd, so that every ticket of the 2^64 has its turn.
        self.tickets = self.tickets.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let ticket = self.tickets;
        let mut process = process::detach(command)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()?;
        // It waits for its ticket, so whatever it starts will be in the job.
        let group = ControlGroup::new().filter(|group| group.take(process.id()));
        let missing = || io::Error::other("a pipe to the process is missing");
        let mut orders = process.stdin.take().ok_or_else(missing)?;
        let answers = process.stdout.take().ok_or_else(missing)?;
        self.words
            .listen(process.stderr.take().ok_or_else(missing)?);
        frame::write(&mut orders, 0, &ticket.to_le_bytes())?;
        Ok(Child {
            process,
            group,
            answers: Inbox::new(Arrivals::of(answers), ticket),
            orders,
            ticket,
            gone: false,
        })
    }

    /// The last line that the last child has printed.
    pub fn last_line(&mut self) -> String {
        self.words.last_line()
    }

    /// All that is kept of what it has printed.
    pub fn text(&mut self) -> String {
        self.words.text()
    }

    /// Repeats what has been printed so far where that is wanted: here a thread has done so already.
    pub fn hear(&mut self) {}

    /// Forgets what has been printed so far.
    pub fn forget(&mut self) {
        self.words.clear();
    }
}

/// A child at work.
#[derive(Debug)]
pub struct Child {
    process: std::process::Child,
    group: Option<ControlGroup>,
    answers: Inbox<Arrivals>,
    orders: ChildStdin,
    ticket: u64,
    /// Whether it has been waited for.
    gone: bool,
}

impl Child {
    /// The memory that it occupies, bytes; 0 where that is not known.
    pub fn resident(&self) -> u64 {
        process::resident(self.process.id())
    }

    /// Sends it a message, which it must be waiting for: this blocks while it does not read.
    ///
    /// # Errors
    /// When it does not listen any more.
    pub fn send(&mut self, payload: &[u8]) -> io::Result<()> {
        frame::write(&mut self.orders, self.ticket, payload)
    }

    /// Waits for its next answer.
    ///
    /// # Errors
    /// When none comes; then only [`end`](Self::end) is left.
    pub fn answer(&mut self, keeper: &mut Keeper, bounds: Bounds) -> Result<Vec<u8>, Loss> {
        let begun = Instant::now();
        loop {
            match self.answers.arrived() {
                Ok(Some(payload)) => return Ok(payload),
                Ok(None) => {}
                Err(broken) => return Err(Loss::Garbled(broken)),
            }
            if self.answers.source_mut().wait(LOOK) {
                match self.answers.read() {
                    Ok(true) => continue,
                    // Nobody can write any more; how the child ends says why.
                    _ => return Err(self.ending(keeper)),
                }
            }
            if let Some(status) = self.ended() {
                // It may have answered just before.
                if self.answers.source_mut().wait(LOOK) {
                    continue;
                }
                keeper.words.settle();
                return Err(loss(status));
            }
            if begun.elapsed() > bounds.time {
                return Err(Loss::Timeout);
            }
            if self.resident() > bounds.memory {
                return Err(Loss::Memory);
            }
        }
    }

    fn ended(&mut self) -> Option<ExitStatus> {
        self.process.try_wait().ok().flatten()
    }

    /// How a child ends whose pipe is closed. One that only closed it must not hold us up.
    fn ending(&mut self, keeper: &mut Keeper) -> Loss {
        let patience = Instant::now() + PATIENCE;
        while Instant::now() < patience {
            if let Some(status) = self.ended() {
                keeper.words.settle();
                return loss(status);
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        Loss::Mute
    }

    /// Lets a child that has answered end by itself, but not longer than `grace`; then ends it.
    pub fn part(mut self, keeper: &mut Keeper, grace: Duration) -> Parting {
        let until = Instant::now() + grace;
        let mut open = true;
        let mut status = None;
        while Instant::now() < until && status.is_none() {
            if open && self.answers.source_mut().wait(LOOK) {
                open = matches!(self.answers.read(), Ok(true));
                continue;
            }
            status = self.ended();
            if !open && status.is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        // The last that it said may have come just before its end.
        while open && self.answers.source_mut().wait(LOOK) {
            open = matches!(self.answers.read(), Ok(true));
        }
        let mut words = None;
        while let Ok(Some(payload)) = self.answers.arrived() {
            words = Some(payload);
        }
        self.finish();
        keeper.words.settle();
        let loss = match status {
            None => Some(Loss::Timeout),
            Some(status) if status.code() == Some(DONE) => None,
            Some(status) => Some(loss(status)).filter(|loss| *loss != Loss::Mute),
        };
        Parting { words, loss }
    }

    /// Ends the child with its job at once.
    pub fn end(mut self) {
        self.finish();
    }

    fn finish(&mut self) {
        if self.gone {
            return;
        }
        self.gone = true;
        match &self.group {
            Some(group) => group.end(),
            None => drop(self.process.kill()),
        }
        let _ = self.process.wait();
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.finish();
    }
}

/// A child's own end of the pipes to its keeper.
#[derive(Debug)]
pub struct Place {
    ticket: u64,
    orders: Inbox<File>,
    answers: File,
}

impl Place {
    /// Takes standard input and output for the keeper alone: reading gives the FMU nothing, and what it prints goes to
    /// standard error, where the keeper hears it.
    ///
    /// # Errors
    /// When there is no keeper.
    pub fn take() -> io::Result<Self> {
        process::end_without_words();
        let [orders, answers] = own_streams()?;
        let mut orders = Inbox::new(orders, 0);
        let missing = || io::Error::other("no keeper has started this process");
        let ticket = orders.wait()?.ok_or_else(missing)?;
        let ticket = u64::from_le_bytes(ticket.try_into().map_err(|_| missing())?);
        orders.expect(ticket);
        Ok(Self {
            ticket,
            orders,
            answers,
        })
    }

    /// Sends an answer. A child that cannot send ends here.
    pub fn send(&mut self, payload: &[u8]) {
        if frame::write(&self.answers, self.ticket, payload).is_err() {
            process::end(MUTE);
        }
    }

    /// Waits for the keeper's next message; `None` when none will come.
    pub fn receive(&mut self) -> Option<Vec<u8>> {
        self.orders.wait().ok().flatten()
    }
}

/// Ends this process: its work is done.
pub fn leave() -> ! {
    // SAFETY: writes what the FMU has printed so far, of all streams.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    process::end(DONE)
}

/// The handles of standard input and output, which the FMU does not find any more.
fn own_streams() -> io::Result<[File; 2]> {
    let input = io::stdin().as_handle().try_clone_to_owned()?;
    let output = io::stdout().as_handle().try_clone_to_owned()?;
    let nothing = OwnedHandle::from(File::open("NUL")?);
    let error = io::stderr().as_handle().try_clone_to_owned()?;
    // SAFETY: valid handles, which stay open for as long as this process lives. The C runtime has handles of its own,
    // of which the first two are closed and replaced.
    unsafe {
        libc::dup2(2, 1);
        libc::close(0);
        SetStdHandle(STD_INPUT_HANDLE, nothing.as_raw_handle());
        SetStdHandle(STD_OUTPUT_HANDLE, error.as_raw_handle());
    }
    std::mem::forget([nothing, error]);
    Ok([input, output].map(File::from))
}

/// The name of an exception that ends processes.
pub fn signal_name(code: i32) -> String {
    let code = code.cast_unsigned();
    let name = match code {
        0xc000_0005 => "access violation",
        0xc000_0006 => "page error",
        0xc000_001d => "illegal instruction",
        0xc000_0025 => "exception that cannot be continued",
        0xc000_008c => "array bounds exceeded",
        0xc000_008e => "floating-point division by zero",
        0xc000_0094 => "integer division by zero",
        0xc000_00fd => "stack overflow",
        0xc000_013a => "Ctrl-C",
        0xc000_0374 => "heap corruption",
        0xc000_0409 => "abort",
        _ => "exception",
    };
    format!("{name} (0x{code:08X})")
}
