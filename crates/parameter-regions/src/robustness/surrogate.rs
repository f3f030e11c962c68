//! A polynomial that stands in for the model, with its cross-validated error.
//!
//! Polynomial chaos by regression: Hermite polynomials of the standardised parameters, total degree
//! and interactions limited by a hyperbolic norm; Blatman & Sudret (2011), "Adaptive sparse
//! polynomial chaos expansion based on least angle regression", J. Computational Physics 230,
//! equations 14-16. The degree is the one with the least leave-one-out error.

use nalgebra::{DMatrix, DVector};
use sampling::statistics::moments::{deviation, mean, moderate_unit};
use serde::{Deserialize, Serialize};

/// How well a surrogate predicts points that it was not fitted to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Highest total degree.
    pub degree: usize,
    /// Number of terms.
    pub terms: usize,
    /// Points fitted.
    pub points: usize,
    /// Root mean square of the leave-one-out errors, in the output's unit.
    pub error: f64,
    /// Part of the variance that is predicted, by leave-one-out: 1 perfect, 0 no better than the mean.
    pub predicted: f64,
}

/// The terms of a polynomial of standardised parameters.
#[derive(Clone, Debug)]
struct Basis {
    centre: Vec<f64>,
    scale: Vec<f64>,
    terms: Vec<Vec<u8>>,
    degree: usize,
}

/// A fitted polynomial.
#[derive(Clone, Debug)]
pub struct Surrogate {
    basis: Basis,
    coefficients: Vec<f64>,
    /// The rows that were fitted.
    rows: Vec<usize>,
    /// Leave-one-out errors of the points fitted, in their order.
    pub errors: Vec<f64>,
    /// Quality of the fit.
    pub quality: Quality,
}

/// Above this number, points are thinned evenly before a fit: more would cost time and change nothing.
const MOST_POINTS: usize = 4000;
/// A fit has at least this many points a term.
const POINTS_A_TERM: f64 = 2.0;
/// The highest total degree of many parameters, and of few, while there are no more terms than [`FEW_TERMS`].
const DEGREES: [usize; 2] = [6, 12];
/// A fit of so many terms takes no time.
const FEW_TERMS: usize = 200;
/// The hyperbolic norm: below 1, interactions of high degree are left out first.
const NORM: f64 = 0.7;

impl Surrogate {
    /// Fits an output to parameters (rows of `inputs`). `None` where the points are too few for a line,
    /// or nothing varies.
    pub fn fit(inputs: &[Vec<f64>], output: &[f64]) -> Option<Self> {
        let [many, few] = DEGREES;
        let parameters = inputs.first()?.len();
        let quick = |degree: &usize| terms(parameters, *degree).len() <= FEW_TERMS;
        let most = (many + 1..=few).take_while(quick).last().unwrap_or(many);
        Self::fit_to(inputs, output, most)
    }

    /// The same with another highest degree, which few parameters can afford.
    pub fn fit_to(inputs: &[Vec<f64>], output: &[f64], most: usize) -> Option<Self> {
        let kept: Vec<usize> =
            (0..output.len()).filter(|&j| output[j].is_finite() && inputs[j].iter().all(|v| v.is_finite())).collect();
        let every = kept.len().div_ceil(MOST_POINTS).max(1);
        let kept: Vec<usize> = kept.into_iter().step_by(every).collect();
        let d = inputs.first()?.len();
        let column = |k: usize| kept.iter().map(|&j| inputs[j][k]).collect::<Vec<f64>>();
        let n = kept.len() as f64;
        let centre: Vec<f64> = (0..d).map(|k| mean(&column(k))).collect();
        let spread = |k: usize| deviation(&column(k), 0);
        let scale: Vec<f64> = (0..d).map(|k| spread(k).max(f64::MIN_POSITIVE)).collect();
        let unit = moderate_unit(kept.iter().map(|&j| output[j]));
        let y = DVector::from_iterator(kept.len(), kept.iter().map(|&j| output[j] / unit));
        let mut best: Option<Self> = None;
        for degree in 1..=most {
            let terms = terms(d, degree);
            // A higher degree finds nothing where errors are less than 1e-8 of the scatter.
            let exact = |fit: &Self| fit.quality.predicted >= 1.0;
            if terms.len() as f64 * POINTS_A_TERM > n || best.as_ref().is_some_and(exact) {
                break;
            }
            let basis = Basis { centre: centre.clone(), scale: scale.clone(), terms, degree };
            let is_better = |fit: &Self| {
                let before = best.as_ref().map(|best| best.quality.error);
                before.is_none_or(|before| fit.quality.error < before)
            };
            let fit = Self::solve(basis, inputs, &kept, &y).filter(is_better);
            best = fit.or(best);
        }
        let mut best = best?;
        let numbers = best.coefficients.iter_mut().chain(&mut best.errors);
        numbers.for_each(|number| *number *= unit);
        best.quality.error *= unit;
        Some(best)
    }

