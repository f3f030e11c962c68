//! Which points agree with the measurement.

mod curve;
mod derived;
mod product;
mod requirements;
mod scalar;

pub use requirements::share;

use crate::{Detail, NominalFrom, Result, Study, concern::Concern, plan::find};
use std::{collections::HashSet, ops::Range};

use serde::{Deserialize, Serialize};
use toml::Spanned;

use conformity::{
    decision::Rule,
    measured::{Assessed, Limits, Measured, Measurement},
    risk::Guard,
    uncertainty::Uncertainty,
};
use curves::{Kind, Metric};
use fmu_import::{Description, Variable};
use fmu_points::{
    failure::Failure,
    names::{behind, did_you_mean, nearest},
};
use sampling::statistics::{Statistic, moments::length};

pub use scalar::sense;

/// Measured value of one quantity with its tolerance, in the study's unit.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Criterion {
    /// Its name.
    pub name: String,
    /// The FMU's variable.
    pub variable: String,
    /// Statistic that turns the signal into one number.
    pub statistic: Statistic,
    /// The number that the statistic needs, where it needs one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<Detail>,
    /// The level of an event with its unit, as the study gives it, and the way in which the signal comes to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<String>,
    /// How a whole curve is compared, in place of a statistic. The value is 0 or 1 then for equal curves, and so is the
    /// measured value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub metric: Option<Metric>,
    /// The unit of the numbers.
    pub unit: Option<String>,
    /// The limits, in the unit: a measured value with its accuracy, or a limit that stands alone.
    #[serde(flatten)]
    pub limits: Limits,
    /// Where the nominal value comes from, where that is no measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_from: Option<NominalFrom>,
    /// The accuracy or the limit as the study states it.
    pub stated_tolerance: String,
    /// The measured value beside a limit that stands alone.
    #[serde(rename = "measured", skip_serializing_if = "Option::is_none")]
    pub reading: Option<f64>,
    /// Of a limit that stands alone: in units of this it counts how far a value is beyond it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_unit: Option<f64>,
    /// The uncertainty of the measured value, where the study states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<Uncertainty>,
    /// The criterion from whose measured value this one's is derived.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub derived_from: Option<String>,
    /// The correlation of the errors of any two rows of the measured curve, where it has an uncertainty. The risk is that over
    /// draws of the curve then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row_correlation: Option<f64>,
    /// The group in which it is counted.
    pub group: Option<String>,
}

impl Criterion {
    /// The limits with the measured value and its error.
    pub fn measured(&self) -> Measured {
        let limits = self.limits;
        let is_nominal = !limits.is_one_sided() && self.nominal_from.is_none();
        let value = Some(limits.about).filter(|_| is_nominal).or(self.reading);
        // Without a reading it is a gauge's error at the limit that counts.
        let at = value.unwrap_or(limits.about);
        let error = self.uncertainty.map(|u| u.law(at));
        Measured { limits, value, error }
    }

    /// How far a value is from the measured one, in tolerances of its side: 1 at a limit. At a limit that stands alone it
    /// is 1, too, and 0 one [unit](Self::room) inside and beyond.
    pub fn deviation(&self, value: f64) -> f64 {
        let deviation = self.level(value);
        if deviation < 0.0 { 0.0 } else { deviation }
    }

    /// The same without an end inside of a limit that stands alone: below 0 it still tells how far inside a value is.
    pub fn level(&self, value: f64) -> f64 {
        let away = value - self.limits.about;
        match self.distance_unit {
            Some(unit) => 1.0 - self.limits.rest(value) / unit,
            None if away < 0.0 => -away / self.limits.minus,
            None => away / self.limits.plus,
        }
    }

    /// Half the width of the limits; of one that stands alone the unit of its distance.
    pub fn room(&self) -> f64 {
        self.distance_unit.unwrap_or(0.5 * self.limits.width())
    }

    /// The value with the [deviation](Self::deviation) 0: the measured one.
    pub fn target(&self) -> f64 {
        let inwards = if self.limits.minus.is_infinite() { -1.0 } else { 1.0 };
        self.limits.about + inwards * self.distance_unit.unwrap_or(0.0)
    }

    /// The limits in words: `82 degC +-0.75 %`, `at most 85 degC`.
    pub fn wanted(&self) -> String {
        let Limits { about, minus, plus } = self.limits;
        let (stated, unit) = (&self.stated_tolerance, self.unit_behind());
        // Written out, 1e300 takes 300 digits.
        let is_short = about == 0.0 || (1e-5..1e16).contains(&about.abs());
        let about = if is_short { about.to_string() } else { format!("{about:e}") };
        match self.metric {
            None if minus == plus => format!("{about}{unit} +-{stated}"),
            None if !self.limits.is_one_sided() => format!("{about}{unit} {stated}"),
            _ => stated.clone(),
        }
    }

