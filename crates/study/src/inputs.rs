//! Inputs that follow a recording.

use super::{
    CaseText, CriterionText, Name, RecordingText, Study,
    limit::{gain, part},
    values::{find, slot_of},
};
use crate::{
    cases::SEPARATOR,
    concern::{Code, Concern},
};
use conformity::uncertainty::Uncertainty;
use fmu_import::{
    Causality, Content, Description, Variability, Variable,
    description::Interface,
    quantity::{Quantity, Scale, Sense},
    units::Conversion,
};
use fmu_points::task::{Probe, Schedule, SensorError, Series, Slot, place};
use number_tables::{Table, files::Result};
use sampling::statistics::moments::{quantile, sorted};

/// How the name of a sensor's zero error ends behind `/`, and its key in a study.
pub const OFFSET: &str = "offset";
/// The same of its gain error.
pub const GAIN: &str = "gain";

/// The recordings of a study for an FMU.
pub(super) struct Recordings {
    /// What the inputs follow.
    pub series: Vec<Series>,
    /// The errors of their sensors.
    pub errors: Vec<InputError>,
    /// Doubts about them.
    pub concerns: Vec<Concern>,
}

/// Reads the recordings of a study for an FMU.
pub(super) fn series(study: &Study, fmu: &Description, schedule: &Schedule) -> Result<Recordings> {
    let (mut errors, mut concerns) = (Vec::new(), Vec::new());
    let mut bind = |(name, recording): (&Name, &RecordingText)| {
        let wrong = |message| study.error_at(name, message);
        let key = name.as_ref().as_str();
        let named = |message| study.error_of(name, message);
        if schedule.leap {
            return Err(study.error_of(name, "leap would hold the input; remove one of them"));
        }
        let variable = find(fmu, key).map_err(wrong)?;
        let slot = slot_while_running(variable).map_err(named)?;
        if recording.ramp {
            can_ramp(recording, fmu, variable, &slot).map_err(named)?;
        }
        let path = study.path_of(recording.file.as_ref());
        let time = recording.time.as_deref().unwrap_or("time");
        let column = recording.column.as_deref().unwrap_or(key);
        let columns = vec![number_tables::column(column, format!("the input {key}"))];
        let mut table = Table::read_over_time(&path, recording.time.as_deref(), columns)
            .map_err(|error| study.error_at(&recording.file, error))?;
        let in_file = |message| named(format!("{}: {message}", path.display()));
        let unit = number_tables::agreed(column, table.units[1].as_deref(), recording.unit.as_deref());
        let scale = Scale::new(unit.map_err(in_file)?, fmu, variable).map_err(named)?;
        let [offset, gain] = known_errors(recording, &slot, &scale).map_err(named)?;
        table.rows.iter_mut().for_each(|row| row[1] = (row[1] - offset) / (1.0 + gain));
        let mut series = follow(&table, time, slot, scale.conversion).map_err(in_file)?;
        series.hold = recording.hold || is_discrete(variable, &series.slot);
        series.ramp = !series.hold && (recording.ramp || is_integrated(variable, fmu));
        series.each_row = takes_any_step(fmu);
        if recording.extrapolate.is_none() {
            let remedy = format!("extrapolate = \"hold\" in [inputs.\"{key}\"]");
            covers(&series, schedule, ["start = ", "stop = ", &remedy]).map_err(in_file)?;
        }
        concerns.extend(doubts(&series, schedule, &scale));
        errors.extend(InputError::all(name, (recording, [offset, gain]), &series.slot, &scale).map_err(named)?);
        Ok(series)
    };
    let series: Vec<Series> = study.inputs.iter().map(&mut bind).collect::<Result<_, _>>()?;
    concerns.extend(many_steps(&series, schedule));
    Ok(Recordings { series, errors, concerns })
}

/// An unknown error of the sensor that recorded an input.
#[derive(Debug)]
pub struct InputError {
    /// The input in the study.
    pub key: Name,
    /// Its name among a point's values: `drive.u/offset`, after that of the case where another case has another sensor.
    pub name: String,
    /// The unit of its values.
    pub unit: Option<String>,
    /// Their standard deviation about 0, in that unit.
    pub spread: f64,
    /// From that unit to the FMU's.
    pub conversion: Conversion,
    /// Takes it off the recording.
    pub slot: Slot,
    /// What was taken off before: the known offset, in the recording's unit, and the known gain, a share.
    pub taken: [f64; 2],
    /// The numbers of the cases that have it: those in which the same is stated of the same input.
    pub cases: Vec<usize>,
}

