//! The film at the place where the solver tries it, with all buffers that the solver needs.

use nalgebra::Vector2;

use super::{
    active_set::ActiveSet,
    balance::{Balance, EndFlow},
    geometry::Geometry,
    linear::{Linear, LinearisedFilm},
    liquid::Liquid,
    stage::FilmStage,
    state::{Field, State},
};
use crate::reynolds::{
    error::FilmError,
    lanes::dot,
    settings::{Drive, FilmSettings},
};

/// A film counts as still if less than this share of its content flows through it in a step. Its mass balance is then judged
/// by this flow, which is well above the rounding of the content.
const STILL: f64 = 1e-5;

/// State, gap, oil, balances and their linearisation. What is not state follows from it or is overwritten before use.
#[derive(Clone, Debug)]
pub struct Workspace {
    pub geometry: Geometry,
    pub state: State,
    /// The oil's properties at the last balance.
    pub liquid: Liquid,
    pub balance: Balance,
    pub linear: Linear,
    pub active_set: ActiveSet,
}

/// The load of a pressure field, and the sum of the absolute contributions to it.
#[derive(Clone, Copy, Debug)]
pub struct PressureLoad {
    pub force: Vector2<f64>,
    pub size: f64,
}

impl Workspace {
    /// A flooded film with the journal in the middle.
    pub fn new(settings: FilmSettings) -> Result<Self, FilmError> {
        let geometry = Geometry::new(settings)?;
        let cells = &geometry.cells;
        let count = cells.count();
        let mut work = Self {
            state: State::flooded(cells),
            liquid: Liquid::new(count),
            balance: Balance::new(count),
            linear: Linear::new(cells),
            active_set: ActiveSet::new(count),
            geometry,
        };
        work.place(Vector2::zeros())?;
        Ok(work)
    }

    /// Puts the journal at an eccentricity ratio and floods the film.
    pub fn place(&mut self, eps: Vector2<f64>) -> Result<(), FilmError> {
        let angles = self.state.angles;
        self.geometry.shape(angles);
        self.geometry.move_to(eps);
        let open = eps.x.is_finite() && eps.y.is_finite() && self.geometry.is_open();
        if !open {
            return Err(FilmError::NoGap(eps.norm()));
        }
        self.state = State { eps, angles, ..State::flooded(&self.geometry.cells) };
        self.arrive();
        Ok(())
    }

    /// Takes over a state and computes what follows from it.
    pub fn restore(&mut self, state: &State) {
        self.state.copy_from(state);
        self.arrive();
    }

    /// Gives the bearing another radial clearance, m. Eccentricity ratio and content stay as they are.
    pub fn set_clearance(&mut self, clearance: f64) -> Result<(), FilmError> {
        let before = self.geometry.settings.clearance;
        self.geometry.set_clearance(clearance);
        self.arrive();
        if self.geometry.is_open() {
            return Ok(());
        }
        let error = FilmError::NoGap(self.state.eps.norm());
        self.geometry.set_clearance(before);
        self.arrive();
        Err(error)
    }

    /// Computes what follows from the state alone.
    fn arrive(&mut self) {
        self.linear.discard();
        self.geometry.shape(self.state.angles);
        self.geometry.move_to(self.state.eps);
        let (field, unit) = (&self.state.field, self.state.unit);
        self.liquid.compress(&self.geometry.settings, field, unit);
        self.balance.weigh(&self.geometry.gap, &self.liquid, field);
    }

    /// Turns the surfaces for `duration` seconds.
    pub fn turn(&mut self, duration: f64, drive: &Drive) {
        self.state.angles[0] += drive.journal_speed * duration;
        self.state.angles[1] += drive.bush_speed * duration;
        self.geometry.shape(self.state.angles);
    }

