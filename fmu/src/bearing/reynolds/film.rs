//! The transient film: journal motion and oil content under a load, step by step.

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::asperities::Asperities;
use super::cells::{Cavitation, Cells, Stage};
use super::diagnostics::{Diagnostics, diagnose};
use super::gap::{Form, Gap};
use super::grid::Grid;
use super::rheology::Rheology;
use crate::bearing::profile::Profile;

/// The bearing as the film sees it, and how the film is to be solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilmSettings {
    /// Width B, m.
    pub width: f64,
    /// Diameter D, m.
    pub diameter: f64,
    /// Radial clearance c, m.
    pub clearance: f64,
    /// What happens where the film ruptures.
    pub cavitation: Cavitation,
    /// Pressure of the oil bath above that of the cavities, Pa: it presses oil back in at the ends.
    /// Only used with conserved mass; without, cavities have the pressure of the bath.
    pub side_pressure: f64,
    /// Columns around the bush (at least 4) and rows over half the width (at least 1).
    pub cells: [usize; 2],
    /// Largest error of the eccentricity ratio in one internal step, as a share of the smallest gap.
    pub tolerance: f64,
    /// The oil's viscosity laws.
    pub rheology: Rheology,
    /// Radial deviations of bush and journal.
    pub profile: Profile,
    /// The journal's tilt against the bush's axis, as the displacement of its end at `z = B/2`, m.
    pub tilt: [f64; 2],
    /// Asperity contact cell by cell; none: it comes from the `contact` of [`ReynoldsFilm::advance`].
    pub asperities: Option<Asperities>,
}

impl FilmSettings {
    /// A round, aligned bearing (m) with the default film: mass-conserving, as many cells as its width
    /// needs, an oil bath 1 bar above the cavities.
    pub fn new(width: f64, diameter: f64, clearance: f64) -> Self {
        Self {
            width,
            diameter,
            clearance,
            cavitation: Cavitation::MassConserving,
            side_pressure: 1e5,
            cells: Grid::sufficient_cells(width / diameter),
            tolerance: 5e-3,
            rheology: Rheology::default(),
            profile: Profile::default(),
            tilt: [0.0; 2],
            asperities: None,
        }
    }

    fn check(&self) -> Result<(), FilmError> {
        let positive = [
            ("width", self.width),
            ("diameter", self.diameter),
            ("clearance", self.clearance),
            ("tolerance", self.tolerance),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(FilmError::Setting { name, value });
            }
        }
        for (name, value, least) in [
            ("number of columns", self.cells[0], 4),
            ("number of rows", self.cells[1], 1),
        ] {
            if value < least {
                let value = value as f64;
                return Err(FilmError::Setting { name, value });
            }
        }
        if !(self.side_pressure.is_finite() && self.side_pressure >= 0.0) {
            let (name, value) = ("side pressure", self.side_pressure);
            return Err(FilmError::Setting { name, value });
        }
        Ok(())
    }
}

/// What acts on the film during an interval; loads vary linearly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// External load on the journal at the interval's start, N.
    pub load_before: Vector2<f64>,
    /// External load on the journal at the interval's end, N.
    pub load_after: Vector2<f64>,
    /// Speed of the journal, rad/s.
    pub journal_speed: f64,
    /// Speed of the bush, rad/s.
    pub bush_speed: f64,
    /// Viscosity of the oil at ambient pressure, Pa.s.
    pub viscosity: f64,
}

impl Drive {
    /// A constant load, with the bush at rest.
    pub fn steady(load: Vector2<f64>, journal_speed: f64, viscosity: f64) -> Self {
        Self {
            load_before: load,
            load_after: load,
            journal_speed,
            bush_speed: 0.0,
            viscosity,
        }
    }

    /// The mean rotation of both surfaces, rad/s.
    pub fn rotation(&self) -> f64 {
        0.5 * (self.journal_speed + self.bush_speed)
    }
}

/// Why a film cannot be made or go on.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FilmError {
    /// A setting is out of its range.
    #[error("the film's {name} is {value}; it must be a positive number")]
    Setting {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// The surfaces touch in the starting position.
    #[error(
        "form error and tilt leave no gap at eccentricity ratio {0}; reduce them, or start nearer the centre"
    )]
    NoGap(f64),
    /// The step did not converge however short.
    #[error(
        "the film's step did not converge at eccentricity ratio {eccentricity} with steps of {step} s"
    )]
    NotConverged {
        /// Where.
        eccentricity: f64,
        /// The shortest step tried, s.
        step: f64,
    },
}

