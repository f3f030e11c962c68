//! One implicit Euler stage of the film: eccentricity, pressures and contents together, by Newton's method.
//!
//! Residuals are exact in every pass. The linearisation is kept while it still leads on fast (the chord method), within
//! a pass's change of the set of full cells it is renewed.

use nalgebra::{Matrix2, Vector2};

use super::active_set::ActiveSet;
use super::balance::Stage;
use super::film::ReynoldsFilm;
use super::linear::load;
use super::settings::Drive;
use super::support::{Motion, Support};

/// Passes before a shorter step is tried.
const PASSES: usize = 60;
/// The stage is solved when the residuals of all balances are this share of the flow through the film; more, where no
/// mass needs to be conserved.
const BALANCED: f64 = 1e-11;
const BALANCED_ROUGHLY: f64 = 5e-9;
/// Residuals that do not get smaller any more are rounding, if they are less than this share of the flow, or than
/// so many units in the last place of all that adds up to them.
const ROUNDED: f64 = 1e-10;
const LAST_PLACES: f64 = 16.0;
/// The forces balance to this share of all that adds up to them,
const CARRIED: f64 = 1e-11;
/// or when what misses would move the journal by less than this share of the clearance.
const SLIGHT: f64 = 1e-13;
/// A kept linearisation may need so many more passes; else a new one is less work.
const MORE_PASSES: f64 = 3.5;
/// A film through which flows less than this share of its content in a step counts as still: its mass
/// balance is judged by this much, which is still well above the rounding of the content.
pub(super) const STILL: f64 = 1e-5;

/// The stage has no solution that the iteration finds.
#[derive(Clone, Copy, Debug)]
pub(super) struct NoSolution;

/// What a stage is to balance.
pub(super) struct Task<'a> {
    /// The eccentricity ratio at its start.
    pub(super) start: Vector2<f64>,
    /// That expected at its end.
    pub(super) guess: Vector2<f64>,
    /// The load at its end, N.
    pub(super) load: Vector2<f64>,
    pub(super) drive: &'a Drive,
    pub(super) contact: &'a dyn Fn(f64) -> f64,
}

/// How the iteration is to go on.
enum Next {
    /// The cells' balances are met.
    Rest,
    /// With the linearisation at hand.
    Reuse,
    /// With a new one.
    Renew,
}

/// How the iteration has gone.
struct Path {
    /// The share of the flow at which it ends.
    balanced: f64,
    /// Cells that moved into or out of the set of full ones in the last pass.
    moved: usize,
    /// Whether the last pass could not go all its way.
    cut_short: bool,
    /// The size of the last residuals.
    last: Option<f64>,
}

impl Path {
    /// Judges the residuals' size over the flow; `rounding` is that of what adds up to them.
    fn judge(&mut self, serves: bool, imbalance: f64, rounding: impl Fn() -> f64) -> Next {
        if !serves || self.moved > 0 || self.cut_short {
            self.last = None;
            return Next::Renew;
        }
        let last = self.last.replace(imbalance);
        let stays = last.is_some_and(|last| imbalance > 0.5 * last);
        if imbalance <= self.balanced || (stays && imbalance <= rounding().max(ROUNDED)) {
            return Next::Rest;
        }
        let contraction = last.map_or(0.0, |last| imbalance / last);
        let passes = (self.balanced / imbalance).ln() / contraction.ln();
        if contraction < 1.0 && passes < MORE_PASSES {
            Next::Reuse
        } else {
            Next::Renew
        }
    }
}

impl ReynoldsFilm {
    /// Finds the eccentricity at the end of a stage; field, gap and balance are then those of its end.
    pub(super) fn settle(
        &mut self,
        stage: &Stage<'_>,
        task: &Task<'_>,
    ) -> Result<Vector2<f64>, NoSolution> {
        let scale = self.settings.force_scale(task.drive.viscosity);
        let wanted = task.load / scale;
        if self.floats(wanted, task) {
            return Ok(self.float(stage, task));
        }
        let motion = Motion {
            start: task.start,
            duration: stage.duration,
            rotation: stage.rotation,
        };
        self.active_set.begin();
        ActiveSet::fill_towards(wanted, &self.cells, &mut self.state.field);
        let mut eps = self.reachable(task.guess);
        let mut path = Path {
            balanced: if self.cells.conserves_mass() {
                BALANCED
            } else {
                BALANCED_ROUGHLY
            },
            moved: 0,
            cut_short: false,
            last: None,
        };
        for _ in 0..PASSES {
            self.move_to(eps);
            let steady = self.update_balance(stage, task.drive);
            path.moved += self.refill(stage);
            let support = self.support(eps, &motion, scale, task.contact);
            let carried = load(&self.cells, &self.gap, &self.state.field.pressure);
            let missing = wanted - support.force - carried.force;
            let size = carried.size + wanted.norm() + support.touch.norm();
            let flow = self.flow(stage);
            let imbalance = self.linear.imbalance(&self.balance) / flow;
            let rounding = || LAST_PLACES * f64::EPSILON * self.turnover(stage) / flow;
            let carries =
                |inverse: Matrix2<f64>| steady && Self::carries(missing, size, inverse * missing);
            match path.judge(self.linear.serves(stage.duration), imbalance, rounding) {
                Next::Rest if self.inverse(&support).is_some_and(carries) => {
                    // A pull that no film has may look like a balance.
                    let forced =
                        self.cells.conserves_mass() && self.active_set.is_forced(&self.state.field);
                    return if forced { Err(NoSolution) } else { Ok(eps) };
                }
                Next::Renew => self.linearise(stage),
                Next::Rest | Next::Reuse => self.linear.reuse(&self.balance),
            }
            let missing = missing + self.linear.load_of_step(&self.cells, &self.gap);
            let change = self.inverse(&support).ok_or(NoSolution)? * missing;
            if !(change.x.is_finite() && change.y.is_finite()) {
                return Err(NoSolution);
            }
            let share = self.allowed(eps, change, 0.25);
            eps += change * share;
            self.linear.apply(change * share, &mut self.state.field);
            path.moved = self
                .active_set
                .settle(&self.cells, &mut self.state.field, stage);
            path.cut_short = share < 1.0;
        }
        Err(NoSolution)
    }

