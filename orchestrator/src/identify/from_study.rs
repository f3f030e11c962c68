//! Ties a study to identification: its criteria are the data, but for those of cases that are held out.
//!
//! A criterion's measured value is data with its standard uncertainty. A measured curve is data at each of its times: so the
//! sum of squares has every sample, and tells parameters apart that one metric of the whole curve could not. Errors that values
//! share, such as the zero error and the gain of a sensor, are sources of the problem. Tolerances play no part: they say what
//! is accepted, not how well it was measured.

use indexmap::IndexMap;

use super::{
    bind::{Bound, BoundCurve, Input, REACH, bare, check_effort},
    late::{Read, Reading, late},
    offsets,
};
use calibration::{
    digits::rounded,
    problem::{
        Case, Channel, Effect, Estimate, Free, Measured, Mixed, NotNormal, Population, Prior, Quantity, SharedKind,
        Source, Spacing,
    },
    text::digits,
};
use conformity::uncertainty::{self, Law, Uncertainty};
use fmu_import::{Description, units::Conversion};
use fmu_points::{
    names::behind,
    task::{MeasuredCurve, Probe, Schedule, Slot},
};
use number_tables::files::FileError;
use rig_signals::scatter;
use sampling::distribution::Distribution;
use study::{
    CriterionText, EstimateText, Identification, Name, Result, Study,
    cases::SEPARATOR,
    judge::{Criterion, Judge},
    plan::{self, Plan},
};

/// The least independent part of an uncertainty that is otherwise shared: what no statement and no scatter tells, such as
/// rounding.
const LEAST: f64 = 0.05;
/// The unknowns and the data of a study: those of its cases, or of its criteria where it has no cases.
///
/// # Errors
/// When a criterion or a parameter does not say what identification needs, with its place and the remedy.
pub fn bind(study: &Study, settings: &Identification, fmu: &Description) -> Result<Bound> {
    check(study, settings)?;
    let mut fitted = study.fitted();
    if let (Some(first), true) = (study.cases.first(), fitted.cases.is_empty()) {
        return Err(study
            .error_at(&first.name, "every case is held out, so there is nothing to fit; remove `held-out` from one"));
    }
    for text in fitted.parameters.values_mut() {
        text.varies = None;
    }
    let plan = Plan::new(&fitted, fmu)?;
    plan.tell_of_inputs();
    let judge = Judge::new(&fitted, Some(fmu))?;
    let mut bound = Bound {
        simulations: plan.cases.iter().cloned().map(bare).collect(),
        known: vec![Vec::new()],
        ..Bound::default()
    };
    let names: Vec<&str> = fitted.cases.iter().map(|case| case.name.as_ref().as_str()).collect();
    bound.problem.cases.push(Case {
        label: if names.is_empty() { "1".to_owned() } else { names.join(", ") },
        latents: Vec::new(),
        measured: Vec::new(),
    });
    Unknowns { study, settings, fmu, plan: &plan }.bind(&mut bound)?;
    offsets::add(&fitted, &plan, &mut bound)?;
    let mut assumed = std::mem::take(&mut bound.notes);
    let criteria = fitted.criteria.iter().zip(&judge.criteria);
    let probes = plan.placed_probes().zip(&plan.outputs);
    let tied = Tied::new(&judge);
    let mut shared = Shared::default();
    let mut lags = Lags::default();
    for (number, (((name, text), criterion), ((case, probe), conversion))) in criteria.zip(probes).enumerate() {
        let first = bound.problem.quantities.len();
        if let Some(curve) = probe.measure.curve() {
            bound.curves.push(BoundCurve {
                name: name.as_ref().clone(),
                unit: criterion.unit.clone(),
                quantities: first..first + curve.times.len(),
                times: curve.times.clone(),
            });
        }
        let data = match probe.measure.curve() {
            Some(curve) => {
                let sensor = fitted.sensor(name, text);
                let curve = Recorded { name, unit: &criterion.unit, curve, first };
                let own = curve.own(&mut bound.notes);
                bound.problem.estimates.extend(curve.estimate(text));
                shared.add(&curve, sensor);
                let schedule = &bound.simulations[case].task.schedule.clone();
                let lags = lags.of(&fitted, name, text, &mut bound)?;
                let data = own.and_then(|own| curve.samples((probe, schedule), &own, lags, bound.outputs.len()));
                let (data, (probes, readings)) = data.map_err(|message| study.error_of(name, message))?;
                bound.readings.extend(readings);
                // They come in the criterion's unit.
                bound.outputs.extend(probes.iter().map(|_| Conversion::IDENTITY));
                bound.simulations[case].task.observed.extend(probes);
                data
            }
            None => {
                let uncertainty = criterion.uncertainty.ok_or_else(|| without_uncertainty(study, name, text))?;
                let (accuracy, law) = tied.value(number, first, criterion, &uncertainty, &mut shared);
                bound.problem.not_normal.extend(law.map(|law| NotNormal { case: 0, quantity: first, law }));
                let value = criterion.measured().value.ok_or_else(|| {
                    study.error_of(
                        name,
                        "a limit that stands alone is no measured value to fit; add `measured`, or put the criterion \
                                          into a case that is held out",
                    )
                })?;
                let difference = probe.measure.is_difference();
                bound.readings.push(Reading::Value(bound.outputs.len()));
                bound.outputs.push(if difference { conversion.of_differences() } else { *conversion });
                bound.simulations[case].task.observed.push(probe.clone());
                // What correlated values share is told as sources.
                if !tied.holds(number) {
                    let parts = [uncertainty.offset(), uncertainty.gain * value].map(|part| (part / accuracy).powi(2));
                    bound.problem.mixed.push(Mixed { case: 0, quantity: first, parts });
                }
                vec![(name.as_ref().clone(), Measured { value, accuracy })]
            }
        };
        for (name, measured) in data {
            let unit = criterion.unit.clone();
            bound.problem.quantities.push(Quantity { name, unit });
            bound.problem.cases[0].measured.push(measured);
        }
    }
    bound.notes.append(&mut assumed);
    bound.notes.extend(as_normal(&fitted, &judge, &plan));
    let populations = bound.problem.populations.iter();
    bound.notes.extend(populations.map(|population| {
        let first = &bound.problem.free[population.members[0]];
        let prior = digits(first.spread(population.scale(&bound.problem)));
        format!(
            "{name} differs from specimen to specimen. Above, each is fitted alone; their common mean and spread {where_told}. There the \
             mean has the parameter's own distribution, and the spread is half-normal with {prior}{unit}, before the measurement.",
            name = population.name,
            where_told = match settings.posterior {
                Some(_) => "stand below, in the sample",
                None => "come with --posterior N",
            },
            unit = behind(first.unit.as_deref()),
        )
    }));
    bound.problem.sources = shared.sources;
    bound.problem.channels = shared.channels;
    Ok(bound)
}

