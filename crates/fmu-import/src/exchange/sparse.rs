//! Linear equations most of whose coefficients are zero: triangles by columns with exchanges of rows (Gilbert & Peierls 1988,
//! SIAM J. Sci. Stat. Comput. 9, 862-874), the columns in an order that fills few zeros: least degree first (Tinney & Walker
//! 1967, Proc. IEEE 55, 1801-1809).

use super::jacobian::Columns;

/// The part of the largest possible pivot that lets the diagonal's one stay, which keeps to the order.
const PIVOT: f64 = 0.1;

#[derive(Debug, Default)]
pub struct Triangles {
    /// The columns in their order, and the rows of their pivots, once found.
    order: Vec<usize>,
    pivots: Vec<usize>,
    /// By columns in that order: below the diagonal by rows, above it by places in the order.
    lower: Columns,
    upper: Columns,
    diagonal: Vec<f64>,
    column: Vec<f64>,
}

impl Triangles {
    /// For coefficients that stand where these do, and on the diagonal.
    pub fn of(coefficients: &Columns) -> Self {
        let n = coefficients.len();
        Self { order: order(coefficients), column: vec![0.0; n], ..Self::default() }
    }

    /// Whether it is for `n` columns.
    pub fn is_for(&self, n: usize) -> bool {
        self.order.len() == n
    }

    /// Decomposes the matrix with `shift` on its diagonal less these coefficients; whether that is possible.
    pub fn decompose(&mut self, coefficients: &Columns, shift: f64) -> bool {
        let n = self.order.len();
        let empty = |columns: &mut Columns| {
            columns.resize_with(n, Vec::new);
            columns.iter_mut().for_each(Vec::clear);
        };
        empty(&mut self.lower);
        empty(&mut self.upper);
        self.pivots.clear();
        self.diagonal.clear();
        // Beside its row's largest coefficient a pivot counts: a row that stands on its diagonal alone is not mixed with others,
        // whose numbers may be larger by far.
        let mut sizes = vec![shift.abs(); n];
        for (row, coefficient) in coefficients.iter().flatten() {
            sizes[*row] = sizes[*row].max(coefficient.abs());
        }
        let mut left: Vec<bool> = vec![true; n];
        for (place, &own) in self.order.iter().enumerate() {
            let column = &mut self.column;
            column.fill(0.0);
            for (row, coefficient) in &coefficients[own] {
                column[*row] = -coefficient;
            }
            column[own] += shift;
            for (step, &row) in self.pivots.iter().enumerate() {
                let value = column[row];
                if value != 0.0 {
                    self.upper[place].push((step, value));
                    for (row, factor) in &self.lower[step] {
                        column[*row] -= factor * value;
                    }
                }
            }
            let rows = || (0..n).filter(|&row| left[row] && column[row] != 0.0);
            let weight = |row: usize| column[row].abs() / sizes[row];
            let Some(largest) = rows().max_by(|&a, &b| weight(a).total_cmp(&weight(b))) else {
                return false;
            };
            let size = weight(largest);
            let pivot = if left[own] && weight(own) >= PIVOT * size { own } else { largest };
            if !size.is_finite() {
                return false;
            }
            self.lower[place].extend(rows().filter(|&row| row != pivot).map(|row| (row, column[row] / column[pivot])));
            self.diagonal.push(column[pivot]);
            self.pivots.push(pivot);
            left[pivot] = false;
        }
        true
    }

    /// Solves with the matrix that was decomposed last.
    pub fn solve(&mut self, right: &mut [f64]) {
        for (row, below) in self.pivots.iter().zip(&self.lower) {
            let value = right[*row];
            for (row, factor) in below {
                right[*row] -= factor * value;
            }
        }
        for (value, row) in self.column.iter_mut().zip(&self.pivots) {
            *value = right[*row];
        }
        for place in (0..self.order.len()).rev() {
            let value = self.column[place] / self.diagonal[place];
            for (step, factor) in &self.upper[place] {
                self.column[*step] -= factor * value;
            }
            right[self.order[place]] = value;
        }
    }
}

