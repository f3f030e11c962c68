//! Form error of bush and journal: measured radial deviations over the angle.
//!
//! # Examples
//! ```
//! use journal_bearing::profile::Profile;
//!
//! // Angle in degrees, radial deviations in micrometres.
//! let text = "angle,bush,journal\n0,2,0\n120,0,0\n240,0,0\n";
//! let profile = Profile::from_text(text, "bush.csv")?;
//! let opening = profile.opening(0.0, [0.0, 0.0]);
//! assert!((opening - 2e-6).abs() < 1e-12); // m
//! # Ok::<(), journal_bearing::profile::ProfileError>(())
//! ```

use std::{f64::consts::TAU, path::Path};

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Radial deviations of bush and journal from round; they are the same over the whole width.
///
/// A positive deviation of the bush opens the gap, a positive deviation of the journal closes it. Deviations vary linearly
/// between the given angles, which go once around and close.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Profile {
    bush: Deviations,
    journal: Deviations,
}

/// Deviations of one surface (m) over increasing angles (rad) within one turn; empty when round.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Deviations {
    angle: Vec<f64>,
    deviation: Vec<f64>,
}

/// Why a profile cannot be used.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ProfileError {
    /// The file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// The operating system's reason.
        reason: String,
    },
    /// A line is not as it must be.
    #[error("{file}, line {line}: {reason}")]
    Line {
        /// The file.
        file: String,
        /// The line, from 1.
        line: usize,
        /// The fault, and the expected content.
        reason: String,
    },
}

impl Profile {
    /// Makes a profile from samples `[angle, bush, journal]`: an angle (rad) and the radial deviations there (m). No samples
    /// make round surfaces.
    ///
    /// # Errors
    /// Returns the index of the first sample that is not finite, not in increasing order or more than a turn from the first
    /// one, with the reason.
    pub fn new(samples: &[[f64; 3]]) -> Result<Self, (usize, &'static str)> {
        let mut profile = Self::default();
        for (k, &[angle, bush, journal]) in samples.iter().enumerate() {
            if ![angle, bush, journal].iter().all(|value| value.is_finite()) {
                return Err((k, "every value must be a finite number"));
            }
            if profile.bush.angle.last().is_some_and(|&last| angle <= last) {
                return Err((k, "angles must increase from line to line"));
            }
            if angle - samples[0][0] >= TAU * (1.0 - 1e-9) {
                return Err((k, "angles must stay within one turn of the first"));
            }
            profile.bush.angle.push(angle);
            profile.bush.deviation.push(bush);
            profile.journal.angle.push(angle);
            profile.journal.deviation.push(journal);
        }
        Ok(profile)
    }

    /// Reads a csv file with the header `angle,bush,journal`: angle in degrees, radial deviations in micrometres. Lines that
    /// start with `#` are comments.
    ///
    /// # Errors
    /// Returns [`ProfileError`] when the file cannot be read or a line is wrong; the message names file and line.
    pub fn from_csv(path: &Path) -> Result<Self, ProfileError> {
        let file = path.display().to_string();
        let unreadable = |reason| ProfileError::Unreadable { file: file.clone(), reason };
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
        Self::from_text(&text, &file)
    }

