//! Findings of a check, and its rules.

use fmu_import::description::About;
use roxmltree::Node;
use serde::Serialize;

use crate::document::{Document, Scalar};

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
    /// The rule's demand.
    pub wants: &'static str,
    pub(crate) find: Find,
}

/// Finds breaches of a rule.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Find {
    /// Looks at the whole model description of FMI 2.0.
    Document(fn(&Document<'_>) -> Vec<Hit>),
    /// Looks at one of FMI 3.0.
    Three(fn(&Document<'_>) -> Vec<Hit>),
    /// Looks at one variable of FMI 3.0.
    Each(fn(Node<'_, '_>, &Document<'_>) -> Option<String>),
    /// Looks at a whole one of either version.
    Either(fn(&Document<'_>) -> Vec<Hit>),
    /// The reader of the model description remarks on it.
    Remark(About),
    /// Looks at one variable of FMI 2.0. Of all such rules the first that finds something counts: others would only repeat it.
    Variable(fn(&Scalar<'_>, &Document<'_>) -> Option<String>),
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

/// A breach of the rule of this name.
pub(crate) type Breach = (&'static str, Hit);

/// A breach of a rule: where, and what to do about it.
#[derive(Clone, Debug, Default)]
pub struct Hit {
    /// The file within the FMU.
    pub file: Option<String>,
    /// The line in that file, from 1.
    pub line: Option<usize>,
    /// Where its element begins, bytes from the start of the file: lines are counted when all is found.
    pub(crate) position: Option<usize>,
    /// The fault, and how to mend it.
    pub text: String,
}

impl Hit {
    /// One of no file.
    pub(crate) fn plain(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            ..Self::default()
        }
    }

    /// One of a file.
    pub(crate) fn of(file: &str, text: impl Into<String>) -> Self {
        Self {
            file: Some(file.to_owned()),
            ..Self::plain(text)
        }
    }

    /// The text with the place before it.
    pub fn full(&self) -> String {
        let Self {
            file, line, text, ..
        } = self;
        match (file, line) {
            (Some(file), Some(line)) => format!("{file}, line {line}: {text}"),
            (Some(file), None) => format!("{file}: {text}"),
            (None, _) => text.clone(),
        }
    }
}
