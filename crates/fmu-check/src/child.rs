//! A process in which an FMU is probed: the side that waits for it.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use fmu_import::isolation::Loss;
use fmu_import::isolation::keeper::signal_name;
use fmu_points::process::marked;
use fmu_points::system::{self, Tree};
use fmu_points::{stop, worker};

use crate::probe::{COMMAND, Report, Setup};

/// The most memory that a probe may use, bytes.
const MEMORY: u64 = 8 << 30;

/// The fate of a probe that takes too long.
pub(crate) const TIMEOUT: &str = "timeout";

/// The outcome of a probe.
#[derive(Clone, Debug)]
pub(crate) struct Outcome {
    /// Its observations, up to where it came.
    pub(crate) report: Option<Report>,
    /// How its process ended, where that was not in order, and during which call.
    pub(crate) fate: Option<String>,
    pub(crate) stage: String,
}

/// Runs a probe. `fill` is what glibc fills fresh and freed memory with.
pub(crate) fn run(setup: &Setup, patience: Duration, fill: Option<u8>) -> io::Result<Outcome> {
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
    let notes = end_of(&setup.stage).unwrap_or_default();
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
    Some(match loss {
        Loss::Signal(signal) => {
            let (name, text) = (signal_name(signal), end_of(heard).unwrap_or_default());
            match text.lines().map(str::trim).rfind(|line| !line.is_empty()) {
                Some(last) => format!("{name}: {last}"),
                None => name,
            }
        }
        Loss::Exit(worker::UNABLE) => worker::MUTE.to_owned(),
        _ => {
            let code = status.code().unwrap_or(-1);
            format!("the FMU ended its process with code {code}")
        }
    })
}

/// The end of a file, which may be of any length.
fn end_of(file: &Path) -> io::Result<String> {
    const KEPT: u64 = 4096;
    let mut file = File::open(file)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(KEPT)))?;
    let mut end = Vec::new();
    file.take(KEPT).read_to_end(&mut end)?;
    Ok(String::from_utf8_lossy(&end).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_output_the_end_is_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), "flood\n".repeat(1_000_000) + "last words").unwrap();
        let end = end_of(file.path()).unwrap();
        assert_eq!(end.len(), 4096);
        assert!(end.ends_with("flood\nlast words"));
    }
}
