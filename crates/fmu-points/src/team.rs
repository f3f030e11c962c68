//! The connections to workers on other machines, as the supervisor sees them.
//!
//! What is lost on the way to a worker says nothing about the FMU: its points are handed out again. Only a point that has cost
//! several workers while it was alone with them has failed.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs::File,
    io::Read,
    path::Path,
    sync::{Mutex, MutexGuard},
    thread::sleep,
    time::{Duration, Instant},
};

use fmu_import::{FmuError, Package, locked};

use crate::{
    dispatch::{Greeting, Order, Report, Terms, WorkerFault},
    failure::Failure,
    isolation::Isolation,
    launcher::{Launcher, RemoteAddress},
    link::Link,
    points::{Event, Job, PointLimits, Post, RunError},
    working_directory,
};

/// A point that has cost so many workers, with each of which it was alone, has failed.
const COSTLY: u32 = 3;
/// A host that has failed so often in a row is left out.
const TRIES: u32 = 8;
/// Where all have failed so often before a worker has started anywhere, none will.
const FIRST_TRIES: u32 = 2;
/// The longest pause between two tries.
const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// How much of a shipped FMU goes into a message: a worker must have all of it before it takes the supervisor for silent.
const PART: u64 = 1 << 18;

/// All workers on other machines, and what they know together.
#[derive(Debug)]
pub struct Team {
    launcher: Launcher,
    greeting: Greeting,
    terms: Terms,
    pub lanes: Vec<Mutex<Lane>>,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// How many workers there are now, and how many may come still.
    connected: usize,
    possible: usize,
    /// Whether there ever was one.
    ever: bool,
    /// How many of those that may come had failed so often before that as to be given up if all had.
    hopeless: usize,
    /// How many workers points have cost.
    costs: BTreeMap<u64, u32>,
    /// Hosts of which the user was told, and what.
    told: BTreeSet<(String, &'static str)>,
    /// How many points each host has answered.
    answered: BTreeMap<String, u64>,
    /// The hosts of points that were answered, by their index, until somebody asks.
    hosts: BTreeMap<u64, String>,
    /// The first file that the FMU changed in its folder.
    changed: Option<String>,
}

/// The place of one worker, which is started there again when it is lost.
#[derive(Debug)]
pub struct Lane {
    place: RemoteAddress,
    pub link: Option<Link>,
    /// The host as the user knows it.
    pub host: String,
    /// The series of points that the worker knows.
    pub series: Option<u64>,
    /// How often it failed in a row, and when it may be tried again.
    failures: u32,
    next: Instant,
    /// Whether it is left out.
    pub out: bool,
}

/// How an order ended.
pub enum OrderEnd {
    /// All is done; how long the worker took for it, s.
    Done(f64),
    Stopped,
    Lost(WorkerFault),
}

impl Team {
    /// Workers for an FMU; none is started yet.
    pub fn new(
        package: &Package,
        launcher: Launcher,
        limits: PointLimits,
        isolation: Isolation,
    ) -> Result<Self, FmuError> {
        let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        let places = launcher.places();
        let terms = Terms {
            ticket: 0,
            patience: launcher.patience,
            fmu: absolute(package.path()),
            digest: package.digest()?,
            ship: launcher.ship,
            folder: std::env::current_dir().unwrap_or_default(),
            here: working_directory::named_by(package.description()),
            time: limits.time,
            memory: launcher.memory,
            slots: None,
            company: places.len() > 1,
            isolation,
        };
        let state = State { possible: places.len(), ..State::default() };
        let lanes = places.into_iter().map(|place| {
            Mutex::new(Lane {
                host: place.label(),
                place,
                link: None,
                series: None,
                failures: 0,
                next: Instant::now(),
                out: false,
            })
        });
        Ok(Self { lanes: lanes.collect(), launcher, greeting: Greeting::own(), terms, state: Mutex::new(state) })
    }

    /// How many points each host has answered.
    pub fn answered(&self) -> BTreeMap<String, u64> {
        self.state().answered.clone()
    }

    /// The first change that the FMU has made in the folder that points shared, on whichever machine.
    pub fn changed(&self) -> Option<String> {
        self.state().changed.clone()
    }

    /// Takes it for known that the FMU changes this file.
    pub fn know(&self, changed: &str) {
        self.state().changed.get_or_insert_with(|| changed.to_owned());
    }

    fn state(&self) -> MutexGuard<'_, State> {
        locked(&self.state)
    }

