//! How far the points of a study may share processes: what the workers have found out together.
//!
//! A point's result is what the FMU gives alone in a process that has loaded it and never instantiated it. The
//! first points are run in really new processes, under two patterns of unwritten memory, and in forks of a process
//! that has loaded the FMU: only where all agree are forks used. Points share processes once that has been proven on
//! points in different orders, unless most of them leave a process that no other may use, or a process each costs next to
//! nothing. These are counts and medians of many times: no single reading of a clock decides, and nothing is decided for
//! good but what was proven. Some points are computed again in a new process with other bytes in unwritten memory:
//! [a few](crate::repeats) where that takes little time, and further ones as long as that takes at most a fiftieth of the
//! time.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::conduct::{Conduct, Isolation, Reason, Separation};
use crate::locked::locked;
use crate::points::Job;
use crate::repeats::{ENOUGH, Repeats};
use crate::runner::Reuse;
use crate::wire::Reply;

/// The next task of a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Plan {
    /// Run a point in several ways and [report](Policy::probed).
    Probe,
    /// Run a point alone.
    Alone(Separation),
    /// Run a point as an audit does.
    Audit,
    /// Find out whether processes may be used again, and [report](Policy::tried).
    Trial,
    /// Run points in one process.
    Used(Reuse),
}

/// The result of a probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Probed {
    /// New processes and forks agree.
    Alike,
    /// New processes agree with each other; forks are not possible, or differ.
    NoForks,
    /// New processes differ from each other.
    Different,
    /// It was interrupted.
    Nothing,
}

/// The reaction to an instance that was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wait {
    /// Nothing: it stays refused.
    No,
    /// Ask again.
    Again,
    /// Ask again, and tell the user for how long at most.
    Told(Duration),
    /// It stays refused, and so will others: tell the user.
    GivenUp(Duration),
}

/// How many points are probed, where that takes little time.
const PROBES: u32 = 3;
/// On how many points reuse is proven, where starts are cheap.
const PROOF: usize = 8;
/// A start that always takes longer is dear, s.
const DEAR: f64 = 1.0;
/// Where simulations take a greater part of the time of points that run alone, a process each costs next to nothing.
const LONG: f64 = 0.9;
/// So many of the latest points tell how many are odd, and so many odd ones among them are too many for sharing.
const LATEST: usize = 64;
const MANY: usize = 8;
/// How long the audits of the chosen points may take together, s.
const LITTLE: f64 = 5.0;
/// How much of the time audits may take beyond that.
const SHARE: f64 = 0.02;
/// So many audits are made in any case, and so many of the last points, where one takes less than [`SHORT`] or this part of
/// the time so far.
const FEW: f64 = 5.0;
const LAST: u32 = 3;
const SHORT: f64 = 0.05;
const SHORT_SHARE: f64 = 0.02;
/// How long a licence is waited for while no other point gets one, and where none ever did.
const LICENCE: Duration = Duration::from_secs(600);
const FIRST_LICENCE: Duration = Duration::from_secs(60);

/// A point with its results, computed alone.
pub(crate) type Proof = (Job, Vec<f64>);

/// Time that was spent on points of one kind, and on their audits.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Spent {
    /// Time for the points, s.
    computed: f64,
    /// Time for audits, s.
    audited: f64,
    /// How many there were.
    audits: f64,
    /// How much of the time for the points this supervisor's own workers took, s.
    here: f64,
}

/// Time that was spent on points in used processes and on those that ran alone; and how long the audits that are made in any
/// case took together, s.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Spending {
    kinds: [Spent; 2],
    in_any_case: f64,
}

impl Spending {
    /// Takes over what others spent: `join` makes one number of two.
    fn join(&mut self, others: &Self, join: fn(f64, f64) -> f64) {
        for (spent, other) in self.kinds.iter_mut().zip(&others.kinds) {
            spent.computed = join(spent.computed, other.computed);
            spent.audited = join(spent.audited, other.audited);
            spent.audits = join(spent.audits, other.audits);
        }
        self.in_any_case = join(self.in_any_case, others.in_any_case);
    }
}

