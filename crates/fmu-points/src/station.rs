//! A worker on another machine: it serves a supervisor there over standard input and output, and has processes here.
//!
//! It unpacks the FMU into a folder of its own, and watches that. It ends with all that it has started when its input closes,
//! or when the supervisor has been silent for too long: a link that is cut may close nothing.

use std::{
    fs::File,
    io::{self, Write},
    mem::take,
    num::NonZero,
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, MutexGuard,
        mpsc::{Receiver, channel},
    },
    thread,
    time::{Duration, Instant},
};

use fmu_import::{
    Package,
    isolation::frame::{self, Inbox},
    locked,
};

use crate::{
    crew::{Crew, WorkerSite},
    dispatch::{Greeting, MAGIC, News, Order, Report, Series, Terms, WorkerFault, beat},
    launcher::Launcher,
    points::{Job, PointLimits, Post, RunError, Worker},
    process, scratch, stop, system,
    wire::{bytes, read},
};

/// News are held back so long: a message a point would cost more than a short point.
const HOLD: Duration = Duration::from_millis(20);
/// How often what is held back is looked at.
const LOOK: Duration = Duration::from_secs(1);

/// Serves a supervisor.
///
/// # Errors
/// When the supervisor cannot be understood or reached.
pub fn serve() -> io::Result<()> {
    let said = serde_json::to_string(&Greeting::own())?;
    // The line break ends what a login shell may have printed before, such as its prompt.
    io::stdout().write_all(format!("\n{MAGIC}{said}\n").as_bytes())?;
    io::stdout().flush()?;
    let output = Arc::new(Mutex::new(Output {
        ticket: 0,
        held: Vec::new(),
        sent: Instant::now(),
        heard: Instant::now(),
        patience: Launcher::PATIENCE,
    }));
    // The link may be cut already.
    let watched = Arc::clone(&output);
    thread::spawn(move || watch(&watched));
    let mut orders = Inbox::new(io::stdin(), 0);
    let Some(terms) = orders.wait()? else { return Ok(()) };
    let terms: Terms = serde_json::from_slice(&terms)?;
    orders.expect(terms.ticket);
    locked(&output).meet(&terms);
    let heard = Arc::clone(&output);
    let (send, coming) = channel();
    // It is heard at any time, also while the FMU is opened.
    thread::spawn(move || {
        loop {
            let order = orders.wait();
            locked(&heard).heard = Instant::now();
            let over = !matches!(order, Ok(Some(_)));
            if send.send(order).is_err() || over {
                return;
            }
        }
    });
    let next = || -> io::Result<Option<Order>> {
        let Some(order) = coming.recv().unwrap_or(Ok(None))? else { return Ok(None) };
        let order = read(&order).ok_or_else(|| io::Error::other("an order is damaged"))?;
        Ok(Some(order))
    };
    let mut bytes = || {
        locked(&output).say(&Report::Wanted)?;
        loop {
            match next()? {
                Some(Order::Bytes(part)) => return Ok(part),
                Some(Order::Beat) => {}
                _ => return Err(io::Error::other("the FMU did not come")),
            }
        }
    };
    let station = Station::new(&terms, &output, &mut bytes);
    let station = match station {
        Ok(station) => station,
        Err(fault) => {
            locked(&output).say(&Report::Unable(fault))?;
            // It is told before this process ends.
            while next()?.is_some() {}
            return Ok(());
        }
    };
    locked(&output).say(&Report::Ready)?;
    let (send, work) = channel();
    thread::spawn(move || station.work(&work));
    let served = loop {
        match next() {
            Ok(Some(order)) => {
                if send.send(order).is_err() {
                    break Ok(());
                }
            }
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    let silent = locked(&output);
    leave(&silent);
    served
}

/// Ends all that this process has started, and removes what it has unpacked. What its points make of that is told nobody.
fn leave(_silent: &MutexGuard<'_, Output>) {
    process::abandon_all();
    scratch::remove_all();
}

/// Where reports go, and when the supervisor was heard last.
#[derive(Debug)]
struct Output {
    ticket: u64,
    held: Vec<News>,
    sent: Instant,
    heard: Instant,
    patience: Duration,
}

impl Output {
    /// Takes note of what the supervisor said first.
    fn meet(&mut self, terms: &Terms) {
        (self.ticket, self.patience) = (terms.ticket, terms.patience);
        self.heard = Instant::now();
    }

    fn hold(&mut self, news: News) -> io::Result<()> {
        self.held.push(news);
        if self.sent.elapsed() < HOLD { Ok(()) } else { self.send() }
    }

    fn send(&mut self) -> io::Result<()> {
        match take(&mut self.held) {
            held if held.is_empty() => Ok(()),
            held => self.say(&Report::News(held)),
        }
    }

    fn say(&mut self, report: &Report) -> io::Result<()> {
        // Where a signal ends this process, what becomes of its points is no finding.
        stop::give_way();
        self.sent = Instant::now();
        let mut frame = Vec::new();
        frame::write(&mut frame, self.ticket, &bytes(report))?;
        // Slurm passes on whole lines only.
        frame.push(b'\n');
        let mut to = io::stdout().lock();
        to.write_all(&frame)?;
        to.flush()
    }
}

/// Sends what is held back and signs of life, and ends this process when the supervisor gives none.
fn watch(output: &Mutex<Output>) {
    loop {
        let beat = beat(locked(output).patience);
        thread::sleep(LOOK.min(beat));
        let mut output = locked(output);
        let mut sent = output.send();
        // Before its first message the supervisor understands none.
        if output.ticket != 0 && output.sent.elapsed() >= beat {
            sent = output.say(&Report::Beat);
        }
        if sent.is_err() || output.heard.elapsed() > output.patience * 2 {
            leave(&output);
            system::leave(1);
        }
    }
}

/// The FMU here, and who runs its points.
struct Station {
    crew: Crew,
    worker: Option<Box<dyn Worker>>,
    output: Arc<Mutex<Output>>,
    /// Why points that need the supervisor's working directory cannot run here.
    nowhere: Option<String>,
    /// Has the unpacked FMU.
    _package: Package,
    _scratch: scratch::Scratch,
}

/// Gives a part of the FMU.
type FmuParts<'a> = &'a mut dyn FnMut() -> io::Result<Vec<u8>>;

impl Station {
    fn new(terms: &Terms, output: &Arc<Mutex<Output>>, source: FmuParts) -> Result<Self, WorkerFault> {
        let nowhere = std::env::set_current_dir(&terms.folder)
            .err()
            .map(|error| format!("the study names a file relative to {}: {error}", terms.folder.display()));
        if let (true, Some(nowhere)) = (terms.here, &nowhere) {
            return Err(WorkerFault::lasting(nowhere));
        }
        let scratch = stop::scratch().map_err(WorkerFault::passing)?;
        let path =
            if terms.ship { receive(scratch.path(), source).map_err(WorkerFault::passing)? } else { terms.fmu.clone() };
        let mut package = open(&path, terms)?;
        let place = WorkerSite::Processes(
            PointLimits {
                time: terms.time,
                memory: terms.memory.unwrap_or_else(|| {
                    system::share_of_memory(
                        terms.slots.unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get)),
                    )
                }),
            },
            terms.isolation,
        );
        let crew = Crew::new(&mut package, place, scratch.path(), 1 + usize::from(terms.company))
            .map_err(WorkerFault::lasting)?;
        Ok(Self { crew, worker: None, output: Arc::clone(output), nowhere, _package: package, _scratch: scratch })
    }

    /// Follows orders until nobody gives any.
    fn work(mut self, orders: &Receiver<Order>) {
        for order in orders {
            let done = match order {
                Order::Begin(series) => self.begin(&series),
                Order::Run(jobs, changed) => {
                    changed.iter().for_each(|changed| self.crew.part(changed));
                    self.run(&jobs)
                }
                Order::Bytes(_) | Order::Beat => Ok(()),
            };
            // Nobody is left to be told.
            if done.is_err() {
                return;
            }
        }
    }

    fn begin(&mut self, series: &Series) -> io::Result<()> {
        if let (true, Some(nowhere)) = (series.here, &self.nowhere) {
            return locked(&self.output).say(&Report::Unable(WorkerFault::lasting(nowhere)));
        }
        let again = if series.again { self.crew.again(&series.cases, None) } else { None };
        self.worker = Some(again.unwrap_or_else(|| self.crew.worker(&series.cases)));
        Ok(())
    }

    fn run(&mut self, jobs: &[Job]) -> io::Result<()> {
        let begun = Instant::now();
        let Some(worker) = &mut self.worker else {
            return locked(&self.output).say(&Report::Unable(WorkerFault::passing("it knows no points")));
        };
        let output = &self.output;
        let mut take = |event| {
            let sent = News::of(event).map(|news| locked(output).hold(news));
            match sent {
                Some(Err(_)) => ControlFlow::Break(()),
                _ => ControlFlow::Continue(()),
            }
        };
        let ran = worker.run(jobs, &mut Post::new(&mut take, &|| false));
        let changed = self.crew.conduct().changed_file;
        let mut output = locked(output);
        output.send()?;
        output.say(&match ran {
            Ok(()) => Report::Done(changed, begun.elapsed().as_secs_f64()),
            Err(error) => Report::Unable(WorkerFault {
                how: error.to_string(),
                lasting: matches!(error, RunError::Unloadable(_)),
            }),
        })
    }
}

/// Writes an FMU that comes in parts, the last one empty, into a folder.
fn receive(folder: &Path, source: FmuParts) -> io::Result<PathBuf> {
    let path = folder.join("shipped.fmu");
    let at = |error: io::Error| io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    let mut file = File::create(&path).map_err(at)?;
    loop {
        let part = source()?;
        if part.is_empty() {
            return Ok(path);
        }
        file.write_all(&part).map_err(at)?;
    }
}

/// Opens the FMU, which must be the supervisor's.
fn open(path: &Path, terms: &Terms) -> Result<Package, WorkerFault> {
    let package = Package::open(path).map_err(|error| {
        let hint = if terms.ship { "" } else { " (it can be shipped)" };
        WorkerFault::lasting(format!("{error}{hint}"))
    })?;
    let digest = package.digest().map_err(WorkerFault::passing)?;
    if digest == terms.digest {
        Ok(package)
    } else {
        Err(WorkerFault::lasting(format!(
            "{} is another file there (SHA-256 {digest:.12}...) than here ({:.12}...)",
            path.display(),
            terms.digest
        )))
    }
}
