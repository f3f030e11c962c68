//! A pipe for which one can wait for a limited time: a thread reads it.

use std::{
    io::{self, Read},
    sync::mpsc::{Receiver, RecvTimeoutError, sync_channel},
    thread,
    time::Duration,
};

/// Pieces that wait at most: then the sender has to wait, as with a full pipe.
const PIECES: usize = 16;
const PIECE: usize = 1 << 14;

/// The bytes that arrive from a pipe.
#[derive(Debug)]
pub struct Arrivals {
    from: Receiver<Vec<u8>>,
    piece: Vec<u8>,
    taken: usize,
    over: bool,
}

impl Arrivals {
    /// The bytes that arrive from this pipe, from now on.
    pub fn of(mut pipe: impl Read + Send + 'static) -> Self {
        let (send, from) = sync_channel(PIECES);
        thread::spawn(move || {
            let mut buffer = [0; PIECE];
            while let Ok(count @ 1..) = pipe.read(&mut buffer) {
                if send.send(buffer[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { from, piece: Vec::new(), taken: 0, over: false }
    }

    /// Waits until there is something to read, or the end of it; `false` when the time is over.
    pub fn wait(&mut self, time: Duration) -> bool {
        if self.over || self.taken < self.piece.len() {
            return true;
        }
        match self.from.recv_timeout(time) {
            Ok(piece) => (self.piece, self.taken) = (piece, 0),
            Err(RecvTimeoutError::Disconnected) => self.over = true,
            Err(RecvTimeoutError::Timeout) => return false,
        }
        true
    }
}

impl Read for Arrivals {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        while !self.wait(Duration::from_secs(1)) {}
        let rest = &self.piece[self.taken..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.taken += count;
        Ok(count)
    }
}
