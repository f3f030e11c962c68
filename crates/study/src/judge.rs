//! Which points agree with the measurement.

mod criterion;
mod curve;
mod derived;
mod product;
mod requirements;
mod scalar;

pub use criterion::Criterion;
pub use requirements::share;

use crate::{Result, Study, concern::Concern, plan::find};
use std::{collections::HashSet, ops::Range};

use toml::Spanned;

use conformity::{
    decision::Rule,
    measured::{Assessed, Measurement},
    risk::Guard,
};
use fmu_import::{Description, Variable};
use fmu_points::{
    failure::Failure,
    names::{did_you_mean, nearest},
};
use sampling::statistics::moments::length;

pub use scalar::sense;

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
