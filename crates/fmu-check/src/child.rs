//! A process in which an FMU is probed: the side that waits for it.

use std::{fmt, io, path::Path, time::Duration};

use fmu_points::{
    PointLimits,
    failure::Failure,
    single::{Recorder, bytes, read},
    stop,
};

use crate::probe::{ProbeNews, ProbeTask, Report};

/// The most memory that a probe may use, bytes.
const MEMORY: u64 = 8 << 30;

/// How the process of a probe ended, where that was not in order.
pub enum Fate {
    /// It took too long.
    Late,
    /// It came to another end: why, with the FMU's last words.
    Broken(String),
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Late => f.write_str("timeout"),
            Self::Broken(text) => f.write_str(text),
        }
    }
}

/// The outcome of a probe.
#[derive(Default)]
pub struct ProbeOutcome {
    /// Its observations, up to where it came.
    pub report: Option<Report>,
    /// How its process ended, where that was not in order.
    pub fate: Option<Fate>,
    /// The last call that it began.
    pub stage: String,
}

/// Runs a probe. `fill` is what fresh and freed memory is filled with.
pub fn run(setup: &ProbeTask, scratch: &Path, patience: Duration, fill: Option<u8>) -> io::Result<ProbeOutcome> {
    let recorder = Recorder {
        fmu: &setup.fmu,
        name: &setup.fmu,
        scratch,
        here: setup.here,
        limits: PointLimits { time: patience, memory: MEMORY },
        echo: false,
    };
    let mut outcome = ProbeOutcome::default();
    let failure = recorder.send(bytes(setup), fill, |told| match read(told) {
        Some(ProbeNews::Stage(stage)) => outcome.stage = stage,
        Some(ProbeNews::Report(report)) => outcome.report = Some(report),
        // Frames have a checksum, so what arrives is what was told.
        None => {}
    });
    stop::give_way();
    outcome.fate = failure.map_err(io::Error::other)?.map(fate);
    Ok(outcome)
}

/// What a failure of the process means for its probe.
fn fate(failure: Failure) -> Fate {
    match failure {
        Failure::Timeout => Fate::Late,
        Failure::Crashed(text) => Fate::Broken(text),
        Failure::Exited(code, words) => {
            let words = if words.is_empty() { words } else { format!(": {words}") };
            Fate::Broken(format!("the FMU ended its process with code {code}{words}"))
        }
        other => Fate::Broken(other.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_words_of_an_fmu_are_told_and_are_no_timeout() {
        let exited = |words: &str| fate(Failure::Exited(3, words.to_owned())).to_string();
        assert_eq!(exited(""), "the FMU ended its process with code 3");
        assert_eq!(exited("no licence"), "the FMU ended its process with code 3: no licence");
        assert!(matches!(fate(Failure::Crashed("SIGABRT: connection timeout".to_owned())), Fate::Broken(_)));
        assert!(matches!(fate(Failure::Timeout), Fate::Late));
    }
}