    /// The point on the way to `guess` that leaves at least half of the gap at the step's start.
    pub fn reachable(&mut self, guess: Vector2<f64>) -> Vector2<f64> {
        let from = self.state.eps;
        let plain = self.geometry.form.is_plain();
        if plain && (guess - from).norm() <= 0.5 * (1.0 - from.norm()) {
            return guess;
        }
        self.geometry.move_to(from);
        from + (guess - from) * self.geometry.allowed(from, guess - from, 0.5)
    }

    /// Guesses the pressures after a further `ahead` of the stage that led here from the field `start`.
    pub fn extrapolate(&mut self, ahead: f64, start: &Field) {
        let field = &mut self.state.field;
        let pressures = field.pressure.iter_mut().zip(&start.pressure);
        for ((pressure, start), &full) in pressures.zip(&field.full) {
            *pressure += if full { ahead * (*pressure - start) } else { 0.0 };
        }
    }

    /// Moves cells into and out of the set by their unknowns; the number that moved.
    pub fn exchange(&mut self, stage: &FilmStage) -> usize {
        let field = &mut self.state.field;
        self.active_set.exchange(&self.geometry.cells, field, stage)
    }

    /// Fills empty cells by their balances where mass is not conserved; the number that moved.
    pub fn refill(&mut self, stage: &FilmStage) -> usize {
        let field = &mut self.state.field;
        self.active_set.refill(&self.geometry.cells, field, &self.balance, stage)
    }

    /// Computes oil and balances at the present gap and field. True when the oil's properties have converged.
    pub fn update_balance(&mut self, stage: &FilmStage, drive: &Drive) -> bool {
        let (field, geometry) = (&self.state.field, &self.geometry);
        let (cells, gap) = (&geometry.cells, &geometry.gap);
        let warm = (&self.state.warm[..], cells.stride);
        let steady = (self.liquid).update(&geometry.settings, gap, field, warm, drive);
        self.balance.update(cells, gap, &self.liquid, field, stage);
        steady
    }

    /// Linearises at the present place and answers to the residuals.
    pub fn linearise(&mut self, stage: &FilmStage) {
        self.geometry.gap.differentiate(&self.geometry.form);
        self.linear.renew(&LinearisedFilm {
            cells: &self.geometry.cells,
            gap: &self.geometry.gap,
            liquid: &self.liquid,
            field: &self.state.field,
            balance: &self.balance,
            stage,
        });
        if self.geometry.gap.rough {
            // An effect on the load that the cells' pressures do not show.
            self.linear.slope -= self.geometry.lost_area(&self.state.field);
        }
    }

    /// The load of the present pressures.
    pub fn pressure_load(&self) -> PressureLoad {
        let (gap, pressure) = (&self.geometry.gap, &self.state.field.pressure);
        let mut sum = PressureLoad { force: Vector2::zeros(), size: 0.0 };
        for (i, range) in self.geometry.cells.columns() {
            let pressed = &gap.pressed[range.clone()];
            let share = dot(pressed, &pressure[range]);
            sum.force += self.geometry.cells.directions.mean[i] * share;
            sum.size += share.abs();
        }
        sum
    }

    /// The flow through the film by which a stage's residuals are judged.
    pub fn flow(&self, stage: &FilmStage) -> f64 {
        self.through(&self.balance.end_flow(), stage.rotation, stage.duration)
    }

    /// The flow through the ends with the one that the mean rotation carries around, averaged over the columns; at least the flow
    /// below which a film counts as still in a stage or step of this duration.
    pub fn through(&self, ends: &EndFlow, rotation: f64, duration: f64) -> f64 {
        let held = self.balance.held(&self.geometry.cells);
        let circulating = rotation.abs() * held / std::f64::consts::TAU;
        (ends.through() + circulating).max(STILL * held / duration)
    }

    /// The sum of the absolute contributions to the residuals.
    pub fn turnover(&self, stage: &FilmStage) -> f64 {
        let stored = self.balance.held(&self.geometry.cells) / stage.duration;
        stored + self.linear.turnover(&self.state.field)
    }
}