impl InputError {
    /// The errors of one case's input that are stated.
    ///
    /// # Errors
    /// When one is no positive number in its unit, or the input has no real values.
    fn all(
        key: &Name,
        (recording, taken): (&RecordingText, [f64; 2]),
        slot: &Slot,
        scale: &Scale,
    ) -> Result<Vec<Self>, String> {
        let in_unit = |what: &str, stated: &Quantity| {
            let number = match stated.unit.as_deref() {
                Some("%") => None,
                _ => Some(scale.number(stated, Sense::Difference)?),
            };
            number
                .filter(|number| *number > 0.0 && number.is_finite())
                .ok_or_else(|| format!("the {what} {stated} must be a positive number in the input's unit"))
        };
        let mut all = Vec::new();
        let mut add = |name: &str, error, unit: Option<&str>, spread, conversion| {
            all.push(Self {
                key: key.clone(),
                name: format!("{}/{name}", key.as_ref()),
                unit: unit.map(str::to_owned),
                spread,
                conversion,
                slot: Slot { error: Some(error), ..slot.clone() },
                taken,
                cases: Vec::new(),
            });
        };
        let unit = scale.unit.as_deref();
        let differences = scale.conversion.of_differences();
        if let Some(stated) = &recording.uncertainty {
            let spread = in_unit("uncertainty", stated)? / Uncertainty::USUAL;
            add(OFFSET, SensorError::Offset, unit, spread, differences);
        }
        if let Some(stated) = &recording.gain_uncertainty {
            let spread = 100.0 * gain(stated)? / Uncertainty::USUAL;
            let error = SensorError::Gain { about: scale.conversion.value(0.0) };
            add(GAIN, error, Some("%"), spread, Conversion { factor: 0.01, offset: 0.0 });
        }
        if let Some(stated) = &recording.noise {
            let deviation = differences.value(in_unit("noise", stated)?).abs();
            add("noise", SensorError::Noise { deviation }, None, 1.0, Conversion::IDENTITY);
        }
        if all.is_empty() || slot.handle.content == Content::Real {
            Ok(all)
        } else {
            Err("only a real input has errors of a sensor; remove `uncertainty`, `gain-uncertainty` and `noise`"
                .to_owned())
        }
    }

    /// Whether a measured product has it and the model's has not: a statistic that is none of the factors', or noise.
    pub(super) fn is_missed(&self, text: &CriterionText, probe: &Probe) -> bool {
        let is_factor = text.derived.as_ref().is_some_and(|derived| derived.by.as_ref() == self.key.as_ref());
        is_factor && (self.is_noise() || probe.product.is_none())
    }

    /// Whether its values are numbers by which noise is drawn.
    pub fn is_noise(&self) -> bool {
        matches!(self.slot.error, Some(SensorError::Noise { .. }))
    }

    /// Whether it is the error of the same sensor with the same calibration.
    fn is_of(&self, other: &Self) -> bool {
        let stated = |error: &Self| (error.unit.clone(), error.spread, error.taken);
        self.slot == other.slot && stated(self) == stated(other)
    }

    /// Adds that of a case to those of the cases before.
    pub(super) fn join(mut self, all: &mut Vec<Self>, number: usize, case: Option<&CaseText>) {
        if let Some(same) = all.iter_mut().find(|known| known.is_of(&self)) {
            return same.cases.push(number);
        }
        if let Some(case) = case
            && all.iter().any(|known| known.slot == self.slot)
        {
            // Another sensor.
            self.name = format!("{}{SEPARATOR}{}", case.name.as_ref(), self.name);
        }
        self.cases.push(number);
        all.push(self);
    }

    /// The slots that a case takes it by.
    pub fn slot_of(&self, case: usize) -> Slot {
        Slot { idle: !self.cases.contains(&case), ..self.slot.clone() }
    }
}

/// A verdict whose points have none of a stated error.
pub fn taken_as_exact(error: &str, points: &str) -> Concern {
    Concern::new(Code::InputTakenAsExact, format!(
        "{error}: {points} take the recorded input as free of this error, though it is stated: no risk and no error bar has it"
    )).remedied("Take a design that draws its points, such as `sobol`; `identify` finds offsets and gains, too.")
}

