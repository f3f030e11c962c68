//! One implicit Euler stage by Newton's method: eccentricity, pressures and contents together.
//!
//! The residuals are exact in every pass. A linearisation is kept as long as it converges fast (the chord method), and
//! renewed when cells fill or rupture.

use nalgebra::{Matrix2, Vector2};

use super::{
    active_set::ActiveSet,
    forces::Forces,
    geometry::Geometry,
    stage::{FilmStage, JournalStage, NoSolution},
    workspace::Workspace,
};

/// Passes before a shorter step is tried.
const PASSES: usize = 60;
/// The cells balance when the sum of their residuals is at most this share of the flow through the film.
const BALANCED: f64 = 1e-11;
/// The same where no mass needs to be conserved.
const BALANCED_ROUGHLY: f64 = 5e-9;
/// Residuals that no longer decrease are rounding, if they are less than this share of the flow,
const ROUNDED: f64 = 1e-10;
/// or than this many units in the last place of all contributions.
const LAST_PLACES: f64 = 16.0;
/// Most further passes for which a linearisation is kept; beyond, a new one is less work.
const MORE_PASSES: f64 = 3.5;

/// How the iteration continues.
enum Next {
    /// The cells' balances hold.
    Rest,
    /// With the linearisation at hand.
    Reuse,
    /// With a new linearisation.
    Renew,
}

/// How the iteration has gone so far.
struct Path {
    /// Share of the flow at which the cells balance.
    balanced: f64,
    /// Cells that moved into or out of the set of full cells in the last pass.
    moved: usize,
    /// Whether the last pass took only part of its step.
    cut_short: bool,
    /// The last residuals over the flow.
    last: Option<f64>,
}

impl Path {
    /// Judges the residuals over the flow. `serves`: a linearisation is at hand; `rounding`: the residuals' rounding.
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
        if contraction < 1.0 && passes < MORE_PASSES { Next::Reuse } else { Next::Renew }
    }
}

/// Finds the eccentricity ratio at the end of a stage. Field, gap and balance are then those of its end.
pub fn solve(work: &mut Workspace, stage: &FilmStage, task: &JournalStage) -> Result<Vector2<f64>, NoSolution> {
    let wanted = task.load / task.force_scale;
    if floats(work, wanted, task) {
        return Ok(float(work, stage, task));
    }
    work.active_set.begin();
    ActiveSet::fill_towards(wanted, &work.geometry.cells, &mut work.state.field);
    let mut eps = work.reachable(task.guess);
    let mut path = Path {
        balanced: if work.geometry.cells.conserves_mass() { BALANCED } else { BALANCED_ROUGHLY },
        moved: 0,
        cut_short: false,
        last: None,
    };
    for _ in 0..PASSES {
        work.geometry.move_to(eps);
        let steady = work.update_balance(stage, task.drive);
        path.moved += work.refill(stage);
        let forces = Forces::at(eps, work, stage, task);
        let flow = work.flow(stage);
        let imbalance = work.linear.imbalance(&work.balance) / flow;
        let rounding = || LAST_PLACES * f64::EPSILON * work.turnover(stage) / flow;
        let carries = |inverse: Matrix2<f64>| steady && forces.balance(inverse * forces.missing);
        match path.judge(work.linear.serves(stage.duration), imbalance, rounding) {
            Next::Rest if inverse(work, &forces).is_some_and(carries) => {
                // A tension that no film can have may look like a balance.
                let conserving = work.geometry.cells.conserves_mass();
                return if conserving && work.active_set.is_forced(&work.state.field) {
                    Err(NoSolution)
                } else {
                    Ok(eps)
                };
            }
            Next::Renew => work.linearise(stage),
            Next::Rest | Next::Reuse => work.linear.reuse(&work.balance),
        }
        let Geometry { cells, gap, .. } = &work.geometry;
        let missing = forces.missing + work.linear.load_of_correction(cells, gap);
        let change = inverse(work, &forces).ok_or(NoSolution)? * missing;
        if !(change.x.is_finite() && change.y.is_finite()) {
            return Err(NoSolution);
        }
        let share = work.geometry.allowed(eps, change, 0.25);
        eps += change * share;
        work.linear.apply(1.0, change * share, &mut work.state.field);
        path.moved = work.exchange(stage);
        path.cut_short = share < 1.0;
    }
    Err(NoSolution)
}

/// Whether the cells' balances hold: their residuals `imbalance` are small enough, or, if they no longer decrease
/// (`stays`), no more than rounding.
pub fn is_balanced(work: &Workspace, stage: &FilmStage, imbalance: f64, stays: bool) -> bool {
    let flow = work.flow(stage);
    let rounding = LAST_PLACES * f64::EPSILON * work.turnover(stage);
    imbalance <= BALANCED * flow || (stays && imbalance <= rounding.max(ROUNDED * flow))
}

/// Derivative of the eccentricity ratio over a force on the journal.
fn inverse(work: &Workspace, forces: &Forces) -> Option<Matrix2<f64>> {
    (work.linear.slope + forces.stiffness).try_inverse()
}

/// Whether nothing presses on a film without conserved mass, so that the journal follows the mean rotation.
fn floats(work: &Workspace, load: Vector2<f64>, task: &JournalStage) -> bool {
    !work.geometry.cells.conserves_mass()
        && load == Vector2::zeros()
        && work.geometry.settings.asperities.is_none()
        && (task.contact)(task.start.norm()) == 0.0
}

/// Solves a stage without load: an empty film that turns the journal with it.
fn float(work: &mut Workspace, stage: &FilmStage, task: &JournalStage) -> Vector2<f64> {
    let (start, turn) = (task.start, stage.rotation * stage.duration);
    work.state.field.rupture();
    work.linear.discard();
    let eps = Vector2::new(start.x - turn * start.y, start.y + turn * start.x) / (1.0 + turn * turn);
    work.geometry.move_to(eps);
    work.update_balance(stage, task.drive);
    eps
}
