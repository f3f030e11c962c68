//! The end of a text; a flood of it costs no memory.

use crate::logger::shortened;

/// How much is kept, bytes.
pub(super) const KEPT: usize = 4096;

/// The last bytes of what was printed.
#[derive(Debug, Default)]
pub(super) struct Tail(Vec<u8>);

impl Tail {
    pub(super) fn add(&mut self, chunk: &[u8]) {
        self.0.extend_from_slice(chunk);
        let surplus = self.0.len().saturating_sub(KEPT);
        self.0.drain(..surplus);
    }

    pub(super) fn text(&self) -> String {
        String::from_utf8_lossy(&self.0).into_owned()
    }

    /// The last line that is not empty.
    pub(super) fn last_line(&self) -> String {
        let text = self.text();
        let line = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        shortened(line.unwrap_or("").to_owned())
    }
}
