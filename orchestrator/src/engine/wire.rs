//! What a supervisor and its worker processes say to each other, over pipes.
//!
//! Messages are frames: a length of 4 bytes, then so many bytes; numbers are little-endian.
//! The first frame to a worker is its [`Setup`] as JSON, which it answers with an empty frame or
//! with the reason why it cannot begin. Then come frames of jobs; answers come back in the
//! jobs' order, many to a frame. A setup with a trajectory to record gets frames of rows instead, each
//! behind a byte that says whether it is the last one.

use std::io::{self, Read, Write};
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::{Answer, Job};
use crate::failure::Failure;
use crate::task::{Record, Task};
use fmu_import::{Content, Handle, Value};

/// What a worker needs to know to begin.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Setup {
    /// The folder of the unpacked FMU.
    pub(super) fmu: PathBuf,
    /// What is to be done for each point.
    pub(super) task: Task,
    /// The file in which the worker notes the point that it is at.
    pub(super) place: PathBuf,
    /// The supervisor, whose end is the worker's end.
    pub(super) supervisor: u32,
    /// What the user calls the FMU.
    pub(super) name: PathBuf,
    /// A point that is run with its trajectory, instead of jobs.
    pub(super) record: Option<Record>,
    /// A reset is taken at its word, for those who want to see what it does.
    pub(super) candid: bool,
}

/// Whether a trajectory ends with a frame.
pub(super) enum End {
    Not,
    Done,
    Failed(Failure),
}

/// More than any frame has, against damaged lengths.
const MAX_FRAME: u32 = 1 << 30;

/// Writes a frame.
pub(super) fn write_frame(mut into: impl Write, payload: &[u8]) -> io::Result<()> {
    let length = u32::try_from(payload.len())
        .ok()
        .filter(|&length| length <= MAX_FRAME);
    let length = length.ok_or_else(|| io::Error::other("a message is too long"))?;
    into.write_all(&length.to_le_bytes())?;
    into.write_all(payload)?;
    into.flush()
}

