//! A stage in which the journal falls through an emptied gap and lands on the oil that is left.
//!
//! There the journal's resistance jumps by many powers of ten from one place to the next, and Newton's method for
//! everything at once ([`newton`](super::newton)) oscillates across the jump. This method is slower but safe. It holds the
//! eccentricity while it solves the cells' complementarity, and moves the eccentricity by Newton's method with a search
//! along each step.
//!
//! *Cells.* Over `u = P - (1 - theta)` the balances are piecewise linear with M-matrices that are diagonally dominant by
//! columns. They therefore have exactly one solution, and the sum of the absolute residuals falls along Newton's direction
//! (the damped semismooth method: Qi & Sun 1993, Math. Program. 58; Jacobians of this kind contract that sum).
//!
//! *Journal.* In short stages squeezing outweighs everything else, and the forces are the slope of a convex function of
//! the eccentricity, the film's dissipation. The search therefore looks for the point where the force along the step
//! vanishes, between a place before it and one beyond it, by Newton's method kept within this bracket.

use nalgebra::{Matrix2, Vector2};

use super::{
    forces::Forces,
    newton::is_balanced,
    stage::{FilmStage, JournalStage, NoSolution},
    state::Field,
    way::GapKeepingMove,
    workspace::Workspace,
};

/// Most steps of the journal.
const STEPS: usize = 60;
/// Most places tried along a step.
const TRIALS: usize = 80;
/// Most passes over the cells at one place.
const PASSES: usize = 100;
/// Least share of a pass's correction that is tried.
const SHORTEST: f64 = 1e-4;
/// A place along a step is accepted if the force along the step is this share of that at its start.
const SETTLED: f64 = 0.3;

/// The buffer of the landing method.
#[derive(Clone, Debug)]
pub struct Landing {
    /// The field before a correction that is tried.
    pub trial: Field,
}

/// A place of the journal at which the cells' balances hold.
#[derive(Clone, Copy)]
struct Rest {
    eps: Vector2<f64>,
    forces: Forces,
    /// Derivative of all that carries over the eccentricity ratio.
    slope: Matrix2<f64>,
}

impl Rest {
    /// How far the journal has to move, to first order.
    fn change(&self) -> Option<Vector2<f64>> {
        let missing = self.forces.missing;
        let change = self.slope.try_inverse()? * missing;
        let ahead = change.dot(&missing) > 0.0;
        // A slope that leads against the force is of no use: move along the force.
        let change = if ahead { change } else { missing / self.slope.norm() };
        (change.x.is_finite() && change.y.is_finite()).then_some(change)
    }
}

impl Landing {
    /// Finds the eccentricity ratio at the end of a stage, from the field at the start of the step. Field, gap and balance
    /// are then those of its end.
    pub fn solve(
        &mut self,
        work: &mut Workspace,
        stage: &FilmStage,
        task: &JournalStage,
        start: &Field,
    ) -> Result<Vector2<f64>, NoSolution> {
        work.state.field.copy_from(start);
        let mut rest = self.rest_at(work, work.state.eps, stage, task)?;
        for _ in 0..STEPS {
            let change = rest.change().ok_or(NoSolution)?;
            if rest.forces.balance(change) {
                return Ok(rest.eps);
            }
            work.geometry.move_to(rest.eps);
            let way = GapKeepingMove::new(&work.geometry, rest.eps, change, 0.25);
            rest = self.search(work, rest, way, stage, task)?;
        }
        Err(NoSolution)
    }

    /// Finds the place along a way where the force along it nearly vanishes, or the way's end.
    fn search(
        &mut self,
        work: &mut Workspace,
        from: Rest,
        way: GapKeepingMove,
        stage: &FilmStage,
        task: &JournalStage,
    ) -> Result<Rest, NoSolution> {
        let force = |share: f64, rest: &Rest| rest.forces.missing.dot(&way.heading(share));
        let settled = SETTLED * force(0.0, &from);
        let mut beyond = self.rest_at(work, way.at(1.0), stage, task)?;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..TRIALS {
            let over = force(high, &beyond);
            if over >= -settled {
                return Ok(beyond);
            }
            let heading = way.heading(high);
            let newton = high + over / heading.dot(&(beyond.slope * heading));
            let middle = 0.5 * (low + high);
            // For a convex force Newton's method approaches from one side only; bisection moves the other side.
            let share = if newton > low && newton < high { newton } else { middle };
            let rest = self.rest_at(work, way.at(share), stage, task)?;
            if force(share, &rest) > settled {
                low = share;
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                let rest = self.rest_at(work, way.at(middle), stage, task)?;
                if force(middle, &rest).abs() <= settled {
                    return Ok(rest);
                }
                if force(middle, &rest) > 0.0 {
                    low = middle;
                } else {
                    (high, beyond) = (middle, rest);
                }
            } else {
                (high, beyond) = (share, rest);
            }
        }
        // The workspace may be at another place.
        self.rest_at(work, way.at(high), stage, task)
    }

    /// Holds the journal at an eccentricity ratio and solves the cells' balances.
    fn rest_at(
        &mut self,
        work: &mut Workspace,
        eps: Vector2<f64>,
        stage: &FilmStage,
        task: &JournalStage,
    ) -> Result<Rest, NoSolution> {
        work.geometry.move_to(eps);
        self.fill_cells(work, stage, task)?;
        let forces = Forces::at(eps, work, stage, task);
        Ok(Rest { eps, forces, slope: work.linear.slope + forces.stiffness })
    }

    /// Solves the cells' balances at the present gap. The linearisation is then that of the solution.
    fn fill_cells(&mut self, work: &mut Workspace, stage: &FilmStage, task: &JournalStage) -> Result<(), NoSolution> {
        let mut steady = work.update_balance(stage, task.drive);
        let mut last = f64::INFINITY;
        for _ in 0..PASSES {
            work.linearise(stage);
            let imbalance = work.linear.imbalance(&work.balance);
            if steady && is_balanced(work, stage, imbalance, imbalance > 0.5 * last) {
                return Ok(());
            }
            last = imbalance;
            self.trial.copy_from(&work.state.field);
            let mut share = 1.0;
            loop {
                work.linear.apply(share, Vector2::zeros(), &mut work.state.field);
                work.active_set.begin();
                work.exchange(stage);
                steady = work.update_balance(stage, task.drive);
                let now = work.linear.imbalance(&work.balance);
                if now <= (1.0 - 0.1 * share) * imbalance || share < SHORTEST {
                    break;
                }
                share *= 0.5;
                work.state.field.copy_from(&self.trial);
            }
        }
        Err(NoSolution)
    }
}
