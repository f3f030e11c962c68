//! Short simulations of an FMU, each in a process of its own: alone, with fresh memory filled otherwise, after a reset,
//! one after another, two at once, with half the step. What differs from the first, the FMU does not do by itself.

use std::io;
use std::path::Path;
use std::time::Duration;

use super::child::{self, Outcome};
use super::hit::Hit;
use super::probe::{Life, Run, Setup};
use super::structure::short;
use crate::results::points::number as written;
use crate::task::Schedule;
use fmu_import::{Causality, Content, Description, Handle, Kind, Value, Variability, Variable};

/// A breach of the rule of this name.
type Found = (&'static str, Hit);

/// What glibc fills memory with, to see whether the FMU reads what it never wrote.
const FILLS: [u8; 2] = [0x55, 0xaa];

/// An FMU that is probed.
pub(super) struct Probes<'a> {
    fmu: &'a Description,
    columns: Vec<&'a Variable>,
    setup: Setup,
    patience: Duration,
}

impl<'a> Probes<'a> {
    /// Probes of the FMU unpacked in a folder; `scratch` is a folder for notes.
    pub(super) fn new(
        fmu: &'a Description,
        unpacked: &Path,
        scratch: &Path,
        patience: Duration,
    ) -> io::Result<Self> {
        let columns = columns(fmu);
        let setup = Setup {
            fmu: std::path::absolute(unpacked)?,
            life: Life::Alone,
            schedule: schedule(fmu),
            columns: columns.iter().map(|variable| variable.handle()).collect(),
            changed: changed(fmu),
            supervisor: std::process::id(),
            stage: scratch.join("probe.stage"),
            result: scratch.join("probe.json"),
        };
        Ok(Self {
            fmu,
            columns,
            setup,
            patience,
        })
    }

    fn run(&self, life: Life, fill: Option<u8>) -> io::Result<Outcome> {
        let setup = Setup {
            life,
            ..self.setup.clone()
        };
        child::run(&setup, self.patience, fill)
    }

    /// All that the probes find. `described_well` says that the start values of the description count.
    pub(super) fn findings(&self, described_well: bool) -> io::Result<Vec<Found>> {
        let alone = self.run(Life::Alone, None)?;
        let mut found = self.remarks(&alone);
        let whole = match sound(&alone, 1) {
            Ok(runs) => &runs[0],
            Err(mut text) => {
                if text.ends_with(child::TIMEOUT) {
                    text += &format!(" after {} s (--patience)", self.patience.as_secs_f64());
                }
                let rule = match &alone.report {
                    Some(report) if report.unloadable.is_some() => "binary-loads",
                    _ => "simulation-runs",
                };
                found.push((rule, Hit::plain(self.shortened(&text))));
                return Ok(found);
            }
        };
        found.extend(self.shown(whole, described_well));
        if let Some(fate) = &alone.fate {
            let text = format!("{} failed after a whole simulation: {fate}", alone.stage);
            found.push(("life-ends", Hit::plain(text)));
            return Ok(found);
        }
        if let Some(text) = &whole.unfinished {
            found.push((
                "life-ends",
                Hit::plain(format!("the simulation is whole, but: {text}")),
            ));
        }
        let stable = self.memory(whole)?;
        let unstable = stable.is_some();
        found.extend(stable);
        if unstable {
            // Nothing can be compared with what differs by itself.
            return Ok(found);
        }
        found.extend(self.lives(whole)?);
        found.extend(self.halved(whole)?);
        Ok(found)
    }

    /// What the first simulation says beside its values.
    fn remarks(&self, alone: &Outcome) -> Vec<Found> {
        let mut found = Vec::new();
        let mut tell = |rule, text: String| found.push((rule, Hit::plain(text)));
        if self.fmu.capabilities.needs_execution_tool {
            tell(
                "execution-tool",
                "it needs the tool that wrote it (needsExecutionTool)".to_owned(),
            );
        }
        let Some(report) = &alone.report else {
            return found;
        };
        for (rule, function, usual, own) in [
            ("binary-version", "fmi2GetVersion", "2.0", &report.version),
            (
                "binary-types",
                "fmi2GetTypesPlatform",
                "default",
                &report.types_platform,
            ),
        ] {
            if let Some(other) = own.as_deref().filter(|own| *own != usual) {
                tell(
                    rule,
                    format!(
                        "{function} returns \"{other}\", not \"{usual}\": build it with the standard's headers"
                    ),
                );
            }
        }
        if report.strays > 0 {
            let text = "the logger is called with an environment that is not the one of fmi2Instantiate: pass \
                        componentEnvironment on";
            tell("logger-environment", text.to_owned());
        }
        for run in &report.runs {
            if run.warnings > 0 {
                let first = run.first_warning.as_deref().unwrap_or_default();
                tell(
                    "warnings",
                    format!(
                        "calls that returned fmi2Warning: {}; the first: {first}",
                        run.warnings
                    ),
                );
            }
            if let Some(time) = run.ended {
                tell(
                    "early-end",
                    format!("it ends the simulation by itself, at {time} s (fmi2Terminated)"),
                );
            }
        }
        found
    }

