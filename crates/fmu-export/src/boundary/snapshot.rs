//! Saved states: as a handle within the process, and as bytes that another process can read.
//!
//! The bytes are, little-endian: `FMUSTATE`, the format's version (2 bytes), the description's fingerprint (16), the
//! length of the rest (8), its CRC-32 (4), the rest.

use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use super::{
    guard::{magic, ours},
    instance::Instance,
    phase::Phase,
    raw,
    refusal::{Outcome, Refusal},
    run::Run,
    types::{FmuState, Status},
    version::Version,
};
use crate::model::{Model, events};

const MARK: &[u8; 8] = b"FMUSTATE";
const VERSION: u16 = 4;
const HEADER: usize = 8 + 2 + 16 + 8 + 4;

/// The target of the pointer that the host has of a saved state.
#[repr(C)]
pub struct Saved<M> {
    magic: AtomicU64,
    run: Run<M>,
}

impl<M: Model> Saved<M> {
    const KIND: u64 = 0x5a4e_d57a;

    fn give(run: Run<M>, version: Version) -> FmuState {
        let magic = AtomicU64::new(magic::<M>(Self::KIND, version));
        Box::into_raw(Box::new(Self { magic, run })).cast()
    }

    /// # Safety
    /// The state is NULL, or points to at least eight readable bytes; one of ours is alive and
    /// not written to during `'a`. Several instances may read it at once.
    unsafe fn find<'a>(state: FmuState, version: Version) -> Outcome<&'a Self> {
        // SAFETY: as the caller promises; the number is written by `give` only, in front of a state of this type.
        unsafe { ours(state, magic::<M>(Self::KIND, version), version.state()) }
    }
}

impl<M: Model> Instance<M> {
    /// Saves the state, in place of an earlier one if `place` holds one.
    ///
    /// # Safety
    /// `place` holds NULL or a state of this FMU that was not freed and that no other call uses.
    pub unsafe fn save(&mut self, place: &mut FmuState) -> Outcome {
        let run = self.run.clone();
        if place.is_null() {
            *place = Saved::give(run, self.version);
        } else {
            // SAFETY: the caller promises that `place` holds NULL or a living state of this FMU.
            unsafe { Saved::<M>::find(*place, self.version) }?;
            // SAFETY: a state of ours, as was just found, which no other call uses.
            unsafe { (*place.cast::<Saved<M>>()).run = run };
        }
        Ok(())
    }

    /// Goes back to a saved state.
    ///
    /// # Safety
    /// `state` is NULL or a state of this FMU that was not freed.
    pub unsafe fn restore(&mut self, state: FmuState) -> Outcome {
        // SAFETY: the caller promises that `state` is NULL or a living state of this FMU.
        let run = &unsafe { Saved::<M>::find(state, self.version) }?.run;
        let event_mode = run.phase == Phase::Event && !run.exchange;
        if run.exchange != self.run.exchange || event_mode && self.event_mode.is_none() {
            return Err(Refusal::Absent(
                "the state belongs to an interface or a mode that this instance does not have",
            ));
        }
        self.run = run.clone();
        Ok(())
    }

    /// Frees a saved state. NULL, and a place that holds NULL, are left alone.
    ///
    /// # Safety
    /// `place` is NULL, or holds NULL or a state of this FMU that was not freed and that no other call uses.
    pub unsafe fn free_state(&mut self, place: *mut FmuState) -> Outcome {
        if place.is_null() {
            return Ok(());
        }
        // SAFETY: the caller promises that it is NULL or such a place.
        let place = unsafe { raw::place(place, self.version.state()) }?;
        if place.is_null() {
            return Ok(());
        }
        // SAFETY: the caller promises that `place` holds NULL or a living state of this FMU.
        unsafe { Saved::<M>::find(*place, self.version) }?.magic.store(0, Ordering::Relaxed);
        // SAFETY: made by `give`, freed only here.
        drop(unsafe { Box::from_raw(place.cast::<Saved<M>>()) });
        *place = std::ptr::null_mut();
        Ok(())
    }

    /// The bytes of a saved state.
    ///
    /// # Safety
    /// `state` is NULL or a state of this FMU that was not freed.
    pub unsafe fn serialize(&self, state: FmuState) -> Outcome<Vec<u8>> {
        // SAFETY: the caller promises that `state` is NULL or a living state of this FMU.
        encode(&unsafe { Saved::<M>::find(state, self.version) }?.run, self.fingerprint)
    }

    /// Writes them to a place for `size` bytes.
    ///
    /// # Safety
    /// As for [`serialize`](Self::serialize); there is room for that many bytes.
    pub unsafe fn serialize_to(&self, state: FmuState, place: *mut u8, size: usize) -> Outcome {
        // SAFETY: as the caller promises.
        let bytes = unsafe { self.serialize(state) }?;
        if size < bytes.len() {
            return Err(Refusal::Size { given: size, needed: bytes.len() });
        }
        // SAFETY: as the caller promises.
        unsafe { raw::values_mut(place, bytes.len(), "serializedState") }?.copy_from_slice(&bytes);
        Ok(())
    }

