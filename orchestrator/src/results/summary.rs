//! `summary.json`.

use std::{collections::BTreeMap, time::Instant};

use chrono::{SecondsFormat, Utc};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::{asides::Asides, by_surrogate::BySurrogate, settled::Settled};
use conformity::{
    conclusion::{Conclusion, Requirement},
    decision::Decision,
    measured::Measurement,
    risk::Risk,
    validation::Comparison,
};
use fmu_points::Conduct;
use study::{
    concern::{Concern, Severity},
    judge::{Criterion, Judge},
};

/// The content of `summary.json`.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Summary {
    /// The study's title.
    pub title: Option<String>,
    /// Who answers for the verdict, and on which test it rests, where the study says it.
    pub dossier: Option<IndexMap<String, String>>,
    /// Versions, seed and hashes: all that is needed to compute the same again.
    pub provenance: Provenance,
    /// How many points there are.
    pub points: u64,
    /// How many of them have no result.
    pub failed: u64,
    /// How many meet all criteria.
    pub verified: u64,
    /// The share of all points that meet all criteria.
    pub verified_fraction: f64,
    /// 95 % interval of the share; none of points that depend on each other.
    pub verified_interval: Option<[f64; 2]>,
    /// How all intervals were computed.
    #[serde(default)]
    pub interval_method: String,
    /// The verdict and the risks.
    #[serde(flatten)]
    pub conclusion: Option<Conclusion>,
    /// How many points conform, as expected from the measured values' uncertainties; none unless
    /// every criterion has one.
    pub expected_verified: Option<f64>,
    /// Which measured values' errors are correlated.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uncertainty_correlations: Vec<Correlated>,
    /// Counts by criterion.
    pub criteria: IndexMap<String, CriterionCount>,
    /// Counts by group of criteria: points that meet all of the group.
    pub groups: IndexMap<String, Count>,
    /// By case, where the study has any.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub cases: IndexMap<String, CaseCount>,
    /// How many points failed for which reason.
    pub failures: IndexMap<String, u64>,
    /// Failures whose reasons differ in their numbers alone, the most frequent first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub failure_kinds: Vec<FailureKind>,
    /// The uncertain parameters.
    pub parameters: Vec<ParameterSummary>,
    /// The point nearest to the measurement, among those that meet all criteria if any does.
    pub best_point: Option<BestPoint>,
    /// Doubts about the verdict.
    #[serde(default)]
    pub concerns: Vec<Concern>,
    /// Whether the results had settled when the runs ended.
    #[serde(rename = "rest", skip_serializing_if = "Option::is_none")]
    pub settled: Option<Settled>,
    /// The work that was left out because it would have taken too long or been too large: a sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_out: Option<String>,
    /// What would explain that the model is not verified, where that was sought: sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub causes: Vec<String>,
    /// How the model compares with the measurement, by criterion (ASME V&V 20); of two points with a result or more.
    #[serde(default)]
    pub validation: IndexMap<String, Comparison>,
    /// What a surrogate of few runs tells, where points were chosen by one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surrogate: Option<BySurrogate>,
    /// How the points were computed, and whether the FMU gave the same again.
    #[serde(flatten)]
    pub conduct: Option<Conduct>,
    /// The FMU's remarks beside its results.
    #[serde(flatten)]
    pub asides: Option<Asides>,
    /// How the computation went. All else is the same for every run of the study.
    pub run: Option<Run>,
}

/// Versions, seed and hashes: all that is needed to compute the same again.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// The version of this program.
    pub orchestrator: String,
    /// The study's file name.
    pub study: String,
    /// The SHA-256 digest of the study's text.
    pub study_sha256: String,
    /// The model's name.
    pub fmu: Option<String>,
    /// The version of the model.
    pub fmu_version: Option<String>,
    /// The identifier that ties the FMU's description to its binary.
    pub fmu_guid: Option<String>,
    /// The SHA-256 digest of the FMU.
    pub fmu_sha256: Option<String>,
    /// How points were chosen: a design's name, or `table`.
    pub method: String,
    /// The design's seed.
    pub seed: Option<u64>,
    /// How many independently scrambled nets a Sobol design consists of, where it is more than one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replicates: Option<u64>,
}