/// What the film keeps from step to step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct State {
    /// Eccentricity ratio of the journal in the bearing's middle plane.
    pub(super) eps: Vector2<f64>,
    /// Its rate, 1/s.
    pub(super) velocity: Vector2<f64>,
    /// Angles through which journal and bush have turned, rad.
    pub(super) angles: [f64; 2],
    /// The internal step that the error control expects to fit, s.
    step: Option<f64>,
    pub(super) pressure: Vec<f64>,
    pub(super) content: Vec<f64>,
    pub(super) full: Vec<bool>,
}

/// The film between journal and bush by the transient two-dimensional Reynolds equation.
///
/// The journal has no inertia here: at every instant film, contact and external load balance. Time is
/// integrated with the two-stage, stiffly accurate SDIRK method of order two (Alexander 1977, SIAM J.
/// Numer. Anal. 14): each stage is an implicit Euler step, which keeps contents in their bounds and lets the
/// journal approach the bush at any step size; the error is controlled by the step of order one inside it.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct ReynoldsFilm {
    pub(super) settings: FilmSettings,
    pub(super) state: State,
    pub(super) cells: Cells,
    pub(super) gap: Gap,
    form: Form,
    start: Vec<f64>,
    middle: Vec<f64>,
    /// The state before the present internal step.
    kept: State,
    /// The state before the present interval.
    before: State,
}

/// A film as it is stored.
#[derive(Serialize, Deserialize)]
struct Saved {
    settings: FilmSettings,
    state: State,
}

impl From<ReynoldsFilm> for Saved {
    fn from(film: ReynoldsFilm) -> Self {
        Self {
            settings: film.settings,
            state: film.state,
        }
    }
}

impl TryFrom<Saved> for ReynoldsFilm {
    type Error = FilmError;

    fn try_from(saved: Saved) -> Result<Self, FilmError> {
        let mut film = Self::new(saved.settings)?;
        let cells = film.cells.count();
        let state = &saved.state;
        let lengths = [state.pressure.len(), state.content.len(), state.full.len()];
        if lengths != [cells; 3] {
            let (name, value) = ("number of stored cells", lengths[0] as f64);
            return Err(FilmError::Setting { name, value });
        }
        film.restore(&saved.state);
        Ok(film)
    }
}

/// `1 - 1/sqrt(2)`, the SDIRK method's coefficient.
const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Damping of a film that has run empty, as a share of that of a full one: the air's. It keeps the
/// motion of a journal without a film determined.
const AIR: f64 = 1e-6;
/// A film through which flows less than this share of its content in a step counts as still: its mass
/// balance is judged by this much, which is still well above the rounding of the content.
const STILL: f64 = 1e-5;
/// Passes of the Newton iteration before a shorter step is tried.
const PASSES: usize = 40;
/// The Newton iteration has converged when the last change of the eccentricity ratio is
/// this share of the smallest gap, and when that share times what it changed the load by, which is the
/// error left by the linearisation, is [`ACCURATE`] of the load.
const CONVERGED: f64 = 1e-6;
/// See [`CONVERGED`]; a change by this share of the clearance is rounding anyway.
const ACCURATE: f64 = 1e-13;

/// The most internal steps, taken or not, in one interval: ordinary ones need a few.
const MOST_TRIES: usize = 2_000;

impl ReynoldsFilm {
    /// A flooded film with the journal in the middle.
    ///
    /// # Errors
    /// When a setting is out of range, or form error and tilt leave no gap.
    pub fn new(settings: FilmSettings) -> Result<Self, FilmError> {
        settings.check()?;
        let width_to_diameter = settings.width / settings.diameter;
        let [columns, rows] = settings.cells;
        let half = Grid::standard(columns, rows, width_to_diameter);
        let tilted = settings.tilt != [0.0; 2];
        let grid = if tilted { half.whole_width() } else { half };
        let cells = Cells::new(grid, width_to_diameter, settings.cavitation);
        let count = cells.count();
        let state = State {
            eps: Vector2::zeros(),
            velocity: Vector2::zeros(),
            angles: [0.0; 2],
            step: None,
            pressure: vec![0.0; count],
            content: vec![1.0; count],
            full: vec![true; count],
        };
        let form = Form {
            tilt: Vector2::from(settings.tilt) / settings.clearance,
            ..Form::default()
        };
        let mut film = Self {
            kept: state.clone(),
            before: state.clone(),
            state,
            cells,
            gap: Gap::default(),
            form,
            start: vec![0.0; count],
            middle: vec![0.0; count],
            settings,
        };
        film.place(Vector2::zeros())?;
        Ok(film)
    }

