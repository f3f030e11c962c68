//! The film's balances linearised: how the cells answer to their residuals and to the journal.

use nalgebra::{Matrix2, Vector2};

use super::balance::{Balance, Stage};
use super::cells::Cells;
use super::field::Field;
use super::gap::Gap;
use super::lanes::{dot, dot3};
use super::liquid::Liquid;
use super::ring::Ring;

/// A linearisation of the balances over the cells' unknowns and the eccentricity ratio, factorised. It serves until it
/// is too far from where the film is.
#[derive(Clone, Debug)]
pub(super) struct Linear {
    pub(super) ring: Ring,
    /// One for cells whose unknown is the pressure, zero for the others.
    pub(super) full: Vec<f64>,
    /// One for cells whose unknown is the content.
    pub(super) empty: Vec<f64>,
    /// How the oil in a full gap grows with the cell's unknown: by the density or its slope.
    pub(super) swell: Vec<f64>,
    /// One for cells whose balance is to be met.
    pub(super) balanced: Vec<f64>,
    /// The unknowns' answer to the present residuals.
    pub(super) step: Vec<f64>,
    /// Their answers to the eccentricity ratio along x and y.
    pub(super) answer: [Vec<f64>; 2],
    /// What one more unit of gap lets through: at the edge before each cell, and at that below it.
    pub(super) around: Vec<f64>,
    pub(super) over: Vec<f64>,
    /// The derivative of the load over the eccentricity ratio.
    pub(super) slope: Matrix2<f64>,
    /// The stages' duration that it is made for; none: it is of no use.
    duration: Option<f64>,
}

impl Linear {
    pub(super) fn new(cells: &Cells) -> Self {
        let zeros = || vec![0.0; cells.count()];
        Self {
            ring: Ring::new(cells.grid.columns(), cells.stride),
            full: zeros(),
            empty: zeros(),
            swell: zeros(),
            balanced: zeros(),
            step: zeros(),
            answer: [zeros(), zeros()],
            around: zeros(),
            over: vec![0.0; cells.count() + 1],
            slope: Matrix2::zeros(),
            duration: None,
        }
    }

    /// Whether it may serve in a stage of a duration.
    pub(super) fn serves(&self, duration: f64) -> bool {
        self.duration == Some(duration)
    }

    /// Makes sure that it serves no more.
    pub(super) fn discard(&mut self) {
        self.duration = None;
    }

    /// Linearises at the present balance, and answers to it.
    pub(super) fn renew(
        &mut self,
        cells: &Cells,
        gap: &Gap,
        liquid: &Liquid,
        field: &Field,
        balance: &Balance,
        stage: &Stage<'_>,
    ) {
        self.sort(cells, liquid, field);
        self.assemble(cells, gap, balance, stage);
        if liquid.compressible {
            self.centre(cells, liquid, field, balance);
        }
        if liquid.thickens {
            self.thicken(cells, liquid, field, balance, stage);
        }
        let cut = self.cut(cells);
        self.ring.factorise(cut);
        self.slide(cells, gap, field, balance, stage);
        self.load_residuals(balance);
        let [x, y] = &mut self.answer;
        self.ring.solve([&mut self.step, x, y]);
        let [x, y] = &self.answer;
        let [x, y] = [x, y].map(|answer| self.load_of(cells, gap, answer));
        self.duration = Some(stage.duration);
        self.slope = Matrix2::from_columns(&[-x, -y]);
    }

    /// Answers to the present balance with the linearisation of another.
    pub(super) fn reuse(&mut self, balance: &Balance) {
        self.load_residuals(balance);
        self.ring.solve([&mut self.step]);
    }

    /// What the answer to the residuals takes from the load.
    pub(super) fn load_of_step(&self, cells: &Cells, gap: &Gap) -> Vector2<f64> {
        self.load_of(cells, gap, &self.step)
    }

