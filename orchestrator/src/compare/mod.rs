//! Two results of a study, point by point: what changed, by how much of the tolerance, and where.

mod document;
mod pairs;

use std::path::{Path, PathBuf};

use indexmap::IndexMap;
use serde::Serialize;

use crate::{
    error::Result,
    junit::{Test, TestOutcome},
    results::{
        self, Summary,
        summary::{CriterionCount, Provenance},
        table,
    },
};
use conformity::{conclusion::grouped, decision::Decision};
use pairs::Pairs;
use parameter_regions::table::{CriterionColumn, PointTable};
use result_document::{Figure, format::number};
use sampling::statistics::moments::{mean, quantile, sorted};
use study::judge::Criterion;

pub use document::write;

/// How a difference is told from what the computation itself leaves open. It stands here alone.
pub const RULE: &str = "A value has changed when it differs by more than rounding: 1e-9 of itself, or of its tolerance. The change \
    counts when it also exceeds the numerical uncertainty of a difference: twice the root of the sum of the squares of both \
    runs' standard uncertainties, as `verify --validation` states them. Where a run does not, only rounding is allowed for.";

/// Relative to a value or its tolerance, this is rounding.
const ROUNDING: f64 = 1e-9;

/// The coverage factor of a difference's expanded uncertainty.
const COVERAGE: f64 = 2.0;

/// A numerical uncertainty that has grown by more than this is a change of its own: it would explain what it brought.
const GROWN: f64 = 1.5;

/// One of the two results.
#[derive(Default, Serialize)]
pub struct Side {
    /// The folder.
    pub folder: PathBuf,
    /// The verdict.
    pub verdict: Option<Decision>,
    /// How many points there are.
    pub points: u64,
    /// How many have no result.
    pub failed: u64,
    /// How many are within all tolerances.
    pub verified: u64,
    /// How many are accepted, with the guard bands.
    pub accepted: Option<u64>,
    /// What was run.
    #[serde(flatten)]
    pub from: Provenance,
}

impl Side {
    fn new(folder: &Path, summary: &Summary) -> Self {
        let conclusion = summary.conclusion.as_ref();
        Self {
            folder: folder.to_owned(),
            verdict: conclusion.map(|conclusion| conclusion.verdict),
            points: summary.points,
            failed: summary.failed,
            verified: summary.verified,
            accepted: conclusion.map(|conclusion| conclusion.accepted),
            from: summary.provenance.clone(),
        }
    }
}

/// Points of a kind: how many, and the first ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Points {
    /// How many.
    pub count: u64,
    /// The numbers of the first ones.
    pub first: Vec<u64>,
}

impl FromIterator<u64> for Points {
    fn from_iter<T: IntoIterator<Item = u64>>(points: T) -> Self {
        const NAMED: usize = 20;
        let mut first = Vec::from_iter(points);
        let count = first.len() as u64;
        first.truncate(NAMED);
        Self { count, first }
    }
}

/// The change of a criterion's values.
#[derive(Serialize)]
pub struct Change {
    /// The unit.
    pub unit: Option<String>,
    /// Points with a value in both results.
    pub compared: u64,
    /// The expanded numerical uncertainty of a difference, in the unit; none where a run does not state its own.
    pub numerical_uncertainty: Option<f64>,
    /// Points at which the value has changed by more than rounding.
    pub changed: u64,
    /// Points at which the change exceeds the numerical uncertainty, too.
    pub beyond: u64,
    /// The mean of new less old.
    pub mean: f64,
    /// The largest change.
    pub largest: Option<Largest>,
    /// Points that meet the criterion in one of the results alone, although that is within the numerical uncertainty.
    pub flipped_within: Points,
    /// The same beyond it.
    pub flipped: Points,
    /// The new values over the old ones.
    #[serde(skip)]
    pub figure: Figure,
    /// Where the points lie that changed sides, or, where these are few, changed most.
    pub place: Option<String>,
}

