//! The transient film over intervals of controlled error.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::{
    diagnostics::Diagnostics,
    periodic::PeriodicSearch,
    stage::NoSolution,
    state::State,
    step::{Step, Stepper},
    warmth::HeatExchange,
    workspace::Workspace,
};
use crate::reynolds::{
    error::{FilmError, positive, within},
    grid::Grid,
    settings::{Drive, FilmSettings},
};

/// The film between journal and bush by the transient Reynolds equation in two dimensions, with its journal.
///
/// The journal has no inertia here: film, contact and external load balance at every instant. Time is integrated with the
/// two-stage, stiffly accurate SDIRK method of order two (Alexander 1977, SIAM J. Numer. Anal. 14, 1006-1021). Each stage is
/// an implicit Euler step, which keeps contents within their bounds and lets the journal approach the bush at any step
/// size. The step of order one inside the method controls the error.
///
/// Serialisation stores settings and state; a film that is read back continues bit for bit.
///
/// # Examples
/// A journal that comes to rest under a steady load:
/// ```
/// use journal_bearing::nalgebra::Vector2;
/// use journal_bearing::reynolds::{Drive, FilmSettings, ReynoldsFilm};
///
/// // Width, diameter and radial clearance in m; 750 N, 300 rpm, 20 mPa.s.
/// let mut film = ReynoldsFilm::new(FilmSettings::new(0.019, 0.025, 20e-6))?;
/// let drive = Drive::steady(Vector2::new(750.0, 0.0), 31.416, 0.02);
/// let report = film.advance(1.5, &drive, &|_| 0.0)?;
/// assert!((film.eccentricity().norm() - 0.89).abs() < 0.01);
/// assert!((report.film_load - drive.load_after).norm() < 1e-3); // N
/// assert!(report.mass_error < 1e-10);
/// # Ok::<(), journal_bearing::reynolds::FilmError>(())
/// ```
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct ReynoldsFilm {
    pub(super) work: Workspace,
    stepper: Stepper,
    /// The state before the present interval.
    before: State,
}

/// A film's state apart from the film: all that changes with time. See [`ReynoldsFilm::state`].
#[derive(Clone, Debug)]
pub struct FilmState(State);

/// A film as it is stored.
#[derive(Serialize, Deserialize)]
struct Saved {
    settings: FilmSettings,
    state: State,
}

impl From<ReynoldsFilm> for Saved {
    fn from(film: ReynoldsFilm) -> Self {
        Self { settings: film.work.geometry.settings.clone(), state: film.work.state.clone() }
    }
}

impl TryFrom<Saved> for ReynoldsFilm {
    type Error = FilmError;

    fn try_from(saved: Saved) -> Result<Self, FilmError> {
        let mut film = Self::new(saved.settings)?;
        film.restore(&FilmState(saved.state))?;
        Ok(film)
    }
}

/// Most internal steps, taken or not, in one interval. Ordinary intervals need a few; a journal that slides around an
/// emptied bush needs some thousands.
const MOST_TRIES: usize = 20_000;
/// The shortest interval, s: its internal steps and their reciprocals must be ordinary numbers.
const LEAST_INTERVAL: f64 = 1e-250;
/// Most internal steps without a solution in one interval.
const MOST_FAILURES: usize = 500;

impl ReynoldsFilm {
    /// A flooded film with the journal in the middle.
    ///
    /// # Errors
    /// Returns [`FilmError::Setting`] when a setting is out of range, and [`FilmError::NoGap`] when form error and tilt leave
    /// no gap.
    pub fn new(settings: FilmSettings) -> Result<Self, FilmError> {
        let work = Workspace::new(settings)?;
        Ok(Self { stepper: Stepper::new(&work), before: work.state.clone(), work })
    }

    /// Puts the journal at an eccentricity ratio and floods the film.
    ///
    /// # Errors
    /// Returns [`FilmError::NoGap`] when the surfaces leave no gap there.
    pub fn place(&mut self, eps: Vector2<f64>) -> Result<(), FilmError> {
        self.work.place(eps)
    }

