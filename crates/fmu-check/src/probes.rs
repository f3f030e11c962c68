//! Short simulations of an FMU, each in a process of its own: alone, with fresh memory filled otherwise, after a reset,
//! one after another, two at once, with half the step. What differs from the first, the FMU does not do by itself.

use std::{
    io,
    path::{Path, PathBuf},
    thread::sleep,
    time::{Duration, Instant},
};

use crate::{
    child::{self, Fate, ProbeOutcome},
    compare::{Change, changes, difference},
    conditions::Conditions,
    experiment,
    hit::{Breach, breach},
    probe::{Life, ProbeTask, Run, StopAfter},
    simulated,
};
use fmu_import::{Description, Package, Variable, isolation::watch::Snapshot};
use fmu_points::working_directory;
use tempfile::TempDir;

/// Bytes with which glibc fills memory, to see whether the FMU reads memory that it never wrote.
const FILLS: [u8; 2] = [0x55, 0xaa];

/// An FMU that is probed.
pub struct Probes<'a> {
    fmu: &'a Description,
    columns: Vec<&'a Variable>,
    setup: ProbeTask,
    patience: Duration,
    /// The FMU as the user gave it, and its unpacked files as they were at first.
    original: &'a Path,
    files: Snapshot,
    /// The first of these files that a probe was seen to change.
    changed: Option<PathBuf>,
    scratch: &'a Path,
}

impl<'a> Probes<'a> {
    /// Probes of the FMU unpacked in a folder; `scratch` is a folder for notes.
    pub fn new(package: &'a Package, unpacked: &Path, scratch: &'a Path, conditions: &Conditions) -> io::Result<Self> {
        let fmu = package.description();
        let columns = experiment::columns(fmu);
        let setup = ProbeTask {
            fmu: std::path::absolute(unpacked)?,
            here: working_directory::is_kept(fmu, []) || working_directory::is_named_among(&conditions.set),
            life: Life::Alone,
            schedule: experiment::first_steps(experiment::schedule(fmu, conditions.step)),
            columns: columns.iter().map(|variable| variable.handle()).collect(),
            set: conditions.set.clone(),
            changed: experiment::changed(fmu),
            every: 1,
            end: StopAfter::default(),
        };
        Ok(Self {
            fmu,
            columns,
            patience: conditions.patience,
            original: package.path(),
            files: Snapshot::of(&setup.fmu),
            changed: None,
            scratch,
            setup,
        })
    }

    fn run(&mut self, life: Life, fill: Option<u8>, patience: Duration) -> io::Result<ProbeOutcome> {
        let fresh = self.fresh_folder()?;
        let fmu = fresh.as_ref().map_or(&*self.setup.fmu, TempDir::path);
        let setup = ProbeTask { life, fmu: fmu.to_owned(), ..self.setup.clone() };
        child::run(&setup, self.scratch, patience, fill)
    }

    /// A probe of an FMU that has ended in time alone. Where this one does not, the machine may be busy: it gets another
    /// chance before it is said to hang.
    fn later(&mut self, life: Life, fill: Option<u8>) -> io::Result<ProbeOutcome> {
        const LONGER: u32 = 3;
        let timed_out = |outcome: &ProbeOutcome| matches!(outcome.fate, Some(Fate::Late));
        let outcome = self.run(life, fill, self.patience)?;
        if !timed_out(&outcome) {
            return Ok(outcome);
        }
        let patience = LONGER * self.patience;
        let mut outcome = self.run(life, fill, patience)?;
        if timed_out(&outcome) {
            let [longer, usual] = [patience, self.patience].map(|time| time.as_secs_f64());
            let text = format!("not done after {longer} s, where a first simulation was done within {usual} s");
            outcome.fate = Some(Fate::Broken(text));
        }
        Ok(outcome)
    }

    /// A newly unpacked FMU, where an earlier probe has changed the files of the first one.
    fn fresh_folder(&mut self) -> io::Result<Option<TempDir>> {
        if self.changed_file().is_none() {
            return Ok(None);
        }
        self.another_folder().map(Some)
    }

    fn another_folder(&self) -> io::Result<TempDir> {
        let package = Package::open(self.original);
        package.and_then(|mut package| package.unpack_anew(self.scratch)).map_err(io::Error::other)
    }

