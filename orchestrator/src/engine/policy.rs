//! How far the points of a study may share processes: what the workers have found out together.
//!
//! A point's result is what the FMU gives alone in a process that has loaded it and never instantiated it. The
//! first points are run in really new processes, under two patterns of unwritten memory, and in forks of a process
//! that has loaded the FMU: only where all agree are forks used. Processes are used for many points only where
//! that pays and has been proven on points, in different orders. Some points are computed again in a new process with
//! other bytes in unwritten memory: [a few](super::repeats) where that takes little time, and further ones as long as
//! that takes at most a fiftieth of the time.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use super::Job;
use super::conduct::{Conduct, Isolation, Separation};
use super::repeats::Repeats;
use crate::run::Habit;

/// The next task of a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Plan {
    /// Run a point in several ways and [report](Policy::probed).
    Probe,
    /// Run a point alone.
    Alone(Separation),
    /// Run a point as an audit does.
    Audit,
    /// Find out whether processes may be used again, and [report](Policy::tried).
    Trial,
    /// Run points in one process.
    Used(Habit),
}

/// The result of a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Probed {
    /// New processes and forks agree.
    Alike,
    /// New processes agree with each other; forks are not possible, or differ.
    NoForks,
    /// New processes differ from each other.
    Different,
    /// It was interrupted.
    Nothing,
}

/// How many points are probed, where that takes little time.
const PROBES: u32 = 3;
/// On how many points reuse is proven, where starts are cheap.
const PROOF: usize = 8;
/// A start that takes longer is dear, s.
const DEAR: f64 = 1.0;
/// The least time of all workers together that the points to come must take alone for reuse to be tried, s: the time
/// of two workers is no cheaper for passing twice as fast.
const WORTH: f64 = 1.0;
/// How long the audits of the chosen points may take together, s.
const LITTLE: f64 = 5.0;
/// How much of the time audits may take beyond that.
const SHARE: f64 = 0.02;
/// So many audits a worker are made in any case, and so many of its last points, where one takes less than
/// [`SHORT`] or this part of the time so far.
const FEW: u32 = 5;
const LAST: u32 = 3;
const SHORT: f64 = 0.05;
const SHORT_SHARE: f64 = 0.02;
/// How long a licence is waited for while no other point gets one.
const LICENCE: Duration = Duration::from_secs(600);

/// A point with its results, computed alone.
pub(super) type Proof = (Job, Vec<f64>);

/// Time that a worker has spent on points of one kind, and on their audits.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spent {
    /// Time for the points, s.
    pub(super) computed: f64,
    /// Time for audits, s.
    pub(super) audited: f64,
    /// How many there were.
    pub(super) audits: u32,
}

impl Spent {
    /// Whether there is time for an audit that takes `one` seconds.
    pub(super) fn allows(&self, one: f64) -> bool {
        SHARE * self.computed >= self.audited + one
    }

    /// How many of some points that were just computed are to be audited, where one audit takes `one` seconds;
    /// `last`: there will be no further points.
    pub(super) fn audits(&self, one: f64, last: bool) -> u32 {
        let share = (SHARE * self.computed - self.audited) / one.max(1e-6);
        let usual = if share > 0.0 { share as u32 } else { 0 };
        let cheap = one < SHORT || one < SHORT_SHARE * self.computed;
        let least = match (cheap, last) {
            (false, _) => 0,
            (true, true) => LAST,
            (true, false) => u32::from(self.audits < FEW),
        };
        usual.max(least)
    }

    /// Notes an audit.
    pub(super) fn note(&mut self, took: f64) {
        self.audited += took;
        self.audits += 1;
    }
}

/// The points that were computed twice, each counted once however often that was.
#[derive(Debug, Default)]
struct Audits {
    /// Whether the point was always the same, and whether it had shared a process.
    points: BTreeMap<u64, (bool, bool)>,
    shared: u64,
    mismatches: u64,
    /// How long one takes, s: the latest ones count most.
    time: Option<f64>,
    /// How long those of the chosen points took together, s.
    of_chosen: f64,
}

