//! Writes XML, a line a tag.

use std::fmt::{self, Display, Write};

/// A real number as `xs:double`, with all its digits.
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

/// A start tag that is being written.
pub struct Tag(String);

impl Tag {
    /// The tag `<name>`.
    pub fn new(name: &str) -> Self {
        Self(name.to_owned())
    }

    /// The tag with an attribute.
    pub fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0
            .push_str(&format!(" {name}=\"{}\"", escaped(&value.to_string())));
        self
    }

    /// The tag with an attribute, if that has a value.
    pub fn with_some(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }
}

/// A document that is being written.
pub struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    /// A document with its first line.
    pub fn new() -> Self {
        Self {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
            depth: 0,
        }
    }

    /// The document's text.
    pub fn text(self) -> String {
        self.text
    }

    fn line(&mut self, line: impl Display) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{:1$}{line}", "", 2 * self.depth);
    }

    /// A start tag.
    pub fn open(&mut self, tag: Tag) {
        self.line(format_args!("<{}>", tag.0));
        self.depth += 1;
    }

    /// A tag without content.
    pub fn leaf(&mut self, tag: Tag) {
        self.line(format_args!("<{}/>", tag.0));
    }

    /// An end tag.
    pub fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(format_args!("</{name}>"));
    }
}

fn escaped(text: &str) -> String {
    text.chars()
        .fold(String::with_capacity(text.len()), |mut out, character| {
            match character {
                '&' => out.push_str("&amp;"),
                '<' => out.push_str("&lt;"),
                '>' => out.push_str("&gt;"),
                '"' => out.push_str("&quot;"),
                '\n' => out.push_str("&#10;"),
                '\t' => out.push_str("&#9;"),
                _ => out.push(character),
            }
            out
        })
}
