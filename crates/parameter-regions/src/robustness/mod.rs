//! How far the parameters may go: maps over pairs, the largest box in which the model
//! stays verified, and the margins of every parameter alone.
//!
//! From existing points, by surrogates whose cross-validated errors are stated and taken into
//! account: a point counts as verified with the probability that its true criteria lie inside.

pub mod answer;
pub mod boxes;
pub mod evidence;
pub mod maps;
pub mod margins;
pub mod region;
pub mod surrogate;

use crate::table::{CriterionColumn, PointTable};
use evidence::Evidence;
use rayon::prelude::*;
use region::{Region, Sample};
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
    /// The verification probability that the box was asked to hold.
    pub level: f64,
    /// Runs beyond the study's points that the surrogates were refined with.
    #[serde(default)]
    pub further_runs: usize,
    /// Whether there is such a box, as far as it is known.
    #[serde(default)]
    pub answer: answer::Answer,
    /// The largest box found.
    pub region: Option<Region>,
    /// How far each parameter alone may move from the best point.
    pub margins: Vec<margins::Margin>,
    /// Caveats for the reader.
    pub warnings: Vec<String>,
}

impl Robustness {
    /// Takes away what moves parameters alone that come together from a sample: nothing is known beside its rows.
    pub fn keep_together(&mut self, names: &[&str]) {
        if names.is_empty() {
            return;
        }
        let bound = |name: &String| names.contains(&name.as_str());
        let parameters = &self.parameters;
        self.margins.retain(|margin| !bound(&margin.parameter));
        self.maps.retain(|map| !bound(&parameters[map.x]) && !bound(&parameters[map.y]));
        self.warnings.push(format!(
            "{} are drawn together from a sample: the box counts its rows; there are no maps and \
             no margins of these parameters, which would move one of them away from its row",
            names.join(", ")
        ));
    }

    /// Whether the statement of the box shows that it holds the level.
    pub fn shown(&self) -> bool {
        let region = self.region.as_ref();
        region.is_some_and(|region| region.interval[0] >= self.level)
    }
}

/// The model's stand-in: a surrogate a criterion.
pub struct Stand {
    criteria: Vec<Part>,
}

/// One criterion's surrogate.
struct Part {
    criterion: CriterionColumn,
    surrogate: Surrogate,
    /// Where the surrogate is of asinh((value - measured) / scale): true near the measurement and
    /// logarithmic far from it, where errors no longer matter; `None` where it is of the value.
    scale: Option<f64>,
    /// Root-mean-square error near the measurement, in the criterion's unit.
    quality: Quality,
    /// The surrogate's prediction at each point that it knows, fitted without it.
    left_out: Vec<f64>,
}

impl Part {
    /// Fits the value and its transform, and keeps what errs less near the measurement.
    fn fit(criterion: &CriterionColumn, inputs: &[Vec<f64>]) -> Option<Self> {
        let mut output = criterion.values.clone();
        let mut surrogate = Surrogate::fit(inputs, &output)?;
        let mut scale = None;
        let room = (criterion.upper - criterion.nominal).min(criterion.nominal - criterion.lower);
        let exact = surrogate.quality.predicted >= 1.0;
        if room.is_finite() && room > 0.0 && !exact {
            let values = criterion.values.iter();
            let bent = values.map(|v| ((v - criterion.nominal) / room).asinh());
            let bent: Vec<f64> = bent.collect();
            let better = |fit: &Surrogate| fit.quality.error * room < surrogate.quality.error;
            if let Some(fit) = Surrogate::fit(inputs, &bent).filter(better) {
                (surrogate, scale, output) = (fit, Some(room), bent);
            }
        }
        Some(Self {
            criterion: CriterionColumn { values: vec![], ok: vec![], ..criterion.clone() },
            scale,
            quality: Quality { error: surrogate.quality.error * scale.unwrap_or(1.0), ..surrogate.quality },
            left_out: surrogate.left_out(inputs, &output),
            surrogate,
        })
    }

    fn value(&self, x: &[f64]) -> f64 {
        let value = self.surrogate.at(x);
        // The transform is not to be trusted beyond what it has seen: sinh grows fast.
        self.scale.map_or(value, |scale| self.criterion.nominal + scale * value.clamp(-12.0, 12.0).sinh())
    }

