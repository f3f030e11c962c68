//! What a worker process printed last.

use std::io::{self, Read, Write};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// The end of what a process printed; a flood of text costs no memory.
#[derive(Debug, Default)]
pub(super) struct LastWords {
    heard: Mutex<Heard>,
    ended: Condvar,
}

#[derive(Debug, Default)]
struct Heard {
    end: Vec<u8>,
    all: bool,
}

const KEPT: usize = 4096;
/// How long the end of the stream is waited for: a process that is gone may have left its end of the pipe
/// to a child of its own.
const PATIENCE: Duration = Duration::from_secs(1);

impl LastWords {
    /// Listens to a stream until its end; `echo` repeats it on standard error.
    pub(super) fn listen(mut stream: impl Read + Send + 'static, echo: bool) -> Arc<Self> {
        let words = Arc::new(Self::default());
        let kept = Arc::clone(&words);
        // The thread ends with the process at the other end of the pipe.
        thread::spawn(move || {
            let mut chunk = [0; KEPT];
            loop {
                let count = stream.read(&mut chunk).unwrap_or(0);
                if echo {
                    // Nobody may be listening.
                    let _ = io::stderr().write_all(&chunk[..count]);
                }
                let mut heard = kept.heard.lock().unwrap_or_else(PoisonError::into_inner);
                heard.end.extend(&chunk[..count]);
                let surplus = heard.end.len().saturating_sub(KEPT);
                heard.end.drain(..surplus);
                heard.all = count == 0;
                if heard.all {
                    kept.ended.notify_all();
                    return;
                }
            }
        });
        words
    }

    /// The last line that is not empty, of a process that has ended: what it printed may still be on its way.
    pub(super) fn text(&self) -> String {
        let heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        let (heard, _) = self
            .ended
            .wait_timeout_while(heard, PATIENCE, |heard| !heard.all)
            .unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&heard.end);
        let line = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        line.unwrap_or("").to_owned()
    }
}
