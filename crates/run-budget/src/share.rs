//! The share of good points: by the surrogate with what it leaves open, or counted where it does not hold.

use crate::output::{Functions, Output};
use crate::refine::{centre, close};
use crate::surrogate::{Run, Surrogate};
use conformity::interval::clopper_pearson;
use nalgebra::DMatrix;

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 16;
/// Points among which those near limits are chosen.
const CANDIDATES: usize = 1024;
/// Noise of so small a part of an output's deviation changes no sign.
const NO_NOISE: f64 = 1e-4;
/// All functions that are drawn lie within so many deviations of the most probable one.
const SURE: f64 = 10.0;
/// Errors of runs left out, over the deviation of the output, from which on the surrogate is asked only where hardly a sign
/// depends on them.
pub const LARGEST_ERROR: f64 = 0.2;
/// Hardly a sign depends on errors that leave open no more than this part of the variance of the signs.
const LARGEST_OPEN: f64 = 0.1;
/// So many deviations more wrong signs among the runs left out than their probabilities say refute the surrogate.
pub const REFUTED: f64 = 2.5;

/// A requirement: an output lies within both ends. Infinite ends are none.
#[derive(Clone, Copy, Debug)]
pub struct Limit {
    /// The number of the output.
    pub output: usize,
    /// The least and the largest value that are good.
    pub range: [f64; 2],
}

impl Limit {
    pub(crate) fn margin(&self, value: f64) -> f64 {
        (value - self.range[0]).min(self.range[1] - value)
    }

    /// Whether a run is good: it succeeded, and no margin is negative.
    pub fn are_kept(limits: &[Self], run: &Run) -> bool {
        run.finite().is_some_and(|values| limits.iter().all(|limit| limit.margin(values[limit.output]) >= 0.0))
    }
}

/// What may become of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// It succeeds and keeps all limits.
    Kept,
    /// It succeeds and misses a limit.
    Missed,
    /// It fails.
    Failed,
}

impl Event {
    /// Whether a run is one.
    pub fn is(self, limits: &[Limit], run: &Run) -> bool {
        match self {
            Self::Kept => Limit::are_kept(limits, run),
            Self::Missed => run.finite().is_some() && !Limit::are_kept(limits, run),
            Self::Failed => run.finite().is_none(),
        }
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

/// A share, known as well as by some number of plain points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// The share of good points.
    pub estimate: f64,
    /// So many independent plain points would leave as much open.
    pub trials: f64,
    /// What it was found by.
    pub basis: Basis,
}

impl Share {
    /// Its interval (Clopper and Pearson's).
    pub fn interval(&self, confidence: f64) -> [f64; 2] {
        clopper_pearson(self.estimate * self.trials, self.trials, confidence)
    }
}

/// Functions that the outputs of a model may be, drawn once to be asked at many points.
pub struct Drawn<'a> {
    surrogate: &'a Surrogate,
    outputs: Vec<Functions<'a>>,
    success: Option<Functions<'a>>,
}

impl<'a> Drawn<'a> {
    /// `each` functions of each member of an output's sample.
    pub fn new(surrogate: &'a Surrogate, each: usize) -> Self {
        let outputs = (0..surrogate.outputs.len()).map(|output| surrogate.functions(output, each)).collect();
        Self { surrogate, outputs, success: surrogate.success(each) }
    }

    /// Their values, with noise or without it.
    pub fn at(&self, points: &[Vec<f64>], noise: bool) -> Possible {
        let Self { surrogate, outputs, success } = self;
        let standard = surrogate.standard(points);
        let of = |(output, functions): (usize, &Functions<'_>)| {
            let mut values = functions.at(&standard);
            let mut random = surrogate.random(4000 + output as u32);
            let least = if noise { NO_NOISE * surrogate.spread(output) } else { f64::INFINITY };
            for (mut column, error) in values.column_iter_mut().zip(functions.noise()).filter(|(_, e)| *e > least) {
                column.iter_mut().for_each(|v| *v += error * random.normal());
            }
            values
        };
        Possible {
            values: outputs.iter().enumerate().map(of).collect(),
            success: success.as_ref().map(|functions| functions.at(&standard)),
            spreads: surrogate.outputs.iter().map(|output| output.unit).collect(),
            points: points.len(),
        }
    }
}

/// Values at points of functions that the model may be: a row a point, a column a function.
#[derive(Clone, Debug)]
pub struct Possible {
    /// By output.
    pub values: Vec<DMatrix<f64>>,
    /// Where it is negative a run would fail.
    success: Option<DMatrix<f64>>,
    spreads: Vec<f64>,
    points: usize,
}

