//! A worker that runs points in processes: each alone, unless the user trusts the FMU.
//!
//! A point runs in a process that has loaded the FMU and never instantiated it. That is a fork of one that has loaded it for
//! all, where a fork does as well as a new process: this is decided once, with the first point that has results. An answer
//! counts while the unpacked FMU is as it came. Once the FMU changes its own folder, each point has a folder of its own, and
//! points that were under way run again.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};

use tempfile::TempDir;

use crate::{
    failure::Failure,
    ground::Ground,
    licences::{Licences, Wait},
    points::{Event, Job, PointLimits, Post, RunError, Worker, is_same},
    process::{Gone, Process},
    quiet::Quiet,
    room::Room,
    task::Case,
    wire::{Order, Origin, Reply, SimulationOutcome, Trouble},
};
use fmu_import::locked;

/// The byte that fills unwritten memory where a point runs again.
const FILL: u8 = 0x55;
/// So many points that run again, or whose child loads the FMU itself, have one worker: where things lie in memory is drawn
/// anew with each worker.
const POINTS_OF_A_WORKER: u32 = 20;
/// An FMU that could not be loaded is loaded again after so long.
const PAUSES: [Duration; 3] = [Duration::from_millis(50), Duration::from_millis(300), Duration::from_secs(1)];

/// What the workers of a run share.
#[derive(Debug)]
pub struct CrewState {
    pub ground: Ground,
    /// Whether the user wants points to share processes.
    pub shared: bool,
    /// Whether points run beside others.
    company: bool,
    start: Mutex<Start>,
    quiet: Quiet,
    licences: Mutex<Licences>,
    /// Whether the FMU was ever loaded.
    loaded: AtomicBool,
}

/// How the process of a point begins.
#[derive(Clone, Copy, Debug)]
enum Start {
    /// Nobody knows yet, nor finds out.
    Open,
    /// Somebody finds out.
    OnTrial,
    /// As a fork of a process that has loaded the FMU.
    Forked,
    /// It loads the FMU itself.
    New,
}

impl CrewState {
    pub fn new(ground: Ground, shared: bool, tool: bool, company: bool) -> Self {
        Self {
            ground,
            shared,
            company,
            start: Mutex::new(Start::Open),
            quiet: Quiet::default(),
            licences: Mutex::new(Licences::new(tool)),
            loaded: AtomicBool::new(false),
        }
    }
}

/// A worker with processes of its own.
#[derive(Debug)]
pub struct Isolated {
    common: Arc<CrewState>,
    /// Where points find nothing but themselves; none until the first one comes.
    room: Option<Arc<Room>>,
    /// Whether points keep the user's working directory.
    here: bool,
    /// Whether its points are compared with what others made of them.
    again: bool,
    /// The worker that has loaded the FMU and forks.
    forking: Process,
    /// The worker of the process that runs many points.
    using: Process,
    /// The worker of points whose processes load the FMU themselves, and how many points it has had.
    loading: Process,
    count: u32,
    /// Another unpacked FMU, for points that run again.
    copy: Option<TempDir>,
}

impl Isolated {
    /// A worker; with `again`, its points run in new processes whose unwritten memory holds other bytes, from another
    /// copy of the unpacked FMU.
    pub fn new(common: &Arc<CrewState>, here: bool, cases: &[Case], limits: PointLimits, again: bool) -> Self {
        let ground = &common.ground;
        let worker = |lasting| {
            let mut worker = Process::new(&ground.shared, &ground.name, cases, limits);
            worker.setup.fill = again.then_some(FILL);
            worker.lasting = lasting;
            worker
        };
        Self {
            room: None,
            here,
            again,
            forking: worker(true),
            using: worker(true),
            loading: worker(false),
            count: 0,
            copy: None,
            common: Arc::clone(common),
        }
    }

    fn limits(&self) -> PointLimits {
        self.loading.setup.limits
    }

