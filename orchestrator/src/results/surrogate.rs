//! What a surrogate of few runs tells, beside the counts of these.

use super::{
    by_surrogate::{BySurrogate, SurrogateFit},
    summary::{Count, Summary},
};
use conformity::{
    conclusion::by_share,
    risk::RiskTally,
    validation::{Comparison, Numerical, Spread},
};
use result_document::format::number;
use run_budget::{Answers, Basis, Doubt, Limit, Share};
use study::judge::Judge;

/// How the shares of a summary were found, behind their heading.
pub fn way(summary: &Summary) -> String {
    summary.surrogate.as_ref().map(|surrogate| format!(" ({})", surrogate.way())).unwrap_or_default()
}

/// What the criteria ask of the outputs: their limits, drawn in by a guard band.
pub fn limits(judge: &Judge, guard: f64) -> Vec<Limit> {
    judge
        .measurement
        .criteria()
        .iter()
        .enumerate()
        .map(|(output, measured)| {
            let band = measured.error.as_ref().map_or(0.0, |error| guard * error.expanded);
            let [low, high] = measured.limits.ends();
            Limit { output, range: [low + band, high - band] }
        })
        .collect()
}

/// What few runs tell of a study.
pub struct Evidence<'a> {
    /// The criteria.
    pub judge: &'a Judge,
    /// What the runs say of the sample.
    pub answers: &'a Answers,
    /// All runs of the FMU.
    pub runs: u64,
    /// The factor of the guard band, and the confidence of the verdict.
    pub verdict: [f64; 2],
}

impl Evidence<'_> {
    /// Puts into the summary of chosen runs what they tell of the sampled space: shares, verdict, risks, spread of the values.
    /// The numbers of points stay those of runs.
    pub fn complete(&self, summary: &mut Summary) {
        let Self { judge, answers, .. } = *self;
        let all = limits(judge, 0.0);
        let whole = answers.share(&all);
        self.shares(summary, &all, &whole);
        let checks = answers.surrogate.as_ref().map(run_budget::Surrogate::checks).unwrap_or_default();
        let fits = judge.criteria.iter().zip(checks).map(|(criterion, check)| {
            (criterion.name.clone(), SurrogateFit { error: check.error / criterion.room(), held: check.held })
        });
        let plain = answers.plain.iter().filter(|plain| **plain).count() as u64;
        let told = BySurrogate {
            runs: self.runs,
            plain,
            chosen: summary.points - plain,
            share: whole.estimate,
            interval: whole.interval(0.95),
            criteria: fits.collect(),
            refuted: whole.basis != Basis::Surrogate,
            reason: match whole.basis {
                Basis::Surrogate => None,
                Basis::Counted(doubt) => Some(reason(judge, doubt)),
            },
        };
        summary.interval_method = if told.refuted {
            "Clopper and Pearson's, from the plain points".to_owned()
        } else {
            format!("by surrogate from {} runs, with its own error", told.runs)
        };
        let compared = summary.is_compared();
        if let Some(conclusion) = summary.conclusion.as_mut().filter(|_| compared)
            && let Some(required) = &mut conclusion.required
        {
            let [guard, confidence] = self.verdict;
            let interval = answers.share(&limits(judge, guard)).interval(confidence);
            required.interval = Some(interval);
            required.method.clone_from(&summary.interval_method);
            conclusion.verdict = required.rule.decide(interval);
            let way = format!(" {}", told.way());
            conclusion.verdict_words = by_share(conclusion.verdict, required, &way);
        }
        if summary.failed < summary.points {
            self.of_the_space(summary, told.refuted);
        }
        summary.surrogate = Some(told);
    }

    fn shares(&self, summary: &mut Summary, all: &[Limit], whole: &Share) {
        let Self { judge, answers, .. } = *self;
        let put = |count: &mut Count, limits: &[Limit]| {
            let share = answers.share(limits);
            (count.fraction, count.interval) = (share.estimate, Some(share.interval(0.95)));
        };
        (summary.verified_fraction, summary.verified_interval) = (whole.estimate, Some(whole.interval(0.95)));
        for (count, limit) in summary.criteria.values_mut().zip(all) {
            put(&mut count.count, &[*limit]);
        }
        let of = |all: &[Limit], members: &[usize]| -> Vec<Limit> { members.iter().map(|&k| all[k]).collect() };
        for (count, (_, members)) in summary.groups.values_mut().zip(&judge.groups) {
            put(count, &of(all, members));
        }
        for (count, case) in summary.cases.values_mut().zip(&judge.cases) {
            put(&mut count.count, &all[case.members.clone()]);
        }
    }

    /// What a plain sample would tell: one that the surrogate gives, or the plain points.
    fn of_the_space(&self, summary: &mut Summary, refuted: bool) {
        let Self { judge, answers, .. } = *self;
        let rows: Vec<Option<Vec<f64>>> = if refuted {
            answers
                .runs
                .iter()
                .zip(&answers.plain)
                .filter(|(_, plain)| **plain)
                .map(|(run, _)| run.finite().map(<[f64]>::to_vec))
                .collect()
        } else {
            answers.outcomes()
        };
        let mut tally = RiskTally::new(&judge.measurement, judge.guard, 1);
        let mut spreads = vec![Spread::default(); judge.criteria.len()];
        for values in &rows {
            let conformity = values.as_ref().map(|values| judge.measurement.assess(values));
            tally.add(conformity.as_ref());
            spreads.iter_mut().zip(values.iter().flatten()).for_each(|(spread, value)| spread.add(*value));
        }
        let statement = tally.statement_of_no_sample();
        if let Some(conclusion) = &mut summary.conclusion {
            conclusion.risk = statement.all;
        }
        for (k, (criterion, spread)) in judge.criteria.iter().zip(&spreads).enumerate() {
            let (name, count) = summary.criteria.get_index_mut(k).expect("each criterion is counted");
            count.risk.clone_from(&statement.criteria[k]);
            if let Some(compared) = summary.validation.get_mut(name)
                && let Some(spread) = spread.result()
                && let Some(comparison) = Comparison::new(&criterion.measured(), spread, Numerical::default())
            {
                *compared = comparison;
            }
        }
    }
}

/// Why a surrogate does not hold, in the words of a study.
pub fn reason(judge: &Judge, doubt: Doubt) -> String {
    match doubt {
        Doubt::Unfit => "too few runs have values".to_owned(),
        Doubt::Error { output, relative } => format!(
            "points that are left out are missed by {} of the spread of {}, more than a fifth",
            number(relative, 2),
            judge.criteria[output].name
        ),
        Doubt::Failures => "runs fail, and others do not tell where".to_owned(),
        Doubt::Signs { deviations } => format!(
            "points that are left out contradict it about their side of a limit by {} deviations",
            number(deviations, 2)
        ),
    }
}
