//! Cubic splines on evenly spaced nodes.

/// What holds at an end of the spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The function is even about the end: its slope is zero.
    Even,
    /// The function is odd about the end: its curvature is zero.
    Odd,
    /// Nothing is known: the slope is that of the cubic through the four outermost nodes.
    Free,
}

/// Slopes per node spacing, at the nodes, of the twice differentiable cubic spline through `values`
/// (at least four), written to `slopes`.
pub(super) fn slopes(values: &[f64], ends: [End; 2], slopes: &mut [f64]) {
    let n = values.len();
    // Rows of the tridiagonal system: slope[i-1] + 4 slope[i] + slope[i+1] = 3 (v[i+1] - v[i-1]).
    let mut upper = vec![0.0; n];
    let free = |v: [f64; 4]| (-11.0 * v[0] + 18.0 * v[1] - 9.0 * v[2] + 2.0 * v[3]) / 6.0;
    // Each end's row: (diagonal, neighbour, right-hand side).
    let row = |end: End, v: [f64; 4]| match end {
        End::Even => (1.0, 0.0, 0.0),
        End::Odd => (2.0, 1.0, 3.0 * (v[1] - v[0])),
        End::Free => (1.0, 0.0, free(v)),
    };
    let (diagonal, right, value) = row(ends[0], [values[0], values[1], values[2], values[3]]);
    upper[0] = right / diagonal;
    slopes[0] = value / diagonal;
    for i in 1..n - 1 {
        let pivot = 4.0 - upper[i - 1];
        upper[i] = 1.0 / pivot;
        slopes[i] = (3.0 * (values[i + 1] - values[i - 1]) - slopes[i - 1]) / pivot;
    }
    // Seen from the other end, slopes change their sign.
    let mirrored = [values[n - 1], values[n - 2], values[n - 3], values[n - 4]];
    let (diagonal, left, value) = row(ends[1], mirrored);
    slopes[n - 1] = (-value - left * slopes[n - 2]) / (diagonal - left * upper[n - 2]);
    for i in (0..n - 1).rev() {
        slopes[i] -= upper[i] * slopes[i + 1];
    }
}

/// The cubic on 0..1 with values and slopes at both ends.
pub(super) fn hermite(x: f64) -> [f64; 4] {
    let (x2, y) = (x * x, 1.0 - x);
    let y2 = y * y;
    [(1.0 + 2.0 * x) * y2, (3.0 - 2.0 * x) * x2, x * y2, -x2 * y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_its_own_spline() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.3 * x * x - 0.05 * x * x * x;
        let values: Vec<f64> = (0..9).map(|i| cubic(f64::from(i))).collect();
        let mut slope = [0.0; 9];
        slopes(&values, [End::Free; 2], &mut slope);
        for position in [0.0_f64, 0.4, 3.7, 8.0] {
            let cell = (position as usize).min(7);
            let [a, b, c, d] = hermite(position - cell as f64);
            let sum =
                a * values[cell] + b * values[cell + 1] + c * slope[cell] + d * slope[cell + 1];
            assert!((sum - cubic(position)).abs() < 1e-12);
        }
    }

    #[test]
    fn symmetric_ends() {
        let values: Vec<f64> = (0..=8)
            .map(|i| (f64::from(i) * 0.125 * std::f64::consts::PI).sin())
            .collect();
        let mut slope = [0.0; 9];
        slopes(&values, [End::Odd; 2], &mut slope);
        let expected = 0.125 * std::f64::consts::PI;
        assert!((slope[0] - expected).abs() < 2e-4 && (slope[8] + expected).abs() < 2e-4);
        let values: Vec<f64> = (0..=8)
            .map(|i| (f64::from(i) * 0.125 * std::f64::consts::PI).cos())
            .collect();
        slopes(&values, [End::Even; 2], &mut slope);
        assert_eq!((slope[0], slope[8]), (0.0, 0.0));
        assert!((slope[4] + expected).abs() < 2e-4);
    }
}
