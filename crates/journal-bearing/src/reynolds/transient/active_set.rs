//! The set of full cells: the active set of the complementarity between pressure and content.

use nalgebra::Vector2;

use super::{balance::Balance, cells::Cells, stage::FilmStage, state::Field};
use crate::reynolds::lanes::largest;

/// Moves cells into and out of the set of full cells, and counts how often each has moved.
#[derive(Clone, Debug)]
pub struct ActiveSet {
    moves: Vec<u8>,
    /// Whether a cell that should have moved in the last exchange was held back.
    held: bool,
}

/// Rounding, as a share of the clearance: inflow or suction that amounts to less than this in a stage moves no cell.
const ROUNDING: f64 = 1e-13;

/// Tolerated violation of a cell that was held back on the brink of rupture, as a share of the largest pressure or of the
/// gap.
const BRINK: f64 = 1e-6;

/// Most moves of one cell in a stage.
const MOVES: u8 = 6;

impl ActiveSet {
    /// For a number of cells, none of which has moved.
    pub fn new(cells: usize) -> Self {
        Self { moves: vec![0; cells], held: false }
    }

    /// Begins a stage: every cell may move again.
    pub fn begin(&mut self) {
        self.moves.fill(0);
    }

    /// After the unknowns have changed: ruptures full cells under tension and fills cells with more oil than gap. Returns the
    /// number of cells that moved.
    pub fn exchange(&mut self, cells: &Cells, field: &mut Field, stage: &FilmStage) -> usize {
        self.held = false;
        let conserving = cells.conserves_mass();
        let tension = if conserving {
            -ROUNDING / stage.duration
        } else {
            // Zero pressure is no tension: such a cell stays.
            -f64::MIN_POSITIVE
        };
        let over = 1.0 + ROUNDING;
        // Most of the time no cell moves: a loop without branches finds out.
        let n = field.full.len();
        let (pressure, content) = (&field.pressure[..n], &field.content[..n]);
        let outside: u64 = (0..n).map(|c| u64::from(pressure[c] < tension) + u64::from(content[c] > over)).sum();
        if outside == 0 {
            return 0;
        }
        let mut moved = 0;
        for cell in 0..n {
            let full = field.full[cell];
            let crosses = if full { field.pressure[cell] < tension } else { field.content[cell] > over };
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

    /// Whether a cell that was held back is under more tension, or has more content, than a cell on the brink may.
    pub fn is_forced(&self, field: &Field) -> bool {
        if !self.held {
            return false;
        }
        let tension = -BRINK * largest(&field.pressure);
        field.pressure.iter().any(|&p| p < tension) || largest(&field.content) > 1.0 + BRINK
    }

    /// Without conserved mass: fills empty cells whose inflow exceeds the growth of their gap. Returns the number of cells
    /// that moved.
    pub fn refill(&mut self, cells: &Cells, field: &mut Field, balance: &Balance, stage: &FilmStage) -> usize {
        if cells.conserves_mass() {
            return 0;
        }
        let least = -ROUNDING / stage.duration;
        let n = field.full.len();
        let (full, residual, area) = (&mut field.full[..n], &balance.residual[..n], &cells.area[..n]);
        let mut moved = 0;
        for cell in 0..n {
            if residual[cell] < least * area[cell] && !full[cell] && self.may_move(cell) {
                full[cell] = true;
                moved += 1;
            }
        }
        moved
    }

    /// Without conserved mass: fills the loaded half of an empty film, so that a load meets resistance.
    pub fn fill_towards(load: Vector2<f64>, cells: &Cells, field: &mut Field) {
        if cells.conserves_mass() || field.full.contains(&true) {
            return;
        }
        let rows = cells.grid.rows();
        for (i, range) in cells.columns() {
            let faces = cells.directions.mean[i].dot(&load) > 0.0;
            field.full[range][..rows].fill(faces);
        }
    }

    /// Whether a cell may move once more. A cell on the brink of rupture that keeps moving to and fro stays as it is for the
    /// rest of the stage; its balance is solved all the same.
    fn may_move(&mut self, cell: usize) -> bool {
        self.moves[cell] = self.moves[cell].saturating_add(1);
        self.moves[cell] <= MOVES
    }
}
