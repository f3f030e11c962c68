//! One Gaussian process with given length scales and nugget: what the runs say of it, and what it says of other points.
//!
//! y(x) = h(x)' b + f(x) + e: a trend of flat prior, a process f of variance s2 and correlation R, independent errors e of
//! variance s2 g (the nugget). Trend and s2 are integrated out (Santner, Williams & Notz 2003, "The Design and Analysis of
//! Computer Experiments", section 3.3; Rasmussen & Williams 2006, section 2.7), so predictions follow Student's distribution.

use crate::arithmetic::cosine;
use crate::kernel::{Kernel, LEAST_NUGGET, Places, Smoothness};
use nalgebra::{DMatrix, DMatrixViewMut, DVector};
use sampling::random::Random;
use std::f64::consts::TAU;

/// Random waves of a draw from the prior.
const WAVES: usize = 384;

/// Points that are worked on at a time: what is known of them stays near the processor.
const CHUNK: usize = 128;

/// Matrices of that size are not divided further.
const UNDIVIDED: usize = 16;

/// Runs as a process sees them.
#[derive(Clone, Debug)]
pub struct Data {
    /// A column a run, a row a coordinate.
    pub points: DMatrix<f64>,
    /// What the runs gave, standardised.
    pub values: DVector<f64>,
    /// A row a run, a column a trend's function.
    pub trend: DMatrix<f64>,
}

/// The trend's functions at points: a constant, and each coordinate where `linear`.
fn trend(points: &DMatrix<f64>, linear: bool) -> DMatrix<f64> {
    let width = if linear { 1 + points.nrows() } else { 1 };
    DMatrix::from_fn(points.ncols(), width, |i, k| if k == 0 { 1.0 } else { points[(k - 1, i)] })
}

impl Data {
    /// Prepares runs; the trend is linear where there are three runs for each of its coefficients, and no coordinate follows from
    /// others.
    pub fn new(points: DMatrix<f64>, values: DVector<f64>) -> Self {
        let (d, n) = points.shape();
        /// Coordinates have deviations of 1, of which a part this small is rounding.
        const INDEPENDENT: f64 = 1e-8;
        let is_independent = || trend(&points, true).rank(INDEPENDENT * (n as f64).sqrt()) == d + 1;
        let linear = n >= 3 * (d + 1) && is_independent();
        Self { trend: trend(&points, linear), points, values }
    }

    /// The lower half of the matrix of the runs; and for each pair of them, column after column, the derivatives of the logarithm of the
    /// correlation by those of each length scale and of the interaction.
    fn correlations(&self, kernel: &Kernel) -> (DMatrix<f64>, Vec<Vec<f64>>) {
        let (d, n) = self.points.shape();
        let mut matrix = DMatrix::identity(n, n) * (1.0 + kernel.nugget);
        let (mut slopes, mut last) = (vec![vec![0.0; n * (n - 1) / 2]; d], vec![0.0; n * (n - 1) / 2]);
        let places = kernel.places(&self.points);
        let mut first = 0;
        for (j, column) in matrix.as_mut_slice().chunks_mut(n).enumerate() {
            let values = &mut column[j + 1..];
            values.fill(1.0);
            let end = first + values.len();
            for (places, slopes) in places.iter().zip(&mut slopes) {
                let (below, other) = (places.each_ref().map(|of| &of[j + 1..]), places.each_ref().map(|of| of[j]));
                kernel.multiply::<true>(below, other, values, [&mut slopes[first..end], &mut last[first..end]]);
            }
            first = end;
        }
        slopes.push(last);
        (matrix, slopes)
    }

    /// The logarithm of the likelihood of the unknowns, and its gradient where asked for. `None` where the matrix is singular.
    pub fn likelihood(&self, smoothness: Smoothness, unknowns: &[f64], sloped: bool) -> Option<(f64, Vec<f64>)> {
        let n = self.points.ncols();
        let kernel = Kernel::new(smoothness, unknowns);
        let (matrix, slopes) = self.correlations(&kernel);
        let solved = Solved::new(matrix.clone(), self)?;
        let freedom = (n - self.trend.ncols()) as f64;
        let squares = solved.squares.max(1e-24);
        let value = -solved.half_log_determinants - 0.5 * freedom * squares.ln();
        if !sloped {
            return Some((value, Vec::new()));
        }
        let projector = solved.projector();
        let factor = 0.5 * freedom / squares;
        let a = &solved.weights;
        // By the logarithm of each pair's correlation.
        let part = |i: usize, j: usize| (2.0 * factor * a[i] * a[j] - projector[(i, j)]) * matrix[(i, j)];
        let parts: Vec<f64> = (0..n).flat_map(|j| (j + 1..n).map(move |i| (i, j))).map(|(i, j)| part(i, j)).collect();
        let mut gradient: Vec<f64> =
            slopes.iter().map(|slopes| slopes.iter().zip(&parts).map(|(s, p)| s * p).sum()).collect();
        let diagonal: f64 = (0..n).map(|i| factor * a[i] * a[i] - 0.5 * projector[(i, i)]).sum();
        gradient.push(if kernel.nugget > LEAST_NUGGET { kernel.nugget * diagonal } else { 0.0 });
        Some((value, gradient))
    }
}

