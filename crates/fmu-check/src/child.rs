//! A process in which an FMU is probed: the side that waits for it.

use std::{io, path::Path, time::Duration};

use fmu_points::{
    PointLimits,
    failure::Failure,
    single::{Recorder, bytes, read},
    stop,
};

use crate::probe::{ProbeNews, ProbeTask, Report};

/// The most memory that a probe may use, bytes.
const MEMORY: u64 = 8 << 30;

/// The fate of a probe that takes too long.
pub const TIMEOUT: &str = "timeout";

/// The outcome of a probe.
#[derive(Default)]
pub struct ProbeOutcome {
    /// Its observations, up to where it came.
    pub report: Option<Report>,
    /// How its process ended, where that was not in order, and during which call.
    pub fate: Option<String>,
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

/// The fault at the end of the process, with the FMU's last output where it crashed.
fn fate(failure: Failure) -> String {
    match failure {
        Failure::Crashed(text) => text,
        Failure::Exited(code, _) => format!("the FMU ended its process with code {code}"),
        Failure::Timeout => TIMEOUT.to_owned(),
        other => other.to_string(),
    }
}
