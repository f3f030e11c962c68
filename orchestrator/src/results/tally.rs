//! The counts of `summary.json`.

use std::ops::Range;

use indexmap::IndexMap;

use super::Outcome;
use super::conclusion::{Conclusion, Ruling};
use super::failed;
use super::resampled::{not_stated, told};
use super::summary::{
    BestPoint, CaseCount, Correlated, Count, CriterionCount, FailedPoint, ParameterSummary,
    Provenance, Summary, VariantCount,
};
use crate::judge::{Judge, PointVerdict, Variant};
use conformity::decision::randomised;
use conformity::looks::Looks;
use conformity::risk::RiskTally;
use fmu_points::notices::{Notices, Replicates};

impl Count {
    /// The count of points that belong to randomisations of a design in turn, given that of each.
    #[allow(clippy::cast_precision_loss)]
    fn new(shares: &Shares, points: u64) -> Self {
        const CONFIDENCE: f64 = 0.95;
        let passed = shares.total();
        Self {
            passed,
            fraction: passed as f64 / points.max(1) as f64,
            interval: (!shares.grid).then(|| randomised(&shares.counts, points, CONFIDENCE)),
        }
    }
}

/// A count, for each randomisation of the design on its own.
#[derive(Clone, Debug)]
struct Shares {
    counts: Vec<u64>,
    /// Whether the points are no sample, so that no interval tells how far the share may be off.
    grid: bool,
}

impl Shares {
    fn none(replicates: usize, grid: bool) -> Self {
        Self {
            counts: vec![0; replicates],
            grid,
        }
    }

    fn add(&mut self, replicate: usize, passed: bool) {
        self.counts[replicate] += u64::from(passed);
    }

    fn total(&self) -> u64 {
        self.counts.iter().sum()
    }
}

/// Counts points one by one, in constant memory.
#[derive(Clone, Debug)]
pub struct Tally<'a> {
    judge: &'a Judge,
    replicates: usize,
    looks: Looks,
    look: u64,
    grid: bool,
    points: u64,
    failures: IndexMap<String, (u64, FailedPoint)>,
    own: Counts,
    variants: Vec<Counts>,
    binds: Vec<u64>,
    only_failure: Vec<u64>,
    /// By case: points that hold in it.
    held: Vec<Shares>,
    /// By case: points whose simulation of it has no result.
    lost: Vec<u64>,
    risk: RiskTally,
    /// Whether any point came with the draws of its measured curves.
    resampled: bool,
    best: Option<Best>,
}

#[derive(Clone, Debug)]
struct Counts {
    verified: Shares,
    criteria: Vec<Shares>,
    groups: Vec<Shares>,
}

#[derive(Clone, Debug)]
struct Best {
    label: u64,
    verified: bool,
    distance: f64,
    parameters: Vec<f64>,
    values: Vec<f64>,
}

impl Counts {
    fn new(judge: &Judge, replicates: usize, grid: bool) -> Self {
        let none = Shares::none(replicates, grid);
        Self {
            verified: none.clone(),
            criteria: vec![none.clone(); judge.criteria.len()],
            groups: vec![none; judge.groups.len()],
        }
    }

    fn add(&mut self, judge: &Judge, verdict: &PointVerdict, replicate: usize) {
        self.verified.add(replicate, verdict.verified());
        for (count, passed) in self.criteria.iter_mut().zip(&verdict.passed) {
            count.add(replicate, *passed);
        }
        for (count, (_, members)) in self.groups.iter_mut().zip(&judge.groups) {
            let passed = members.iter().all(|&member| verdict.passed[member]);
            count.add(replicate, passed);
        }
    }

    fn by_criterion(&self, judge: &Judge, points: u64) -> IndexMap<String, Count> {
        let names = judge
            .criteria
            .iter()
            .map(|criterion| criterion.name.clone());
        names
            .zip(self.criteria.iter().map(|count| Count::new(count, points)))
            .collect()
    }

    fn by_group(&self, judge: &Judge, points: u64) -> IndexMap<String, Count> {
        let names = judge.groups.iter().map(|(name, _)| name.clone());
        names
            .zip(self.groups.iter().map(|count| Count::new(count, points)))
            .collect()
    }
}

impl<'a> Tally<'a> {
    /// No points yet.
    pub fn new(judge: &'a Judge) -> Self {
        Self::of_samples(judge, 1, false)
    }

    /// No points yet of a grid, which are no sample: no interval tells how far their share is from that of the space.
    pub fn of_grid(judge: &'a Judge) -> Self {
        Self::of_samples(judge, 1, true)
    }

