//! The errors of the measured values: those of single values, and those that several values share.
//!
//! In units of the accuracies the misfits `r` have the covariance `I + V V'`, with a column of `V` for each shared source.
//! By the identity of Woodbury (Golub & Van Loan 2013, Matrix Computations, section 2.1.4) no matrix larger than the number
//! of sources is ever inverted. With `M = I + V'V`, the sources' most probable values for given predictions are
//! `z = -M^-1 V'r`, with the covariance `M^-1`, and the sum of squares `r' (I + V V')^-1 r` is that of `r + V z` and of `z`:
//! the sources are unknowns with a prior, and integrated out.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::problem::Problem;

/// The errors of the measured values of a problem.
pub struct Errors {
    /// The accuracies, case by case.
    accuracy: Vec<Vec<f64>>,
    /// `V`: by case and source the places of the values that it touches among the case's own, with its effect over their
    /// accuracy.
    effects: Vec<Vec<Vec<(usize, f64)>>>,
    /// The factor of `M`; none without shared sources.
    factor: Option<Cholesky<f64, Dyn>>,
    sources: usize,
    /// The logarithm of the density where all misfits are 0.
    peak: f64,
}

impl Errors {
    /// The curvature with the shared errors as unknowns behind the others, given that without them and how the derivatives lie
    /// along them: what they take from it comes back.
    pub fn with_sources(&self, precision: &DMatrix<f64>, along: &DMatrix<f64>) -> DMatrix<f64> {
        let (n, sources) = (precision.nrows(), self.sources());
        let halved = self.halved(along.clone());
        let mut full = DMatrix::zeros(n + sources, n + sources);
        full.view_mut((0, 0), (n, n)).copy_from(&(precision + halved.tr_mul(&halved)));
        full.view_mut((n, 0), (sources, n)).copy_from(along);
        full.view_mut((0, n), (n, sources)).copy_from(&along.transpose());
        full.view_mut((n, n), (sources, sources)).copy_from(&self.matrix());
        full
    }

    /// The errors of a problem.
    pub fn new(problem: &Problem) -> Self {
        let sources = problem.sources.len();
        let accuracy: Vec<Vec<f64>> =
            problem.cases.iter().map(|case| case.measured.iter().map(|value| value.accuracy).collect()).collect();
        let mut effects = vec![vec![Vec::new(); sources]; accuracy.len()];
        for (number, source) in problem.sources.iter().enumerate() {
            for effect in &source.effects {
                let part = effect.change / accuracy[effect.case][effect.quantity];
                effects[effect.case][number].push((effect.quantity, part));
            }
        }
        let mut matrix = DMatrix::identity(sources, sources);
        for (case, accuracy) in effects.iter().zip(&accuracy) {
            // A source may touch a value twice.
            let mut columns = DMatrix::<f64>::zeros(accuracy.len(), sources);
            for (number, column) in case.iter().enumerate() {
                for &(quantity, part) in column {
                    columns[(quantity, number)] += part;
                }
            }
            matrix += columns.tr_mul(&columns);
        }
        let factor =
            (sources > 0).then(|| Cholesky::new(matrix).expect("the identity and squares have a positive sum"));
        let singles = accuracy.iter().flatten().map(|accuracy| -accuracy.ln() - 0.5 * std::f64::consts::TAU.ln());
        let shared = factor.as_ref().map_or(0.0, |factor| factor.l_dirty().diagonal().map(f64::ln).sum());
        Self { peak: singles.sum::<f64>() - shared, accuracy, effects, factor, sources }
    }

    /// `M`.
    pub fn matrix(&self) -> DMatrix<f64> {
        self.factor.as_ref().map(Cholesky::l).map_or_else(|| DMatrix::zeros(0, 0), |l| &l * l.transpose())
    }

