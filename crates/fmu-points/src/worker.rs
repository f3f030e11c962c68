//! A worker: the process between the supervisor and those in which the FMU runs.
//!
//! It runs each point in a child, or many in one, and gives one reply a point whatever becomes of the child: a
//! crash, silence, foreign bytes. Only its own code writes to the supervisor. It ends with the supervisor, and
//! all that it has started with it.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::birth::{self, Estate};
use crate::child::{self, Work};
use crate::failure::Failure;
use crate::points::Job;
use crate::runner::Habit;
use crate::system::{self, Shared, Streams};
use crate::task::Record;
use crate::wire::{
    End, Odd, Reader, Reply, Setup, Trouble, Way, put_end, put_job, put_reply, put_trouble, speech,
};
use fmu_import::isolation::keeper::signal_name;
use fmu_import::isolation::{Bounds, Child, Keeper, Loss, Parting, frame};
use fmu_import::{FmuError, Library, Package};

/// Replies are sent after this time at the latest, when the next point is done: a message a point would cost more
/// than a short point.
const HOLD: Duration = Duration::from_millis(1);
/// How long a child may take to end its instance after it has answered, where a point may take longer than that: a
/// tool behind the FMU is closed then, files are written, a licence is given back.
const GRACE: Duration = Duration::from_secs(60);

/// The exit code of a process of this program in which an FMU runs, when it cannot tell what it has found: unlike those
/// with which an FMU may end it.
pub const UNABLE: i32 = 121;
/// Why it cannot.
pub const MUTE: &str = "the FMU closed descriptors that it did not open, or became another program";

/// Serves a supervisor over standard input and output.
///
/// # Errors
/// When the supervisor cannot be understood or reached.
pub(crate) fn serve() -> io::Result<()> {
    let (input, output, streams) = Streams::take()?;
    let mut orders = frame::Inbox::new(input, 0);
    let Some(setup) = orders.wait()? else {
        return Ok(());
    };
    let setup: Setup = serde_json::from_slice(&setup)?;
    orders.expect(setup.ticket);
    if let Some(byte) = setup.fill {
        child::fill_memory(byte);
    }
    let mut service = Service {
        keeper: streams.keeper(setup.echo, setup.ticket)?,
        output: Output {
            to: output,
            ticket: setup.ticket,
            held: Vec::new(),
            sent: Instant::now(),
        },
        package: None,
        library: None,
        used: None,
        progress: Shared::new()?,
        setup,
    };
    while let Some(order) = orders.wait()? {
        service.obey(&order)?;
        service.output.send()?;
    }
    Ok(())
}

/// What a worker works with.
struct Service {
    setup: Setup,
    keeper: Keeper,
    output: Output,
    package: Option<Package>,
    /// The FMU, once this process has loaded it. It is never instantiated here.
    library: Option<Arc<Library>>,
    /// The child that runs many points.
    used: Option<(Habit, Child)>,
    /// How many points of its present message that child has begun.
    progress: Shared,
}

impl Service {
    fn obey(&mut self, order: &[u8]) -> io::Result<()> {
        let mut reader = Reader(order);
        let damaged = || io::Error::other("an order is damaged");
        let way = reader.way().ok_or_else(damaged)?;
        if let Way::Recorded = way {
            let record: Record = serde_json::from_slice(reader.0)?;
            return self.record(&record);
        }
        let mut jobs = VecDeque::new();
        while let Some(job) = reader.job() {
            jobs.push_back(job);
        }
        if let Way::Used(habit) = way {
            return self.run_used(habit, jobs);
        }
        // A child that stays would be taken for one left behind.
        self.used = None;
        for job in &jobs {
            let reply = self.run_alone(way, job)?;
            put_reply(&reply, &mut self.output.held);
            self.output.send_in_time()?;
        }
        Ok(())
    }

