//! How far a metric of curves may be from that of equal ones.

use super::{CriterionText, ToleranceText};
use curves::{Kind, Metric};
use fmu_import::quantity::{Quantity, Scale, Sense};

/// How much a corridor's share may fall short of all: less than one of any number of times.
const ALL: f64 = 1e-9;

/// The ideal value, how far away from it is accepted, and both in words.
pub fn limit(text: &CriterionText, metric: Metric, scale: &Scale) -> Result<(f64, f64, String), String> {
    let label = metric.label();
    let tolerance = text.tolerance.as_ref().map(ToleranceText::of_curve);
    match (metric.kind(), tolerance.transpose()?, &text.least) {
        (Kind::Error, Some(stated), _) => {
            let tolerance = error(stated, scale)?;
            Ok((0.0, tolerance, format!("{label} at most {stated}")))
        }
        (Kind::Relative, Some(stated), _) => {
            let tolerance = part(stated)
                .filter(|tolerance| *tolerance > 0.0)
                .ok_or_else(|| format!("the tolerance {stated} must be a positive share, such as \"5 %\""))?;
            Ok((0.0, tolerance, format!("{label} at most {stated}")))
        }
        (_, _, Some(stated)) => {
            let least = part(stated)
                .filter(|least| *least > 0.0 && *least <= 1.0)
                .ok_or_else(|| format!("`least` = {stated} must be more than 0 and at most 1, such as \"90 %\""))?;
            if least == 1.0 && metric == Metric::Iso18571 {
                return Err("only equal curves have a rating of 1; give `least` below 1".to_owned());
            }
            Ok((1.0, (1.0 - least).max(ALL), format!("{label} at least {stated}")))
        }
        _ => Err("the limit is missing".to_owned()),
    }
}

/// The largest error, in the criterion's unit.
pub fn error(stated: &Quantity, scale: &Scale) -> Result<f64, String> {
    if stated.unit.as_deref() == Some("%") {
        return Err(format!(
            "the tolerance {stated} of a curve is not a part of anything; give it with a unit, or use metric = \"nrmse\""
        ));
    }
    let tolerance = scale.number(stated, Sense::Difference)?;
    if tolerance > 0.0 && tolerance.is_finite() {
        Ok(tolerance)
    } else {
        Err(format!("the tolerance {stated} must be a positive, finite number"))
    }
}

/// A share, in percent or not.
pub fn part(stated: &Quantity) -> Option<f64> {
    let part = match stated.unit.as_deref() {
        None => stated.number,
        Some("%") => stated.number / 100.0,
        Some(_) => return None,
    };
    part.is_finite().then_some(part)
}

/// The expanded uncertainty of a gain, as a part of the value.
///
/// # Errors
/// When it is none, or may have been meant in per cent.
pub fn gain(stated: &Quantity) -> Result<f64, String> {
    let gain = part(stated).filter(|part| *part > 0.0);
    match gain {
        Some(part) if part >= 0.1 && stated.unit.is_none() => Err(format!(
            "the gain uncertainty {stated} would be {} % of the value; write \"{stated} %\" or \"{} %\"",
            100.0 * part,
            100.0 * part
        )),
        Some(part) => Ok(part),
        None => Err(format!("the gain uncertainty {stated} must be a positive part of the value, such as \"0.5 %\"")),
    }
}