/// Replaces a positive definite matrix, of which the lower half is given and the upper one 0, by the inverse of its Cholesky factor.
/// Products of blocks do nearly all of the work. False where it is singular.
fn whiten(mut matrix: DMatrixViewMut<'_, f64>) -> bool {
    let n = matrix.nrows();
    if n <= UNDIVIDED {
        let Some(factor) = matrix.clone_owned().cholesky() else {
            return false;
        };
        matrix.fill_with_identity();
        return factor.l_dirty().solve_lower_triangular_mut(&mut matrix);
    }
    let half = n / 2;
    let (mut left, mut right) = matrix.columns_range_pair_mut(..half, half..);
    let (mut first, mut below) = left.rows_range_pair_mut(..half, half..);
    let mut last = right.rows_mut(half, n - half);
    if !whiten(first.as_view_mut()) {
        return false;
    }
    let factor = &below * first.transpose();
    last.gemm(-1.0, &factor, &factor.transpose(), 1.0);
    last.fill_upper_triangle(0.0, 1);
    if !whiten(last.as_view_mut()) {
        return false;
    }
    below.copy_from(&(&last * (factor * &first) * -1.0));
    true
}

/// The linear algebra that likelihood and predictions share.
#[derive(Clone, Debug)]
struct Solved {
    /// L^-1, with K = L L', and that of H' K^-1 H.
    whitening: DMatrix<f64>,
    of_trend: DMatrix<f64>,
    /// An orthonormal basis of L^-1 H.
    basis: DMatrix<f64>,
    coefficients: DVector<f64>,
    /// K^-1 (y - H b).
    weights: DVector<f64>,
    /// (y - H b)' K^-1 (y - H b).
    squares: f64,
    half_log_determinants: f64,
}

/// L^-1 of K = L L', of which the lower half is given, and half of the logarithm of its determinant.
fn whitened(mut matrix: DMatrix<f64>) -> Option<(DMatrix<f64>, f64)> {
    matrix.fill_upper_triangle(0.0, 1);
    if !whiten(matrix.as_view_mut()) {
        return None;
    }
    let logarithm = matrix.diagonal().iter().map(|v| -v.ln()).sum();
    Some((matrix, logarithm))
}

impl Solved {
    fn new(matrix: DMatrix<f64>, data: &Data) -> Option<Self> {
        let (whitening, of_all) = whitened(matrix)?;
        let white = &whitening * &data.trend;
        let (of_trend, of_rest) = whitened(white.tr_mul(&white))?;
        let basis = white * of_trend.transpose();
        let white = &whitening * &data.values;
        let parts = basis.tr_mul(&white);
        let rest = white - &basis * &parts;
        let (coefficients, weights) = (of_trend.tr_mul(&parts), whitening.tr_mul(&rest));
        let (squares, half_log_determinants) = (rest.norm_squared(), of_all + of_rest);
        Some(Self { whitening, of_trend, basis, coefficients, weights, squares, half_log_determinants })
    }

    /// K^-1 - K^-1 H (H' K^-1 H)^-1 H' K^-1.
    fn projector(&self) -> DMatrix<f64> {
        let turned = self.whitening.transpose();
        let of_trend = &turned * &self.basis;
        let mut projector = &turned * &self.whitening;
        projector.gemm(-1.0, &of_trend, &of_trend.transpose(), 1.0);
        projector
    }
}

/// A process given the runs.
#[derive(Clone, Debug)]
pub struct Process {
    /// Logarithms of length scales, interaction and nugget.
    pub unknowns: Vec<f64>,
    /// The variance s2.
    pub variance: f64,
    /// Runs less coefficients of the trend.
    pub freedom: f64,
    kernel: Kernel,
    solved: Solved,
    /// The runs' points.
    places: Places,
    linear: bool,
}