impl Possible {
    /// Of functions that are asked only here; see [`Drawn`].
    pub fn new(surrogate: &Surrogate, points: &[Vec<f64>], each: usize, noise: bool) -> Self {
        Drawn::new(surrogate, each).at(points, noise)
    }

    /// The most probable functions alone.
    pub fn likely(surrogate: &Surrogate, points: &[Vec<f64>]) -> Self {
        let standard = surrogate.standard(points);
        let of = |output: &Output| DMatrix::from_vec(points.len(), 1, output.means(&standard));
        Self {
            values: surrogate.outputs.iter().map(of).collect(),
            success: surrogate.success.as_ref().map(of),
            spreads: surrogate.outputs.iter().map(|output| output.unit).collect(),
            points: points.len(),
        }
    }

    /// The least margin over all limits, in deviations of the outputs, and below 0 where a run would fail.
    pub fn margins(&self, limits: &[Limit]) -> DMatrix<f64> {
        let mut least = self.success.clone();
        for limit in limits {
            let margins = self.values[limit.output].map(|v| limit.margin(v) / self.spreads[limit.output]);
            least = Some(match least {
                None => margins,
                Some(before) => before.zip_map(&margins, f64::min),
            });
        }
        least.unwrap_or_else(|| DMatrix::repeat(self.points, 1, 1.0))
    }

    /// Below 0 where an event happens.
    pub fn event(&self, event: Event, limits: &[Limit]) -> DMatrix<f64> {
        match (event, &self.success) {
            (Event::Kept, _) => -self.margins(limits),
            (Event::Failed, Some(success)) => success.clone(),
            (Event::Failed, None) => DMatrix::repeat(self.points, 1, 1.0),
            (Event::Missed, None) => self.margins(limits),
            (Event::Missed, Some(success)) => {
                let ended = Self { success: None, ..self.clone() };
                ended.margins(limits).zip_map(success, |margin, success| margin.max(-success))
            }
        }
    }

    /// The share of good points in the mean over the functions, with what they and the points leave open.
    fn share(&self, limits: &[Limit]) -> Share {
        let margins = self.margins(limits);
        let points = self.points as f64;
        let good = |column: usize| margins.column(column).iter().filter(|m| **m >= 0.0).count() as f64 / points;
        let shares: Vec<f64> = (0..margins.ncols()).map(good).collect();
        let draws = shares.len() as f64;
        let estimate = shares.iter().sum::<f64>() / draws;
        let between = shares.iter().map(|s| (s - estimate).powi(2)).sum::<f64>() / (draws - 1.0).max(1.0);
        // As many plain points as would leave as much open: surrogate's error and that of the sample, which is at most that
        // of independent points. Half a point is always open.
        let inner = estimate.clamp(0.5 / points, 1.0 - 0.5 / points);
        let trials = inner * (1.0 - inner) / (inner * (1.0 - inner) / points + between);
        Share { estimate, trials, basis: Basis::Surrogate }
    }
}

