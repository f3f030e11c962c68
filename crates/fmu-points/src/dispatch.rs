//! The messages between a supervisor and a worker on another machine, over whatever a launcher connects.
//!
//! The worker says a [`Greeting`] first, on a line of its own, since a launcher may print lines before it. All that follows are
//! frames, as [between processes](crate::wire). The supervisor answers with its [`Terms`] as JSON.

use std::{fs::File, path::PathBuf, time::Duration};

use serde::{Deserialize, Serialize};

use crate::{
    as_json,
    failure::Failure,
    isolation::Isolation,
    notices::Notices,
    points::{Event, Job, Simulated},
    system,
    task::Case,
};

/// What a worker's first line begins with; JSON follows.
pub const MAGIC: &str = "fmu-points worker ";

/// The longest time between two messages where silence is suffered for so long: whoever has nothing to say says so.
pub fn beat(patience: Duration) -> Duration {
    const USUAL: Duration = Duration::from_secs(5);
    USUAL.min(patience / 4)
}

/// Who a worker is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Greeting {
    /// The version of its program.
    pub version: String,
    /// The SHA-256 digest of its program.
    pub program: String,
    /// The name of its machine.
    pub host: String,
}

impl Greeting {
    /// That of this program.
    pub fn own() -> Self {
        let digest = system::program().and_then(File::open).and_then(fmu_import::sha256);
        let named =
            std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| std::env::var("COMPUTERNAME").ok());
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            program: digest.map_or_else(|error| error.to_string(), |digest| fmu_import::hexadecimal(&digest)),
            host: named.map_or_else(|| "a host".to_owned(), |name| name.trim().to_owned()),
        }
    }

    /// The greeting in what a launcher has printed, and the end of its line. The launcher may print the same words.
    pub fn find(printed: &[u8]) -> Option<(Self, usize)> {
        let mut end = 0;
        printed.split_inclusive(|&byte| byte == b'\n').find_map(|line| {
            end += line.len();
            let line = String::from_utf8_lossy(line.strip_suffix(b"\n")?);
            let (_, said) = line.rsplit_once(MAGIC)?;
            Some((serde_json::from_str(said).ok()?, end))
        })
    }
}

/// What a worker needs to know before any task.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Terms {
    /// The number that marks all further frames.
    pub ticket: u64,
    /// How long the supervisor suffers silence; it may be silent itself for twice as long.
    pub patience: Duration,
    /// The FMU's path.
    pub fmu: PathBuf,
    /// The FMU's digest.
    pub digest: String,
    /// Whether the FMU is sent.
    pub ship: bool,
    /// The supervisor's working directory, and whether the FMU needs it.
    pub folder: PathBuf,
    pub here: bool,
    /// How long a point may take.
    pub time: Duration,
    /// How much memory; none for a fair share of the machine's.
    pub memory: Option<u64>,
    /// How many workers its machine has; where that is not known, it takes the machine's cores for it.
    pub slots: Option<usize>,
    /// Whether points run beside others.
    pub company: bool,
    /// How the user wishes points to share processes.
    pub isolation: Isolation,
}

/// The points that follow.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Series {
    pub cases: Vec<Case>,
    /// Whether they run again, to be compared.
    pub again: bool,
    /// Whether the cases name a file in the working directory.
    pub here: bool,
}

/// A message to a worker.
#[derive(Debug, Serialize, Deserialize)]
pub enum Order {
    /// A part of the FMU's bytes; the last one is empty.
    Bytes(Vec<u8>),
    /// The points that follow are of this kind.
    Begin(#[serde(with = "as_json")] Box<Series>),
    /// Points, and the first file that the FMU changed in its folder anywhere.
    Run(Vec<Job>, Option<String>),
    /// The supervisor is there still.
    Beat,
}

/// A message of a worker.
#[derive(Debug, Serialize, Deserialize)]
pub enum Report {
    /// It wants the next part of the FMU's bytes.
    Wanted,
    /// It has the FMU.
    Ready,
    /// It cannot work.
    Unable(WorkerFault),
    /// What happened.
    News(Vec<News>),
    /// All that was ordered is done: the first file that the FMU changed in its folder, and how long it took, s.
    Done(Option<String>, f64),
    /// It is there still.
    Beat,
}

/// An [`Event`] at a worker.
#[derive(Debug, Serialize, Deserialize)]
pub enum News {
    Result(u64, Simulated),
    Failed(u64, #[serde(with = "as_json")] Failure),
    Said(u64, #[serde(with = "as_json")] Box<Notices>),
}

impl News {
    /// The news of an event; none where that is not one of a worker.
    pub fn of(event: Event) -> Option<Self> {
        Some(match event {
            Event::Answer(index, Ok(result)) => Self::Result(index, result),
            Event::Answer(index, Err(failure)) => Self::Failed(index, failure),
            Event::Said(index, notices) => Self::Said(index, notices),
            Event::Idle => return None,
        })
    }

    /// The event, where it can be one of points with so many results; else what is wrong.
    pub fn event(self, results: usize) -> Result<Event, String> {
        Ok(match self {
            Self::Result(index, result) if result.values.len() == results => Event::Answer(index, Ok(result)),
            Self::Result(index, result) => {
                let count = result.values.len();
                return Err(format!("it sent {count} results of point {index} instead of {results}"));
            }
            Self::Failed(index, failure) => Event::Answer(index, Err(failure)),
            Self::Said(index, notices) => Event::Said(index, notices),
        })
    }
}

/// Why a worker cannot go on, and whether another one there could not either.
#[derive(Debug, Serialize, Deserialize)]
pub struct WorkerFault {
    pub how: String,
    pub lasting: bool,
}

impl WorkerFault {
    pub fn lasting(how: impl ToString) -> Self {
        Self { how: how.to_string(), lasting: true }
    }

    pub fn passing(how: impl ToString) -> Self {
        Self { how: how.to_string(), lasting: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_greeting_is_found_behind_what_a_launcher_prints() {
        let greeting = Greeting { version: "1".to_owned(), program: "a".to_owned(), host: "node".to_owned() };
        let said = format!("{MAGIC}{}\n", serde_json::to_string(&greeting).unwrap());
        let noise = format!("starting {MAGIC}{MAGIC}soon\n$ ");
        let printed = format!("{noise}{said}frames");
        assert_eq!(Greeting::find(printed.as_bytes()), Some((greeting, noise.len() + said.len())));
        let cut = &printed.as_bytes()[..noise.len() + said.len() - 1];
        assert_eq!(Greeting::find(cut), None);
    }
}
