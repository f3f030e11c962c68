//! Factorisation of the film's matrix: a ring of columns, each coupled to its two neighbours row by row.
//!
//! The matrix is tridiagonal within a column and diagonal between columns. One column, the cut, is set aside. The others
//! form a chain that is eliminated block by block, with each pivot block inverted (block LU without pivoting, stable for
//! the diagonally dominant matrices of a film: Demmel, Higham & Schreiber 1995, Numer. Linear Algebra Appl. 2). The cut
//! follows by its Schur complement, through the chain's answers to it, the "spikes".
//!
//! All sums run down whole columns of a multiple of [`LANES`] rows, which the compiler keeps in vector registers. The order
//! of summation is the same on every machine.

mod block;
#[cfg(test)]
mod tests;

use super::lanes::LANES;
use block::{Size, apply, invert, two_blocks};

/// A spike is followed until it has fallen to this share of its largest entry. The factorisation is inexact by this much,
/// which an iteration with exact residuals tolerates.
const FADED: f64 = 1e-13;

/// The matrix and its factorisation. The buffers are kept between uses.
#[derive(Clone, Debug)]
pub struct Ring {
    columns: usize,
    rows: usize,
    /// The matrix, row by row of the cells: the diagonal entry.
    pub diagonal: Vec<f64>,
    /// The entry of the cell in the row below.
    pub below: Vec<f64>,
    /// The entry of the cell in the row above.
    pub above: Vec<f64>,
    /// The entry of the cell in the column before.
    pub before: Vec<f64>,
    /// The entry of the cell in the column after.
    pub after: Vec<f64>,
    /// Whether a column takes part; the others count as identity.
    pub active: Vec<bool>,
    /// The column set aside.
    cut: usize,
    /// The inverted pivot blocks; the cut's is the inverse of its Schur complement.
    inverse: Vec<f64>,
    /// The chain's answers to unit values of the cut's cells: a block per column, with a column for each cell of the cut.
    spike: Vec<f64>,
    /// Whether a column's spike is above [`FADED`].
    spiked: Vec<bool>,
    scratch: Vec<f64>,
}

impl Ring {
    /// A ring with this number of columns and of rows, a multiple of [`LANES`].
    pub fn new(columns: usize, rows: usize) -> Self {
        debug_assert!(rows.is_multiple_of(LANES) && columns > 2);
        let cells = columns * rows;
        Self {
            columns,
            rows,
            diagonal: vec![1.0; cells],
            below: vec![0.0; cells],
            above: vec![0.0; cells],
            before: vec![0.0; cells],
            after: vec![0.0; cells],
            active: vec![false; columns],
            cut: 0,
            inverse: vec![0.0; cells * rows],
            spike: vec![0.0; cells * rows],
            spiked: vec![false; columns],
            scratch: vec![0.0; 3 * rows],
        }
    }

    /// Factorises the matrix, with `cut` as the column set aside.
    pub fn factorise(&mut self, cut: usize) {
        self.cut = cut;
        match self.rows {
            8 => self.eliminate(8),
            16 => self.eliminate(16),
            rows => self.eliminate(rows),
        }
    }

    /// Solves for several right-hand sides, in place. Needs [`factorise`](Self::factorise).
    pub fn solve<const N: usize>(&mut self, x: [&mut [f64]; N]) {
        match self.rows {
            8 => self.substitute(8, x),
            16 => self.substitute(16, x),
            rows => self.substitute(rows, x),
        }
    }

