//! A worker: the process between the supervisor and those in which the FMU runs.
//!
//! It runs each point in a child, or many in one, and gives one reply a point whatever becomes of the child: a
//! crash, silence, foreign bytes. Only its own code writes to the supervisor. It ends with the supervisor, and
//! all that it has started with it.

use std::{
    collections::VecDeque,
    fs::File,
    io,
    time::{Duration, Instant},
};

use crate::{
    birth,
    child::{self, Estate},
    failure::Failure,
    points::{Job, PointLimits},
    runner::Runner,
    system::{self, Streams},
    wire::{Order, Origin, Reply, Said, Setup, Trouble, bytes, read},
};
use fmu_import::{
    FmuError, Package,
    isolation::{Bounds, Child, Keeper, Loss, Parting, frame, keeper::signal_name},
};

/// Replies are sent after this time at the latest, when the next point is done: a message a point would cost more
/// than a short point.
const HOLD: Duration = Duration::from_millis(1);
/// How long a child may take to end its instance after it has answered, where a point may take longer than that: a
/// tool behind the FMU is closed then, files are written, a licence is given back.
const GRACE: Duration = Duration::from_secs(60);

/// The exit code of a child that could not report: unlike those with which an FMU may end it.
const UNABLE: i32 = 121;
/// Why it cannot.
const MUTE: &str = "the FMU closed descriptors that it did not open, or became another program";

/// Serves a supervisor over standard input and output.
///
/// # Errors
/// When the supervisor cannot be understood or reached.
pub fn serve() -> io::Result<()> {
    let (input, output, streams) = Streams::take()?;
    let mut orders = frame::Inbox::new(input, 0);
    let Some(setup) = orders.wait()? else { return Ok(()) };
    let setup: Setup = serde_json::from_slice(&setup)?;
    orders.expect(setup.ticket);
    if let Some(byte) = setup.fill {
        child::fill_memory(byte);
    }
    let mut service = Service {
        keeper: streams.keeper(setup.echo, setup.ticket)?,
        output: Output { to: output, ticket: setup.ticket, held: Vec::new(), sent: Instant::now() },
        package: None,
        runner: None,
        used: None,
        setup,
    };
    while let Some(order) = orders.wait()? {
        let order = read(&order).ok_or_else(|| io::Error::other("an order is damaged"))?;
        service.obey(order)?;
        service.output.send()?;
    }
    Ok(())
}

/// A worker's means.
struct Service {
    setup: Setup,
    keeper: Keeper,
    output: Output,
    package: Option<Package>,
    /// What runs points in forks, once this process has loaded the FMU. It is never instantiated here.
    runner: Option<Box<Runner>>,
    /// The child that runs many points.
    used: Option<Child>,
}

impl Service {
    fn obey(&mut self, order: Order) -> io::Result<()> {
        if let Order::Used(jobs) = order {
            return self.run_used(jobs.into());
        }
        // A child that stays would be taken for one left behind.
        self.used = None;
        let (jobs, one): (_, fn(Vec<Job>) -> Order) = match order {
            Order::New(jobs) => (jobs, Order::New),
            Order::Forked(jobs) => (jobs, Order::Forked),
            other => return self.record(&other),
        };
        for job in jobs {
            let reply = self.run_alone(job.index, &one(vec![job]))?;
            self.output.held.push(reply);
            self.output.send_in_time()?;
        }
        Ok(())
    }

    /// Runs a point in a child of its own.
    fn run_alone(&mut self, index: u64, order: &Order) -> io::Result<Reply> {
        let (mut child, forkable) = match self.begin(order)? {
            Ok(begun) => begun,
            Err(trouble) => return Ok(Reply::new(index, Err(trouble))),
        };
        let mut replies = match self.hear(&mut child) {
            Ok(Said::Replies(replies)) => replies,
            Ok(_) => Vec::new(),
            Err(loss) => {
                drop(child);
                let trouble = Trouble::lost(self.failure(&loss)?);
                let reply = Reply::new(index, Err(trouble));
                return Ok(Reply { forkable, ..reply });
            }
        };
        let mut reply = match replies.pop() {
            Some(reply) => reply,
            None => Reply::new(index, Err(Trouble::lost(self.failure(&Loss::Mute)?))),
        };
        reply.forkable = forkable;
        let parting = child.part(&mut self.keeper, grace(&self.setup));
        self.note_parting(&parting, &mut reply)?;
        self.hear_of_licences(&mut reply);
        Ok(reply)
    }

    /// The next message of a child.
    fn hear(&mut self, child: &mut Child) -> Result<Said, Loss> {
        let said = child.answer(&mut self.keeper, bounds(&self.setup))?;
        read(&said).ok_or(Loss::Mute)
    }

