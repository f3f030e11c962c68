//! Cholesky factorisation of a symmetric positive definite skyline matrix.

/// A symmetric positive definite matrix. Each row of the lower triangle is stored from its first non-zero to the diagonal.
/// Buffers are kept between uses: refilling a matrix of a size seen before allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Skyline {
    first: Vec<usize>,
    start: Vec<usize>,
    value: Vec<f64>,
}

impl Skyline {
    /// Removes all rows.
    pub fn clear(&mut self) {
        self.first.clear();
        self.start.clear();
        self.value.clear();
    }

    /// Appends a row whose first non-zero is in column `first` (at most the row's own number).
    pub fn push_row(&mut self, first: usize) {
        let row = self.first.len();
        self.first.push(first);
        self.start.push(self.value.len());
        self.value.resize(self.value.len() + row - first + 1, 0.0);
    }

    /// Adds `value` to the entry in `row` and `column <= row`.
    pub fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = self.start[row] + column - self.first[row];
        self.value[at] += value;
    }

    /// Replaces the matrix `A` by its Cholesky factor `L`, `A = L L^T`, with reciprocals on the diagonal. False when the
    /// matrix is not positive definite.
    pub fn factorise(&mut self) -> bool {
        for i in 0..self.first.len() {
            let (done, rest) = self.value.split_at_mut(self.start[i]);
            let (first, row) = (self.first[i], rest);
            for j in first..i {
                let from = first.max(self.first[j]);
                let other = &done[self.start[j]..];
                let sum = dot(
                    &row[from - first..j - first],
                    &other[from - self.first[j]..j - self.first[j]],
                );
                let pivot = other[j - self.first[j]];
                row[j - first] = (row[j - first] - sum) * pivot;
            }
            let own = &row[..i - first];
            let pivot = row[i - first] - dot(own, own);
            if pivot.is_nan() || pivot <= 0.0 {
                return false;
            }
            row[i - first] = 1.0 / pivot.sqrt();
        }
        true
    }

    /// Solves `A x = b` for two right-hand sides at once, in place. Needs [`factorise`](Self::factorise).
    pub fn solve2(&self, x: &mut [[f64; 2]]) {
        for i in 0..x.len() {
            let (first, row) = self.row(i);
            let mut sum = x[i];
            for (l, known) in row.iter().zip(&x[first..i]) {
                sum[0] -= l * known[0];
                sum[1] -= l * known[1];
            }
            let pivot = self.value[self.start[i] + i - first];
            x[i] = [sum[0] * pivot, sum[1] * pivot];
        }
        for i in (0..x.len()).rev() {
            let (first, row) = self.row(i);
            let pivot = self.value[self.start[i] + i - first];
            let own = [x[i][0] * pivot, x[i][1] * pivot];
            x[i] = own;
            for (l, above) in row.iter().zip(&mut x[first..i]) {
                above[0] -= l * own[0];
                above[1] -= l * own[1];
            }
        }
    }

    /// The first column of row `i` and the entries before the diagonal.
    fn row(&self, i: usize) -> (usize, &[f64]) {
        let first = self.first[i];
        let start = self.start[i];
        (first, &self.value[start..start + i - first])
    }
}

/// The scalar product, in four independent sums that the compiler can keep in vector registers.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [0.0; 4];
    let (a4, a1) = a.as_chunks::<4>();
    let (b4, b1) = b.as_chunks::<4>();
    for (x, y) in a4.iter().zip(b4) {
        for k in 0..4 {
            sum[k] += x[k] * y[k];
        }
    }
    let tail: f64 = a1.iter().zip(b1).map(|(x, y)| x * y).sum();
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + tail
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_matrix_with_a_ragged_skyline() {
        // A = tridiagonal (4, -1) with an extra coupling between 0 and 3.
        let mut a = Skyline::default();
        for first in [0, 0, 1, 0, 3] {
            a.push_row(first);
        }
        for i in 0..5 {
            a.add(i, i, 4.0);
        }
        for i in 1..5 {
            a.add(i, i - 1, -1.0);
        }
        a.add(3, 0, -0.5);
        let dense = |x: [f64; 5]| {
            let mut y = [0.0; 5];
            for i in 0..5 {
                y[i] += 4.0 * x[i];
                if i > 0 {
                    y[i] -= x[i - 1];
                    y[i - 1] -= x[i];
                }
            }
            y[0] -= 0.5 * x[3];
            y[3] -= 0.5 * x[0];
            y
        };
        let (u, v) = ([1.0, -2.0, 3.0, 0.5, 7.0], [0.0, 1.0, 0.0, -1.0, 2.0]);
        let mut x: Vec<[f64; 2]> = dense(u)
            .into_iter()
            .zip(dense(v))
            .map(|(a, b)| [a, b])
            .collect();
        assert!(a.factorise());
        a.solve2(&mut x);
        for i in 0..5 {
            assert!((x[i][0] - u[i]).abs() < 1e-13 && (x[i][1] - v[i]).abs() < 1e-13);
        }
    }

    #[test]
    fn refuses_an_indefinite_matrix() {
        let mut a = Skyline::default();
        a.push_row(0);
        a.push_row(0);
        a.add(0, 0, 1.0);
        a.add(1, 1, 1.0);
        a.add(1, 0, 2.0);
        assert!(!a.factorise());
    }
}