    /// Values that cannot be right.
    fn shown(&self, run: &Run, described_well: bool) -> Vec<Found> {
        let (mut found, mut infinite) = (Vec::new(), Vec::new());
        for (place, variable) in self.columns.iter().enumerate() {
            let values = run
                .rows
                .iter()
                .filter_map(|row| number(row[place], variable));
            if variable.causality == Causality::Parameter {
                continue;
            }
            // Before the first step, some are not known yet.
            if let Some(value) = values.clone().skip(1).find(|value| !value.is_finite()) {
                infinite.push(format!("{} is {value}", variable.name));
            }
            found.extend(beyond(variable, values));
        }
        if !infinite.is_empty() {
            let text = format!(
                "{} in a simulation: no criterion can use it",
                short(&infinite)
            );
            found.push(("output-finite", Hit::plain(text)));
        }
        if described_well {
            found.extend(self.other_starts(run));
        }
        found
    }

    /// Parameters that the binary starts with another value than the description says.
    fn other_starts(&self, run: &Run) -> Option<Found> {
        const ROUNDING: f64 = 1e-6;
        let first = run.rows.first()?;
        let parameters = self.columns.iter().zip(first);
        let others: Vec<String> = parameters
            .filter(|(variable, _)| variable.causality == Causality::Parameter)
            .filter_map(|(variable, bits)| {
                let (start, value) = (variable.kind.start()?, number(*bits, variable)?);
                let differs = (value - start).abs() > ROUNDING * start.abs().max(value.abs());
                let Variable { name, line, .. } = variable;
                differs.then(|| {
                    format!("{name} (line {line}): start is {start}, but the binary's is {value}")
                })
            })
            .collect();
        let text = || format!("{}: correct the description or the binary", short(&others));
        (!others.is_empty()).then(|| ("start-agrees", Hit::of(super::document::NAME, text())))
    }

    /// Whether the values depend on memory that was never written, or on nothing that can be named.
    fn memory(&self, whole: &Run) -> io::Result<Option<Found>> {
        let [filled, again, other] =
            [FILLS[0], FILLS[0], FILLS[1]].map(|fill| self.run(Life::Alone, Some(fill)));
        let (filled, again, other) = (filled?, again?, other?);
        let all = [&filled, &again, &other].map(|outcome| sound(outcome, 1).map(|runs| &runs[0]));
        let [filled, again, other] = &all;
        let differ = |one: &Result<&Run, String>, two: &Result<&Run, String>| match (one, two) {
            (Ok(one), Ok(two)) => self.difference(one, two),
            (Ok(_), Err(text)) | (Err(text), Ok(_)) => Some(text.clone()),
            (Err(_), Err(_)) => None,
        };
        if let Some(text) = differ(filled, again) {
            let text = format!(
                "two simulations of the same differ (clock, random numbers, addresses): {text}"
            );
            return Ok(Some(("reproducible", Hit::plain(text))));
        }
        let whole = Ok(whole);
        let text = differ(filled, other).or_else(|| differ(&whole, filled));
        Ok(text.map(|text| {
            let text = format!(
                "it reads memory that it never wrote: with fresh memory filled otherwise, {text}"
            );
            ("memory-written", Hit::plain(text))
        }))
    }

    /// Whether other lives give the same values.
    fn lives(&self, whole: &Run) -> io::Result<Vec<Found>> {
        let once = self
            .fmu
            .capabilities
            .can_be_instantiated_only_once_per_process;
        let mut found = Vec::new();
        let reset = self.life(Life::Reset, "life-reset", "after fmi2Reset", whole)?;
        if reset.is_none() && !self.setup.changed.is_empty() {
            let what = "after a simulation with changed parameters and fmi2Reset";
            // What fails with other parameters says nothing of the reset.
            let changed = self.run(Life::Changed, None)?;
            let first_fine =
                matches!(sound(&changed, 2), Ok([first, _]) if first.failure.is_none());
            if first_fine {
                found.extend(self.judged(&changed, "life-reset", what, whole));
            }
        }
        found.extend(reset);
        if once {
            return Ok(found);
        }
        let in_turn = "in a second instance after the first was freed";
        let in_turn = self.life(Life::InTurn, "life-again", in_turn, whole)?;
        if in_turn.is_none() {
            let at_once =
                "with two instances at once (canBeInstantiatedOnlyOncePerProcess is not set)";
            found.extend(self.life(Life::Together, "life-instances", at_once, whole)?);
        }
        found.extend(in_turn);
        Ok(found)
    }