impl Spent {
    /// How long audits may take now, s. Of what is left for them everywhere, each supervisor has the part that it has computed.
    fn allowance(&self) -> f64 {
        let part = self.here / self.computed.max(1e-9);
        (SHARE * self.computed - self.audited) * part
    }

    /// How many of some points that were just computed are to be audited, where one audit takes `one` seconds;
    /// `last`: there will be no further points.
    fn audits(&self, one: f64, last: bool) -> u32 {
        let share = self.allowance() / one.max(1e-6);
        let usual = if share > 0.0 { share as u32 } else { 0 };
        let cheap = one < SHORT || one < SHORT_SHARE * self.computed;
        let least = match (cheap, last) {
            (false, _) => 0,
            (true, true) => LAST,
            (true, false) => u32::from(self.audits < FEW),
        };
        usual.max(least)
    }
}

/// The points that were computed twice, each counted once however often that was.
#[derive(Debug, Default)]
struct Audits {
    /// Whether the point was always the same, and whether it had followed another one in its process.
    points: BTreeMap<u64, (bool, bool)>,
    shared: u64,
    mismatches: u64,
    /// How long one takes, s.
    times: Readings,
    /// How many of those that are made in any case stood right behind an odd point.
    behind_odd: usize,
    /// Those that nobody else was told of.
    latest: Vec<(u64, bool, bool)>,
}

impl Audits {
    fn note(&mut self, index: u64, agreed: bool, shared: bool) {
        self.latest.push((index, agreed, shared));
        let (same, known) = self.points.entry(index).or_insert((true, false));
        self.mismatches += u64::from(*same && !agreed);
        self.shared += u64::from(shared && !*known);
        *same &= agreed;
        *known |= shared;
    }
}

/// The latest readings of a quantity. Their median does not mind that some of them were disturbed.
#[derive(Debug, Default)]
struct Readings(VecDeque<f64>);

impl Readings {
    const KEPT: usize = 15;

    fn note(&mut self, value: f64) {
        if self.0.len() == Self::KEPT {
            self.0.pop_front();
        }
        self.0.push_back(value);
    }

    fn median(&self) -> Option<f64> {
        let mut sorted: Vec<f64> = self.0.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }
}

/// Decides how points share processes, from all that is known of the FMU. The workers of a run have it together.
#[derive(Debug, Default)]
pub(crate) struct Policy {
    /// How the user wishes points to share processes.
    pub(crate) wish: Isolation,
    /// A tool stands behind the FMU.
    tool: bool,
    /// Whether points run beside others.
    pub(crate) company: bool,
    /// Whether the FMU changes its folder, so that each point has one of its own.
    apart: bool,
    /// Whether every point runs as strictly as an audited one: in a process of its own.
    auditing: bool,
    /// The points that are computed twice in any case; none where nothing is audited.
    repeats: Option<Repeats>,
    /// How points are run alone; unknown at first.
    alone: Option<Separation>,
    probing: bool,
    probes: u32,
    probe_time: Duration,
    sharing: Sharing,
    /// Whether points were computed in a used process.
    pub(crate) reused: bool,
    proof: Vec<Proof>,
    /// Whether new processes differ among themselves.
    differing: bool,
    audits: Audits,
    /// Time spent everywhere as far as that is known, and what nobody else was told of.
    spent: Spending,
    untold: Spending,
    /// The oddities of the latest points.
    latest: VecDeque<Option<Reason>>,
    /// How many points were computed alone.
    alone_so_far: usize,
    /// Which part of the time of a point alone its simulation takes.
    simulating: Readings,
    /// The shortest start of an instance from the start of its process on, s.
    start: Option<f64>,
    /// Whether the FMU has ever been loaded: if not, it will never be.
    pub(crate) loaded: bool,
    /// When an instance was made last.
    instance: Option<Instant>,
    /// Whether the user was told that a licence is waited for, and whether that was in vain.
    told: bool,
    hopeless: bool,
    /// Whether a worker on another machine finds out how points may share processes.
    led: bool,
    /// Why points ran alone on other machines, where they did.
    reason_there: Option<Reason>,
}