    pub fn lane(&self, number: usize) -> MutexGuard<'_, Lane> {
        locked(&self.lanes[number])
    }

    /// The host that answered a point last; it is asked for once.
    pub fn take_host(&self, index: u64) -> Option<String> {
        self.state().hosts.remove(&index)
    }

    /// Starts the worker of a lane, where there is none; whether there is one now.
    pub fn connect(&self, lane: &mut Lane, stopped: &dyn Fn() -> bool) -> Result<bool, RunError> {
        const LOOK: Duration = Duration::from_millis(50);
        while lane.link.is_none() {
            if lane.out || stopped() {
                return Ok(false);
            }
            let pause = lane.next.saturating_duration_since(Instant::now());
            if !pause.is_zero() {
                sleep(pause.min(LOOK));
                continue;
            }
            match self.start(lane, stopped) {
                Ok(Some(link)) => {
                    lane.link = Some(link);
                    lane.series = None;
                    let mut state = self.state();
                    state.connected += 1;
                    state.ever = true;
                }
                Ok(None) => return Ok(false),
                Err(fault) => self.fail(lane, &fault)?,
            }
        }
        Ok(true)
    }

    /// Starts a worker and waits until it has the FMU; none where nobody waits for it any more.
    fn start(&self, lane: &mut Lane, stopped: &dyn Fn() -> bool) -> Result<Option<Link>, WorkerFault> {
        let begun = Instant::now();
        let mut link = Link::start(&lane.place, &self.launcher).map_err(WorkerFault::lasting)?;
        let greeting = loop {
            if let Some(greeting) = link.greeting().map_err(WorkerFault::passing)? {
                break greeting;
            }
            if stopped() {
                return Ok(None);
            }
            // A scheduler may start it once there is room; that is waited for as long as others work.
            if begun.elapsed() > self.launcher.patience {
                let seconds = self.launcher.patience.as_secs_f64();
                let how = format!("no worker started within {seconds} s{}", link.last_words());
                let State { connected, ever, .. } = *self.state();
                if connected == 0 {
                    let lasting = !ever;
                    return Err(WorkerFault { how, lasting });
                }
                self.tell(&lane.host, "late", &format!("{how}; it is waited for"));
            }
        };
        if lane.place.name.is_none() {
            lane.host.clone_from(&greeting.host);
        }
        self.compare(&greeting).map_err(WorkerFault::lasting)?;
        let terms = Terms {
            ticket: rand::random::<u64>() | 1,
            slots: lane.place.name.is_some().then_some(lane.place.slots),
            ..self.terms.clone()
        };
        link.open(serde_json::to_vec(&terms).expect("terms are plain data"), terms.ticket);
        let mut shipped = None;
        loop {
            match link.wait(stopped)? {
                Some(Report::Ready) => return Ok(Some(link)),
                Some(Report::Wanted) => {
                    let part = self.part(&mut shipped).map_err(WorkerFault::lasting)?;
                    link.order(&Order::Bytes(part));
                }
                Some(Report::Unable(fault)) => return Err(fault),
                Some(_) => return Err(WorkerFault::passing("it answers what was not asked")),
                None => return Ok(None),
            }
        }
    }

    /// In what a worker's program differs from this one.
    fn compare(&self, there: &Greeting) -> Result<(), String> {
        let here = &self.greeting;
        let program = self.launcher.program.display();
        if there.version != here.version {
            return Err(format!("{program} is version {} there and {} here", there.version, here.version));
        }
        if there.program == here.program {
            Ok(())
        } else {
            Err(format!(
                "{program} is another build of version {} there (SHA-256 {:.12}...) than here ({:.12}...)",
                here.version, there.program, here.program
            ))
        }
    }

    /// The next part of the FMU, from its beginning where none is under way; an empty one at its end.
    fn part(&self, shipped: &mut Option<File>) -> Result<Vec<u8>, String> {
        let path = &self.terms.fmu;
        let told = |error| format!("{}: {error}", path.display());
        let file = match shipped.take() {
            Some(file) => file,
            None => File::open(path).map_err(told)?,
        };
        let mut part = Vec::new();
        (&file).take(PART).read_to_end(&mut part).map_err(told)?;
        *shipped = (!part.is_empty()).then_some(file);
        Ok(part)
    }

    /// Notes that a worker was lost or did not start.
    pub fn fail(&self, lane: &mut Lane, fault: &WorkerFault) -> Result<(), RunError> {
        self.leave(lane);
        lane.failures += 1;
        let how = format!("{}: {}", lane.host, fault.how);
        let mut state = self.state();
        state.hopeless += usize::from(!state.ever && lane.failures == FIRST_TRIES);
        let started = state.ever || state.hopeless < state.possible;
        if lane.failures < TRIES && !fault.lasting && started {
            let pause = Duration::from_secs(1) * 2_u32.pow(lane.failures - 1);
            lane.next = Instant::now() + pause.min(LONGEST_PAUSE);
            drop(state);
            if lane.failures == FIRST_TRIES {
                let text = format!("{}; it is tried again", fault.how);
                self.tell(&lane.host, "tried again", &text);
            }
            return Ok(());
        }
        if !started {
            return Err(RunError::Start(how));
        }
        lane.out = true;
        state.possible -= 1;
        let counted = usize::from(lane.failures >= FIRST_TRIES);
        state.hopeless = state.hopeless.saturating_sub(counted);
        match (state.possible, state.ever) {
            (0, true) => return Err(RunError::NoWorker(how)),
            (0, false) => return Err(RunError::Start(how)),
            _ => {}
        }
        drop(state);
        let text = format!("{}; the run goes on without it", fault.how);
        self.tell(&lane.host, "left out", &text);
        Ok(())
    }

    /// Ends the worker of a lane.
    pub fn leave(&self, lane: &mut Lane) {
        if lane.link.take().is_some() {
            self.state().connected -= 1;
        }
    }

    /// Tells the user something of a host, once of each kind.
    fn tell(&self, host: &str, kind: &'static str, text: &str) {
        let first = self.state().told.insert((host.to_owned(), kind));
        if first {
            crate::tell::line!("note: {host}: {text}");
        }
    }

    /// Lets a worker follow an order for these points. What is left of them is given back.
    pub fn order(
        &self,
        lane: &mut Lane,
        order: &Order,
        jobs: &[Job],
        results: usize,
        post: &mut Post,
    ) -> (OrderEnd, BTreeMap<u64, Job>) {
        let mut open: BTreeMap<u64, Job> = jobs.iter().map(|job| (job.index, job.clone())).collect();
        let Some(link) = &mut lane.link else { return (OrderEnd::Stopped, open) };
        link.order(order);
        let end = loop {
            let news = match link.wait(post.stopped) {
                Ok(Some(Report::News(news))) => news,
                Ok(Some(Report::Done(changed, took))) => {
                    changed.iter().for_each(|changed| self.know(changed));
                    break match open.len() {
                        0 => OrderEnd::Done(took),
                        left => {
                            OrderEnd::Lost(WorkerFault::lasting(format!("it left {left} points without an answer")))
                        }
                    };
                }
                Ok(Some(Report::Unable(fault))) | Err(fault) => break OrderEnd::Lost(fault),
                Ok(Some(_)) => break OrderEnd::Lost(WorkerFault::passing("it answers what was not asked")),
                Ok(None) => break OrderEnd::Stopped,
            };
            let mut wrong = None;
            for news in news {
                let event = match news.event(results) {
                    Ok(event) => event,
                    Err(how) => {
                        wrong = Some(how);
                        break;
                    }
                };
                if let Event::Answer(index, _) = &event {
                    // Each point is answered once, whatever a worker says.
                    if open.remove(index).is_none() {
                        continue;
                    }
                    self.state().hosts.insert(*index, lane.host.clone());
                }
                post.send(event);
            }
            if let Some(how) = wrong {
                break OrderEnd::Lost(WorkerFault::lasting(how));
            }
        };
        let answered = jobs.len() - open.len();
        *self.state().answered.entry(lane.host.clone()).or_default() += answered as u64;
        if answered > 0 {
            lane.failures = 0;
        }
        (end, open)
    }

    /// Points of a worker that was lost: they are handed out again, unless one alone has cost too many workers.
    pub fn reclaim(&self, open: BTreeMap<u64, Job>, alone: bool, how: &str, post: &mut Post) -> Vec<Job> {
        if let (true, Some(&index)) = (alone, open.keys().next()) {
            let mut state = self.state();
            let cost = state.costs.entry(index).or_default();
            *cost += 1;
            let cost = *cost;
            drop(state);
            if cost >= COSTLY {
                let answer =
                    Err(Failure::Crashed(format!("{cost} workers were lost at this point; the last one: {how}")));
                post.send(Event::Answer(index, answer));
                return Vec::new();
            }
        }
        open.into_values().collect()
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        // All of them learn it before one of them is waited for.
        self.lanes
            .iter_mut()
            .filter_map(|lane| lane.get_mut().ok())
            .filter_map(|lane| lane.link.as_mut())
            .for_each(Link::part);
    }
}
