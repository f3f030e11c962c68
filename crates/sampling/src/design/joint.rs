//! Inputs that are drawn together, a row of a sample at a time, so that whatever binds them stays: correlations, curved
//! valleys, separate modes.

use std::sync::Arc;

use nalgebra::DMatrix;

/// Inputs that are drawn together from a sample.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The inputs' places among all.
    inputs: Vec<usize>,
    /// The sample, in the order in which a number from 0 to 1 runs through it.
    rows: Arc<Vec<Vec<f64>>>,
}

impl Joint {
    /// The inputs at these places, and a sample with a column for each. The rows are sorted along the first principal
    /// component of the standardised columns: a number from 0 to 1 that changes little goes to a row that is near, as far
    /// as one direction tells, and a design that spreads its numbers evenly spreads the rows.
    ///
    /// # Errors
    /// When there is no row, or one has another length.
    pub fn new(inputs: Vec<usize>, rows: Vec<Vec<f64>>) -> Result<Self, String> {
        if inputs.is_empty() || rows.is_empty() {
            return Err("a sample needs a column and a row".to_owned());
        }
        if let Some(row) = rows.iter().find(|row| row.len() != inputs.len()) {
            let (count, wanted) = (row.len(), inputs.len());
            return Err(format!("a row of the sample has {count} numbers, not {wanted}"));
        }
        let rows = Arc::new(sorted(rows));
        Ok(Self { inputs, rows })
    }

    /// The inputs' places among all.
    pub fn inputs(&self) -> &[usize] {
        &self.inputs
    }

    /// The input whose number from 0 to 1 chooses the row.
    pub fn lead(&self) -> usize {
        self.inputs[0]
    }

    /// How many rows there are: one at least.
    pub fn count(&self) -> usize {
        self.rows.len()
    }

    /// Whether several inputs are drawn together; one alone is as independent as any other.
    pub fn binds(&self) -> bool {
        self.inputs.len() > 1
    }

    /// The row at a number from 0 to 1, in the order of the inputs.
    pub fn row(&self, place: f64) -> &[f64] {
        let last = self.rows.len() - 1;
        let index = (place * self.rows.len() as f64) as usize;
        &self.rows[index.min(last)]
    }

    /// Puts the row at the lead's number into a point. `places` has a number from 0 to 1 for each input of the point.
    pub fn fill(&self, places: &[f64], point: &mut [f64]) {
        let row = self.row(places[self.lead()]);
        for (&input, &value) in self.inputs.iter().zip(row) {
            point[input] = value;
        }
    }
}