    /// Makes a saved state of bytes. What `place` held before is not read, as the standard
    /// does not say that the host initialises it.
    pub fn deserialize(&self, bytes: &[u8], place: &mut FmuState) -> Outcome {
        *place = Saved::<M>::give(decode(bytes, self.fingerprint)?, self.version);
        Ok(())
    }
}

/// A run as it is serialised.
#[derive(Serialize, Deserialize)]
struct Record {
    phase: Phase,
    stale: bool,
    sloped: bool,
    time: f64,
    start: f64,
    stop: Option<f64>,
    tolerance: Option<f64>,
    discarded: bool,
    failed: bool,
    exchange: bool,
    model: Vec<u8>,
    seed: Option<Vec<u8>>,
}

fn encode<M: Model>(run: &Run<M>, fingerprint: u128) -> Outcome<Vec<u8>> {
    let record = Record {
        phase: run.phase,
        stale: run.stale,
        sloped: run.sloped,
        time: run.time,
        start: run.start,
        stop: run.stop,
        tolerance: run.tolerance,
        discarded: run.last_step == Status::Discard,
        failed: run.last_step == Status::Error,
        exchange: run.exchange,
        model: run.model.save()?,
        seed: run.seed.as_ref().map(Model::save).transpose()?,
    };
    let rest = postcard::to_stdvec(&record).map_err(|error| Refusal::Bytes(error.to_string()))?;
    let mut bytes = Vec::with_capacity(HEADER + rest.len());
    bytes.extend_from_slice(MARK);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&fingerprint.to_le_bytes());
    bytes.extend_from_slice(&(rest.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&crc32fast::hash(&rest).to_le_bytes());
    bytes.extend_from_slice(&rest);
    Ok(bytes)
}

fn decode<M: Model>(bytes: &[u8], fingerprint: u128) -> Outcome<Run<M>> {
    let record = read(bytes, fingerprint)?;
    let run = Run {
        phase: record.phase,
        model: model(&record.model)?,
        seed: record.seed.as_deref().map(model).transpose()?,
        stale: record.stale,
        differentiated: false,
        sloped: record.sloped,
        time: record.time,
        start: record.start,
        stop: record.stop,
        tolerance: record.tolerance,
        last_step: match (record.failed, record.discarded) {
            (true, _) => Status::Error,
            (false, true) => Status::Discard,
            (false, false) => Status::Ok,
        },
        at_once: (0.0, 0),
        exchange: record.exchange,
    };
    let stepped = matches!(run.phase, Phase::StepComplete | Phase::StepFailed);
    let plausible = run.time.is_finite()
        && (run.phase != Phase::Continuous || run.exchange)
        && (run.phase != Phase::Event || run.exchange || events::<M>().is_some())
        && (!stepped || !run.exchange)
        && !matches!(run.phase, Phase::Fatal | Phase::Intermediate)
        && run.seed.is_some() == (run.phase == Phase::Initialization);
    if plausible { Ok(run) } else { Err(broken("its parts contradict each other")) }
}

/// Checks the header and the checksum, then reads the rest.
fn read(bytes: &[u8], fingerprint: u128) -> Outcome<Record> {
    let (mark, bytes) = take::<8>(bytes)?;
    if mark != *MARK {
        return Err(broken("they do not begin with FMUSTATE"));
    }
    let (version, bytes) = take(bytes)?;
    if u16::from_le_bytes(version) != VERSION {
        return Err(broken("they are of another version of the format"));
    }
    let (table, bytes) = take(bytes)?;
    if u128::from_le_bytes(table) != fingerprint {
        return Err(broken("another FMU, or another version of this one, wrote them"));
    }
    let (length, bytes) = take(bytes)?;
    let (checksum, rest) = take(bytes)?;
    if u64::from_le_bytes(length) != rest.len() as u64 {
        return Err(broken("some are missing, or there are too many"));
    }
    if u32::from_le_bytes(checksum) != crc32fast::hash(rest) {
        return Err(broken("they are damaged: the checksum is wrong"));
    }
    postcard::from_bytes(rest).map_err(|error| broken(&error.to_string()))
}

fn take<const N: usize>(bytes: &[u8]) -> Outcome<([u8; N], &[u8])> {
    bytes.split_first_chunk::<N>().map(|(first, rest)| (*first, rest)).ok_or_else(|| broken("some are missing"))
}

fn model<M: Model>(bytes: &[u8]) -> Outcome<M> {
    let mut model = M::default();
    model.restore(bytes).map_err(|fault| broken(&fault.to_string()))?;
    Ok(model)
}

fn broken(why: &str) -> Refusal {
    Refusal::Bytes(why.to_owned())
}
