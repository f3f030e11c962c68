//! The share of good points: by the surrogate with what it leaves open, or counted where it does not hold.

use crate::output::Check;
use crate::surrogate::{Run, Surrogate};
use conformity::interval::clopper_pearson;
use nalgebra::DMatrix;
use sampling::random::{Purpose, Random};

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 16;
/// Errors of runs left out, over the deviation of the output, from which on the surrogate is not asked.
pub(crate) const LARGEST_ERROR: f64 = 0.2;
/// So many deviations more wrong signs among the runs left out than their probabilities say refute the surrogate.
const REFUTED: f64 = 2.5;

/// A requirement: an output lies within both ends. Infinite ends are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The number of the output.
    pub output: usize,
    /// The least and the largest value that are good.
    pub range: [f64; 2],
}

impl Limit {
    fn margin(&self, value: f64) -> f64 {
        (value - self.range[0]).min(self.range[1] - value)
    }

    /// Whether a run is good: it succeeded, and no margin is negative.
    pub fn are_kept(limits: &[Self], run: &Run) -> bool {
        run.finite().is_some_and(|values| limits.iter().all(|limit| limit.margin(values[limit.output]) >= 0.0))
    }
}

/// What a share was found by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// The surrogate. Its runs may have been chosen.
    Surrogate,
    /// Plain runs were counted, because the surrogate does not hold.
    Counted(Doubt),
}

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

/// A share with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The share of good points.
    pub estimate: f64,
    /// The interval at the level of confidence asked for.
    pub interval: [f64; 2],
    /// What it was found by.
    pub basis: Basis,
}

/// The margins of functions that the model may be: the least of all limits, and below 0 where a run would fail.
pub(crate) fn margins(surrogate: &Surrogate, limits: &[Limit], points: &[Vec<f64>], each: usize) -> DMatrix<f64> {
    let mut least = surrogate.success(each).map(|functions| functions.at(&surrogate.standard(points)));
    let mut outputs: Vec<usize> = limits.iter().map(|limit| limit.output).collect();
    outputs.sort_unstable();
    outputs.dedup();
    for output in outputs {
        let functions = surrogate.functions(output, each);
        let mut values = functions.at(&surrogate.standard(points));
        let mut random = surrogate.random(4000 + output as u32);
        for (mut column, error) in values.column_iter_mut().zip(functions.noise()) {
            column.iter_mut().for_each(|v| *v += error * random.normal());
        }
        let unit = surrogate.spread(output);
        let of_output = || limits.iter().filter(|limit| limit.output == output);
        values.apply(|v| *v = of_output().map(|limit| limit.margin(*v) / unit).fold(f64::INFINITY, f64::min));
        least = Some(match least {
            None => values,
            Some(before) => before.zip_map(&values, f64::min),
        });
    }
    least.unwrap_or_else(|| DMatrix::repeat(points.len(), 1, 1.0))
}

/// The share of good points by the surrogate of `runs`. `sample` is a plain sample of the parameters, `plain` says which of the
/// runs are one too (the others were chosen): they are counted where the surrogate does not hold.
pub fn share(
    surrogate: Option<&Surrogate>,
    limits: &[Limit],
    runs: &[Run],
    plain: &[bool],
    sample: &[Vec<f64>],
    confidence: f64,
) -> Share {
    let doubt = match surrogate {
        None => Some(Doubt::Unfit),
        Some(surrogate) => doubt(surrogate, limits, runs),
    };
    let (Some(surrogate), None) = (surrogate, doubt) else {
        return counted(limits, runs, plain, confidence, doubt.unwrap_or(Doubt::Unfit));
    };
    let margins = margins(surrogate, limits, sample, EACH);
    let points = sample.len() as f64;
    let good = |column: usize| margins.column(column).iter().filter(|m| **m >= 0.0).count() as f64 / points;
    let shares: Vec<f64> = (0..margins.ncols()).map(good).collect();
    let draws = shares.len() as f64;
    let estimate = shares.iter().sum::<f64>() / draws;
    let between = shares.iter().map(|s| (s - estimate).powi(2)).sum::<f64>() / (draws - 1.0).max(1.0);
    // As many plain points as would leave as much open: surrogate's error and that of the sample, which is at most that of
    // independent points. Half a point is always open.
    let inner = estimate.clamp(0.5 / points, 1.0 - 0.5 / points);
    let trials = inner * (1.0 - inner) / (inner * (1.0 - inner) / points + between);
    Share { estimate, interval: clopper_pearson(estimate * trials, trials, confidence), basis: Basis::Surrogate }
}