/// The known offset, in the recording's unit, and gain of its sensor.
fn known_errors(recording: &RecordingText, slot: &Slot, scale: &Scale) -> Result<[f64; 2], String> {
    let is_real = slot.handle.content == Content::Real;
    let number = |stated: &Option<Quantity>, what, of: &dyn Fn(&Quantity) -> Option<f64>| match stated {
        None => Ok(0.0),
        Some(stated) => of(stated).filter(|number| is_real && number.is_finite()).ok_or_else(|| {
            format!(
                "the {what} {stated} must be {}",
                match what {
                    OFFSET => "a number in the unit of a real input",
                    _ => "a share of a real input such as `0.5 %`, above -100 %",
                }
            )
        }),
    };
    let in_unit = |stated: &Quantity| {
        scale.number(stated, Sense::Difference).ok().filter(|_| stated.unit.as_deref() != Some("%"))
    };
    Ok([
        number(&recording.offset, OFFSET, &in_unit)?,
        number(&recording.gain, GAIN, &|stated| part(stated).filter(|part| *part > -1.0))?,
    ])
}

/// Whether a recording covers a run. `words` are how to set start and stop, and how to let the ends hold.
///
/// # Errors
/// Says which part is missing, and the remedy.
pub fn covers(series: &Series, schedule: &Schedule, words: [&str; 3]) -> Result<(), String> {
    let Some([from, to]) = series.uncovered(schedule) else { return Ok(()) };
    let [first, last] = series.span();
    let Schedule { start, stop, .. } = *schedule;
    let [set_start, set_stop, hold] = words;
    let cut = match from == start {
        true if first < stop && first > start => format!("set {set_start}{first}, or "),
        false => format!("set {set_stop}{last}, or "),
        // Nothing is in common.
        true => "correct its times, which are in s, or ".to_owned(),
    };
    let end = if first > start { "first" } else { "last" };
    Err(format!(
        "the recording covers {first} s .. {last} s, the run goes from {start} s to {stop} s, so {from} s .. {to} s is missing; \
         record it, {cut}write {hold}, which keeps the {end} value"
    ))
}

/// Whether a variable has its values one after the other, with nothing in between: the mean of two numbers of gears is none.
pub fn is_discrete(variable: &Variable, slot: &Slot) -> bool {
    slot.handle.content != Content::Real || variable.variability == Variability::Discrete
}

/// Whether a variable is an input of rates that are integrated here. These are evaluated within a step, with the input's value
/// then: one that was held from the step's begin would be late by half a step.
pub fn is_integrated(variable: &Variable, fmu: &Description) -> bool {
    fmu.interface == Interface::ModelExchange
        && variable.causality == Causality::Input
        && variable.variability == Variability::Continuous
}

/// Whether the FMU can take a step to any time.
pub fn takes_any_step(fmu: &Description) -> bool {
    fmu.capabilities.can_handle_variable_communication_step_size
}

/// What an FMU gets otherwise than it was on the rig.
pub fn doubts(series: &Series, schedule: &Schedule, scale: &Scale) -> impl Iterator<Item = Concern> + use<> {
    missed(series, schedule, scale).into_iter().chain(hole(series, schedule))
}

/// Warns of a hole in a recording, over which the input is a straight line that nobody measured. Few rows are the corners of a
/// line that somebody drew.
fn hole(series: &Series, schedule: &Schedule) -> Option<Concern> {
    const FEWEST: usize = 20;
    const USUAL: f64 = 10.0;
    const SHARE: f64 = 0.1;
    let Schedule { start, stop, .. } = *schedule;
    let gaps = || series.times.windows(2).map(|ends| [ends[0], ends[1]]);
    let lengths = gaps().map(|[from, to]| to - from);
    let usual = quantile(&sorted(lengths.filter(|&length| length > 0.0).collect()), 0.5);
    let share = |[from, to]: [f64; 2]| (to.min(stop) - from.max(start)) / (stop - start);
    let [from, to] = gaps()
        .filter(|&[from, to]| to - from > USUAL * usual && share([from, to]) >= SHARE)
        .max_by(|a, b| share(*a).total_cmp(&share(*b)))
        .filter(|_| series.times.len() >= FEWEST && !series.hold)?;
    let name = &series.slot.name;
    Some(Concern::new(Code::Hole, format!(
        "{name}: the recording has no rows between {from} s and {to} s, {:.0} % of the run (elsewhere they are {} s apart), and \
         the FMU gets a straight line there",
        100.0 * share([from, to]),
        short(usual)
    )).remedied(format!("Record {name} without the hole, or cut the run so that it has none.")))
}

