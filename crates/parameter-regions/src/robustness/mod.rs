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
pub mod stand;

use crate::table::PointTable;
use evidence::Evidence;
use region::{Region, Sample};
use serde::{Deserialize, Serialize};
use stand::{Quality, Stand};

/// A study's robustness.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
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
    /// Whether there is such a box, as far as it is known.
    #[serde(default)]
    pub answer: answer::BoxAnswer,
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
/// points where the distributions are not known. Surrogates are fitted to the points `fitted`: to those of the table, which are a
/// sample of the study's space, and to chosen ones where there are any. `None` where the points are too few, or nothing varies.
pub fn robustness(table: &PointTable, fitted: &PointTable, cloud: &[Vec<f64>], level: f64) -> Option<Robustness> {
    let varying: Vec<usize> =
        (0..table.parameters.len()).filter(|&k| table.parameters[k].values.windows(2).any(|w| w[0] != w[1])).collect();
    let only = |table: &PointTable| PointTable {
        parameters: varying.iter().map(|&k| table.parameters[k].clone()).collect(),
        ..table.clone()
    };
    let stand = Stand::fit(&only(fitted))?;
    let table = &only(table);
    let inputs = rows(table);
    let best = table.ranking().first()?.point;
    let places = |x: &Vec<f64>| varying.iter().map(|&k| x[k]).collect();
    let cloud: Vec<Vec<f64>> = cloud.iter().map(places).collect();
    let verdicts: Vec<f64> = stand.probabilities(&cloud);
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
    let mut result = Robustness {
        parameters: table.parameters.iter().map(|p| p.name.clone()).collect(),
        units: table.parameters.iter().map(|p| p.unit.clone()).collect(),
        criteria: stand.criteria.iter().map(|c| c.name.clone()).zip(stand.qualities.iter().copied()).collect(),
        maps: maps::maps(table, &stand, &inputs),
        level,
        answer: answer::BoxAnswer::default(),
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
    result.warnings.extend(unseen_failures(table, &inputs, result.region.as_ref()));
    result.warnings.extend(result.criteria.iter().filter_map(rough));
    result.answer = answer::BoxAnswer::new(&result, &stand, &cloud, &verdicts, &table.verified);
    result.warnings.extend(result.answer.warning(level));
    Some(result)
}

/// Warns of a surrogate that tells little.
fn rough((name, quality): &(String, Quality)) -> Option<String> {
    (quality.predicted < TRUSTED).then(|| {
        format!(
            "the surrogate of {name} predicts only {:.0} % of its variance: maps and margins that depend on it are rough; use more points",
            100.0 * quality.predicted.max(0.0)
        )
    })
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
         a model that has values everywhere. What is stated of the box counts failed points as not verified",
        failed.len(),
        table.len(),
    ))
}

/// Searches until the lower limit of what is stated is no less than the level: where it is less, the search asks for so
/// much more. Where no search comes to that, the first region whose probability alone is no less. It is checked against the
/// study's own points.
fn firm(level: f64, search: impl Fn(f64, Option<&Region>) -> Option<Region>, evidence: &Evidence) -> Option<Region> {
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
