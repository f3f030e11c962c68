//! Which cells are full: the active set of the complementarity of pressure and content.

use nalgebra::Vector2;

use super::balance::{Balance, Stage};
use super::cells::Cells;
use super::field::Field;
use super::lanes::largest;

/// Moves cells into and out of the set of full ones, and counts how often each has moved.
#[derive(Clone, Debug)]
pub(super) struct ActiveSet {
    moves: Vec<u8>,
    /// Whether a cell should have changed sides last, and was not let.
    held: bool,
}

/// A share of the clearance that is lost in rounding: less inflow or suction than makes this much in a stage
/// does not move a cell into or out of the set.
const ROUNDING: f64 = 1e-13;

/// What a cell on the brink of rupture may miss, as a share of the largest pressure or of the gap.
const BRINK: f64 = 1e-6;

/// A cell changes sides at most this often in a stage.
const MOVES: u8 = 6;

impl ActiveSet {
    pub(super) fn new(cells: usize) -> Self {
        Self {
            moves: vec![0; cells],
            held: false,
        }
    }

    /// Begins a stage: every cell may move again.
    pub(super) fn begin(&mut self) {
        self.moves.fill(0);
    }

    /// Moves cells by what they hold, after their unknowns have changed; the number of cells that moved.
    pub(super) fn settle(&mut self, cells: &Cells, field: &mut Field, stage: &Stage<'_>) -> usize {
        self.held = false;
        let conserving = cells.conserves_mass();
        let tension = if conserving {
            -ROUNDING / stage.duration
        } else {
            // An empty cell has no pressure either: it does not count as moved.
            -f64::MIN_POSITIVE
        };
        let over = 1.0 + ROUNDING;
        // Whether any moves at all, without branches.
        let n = field.full.len();
        let (pressure, content) = (&field.pressure[..n], &field.content[..n]);
        let outside: u64 = (0..n)
            .map(|c| u64::from(pressure[c] < tension) + u64::from(content[c] > over))
            .sum();
        if outside == 0 {
            return 0;
        }
        let mut moved = 0;
        for cell in 0..n {
            let full = field.full[cell];
            let crosses = if full {
                field.pressure[cell] < tension
            } else {
                field.content[cell] > over
            };
            if !crosses {
                continue;
            }
            if self.may_move(cell) {
                field.full[cell] = !full;
                moved += 1;
                field.content[cell] = 1.0;
                field.pressure[cell] = 0.0;
            } else {
                self.held = true;
            }
        }
        moved
    }

    /// Whether a cell that was held back is under a tension, or over its brim, that is more than a brink's.
    pub(super) fn is_forced(&self, field: &Field) -> bool {
        if !self.held {
            return false;
        }
        let tension = -BRINK * largest(&field.pressure);
        field.pressure.iter().any(|&p| p < tension) || largest(&field.content) > 1.0 + BRINK
    }

    /// Fills the cells of a film without conserved mass into which more oil flows than the closing gap wants; the
    /// number of cells that moved.
    pub(super) fn refill(
        &mut self,
        cells: &Cells,
        field: &mut Field,
        balance: &Balance,
        stage: &Stage<'_>,
    ) -> usize {
        if cells.conserves_mass() {
            return 0;
        }
        let least = -ROUNDING / stage.duration;
        let n = field.full.len();
        let (full, residual, area) = (
            &mut field.full[..n],
            &balance.residual[..n],
            &cells.area[..n],
        );
        let mut moved = 0;
        for cell in 0..n {
            if residual[cell] < least * area[cell] && !full[cell] && self.may_move(cell) {
                full[cell] = true;
                moved += 1;
            }
        }
        moved
    }

    /// Where a film without conserved mass is empty, lets a load find something to press on.
    pub(super) fn fill_towards(load: Vector2<f64>, cells: &Cells, field: &mut Field) {
        if cells.conserves_mass() || field.full.contains(&true) {
            return;
        }
        let rows = cells.grid.rows();
        for (i, range) in cells.columns() {
            let faces = cells.directions.mean[i].dot(&load) > 0.0;
            field.full[range][..rows].fill(faces);
        }
    }

    /// Whether a cell that should change sides may: one that keeps going to and fro, on the brink of
    /// rupture, stays where it is for the rest of the stage. Its balance is solved all the same.
    fn may_move(&mut self, cell: usize) -> bool {
        self.moves[cell] = self.moves[cell].saturating_add(1);
        self.moves[cell] <= MOVES
    }
}
