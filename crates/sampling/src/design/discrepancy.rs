//! The centred L2 discrepancy of points (Hickernell 1998, "A generalized discrepancy and quadrature error bound",
//! Math. Comp. 67, eq. 4.4), kept up to date while coordinates are exchanged.
//!
//! An exchange between two points changes one factor in their products with every other point. So its effect is known in
//! O(N), whatever the number of inputs (Jin, Chen, Sudjianto 2005, "An efficient algorithm for constructing optimal design
//! of computer experiments", J. Stat. Plann. Inference 134, section 4.2).

/// Points are padded to a multiple of this number, so that sums run over several of them at once.
const LANES: usize = 4;

/// Points and the sums that their discrepancy is made of.
pub(super) struct Discrepancy {
    points: usize,
    /// `points`, padded.
    row: usize,
    /// The coordinates, measured from the centre of the cube, input after input.
    columns: Vec<Vec<f64>>,
    /// Hickernell's product over each point.
    ones: Vec<f64>,
    /// His product over each pair of points, point after point; 0 for the padding.
    pairs: Vec<f64>,
    /// The sums of both.
    single: f64,
    double: f64,
}

/// An exchange of the coordinates of two points in one input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exchange {
    pub(super) dimension: usize,
    pub(super) a: usize,
    pub(super) b: usize,
}

/// A point's factor in the second term, by its distance from the centre.
fn one(x: f64) -> f64 {
    1.0 + 0.5 * x.abs() - 0.5 * x * x
}

/// A pair's factor in the third term.
fn two(x: f64, y: f64) -> f64 {
    1.0 + 0.5 * (x.abs() + y.abs() - (x - y).abs())
}

impl Discrepancy {
    /// Of points in the unit cube, by their coordinates input after input.
    pub(super) fn new(coordinates: &[Vec<f64>]) -> Self {
        let points = coordinates.first().map_or(0, Vec::len);
        let row = points.next_multiple_of(LANES);
        let centred = |column: &Vec<f64>| {
            let mut centred: Vec<f64> = column.iter().map(|u| u - 0.5).collect();
            centred.resize(row, 0.0);
            centred
        };
        let mut state = Self {
            points,
            row,
            columns: coordinates.iter().map(centred).collect(),
            ones: vec![1.0; points],
            pairs: vec![0.0; points * row],
            single: 0.0,
            double: 0.0,
        };
        for point in 0..points {
            state.set_products(point);
        }
        state.single = state.ones.iter().sum();
        state.double = state.pairs.iter().sum();
        state
    }

    /// Computes the products of a point from its coordinates.
    fn set_products(&mut self, point: usize) {
        let range = point * self.row..point * self.row + self.points;
        self.pairs[range.clone()].fill(1.0);
        self.ones[point] = 1.0;
        for column in &self.columns {
            let x = column[point];
            self.ones[point] *= one(x);
            for (product, y) in self.pairs[range.clone()].iter_mut().zip(column) {
                *product *= two(x, *y);
            }
        }
        for other in 0..self.points {
            self.pairs[other * self.row + point] = self.pairs[point * self.row + other];
        }
    }

    /// The square of the discrepancy.
    pub(super) fn square(&self) -> f64 {
        self.square_of([0.0; 2])
    }

    /// The square of the discrepancy after changes of both sums.
    fn square_of(&self, [single, double]: [f64; 2]) -> f64 {
        let n = self.points as f64;
        let whole = (13.0_f64 / 12.0).powi(self.columns.len() as i32);
        whole - 2.0 / n * (self.single + single) + (self.double + double) / (n * n)
    }

    /// The square of the discrepancy after an exchange that is not made.
    pub(super) fn square_after(&self, exchange: Exchange) -> f64 {
        self.square_of(self.changes(exchange))
    }

    /// How an exchange changes both sums.
    fn changes(&self, Exchange { dimension, a, b }: Exchange) -> [f64; 2] {
        let column = &self.columns[dimension];
        let (x, y) = (column[a], column[b]);
        let (of_a, of_b) = (self.row_of(a), self.row_of(b));
        // The change of the products of `a` and `b` with the point at `z`.
        let change = |z: f64, with_a: f64, with_b: f64| {
            let (near_a, near_b) = (two(x, z), two(y, z));
            (near_b - near_a) * (with_a * near_b - with_b * near_a) / (near_a * near_b)
        };
        let mut sums = [0.0; LANES];
        let others = column.chunks_exact(LANES);
        let products = of_a.chunks_exact(LANES).zip(of_b.chunks_exact(LANES));
        for (z, (with_a, with_b)) in others.zip(products) {
            for lane in 0..LANES {
                sums[lane] += change(z[lane], with_a[lane], with_b[lane]);
            }
        }
        // The pair of `a` and `b` itself does not change, and each point's product with itself counts once.
        let pair = change(x, of_a[a], of_b[a]) + change(y, of_a[b], of_b[b]);
        let swapped = |product: f64, from: f64, to: f64| product * (to / from - 1.0);
        let squares = swapped(of_a[a], two(x, x), two(y, y)) + swapped(of_b[b], two(y, y), two(x, x));
        let single = swapped(self.ones[a], one(x), one(y)) + swapped(self.ones[b], one(y), one(x));
        [single, squares + 2.0 * (sums.iter().sum::<f64>() - pair)]
    }