/// Reads a frame; `false` at the end of the stream.
pub(super) fn read_frame(mut from: impl Read, payload: &mut Vec<u8>) -> io::Result<bool> {
    let mut length = [0; 4];
    match from.read_exact(&mut length) {
        Ok(()) => {}
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(false),
        Err(error) => return Err(error),
    }
    let length = u32::from_le_bytes(length);
    if length > MAX_FRAME {
        return Err(io::Error::other("a message is damaged"));
    }
    payload.clear();
    // Grows with what really comes, whatever the length says.
    let read = from.take(length.into()).read_to_end(payload)?;
    if read == length as usize {
        Ok(true)
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

/// Appends a job.
pub(super) fn put_job(job: &Job, into: &mut Vec<u8>) {
    into.extend(job.index.to_le_bytes());
    put_numbers(&job.values, into);
}

/// Appends an answer.
pub(super) fn put_answer(index: u64, answer: &Result<&[f64], Failure>, into: &mut Vec<u8>) {
    into.extend(index.to_le_bytes());
    match answer {
        Ok(values) => {
            into.push(1);
            put_numbers(values, into);
        }
        Err(failure) => {
            into.push(0);
            let text = serde_json::to_vec(failure).unwrap_or_default();
            put_length(text.len(), into);
            into.extend(text);
        }
    }
}

/// Appends how a trajectory ended.
pub(super) fn put_end(end: &End, into: &mut Vec<u8>) {
    match end {
        End::Not => into.push(0),
        End::Done => into.push(1),
        End::Failed(failure) => {
            into.push(2);
            into.extend(serde_json::to_vec(failure).unwrap_or_default());
        }
    }
}

/// Appends a value of a trajectory's row.
pub(super) fn put_value(value: &Value, into: &mut Vec<u8>) {
    match value {
        Value::Real(value) => into.extend(value.to_le_bytes()),
        Value::Integer(value) => into.extend(value.to_le_bytes()),
        Value::Boolean(value) => into.push(u8::from(*value)),
        Value::String(text) => {
            put_length(text.len(), into);
            into.extend(text.as_bytes());
        }
    }
}

#[allow(clippy::cast_possible_truncation)]
fn put_length(length: usize, into: &mut Vec<u8>) {
    into.extend((length as u32).to_le_bytes());
}

fn put_numbers(values: &[f64], into: &mut Vec<u8>) {
    put_length(values.len(), into);
    values
        .iter()
        .for_each(|value| into.extend(value.to_le_bytes()));
}

/// Reads what was put into a frame; `None` where that is damaged.
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl Reader<'_> {
    pub(super) fn job(&mut self) -> Option<Job> {
        let index = u64::from_le_bytes(self.array()?);
        Some(Job {
            index,
            values: self.numbers()?,
        })
    }

    pub(super) fn answer(&mut self) -> Option<(u64, Answer)> {
        let index = u64::from_le_bytes(self.array()?);
        let [good] = self.array()?;
        let answer = if good == 1 {
            Ok(self.numbers()?)
        } else {
            let length = self.length()?;
            Err(serde_json::from_slice(self.bytes(length)?).ok()?)
        };
        Some((index, answer))
    }

    /// How a trajectory goes on.
    pub(super) fn end(&mut self) -> Option<End> {
        match self.array()? {
            [0] => Some(End::Not),
            [1] => Some(End::Done),
            [_] => Some(End::Failed(serde_json::from_slice(self.0).ok()?)),
        }
    }

    /// A row of a trajectory: the time, and a value a column.
    pub(super) fn row(&mut self, columns: &[Handle]) -> Option<(f64, Vec<Value>)> {
        let time = f64::from_le_bytes(self.array()?);
        let value = |column: &Handle| self.value(column.content);
        Some((time, columns.iter().map(value).collect::<Option<_>>()?))
    }

    fn value(&mut self, content: Content) -> Option<Value> {
        Some(match content {
            Content::Real => Value::Real(f64::from_le_bytes(self.array()?)),
            Content::Integer => Value::Integer(i32::from_le_bytes(self.array()?)),
            Content::Boolean => Value::Boolean(self.array()? == [1]),
            Content::Text => {
                let length = self.length()?;
                Value::String(String::from_utf8_lossy(self.bytes(length)?).into_owned())
            }
        })
    }

    fn numbers(&mut self) -> Option<Vec<f64>> {
        let length = self.length()?;
        let bytes = self.bytes(length.checked_mul(8)?)?;
        let numbers = bytes.as_chunks::<8>().0.iter();
        Some(numbers.map(|number| f64::from_le_bytes(*number)).collect())
    }

    fn length(&mut self) -> Option<usize> {
        usize::try_from(u32::from_le_bytes(self.array()?)).ok()
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn bytes(&mut self, count: usize) -> Option<&[u8]> {
        let (bytes, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_was_put_is_read(index: u64, values: Vec<f64>, text: String) {
            let job = Job { index, values };
            let failure = Failure::Error(text);
            let mut bytes = Vec::new();
            put_job(&job, &mut bytes);
            put_answer(index, &Ok(&job.values), &mut bytes);
            put_answer(index, &Err(failure.clone()), &mut bytes);
            let mut frame = Vec::new();
            write_frame(&mut frame, &bytes).unwrap();
            let mut payload = Vec::new();
            prop_assert!(read_frame(&frame[..], &mut payload).unwrap());
            let mut reader = Reader(&payload);
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(bits(&reader.job().unwrap().values), bits(&job.values));
            let (_, answer) = reader.answer().unwrap();
            prop_assert_eq!(bits(&answer.unwrap()), bits(&job.values));
            prop_assert_eq!(reader.answer(), Some((index, Err(failure))));
            prop_assert!(reader.0.is_empty());
        }

        #[test]
        fn rows_are_read_as_they_were_put(time: f64, real: f64, whole: i32, flag: bool, text: String) {
            let row = [Value::Real(real), Value::Integer(whole), Value::Boolean(flag), Value::String(text)];
            let contents = [Content::Real, Content::Integer, Content::Boolean, Content::Text];
            let columns = contents.map(|content| Handle { reference: 0, content });
            let mut bytes = Vec::new();
            put_end(&End::Not, &mut bytes);
            for _ in 0..2 {
                put_value(&Value::Real(time), &mut bytes);
                row.iter().for_each(|value| put_value(value, &mut bytes));
            }
            let mut reader = Reader(&bytes);
            prop_assert!(matches!(reader.end(), Some(End::Not)));
            for _ in 0..2 {
                let (then, values) = reader.row(&columns).unwrap();
                prop_assert_eq!(then.to_bits(), time.to_bits());
                prop_assert_eq!(&values[..], &row[..]);
            }
            prop_assert!(reader.row(&columns).is_none());
        }

        #[test]
        fn damage_is_no_panic(bytes: Vec<u8>) {
            let column = Handle { reference: 0, content: Content::Text };
            let _ = Reader(&bytes).row(&[column]);
            let _ = Reader(&bytes).end();
            let _ = Reader(&bytes).job();
            let _ = Reader(&bytes).answer();
            let _ = read_frame(&bytes[..], &mut Vec::new());
        }
    }
}