    /// No points yet of a design of which the points belong to randomisations in turn; they must
    /// be added in their order.
    pub fn of_replicates(judge: &'a Judge, replicates: u64) -> Self {
        Self::of_samples(judge, replicates, false)
    }

    fn of_samples(judge: &'a Judge, replicates: u64, grid: bool) -> Self {
        let replicates = usize::try_from(replicates).unwrap_or(1).max(1);
        let none = || Counts::new(judge, replicates, grid);
        Self {
            judge,
            replicates,
            looks: Looks::default(),
            look: 1,
            grid,
            points: 0,
            failures: IndexMap::new(),
            own: none(),
            variants: judge.variants.iter().map(|_| none()).collect(),
            binds: vec![0; judge.criteria.len()],
            only_failure: vec![0; judge.criteria.len()],
            held: vec![Shares::none(replicates, grid); judge.cases.len()],
            lost: vec![0; judge.cases.len()],
            risk: RiskTally::new(&judge.measurement, judge.guard, replicates as u64),
            resampled: false,
            best: None,
        }
    }

    /// How the points are looked at, and the how manieth verdict on points of this study it is.
    pub fn looked_at(self, looks: Looks, look: u64) -> Self {
        Self {
            looks,
            look,
            ..self
        }
    }

    /// Counts a point and returns the verdict on it.
    pub fn add(&mut self, label: u64, parameters: &[f64], outcome: &Outcome) -> PointVerdict {
        self.add_noted(label, parameters, outcome, None)
    }

    /// The same for a point with what came beside its results.
    pub fn add_noted(
        &mut self,
        label: u64,
        parameters: &[f64],
        outcome: &Outcome,
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
        self.own.add(self.judge, &verdict, replicate);
        for (counts, variant) in self.variants.iter_mut().zip(&self.judge.variants) {
            let verdict = self.judge.variant_verdict(variant, values);
            counts.add(self.judge, &verdict, replicate);
        }
        match outcome {
            Ok(values) => {
                self.blame(values, &verdict);
                self.compare(label, parameters, values, verdict.verified());
            }
            Err(failure) => {
                let first = || FailedPoint {
                    point: label,
                    status: failure.to_string(),
                };
                let class = failure.class().to_owned();
                self.failures.entry(class).or_insert_with(|| (0, first())).0 += 1;
            }
        }
        verdict
    }

    fn count_cases(&mut self, outcome: &Outcome, verdict: &PointVerdict, replicate: usize) {
        for (number, case) in self.judge.cases.iter().enumerate() {
            let members = case.members.clone();
            let holds = verdict.passed[members.clone()].iter().all(|&passed| passed);
            self.held[number].add(replicate, holds);
            let is_lost = outcome
                .as_ref()
                .err()
                .is_some_and(|failure| members.into_iter().any(|k| failure.value(k).is_none()));
            self.lost[number] += u64::from(is_lost);
        }
    }

    fn cases(&self) -> IndexMap<String, CaseCount> {
        let counts = self.held.iter().zip(&self.lost);
        let names = |members: Range<usize>| {
            let criteria = self.judge.criteria[members].iter();
            criteria.map(|criterion| criterion.name.clone()).collect()
        };
        let cases = self.judge.cases.iter().zip(counts);
        cases
            .map(|(case, (held, lost))| {
                let count = CaseCount {
                    count: Count::new(held, self.points),
                    failed: *lost,
                    held_out: case.held_out,
                    criteria: names(case.members.clone()),
                };
                (case.name.clone(), count)
            })
            .collect()
    }