    fn life(
        &self,
        life: Life,
        rule: &'static str,
        what: &str,
        whole: &Run,
    ) -> io::Result<Option<Found>> {
        Ok(self.judged(&self.run(life, None)?, rule, what, whole))
    }

    /// The first difference of two runs in one process from one alone.
    fn judged(
        &self,
        outcome: &Outcome,
        rule: &'static str,
        what: &str,
        whole: &Run,
    ) -> Option<Found> {
        let text = match sound(outcome, 2) {
            Err(text) => Some(text),
            Ok(runs) => {
                // The first run with changed parameters differs because it shall.
                let changed = what.contains("changed");
                let mut compared = runs.iter().skip(usize::from(changed));
                compared
                    .find_map(|run| self.difference(whole, run))
                    .or_else(|| {
                        outcome
                            .fate
                            .as_ref()
                            .map(|fate| format!("{}: {fate}", outcome.stage))
                    })
                    .or_else(|| {
                        let unfinished = runs.iter().find_map(|run| run.unfinished.clone());
                        unfinished.filter(|_| whole.unfinished.is_none())
                    })
            }
        };
        text.map(|text| {
            (
                rule,
                Hit::plain(format!("{what}, {text}: it must be as alone")),
            )
        })
    }

    /// Where two runs differ first. Zero is zero with either sign.
    fn difference(&self, one: &Run, other: &Run) -> Option<String> {
        for (row, (first, second)) in one.rows.iter().zip(&other.rows).enumerate() {
            for (place, variable) in self.columns.iter().enumerate() {
                let (first, second) = (first[place], second[place]);
                let numbers = [first, second].map(|bits| number(bits, variable));
                let same =
                    first == second || matches!(numbers, [Some(one), Some(two)] if one == two);
                if !same {
                    let shown =
                        |value: Option<f64>| value.map_or("another text".to_owned(), written);
                    let [first, second] = numbers.map(shown);
                    let (name, time) = (&variable.name, one.times[row]);
                    return Some(format!("{name} is {second} instead of {first} at {time} s"));
                }
            }
        }
        let [first, second] = [one, other].map(|run| run.times.last().copied().unwrap_or(f64::NAN));
        (first.to_bits() != second.to_bits())
            .then(|| format!("it ends at {second} s instead of {first} s"))
    }

    /// How much half the step changes. It may: a note.
    fn halved(&self, whole: &Run) -> io::Result<Option<Found>> {
        const MUCH: f64 = 0.01;
        // Where it ends depends on the step that it refuses.
        if whole.ended.is_some() {
            return Ok(None);
        }
        let outcome = self.run(Life::Halved, None)?;
        let runs = match sound(&outcome, 1) {
            Ok(runs) => runs,
            Err(text) => {
                let text = format!("with half the communication step, {text}");
                return Ok(Some(("step-size", Hit::plain(text))));
            }
        };
        let last = whole.rows.last().zip(runs[0].rows.last());
        let ends = whole.times.last() == runs[0].times.last();
        let Some((one, other)) = last.filter(|_| ends) else {
            return Ok(None);
        };
        let share = |(place, variable): (usize, &&'a Variable)| {
            let over_time = whole
                .rows
                .iter()
                .filter_map(|row| number(row[place], variable));
            let scale = over_time.fold(0.0, |largest: f64, value| largest.max(value.abs()));
            let change = (number(one[place], variable)? - number(other[place], variable)?).abs();
            let real = variable.kind.content() == Content::Real && scale > 0.0;
            real.then_some((change / scale, &variable.name))
        };
        let most = self
            .columns
            .iter()
            .enumerate()
            .filter_map(share)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        Ok(most.filter(|(share, _)| *share > MUCH).map(|(share, name)| {
            let step = self.setup.schedule.step;
            let text = format!(
                "with half the communication step of {step} s, {name} changes by {:.2} % of its size",
                100.0 * share
            );
            ("step-size", Hit::plain(text))
        }))
    }