    fn solve(mut basis: Basis, inputs: &[Vec<f64>], kept: &[usize], y: &DVector<f64>) -> Option<Self> {
        let rows: Vec<Vec<f64>> = kept.iter().map(|&j| basis.values(&inputs[j]).collect()).collect();
        let mut matrix = DMatrix::from_fn(rows.len(), basis.terms.len(), |r, c| rows[r][c]);
        let mut dependent = dependent(&matrix);
        if !dependent.is_empty() {
            // Parameters that stay in a relation, as those from a sample may: the other terms say the same.
            matrix = matrix.remove_columns_at(&dependent);
            while let Some(last) = dependent.pop() {
                basis.terms.remove(last);
            }
            if !self::dependent(&matrix).is_empty() {
                return None;
            }
        }
        let qr = matrix.qr();
        let (q, r) = (qr.q(), qr.r());
        let coefficients = r.solve_upper_triangular(&(q.transpose() * y))?;
        let fitted = &q * (q.transpose() * y);
        // Allen (1974): the leave-one-out error is the residual over one minus the leverage.
        let errors = (0..y.len()).map(|j| {
            let leverage = q.row(j).iter().map(|v| v * v).sum::<f64>();
            (y[j] - fitted[j]) / (1.0 - leverage).max(1e-9)
        });
        let errors: Vec<f64> = errors.collect();
        let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / y.len() as f64;
        let variance = y.variance();
        let left = if variance > 0.0 { mean_square / variance } else { 0.0 };
        Some(Self {
            quality: Quality {
                degree: basis.degree,
                terms: basis.terms.len(),
                points: y.len(),
                error: mean_square.sqrt(),
                predicted: 1.0 - left,
            },
            coefficients: coefficients.iter().copied().collect(),
            rows: kept.to_vec(),
            errors,
            basis,
        })
    }

    /// The predicted output.
    pub fn at(&self, x: &[f64]) -> f64 {
        let values = self.basis.values(x).zip(&self.coefficients);
        values.map(|(value, c)| value * c).sum()
    }

    /// The prediction of a fit without it at each row of the inputs.
    pub fn left_out(&self, inputs: &[Vec<f64>], output: &[f64]) -> Vec<f64> {
        let mut predicted: Vec<f64> = inputs.iter().map(|x| self.at(x)).collect();
        for (&row, error) in self.rows.iter().zip(&self.errors) {
            predicted[row] = output[row] - error;
        }
        predicted
    }
}

impl Basis {
    /// The values of the terms: products of the parameters' polynomials.
    fn values(&self, x: &[f64]) -> impl Iterator<Item = f64> + '_ {
        let standard = x.iter().zip(&self.centre).zip(&self.scale);
        let standard = standard.map(|((v, centre), scale)| (v - centre) / scale);
        let powers: Vec<Vec<f64>> = standard.map(|z| hermite(z, self.degree)).collect();
        self.terms.iter().map(move |term| {
            let pairs = term.iter().zip(&powers).filter(|(p, _)| **p > 0);
            pairs.map(|(p, powers)| powers[usize::from(*p)]).product()
        })
    }
}