/// Two criteria whose measured values have correlated errors.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Correlated {
    /// Their names.
    pub between: [String; 2],
    /// The correlation coefficient.
    pub coefficient: f64,
}

impl Summary {
    /// The criteria that pictures show: all of them, or those that the fewest points meet.
    pub fn pictured(&self) -> Vec<usize> {
        const MOST: usize = 60;
        self.least_met(MOST)
    }

    /// So many criteria that the fewest points meet, in their order.
    pub fn least_met(&self, most: usize) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.criteria.len()).collect();
        all.sort_by_key(|&k| self.criteria[k].count.passed);
        all.truncate(most);
        all.sort_unstable();
        all
    }

    /// Points that meet all criteria.
    pub fn whole(&self) -> Count {
        Count { passed: self.verified, fraction: self.verified_fraction, interval: self.verified_interval }
    }

    /// Whether a nominal value comes from the model itself, so that agreement verifies nothing.
    pub fn has_own_values(&self) -> bool {
        let mut criteria = self.criteria.values();
        criteria.any(|count| count.criterion.nominal_from.is_some())
    }

    /// Whether a point has a result, and a measured value to be compared with.
    pub fn is_compared(&self) -> bool {
        self.failed < self.points && !self.has_own_values()
    }

    /// The share that the study requires, and how far it is known.
    pub fn required(&self) -> Option<&Requirement> {
        self.conclusion.as_ref()?.required.as_ref()
    }

    /// Doubts that are warnings.
    pub fn warnings(&self) -> impl Iterator<Item = &Concern> {
        self.concerns.iter().filter(|concern| concern.severity == Severity::Warning)
    }

    /// The verdict; of results that state none, by the one-point rule.
    pub fn decision(&self) -> Decision {
        let one_point = match self.verified {
            0 => Decision::NotVerified,
            _ => Decision::Verified,
        };
        let conclusion = self.conclusion.as_ref();
        conclusion.map_or(one_point, |conclusion| conclusion.verdict)
    }

    /// What a point is that meets all criteria.
    pub fn met(&self) -> &'static str {
        if self.has_own_values() { "accepted" } else { "verified" }
    }

    /// The measured values with the joint distribution of their errors.
    ///
    /// # Errors
    /// When the correlations contradict each other or name criteria that are not there.
    pub fn measurement(&self) -> Result<Measurement, String> {
        let number =
            |name: &String| self.criteria.get_index_of(name).ok_or_else(|| format!("there is no criterion `{name}`"));
        let pairs: Vec<(usize, usize, f64)> = self
            .uncertainty_correlations
            .iter()
            .map(|entry| {
                let [a, b] = &entry.between;
                Ok::<_, String>((number(a)?, number(b)?, entry.coefficient))
            })
            .collect::<Result<_, _>>()?;
        let criteria = self.criteria.values().map(|count| count.criterion.measured()).collect();
        Measurement::new(criteria, &pairs)
    }
}

/// A point without a result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FailedPoint {
    /// Name, for people.
    pub point: u64,
    /// Why it has none, as in the `status` column of `points.csv`.
    pub status: String,
}

/// Points without a result for reasons that differ in their numbers alone.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FailureKind {
    /// How many points.
    pub points: u64,
    /// The first of them.
    #[serde(flatten)]
    pub first: FailedPoint,
}

/// How many points meet a condition.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Count {
    /// Points that do.
    pub passed: u64,
    /// Their share of all points.
    pub fraction: f64,
    /// 95 % interval of the share; none of points that depend on each other.
    pub interval: Option<[f64; 2]>,
}