impl Audits {
    fn note(&mut self, index: u64, agreed: bool, used: bool) {
        let (same, shared) = self.points.entry(index).or_insert((true, false));
        self.mismatches += u64::from(*same && !agreed);
        self.shared += u64::from(used && !*shared);
        *same &= agreed;
        *shared |= used;
    }
}

/// Decides how points share processes, from all that is known of the FMU.
#[derive(Debug)]
pub(super) struct Policy {
    wish: Isolation,
    /// A tool stands behind the FMU.
    tool: bool,
    /// The most independent processes: new ones, or new ones with a folder each where the FMU changes its folder.
    strictest: Separation,
    /// Whether every point runs as strictly as an audited one: in a process of its own.
    auditing: bool,
    /// The points that are computed twice in any case; none where nothing is audited.
    repeats: OnceLock<Repeats>,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// How points are run alone; unknown at first.
    alone: Option<Separation>,
    probing: bool,
    probes: u32,
    probe_time: Duration,
    reuse: Reuse,
    reused: bool,
    proof: Vec<Proof>,
    reproducible: bool,
    audits: Audits,
    /// How many points were computed alone.
    alone_so_far: usize,
    /// How long a point takes alone, s: the latest ones count most.
    time: Option<f64>,
    /// How long a point takes in a new process, s.
    time_of_new: f64,
    dear: bool,
    /// Whether the FMU has ever been loaded.
    loaded: bool,
    /// When an instance was made last.
    instance: Option<Instant>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reuse {
    Untried,
    OnTrial,
    Earned(Habit),
    Refused,
}

impl Policy {
    pub(super) fn new(wish: Isolation, tool: bool) -> Self {
        let reuse = match wish {
            Isolation::Audited => Reuse::Untried,
            Isolation::Reuse => Reuse::Earned(Habit::Reset),
            Isolation::Fresh | Isolation::InProcess => Reuse::Refused,
        };
        Self {
            wish,
            tool,
            strictest: Separation::New,
            auditing: false,
            repeats: OnceLock::new(),
            state: Mutex::new(State {
                alone: None,
                probing: false,
                probes: 0,
                probe_time: Duration::ZERO,
                reuse,
                reused: false,
                proof: Vec::new(),
                reproducible: true,
                audits: Audits::default(),
                alone_so_far: 0,
                time: None,
                time_of_new: 0.0,
                dear: tool,
                loaded: false,
                instance: None,
            }),
        }
    }

    /// A policy for points that have an unpacked FMU each.
    pub(super) fn apart(tool: bool) -> Self {
        Self {
            strictest: Separation::Apart,
            ..Self::new(Isolation::Fresh, tool)
        }
    }

    /// A policy for points that are computed again as in audits.
    pub(super) fn auditing() -> Self {
        Self {
            auditing: true,
            ..Self::new(Isolation::Fresh, false)
        }
    }

    /// How the user wishes points to share processes.
    pub(super) fn wish(&self) -> Isolation {
        self.wish
    }