/// The largest change of a criterion's values.
#[derive(Clone, Copy, Serialize)]
pub struct Largest {
    /// The point.
    pub point: u64,
    /// Its value before.
    pub old: f64,
    /// Its value now.
    pub new: f64,
    /// The difference as a share of the tolerance.
    pub of_tolerance: f64,
}

/// The comparison of two results.
#[derive(Default, Serialize)]
pub struct Comparison {
    /// Whether nothing differs: the same verdict, counts that fit, each point has its partner, and none changed sides.
    pub same: bool,
    /// The differences in words.
    pub differences: Vec<String>,
    /// What else changed: values within their tolerances, and the study.
    pub warnings: Vec<String>,
    /// The result before.
    pub old: Side,
    /// The result now.
    pub new: Side,
    /// Whether the new result's FMU carries the old one, and is otherwise the FMU that it was packed into.
    pub as_packed: bool,
    /// How a difference is told from rounding and numerical uncertainty.
    pub rule: &'static str,
    /// Points of both results with the same parameters.
    pub pairs: u64,
    /// Points of the old result alone.
    pub only_old: Points,
    /// Points of the new result alone.
    pub only_new: Points,
    /// Points with other parameters.
    pub other_parameters: Points,
    /// Points that had a result and have none.
    pub lost: Points,
    /// Points that had none and have one.
    pub gained: Points,
    /// Points that meet all criteria in one of the results alone, beyond the numerical uncertainty.
    pub flipped: Points,
    /// By criterion, of those that both results have.
    pub criteria: IndexMap<String, Change>,
}

/// Whether two numbers differ by no more than rounding; `scale` is a length that matters.
fn is_rounding(old: f64, new: f64, scale: f64) -> bool {
    let size = old.abs().max(new.abs());
    let size = if scale.is_finite() { size.max(scale) } else { size };
    old.to_bits() == new.to_bits() || (new - old).abs() <= ROUNDING * size
}

/// Compares the results in two folders.
///
/// # Errors
/// When one of them holds no finished study, or a damaged one.
pub fn compare(old: &Path, new: &Path) -> Result<Comparison> {
    let before = table::read(old)?;
    let now = table::read(new)?;
    Ok(between([old, new], [&before, &now]))
}

fn between([old, new]: [&Path; 2], [before, now]: [&(Summary, PointTable); 2]) -> Comparison {
    let pairs = Pairs::new(&before.1, &now.1);
    let [only_old, only_new, other_parameters] =
        [&pairs.only_old, &pairs.only_new, &pairs.other_parameters].map(|points| points.iter().copied().collect());
    let mut told = Comparison {
        old: Side::new(old, &before.0),
        new: Side::new(new, &now.0),
        rule: RULE,
        pairs: pairs.both.len() as u64,
        only_old,
        only_new,
        other_parameters,
        ..Comparison::default()
    };
    let completed = |[i, j]: [usize; 2]| [before.1.completed(i), now.1.completed(j)];
    let with = |wanted: [bool; 2]| {
        pairs.both.iter().filter(|pair| completed(**pair) == wanted).map(|[i, _]| before.1.ids[*i]).collect()
    };
    (told.lost, told.gained) = (with([true, false]), with([false, true]));
    let mut really = vec![false; pairs.both.len()];
    for (k, (name, was)) in before.0.criteria.iter().enumerate() {
        let Some((l, _, is)) = now.0.criteria.get_full(name) else { continue };
        if was.criterion.unit != is.criterion.unit || was.criterion.source() != is.criterion.source() {
            continue;
        }
        let judged = Judged {
            name,
            criteria: [&was.criterion, &is.criterion],
            columns: [&before.1.criteria[k], &now.1.criteria[l]],
            uncertainty: uncertainty(name, [&before.0, &now.0]),
        };
        told.criteria.insert(name.clone(), judged.change(&before.1, &pairs, &mut really));
    }
    let flipped = pairs.both.iter().zip(&really).filter(|([i, j], really)| {
        let verified = [before.1.verified[*i], now.1.verified[*j]];
        let lost = completed([*i, *j]);
        verified[0] != verified[1] && (**really || lost[0] != lost[1])
    });
    told.flipped = flipped.map(|([i, _], _)| before.1.ids[*i]).collect();
    told.conclude([&before.0, &now.0]);
    if told.old.accepted != told.new.accepted && !told.explains_counts() {
        let [old, new] = [&told.old, &told.new].map(|side| side.accepted.unwrap_or(0));
        told.same = false;
        told.differences.push(format!("{old} points were accepted and {new} are"));
    }
    told
}

