//! Keeps the last lines that a child prints.

use std::{
    fs::File,
    io::{Read, Write},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        mpsc::{Receiver, channel},
    },
    thread,
    time::Duration,
};

use crate::isolation::tail::{KEPT, Tail, harmless};

/// How long the last words of a child may take to arrive.
const PATIENCE: Duration = Duration::from_millis(200);

/// Hears what a child prints.
#[derive(Debug)]
pub struct Words {
    heard: Arc<Mutex<Tail>>,
    /// Disconnected when nobody can print any more.
    over: Option<Receiver<()>>,
    echo: Option<Arc<File>>,
}

impl Words {
    /// Nothing yet; with `echo`, what is printed is repeated there.
    pub fn new(echo: Option<File>) -> Self {
        Self { heard: Arc::default(), over: None, echo: echo.map(Arc::new) }
    }

    /// Forgets what was heard, and listens to a new child.
    pub fn listen(&mut self, mut pipe: impl Read + Send + 'static) {
        let heard = Arc::<Mutex<Tail>>::default();
        let (alive, over) = channel::<()>();
        let (place, echo) = (Arc::clone(&heard), self.echo.clone());
        thread::spawn(move || {
            let mut chunk = [0; KEPT];
            while let Ok(count @ 1..) = pipe.read(&mut chunk) {
                if let Some(mut echo) = echo.as_deref() {
                    // Nobody may be listening.
                    let _ = echo.write_all(harmless(&chunk[..count]).as_bytes());
                }
                let mut end = place.lock().unwrap_or_else(PoisonError::into_inner);
                end.add(&chunk[..count]);
            }
            drop(alive);
        });
        (self.heard, self.over) = (heard, Some(over));
    }

    /// Waits for the last words of a child that has ended.
    pub fn settle(&mut self) {
        if let Some(over) = self.over.take() {
            // Nothing is ever sent: the wait ends with the thread.
            let _ = over.recv_timeout(PATIENCE);
        }
    }

    fn heard(&self) -> MutexGuard<'_, Tail> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The printed text that was kept.
    pub fn text(&self) -> String {
        self.heard().text()
    }

    /// The last line that is not empty.
    pub fn last_line(&self) -> String {
        self.heard().last_line()
    }
}