/// What is assumed of errors that are not normal: rectangular limits, and Student's of a mean of repeats.
fn as_normal(study: &Study, judge: &Judge, plan: &Plan) -> Option<String> {
    let of_curve = |probe: &Probe| {
        let errors = probe.measure.curve().and_then(|curve| curve.errors.as_ref());
        errors.is_some_and(|errors| errors.rectangular)
    };
    let of_value = |criterion: &Criterion| {
        criterion
            .uncertainty
            .is_some_and(|u| u.repeats.is_some() || u.distribution == uncertainty::Distribution::Rectangular)
    };
    let names: Vec<&str> = study
        .criteria
        .keys()
        .zip(&judge.criteria)
        .zip(plan.placed_probes())
        .filter(|((_, criterion), (_, probe))| of_curve(probe) || of_value(criterion))
        .map(|((name, _), _)| name.as_ref().as_str())
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "The table takes the errors of {} as normal, though they are rectangular, or known from few repeats: rectangular ones with \
             their standard deviation, means of repeats with as wide a 95 % interval as Student's, of several so wide that all hold \
             together. --posterior N takes them as they are.",
            names.join(", ")
        )
    })
}

/// The name of a measured number, and the number.
type Datum = (String, Measured);

/// The unknown lags as they are gathered: by name their numbers among the free parameters, and their ranges.
#[derive(Default)]
struct Lags {
    known: IndexMap<String, (usize, [f64; 2])>,
}

