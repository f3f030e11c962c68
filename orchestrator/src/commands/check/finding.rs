//! Findings of a check, and its rules.

use serde::Serialize;

use super::document::{Document, Scalar};
use super::hit::Hit;

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Severity {
    /// Good to know.
    Note,
    /// The standard does not forbid it, or it does no harm; but look at it.
    Warning,
    /// The standard forbids it, or a study would be wrong.
    Error,
}

impl Severity {
    pub(super) fn word(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One rule.
pub(super) struct Rule {
    /// Its name, which stays the same from version to version.
    pub(super) id: &'static str,
    pub(super) severity: Severity,
    /// Where it stands: the standard with its section, or the schema file.
    pub(super) source: &'static str,
    /// The rule's demand.
    pub(super) wants: &'static str,
    pub(super) find: Find,
}

/// Finds breaches of a rule.
#[derive(Clone, Copy)]
pub(super) enum Find {
    /// Looks at the whole model description of FMI 2.0.
    Document(fn(&Document<'_>) -> Vec<Hit>),
    /// Looks at one of FMI 3.0.
    Three(fn(&Document<'_>) -> Vec<Hit>),
    /// Looks at one of either version.
    Either(fn(&Document<'_>) -> Vec<Hit>),
    /// Looks at one variable of FMI 2.0. Of all such rules the first that finds something counts: others would only repeat it.
    Variable(fn(&Scalar<'_>, &Document<'_>) -> Option<String>),
    /// The archive or a simulation shows it while it is looked at.
    Elsewhere,
}

/// A breach with the rule that it breaks.
pub(super) struct Finding {
    pub(super) rule: &'static Rule,
    pub(super) hit: Hit,
}
