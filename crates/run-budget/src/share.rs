//! The share of good points: by the surrogate with what it leaves open, or counted where it does not hold.

use crate::doubt::{Doubt, doubt};
use crate::limit::Limit;
use crate::possible::Possible;
use crate::surrogate::{Run, Surrogate};
use conformity::interval::clopper_pearson;
use nalgebra::DMatrix;

/// Functions that are drawn from each member of an output's sample.
pub const EACH: usize = 16;

/// What a share was found by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Basis {
    /// The surrogate. Its runs may have been chosen.
    Surrogate,
    /// Plain runs were counted, because the surrogate does not hold.
    Counted(Doubt),
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
        let possible = surrogate.as_ref().map(|surrogate| Possible::new(surrogate, sample, EACH));
        Self { runs, plain, surrogate, possible }
    }

    /// The share of points that keep all limits and do not fail: by the surrogate, or by counting plain runs where it does not
    /// hold.
    pub fn share(&self, limits: &[Limit]) -> Share {
        match self.surrogate.as_ref().zip(self.possible.as_ref()) {
            None => self.counted(limits, Doubt::Unfit),
            Some((surrogate, possible)) => match doubt(surrogate, limits, &self.runs) {
                Some(doubt) => self.counted(limits, doubt),
                None => of_surrogate(possible, limits),
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

/// The share of good points in the mean over the functions, with what they and the points leave open.
fn of_surrogate(possible: &Possible, limits: &[Limit]) -> Share {
    let margins = possible.margins(limits);
    let points = possible.points as f64;
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
