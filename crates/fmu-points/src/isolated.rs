//! A worker that runs points in processes, as strictly separated as the FMU needs it.

mod comparisons;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use crate::conduct::{Reason, Separation};
use crate::failure::Failure;
use crate::ground::Ground;
use crate::locked::locked;
use crate::points::{Event, Job, Limits, Post, RunError, Worker};
use crate::policy::{Plan, Policy, Wait};
use crate::process::{Gone, Process};
use crate::runner::Reuse;
use crate::task::Case;
use crate::wire::{Order, Origin, Outcome, Reply, Setup, Trouble};

/// The bytes with which unwritten memory is filled for comparison.
const FILLS: [u8; 2] = [0x55, 0xaa];

/// What fills unwritten memory: nothing for points that count, and two patterns for comparison.
const MEMORIES: [Option<u8>; 3] = [None, Some(FILLS[0]), Some(FILLS[1])];

/// So many points, each in a child that loads the FMU itself, have one worker.
const POINTS_OF_A_WORKER: u32 = 20;

/// A worker with processes of its own.
#[derive(Debug)]
pub(crate) struct Isolated {
    policy: Arc<Mutex<Policy>>,
    /// For points with a folder of their own.
    apart: Arc<Mutex<Policy>>,
    ground: Arc<Ground>,
    /// The worker of points that are run alone, in forks.
    forking: Process,
    /// The worker of the process that runs many points.
    using: Process,
    /// The workers of points whose processes load the FMU themselves, one for each of [`MEMORIES`], and how many points each
    /// has had.
    loading: [(Process, u32); 3],
    /// Whether the last point that ran in a used process was odd.
    behind_odd: bool,
}

/// A point with results.
#[derive(Debug)]
struct Done<'a> {
    job: &'a Job,
    values: Vec<f64>,
    separation: Separation,
    /// Whether the point before it, in another process, was odd.
    behind_odd: bool,
}

impl Isolated {
    pub(crate) fn new(
        [policy, apart]: [Arc<Mutex<Policy>>; 2],
        ground: Arc<Ground>,
        home: Option<&Path>,
        cases: &[Case],
        limits: Limits,
    ) -> Self {
        let worker = |lasting| {
            let mut worker = Process::new(&ground.shared, &ground.name, cases, limits);
            worker.ground = Some(Arc::clone(&ground));
            worker.home = home.map(Path::to_owned);
            worker.lasting = lasting;
            worker
        };
        let loading = MEMORIES.map(|fill| {
            let mut worker = worker(false);
            worker.setup.fill = fill;
            (worker, 0)
        });
        let known = ground.changed().is_some();
        Self {
            forking: worker(true),
            using: worker(true),
            loading,
            policy: if known { Arc::clone(&apart) } else { policy },
            apart,
            ground,
            behind_odd: false,
        }
    }