/// The rows along the first principal component of the standardised columns.
fn sorted(mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let (count, columns) = (rows.len() as f64, rows[0].len());
    let means: Vec<f64> = (0..columns).map(|k| rows.iter().map(|row| row[k]).sum::<f64>() / count).collect();
    let squares = |k: usize| rows.iter().map(|row| (row[k] - means[k]).powi(2)).sum::<f64>();
    // A column that does not vary gives no direction.
    let units: Vec<f64> = (0..columns)
        .map(|k| match squares(k) {
            squares if squares > 0.0 => (count / squares).sqrt(),
            _ => 0.0,
        })
        .collect();
    let standard = |row: &[f64], k: usize| (row[k] - means[k]) * units[k];
    // The directions are those of the correlations, which these are but for a factor.
    let product = |a: usize, b: usize| -> f64 { rows.iter().map(|row| standard(row, a) * standard(row, b)).sum() };
    let eigen = DMatrix::from_fn(columns, columns, product).symmetric_eigen();
    let first = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let sign = first[first.icamax()].signum();
    let score = |row: &[f64]| -> f64 { (0..columns).map(|k| sign * first[k] * standard(row, k)).sum() };
    let mut scored: Vec<(f64, Vec<f64>)> = rows.drain(..).map(|row| (score(&row), row)).collect();
    scored.sort_by(|a, b| a.0.total_cmp(&b.0));
    scored.into_iter().map(|(_, row)| row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_whole_and_follow_the_main_direction() {
        // Along a line, in a random order, with a third column that does not vary.
        let rows: Vec<Vec<f64>> =
            [7, 2, 9, 0, 5, 1, 8, 3, 6, 4].map(|k| vec![f64::from(k), 100.0 - 10.0 * f64::from(k), 3.0]).to_vec();
        let joint = Joint::new(vec![2, 0, 1], rows).unwrap();
        let mut first = Vec::new();
        for k in 0..10 {
            let mut point = [f64::NAN; 4];
            joint.fill(&[0.9, 0.9, (f64::from(k) + 0.5) / 10.0, 0.9], &mut point);
            assert_eq!(point[0], 100.0 - 10.0 * point[2]);
            assert_eq!(point[1], 3.0);
            assert!(point[3].is_nan());
            first.push(point[2]);
        }
        assert!(first.is_sorted() || first.iter().rev().is_sorted(), "{first:?}");
        // Every row has its tenth of the interval, the ends too.
        first.sort_by(f64::total_cmp);
        assert_eq!(first, (0..10).map(f64::from).collect::<Vec<_>>());
        assert_eq!(joint.row(1.0), joint.row(0.999));
        assert_eq!((joint.inputs(), joint.lead(), joint.count()), (&[2, 0, 1][..], 2, 10));
        assert!(joint.binds() && !Joint::new(vec![0], vec![vec![1.0]]).unwrap().binds());
    }

    /// Two columns rise together, each with its own zigzag, and a third, in a small unit, with neither. Far from 0, the
    /// direction is still that of what varies, not of the means; and a column's unit does not matter.
    #[test]
    fn the_main_direction_is_that_of_the_standardised_columns() {
        let zigzag = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        let apart = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0];
        let row = |k: usize| {
            let rise = f64::from(u32::try_from(k).unwrap());
            let [x, y] = [rise + 0.6 * zigzag[k], rise - 0.6 * zigzag[k]];
            vec![1003.0 + x, 5.0 + 0.01 * y, 7000.0 + 1000.0 * apart[k]]
        };
        let mixed = [5, 0, 3, 7, 1, 6, 2, 4].map(row).to_vec();
        let rows = sorted(mixed);
        let expected: Vec<Vec<f64>> = (0..8).map(row).collect();
        let reversed: Vec<Vec<f64>> = expected.iter().rev().cloned().collect();
        assert!(rows == expected || rows == reversed, "{rows:?}");
    }

    /// Where one column rises and the other falls, the rows go along the difference. The means, both positive, would
    /// point along the sum.
    #[test]
    fn the_main_direction_is_not_that_of_the_means() {
        let zigzag = [0.3, -0.3, 0.3, -0.3, 0.3, -0.3, 0.3, -0.3];
        let row = |k: u8| vec![f64::from(k), 7.0 - f64::from(k) + zigzag[usize::from(k)]];
        let rows = sorted([5, 0, 3, 7, 1, 6, 2, 4].map(row).to_vec());
        let firsts: Vec<f64> = rows.iter().map(|row| row[0]).collect();
        assert!(firsts.is_sorted() || firsts.is_sorted_by(|a, b| a >= b), "{firsts:?}");
    }

    /// The column with the largest part in the direction rises, whichever it is and however the others go with it.
    #[test]
    fn the_leading_column_rises() {
        let zigzag = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        let apart = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0, -1.0, 1.0];
        for leading in 0..3 {
            for signs in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
                let row = |k: u8| {
                    let (rise, k) = (f64::from(k), usize::from(k));
                    let mut row = vec![rise, signs[0] * (rise + zigzag[k]), signs[1] * (rise + apart[k])];
                    row.rotate_right(leading);
                    row
                };
                let rows = sorted([5, 0, 3, 7, 1, 6, 2, 4].map(row).to_vec());
                let (first, last) = (rows[0][leading], rows[7][leading]);
                assert!(first < last, "{leading} {signs:?}: {rows:?}");
            }
        }
    }

    #[test]
    fn wrong_samples_are_refused() {
        assert!(Joint::new(vec![0], Vec::new()).is_err());
        let error = Joint::new(vec![0, 1], vec![vec![1.0, 2.0], vec![1.0]]).unwrap_err();
        assert!(error.contains("has 1 numbers, not 2"), "{error}");
    }
}
