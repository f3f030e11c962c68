//! Sobol indices of an output, with intervals that contain the surrogate's error.

use crate::doubt::{Doubt, LARGEST_ERROR, doubt};
use crate::limit::Limit;
use crate::possible::{Drawn, Possible};
use crate::surrogate::{Run, Surrogate};
use nalgebra::DMatrix;
use sampling::statistics::moments::{mean, variance};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 8;
/// Parts of the points, each of which gives indices of its own: they scatter by the error of the points.
const PARTS: usize = 16;
/// Pairs of points at which functions are drawn for Sobol indices.
const DRAWN: usize = 1024;

/// An index with its interval.
#[derive(Clone, Copy, Debug)]
pub struct Index {
    /// The mean over the functions that the output may be.
    pub estimate: f64,
    /// The interval at the level of confidence asked for.
    pub interval: [f64; 2],
}

/// By number of a pair and the values at its points: numbers [x, y] of each measure. A measure is the mean of x - m y over the variance,
/// where m is the mean value.
pub type Explained<'a> = &'a dyn Fn(usize, &[f64]) -> Vec<[f64; 2]>;

/// Points at which the surrogate is asked, and what their values tell of an output's variance.
pub struct Design<'a> {
    /// For each pair of independent plain points these two, then others that are made of them.
    pub points: &'a [Vec<f64>],
    /// Points of each pair.
    pub width: usize,
    /// Pairs at which functions are drawn. At all others, which tell of the tails, the most probable one takes their place.
    pub drawn: usize,
    /// What these values explain.
    pub explained: Explained<'a>,
}

/// First and total index of each parameter in every output and, last, in whether a point is good: it keeps all limits and does not
/// fail. `runs` are those of the surrogate. `a` and `b` are independent plain samples of as many points, at least 64, of parameters
/// that are independent of each other (the halves of a net of twice the dimensions). Noise takes no part.
///
/// Estimators: Saltelli et al. (2010), "Variance based sensitivity analysis of model output", table 2, b and f.
///
/// A doubt stands where the surrogate's error is too large to tell them.
pub fn indices(
    surrogate: &Surrogate,
    limits: &[Limit],
    runs: &[Run],
    [a, b]: [&[Vec<f64>]; 2],
    confidence: f64,
) -> Vec<Result<Vec<[Index; 2]>, Doubt>> {
    let dimensions = a[0].len();
    let together = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let mut points = vec![a.clone(); dimensions + 2];
        points[1].clone_from(b);
        (0..dimensions).for_each(|k| points[2 + k][k] = b[k]);
        points
    };
    let points: Vec<Vec<f64>> = a.iter().zip(b).flat_map(together).collect();
    let explained = |_, values: &[f64]| {
        let of = |mixed: &f64| {
            let change = mixed - values[0];
            [[values[1] * change, change], [0.5 * change * change, 0.0]]
        };
        values[2..].iter().flat_map(of).collect()
    };
    let design = Design { points: &points, width: dimensions + 2, drawn: DRAWN, explained: &explained };
    let both = |found: Vec<Index>| found.chunks(2).map(|index| [index[0], index[1]]).collect();
    measures(surrogate, limits, runs, &design, confidence).into_iter().map(|found| found.map(both)).collect()
}

/// The measures of a design, of at least 64 pairs, in every output and, last, in whether a point is good.
///
/// Draws of the function: Le Gratiet, Cannamela & Iooss (2014), "A Bayesian approach for global sensitivity analysis of
/// (multifidelity) computer codes".
///
/// A doubt stands where the surrogate's error is too large to tell them.
pub fn measures(
    surrogate: &Surrogate,
    limits: &[Limit],
    runs: &[Run],
    design: &Design,
    confidence: f64,
) -> Vec<Result<Vec<Index>, Doubt>> {
    let pairs = design.points.len() / design.width;
    let nearly = runs.iter().find_map(Run::finite).unwrap_or_default();
    let parts = |count: usize, of: &dyn Fn(&[Vec<f64>]) -> Possible| -> Vec<Vec<PairSums>> {
        // Consecutive points of a net are spread like the whole, and so is each part.
        let size = count.div_ceil(PARTS);
        let part = |(number, points): (usize, &[Vec<f64>])| -> Vec<PairSums> {
            let possible = of(points);
            let good = possible.margins(limits).map(|margin| f64::from(margin >= 0.0));
            let values = possible.values.into_iter().chain([good]).zip(nearly.iter().chain([&0.0]));
            values.map(|(values, nearly)| PairSums::new(&values.add_scalar(-nearly), number * size, design)).collect()
        };
        design.points[..count * design.width].chunks(size * design.width).enumerate().map(part).collect()
    };
    let likely = |points: &[Vec<f64>]| Possible::likely(surrogate, points);
    let few = pairs.min(design.drawn);
    let functions = Drawn::new(surrogate, EACH);
    let drawn = parts(few, &|points| functions.at(points, false));
    let [near, all] = [few, pairs].map(|count| parts(count, &likely));
    let mut relative: Vec<f64> = surrogate.checks().iter().map(|check| check.relative).collect();
    let doubt_of =
        |(output, &relative): (usize, &f64)| (relative > LARGEST_ERROR).then_some(Doubt::Error { output, relative });
    let doubts: Vec<Option<Doubt>> =
        relative.iter().enumerate().map(doubt_of).chain([doubt(surrogate, limits, runs)]).collect();
    relative.push(limits.iter().map(|limit| relative[limit.output]).fold(0.0, f64::max));
    let found = |(output, doubt): (usize, Option<Doubt>)| {
        let told = || {
            let [drawn, near, all] = [&drawn, &near, &all].map(|parts| terms(parts, output));
            let three = drawn.iter().zip(&near).zip(&all);
            three.map(|((drawn, near), all)| index([drawn, near, all], relative[output].powi(2), confidence)).collect()
        };
        doubt.map_or_else(|| Ok(told()), Err)
    };
    doubts.into_iter().enumerate().map(found).collect()
}

