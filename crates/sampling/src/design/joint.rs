//! Inputs that are drawn together, a row of a sample at a time, so that whatever binds them stays: correlations, curved
//! valleys, separate modes.

use std::sync::Arc;

/// Inputs that are drawn together from a sample.
#[derive(Clone, Debug)]
pub struct Joint {
    /// The inputs' places among all.
    inputs: Vec<usize>,
    /// The sample, in the order in which a number from 0 to 1 runs through it.
    rows: Arc<Vec<Vec<f64>>>,
}

impl Joint {
    /// The inputs at these places, and a sample with a column for each. The rows are sorted by the first column: a number from
    /// 0 to 1 that changes little goes to a row that is near, as far as this one tells, and a design that spreads its numbers
    /// evenly spreads the rows.
    ///
    /// # Errors
    /// When there is no row, or one has another length.
    pub fn new(inputs: Vec<usize>, mut rows: Vec<Vec<f64>>) -> Result<Self, String> {
        if inputs.is_empty() || rows.is_empty() {
            return Err("a sample needs a column and a row".to_owned());
        }
        if let Some(row) = rows.iter().find(|row| row.len() != inputs.len()) {
            let (count, wanted) = (row.len(), inputs.len());
            return Err(format!("a row of the sample has {count} numbers, not {wanted}"));
        }
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Ok(Self { inputs, rows: Arc::new(rows) })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_stay_whole_and_follow_the_first_column() {
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
        assert!(first.is_sorted(), "{first:?}");
        // Every row has its tenth of the interval, the ends too.
        assert_eq!(first, (0..10).map(f64::from).collect::<Vec<_>>());
        assert_eq!(joint.row(1.0), joint.row(0.999));
        assert_eq!((joint.inputs(), joint.lead(), joint.count()), (&[2, 0, 1][..], 2, 10));
        assert!(joint.binds() && !Joint::new(vec![0], vec![vec![1.0]]).unwrap().binds());
    }

    #[test]
    fn wrong_samples_are_refused() {
        assert!(Joint::new(vec![0], Vec::new()).is_err());
        let error = Joint::new(vec![0, 1], vec![vec![1.0, 2.0], vec![1.0]]).unwrap_err();
        assert!(error.contains("has 1 numbers, not 2"), "{error}");
    }
}