fn counted(limits: &[Limit], runs: &[Run], plain: &[bool], confidence: f64, doubt: Doubt) -> Share {
    let good: Vec<bool> =
        runs.iter().zip(plain).filter(|(_, plain)| **plain).map(|(run, _)| Limit::are_kept(limits, run)).collect();
    let (hits, trials) = (good.iter().filter(|good| **good).count() as f64, good.len() as f64);
    let estimate = if trials > 0.0 { hits / trials } else { 0.5 };
    Share { estimate, interval: clopper_pearson(hits, trials, confidence), basis: Basis::Counted(doubt) }
}

/// What refutes the surrogate, if anything does: errors that are too large, or runs that are good or bad against what the others
/// say of them.
pub fn doubt(surrogate: &Surrogate, limits: &[Limit], runs: &[Run]) -> Option<Doubt> {
    let checks: Vec<Check> = surrogate.checks();
    for limit in limits {
        let relative = checks[limit.output].error / surrogate.spread(limit.output);
        if relative > LARGEST_ERROR {
            return Some(Doubt::Error { output: limit.output, relative });
        }
    }
    let fails = runs.iter().any(|run| run.finite().is_none());
    if fails && surrogate.success_error().is_none_or(|relative| relative > LARGEST_ERROR) {
        return Some(Doubt::Failures);
    }
    let succeeded: Vec<&Run> = runs.iter().filter(|run| run.finite().is_some()).collect();
    let (mut excess, mut variance) = (0.0, 0.0);
    for limit in limits {
        for (run, [mean, deviation]) in succeeded.iter().zip(surrogate.left_out(limit.output)) {
            let value = run.finite().map_or(f64::NAN, |values| values[limit.output]);
            let below = |end: f64| normal_below((end - mean) / deviation);
            // A surrogate is never surer of a sign than its number of runs allows.
            let least = 0.1 / succeeded.len() as f64;
            let good = (below(limit.range[1]) - below(limit.range[0])).clamp(least, 1.0 - least);
            let is_good = if limit.margin(value) >= 0.0 { 1.0 } else { 0.0 };
            excess += (is_good - good).powi(2) - good * (1.0 - good);
            variance += good * (1.0 - good) * (1.0 - 2.0 * good).powi(2);
        }
    }
    let deviations = excess / variance.sqrt();
    (deviations > REFUTED).then_some(Doubt::Signs { deviations })
}