    /// Notes which criterion decides at a point.
    fn blame(&mut self, values: &[f64], verdict: &PointVerdict) {
        let criteria = || self.judge.criteria.iter().zip(values);
        let deviations: Vec<f64> = criteria()
            .map(|(c, value)| (value - c.nominal).abs() / c.tolerance)
            .collect();
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

    /// Keeps the point if it is better than the best so far; of equals the first one stays.
    fn compare(&mut self, label: u64, parameters: &[f64], values: &[f64], verified: bool) {
        let distance = self.judge.distance(values);
        let better = self
            .best
            .as_ref()
            .is_none_or(|best| (verified, -distance) > (best.verified, -best.distance));
        if better {
            self.best = Some(Best {
                label,
                verified,
                distance,
                parameters: parameters.to_vec(),
                values: values.to_vec(),
            });
        }
    }

    /// How many points were counted.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// How many of them meet all criteria.
    pub fn verified(&self) -> u64 {
        self.own.verified.total()
    }

    /// How many of them have no result.
    pub fn failed(&self) -> u64 {
        self.failures.values().map(|(count, _)| count).sum()
    }

    /// The summary of what was counted.
    pub fn summary(
        &self,
        title: Option<String>,
        provenance: Provenance,
        parameters: Vec<ParameterSummary>,
    ) -> Summary {
        let (judge, points) = (self.judge, self.points);
        let ruling = judge.rule.map(|rule| Ruling {
            rule,
            looks: self.looks,
            count: self.look,
        });
        let statement = match ruling {
            _ if self.grid => self.risk.statement().without_intervals(),
            Some(ruling) => self.risk.statement_at(ruling.band_confidence()),
            None => self.risk.statement(),
        };
        let mut conclusion = Conclusion::new(ruling, &statement, points);
        if self.grid {
            // A grid has no seed.
            conclusion.other_verdict_interval = None;
        }
        let compared = self.failed() < points;
        if !compared {
            failed::nothing_compared(&mut conclusion, points);
        }
        let all = Count::new(&self.own.verified, points);
        let own = self.own.by_criterion(judge, points);
        let criteria =
            judge
                .criteria
                .iter()
                .zip(own)
                .enumerate()
                .map(|(k, (criterion, (name, count)))| {
                    let count = CriterionCount {
                        count,
                        binds: self.binds[k],
                        only_failure: self.only_failure[k],
                        risk_not_stated: not_stated(
                            criterion,
                            statement.criteria[k].as_ref(),
                            self.resampled,
                        ),
                        risk: statement.criteria[k].clone().filter(|_| compared),
                        criterion: criterion.clone(),
                    };
                    (name, count)
                });
        let variants = judge.variants.iter().zip(&self.variants);
        let counts = self.failures.iter();
        let mut failures: IndexMap<String, u64> = counts
            .map(|(class, (count, _))| (class.clone(), *count))
            .collect();
        failures.sort_unstable_keys();
        // Ties between reasons go to the one that occurred first.
        let usual = self.failures.values().rev().max_by_key(|(count, _)| count);
        Summary {
            title,
            dossier: None,
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
            groups: self.own.by_group(judge, points),
            cases: self.cases(),
            variants: variants
                .map(|(variant, counts)| self.variant(variant, counts))
                .collect(),
            failures,
            first_failure: usual.map(|(_, first)| first.clone()),
            best_point: self
                .best
                .as_ref()
                .map(|best| self.best_point(best, &parameters)),
            parameters,
            most_probable_point: None,
            concerns: Vec::new(),
            settled: None,
            left_out: None,
            validation: IndexMap::new(),
            improvements: None,
            conduct: None,
            reproducibility: None,
            asides: None,
            run: None,
            provenance,
        }
    }

    fn interval_method(&self, provenance: &Provenance) -> String {
        match (self.replicates, provenance.method.as_str()) {
            _ if self.grid => "none: the points of a grid are no sample".to_owned(),
            (1, "monte-carlo" | "table") => "Clopper and Pearson's".to_owned(),
            (1, _) => {
                "Clopper and Pearson's; it takes the points as independent, which makes it wider than the even \
                 design needs"
                    .to_owned()
            }
            (n, _) => format!(
                "Student's over {n} independently scrambled nets; Clopper and Pearson's where their counts hardly differ"
            ),
        }
    }

    fn variant(&self, variant: &Variant, counts: &Counts) -> (String, VariantCount) {
        let names = self
            .judge
            .criteria
            .iter()
            .map(|criterion| criterion.name.clone());
        let count = VariantCount {
            about: variant.about.clone(),
            verified: Count::new(&counts.verified, self.points),
            criteria: counts.by_criterion(self.judge, self.points),
            groups: counts.by_group(self.judge, self.points),
            tolerances: names.zip(variant.tolerances.iter().copied()).collect(),
        };
        (variant.name.clone(), count)
    }

    fn best_point(&self, best: &Best, parameters: &[ParameterSummary]) -> BestPoint {
        let names = parameters.iter().map(|parameter| parameter.name.clone());
        let criteria = self
            .judge
            .criteria
            .iter()
            .map(|criterion| criterion.name.clone());
        BestPoint {
            point: best.label,
            verified: best.verified,
            distance: best.distance,
            parameters: names.zip(best.parameters.iter().copied()).collect(),
            values: criteria.zip(best.values.iter().copied()).collect(),
        }
    }
}

/// Which measured values' errors are correlated.
fn correlations(judge: &Judge) -> Vec<Correlated> {
    let name = |number: usize| judge.criteria[number].name.clone();
    let pairs = judge.measurement.correlations().iter();
    pairs
        .map(|&(a, b, coefficient)| Correlated {
            between: [name(a), name(b)],
            coefficient,
        })
        .collect()
}