impl Lags {
    /// The lags of a curve: that of its case and its own.
    fn of(
        &mut self,
        study: &Study,
        name: &Name,
        text: &CriterionText,
        bound: &mut Bound,
    ) -> Result<(Vec<usize>, [f64; 2])> {
        let case = text.case.and_then(|case| study.cases.get(case));
        let of_case = case.and_then(|case| Some((&case.name, case.lag.as_ref()?)));
        let own = text.lag.as_ref().map(|lag| (name, lag));
        let mut lags = Vec::new();
        for (name, lag) in of_case.into_iter().chain(own) {
            let ends = lag.ends().map_err(|message| study.error_of(name, message))?;
            lags.push((format!("{}/lag", name.as_ref()), ends));
        }
        let (mut numbers, mut range) = (Vec::new(), [0.0; 2]);
        for (lag, ends) in lags {
            let new = bound.problem.free.len();
            let (number, _) = *self.known.entry(lag.clone()).or_insert_with(|| {
                bound.lags.push(lag.clone());
                bound.problem.free.push(Free {
                    name: lag,
                    unit: Some("s".to_owned()),
                    scale: Spacing::Linear,
                    min: ends[0],
                    max: ends[1],
                    prior: None,
                });
                (new, ends)
            });
            numbers.push(number);
            range = [range[0] + ends[0], range[1] + ends[1]];
        }
        Ok((numbers, range))
    }
}

/// Refuses other data beside the criteria.
fn check(study: &Study, settings: &Identification) -> Result {
    let advice = "the criteria of the study are the data of identify; remove";
    if let Some(table) = &settings.cases {
        return Err(study.error_at(table, format!("{advice} `cases` from [identify], or the criteria")));
    }
    let measured = settings.measured.keys().map(|name| (name, "measured"));
    let known = settings.known.keys().map(|name| (name, "known"));
    let latent = settings.latent.keys().map(|name| (name, "latent"));
    if let Some((name, section)) = measured.chain(known).chain(latent).next() {
        return Err(study.error_at(name, format!("{advice} [identify.{section}]")));
    }
    check_effort(study, settings)
}

fn without_uncertainty(study: &Study, name: &Name, text: &CriterionText) -> FileError {
    let stated = text.tolerance.as_ref().map(|tolerance| format!(" {tolerance}")).unwrap_or_default();
    study.error_of(name, format!(
        "identify weighs each measured value by its uncertainty: add `uncertainty`; the tolerance{stated} says what is \
         accepted, not how well it was measured"
    ))
}

/// A measured curve of a criterion, whose rows are values of the problem from the number `first` on.
struct Recorded<'a> {
    name: &'a Name,
    unit: &'a Option<String>,
    curve: &'a MeasuredCurve,
    first: usize,
}

impl Recorded<'_> {
    /// Whether the study states what its rows do not share.
    fn states_noise(&self) -> bool {
        let errors = self.curve.errors.as_ref();
        errors.is_some_and(|errors| errors.own.iter().any(|own| *own > 0.0))
    }

    /// The standard deviation of each row's own error. Where none is stated it is the recording's scatter, with a note.
    fn own(&self, notes: &mut Vec<String>) -> Result<Vec<f64>, String> {
        let Some(errors) = &self.curve.errors else {
            return Err("identify weighs each value of a curve by its uncertainty: add `uncertainty` and `noise` to the reference \
                           (one that is resampled to even times has none)".to_owned());
        };
        let combined = |(row, shared): (usize, &f64)| shared.hypot(errors.gain * self.curve.values[row]);
        let combined: Vec<f64> = errors.shared.iter().enumerate().map(combined).collect();
        let is_stated = self.states_noise();
        let scatter = scatter::scatter(&self.curve.values);
        let own: Vec<f64> = errors
            .own
            .iter()
            .zip(&combined)
            .map(
                |(own, combined)| {
                    if is_stated { *own } else { scatter.map_or(*combined, |scatter| scatter.max(LEAST * combined)) }
                },
            )
            .collect();
        if let Some(row) = own.iter().position(|own| *own <= 0.0) {
            return Err(format!("the uncertainty at {} s is {}; it must be positive", self.curve.times[row], own[row]));
        }
        if !is_stated {
            notes.push(self.assumed(scatter, &own));
        }
        Ok(own)
    }

    /// How well the noise is known that is not simply stated.
    fn estimate(&self, text: &CriterionText) -> Option<Estimate> {
        let reference = text.reference.as_ref()?;
        let rows = self.curve.values.len();
        let known = match &reference.noise_estimate {
            Some(stated) => *stated.as_ref(),
            None if self.states_noise() => return None,
            None => EstimateText { freedom: scatter::freedom(rows)?, correlation: 0.0, rows: 1.0 },
        };
        Some(Estimate {
            quantities: self.first..self.first + rows,
            freedom: known.freedom,
            correlation: known.correlation,
            rows: known.rows,
        })
    }

    /// The independent error that is assumed.
    fn assumed(&self, scatter: Option<f64>, own: &[f64]) -> String {
        let mean = (own.iter().map(|own| own * own).sum::<f64>() / own.len() as f64).sqrt();
        let number = format!("{}{}", rounded(mean, 3), behind(self.unit.as_deref()));
        let from = match scatter {
            Some(_) => "as the scatter of its rows",
            None => "as large as the uncertainty, since its rows are too few to show their scatter",
        };
        let name = self.name.as_ref();
        format!("{name} states no noise: taken {from}, noise = \"{number}\"")
    }

    /// A datum for each time, with the probes that read the model, of which the first has the number `first`, and how their
    /// readings become predictions.
    fn samples(
        &self,
        (probe, schedule): (&Probe, &Schedule),
        own: &[f64],
        lags: (Vec<usize>, [f64; 2]),
        first: usize,
    ) -> Result<(Vec<Datum>, Read), String> {
        let data = self.curve.times.iter().zip(&self.curve.values).zip(own).map(|((time, &value), &accuracy)| {
            // Without the rounding of times that were shifted by a delay.
            let time = (time * 1e9).round() / 1e9;
            (format!("{} at {time} s", self.name.as_ref()), Measured { value, accuracy })
        });
        let read = if lags.0.is_empty() {
            let probes = self.curve.shown_times().map(|time| probe.at_row(self.curve, time));
            let numbers = first..first + own.len();
            (probes.collect(), numbers.map(Reading::Value).collect())
        } else {
            late(probe, self.curve, schedule, lags, first)?
        };
        Ok((data.collect(), read))
    }
}

