//! Writes XML, a line a tag.

use std::fmt::{self, Display, Write};

/// A real number as `xs:double`, with all its digits.
pub struct Number(pub f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
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
        // Writing to a String cannot fail.
        let _ = write!(self.0, " {name}=\"");
        let _ = write!(Escaped(&mut self.0), "{value}");
        self.0.push('"');
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
        Self { text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(), depth: 0 }
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

/// Takes an attribute's value. Each instance writes the whole description for its fingerprint, so no value is copied on the way.
struct Escaped<'a>(&'a mut String);

impl Write for Escaped<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let mut done = 0;
        for (at, byte) in text.bytes().enumerate() {
            let instead = match byte {
                b'&' => "&amp;",
                b'<' => "&lt;",
                b'>' => "&gt;",
                b'"' => "&quot;",
                b'\n' => "&#10;",
                b'\t' => "&#9;",
                _ => continue,
            };
            self.0.push_str(&text[done..at]);
            self.0.push_str(instead);
            done = at + 1;
        }
        self.0.push_str(&text[done..]);
        Ok(())
    }
}