    /// Puts the journal at an eccentricity ratio and floods the film.
    ///
    /// # Errors
    /// When no gap is left there.
    pub fn place(&mut self, eps: Vector2<f64>) -> Result<(), FilmError> {
        self.shape(self.state.angles);
        self.move_to(eps);
        let open = eps.x.is_finite() && eps.y.is_finite() && self.gap.smallest > 0.0;
        if !open {
            return Err(FilmError::NoGap(eps.norm()));
        }
        self.state.eps = eps;
        self.state.velocity = Vector2::zeros();
        self.state.step = None;
        self.cells.content.fill(1.0);
        self.cells.full.fill(true);
        self.cells.pressure.fill(0.0);
        self.keep();
        Ok(())
    }

    /// The settings.
    pub fn settings(&self) -> &FilmSettings {
        &self.settings
    }

    /// The eccentricity ratio in the middle plane, as a vector.
    pub fn eccentricity(&self) -> Vector2<f64> {
        self.state.eps
    }

    /// The share of the gap's volume that oil fills, cell by cell around the bush, then over the width.
    pub fn content(&self) -> &[f64] {
        &self.state.content
    }

    /// The grid: its first and last rows tell whether the film is solved over half or the whole width.
    pub fn grid(&self) -> &Grid {
        &self.cells.grid
    }

    /// The smallest gap, m.
    pub fn smallest_gap(&self) -> f64 {
        self.gap.smallest * self.settings.clearance
    }

    /// Lets `interval` seconds pass under `drive`, in internal steps of controlled error. `contact` gives the
    /// force with which asperities push an aligned journal back (N), over the eccentricity ratio.
    ///
    /// # Errors
    /// When the film cannot be solved; the film is then as before.
    pub fn advance(
        &mut self,
        interval: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
    ) -> Result<Diagnostics, FilmError> {
        self.before.clone_from(&self.state);
        let mut total = Diagnostics::default();
        let mut done = 0.0;
        let shortest = 1e-9 * interval;
        let mut step = self.state.step.unwrap_or(interval).min(interval);
        for tries in 0.. {
            if interval - done <= shortest {
                break;
            }
            if tries == MOST_TRIES {
                return Err(self.given_up(step));
            }
            let left = interval - done;
            // No sliver of a step at the end.
            let duration = if step < left {
                step.clamp(shortest, 0.5 * left)
            } else {
                left
            };
            let duration = self.resolve_turning(duration, drive);
            match self.step(
                done / interval,
                duration / interval,
                duration,
                drive,
                contact,
            ) {
                Ok((report, error)) if error <= 2.0 || duration <= shortest => {
                    done += duration;
                    let fitting = duration * (0.9 / error.max(1e-6).sqrt()).clamp(0.3, 2.5);
                    // A step cut short by the interval's end says nothing against a longer one.
                    step = if duration < step {
                        step.max(fitting)
                    } else {
                        fitting
                    };
                    self.keep();
                    total.add(report, duration);
                }
                Ok((_, error)) => {
                    step = duration * (0.9 / error.sqrt()).clamp(0.1, 0.7);
                    self.take_back();
                }
                Err(()) => {
                    step = 0.25 * duration;
                    self.take_back();
                    if step < shortest {
                        return Err(self.given_up(step));
                    }
                }
            }
        }
        self.state.step = Some(step);
        Ok(total.over(done))
    }

    /// The film as it was before the interval, and why.
    fn given_up(&mut self, step: f64) -> FilmError {
        let eccentricity = self.state.eps.norm();
        let before = std::mem::replace(&mut self.before, self.kept.clone());
        self.restore(&before);
        FilmError::NotConverged { eccentricity, step }
    }

