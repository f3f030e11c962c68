//! Lines on standard error and texts on standard output. What strangers wrote (an FMU, a table, a file's name) cannot steer the
//! terminal there, nor look like another text.

use std::{
    borrow::Cow,
    io::{self, Write},
};

/// Whether a character is one that is not seen, but changes what is seen: it steers the terminal, or turns or breaks the
/// text after it.
pub fn is_hidden(c: char) -> bool {
    matches!(
        c,
        '\0'..='\x1f' | '\x7f'..='\u{9f}' | '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    )
}

/// The text with each hidden character written as `\u001b`: as JSON, TOML and JavaScript read it. Line ends and tabs stay.
pub fn visible(text: &str) -> Cow<'_, str> {
    if text.contains("\r\n") {
        let lines: Vec<_> = text.split("\r\n").map(visible).collect();
        return Cow::Owned(lines.join("\r\n"));
    }
    written(text, |c| is_hidden(c) && !matches!(c, '\n' | '\t'))
}

/// The same for a text that must be one line.
pub fn one_line(text: &str) -> Cow<'_, str> {
    written(text, is_hidden)
}

fn written(text: &str, is_hidden: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_hidden) {
        return Cow::Borrowed(text);
    }
    let written = text.chars().fold(String::new(), |mut all, c| {
        if is_hidden(c) {
            all += &format!("\\u{:04x}", u32::from(c))
        } else {
            all.push(c)
        }
        all
    });
    Cow::Owned(written)
}

/// Writes a text to standard output. A reader that has gone, such as `head`, is no error.
pub fn print(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(visible(text).as_bytes()).and_then(|()| out.flush());
}

/// Writes a line to standard error. Where nobody reads that any more it is lost, and the work goes on; `eprintln!` would
/// panic.
#[doc(hidden)]
pub fn write_line(text: &str) {
    let _ = io::stderr().write_all(format!("{}\n", one_line(text)).as_bytes());
}

/// Writes a line to standard error, as `eprintln!` would.
#[doc(hidden)]
#[macro_export]
macro_rules! tell_line {
    ($($what:tt)*) => {
        $crate::tell::write_line(&format!($($what)*))
    };
}

pub use tell_line as line;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_hidden_is_left() {
        let steering = "a\x1b[2J\x07\u{9b}1m\x7f\r\u{202e}b\u{2066}\u{200f}\u{61c}\u{2028}";
        let shown = r"a\u001b[2J\u0007\u009b1m\u007f\u000d\u202eb\u2066\u200f\u061c\u2028";
        assert_eq!(visible(steering), shown);
        assert_eq!(one_line("a\n\tb"), r"a\u000a\u0009b");
        assert_eq!(visible("a\r\n\rb"), "a\r\n\\u000db");
        for plain in ["", "a\n\tb", "Ölfilm µ 漢字 עברית", "C:\\users"] {
            assert!(matches!(visible(plain), Cow::Borrowed(_)));
        }
        // Escaped JSON still holds the same text.
        let name = "\u{202e}\x1b\x7f";
        let json = serde_json::to_string(name).unwrap();
        assert_eq!(serde_json::from_str::<String>(&visible(&json)).unwrap(), name);
    }
}