    /// Runs a point in a child of its own.
    fn run_alone(&mut self, way: Way, job: &Job) -> io::Result<Reply> {
        let mut reply = Reply {
            index: job.index,
            answer: Err(Trouble::Lost(Failure::Timeout)),
            start: 0.0,
            simulated: 0.0,
            odd: None,
            forkable: None,
        };
        if let Err(reason) = self.prepare(way) {
            reply.answer = Err(Trouble::Unloadable(reason));
            return Ok(reply);
        }
        let library = self.library.clone().filter(|_| way == Way::Forked);
        clear(self.setup.place.as_deref())?;
        let mut child = match self.begin(library, &Work::Alone(job.clone())) {
            Ok(child) => child,
            Err(error) => {
                reply.answer = Err(Trouble::Lost(no_process(&error)));
                return Ok(reply);
            }
        };
        let mut loaded = way == Way::Forked;
        loop {
            let said = match child.answer(&mut self.keeper, bounds(&self.setup)) {
                Ok(said) => said,
                Err(loss) => {
                    drop(child);
                    let failure = self.failure(&loss)?;
                    reply.answer = Err(if loaded {
                        Trouble::Lost(failure)
                    } else {
                        Trouble::Unloadable(self.loading(&loss, &failure))
                    });
                    return Ok(reply);
                }
            };
            match said.split_first() {
                Some((&speech::LOADED, flag)) => {
                    loaded = true;
                    reply.forkable = flag.first().map(|&flag| flag == 1);
                }
                Some((&speech::UNLOADABLE, reason)) => {
                    let reason = String::from_utf8_lossy(reason).into_owned();
                    reply.answer = Err(Trouble::Unloadable(reason));
                    break;
                }
                Some((&speech::REPLIES, replies)) => {
                    let forkable = reply.forkable;
                    reply = match Reader(replies).reply() {
                        Some(own) => Reply { forkable, ..own },
                        None => {
                            let failure = self.failure(&Loss::Mute)?;
                            let answer = Err(Trouble::Lost(failure));
                            Reply { answer, ..reply }
                        }
                    };
                    break;
                }
                _ => break,
            }
        }
        let parting = child.part(&mut self.keeper, grace(&self.setup));
        self.note_parting(&parting, &mut reply)?;
        self.hear_of_licences(&mut reply);
        Ok(reply)
    }

    /// Notes what the FMU did when its simulation was ended.
    fn note_parting(&mut self, parting: &Parting, reply: &mut Reply) -> io::Result<()> {
        let Ok(simulated) = &mut reply.answer else {
            return Ok(());
        };
        if let Some((&speech::FAREWELL, said)) =
            parting.words.as_deref().and_then(<[u8]>::split_first)
        {
            simulated.notices = serde_json::from_slice(said).ok();
        }
        if let Some(why) = self.why_unfinished(parting)? {
            let notices = simulated.notices.get_or_insert_default();
            notices.unfinished.get_or_insert(why);
        }
        Ok(())
    }

    /// What went wrong after all had been computed, if anything did.
    fn why_unfinished(&mut self, parting: &Parting) -> io::Result<Option<String>> {
        let why = match &parting.loss {
            None => return Ok(None),
            Some(Loss::Timeout) => {
                let patience = grace(&self.setup).as_secs_f64();
                format!("not done after {patience} s")
            }
            Some(loss) => self.failure(loss)?.to_string(),
        };
        // The user looks for the functions by their names in the standard.
        let package = self.package.as_ref();
        let prefix = package.map_or("", |package| package.description().standard.prefix());
        Ok(Some(format!(
            "{why} ({prefix}Terminate or {prefix}FreeInstance)"
        )))
    }

    /// Opens the FMU; loads it into this process where children are to have it loaded already.
    fn prepare(&mut self, way: Way) -> Result<(), String> {
        // The user knows the file, not the folder into which it was unpacked.
        let named = |error: FmuError| error.at(&self.setup.name).to_string();
        if self.package.is_none() {
            self.package = Some(Package::open(&self.setup.fmu).map_err(named)?);
        }
        if let (Way::Forked, None, Some(package)) = (way, &self.library, &mut self.package) {
            let library = self.keeper.blindly(|| package.load());
            // Its initialisers may have changed what this process does about its children.
            system::adopt_orphans();
            self.library = Some(library.map_err(named)?);
        }
        Ok(())
    }

