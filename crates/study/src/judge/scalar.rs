//! Criteria on single numbers: a measured value with its tolerance and its uncertainty, or a limit that stands alone.

use crate::{BOTH_SIDES, CriterionText, Name, Result, Study, ToleranceText, first_wrong, limit::gain};
use toml::Spanned;

use super::{criterion::Criterion, curve};
use conformity::{
    measured::Limits,
    uncertainty::{Distribution, Uncertainty},
};
use fmu_import::quantity::{Quantity, Scale, Sense};
use fmu_points::names::behind;
use sampling::statistics::Statistic;

/// The criterion on one number.
pub fn criterion(study: &Study, name: &Name, text: &CriterionText, scale: &Scale) -> Result<Criterion> {
    let at = |message| study.error_of(name, message);
    curve::refuse_keys(text).map_err(at)?;
    let alone = match (&text.at_most, &text.at_least) {
        (Some(most), _) => Some((most, "at most", Limits::at_most as fn(f64) -> Limits)),
        (None, Some(least)) => Some((least, "at least", Limits::at_least as fn(f64) -> Limits)),
        (None, None) => None,
    };
    check_keys(text, alone.is_some()).map_err(at)?;
    let statistic = text.statistic.unwrap_or_default();
    let sense = sense(statistic);
    let value = |quantity: &Quantity| scale.number(quantity, sense).map_err(at);
    let (limits, stated, measured) = match (alone, &text.nominal, &text.tolerance) {
        (Some((stated, words, limits)), ..) => {
            let limit = value(stated)?;
            if !limit.is_finite() {
                return Err(at(format!("the limit {stated} is not a finite number")));
            }
            let unit = match &stated.unit {
                Some(_) => String::new(),
                None => behind(scale.unit.as_deref()),
            };
            let words = format!("{words} {stated}{unit}");
            (limits(limit), words, text.measured.as_ref().unwrap_or(stated))
        }
        (None, Some(measured), Some(accuracy)) => {
            let nominal = value(measured)?;
            if !nominal.is_finite() {
                return Err(at(format!("the nominal value {measured} is not a finite number")));
            }
            let limits = within(nominal, accuracy, measured, scale).map_err(at)?;
            (limits, stated(accuracy, measured, scale), measured)
        }
        (None, None, _) => {
            return Err(at("the measured value is missing: add `nominal`, `reference` for a curve, or `at-most` or `at-least` for a \
                           limit alone".to_owned()));
        }
        (None, _, None) => {
            return Err(at("its tolerance is missing: add `tolerance`, such as \"0.5 %\"".to_owned()));
        }
    };
    let mut criterion = Criterion {
        name: name.as_ref().clone(),
        variable: text.variable.as_ref().clone(),
        statistic,
        detail: text.detail().map_err(at)?,
        unit: scale.unit.clone(),
        limits,
        nominal_from: text.nominal_from,
        stated_tolerance: stated,
        reading: text.measured.as_ref().map(value).transpose()?,
        uncertainty: uncertainty(study, name, text, measured, scale)?,
        derived_from: text.derived.as_ref().map(|derived| derived.from.as_ref().clone()),
        group: text.group.clone(),
        ..Criterion::default()
    };
    criterion.distance_unit = alone.is_some().then(|| distance_unit(&criterion));
    Ok(criterion)
}

/// In what a distance from a limit that stands alone counts: the expanded uncertainty, how far the measured value is inside,
/// or else the limit itself.
pub fn distance_unit(criterion: &Criterion) -> f64 {
    let measured = criterion.measured();
    let inside = measured.value.map(|value| criterion.limits.rest(value));
    measured.error.map(|error| error.expanded).or(inside.filter(|rest| *rest > 0.0)).unwrap_or(
        match criterion.limits.about {
            0.0 => 1.0,
            limit => limit.abs(),
        },
    )
}