/// The shared errors as they are gathered.
#[derive(Default)]
struct Shared {
    sources: Vec<Source>,
    channels: Vec<Channel>,
    /// The sources of the sensors: of the offset and of the gain.
    sensors: IndexMap<(String, SharedKind), usize>,
}

impl Shared {
    /// Lists a channel's error. Where the same error of the same sensor is listed already, only the channel's name is added.
    fn tell(&mut self, channel: Channel) {
        match self.channels.iter_mut().find(|known| {
            known.kind == channel.kind
                && known.unit == channel.unit
                && known.sources == channel.sources
                && known.limit == channel.limit
        }) {
            Some(known) => known.name = format!("{} and {}", known.name, channel.name),
            None => self.channels.push(channel),
        }
    }

    /// The number of the source of a sensor's error.
    fn source(&mut self, sensor: String, kind: SharedKind) -> usize {
        *self.sensors.entry((sensor, kind)).or_insert_with(|| {
            self.sources.push(Source::default());
            self.sources.len() - 1
        })
    }

    /// Adds the offset and the gain of a curve's sensor.
    fn add(&mut self, recorded: &Recorded, (sensor, sign): (String, f64)) {
        let Some(errors) = &recorded.curve.errors else { return };
        let [of_offset, of_gain] = errors.coverage;
        let first = errors.shared.first().copied().unwrap_or(0.0);
        let even = errors.shared.iter().all(|shared| (shared - first).abs() <= 1e-9 * first);
        let (kind, one) = if even { (SharedKind::Offset, first) } else { (SharedKind::Scaled, of_offset.recip()) };
        // An uncertainty in per cent is a part of the value, as a gain's is.
        let values = recorded.curve.values.iter();
        let ratio = first / recorded.curve.values.first().copied().unwrap_or(1.0);
        let is_part = values
            .zip(&errors.shared)
            .all(|(value, shared)| *value > 0.0 && (shared - ratio * value).abs() <= 1e-9 * shared);
        let part_of = |kind| match kind {
            SharedKind::Gain => Some(errors.gain),
            SharedKind::Scaled if is_part => Some(ratio),
            _ => None,
        };
        let offset = errors.shared.clone();
        let gain = recorded.curve.values.iter().map(|value| errors.gain * value).collect();
        let parts =
            [(kind, offset, one, of_offset * one), (SharedKind::Gain, gain, errors.gain, of_gain * errors.gain)];
        for (kind, changes, one, limit) in parts {
            let changes: Vec<f64> = changes;
            if changes.iter().all(|change| *change == 0.0) {
                continue;
            }
            let source = self.source(sensor.clone(), kind);
            let channel = Channel {
                name: recorded.name.as_ref().clone(),
                kind,
                unit: recorded.unit.clone(),
                limit,
                sources: vec![(source, sign * one)],
            };
            let source = &mut self.sources[source];
            source.rectangular |= errors.rectangular && kind != SharedKind::Gain;
            let effects = changes.iter().enumerate().map(|(row, change)| Effect {
                case: 0,
                quantity: recorded.first + row,
                change: sign * change,
                part: part_of(kind).map(|part| sign * part),
            });
            source.effects.extend(effects);
            self.tell(channel);
        }
    }
}