    /// A refusal may speak of a licence in what the FMU printed.
    fn hear_of_licences(&mut self, reply: &mut Reply) {
        if let Err(Trouble::Refused { licence, failure }) = &mut reply.answer {
            let text = format!("{failure}\n{}", self.keeper.text());
            *licence |= lacks_licence(&text);
        }
    }

    /// Runs points in one child. When the child is lost, the point that it was running is answered as lost, and
    /// another child runs the rest; likewise behind a point that did not end plainly.
    fn run_used(&mut self, habit: Habit, mut jobs: VecDeque<Job>) -> io::Result<()> {
        if self.used.as_ref().is_some_and(|(own, _)| *own != habit) {
            self.used = None;
        }
        let mut in_vain = false;
        while !jobs.is_empty() {
            let before = jobs.len();
            let Some(loss) = self.attempt(habit, &mut jobs)? else {
                continue;
            };
            self.used = None;
            let failure = self.failure(&loss)?;
            // Those before it have to be run again: their answers were not sent yet.
            let answered = before - jobs.len();
            let at = self.progress.get().checked_sub(1 + answered as u64);
            let at = at.and_then(|at| usize::try_from(at).ok());
            let at = at.filter(|&at| at < jobs.len());
            // A child that ends between points has not been struck by one, unless that goes on and on.
            let at = at.or((in_vain && answered == 0).then_some(0));
            in_vain = answered == 0;
            if let Some(job) = at.and_then(|at| jobs.remove(at)) {
                let trouble = Trouble::Lost(failure);
                put_trouble(job.index, [0.0; 2], &trouble, &mut self.output.held);
                in_vain = false;
            }
        }
        let swollen = |child: &Child| child.resident() > self.setup.memory / 2;
        // A leak costs a restart now and then, long before it costs a point.
        if self.used.as_ref().is_some_and(|(_, child)| swollen(child)) {
            self.used = None;
        }
        Ok(())
    }

    /// Lets the child run points until all are answered, or one was odd, or it is lost.
    fn attempt(&mut self, habit: Habit, jobs: &mut VecDeque<Job>) -> io::Result<Option<Loss>> {
        self.progress.set(0);
        let mut child = match self.used.take() {
            Some((_, child)) => child,
            None => match self.begin_used(habit)? {
                Ok(child) => child,
                Err(trouble) => {
                    for job in jobs.drain(..) {
                        put_trouble(job.index, [0.0; 2], &trouble, &mut self.output.held);
                    }
                    return Ok(None);
                }
            },
        };
        let mut message = Vec::new();
        jobs.iter()
            .for_each(|job| put_job(job.index, &job.values, &mut message));
        if child.send(&message).is_err() {
            return Ok(Some(Loss::Mute));
        }
        while !jobs.is_empty() {
            let said = match child.answer(&mut self.keeper, bounds(&self.setup)) {
                Ok(said) => said,
                Err(loss) => return Ok(Some(loss)),
            };
            let Some((&speech::REPLIES, replies)) = said.split_first() else {
                return Ok(Some(Loss::Mute));
            };
            let mut reader = Reader(replies);
            while let Some(mut reply) = reader.reply() {
                if jobs.front().is_none_or(|job| job.index != reply.index) {
                    return Ok(Some(Loss::Mute));
                }
                jobs.pop_front();
                self.hear_of_licences(&mut reply);
                put_reply(&reply, &mut self.output.held);
                if let Some(odd) = reply.odd {
                    self.setup.careful |= odd == Odd::Signals;
                    // It frees its instance, and ends.
                    child.part(&mut self.keeper, grace(&self.setup));
                    self.output.send_in_time()?;
                    return Ok(None);
                }
            }
            self.output.send_in_time()?;
        }
        self.used = Some((habit, child));
        Ok(None)
    }