/// Warns of rows of a recording that an FMU of fixed steps cannot follow.
fn missed(series: &Series, schedule: &Schedule, scale: &Scale) -> Option<Concern> {
    let unseen = Some(series).filter(|series| !series.each_row).and_then(|series| series.unseen(schedule))?;
    let unit = scale.unit.as_deref().filter(|unit| *unit != "1").unwrap_or_default();
    let most = scale.conversion.inverse().difference(unseen.most).abs();
    let rows = match unseen.rows {
        1 => "1 row".to_owned(),
        rows => format!("{rows} rows"),
    };
    Some(Concern::new(Code::MissedRows, format!(
        "{}: the FMU gets another input than the recorded one at {rows} between communication points, by up to {} (at \
         {} s), since its steps have one size (no canHandleVariableCommunicationStepSize)",
        series.slot.name,
        format!("{} {unit}", short(most)).trim_end(),
        short(unseen.at),
    )).remedied("Make `step` under [simulation] a divisor of the recording's step."))
}

/// Tells of recordings that make the steps many more than the study asks for.
pub fn many_steps(inputs: &[Series], schedule: &Schedule) -> Option<Concern> {
    const MANY: u64 = 2;
    let more = place(&mut inputs.to_vec(), schedule).len() as u64;
    let steps = schedule.steps();
    (more >= MANY * steps).then(|| {
        Concern::new(Code::ManySteps, format!(
            "the recorded inputs have {more} rows between the communication points, and each takes a step of its own: {} \
             steps rather than {steps}",
            more + steps
        )).remedied("Smooth and thin recorded inputs whose rows are noise.")
    })
}

/// Four significant digits.
fn short(number: f64) -> String {
    let rounded: f64 = format!("{number:.3e}").parse().unwrap_or(number);
    rounded.to_string()
}

/// How a variable takes numbers between the steps of a simulation.
///
/// # Errors
/// When it can only be set before, or not at all: FMI 2.0.5, 4.2.4, lets inputs and tunable parameters change.
pub fn slot_while_running(variable: &Variable) -> Result<Slot, String> {
    let slot = slot_of(variable)?;
    let tunable = variable.variability == Variability::Tunable;
    match variable.causality {
        Causality::Input => Ok(slot),
        Causality::Parameter if tunable => Ok(slot),
        Causality::Parameter => {
            Err("it is a fixed parameter, which cannot change while the simulation runs; set it once, before the start"
                .to_owned())
        }
        _ => Err("it is no input, so it can only be set once, before the start".to_owned()),
    }
}

/// An input that follows a table of times and values, along straight lines; `time_column` names the times in messages.
///
/// # Errors
/// When the times do not grow, or the FMU does not allow a value.
pub fn follow(table: &Table, time_column: &str, slot: Slot, conversion: Conversion) -> Result<Series, String> {
    let [mut times, mut values] = [Vec::new(), Vec::new()];
    for row in &table.rows {
        let (time, value) = (row[0], conversion.value(row[1]));
        let after = times.last().is_none_or(|&last| time >= last);
        if !(time.is_finite() && after) {
            return Err(format!("{time_column} = {time} is not later than the time before"));
        }
        let is_whole = slot.handle.content == Content::Real || value.fract() == 0.0;
        let whole = is_whole
            .then_some(())
            .ok_or_else(|| format!("{value} is no whole number, and the input takes no others; correct the recording"));
        slot.check(value).and(whole).map_err(|message| format!("{time_column} = {time}: {message}"))?;
        times.push(time);
        values.push(value);
    }
    Ok(Series { slot, hold: false, ramp: false, each_row: false, times, values })
}

/// Whether an input can vary within a step.
fn can_ramp(recording: &RecordingText, fmu: &Description, variable: &Variable, slot: &Slot) -> Result<(), String> {
    let why = if recording.hold {
        "hold keeps the value between rows"
    } else if slot.handle.content != Content::Real {
        "the variable is not a Real"
    } else if is_discrete(variable, slot) {
        "the variable is discrete"
    } else if !fmu.capabilities.can_interpolate_inputs {
        "the FMU does not interpolate inputs (canInterpolateInputs)"
    } else {
        return Ok(());
    };
    Err(format!("ramp = true, but {why}; remove ramp"))
}
