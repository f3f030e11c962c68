//! The form in which processes send each other bytes: a head with length and checksum, then the payload.
//!
//! An FMU may write into any open descriptor, so a reader trusts nothing: a frame that does not begin with the
//! mark, that belongs to another exchange, or whose checksum differs is [`Broken`], and the sender is given up.

use std::io::{self, Read, Write};

/// The first bytes of each frame.
const MARK: [u8; 4] = *b"FMUf";
/// Mark, ticket, length and checksum.
const HEAD: usize = 4 + 8 + 4 + 4;
/// The longest payload: far above any answer, far below what would exhaust the memory.
const LONGEST: usize = 1 << 28;
/// The part of a payload that is written together with the head: what a pipe holds.
const TOGETHER: usize = 1 << 16;

/// The bytes are no frame of this exchange.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Broken {
    /// The bytes do not begin with the mark.
    #[error("foreign bytes came instead of an answer: the FMU writes into descriptors that it did not open")]
    Mark,
    /// The frame answers something else.
    #[error("an answer to another question came")]
    Ticket,
    /// The length is beyond all reason.
    #[error("an answer of {0} bytes was announced")]
    Length(usize),
    /// The payload was altered on its way.
    #[error("an answer came damaged: its checksum differs")]
    Checksum,
}

/// Writes one frame and flushes it.
///
/// # Errors
/// When the reader has gone, and for a payload longer than any reader takes.
pub fn write(mut to: impl Write, ticket: u64, payload: &[u8]) -> io::Result<()> {
    if payload.len() > LONGEST {
        return Err(io::Error::other("the answer is too long to be sent"));
    }
    // One write for head and payload: nothing that an FMU's thread writes meanwhile comes between them. No pipe takes
    // more than `TOGETHER` in one go, so a longer payload, such as a measured curve, is not copied for it.
    let (first, rest) = payload.split_at(payload.len().min(TOGETHER));
    // `LONGEST` fits.
    let length = (payload.len() as u32).to_le_bytes();
    let checksum = checksum(ticket, payload).to_le_bytes();
    let bytes = [&MARK[..], &ticket.to_le_bytes(), &length, &checksum, first].concat();
    to.write_all(&bytes)?;
    to.write_all(rest)?;
    to.flush()
}

/// Takes the first frame out of what has arrived so far; `None` while it is incomplete.
///
/// # Errors
/// As soon as the bytes cannot become a frame with this ticket.
pub fn take(arrived: &mut Vec<u8>, ticket: u64) -> Result<Option<Vec<u8>>, Broken> {
    let known = arrived.len().min(MARK.len());
    if arrived[..known] != MARK[..known] {
        return Err(Broken::Mark);
    }
    let Some(head) = arrived.first_chunk::<HEAD>() else { return Ok(None) };
    let [low, high, length, checksum_then] =
        [4, 8, 12, 16].map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
    if u64::from(low) | u64::from(high) << 32 != ticket {
        return Err(Broken::Ticket);
    }
    let length = length as usize;
    if length > LONGEST {
        return Err(Broken::Length(length));
    }
    let Some(payload) = arrived.get(HEAD..HEAD + length) else { return Ok(None) };
    if checksum(ticket, payload) != checksum_then {
        return Err(Broken::Checksum);
    }
    let payload = payload.to_vec();
    arrived.drain(..HEAD + length);
    Ok(Some(payload))
}

/// Frames from one sender that are not yet taken.
#[derive(Debug)]
pub struct Inbox<R> {
    from: R,
    arrived: Vec<u8>,
    ticket: u64,
}

impl<R: Read> Inbox<R> {
    /// Frames with this ticket.
    pub fn new(from: R, ticket: u64) -> Self {
        Self { from, arrived: Vec::new(), ticket }
    }

    /// From here on, frames have another ticket.
    pub fn expect(&mut self, ticket: u64) {
        self.ticket = ticket;
    }

    /// The bytes that have arrived and are not taken yet.
    pub fn seen(&self) -> &[u8] {
        &self.arrived
    }

    /// Passes over so many of them.
    pub fn skip(&mut self, count: usize) {
        self.arrived.drain(..count.min(self.arrived.len()));
    }

    /// Where the frames come from.
    pub fn source(&self) -> &R {
        &self.from
    }

    /// The same, to wait there.
    pub fn source_mut(&mut self) -> &mut R {
        &mut self.from
    }

    /// The next frame that has arrived whole, without reading.
    ///
    /// # Errors
    /// When what has arrived is no frame.
    pub fn arrived(&mut self) -> Result<Option<Vec<u8>>, Broken> {
        take(&mut self.arrived, self.ticket)
    }

    /// Reads once; `false` at the end of the stream.
    ///
    /// # Errors
    /// When the system says no.
    pub fn read(&mut self) -> io::Result<bool> {
        let mut buffer = [0; 1 << 12];
        match self.from.read(&mut buffer) {
            Ok(0) => Ok(false),
            Ok(count) => {
                self.arrived.extend_from_slice(&buffer[..count]);
                Ok(true)
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Ok(true),
            Err(error) => Err(error),
        }
    }

    /// Waits for the next frame; `None` at the end of the stream.
    ///
    /// # Errors
    /// When the system says no, and when what arrives is no frame.
    pub fn wait(&mut self) -> io::Result<Option<Vec<u8>>> {
        loop {
            if let Some(payload) = self.arrived().map_err(io::Error::other)? {
                return Ok(Some(payload));
            }
            if !self.read()? {
                return Ok(None);
            }
        }
    }
}

/// Covers the ticket too, so that a frame cannot be taken for another's.
fn checksum(ticket: u64, payload: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&ticket.to_le_bytes());
    hasher.update(payload);
    hasher.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_arrives_whole_or_not_at_all() {
        let mut sent = Vec::new();
        write(&mut sent, 7, b"hello").unwrap();
        write(&mut sent, 7, b"").unwrap();
        let mut arrived = Vec::new();
        let mut got = Vec::new();
        for byte in sent {
            arrived.push(byte);
            while let Some(payload) = take(&mut arrived, 7).unwrap() {
                got.push(payload);
            }
        }
        assert_eq!(got, [b"hello".to_vec(), Vec::new()]);
        assert!(arrived.is_empty());
    }

    #[test]
    fn any_altered_byte_is_noticed() {
        let mut sent = Vec::new();
        write(&mut sent, 7, b"hello").unwrap();
        for at in 0..sent.len() {
            for bit in 0..8 {
                let mut bytes = sent.clone();
                bytes[at] ^= 1 << bit;
                // A length that grew leaves the frame incomplete: its reader runs into the deadline.
                assert!(matches!(take(&mut bytes, 7), Err(_) | Ok(None)), "bit {bit} of byte {at}");
            }
        }
        assert_eq!(take(&mut b"stray".to_vec(), 7), Err(Broken::Mark));
        assert_eq!(take(&mut sent, 8), Err(Broken::Ticket));
    }
}