    /// A child that has loaded the FMU and waits for points.
    fn begin_used(&mut self, habit: Habit) -> io::Result<Result<Child, Trouble>> {
        if let Err(reason) = self.prepare(Way::Used(habit)) {
            return Ok(Err(Trouble::Unloadable(reason)));
        }
        clear(self.setup.place.as_deref())?;
        let mut child = match self.begin(self.library.clone(), &Work::Serve(habit)) {
            Ok(child) => child,
            Err(error) => return Ok(Err(Trouble::Lost(no_process(&error)))),
        };
        let said = child.answer(&mut self.keeper, bounds(&self.setup));
        match said.as_deref().map(<[u8]>::split_first) {
            Ok(Some((&speech::LOADED, _))) => Ok(Ok(child)),
            Ok(Some((&speech::UNLOADABLE, reason))) => {
                let reason = String::from_utf8_lossy(reason).into_owned();
                Ok(Err(Trouble::Unloadable(reason)))
            }
            Ok(_) => Ok(Err(Trouble::Lost(self.failure(&Loss::Mute)?))),
            Err(loss) => {
                let loss = loss.clone();
                drop(child);
                let failure = self.failure(&loss)?;
                Ok(Err(Trouble::Unloadable(self.loading(&loss, &failure))))
            }
        }
    }

    /// A child at work; waits for room where the system has none at the moment.
    fn begin(&mut self, library: Option<Arc<Library>>, work: &Work) -> io::Result<Child> {
        const PAUSES: [u64; 5] = [1, 10, 100, 500, 1000];
        let mut estate = Estate {
            setup: &self.setup,
            package: &mut self.package,
            library,
            progress: &self.progress,
        };
        for pause in PAUSES {
            // SAFETY: where children are forks, a worker has a single thread; loading the FMU has started none, or it is
            // not loaded here.
            if let Ok(child) = unsafe { birth::child(&mut self.keeper, &mut estate, work) } {
                return Ok(child);
            }
            std::thread::sleep(Duration::from_millis(pause));
        }
        // SAFETY: a single thread, as in the loop.
        unsafe { birth::child(&mut self.keeper, &mut estate, work) }
    }

    /// Runs a point with its trajectory.
    fn record(&mut self, record: &Record) -> io::Result<()> {
        self.used = None;
        let failed = |failure| {
            let mut end = Vec::new();
            put_end(&End::Failed(failure), &mut end);
            end
        };
        if let Err(reason) = self.prepare(Way::Recorded) {
            return self.output.put(&failed(Failure::Unloadable(reason)));
        }
        clear(self.setup.place.as_deref())?;
        let mut child = match self.begin(None, &Work::Record(record.clone())) {
            Ok(child) => child,
            Err(error) => return self.output.put(&failed(no_process(&error))),
        };
        loop {
            let said = match child.answer(&mut self.keeper, bounds(&self.setup)) {
                Ok(said) => said,
                Err(loss) => {
                    drop(child);
                    let failure = self.failure(&loss)?;
                    return self.output.put(&failed(failure));
                }
            };
            match said.split_first() {
                Some((&speech::LOADED, _)) => {}
                Some((&speech::UNLOADABLE, reason)) => {
                    let reason = String::from_utf8_lossy(reason).into_owned();
                    self.output.put(&failed(Failure::Unloadable(reason)))?;
                    break;
                }
                Some((&speech::ROWS, rows)) => {
                    self.output.put(rows)?;
                    if !matches!(Reader(rows).end(), Some(End::Not)) {
                        break;
                    }
                }
                _ => {
                    let failure = self.failure(&Loss::Mute)?;
                    self.output.put(&failed(failure))?;
                    break;
                }
            }
        }
        let parting = child.part(&mut self.keeper, grace(&self.setup));
        if let Some(why) = self.why_unfinished(&parting)? {
            crate::tell::line!("note: the simulation is whole, but its end failed: {why}");
            self.keeper.hear();
        }
        if self.setup.echo {
            let mut end = Vec::new();
            put_end(&End::Done, &mut end);
            self.output.put(&end)?;
        }
        Ok(())
    }