    /// Gives all processes their folders.
    fn settle_in(&mut self) -> Result<(), Gone> {
        if self.again && self.copy.is_none() {
            self.copy = self.common.ground.copy();
            // Without room for it, the same files serve.
            for worker in [&mut self.forking, &mut self.loading] {
                self.copy.iter().for_each(|copy| copy.path().clone_into(&mut worker.setup.fmu));
            }
        }
        if self.room.is_none() {
            let room = Room::take(&self.common.ground.scratch).map_err(|error| Gone::Start(error.to_string()))?;
            let room = self.room.insert(Arc::new(room));
            for worker in [&mut self.forking, &mut self.using, &mut self.loading] {
                worker.live_in(room, self.here);
            }
        }
        Ok(())
    }

    /// How a point's process begins now. Whoever is told that it is open must find out.
    fn start(&self) -> Start {
        if self.common.ground.changed().is_some() {
            return Start::New;
        }
        let mut start = locked(&self.common.start);
        match *start {
            // Points that run again decide nothing.
            Start::Open | Start::OnTrial if self.again => Start::New,
            Start::Open => std::mem::replace(&mut *start, Start::OnTrial),
            now => now,
        }
    }

    /// Lets points run, and hands over the outcome of each; gives those back that have none, and the reason.
    fn run_by<'a>(
        &mut self,
        way: fn(Vec<Job>) -> Order,
        jobs: &'a [Job],
        post: &mut Post,
        answer: &mut dyn FnMut(&mut Post, &'a Job, Reply),
    ) -> Result<(Vec<&'a Job>, Failure), Gone> {
        self.settle_in()?;
        let common = Arc::clone(&self.common);
        let mut open: BTreeMap<u64, &Job> = jobs.iter().map(|job| (job.index, job)).collect();
        let (worker, lasting) = match way(Vec::new()) {
            Order::Forked(_) => (&mut self.forking, !self.again),
            Order::Used(_) => (&mut self.using, true),
            _ => (&mut self.loading, false),
        };
        if !lasting {
            if self.count.is_multiple_of(POINTS_OF_A_WORKER) {
                worker.end();
            }
            self.count += 1;
        }
        let folder = common.ground.changed().map(|_| common.ground.folder()).transpose();
        let folder = folder.map_err(|error| Gone::Start(error.to_string()))?;
        if let Some(folder) = &folder {
            worker.end();
            worker.setup.fmu = folder.path().to_owned();
        }
        let sound = || folder.is_some() || common.ground.changed().is_none();
        let stopped = post.stopped;
        let ran = worker.run(way, jobs, stopped, &sound, &mut |reply| {
            if let Some(job) = open.remove(&reply.index) {
                match &reply.answer {
                    Err(trouble) if matches!(trouble.from, Origin::Loading | Origin::Refusal { .. }) => {}
                    answer => {
                        common.loaded.store(true, Ordering::Relaxed);
                        if answer.is_ok() {
                            locked(&common.licences).note();
                        }
                    }
                }
                answer(post, job, reply);
            }
        });
        if folder.is_some() {
            worker.end();
        }
        let failure = match ran {
            Ok(()) => Failure::Crashed("no answer came".to_owned()),
            Err(Gone::Lost(failure)) => failure,
            Err(gone) => return Err(gone),
        };
        Ok((open.into_values().collect(), failure))
    }

    /// One try of one point.
    fn once(&mut self, way: fn(Vec<Job>) -> Order, job: &Job, post: &mut Post) -> Result<Reply, Gone> {
        let mut reply = None;
        let jobs = std::slice::from_ref(job);
        let (_, lost) = self.run_by(way, jobs, post, &mut |_, _, came| reply = Some(came))?;
        Ok(reply.unwrap_or_else(|| Reply::new(job.index, Err(Trouble::lost(lost)))))
    }

    /// The same, but what hinders the FMU from starting is waited for: a licence that others have, and whatever kept it from
    /// being loaded.
    fn patiently(&mut self, way: fn(Vec<Job>) -> Order, job: &Job, post: &mut Post) -> Result<Reply, Gone> {
        let first = self.once(way, job, post)?;
        self.insist(first, way, job, post)
    }

