//! Tests of the ring's factorisation against dense matrices.

use super::Ring;
use nalgebra::{DMatrix, DVector};

/// A ring with all couplings, diagonally dominant by columns, and the same matrix dense.
fn example(columns: usize, rows: usize, idle: &[usize]) -> (Ring, DMatrix<f64>) {
    let mut ring = Ring::new(columns, rows);
    let n = columns * rows;
    let mut dense = DMatrix::identity(n, n);
    let value = |a: usize, b: usize| -0.2 - 0.5 * ((a * 7 + b * 3) as f64).sin().powi(2);
    for column in 0..columns {
        if idle.contains(&column) {
            continue;
        }
        ring.active[column] = true;
        let (before, after) = ((column + columns - 1) % columns, (column + 1) % columns);
        for j in 0..rows {
            let cell = column * rows + j;
            ring.diagonal[cell] = 4.0 + 0.1 * j as f64;
            dense[(cell, cell)] = ring.diagonal[cell];
            if !idle.contains(&before) {
                ring.before[cell] = value(cell, 1);
                dense[(cell, before * rows + j)] = value(cell, 1);
            }
            if !idle.contains(&after) {
                ring.after[cell] = value(cell, 2);
                dense[(cell, after * rows + j)] = value(cell, 2);
            }
            if j > 0 {
                ring.below[cell] = value(cell, 3);
                dense[(cell, cell - 1)] = value(cell, 3);
            }
            if j + 1 < rows {
                ring.above[cell] = value(cell, 4);
                dense[(cell, cell + 1)] = value(cell, 4);
            }
        }
    }
    (ring, dense)
}

#[test]
fn agrees_with_a_dense_solution() {
    for (columns, rows, idle, cut) in
        [(5, 8, &[][..], 2), (40, 8, &[], 7), (6, 16, &[], 0), (9, 24, &[3, 4], 5), (12, 8, &[0, 11, 5], 0)]
    {
        let (mut ring, dense) = example(columns, rows, idle);
        ring.factorise(cut);
        let idle_cell = |k: usize| idle.contains(&(k / rows));
        let b = DVector::from_fn(columns * rows, |k, _| if idle_cell(k) { 0.0 } else { (k as f64).sin() });
        let mut x = b.clone();
        let mut twice = &b * 2.0;
        ring.solve([x.as_mut_slice(), twice.as_mut_slice()]);
        let expected = dense.lu().solve(&b).unwrap();
        assert!((&x - &expected).amax() < 1e-12, "{columns} x {rows}");
        assert!((twice * 0.5 - &expected).amax() < 1e-12);
    }
}