/// The standard numerical uncertainty that a result states of a criterion.
fn stated(name: &str, summary: &Summary) -> Option<f64> {
    summary.validation.get(name)?.u_num
}

/// The expanded uncertainty of a difference of a criterion's values from what both runs state.
fn uncertainty(name: &str, summaries: [&Summary; 2]) -> Option<f64> {
    let [old, new] = summaries.map(|summary| stated(name, summary));
    Some(COVERAGE * old?.hypot(new?)).filter(|u| u.is_finite())
}

/// A criterion that both results have.
struct Judged<'a> {
    name: &'a str,
    criteria: [&'a Criterion; 2],
    columns: [&'a CriterionColumn; 2],
    uncertainty: Option<f64>,
}

impl Judged<'_> {
    /// The change of the criterion; marks the pairs that it really moves to the other side.
    fn change(&self, table: &PointTable, pairs: &Pairs, really: &mut [bool]) -> Change {
        let ([was, is], [old, new]) = (self.criteria, self.columns);
        let room = was.room();
        let id = |pair: usize| table.ids[pairs.both[pair][0]];
        let values = |pair: usize| {
            let [i, j] = pairs.both[pair];
            [old.values[i], new.values[j]]
        };
        let ok = |pair: usize| {
            let [i, j] = pairs.both[pair];
            [old.ok[i], new.ok[j]]
        };
        let is_known = |pair: &usize| values(*pair).into_iter().all(f64::is_finite);
        let both: Vec<usize> = (0..pairs.both.len()).filter(is_known).collect();
        let difference = |pair: usize| {
            let [old, new] = values(pair);
            new - old
        };
        let is_changed = |pair: &usize| {
            let [old, new] = values(*pair);
            !is_rounding(old, new, room)
        };
        let changed: Vec<usize> = both.iter().copied().filter(is_changed).collect();
        let exceeds = |pair: &usize| difference(*pair).abs() > self.uncertainty.unwrap_or(0.0);
        let beyond: Vec<usize> = changed.iter().copied().filter(exceeds).collect();
        let flipped = both.iter().copied().filter(|&pair| {
            let [old, new] = ok(pair);
            old != new
        });
        // Another answer at the same value has no numerical reason.
        let is_same = |pair: &usize| {
            let [old, new] = values(*pair).map(f64::to_bits);
            old == new
        };
        let other_limits = was.limits != is.limits;
        let (flipped, within): (Vec<usize>, Vec<usize>) =
            flipped.partition(|pair| other_limits || is_same(pair) || (is_changed(pair) && exceeds(pair)));
        flipped.iter().for_each(|&pair| really[pair] = true);
        let largest =
            changed.iter().max_by(|a, b| difference(**a).abs().total_cmp(&difference(**b).abs())).map(|&pair| {
                let [old, new] = values(pair);
                Largest { point: id(pair), old, new, of_tolerance: difference(pair) / room }
            });
        let differences: Vec<f64> = both.iter().map(|&pair| difference(pair)).collect();
        let ids = |pairs: &[usize]| pairs.iter().map(|&pair| id(pair)).collect();
        Change {
            unit: was.unit.clone(),
            figure: document::scatter(self.name, self.criteria, both.iter().map(|pair| (values(*pair), ok(*pair)))),
            compared: both.len() as u64,
            numerical_uncertainty: self.uncertainty,
            changed: changed.len() as u64,
            beyond: beyond.len() as u64,
            mean: if differences.is_empty() { 0.0 } else { mean(&differences) },
            largest,
            place: (!beyond.is_empty()).then(|| place(table, pairs, &both, &flipped, &differences)).flatten(),
            flipped: ids(&flipped),
            flipped_within: ids(&within),
        }
    }
}

