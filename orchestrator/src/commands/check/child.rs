//! A process in which an FMU is probed: the side that waits for it.

use std::fs::{self, File};
use std::io;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::probe::{COMMAND, Report, Setup};
use crate::engine::guard;
use crate::engine::process::{marked, program};
use crate::pipeline::stop;
use fmu_import::isolation::keeper::signal_name;

/// The most memory that a probe may use, bytes.
const MEMORY: u64 = 8 << 30;

/// The fate of a probe that takes too long.
pub(super) const TIMEOUT: &str = "timeout";

/// The outcome of a probe.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    /// Its observations, up to where it came.
    pub(super) report: Option<Report>,
    /// How its process ended, where that was not in order, and during which call.
    pub(super) fate: Option<String>,
    pub(super) stage: String,
}

/// Runs a probe. `fill` is what glibc fills fresh and freed memory with.
pub(super) fn run(setup: &Setup, patience: Duration, fill: Option<u8>) -> io::Result<Outcome> {
    let description = setup.result.with_extension("setup");
    fs::write(&description, serde_json::to_vec(setup)?)?;
    for file in [&setup.result, &setup.stage] {
        let _ = fs::remove_file(file);
    }
    // Files cannot be filled up and block, as pipes can.
    let heard = setup.result.with_extension("heard");
    let words = File::create(&heard)?;
    let mut command = Command::new(program()?);
    marked(&mut command)
        .arg0("orchestrator")
        .arg(COMMAND)
        .arg(&description)
        .stdin(Stdio::null())
        .stdout(words.try_clone()?)
        .stderr(words)
        .env_remove("MALLOC_PERTURB_")
        .process_group(0);
    if let Some(fill) = fill {
        command.env("MALLOC_PERTURB_", fill.to_string());
    }
    let mut child = command.spawn()?;
    let end = wait(&mut child, patience);
    stop::give_way();
    end_all(&mut child);
    let stage = fs::read_to_string(&setup.stage).unwrap_or_default();
    let report = fs::read(&setup.result).ok();
    Ok(Outcome {
        report: report.and_then(|bytes| serde_json::from_slice(&bytes).ok()),
        fate: fate(end?, &heard),
        stage,
    })
}

/// How a process ended, or which limit ended it.
enum End {
    Status(ExitStatus),
    Limit(&'static str),
}

fn wait(child: &mut Child, patience: Duration) -> io::Result<End> {
    const LOOK: Duration = Duration::from_millis(2);
    let begun = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(End::Status(status));
        }
        if begun.elapsed() > patience {
            return Ok(End::Limit(TIMEOUT));
        }
        if memory(child.id()) > MEMORY {
            return Ok(End::Limit("out of memory"));
        }
        thread::sleep(LOOK);
    }
}

/// The memory that a process occupies, bytes; 0 where that is not known.
fn memory(process: u32) -> u64 {
    const PAGE: u64 = 4096;
    let text = fs::read_to_string(format!("/proc/{process}/statm")).unwrap_or_default();
    let pages = text
        .split(' ')
        .nth(1)
        .and_then(|text| text.parse::<u64>().ok());
    pages.unwrap_or(0) * PAGE
}

/// Ends the process and all that it has started in its group.
fn end_all(child: &mut Child) {
    if let Ok(group) = i32::try_from(child.id()) {
        // SAFETY: sends a signal to the group that the child was started in; a group that is gone is no harm.
        unsafe { libc::kill(-group, libc::SIGKILL) };
    }
    let _ = child.kill();
    let _ = child.wait();
}

/// The fault at the end of the process, with the FMU's last output.
fn fate(end: End, heard: &Path) -> Option<String> {
    let status = match end {
        End::Limit(limit) => return Some(limit.to_owned()),
        End::Status(status) => status,
    };
    if let Some(signal) = status.signal() {
        let text = fs::read(heard).unwrap_or_default();
        let text = String::from_utf8_lossy(&text[text.len().saturating_sub(4096)..]).into_owned();
        let last = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        let name = signal_name(signal);
        return Some(last.map_or(name.clone(), |last| format!("{name}: {last}")));
    }
    match status.code() {
        Some(0) => None,
        Some(guard::UNABLE) => Some(guard::MUTE.to_owned()),
        code => Some(format!(
            "the FMU ended its process with code {}",
            code.unwrap_or(-1)
        )),
    }
}