    fn insist(&mut self, first: Reply, way: fn(Vec<Job>) -> Order, job: &Job, post: &mut Post) -> Result<Reply, Gone> {
        const LONGEST: Duration = Duration::from_secs(5);
        let (since, mut pause) = (Instant::now(), Duration::from_millis(20));
        let mut pauses = PAUSES.iter();
        let mut reply = first;
        loop {
            let Err(trouble) = &reply.answer else {
                return Ok(reply);
            };
            match trouble.from {
                Origin::Refusal { licence } => {
                    if !self.waits(licence, since, &trouble.failure) {
                        return Ok(reply);
                    }
                    // A process that waits for further points keeps its licence, perhaps the only one.
                    self.using.end();
                    pause_for(pause, post)?;
                    pause = LONGEST.min(pause * 3 / 2);
                }
                Origin::Loading => {
                    match pauses.next().filter(|_| trouble.passing || self.common.loaded.load(Ordering::Relaxed)) {
                        Some(&pause) => pause_for(pause, post)?,
                        // No point is to blame, whichever worker finds it first.
                        None if !self.common.loaded.load(Ordering::Relaxed) => {
                            return Err(Gone::Unloadable(trouble.failure.to_string()));
                        }
                        None => {
                            let text = format!(
                                "the FMU, which could be loaded before, cannot be loaded any more: {}",
                                trouble.failure
                            );
                            return Err(Gone::Start(text));
                        }
                    }
                }
                Origin::Process | Origin::Fmu => return Ok(reply),
            }
            reply = self.once(way, job, post)?;
        }
    }

    /// Whether a licence is waited for; the user is told once.
    fn waits(&self, spoken: bool, since: Instant, failure: &Failure) -> bool {
        let wait = locked(&self.common.licences).wait(spoken, since, self.limits().time);
        match wait {
            Wait::Told(longest) => crate::tell::line!(
                "note: the FMU gives no instance for want of a licence: waiting for one, up to {longest:.0?} ({failure})"
            ),
            Wait::GivenUp(longest) => crate::tell::line!(
                "note: no licence came within {longest:.0?}: points without one fail at once from now on"
            ),
            Wait::Again | Wait::No => {}
        }
        matches!(wait, Wait::Again | Wait::Told(_))
    }

    /// Finds out with a point whether forks do as well as new processes, and reports the point.
    fn try_forks(&mut self, job: &Job, post: &mut Post) -> Result<(), Gone> {
        let common = Arc::clone(&self.common);
        let verdict = self.compare(job, post);
        let (reply, start) = match verdict {
            Ok((reply, start)) => (Ok(reply), start),
            Err(gone) => (Err(gone), Start::Open),
        };
        *locked(&common.start) = start;
        self.finish(job, reply?, post)
    }

    fn compare(&mut self, job: &Job, post: &mut Post) -> Result<(Reply, Start), Gone> {
        let beside = Arc::clone(&self.common);
        let _others = beside.quiet.beside_others();
        let new = self.patiently(Order::New, job, post)?;
        let start = match (&new.answer, new.forkable) {
            // It tells nothing of what a process must have.
            (Err(_), Some(true)) => Start::Open,
            (Ok(_), Some(true)) => {
                let forked = self.patiently(Order::Forked, job, post)?;
                if is_same(&new.answer, &forked.answer) { Start::Forked } else { Start::New }
            }
            _ => Start::New,
        };
        Ok((new, start))
    }