/// What refutes the surrogate, if anything does: errors that are too large, or runs that are good or bad against what the others
/// say of them.
pub fn doubt(surrogate: &Surrogate, limits: &[Limit], runs: &[Run]) -> Option<Doubt> {
    let succeeded: Vec<&[f64]> = runs.iter().filter_map(Run::finite).collect();
    let told_by = |limit: &Limit| -> Vec<[f64; 2]> {
        let told = |(values, [mean, deviation]): (&&[f64], &[f64; 2])| {
            let below = |end: f64| normal_below((end - mean) / deviation);
            let is_good = if limit.margin(values[limit.output]) >= 0.0 { 1.0 } else { 0.0 };
            [below(limit.range[1]) - below(limit.range[0]), is_good]
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

/// The probability that a standard normal number is below another.
fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

/// Which of the points to run next so that the share gets known best, by the margins that they may have (a row a point, a column
/// a function): in turn the one whose sign is least known, as far as those chosen before it do not tell it. Fewer than `count`
/// where the signs of all others are known.
pub fn undecided(mut margins: DMatrix<f64>, count: usize) -> Vec<usize> {
    let draws = margins.ncols() as f64;
    let open = |i: usize| {
        let good = margins.row(i).iter().filter(|m| **m >= 0.0).count() as f64 / draws;
        good * (1.0 - good)
    };
    let candidates = margins.nrows();
    let open: Vec<f64> = (0..candidates).map(open).collect();
    centre(&mut margins);
    let square = |margins: &DMatrix<f64>, i: usize| margins.row(i).norm_squared();
    let before: Vec<f64> = (0..candidates).map(|i| square(&margins, i)).collect();
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < count {
        let score = |i: usize| {
            // Margins so wide that their squares are infinite leave nothing open.
            if open[i] > 0.0 && before[i] > 0.0 { open[i] * square(&margins, i) / before[i] } else { 0.0 }
        };
        let free = (0..candidates).filter(|i| !chosen.contains(i));
        let Some((best, worth)) = free.map(|i| (i, score(i))).max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        if worth <= 0.0 {
            break;
        }
        chosen.push(best);
        close(&mut margins, best);
    }
    chosen
}

/// Whether what becomes of points may be open. Of others the most probable functions are so sure that it is worth drawing none.
fn may_be_open(surrogate: &Surrogate, limits: &[Limit], points: &[Vec<f64>]) -> Vec<bool> {
    let standard = surrogate.standard(points);
    let of_limit = |limit: &Limit| {
        let output = &surrogate.outputs[limit.output];
        let noise = output.check.widening * output.check.noise.sqrt() * output.unit;
        let sure = |[mean, deviation]: [f64; 2]| limit.margin(mean) / deviation.hypot(noise);
        output.at_once(&standard).into_iter().map(sure).collect()
    };
    let success = surrogate.success_at_once(&standard);
    let success = success.map(|told| told.into_iter().map(|[mean, deviation]| mean / deviation).collect());
    let sure: Vec<Vec<f64>> = limits.iter().map(of_limit).chain(success).collect();
    let least = |i: usize| sure.iter().map(|of| of[i]).fold(f64::INFINITY, f64::min);
    (0..points.len()).map(|i| least(i).abs() < SURE).collect()
}

/// Runs in batches: plain ones first, then in each batch a half that is plain (it tests the surrogate) and a half near limits.
/// What a batch is does not depend on how many are to follow.
#[derive(Clone, Debug)]
pub struct Campaign {
    limits: Vec<Limit>,
    sample: Vec<Vec<f64>>,
    start: usize,
    seed: u64,
    /// The runs, as places in the sample.
    places: Vec<usize>,
    outcomes: Vec<Option<Run>>,
    /// So many plain points are taken.
    taken: usize,
    /// The last surrogate, of fewer runs than there are now.
    earlier: Option<Surrogate>,
}

impl Campaign {
    /// Starts with the first `start` points of `sample`, a plain sample of the parameters each part of which is one too (a
    /// scrambled net, or independent points). Its first half gives the plain points, so it needs at least twice as many points
    /// as there will be runs; some 4,000 tell a share to 1.3 points.
    pub fn new(limits: Vec<Limit>, sample: Vec<Vec<f64>>, start: usize, seed: u64) -> Self {
        let (places, outcomes) = (Vec::new(), Vec::new());
        Self { limits, sample, start, seed, places, outcomes, taken: 0, earlier: None }
    }

    /// The next batch of at most `count` runs, as places in the sample. Empty as long as outcomes of an earlier one are missing,
    /// so that a batch does not depend on the order in which they come back.
    pub fn next(&mut self, count: usize) -> Vec<usize> {
        if self.outcomes.iter().any(Option::is_none) {
            return Vec::new();
        }
        let first = self.places.len();
        if self.taken < self.start {
            self.add_plain(count.min(self.start - self.taken));
        } else {
            let runs = self.runs();
            self.earlier = Surrogate::fit(&runs, &self.sample, self.earlier.as_ref(), self.seed).ok();
            // Plain points come from the first half, so that none of them was chosen before.
            let fresh = |place: &usize| !self.places.contains(place);
            let mut candidates: Vec<usize> =
                (self.sample.len() / 2..self.sample.len()).filter(fresh).take(CANDIDATES).collect();
            let at = |places: &[usize]| places.iter().map(|place| self.sample[*place].clone()).collect::<Vec<_>>();
            let trusted = self.earlier.as_ref().filter(|s| doubt(s, &self.limits, &runs).is_none());
            let chosen = trusted.map_or(Vec::new(), |s| {
                let mut open = may_be_open(s, &self.limits, &at(&candidates)).into_iter();
                candidates.retain(|_| open.next() == Some(true));
                undecided(Possible::new(s, &at(&candidates), EACH, true).margins(&self.limits), count / 2)
            });
            self.places.extend(chosen.into_iter().map(|chosen| candidates[chosen]));
            self.add_plain(count - (self.places.len() - first));
        }
        self.outcomes.resize(self.places.len(), None);
        self.places[first..].to_vec()
    }

    fn add_plain(&mut self, count: usize) {
        let last = (self.taken + count).min(self.sample.len() / 2);
        self.places.extend(self.taken..last);
        self.taken = last;
    }

    /// Tells what the run of this number gave, counted over all batches; `None`: it failed.
    ///
    /// # Panics
    /// When no batch had this number.
    pub fn tell(&mut self, number: usize, values: Option<Vec<f64>>) {
        let point = self.sample[self.places[number]].clone();
        self.outcomes[number] = Some(Run { point, values });
    }

    /// The runs told, in the order of their numbers.
    pub fn runs(&self) -> Vec<Run> {
        self.outcomes.iter().flatten().cloned().collect()
    }

    /// What all runs told so far say.
    pub fn answers(&self) -> Answers {
        let told = self.places.iter().zip(&self.outcomes);
        let is_plain = |(place, run): (&usize, &Option<Run>)| run.is_some().then_some(*place < self.sample.len() / 2);
        let plain = told.filter_map(is_plain).collect();
        Answers::new(self.runs(), plain, &self.sample, self.earlier.as_ref(), self.seed)
    }
}

/// What runs say of a plain sample.
#[derive(Clone, Debug)]
pub struct Answers {
    /// The runs.
    pub runs: Vec<Run>,
    /// Which of the runs are a plain sample of the parameters, too. The others were chosen.
    pub plain: Vec<bool>,
    /// The surrogate; none where none fits.
    pub surrogate: Option<Surrogate>,
    possible: Option<Possible>,
}

impl Answers {
    /// What `runs` say of a plain `sample`; `plain` tells which of them are one, too.
    pub fn new(runs: Vec<Run>, plain: Vec<bool>, sample: &[Vec<f64>], earlier: Option<&Surrogate>, seed: u64) -> Self {
        let surrogate = Surrogate::fit(&runs, sample, earlier, seed).ok();
        let possible = surrogate.as_ref().map(|surrogate| Possible::new(surrogate, sample, EACH, true));
        Self { runs, plain, surrogate, possible }
    }

    /// The share of points that keep all limits and do not fail: by the surrogate, or by counting plain runs where it does not
    /// hold.
    pub fn share(&self, limits: &[Limit]) -> Share {
        match self.surrogate.as_ref().zip(self.possible.as_ref()) {
            None => self.counted(limits, Doubt::Unfit),
            Some((surrogate, possible)) => match doubt(surrogate, limits, &self.runs) {
                Some(doubt) => self.counted(limits, doubt),
                None => possible.share(limits),
            },
        }
    }

    /// Outcomes at the points of the sample, those of each point by another function that the model may be; `None` at a point
    /// where the run would fail. Nothing where no surrogate fits.
    pub fn outcomes(&self) -> Vec<Option<Vec<f64>>> {
        let Some(Possible { values, success, points, .. }) = &self.possible else {
            return Vec::new();
        };
        let columns = values.first().map(DMatrix::ncols).unwrap_or(1);
        let outcome = |i: usize| {
            let k = i % columns;
            let fails = success.as_ref().is_some_and(|success| success[(i, k)] < 0.0);
            (!fails).then(|| values.iter().map(|values| values[(i, k)]).collect())
        };
        (0..*points).map(outcome).collect()
    }

    fn counted(&self, limits: &[Limit], doubt: Doubt) -> Share {
        let plain = self.runs.iter().zip(&self.plain).filter(|(_, plain)| **plain);
        let good: Vec<bool> = plain.map(|(run, _)| Limit::are_kept(limits, run)).collect();
        let (hits, trials) = (good.iter().filter(|good| **good).count() as f64, good.len() as f64);
        let estimate = if trials > 0.0 { hits / trials } else { 0.5 };
        Share { estimate, trials, basis: Basis::Counted(doubt) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::{Purpose, Random};

    /// A point of which no function is drawn is on one side by all of them.
    #[test]
    fn what_is_sure_is_not_drawn() {
        let mut random = Random::new(2, Purpose::Unstated, 0);
        let points: Vec<Vec<f64>> = (0..400).map(|_| random.normals(3)).collect();
        let of = |x: &[f64]| (x[1] < 1.0).then(|| vec![x[0] + 0.3 * x[1] * x[1] + (0.5 * x[2]).sin()]);
        let runs: Vec<Run> = points[..60].iter().map(|x| Run { point: x.clone(), values: of(x) }).collect();
        let surrogate = Surrogate::fit(&runs, &points, None, 1).unwrap();
        let limits = [Limit { output: 0, range: [-1.0, 1.5] }];
        let open = may_be_open(&surrogate, &limits, &points);
        let margins = Possible::new(&surrogate, &points, 16, true).margins(&limits);
        for (open, margins) in open.iter().zip(margins.row_iter()) {
            let below = margins.iter().filter(|m| **m < 0.0).count();
            assert!(*open || below == 0 || below == margins.len(), "{below} of {}", margins.len());
        }
        let count = open.iter().filter(|open| **open).count();
        assert!((1..300).contains(&count), "{count}");
        assert!(undecided(Possible::new(&surrogate, &[], 16, true).margins(&limits), 3).is_empty());
    }
}