/// The measured values whose errors are correlated: their numbers, and a factor of the matrix of correlations.
struct Tied {
    numbers: Vec<usize>,
    factor: Vec<Vec<f64>>,
    /// How many values are means of repeats.
    means: usize,
}

impl Tied {
    fn new(judge: &Judge) -> Self {
        let pairs = judge.measurement.correlations();
        let mut numbers: Vec<usize> = pairs.iter().flat_map(|&(a, b, _)| [a, b]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let place = |number: usize| numbers.binary_search(&number).expect("it is in a pair");
        let count = numbers.len();
        let mut matrix = vec![vec![0.0; count]; count];
        (0..count).for_each(|k| matrix[k][k] = 1.0);
        for &(a, b, coefficient) in pairs {
            let (a, b) = (place(a), place(b));
            (matrix[a][b], matrix[b][a]) = (coefficient, coefficient);
        }
        let factor = factor(&matrix);
        Self {
            means: judge.criteria.iter().filter_map(|criterion| criterion.uncertainty?.repeats).count(),
            numbers,
            factor,
        }
    }

    /// Whether the errors of a criterion are correlated with others'.
    fn holds(&self, number: usize) -> bool {
        self.numbers.binary_search(&number).is_ok()
    }

    /// The independent standard uncertainty of a value, number `quantity` of the problem, and its distribution where that is not
    /// normal. What it shares with others becomes sources.
    fn value(
        &self,
        number: usize,
        quantity: usize,
        criterion: &Criterion,
        uncertainty: &Uncertainty,
        shared: &mut Shared,
    ) -> (f64, Option<Law>) {
        let law = uncertainty.law(criterion.measured().value.unwrap_or(criterion.limits.about));
        let Ok(place) = self.numbers.binary_search(&number) else {
            let accuracy = law.among(self.means).as_normal();
            return (accuracy, Some(law).filter(|law| !law.is_normal()));
        };
        // A correlation is that of the whole errors, as for the verdict.
        let standard = law.among(self.means).as_normal();
        let mut sources = Vec::new();
        for (column, part) in self.factor[place].iter().enumerate().filter(|(_, part)| **part != 0.0) {
            let source = shared.source(format!("\0{column}"), SharedKind::Offset);
            let change = standard * part;
            shared.sources[source].effects.push(Effect { case: 0, quantity, change, part: None });
            sources.push((source, change));
        }
        shared.tell(Channel {
            name: criterion.name.clone(),
            kind: SharedKind::Offset,
            unit: criterion.unit.clone(),
            limit: uncertainty.coverage * standard,
            sources,
        });
        (LEAST * standard, None)
    }
}

/// The triangular factor `L` of a matrix of correlations `L L'`, also where errors are fully correlated (Cholesky).
fn factor(matrix: &[Vec<f64>]) -> Vec<Vec<f64>> {
    const NOTHING: f64 = 1e-9;
    let mut factor = vec![vec![0.0; matrix.len()]; matrix.len()];
    for column in 0..matrix.len() {
        let left = |row: usize, factor: &[Vec<f64>]| {
            let known = factor[row][..column].iter().zip(&factor[column][..column]);
            matrix[row][column] - known.map(|(a, b)| a * b).sum::<f64>()
        };
        let square = left(column, &factor);
        if square <= NOTHING {
            continue;
        }
        for row in column..matrix.len() {
            factor[row][column] = left(row, &factor) / square.sqrt();
        }
    }
    factor
}

/// The parameters of a study: those to be found, and those that are fixed.
struct Unknowns<'a> {
    study: &'a Study,
    settings: &'a Identification,
    fmu: &'a Description,
    plan: &'a Plan,
}

