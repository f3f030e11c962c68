//! Many values of a case as few numbers: principal components.

use nalgebra::{DMatrix, DVector};

/// More values of a case than this are replaced by few components.
const PLAIN: usize = 8;

/// The most components.
const COMPONENTS: usize = 10;

/// What the components leave of each run's values is less than this part of their accuracies, if they are not too many.
const REST: f64 = 0.05;

/// A case's values over their accuracies as sums of few functions of the quantity: principal components, where there are many.
#[derive(Clone, Debug)]
pub struct Components {
    /// Where all scores are 0.
    pub centre: DVector<f64>,
    /// A column a component.
    pub vectors: DMatrix<f64>,
    /// Root mean square of what they leave of each value.
    pub rest: DVector<f64>,
}

impl Components {
    /// Those of runs, a row each.
    pub fn new(values: &DMatrix<f64>) -> Self {
        let (runs, quantities) = values.shape();
        let (centre, rest) = (DVector::zeros(quantities), DVector::zeros(quantities));
        if quantities <= PLAIN || runs == 0 {
            return Self { centre, rest, vectors: DMatrix::identity(quantities, quantities) };
        }
        let centre = values.row_mean().transpose();
        let mut left = values.clone();
        left.row_iter_mut().for_each(|mut row| row -= centre.transpose());
        let parts = left.clone().svd(false, true);
        let rows = parts.v_t.expect("it was asked for");
        let mut order: Vec<usize> = (0..rows.nrows()).collect();
        order.sort_by(|a, b| parts.singular_values[*b].total_cmp(&parts.singular_values[*a]));
        let mut vectors = DMatrix::zeros(quantities, 0);
        for k in order.into_iter().take(COMPONENTS) {
            if left.amax() < REST {
                break;
            }
            let vector = rows.row(k).transpose();
            left -= &left * &vector * vector.transpose();
            let last = vectors.ncols();
            vectors = vectors.insert_column(last, 0.0);
            vectors.set_column(last, &vector);
        }
        let rest = DVector::from_fn(quantities, |q, _| left.column(q).norm() / (runs as f64).sqrt());
        Self { centre, vectors, rest }
    }

    /// How much of each component these values hold.
    pub fn scores(&self, values: &DVector<f64>) -> DVector<f64> {
        self.vectors.tr_mul(&(values - &self.centre))
    }
}
