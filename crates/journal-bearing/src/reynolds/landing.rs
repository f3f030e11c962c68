//! A stage in which the journal falls through an emptied gap and lands on what oil is left.
//!
//! There the journal's resistance to motion jumps by many powers of ten from one place to the next, and Newton's method
//! for everything at once goes to and fro over the edge ([`newton`](super::newton)). This way is slower and sure: the
//! eccentricity is held while the cells' complementarity is solved for it, and moved by Newton's method
//! with a search along each step.
//!
//! *Cells.* Over `u = P - (1 - theta)` the balances are piecewise linear with M-matrices, diagonally dominant by
//! columns, so they have one solution, and the sum of the residuals' sizes falls along Newton's direction (the damped
//! semismooth method: Qi & Sun 1993, Math. Program. 58; the sum is what Jacobians of this kind contract).
//!
//! *Journal.* With short stages squeezing outweighs all else, and the forces are the slope of a convex function of the
//! eccentricity (the film's dissipation). So the search looks for where the force along the step vanishes: between a
//! place before and one beyond, by Newton's method kept to that bracket.

use nalgebra::{Matrix2, Vector2};

use super::balance::Stage;
use super::film::ReynoldsFilm;
use super::linear::load;
use super::newton::{NoSolution, Task};
use super::support::Motion;
use super::way::Way;

/// As many failures in an interval are left to shorter steps, which is less work at an ordinary start.
const PATIENCE: usize = 4;
/// Steps of the journal.
const STEPS: usize = 60;
/// Places tried along a step.
const TRIALS: usize = 80;
/// Passes over the cells at one place.
const PASSES: usize = 100;
/// The shortest share of a pass's change.
const SHORTEST: f64 = 1e-4;
/// A place along a step serves if the force along it is this share of that at its start.
const SETTLED: f64 = 0.3;

/// The journal at a place where the cells' balances are met.
#[derive(Clone, Copy)]
struct Place {
    eps: Vector2<f64>,
    /// The load that nothing carries.
    missing: Vector2<f64>,
    /// The size of all that adds up to it.
    size: f64,
    /// How what is carried grows with the eccentricity.
    slope: Matrix2<f64>,
}

impl Place {
    /// How far the journal has to move, to first order.
    fn change(&self) -> Option<Vector2<f64>> {
        let change = self.slope.try_inverse()? * self.missing;
        let ahead = change.dot(&self.missing) > 0.0;
        // Where the slope says nothing of use, along the force.
        let change = if ahead {
            change
        } else {
            self.missing / self.slope.norm()
        };
        (change.x.is_finite() && change.y.is_finite()).then_some(change)
    }
}

impl ReynoldsFilm {
    /// Finds the eccentricity at the end of a stage like [`settle`](Self::settle), where that does not.
    pub(super) fn land(
        &mut self,
        stage: &Stage<'_>,
        task: &Task<'_>,
    ) -> Result<Vector2<f64>, NoSolution> {
        if !self.cells.conserves_mass() || self.failures < PATIENCE {
            return Err(NoSolution);
        }
        self.state.field.copy_from(&self.kept.field);
        let mut place = self.rest_at(self.state.eps, stage, task)?;
        for _ in 0..STEPS {
            let change = place.change().ok_or(NoSolution)?;
            if Self::carries(place.missing, place.size, change) {
                return Ok(place.eps);
            }
            self.move_to(place.eps);
            let way = self.way(place.eps, change, 0.25);
            place = self.search(place, way, stage, task)?;
        }
        Err(NoSolution)
    }

    /// Finds where, along a way from a place, the force along it nearly vanishes, or its end.
    fn search(
        &mut self,
        from: Place,
        way: Way,
        stage: &Stage<'_>,
        task: &Task<'_>,
    ) -> Result<Place, NoSolution> {
        let force = |share: f64, place: &Place| place.missing.dot(&way.heading(share));
        let settled = SETTLED * force(0.0, &from);
        let mut beyond = self.rest_at(way.at(1.0), stage, task)?;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..TRIALS {
            let over = force(high, &beyond);
            if over >= -settled {
                return Ok(beyond);
            }
            let heading = way.heading(high);
            let newton = high + over / heading.dot(&(beyond.slope * heading));
            let middle = 0.5 * (low + high);
            // Newton's way is one-sided where the force is convex; the other side needs the middle.
            let share = if newton > low && newton < high {
                newton
            } else {
                middle
            };
            let place = self.rest_at(way.at(share), stage, task)?;
            if force(share, &place) > settled {
                low = share;
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                let place = self.rest_at(way.at(middle), stage, task)?;
                if force(middle, &place).abs() <= settled {
                    return Ok(place);
                }
                if force(middle, &place) > 0.0 {
                    low = middle;
                } else {
                    (high, beyond) = (middle, place);
                }
            } else {
                (high, beyond) = (share, place);
            }
        }
        // The last place tried may be another one.
        self.rest_at(way.at(high), stage, task)
    }

    /// Holds the journal and solves the cells' balances.
    fn rest_at(
        &mut self,
        eps: Vector2<f64>,
        stage: &Stage<'_>,
        task: &Task<'_>,
    ) -> Result<Place, NoSolution> {
        self.move_to(eps);
        self.fill_cells(stage, task)?;
        let scale = self.settings.force_scale(task.drive.viscosity);
        let motion = Motion {
            start: task.start,
            duration: stage.duration,
            rotation: stage.rotation,
        };
        let support = self.support(eps, &motion, scale, task.contact);
        let carried = load(&self.cells, &self.gap, &self.state.field.pressure);
        let wanted = task.load / scale;
        Ok(Place {
            eps,
            missing: wanted - support.force - carried.force,
            size: carried.size + wanted.norm() + support.touch.norm(),
            slope: self.linear.slope + support.stiffness,
        })
    }

    /// Solves the cells' balances at the present gap. The linearisation is then the solution's own.
    fn fill_cells(&mut self, stage: &Stage<'_>, task: &Task<'_>) -> Result<(), NoSolution> {
        let mut steady = self.update_balance(stage, task.drive);
        let mut last = f64::INFINITY;
        for _ in 0..PASSES {
            self.linearise(stage);
            let imbalance = self.linear.imbalance(&self.balance);
            if steady && self.is_balanced(stage, imbalance, imbalance > 0.5 * last) {
                return Ok(());
            }
            last = imbalance;
            self.trial.copy_from(&self.state.field);
            let mut share = 1.0;
            loop {
                self.linear.approach(share, &mut self.state.field);
                self.active_set.begin();
                self.active_set
                    .settle(&self.cells, &mut self.state.field, stage);
                steady = self.update_balance(stage, task.drive);
                let now = self.linear.imbalance(&self.balance);
                if now <= (1.0 - 0.1 * share) * imbalance || share < SHORTEST {
                    break;
                }
                share *= 0.5;
                self.state.field.copy_from(&self.trial);
            }
        }
        Err(NoSolution)
    }
}