    /// Eliminates the chain, then the cut.
    #[inline(always)]
    fn eliminate(&mut self, rows: usize) {
        let (columns, cut) = (self.columns, self.cut);
        for place in 1..columns {
            let column = (cut + place) % columns;
            if !self.active[column] {
                continue;
            }
            self.load_block(rows, column);
            let previous = (column + columns - 1) % columns;
            if previous != cut && self.active[previous] {
                let [block, other] = two_blocks(&mut self.inverse, rows, column, previous);
                let before = &self.before[column * rows..][..rows];
                let after = &self.after[previous * rows..][..rows];
                for (q, &after) in after.iter().enumerate() {
                    let (block, other) = (&mut block[q * rows..][..rows], &other[q * rows..][..rows]);
                    for j in 0..rows {
                        block[j] -= before[j] * other[j] * after;
                    }
                }
            }
            let block = &mut self.inverse[column * rows * rows..][..rows * rows];
            invert(rows, block, &mut self.scratch);
        }
        self.spiked.fill(false);
        if self.active[cut] {
            self.grow_spikes(rows);
            self.close(rows);
        }
    }

    /// Loads a column's tridiagonal block.
    #[inline(always)]
    fn load_block(&mut self, rows: usize, column: usize) {
        let at = column * rows;
        let entries = [&self.diagonal, &self.below, &self.above];
        let [diagonal, below, above] = entries.map(|of| &of[at..][..rows]);
        let block = &mut self.inverse[at * rows..][..rows * rows];
        for (k, line) in block.chunks_exact_mut(rows).enumerate() {
            line.fill(0.0);
            line[k] = diagonal[k];
            if k > 0 {
                line[k - 1] = above[k - 1];
            }
            if k + 1 < rows {
                line[k + 1] = below[k + 1];
            }
        }
    }

    /// Solves the chain for the cut's couplings to its two ends.
    #[inline(always)]
    fn grow_spikes(&mut self, rows: usize) {
        let (columns, cut) = (self.columns, self.cut);
        let (first, last) = ((cut + 1) % columns, (cut + columns - 1) % columns);
        let block = rows * rows;
        let mut largest: f64 = 0.0;
        for place in 1..columns {
            let column = (cut + place) % columns;
            let previous = (column + columns - 1) % columns;
            let follows = place > 1 && self.spiked[previous] && self.active[column];
            let ends = (column == first || column == last) && self.active[column];
            if !follows && !ends {
                continue;
            }
            let [spike, other] = two_blocks(&mut self.spike, rows, column, previous);
            let inverse = &self.inverse[column * block..][..block];
            let before = &self.before[column * rows..][..rows];
            let after = &self.after[column * rows..][..rows];
            let mut size = Size::default();
            for k in 0..rows {
                let source = &mut self.scratch[..rows];
                source.fill(0.0);
                if follows {
                    let other = &other[k * rows..][..rows];
                    for j in 0..rows {
                        source[j] = -before[j] * other[j];
                    }
                }
                if column == first {
                    source[k] += before[k];
                }
                if column == last {
                    source[k] += after[k];
                }
                let answer = &mut spike[k * rows..][..rows];
                apply(rows, inverse, source, answer);
                size.see(answer);
            }
            let size = size.largest();
            largest = largest.max(size);
            self.spiked[column] = size > FADED * largest;
        }
        for place in (1..columns - 1).rev() {
            let column = (cut + place) % columns;
            let next = (column + 1) % columns;
            if !(self.spiked[next] && self.active[column]) {
                continue;
            }
            let [spike, other] = two_blocks(&mut self.spike, rows, column, next);
            let inverse = &self.inverse[column * block..][..block];
            let after = &self.after[column * rows..][..rows];
            if !self.spiked[column] {
                spike.fill(0.0);
            }
            let mut size = Size::default();
            for k in 0..rows {
                let (source, answer) = self.scratch[..2 * rows].split_at_mut(rows);
                let other = &other[k * rows..][..rows];
                for j in 0..rows {
                    source[j] = after[j] * other[j];
                }
                apply(rows, inverse, source, answer);
                let spike = &mut spike[k * rows..][..rows];
                for j in 0..rows {
                    spike[j] -= answer[j];
                }
                size.see(spike);
            }
            self.spiked[column] = size.largest() > FADED * largest;
        }
    }

