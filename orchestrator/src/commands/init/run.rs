//! One run of the FMU as it is: what its outputs do.

use std::time::{Duration, Instant};

use crate::cli::Init;
use crate::commands::isolated::Isolated;
use crate::commands::simulate::of_step;
use crate::error::Error;
use fmu_import::{Description, Handle, Value, Variable};
use fmu_points::failure::Failure;
use fmu_points::names::behind;
use fmu_points::task::{Schedule, Task};
use result_document::format::number as digits;
use sampling::statistics::moments::mean;
use sampling::statistics::{Accumulator, Statistic};

/// The longest time of the run.
const PATIENCE: Duration = Duration::from_secs(60);

/// The tolerance of the study that is written, as a part of the value.
pub(super) const TOLERANCE: f64 = 0.05;
/// Half the step changes a criterion's value by less than this part of it, a sixth of its tolerance, and the whole signal by
/// less than this part of its range, where the step is short enough.
const SETTLED: f64 = TOLERANCE / 6.0;

/// Less than this part of its range is next to nothing.
pub(super) const SMALL: f64 = 0.01;

/// What a variable did, in its own unit.
#[derive(Debug)]
pub(super) struct Signal<'a> {
    pub(super) variable: &'a Variable,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) is_finite: bool,
    last: f64,
    mean: Accumulator,
    rms: Accumulator,
    span: f64,
    /// Its values at times that runs with other steps have, too.
    course: Vec<f64>,
    /// How often it turned in the second half of the run.
    turns: u32,
    way: f64,
}

impl<'a> Signal<'a> {
    fn new(variable: &'a Variable) -> Self {
        Self {
            variable,
            least: f64::INFINITY,
            most: f64::NEG_INFINITY,
            is_finite: true,
            last: f64::NAN,
            mean: Accumulator::new(Statistic::Mean),
            rms: Accumulator::new(Statistic::Rms),
            span: 0.0,
            course: Vec::new(),
            turns: 0,
            way: 0.0,
        }
    }

    fn add(&mut self, elapsed: f64, value: f64, counts: bool) {
        self.is_finite &= value.is_finite();
        let way = value - self.last;
        if way * self.way < 0.0 && counts {
            self.turns += 1;
        }
        if way != 0.0 && way.is_finite() {
            self.way = way;
        }
        (self.least, self.most) = (self.least.min(value), self.most.max(value));
        self.mean.add(elapsed, value);
        self.rms.add(elapsed, value);
        self.span += elapsed;
        self.last = value;
    }

    pub(super) fn moves(&self) -> bool {
        self.is_finite && self.least < self.most
    }

    /// A statistic that tells of it, and its value. Of what still swings at the end, one instant says little; of what is next
    /// to nothing, its tolerance could be no part.
    pub(super) fn value(&self) -> (Statistic, f64) {
        let mut statistic = match self.turns > 1 {
            true => Statistic::Mean,
            false => Statistic::Final,
        };
        if self.of(statistic).abs() < SMALL * (self.most - self.least) {
            statistic = Statistic::Rms;
        }
        (statistic, self.of(statistic))
    }

    fn of(&self, statistic: Statistic) -> f64 {
        match statistic {
            Statistic::Mean => self.mean.result(self.span),
            Statistic::Rms => self.rms.result(self.span),
            _ => self.last,
        }
    }

    /// How far it is from that with a coarser step: its value, as a part of what its tolerance is a part of, and its course in
    /// the mean, as a part of its range. A value alone may not tell a swing that decays from one that does not.
    fn change_from(&self, coarse: &Self) -> [f64; 2] {
        let (statistic, value) = self.value();
        let range = self.most - self.least;
        let size = match value.abs() < SMALL * range {
            true => range,
            false => value.abs(),
        };
        let pairs = self.course.iter().zip(&coarse.course);
        let apart: Vec<f64> = pairs.map(|(a, b)| (a - b).abs()).collect();
        [(value - coarse.of(statistic)).abs() / size, mean(&apart) / range.max(SMALL * size)]
    }
}