impl Unknowns<'_> {
    fn bind(&self, bound: &mut Bound) -> Result {
        let named = self.study.parameters.keys().zip(&self.plan.inputs).zip(&self.plan.slots);
        for ((name, input), slot) in named.clone() {
            if let (Distribution::Fixed { value }, false) = (&input.distribution, self.is_free(name)) {
                bound.known[0].push(input.conversion.value(*value));
                bound.vary(slot.clone());
            }
        }
        self.refuse_doubles()?;
        for (name, text) in &self.settings.free {
            let (free, input) = Input::free(self.study, self.fmu, name, text)?;
            self.add(bound, name, free, input.slot, input.scale.conversion)?;
        }
        for ((name, input), slot) in named {
            if self.is_free(name) || !input.distribution.varies() {
                continue;
            }
            if !self.settings.free.is_empty() {
                return Err(self.study.error_of(
                    name,
                    "varies under [parameters], but is not under [identify.free]; add it there, or give it the \
                               distribution `fixed`",
                ));
            }
            let free = prior(input, slot).map_err(|message| self.study.error_of(name, message))?;
            self.add(bound, name, free, slot.clone(), input.conversion)?;
        }
        if bound.problem.free.is_empty() {
            Err(self.study.error_near(
                "parameters",
                "identify needs at least one parameter: one that varies under [parameters], or [identify.free.NAME]",
            ))
        } else {
            Ok(())
        }
    }

    /// Whether a name stands under `[identify.free]`.
    fn is_free(&self, name: &Name) -> bool {
        self.settings.free.contains_key(name.as_ref().as_str())
    }

    /// Adds an unknown, or one for each case.
    fn add(&self, bound: &mut Bound, name: &Name, free: Free, slot: Slot, conversion: Conversion) -> Result {
        let text = self.study.parameters.get(name.as_ref().as_str());
        let Some(varies) = text.and_then(|text| text.varies.as_ref()) else {
            return bound.add_free(self.study, name, free, slot, conversion);
        };
        let cases: Vec<String> = bound.simulations.iter().filter_map(|case| case.name.clone()).collect();
        if cases.len() < 2 {
            return Err(self.study.error_at(
                varies,
                "one case that is fitted shows no spread from case to case; give more, or remove `varies`",
            ));
        }
        let first = bound.problem.free.len();
        for (number, case) in cases.iter().enumerate() {
            let of_case = Free { name: format!("{case}{SEPARATOR}{}", free.name), ..free.clone() };
            bound.add_free(self.study, name, of_case, slot.clone(), conversion)?;
            for (other, simulation) in bound.simulations.iter_mut().enumerate() {
                if let Some(slot) = simulation.task.varied.last_mut() {
                    slot.idle = other != number;
                }
            }
        }
        bound
            .problem
            .populations
            .push(Population { name: free.name, members: (first..bound.problem.free.len()).collect() });
        Ok(())
    }

    /// A parameter may be free too: then it is sought between other bounds than it is drawn from.
    fn refuse_doubles(&self) -> Result {
        for (_, study) in self.study.by_case() {
            let others = study.set().filter(|(name, section)| *section != "[parameters]" || !self.is_free(name));
            let names = self.settings.free.keys().map(|name| (name, "[identify.free]"));
            self.study.once(self.fmu, others.chain(names))?;
        }
        Ok(())
    }
}

/// A sampled parameter as an unknown: its distribution is what was known before.
fn prior(input: &plan::Input, slot: &Slot) -> Result<Free, String> {
    let reach = |mean: f64, deviation: f64| [-1.0, 1.0].map(|side| mean + side * REACH * deviation);
    let known = |centre, spread| Some(Prior { centre, spread });
    let ([low, high], prior) = match *input.distribution.continuous() {
        Distribution::Uniform { min, max } => ([min, max], None),
        Distribution::Normal { mean, deviation } => (reach(mean, deviation), known(mean, deviation)),
        Distribution::TruncatedNormal { mean, deviation, min, max } => {
            let [low, high] = reach(mean, deviation);
            let ends = [min.unwrap_or(low), max.unwrap_or(high)];
            (ends, known(mean, deviation))
        }
        _ => {
            return Err(
                "identify takes uniform and normal parameters as unknowns; give this one under [identify.free] with min, max \
                 and what is known of it"
                    .to_owned(),
            );
        }
    };
    // Within what the FMU allows, in the study's unit.
    let back = input.conversion.inverse();
    let allowed = |limit: Option<f64>, otherwise: f64| limit.map_or(otherwise, |x| back.value(x));
    let free = Free {
        name: input.name.clone(),
        unit: input.unit.clone(),
        scale: Spacing::Linear,
        min: low.max(allowed(slot.min, f64::NEG_INFINITY)),
        max: high.min(allowed(slot.max, f64::INFINITY)),
        prior,
    };
    free.check()?;
    Ok(free)
}