    /// With a form error on a turning surface, a step turns it by no more than two columns.
    fn resolve_turning(&self, duration: f64, drive: &Drive) -> f64 {
        if self.settings.profile.is_round() {
            return duration;
        }
        let speed = drive.journal_speed.abs().max(drive.bush_speed.abs());
        let turn = 2.0 * std::f64::consts::TAU / self.cells.grid.columns() as f64;
        if speed * duration > turn {
            turn / speed
        } else {
            duration
        }
    }

    /// One step; the result's error is relative to the tolerance.
    fn step(
        &mut self,
        from: f64,
        share: f64,
        duration: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
    ) -> Result<(Diagnostics, f64), ()> {
        let start = self.state.eps;
        self.shape(self.state.angles);
        self.move_to(start);
        let mut mass = std::mem::take(&mut self.start);
        self.cells.masses(&self.gap, &mut mass);

        let first = GAMMA * duration;
        self.turn(first, drive);
        let guess = start + self.state.velocity * first;
        let result = self.settle(
            first,
            &mass,
            start,
            guess,
            from + GAMMA * share,
            drive,
            contact,
        );
        self.start = mass;
        let middle = result?;
        let side = self.side(drive);
        let first_flow = self.cells.end_flow(side);

        // The second stage starts from where the first one's rates lead at (1 - gamma) of the step.
        let mut mass = std::mem::take(&mut self.middle);
        self.cells.masses(&self.gap, &mut mass);
        let ahead = (1.0 - GAMMA) / GAMMA;
        for (mass, start) in mass.iter_mut().zip(&self.start) {
            *mass = start + ahead * (*mass - start);
        }
        let launch = start + (middle - start) * ahead;
        let straight = start + (middle - start) / GAMMA;
        self.turn(duration - first, drive);
        let result = self.settle(first, &mass, launch, straight, from + share, drive, contact);
        self.middle = mass;
        let end = result?;

        self.state.velocity = (end - launch) / first;
        self.state.eps = end;
        let error = (end - straight).norm() / (self.settings.tolerance * self.gap.smallest);
        let stage = Stage {
            duration: first,
            mass: &self.middle,
            rotation: drive.rotation(),
            side,
        };
        let mut report = diagnose(self, &stage, drive);
        let last_flow = self.cells.end_flow(side);
        let flow = first_flow
            .weighted(1.0 - GAMMA)
            .and(last_flow.weighted(GAMMA));
        report.mass_error = match self.settings.cavitation {
            Cavitation::NonNegative => 0.0,
            Cavitation::MassConserving => {
                let stored = self.cells.stored_since(&self.gap, &self.start) / duration;
                let still = STILL * self.cells.held(&self.gap) / duration;
                let moved =
                    flow.out + flow.into + self.cells.circulating(&self.gap, stage.rotation);
                (stored + flow.out - flow.into).abs() / moved.max(still)
            }
        };
        Ok((report, error))
    }

    /// Finds the eccentricity at the end of an implicit Euler stage, by Newton's method on it and on the
    /// film's cells together.
    #[allow(clippy::too_many_arguments)]
    fn settle(
        &mut self,
        duration: f64,
        mass: &[f64],
        start: Vector2<f64>,
        guess: Vector2<f64>,
        at: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
    ) -> Result<Vector2<f64>, ()> {
        let rotation = drive.rotation();
        let stage = Stage {
            duration,
            mass,
            rotation,
            side: self.side(drive),
        };
        let scale = self.force_scale(drive.viscosity);
        let load = (drive.load_before + (drive.load_after - drive.load_before) * at) / scale;
        let floats = self.settings.cavitation == Cavitation::NonNegative
            && load == Vector2::zeros()
            && self.settings.asperities.is_none()
            && contact(start.norm()) == 0.0;
        if floats {
            return Ok(self.float(start, rotation * duration));
        }
        self.cells.begin();
        let mut eps = self.reachable(guess);
        if self.cells.is_empty() {
            self.cells.fill_towards(load);
        }
        for _ in 0..PASSES {
            self.move_to(eps);
            let settled = self.update_viscosity(drive);
            self.cells.conduct(&self.gap);
            if !self.cells.solve(&self.gap, &stage) {
                return Err(());
            }
            let response = self.cells.response();
            let (touch, stiffness) = self.touch(eps, scale, contact);
            let air = AIR * self.settings.width.powi(2) / self.settings.diameter.powi(2);
            let slip = (eps - start) / duration - rotation * Vector2::new(-eps.y, eps.x);
            let (pinch, stiffening) = self.unresolved(eps, start, duration);
            let missing = load - touch - response.load - pinch - slip * air;
            let matrix =
                response.slope + stiffness + stiffening + Matrix2::identity() * (air / duration);
            let Some(inverse) = matrix.try_inverse() else {
                return Err(());
            };
            let change = inverse * missing;
            if !(change.x.is_finite() && change.y.is_finite()) {
                return Err(());
            }
            let share = self.allowed(eps, change, 0.25);
            let change = change * share;
            let moved = self.cells.accept(change, &self.gap, &stage);
            eps += change;
            let correction = change.norm() / self.gap.smallest;
            let size = response.size + load.norm() + touch.norm();
            let accurate =
                change.norm() <= ACCURATE || correction * missing.norm() <= ACCURATE * size;
            if moved == 0 && settled && share == 1.0 && correction <= CONVERGED && accurate {
                self.move_to(eps);
                self.cells.conduct(&self.gap);
                return Ok(eps);
            }
        }
        Err(())
    }

