//! Points that failed, once more while no other point runs.
//!
//! An FMU may need what only one process can have at a time: a port, a file. Then a point fails because of another one.
//! A study may have very many points that fail for reasons of their own: of each kind of failure a few are tried again, and
//! further ones only as long as that changes something.

use std::{
    collections::BTreeMap,
    sync::{Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard},
};

use crate::failure::Failure;
use fmu_import::locked;

/// So many points of a kind that fail again are enough; of those that took too long, one.
const ENOUGH: u32 = 3;
/// So many kinds are told apart by their words; further ones only by their class.
const KINDS: usize = 32;

/// Lets points run beside each other, or one alone.
#[derive(Debug, Default)]
pub struct Quiet {
    floor: RwLock<()>,
    /// How many points in a row failed again, by the kind of failure.
    in_vain: Mutex<BTreeMap<String, u32>>,
}

impl Quiet {
    /// While this is held, others may run, but none alone.
    pub fn beside_others(&self) -> RwLockReadGuard<'_, ()> {
        self.floor.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// While this is held, nothing else runs.
    pub fn alone(&self) -> RwLockWriteGuard<'_, ()> {
        self.floor.write().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a point that failed so is worth another try.
    pub fn is_open(&self, failure: &Failure) -> bool {
        let enough = match failure.cause() {
            // The FMU was not even asked.
            Failure::OutOfRange(_) => return false,
            Failure::Timeout => 1,
            _ => ENOUGH,
        };
        let in_vain = locked(&self.in_vain);
        in_vain.get(&kind(failure, &in_vain)).is_none_or(|count| *count < enough)
    }

    /// Notes what came of the other try.
    pub fn note(&self, failure: &Failure, failed: bool) {
        let mut in_vain = locked(&self.in_vain);
        let kind = kind(failure, &in_vain);
        if failed {
            *in_vain.entry(kind).or_default() += 1;
        } else {
            in_vain.remove(&kind);
        }
    }
}

/// Failures with the same words are of one kind, whatever numbers stand in them.
fn kind(failure: &Failure, known: &BTreeMap<String, u32>) -> String {
    const LENGTH: usize = 80;
    let kind: String =
        failure.cause().to_string().chars().filter(|letter| !letter.is_ascii_digit()).take(LENGTH).collect();
    if known.len() >= KINDS && !known.contains_key(&kind) { failure.class().to_owned() } else { kind }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_that_fail_again_are_left_alone_and_others_are_not() {
        let quiet = Quiet::default();
        let failure = |index: u64, why: &str| Failure::Error(format!("{index} {why}"));
        for index in 0..3 {
            assert!(quiet.is_open(&failure(index, "is too large")));
            quiet.note(&failure(index, "is too large"), true);
            quiet.note(&failure(index, "port in use"), index != 1);
        }
        assert!(!quiet.is_open(&failure(7, "is too large")) && quiet.is_open(&failure(7, "port in use")));
        quiet.note(&Failure::Timeout, true);
        assert!(!quiet.is_open(&Failure::Timeout) && !quiet.is_open(&Failure::OutOfRange(String::new())));
    }
}