    /// The first file of its own folder that the FMU has changed.
    pub fn changed_file(&mut self) -> Option<&Path> {
        if self.changed.is_none() {
            self.changed = self.files.difference(&Snapshot::of(&self.setup.fmu));
        }
        let place = self.changed.as_deref()?;
        Some(place.strip_prefix(&self.setup.fmu).unwrap_or(place))
    }

    /// All that the probes find. `described_well` says that the start values of the description count.
    pub fn findings(&mut self, described_well: bool) -> io::Result<Vec<Breach>> {
        let (mut alone, refused) = self.alone()?;
        if matches!(alone.fate, Some(Fate::Late)) {
            let text = format!("{} after {} s (`patience`)", Fate::Late, self.patience.as_secs_f64());
            alone.fate = Some(Fate::Broken(text));
        }
        let (since, setup) = (Instant::now(), self.setup.clone());
        let mut breaches = simulated::remarks(self.fmu, alone.report.as_ref());
        breaches.extend(refused);
        let whole = match sound(&alone, 1) {
            Ok(runs) => &runs[0],
            Err(mut text) => {
                if text.contains("DoStep") && self.fmu.default_experiment.step.is_none() {
                    text += "; the FMU suggests no step: set a `step`";
                } else if text.contains("InitializationMode") {
                    text += "; `set` other start values";
                }
                let rule = match &alone.report {
                    Some(report) if report.unloadable.is_some() => "binary-loads",
                    _ => "simulation-runs",
                };
                breaches.push(breach(rule, self.shortened(&text)));
                return Ok(breaches);
            }
        };
        breaches.extend(simulated::values(&self.columns, whole, described_well));
        if let Some(fate) = &alone.fate {
            breaches.push(breach("life-ends", format!("{} failed after a whole simulation: {fate}", alone.stage)));
            return Ok(breaches);
        }
        if let Some(text) = &whole.unfinished {
            breaches.push(breach("life-ends", format!("the simulation is whole, but: {text}")));
        }
        let stable = self.memory(whole)?;
        let unstable = stable.is_some();
        breaches.extend(stable);
        if unstable {
            // Nothing can be compared with what differs by itself.
            return Ok(breaches);
        }
        breaches.extend(self.lives(whole)?);
        breaches.extend(self.halved(whole)?);
        breaches.extend(self.late(whole, since, setup)?);
        Ok(breaches)
    }

    /// One simulation. A step that the FMU refuses and does not suggest itself is replaced by another, with a note.
    fn alone(&mut self) -> io::Result<(ProbeOutcome, Option<Breach>)> {
        const STEPS: [f64; 5] = [1.0, 0.1, 0.01, 0.001, 0.0001];
        let first = self.run(Life::Alone, None, self.patience)?;
        let refused = self::first(&first).is_some_and(|run| run.refused);
        if !refused || self.fmu.default_experiment.step.is_some() {
            return Ok((first, None));
        }
        let usual = self.setup.schedule;
        for step in STEPS {
            self.setup.schedule = experiment::with_step(usual, step);
            let outcome = self.run(Life::Alone, None, self.patience)?;
            if sound(&outcome, 1).is_ok() {
                return Ok((
                    outcome,
                    Some(breach(
                        "step-suggested",
                        format!(
                            "it refuses the communication step of {} s and suggests none (stepSize); with {step} s it runs: \
                     simulate it with that",
                            usual.step
                        ),
                    )),
                ));
            }
        }
        self.setup.schedule = usual;
        Ok((first, None))
    }

    /// Whether the values depend on memory that was never written, or on nothing that can be named.
    fn memory(&mut self, whole: &Run) -> io::Result<Option<Breach>> {
        let [filled, again, other] = [FILLS[0], FILLS[0], FILLS[1]].map(|fill| self.later(Life::Alone, Some(fill)));
        let (filled, again, other) = (filled?, again?, other?);
        let all = [&filled, &again, &other].map(|outcome| sound(outcome, 1).map(|runs| &runs[0]));
        let [filled, again, other] = &all;
        let columns = self.columns.clone();
        let differ = |one: &Result<&Run, String>, two: &Result<&Run, String>| match (one, two) {
            (Ok(one), Ok(two)) => difference(&columns, one, two),
            (Ok(_), Err(text)) | (Err(text), Ok(_)) => Some(text.clone()),
            (Err(_), Err(_)) => None,
        };
        let Some(text) = differ(filled, again).or_else(|| differ(filled, other)).or_else(|| differ(&Ok(whole), filled))
        else {
            return Ok(None);
        };
        // What is drawn from few values, such as an address within a page, agrees now and then by chance.
        let mut by_itself = differ(filled, again);
        for (fill, before) in FILLS.into_iter().zip([filled, other]) {
            let once_more = self.later(Life::Alone, Some(fill))?;
            let once_more = sound(&once_more, 1).map(|runs| &runs[0]);
            by_itself = by_itself.or_else(|| differ(before, &once_more));
        }
        Ok(Some(match by_itself {
            Some(text) => breach(
                "reproducible",
                format!("two simulations of the same differ (clock, random numbers, addresses): {text}"),
            ),
            None => breach(
                "memory-written",
                format!("it reads memory that it never wrote: with fresh memory filled otherwise, {text}"),
            ),
        }))
    }

