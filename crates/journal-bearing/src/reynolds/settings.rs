//! The bearing as its film sees it, the loads and speeds that act on it, and the errors of a film.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::{
    error::{FilmError, finite, positive, within},
    feed::Feed,
    grid::Grid,
};

use crate::{
    contact::Surface,
    profile::Profile,
    rheology::{DensityLaw, Rheology},
    roughness::RoughFilm,
};

/// Cavitation condition: how the film treats regions where it ruptures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cavitation {
    /// The oil's mass is conserved: the film reforms only where enough oil has flowed in (Jakobsson & Floberg 1957,
    /// Olsson 1965).
    #[default]
    MassConserving,
    /// Only `p >= 0` holds: oil is available wherever the pressure can rise.
    NonNegative,
}

/// The bearing as the film sees it, and how the film is to be solved.
///
/// # Examples
/// ```
/// use journal_bearing::reynolds::{Cavitation, FilmSettings};
///
/// let settings = FilmSettings {
///     cavitation: Cavitation::NonNegative,
///     tilt: [2e-6, 0.0],
///     ..FilmSettings::new(0.019, 0.025, 20e-6)
/// };
/// assert_eq!(settings.cells, [96, 8]);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FilmSettings {
    /// Width B, m.
    pub width: f64,
    /// Diameter D, m.
    pub diameter: f64,
    /// Radial clearance c, m.
    pub clearance: f64,
    /// Cavitation condition.
    pub cavitation: Cavitation,
    /// Pressure of the oil bath above that of the cavities, Pa, at least 0. It presses oil back in at the ends.
    /// Only [`Cavitation::MassConserving`] uses it; otherwise the cavities have the pressure of the bath.
    pub side_pressure: f64,
    /// Columns around the bush (at least 4) and rows over half the width (at least 1).
    pub cells: [usize; 2],
    /// Largest error of the eccentricity ratio in one internal step, as a share of the smallest gap, 1.
    pub tolerance: f64,
    /// The oil's laws over pressure and shear rate.
    pub rheology: Rheology,
    /// Radial deviations of bush and journal.
    pub profile: Profile,
    /// Tilt of the journal against the bush's axis: displacement of its end at `z = B/2` along x and y, m.
    pub tilt: [f64; 2],
    /// Surfaces whose asperity contact is evaluated in each cell, for journals that are tilted or not round. With `None`,
    /// contact comes from the `contact` argument of [`ReynoldsFilm::advance`](super::ReynoldsFilm::advance).
    pub asperities: Option<Surface>,
    /// Composite rms roughness that the film of a round, aligned journal sees, m, where `asperities` does not say it.
    pub roughness: f64,
    /// How the film sees the roughness.
    pub rough_film: RoughFilm,
    /// Feeds in the bush. Without them the oil comes from the bath alone.
    pub feed: Option<Feed>,
}

impl FilmSettings {
    /// A round, aligned bearing of this width, diameter and radial clearance (m) with the default film: mass-conserving,
    /// as many cells as its width needs, an oil bath 1 bar above the cavities.
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
            roughness: 0.0,
            rough_film: RoughFilm::Nominal,
            feed: None,
        }
    }

    /// Refuses numbers that are out of range.
    pub(super) fn check(&self) -> Result<(), FilmError> {
        positive("width", self.width)?;
        positive("diameter", self.diameter)?;
        positive("clearance", self.clearance)?;
        positive("tolerance", self.tolerance)?;
        finite("tilt", self.tilt[0])?;
        finite("tilt", self.tilt[1])?;
        let [columns, rows] = self.cells;
        within("number of columns", columns as f64, columns >= 4, "at least 4")?;
        within("number of rows", rows as f64, rows >= 1, "at least 1")?;
        let pressure = self.side_pressure;
        let usable = pressure.is_finite() && pressure >= 0.0;
        within("side pressure", pressure, usable, "0 or more")?;
        (self.feed.iter()).try_for_each(|feed| feed.check(self.width, self.bath_above_cavities()))
    }

    /// The bath's pressure above that of the cavities, Pa.
    fn bath_above_cavities(&self) -> f64 {
        match self.cavitation {
            Cavitation::MassConserving => self.side_pressure,
            Cavitation::NonNegative => 0.0,
        }
    }

    /// Pressures of the bath and of the feeds above that of the cavities, in units of the dimensionless pressure, 1/s.
    ///
    /// Feeds stand at least a little above the cavities, so that their oil can follow the film: some 60 Pa at the rig.
    pub(super) fn reservoirs(&self, drive: &Drive) -> [f64; 2] {
        const LEAST: f64 = 2e-5;
        let bath = self.bath_above_cavities();
        let feed = self.feed.as_ref().map_or(0.0, |feed| feed.pressure);
        let [bath, feed] = [bath, bath + feed].map(|pressure| pressure / self.pressure_scale(drive.viscosity));
        [bath, feed.max(LEAST * drive.rotation().abs())]
    }

    /// Roughness over clearance where the film sees the roughness, else zero.
    pub(super) fn film_roughness(&self) -> f64 {
        let surface = self.asperities.as_ref();
        match self.rough_film {
            RoughFilm::Nominal => 0.0,
            _ => surface.map_or(self.roughness, |surface| surface.roughness) / self.clearance,
        }
    }

    /// Whether the oil's density depends on its pressure.
    pub(super) fn is_compressible(&self) -> bool {
        self.rheology.density_law != DensityLaw::Constant
    }

    /// The journal's share of the roughness' variance where the film has flow factors, else `None`.
    pub(super) fn flow_factors(&self) -> Option<f64> {
        match self.rough_film {
            RoughFilm::FlowFactors { journal_share } if self.film_roughness() > 0.0 => Some(journal_share),
            _ => None,
        }
    }

    /// Force per unit of dimensionless load `W` at a viscosity (Pa.s), N.s.
    pub(super) fn force_scale(&self, viscosity: f64) -> f64 {
        let radius = 0.5 * self.diameter;
        12.0 * viscosity * radius.powi(3) * self.width / self.clearance.powi(2)
    }

    /// Pressure per unit of dimensionless pressure `P` at a viscosity (Pa.s), Pa.s.
    pub(super) fn pressure_scale(&self, viscosity: f64) -> f64 {
        12.0 * viscosity * (0.5 * self.diameter / self.clearance).powi(2)
    }
}

/// Loads, speeds and viscosity during an interval. The load varies linearly in time, the rest is constant.
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
    /// Viscosity of the oil at ambient pressure and low shear, Pa.s.
    pub viscosity: f64,
    /// Friction coefficient of the touching asperities, 1: positive where the journal slides ahead of the bush. Their
    /// friction pushes the journal against its sliding.
    pub contact_friction: f64,
}

impl Drive {
    /// A constant load (N) on a journal that turns in a resting bush (rad/s), in oil of a viscosity (Pa.s).
    /// Its asperities touch without friction.
    pub fn steady(load: Vector2<f64>, journal_speed: f64, viscosity: f64) -> Self {
        Self { load_before: load, load_after: load, journal_speed, bush_speed: 0.0, viscosity, contact_friction: 0.0 }
    }

    /// Refuses numbers that are out of range.
    pub(super) fn check(&self) -> Result<(), FilmError> {
        positive("viscosity", self.viscosity)?;
        for load in [self.load_before, self.load_after] {
            finite("load", load.x)?;
            finite("load", load.y)?;
        }
        finite("speed of the journal", self.journal_speed)?;
        finite("speed of the bush", self.bush_speed)?;
        finite("contact friction", self.contact_friction)
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
