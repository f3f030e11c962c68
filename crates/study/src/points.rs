//! Number of points of a study, and correlations between its parameters.

use crate::Result;
use toml::Spanned;

use super::{Name, Pair, Shape, Study};
use fmu_points::names::{did_you_mean, nearest};
use sampling::design::correlation::Correlation;

/// Refuses a study whose points are all the same, which would make a share of them look certain.
///
/// # Errors
/// When no parameter varies.
pub fn varies(study: &Study) -> Result {
    let mut parameters = study.parameters.iter();
    let is_uncertain = |study: &Study| study.inputs.values().any(|recording| recording.uncertainty.is_some());
    if parameters.any(|(_, parameter)| parameter.distribution != Shape::Fixed)
        || study.by_case().iter().any(|(_, study)| is_uncertain(study))
    {
        return Ok(());
    }
    let message = "no parameter varies: all points would be the same; give at least one under \
                   [parameters] a distribution other than `fixed`";
    Err(match study.parameters.keys().next() {
        Some(name) => study.error_at(name, message),
        None => study.error_at(&study.fmu, message),
    })
}

/// Pairs of entries by their places, with their coefficients.
pub type Pairs = Vec<(usize, usize, f64)>;

/// Reads correlations: `place` finds what a name stands for. `alone` says that nothing is correlated with itself, `limits` which
/// coefficients there are.
///
/// # Errors
/// At the pair or the name that does not fit.
pub fn pairs(
    study: &Study,
    entries: &[Spanned<Pair>],
    place: impl Fn(&Name) -> Result<usize>,
    alone: &str,
    limits: (impl Fn(f64) -> bool, &str),
) -> Result<Pairs> {
    let mut pairs = Pairs::new();
    for entry in entries {
        let Pair { between: [a, b], coefficient, .. } = entry.as_ref();
        let (a, b) = (place(a)?, place(b)?);
        let wrong = if a == b {
            alone
        } else if !limits.0(*coefficient) {
            limits.1
        } else if pairs.iter().any(|&(x, y, _)| (x, y) == (a, b) || (y, x) == (a, b)) {
            "the correlation of these two stands above already; keep one"
        } else {
            pairs.push((a, b, *coefficient));
            continue;
        };
        return Err(study.error_at(entry, wrong));
    }
    Ok(pairs)
}

/// The correlations of a study's parameters, the first ones among `count` values of a point.
pub(super) fn correlation(study: &Study, count: usize) -> Result<Option<Correlation>> {
    let pairs = pairs(
        study,
        &study.correlations,
        |name| {
            let parameter = study.parameters.get_full(name.as_ref().as_str());
            let (index, _, parameter) = parameter.ok_or_else(|| {
                let names = study.parameters.keys().map(|key| key.as_ref().as_str());
                let suggestion = did_you_mean(nearest(name.as_ref(), names));
                study.error_at(name, format!("no parameter `{}`{suggestion}", name.as_ref()))
            })?;
            let wrong = match parameter.distribution {
                Shape::Fixed => "does not vary",
                Shape::Sample => "comes from a sample, which has its correlations already; remove the pair",
                _ => return Ok(index),
            };
            Err(study.error_at(name, format!("{} {wrong}", name.as_ref())))
        },
        "a parameter is not correlated with itself; name two",
        (|coefficient: f64| coefficient.abs() < 1.0, "the coefficient must be more than -1 and less than 1"),
    )?;
    let Some(first) = study.correlations.first() else { return Ok(None) };
    Correlation::new(count, &pairs).map(Some).map_err(|message| study.error_at(first, message))
}
