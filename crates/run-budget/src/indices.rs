//! Sobol indices of an output, with intervals that contain the surrogate's error.

use crate::share::{Doubt, LARGEST_ERROR, Limit, Possible, doubt};
use crate::surrogate::{Run, Surrogate};
use nalgebra::{DMatrix, DVectorView};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 8;
/// Parts of the points, each of which gives indices of its own: they scatter by the error of the points.
const PARTS: usize = 16;

/// An index with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Index {
    /// The mean over the functions that the output may be.
    pub estimate: f64,
    /// The interval at the level of confidence asked for.
    pub interval: [f64; 2],
}

/// First and total index of each parameter in every output and, last, in whether a point is good: it keeps all limits and does not
/// fail. `runs` are those of the surrogate. `a` and `b` are independent plain samples of as many points, at least 64, of parameters
/// that are independent of each other (the halves of a net of twice the dimensions). Noise takes no part.
///
/// Estimators: Saltelli et al. (2010), "Variance based sensitivity analysis of model output", table 2, b and f; draws of the
/// function: Le Gratiet, Cannamela & Iooss (2014), "A Bayesian approach for global sensitivity analysis of (multifidelity)
/// computer codes".
///
/// A doubt stands where the surrogate's error is too large to tell them.
pub fn indices(
    surrogate: &Surrogate,
    limits: &[Limit],
    runs: &[Run],
    [a, b]: [&[Vec<f64>]; 2],
    confidence: f64,
) -> Vec<Result<Vec<[Index; 2]>, Doubt>> {
    let at = |points: &[Vec<f64>]| -> Vec<DMatrix<f64>> {
        let possible = Possible::new(surrogate, points, EACH, false);
        let good = possible.margins(limits).map(|margin| if margin >= 0.0 { 1.0 } else { 0.0 });
        possible.values.into_iter().chain([good]).collect()
    };
    let checks = surrogate.checks();
    let relative: Vec<f64> = checks.iter().map(|check| check.relative).collect();
    let worst = limits.iter().map(|limit| relative[limit.output]).fold(0.0, f64::max);
    let doubt_of =
        |(output, &relative): (usize, &f64)| (relative > LARGEST_ERROR).then_some(Doubt::Error { output, relative });
    let doubts: Vec<Option<Doubt>> =
        relative.iter().enumerate().map(doubt_of).chain([doubt(surrogate, limits, runs)]).collect();
    let pairs = at(a).into_iter().zip(at(b)).zip(relative.iter().chain([&worst]));
    let functions: Vec<Functions> = pairs.map(|((a, b), relative)| Functions::new(a, b, relative * relative)).collect();
    let mut found = vec![Vec::new(); functions.len()];
    for parameter in 0..a[0].len() {
        let mut mixed = a.to_vec();
        mixed.iter_mut().zip(b).for_each(|(to, from)| to[parameter] = from[parameter]);
        for ((found, functions), mixed) in found.iter_mut().zip(&functions).zip(at(&mixed)) {
            found.push(functions.indices(&mixed, confidence));
        }
    }
    doubts.into_iter().zip(found).map(|(doubt, found)| doubt.map_or(Ok(found), Err)).collect()
}

/// Functions that an output may be: a row a point, a column a function.
struct Functions {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    /// Of each of them.
    moments: Vec<[f64; 2]>,
    /// The part of the variance that they miss.
    unexplained: f64,
}

impl Functions {
    fn new(a: DMatrix<f64>, b: DMatrix<f64>, unexplained: f64) -> Self {
        let moments = |(a, b): (DVectorView<'_, f64>, DVectorView<'_, f64>)| {
            let count = 2.0 * a.len() as f64;
            let mean = (a.sum() + b.sum()) / count;
            [mean, a.iter().chain(&b).map(|v| (v - mean).powi(2)).sum::<f64>() / count]
        };
        let moments = a.column_iter().zip(b.column_iter()).map(moments).collect();
        Self { a, b, moments, unexplained }
    }

    /// By their values where one parameter is that of `b`, and all others are those of `a`.
    fn indices(&self, mixed: &DMatrix<f64>, confidence: f64) -> [Index; 2] {
        let (points, draws) = mixed.shape();
        // Points of a net belong to the parts in turn, so that each part is spread like the whole.
        let part = |i: usize| i * PARTS / points;
        // By draw, and by part over all draws.
        let mut by_draw = [vec![0.0; draws], vec![0.0; draws]];
        let mut by_part = [[0.0; PARTS]; 2];
        let mut sizes = [0.0; PARTS];
        (0..points).for_each(|i| sizes[part(i)] += 1.0);
        for (k, [mean, variance]) in self.moments.iter().enumerate() {
            for i in 0..points {
                let (a, b, mixed) = (self.a[(i, k)], self.b[(i, k)], mixed[(i, k)]);
                let terms = [(b - mean) * (mixed - a), 0.5 * (mixed - a).powi(2)];
                for (which, term) in terms.into_iter().enumerate() {
                    let term = if *variance > 0.0 { term / variance } else { 0.0 };
                    by_draw[which][k] += term / points as f64;
                    by_part[which][part(i)] += term / (draws as f64 * sizes[part(i)]);
                }
            }
        }
        [0, 1].map(|which| index(&by_draw[which], &by_part[which], self.unexplained, confidence))
    }
}

/// `unexplained` is the part of the variance that the surrogate misses when runs are left out. It may belong to any parameter, and
/// a process smooths interactions first, so it counts as a deviation of each index.
fn index(by_draw: &[f64], by_part: &[f64], unexplained: f64, confidence: f64) -> Index {
    let spread = |values: &[f64]| {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0))
    };
    let (estimate, of_surrogate) = spread(by_draw);
    let of_points = spread(by_part).1 / by_part.len() as f64;
    let student = StudentsT::new(0.0, 1.0, by_part.len() as f64 - 1.0).expect("its freedom is positive");
    let half =
        student.inverse_cdf(0.5 + 0.5 * confidence) * (of_surrogate + of_points + unexplained * unexplained).sqrt();
    let within = |v: f64| v.clamp(0.0, 1.0);
    Index { estimate: within(estimate), interval: [within(estimate - half), within(estimate + half)] }
}