    fn policy(&self) -> MutexGuard<'_, Policy> {
        locked(&self.policy)
    }

    /// The most independent processes.
    fn strictest(&self) -> Separation {
        self.policy().strictest()
    }

    /// One try of a point alone.
    fn once(&mut self, job: &Job, separation: Separation, fill: Option<u8>, post: &Post<'_>) -> Result<Reply, Gone> {
        let mut reply = None;
        let (stopped, mut take) = (post.stopped, |came| reply = Some(came));
        let jobs = std::slice::from_ref(job);
        let ran = match separation {
            Separation::Forked => self.forking.run(Order::Forked, jobs, stopped, &mut take),
            Separation::Apart => {
                let folder = self.ground.folder();
                let folder = folder.map_err(|error| Gone::Start(error.to_string()))?;
                let mut worker = self.new_worker(folder.path(), fill);
                worker.run(Order::New, jobs, stopped, &mut take)
            }
            Separation::New | Separation::Used => {
                let (worker, count) = self.loading(fill);
                // Where things lie in memory is drawn anew with each worker.
                if *count % POINTS_OF_A_WORKER == 0 {
                    worker.end();
                }
                *count += 1;
                worker.run(Order::New, jobs, stopped, &mut take)
            }
        };
        let failure = match (ran, reply) {
            (_, Some(reply)) => {
                match &reply.answer {
                    Ok(_) => self.policy().instantiated(f64::from(reply.start)),
                    Err(trouble) if trouble.from == Origin::Loading => {}
                    Err(_) => self.policy().loaded = true,
                }
                if reply.odd.is_some() || reply.answer.is_err() {
                    self.leave(separation, fill);
                }
                return Ok(reply);
            }
            (Ok(()), None) => Failure::Crashed("no answer came".to_owned()),
            (Err(Gone::Lost(failure)), None) => failure,
            (Err(gone), None) => return Err(gone),
        };
        self.leave(separation, fill);
        Ok(Reply { odd: Some(Reason::Complaints), ..Reply::new(job.index, Err(Trouble::lost(failure))) })
    }

    /// The worker of processes that load the FMU themselves, and how many it has had.
    fn loading(&mut self, fill: Option<u8>) -> &mut (Process, u32) {
        let place = MEMORIES.iter().position(|memory| *memory == fill);
        &mut self.loading[place.expect("memory is filled in these ways only")]
    }

    /// Behind an odd point its worker is left: the FMU is loaded anew, as what it makes when it is loaded, such as a folder, all
    /// forks share; and what it may have done to the process that has started its own is gone.
    fn leave(&mut self, separation: Separation, fill: Option<u8>) {
        match separation {
            Separation::Forked => self.forking.end(),
            Separation::New | Separation::Used => self.loading(fill).0.end(),
            Separation::Apart => {}
        }
    }

    /// A worker for one point.
    fn new_worker(&self, fmu: &Path, fill: Option<u8>) -> Process {
        let Setup { cases, limits, .. } = &self.using.setup;
        let mut worker = Process::new(fmu, &self.ground.name, cases, *limits);
        worker.home.clone_from(&self.using.home);
        worker.setup.fill = fill;
        worker
    }

    /// The same, but a licence is waited for.
    fn licensed(
        &mut self,
        job: &Job,
        separation: Separation,
        fill: Option<u8>,
        post: &mut Post<'_>,
    ) -> Result<Reply, Gone> {
        const LONGEST: Duration = Duration::from_secs(5);
        let (since, mut pause) = (Instant::now(), Duration::from_millis(20));
        loop {
            let reply = self.once(job, separation, fill, post)?;
            let Err(trouble) = &reply.answer else {
                return Ok(reply);
            };
            let Origin::Refusal { licence } = trouble.from else {
                return Ok(reply);
            };
            let failure = &trouble.failure;
            let wait = self.policy().wait(licence, since, self.using.setup.limits.time);
            match wait {
                Wait::No => return Ok(reply),
                Wait::Again => {}
                Wait::Told(longest) => crate::tell::line!(
                    "note: the FMU gives no instance for want of a licence: waiting for one, up to {longest:.0?} ({failure})"
                ),
                Wait::GivenUp(longest) => {
                    crate::tell::line!(
                        "note: no licence came within {longest:.0?}: points without one fail at once from now on"
                    );
                    return Ok(reply);
                }
            }
            // A process that waits for further points keeps its licence, perhaps the only one.
            self.using.end();
            if self.policy().share_licences() {
                post.send(Event::Void(Separation::Used));
            }
            pause_for(pause, post)?;
            pause = LONGEST.min(pause * 3 / 2);
        }
    }

    /// Why the FMU cannot be loaded, where it never was.
    fn unloadable(&self, outcome: &Outcome) -> Option<String> {
        let trouble = outcome.as_ref().err()?;
        let never = trouble.from == Origin::Loading && !self.policy().loaded;
        never.then(|| trouble.failure.to_string())
    }

    /// A point in a process as independent as can be.
    fn anew(&mut self, job: &Job, fill: Option<u8>, post: &mut Post<'_>) -> Result<Reply, Gone> {
        self.licensed(job, self.strictest(), fill, post)
    }

    /// A point alone; one that fails is tried once more, in a new process.
    fn alone(&mut self, job: &Job, separation: Separation, post: &mut Post<'_>) -> Result<(Outcome, Separation), Gone> {
        let begun = Instant::now();
        let ready = separation != Separation::Forked || self.forking.is_running();
        let first = self.licensed(job, separation, None, post)?;
        if first.answer.is_ok() {
            let took = ready.then(|| begun.elapsed().as_secs_f64());
            self.policy().note(job, &first, separation, took);
            return Ok((first.answer, separation));
        }
        let second = self.anew(job, None, post)?.answer;
        if second.is_ok() && speaks_of_the_fmu(&first.answer) {
            if self.policy().company {
                post.send(Event::Fickle(job.index));
            } else {
                self.explain(job, separation, &second, post)?;
            }
        }
        if let Some(reason) = self.unloadable(&second) {
            // No point is to blame, whichever worker finds it first.
            return Err(Gone::Start(reason));
        }
        Ok((second, self.strictest()))
    }

    /// A point alone, with its answer.
    fn answer_alone(&mut self, job: &Job, separation: Separation, post: &mut Post<'_>) -> Result<(), Gone> {
        let begun = Instant::now();
        let (outcome, separation) = self.alone(job, separation, post)?;
        let values = outcome.as_ref().ok().map(|outcome| outcome.values.clone());
        if values.is_none() {
            self.policy().note_odd(Some(Reason::Complaints));
        }
        tell(post, job.index, outcome, separation);
        let mut policy = self.policy();
        policy.spend(separation, begun.elapsed().as_secs_f64());
        let in_any_case = policy.chooses(job.index, false);
        let wanted = policy.audits() && (in_any_case || policy.audits_alone());
        drop(policy);
        if let Some(values) = values.filter(|_| wanted) {
            let point = Done { job, values, separation, behind_odd: false };
            self.audit(&point, in_any_case, post)?;
        }
        Ok(())
    }

    /// A point failed in a process of this separation, but not in a new one: either that matters, or new ones differ.
    fn explain(&mut self, job: &Job, separation: Separation, new: &Outcome, post: &mut Post<'_>) -> Result<(), Gone> {
        if separation != self.strictest() && is_same(new, &self.anew(job, None, post)?.answer) {
            self.refute(separation, post);
        } else {
            self.give_up_reproducing(post);
        }
        Ok(())
    }

    /// Whether one try gave results and the other none, which may be the fault of what ran meanwhile.
    fn is_crowd(&self, one: &Outcome, other: &Outcome) -> bool {
        self.policy().company && one.is_ok() != other.is_ok()
    }

    fn refute(&mut self, separation: Separation, post: &mut Post<'_>) {
        self.policy().refute(separation);
        post.send(Event::Void(separation));
    }

    fn give_up_reproducing(&mut self, post: &mut Post<'_>) {
        self.policy().give_up_reproducing();
        // Forks share what new processes would draw anew.
        post.send(Event::Void(Separation::Forked));
    }

    /// The FMU has changed the folder that points share: nothing that was computed there counts.
    fn leave_the_shared_folder(&mut self, post: &mut Post<'_>) {
        self.policy = Arc::clone(&self.apart);
        self.forking.end();
        self.using.end();
        self.loading.iter_mut().for_each(|(worker, _)| worker.end());
        post.send(Event::Void(Separation::New));
    }

    /// Runs points in one process; each that fails there is run alone. Some are audited.
    fn used(&mut self, jobs: &[Job], reuse: Reuse, post: &mut Post<'_>) -> Result<(), Gone> {
        let begun = Instant::now();
        self.policy().reused = true;
        let mut open: BTreeMap<u64, &Job> = jobs.iter().map(|job| (job.index, job)).collect();
        let mut failed = Vec::new();
        let mut done = Vec::new();
        let way = |jobs| Order::Used(reuse, jobs);
        let stopped = post.stopped;
        let (policy, mut behind_odd) = (Arc::clone(&self.policy), self.behind_odd);
        let ran = self.using.run(way, jobs, stopped, &mut |reply| {
            let Some(job) = open.remove(&reply.index) else {
                return;
            };
            let odd = match reply.answer {
                Ok(outcome) => {
                    done.push(Done { job, values: outcome.values.clone(), separation: Separation::Used, behind_odd });
                    tell(post, job.index, Ok(outcome), Separation::Used);
                    reply.odd
                }
                Err(trouble) => {
                    failed.push((job, Err(trouble)));
                    reply.odd.or(Some(Reason::Complaints))
                }
            };
            locked(&policy).note_odd(odd);
            behind_odd = odd.is_some();
        });
        self.behind_odd = behind_odd;
        match ran {
            Ok(()) => {}
            Err(Gone::Lost(failure)) => {
                // The worker was lost: which point it was is not known, so none of them is to blame yet.
                let lost = |job| (job, Err(Trouble::lost(failure.clone())));
                failed.extend(open.into_values().map(lost));
            }
            Err(gone) => return Err(gone),
        }
        let took = begun.elapsed().as_secs_f64();
        self.policy().spend(Separation::Used, took);
        for (job, used) in failed {
            self.again(job, &used, post)?;
        }
        self.audit_some(&done, post)
    }

    /// A point that failed in a used process, alone.
    fn again(&mut self, job: &Job, used: &Outcome, post: &mut Post<'_>) -> Result<(), Gone> {
        let separation = self.policy().alone();
        let late = |trouble: &Trouble| trouble.failure == Failure::Timeout;
        let (outcome, separation) = match used.as_ref().is_err_and(late) {
            // It has had its second try with this one.
            true => (self.licensed(job, separation, None, post)?.answer, separation),
            false => self.alone(job, separation, post)?,
        };
        if outcome.is_ok() && speaks_of_the_fmu(used) {
            self.policy().audited(job.index, false, true);
            self.refute(Separation::Used, post);
        }
        tell(post, job.index, outcome, separation);
        Ok(())
    }
}

