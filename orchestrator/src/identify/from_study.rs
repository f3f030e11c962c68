//! Ties a study to identification: its criteria are the data, but for those of cases that are held out.
//!
//! A criterion's measured value is data with its standard uncertainty. A measured curve is data at each of its times: so the
//! sum of squares has every sample, and tells parameters apart that one metric of the whole curve could not. Errors that values
//! share, such as the zero error and the gain of a sensor, are sources of the problem. Tolerances play no part: they say what
//! is accepted, not how well it was measured.

use indexmap::IndexMap;

use super::{
    bind::{Bound, BoundCurve, bare, check_effort},
    fitted::{FittedCurve, Value},
    late::Reading,
    offsets,
    shared::{Shared, Tied},
    unknowns::Unknowns,
};
use calibration::{
    problem::{Case, Free, Mixed, NotNormal, Population, Problem, Quantity, UncertainValue},
    text::digits,
};
use conformity::uncertainty;
use fmu_import::{Description, units::Conversion};
use fmu_points::{
    names::behind,
    task::{MeasuredCurve, Probe},
};
use number_tables::files::FileError;
use study::{
    CriterionText, Identification, Name, Result, Study,
    judge::{Criterion, Judge},
    plan::Plan,
};

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
    let tied = Tied::new(&judge);
    let mut gathering =
        Gathering { study: &fitted, bound, tied: &tied, shared: Shared::default(), lags: IndexMap::new() };
    let criteria = fitted.criteria.iter().zip(&judge.criteria);
    let probes = plan.placed_probes().zip(&plan.outputs);
    for (number, (((name, text), criterion), ((case, probe), conversion))) in criteria.zip(probes).enumerate() {
        gathering.add(&Datum { number, name, text, criterion, case, probe, conversion: *conversion })?;
    }
    let Gathering { mut bound, shared, .. } = gathering;
    bound.notes.append(&mut assumed);
    bound.notes.extend(as_normal(&fitted, &judge, &plan));
    let populations = bound.problem.populations.iter();
    let populations: Vec<String> =
        populations.map(|population| told(population, &bound.problem, settings.posterior.is_some())).collect();
    bound.notes.extend(populations);
    (bound.problem.sources, bound.problem.channels) = (shared.sources, shared.channels);
    Ok(bound)
}

/// Where the mean and the spread of a population are told, and what was known of them before.
fn told(population: &Population, problem: &Problem, is_sampled: bool) -> String {
    let first = &problem.free[population.members[0]];
    let prior = digits(first.spread(population.scale(problem)));
    format!(
        "{name} differs from specimen to specimen. Above, each is fitted alone; their common mean and spread {where_told}. There the \
         mean has the parameter's own distribution, and the spread is half-normal with {prior}{unit}, before the measurement.",
        name = population.name,
        where_told = if is_sampled { "stand below, in the sample" } else { "come with --posterior N" },
        unit = behind(first.unit.as_deref()),
    )
}

/// A criterion whose measured value or curve is data.
struct Datum<'a> {
    /// Its number among the criteria.
    number: usize,
    name: &'a Name,
    text: &'a CriterionText,
    criterion: &'a Criterion,
    /// The number of its case.
    case: usize,
    probe: &'a Probe,
    /// From the FMU's unit.
    conversion: Conversion,
}

/// The data of a study as they are gathered.
struct Gathering<'a> {
    study: &'a Study,
    bound: Bound,
    tied: &'a Tied,
    shared: Shared,
    /// The unknown lags by name: their numbers among the free parameters, and their ranges.
    lags: IndexMap<String, (usize, [f64; 2])>,
}

impl Gathering<'_> {
    fn add(&mut self, datum: &Datum) -> Result {
        let values = match datum.probe.measure.curve() {
            Some(curve) => self.add_curve(datum, curve)?,
            None => vec![self.add_value(datum)?],
        };
        let problem = &mut self.bound.problem;
        for (name, measured) in values {
            problem.quantities.push(Quantity { name, unit: datum.criterion.unit.clone() });
            problem.cases[0].measured.push(measured);
        }
        Ok(())
    }

    fn add_curve(&mut self, datum: &Datum, curve: &MeasuredCurve) -> Result<Vec<Value>> {
        let lags = self.lags(datum)?;
        let Self { study, bound, .. } = self;
        let Datum { name, text, case, .. } = *datum;
        let unit = &datum.criterion.unit;
        let first = bound.problem.quantities.len();
        bound.curves.push(BoundCurve {
            name: name.as_ref().clone(),
            unit: unit.clone(),
            quantities: first..first + curve.times.len(),
            times: curve.times.clone(),
        });
        let curve = FittedCurve { name, unit, curve, first };
        let own = curve.own(&mut bound.notes);
        bound.problem.estimates.extend(curve.estimate(text));
        self.shared.add(&curve, study.sensor(name, text));
        let task = &mut bound.simulations[case].task;
        let samples = own.and_then(|own| curve.samples((datum.probe, &task.schedule), &own, lags, bound.outputs.len()));
        let (values, (probes, readings)) = samples.map_err(|message| study.error_of(name, message))?;
        bound.readings.extend(readings);
        // They come in the criterion's unit.
        bound.outputs.extend(probes.iter().map(|_| Conversion::IDENTITY));
        task.observed.extend(probes);
        Ok(values)
    }

    /// The lags of a curve: that of its case and its own.
    fn lags(&mut self, datum: &Datum) -> Result<(Vec<usize>, [f64; 2])> {
        let Self { study, bound, lags: known, .. } = self;
        let Datum { name, text, .. } = *datum;
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
            let (number, _) = *known.entry(lag.clone()).or_insert_with(|| {
                bound.lags.push(lag.clone());
                bound.problem.free.push(Free::linear(lag, Some("s".to_owned()), ends));
                (new, ends)
            });
            numbers.push(number);
            range = [range[0] + ends[0], range[1] + ends[1]];
        }
        Ok((numbers, range))
    }

    fn add_value(&mut self, datum: &Datum) -> Result<Value> {
        let Self { study, bound, tied, shared, .. } = self;
        let Datum { number, name, criterion, probe, conversion, .. } = *datum;
        let quantity = bound.problem.quantities.len();
        let uncertainty = criterion.uncertainty.ok_or_else(|| without_uncertainty(study, name, datum.text))?;
        let (accuracy, law) = tied.value(number, quantity, criterion, &uncertainty, shared);
        bound.problem.not_normal.extend(law.map(|law| NotNormal { case: 0, quantity, law }));
        let value = criterion.measured().value.ok_or_else(|| {
            study.error_of(
                name,
                "a limit that stands alone is no measured value to fit; add `measured`, or put the criterion \
                                  into a case that is held out",
            )
        })?;
        let is_difference = probe.measure.is_difference();
        bound.readings.push(Reading::Value(bound.outputs.len()));
        bound.outputs.push(if is_difference { conversion.of_differences() } else { conversion });
        bound.simulations[datum.case].task.observed.push(probe.clone());
        // What correlated values share is told as sources.
        if !tied.holds(number) {
            let parts = [uncertainty.offset(), uncertainty.gain * value].map(|part| (part / accuracy).powi(2));
            bound.problem.mixed.push(Mixed { case: 0, quantity, parts });
        }
        Ok((name.as_ref().clone(), UncertainValue { value, accuracy }))
    }
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
