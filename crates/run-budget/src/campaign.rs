//! Which points are run, batch by batch.

use crate::doubt::doubt;
use crate::limit::Limit;
use crate::possible::Possible;
use crate::refine::{centre, close, in_turn};
use crate::share::{Answers, EACH};
use crate::surrogate::{Run, Surrogate};
use nalgebra::DMatrix;

/// Points among which those near limits are chosen.
const CANDIDATES: usize = 1024;
/// All functions that are drawn lie within so many deviations of the most probable one.
const SURE: f64 = 10.0;

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
                undecided(Possible::new(s, &at(&candidates), EACH).margins(&self.limits), count / 2)
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
    let before: Vec<f64> = margins.row_iter().map(|row| row.norm_squared()).collect();
    in_turn(&mut margins, [candidates, count], close, |margins, i| {
        // Margins so wide that their squares are infinite leave nothing open.
        let worth = open[i] * margins.row(i).norm_squared() / before[i];
        (worth > 0.0).then_some(worth)
    })
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
    let success = surrogate
        .success
        .as_ref()
        .map(|success| success.at_once(&standard).into_iter().map(|[mean, deviation]| mean / deviation).collect());
    let sure: Vec<Vec<f64>> = limits.iter().map(of_limit).chain(success).collect();
    let least = |i: usize| sure.iter().map(|of| of[i]).fold(f64::INFINITY, f64::min);
    (0..points.len()).map(|i| least(i).abs() < SURE).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sampling::random::{Purpose, Random};

    /// The part of them that is left would be no number.
    #[test]
    fn margins_whose_squares_are_infinite_are_not_chosen() {
        let wide = DMatrix::from_row_slice(2, 2, &[-1e200, 1e200, -1.0, 1.0]);
        assert_eq!(undecided(wide, 2), [1]);
    }

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
        let margins = Possible::new(&surrogate, &points, 16).margins(&limits);
        for (open, margins) in open.iter().zip(margins.row_iter()) {
            let below = margins.iter().filter(|m| **m < 0.0).count();
            assert!(*open || below == 0 || below == margins.len(), "{below} of {}", margins.len());
        }
        let count = open.iter().filter(|open| **open).count();
        assert!((1..300).contains(&count), "{count}");
        assert!(undecided(Possible::new(&surrogate, &[], 16).margins(&limits), 3).is_empty());
    }
}