    /// Whether the values depend on the second at which they are computed, on the path, or now and then on chance: those of another
    /// copy of the FMU in another working directory, again and again until more than a second has passed.
    fn late(&mut self, whole: &Run, since: Instant, first: ProbeTask) -> io::Result<Option<Breach>> {
        const LATER: Duration = Duration::from_millis(1100);
        // One that leaves something in its folder finds it there.
        if self.changed_file().is_some() {
            sleep(LATER.saturating_sub(since.elapsed()));
        }
        let copy = self.another_folder()?;
        let setup = ProbeTask { fmu: copy.path().to_owned(), ..first };
        let room = tempfile::tempdir_in(self.scratch)?;
        loop {
            let is_last = since.elapsed() >= LATER;
            let late = child::run(&setup, room.path(), 3 * self.patience, None)?;
            let text = sound(&late, 1).map_or_else(Some, |runs| difference(&self.columns, whole, &runs[0]));
            if let Some(text) = text {
                return Ok(Some(breach(
                    "reproducible",
                    format!(
                        "the same simulation, later and from another copy of the FMU, differs (clock, path, random numbers): {text}"
                    ),
                )));
            }
            if is_last {
                return Ok(None);
            }
        }
    }

    /// Whether other lives give the same values.
    fn lives(&mut self, whole: &Run) -> io::Result<Vec<Breach>> {
        let once = self.fmu.capabilities.can_be_instantiated_only_once_per_process;
        let mut breaches = Vec::new();
        let reset = self.life(Life::Reset, whole)?;
        if reset.is_none() && !self.setup.changed.is_empty() {
            breaches.extend(self.life(Life::Changed, whole)?);
        }
        breaches.extend(reset);
        if once {
            return Ok(breaches);
        }
        let in_turn = self.life(Life::InTurn, whole)?;
        if in_turn.is_none() {
            breaches.extend(self.life(Life::Together, whole)?);
        }
        breaches.extend(in_turn);
        Ok(breaches)
    }

    /// The fault of two runs in one process, where one alone was `whole`.
    fn life(&mut self, life: Life, whole: &Run) -> io::Result<Option<Breach>> {
        let reset = format!("{}Reset", self.fmu.standard.prefix());
        let (rule, what) = match life {
            Life::Reset => ("life-reset", format!("after {reset}")),
            Life::Changed => ("life-reset", format!("after a simulation with changed parameters and {reset}")),
            Life::InTurn => ("life-again", "in a second instance after the first was freed".to_owned()),
            Life::Together => (
                "life-instances",
                "with two instances at once (canBeInstantiatedOnlyOncePerProcess is not set)".to_owned(),
            ),
            // It is one run.
            Life::Alone => return Ok(None),
        };
        let outcome = self.later(life, None)?;
        let runs = match sound(&outcome, 2) {
            // With changed parameters it may fail, and that says nothing of the reset.
            Err(_) if life == Life::Changed && first(&outcome).is_none_or(|run| run.failure.is_some()) => {
                return Ok(None);
            }
            Err(text) => return Ok(Some(unlike(rule, &what, &text))),
            // With changed parameters the first run must differ.
            Ok(runs) if life == Life::Changed => &runs[1..],
            Ok(runs) => runs,
        };
        let text = runs
            .iter()
            .find_map(|run| difference(&self.columns, whole, run))
            .or_else(|| Some(format!("{}: {}", outcome.stage, outcome.fate.as_ref()?)))
            .or_else(|| runs.iter().find_map(|run| run.unfinished.clone()).filter(|_| whole.unfinished.is_none()));
        Ok(text.map(|text| unlike(rule, &what, &text)))
    }