fn check_keys(text: &CriterionText, is_alone: bool) -> Result<(), String> {
    first_wrong(&[
        (
            text.at_most.is_some() && text.at_least.is_some(),
            "`at-most` and `at-least` are limits that stand alone; for two limits a and b state nominal = (a + b) / 2 and tolerance = \
             (b - a) / 2",
        ),
        (
            is_alone && text.nominal.is_some(),
            "a limit takes the place of `nominal`; keep one of them; the measured value beside a limit is `measured`",
        ),
        (is_alone && text.tolerance.is_some(), "a limit takes the place of `tolerance`; keep one of them"),
        (
            !is_alone && text.measured.is_some(),
            "`measured` stands beside `at-most` or `at-least`; the measured value of a tolerance is `nominal`",
        ),
        (
            text.nominal_from.is_some() && text.nominal.is_none(),
            "`nominal-from` says where `nominal` comes from; add that, or remove `nominal-from`",
        ),
        (
            text.nominal_from.is_some()
                && (text.uncertainty.is_some()
                    || text.gain_uncertainty.is_some()
                    || text.noise.is_some()
                    || text.derived.is_some()),
            "a nominal value from the model has no error of a measurement; remove `nominal-from` once the measured value stands there",
        ),
    ])
}

/// Whether the numbers of a statistic are values, or differences of two, such as amplitudes: these have no offset when units
/// convert.
pub fn sense(statistic: Statistic) -> Sense {
    if statistic.is_difference() { Sense::Difference } else { Sense::Value }
}

/// A measured value with its tolerance, in the study's unit.
fn within(about: f64, stated: &ToleranceText, nominal: &Quantity, scale: &Scale) -> Result<Limits, String> {
    match stated {
        ToleranceText::Even(stated) => Ok(Limits::within(about, tolerance(stated, nominal, scale)?)),
        ToleranceText::Uneven { minus, plus } => {
            Ok(Limits { about, minus: tolerance(minus, nominal, scale)?, plus: tolerance(plus, nominal, scale)? })
        }
    }
}

/// A tolerance as people read it beside the nominal value in the study's unit.
fn stated(tolerance: &ToleranceText, nominal: &Quantity, scale: &Scale) -> String {
    let is_elsewhere = nominal.unit.is_some() && nominal.unit != scale.unit;
    let percent = |quantity: &Quantity| quantity.unit.as_deref() == Some("%");
    let of_nominal = match tolerance {
        ToleranceText::Even(even) => percent(even),
        ToleranceText::Uneven { minus, plus } => percent(minus) || percent(plus),
    };
    if is_elsewhere && of_nominal { format!("{tolerance} of {nominal}") } else { tolerance.to_string() }
}

/// A tolerance in the study's unit.
fn tolerance(quantity: &Quantity, nominal: &Quantity, scale: &Scale) -> Result<f64, String> {
    amount_of("the tolerance", quantity, nominal, scale)
}

/// A tolerance, or what is given like one, in the study's unit. Percents are of the nominal value as written: 0.75 % of 82 degC is
/// 0.615 degC.
fn amount_of(what: &str, quantity: &Quantity, nominal: &Quantity, scale: &Scale) -> Result<f64, String> {
    let amount = match quantity.unit.as_deref() {
        // "+0.5/-1", "-1 .. 0.5"
        Some(rest) if rest.starts_with(['/', '+', '-', '.', ',']) => {
            return Err(format!("{what} `{quantity}` cannot be used: {BOTH_SIDES}"));
        }
        Some("%") => scale.part(quantity.number / 100.0, nominal)?,
        _ => scale.number(quantity, Sense::Difference)?,
    };
    if amount > 0.0 && amount.is_finite() {
        Ok(amount)
    } else if nominal.number == 0.0 && quantity.number > 0.0 && quantity.number.is_finite() {
        Err(format!("{what} {quantity} of the nominal value 0 is nothing; give it without %"))
    } else {
        Err(format!("{what} {quantity} must be a positive, finite number"))
    }
}

fn is_rectangular(text: &CriterionText) -> bool {
    text.uncertainty_distribution == Some(Distribution::Rectangular)
}

