//! Standard output.

use std::io::{self, Write};

/// Writes a text. A reader that has gone, such as `head`, is no error.
pub(super) fn print(text: &str) {
    let mut out = io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}
