//! One Gaussian process with given length scales and nugget: what the runs say of it, and what it says of other points.
//!
//! y(x) = h(x)' b + f(x) + e: a trend of flat prior, a process f of variance s2 and correlation R, independent errors e of
//! variance s2 g (the nugget). Trend and s2 are integrated out (Santner, Williams & Notz 2003, "The Design and Analysis of
//! Computer Experiments", section 3.3; Rasmussen & Williams 2006, section 2.7), so predictions follow Student's distribution.

use crate::kernel::{Kernel, Smoothness};
use nalgebra::{DMatrix, DVector, Dyn, linalg::Cholesky};
use sampling::random::Random;

/// The smallest nugget, for the condition of the matrices.
pub const LEAST_NUGGET: f64 = 1e-9;

/// Random waves of a draw from the prior.
const WAVES: usize = 384;

/// Runs as a process sees them.
#[derive(Clone, Debug)]
pub struct Data {
    /// A column a run, a row a coordinate.
    pub points: DMatrix<f64>,
    /// What the runs gave, standardised.
    pub values: DVector<f64>,
    /// A row a run, a column a trend's function.
    pub trend: DMatrix<f64>,
    /// The squared differences of each pair of runs (i > j, row after row) by coordinate.
    apart: Vec<f64>,
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
        let mut apart = Vec::with_capacity(d * n * (n - 1) / 2);
        for i in 0..n {
            for j in 0..i {
                apart.extend((0..d).map(|k| (points[(k, i)] - points[(k, j)]).powi(2)));
            }
        }
        Self { trend: trend(&points, linear), points, values, apart }
    }

    /// The matrix of the runs, and for each pair of them (row after row) the derivatives of the logarithm of its correlation.
    fn correlations(&self, smoothness: Smoothness, unknowns: &[f64]) -> (DMatrix<f64>, Vec<f64>) {
        let (d, n) = self.points.shape();
        let kernel = Kernel { smoothness, interaction: unknowns[d].exp() };
        let weights: Vec<f64> = unknowns[..d].iter().map(|u| (-2.0 * u).exp()).collect();
        let mut matrix = DMatrix::identity(n, n) * (1.0 + unknowns[d + 1].exp().max(LEAST_NUGGET));
        let mut slopes = vec![0.0; n * (n - 1) / 2 * (d + 1)];
        let mut pairs = self.apart.chunks(d).zip(slopes.chunks_mut(d + 1));
        for i in 0..n {
            for j in 0..i {
                let (pair, slopes) = pairs.next().expect("there is a row of differences for each pair");
                let value = kernel.sloped(pair.iter().zip(&weights).map(|(a, w)| a * w), slopes);
                matrix[(i, j)] = value;
                matrix[(j, i)] = value;
            }
        }
        (matrix, slopes)
    }

    /// The logarithm of the likelihood of the unknowns, and its gradient where asked for. `None` where the matrix is singular.
    pub fn likelihood(&self, smoothness: Smoothness, unknowns: &[f64], sloped: bool) -> Option<(f64, Vec<f64>)> {
        let (d, n) = self.points.shape();
        let (matrix, slopes) = self.correlations(smoothness, unknowns);
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
        let mut gradient = vec![0.0; d + 2];
        let mut slopes = slopes.chunks(d + 1);
        for i in 0..n {
            for j in 0..i {
                let slopes = slopes.next().expect("as many as pairs");
                let part = (2.0 * factor * a[i] * a[j] - projector[(i, j)]) * matrix[(i, j)];
                gradient.iter_mut().zip(slopes).for_each(|(to, slope)| *to += part * slope);
            }
        }
        let nugget = unknowns[d + 1].exp();
        if nugget > LEAST_NUGGET {
            let diagonal: f64 = (0..n).map(|i| factor * a[i] * a[i] - 0.5 * projector[(i, i)]).sum();
            gradient[d + 1] = nugget * diagonal;
        }
        Some((value, gradient))
    }
}

/// The linear algebra that likelihood and predictions share.
#[derive(Clone, Debug)]
struct Solved {
    factor: Cholesky<f64, Dyn>,
    /// L^-1 H, and the factor of H' K^-1 H.
    whitened: DMatrix<f64>,
    of_trend: Cholesky<f64, Dyn>,
    coefficients: DVector<f64>,
    /// K^-1 (y - H b).
    weights: DVector<f64>,
    /// (y - H b)' K^-1 (y - H b).
    squares: f64,
    half_log_determinants: f64,
}

