//! How far the parameters may go: maps over pairs, the largest box and ellipsoid in which the model
//! stays verified, and the margins of every parameter alone.
//!
//! From existing points, by surrogates whose cross-validated errors are stated and taken into
//! account: a point counts as verified with the probability that its true criteria lie inside.

pub mod maps;
pub mod margins;
pub mod region;
pub mod surrogate;

use crate::analysis::table::{Criterion, PointTable};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};
use surrogate::{Quality, Surrogate};

/// A study's robustness.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Robustness {
    /// The parameters.
    pub parameters: Vec<String>,
    /// Their units.
    pub units: Vec<String>,
    /// The criteria with the quality of their surrogates.
    pub criteria: Vec<(String, Quality)>,
    /// Maps over all pairs of parameters.
    pub maps: Vec<maps::Map>,
    /// The verification probability that box and ellipsoid were asked to hold.
    pub level: f64,
    /// The largest box found; `None` where the level is reached nowhere.
    pub region: Option<region::Region>,
    /// The largest ellipsoid found.
    pub ellipsoid: Option<region::Ellipsoid>,
    /// One parameter at a time, from the best point.
    pub margins: Vec<margins::Margin>,
    /// What a careful reader should know.
    pub warnings: Vec<String>,
}

/// The model's stand-in: a surrogate a criterion.
pub struct Stand {
    criteria: Vec<(Criterion, Surrogate)>,
}

impl Stand {
    /// Fits all criteria; `None` where one of them cannot be.
    pub fn fit(table: &PointTable) -> Option<Self> {
        let inputs = rows(table);
        let fit = |c: &Criterion| {
            let bare = Criterion {
                values: vec![],
                ok: vec![],
                ..c.clone()
            };
            Some((bare, Surrogate::fit(&inputs, &c.values)?))
        };
        Some(Self {
            criteria: table.criteria.iter().map(fit).collect::<Option<_>>()?,
        })
    }

    /// The predicted value of a criterion.
    pub fn value(&self, criterion: usize, x: &[f64]) -> f64 {
        self.criteria[criterion].1.at(x)
    }

    /// The probability that all criteria are met at a point, given the surrogates' errors.
    pub fn probability(&self, x: &[f64]) -> f64 {
        let normal = Normal::standard();
        self.criteria
            .iter()
            .map(|(c, s)| {
                let (value, error) = (
                    s.at(x),
                    s.quality
                        .error
                        .max(1e-12 * c.nominal.abs())
                        .max(f64::MIN_POSITIVE),
                );
                normal.cdf((c.upper - value) / error) - normal.cdf((c.lower - value) / error)
            })
            .product()
    }
}

/// The parameters of every point.
pub fn rows(table: &PointTable) -> Vec<Vec<f64>> {
    (0..table.len())
        .map(|i| table.parameters.iter().map(|p| p.values[i]).collect())
        .collect()
}

/// Below this, a surrogate is not trusted without a warning.
const TRUSTED: f64 = 0.9;

/// Derives everything from the points of a study. `cloud` is a large sample of the same parameters
/// from their distributions, which the probabilities refer to; [`region::cloud`] makes one from the
/// points where the distributions are not known. `None` where the points are too few, or nothing varies.
pub fn robustness(table: &PointTable, cloud: &[Vec<f64>], level: f64) -> Option<Robustness> {
    let varying: Vec<usize> = (0..table.parameters.len())
        .filter(|&k| table.parameters[k].values.windows(2).any(|w| w[0] != w[1]))
        .collect();
    let table = &PointTable {
        parameters: varying
            .iter()
            .map(|&k| table.parameters[k].clone())
            .collect(),
        ..table.clone()
    };
    let stand = Stand::fit(table)?;
    let inputs = rows(table);
    let best = table.ranking().first()?.point;
    let cloud: Vec<Vec<f64>> = cloud
        .iter()
        .map(|x| varying.iter().map(|&k| x[k]).collect())
        .collect();
    let verdicts: Vec<f64> = cloud.iter().map(|x| stand.probability(x)).collect();
    let mut result = Robustness {
        parameters: table.parameters.iter().map(|p| p.name.clone()).collect(),
        units: table.parameters.iter().map(|p| p.unit.clone()).collect(),
        criteria: stand
            .criteria
            .iter()
            .map(|(c, s)| (c.name.clone(), s.quality))
            .collect(),
        maps: maps::maps(table, &stand, &inputs),
        level,
        region: region::largest_box(&cloud, &verdicts, level),
        ellipsoid: region::largest_ellipsoid(&cloud, &verdicts, level),
        margins: margins::margins(table, &stand, &inputs[best]),
        warnings: vec![],
    };
    if let Some(region) = &mut result.region {
        region.confirm(&inputs, &table.verified);
    }
    if let Some(ellipsoid) = &mut result.ellipsoid {
        ellipsoid.confirm(&inputs, &table.verified);
    }
    for (name, quality) in &result.criteria {
        if quality.predicted < TRUSTED {
            result.warnings.push(format!(
                "the surrogate of {name} predicts only {:.0} % of its variance: maps and margins that depend on it are rough; use more points",
                100.0 * quality.predicted.max(0.0)
            ));
        }
    }
    if result.region.is_none() {
        result.warnings.push(format!(
            "no box holds a verification probability of {level}: the criteria leave too little room"
        ));
    }
    Some(result)
}

#[cfg(test)]
mod tests;