/// A case and how many points hold in it: meet all its criteria.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CaseCount {
    /// The count.
    #[serde(flatten)]
    pub count: Count,
    /// Points whose simulation of this case has no result.
    pub failed: u64,
    /// Whether the case is judged as any other one, but not used by `identify`.
    pub held_out: bool,
    /// The names of its criteria.
    pub criteria: Vec<String>,
}

/// A criterion and how many points meet it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CriterionCount {
    /// The count.
    #[serde(flatten)]
    pub count: Count,
    /// Points at which it deviates most of all criteria, in units of the tolerances.
    #[serde(default)]
    pub binds: u64,
    /// Points that fail this criterion and no other.
    #[serde(default)]
    pub only_failure: u64,
    /// The least and the greatest value at a point; none where no point has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reached: Option<[f64; 2]>,
    /// The risks of this criterion alone, where its uncertainty is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub risk: Option<Risk>,
    /// Of a measured curve: why it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub risk_not_stated: Option<String>,
    /// The criterion.
    #[serde(flatten)]
    pub criterion: Criterion,
}

/// An uncertain parameter.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ParameterSummary {
    /// The FMU's variable.
    pub name: String,
    /// The unit of its numbers.
    pub unit: Option<String>,
    /// The distribution's name and its numbers.
    #[serde(flatten)]
    pub distribution: serde_json::Map<String, serde_json::Value>,
}

/// A point with its parameters and values.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct BestPoint {
    /// Name, for people.
    pub point: u64,
    /// Whether the point meets all criteria.
    pub verified: bool,
    /// The root of the sum of its squared deviations from the measurement, each relative to the accuracy.
    pub distance: f64,
    /// The point's parameters.
    pub parameters: IndexMap<String, f64>,
    /// The criteria's values at the point.
    pub values: IndexMap<String, f64>,
}

/// A point as it was judged.
pub(super) struct Kept {
    label: u64,
    parameters: Vec<f64>,
    values: Vec<f64>,
}

impl Kept {
    pub fn new(label: u64, parameters: &[f64], values: &[f64]) -> Self {
        Self { label, parameters: parameters.to_vec(), values: values.to_vec() }
    }
}

impl BestPoint {
    pub(super) fn new(judge: &Judge, parameters: &[ParameterSummary], kept: &Kept) -> Self {
        let names = parameters.iter().map(|parameter| parameter.name.clone());
        Self {
            point: kept.label,
            verified: judge.verdict(Some(&kept.values)).verified(),
            distance: judge.distance(&kept.values),
            parameters: names.zip(kept.parameters.iter().copied()).collect(),
            values: judge.names().cloned().zip(kept.values.iter().copied()).collect(),
        }
    }
}

/// How the computation went.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    /// When it was done, in the form of ISO 8601 with the time zone.
    #[serde(default)]
    pub date: String,
    /// Wall time of this run, s.
    pub wall_seconds: f64,
    /// Points computed in this run; the others were there before.
    pub computed: u64,
    /// How many points were computed at a time.
    pub jobs: usize,
    /// How many points each host computed, where workers ran on other machines.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub hosts: BTreeMap<String, u64>,
}

impl Run {
    /// The run of a program that computed so many points since it began, so many at a time.
    pub fn since(begun: Instant, computed: u64, jobs: usize) -> Self {
        Self {
            date: Utc::now().to_rfc3339_opts(SecondsFormat::Secs, true),
            wall_seconds: begun.elapsed().as_secs_f64(),
            computed,
            jobs,
            hosts: BTreeMap::new(),
        }
    }
}

impl ParameterSummary {
    /// A study's parameter as the summary lists it.
    pub fn new(input: &study::plan::Input) -> Self {
        let distribution = serde_json::to_value(&input.distribution);
        let Ok(serde_json::Value::Object(distribution)) = distribution else {
            unreachable!("a distribution is a name with numbers");
        };
        Self { name: input.name.clone(), unit: input.unit.clone(), distribution }
    }
}