impl Solved {
    fn new(matrix: DMatrix<f64>, data: &Data) -> Option<Self> {
        let factor = Cholesky::new(matrix)?;
        let lower = factor.l_dirty();
        let whitened = lower.solve_lower_triangular(&data.trend)?;
        let of_trend = Cholesky::new(whitened.tr_mul(&whitened))?;
        let (coefficients, weights, squares) = regressed(&factor, &whitened, &of_trend, data, &data.values)?;
        let logs = |factor: &Cholesky<f64, Dyn>| factor.l_dirty().diagonal().iter().map(|v| v.ln()).sum::<f64>();
        let half_log_determinants = logs(&factor) + logs(&of_trend);
        Some(Self { factor, whitened, of_trend, coefficients, weights, squares, half_log_determinants })
    }

    /// K^-1 - K^-1 H (H' K^-1 H)^-1 H' K^-1.
    fn projector(&self) -> DMatrix<f64> {
        let mut of_trend =
            self.factor.l_dirty().tr_solve_lower_triangular(&self.whitened).expect("no zero on the diagonal");
        let inverse = self.factor.inverse();
        let solved = self.of_trend.solve(&of_trend.transpose());
        of_trend *= solved;
        inverse - of_trend
    }
}

/// Generalised least squares: coefficients of the trend, K^-1 times the rest, and its square in that metric.
fn regressed(
    factor: &Cholesky<f64, Dyn>,
    whitened: &DMatrix<f64>,
    of_trend: &Cholesky<f64, Dyn>,
    data: &Data,
    values: &DVector<f64>,
) -> Option<(DVector<f64>, DVector<f64>, f64)> {
    let lower = factor.l_dirty();
    let white = lower.solve_lower_triangular(values)?;
    let coefficients = of_trend.solve(&whitened.tr_mul(&white));
    let rest = white - whitened * &coefficients;
    debug_assert_eq!(data.trend.ncols(), coefficients.len());
    let weights = lower.tr_solve_lower_triangular(&rest)?;
    Some((coefficients, weights, rest.norm_squared()))
}

/// A process given the runs.
#[derive(Clone, Debug)]
pub struct Process {
    /// How smooth it is.
    pub smoothness: Smoothness,
    /// Logarithms of length scales, interaction and nugget.
    pub unknowns: Vec<f64>,
    /// The variance s2.
    pub variance: f64,
    /// Runs less coefficients of the trend.
    pub freedom: f64,
    solved: Solved,
    /// The runs' points, divided by the length scales.
    scaled: DMatrix<f64>,
    linear: bool,
}

impl Process {
    /// The process of these unknowns. `None` where its matrix is singular.
    pub fn new(data: &Data, smoothness: Smoothness, unknowns: Vec<f64>) -> Option<Self> {
        let solved = Solved::new(data.correlations(smoothness, &unknowns).0, data)?;
        let freedom = (data.points.ncols() - data.trend.ncols()) as f64;
        let variance = (solved.squares / freedom).max(1e-24);
        let linear = data.trend.ncols() > 1;
        let mut process =
            Self { smoothness, unknowns, variance, freedom, solved, scaled: DMatrix::zeros(0, 0), linear };
        process.scaled = process.scaled(&data.points);
        Some(process)
    }

    /// The variance of the independent errors, over that of the process.
    pub fn nugget(&self) -> f64 {
        self.unknowns.last().map_or(0.0, |u| u.exp()).max(LEAST_NUGGET)
    }

    fn scaled(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let mut scaled = points.clone();
        for (k, mut row) in scaled.row_iter_mut().enumerate() {
            row *= (-self.unknowns[k]).exp();
        }
        scaled
    }

    fn kernel(&self) -> Kernel {
        Kernel { smoothness: self.smoothness, interaction: self.unknowns[self.unknowns.len() - 2].exp() }
    }

    /// Correlations with the runs: a row a run, a column a point (scaled).
    fn cross(&self, scaled: &DMatrix<f64>) -> DMatrix<f64> {
        {
            let columns =
                |m: &DMatrix<f64>| -> Vec<Vec<f64>> { m.column_iter().map(|c| c.iter().copied().collect()).collect() };
            let (runs, points, kernel) = (columns(&self.scaled), columns(scaled), self.kernel());
            DMatrix::from_fn(runs.len(), points.len(), |i, j| kernel.between(&runs[i], &points[j]))
        }
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
        let scaled = self.scaled(points);
        let cross = self.cross(&scaled);
        let trend = trend(points, self.linear);
        let means = &trend * &self.solved.coefficients + cross.tr_mul(&self.solved.weights);
        let (white, rest) = self.whitened(cross, &trend);
        let one = |i: usize| {
            let left = 1.0 - white.column(i).norm_squared() + rest.column(i).norm_squared();
            [means[i], (self.variance * left.max(0.0)).sqrt()]
        };
        (0..points.ncols()).map(one).collect()
    }