/// Where the points that changed sides lie among the parameters, or else the tenth with the largest changes.
fn place(table: &PointTable, pairs: &Pairs, both: &[usize], flipped: &[usize], differences: &[f64]) -> Option<String> {
    /// Fewer points show no region.
    const LEAST: usize = 5;
    let limit = quantile(&sorted(differences.iter().map(|difference| difference.abs()).collect()), 0.9);
    let points: Vec<(Vec<f64>, bool)> = both
        .iter()
        .zip(differences)
        .map(|(pair, difference)| {
            let is_chosen = match flipped.len() {
                LEAST.. => flipped.binary_search(pair).is_ok(),
                _ => difference.abs() >= limit && *difference != 0.0,
            };
            let parameters = table.parameters.iter().map(|parameter| parameter.values[pairs.both[*pair][0]]);
            (parameters.collect(), is_chosen)
        })
        .collect();
    let chosen = points.iter().filter(|(_, is_chosen)| *is_chosen).count();
    let named: Vec<_> = table
        .parameters
        .iter()
        .enumerate()
        .map(|(k, parameter)| (k, &*parameter.name, Some(&*parameter.unit).filter(|unit| !unit.is_empty())))
        .collect();
    (chosen.min(both.len() - chosen) >= LEAST).then(|| results::place(&named, &points))?
}

fn points(count: u64) -> String {
    format!("{} point{}", grouped(count), if count == 1 { "" } else { "s" })
}

fn said(verdict: Option<Decision>) -> String {
    verdict.map_or_else(|| "no verdict".to_owned(), |verdict| verdict.to_string())
}

impl Change {
    /// The change in words, where it counts.
    fn told(&self, name: &str) -> Option<String> {
        let largest = self.largest.filter(|_| self.beyond > 0)?;
        let share = number(100.0 * largest.of_tolerance.abs(), 3);
        let beyond = match self.numerical_uncertainty {
            Some(_) => "the numerical uncertainty",
            None => "rounding (no numerical uncertainty is stated)",
        };
        Some(format!(
            "{name} changed at {} beyond {beyond}, by up to {share} % of its tolerance (point {})",
            points(self.beyond),
            largest.point
        ))
    }
}

impl Comparison {
    /// The new result's verdict in words.
    pub fn verdict(&self) -> String {
        said(self.new.verdict)
    }

    /// Whether values that changed within the numerical uncertainty alone may have brought other counts.
    fn explains_counts(&self) -> bool {
        let criteria = || self.criteria.values();
        criteria().any(|change| change.changed > 0) && criteria().all(|change| change.beyond == 0)
    }