    /// Notes what the FMU did when its simulation was ended.
    fn note_parting(&mut self, parting: &Parting, reply: &mut Reply) -> io::Result<()> {
        let Ok(simulated) = &mut reply.answer else { return Ok(()) };
        if let Some(Said::Farewell(notices)) = parting.words.as_deref().and_then(read) {
            simulated.notices = Some(Box::new(notices));
        }
        if let Some(why) = self.why_unfinished(parting)? {
            simulated.notices.get_or_insert_default().unfinished.get_or_insert(why);
        }
        Ok(())
    }

    /// The fault after all had been computed, if there was one.
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
        Ok(Some(format!("{why} ({prefix}Terminate or {prefix}FreeInstance)")))
    }

    /// Opens the FMU; loads it into this process where children are to have it loaded already.
    fn prepare(&mut self, order: &Order) -> Result<(), String> {
        // The user knows the file, not the folder into which it was unpacked.
        let named = |error: FmuError| error.at(&self.setup.name).to_string();
        if self.package.is_none() {
            self.package = Some(self.setup.open().map_err(named)?);
        }
        if let (Order::Forked(_), None, Some(package)) = (order, &self.runner, &mut self.package) {
            let library = self.keeper.blindly(|| package.load());
            // Its initialisers may have changed what this process does about its children.
            system::adopt_orphans();
            self.runner = Runner::new(library.map_err(named)?, &self.setup.cases);
            system::give_back_free_memory();
        }
        Ok(())
    }

    /// A refusal may speak of a licence in what the FMU printed.
    fn hear_of_licences(&mut self, reply: &mut Reply) {
        if let Err(trouble) = &mut reply.answer
            && let Origin::Refusal { licence } = &mut trouble.from
        {
            let text = format!("{}\n{}", trouble.failure, self.keeper.text());
            *licence |= lacks_licence(&text);
        }
    }

    /// Runs points in one child. Where it is lost, nobody knows which of them has cost it: those that are left run alone.
    fn run_used(&mut self, mut jobs: VecDeque<Job>) -> io::Result<()> {
        while !jobs.is_empty() {
            if self.attempt(&mut jobs)? {
                continue;
            }
            self.used = None;
            for job in jobs.drain(..) {
                let reply = self.run_alone(job.index, &Order::New(vec![job]))?;
                self.output.held.push(reply);
                self.output.send_in_time()?;
            }
        }
        let swollen = |child: &Child| child.resident() > self.setup.limits.memory / 2;
        // A leak costs a restart now and then, long before it costs a point.
        if self.used.as_ref().is_some_and(swollen) {
            self.used = None;
        }
        Ok(())
    }

    /// Lets the child run points until all are answered, or one has failed; `false` where it is lost.
    fn attempt(&mut self, jobs: &mut VecDeque<Job>) -> io::Result<bool> {
        let mut child = match self.used.take() {
            Some(child) => child,
            None => match self.begin(&Order::Used(Vec::new()))? {
                Ok((child, _)) => child,
                Err(trouble) => {
                    self.output.held.extend(jobs.drain(..).map(|job| Reply::new(job.index, Err(trouble.clone()))));
                    return Ok(true);
                }
            },
        };
        if child.send(&bytes(jobs)).is_err() {
            return Ok(false);
        }
        while !jobs.is_empty() {
            let Ok(Said::Replies(replies)) = self.hear(&mut child) else { return Ok(false) };
            for mut reply in replies {
                if jobs.front().is_none_or(|job| job.index != reply.index) {
                    return Ok(false);
                }
                jobs.pop_front();
                self.hear_of_licences(&mut reply);
                let failed = reply.answer.is_err();
                self.output.held.push(reply);
                if failed {
                    // It frees its instance, and ends.
                    child.part(&mut self.keeper, grace(&self.setup));
                    self.output.send_in_time()?;
                    return Ok(true);
                }
            }
            self.output.send_in_time()?;
        }
        self.used = Some(child);
        Ok(true)
    }

    /// A child that has loaded the FMU, and whether its process may be forked, where that was looked at; or why there is
    /// none.
    fn begin(&mut self, order: &Order) -> io::Result<Result<(Child, Option<bool>), Trouble>> {
        if let Err(reason) = self.prepare(order) {
            return Ok(Err(Trouble::unloadable(reason)));
        }
        self.setup.clear()?;
        // A point may have removed the one that this process was in.
        self.setup.place.as_ref().map_or(Ok(()), std::env::set_current_dir)?;
        let mut child = match self.child(order) {
            Ok(child) if matches!(order, Order::Forked(_)) => return Ok(Ok((child, None))),
            Ok(child) => child,
            Err(error) => {
                return Ok(Err(Trouble::lost(Failure::Crashed(format!(
                    "the system starts no further process: {error}"
                )))));
            }
        };
        let loss = match self.hear(&mut child) {
            Ok(Said::Loaded(forkable)) => return Ok(Ok((child, Some(forkable)))),
            Ok(Said::Unloadable(reason)) => {
                child.part(&mut self.keeper, grace(&self.setup));
                return Ok(Err(Trouble::unloadable(reason)));
            }
            Ok(_) => Loss::Mute,
            Err(loss) => loss,
        };
        drop(child);
        let failure = self.failure(&loss)?;
        // What ended the process may have nothing to do with the FMU.
        let passing = !matches!(loss, Loss::Timeout | Loss::Memory);
        Ok(Err(Trouble { passing, ..Trouble::unloadable(self.loading(&loss, &failure)) }))
    }

    /// A child at work; waits for room where the system has none at the moment.
    fn child(&mut self, order: &Order) -> io::Result<Child> {
        const PAUSES: [u64; 5] = [1, 10, 100, 500, 1000];
        let runner = if matches!(order, Order::Forked(_)) { &mut self.runner } else { &mut None };
        let mut estate = Estate { setup: &mut self.setup, package: self.package.as_mut(), runner };
        for pause in PAUSES {
            // SAFETY: where children are forks, a worker has a single thread; loading the FMU has started none, or it is
            // not loaded here.
            if let Ok(child) = unsafe { birth::child(&mut self.keeper, &mut estate, order) } {
                return Ok(child);
            }
            std::thread::sleep(Duration::from_millis(pause));
        }
        // SAFETY: a single thread, as in the loop.
        unsafe { birth::child(&mut self.keeper, &mut estate, order) }
    }

    /// Runs a point with its trajectory, or an errand.
    fn record(&mut self, order: &Order) -> io::Result<()> {
        let mut child = match self.begin(order)? {
            Ok((child, _)) => child,
            Err(trouble) => return self.output.say(&Said::Ended(Some(trouble.failure))),
        };
        let is_errand = matches!(order, Order::Errand(_));
        loop {
            // What comes is handed on as it came.
            let said = child.answer(&mut self.keeper, bounds(&self.setup));
            let said = said.and_then(|said| match read(&said) {
                Some(Said::Rows(_) | Said::Told(_)) => Ok((said, false)),
                Some(Said::Ended(_)) => Ok((said, true)),
                _ => Err(Loss::Mute),
            });
            match said {
                // Its end belongs to an errand.
                Ok((_, true)) if is_errand => break,
                Ok((said, ended)) => {
                    self.output.write(&said)?;
                    if ended {
                        break;
                    }
                }
                Err(loss) => {
                    drop(child);
                    let failure = self.failure(&loss)?;
                    return self.output.say(&Said::Ended(Some(failure)));
                }
            }
        }
        let parting = child.part(&mut self.keeper, grace(&self.setup));
        if is_errand {
            let failure = parting.loss.map(|loss| self.failure(&loss));
            return self.output.say(&Said::Ended(failure.transpose()?));
        }
        if let Some(why) = self.why_unfinished(&parting)? {
            crate::tell::line!("note: the simulation is whole, but its end failed: {why}");
            self.keeper.hear();
        }
        if self.setup.echo {
            self.output.say(&Said::Ended(None))?;
        }
        Ok(())
    }

    /// The failure of a point whose child was lost, with the child's last output.
    fn failure(&mut self, loss: &Loss) -> io::Result<Failure> {
        let with_words = |text: String, words: String| {
            Failure::Crashed(if words.is_empty() { text } else { format!("{text}: {words}") })
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
                "it takes more memory than the {:.0} MB that a worker may; allow more, or run fewer points at once",
                self.setup.limits.memory as f64 / f64::from(1 << 20)
            ),
            Loss::Timeout => "it takes more time than a point may".to_owned(),
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
    text.to_lowercase().lines().any(|line| line.contains("licen") && LACK.iter().any(|word| line.contains(word)))
}