    /// How much half the step changes up to the suggested stop time, or as far as a simulation gets in a second.
    fn halved(&mut self, whole: &Run) -> io::Result<Option<Breach>> {
        const ROWS: u64 = 200;
        const TIME: Duration = Duration::from_secs(1);
        // Where it ends depends on the step that it refuses.
        if whole.ended.is_some() {
            return Ok(None);
        }
        let schedule = &mut self.setup.schedule;
        schedule.stop = experiment::last_whole_step(self.fmu, schedule).max(schedule.stop);
        let (step, stop, steps) = (schedule.step, schedule.stop, schedule.steps());
        self.setup.every = steps.div_ceil(ROWS);
        self.setup.end.time = Some(TIME);
        let coarse = self.run(Life::Alone, None, self.patience)?;
        let coarse = match (&coarse.fate, sound(&coarse, 1)) {
            (Some(Fate::Late), _) => return Ok(None),
            (_, Ok(runs)) => &runs[0],
            (_, Err(text)) => {
                return Ok(Some(breach(
                    "early-end",
                    format!("up to its stop time of {stop} s, {}", self.shortened(&text)),
                )));
            }
        };
        let reached = coarse.times.last().copied().unwrap_or(stop);
        let taken = if reached < stop { self.setup.every * (coarse.rows.len() as u64 - 1) } else { steps };
        self.setup.schedule.step /= 2.0;
        self.setup.every *= 2;
        self.setup.end = StopAfter { steps: Some(2 * taken), time: None };
        let finer = self.later(Life::Alone, None)?;
        let finer = match sound(&finer, 1) {
            Err(text) => {
                return Ok(Some(breach("step-size", format!("with half the communication step, {text}"))));
            }
            Ok(runs) => &runs[0],
        };
        let less = if reached < stop {
            format!("; it was tried up to {reached} s of {stop} s, for want of time")
        } else {
            String::new()
        };
        Ok(much(changes(&self.columns, coarse, finer))
            .map(|(rule, text)| breach(rule, format!("with half the communication step of {step} s, {text}{less}"))))
    }

    /// A message without the folder into which the FMU was unpacked.
    fn shortened(&self, text: &str) -> String {
        let folder = self.setup.fmu.display();
        text.replace(&format!("{folder}/"), "").replace(&format!("{folder}: "), "")
    }
}

/// The runs of a process, as many as there must be, or why there are not.
fn sound(outcome: &ProbeOutcome, count: usize) -> Result<&[Run], String> {
    let report = outcome.report.as_ref();
    if let Some(text) = report.and_then(|report| report.unloadable.as_ref()) {
        return Err(format!("the binary cannot be loaded: {text}"));
    }
    let runs = report.map_or(&[][..], |report| &report.runs);
    if let Some(text) = runs.iter().find_map(|run| run.failure.as_ref()) {
        return Err(format!("a simulation failed: {text}"));
    }
    if runs.len() < count {
        let fate = outcome.fate.as_ref().map_or_else(|| "it ended without a word".to_owned(), Fate::to_string);
        return Err(format!("{} failed: {fate}", outcome.stage));
    }
    Ok(runs)
}

/// The first of some runs, where there is one.
fn first(outcome: &ProbeOutcome) -> Option<&Run> {
    outcome.report.as_ref()?.runs.first()
}

/// The variable of those that change much which changes most on average, where that is no matter of single moments: a jump that
/// comes a step later. Then it is a warning.
fn much(changes: Vec<Change>) -> Option<(&'static str, String)> {
    const MUCH: f64 = 0.01;
    let Change { name, most, mean } =
        changes.into_iter().filter(|change| change.most > MUCH).max_by(|a, b| a.mean.total_cmp(&b.mean))?;
    let rule = if mean > MUCH { "step-coarse" } else { "step-size" };
    let text = if most.is_finite() {
        format!("{name} changes by up to {:.2} % of its range, {:.2} % on average", 100.0 * most, 100.0 * mean)
    } else {
        format!("{name} is a finite number with one of the steps alone")
    };
    Some((rule, text))
}

/// A life that is not as one alone.
fn unlike(rule: &'static str, what: &str, text: &str) -> Breach {
    breach(rule, format!("{what}, {text}: it must be as alone"))
}
