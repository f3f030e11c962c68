//! The counts of `summary.json`.

use std::cmp::Reverse;

use indexmap::IndexMap;

use super::{
    failed,
    resampled::{not_stated, told},
    summary::{
        BestPoint, CaseCount, Correlated, Count, CriterionCount, FailedPoint, FailureKind, Kept, ParameterSummary,
        Provenance, Summary,
    },
};
use conformity::{
    conclusion::{Conclusion, Requirement, Ruling, grouped},
    decision::{Decision, randomised},
    interval::LEAST_SAMPLES,
    looks::Looks,
    risk::{Guard, RiskTally},
};
use fmu_import::validity;
use fmu_points::{
    failure::Failure,
    notices::{Notices, Replicates},
};
use point_journal::PointOutcome;
use study::{
    Study,
    judge::{Judge, PointVerdict},
};

/// How the points represent the space.
#[derive(PartialEq)]
pub enum Sample {
    /// Each by itself.
    Independent,
    /// They belong to so many independent nets in turn; they must be added in their order.
    Nets(u64),
    /// They depend on each other in a way that nobody knows, as those of too few nets do. No interval tells how far the share of
    /// these points is from that of the space.
    Dependent,
}

impl Sample {
    /// So many points of a study's design, in their order, with so many replicates.
    pub fn of(study: &Study, points: u64, replicates: u64) -> Self {
        match replicates {
            _ if study.design.method.is_independent(points, !study.correlations.is_empty()) => Self::Independent,
            n if n >= LEAST_SAMPLES as u64 => Self::Nets(n),
            _ => Self::Dependent,
        }
    }
}

/// Points that meet a condition, for each randomisation of the design on its own.
type Passed = Vec<u64>;

/// Counts points one by one, in constant memory.
pub struct Tally<'a> {
    judge: &'a Judge,
    replicates: usize,
    is_dependent: bool,
    looks: Looks,
    look: u64,
    /// How many points were counted.
    pub points: u64,
    /// With their classes, by what they say but for its numbers.
    failures: IndexMap<String, (&'static str, FailureKind)>,
    stated: Counts,
    binds: Vec<u64>,
    only_failure: Vec<u64>,
    /// By case: points that hold in it.
    held: Vec<Passed>,
    /// By case: points whose simulation of it has no result.
    lost: Vec<u64>,
    risk: RiskTally,
    /// Whether any point came with the draws of its measured curves.
    resampled: bool,
    /// The best point so far with its rank.
    best: Option<((bool, f64), Kept)>,
}

/// Counts of points.
struct Counts {
    verified: Passed,
    criteria: Vec<Passed>,
    groups: Vec<Passed>,
}

impl Counts {
    fn new(judge: &Judge, replicates: usize) -> Self {
        let none = vec![0; replicates];
        Self {
            criteria: vec![none.clone(); judge.criteria.len()],
            groups: vec![none.clone(); judge.groups.len()],
            verified: none,
        }
    }

    fn add(&mut self, judge: &Judge, verdict: &PointVerdict, replicate: usize) {
        self.verified[replicate] += u64::from(verdict.verified());
        for (count, passed) in self.criteria.iter_mut().zip(&verdict.passed) {
            count[replicate] += u64::from(*passed);
        }
        for (count, (_, members)) in self.groups.iter_mut().zip(&judge.groups) {
            let passed = members.iter().all(|&member| verdict.passed[member]);
            count[replicate] += u64::from(passed);
        }
    }
}

impl<'a> Tally<'a> {
    /// No points yet.
    pub fn new(judge: &'a Judge, sample: Sample) -> Self {
        let replicates = match sample {
            Sample::Nets(number) => usize::try_from(number).unwrap_or(1).max(1),
            Sample::Independent | Sample::Dependent => 1,
        };
        Self {
            judge,
            replicates,
            is_dependent: sample == Sample::Dependent,
            looks: Looks::default(),
            look: 1,
            points: 0,
            failures: IndexMap::new(),
            stated: Counts::new(judge, replicates),
            binds: vec![0; judge.criteria.len()],
            only_failure: vec![0; judge.criteria.len()],
            held: vec![vec![0; replicates]; judge.cases.len()],
            lost: vec![0; judge.cases.len()],
            risk: RiskTally::new(&judge.measurement, judge.guard, replicates as u64),
            resampled: false,
            best: None,
        }
    }

    /// How the points are looked at, and the how manieth verdict on points of this study it is.
    pub fn looked_at(self, looks: Looks, look: u64) -> Self {
        Self { looks, look, ..self }
    }

