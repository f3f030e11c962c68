//! The place and the text of a finding.

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