/// The probability that a standard normal number is below another.
fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Which of `candidates` to run next so that the share gets known best: in turn the one whose sign is least known, as far as
/// those chosen before it do not tell it. Fewer than `count` where the signs of all others are known.
pub fn undecided(surrogate: &Surrogate, limits: &[Limit], candidates: &[Vec<f64>], count: usize) -> Vec<usize> {
    let mut margins = margins(surrogate, limits, candidates, EACH);
    let draws = margins.ncols() as f64;
    let open = |i: usize| {
        let good = margins.row(i).iter().filter(|m| **m >= 0.0).count() as f64 / draws;
        good * (1.0 - good)
    };
    let open: Vec<f64> = (0..candidates.len()).map(open).collect();
    for mut row in margins.row_iter_mut() {
        let mean = row.mean();
        row.add_scalar_mut(-mean);
    }
    let square = |margins: &DMatrix<f64>, i: usize| margins.row(i).norm_squared();
    let before: Vec<f64> = (0..candidates.len()).map(|i| square(&margins, i)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count {
        let score = |i: usize| if before[i] > 0.0 { open[i] * square(&margins, i) / before[i] } else { 0.0 };
        let free = (0..candidates.len()).filter(|i| !chosen.contains(i));
        let Some((best, worth)) = free.map(|i| (i, score(i))).max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        if worth <= 0.0 {
            break;
        }
        chosen.push(best);
        // What the chosen point's value tells of all others is no longer open.
        let row = margins.row(best).into_owned();
        let of_row = row.norm_squared();
        let told = &margins * row.transpose() / of_row;
        margins -= told * row;
    }
    chosen
}

/// Runs in batches: plain ones first, then in each batch a part that is plain (it tests the surrogate) and the rest near limits.
#[derive(Clone, Debug)]
pub struct Campaign {
    limits: Vec<Limit>,
    sample: Vec<Vec<f64>>,
    start: usize,
    seed: u64,
    points: Vec<Vec<f64>>,
    plain: Vec<bool>,
    outcomes: Vec<Option<Run>>,
    taken: usize,
    surrogate: Option<Surrogate>,
}

impl Campaign {
    /// Starts with the first `start` points of `sample`, a plain sample of the parameters each part of which is one too (a
    /// scrambled net, or independent points). Its first half gives the plain points, so it needs at least twice as many points
    /// as there will be runs; some 4,000 tell a share to 1.3 points.
    pub fn new(limits: Vec<Limit>, sample: Vec<Vec<f64>>, start: usize, seed: u64) -> Self {
        let (points, plain, outcomes) = (Vec::new(), Vec::new(), Vec::new());
        Self { limits, sample, start, seed, points, plain, outcomes, taken: 0, surrogate: None }
    }

    /// The numbers and points of the next batch of at most `count` runs. Empty as long as runs of an earlier one are missing, so
    /// that a batch does not depend on the order in which they come back.
    pub fn next(&mut self, count: usize) -> Vec<(usize, Vec<f64>)> {
        if self.outcomes.iter().any(Option::is_none) {
            return Vec::new();
        }
        let first = self.points.len();
        if self.taken < self.start {
            self.add_plain(count.min(self.start - self.taken));
        } else {
            self.fit();
            let near = count - count.div_ceil(5);
            // Plain points come from the first half, so that none of them was chosen before.
            let half = self.sample.len() / 2;
            let fresh = |i: &usize| !self.points.contains(&self.sample[*i]);
            let candidates: Vec<usize> = (half..self.sample.len()).filter(fresh).take(2048).collect();
            let of_candidates: Vec<Vec<f64>> = candidates.iter().map(|i| self.sample[*i].clone()).collect();
            let trusted = self.surrogate.as_ref().filter(|s| doubt(s, &self.limits, &self.runs()).is_none());
            let chosen = trusted.map_or(Vec::new(), |s| undecided(s, &self.limits, &of_candidates, near));
            for i in chosen {
                self.add(of_candidates[i].clone(), false);
            }
            self.add_plain(count - (self.points.len() - first));
        }
        (first..self.points.len()).map(|i| (i, self.points[i].clone())).collect()
    }

    fn add_plain(&mut self, count: usize) {
        let last = (self.taken + count).min(self.sample.len() / 2);
        for i in self.taken..last {
            self.add(self.sample[i].clone(), true);
        }
        self.taken = last;
    }

    fn add(&mut self, point: Vec<f64>, plain: bool) {
        self.points.push(point);
        self.plain.push(plain);
        self.outcomes.push(None);
    }

    /// Tells what a run of a batch gave; `None`: it failed.
    ///
    /// # Panics
    /// When no batch had this number.
    pub fn tell(&mut self, number: usize, values: Option<Vec<f64>>) {
        self.outcomes[number] = Some(Run { point: self.points[number].clone(), values });
        self.surrogate = None;
    }

    /// The runs told, in the order of their numbers.
    pub fn runs(&self) -> Vec<Run> {
        self.outcomes.iter().flatten().cloned().collect()
    }

    fn fit(&mut self) {
        if self.surrogate.is_none() {
            self.surrogate = Surrogate::fit(&self.runs(), &self.sample, None, self.seed).ok();
        }
    }

    /// The share by all runs told so far.
    pub fn share(&mut self, confidence: f64) -> Share {
        self.fit();
        let told = |(plain, run): (&bool, &Option<Run>)| run.is_some().then_some(*plain);
        let plain: Vec<bool> = self.plain.iter().zip(&self.outcomes).filter_map(told).collect();
        share(self.surrogate.as_ref(), &self.limits, &self.runs(), &plain, &self.sample, confidence)
    }

    /// The surrogate of all runs told so far. `None` where none fits.
    pub fn surrogate(&mut self) -> Option<&Surrogate> {
        self.fit();
        self.surrogate.as_ref()
    }
}

impl Surrogate {
    fn random(&self, stream: u32) -> Random {
        Random::new(self.seed(), Purpose::Surrogate, stream)
    }
}
