//! The end of a text; a flood of it costs no memory.

use crate::logger::shortened;

/// How much is kept, bytes.
pub const KEPT: usize = 4096;

/// What may go to a terminal: an FMU's own control characters could paint over what the program says there.
pub fn harmless(chunk: &[u8]) -> String {
    String::from_utf8_lossy(chunk)
        .replace("\r\n", "\n")
        .chars()
        .map(|c| if c.is_control() && !matches!(c, '\n' | '\t') { char::REPLACEMENT_CHARACTER } else { c })
        .collect()
}

/// The last bytes of what was printed.
#[derive(Debug, Default)]
pub struct Tail(Vec<u8>);

impl Tail {
    pub fn add(&mut self, chunk: &[u8]) {
        self.0.extend_from_slice(chunk);
        let surplus = self.0.len().saturating_sub(KEPT);
        self.0.drain(..surplus);
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.0).into_owned()
    }

    /// The last line that is not empty.
    pub fn last_line(&self) -> String {
        let text = self.text();
        let line = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        shortened(line.unwrap_or("").to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_does_not_reach_it() {
        assert_eq!(harmless(b"warm\x1b[2J\r\n\tand \xc3\xa9\x07\n"), "warm\u{fffd}[2J\n\tand \u{e9}\u{fffd}\n");
    }
}