impl Worker for Isolated {
    fn run(&mut self, jobs: &[Job], post: &mut Post<'_>) -> Result<(), RunError> {
        let mut jobs = jobs;
        while let Some((job, rest)) = jobs.split_first() {
            let left = post.left.map(|left| left + jobs.len());
            let plan = self.policy().plan(left);
            let done = match plan {
                Plan::Probe => self.probe(job, post),
                Plan::Alone(separation) => self.answer_alone(job, separation, post),
                Plan::Audit => self.run_as_audit(job, post),
                Plan::Trial => {
                    let tried = self.trial(post);
                    self.policy().tried(tried.as_ref().ok().copied());
                    tried.map(|_| ())
                }
                Plan::Used(reuse) => self.used(jobs, reuse, post),
            };
            match done {
                Ok(()) => {}
                Err(Gone::Stopped) => return Ok(()),
                Err(Gone::Disturbed) => {
                    self.leave_the_shared_folder(post);
                    continue;
                }
                Err(gone) => return Err(gone.into()),
            }
            jobs = match plan {
                Plan::Trial => jobs,
                Plan::Used(_) => &[],
                Plan::Probe | Plan::Alone(_) | Plan::Audit => rest,
            };
            if post.is_over() {
                return Ok(());
            }
        }
        if post.left == Some(0) {
            self.rest();
        }
        Ok(())
    }