    /// An implicit Euler stage without load or pressure: the journal goes with the mean rotation.
    fn float(&mut self, start: Vector2<f64>, turn: f64) -> Vector2<f64> {
        self.cells.empty();
        let eps =
            Vector2::new(start.x - turn * start.y, start.y + turn * start.x) / (1.0 + turn * turn);
        self.move_to(eps);
        self.cells.conduct(&self.gap);
        eps
    }

    /// The force of the asperities on the load's side and its derivative over the eccentricity,
    /// dimensionless.
    fn touch(
        &self,
        eps: Vector2<f64>,
        scale: f64,
        contact: &dyn Fn(f64) -> f64,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        if let Some(asperities) = &self.settings.asperities {
            let (force, slope) = asperities.push(&self.cells, &self.gap, &self.settings);
            return (force / scale, slope / scale);
        }
        let e = eps.norm();
        let force = contact(e) / scale;
        if force == 0.0 || e == 0.0 {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let nudge = 1e-6 * (1.0 - e).abs().max(1e-9);
        let slope = (contact(e + nudge) - contact(e - nudge)) / (2.0 * nudge * scale);
        let n = eps / e;
        let along = n * n.transpose();
        let across = Matrix2::identity() - along;
        (n * force, along * slope + across * (force / e))
    }

    /// The load that the film's narrowest part carries beyond what the grid resolves, and its
    /// derivative.
    ///
    /// A closing gap carries near its narrowest point (the squeeze film of a long bearing with
    /// `H = g + theta^2/2`) `pi sqrt(2)/4 g^(-3/2)` times its rate. Where `g` is narrower than the gap's
    /// variation `d` over half a column, what is beyond `(g + d)^(-3/2)` is added. It matters only within a few
    /// `d` of the bush (`d` is 5e-4 of the clearance at 96 columns), and keeps the journal from it.
    fn unresolved(
        &self,
        eps: Vector2<f64>,
        start: Vector2<f64>,
        duration: f64,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        let e = eps.norm();
        let variation = 0.5 * (0.5 * self.cells.grid.theta_width(0)).powi(2);
        let gap = 1.0 - e;
        let n = eps / e;
        let closing = (eps - start).dot(&n) / duration;
        if !self.is_plain() || gap > 3.0 * variation || closing <= 0.0 {
            return (Vector2::zeros(), Matrix2::zeros());
        }
        let factor = 0.25 * std::f64::consts::PI * std::f64::consts::SQRT_2;
        let beyond = |power: f64| gap.powf(power) - (gap + variation).powf(power);
        let carried = factor * beyond(-1.5);
        let slope = carried / duration + closing * 1.5 * factor * beyond(-2.5);
        (n * (carried * closing), n * n.transpose() * slope)
    }

    /// Whether both surfaces are round and aligned.
    fn is_plain(&self) -> bool {
        self.settings.profile.is_round() && self.settings.tilt == [0.0; 2]
    }

    /// The share of the step `change` from `eps` that leaves at least `rest` of the gap everywhere.
    fn allowed(&self, eps: Vector2<f64>, change: Vector2<f64>, rest: f64) -> f64 {
        let mut share = self.gap.allowed(&self.cells.directions, change, rest);
        let limit = 1.0 - rest * (1.0 - eps.norm());
        while self.is_plain() && share > 1e-12 && (eps + change * share).norm() > limit {
            share *= 0.5;
        }
        share
    }

    /// The point towards `guess` that leaves at least half of the present gap.
    fn reachable(&mut self, guess: Vector2<f64>) -> Vector2<f64> {
        let from = self.state.eps;
        self.move_to(from);
        from + (guess - from) * self.allowed(from, guess - from, 0.5)
    }

    /// Updates the cells' viscosity; true when it has come to rest.
    fn update_viscosity(&mut self, drive: &Drive) -> bool {
        if self.settings.rheology.is_newtonian() {
            return true;
        }
        let psi = self.settings.clearance / (0.5 * self.settings.diameter);
        let to_pascal = 12.0 * drive.viscosity / (psi * psi);
        let sliding = (drive.journal_speed - drive.bush_speed).abs() / psi;
        let mut largest: f64 = 0.0;
        for cell in 0..self.cells.count() {
            let pressure = self.cells.pressure[cell] * to_pascal;
            let rate = sliding / self.gap.cell[cell];
            let ratio = self
                .settings
                .rheology
                .ratio(drive.viscosity, pressure, rate);
            let fluidity = 1.0 / ratio;
            largest = largest.max((fluidity / self.cells.fluidity[cell] - 1.0).abs());
            self.cells.fluidity[cell] = fluidity;
        }
        largest < 1e-9
    }

    /// The load that a dimensionless load of one stands for, N.
    pub(super) fn force_scale(&self, viscosity: f64) -> f64 {
        let FilmSettings {
            width,
            diameter,
            clearance,
            ..
        } = self.settings;
        let radius = 0.5 * diameter;
        12.0 * viscosity * radius.powi(3) * width / clearance.powi(2)
    }

    /// The dimensionless pressure at the open ends.
    fn side(&self, drive: &Drive) -> f64 {
        match self.settings.cavitation {
            Cavitation::NonNegative => 0.0,
            Cavitation::MassConserving => {
                let psi = self.settings.clearance / (0.5 * self.settings.diameter);
                self.settings.side_pressure * psi * psi / (12.0 * drive.viscosity)
            }
        }
    }

    /// Computes the gap at an eccentricity.
    fn move_to(&mut self, eps: Vector2<f64>) {
        self.gap
            .update(&self.cells.grid, &self.cells.directions, &self.form, eps);
        if self.is_plain() {
            // The narrowest point may lie between the grid's.
            self.gap.smallest = 1.0 - eps.norm();
        }
    }

    /// Turns the surfaces.
    fn turn(&mut self, duration: f64, drive: &Drive) {
        self.state.angles[0] += drive.journal_speed * duration;
        self.state.angles[1] += drive.bush_speed * duration;
        self.shape(self.state.angles);
    }

    /// Computes the form error at the surfaces' angles.
    fn shape(&mut self, angles: [f64; 2]) {
        let profile = &self.settings.profile;
        if profile.is_round() {
            return;
        }
        let grid = &self.cells.grid;
        let at = |theta: f64| profile.opening(theta, angles) / self.settings.clearance;
        self.form.middle.clear();
        self.form.edge.clear();
        for i in 0..grid.columns() {
            self.form.middle.push(at(grid.theta_centre(i)));
            self.form.edge.push(at(grid.theta_edge(i)));
        }
    }

    /// Stores the cells in the state, which then is where to come back to.
    fn keep(&mut self) {
        self.state.pressure.clone_from(&self.cells.pressure);
        self.state.content.clone_from(&self.cells.content);
        self.state.full.clone_from(&self.cells.full);
        self.kept.clone_from(&self.state);
    }

    /// Goes back to the last kept state.
    fn take_back(&mut self) {
        std::mem::swap(&mut self.kept, &mut self.state);
        self.load();
    }

    fn restore(&mut self, state: &State) {
        self.state.clone_from(state);
        self.load();
    }

    /// Fills the cells from the state.
    fn load(&mut self) {
        self.kept.clone_from(&self.state);
        self.cells.pressure.clone_from(&self.state.pressure);
        self.cells.content.clone_from(&self.state.content);
        self.cells.full.clone_from(&self.state.full);
        self.shape(self.state.angles);
        self.move_to(self.state.eps);
    }
}
