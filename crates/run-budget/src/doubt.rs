//! Whether a surrogate holds: its runs left out are held against what the others say of them.

use crate::limit::Limit;
use crate::surrogate::{Run, Surrogate};
use conformity::normal::between;

/// Errors of runs left out, over the deviation of the output, from which on the surrogate is asked only where hardly a sign
/// depends on them.
pub const LARGEST_ERROR: f64 = 0.2;
/// Hardly a sign depends on errors that leave open no more than this part of the variance of the signs.
const LARGEST_OPEN: f64 = 0.1;
/// So many deviations more wrong signs among the runs left out than their probabilities say refute the surrogate.
pub const REFUTED: f64 = 2.5;

/// Why a surrogate does not hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Doubt {
    /// There are too few runs for one, or no process fits.
    Unfit,
    /// Errors of an output when runs are left out, over its deviation.
    Error {
        /// The number of the output.
        output: usize,
        /// Root mean square error over the deviation.
        relative: f64,
    },
    /// Runs fail, and those left out do not tell where to within a fifth.
    Failures,
    /// The runs left out are good or bad against their probability.
    Signs {
        /// By so many deviations.
        deviations: f64,
    },
}

/// What refutes the surrogate, if anything does: errors that are too large, or runs that are good or bad against what the others
/// say of them.
pub fn doubt(surrogate: &Surrogate, limits: &[Limit], runs: &[Run]) -> Option<Doubt> {
    let succeeded: Vec<&[f64]> = runs.iter().filter_map(Run::finite).collect();
    let told_by = |limit: &Limit| -> Vec<[f64; 2]> {
        let told = |(values, [mean, deviation]): (&&[f64], &[f64; 2])| {
            let [from, to] = limit.range.map(|end| (end - mean) / deviation);
            [between(from, to), f64::from(limit.margin(values[limit.output]) >= 0.0)]
        };
        succeeded.iter().zip(surrogate.left_out(limit.output)).map(told).collect()
    };
    let told: Vec<Vec<[f64; 2]>> = limits.iter().map(told_by).collect();
    let checks = surrogate.checks();
    let errors = limits.iter().map(|limit| (limit.output, checks[limit.output].relative));
    if let Some((output, relative)) = errors.max_by(|a, b| a.1.total_cmp(&b.1))
        && relative > LARGEST_ERROR
        && left_open(&told, succeeded.len()) > LARGEST_OPEN
    {
        return Some(Doubt::Error { output, relative });
    }
    let unforeseen = surrogate.success.as_ref().is_none_or(|success| success.check.relative > LARGEST_ERROR);
    if succeeded.len() < runs.len() && unforeseen {
        return Some(Doubt::Failures);
    }
    // A surrogate is never surer of a sign than its number of runs allows.
    let [scattered, one_sided] = surprise(told.into_iter().flatten(), 0.1 / succeeded.len() as f64);
    // A process smooths a jump: the limit then lies on one side of where it is at all runs, and its functions share that error.
    let deviations = scattered.max(one_sided);
    (deviations > REFUTED).then_some(Doubt::Signs { deviations })
}

/// How much of the variance of whether a run keeps all limits is open when it is left out. `told` has, by limit and run, the
/// probability that it keeps the limit, and 1 if it does or 0.
fn left_open(told: &[Vec<[f64; 2]>], runs: usize) -> f64 {
    let all = |run: usize, which: usize| told.iter().map(|of_limit| of_limit[run][which]).product::<f64>();
    let variance = |share: f64| share * (1.0 - share);
    let open: f64 = (0..runs).map(|run| variance(all(run, 0))).sum();
    let kept: f64 = (0..runs).map(|run| all(run, 1)).sum();
    open / (runs as f64 * variance(kept / runs as f64))
}

/// By how many deviations what came out, 0 or 1, is farther off what was said of it than that admits, and how far it is off to one
/// side. What was said is never surer than `least`.
pub fn surprise(told: impl Iterator<Item = [f64; 2]>, least: f64) -> [f64; 2] {
    let (mut excess, mut variance, mut off, mut open) = (0.0, 0.0, 0.0, 0.0);
    for [said, is] in told {
        let said = said.clamp(least, 1.0 - least);
        let by_chance: f64 = said * (1.0 - said);
        excess += (is - said).powi(2) - by_chance;
        variance += by_chance * (1.0 - 2.0 * said).powi(2);
        off += is - said;
        open += by_chance;
    }
    [excess / variance.sqrt(), off.abs() / open.sqrt()]
}