/// What workers on several machines tell each other of the FMU.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Found {
    alone: Option<Separation>,
    sharing: Sharing,
    differing: bool,
    reused: bool,
    start: Option<f64>,
    reason: Option<Reason>,
    /// Points that were computed twice: whether they were the same, and whether they had followed another one.
    audits: Vec<(u64, bool, bool)>,
    /// Time spent here since this was told last, and everywhere.
    spent: Spending,
    spent_by_all: Spending,
    /// The first file that the FMU changed in its folder.
    pub(crate) changed: Option<String>,
    /// Whether another worker is finding out how points may share processes.
    pub(crate) led: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Sharing {
    #[default]
    Untried,
    OnTrial,
    Earned(Reuse),
    Refused(Reason),
}

impl Policy {
    /// A policy for points of an FMU with a tool behind it or not, which run beside others or not.
    pub(crate) fn new(wish: Isolation, tool: bool, company: bool) -> Self {
        Self {
            wish,
            tool,
            company,
            sharing: match wish {
                Isolation::Audited => Sharing::Untried,
                Isolation::Reuse => Sharing::Earned(Reuse::Reset),
                Isolation::Fresh | Isolation::InProcess => Sharing::Refused(Reason::Asked),
            },
            ..Self::default()
        }
    }

    /// A policy for points that have an unpacked FMU each.
    pub(crate) fn apart(tool: bool, company: bool) -> Self {
        Self { apart: true, ..Self::new(Isolation::Fresh, tool, company) }
    }

    /// A policy for points that are computed again as in audits.
    pub(crate) fn auditing() -> Self {
        Self { auditing: true, ..Self::new(Isolation::Fresh, false, false) }
    }

    /// The most independent processes: new ones, or new ones with a folder each where the FMU changes its folder.
    pub(crate) fn strictest(&self) -> Separation {
        match self.apart {
            true => Separation::Apart,
            false => Separation::New,
        }
    }

    /// The next task; `left` is the number of points to come, where it is known.
    pub(crate) fn plan(&mut self, left: Option<usize>) -> Plan {
        if self.auditing {
            return Plan::Audit;
        }
        let Some(alone) = self.alone else {
            if self.led || std::mem::replace(&mut self.probing, true) {
                return Plan::Alone(self.strictest());
            }
            return Plan::Probe;
        };
        match self.sharing {
            // Whoever wants that gets it.
            Sharing::Earned(reuse) if self.wish == Isolation::Reuse || !self.is_odd() => Plan::Used(reuse),
            Sharing::Untried if !self.led && self.is_worth_a_trial(left) => {
                self.sharing = Sharing::OnTrial;
                Plan::Trial
            }
            _ => Plan::Alone(alone),
        }
    }

    /// Whether sharing saves more than its trial takes.
    fn is_worth_a_trial(&self, left: Option<usize>) -> bool {
        let dear = self.is_dear();
        let wanted = if dear { 1 } else { PROOF };
        if self.proof.len() < wanted || self.is_odd() || self.is_long() {
            return false;
        }
        // The trial runs each point three times and starts a process; it must stay a small part of what is left.
        const PART: usize = 20;
        // A search asks for few points at a time: one that has asked for so many will probably ask for as many again.
        let left = left.map_or(usize::MAX, |left| left.max(self.alone_so_far));
        left > if dear { 4 } else { 3 * PART * wanted }
    }

    /// Notes what a probe found and how long it took.
    pub(crate) fn probed(&mut self, outcome: Probed, took: Duration) {
        self.probing = false;
        self.probe_time += took;
        match outcome {
            Probed::Nothing => {}
            Probed::Different => self.give_up_reproducing(),
            Probed::NoForks => self.alone = Some(self.strictest()),
            // Meanwhile an audit may have shown that forks, or new processes, differ: that stays so.
            Probed::Alike if self.alone.is_some() => {}
            Probed::Alike => {
                self.probes += 1;
                let long = self.probe_time > Duration::from_secs(1);
                let enough = long || self.probes >= PROBES || self.wish == Isolation::Reuse;
                if enough || self.is_dear() {
                    self.alone = Some(Separation::Forked);
                }
            }
        }
    }

