//! One probe of an FMU's life, in a process of its own: the child's side.
//!
//! It tells what it is about to call and what it saw, so that whatever the FMU does to the process, the other side knows how
//! far it came.

use std::{
    path::PathBuf,
    sync::Arc,
    time::{Duration, Instant},
};

use serde::{Deserialize, Serialize};

use fmu_import::{Call, Called, Handle, Instance, Library, Package, Status, Value, Version};
use fmu_points::{
    single::{bytes, read},
    system,
    task::Schedule,
};

/// Kinds of probes.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Life {
    /// One simulation.
    Alone,
    /// Two on one instance, reset between.
    Reset,
    /// The same, and the first with changed parameters.
    Changed,
    /// Two instances, one after another.
    InTurn,
    /// Two instances at once, their steps in turn.
    Together,
}

/// The task.
#[derive(Clone, Serialize, Deserialize)]
pub struct ProbeTask {
    pub fmu: PathBuf,
    /// Whether it keeps the user's working directory.
    pub here: bool,
    pub life: Life,
    pub schedule: Schedule,
    pub columns: Vec<Handle>,
    /// Start values of every simulation, and of those in which parameters change.
    pub set: Vec<(u32, Value)>,
    pub changed: Vec<(u32, Value)>,
    /// One row is kept of so many steps.
    pub every: u64,
    /// Where a simulation ends early, with what is kept of it.
    pub end: StopAfter,
}

/// An end of a simulation before its stop time, which is no failure.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct StopAfter {
    /// After so many steps.
    pub steps: Option<u64>,
    /// After so long.
    pub time: Option<Duration>,
}

/// What a probe tells.
#[derive(Serialize, Deserialize)]
pub enum ProbeNews {
    /// What comes next.
    Stage(String),
    /// What has been seen so far.
    Report(Report),
}

/// Observations of a process.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Report {
    /// Why the binary cannot be loaded.
    pub unloadable: Option<String>,
    pub version: Option<String>,
    pub types_platform: Option<String>,
    /// Messages with a foreign environment.
    pub strays: u64,
    /// What no other process of the machine could have at the end of the simulation.
    pub held: Option<String>,
    pub runs: Vec<Run>,
}

/// Observations of one simulation.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Run {
    pub times: Vec<f64>,
    /// A row per time: the value of each column.
    pub rows: Vec<Vec<Value>>,
    pub ended: Option<f64>,
    pub warnings: u64,
    pub first_warning: Option<String>,
    /// Why it failed, and why it could not be terminated.
    pub failure: Option<String>,
    /// Whether that was a step which it refused (`fmi2Discard`).
    pub refused: bool,
    pub unfinished: Option<String>,
}

/// Runs the probe that a text describes.
pub fn serve(package: &mut Package, setup: &[u8], tell: &mut dyn FnMut(Vec<u8>)) {
    let setup: ProbeTask = read(setup).expect("this program has written it");
    let mut probe = Probe {
        report: Report::default(),
        setup: &setup,
        schedule: setup.schedule,
        version: package.description().standard,
        tell,
    };
    probe.at("loading");
    match package.load() {
        Err(error) => probe.report.unloadable = Some(error.to_string()),
        Ok(library) => probe.live(&library),
    }
    probe.save();
    probe.at("the end of its process");
}

struct Probe<'a> {
    report: Report,
    setup: &'a ProbeTask,
    schedule: Schedule,
    /// By which the functions are called that its notes name.
    version: Version,
    tell: &'a mut dyn FnMut(Vec<u8>),
}

/// A simulation under way.
struct Live {
    instance: Instance,
    run: Run,
    open: bool,
}