fn check_coverage(study: &Study, text: &CriterionText) -> Result {
    let Some(coverage) = &text.coverage else { return Ok(()) };
    first_wrong(&[
        (
            text.uncertainty.is_none() && text.gain_uncertainty.is_none(),
            "coverage says how many standard uncertainties `uncertainty` is; add `uncertainty` or remove it",
        ),
        (
            is_rectangular(text),
            "a rectangular uncertainty is the half-width of its limits, which no coverage factor expands; remove `coverage`",
        ),
    ])
    .map_err(|message| study.error_at(coverage, message))
}

fn check_repeats(text: &CriterionText) -> Result<(), String> {
    first_wrong(&[
        (
            text.uncertainty_distribution.is_some() && text.uncertainty.is_none(),
            "`uncertainty-distribution` says how `uncertainty` is meant; add `uncertainty` or remove it",
        ),
        (
            text.repeats.is_some() && text.noise.is_none(),
            "`repeats` says of how many readings the measured value is the mean; add their standard deviation as `noise`, or \
             remove `repeats`",
        ),
        (
            text.repeats.is_some_and(|repeats| repeats < 2.0 || repeats.fract() != 0.0 || repeats > 1e9),
            "`repeats` must be a whole number, 2 or more, as a single reading tells no standard deviation; without `repeats` the \
             measured value is one reading, and `noise` is known",
        ),
    ])
}

/// The uncertainty of a criterion's measured value, in the criterion's unit.
fn uncertainty(
    study: &Study,
    name: &Name,
    text: &CriterionText,
    nominal: &Quantity,
    scale: &Scale,
) -> Result<Option<Uncertainty>> {
    check_coverage(study, text)?;
    check_repeats(text).map_err(|message| study.error_of(name, message))?;
    let named =
        |place: &Spanned<Quantity>, message: String| study.error_at(place, format!("{}: {message}", name.as_ref()));
    let amount = |stated: &Option<Spanned<Quantity>>, what: &str| {
        let stated = stated.as_ref();
        stated
            .map(|stated| amount_of(what, stated.as_ref(), nominal, scale).map_err(|message| named(stated, message)))
            .transpose()
    };
    let coverage = text.coverage.as_ref().map_or(Uncertainty::USUAL, |k| *k.as_ref());
    if !(coverage > 0.0 && coverage.is_finite()) {
        return Err(study.error_of(name, format!("the coverage factor {coverage} must be a positive, finite number")));
    }
    let offset = amount(&text.uncertainty, "the uncertainty")?;
    let gain = text.gain_uncertainty.as_ref().map(|stated| {
        let part = gain(stated.as_ref()).map_err(|message| study.error_at(stated, message))?;
        // Where it is not clear of which number it is a part, this says so.
        scale.part(part, nominal).map_err(|message| named(stated, message))?;
        Ok(part)
    });
    let gain = gain.transpose()?;
    let noise = amount(&text.noise, "the noise")?;
    if offset.is_none() && gain.is_none() && noise.is_none() {
        return Ok(None);
    }
    let offset = offset.unwrap_or(0.0);
    let offset =
        if is_rectangular(text) { Uncertainty::rectangular(offset) } else { Uncertainty::normal(offset, coverage) };
    let uncertainty = Uncertainty {
        gain: gain.unwrap_or(0.0) / coverage,
        noise: noise.unwrap_or(0.0),
        // A whole number within the type's range, as refused above otherwise.
        repeats: text.repeats.map(|repeats| repeats as u32),
        ..offset
    };
    let value = scale.number(nominal, sense(text.statistic.unwrap_or_default())).unwrap_or(f64::NAN);
    match &text.gain_uncertainty {
        Some(stated) if uncertainty.standard(value) == 0.0 => Err(study
            .error_at(stated, "a part of a measured value of 0 is no uncertainty; add `uncertainty`, the error there")),
        _ => Ok(Some(uncertainty)),
    }
}