    /// The failure of a point whose child was lost, with the child's last output.
    fn failure(&mut self, loss: &Loss) -> io::Result<Failure> {
        let with_words = |text: String, words: String| {
            Failure::Crashed(if words.is_empty() {
                text
            } else {
                format!("{text}: {words}")
            })
        };
        Ok(match loss {
            Loss::Signal(signal) => with_words(signal_name(*signal), self.keeper.last_line()),
            Loss::Exit(code) => Failure::Exited(*code, self.keeper.last_line()),
            Loss::Timeout => Failure::Timeout,
            Loss::Memory => Failure::OutOfMemory,
            Loss::Stopped => Failure::Crashed("the FMU stopped its own process".to_owned()),
            Loss::Mute => Failure::Crashed(MUTE.to_owned()),
            Loss::Garbled(broken) => Failure::Crashed(broken.to_string()),
            // Nobody is left who could read it.
            Loss::Orphaned => return Err(io::Error::other("the supervisor has gone")),
        })
    }

    /// Why a child was lost while it loaded the FMU.
    fn loading(&self, loss: &Loss, failure: &Failure) -> String {
        let reason = match loss {
            Loss::Memory => format!(
                "it takes more memory than the {:.0} MB that a worker may; raise --memory-limit or use fewer --jobs",
                self.setup.memory as f64 / f64::from(1 << 20)
            ),
            Loss::Timeout => "it takes a longer time than --point-timeout".to_owned(),
            _ => failure.to_string(),
        };
        format!("loading the FMU: {reason}")
    }
}

/// Whether a text says that there is no licence. That it names one is not enough.
fn lacks_licence(text: &str) -> bool {
    const LACK: [&str; 15] = [
        "no ",
        "not ",
        "n't",
        "fail",
        "denied",
        "refuse",
        "unable",
        "missing",
        "invalid",
        "expire",
        "exceed",
        "in use",
        "busy",
        "unavailable",
        "wait",
    ];
    text.to_lowercase()
        .lines()
        .any(|line| line.contains("licen") && LACK.iter().any(|word| line.contains(word)))
}

fn no_process(error: &io::Error) -> Failure {
    Failure::Crashed(format!("the system starts no further process: {error}"))
}

fn bounds(setup: &Setup) -> Bounds {
    let time = setup.time.map(Duration::try_from_secs_f64);
    Bounds {
        time: time.and_then(Result::ok).unwrap_or(Duration::MAX),
        memory: setup.memory,
    }
}

/// Makes the working directory empty for the next child, whatever the last one has left there.
fn clear(place: Option<&Path>) -> io::Result<()> {
    let Some(place) = place else {
        return Ok(());
    };
    let is_empty = |mut entries: fs::ReadDir| entries.next().is_none();
    if fs::read_dir(place).is_ok_and(is_empty) {
        return Ok(());
    }
    // What cannot be removed stays.
    let _ = fs::remove_dir_all(place).or_else(|_| fs::remove_file(place));
    fs::create_dir_all(place)?;
    std::env::set_current_dir(place)
}

/// How long a child may take to end its instance.
fn grace(setup: &Setup) -> Duration {
    bounds(setup).time.min(GRACE)
}

/// Where replies go.
struct Output {
    to: File,
    ticket: u64,
    held: Vec<u8>,
    sent: Instant,
}

impl Output {
    fn send_in_time(&mut self) -> io::Result<()> {
        if self.sent.elapsed() < HOLD {
            Ok(())
        } else {
            self.send()
        }
    }

    fn send(&mut self) -> io::Result<()> {
        if !self.held.is_empty() {
            frame::write(&mut self.to, self.ticket, &self.held)?;
            self.held.clear();
        }
        self.sent = Instant::now();
        Ok(())
    }

    fn put(&mut self, payload: &[u8]) -> io::Result<()> {
        frame::write(&mut self.to, self.ticket, payload)
    }
}

/// Ends this process and all that it has started, at once: the FMU's own destructors have no say any more.
pub fn end(result: io::Result<()>) -> ! {
    system::end_all();
    system::leave(if result.is_err() { UNABLE } else { 0 })
}