/// Sums over some pairs of points, by function that an output may be.
struct PairSums {
    pairs: f64,
    /// Of the values at both points, and of their squares.
    moments: Vec<[f64; 2]>,
    /// By measure: of what its design explains.
    explained: Vec<Vec<[f64; 2]>>,
}

impl PairSums {
    /// Of values: a row a point of a design, from the pair `start` on, a column a function.
    fn new(values: &DMatrix<f64>, start: usize, design: &Design) -> Self {
        let functions = values.ncols();
        let mut moments = vec![[0.0; 2]; functions];
        let mut explained: Vec<Vec<[f64; 2]>> = Vec::new();
        for (k, (column, moments)) in values.column_iter().zip(&mut moments).enumerate() {
            for (pair, values) in (start..).zip(column.as_slice().chunks(design.width)) {
                let [a, b] = [values[0], values[1]];
                add(moments, [a + b, a * a + b * b]);
                let terms = (design.explained)(pair, values);
                explained.resize(terms.len(), vec![[0.0; 2]; functions]);
                explained.iter_mut().zip(terms).for_each(|(sums, terms)| add(&mut sums[k], terms));
            }
        }
        Self { pairs: (values.nrows() / design.width) as f64, moments, explained }
    }
}

fn add<const N: usize>(sums: &mut [f64; N], terms: [f64; N]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

/// An index by function, and by part over all functions.
struct Terms {
    by_function: Vec<f64>,
    by_part: Vec<f64>,
}

/// Each measure in an output.
fn terms(parts: &[Vec<PairSums>], output: usize) -> Vec<Terms> {
    let parts: Vec<&PairSums> = parts.iter().map(|part| &part[output]).collect();
    let pairs: f64 = parts.iter().map(|part| part.pairs).sum();
    let functions = parts[0].moments.len();
    let moments = |k: usize| {
        let mut sums = [0.0; 2];
        parts.iter().for_each(|part| add(&mut sums, part.moments[k]));
        let [mean, square] = sums.map(|sum| sum / (2.0 * pairs));
        [mean, square - mean * mean]
    };
    let moments: Vec<[f64; 2]> = (0..functions).map(moments).collect();
    let of_measure = |measure: usize| {
        let mut terms = Terms { by_function: vec![0.0; functions], by_part: vec![0.0; parts.len()] };
        for (p, part) in parts.iter().enumerate() {
            for (k, [mean, variance]) in moments.iter().enumerate().filter(|(_, [_, variance])| *variance > 0.0) {
                let [x, y] = part.explained[measure][k];
                let sum = x - mean * y;
                terms.by_function[k] += sum / variance / pairs;
                terms.by_part[p] += sum / variance / functions as f64 / part.pairs;
            }
        }
        terms
    };
    (0..parts[0].explained.len()).map(of_measure).collect()
}

/// By functions that are drawn, by the most probable one at the same points, and by that at all points. `unexplained` is the part of
/// the variance that the surrogate misses when runs are left out. It may belong to any parameter, and a process smooths interactions
/// first, so it counts as a deviation of each index.
fn index([drawn, near, all]: [&Terms; 3], unexplained: f64, confidence: f64) -> Index {
    let of_surrogate = variance(&drawn.by_function, 1);
    let estimate = mean(&drawn.by_function) + all.by_function[0] - near.by_function[0];
    // That of the few pairs, though the estimate's is smaller: it also stands for how little the runs tell of the tails.
    let count = drawn.by_part.len() as f64;
    let of_points = variance(&drawn.by_part, 1) / count;
    let student = StudentsT::new(0.0, 1.0, count - 1.0).expect("its freedom is positive");
    let half =
        student.inverse_cdf(0.5 + 0.5 * confidence) * (of_surrogate + of_points + unexplained * unexplained).sqrt();
    let within = |v: f64| v.clamp(0.0, 1.0);
    Index { estimate: within(estimate), interval: [within(estimate - half), within(estimate + half)] }
}
