//! The worker's side of a process of its own: runs jobs until its supervisor ends.

use std::fs::File;
use std::io::{self, BufReader, Write};
use std::time::{Duration, Instant};

use super::wire::{End, Reader, Setup, put_answer, put_end, put_value, read_frame, write_frame};
use crate::failure::Failure;
use crate::run::{Runner, Trouble};
use crate::task::Record;
use fmu_import::{FmuError, Package, Value};

/// Answers are sent after this time at the latest, when the next point is done: a message a
/// point would cost more than a short point.
const HOLD: Duration = Duration::from_millis(1);

/// Serves a supervisor over standard input and output.
///
/// # Errors
/// When the supervisor cannot be understood or reached.
pub fn serve() -> io::Result<()> {
    let (input, mut output) = own_streams()?;
    let mut input = BufReader::new(input);
    let mut payload = Vec::new();
    if !read_frame(&mut input, &mut payload)? {
        return Ok(());
    }
    let setup: Setup = serde_json::from_slice(&payload)?;
    end_with(setup.supervisor)?;
    let place = File::options().write(true).open(&setup.place)?;
    let mut runner = match begin(&setup) {
        Ok(runner) => runner,
        Err(reason) => return write_frame(&mut output, reason.as_bytes()),
    };
    write_frame(&mut output, &[])?;
    if let Some(record) = &setup.record {
        return rows(&mut runner, record, &mut output);
    }
    let mut answers = Answers {
        output,
        buffer: Vec::new(),
        sent: Instant::now(),
    };
    while read_frame(&mut input, &mut payload)? {
        let mut jobs = Reader(&payload);
        while let Some(job) = jobs.job() {
            note(&place, job.index)?;
            let answer = runner.run(&job.values);
            let fatal = matches!(answer, Err(Failure::Fatal(_)));
            put_answer(job.index, &answer, &mut answers.buffer);
            // After fmi2Fatal nothing may be called any more: a fresh process goes on.
            if fatal {
                return answers.send();
            }
            answers.send_in_time()?;
        }
        answers.send()?;
    }
    Ok(())
}

fn begin(setup: &Setup) -> Result<Runner, String> {
    // The user knows the file, not the folder into which it was unpacked.
    let named = |error: FmuError| error.at(&setup.name).to_string();
    let mut package = Package::open(&setup.fmu).map_err(named)?;
    let library = package.load().map_err(named)?;
    let runner = Runner::new(library, setup.task.clone());
    Ok(if setup.candid {
        runner.candid()
    } else {
        runner
    })
}

/// Runs a point and sends its trajectory.
fn rows(runner: &mut Runner, record: &Record, mut output: impl Write) -> io::Result<()> {
    const FULL: usize = 1 << 16;
    let (mut buffer, mut sent) = (Vec::new(), Instant::now());
    put_end(&End::Not, &mut buffer);
    let ended = runner.trajectory(&record.values, |time, instance| {
        put_value(&Value::Real(time), &mut buffer);
        for &column in &record.columns {
            put_value(&instance.value(column)?, &mut buffer);
        }
        if buffer.len() > FULL || sent.elapsed() > HOLD {
            write_frame(&mut output, &buffer).map_err(|error| Trouble::Other(Stop::Gone(error)))?;
            buffer.truncate(1);
            sent = Instant::now();
        }
        Ok(())
    });
    write_frame(&mut output, &buffer)?;
    let end = match ended {
        Ok(()) => End::Done,
        Err(Stop::Failed(failure)) => End::Failed(failure),
        Err(Stop::Gone(error)) => return Err(error),
    };
    buffer.clear();
    put_end(&end, &mut buffer);
    write_frame(&mut output, &buffer)
}

/// What ends a trajectory early.
enum Stop {
    Failed(Failure),
    Gone(io::Error),
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Failed(failure)
    }
}

/// Notes the point at hand where it survives this process, whatever becomes of it.
fn note(place: &File, index: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(place, &index.to_le_bytes(), 0)
}

struct Answers<W> {
    output: W,
    buffer: Vec<u8>,
    sent: Instant,
}

impl<W: Write> Answers<W> {
    fn send_in_time(&mut self) -> io::Result<()> {
        if self.sent.elapsed() < HOLD {
            Ok(())
        } else {
            self.send()
        }
    }

    fn send(&mut self) -> io::Result<()> {
        if !self.buffer.is_empty() {
            write_frame(&mut self.output, &self.buffer)?;
            self.buffer.clear();
        }
        self.sent = Instant::now();
        Ok(())
    }
}

/// Takes standard input and output for the supervisor alone. What the FMU prints goes to
/// standard error instead, and reading gives it nothing.
fn own_streams() -> io::Result<(File, File)> {
    use std::os::fd::{AsFd, AsRawFd};
    let input = io::stdin().as_fd().try_clone_to_owned()?;
    let output = io::stdout().as_fd().try_clone_to_owned()?;
    let nothing = File::open("/dev/null")?;
    let redirections = [(nothing.as_raw_fd(), 0), (2, 1)];
    for (from, to) in redirections {
        // SAFETY: both are open descriptors of this process, and Rust's own handles of standard
        // input and output own none.
        if unsafe { libc::dup2(from, to) } < 0 {
            return Err(io::Error::last_os_error());
        }
    }
    Ok((input.into(), output.into()))
}

/// Lets the kernel end this process with its supervisor, even in an endless loop of the FMU.
fn end_with(supervisor: u32) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    // SAFETY: sets a property of this process; the arguments are plain numbers.
    if unsafe { libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // It may have ended before.
    if std::os::unix::process::parent_id() == supervisor {
        Ok(())
    } else {
        Err(io::Error::other("the supervisor has gone"))
    }
}

/// Ends this process at once: the FMU's own destructors have no say any more.
pub fn end(result: io::Result<()>) -> ! {
    if let Err(error) = &result {
        eprintln!("worker: {error}");
    }
    // SAFETY: writes what the FMU has printed so far, of all streams.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    let code = i32::from(result.is_err());
    // SAFETY: never returns, runs no code of this process.
    unsafe { libc::_exit(code) }
}
