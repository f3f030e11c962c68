//! Cubic splines on evenly spaced nodes.

/// The condition at an end of a spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplineEnd {
    /// The function is even about the end: its slope is zero.
    Even,
    /// The function is odd about the end: its curvature is zero.
    Odd,
    /// No condition is known: the slope is that of the cubic through the four outermost nodes.
    Free,
}

/// The twice continuously differentiable cubic spline through a fixed number of values; its linear system is
/// factorised once.
#[derive(Clone, Debug)]
pub struct Spline {
    ends: [SplineEnd; 2],
    /// Entries above the diagonal, after elimination.
    upper: Vec<f64>,
    /// Reciprocal pivots.
    pivots: Vec<f64>,
}

impl SplineEnd {
    /// The end's row of the linear system: its diagonal and its neighbour's entry.
    fn row(self) -> [f64; 2] {
        match self {
            Self::Even | Self::Free => [1.0, 0.0],
            Self::Odd => [2.0, 1.0],
        }
    }

    /// The row's right-hand side, from the four outermost values.
    fn right(self, v: [f64; 4]) -> f64 {
        match self {
            Self::Even => 0.0,
            Self::Odd => 3.0 * (v[1] - v[0]),
            Self::Free => (-11.0 * v[0] + 18.0 * v[1] - 9.0 * v[2] + 2.0 * v[3]) / 6.0,
        }
    }
}

impl Spline {
    /// Factorises the system for `n >= 4` values.
    pub fn new(n: usize, ends: [SplineEnd; 2]) -> Self {
        // Rows of the tridiagonal system: slope[i-1] + 4 slope[i] + slope[i+1] = 3 (v[i+1] - v[i-1]).
        let (mut upper, mut pivots) = (vec![0.0; n], vec![0.0; n]);
        let [diagonal, right] = ends[0].row();
        (upper[0], pivots[0]) = (right / diagonal, 1.0 / diagonal);
        for i in 1..n - 1 {
            pivots[i] = 1.0 / (4.0 - upper[i - 1]);
            upper[i] = pivots[i];
        }
        let [diagonal, left] = ends[1].row();
        pivots[n - 1] = 1.0 / (diagonal - left * upper[n - 2]);
        Self { ends, upper, pivots }
    }

    /// Computes the slopes at the nodes, per node spacing.
    pub fn slopes(&self, values: &[f64], slopes: &mut [f64]) {
        self.slopes_of_many(1, values, slopes);
    }

    /// Computes the slopes of `many` functions at once; the values of all functions at one node stand side by side.
    /// The inner loops run over the functions, so that the processor works on several of them at a time.
    pub fn slopes_of_many(&self, many: usize, values: &[f64], slopes: &mut [f64]) {
        let n = self.upper.len();
        let (values, slopes) = (&values[..n * many], &mut slopes[..n * many]);
        let node = |i: usize| &values[i * many..(i + 1) * many];
        let end = |end: SplineEnd, nodes: [usize; 4], lane: usize| end.right(nodes.map(|i| node(i)[lane]));
        for (lane, slope) in slopes[..many].iter_mut().enumerate() {
            *slope = self.pivots[0] * end(self.ends[0], [0, 1, 2, 3], lane);
        }
        for i in 1..n - 1 {
            let (done, rest) = slopes.split_at_mut(i * many);
            let before = &done[(i - 1) * many..];
            let around = node(i + 1).iter().zip(node(i - 1));
            for ((slope, before), (right, left)) in rest.iter_mut().zip(before).zip(around) {
                *slope = self.pivots[i] * (3.0 * (right - left) - before);
            }
        }
        // The second end is the first one mirrored: slopes change their sign.
        let mirrored = [n - 1, n - 2, n - 3, n - 4];
        let [_, left] = self.ends[1].row();
        let (done, last) = slopes.split_at_mut((n - 1) * many);
        for (lane, (slope, before)) in last.iter_mut().zip(&done[(n - 2) * many..]).enumerate() {
            let right = end(self.ends[1], mirrored, lane);
            *slope = self.pivots[n - 1] * (-right - left * before);
        }
        for i in (0..n - 1).rev() {
            let (rest, after) = slopes.split_at_mut((i + 1) * many);
            for (slope, after) in rest[i * many..].iter_mut().zip(&after[..many]) {
                *slope -= self.upper[i] * after;
            }
        }
    }
}

/// Weights of the cubic Hermite polynomial at `x` in 0..1: of both values, then of both slopes.
#[inline]
pub fn hermite(x: f64) -> [f64; 4] {
    let (x2, y) = (x * x, 1.0 - x);
    let y2 = y * y;
    [(1.0 + 2.0 * x) * y2, (3.0 - 2.0 * x) * x2, x * y2, -x2 * y]
}

/// The largest whole number up to `x`, whose size must be one of an `i32`.
#[inline]
pub fn below(x: f64) -> i32 {
    let towards_zero = x as i32;
    towards_zero - i32::from(f64::from(towards_zero) > x)
}

/// The derivatives of [`hermite`]'s weights over `x`.
pub fn slope_of_hermite(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [-6.0 * x * y, 6.0 * x * y, y * (1.0 - 3.0 * x), x * (3.0 * x - 2.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_below() {
        for x in [-3.0, -2.7, -0.1, 0.0, 0.9, 4.0] {
            assert_eq!(f64::from(below(x)), x.floor());
        }
    }

    #[test]
    fn a_cubic_is_its_own_spline() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.3 * x * x - 0.05 * x * x * x;
        let values: Vec<f64> = (0..9).map(|i| cubic(f64::from(i))).collect();
        let mut slope = [0.0; 9];
        Spline::new(9, [SplineEnd::Free; 2]).slopes(&values, &mut slope);
        for position in [0.0_f64, 0.4, 3.7, 8.0] {
            let cell = (position as usize).min(7);
            let [a, b, c, d] = hermite(position - cell as f64);
            let sum = a * values[cell] + b * values[cell + 1] + c * slope[cell] + d * slope[cell + 1];
            assert!((sum - cubic(position)).abs() < 1e-12);
        }
    }

    #[test]
    fn symmetric_ends() {
        let values: Vec<f64> = (0..=8).map(|i| (f64::from(i) * 0.125 * std::f64::consts::PI).sin()).collect();
        let mut slope = [0.0; 9];
        Spline::new(9, [SplineEnd::Odd; 2]).slopes(&values, &mut slope);
        let expected = 0.125 * std::f64::consts::PI;
        assert!((slope[0] - expected).abs() < 2e-4 && (slope[8] + expected).abs() < 2e-4);
        let values: Vec<f64> = (0..=8).map(|i| (f64::from(i) * 0.125 * std::f64::consts::PI).cos()).collect();
        Spline::new(9, [SplineEnd::Even; 2]).slopes(&values, &mut slope);
        assert_eq!((slope[0], slope[8]), (0.0, 0.0));
        assert!((slope[4] + expected).abs() < 2e-4);
    }
}