    /// Whether the forces balance; `change` is how the journal would answer to what misses.
    pub(super) fn carries(missing: Vector2<f64>, size: f64, change: Vector2<f64>) -> bool {
        missing.norm() <= CARRIED * size || change.norm() <= SLIGHT
    }

    /// Whether the cells' balances miss no more than allowed, or, if the residuals do not get smaller any more, than
    /// rounding does.
    pub(super) fn is_balanced(&self, stage: &Stage<'_>, imbalance: f64, stays: bool) -> bool {
        let flow = self.flow(stage);
        let rounding = LAST_PLACES * f64::EPSILON * self.turnover(stage);
        imbalance <= BALANCED * flow || (stays && imbalance <= rounding.max(ROUNDED * flow))
    }

    /// How the journal answers to a force.
    fn inverse(&self, support: &Support) -> Option<Matrix2<f64>> {
        (self.linear.slope + support.stiffness).try_inverse()
    }

    /// The size of all that adds up to the residuals.
    fn turnover(&self, stage: &Stage<'_>) -> f64 {
        let stored = self.balance.held(&self.cells) / stage.duration;
        stored + self.linear.turnover(&self.state.field)
    }

    /// Whether nothing presses on a film without conserved mass, so that the journal goes with the mean rotation.
    fn floats(&self, load: Vector2<f64>, task: &Task<'_>) -> bool {
        !self.cells.conserves_mass()
            && load == Vector2::zeros()
            && self.settings.asperities.is_none()
            && (task.contact)(task.start.norm()) == 0.0
    }

    /// A stage without load or pressure.
    fn float(&mut self, stage: &Stage<'_>, task: &Task<'_>) -> Vector2<f64> {
        let (start, turn) = (task.start, stage.rotation * stage.duration);
        self.state.field.full.fill(false);
        self.state.field.pressure.fill(0.0);
        self.linear.discard();
        let eps =
            Vector2::new(start.x - turn * start.y, start.y + turn * start.x) / (1.0 + turn * turn);
        self.move_to(eps);
        self.update_balance(stage, task.drive);
        eps
    }

    /// Computes properties and balance at the present gap and field; true when the properties have come to rest.
    pub(super) fn update_balance(&mut self, stage: &Stage<'_>, drive: &Drive) -> bool {
        let field = &self.state.field;
        let steady = self.liquid.update(&self.settings, &self.gap, field, drive);
        self.balance
            .update(&self.cells, &self.gap, &self.liquid, field, stage);
        steady
    }

    fn refill(&mut self, stage: &Stage<'_>) -> usize {
        let field = &mut self.state.field;
        self.active_set
            .refill(&self.cells, field, &self.balance, stage)
    }

    /// What a closing gap between rough surfaces takes from the load, as touching asperities take area from the film.
    fn parting(&self) -> Matrix2<f64> {
        let pressure = &self.state.field.pressure;
        let mut taken = Matrix2::zeros();
        for (i, range) in self.cells.columns() {
            let n = self.cells.directions.mean[i];
            let sum: f64 = range
                .filter(|&c| pressure[c] != 0.0)
                .map(|c| pressure[c] * self.cells.area[c] * self.gap.parting(&self.form, c))
                .sum();
            taken += n * n.transpose() * sum;
        }
        taken
    }

    pub(super) fn linearise(&mut self, stage: &Stage<'_>) {
        self.linear.renew(
            &self.cells,
            &self.gap,
            &self.liquid,
            &self.state.field,
            &self.balance,
            stage,
        );
        if self.form.roughness > 0.0 {
            self.linear.slope -= self.parting();
        }
    }
}
