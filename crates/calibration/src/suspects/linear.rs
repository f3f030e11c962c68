//! By how much the sum of squares would fall, without a run.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{
    super::errors::Errors,
    inquiry::{Inquiry, expected},
};

/// The linear problem at the optimum, with the shared errors as unknowns. An unknown at a bound is known.
pub struct Linear<'a> {
    pub slopes: &'a DMatrix<f64>,
    /// The effects of the shared errors, a row a value.
    effects: DMatrix<f64>,
    pub accuracies: DVector<f64>,
    residuals: DVector<f64>,
    full: DMatrix<f64>,
    open: Vec<usize>,
    /// The degrees of freedom.
    pub freedom: f64,
}

impl<'a> Linear<'a> {
    pub fn new(inquiry: &Inquiry<'a>) -> Option<Self> {
        let (problem, minimum) = (inquiry.problem, &inquiry.optimum.minimum);
        let posterior = &inquiry.optimum.posterior;
        let (errors, values) = (Errors::new(problem), problem.values());
        let (full, open) = inquiry.optimum.precision(&errors);
        let mut effects = DMatrix::zeros(values, problem.sources.len());
        let quantities = problem.quantities.len();
        for value in 0..values {
            let row = errors.effects(value / quantities, value % quantities);
            effects.set_row(value, &row.transpose());
        }
        let accuracies = problem.cases.iter().flat_map(|case| &case.measured).map(|measured| measured.accuracy);
        (values > 0).then(|| Self {
            slopes: &posterior.slopes[0],
            effects,
            accuracies: DVector::from_iterator(values, accuracies),
            residuals: minimum.misfit.residuals.rows(0, values).into_owned(),
            full,
            open,
            freedom: expected(problem, minimum, 0).freedom,
        })
    }

    /// By how much the sum of squares falls if a further unknown moves the misfits along a column, and how far that goes; without
    /// the unknown `but`, whose column it is. None where the others do the same.
    pub fn score(&self, column: &DVector<f64>, but: Option<usize>) -> Option<(f64, f64)> {
        /// Less than this part of a column is left of one that the others make up.
        const LEFT: f64 = 1e-6;
        let n = self.slopes.ncols();
        let along_all = [self.slopes.tr_mul(column), self.effects.tr_mul(column)];
        let open: Vec<usize> = self.open.iter().copied().filter(|k| Some(*k) != but).collect();
        let along = DVector::from_iterator(
            open.len(),
            open.iter().map(|&k| if k < n { along_all[0][k] } else { along_all[1][k - n] }),
        );
        let factor = Cholesky::new(self.full.select_rows(&open).select_columns(&open))?;
        let square = column.norm_squared();
        let own = square - along.dot(&factor.solve(&along));
        let pull = column.dot(&self.residuals);
        (own > LEFT * square).then(|| (pull * pull / own, -pull / own))
    }
}
