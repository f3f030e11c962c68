//! Sobol indices of an output, with intervals that contain the surrogate's error.

use crate::share::{Doubt, LARGEST_ERROR, Limit, Possible, doubt};
use crate::surrogate::{Run, Surrogate};
use nalgebra::DMatrix;
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

/// First and total index of each parameter in an output. `a` and `b` are independent plain samples of as many points, at least 64, of
/// parameters that are independent of each other (the halves of a net of twice the dimensions). Noise takes no part.
///
/// Estimators: Saltelli et al. (2010), "Variance based sensitivity analysis of model output", table 2, b and f; draws of the
/// function: Le Gratiet, Cannamela & Iooss (2014), "A Bayesian approach for global sensitivity analysis of (multifidelity)
/// computer codes".
///
/// # Errors
/// When the surrogate's error is too large to tell them.
pub fn indices(
    surrogate: &Surrogate,
    output: usize,
    a: &[Vec<f64>],
    b: &[Vec<f64>],
    confidence: f64,
) -> Result<Vec<[Index; 2]>, Doubt> {
    let relative = surrogate.checks()[output].error / surrogate.spread(output);
    if relative > LARGEST_ERROR {
        return Err(Doubt::Error { output, relative });
    }
    let functions = surrogate.functions(output, EACH);
    let at = |points: &[Vec<f64>]| functions.at(&surrogate.standard(points));
    Ok(of_functions(at, relative * relative, [a, b], confidence))
}

/// The same for whether a point is good: it keeps all limits and does not fail. `runs` are those of the surrogate.
///
/// # Errors
/// When the surrogate does not hold there.
pub fn indices_of_good(
    surrogate: &Surrogate,
    limits: &[Limit],
    runs: &[Run],
    [a, b]: [&[Vec<f64>]; 2],
    confidence: f64,
) -> Result<Vec<[Index; 2]>, Doubt> {
    if let Some(doubt) = doubt(surrogate, limits, runs) {
        return Err(doubt);
    }
    let checks = surrogate.checks();
    let relative = |limit: &Limit| checks[limit.output].error / surrogate.spread(limit.output);
    let worst = limits.iter().map(relative).fold(0.0, f64::max);
    let at = |points: &[Vec<f64>]| {
        let margins = Possible::new(surrogate, limits, points, EACH, false).margins(limits);
        margins.map(|margin| if margin >= 0.0 { 1.0 } else { 0.0 })
    };
    Ok(of_functions(at, worst * worst, [a, b], confidence))
}

/// The indices over all columns of `at`, the values of functions at points. `unexplained` is the part of the variance that these
/// miss.
fn of_functions(
    at: impl Fn(&[Vec<f64>]) -> DMatrix<f64>,
    unexplained: f64,
    [a, b]: [&[Vec<f64>]; 2],
    confidence: f64,
) -> Vec<[Index; 2]> {
    let (of_a, of_b) = (at(a), at(b));
    let (points, draws) = of_a.shape();
    // Points of a net belong to the parts in turn, so that each part is spread like the whole.
    let part = |i: usize| i * PARTS / points;
    let means: Vec<f64> =
        (0..draws).map(|k| (of_a.column(k).sum() + of_b.column(k).sum()) / (2 * points) as f64).collect();
    let mut variances = vec![0.0; draws];
    for k in 0..draws {
        let square = |v: &f64| (v - means[k]).powi(2);
        variances[k] = (of_a.column(k).iter().map(square).sum::<f64>()
            + of_b.column(k).iter().map(square).sum::<f64>())
            / (2 * points) as f64;
    }
    let one = |parameter: usize| {
        let mut mixed = a.to_vec();
        mixed.iter_mut().zip(b).for_each(|(to, from)| to[parameter] = from[parameter]);
        let of_mixed = at(&mixed);
        // By draw, and by part over all draws.
        let mut by_draw = [vec![0.0; draws], vec![0.0; draws]];
        let mut by_part = [[0.0; PARTS]; 2];
        let mut sizes = [0.0; PARTS];
        (0..points).for_each(|i| sizes[part(i)] += 1.0);
        for k in 0..draws {
            for i in 0..points {
                let (a, b, mixed) = (of_a[(i, k)], of_b[(i, k)], of_mixed[(i, k)]);
                let terms = [(b - means[k]) * (mixed - a), 0.5 * (mixed - a).powi(2)];
                for (which, term) in terms.into_iter().enumerate() {
                    let term = if variances[k] > 0.0 { term / variances[k] } else { 0.0 };
                    by_draw[which][k] += term / points as f64;
                    by_part[which][part(i)] += term / (draws as f64 * sizes[part(i)]);
                }
            }
        }
        [0, 1].map(|which| index(&by_draw[which], &by_part[which], unexplained, confidence))
    };
    (0..a[0].len()).map(one).collect()
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
