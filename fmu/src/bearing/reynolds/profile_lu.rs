//! LU factorisation of an unsymmetric matrix with a profile.

/// A matrix stored by rows below and by columns above its diagonal, each from its first non-zero on.
///
/// Factorised without pivoting, which is stable for the column-wise diagonally dominant matrices of
/// the film (Higham 2002, Accuracy and Stability of Numerical Algorithms, section 9.5). The buffers
/// are kept between uses.
#[derive(Clone, Debug, Default)]
pub(super) struct ProfileLu {
    lower: Profile,
    upper: Profile,
    /// The diagonal; after factorisation its reciprocal.
    diagonal: Vec<f64>,
}

/// Rows (or columns) that reach from a first entry up to, without, the diagonal.
#[derive(Clone, Debug, Default)]
struct Profile {
    first: Vec<u32>,
    start: Vec<u32>,
    value: Vec<f64>,
}

impl Profile {
    fn reset(&mut self, size: usize) {
        self.first.clear();
        self.first.extend(0..size as u32);
    }

    fn reach(&mut self, line: usize, to: usize) {
        self.first[line] = self.first[line].min(to as u32);
    }

    fn allocate(&mut self) {
        self.start.clear();
        let mut end = 0;
        for (line, &first) in self.first.iter().enumerate() {
            self.start.push(end);
            end += line as u32 - first;
        }
        self.start.push(end);
        self.value.clear();
        self.value.resize(end as usize, 0.0);
    }

    fn add(&mut self, line: usize, at: usize, value: f64) {
        self.value[self.start[line] as usize + at - self.first[line] as usize] += value;
    }

    fn first(&self, line: usize) -> usize {
        self.first[line] as usize
    }

    fn line(&self, line: usize) -> &[f64] {
        &self.value[self.start[line] as usize..self.start[line + 1] as usize]
    }
}

impl ProfileLu {
    /// Starts a matrix of `size` rows; declare its entries with [`reach`](Self::reach) next.
    pub(super) fn reset(&mut self, size: usize) {
        self.lower.reset(size);
        self.upper.reset(size);
        self.diagonal.clear();
        self.diagonal.resize(size, 0.0);
    }

    /// Declares the entry in `row` and `column`.
    pub(super) fn reach(&mut self, row: usize, column: usize) {
        if column < row {
            self.lower.reach(row, column);
        } else if column > row {
            self.upper.reach(column, row);
        }
    }

    /// Makes room for the declared entries, all zero.
    pub(super) fn allocate(&mut self) {
        self.lower.allocate();
        self.upper.allocate();
    }

    /// Adds to the declared entry in `row` and `column`.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        match column.cmp(&row) {
            std::cmp::Ordering::Less => self.lower.add(row, column, value),
            std::cmp::Ordering::Equal => self.diagonal[row] += value,
            std::cmp::Ordering::Greater => self.upper.add(column, row, value),
        }
    }

    /// Factorises in place. False when a pivot vanishes.
    pub(super) fn factorise(&mut self) -> bool {
        for k in 0..self.diagonal.len() {
            eliminate(&mut self.lower, &self.upper, k, Some(&self.diagonal));
            eliminate(&mut self.upper, &self.lower, k, None);
            let from = self.lower.first(k).max(self.upper.first(k));
            let row = &self.lower.line(k)[from - self.lower.first(k)..];
            let column = &self.upper.line(k)[from - self.upper.first(k)..];
            let pivot = self.diagonal[k] - dot(row, column);
            if !pivot.is_normal() {
                return false;
            }
            self.diagonal[k] = 1.0 / pivot;
        }
        true
    }

    /// Solves for four right-hand sides at once, in place.
    pub(super) fn solve(&self, x: &mut [[f64; 4]]) {
        for k in 0..x.len() {
            let (before, rest) = x.split_at_mut(k);
            let own = &mut rest[0];
            for (l, known) in self
                .lower
                .line(k)
                .iter()
                .zip(&before[self.lower.first(k)..])
            {
                for q in 0..4 {
                    own[q] -= l * known[q];
                }
            }
        }
        for k in (0..x.len()).rev() {
            let own = x[k].map(|value| value * self.diagonal[k]);
            x[k] = own;
            let first = self.upper.first(k);
            for (u, above) in self.upper.line(k).iter().zip(&mut x[first..k]) {
                for q in 0..4 {
                    above[q] -= u * own[q];
                }
            }
        }
    }
}

/// Computes line `k` of one factor from its earlier entries and the other factor's lines; `scale`
/// holds the reciprocal pivots for the lower factor, whose diagonal is not one.
fn eliminate(own: &mut Profile, other: &Profile, k: usize, scale: Option<&[f64]>) {
    let first = own.first(k);
    if first == k {
        return;
    }
    let start = own.start[k] as usize;
    let line = &mut own.value[start..start + k - first];
    for m in first..k {
        let (done, rest) = line.split_at_mut(m - first);
        let from = first.max(other.first(m));
        let mut value = rest[0];
        if from < m {
            value -= dot(
                &done[from - first..],
                &other.line(m)[from - other.first(m)..],
            );
        }
        rest[0] = scale.map_or(value, |scale| value * scale[m]);
    }
}

/// The scalar product, in independent sums that the compiler can keep in vector registers.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [0.0; 4];
    let (a4, a1) = a.as_chunks::<4>();
    let (b4, b1) = b.as_chunks::<4>();
    for (x, y) in a4.iter().zip(b4) {
        for q in 0..4 {
            sum[q] += x[q] * y[q];
        }
    }
    let tail: f64 = a1.iter().zip(b1).map(|(x, y)| x * y).sum();
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + tail
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn agrees_with_a_dense_solution() {
        // A banded matrix with a corner, as a ring of cells has, column-wise dominant.
        let n = 12;
        let mut dense = DMatrix::zeros(n, n);
        for k in 0..n {
            dense[(k, k)] = 5.0 + k as f64;
            dense[(k, (k + 1) % n)] = -1.0 - 0.1 * k as f64;
            dense[((k + 3) % n, k)] -= 0.7;
        }
        let mut lu = ProfileLu::default();
        lu.reset(n);
        let entries: Vec<(usize, usize)> = (0..n)
            .flat_map(|i| (0..n).map(move |j| (i, j)))
            .filter(|&at| dense[at] != 0.0)
            .collect();
        for &(i, j) in &entries {
            lu.reach(i, j);
        }
        lu.allocate();
        for &(i, j) in &entries {
            lu.add(i, j, dense[(i, j)]);
        }
        assert!(lu.factorise());
        let b = DVector::from_fn(n, |i, _| (i as f64).sin());
        let mut x: Vec<[f64; 4]> = b.iter().map(|&b| [b, 2.0 * b, 0.0, -b]).collect();
        lu.solve(&mut x);
        let expected = dense.lu().solve(&b).unwrap();
        for k in 0..n {
            assert!((x[k][0] - expected[k]).abs() < 1e-14);
            assert!((x[k][1] - 2.0 * expected[k]).abs() < 1e-14);
            assert_eq!(x[k][2], 0.0);
        }
    }
}
