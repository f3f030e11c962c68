//! The messages between the processes of a study, over pipes.
//!
//! A supervisor has workers, each worker has children in which the FMU runs. All messages are frames with length and
//! checksum ([`frame`](fmu_import::isolation::frame)); numbers are little-endian. The first frame to a worker is its
//! [`Setup`] as JSON; then come orders: a byte that says how points are to be run, then the points. A worker gives
//! one [`Reply`] a point, many to a frame. An order to record a trajectory gets frames of rows instead, each behind
//! a byte that says whether it is the last one.

use std::path::PathBuf;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::conduct::Reason;
use crate::failure::Failure;
use crate::notices::Notices;
use crate::points::{Job, Simulated};
use crate::runner::Habit;
use crate::task::Case;
use fmu_import::{Content, Handle, Value};

/// The first message to a worker.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Setup {
    /// The folder of the unpacked FMU.
    pub(crate) fmu: PathBuf,
    /// The FMU's path as the user gave it.
    pub(crate) name: PathBuf,
    /// The working directory, empty for each child; none where that is the supervisor's own.
    pub(crate) place: Option<PathBuf>,
    /// The simulations of a point. Those of several cases are ordered one by one: see [`join`](crate::join).
    pub(crate) cases: Vec<Case>,
    /// The longest time that a point may take, s; none without a limit.
    pub(crate) time: Option<f64>,
    /// The most memory that a child may occupy, bytes.
    pub(crate) memory: u64,
    /// The number that marks all further frames.
    pub(crate) ticket: u64,
    /// The byte that fills memory which the FMU has not written; none for memory as it comes.
    pub(crate) fill: Option<u8>,
    /// Whether what the FMU prints is shown on standard error.
    pub(crate) echo: bool,
    /// Whether signals are looked at after every point, since one of them has changed how they are handled.
    pub(crate) careful: bool,
}

/// How points are run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// Each in a child that loads the FMU itself.
    New,
    /// Each in a child of a process that has loaded the FMU and never instantiated it.
    Forked,
    /// All in one child.
    Used(Habit),
    /// One point with its trajectory, in a child of its own.
    Recorded,
}

const WAYS: [Way; 5] = [
    Way::New,
    Way::Forked,
    Way::Used(Habit::Reset),
    Way::Used(Habit::Renew),
    Way::Recorded,
];

impl Way {
    pub(crate) fn put(self, into: &mut Vec<u8>) {
        let place = WAYS.iter().position(|way| *way == self);
        // `WAYS` has them all, and they are few.
        into.push(place.unwrap_or(0) as u8);
    }
}

/// The outcome of a point.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reply {
    /// The index of the point.
    pub(crate) index: u64,
    /// Its results in the FMU's units, or why there are none.
    pub(crate) answer: Result<Simulated, Trouble>,
    /// How long it took until there was an instance, s; 0 where that is not known.
    pub(crate) start: f32,
    /// How long the simulation took from then on, s; likewise.
    pub(crate) simulated: f32,
    /// Why no other point may use its process; none after a point that ended plainly.
    pub(crate) odd: Option<Odd>,
    /// Whether the process that has loaded the FMU may be forked, where that has been looked at.
    pub(crate) forkable: Option<bool>,
}

/// What was odd about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Odd {
    /// It failed, ended early, or the FMU said or returned something other than OK.
    Complaint,
    /// A thread of the FMU still runs.
    Threads,
    /// Signals are handled in another way than before.
    Signals,
}

impl Odd {
    const ALL: [Self; 3] = [Self::Complaint, Self::Threads, Self::Signals];

    /// Why points run alone that are mostly so.
    pub(crate) fn reason(self) -> Reason {
        match self {
            Self::Complaint => Reason::Complaints,
            Self::Threads => Reason::Threads,
            Self::Signals => Reason::Signals,
        }
    }
}

/// Why there are no results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Trouble {
    /// The FMU failed, and said so; its warnings before that.
    Failed {
        failure: Failure,
        notices: Box<Notices>,
    },
    /// The FMU refused an instance; whether it spoke of a licence.
    Refused { failure: Failure, licence: bool },
    /// The process ended, or had to be ended.
    Lost(Failure),
    /// The FMU cannot be loaded.
    Unloadable(String),
}

impl Trouble {
    /// The FMU's warnings before it failed, if there were any.
    pub(crate) fn notices(&self) -> Option<&Notices> {
        match self {
            Self::Failed { notices, .. } if !notices.is_empty() => Some(notices),
            _ => None,
        }
    }