    /// A message without the folder into which the FMU was unpacked.
    fn shortened(&self, text: &str) -> String {
        let folder = self.setup.fmu.display();
        text.replace(&format!("{folder}/"), "")
            .replace(&format!("{folder}: "), "")
    }
}

/// The runs of a process, as many as there must be, or why there are not.
fn sound(outcome: &Outcome, count: usize) -> Result<&[Run], String> {
    let stage = &outcome.stage;
    let Some(report) = &outcome.report else {
        let fate = outcome.fate.as_deref().unwrap_or("it ended without a word");
        return Err(format!("{stage} failed: {fate}"));
    };
    if let Some(text) = &report.unloadable {
        return Err(format!("the binary cannot be loaded: {text}"));
    }
    if let Some(text) = report.runs.iter().find_map(|run| run.failure.as_ref()) {
        return Err(format!("a simulation failed: {text}"));
    }
    if report.runs.len() < count {
        let fate = outcome.fate.as_deref().unwrap_or("it ended without a word");
        return Err(format!("{stage} failed: {fate}"));
    }
    Ok(&report.runs)
}

/// A value as a number; a text is none.
fn number(bits: u64, variable: &Variable) -> Option<f64> {
    Some(match variable.kind.content() {
        Content::Real => f64::from_bits(bits),
        #[allow(clippy::cast_possible_truncation)]
        Content::Integer => f64::from((bits as u32).cast_signed()),
        Content::Boolean => f64::from(u8::from(bits != 0)),
        Content::Text => return None,
    })
}

/// A variable that leaves the range that the FMU declares for it.
fn beyond(variable: &Variable, values: impl Iterator<Item = f64> + Clone) -> Option<Found> {
    let (min, max) = variable.kind.range();
    // A range that is none is a finding of its own.
    if min.zip(max).is_some_and(|(min, max)| min > max) {
        return None;
    }
    let below = min.and_then(|min| Some((values.clone().find(|value| *value < min)?, min, "min")));
    let beyond = below.or_else(|| {
        max.and_then(|max| Some((values.clone().find(|value| *value > max)?, max, "max")))
    });
    let (value, bound, name) = beyond?;
    let text = format!(
        "{}: {value} in a simulation, beyond its {name} of {bound}: correct the range or the model",
        variable.name
    );
    Some(("output-range", Hit::plain(text)))
}

/// All outputs and parameters; without outputs, local variables.
fn columns(fmu: &Description) -> Vec<&Variable> {
    const LOCALS: usize = 100;
    let mut columns: Vec<&Variable> = fmu.with(Causality::Output).collect();
    if columns.is_empty() {
        let varying = |variable: &&Variable| variable.variability != Variability::Constant;
        columns = fmu
            .with(Causality::Local)
            .filter(varying)
            .take(LOCALS)
            .collect();
    }
    let numbers = fmu
        .with(Causality::Parameter)
        .filter(|variable| variable.number_handle().is_some());
    columns.extend(numbers);
    columns
}

/// A few steps of the suggested experiment, or of another where that is of no use.
fn schedule(fmu: &Description) -> Schedule {
    const STEPS: f64 = 10.0;
    let mut schedule = Schedule::suggested(fmu);
    let passes = schedule.stop > schedule.start;
    if !passes {
        schedule.stop = schedule.start + 1.0;
    }
    if !(schedule.step > 0.0 && schedule.step.is_finite()) {
        schedule.step = (schedule.stop - schedule.start) / 500.0;
    }
    schedule.stop = schedule.stop.min(schedule.start + STEPS * schedule.step);
    schedule.tolerance = schedule.tolerance.filter(|tolerance| *tolerance > 0.0);
    schedule
}

/// Other values of real parameters: a little more than the start, within the range.
fn changed(fmu: &Description) -> Vec<(u32, Value)> {
    const MORE: f64 = 1.01;
    let parameters = fmu
        .with(Causality::Parameter)
        .filter(|variable| variable.is_settable());
    let other = |variable: &Variable| {
        let Kind::Real {
            start: Some(start),
            min,
            max,
            ..
        } = variable.kind
        else {
            return None;
        };
        let value = [start * MORE, start / MORE].into_iter().find(|value| {
            value.is_finite()
                && *value != start
                && min.is_none_or(|min| *value >= min)
                && max.is_none_or(|max| *value <= max)
        })?;
        let Handle { reference, .. } = variable.handle();
        Some((reference, Value::Real(value)))
    };
    parameters.filter_map(other).collect()
}