    /// Gives the bearing another radial clearance, m, as it changes with temperature or wear. Eccentricity ratio and content
    /// stay as they are: the clearance should change little between two intervals, since the squeeze of its own change is
    /// not in the film.
    ///
    /// # Errors
    /// Returns [`FilmError::Setting`] for a clearance that is not positive, and [`FilmError::NoGap`] when form error and tilt
    /// leave no gap; the film is then as before.
    pub fn set_clearance(&mut self, clearance: f64) -> Result<(), FilmError> {
        positive("clearance", clearance)?;
        self.work.set_clearance(clearance)
    }

    /// The settings.
    pub fn settings(&self) -> &FilmSettings {
        &self.work.geometry.settings
    }

    /// The eccentricity-ratio vector in the middle plane, 1.
    pub fn eccentricity(&self) -> Vector2<f64> {
        self.work.state.eps
    }

    /// The share of the gap that oil fills, 0..1, in a column (around the bush) and a row (over the width) of
    /// [`grid`](Self::grid).
    ///
    /// # Panics
    /// When the grid has no such cell.
    pub fn content(&self, column: usize, row: usize) -> f64 {
        self.work.state.field.content[column * self.work.geometry.cells.stride + row]
    }

    /// The grid. It covers the half width, or the whole width of a tilted journal.
    pub fn grid(&self) -> &Grid {
        &self.work.geometry.cells.grid
    }

    /// The smallest gap, m; where the film sees the surfaces' roughness, the smallest mean gap.
    pub fn smallest_gap(&self) -> f64 {
        self.work.geometry.smallest_gap(self.eccentricity())
    }

    /// A copy of the state, for [`restore`](Self::restore). It is far smaller than a clone of the film.
    pub fn state(&self) -> FilmState {
        FilmState(self.work.state.clone())
    }

    /// Returns to a state of this film, or of one with the same settings.
    ///
    /// # Errors
    /// Returns [`FilmError::Setting`] when the state has another number of cells; the film is then as before.
    pub fn restore(&mut self, state: &FilmState) -> Result<(), FilmError> {
        let FilmState(state) = state;
        if !state.field.fits(self.work.geometry.cells.count()) {
            let (name, value) = ("number of stored cells", state.field.full.len());
            let value = value as f64;
            let must = "that of this film";
            return Err(FilmError::Setting { name, value, must });
        }
        self.work.restore(state);
        Ok(())
    }

    /// Begins the search for the periodic orbit of a load that repeats itself: the first turn starts here.
    pub fn seek_orbit(&self) -> PeriodicSearch {
        PeriodicSearch::new(&self.work.state)
    }

    /// Ends a turn of a search, and moves the film to where the next one should begin. Returns how far that is from where this
    /// turn began: the change of eccentricity ratio and content, root of the sum of both mean squares, 1. It is next to zero on
    /// the orbit. Mass is not conserved when the film is moved.
    pub fn end_turn(&mut self, search: &mut PeriodicSearch) -> f64 {
        let (start, moved) = search.next(&self.work.state);
        self.work.restore(start);
        moved
    }

    /// Lets `interval` seconds pass under `drive`, in internal steps of controlled error.
    ///
    /// `contact` gives the force (N) with which asperities push an aligned journal back, over the eccentricity ratio; it is
    /// not used with [`FilmSettings::asperities`].
    ///
    /// # Errors
    /// Returns [`FilmError::Setting`] when the interval is shorter than 1e-250 s, the viscosity is not positive or another number
    /// is not finite, [`FilmError::Touches`] when smooth surfaces meet and [`FilmError::NotConverged`] when no internal step finds a
    /// solution. The film is then as before.
    pub fn advance(
        &mut self,
        interval: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
    ) -> Result<Diagnostics, FilmError> {
        self.pass(interval, drive, contact, None)
    }