    /// Reads a text in the format of [`from_csv`](Self::from_csv); `file` names it in messages.
    ///
    /// # Errors
    /// Returns [`ProfileError::Line`] when a line is wrong.
    pub fn from_text(text: &str, file: &str) -> Result<Self, ProfileError> {
        let wrong = |line: usize, reason| ProfileError::Line { file: file.to_owned(), line, reason };
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k + 1, line.trim()))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let header = lines.next();
        let names = header.map(|(_, line)| line.split(',').map(str::trim).collect::<Vec<_>>());
        if names.as_deref() != Some(&["angle", "bush", "journal"]) {
            let line = header.map_or(1, |(line, _)| line);
            return Err(wrong(
                line,
                "the header must be `angle,bush,journal` (degrees, micrometres, micrometres)".to_owned(),
            ));
        }
        let (mut samples, mut numbers) = (Vec::new(), Vec::new());
        for (number, line) in lines {
            let values: Vec<f64> = line
                .split(',')
                .map(|field| field.trim().parse().map_err(|_| field.trim()))
                .collect::<Result<_, _>>()
                .map_err(|field| wrong(number, format!("`{field}` is not a number")))?;
            let &[angle, bush, journal] = values.as_slice() else {
                return Err(wrong(number, format!("3 values are wanted, not {}", values.len())));
            };
            samples.push([angle.to_radians(), bush * 1e-6, journal * 1e-6]);
            numbers.push(number);
        }
        if samples.len() < 3 {
            return Err(wrong(text.lines().count().max(1), "at least 3 angles are needed".to_owned()));
        }
        Self::new(&samples).map_err(|(k, reason)| wrong(numbers[k], reason.to_owned()))
    }

    /// Whether both surfaces are round.
    pub fn is_round(&self) -> bool {
        self.bush.angle.is_empty() && self.journal.angle.is_empty()
    }

    /// The form errors' contribution to the gap, m, at the angle `theta` of the fixed frame (rad), with journal and bush turned
    /// by these angles (rad).
    pub fn opening(&self, theta: f64, [journal, bush]: [f64; 2]) -> f64 {
        self.bush.at(theta - bush)[0] - self.journal.at(theta - journal)[0]
    }

    /// Derivatives of [`opening`](Self::opening) over the angles of journal and bush, m/rad.
    pub fn opening_rates(&self, theta: f64, [journal, bush]: [f64; 2]) -> [f64; 2] {
        [self.journal.at(theta - journal)[1], -self.bush.at(theta - bush)[1]]
    }
}

impl Deviations {
    /// The deviation at an angle, m, and its slope, m/rad.
    fn at(&self, theta: f64) -> [f64; 2] {
        let count = self.angle.len();
        let Some(&first) = self.angle.first() else { return [0.0; 2] };
        let angle = first + (theta - first).rem_euclid(TAU);
        let after = self.angle.partition_point(|&a| a <= angle);
        let before = after.saturating_sub(1);
        let next = if after < count { self.angle[after] } else { first + TAU };
        let to = self.deviation[after % count];
        let from = self.deviation[before];
        let slope = (to - from) / (next - self.angle[before]);
        [from + slope * (angle - self.angle[before]), slope]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closes_around_the_turn() {
        let profile = Profile::from_text("angle,bush,journal\n0,1,0\n90,2,0\n270,-2,4\n", "p.csv").unwrap();
        let at = |degrees: f64| profile.opening(degrees.to_radians(), [0.0; 2]) * 1e6;
        assert!((at(0.0) - 1.0).abs() < 1e-9);
        assert!((at(180.0) - (0.0 - 2.0)).abs() < 1e-9);
        assert!((at(315.0) - (-0.5 - 2.0)).abs() < 1e-9);
        assert!((at(-45.0) - at(315.0)).abs() < 1e-9);
    }

    #[test]
    fn turns_with_the_journal() {
        let profile = Profile::from_text("angle,bush,journal\n0,0,3\n120,0,0\n240,0,0\n", "p.csv").unwrap();
        assert!((profile.opening(1.0, [1.0, 0.5]) + 3e-6).abs() < 1e-12);
        let step = 1e-6;
        let rate = (profile.opening(0.5, [step, 0.0]) - profile.opening(0.5, [0.0, 0.0])) / step;
        assert!((rate - profile.opening_rates(0.5, [0.0; 2])[0]).abs() < 1e-9);
    }

    #[test]
    fn bad_files_name_their_line() {
        let error = |text| Profile::from_text(text, "p.csv").unwrap_err().to_string();
        assert!(error("theta,a,b\n").contains("p.csv, line 1: the header"));
        assert!(error("# x\nangle,bush,journal\n0,0,0\n10,x,0\n").contains("line 4: `x`"));
        assert!(error("angle,bush,journal\n0,0,0\n10,0,0\n5,0,0\n").contains("line 4: angles must increase"));
        assert!(error("angle,bush,journal\n0,0,0\n10,0\n").contains("3 values"));
    }
}
