//! Number of points of a study, and correlations between its parameters.

use serde::Deserialize;
use toml::Spanned;

use super::{Pair, Shape, Study, StudyError};
use fmu_points::names::{did_you_mean, nearest};
use sampling::design::correlation::Correlation;

/// Points or levels that the design would ignore are an error: they were meant to do something.
pub(super) fn check(study: &Study) -> Result<(), StudyError> {
    #[derive(Deserialize)]
    struct Text {
        #[serde(default)]
        design: Count,
    }
    #[derive(Default, Deserialize)]
    struct Count {
        points: Option<Spanned<u64>>,
    }
    if !study.design.method.is_by_levels()
        && let Some(levels) = study.parameters.values().find_map(|p| p.levels.as_ref())
    {
        let message = "only a full factorial has levels; remove this, or set method = \"full-factorial\" in [design]";
        return Err(study.error_at(levels, message));
    }
    match study.section::<Text>()?.design.points {
        Some(points) if study.design.method.is_by_levels() => {
            let message = "the design has as many points as the levels make; remove `points`";
            Err(study.error_at(&points, message))
        }
        _ => Ok(()),
    }
}

/// Refuses a study whose points are all the same, which would make a share of them look certain.
///
/// # Errors
/// When no parameter varies.
pub fn varies(study: &Study) -> Result<(), StudyError> {
    let mut parameters = study.parameters.iter();
    if parameters.any(|(_, parameter)| parameter.distribution != Shape::Fixed) {
        return Ok(());
    }
    let message = "no parameter varies: all points would be the same; give at least one under \
                   [parameters] a distribution other than `fixed`";
    Err(match study.parameters.keys().next() {
        Some(name) => study.error_at(name, message),
        None => study.error_at(&study.fmu, message),
    })
}

/// The correlations of a study's parameters.
pub(super) fn correlation(study: &Study) -> Result<Option<Correlation>, StudyError> {
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for entry in &study.correlations {
        let Pair {
            between,
            coefficient,
            ..
        } = entry.as_ref();
        let [a, b] = between.each_ref().map(|name| {
            let parameter = study.parameters.get_full(name.as_ref().as_str());
            let (index, _, parameter) = parameter.ok_or_else(|| {
                let names = study.parameters.keys().map(|key| key.as_ref().as_str());
                let suggestion = did_you_mean(nearest(name.as_ref(), names));
                let message = format!("no parameter `{}`{suggestion}", name.as_ref());
                study.error_at(name, message)
            })?;
            if parameter.distribution == Shape::Fixed {
                return Err(study.error_at(name, format!("{} does not vary", name.as_ref())));
            }
            if parameter.distribution == Shape::Sample {
                let message = format!(
                    "{} comes from a sample, which has its correlations already; remove the pair",
                    name.as_ref()
                );
                return Err(study.error_at(name, message));
            }
            Ok(index)
        });
        let (a, b) = (a?, b?);
        let wrong = |message: &str| Err(study.error_at(entry, message));
        if a == b {
            return wrong("a parameter is not correlated with itself; name two");
        }
        if coefficient.is_nan() || coefficient.abs() >= 1.0 {
            return wrong("the coefficient must be more than -1 and less than 1");
        }
        if pairs
            .iter()
            .any(|&(x, y, _)| (x, y) == (a, b) || (x, y) == (b, a))
        {
            return wrong("the correlation of these two stands above already; keep one");
        }
        pairs.push((a, b, *coefficient));
    }
    let Some(first) = study.correlations.first() else {
        return Ok(None);
    };
    let correlation = Correlation::new(study.parameters.len(), &pairs);
    correlation
        .map(Some)
        .map_err(|message| study.error_at(first, message))
}