    /// Says in words what differs, and what else changed.
    fn conclude(&mut self, [before, now]: [&Summary; 2]) {
        let mut differences = Vec::new();
        if self.old.verdict != self.new.verdict {
            let [old, new] = [&self.old, &self.new].map(|side| said(side.verdict));
            differences.push(format!("The verdict was `{old}` and is `{new}`"));
        }
        let kinds = [
            (&self.only_old, "only in the old result"),
            (&self.only_new, "only in the new result"),
            (&self.other_parameters, "with other parameters"),
            (&self.lost, "without a result that had one"),
            (&self.gained, "with a result that had none"),
            (&self.flipped, "on the other side of the tolerances"),
        ];
        for (found, what) in kinds.into_iter().filter(|(found, _)| found.count > 0) {
            let first: Vec<String> = found.first.iter().take(5).map(u64::to_string).collect();
            let more = if found.count > 5 { ", ..." } else { "" };
            differences.push(format!("{} {what}: {}{more}", points(found.count), first.join(", ")));
        }
        for (these, others, side) in [(before, now, "old"), (now, before, "new")] {
            let missing = these.criteria.keys().filter(|name| !others.criteria.contains_key(*name));
            differences.extend(missing.map(|name| format!("The criterion {name} is only in the {side} result")));
        }
        for (name, was) in &before.criteria {
            let Some(is) = now.criteria.get(name) else { continue };
            let in_words = |count: &CriterionCount| {
                let unit = count.criterion.unit.as_ref();
                let unit = unit.map(|unit| format!(" in {unit}")).unwrap_or_default();
                count.criterion.source() + &unit
            };
            let (old, new) = (in_words(was), in_words(is));
            if old != new {
                differences
                    .push(format!("The criterion {name} was the {old} and is the {new}: its values are not compared"));
            } else if was.criterion.limits != is.criterion.limits {
                let [old, new] = [was, is].map(|count| count.criterion.wanted());
                self.warnings.push(format!("The criterion {name} was `{old}` and is `{new}`"));
            }
        }
        for name in self.criteria.keys() {
            let [old, new] = [before, now].map(|summary| stated(name, summary));
            let Some(old) = old.filter(|old| new.is_none_or(|new| new > GROWN * old)) else {
                continue;
            };
            let now = new.map_or_else(|| "not stated".to_owned(), |new| number(new, 4));
            self.warnings.push(format!(
                "The standard numerical uncertainty of {name} was {} and is {now}: the solution is coarser, or tells less",
                number(old, 4)
            ));
        }
        let changed = self.criteria.iter().filter_map(|(name, change)| change.told(name));
        self.warnings.extend(changed);
        self.same = differences.is_empty();
        self.differences = differences;
    }

    /// The comparison as tests: the verdict, the points, and a test a criterion. Changed values within the tolerances fail
    /// only where `strict`.
    pub fn tests(&self, strict: bool) -> Vec<Test> {
        let class = "compare";
        let verdicts = [&self.old, &self.new].map(|side| said(side.verdict));
        let [old, new] = &verdicts;
        let verdict = TestOutcome::of(old == new, || format!("was {old}, is {new}"));
        // The first difference is that of the verdicts, where there is one.
        let others = &self.differences[usize::from(old != new)..];
        let whole = TestOutcome::of(others.is_empty(), || others.join("; "));
        let criteria = self.criteria.iter().map(|(name, change)| {
            let flipped = change.flipped.count;
            let outcome = match change.told(name) {
                _ if flipped > 0 => TestOutcome::Failed(format!("{} changed sides", points(flipped))),
                Some(text) => TestOutcome::doubt(strict, text),
                None => TestOutcome::Passed,
            };
            Test::new(class, name, outcome)
        });
        let told: Vec<String> = self.criteria.iter().filter_map(|(name, change)| change.told(name)).collect();
        let rest: Vec<&str> = self.warnings.iter().filter(|text| !told.contains(text)).map(String::as_str).collect();
        let rest = (!rest.is_empty()).then(|| TestOutcome::doubt(strict, rest.join("; ")));
        let whole = [("verdict", Some(verdict)), ("points", Some(whole)), ("settings", rest)];
        let whole = whole.into_iter().filter_map(|(name, outcome)| Some(Test::new(class, name, outcome?)));
        whole.chain(criteria).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_relative_to_the_value_or_its_tolerance() {
        for (old, new, scale, expected) in [
            (1.0, 1.0 + 0.9e-9, 0.0, true),
            (1.0, 1.0 + 1.1e-9, 0.0, false),
            (0.0, 0.9e-9, 1.0, true),
            (0.0, 1.1e-9, 1.0, false),
            (0.0, 1e-300, 0.0, false),
            (1.0, 2.0, f64::INFINITY, false),
            (f64::MAX, f64::MAX, 1.0, true),
        ] {
            assert_eq!(is_rounding(old, new, scale), expected, "{old} {new} {scale}");
        }
    }
}