    /// How points are run alone, as far as that is known.
    pub(crate) fn alone(&self) -> Separation {
        self.alone.unwrap_or(self.strictest())
    }

    /// Whether a single probe is enough, because every start costs much.
    pub(crate) fn is_dear(&self) -> bool {
        self.tool || self.start.is_some_and(|start| start > DEAR)
    }

    /// Notes a point with results that was computed alone, and how long that took, s, where nothing else was started for it.
    pub(crate) fn note(&mut self, job: &Job, reply: &Reply, separation: Separation, took: Option<f64>) {
        let Ok(simulated) = &reply.answer else {
            return;
        };
        self.alone_so_far += 1;
        self.note_odd(reply.odd);
        if let (true, Some(took)) = (separation == self.strictest(), took) {
            // An audit takes as long.
            self.audits.times.note(took);
        }
        if let (true, Some(took)) = (self.alone == Some(separation), took) {
            let part = f64::from(reply.simulated) / took.max(1e-9);
            self.simulating.note(part);
        }
        let plain = reply.odd.is_none();
        if plain && self.proof.len() < PROOF && self.wish == Isolation::Audited {
            self.proof.push((job.clone(), simulated.values.clone()));
        }
    }

    /// Notes what was odd about a point.
    pub(crate) fn note_odd(&mut self, odd: Option<Reason>) {
        if self.latest.len() == LATEST {
            self.latest.pop_front();
        }
        self.latest.push_back(odd);
    }

    /// Notes that an instance was made, and how long it took from the start of its process, s.
    pub(crate) fn instantiated(&mut self, start: f64) {
        self.instance = Some(Instant::now());
        self.loaded = true;
        self.hopeless = false;
        self.start = Some(self.start.map_or(start, |least| least.min(start)));
    }

    /// Whether a refused instance is to be asked for again: it spoke of a licence, or the tool behind the FMU
    /// gave one before. A point waits no longer than it may take, and where nobody got an instance for a whole round, no
    /// further one is waited for until somebody does.
    pub(crate) fn wait(&mut self, spoken: bool, since: Instant, limit: Duration) -> Wait {
        let wanted = spoken || self.tool && self.instance.is_some();
        if !wanted || self.hopeless {
            return Wait::No;
        }
        let round = self.instance.map_or(FIRST_LICENCE, |_| LICENCE).min(limit);
        let last = self.instance.map_or(since, |last| last.max(since));
        if last.elapsed() >= round {
            self.hopeless = true;
            return Wait::GivenUp(round);
        }
        if since.elapsed() >= limit {
            return Wait::No;
        }
        if std::mem::replace(&mut self.told, true) { Wait::Again } else { Wait::Told(round) }
    }

    /// There are too few licences: no process may keep one between points. Says whether some did, so that their points
    /// have to be computed again, because their last audits will not come.
    pub(crate) fn share_licences(&mut self) -> bool {
        if self.wish != Isolation::Audited || matches!(self.sharing, Sharing::Refused(_)) {
            return false;
        }
        self.sharing = Sharing::Refused(Reason::ScarceLicences);
        self.reused
    }

    /// The points on which sharing is to be proven.
    pub(crate) fn proof(&mut self) -> Vec<Proof> {
        if self.is_dear() {
            self.proof.truncate(1);
        }
        self.proof.clone()
    }

    /// Notes what a trial found: how instances are used again where points came out the same, or why they are not; nothing
    /// where it was interrupted.
    pub(crate) fn tried(&mut self, outcome: Option<Result<Reuse, Reason>>) {
        if self.sharing == Sharing::OnTrial {
            self.sharing = match outcome {
                None => Sharing::Untried,
                Some(Ok(reuse)) => Sharing::Earned(reuse),
                Some(Err(reason)) => Sharing::Refused(reason),
            };
            if outcome.is_some() {
                self.proof = Vec::new();
            }
        }
    }