    /// The failure as the results show it.
    pub(crate) fn failure(self) -> Failure {
        match self {
            Self::Failed { failure, .. } | Self::Refused { failure, .. } | Self::Lost(failure) => {
                failure
            }
            Self::Unloadable(text) => Failure::Unloadable(text),
        }
    }
}

/// Kinds of messages from a child.
pub(crate) mod speech {
    /// The FMU cannot be loaded; the reason follows.
    pub(crate) const UNLOADABLE: u8 = 0;
    /// It is loaded; 0 or 1 follows where it was looked at whether the process may be forked.
    pub(crate) const LOADED: u8 = 1;
    /// Replies follow.
    pub(crate) const REPLIES: u8 = 2;
    /// Rows of a trajectory follow.
    pub(crate) const ROWS: u8 = 3;
    /// The [`Notices`](crate::notices::Notices) of the point follow, now that its simulation has been ended.
    pub(crate) const FAREWELL: u8 = 4;
}

/// Whether a trajectory ends with a frame.
pub(crate) enum End {
    Not,
    Done,
    Failed(Failure),
}

/// Appends a job: the index of a simulation, and the point's values.
pub(crate) fn put_job(index: u64, values: &[f64], into: &mut Vec<u8>) {
    into.extend(index.to_le_bytes());
    put_numbers(values, into);
}

/// Appends results; `times` are those until there was an instance, and from then on, s.
pub(crate) fn put_results(
    index: u64,
    times: [f32; 2],
    values: &[f64],
    notices: Option<&Notices>,
    into: &mut Vec<u8>,
) {
    let notices = notices.filter(|notices| !notices.is_empty());
    put_head(
        index,
        if notices.is_some() { NOTED } else { GOOD },
        times,
        into,
    );
    put_numbers(values, into);
    if let Some(notices) = notices {
        put_json(notices, into);
    }
}

/// Appends why there are none.
pub(crate) fn put_trouble(index: u64, times: [f32; 2], trouble: &Trouble, into: &mut Vec<u8>) {
    put_head(index, BAD, times, into);
    put_json(trouble, into);
}

fn put_json(value: &impl Serialize, into: &mut Vec<u8>) {
    let text = serde_json::to_vec(value).unwrap_or_default();
    put_length(text.len(), into);
    into.extend(text);
}

/// Appends a reply.
pub(crate) fn put_reply(reply: &Reply, into: &mut Vec<u8>) {
    let begin = into.len();
    let times = [reply.start, reply.simulated];
    match &reply.answer {
        Ok(Simulated { values, notices }) => {
            put_results(reply.index, times, values, notices.as_deref(), into);
        }
        Err(trouble) => put_trouble(reply.index, times, trouble, into),
    }
    into[begin + FORKABLE] = reply.forkable.map_or(2, u8::from);
    mark(reply.odd, &mut into[begin..]);
}

/// Says in a reply what was odd about its point.
pub(crate) fn mark(odd: Option<Odd>, reply: &mut [u8]) {
    let place = Odd::ALL.iter().position(|known| Some(*known) == odd);
    reply[ODD] = place.map_or(0, |place| 1 + place as u8);
}

/// The kinds of replies: a point without results, one with results, and one with results and notices.
const BAD: u8 = 0;
const GOOD: u8 = 1;
const NOTED: u8 = 2;

/// Where the byte is in a reply that says whether the process may be forked.
const FORKABLE: usize = 9;
/// Where the byte is that says what was odd.
const ODD: usize = 10;

fn put_head(index: u64, kind: u8, times: [f32; 2], into: &mut Vec<u8>) {
    into.extend(index.to_le_bytes());
    into.extend([kind, 2, 0]);
    times
        .iter()
        .for_each(|time| into.extend(time.to_le_bytes()));
}