    /// Exchanges the coordinates of two points in one input.
    pub(super) fn make(&mut self, exchange: Exchange) {
        let Exchange { dimension, a, b } = exchange;
        let [single, double] = self.changes(exchange);
        self.single += single;
        self.double += double;
        self.columns[dimension].swap(a, b);
        self.set_products(a);
        self.set_products(b);
    }

    fn row_of(&self, point: usize) -> &[f64] {
        &self.pairs[point * self.row..(point + 1) * self.row]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hickernell's formula as it is written.
    fn written_out(coordinates: &[Vec<f64>]) -> f64 {
        let (n, d) = (coordinates[0].len(), coordinates.len());
        let mut square = (13.0_f64 / 12.0).powi(d as i32);
        for i in 0..n {
            let mut product = 1.0;
            for x in coordinates {
                product *= 1.0 + 0.5 * (x[i] - 0.5).abs() - 0.5 * (x[i] - 0.5).powi(2);
            }
            square -= 2.0 / n as f64 * product;
            for j in 0..n {
                let mut product = 1.0;
                for x in coordinates {
                    product *= 1.0 + 0.5 * (x[i] - 0.5).abs() + 0.5 * (x[j] - 0.5).abs() - 0.5 * (x[i] - x[j]).abs();
                }
                square += product / (n * n) as f64;
            }
        }
        square
    }

    fn points(count: u32) -> Vec<Vec<f64>> {
        let place = |i: u32, step: u32| (f64::from(step * i % count) + 0.3 + 0.1 * f64::from(i % 5)) / f64::from(count);
        let column = |step| (0..count).map(|i| place(i, step)).collect();
        [3, 7, 11].map(column).to_vec()
    }

    #[test]
    fn the_discrepancy_is_the_published_one() {
        // One point in the middle of d inputs: (13/12)^d - 2 + 1.
        let middle = Discrepancy::new(&[vec![0.5], vec![0.5]]).square();
        assert!((middle - ((13.0_f64 / 12.0).powi(2) - 1.0)).abs() < 1e-15);
        // Two points in one input at 1/4 and 3/4: 13/12 - 2 * (1 + 1/8 - 1/32) + (1.25 + 1) / 2.
        let two = Discrepancy::new(&[vec![0.25, 0.75]]).square();
        assert!((two - (13.0 / 12.0 - 2.0 * 1.09375 + 1.125)).abs() < 1e-15);
        for count in [5, 8, 13] {
            let points = points(count);
            let square = Discrepancy::new(&points).square();
            assert!((square - written_out(&points)).abs() < 1e-14, "{count}");
        }
    }

    /// Each exchange of 10 points, against the sum over all pairs; the points themselves stay.
    #[test]
    fn the_effect_of_an_exchange_is_known_beforehand() {
        let start = points(10);
        let state = Discrepancy::new(&start);
        for dimension in 0..3 {
            for (a, b) in (0..10).flat_map(|a| (0..10).map(move |b| (a, b))) {
                let mut changed = start.clone();
                changed[dimension].swap(a, b);
                let square = state.square_after(Exchange { dimension, a, b });
                let expected = written_out(&changed);
                assert!((square - expected).abs() < 1e-14, "{dimension} {a} {b}");
            }
        }
        assert!((state.square() - written_out(&start)).abs() < 1e-14);
    }

    #[test]
    fn exchanges_do_not_drift() {
        let mut expected = points(40);
        let mut state = Discrepancy::new(&expected);
        for k in 0..1000 {
            let (dimension, a, b) = (k % 3, k % 40, (7 * k + 1) % 40);
            state.make(Exchange { dimension, a, b });
            expected[dimension].swap(a, b);
        }
        let (square, expected) = (state.square(), written_out(&expected));
        assert!((square - expected).abs() < 1e-12, "{square} {expected}");
    }
}