/// The numbers of the first ones that move.
pub(super) fn moving<'s>(signals: &'s [Signal<'_>], most: usize) -> impl Iterator<Item = usize> + 's {
    let all = 0..signals.len();
    all.filter(|&k| signals[k].moves()).take(most)
}

/// Of those that become criteria, `most` of them, the one that a finer step changes most, where that is notable.
fn changed(coarse: &[Signal<'_>], finer: &[Signal<'_>], most: usize) -> Option<usize> {
    let change = |k: &usize| finer[*k].change_from(&coarse[*k]);
    let is_notable = |part: &f64| *part > SETTLED || part.is_nan();
    let notable = moving(finer, most).filter(|k| change(k).iter().any(is_notable));
    let sum = |k: &usize| change(k).iter().sum::<f64>();
    notable.max_by(|a, b| sum(a).total_cmp(&sum(b)))
}

/// What the FMU's variables do with a step that is short enough for those of them that become criteria, `most` of them;
/// and a sentence where the first step is not. `schedule` gets the step, unless `kept` or none is short enough.
pub(super) fn settled<'a>(
    isolated: &Isolated,
    (task, schedule): (Task, &mut Schedule),
    variables: &[&'a Variable],
    (most, kept): (usize, bool),
) -> Result<(Vec<Signal<'a>>, Option<String>), Error> {
    const HALVINGS: u32 = 6;
    /// So many values of a signal tell its course.
    const COURSE: u64 = 500;
    let until = Instant::now().checked_add(PATIENCE);
    let first_step = schedule.step;
    let every = schedule.steps().div_ceil(COURSE).max(1) as usize;
    let with = |step: f64| {
        let task = Task { schedule: Schedule { step, ..*schedule }, ..task.clone() };
        // The same messages again would tell nothing.
        let end = (until, step == first_step);
        let every = every * (first_step / step).round() as usize;
        signals(isolated, &task, variables, end, every)
    };
    let first = with(first_step)?;
    let (mut found, mut first_changed, mut is_short_enough) = (None, None, false);
    for _ in 0..HALVINGS {
        let (step, signals) = found.as_ref().map_or((first_step, &first), |(step, signals)| (*step, signals));
        // An FMU may refuse such a step, and what takes long is no first study.
        let step = 0.5 * step;
        let Ok(finer) = with(step) else { break };
        let Some(changed) = changed(signals, &finer, most) else {
            is_short_enough = true;
            break;
        };
        first_changed.get_or_insert(changed);
        found = Some((step, finer));
    }
    let (Some((step, signals)), Some(changed)) = (found, first_changed) else {
        return Ok((first, None));
    };
    let (finer, coarse) = (&signals[changed], &first[changed]);
    let ((statistic, value), [_, course]) = (finer.value(), finer.change_from(coarse));
    let unit = behind(finer.variable.unit());
    let told = format!(
        "a step of {first_step} s is too coarse: {} is {}{unit} with it, {}{unit} with {step} s, and in the mean {} % of its range apart on the way{}",
        finer.variable.name,
        digits(coarse.of(statistic), 4),
        digits(value, 4),
        digits(100.0 * course, 2),
        if is_short_enough { "" } else { ", and changes on: choose a step yourself" }
    );
    if kept || !is_short_enough {
        return Ok((first, Some(told)));
    }
    schedule.step = step;
    Ok((signals, Some(told)))
}

/// Runs the FMU once and looks at these variables, of which every so many values are kept.
fn signals<'a>(
    isolated: &Isolated,
    task: &Task,
    variables: &[&'a Variable],
    end: (Option<Instant>, bool),
    every: usize,
) -> Result<Vec<Signal<'a>>, Error> {
    let handles: Vec<Handle> = variables.iter().map(|variable| variable.handle()).collect();
    let mut signals: Vec<Signal<'_>> = variables.iter().map(|v| Signal::new(v)).collect();
    let middle = 0.5 * (task.schedule.start + task.schedule.stop);
    let (mut before, mut row) = (None, 0);
    isolated.observe(task, &handles, end, |time, values| {
        let elapsed = time - before.replace(time).unwrap_or(time);
        for (signal, value) in signals.iter_mut().zip(values) {
            let value = match value {
                Value::Real(value) => *value,
                Value::Integer(value) => *value as f64,
                Value::Boolean(_) | Value::String(_) => f64::NAN,
            };
            signal.add(elapsed, value, time > middle);
            if row % every == 0 {
                signal.course.push(value);
            }
        }
        row += 1;
    })?;
    Ok(signals)
}

/// What to do about a run that failed.
pub(super) fn advice(error: Error, options: &Init, fmu: &Description, step: f64) -> Error {
    match error {
        Error::Simulation(Failure::Timeout) => {
            let message = format!(
                "one run takes longer than {} s, which is too long for a first study: give an earlier end or a longer --step",
                PATIENCE.as_secs()
            );
            Error::option("stop", message)
        }
        other => {
            let ours = options.step.is_none() && fmu.default_experiment.step.is_none();
            of_step(other, ours.then_some(step))
        }
    }
}