    /// Inverts the Schur complement of the cut.
    #[inline(always)]
    fn close(&mut self, rows: usize) {
        let (columns, cut) = (self.columns, self.cut);
        self.load_block(rows, cut);
        let block = rows * rows;
        let matrix = &mut self.inverse[cut * block..][..block];
        let neighbours = [((cut + columns - 1) % columns, &self.before), ((cut + 1) % columns, &self.after)];
        for (neighbour, coupling) in neighbours {
            if !self.spiked[neighbour] {
                continue;
            }
            let coupling = &coupling[cut * rows..][..rows];
            let spike = &self.spike[neighbour * block..][..block];
            for k in 0..rows {
                for j in 0..rows {
                    matrix[k * rows + j] -= coupling[j] * spike[k * rows + j];
                }
            }
        }
        invert(rows, matrix, &mut self.scratch);
    }

    /// Forward and backward substitution along the chain, then the cut.
    #[inline(always)]
    fn substitute<const N: usize>(&mut self, rows: usize, mut x: [&mut [f64]; N]) {
        let (columns, cut, block) = (self.columns, self.cut, rows * rows);
        for place in 1..columns {
            let column = (cut + place) % columns;
            if !self.active[column] {
                continue;
            }
            let previous = (column + columns - 1) % columns;
            let inverse = &self.inverse[column * block..][..block];
            let before = &self.before[column * rows..][..rows];
            let follows = previous != cut && self.active[previous];
            for x in &mut x {
                let source = &mut self.scratch[..rows];
                let values = &x[column * rows..][..rows];
                if follows {
                    let other = &x[previous * rows..][..rows];
                    for j in 0..rows {
                        source[j] = values[j] - before[j] * other[j];
                    }
                } else {
                    source.copy_from_slice(values);
                }
                apply(rows, inverse, source, &mut x[column * rows..][..rows]);
            }
        }
        for place in (1..columns - 1).rev() {
            let column = (cut + place) % columns;
            let next = (column + 1) % columns;
            if !(self.active[column] && self.active[next]) {
                continue;
            }
            let inverse = &self.inverse[column * block..][..block];
            let after = &self.after[column * rows..][..rows];
            for x in &mut x {
                let (source, answer) = self.scratch[..2 * rows].split_at_mut(rows);
                let other = &x[next * rows..][..rows];
                for j in 0..rows {
                    source[j] = after[j] * other[j];
                }
                apply(rows, inverse, source, answer);
                let values = &mut x[column * rows..][..rows];
                for j in 0..rows {
                    values[j] -= answer[j];
                }
            }
        }
        if self.active[cut] {
            for x in &mut x {
                self.join(rows, x);
            }
        }
    }

    /// Completes the chain's solution by the cut.
    #[inline(always)]
    fn join(&mut self, rows: usize, x: &mut [f64]) {
        let (columns, cut, block) = (self.columns, self.cut, rows * rows);
        let (source, answer) = self.scratch[..2 * rows].split_at_mut(rows);
        source.copy_from_slice(&x[cut * rows..][..rows]);
        let neighbours = [((cut + columns - 1) % columns, &self.before), ((cut + 1) % columns, &self.after)];
        for (neighbour, coupling) in neighbours {
            let coupling = &coupling[cut * rows..][..rows];
            let other = &x[neighbour * rows..][..rows];
            for j in 0..rows {
                source[j] -= coupling[j] * other[j];
            }
        }
        apply(rows, &self.inverse[cut * block..][..block], source, answer);
        x[cut * rows..][..rows].copy_from_slice(answer);
        for column in 0..columns {
            if !self.spiked[column] {
                continue;
            }
            let spike = &self.spike[column * block..][..block];
            apply(rows, spike, answer, source);
            let values = &mut x[column * rows..][..rows];
            for j in 0..rows {
                values[j] -= source[j];
            }
        }
    }
}
