//! The film's balances, linearised: how the cells answer to their residuals and to the journal.

mod assembly;
mod centring;
mod closing;
mod thickening;
mod unknowns;

use nalgebra::{Matrix2, Vector2};

use super::{balance::Balance, cells::Cells, gap::Gap, liquid::Liquid, stage::FilmStage, state::Field};
use crate::reynolds::{lanes::sum_of, ring::Ring};
use closing::Closing;
use unknowns::Unknowns;

/// The film about which the balances are linearised: gap, oil, field and balances at one place of the journal, in one stage.
#[derive(Clone, Copy)]
pub struct LinearisedFilm<'a> {
    pub cells: &'a Cells,
    pub gap: &'a Gap,
    pub liquid: &'a Liquid,
    pub field: &'a Field,
    pub balance: &'a Balance,
    pub stage: &'a FilmStage<'a>,
}

/// A factorised linearisation of the balances over the cells' unknowns and the eccentricity ratio.
///
/// It stays in use until the film has moved too far from where it was made (the chord method).
#[derive(Clone, Debug)]
pub struct Linear {
    ring: Ring,
    unknowns: Unknowns,
    closing: Closing,
    /// The unknowns' answer to the present residuals: the Newton correction with the journal held.
    correction: Vec<f64>,
    /// The unknowns' answers to the eccentricity ratio along x and y.
    answer: [Vec<f64>; 2],
    /// Derivative of the load over the eccentricity ratio.
    pub slope: Matrix2<f64>,
    /// Duration of the stages for which it was made; `None` when it must not be used.
    duration: Option<f64>,
}

impl Linear {
    /// Buffers without a usable linearisation.
    pub fn new(cells: &Cells) -> Self {
        let zeros = || vec![0.0; cells.count()];
        Self {
            ring: Ring::new(cells.grid.columns(), cells.stride),
            unknowns: Unknowns::new(cells.count()),
            closing: Closing::new(cells.count()),
            correction: zeros(),
            answer: [zeros(), zeros()],
            slope: Matrix2::zeros(),
            duration: None,
        }
    }

    /// Whether it can be used in a stage of this duration.
    pub fn serves(&self, duration: f64) -> bool {
        self.duration == Some(duration)
    }

    /// Puts it out of use.
    pub fn discard(&mut self) {
        self.duration = None;
    }

    /// Linearises about `base` and answers to its residuals.
    pub fn renew(&mut self, base: &LinearisedFilm) {
        self.sort(base);
        let (ring, unknowns) = (&mut self.ring, &self.unknowns);
        assembly::assemble(ring, unknowns, self.closing.scratch(), base);
        if base.liquid.compressible {
            centring::centre(ring, unknowns, base);
        }
        if base.liquid.thickens {
            thickening::thicken(ring, unknowns, base);
        }
        ring.factorise(unknowns.emptiest_column(base.cells));
        self.closing.differentiate(base, &unknowns.balanced, &mut self.answer);
        self.take_residuals(base.balance);
        let [x, y] = &mut self.answer;
        self.ring.solve([&mut self.correction, x, y]);
        let [x, y] = &self.answer;
        let [x, y] = [x, y].map(|answer| self.load_of(base.cells, base.gap, answer));
        self.duration = Some(base.stage.duration);
        self.slope = Matrix2::from_columns(&[-x, -y]);
    }

    /// Answers to the residuals of `balance` with the linearisation at hand.
    pub fn reuse(&mut self, balance: &Balance) {
        self.take_residuals(balance);
        self.ring.solve([&mut self.correction]);
    }

    /// The load that the correction takes from the film.
    pub fn load_of_correction(&self, cells: &Cells, gap: &Gap) -> Vector2<f64> {
        self.load_of(cells, gap, &self.correction)
    }

    /// The load of the pressures in an answer.
    fn load_of(&self, cells: &Cells, gap: &Gap, answer: &[f64]) -> Vector2<f64> {
        let full = &self.unknowns.full;
        let mut sum = Vector2::zeros();
        for (i, range) in cells.columns() {
            let pressed = &gap.pressed[range.clone()];
            let of = [pressed, &full[range.clone()], &answer[range]];
            let share = sum_of(of, |[pressed, full, answer]| pressed * full * answer);
            sum += cells.directions.mean[i] * share;
        }
        sum
    }

    /// Moves the unknowns by a share of the correction and by the answers to a change of the eccentricity ratio.
    pub fn apply(&self, share: f64, change: Vector2<f64>, field: &mut Field) {
        let n = self.correction.len();
        let correction = &self.correction[..n];
        let (x, y) = (&self.answer[0][..n], &self.answer[1][..n]);
        let (full, empty) = (&self.unknowns.full[..n], &self.unknowns.empty[..n]);
        let (pressure, content) = (&mut field.pressure[..n], &mut field.content[..n]);
        for c in 0..n {
            let move_by = share * correction[c] + x[c] * change.x + y[c] * change.y;
            pressure[c] -= full[c] * move_by;
            content[c] -= empty[c] * move_by;
        }
    }

    /// The sum of the absolute residuals that have to vanish.
    pub fn imbalance(&self, balance: &Balance) -> f64 {
        balance.imbalance(&self.unknowns.balanced)
    }

    /// The sum of the absolute flows that the pressures drive out of the cells.
    pub fn turnover(&self, field: &Field) -> f64 {
        let diagonal = self.ring.diagonal.iter().zip(&self.unknowns.full);
        diagonal.zip(&field.pressure).map(|((leak, full), p)| leak * full * p.abs()).sum()
    }

    fn take_residuals(&mut self, balance: &Balance) {
        for ((correction, residual), balanced) in
            self.correction.iter_mut().zip(&balance.residual).zip(&self.unknowns.balanced)
        {
            *correction = residual * balanced;
        }
    }

    /// Sorts the cells by their unknowns; columns without any are left out of the factorisation.
    fn sort(&mut self, base: &LinearisedFilm) {
        let (cells, field) = (base.cells, base.field);
        self.unknowns.sort(cells, base.liquid, field);
        let conserving = cells.conserves_mass();
        for (i, range) in cells.columns() {
            self.ring.active[i] = conserving || field.full[range].contains(&true);
        }
    }
}