impl Probe<'_> {
    /// Tells what comes next.
    fn at(&mut self, stage: &str) {
        (self.tell)(bytes(&ProbeNews::Stage(stage.replace(Version::Two.prefix(), self.version.prefix()))));
    }

    /// Tells what has been seen so far.
    fn save(&mut self) {
        (self.tell)(bytes(&ProbeNews::Report(self.report.clone())));
    }

    fn live(&mut self, library: &Arc<Library>) {
        self.report.version = library.version();
        self.report.types_platform = library.types_platform();
        match self.setup.life {
            Life::Alone => self.whole(library, ""),
            Life::Reset => self.twice_on_one(library, &[]),
            Life::Changed => self.twice_on_one(library, &self.setup.changed),
            Life::InTurn => {
                self.whole(library, "the first ");
                self.whole(library, "the second ");
            }
            Life::Together => self.two_at_once(library),
        }
    }

    /// One simulation on an instance of its own.
    fn whole(&mut self, library: &Arc<Library>, which: &str) {
        let mut live = self.begin(library, &[], which);
        if let Some(live) = &mut live {
            self.steps(&mut [live]);
            self.ended(live, which);
        }
        self.free(live, which)
    }

    fn twice_on_one(&mut self, library: &Arc<Library>, changed: &[(u32, Value)]) {
        let Some(mut live) = self.begin(library, changed, "") else { return };
        self.steps(&mut [&mut live]);
        self.terminate(&mut live, "");
        self.keep(&mut live);
        self.at("fmi2Reset");
        if let Err(call) = live.instance.reset() {
            live.run.failure = Some(call.to_string());
        } else {
            self.start(&mut live, &[], " after fmi2Reset");
            self.steps(&mut [&mut live]);
            self.terminate(&mut live, " after fmi2Reset");
        }
        self.keep(&mut live);
        self.free(Some(live), "")
    }

    fn two_at_once(&mut self, library: &Arc<Library>) {
        let Some(mut first) = self.begin(library, &[], "the first ") else { return };
        let Some(mut second) = self.begin(library, &[], "the second ") else { return };
        self.steps(&mut [&mut first, &mut second]);
        for mut live in [first, second] {
            self.ended(&mut live, "");
            self.free(Some(live), "");
        }
    }

    /// Terminates, and keeps what was seen.
    fn ended(&mut self, live: &mut Live, which: &str) {
        self.report.held = system::held();
        self.terminate(live, which);
        self.report.strays += live.instance.strays();
        self.keep(live);
    }

    /// Keeps what was seen of a run.
    fn keep(&mut self, live: &mut Live) {
        self.report.runs.push(std::mem::take(&mut live.run));
    }

    /// An initialised instance. What fails is noted as a run of its own.
    fn begin(&mut self, library: &Arc<Library>, changed: &[(u32, Value)], which: &str) -> Option<Live> {
        self.at(&format!("{which}fmi2Instantiate"));
        match Instance::new(library, "probe") {
            Ok(instance) => {
                let mut live = Live { instance, run: Run::default(), open: false };
                self.start(&mut live, changed, "");
                Some(live)
            }
            Err(call) => {
                self.report.runs.push(Run { failure: Some(call.to_string()), ..Run::default() });
                None
            }
        }
    }

    /// Initialises.
    fn start(&mut self, live: &mut Live, changed: &[(u32, Value)], when: &str) {
        self.at(&format!("the initialisation{when}"));
        let mut begin = || -> Called {
            let (instance, schedule) = (&mut live.instance, &self.schedule);
            instance.setup_experiment(schedule.start, schedule.stop, schedule.tolerance)?;
            for (reference, value) in changed.iter().chain(&self.setup.set) {
                instance.set(*reference, value)?;
            }
            instance.initialise()?;
            note(instance, self.setup, schedule.start, &mut live.run)
        };
        let begun = begin();
        live.open = begun.is_ok();
        live.run.failure = begun.err().map(|call| call.to_string());
    }

    /// Takes all steps, of several instances in turn.
    fn steps(&mut self, lives: &mut [&mut Live]) {
        let points = self.schedule.points();
        let ProbeTask { every, end, .. } = self.setup;
        let (count, begun) = (end.steps.unwrap_or(u64::MAX).min(points.steps), Instant::now());
        for index in 0..count {
            let (time, next) = (points.at(index), points.at(index + 1));
            let is_kept = (index + 1).is_multiple_of(*every) || index + 1 == count;
            if index.is_multiple_of(*every) {
                self.at(&format!("fmi2DoStep at {time} s"));
            }
            for live in lives.iter_mut().filter(|live| live.open) {
                let Live { instance, run, .. } = &mut **live;
                let mut at = next;
                let mut outcome = instance.step(time, next - time);
                if let Err(Call { ended: Some(end), .. }) = &outcome {
                    at = end.at;
                    run.ended = Some(at);
                    outcome = Ok(());
                }
                let outcome = outcome.and_then(|()| {
                    if is_kept || run.ended.is_some() { note(instance, self.setup, at, run) } else { Ok(()) }
                });
                run.refused = matches!(&outcome, Err(call) if call.status == Status::Discard);
                run.failure = outcome.err().map(|call| call.to_string());
                live.open = run.failure.is_none() && run.ended.is_none();
            }
            let is_over = || end.time.is_some_and(|time| begun.elapsed() > time);
            if is_kept && is_over() || lives.iter().all(|live| !live.open) {
                break;
            }
        }
    }

    /// Ends a simulation that was initialised.
    fn terminate(&mut self, live: &mut Live, which: &str) {
        let warnings = live.instance.warnings();
        live.run.warnings = warnings.count;
        live.run.first_warning = warnings.first;
        if live.run.failure.is_none() {
            self.at(&match which.strip_prefix(' ') {
                Some(when) => format!("fmi2Terminate {when}"),
                None => format!("{which}fmi2Terminate"),
            });
            live.run.unfinished = live.instance.terminate().err().map(|call| call.to_string());
        }
    }

    /// Frees an instance, after what it showed has been written down.
    fn free(&mut self, live: Option<Live>, which: &str) {
        self.save();
        self.at(&format!("{which}fmi2FreeInstance"));
        drop(live);
    }
}

/// Adds a row.
fn note(instance: &mut Instance, setup: &ProbeTask, time: f64, run: &mut Run) -> Called {
    let folder = setup.fmu.to_string_lossy();
    let row = setup.columns.iter().map(|column| {
        Ok(match instance.value(*column)? {
            // Where the FMU was unpacked is no difference between two simulations.
            Value::String(text) => Value::String(text.replace(&*folder, "")),
            number => number,
        })
    });
    let row = row.collect::<Called<_>>()?;
    run.times.push(time);
    run.rows.push(row);
    Ok(())
}