impl Process {
    /// The process of these unknowns. `None` where its matrix is singular.
    pub fn new(data: &Data, smoothness: Smoothness, unknowns: Vec<f64>) -> Option<Self> {
        let kernel = Kernel::new(smoothness, &unknowns);
        let solved = Solved::new(data.correlations(&kernel).0, data)?;
        let freedom = (data.points.ncols() - data.trend.ncols()) as f64;
        let variance = (solved.squares / freedom).max(1e-24);
        let (places, linear) = (kernel.places(&data.points), data.trend.ncols() > 1);
        Some(Self { unknowns, variance, freedom, kernel, solved, places, linear })
    }

    /// The variance of the independent errors, over that of the process.
    pub fn nugget(&self) -> f64 {
        self.kernel.nugget
    }

    /// Correlations with the runs: a row a run, a column a point. Points of a grid share coordinates, and factors.
    fn cross(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.solved.weights.len();
        let mut cross = DMatrix::repeat(n, points.ncols(), 1.0);
        let (mut factors, mut unasked) = (vec![0.0; n], [vec![0.0; n], vec![0.0; n]]);
        for (of_runs, of_points) in self.places.iter().zip(&self.kernel.places(points)) {
            let of_runs = of_runs.each_ref().map(|of| &**of);
            let mut multiply = |j: usize, values: &mut [f64]| {
                let unasked = unasked.each_mut().map(|of| &mut **of);
                self.kernel.multiply::<false>(of_runs, of_points.each_ref().map(|of| of[j]), values, unasked);
            };
            let [at, ..] = of_points;
            let mut order: Vec<usize> = (0..at.len()).collect();
            order.sort_unstable_by(|a, b| at[*a].total_cmp(&at[*b]));
            for equal in order.chunk_by(|a, b| at[*a] == at[*b]) {
                if let [one] = equal {
                    multiply(*one, cross.column_mut(*one).as_mut_slice());
                    continue;
                }
                factors.fill(1.0);
                multiply(equal[0], &mut factors);
                for j in equal {
                    cross
                        .column_mut(*j)
                        .as_mut_slice()
                        .iter_mut()
                        .zip(&factors)
                        .for_each(|(value, factor)| *value *= factor);
                }
            }
        }
        cross
    }

    /// What leaving each run out gives: its error, and the deviation that the process states for it (Dubrule 1983).
    pub fn left_out(&self) -> Vec<[f64; 2]> {
        let projector = self.solved.projector();
        let one = |i| {
            let inverse: f64 = projector[(i, i)];
            [self.solved.weights[i] / inverse, (self.variance / inverse).sqrt()]
        };
        (0..projector.nrows()).map(one).collect()
    }

    /// Mean and deviation (without the independent errors) at points, one a column.
    pub fn predict(&self, points: &DMatrix<f64>) -> Vec<[f64; 2]> {
        let Solved { whitening, of_trend, basis, .. } = &self.solved;
        let cross = self.cross(points);
        let trend = trend(points, self.linear);
        let means = self.mean(&cross, &trend);
        let white = whitening * cross;
        let rest = of_trend * trend.transpose() - basis.transpose() * &white;
        let one = |i: usize| {
            let left = 1.0 - white.column(i).norm_squared() + rest.column(i).norm_squared();
            [means[i], (self.variance * left.max(0.0)).sqrt()]
        };
        (0..points.ncols()).map(one).collect()
    }

    /// Means at points, one a column: a small part of the work of [`Self::predict`].
    pub fn means(&self, points: &DMatrix<f64>) -> DVector<f64> {
        self.mean(&self.cross(points), &trend(points, self.linear))
    }

    fn mean(&self, cross: &DMatrix<f64>, trend: &DMatrix<f64>) -> DVector<f64> {
        trend * &self.solved.coefficients + cross.tr_mul(&self.solved.weights)
    }