    /// Chooses the points that are computed twice in any case. Later sets of points of the same run keep the first choice.
    pub(crate) fn repeat(&mut self, repeats: &Repeats) {
        self.repeats.get_or_insert_with(|| repeats.clone());
    }

    /// Whether points are computed twice now and then: not where the user wants none, nor once it is known that they
    /// differ.
    pub(crate) fn audits(&self) -> bool {
        let wanted = matches!(self.wish, Isolation::Fresh | Isolation::Audited);
        wanted && self.repeats.is_some() && !self.differing
    }

    /// Whether a point is computed twice whatever share of the time that takes: one of those that were chosen, or one of
    /// the first that came right behind an odd one. There must be time for it.
    pub(crate) fn chooses(&self, index: u64, behind_odd: bool) -> bool {
        let chosen = self.repeats.as_ref().is_some_and(|repeats| repeats.has(index));
        let wanted = chosen || behind_odd && self.audits.behind_odd < ENOUGH;
        wanted && !self.is_dear() && self.spent.in_any_case + self.time_of_audit() <= LITTLE
    }

    /// The place of a point in the order in which points are audited.
    pub(crate) fn rank(&self, index: u64) -> u64 {
        self.repeats.as_ref().map_or(0, |repeats| repeats.rank(index))
    }

    /// Notes the time that points took, s.
    pub(crate) fn spend(&mut self, separation: Separation, took: f64) {
        let kind = kind(separation);
        self.spent.kinds[kind].here += took;
        for spending in [&mut self.spent, &mut self.untold] {
            spending.kinds[kind].computed += took;
        }
    }

    /// Whether a point that ran alone is audited, as far as the share of the time goes.
    pub(crate) fn audits_alone(&self) -> bool {
        self.spent.kinds[1].allowance() >= self.time_of_audit()
    }

    /// How many of the points that a used process has just computed are audited beside the chosen ones.
    pub(crate) fn audits_of_used(&self, last: bool) -> u32 {
        self.spent.kinds[0].audits(self.time_of_audit(), last)
    }

    /// Notes how long an audit took, s; `in_any_case`: whatever share of the time that is.
    pub(crate) fn note_audit(&mut self, took: f64, separation: Separation, in_any_case: bool, behind_odd: bool) {
        for spending in [&mut self.spent, &mut self.untold] {
            let spent = &mut spending.kinds[kind(separation)];
            spent.audited += took;
            spent.audits += 1.0;
            spending.in_any_case += if in_any_case { took } else { 0.0 };
        }
        self.audits.times.note(took);
        self.audits.behind_odd += usize::from(behind_odd);
    }

    /// Notes what came of an audit of a point, which another one before it in its process may have spoilt or not.
    pub(crate) fn audited(&mut self, index: u64, agreed: bool, shared: bool) {
        self.audits.note(index, agreed, shared);
    }

    /// Points of this separation are not to be had any more. Those that there are do not count.
    pub(crate) fn refute(&mut self, separation: Separation) {
        self.sharing = Sharing::Refused(Reason::OtherResults);
        if separation == Separation::Forked {
            self.alone = Some(self.strictest());
        }
    }

    /// New processes differ among themselves.
    pub(crate) fn give_up_reproducing(&mut self) {
        self.differing = true;
        self.alone = Some(self.strictest());
        self.sharing = Sharing::Refused(Reason::NotReproducible);
    }

    fn time_of_audit(&self) -> f64 {
        self.audits.times.median().unwrap_or(SHORT)
    }

    /// Whether so many points leave a process that no other may use that sharing saves nothing.
    fn is_odd(&self) -> bool {
        self.latest.iter().flatten().count() > MANY.min(self.latest.len() / 2)
    }

    /// Whether a process each costs next to nothing.
    fn is_long(&self) -> bool {
        self.simulating.median().is_some_and(|part| part > LONG)
    }