    /// The probability that the criterion is met.
    fn probability(&self, x: &[f64]) -> f64 {
        self.probability_of(self.surrogate.at(x))
    }

    /// The probability that the criterion is met where the surrogate says so much.
    fn probability_of(&self, value: f64) -> f64 {
        let c = &self.criterion;
        let bend = |limit: f64| {
            let bent = |scale: f64| ((limit - c.nominal) / scale).asinh();
            self.scale.map_or(limit, bent)
        };
        let least = (1e-12 * c.nominal.abs()).max(f64::MIN_POSITIVE);
        let error = self.surrogate.quality.error.max(least);
        let normal = Normal::standard();
        normal.cdf((bend(c.upper) - value) / error) - normal.cdf((bend(c.lower) - value) / error)
    }
}

impl Stand {
    /// Fits all criteria; `None` where one of them cannot be.
    pub fn fit(table: &PointTable) -> Option<Self> {
        let inputs = rows(table);
        let parts = table.criteria.iter().map(|c| Part::fit(c, &inputs));
        Some(Self { criteria: parts.collect::<Option<_>>()? })
    }

    /// The predicted value of a criterion.
    pub fn value(&self, criterion: usize, x: &[f64]) -> f64 {
        self.criteria[criterion].value(x)
    }

    /// The name of the criterion with the least probability over some points.
    fn least_met<'a>(&self, points: impl Iterator<Item = &'a Vec<f64>>) -> String {
        let mut sums = vec![0.0; self.criteria.len()];
        for x in points {
            for (sum, part) in sums.iter_mut().zip(&self.criteria) {
                *sum += part.probability(x);
            }
        }
        let least = (0..sums.len()).min_by(|&a, &b| sums[a].total_cmp(&sums[b]));
        least.map_or_else(String::new, |k| self.criteria[k].criterion.name.clone())
    }

    /// The probability that all criteria are met at a point, given the surrogates' errors.
    pub fn probability(&self, x: &[f64]) -> f64 {
        let parts = self.criteria.iter();
        parts.map(|part| part.probability(x)).product()
    }

    /// The probability that all criteria are met at each of the first points that were fitted, by surrogates without it.
    fn foretold(&self, points: usize) -> Vec<f64> {
        let one = |i: usize| {
            let parts = self.criteria.iter();
            let each = parts.map(|part| part.probability_of(part.left_out[i]));
            each.product()
        };
        (0..points).map(one).collect()
    }
}

/// The parameters of every point.
pub fn rows(table: &PointTable) -> Vec<Vec<f64>> {
    (0..table.len()).map(|i| table.parameters.iter().map(|p| p.values[i]).collect()).collect()
}

/// One in so many places of the sample is searched, the others state what was found.
const SEARCHED: usize = 4;
/// Below this, a surrogate is not trusted without a warning.
const TRUSTED: f64 = 0.9;

/// Derives everything from the points of a study. `cloud` is a large sample of the same parameters
/// from their distributions, which the probabilities refer to; [`region::cloud`] makes one from the
/// points where the distributions are not known. `None` where the points are too few, or nothing varies.
pub fn robustness(table: &PointTable, cloud: &[Vec<f64>], level: f64) -> Option<Robustness> {
    refined(table, table, cloud, level)
}