/// The columns that depend on those before them.
fn dependent(matrix: &DMatrix<f64>) -> Vec<usize> {
    const NONE_LEFT: f64 = 1e-10;
    let r = matrix.clone().qr().r();
    let size = r.diagonal().iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let depends = |&k: &usize| r[(k, k)].abs() < NONE_LEFT * size;
    (0..matrix.ncols()).filter(depends).collect()
}

/// Orthonormal Hermite polynomials of degree 0 to `degree` (probabilists').
fn hermite(z: f64, degree: usize) -> Vec<f64> {
    let mut h = vec![1.0, z];
    for k in 1..degree {
        h.push((z * h[k] - (k as f64).sqrt() * h[k - 1]) / (k as f64 + 1.0).sqrt());
    }
    h
}

/// All combinations of degrees within the hyperbolic norm.
fn terms(d: usize, degree: usize) -> Vec<Vec<u8>> {
    let limit = (degree as f64).powf(NORM) + 1e-9;
    let mut terms = vec![vec![]];
    for _ in 0..d {
        terms = terms
            .iter()
            .flat_map(|head: &Vec<u8>| (0..=degree as u8).map(|p| [&head[..], &[p]].concat()))
            .filter(|t| t.iter().map(|p| f64::from(*p).powf(NORM)).sum::<f64>() <= limit)
            .collect();
    }
    terms
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::StdRng};

    pub fn points(n: usize, d: usize, seed: u64) -> Vec<Vec<f64>> {
        let mut random = StdRng::seed_from_u64(seed);
        (0..n).map(|_| (0..d).map(|_| random.random_range(-1.0..1.0)).collect()).collect()
    }

    #[test]
    fn a_polynomial_is_found_exactly() {
        let x = points(80, 3, 1);
        let f = |p: &[f64]| 2.0 + p[0] - 3.0 * p[1] * p[1] + 0.5 * p[0].powi(3);
        let y: Vec<f64> = x.iter().map(|p| f(p)).collect();
        let s = Surrogate::fit(&x, &y).unwrap();
        assert!(s.quality.predicted > 1.0 - 1e-12, "{:?}", s.quality);
        assert!((s.at(&[0.3, -0.2, 0.9]) - f(&[0.3, -0.2, 0.9])).abs() < 1e-9);
        // In any unit of parameters and output, whose squares may be beyond all numbers.
        let scaled = |values: &[f64]| values.iter().map(|v| 1e200 * v).collect::<Vec<f64>>();
        let x: Vec<Vec<f64>> = x.iter().map(|row| scaled(row)).collect();
        let large = Surrogate::fit(&x, &scaled(&y)).unwrap();
        assert!(large.quality.predicted > 1.0 - 1e-12, "{:?}", large.quality);
        let place = scaled(&[0.3, -0.2, 0.9]);
        assert!((large.at(&place) / 1e200 - f(&[0.3, -0.2, 0.9])).abs() < 1e-9);
    }

    #[test]
    fn the_stated_error_is_that_on_fresh_points() {
        let f = |p: &[f64]| (2.0 * p[0]).exp() / (1.5 + p[1]) + (3.0 * p[2]).sin();
        let x = points(200, 3, 2);
        let s = Surrogate::fit(&x, &x.iter().map(|p| f(p)).collect::<Vec<_>>()).unwrap();
        let fresh = points(2000, 3, 3);
        let error = (fresh.iter().map(|p| (s.at(p) - f(p)).powi(2)).sum::<f64>() / 2000.0).sqrt();
        assert!(s.quality.predicted > 0.95, "{:?}", s.quality);
        assert!(error < 1.5 * s.quality.error && error > 0.5 * s.quality.error, "{error} {:?}", s.quality);
    }

    #[test]
    fn failed_points_are_left_out_and_noise_is_not_fitted() {
        let x = points(60, 2, 4);
        let mut random = StdRng::seed_from_u64(5);
        let mut y: Vec<f64> = x.iter().map(|_| random.random_range(-1.0..1.0)).collect();
        y[7] = f64::NAN;
        let s = Surrogate::fit(&x, &y).unwrap();
        assert_eq!(s.quality.points, 59);
        assert!(s.quality.predicted < 0.3);
        assert!(Surrogate::fit(&x[..3], &y[..3]).is_none());
    }
}
