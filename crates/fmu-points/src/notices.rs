//! Remarks on a simulation: the FMU's warnings, the limits of its model, an early end, errors of its end; to which of the curves
//! that a measured one may truly have been the model conforms.

use std::fmt;

use serde::{Deserialize, Serialize};

use fmu_import::{Call, Warnings, validity::is_further};

/// An FMU's remarks in one simulation, beside its results. None of them makes the point fail.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Notices {
    /// How many warnings came from `fmi2Instantiate` to the last step.
    #[serde(skip_serializing_if = "is_zero")]
    pub warnings: u64,
    /// The first of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_warning: Option<String>,
    /// The limits of the model's validity that the simulation passed, the first message of each kind.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<Limit>,
    /// When the FMU ended the simulation by itself, s, as the standard allows (`fmi2Discard` with `fmi2Terminated`).
    /// The results are those until then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ended: Option<f64>,
    /// Why the simulation could not be ended properly, though all of it was computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unfinished: Option<String>,
    /// A port, a socket's name or a lock that the point held when its results were there: only one process of a machine can.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub held: Option<String>,
    /// The answer of `fmi2GetVersion`, where it is not "2.0".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// For each measured curve that has an uncertainty: to which of the curves that it may truly have been the model conforms.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conforming: Vec<Replicates>,
}

/// A limit of a model's validity that a simulation passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// The case; none where a point has one simulation only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<String>,
    /// What the FMU says.
    pub message: String,
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match &self.case {
            Some(case) => write!(f, "case {case}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

/// Draws of a measured curve to which the model conforms, a bit each; empty where the curve cannot be drawn.
pub type Replicates = Vec<u64>;

pub(crate) fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Notices {
    /// Whether there is nothing beside the results.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Adds warnings after those that are there.
    pub fn warn(&mut self, warnings: Warnings) {
        self.warnings += warnings.count;
        if self.first_warning.is_none() {
            self.first_warning = warnings.first;
        }
        warnings.beyond.into_iter().for_each(|message| self.pass(None, message));
    }

    /// Adds a limit, unless another case has passed it, too.
    fn pass(&mut self, case: Option<&str>, message: String) {
        let kept = self.beyond.iter().map(|limit| limit.message.as_str());
        if is_further(&message, kept) {
            let case = case.map(str::to_owned);
            self.beyond.push(Limit { case, message });
        }
    }

    /// Adds what was said in one of a point's cases. Of warnings and errors, the first one is kept, with its case.
    pub fn add(&mut self, other: &Self, case: &str) {
        let named = |text: &Option<String>| text.as_ref().map(|text| format!("case {case}: {text}"));
        self.warnings += other.warnings;
        self.first_warning = self.first_warning.take().or_else(|| named(&other.first_warning));
        other.beyond.iter().map(|limit| limit.message.clone()).for_each(|message| self.pass(Some(case), message));
        self.ended = self.ended.or(other.ended);
        self.unfinished = self.unfinished.take().or_else(|| named(&other.unfinished));
        self.held = self.held.take().or_else(|| other.held.clone());
        self.version = self.version.take().or_else(|| other.version.clone());
        self.conforming.extend(other.conforming.iter().cloned());
    }

    /// Notes a call that ends a simulation, and failed.
    pub fn cannot_end(&mut self, call: &Call) {
        self.unfinished.get_or_insert_with(|| call.to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_warning_is_kept() {
        let warning = |count, text: &str| Warnings { count, first: Some(text.to_owned()), ..Warnings::default() };
        let mut notices = Notices::default();
        notices.warn(Warnings::default());
        assert!(notices.is_empty());
        notices.warn(warning(2, "first"));
        notices.warn(warning(3, "second"));
        assert_eq!(notices.warnings, 5);
        assert_eq!(notices.first_warning, Some("first".to_owned()));
    }

    #[test]
    fn a_limit_that_several_cases_pass_is_that_of_the_first() {
        let passed = |messages: &[&str]| {
            let mut notices = Notices::default();
            notices.warn(Warnings {
                beyond: messages.iter().map(|&text| text.to_owned()).collect(),
                ..Warnings::default()
            });
            notices
        };
        let mut point = Notices::default();
        point.add(&passed(&["hot at 3 s"]), "300 rpm");
        point.add(&passed(&["hot at 5.5 s", "fast at 1 s"]), "900 rpm");
        let told: Vec<String> = point.beyond.iter().map(Limit::to_string).collect();
        assert_eq!(told, ["case 300 rpm: hot at 3 s", "case 900 rpm: fast at 1 s"]);
        let text = serde_json::to_string(&passed(&["hot"])).unwrap();
        assert_eq!(text, r#"{"beyond":[{"message":"hot"}]}"#);
    }

    #[test]
    fn only_what_was_said_is_written() {
        let notices = Notices { ended: Some(0.5), ..Notices::default() };
        let text = serde_json::to_string(&notices).unwrap();
        assert_eq!(text, r#"{"ended":0.5}"#);
        assert_eq!(serde_json::from_str::<Notices>(&text).unwrap(), notices);
        assert_eq!(serde_json::to_string(&Notices::default()).unwrap(), "{}");
    }
}
