//! The bearing as its film sees it, what drives it, and why a film cannot go on.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::asperities::Asperities;
use super::cells::Cavitation;
use super::grid::Grid;
use super::roughness::RoughFilm;
use crate::profile::Profile;
use crate::rheology::{DensityLaw, Rheology};

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
    /// The oil's laws over pressure and shear rate.
    pub rheology: Rheology,
    /// Radial deviations of bush and journal.
    pub profile: Profile,
    /// The journal's tilt against the bush's axis, as the displacement of its end at `z = B/2`, m.
    pub tilt: [f64; 2],
    /// Asperity contact cell by cell; none: it comes from the `contact` of
    /// [`ReynoldsFilm::advance`](super::ReynoldsFilm::advance).
    pub asperities: Option<Asperities>,
    /// What the film sees of the roughness of `asperities`.
    pub rough_film: RoughFilm,
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
            rough_film: RoughFilm::Nominal,
        }
    }

    /// Checks the numbers' ranges.
    pub(super) fn check(&self) -> Result<(), FilmError> {
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

    /// Roughness over clearance, where the film sees it; else zero.
    pub(super) fn film_roughness(&self) -> f64 {
        match (&self.asperities, self.rough_film) {
            (None, _) | (_, RoughFilm::Nominal) => 0.0,
            (Some(Asperities(surface)), _) => surface.roughness / self.clearance,
        }
    }

    /// Whether the oil's density depends on its pressure.
    pub(super) fn is_compressible(&self) -> bool {
        self.rheology.density != DensityLaw::Constant
    }

    /// Whether the film has flow factors: the journal's share of the roughness' variance.
    pub(super) fn flow_factors(&self) -> Option<f64> {
        match self.rough_film {
            RoughFilm::FlowFactors { journal_share } if self.film_roughness() > 0.0 => {
                Some(journal_share)
            }
            _ => None,
        }
    }

    /// The load that a dimensionless load of one stands for at a viscosity (Pa.s), N.
    pub(super) fn force_scale(&self, viscosity: f64) -> f64 {
        let radius = 0.5 * self.diameter;
        12.0 * viscosity * radius.powi(3) * self.width / self.clearance.powi(2)
    }

    /// The pressure that a dimensionless pressure of one stands for at a viscosity (Pa.s), Pa.
    pub(super) fn pressure_scale(&self, viscosity: f64) -> f64 {
        12.0 * viscosity * (0.5 * self.diameter / self.clearance).powi(2)
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

    /// The load after a share (0..1) of the interval, N.
    pub(super) fn load_at(&self, share: f64) -> Vector2<f64> {
        self.load_before + (self.load_after - self.load_before) * share
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
    /// Tilt or form error bring smooth surfaces together under the load.
    #[error(
        "tilt or form error bring the smooth surfaces together at eccentricity ratio {0}, where no film carries the load; give bearing.roughness, or reduce them"
    )]
    Touches(f64),
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