    /// Runs points one by one or in forks, each alone; those that fail once more.
    fn each_alone(&mut self, way: fn(Vec<Job>) -> Order, jobs: &[Job], post: &mut Post) -> Result<(), Gone> {
        let common = Arc::clone(&self.common);
        let mut failed = Vec::new();
        let floor = common.quiet.beside_others();
        let mut take = |post: &mut Post, job, reply: Reply| match reply.answer {
            Ok(simulated) => post.send(Event::Answer(reply.index, Ok(simulated))),
            Err(_) => failed.push((job, reply)),
        };
        let ran = self.run_by(way, jobs, post, &mut take);
        drop(floor);
        let (lost, failure) = ran?;
        // One of them has ended the worker, and nobody knows which: each runs in a worker that has no other point.
        let is_one = jobs.len() == 1;
        for job in lost {
            let floor = common.quiet.beside_others();
            let reply = if is_one {
                Reply::new(job.index, Err(Trouble::lost(failure.clone())))
            } else {
                self.once(way, job, post)?
            };
            drop(floor);
            take(post, job, reply);
        }
        for (job, reply) in failed {
            let reply = self.insist(reply, way, job, post)?;
            self.finish(job, reply, post)?;
        }
        Ok(())
    }

    /// Reports a point. One that failed is tried once more before, in a new process, while nothing else runs.
    fn finish(&mut self, job: &Job, mut reply: Reply, post: &mut Post) -> Result<(), Gone> {
        let common = Arc::clone(&self.common);
        if let Err(trouble) = &reply.answer
            && common.quiet.is_open(&trouble.failure)
            && !self.again
        {
            let failure = trouble.failure.clone();
            // What this worker keeps for further points may be what was missing.
            self.using.end();
            let _alone = common.company.then(|| common.quiet.alone());
            reply = self.patiently(Order::New, job, post)?;
            common.quiet.note(&failure, reply.answer.is_err());
        }
        tell(post, job.index, reply.answer);
        Ok(())
    }
}

impl Worker for Isolated {
    fn run(&mut self, jobs: &[Job], post: &mut Post) -> Result<(), RunError> {
        let mut jobs = jobs;
        while let Some((job, rest)) = jobs.split_first() {
            let one = std::slice::from_ref(job);
            let mut answered = Vec::new();
            let mut take = |event| {
                if let Event::Answer(index, _) = &event {
                    answered.push(*index);
                }
                (post.take)(event)
            };
            let mut inner = Post::new(&mut take, post.stopped);
            let way: fn(Vec<Job>) -> Order =
                if self.common.shared && !self.again { Order::Used } else { Order::Forked };
            let (many, done) = match self.start() {
                _ if self.common.shared && !self.again && self.common.ground.changed().is_none() => {
                    (jobs, self.each_alone(way, jobs, &mut inner))
                }
                Start::Forked => (jobs, self.each_alone(way, jobs, &mut inner)),
                Start::Open => (one, self.try_forks(job, &mut inner)),
                Start::OnTrial | Start::New => (one, self.each_alone(Order::New, one, &mut inner)),
            };
            let over = inner.is_over();
            match done {
                // What was under way when the folder changed runs again, each with a folder of its own.
                Err(Gone::Disturbed) => {
                    for worker in [&mut self.forking, &mut self.using, &mut self.loading] {
                        worker.end();
                    }
                    let open: Vec<Job> = jobs.iter().filter(|job| !answered.contains(&job.index)).cloned().collect();
                    return if over { Ok(()) } else { self.run(&open, post) };
                }
                Err(Gone::Stopped) => return Ok(()),
                Err(gone) => return Err(gone.into()),
                Ok(()) => {}
            }
            if over {
                return Ok(());
            }
            jobs = if many.len() > 1 { &[] } else { rest };
        }
        Ok(())
    }
}

/// Reports the outcome of a point: what the FMU said before it failed comes first.
fn tell(post: &mut Post, index: u64, outcome: SimulationOutcome) {
    let answer = outcome.map_err(|Trouble { failure, notices, .. }| {
        if !notices.is_empty() {
            post.send(Event::Said(index, notices));
        }
        failure
    });
    post.send(Event::Answer(index, answer));
}

/// Waits, unless the run is to end.
fn pause_for(pause: Duration, post: &Post) -> Result<(), Gone> {
    let until = Instant::now() + pause;
    while Instant::now() < until {
        if (post.stopped)() {
            return Err(Gone::Stopped);
        }
        std::thread::sleep(pause.min(Duration::from_millis(20)));
    }
    Ok(())
}