    /// What the study allows, in its words: `tolerance 0.75 %`, `at most 85 degC`.
    pub fn allowed(&self) -> String {
        let word = if self.limits.is_one_sided() { "" } else { "tolerance " };
        format!("{word}{}", self.stated_tolerance)
    }

    /// The unit as it stands behind a number, with a blank.
    pub fn unit_behind(&self) -> String {
        behind(self.unit.as_deref())
    }

    /// Where its value comes from, such as "mean of sensor.loadForce".
    pub fn source(&self) -> String {
        let label = match (self.metric, self.detail) {
            (Some(metric), _) => metric.label().to_owned(),
            (None, Some(detail)) => detail.label(),
            (None, None) => self.statistic.label().to_owned(),
        };
        let level = self.level.as_deref();
        let level = level.map(|level| format!(", {level}")).unwrap_or_default();
        format!("{label} of {}{level}", self.variable)
    }

    /// The accepted interval as people read and see it: no error is negative, and no rating more than 1, but for rounding.
    pub fn accepted(&self) -> [f64; 2] {
        const ROUNDING: f64 = 1e-9;
        let [low, high] = self.limits.ends();
        match self.metric.map(Metric::kind) {
            Some(Kind::Rating) => [low, high.min(1.0 + ROUNDING)],
            Some(_) => [low.max(0.0), high],
            None => [low, high],
        }
    }

    /// Whether a value agrees with the measurement; the limits themselves do.
    pub fn accepts(&self, value: f64) -> bool {
        self.limits.accepts(value)
    }
}

/// A case with its criteria.
#[derive(Debug)]
pub struct JudgedCase {
    /// Its name.
    pub name: String,
    /// Whether it is judged as any other one, but never fitted.
    pub held_out: bool,
    /// The numbers of its criteria.
    pub members: Range<usize>,
}

/// All criteria of a study.
#[derive(Debug)]
pub struct Judge {
    /// The criteria in the order of the study.
    pub criteria: Vec<Criterion>,
    /// Groups with the numbers of their criteria, in the order of the study.
    pub groups: Vec<(String, Vec<usize>)>,
    /// The cases in the order of the study; empty where it has none.
    pub cases: Vec<JudgedCase>,
    /// The measured values with the joint distribution of their errors.
    pub measurement: Measurement,
    /// Criteria whose measured value is the product of others.
    derived: Vec<derived::Derived>,
    /// The rule for the model as a whole, where it is another than one point that meets all criteria.
    pub rule: Option<Rule>,
    /// How far the acceptance intervals are drawn in.
    pub guard: Guard,
    /// Warnings about a study that can be used all the same, each with its place.
    pub warnings: Vec<Concern>,
}

/// Whether a point agrees, criterion by criterion.
#[derive(Debug, Default)]
pub struct PointVerdict {
    /// A flag for each criterion.
    pub passed: Vec<bool>,
    /// How far it is within all tolerances, and how probably so, where that was asked for and the point has all values.
    pub together: Option<Assessed>,
}

impl PointVerdict {
    /// Whether the point agrees in everything.
    pub fn verified(&self) -> bool {
        !self.passed.is_empty() && self.passed.iter().all(|&passed| passed)
    }
}

impl Judge {
    /// The criteria of a study. With an FMU, units are converted by its definitions; without
    /// one, all numbers of a criterion must be in one unit.
    ///
    /// # Errors
    /// With line and column, when a number or a unit does not fit, and when there are no criteria.
    pub fn new(study: &Study, fmu: Option<&Description>) -> Result<Self> {
        if study.criteria.is_empty() {
            return Err(study.error(
                "no criteria: add at least one [criteria.NAME] with variable, nominal \
                           and tolerance",
            ));
        }
        check_columns(study)?;
        let mut judge = Self {
            criteria: Vec::new(),
            groups: Vec::new(),
            cases: cases(study),
            measurement: Measurement::default(),
            derived: Vec::new(),
            rule: None,
            guard: Guard::Given(0.0),
            warnings: Vec::new(),
        };
        for (name, text) in &study.criteria {
            let variable = fmu
                .map(|fmu| find(fmu, text.variable.as_ref()))
                .transpose()
                .map_err(|message| study.error_at(&text.variable, message))?;
            requirements::check_variable(study, text, variable)?;
            let scale = text.scale(fmu.zip(variable)).map_err(|message| study.error_of(name, message))?;
            let mut criterion = match text.reference {
                Some(_) => curve::criterion(study, name, text, &scale)?,
                None => scalar::criterion(study, name, text, &scale)?,
            };
            criterion.level = text.event(variable.and_then(Variable::unit));
            judge.add_to_group(criterion.group.as_deref());
            judge.criteria.push(criterion);
        }
        judge.derive(study, fmu)?;
        judge.add_requirements(study)?;
        Ok(judge)
    }