    /// The same with a temperature of the film around the bearing, which oil, friction and the surfaces change: its viscosity is
    /// that of each column's temperature, relative to the drive's.
    ///
    /// # Errors
    /// As for [`advance`](Self::advance), and [`FilmError::Setting`] where the oil's mass is not conserved: then its heat is not.
    pub fn advance_warm(
        &mut self,
        interval: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
        exchange: &HeatExchange,
    ) -> Result<Diagnostics, FilmError> {
        let conserves = self.work.geometry.cells.conserves_mass();
        let must = "one that conserves the oil's mass where the film has a temperature around the bearing";
        within("cavitation condition", f64::NAN, conserves, must)?;
        self.pass(interval, drive, contact, Some(exchange))
    }

    /// The film's temperature, K: the mean of its oil's. `None` before [`advance_warm`](Self::advance_warm).
    pub fn temperature(&self) -> Option<f64> {
        self.work.temperature()
    }

    /// The temperature of each column, K; none before [`advance_warm`](Self::advance_warm).
    pub fn temperatures(&self) -> impl Iterator<Item = f64> + '_ {
        self.work.state.warm.iter().map(|warm| warm.temperature)
    }

    fn pass(
        &mut self,
        interval: f64,
        drive: &Drive,
        contact: &dyn Fn(f64) -> f64,
        exchange: Option<&HeatExchange>,
    ) -> Result<Diagnostics, FilmError> {
        let usable = interval.is_finite() && interval >= LEAST_INTERVAL;
        within("interval", interval, usable, "at least 1e-250 s")?;
        drive.check()?;
        self.before.copy_from(&self.work.state);
        // The linearisation is not stored, so an interval must not begin with that of the last one.
        self.work.linear.discard();
        self.stepper.failures = 0;
        let mut total = Diagnostics::default();
        let mut done = 0.0;
        let shortest = 1e-9 * interval;
        let mut step = self.work.state.step.unwrap_or(interval).min(interval);
        for tries in 0.. {
            if interval - done <= shortest {
                break;
            }
            if tries == MOST_TRIES {
                return Err(self.give_up(step));
            }
            let left = interval - done;
            // Half of the rest at most, so that no sliver of a step remains.
            let duration = if step < left { step.clamp(shortest, 0.5 * left) } else { left };
            let duration = self.work.geometry.resolve_turning(duration, drive);
            let place = Step { from: done / interval, share: duration / interval, duration };
            let stepped = (self.stepper).step(&mut self.work, place, drive, contact, exchange);
            match stepped {
                Ok((report, error)) if error <= 2.0 || duration <= shortest => {
                    done += duration;
                    let fitting = duration * (0.9 / error.max(1e-6).sqrt()).clamp(0.3, 2.5);
                    // A step cut short by the interval's end is no reason for shorter ones.
                    step = if duration < step { step.max(fitting) } else { fitting };
                    total.add(report, duration);
                }
                Ok((_, error)) => {
                    step = duration * (0.9 / error.sqrt()).clamp(0.1, 0.7);
                    self.work.restore(&self.stepper.kept);
                }
                Err(NoSolution) => {
                    step = 0.25 * duration;
                    self.work.restore(&self.stepper.kept);
                    if step < shortest || self.stepper.failures == MOST_FAILURES {
                        return Err(self.give_up(step));
                    }
                }
            }
        }
        self.work.state.step = Some(step);
        Ok(total.over(done))
    }

    /// Goes back to the state before the interval. Returns why.
    fn give_up(&mut self, step: f64) -> FilmError {
        let eps = self.eccentricity();
        let touches = self.work.geometry.touches(eps);
        self.work.restore(&self.before);
        let eccentricity = eps.norm();
        if touches {
            return FilmError::Touches(eccentricity);
        }
        FilmError::NotConverged { eccentricity, step }
    }
}