    /// Counts a point, with what came beside its results, and returns the verdict on it.
    pub fn add(
        &mut self,
        label: u64,
        parameters: &[f64],
        outcome: &PointOutcome,
        notices: Option<&Notices>,
    ) -> PointVerdict {
        let conforming: &[Replicates] = notices.map_or(&[], |notices| &notices.conforming);
        self.resampled |= !conforming.is_empty();
        let replicate = (self.points % self.replicates as u64) as usize;
        self.points += 1;
        let values = outcome.as_deref().ok();
        let verdict = self.judge.judged(outcome.as_deref());
        self.count_cases(outcome, &verdict, replicate);
        let conformity = values.map(|values| {
            let told = told(self.judge, conforming);
            self.judge.measurement.assess_with(values, told.as_ref())
        });
        self.risk.add(conformity.as_ref());
        let verdict = PointVerdict { together: conformity.map(|conformity| conformity.all), ..verdict };
        self.stated.add(self.judge, &verdict, replicate);
        match outcome {
            Ok(values) => {
                self.blame(values, &verdict);
                // Of equally good ones the first one stays.
                let rank = (verdict.verified(), -self.judge.distance(values));
                if self.best.as_ref().is_none_or(|(best, _)| rank > *best) {
                    self.best = Some((rank, Kept::new(label, parameters, values)));
                }
            }
            Err(failure) => self.add_failure(label, failure),
        }
        verdict
    }

    fn add_failure(&mut self, label: u64, failure: &Failure) {
        const MOST_KINDS: usize = 20;
        let (class, status) = (failure.class(), failure.to_string());
        let mut kind = validity::kind(&status);
        // An FMU may say another thing each time.
        if self.failures.len() >= MOST_KINDS && !self.failures.contains_key(&kind) {
            class.clone_into(&mut kind);
        }
        let first = FailedPoint { point: label, status };
        let (_, of_kind) = self.failures.entry(kind).or_insert((class, FailureKind { points: 0, first }));
        of_kind.points += 1;
    }

    fn count_cases(&mut self, outcome: &PointOutcome, verdict: &PointVerdict, replicate: usize) {
        for (number, case) in self.judge.cases.iter().enumerate() {
            let mut members = case.members.clone();
            let holds = verdict.passed[members.clone()].iter().all(|&passed| passed);
            self.held[number][replicate] += u64::from(holds);
            let failure = outcome.as_ref().err();
            let is_lost = failure.is_some_and(|failure| members.any(|k| failure.value(k).is_none()));
            self.lost[number] += u64::from(is_lost);
        }
    }

    /// Notes which criterion decides at a point.
    fn blame(&mut self, values: &[f64], verdict: &PointVerdict) {
        let deviations: Vec<f64> =
            self.judge.criteria.iter().zip(values).map(|(c, &value)| c.deviation(value)).collect();
        let worst = (0..deviations.len()).reduce(|most, k| {
            let larger = deviations[k] > deviations[most];
            if larger { k } else { most }
        });
        if let Some(worst) = worst.filter(|_| deviations.iter().all(|d| !d.is_nan())) {
            self.binds[worst] += 1;
        }
        let mut failed = (0..verdict.passed.len()).filter(|&k| !verdict.passed[k]);
        if let (Some(only), None) = (failed.next(), failed.next()) {
            self.only_failure[only] += 1;
        }
    }

    fn failed(&self) -> u64 {
        self.failures.values().map(|(_, kind)| kind.points).sum()
    }

    fn count(&self, passed: &Passed) -> Count {
        const CONFIDENCE: f64 = 0.95;
        let all = passed.iter().sum();
        Count {
            passed: all,
            fraction: all as f64 / self.points.max(1) as f64,
            interval: (!self.is_dependent).then(|| randomised(passed, self.points, CONFIDENCE)),
        }
    }

    fn by_group(&self) -> IndexMap<String, Count> {
        let names = self.judge.groups.iter().map(|(name, _)| name.clone());
        let counts = self.stated.groups.iter().map(|passed| self.count(passed));
        names.zip(counts).collect()
    }

    fn by_case(&self) -> IndexMap<String, CaseCount> {
        self.judge
            .cases
            .iter()
            .zip(self.held.iter().zip(&self.lost))
            .map(|(case, (held, lost))| {
                let members = self.judge.criteria[case.members.clone()].iter();
                let count = CaseCount {
                    count: self.count(held),
                    failed: *lost,
                    held_out: case.held_out,
                    criteria: members.map(|criterion| criterion.name.clone()).collect(),
                };
                (case.name.clone(), count)
            })
            .collect()
    }