/// The same with surrogates that are fitted to other points than those of the study: these and
/// further runs, where it matters.
pub fn refined(table: &PointTable, fitted: &PointTable, cloud: &[Vec<f64>], level: f64) -> Option<Robustness> {
    let varying: Vec<usize> =
        (0..table.parameters.len()).filter(|&k| table.parameters[k].values.windows(2).any(|w| w[0] != w[1])).collect();
    let parameter = |table: &PointTable, k: &usize| table.parameters[*k].clone();
    let only = |table: &PointTable| PointTable {
        parameters: varying.iter().map(|k| parameter(table, k)).collect(),
        ..table.clone()
    };
    let stand = Stand::fit(&only(fitted))?;
    let table = &only(table);
    let inputs = rows(table);
    let best = table.ranking().first()?.point;
    let places = |x: &Vec<f64>| varying.iter().map(|&k| x[k]).collect();
    let cloud: Vec<Vec<f64>> = cloud.iter().map(places).collect();
    let verdicts: Vec<f64> = cloud.par_iter().map(|x| stand.probability(x)).collect();
    // A part to search with, the rest to state what was found: a search flatters its own sample.
    let part = cloud.len() / SEARCHED;
    let sample = |range: std::ops::Range<usize>| Sample { points: &cloud[range.clone()], verdicts: &verdicts[range] };
    let seen = sample(0..part);
    let evidence = Evidence {
        unseen: sample(part..cloud.len()),
        points: &inputs,
        verified: &table.verified,
        foretold: &stand.foretold(table.len()),
    };
    let quality = |part: &Part| (part.criterion.name.clone(), part.quality);
    let mut result = Robustness {
        parameters: table.parameters.iter().map(|p| p.name.clone()).collect(),
        units: table.parameters.iter().map(|p| p.unit.clone()).collect(),
        criteria: stand.criteria.iter().map(quality).collect(),
        maps: maps::maps(table, &stand, &inputs),
        level,
        further_runs: fitted.len().saturating_sub(table.len()),
        answer: answer::Answer::default(),
        region: firm(
            level,
            |target, before| match before {
                None => boxes::largest_box(&seen, target),
                Some(before) => boxes::tightened(&seen, target, before),
            },
            &evidence,
        ),
        margins: margins::margins(table, &stand, &inputs[best]),
        warnings: vec![],
    };
    let failures = unseen_failures(table, &inputs, result.region.as_ref());
    result.warnings.extend(failures);
    for (name, quality) in &result.criteria {
        if quality.predicted < TRUSTED {
            result.warnings.push(format!(
                "the surrogate of {name} predicts only {:.0} % of its variance: maps and margins that depend on it are rough; use more points",
                100.0 * quality.predicted.max(0.0)
            ));
        }
    }
    result.answer = answer::Answer::new(&result, &stand, &cloud, &verdicts, &table.verified);
    result.warnings.extend(result.answer.warning(level));
    Some(result)
}

/// Warns of failed points: the surrogates are fitted to the others.
fn unseen_failures(table: &PointTable, inputs: &[Vec<f64>], region: Option<&Region>) -> Option<String> {
    let failed = (0..table.len()).filter(|&i| !table.completed(i));
    let failed: Vec<&Vec<f64>> = failed.map(|i| &inputs[i]).collect();
    if failed.is_empty() {
        return None;
    }
    let inside = region.map_or_else(String::new, |region| {
        let inside = failed.iter().filter(|x| region.contains(x)).count();
        format!("; {inside} of them lie in the box")
    });
    Some(format!(
        "{} of {} points failed{inside}. The surrogates do not know where the model fails: maps and margins are those of \
         a model that has values everywhere. What is stated of the box counts failed points as not verified, and so does --confirm",
        failed.len(),
        table.len(),
    ))
}

/// Searches until the lower limit of what is stated is no less than the level: where it is less, the search asks for so
/// much more. Where no search comes to that, the first region whose probability alone is no less. It is checked against the
/// study's own points.
fn firm(
    level: f64,
    search: impl Fn(f64, Option<&Region>) -> Option<Region>,
    evidence: &Evidence<'_>,
) -> Option<Region> {
    const TRIES: usize = 12;
    let (mut target, mut before, mut likely) = (level, None, None::<Region>);
    for _ in 0..TRIES {
        let Some(mut region) = search(target, before.as_ref()) else {
            break;
        };
        let statement = evidence.statement(|x| region.contains(x));
        region.note(statement);
        let is_firm = statement.interval[0] >= level;
        if is_firm || likely.is_none() && statement.probability >= level {
            likely = Some(region.clone());
        }
        if is_firm {
            break;
        }
        // Not a number where the other sample has no point inside: too small to be told.
        let missing = if statement.probability.is_finite() { level - statement.interval[0] } else { 1.0 };
        target = (target + 1.2 * missing).min(0.5 * (target + 1.0));
        before = Some(region);
    }
    let checked = |mut region: Region| {
        region.confirmed = region.confirm(evidence.points, evidence.verified);
        region
    };
    likely.map(checked)
}

#[cfg(test)]
mod tests;
