//! What a worker process printed last.

use std::io::Read;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// The end of what a process printed; a flood of text costs no memory.
#[derive(Debug, Default)]
pub(super) struct LastWords {
    end: Mutex<Vec<u8>>,
}

const KEPT: usize = 4096;

impl LastWords {
    /// Listens to a stream until its end.
    pub(super) fn listen(mut stream: impl Read + Send + 'static) -> Arc<Self> {
        let words = Arc::new(Self::default());
        let kept = Arc::clone(&words);
        // The thread ends with the process at the other end of the pipe.
        thread::spawn(move || {
            let mut chunk = [0; KEPT];
            while let Ok(count @ 1..) = stream.read(&mut chunk) {
                let mut end = kept.end.lock().unwrap_or_else(PoisonError::into_inner);
                end.extend(&chunk[..count]);
                let surplus = end.len().saturating_sub(KEPT);
                end.drain(..surplus);
            }
        });
        words
    }

    /// The last line that is not empty.
    pub(super) fn text(&self) -> String {
        let end = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&end);
        let line = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        line.unwrap_or("").to_owned()
    }
}