    fn add_to_group(&mut self, group: Option<&str>) {
        let number = self.criteria.len();
        let Some(group) = group else { return };
        match self.groups.iter_mut().find(|(name, _)| name == group) {
            Some((_, members)) => members.push(number),
            None => self.groups.push((group.to_owned(), vec![number])),
        }
    }

    /// The criteria's names.
    pub fn names(&self) -> impl Iterator<Item = &String> {
        self.criteria.iter().map(|criterion| &criterion.name)
    }

    fn number_of(&self, name: &Spanned<String>) -> Result<usize, String> {
        let name = name.as_ref();
        let mut names = self.names();
        names.position(|known| known == name).ok_or_else(|| {
            let suggestion = did_you_mean(nearest(name, self.names().map(String::as_str)));
            format!("there is no criterion `{name}`{suggestion}")
        })
    }

    /// Judges the values of one point; `None` is a point that failed.
    pub fn verdict(&self, values: Option<&[f64]>) -> PointVerdict {
        let value = |number: usize| values.and_then(|values| values.get(number));
        let passed = self
            .criteria
            .iter()
            .enumerate()
            .map(|(number, criterion)| value(number).is_some_and(|&v| criterion.accepts(v)));
        PointVerdict { passed: passed.collect(), together: None }
    }

    /// Judges what came of one point. Where the study has cases, a failed point still meets the criteria of the cases that
    /// have all their values; a case without a result meets none of its own.
    pub fn judged(&self, outcome: Result<&[f64], &Failure>) -> PointVerdict {
        let failure = match outcome {
            Ok(values) => return self.verdict(Some(values)),
            Err(failure) => failure,
        };
        let mut passed = vec![false; self.criteria.len()];
        for case in &self.cases {
            let values = case.members.clone().map(|k| failure.value(k));
            let Some(values) = values.collect::<Option<Vec<f64>>>() else { continue };
            for (k, value) in case.members.clone().zip(values) {
                passed[k] = self.criteria[k].accepts(value);
            }
        }
        PointVerdict { passed, together: None }
    }

    /// Whether a nominal value comes from the model itself, so that agreement verifies nothing.
    pub fn has_own_values(&self) -> bool {
        let mut criteria = self.criteria.iter();
        criteria.any(|criterion| criterion.nominal_from.is_some())
    }

    /// Whether a guard band decides which points are accepted.
    pub fn is_guarded(&self) -> bool {
        self.guard != Guard::Given(0.0)
    }

    /// Whether the conformance probability of a point is known.
    pub fn knows_conformance(&self) -> bool {
        !self.has_own_values() && (0..self.criteria.len()).all(|criterion| self.measurement.knows(criterion))
    }

    /// How far the values are from the measured ones: the root of the sum of the squared
    /// deviations, each relative to its tolerance. The point with the least distance is the nearest one.
    pub fn distance(&self, values: &[f64]) -> f64 {
        let pairs = self.criteria.iter().zip(values);
        // A number in any case: the summary has no way to write another one.
        length(pairs.map(|(criterion, &value)| criterion.deviation(value))).min(f64::MAX)
    }
}

/// The study's cases; their criteria follow one another.
fn cases(study: &Study) -> Vec<JudgedCase> {
    let mut first = 0;
    study
        .cases
        .iter()
        .enumerate()
        .map(|(number, case)| {
            let count = study.criteria.values().filter(|text| text.case == Some(number)).count();
            let members = first..first + count;
            first = members.end;
            JudgedCase { name: case.name.as_ref().clone(), held_out: case.held_out, members }
        })
        .collect()
}

/// Refuses criteria whose columns in `points.csv` could not be told apart from other ones.
fn check_columns(study: &Study) -> Result {
    const OWN: [&str; 5] = ["point", "verified", "accepted", "conformance", "status"];
    let parameters = study.parameters.keys().map(|name| name.as_ref().as_str());
    let mut columns: HashSet<String> = OWN.into_iter().chain(parameters).map(String::from).collect();
    for name in study.criteria.keys() {
        let text = name.as_ref();
        if text.trim().is_empty() || text.contains(char::is_control) {
            return Err(study.error_at(name, "a criterion needs a name of printable characters"));
        }
        for column in [text.clone(), format!("{text}.ok")] {
            if !columns.insert(column.clone()) {
                return Err(
                    study.error_at(name, format!("points.csv would have two columns `{column}`; rename the criterion"))
                );
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