    /// The row of `V` of a value.
    pub fn effects(&self, case: usize, quantity: usize) -> DVector<f64> {
        let effect = |column: &Vec<(usize, f64)>| -> f64 {
            column.iter().filter(|(place, _)| *place == quantity).map(|(_, part)| part).sum()
        };
        DVector::from_iterator(self.sources, self.effects[case].iter().map(effect))
    }

    /// How many shared sources there are.
    pub fn sources(&self) -> usize {
        self.sources
    }

    /// The accuracy of a value.
    pub fn accuracy(&self, case: usize, quantity: usize) -> f64 {
        self.accuracy[case][quantity]
    }

    /// The misfits without what the shared sources explain, and then the sources' most probable values in their standard
    /// uncertainties. The squares of both add up to the sum of squares.
    pub fn residuals(&self, problem: &Problem, predicted: &[Vec<f64>]) -> DVector<f64> {
        let mut residuals = self.plain(problem, predicted);
        if self.sources == 0 {
            return residuals;
        }
        let mut onto = DVector::zeros(self.sources);
        let mut start = 0;
        for (case, accuracy) in self.accuracy.iter().enumerate() {
            onto += self.onto(case, residuals.rows(start, accuracy.len()).as_slice());
            start += accuracy.len();
        }
        let values = -self.solved(&onto);
        start = 0;
        for (effects, accuracy) in self.effects.iter().zip(&self.accuracy) {
            for (column, value) in effects.iter().zip(&values) {
                for (quantity, part) in column {
                    residuals[start + quantity] += part * value;
                }
            }
            start += accuracy.len();
        }
        let all = residuals.iter().chain(&values).copied();
        DVector::from_vec(all.collect())
    }

    /// The misfits over the accuracies, case by case.
    fn plain(&self, problem: &Problem, predicted: &[Vec<f64>]) -> DVector<f64> {
        let misfits =
            problem.cases.iter().zip(predicted).zip(&self.accuracy).flat_map(|((case, predicted), accuracy)| {
                case.measured
                    .iter()
                    .zip(predicted)
                    .zip(accuracy)
                    .map(|((measured, predicted), accuracy)| (predicted - measured.value) / accuracy)
            });
        DVector::from_vec(misfits.collect())
    }

    /// The logarithm of the density of the measured values, given their part of the sum of squares.
    pub fn log_density(&self, squares: f64) -> f64 {
        self.peak - 0.5 * squares
    }

    /// `V'x`, for the values of one case.
    pub fn onto(&self, case: usize, values: &[f64]) -> DVector<f64> {
        let sum = |column: &Vec<(usize, f64)>| -> f64 {
            column.iter().map(|(quantity, part)| part * values[*quantity]).sum()
        };
        DVector::from_iterator(self.sources, self.effects[case].iter().map(sum))
    }

    /// `M^-1 x`.
    pub fn solved(&self, x: &DVector<f64>) -> DVector<f64> {
        self.factor.as_ref().map_or_else(|| x.clone(), |factor| factor.solve(x))
    }

    /// `L^-1 X` with `M = L L'`: its squares are those of `X` in the metric of `M^-1`.
    pub fn halved(&self, mut matrix: DMatrix<f64>) -> DMatrix<f64> {
        if let Some(factor) = &self.factor {
            let solves = factor.l_dirty().solve_lower_triangular_mut(&mut matrix);
            assert!(solves, "the diagonal of a Cholesky factor is positive");
        }
        matrix
    }

    /// Mean and standard deviation of each channel's error, given the sources' most probable values for one set of unknowns.
    pub fn channels(&self, problem: &Problem, sources: &[f64]) -> Vec<[f64; 2]> {
        problem
            .channels
            .iter()
            .map(|channel| {
                let weights = channel.weights(self.sources);
                let mean = weights.iter().zip(sources).map(|(weight, value)| weight * value);
                let column = DMatrix::from_column_slice(self.sources, 1, weights.as_slice());
                [mean.sum(), self.halved(column).norm()]
            })
            .collect()
    }
}