fn bounds(setup: &Setup) -> Bounds {
    let PointLimits { time, memory } = setup.limits;
    Bounds { time, memory }
}

/// How long a child may take to end its instance.
fn grace(setup: &Setup) -> Duration {
    setup.limits.time.min(GRACE)
}

/// Where replies go.
struct Output {
    to: File,
    ticket: u64,
    held: Vec<Reply>,
    sent: Instant,
}

impl Output {
    fn send_in_time(&mut self) -> io::Result<()> {
        if self.sent.elapsed() < HOLD { Ok(()) } else { self.send() }
    }

    fn send(&mut self) -> io::Result<()> {
        if !self.held.is_empty() {
            let held = std::mem::take(&mut self.held);
            self.say(&Said::Replies(held))?;
        }
        self.sent = Instant::now();
        Ok(())
    }

    fn say(&mut self, said: &Said) -> io::Result<()> {
        self.write(&bytes(said))
    }

    fn write(&mut self, said: &[u8]) -> io::Result<()> {
        frame::write(&mut self.to, self.ticket, said)
    }
}

/// Ends this process and all that it has started, at once: the FMU's own destructors have no say any more.
pub fn end(result: io::Result<()>) -> ! {
    system::end_all();
    system::leave(if result.is_err() { UNABLE } else { 0 })
}