/// Appends how a trajectory ended.
pub(crate) fn put_end(end: &End, into: &mut Vec<u8>) {
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
pub(crate) fn put_value(value: &Value, into: &mut Vec<u8>) {
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
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl Reader<'_> {
    pub(crate) fn job(&mut self) -> Option<Job> {
        let index = u64::from_le_bytes(self.array()?);
        Some(Job {
            index,
            values: self.numbers()?,
        })
    }

    /// How the points of an order are to be run.
    pub(crate) fn way(&mut self) -> Option<Way> {
        let [number] = self.array()?;
        WAYS.get(usize::from(number)).copied()
    }

    pub(crate) fn reply(&mut self) -> Option<Reply> {
        let index = u64::from_le_bytes(self.array()?);
        let [kind, forkable, odd] = self.array()?;
        let start = f32::from_le_bytes(self.array()?);
        let simulated = f32::from_le_bytes(self.array()?);
        let answer = match kind {
            GOOD => Ok(self.numbers()?.into()),
            NOTED => Ok(Simulated {
                values: self.numbers()?,
                notices: Some(self.json()?),
            }),
            BAD => Err(self.json()?),
            _ => return None,
        };
        Some(Reply {
            index,
            answer,
            start,
            simulated,
            odd: usize::from(odd)
                .checked_sub(1)
                .and_then(|place| Odd::ALL.get(place).copied()),
            forkable: (forkable < 2).then_some(forkable == 1),
        })
    }

    /// How a trajectory goes on.
    pub(crate) fn end(&mut self) -> Option<End> {
        match self.array()? {
            [0] => Some(End::Not),
            [1] => Some(End::Done),
            [_] => Some(End::Failed(serde_json::from_slice(self.0).ok()?)),
        }
    }

    /// A row of a trajectory: the time, and a value per column.
    pub(crate) fn row(&mut self, columns: &[Handle]) -> Option<(f64, Vec<Value>)> {
        let time = f64::from_le_bytes(self.array()?);
        let value = |column: &Handle| self.value(column.content);
        Some((time, columns.iter().map(value).collect::<Option<_>>()?))
    }

    fn value(&mut self, content: Content) -> Option<Value> {
        Some(match content {
            Content::Real => Value::Real(f64::from_le_bytes(self.array()?)),
            Content::Integer => Value::Integer(i64::from_le_bytes(self.array()?)),
            Content::Boolean => Value::Boolean(self.array()? == [1]),
            Content::Text => {
                let length = self.length()?;
                Value::String(String::from_utf8_lossy(self.bytes(length)?).into_owned())
            }
        })
    }

    fn json<T: DeserializeOwned>(&mut self) -> Option<T> {
        let length = self.length()?;
        serde_json::from_slice(self.bytes(length)?).ok()
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
        fn what_was_put_is_read(index: u64, values: Vec<f64>, text: String, start: f32) {
            let job = Job { index, values };
            let notices = Box::new(Notices { warnings: index, ..Notices::default() });
            let trouble = Trouble::Failed { failure: Failure::Error(text), notices };
            let odd = Some(Odd::Signals);
            let lost = Reply { index, answer: Err(trouble.clone()), start, simulated: 2.0, odd, forkable: Some(true) };
            let times = [start, 2.0];
            let mut bytes = Vec::new();
            Way::Used(Habit::Renew).put(&mut bytes);
            put_job(job.index, &job.values, &mut bytes);
            put_results(index, times, &job.values, None, &mut bytes);
            put_reply(&lost, &mut bytes);
            let notices = Notices { warnings: index, ended: Some(0.5), ..Notices::default() };
            put_results(index, times, &job.values, Some(&notices), &mut bytes);
            let mut reader = Reader(&bytes);
            let bits = |values: &[f64]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
            prop_assert_eq!(reader.way(), Some(Way::Used(Habit::Renew)));
            prop_assert_eq!(bits(&reader.job().unwrap().values), bits(&job.values));
            let reply = reader.reply().unwrap();
            prop_assert_eq!((reply.index, reply.forkable, reply.odd), (index, None, None));
            prop_assert_eq!(bits(&reply.answer.unwrap().values), bits(&job.values));
            let reply = reader.reply().unwrap();
            prop_assert_eq!((reply.index, reply.forkable, reply.start.to_bits()), (index, Some(true), start.to_bits()));
            prop_assert_eq!((reply.simulated.to_bits(), reply.odd), (2_f32.to_bits(), odd));
            prop_assert_eq!(reply.answer, Err(trouble));
            let noted = reader.reply().unwrap().answer.unwrap();
            prop_assert_eq!(bits(&noted.values), bits(&job.values));
            prop_assert_eq!(noted.notices.as_deref(), Some(&notices));
            prop_assert!(reader.0.is_empty());
        }

        #[test]
        fn rows_are_read_as_they_were_put(time: f64, real: f64, whole: i64, flag: bool, text: String) {
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
            let _ = Reader(&bytes).reply();
        }
    }
}
