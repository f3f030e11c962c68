//! Arithmetic of dense square blocks, which are stored by columns.

use crate::reynolds::lanes::LANES;

/// Two blocks out of an array of blocks: one to write and one to read.
#[inline]
pub fn two_blocks(all: &mut [f64], rows: usize, write: usize, read: usize) -> [&mut [f64]; 2] {
    let size = rows * rows;
    if write > read {
        let (low, high) = all.split_at_mut(write * size);
        [&mut high[..size], &mut low[read * size..][..size]]
    } else {
        let (low, high) = all.split_at_mut(read * size);
        [&mut low[write * size..][..size], &mut high[..size]]
    }
}

/// The product of a block and a column.
#[inline(always)]
pub fn apply(rows: usize, block: &[f64], x: &[f64], product: &mut [f64]) {
    for group in (0..rows).step_by(LANES) {
        let mut sum = [0.0; LANES];
        for (q, &x) in x[..rows].iter().enumerate() {
            let lanes = &block[q * rows + group..][..LANES];
            for (sum, lane) in sum.iter_mut().zip(lanes) {
                *sum += lane * x;
            }
        }
        product[group..][..LANES].copy_from_slice(&sum);
    }
}

/// The largest magnitudes seen so far, side by side.
#[derive(Default)]
pub struct Size([f64; LANES]);

impl Size {
    /// Takes the values of a column into account.
    #[inline(always)]
    pub fn see(&mut self, values: &[f64]) {
        for lanes in values.as_chunks::<LANES>().0 {
            for (most, value) in self.0.iter_mut().zip(lanes.map(f64::abs)) {
                *most = if value > *most { value } else { *most };
            }
        }
    }

    /// The largest of all.
    #[inline(always)]
    pub fn largest(&self) -> f64 {
        self.0.iter().copied().fold(0.0, f64::max)
    }
}

/// Inverts a block in place by Gauss-Jordan elimination without pivoting.
#[inline(always)]
pub fn invert(rows: usize, block: &mut [f64], scratch: &mut [f64]) {
    if rows == LANES
        && let (lines, []) = block.as_chunks_mut::<LANES>()
        && let Ok(lines) = lines.try_into()
    {
        return invert_small(lines);
    }
    let (keep, pivot) = scratch[..2 * rows].split_at_mut(rows);
    for p in 0..rows {
        // Multiplying by factors replaces single stores, which would stall the vector loads that follow.
        for (q, keep) in keep.iter_mut().enumerate() {
            *keep = if q == p { 0.0 } else { 1.0 };
        }
        let line = &block[p * rows..][..rows];
        let reciprocal = 1.0 / line[p];
        for q in 0..rows {
            pivot[q] = (line[q] * keep[q] + (1.0 - keep[q])) * reciprocal;
        }
        for r in 0..rows {
            let line = &mut block[r * rows..][..rows];
            let factor = line[p];
            for q in 0..rows {
                line[q] = line[q] * keep[q] - factor * pivot[q];
            }
        }
        block[p * rows..][..rows].copy_from_slice(pivot);
    }
}

/// Inverts a block of the usual size, with the elimination unrolled.
fn invert_small(block: &mut [[f64; LANES]; LANES]) {
    pivot_on::<0>(block);
    pivot_on::<1>(block);
    pivot_on::<2>(block);
    pivot_on::<3>(block);
    pivot_on::<4>(block);
    pivot_on::<5>(block);
    pivot_on::<6>(block);
    pivot_on::<7>(block);
}

/// Eliminates with row and column `P`.
#[inline(always)]
fn pivot_on<const P: usize>(block: &mut [[f64; LANES]; LANES]) {
    let mut pivot = block[P];
    let reciprocal = 1.0 / pivot[P];
    pivot[P] = 1.0;
    for value in &mut pivot {
        *value *= reciprocal;
    }
    for line in block.iter_mut() {
        let factor = line[P];
        let mut rest = *line;
        rest[P] = 0.0;
        for q in 0..LANES {
            rest[q] -= factor * pivot[q];
        }
        *line = rest;
    }
    block[P] = pivot;
}
