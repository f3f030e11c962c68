//! Keeps the last lines that a child prints.

use std::fs::File;
use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// The end of what is printed; a flood of text costs no memory.
const KEPT: usize = 4096;
/// How long the last words of a child may take to arrive.
const PATIENCE: Duration = Duration::from_millis(200);

/// Hears what a child prints.
#[derive(Debug)]
pub(super) struct Words {
    heard: Arc<Mutex<Vec<u8>>>,
    /// Disconnected when nobody can print any more.
    over: Option<Receiver<()>>,
    echo: Option<Arc<File>>,
}

impl Words {
    /// Nothing yet; with `echo`, what is printed is repeated there.
    pub(super) fn new(echo: Option<File>) -> Self {
        Self {
            heard: Arc::default(),
            over: None,
            echo: echo.map(Arc::new),
        }
    }

    /// Forgets what was heard, and listens to a new child.
    pub(super) fn listen(&mut self, mut pipe: impl Read + Send + 'static) {
        let heard = Arc::new(Mutex::new(Vec::new()));
        let (alive, over) = channel::<()>();
        let (place, echo) = (Arc::clone(&heard), self.echo.clone());
        thread::spawn(move || {
            let mut chunk = [0; KEPT];
            while let Ok(count @ 1..) = pipe.read(&mut chunk) {
                if let Some(mut echo) = echo.as_deref() {
                    // Nobody may be listening.
                    let _ = echo.write_all(&chunk[..count]);
                }
                let mut end = place.lock().unwrap_or_else(PoisonError::into_inner);
                end.extend_from_slice(&chunk[..count]);
                let surplus = end.len().saturating_sub(KEPT);
                end.drain(..surplus);
            }
            drop(alive);
        });
        (self.heard, self.over) = (heard, Some(over));
    }

    /// Waits for the last words of a child that has ended.
    pub(super) fn settle(&mut self) {
        if let Some(over) = self.over.take() {
            // Nothing is ever sent: the wait ends with the thread.
            let _ = over.recv_timeout(PATIENCE);
        }
    }

    /// Forgets what was heard so far.
    pub(super) fn clear(&mut self) {
        let mut heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        heard.clear();
    }

    /// The printed text that was kept.
    pub(super) fn text(&self) -> String {
        let heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        String::from_utf8_lossy(&heard).into_owned()
    }

    /// The last line that is not empty.
    pub(super) fn last_line(&self) -> String {
        let text = self.text();
        let line = text.lines().map(str::trim).rfind(|line| !line.is_empty());
        line.unwrap_or("").to_owned()
    }
}
