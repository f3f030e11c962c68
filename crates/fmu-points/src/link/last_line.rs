//! What a launcher prints for people: its last line tells why no worker came.

use std::{
    io::{BufRead, BufReader, Read},
    process::ChildStderr,
    sync::{Arc, Mutex},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

use fmu_import::locked;

/// The last line with anything on it that a launcher printed.
#[derive(Debug, Default)]
pub struct LastLine {
    text: Arc<Mutex<Option<String>>>,
    listener: Option<JoinHandle<()>>,
}

impl LastLine {
    /// Hears a launcher's standard error in a thread of its own, which ends when no process has that open any more.
    pub fn listen(&mut self, errors: ChildStderr) -> Result<(), String> {
        // A line that is longer is heard in parts: it must not fill the memory.
        const LONGEST: u64 = 1 << 16;
        let text = Arc::clone(&self.text);
        self.listener = Some(super::thread(move || {
            let mut errors = BufReader::new(errors);
            let mut line = Vec::new();
            while (&mut errors).take(LONGEST).read_until(b'\n', &mut line).is_ok_and(|count| count > 0) {
                keep(&text, &line);
                line.clear();
            }
        })?);
        Ok(())
    }

    /// Hears what came another way.
    pub fn hear(&self, bytes: &[u8]) {
        keep(&self.text, bytes);
    }

    /// Waits until all is heard of a launcher that has ended. A process that it left behind may hold its standard error open for
    /// ever, so the wait is short.
    pub fn settle(&self) {
        const PATIENCE: Duration = Duration::from_millis(200);
        let begun = Instant::now();
        while self.listener.as_ref().is_some_and(|listener| !listener.is_finished()) && begun.elapsed() < PATIENCE {
            thread::sleep(Duration::from_millis(1));
        }
    }

    /// The line behind a colon, to end a sentence with; where none was heard, that of other bytes, if they have one.
    pub fn told(&self, otherwise: &[u8]) -> String {
        let line = locked(&self.text).clone().or_else(|| last_line(otherwise));
        line.map(|line| format!(": {line}")).unwrap_or_default()
    }
}

fn keep(text: &Mutex<Option<String>>, printed: &[u8]) {
    if let line @ Some(_) = last_line(printed) {
        *locked(text) = line;
    }
}

/// The last line with anything on it, shortened.
fn last_line(printed: &[u8]) -> Option<String> {
    const LONGEST: usize = 400;
    let printed = String::from_utf8_lossy(printed);
    let line = printed.lines().map(str::trim).rfind(|line| !line.is_empty())?;
    Some(line.chars().take(LONGEST).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_with_anything_on_it_is_told() {
        let last = LastLine::default();
        assert_eq!((last.told(b""), last.told(b"zero\n")), (String::new(), ": zero".to_owned()));
        last.hear(b"one\n two \n\n  \n");
        last.hear(b"\n");
        assert_eq!(last.told(b"zero"), ": two");
        last.hear("ä".repeat(500).as_bytes());
        assert_eq!(last.told(b"").chars().count(), 2 + 400);
    }
}