    /// Functions drawn from the process given the runs, with deviations `widening` times as large (Matheron's rule; Wilson et
    /// al. 2020, "Efficiently sampling functions from Gaussian process posteriors").
    pub fn draws(&self, data: &Data, count: usize, widening: f64, random: &mut Random) -> Draws<'_> {
        let (d, n) = data.points.shape();
        let mut waves = DMatrix::zeros(d, WAVES);
        for mut wave in waves.column_iter_mut() {
            wave.iter_mut().zip(self.kernel.frequency(random)).for_each(|(to, from)| *to = from / TAU);
        }
        let phases: Vec<f64> = (0..WAVES).map(|_| random.unit()).collect();
        let error = self.nugget().sqrt();
        let mut amplitudes = DMatrix::zeros(WAVES, count);
        let mut off = DMatrix::zeros(n, count);
        let one = |k: usize| {
            // A chi-squared number by its Wilson-Hilferty approximation.
            let part = 2.0 / (9.0 * self.freedom);
            let squares = self.freedom * (1.0 - part + part.sqrt() * random.normal()).max(0.05).powi(3);
            let deviation = widening * (self.variance * self.freedom / squares).sqrt();
            amplitudes.column_mut(k).apply(|v| *v = deviation * random.normal());
            off.column_mut(k).apply(|v| *v = deviation * error * random.normal());
            deviation * error
        };
        let errors = (0..count).map(one).collect();
        let mut rest = -off - features(&waves, &phases, &data.points) * &amplitudes;
        rest.column_iter_mut().for_each(|mut column| column += &data.values);
        let Solved { whitening, of_trend, basis, .. } = &self.solved;
        let white = whitening * rest;
        let parts = basis.tr_mul(&white);
        let weights = whitening.transpose() * (white - basis * &parts);
        let coefficients = of_trend.transpose() * parts;
        Draws { process: self, waves, phases, amplitudes, weights, coefficients, errors }
    }
}

/// Functions that a process may be, given the runs. A column a draw.
#[derive(Clone, Debug)]
pub struct Draws<'a> {
    process: &'a Process,
    /// A column a wave; frequencies and phases are in turns.
    waves: DMatrix<f64>,
    phases: Vec<f64>,
    amplitudes: DMatrix<f64>,
    weights: DMatrix<f64>,
    coefficients: DMatrix<f64>,
    /// The deviation of the independent errors of each draw.
    pub errors: Vec<f64>,
}

impl Draws<'_> {
    /// Values at points: a row a point, a column a draw.
    pub fn at(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let mut values = trend(points, self.process.linear) * &self.coefficients;
        for start in (0..points.ncols()).step_by(CHUNK) {
            let chunk = points.columns(start, CHUNK.min(points.ncols() - start)).into_owned();
            let mut values = values.rows_mut(start, chunk.ncols());
            values.gemm(1.0, &features(&self.waves, &self.phases, &chunk), &self.amplitudes, 1.0);
            values.gemm(1.0, &self.process.cross(&chunk).transpose(), &self.weights, 1.0);
        }
        values
    }
}

/// A row a point, a column a wave, which does not vary with most coordinates where there is little interaction.
fn features(waves: &DMatrix<f64>, phases: &[f64], points: &DMatrix<f64>) -> DMatrix<f64> {
    let by_coordinate = points.transpose();
    let amplitude = (2.0 / WAVES as f64).sqrt();
    let mut features = DMatrix::zeros(points.ncols(), WAVES);
    for ((mut feature, wave), phase) in features.column_iter_mut().zip(waves.column_iter()).zip(phases) {
        feature.fill(*phase);
        for (k, frequency) in wave.iter().enumerate().filter(|(_, frequency)| **frequency != 0.0) {
            feature.axpy(*frequency, &by_coordinate.column(k), 1.0);
        }
        feature.as_mut_slice().iter_mut().for_each(|v| *v = amplitude * cosine(*v));
    }
    features
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cholesky's factor as nalgebra has it.
    #[test]
    fn a_matrix_is_whitened() {
        let random = DMatrix::from_fn(150, 150, |i, k| ((3 * i * i + 7 * k * i + k) as f64).sin());
        let matrix = &random * random.transpose() + DMatrix::identity(150, 150);
        let (whitened, logarithm) = whitened(matrix.clone()).unwrap();
        assert!((2.0 * logarithm - matrix.clone().cholesky().unwrap().ln_determinant()).abs() < 1e-8);
        let error = &whitened * matrix.clone().cholesky().unwrap().l() - DMatrix::identity(150, 150);
        assert!(error.amax() < 1e-10 && whitened.upper_triangle().iter().filter(|v| **v != 0.0).count() == 150);
        assert!(super::whitened(matrix - DMatrix::identity(150, 150) * 5.0).is_none());
    }
}