    /// The summary of what was counted.
    pub fn summary(&self, title: Option<String>, provenance: Provenance, parameters: Vec<ParameterSummary>) -> Summary {
        let (judge, points) = (self.judge, self.points);
        let ruling = judge.rule.map(|rule| Ruling { rule, looks: self.looks, count: self.look });
        let statement = match ruling {
            _ if self.is_dependent => self.risk.statement_of_no_sample(),
            Some(Ruling { rule, looks, .. }) => self.risk.statement_at(looks.band_confidence(rule.confidence)),
            None => self.risk.statement(),
        };
        let mut conclusion = Conclusion::new(ruling, &statement, points);
        if let Guard::EachPoint { risk } = judge.guard {
            conclusion.point_risk = Some(risk);
        }
        if self.is_dependent {
            untold(&mut conclusion, points);
        }
        let compared = self.failed() < points;
        if !compared {
            failed::nothing_compared(&mut conclusion, points);
        } else if judge.has_own_values() {
            unmeasured(&mut conclusion, points);
        }
        let all = self.count(&self.stated.verified);
        let criteria = judge.criteria.iter().enumerate().map(|(k, criterion)| {
            let risk = &statement.criteria[k];
            let count = CriterionCount {
                count: self.count(&self.stated.criteria[k]),
                binds: self.binds[k],
                only_failure: self.only_failure[k],
                reached: None,
                risk_not_stated: not_stated(criterion, risk.as_ref(), self.resampled),
                risk: risk.clone().filter(|_| compared),
                criterion: criterion.clone(),
            };
            (criterion.name.clone(), count)
        });
        let mut failures: IndexMap<String, u64> = IndexMap::new();
        for (class, kind) in self.failures.values() {
            *failures.entry((*class).to_owned()).or_default() += kind.points;
        }
        failures.sort_unstable_keys();
        let mut failure_kinds: Vec<FailureKind> = self.failures.values().map(|(_, kind)| kind.clone()).collect();
        // Ties between reasons go to the one that occurred first.
        failure_kinds.sort_by_key(|kind| Reverse(kind.points));
        let best = self.best.as_ref();
        Summary {
            title,
            points,
            failed: self.failed(),
            verified: all.passed,
            verified_fraction: all.fraction,
            verified_interval: all.interval,
            interval_method: self.interval_method(&provenance),
            expected_verified: statement.expected_conforming.filter(|_| compared),
            conclusion: Some(conclusion),
            uncertainty_correlations: correlations(judge),
            criteria: criteria.collect(),
            groups: self.by_group(),
            cases: self.by_case(),
            failures,
            failure_kinds,
            best_point: best.map(|(_, kept)| BestPoint::new(judge, &parameters, kept)),
            parameters,
            provenance,
            ..Summary::default()
        }
    }

    fn interval_method(&self, provenance: &Provenance) -> String {
        match (self.replicates, provenance.method.as_str()) {
            (_, method) if self.is_dependent => {
                format!("none: the points of {method} depend on each other, and nothing tells how much")
            }
            (1, "table") => {
                "Clopper and Pearson's, for rows that were drawn independently, as [design] says".to_owned()
            }
            (1, _) => "Clopper and Pearson's".to_owned(),
            (n, _) => format!("Clopper and Pearson's, with each of {n} independently scrambled nets as one trial"),
        }
    }
}

/// The conclusion from points whose share nothing tells the error of.
fn untold(conclusion: &mut Conclusion, points: u64) {
    let Some(required) = &mut conclusion.required else { return };
    *required = Requirement {
        method: "none: the points depend on each other, and nothing tells how much".to_owned(),
        ..Requirement::open(required.rule, required.looks)
    };
    conclusion.verdict = Decision::Inconclusive;
    conclusion.verdict_words = format!(
        "inconclusive: {} of {} points are accepted, but they were not drawn independently, and nothing tells how far that share \
         is off; use method = \"monte-carlo\" under [design]",
        grouped(conclusion.accepted),
        grouped(points)
    );
}

/// The conclusion while the model is compared with its own values: they verify nothing.
fn unmeasured(conclusion: &mut Conclusion, points: u64) {
    conclusion.verdict = Decision::NotVerified;
    conclusion.verdict_words = format!(
        "no measured value yet: {} of {} points are within the tolerances of values that the model itself gave",
        grouped(conclusion.accepted),
        grouped(points)
    );
    conclusion.required = None;
}

/// Which measured values' errors are correlated.
fn correlations(judge: &Judge) -> Vec<Correlated> {
    let name = |number: usize| judge.criteria[number].name.clone();
    judge
        .measurement
        .correlations()
        .iter()
        .map(|&(a, b, coefficient)| Correlated { between: [name(a), name(b)], coefficient })
        .collect()
}
