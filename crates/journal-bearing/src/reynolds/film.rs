//! The transient film: journal motion and oil content under a load, step by step.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::active_set::ActiveSet;
use super::balance::Balance;
use super::cells::Cells;
use super::diagnostics::Diagnostics;
use super::field::{Field, State};
use super::gap::{Form, Gap};
use super::grid::Grid;
use super::linear::Linear;
use super::liquid::Liquid;
use super::newton::NoSolution;
use super::settings::{Drive, FilmError, FilmSettings};
use super::step::Step;

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
    pub(super) form: Form,
    pub(super) gap: Gap,
    pub(super) liquid: Liquid,
    pub(super) balance: Balance,
    pub(super) linear: Linear,
    pub(super) active_set: ActiveSet,
    /// Mass per cell at the start of a step's first and second stage.
    pub(super) start: Vec<f64>,
    pub(super) launch: Vec<f64>,
    /// The state before the present internal step.
    pub(super) kept: State,
    /// The field before a change that is tried.
    pub(super) trial: Field,
    /// The state before the present interval.
    before: State,
    /// Internal steps without a solution in it.
    pub(super) failures: usize,
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
        if !saved.state.field.fits(film.cells.count()) {
            let (name, value) = ("number of stored cells", saved.state.field.full.len());
            let value = value as f64;
            return Err(FilmError::Setting { name, value });
        }
        film.state.copy_from(&saved.state);
        film.arrive();
        Ok(film)
    }
}

/// The most internal steps, taken or not, in one interval: ordinary ones need a few, a journal that slides around an
/// emptied bush some thousands.
const MOST_TRIES: usize = 20_000;
/// The most of them without a solution.
const MOST_FAILURES: usize = 500;
/// Smooth surfaces that come closer than this share of the clearance touch.
const TOUCHING: f64 = 1e-3;

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
        let state = State::flooded(&cells);
        let form = Form {
            tilt: Vector2::from(settings.tilt) / settings.clearance,
            roughness: settings.film_roughness(),
            ..Form::default()
        };
        let mut film = Self {
            kept: state.clone(),
            before: state.clone(),
            trial: state.field.clone(),
            failures: 0,
            state,
            form,
            gap: Gap::new(&cells),
            liquid: Liquid::new(count),
            balance: Balance::new(count),
            linear: Linear::new(&cells),
            active_set: ActiveSet::new(count),
            start: vec![0.0; count],
            launch: vec![0.0; count],
            cells,
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
        self.shape();
        self.move_to(eps);
        let open = eps.x.is_finite() && eps.y.is_finite() && self.gap.is_open(&self.form);
        if !open {
            return Err(FilmError::NoGap(eps.norm()));
        }
        let angles = self.state.angles;
        self.state = State {
            eps,
            angles,
            ..State::flooded(&self.cells)
        };
        self.arrive();
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

    /// The share of the gap's volume that oil fills, in a column (around the bush) and a row (over the width).
    pub fn content(&self, column: usize, row: usize) -> f64 {
        self.state.field.content[column * self.cells.stride + row]
    }

    /// The grid: its first and last rows tell whether the film is solved over half or the whole width.
    pub fn grid(&self) -> &Grid {
        &self.cells.grid
    }

    /// The smallest gap, m; with a film between rough surfaces, the smallest mean gap.
    pub fn smallest_gap(&self) -> f64 {
        let narrowest = (self.gap).narrowest(&self.cells, &self.form, self.state.eps);
        narrowest * self.settings.clearance
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
        self.before.copy_from(&self.state);
        // What an interval begins with must not depend on what is not stored.
        self.linear.discard();
        let mut total = Diagnostics::default();
        let mut done = 0.0;
        let shortest = 1e-9 * interval;
        let mut step = self.state.step.unwrap_or(interval).min(interval);
        self.failures = 0;
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
            self.kept.copy_from(&self.state);
            let place = Step {
                from: done / interval,
                share: duration / interval,
                duration,
            };
            match self.step(place, drive, contact) {
                Ok((report, error)) if error <= 2.0 || duration <= shortest => {
                    done += duration;
                    let fitting = duration * (0.9 / error.max(1e-6).sqrt()).clamp(0.3, 2.5);
                    // A step cut short by the interval's end says nothing against a longer one.
                    step = if duration < step {
                        step.max(fitting)
                    } else {
                        fitting
                    };
                    total.add(report, duration);
                }
                Ok((_, error)) => {
                    step = duration * (0.9 / error.sqrt()).clamp(0.1, 0.7);
                    self.take_back();
                }
                Err(NoSolution) => {
                    step = 0.25 * duration;
                    self.failures += 1;
                    self.take_back();
                    if step < shortest || self.failures == MOST_FAILURES {
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
        let smooth = self.form.roughness == 0.0 && !self.form.is_plain();
        let touches = smooth && self.smallest_gap() <= TOUCHING * self.settings.clearance;
        self.state.copy_from(&self.before);
        self.arrive();
        if touches {
            return FilmError::Touches(eccentricity);
        }
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

    /// Computes the gap at an eccentricity.
    pub(super) fn move_to(&mut self, eps: Vector2<f64>) {
        self.gap.update(&self.cells, &self.form, eps);
    }

    /// The share of the step `change` from `eps` that leaves at least `rest` of the gap everywhere.
    pub(super) fn allowed(&self, eps: Vector2<f64>, change: Vector2<f64>, rest: f64) -> f64 {
        let mut share = self.gap.allowed(&self.cells, &self.form, change, rest);
        let limit = 1.0 - rest * (1.0 - eps.norm());
        while self.form.is_plain() && share > 1e-12 && (eps + change * share).norm() > limit {
            share *= 0.5;
        }
        share
    }

    /// The point towards `guess` that leaves at least half of the present gap.
    pub(super) fn reachable(&mut self, guess: Vector2<f64>) -> Vector2<f64> {
        let from = self.state.eps;
        if self.form.is_plain() && (guess - from).norm() <= 0.5 * (1.0 - from.norm()) {
            return guess;
        }
        self.move_to(from);
        from + (guess - from) * self.allowed(from, guess - from, 0.5)
    }

    /// Turns the surfaces.
    pub(super) fn turn(&mut self, duration: f64, drive: &Drive) {
        self.state.angles[0] += drive.journal_speed * duration;
        self.state.angles[1] += drive.bush_speed * duration;
        self.shape();
    }

    /// Computes the form error at the surfaces' angles.
    fn shape(&mut self) {
        let profile = &self.settings.profile;
        if profile.is_round() {
            return;
        }
        let angles = self.state.angles;
        let grid = &self.cells.grid;
        let at = |theta: f64| profile.opening(theta, angles) / self.settings.clearance;
        self.form.middle.clear();
        self.form.edge.clear();
        for i in 0..grid.columns() {
            self.form.middle.push(at(grid.theta_centre(i)));
            self.form.edge.push(at(grid.theta_edge(i)));
        }
    }

    /// Goes back to the state before the present internal step.
    fn take_back(&mut self) {
        self.state.copy_from(&self.kept);
        self.arrive();
    }

    /// Computes what follows from the state alone.
    fn arrive(&mut self) {
        self.linear.discard();
        self.shape();
        self.move_to(self.state.eps);
        self.liquid
            .compress(&self.settings, &self.state.field, self.state.unit);
        self.balance
            .weigh(&self.gap, &self.liquid, &self.state.field);
    }
}