    /// A point that gives results now gives them twice, or the FMU is not reproducible.
    fn run_alone(&mut self, job: &Job, post: &mut Post<'_>) -> Result<(), RunError> {
        loop {
            let outcome = self.anew(job, None, post).and_then(|first| {
                if first.answer.is_ok() {
                    let second = self.anew(job, None, post)?;
                    let told = speaks_of_the_fmu(&second.answer);
                    if told && !is_same(&first.answer, &second.answer) {
                        self.give_up_reproducing(post);
                    }
                }
                Ok(first.answer)
            });
            match outcome {
                Ok(outcome) => tell(post, job.index, outcome, self.strictest()),
                Err(Gone::Stopped) => {}
                Err(Gone::Disturbed) => {
                    self.leave_the_shared_folder(post);
                    continue;
                }
                Err(gone) => return Err(gone.into()),
            }
            return Ok(());
        }
    }

    fn rest(&mut self) {
        // Others may need the licence that it holds.
        self.using.end();
    }
}

/// Hands over the outcome of a point, and the FMU's warnings before it failed.
fn tell(post: &mut Post<'_>, index: u64, outcome: Outcome, separation: Separation) {
    let answer = outcome.map_err(|Trouble { failure, notices, .. }| {
        if !notices.is_empty() {
            post.send(Event::Said(index, notices));
        }
        failure
    });
    post.send(Event::Answer(index, answer, separation));
}

/// Waits, unless the run is to end.
fn pause_for(pause: Duration, post: &Post<'_>) -> Result<(), Gone> {
    let until = Instant::now() + pause;
    while Instant::now() < until {
        if (post.stopped)() {
            return Err(Gone::Stopped);
        }
        std::thread::sleep(pause.min(Duration::from_millis(20)));
    }
    Ok(())
}

/// Whether an answer comes from the FMU, and not from what happened around its process: a lack of time or memory,
/// a signal from outside.
fn speaks_of_the_fmu(outcome: &Outcome) -> bool {
    let Err(trouble) = outcome else { return true };
    match (trouble.from, trouble.failure.cause()) {
        (Origin::Fmu, _) | (Origin::Process, Failure::Exited(..)) => true,
        (Origin::Process, Failure::Crashed(text)) => {
            let by_the_fmu = ["SIGSEGV", "SIGABRT", "SIGFPE", "SIGILL", "SIGBUS"];
            by_the_fmu.iter().any(|signal| text.starts_with(signal))
        }
        _ => false,
    }
}

/// Whether two processes gave the same: results to the last bit, or failures of one class, whose words may hold
/// addresses and times.
fn is_same(one: &Outcome, other: &Outcome) -> bool {
    match (one, other) {
        (Ok(one), Ok(other)) => bits(&one.values).eq(bits(&other.values)),
        (Err(one), Err(other)) => one.failure.class() == other.failure.class(),
        _ => false,
    }
}

fn bits(values: &[f64]) -> impl Iterator<Item = u64> {
    values.iter().map(|value| value.to_bits())
}