/// The columns, that with the fewest neighbours first: its elimination makes them neighbours of each other.
fn order(coefficients: &Columns) -> Vec<usize> {
    let n = coefficients.len();
    let words = n.div_ceil(64);
    let bit = |of: usize| 1_u64 << (of % 64);
    let mut neighbours = vec![vec![0_u64; words]; n];
    for (column, rows) in coefficients.iter().enumerate() {
        for (row, _) in rows {
            neighbours[column][row / 64] |= bit(*row);
            neighbours[*row][column / 64] |= bit(column);
        }
    }
    let count = |set: &[u64]| set.iter().map(|word| word.count_ones()).sum::<u32>();
    let mut degrees: Vec<u32> = neighbours.iter().map(|set| count(set)).collect();
    let mut left: Vec<usize> = (0..n).collect();
    let mut order = Vec::with_capacity(n);
    while let Some(best) = (0..left.len()).min_by_key(|&place| degrees[left[place]]) {
        let column = left.remove(best);
        order.push(column);
        let own = std::mem::take(&mut neighbours[column]);
        for &other in left.iter().filter(|&&other| own[other / 64] & bit(other) != 0) {
            for (word, more) in neighbours[other].iter_mut().zip(&own) {
                *word |= more;
            }
            neighbours[other][column / 64] &= !bit(column);
            degrees[other] = count(&neighbours[other]);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hub, a chain and some entries far off, of which some pivots are zero.
    #[test]
    fn the_solution_solves_the_equations() {
        for n in [1, 2, 7, 60] {
            let stands = |row: usize, column: usize| {
                let is_near = column.abs_diff(row) == 1 || row == 0 || (column * 7 + row * 3).is_multiple_of(11);
                (is_near && row != column).then(|| (row, ((column * 5 + row * 3) % 7) as f64 - 3.1))
            };
            let coefficients: Columns =
                (0..n).map(|column| (0..n).filter_map(|row| stands(row, column)).collect()).collect();
            for shift in [1e-9, 1.0, 100.0] {
                let mut triangles = Triangles::of(&coefficients);
                if !triangles.decompose(&coefficients, shift) {
                    assert!(shift < 1.0);
                    continue;
                }
                let right: Vec<f64> = (0..n).map(|row| row as f64 - 2.5).collect();
                let mut solution = right.clone();
                triangles.solve(&mut solution);
                let mut left: Vec<f64> = solution.iter().map(|value| shift * value).collect();
                for (column, value) in coefficients.iter().zip(&solution) {
                    for (row, coefficient) in column {
                        left[*row] -= coefficient * value;
                    }
                }
                let size = solution.iter().fold(1.0_f64, |size, value| size.max(value.abs()));
                for (left, right) in left.iter().zip(&right) {
                    assert!((left - right).abs() < 1e-9 * size, "{n} {shift}: {left} for {right}");
                }
            }
        }
    }

    /// A state of its own beside one on which it has a large effect: nothing of the other's comes into it.
    #[test]
    fn a_row_that_stands_alone_keeps_its_value() {
        let coefficients = vec![vec![(1, 1e12)], vec![(1, -3.0)]];
        let mut triangles = Triangles::of(&coefficients);
        assert!(triangles.decompose(&coefficients, 0.7));
        let mut solution = [0.0, 0.3];
        triangles.solve(&mut solution);
        assert_eq!(solution[0], 0.0);
    }

    #[test]
    fn a_matrix_without_an_inverse_is_refused() {
        let coefficients = vec![vec![(0, 1.0), (1, 1.0)], vec![(0, 1.0), (1, 1.0)]];
        assert!(!Triangles::of(&coefficients).decompose(&coefficients, 0.0));
        assert!(!Triangles::of(&coefficients).decompose(&vec![vec![(0, f64::NAN)], Vec::new()], 1.0));
    }

    /// In its own order the hub's elimination would fill all.
    #[test]
    fn a_hub_is_eliminated_late() {
        let n = 50;
        let mut coefficients: Columns = (0..n).map(|column| vec![(0, 0.1), (column, 0.5)]).collect();
        coefficients[0] = (0..n).map(|row| (row, 0.1)).collect();
        let mut triangles = Triangles::of(&coefficients);
        assert!(triangles.decompose(&coefficients, 1.0));
        let filled: usize = triangles.lower.iter().chain(&triangles.upper).map(Vec::len).sum();
        assert_eq!(filled, 2 * (n - 1));
    }
}