    /// The most independent processes: new ones, or new ones with a folder each where the FMU changes its folder.
    pub(super) fn strictest(&self) -> Separation {
        self.strictest
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Every change leaves it sound.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The next task; `left` is the number of points to come, where it is known.
    pub(super) fn plan(&self, left: Option<usize>) -> Plan {
        if self.auditing {
            return Plan::Audit;
        }
        let mut state = self.state();
        let Some(alone) = state.alone else {
            if state.probing {
                return Plan::Alone(self.strictest);
            }
            state.probing = true;
            return Plan::Probe;
        };
        match state.reuse {
            Reuse::Earned(habit) => Plan::Used(habit),
            Reuse::Untried if self.is_worth_a_trial(&state, left) => {
                state.reuse = Reuse::OnTrial;
                Plan::Trial
            }
            _ => Plan::Alone(alone),
        }
    }

    /// Whether reuse could save so much that its trial pays.
    fn is_worth_a_trial(&self, state: &State, left: Option<usize>) -> bool {
        let wanted = if state.dear { 1 } else { PROOF };
        if state.proof.len() < wanted {
            return false;
        }
        // The trial runs each point three times and starts a process; it must stay a small part of what is left.
        const PART: usize = 20;
        // A search asks for few points at a time: one that has asked for so many will probably ask for as many again.
        let left = left.map_or(usize::MAX, |left| left.max(state.alone_so_far));
        let enough = if state.dear { 4 } else { 3 * PART * wanted };
        let mean = state.mean();
        left > enough && left as f64 * mean > WORTH
    }

    /// Notes what a probe found and how long it took.
    pub(super) fn probed(&self, found: Probed, took: Duration) {
        let mut state = self.state();
        state.probing = false;
        state.probe_time += took;
        match found {
            Probed::Nothing => {}
            Probed::Different => state.give_up_reproducing(self.strictest),
            Probed::NoForks => state.alone = Some(self.strictest),
            // Meanwhile an audit may have shown that forks, or new processes, differ: that stays so.
            Probed::Alike if state.alone.is_some() => {}
            Probed::Alike => {
                state.probes += 1;
                let long = state.probe_time > Duration::from_secs(1);
                if long || state.dear || state.probes >= PROBES || self.wish == Isolation::Reuse {
                    state.alone = Some(Separation::Forked);
                }
            }
        }
    }

    /// How points are run alone, as far as that is known.
    pub(super) fn alone(&self) -> Separation {
        self.state().alone.unwrap_or(self.strictest)
    }

    /// Whether a single probe is enough, because every start costs much.
    pub(super) fn is_dear(&self) -> bool {
        self.state().dear
    }

    /// Notes a point that was computed alone, and how long that took, s, where nothing else was started for it.
    pub(super) fn note(
        &self,
        job: &Job,
        values: &[f64],
        separation: Separation,
        took: Option<f64>,
    ) {
        let mut state = self.state();
        state.alone_so_far += 1;
        if let (true, Some(took)) = (separation == self.strictest, took) {
            state.time_of_new = took;
        }
        if let (true, Some(took)) = (state.alone == Some(separation), took) {
            state.time = Some(latest(state.time, took));
        }
        if state.proof.len() < PROOF && self.wish == Isolation::Audited {
            state.proof.push((job.clone(), values.to_vec()));
        }
    }

    /// Notes that an instance was made, and how long it took from the start of its process, s.
    pub(super) fn instantiated(&self, start: f64) {
        let mut state = self.state();
        state.instance = Some(Instant::now());
        state.loaded = true;
        state.dear |= start > DEAR;
    }

    /// Notes that the FMU was loaded, whatever came after that.
    pub(super) fn loaded(&self) {
        self.state().loaded = true;
    }

    /// Whether the FMU was ever loaded: if not, it will never be.
    pub(super) fn has_loaded(&self) -> bool {
        self.state().loaded
    }

    /// Whether a refused instance is to be asked for again: it spoke of a licence, or the tool behind the FMU
    /// gave one before; and it is not too long that nobody got one.
    pub(super) fn waits_for_licence(&self, spoken: bool, since: Instant) -> bool {
        let state = self.state();
        let last = state.instance.map_or(since, |instance| instance.max(since));
        (spoken || self.tool && state.instance.is_some()) && last.elapsed() < LICENCE
    }

    /// There are too few licences: no process may keep one between points. Says whether some did, so that their points
    /// have to be computed again, because their last audits will not come.
    pub(super) fn share_licences(&self) -> bool {
        let mut state = self.state();
        if self.wish != Isolation::Audited || state.reuse == Reuse::Refused {
            return false;
        }
        state.reuse = Reuse::Refused;
        state.reused
    }

    /// The points on which reuse is to be proven.
    pub(super) fn proof(&self) -> Vec<Proof> {
        let mut state = self.state();
        if state.dear {
            state.proof.truncate(1);
        }
        state.proof.clone()
    }

    /// How long a point takes alone, s.
    pub(super) fn mean_time(&self) -> f64 {
        self.state().mean()
    }

    /// Notes what a trial found: the habit that gave the same, if it is worth it.
    pub(super) fn tried(&self, habit: Option<Habit>) {
        let mut state = self.state();
        if state.reuse == Reuse::OnTrial {
            state.reuse = habit.map_or(Reuse::Refused, Reuse::Earned);
            state.proof = Vec::new();
        }
    }

    /// Notes that points were computed in a used process.
    pub(super) fn note_reuse(&self) {
        self.state().reused = true;
    }

    /// Chooses the points that are computed twice in any case.
    pub(super) fn repeat(&self, repeats: &Repeats) {
        // Later sets of points of the same run keep the first choice.
        let _ = self.repeats.set(repeats.clone());
    }

    /// Whether points are computed twice now and then: not where the user wants none, nor once it is known that they
    /// differ.
    pub(super) fn audits(&self) -> bool {
        let wanted = matches!(self.wish, Isolation::Fresh | Isolation::Audited);
        wanted && self.repeats.get().is_some() && self.state().reproducible
    }

    /// Whether a point is one of those that are computed twice in any case.
    pub(super) fn chooses(&self, index: u64) -> bool {
        self.repeats.get().is_some_and(|repeats| repeats.has(index))
    }

    /// Whether there is time to compute a chosen point twice.
    pub(super) fn has_time(&self) -> bool {
        let state = self.state();
        !state.dear && state.audits.of_chosen + state.time_of_audit() <= LITTLE
    }

    /// The place of a point in the order in which points are audited.
    pub(super) fn rank(&self, index: u64) -> u64 {
        self.repeats.get().map_or(0, |repeats| repeats.rank(index))
    }

    /// How long it takes to compute a point again in a new process, s.
    pub(super) fn time_of_audit(&self) -> f64 {
        self.state().time_of_audit()
    }

    /// Notes how long an audit took, s.
    pub(super) fn note_audit(&self, took: f64, chosen: bool) {
        let mut state = self.state();
        let audits = &mut state.audits;
        audits.time = Some(latest(audits.time, took));
        audits.of_chosen += if chosen { took } else { 0.0 };
    }

    /// Notes what came of an audit of a point that had been computed in such a process.
    pub(super) fn audited(&self, index: u64, agreed: bool, separation: Separation) {
        let used = separation == Separation::Used;
        self.state().audits.note(index, agreed, used);
    }

    /// Points of this separation are not to be had any more. Those that there are do not count.
    pub(super) fn refute(&self, separation: Separation) {
        let mut state = self.state();
        state.reuse = Reuse::Refused;
        if separation == Separation::Forked {
            state.alone = Some(self.strictest);
        }
    }

    /// New processes differ among themselves.
    pub(super) fn give_up_reproducing(&self) {
        self.state().give_up_reproducing(self.strictest);
    }

    /// How the points were computed.
    pub(super) fn conduct(&self) -> Conduct {
        let state = self.state();
        Conduct {
            isolation: match (self.wish, state.reuse) {
                (Isolation::Audited, Reuse::Earned(_)) if state.reused => Isolation::Audited,
                (Isolation::Reuse, Reuse::Earned(_)) => Isolation::Reuse,
                (Isolation::InProcess, _) => Isolation::InProcess,
                _ => Isolation::Fresh,
            },
            audits: state.audits.points.len() as u64,
            audits_of_shared: state.audits.shared,
            audit_mismatches: state.audits.mismatches,
            reproducible: match self.wish {
                _ if !state.reproducible => Some(false),
                Isolation::Reuse | Isolation::InProcess => None,
                _ if state.audits.points.is_empty() => None,
                _ => Some(true),
            },
            changed_file: None,
        }
    }
}

/// A mean in which the latest values count most.
fn latest(before: Option<f64>, value: f64) -> f64 {
    const WEIGHT: f64 = 0.2;
    let before = before.unwrap_or(value);
    before + WEIGHT * (value - before)
}

impl State {
    fn time_of_audit(&self) -> f64 {
        self.audits.time.unwrap_or(self.time_of_new)
    }

    fn mean(&self) -> f64 {
        self.time.unwrap_or(0.0)
    }

    fn give_up_reproducing(&mut self, strictest: Separation) {
        self.reproducible = false;
        self.alone = Some(strictest);
        self.reuse = Reuse::Refused;
    }
}

#[cfg(test)]
mod tests;
