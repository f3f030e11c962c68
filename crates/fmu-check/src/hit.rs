//! The place and the text of a finding.

/// A breach of the rule of this name.
pub type Breach = (&'static str, Hit);

/// A breach that has no line.
pub fn breach(rule: &'static str, text: impl Into<String>) -> Breach {
    (rule, Hit::plain(text))
}

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
        Self { text: text.into(), ..Self::default() }
    }

    /// One of a file.
    pub(crate) fn of(file: &str, text: impl Into<String>) -> Self {
        Self { file: Some(file.to_owned()), ..Self::plain(text) }
    }

    /// Whether the text has this name as a whole: `oil.density` is not in `oil.density15`, nor in `hot.oil.density`.
    pub fn names(&self, variable: &str) -> bool {
        let is_of_name = |c: char| c.is_alphanumeric() || c == '_';
        self.text.match_indices(variable).any(|(start, _)| {
            let mut before = self.text[..start].chars();
            let mut after = self.text[start + variable.len()..].chars();
            let (last, next) = (before.next_back(), after.next());
            let begins = last.is_none_or(|c| !is_of_name(c) && c != '.');
            // A full stop ends a sentence, or goes on with the name.
            let goes_on = next == Some('.') && after.next().is_some_and(is_of_name);
            begins && !goes_on && next.is_none_or(|c| !is_of_name(c) && c != '[')
        })
    }

    /// The text with the place before it.
    pub fn full(&self) -> String {
        let Self { file, line, text, .. } = self;
        match (file, line) {
            (Some(file), Some(line)) => format!("{file}, line {line}: {text}"),
            (Some(file), None) => format!("{file}: {text}"),
            (None, _) => text.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variable_is_named_as_a_whole() {
        let hit = Hit::plain("oil.density15: no unit, as `a[1].b` and (x). See hot.oil.");
        for name in ["oil.density15", "a[1].b", "x", "hot.oil"] {
            assert!(hit.names(name), "{name}");
        }
        for name in ["oil.density1", "density15", "oil", "a", "a[1]", "b", "unity"] {
            assert!(!hit.names(name), "{name}");
        }
    }
}
