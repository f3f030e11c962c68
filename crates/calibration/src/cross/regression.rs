//! The plainest predictions that a model has to beat: a straight line through the other cases, and their mean.

use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the largest one count as none.
const RANK: f64 = 1e-9;

/// Predicts each of `y` from the others by linear least squares on `rows` (with a constant; without columns it is the
/// others' mean). `None` where the others are too few: as many as there are coefficients, or fewer.
pub fn leave_one_out(rows: &[Vec<f64>], y: &[f64]) -> Vec<Option<f64>> {
    let scaled = standardised(rows);
    (0..y.len()).map(|left_out| predicted(&scaled, y, left_out)).collect()
}

/// Columns of mean 0 and size 1, so that ranks can be told; constant columns say nothing and go.
fn standardised(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let n = rows.len() as f64;
    let columns = (0..rows.first().map_or(0, Vec::len)).filter_map(|k| {
        let mean = rows.iter().map(|row| row[k]).sum::<f64>() / n;
        let square = rows.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>() / n;
        let varies = square.sqrt() > RANK * mean.abs();
        varies.then(|| (k, mean, square.sqrt()))
    });
    let columns: Vec<_> = columns.collect();
    let row = |row: &Vec<f64>| {
        let scaled = columns.iter().map(|&(k, mean, size)| (row[k] - mean) / size);
        std::iter::once(1.0).chain(scaled).collect()
    };
    rows.iter().map(row).collect()
}

fn predicted(rows: &[Vec<f64>], y: &[f64], left_out: usize) -> Option<f64> {
    let others: Vec<usize> = (0..y.len()).filter(|&case| case != left_out).collect();
    let coefficients = rows[left_out].len();
    if others.len() <= coefficients.max(1) {
        return None;
    }
    let matrix = DMatrix::from_fn(others.len(), coefficients, |i, k| rows[others[i]][k]);
    let right = DVector::from_fn(others.len(), |i, _| y[others[i]]);
    let factors = matrix.svd(true, true);
    let least = RANK * factors.singular_values.amax();
    let solution = factors.solve(&right, least).ok()?;
    let pairs = rows[left_out].iter().zip(&solution);
    Some(pairs.map(|(value, coefficient)| value * coefficient).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_those_of_the_hat_matrix() {
        // With leverages h, the error of a case that is left out is e / (1 - h) (Allen 1974, Technometrics 16, 125).
        let x = [1.0, 2.0, 4.0, 7.0, 11.0];
        let y = [0.3, 1.9, 2.5, 6.0, 8.4];
        let n = x.len() as f64;
        let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
        let xx: f64 = x.iter().map(|x| (x - mx).powi(2)).sum();
        let xy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
        // A column that does not vary changes nothing.
        let rows: Vec<Vec<f64>> = x.iter().map(|&x| vec![5e6, 1e-6 * x]).collect();
        for ((x, y), predicted) in x.iter().zip(y).zip(leave_one_out(&rows, &y)) {
            let residual = my + xy / xx * (x - mx) - y;
            let leverage = 1.0 / n + (x - mx).powi(2) / xx;
            let error = predicted.unwrap() - y;
            assert!((error - residual / (1.0 - leverage)).abs() < 1e-9, "{error}");
        }
    }

    #[test]
    fn without_columns_it_is_the_mean_of_the_others() {
        let means = leave_one_out(&[vec![], vec![], vec![]], &[1.0, 2.0, 6.0]);
        for (mean, expected) in means.iter().zip([4.0, 3.5, 1.5]) {
            assert!((mean.unwrap() - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn too_few_cases_have_no_line() {
        let rows = [vec![1.0, 0.0], vec![2.0, 1.0], vec![3.0, 5.0], vec![4.0, 2.0]];
        assert_eq!(leave_one_out(&rows, &[1.0, 2.0, 3.0, 5.0]), [None; 4]);
    }
}