    /// Means at points, one a column: a small part of the work of [`Self::predict`].
    pub fn means(&self, points: &DMatrix<f64>) -> DVector<f64> {
        let cross = self.cross(&self.scaled(points));
        trend(points, self.linear) * &self.solved.coefficients + cross.tr_mul(&self.solved.weights)
    }

    /// L^-1 k and what the trend's coefficients leave open, a column a point.
    fn whitened(&self, mut cross: DMatrix<f64>, trend: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let solvable = self.solved.factor.l_dirty().solve_lower_triangular_mut(&mut cross);
        debug_assert!(solvable, "a Cholesky factor has no zero on its diagonal");
        let mut rest = trend.transpose() - self.solved.whitened.tr_mul(&cross);
        let solvable = self.solved.of_trend.l_dirty().solve_lower_triangular_mut(&mut rest);
        debug_assert!(solvable, "a Cholesky factor has no zero on its diagonal");
        (cross, rest)
    }

    /// Functions drawn from the process given the runs, with deviations `widening` times as large (Matheron's rule; Wilson et
    /// al. 2020, "Efficiently sampling functions from Gaussian process posteriors").
    pub fn draws(&self, data: &Data, count: usize, widening: f64, random: &mut Random) -> Draws {
        let (d, n) = self.scaled.shape();
        let mut waves = DMatrix::zeros(WAVES, d);
        for mut row in waves.row_iter_mut() {
            let frequency = self.kernel().frequency(d, random);
            row.iter_mut().zip(frequency).for_each(|(to, from)| *to = from);
        }
        let phases = DVector::from_fn(WAVES, |_, _| std::f64::consts::TAU * random.unit());
        let at_runs = features(&waves, &phases, &self.scaled);
        let mut draws = Draws {
            process: self.clone(),
            waves,
            phases,
            amplitudes: DMatrix::zeros(WAVES, count),
            weights: DMatrix::zeros(n, count),
            coefficients: DMatrix::zeros(data.trend.ncols(), count),
            errors: Vec::with_capacity(count),
        };
        let error = self.nugget().sqrt();
        for k in 0..count {
            let squares: f64 = {
                // A chi-squared number by its Wilson-Hilferty approximation.
                let part = 2.0 / (9.0 * self.freedom);
                self.freedom * (1.0 - part + part.sqrt() * random.normal()).max(0.05).powi(3)
            };
            let deviation = widening * (self.variance * self.freedom / squares).sqrt();
            let amplitudes = DVector::from_fn(WAVES, |_, _| deviation * random.normal());
            let errors = DVector::from_fn(n, |_, _| deviation * error * random.normal());
            let rest = &data.values - at_runs.tr_mul(&amplitudes) - errors;
            let solved = &self.solved;
            let (coefficients, weights, _) = regressed(&solved.factor, &solved.whitened, &solved.of_trend, data, &rest)
                .expect("it was solved before");
            draws.amplitudes.set_column(k, &amplitudes);
            draws.weights.set_column(k, &weights);
            draws.coefficients.set_column(k, &coefficients);
            draws.errors.push(deviation * error);
        }
        draws
    }
}

/// Functions that a process may be, given the runs.
#[derive(Clone, Debug)]
pub struct Draws {
    process: Process,
    waves: DMatrix<f64>,
    phases: DVector<f64>,
    amplitudes: DMatrix<f64>,
    weights: DMatrix<f64>,
    coefficients: DMatrix<f64>,
    /// The deviation of the independent errors of each draw.
    pub errors: Vec<f64>,
}

impl Draws {
    /// Values at points: a row a point, a column a draw.
    pub fn at(&self, points: &DMatrix<f64>) -> DMatrix<f64> {
        let scaled = self.process.scaled(points);
        let mut values = features(&self.waves, &self.phases, &scaled).tr_mul(&self.amplitudes);
        values += self.process.cross(&scaled).tr_mul(&self.weights);
        values += trend(points, self.process.linear) * &self.coefficients;
        values
    }
}

fn features(waves: &DMatrix<f64>, phases: &DVector<f64>, scaled: &DMatrix<f64>) -> DMatrix<f64> {
    let mut features = waves * scaled;
    let amplitude = (2.0 / WAVES as f64).sqrt();
    for mut column in features.column_iter_mut() {
        column.iter_mut().zip(phases).for_each(|(v, phase)| *v = amplitude * (*v + phase).cos());
    }
    features
}
