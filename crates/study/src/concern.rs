//! Doubts about the verdict of a study that can be judged all the same, with the remedy.

use std::fmt;

use serde::{Deserialize, Serialize};

/// The remedy of a tolerance that accepts 0.
pub const ACCEPTS_ZERO: &str = "Correct each tolerance that accepts 0, or its unit.";

/// A doubt about a verdict.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Concern {
    /// Its kind, for programs.
    pub code: Code,
    /// How far it touches the verdict.
    pub severity: Severity,
    /// What is doubtful: a sentence for people, without its full stop.
    pub text: String,
    /// What to do about it: a sentence of its own. Summaries of earlier versions end the text with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

impl Concern {
    /// A doubt of a kind, which decides how far it touches the verdict.
    pub fn new(code: Code, text: impl fmt::Display) -> Self {
        let severity = match code {
            Code::ManySteps | Code::NotCompared | Code::NotReRun => Severity::Note,
            _ => Severity::Warning,
        };
        Self { code, severity, text: text.to_string(), remedy: None }
    }

    /// The same with what to do about it.
    #[must_use]
    pub fn remedied(self, remedy: impl Into<String>) -> Self {
        let remedy = Some(remedy.into());
        Self { remedy, ..self }
    }
}

impl fmt::Display for Concern {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)?;
        self.remedy.iter().try_for_each(|remedy| write!(f, ". {remedy}"))
    }
}

/// The kinds of doubts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Code {
    /// A nominal value is the model's own, and nothing was measured.
    NominalFromModel,
    /// The guard band is as wide as a tolerance.
    GuardBandTooWide,
    /// The uncertainty of a measured value exceeds the tolerance.
    UncertaintyAboveTolerance,
    /// A measured value is beyond the limit that it stands beside.
    MeasuredBeyondLimit,
    /// A tolerance is so wide that it refuses next to nothing.
    WideTolerance,
    /// Every case is held out.
    AllHeldOut,
    /// A recording has too few rows for a curve.
    FewRows,
    /// Two criteria judge the same value, and no value meets both.
    Contradictory,
    /// No point reaches a measured value.
    OutOfReach,
    /// A criterion's value is the same at all points.
    Unmoved,
    /// Points have no result.
    FailedPoints,
    /// Points went beyond what the model says it is valid for.
    BeyondValidity,
    /// Points held a port, a socket or a lock, where they may have met each other.
    Held,
    /// Values are too large for the validation comparison.
    NotCompared,
    /// Rows of a table repeat earlier ones.
    RepeatedRows,
    /// There are more points than rows of a sample.
    RepeatedSample,
    /// The FMU refuses a part of a parameter's distribution.
    RefusedDistribution,
    /// The FMU cannot follow a recording.
    MissedRows,
    /// A recording has a hole, which a straight line bridges.
    Hole,
    /// A verdict takes a recorded input as exact, though its uncertainty is stated.
    InputTakenAsExact,
    /// What `synchronise` found doubtful in a recording.
    Doubtful,
    /// Recordings make many more steps than the study asks for.
    ManySteps,
    /// Values depend on the communication step, or on the FMU's solver.
    CoarseStep,
    /// Nothing is known of swing and drift.
    NotReRun,
    /// The final value is one instant of a signal that swings.
    Swings,
    /// A value still moves when the run ends.
    StillMoves,
    /// One that this version does not know.
    #[serde(other)]
    Other,
}

impl Code {
    /// Its name, as in `summary.json`.
    pub fn name(self) -> String {
        sampling::word(&self)
    }
}

/// How far a doubt touches a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    /// The verdict may be wrong, or mean something else.
    Warning,
    /// Something beside the verdict is missing or dear.
    Note,
}

impl Severity {
    /// Its name before a doubt's text.
    pub fn name(self) -> String {
        sampling::word(&self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_of_later_versions_are_read() {
        let new = Concern::new(Code::NotReRun, "no point was re-run");
        let text = serde_json::to_string(&new).unwrap();
        assert_eq!(text, r#"{"code":"not-re-run","severity":"note","text":"no point was re-run"}"#);
        let later = text.replace("not-re-run", "of-later");
        let moves = Concern::new(Code::StillMoves, "Y: it moves").remedied("Simulate longer.");
        assert_eq!(moves.to_string(), "Y: it moves. Simulate longer.");
        let remedied = serde_json::to_string(&moves).unwrap();
        assert!(remedied.ends_with(r#","text":"Y: it moves","remedy":"Simulate longer."}"#));
        let all: Vec<Concern> = serde_json::from_str(&format!("[{text}, {later}, {remedied}]")).unwrap();
        let later = Concern { code: Code::Other, ..new.clone() };
        assert_eq!(all, [new, later, moves]);
    }
}
