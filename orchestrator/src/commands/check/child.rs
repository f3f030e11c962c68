//! A process in which an FMU is probed: the side that waits for it.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::probe::{COMMAND, Report, Setup};
use fmu_import::isolation::Loss;
use fmu_import::isolation::keeper::signal_name;
use fmu_points::process::marked;
use fmu_points::stop;
use fmu_points::system::{self, Tree};
use fmu_points::worker;

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
    // Files cannot be filled up and block, as pipes can.
    let heard = setup.result.with_extension("heard");
    for file in [&setup.result, &setup.stage, &description, &heard] {
        let _ = fs::remove_file(file);
    }
    fs::write(&description, serde_json::to_vec(setup)?)?;
    let words = File::create(&heard)?;
    let mut command = Command::new(system::program()?);
    system::detach(marked(&mut command))
        .arg(COMMAND)
        .arg(&description)
        .stdin(Stdio::null())
        .stdout(words.try_clone()?)
        .stderr(words)
        .env_remove("MALLOC_PERTURB_");
    if let Some(fill) = fill {
        command.env("MALLOC_PERTURB_", fill.to_string());
    }
    let mut child = command.spawn()?;
    let tree = Tree::of(&child);
    let end = wait(&mut child, patience);
    stop::give_way();
    tree.end();
    let _ = child.kill();
    let _ = child.wait();
    let notes = fs::read_to_string(&setup.stage).unwrap_or_default();
    let stage = notes.lines().next_back().unwrap_or_default().to_owned();
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
        if system::resident(child.id()) > MEMORY {
            return Ok(End::Limit("out of memory"));
        }
        thread::sleep(LOOK);
    }
}

/// The fault at the end of the process, with the FMU's last output.
fn fate(end: End, heard: &Path) -> Option<String> {
    let status = match end {
        End::Limit(limit) => return Some(limit.to_owned()),
        End::Status(status) => status,
    };
    if status.success() {
        return None;
    }
    let loss = system::loss(status);
    if let Loss::Signal(signal) = loss {
        let text = fs::read(heard).unwrap_or_default();
        let text = String::from_utf8_lossy(&text[text.len().saturating_sub(4096)..]).into_owned();
        let last = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        let name = signal_name(signal);
        return Some(last.map_or(name.clone(), |last| format!("{name}: {last}")));
    }
    match loss {
        Loss::Exit(worker::UNABLE) => Some(worker::MUTE.to_owned()),
        _ => Some(format!(
            "the FMU ended its process with code {}",
            status.code().unwrap_or(-1)
        )),
    }
}
