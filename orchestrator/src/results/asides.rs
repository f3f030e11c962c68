//! An FMU's remarks beside its results, over all points of a study.

use serde::{Deserialize, Serialize};

use super::validity::Validity;
use fmu_points::notices::Notices;

/// The FMU's remarks beside its results, over all points. None of them makes a point fail.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Asides {
    /// Points with warnings (`fmi2Warning`, or messages logged as such), and how many these were.
    pub warnings: Warnings,
    /// Points beyond what the model is valid for; none where the FMU has no log category for that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub validity: Option<Validity>,
    /// Points whose simulation the FMU ended before the stop time, as the standard allows.
    pub ended_early: Points,
    /// Points whose simulation was complete, but could not be ended properly (`fmi2Terminate`, `fmi2FreeInstance`).
    pub terminate_errors: Points,
    /// Points that held a port, a socket's name or a lock of the machine when their results were there, beside others.
    #[serde(default, skip_serializing_if = "Points::is_none")]
    pub held: Points,
    /// The answer of `fmi2GetVersion`, where it is not "2.0".
    pub fmi_version: Option<String>,
    /// Whether the FMU needs a tool to be installed beside it.
    pub needs_execution_tool: bool,
}

/// Points of which the same was said.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Points {
    /// How many points.
    pub points: u64,
    /// The first of them.
    pub first: Option<First>,
}

/// Points with warnings.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Warnings {
    /// How many warnings all points had together.
    pub count: u64,
    /// Points with warnings.
    #[serde(flatten)]
    pub at: Points,
}

/// The first point of which something was said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct First {
    /// Name, for people.
    pub point: u64,
    /// The FMU's message, or what it did.
    pub message: String,
}

impl Points {
    fn is_none(&self) -> bool {
        self.points == 0
    }

    fn add(&mut self, point: u64, message: impl FnOnce() -> String) {
        self.points += 1;
        self.first.get_or_insert_with(|| First { point, message: message() });
    }

    /// A sentence about these points, where there are any.
    pub(super) fn remark(&self, what: &str) -> Option<String> {
        let First { point, message } = self.first.as_ref()?;
        let plural = if self.points == 1 { "" } else { "s" };
        Some(format!("{} point{plural}: {what}; the first is point {point}: {message}", self.points))
    }
}

impl Asides {
    /// Counts what was said of a point, and whether that meets all criteria; points come in their order.
    pub fn add(&mut self, point: u64, verified: bool, notices: &Notices) {
        if let Some(validity) = &mut self.validity {
            validity.add(point, verified, &notices.beyond);
        }
        if notices.warnings > 0 {
            self.warnings.count += notices.warnings;
            self.warnings.at.add(point, || notices.first_warning.clone().unwrap_or_default());
        }
        if let Some(time) = notices.ended {
            self.ended_early.add(point, || format!("ended at {time} s"));
        }
        if let Some(error) = &notices.unfinished {
            self.terminate_errors.add(point, || error.clone());
        }
        if let Some(held) = &notices.held {
            self.held.add(point, || held.clone());
        }
        if self.fmi_version.is_none() {
            self.fmi_version.clone_from(&notices.version);
        }
    }

    /// Sentences for a reader of the results.
    pub fn remarks(&self) -> Vec<String> {
        let warned = format!("the FMU gave {} warnings", self.warnings.count);
        let ended = "the FMU ended the simulation before the stop time, as the standard allows (fmi2Discard with \
                     fmi2Terminated, in FMI 3.0 terminateSimulation), and its last values count";
        let unfinished = "the simulation was complete, but the FMU could not end it";
        let version = self.fmi_version.as_ref().map(|version| {
            format!("fmi2GetVersion returns {version:?} instead of \"2.0\"; the FMU ran as one of FMI 2.0")
        });
        let tool = self.needs_execution_tool.then(|| {
            "the FMU needs a tool beside it (needsExecutionTool): its results are those of the tool's installed version"
                .to_owned()
        });
        [
            self.warnings.at.remark(&warned),
            self.ended_early.remark(ended),
            self.terminate_errors.remark(unfinished),
            version,
            tool,
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_counted_and_the_first_is_kept() {
        let mut asides = Asides::default();
        assert!(asides.remarks().is_empty());
        let warned =
            |warnings, text: &str| Notices { warnings, first_warning: Some(text.to_owned()), ..Notices::default() };
        asides.add(3, true, &warned(2, "the oil is warm"));
        asides.add(4, true, &warned(5, "the oil is hot"));
        asides.add(4, true, &Notices { ended: Some(0.5), ..Notices::default() });
        assert_eq!((asides.warnings.count, asides.warnings.at.points), (7, 2));
        let remarks = asides.remarks();
        assert_eq!(remarks[0], "2 points: the FMU gave 7 warnings; the first is point 3: the oil is warm");
        assert!(remarks[1].starts_with("1 point: the FMU ended"));
        assert!(remarks[1].ends_with("the first is point 4: ended at 0.5 s"));
        let text = serde_json::to_string(&asides).unwrap();
        assert_eq!(serde_json::from_str::<Asides>(&text).unwrap(), asides);
    }
}
