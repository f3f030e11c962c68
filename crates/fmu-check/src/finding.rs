//! Findings of a check, and its rules.

use fmu_import::description::About;
use serde::Serialize;

use crate::{
    document::{Document, Variable},
    hit::Hit,
};

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Good to know.
    Note,
    /// The standard does not forbid it, or it does no harm; but look at it.
    Warning,
    /// The standard forbids it, or a study would be wrong.
    Error,
}

impl Severity {
    /// `note`, `warning` or `error`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One rule.
#[derive(Debug)]
pub struct Rule {
    /// Its name, which stays the same from version to version.
    pub id: &'static str,
    /// How much a breach matters.
    pub severity: Severity,
    /// Where it stands: the standard with its section, or the schema file.
    pub source: &'static str,
    /// The same in FMI 3.0, where it stands elsewhere there.
    pub(crate) source_of_three: &'static str,
    /// The rule's demand.
    pub wants: &'static str,
    pub(crate) find: Find,
}

/// Finds breaches of a rule.
#[derive(Debug)]
pub(crate) enum Find {
    /// Looks at the whole model description of FMI 2.0.
    Document(fn(&Document) -> Vec<Hit>),
    /// Looks at one of FMI 3.0.
    Three(fn(&Document) -> Vec<Hit>),
    /// Looks at one variable of FMI 3.0.
    Each(fn(Variable) -> Option<String>),
    /// Looks at a whole one of either version.
    Either(fn(&Document) -> Vec<Hit>),
    /// The reader of the model description remarks on it.
    Remark(About),
    /// Looks at one variable of FMI 2.0. Of all such rules the first that finds something counts: others would only repeat it.
    Variable(fn(Variable) -> Option<String>),
    /// The archive or a simulation shows it while it is looked at.
    Elsewhere,
}

/// A breach with the rule that it breaks.
#[derive(Debug)]
pub struct Finding {
    /// The rule.
    pub rule: &'static Rule,
    /// The breach.
    pub hit: Hit,
}