    /// How the points were computed.
    pub(crate) fn conduct(&self) -> Conduct {
        Conduct {
            isolation: match (self.wish, self.sharing) {
                (Isolation::Audited, Sharing::Earned(_)) if self.reused => Isolation::Audited,
                (Isolation::Reuse, Sharing::Earned(_)) => Isolation::Reuse,
                (Isolation::InProcess, _) => Isolation::InProcess,
                _ => Isolation::Fresh,
            },
            isolation_reason: self.reason(),
            audits: self.audits.points.len() as u64,
            audits_of_shared: self.audits.shared,
            audit_mismatches: self.audits.mismatches,
            reproducible: match self.wish {
                _ if self.differing => Some(false),
                Isolation::Reuse | Isolation::InProcess => None,
                _ if self.audits.points.is_empty() => None,
                _ => Some(true),
            },
            ..Conduct::default()
        }
    }

    /// What others should know; audits are told once.
    pub(crate) fn found(&mut self) -> Found {
        let audits = std::mem::take(&mut self.audits.latest);
        Found {
            alone: self.alone,
            sharing: match self.sharing {
                Sharing::OnTrial => Sharing::Untried,
                known => known,
            },
            differing: self.differing,
            reused: self.reused,
            start: self.start,
            reason: self.reason(),
            audits,
            spent: std::mem::take(&mut self.untold),
            spent_by_all: Spending::default(),
            changed: None,
            led: false,
        }
    }

    /// What a worker elsewhere should know before it computes points: no audits, nor why points run alone.
    pub(crate) fn known(&mut self) -> Found {
        Found { reason: None, audits: Vec::new(), spent_by_all: self.spent, ..self.found() }
    }

    /// Lets the policy take over what others found that it concerns: that of points which share the FMU's folder, or that of
    /// points with a folder each. What was found in a shared folder, and is told late, says nothing of the others.
    pub(crate) fn adopt_in([shared, apart]: [&Mutex<Self>; 2], found: &Found) {
        let policy = if found.changed.is_some() { apart } else { shared };
        locked(policy).adopt(found);
    }

    /// Takes over what others found: of two findings the stricter one.
    fn adopt(&mut self, found: &Found) {
        for &(index, agreed, shared) in &found.audits {
            self.audits.note(index, agreed, shared);
        }
        self.spent.join(&found.spent, |one, other| one + other);
        self.spent.join(&found.spent_by_all, f64::max);
        self.led = found.led;
        self.reused |= found.reused;
        self.reason_there = found.reason;
        self.start = match (self.start, found.start) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
        if found.differing && !self.differing {
            self.give_up_reproducing();
        }
        self.alone = match (self.alone, found.alone) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        };
        match (self.sharing, found.sharing) {
            (Sharing::Refused(_), _) | (_, Sharing::Untried | Sharing::OnTrial) => {}
            (Sharing::Earned(_), Sharing::Earned(_)) => {}
            (_, known) => self.sharing = known,
        }
    }

    /// The points that are computed twice in any case.
    pub(crate) fn repeats(&self) -> Option<&Repeats> {
        self.repeats.as_ref()
    }

    /// Why points run alone, where they do.
    fn reason(&self) -> Option<Reason> {
        match self.sharing {
            _ if self.wish == Isolation::InProcess => None,
            _ if self.apart => Some(Reason::ChangedFolder),
            Sharing::Refused(reason) => Some(reason),
            _ if self.wish == Isolation::Reuse => None,
            _ if self.reason_there.is_some() => self.reason_there,
            _ if self.is_odd() => self.latest.iter().flatten().next_back().copied(),
            Sharing::Earned(_) => None,
            _ if self.is_long() => Some(Reason::LongPoints),
            _ => Some(Reason::FewPoints),
        }
    }
}

/// The place of a separation's time: shared processes, or points that ran alone.
fn kind(separation: Separation) -> usize {
    usize::from(separation != Separation::Used)
}

#[cfg(test)]
mod tests;
