//! Limits of time and memory for a point, from the command line.

use std::time::Duration;

use super::CommandError;
use crate::cli::Means;
use fmu_points::crew::Place;
use fmu_points::process::Limits;
use fmu_points::system;

/// Where `jobs` points at a time are run.
pub(super) fn place(options: &Means, jobs: usize) -> Result<Place, CommandError> {
    if options.in_process {
        return Ok(Place::Here);
    }
    Ok(Place::Processes(limits(options, jobs)?, options.isolation))
}

/// The limits for one of `jobs` workers.
pub(super) fn limits(options: &Means, jobs: usize) -> Result<Limits, CommandError> {
    let time = Duration::try_from_secs_f64(options.point_timeout);
    let time = time
        .ok()
        .filter(|time| !time.is_zero())
        .ok_or_else(|| CommandError::Option {
            option: "point-timeout",
            message: format!("{:?} s is not a positive time", options.point_timeout),
        })?;
    let memory = match &options.memory_limit {
        Some(text) => size(text).ok_or_else(|| CommandError::Option {
            option: "memory-limit",
            message: format!("`{text}` is not a size such as 500MB or 2GB"),
        })?,
        None => share(jobs),
    };
    Ok(Limits { time, memory })
}

/// A size with a unit, bytes.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn size(text: &str) -> Option<u64> {
    let text = text.trim();
    let digits = text
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(text.len());
    let number: f64 = text[..digits].parse().ok()?;
    let factor = match text[digits..].trim().to_uppercase().as_str() {
        "" | "B" => 1.0,
        "K" | "KB" | "KIB" => 1024.0,
        "M" | "MB" | "MIB" => 1024.0 * 1024.0,
        "G" | "GB" | "GIB" => 1024.0 * 1024.0 * 1024.0,
        _ => return None,
    };
    let bytes = number * factor;
    (bytes >= 1.0).then_some(bytes as u64)
}

/// Four fifths of the machine's memory, shared by the workers.
fn share(jobs: usize) -> u64 {
    // Where the size is not known, a limit that any of today's machines keeps.
    const UNKNOWN: u64 = 4 << 30;
    let memory = system::memory_of_machine();
    memory.map_or(UNKNOWN, |bytes| bytes / 5 * 4) / jobs.max(1) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("500MB"), Some(500 << 20));
        assert_eq!(size("1.5 G"), Some(3 << 29));
        assert_eq!(size("4096"), Some(4096));
        assert_eq!(size("many"), None);
        assert_eq!(size("0"), None);
    }
}
