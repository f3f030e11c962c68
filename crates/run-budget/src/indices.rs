//! Sobol indices of an output, with intervals that contain the surrogate's error.

use crate::share::{Doubt, Drawn, LARGEST_ERROR, Limit, Possible, doubt};
use crate::surrogate::{Run, Surrogate};
use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Functions that are drawn from each member of an output's sample.
const EACH: usize = 8;
/// Parts of the points, each of which gives indices of its own: they scatter by the error of the points.
const PARTS: usize = 16;
/// Pairs of points at which functions are drawn. At all others, which tell of the tails, the most probable one takes their place.
const DRAWN: usize = 1024;

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
    let dimensions = a[0].len();
    // One after another, so that most coordinates, and their factors, are those of the point before.
    let together = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let mut points = vec![a.clone(); dimensions + 1];
        (0..dimensions).for_each(|k| points[1 + k][k] = b[k]);
        points.push(b.clone());
        points
    };
    let nearly = runs.iter().find_map(Run::finite).unwrap_or_default();
    let parts = |count: usize, of: &dyn Fn(&[Vec<f64>]) -> Possible| -> Vec<Vec<Part>> {
        let part = |(a, b): (&[Vec<f64>], &[Vec<f64>])| -> Vec<Part> {
            let points: Vec<Vec<f64>> = a.iter().zip(b).flat_map(together).collect();
            let possible = of(&points);
            let good = possible.margins(limits).map(|margin| if margin >= 0.0 { 1.0 } else { 0.0 });
            let values = possible.values.into_iter().chain([good]).zip(nearly.iter().chain([&0.0]));
            values.map(|(values, nearly)| Part::new(&values.add_scalar(-nearly), dimensions)).collect()
        };
        // Points of a net belong to the parts in turn, so that each part is spread like the whole.
        let size = count.div_ceil(PARTS);
        a[..count].chunks(size).zip(b[..count].chunks(size)).map(part).collect()
    };
    let likely = |points: &[Vec<f64>]| Possible::likely(surrogate, points);
    let few = a.len().min(DRAWN);
    let functions = Drawn::new(surrogate, EACH);
    let drawn = parts(few, &|points| functions.at(points, false));
    let [near, all] = [few, a.len()].map(|count| parts(count, &likely));
    let mut relative: Vec<f64> = surrogate.checks().iter().map(|check| check.relative).collect();
    let doubt_of =
        |(output, &relative): (usize, &f64)| (relative > LARGEST_ERROR).then_some(Doubt::Error { output, relative });
    let doubts: Vec<Option<Doubt>> =
        relative.iter().enumerate().map(doubt_of).chain([doubt(surrogate, limits, runs)]).collect();
    relative.push(limits.iter().map(|limit| relative[limit.output]).fold(0.0, f64::max));
    let found = |(output, doubt): (usize, Option<Doubt>)| {
        let told = || {
            let [drawn, near, all] = [&drawn, &near, &all].map(|parts| terms(parts, output));
            let one = |k: usize| {
                [0, 1].map(|which| {
                    index([&drawn[k][which], &near[k][which], &all[k][which]], relative[output].powi(2), confidence)
                })
            };
            (0..dimensions).map(one).collect()
        };
        doubt.map_or_else(|| Ok(told()), Err)
    };
    doubts.into_iter().enumerate().map(found).collect()
}

/// Sums over some pairs of points, by function that an output may be.
struct Part {
    pairs: f64,
    /// Of the values at both points, and of their squares.
    moments: Vec<[f64; 2]>,
    /// By parameter: of what it changes times the value at the second point, of what it changes, and of half the square of that.
    changes: Vec<Vec<[f64; 3]>>,
}

impl Part {
    /// Of values: a column a function, and of each pair a row of the first point, rows of it with one parameter of the second, and one
    /// of that.
    fn new(values: &DMatrix<f64>, dimensions: usize) -> Self {
        let functions = values.ncols();
        let mut moments = vec![[0.0; 2]; functions];
        let mut changes = vec![vec![[0.0; 3]; functions]; dimensions];
        for (k, (column, moments)) in values.column_iter().zip(&mut moments).enumerate() {
            for pair in column.as_slice().chunks(dimensions + 2) {
                let [a, b] = [pair[0], pair[dimensions + 1]];
                add(moments, [a + b, a * a + b * b]);
                for (changes, mixed) in changes.iter_mut().zip(&pair[1..]) {
                    let change = mixed - a;
                    add(&mut changes[k], [b * change, change, 0.5 * change * change]);
                }
            }
        }
        Self { pairs: (values.nrows() / (dimensions + 2)) as f64, moments, changes }
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

/// First and total index of each parameter in an output.
fn terms(parts: &[Vec<Part>], output: usize) -> Vec<[Terms; 2]> {
    let parts: Vec<&Part> = parts.iter().map(|part| &part[output]).collect();
    let pairs: f64 = parts.iter().map(|part| part.pairs).sum();
    let functions = parts[0].moments.len();
    let moments = |k: usize| {
        let mut sums = [0.0; 2];
        parts.iter().for_each(|part| add(&mut sums, part.moments[k]));
        let [mean, square] = sums.map(|sum| sum / (2.0 * pairs));
        [mean, square - mean * mean]
    };
    let moments: Vec<[f64; 2]> = (0..functions).map(moments).collect();
    let of_parameter = |parameter: usize| {
        let none = || Terms { by_function: vec![0.0; functions], by_part: vec![0.0; parts.len()] };
        let mut terms = [none(), none()];
        for (p, part) in parts.iter().enumerate() {
            for (k, [mean, variance]) in moments.iter().enumerate().filter(|(_, [_, variance])| *variance > 0.0) {
                let [with_b, change, square] = part.changes[parameter][k];
                for (terms, sum) in terms.iter_mut().zip([with_b - mean * change, square]) {
                    terms.by_function[k] += sum / variance / pairs;
                    terms.by_part[p] += sum / variance / functions as f64 / part.pairs;
                }
            }
        }
        terms
    };
    (0..parts[0].changes.len()).map(of_parameter).collect()
}

/// By functions that are drawn, by the most probable one at the same points, and by that at all points. `unexplained` is the part of
/// the variance that the surrogate misses when runs are left out. It may belong to any parameter, and a process smooths interactions
/// first, so it counts as a deviation of each index.
fn index([drawn, near, all]: [&Terms; 3], unexplained: f64, confidence: f64) -> Index {
    let spread = |values: &[f64]| {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        (mean, values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (count - 1.0))
    };
    let (mean, of_surrogate) = spread(&drawn.by_function);
    let estimate = mean + all.by_function[0] - near.by_function[0];
    // That of the few pairs, though the estimate's is smaller: it also stands for how little the runs tell of the tails.
    let count = drawn.by_part.len() as f64;
    let of_points = spread(&drawn.by_part).1 / count;
    let student = StudentsT::new(0.0, 1.0, count - 1.0).expect("its freedom is positive");
    let half =
        student.inverse_cdf(0.5 + 0.5 * confidence) * (of_surrogate + of_points + unexplained * unexplained).sqrt();
    let within = |v: f64| v.clamp(0.0, 1.0);
    Index { estimate: within(estimate), interval: [within(estimate - half), within(estimate + half)] }
}