    /// The load of an answer's pressures.
    fn load_of(&self, cells: &Cells, gap: &Gap, answer: &[f64]) -> Vector2<f64> {
        let mut sum = Vector2::zeros();
        for (i, range) in cells.columns() {
            let pressed = &gap.pressed[range.clone()];
            let share = dot3(pressed, &self.full[range.clone()], &answer[range]);
            sum += cells.directions.mean[i] * share;
        }
        sum
    }

    /// Moves the unknowns by the answers to the residuals and to a change of the eccentricity ratio.
    pub(super) fn apply(&self, change: Vector2<f64>, field: &mut Field) {
        let n = self.step.len();
        let (step, x, y) = (&self.step[..n], &self.answer[0][..n], &self.answer[1][..n]);
        let (full, empty) = (&self.full[..n], &self.empty[..n]);
        let (pressure, content) = (&mut field.pressure[..n], &mut field.content[..n]);
        for c in 0..n {
            let move_by = step[c] + x[c] * change.x + y[c] * change.y;
            pressure[c] -= full[c] * move_by;
            content[c] -= empty[c] * move_by;
        }
    }

    /// Moves the unknowns by a share of the answer to the residuals.
    pub(super) fn approach(&self, share: f64, field: &mut Field) {
        for (c, step) in self.step.iter().enumerate() {
            field.pressure[c] -= share * self.full[c] * step;
            field.content[c] -= share * self.empty[c] * step;
        }
    }

    /// The size of the residuals that are to vanish.
    pub(super) fn imbalance(&self, balance: &Balance) -> f64 {
        balance.imbalance(&self.balanced)
    }

    /// The size of what the pressures drive out of each cell, in all.
    pub(super) fn turnover(&self, field: &Field) -> f64 {
        let own = self.ring.own.iter().zip(&self.full);
        own.zip(&field.pressure)
            .map(|((own, full), p)| own * full * p.abs())
            .sum()
    }

    fn load_residuals(&mut self, balance: &Balance) {
        for ((step, residual), balanced) in self
            .step
            .iter_mut()
            .zip(&balance.residual)
            .zip(&self.balanced)
        {
            *step = residual * balanced;
        }
    }

    /// Sorts the cells by their unknowns.
    fn sort(&mut self, cells: &Cells, liquid: &Liquid, field: &Field) {
        let conserving = cells.conserves_mass();
        for (c, &full) in field.full.iter().enumerate() {
            let real = cells.area[c] > 0.0;
            self.full[c] = f64::from(full);
            self.empty[c] = f64::from(!full && conserving && real);
            self.balanced[c] = self.full[c] + self.empty[c];
        }
        self.swell(liquid);
        for (i, range) in cells.columns() {
            self.ring.active[i] = conserving || field.full[range].contains(&true);
        }
    }

    fn swell(&mut self, liquid: &Liquid) {
        let n = self.full.len();
        let (full, empty, swell) = (&self.full[..n], &self.empty[..n], &mut self.swell[..n]);
        let (density, swelling) = (&liquid.density[..n], &liquid.swelling[..n]);
        for c in 0..n {
            swell[c] = full[c] * swelling[c] + empty[c] * density[c];
        }
    }

    /// The column to set aside: an idle one, or the one with the fewest full cells.
    fn cut(&self, cells: &Cells) -> usize {
        let count = |range: std::ops::Range<usize>| self.full[range].iter().sum::<f64>();
        cells
            .columns()
            .map(|(i, range)| (count(range), i))
            .fold((f64::INFINITY, 0), |least, column| {
                if column.0 < least.0 { column } else { least }
            })
            .1
    }
}

/// A load with the sum of the sizes of what adds up to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    pub(super) force: Vector2<f64>,
    pub(super) size: f64,
}

/// The load that pressures carry.
pub(super) fn load(cells: &Cells, gap: &Gap, pressure: &[f64]) -> Carried {
    let mut sum = Carried {
        force: Vector2::zeros(),
        size: 0.0,
    };
    for (i, range) in cells.columns() {
        let pressed = &gap.pressed[range.clone()];
        let share = dot(pressed, &pressure[range]);
        sum.force += cells.directions.mean[i] * share;
        sum.size += share.abs();
    }
    sum
}
