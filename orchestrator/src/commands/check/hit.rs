//! The place and the text of a finding.

/// A breach of the rule of this name.
pub(super) type Breach = (&'static str, Hit);

/// A breach of a rule: where, and what to do about it.
#[derive(Clone, Debug, Default)]
pub(super) struct Hit {
    /// The file within the FMU.
    pub(super) file: Option<String>,
    pub(super) line: Option<usize>,
    /// Where its element begins, bytes from the start of the file: lines are counted when all is found.
    pub(super) position: Option<usize>,
    pub(super) text: String,
}

impl Hit {
    /// One of no file.
    pub(super) fn plain(text: String) -> Self {
        Self {
            text,
            ..Self::default()
        }
    }

    /// One of a file.
    pub(super) fn of(file: &str, text: String) -> Self {
        Self {
            file: Some(file.to_owned()),
            ..Self::plain(text)
        }
    }

    /// With the place before it.
    pub(super) fn full(&self) -> String {
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
