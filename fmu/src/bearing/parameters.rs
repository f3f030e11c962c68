//! The bearing's parameters.

use super::{hot::Expansion, supply::Supply, wear::Wear};
use journal_bearing::contact::Surface;
use serde::{Deserialize, Serialize};

/// The bearing's parameters, apart from the choice of the [film model](super::FilmModel).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Bearing {
    /// Radial clearance as it was measured, m.
    pub radial_clearance: f64,
    /// Width B, m.
    pub width: f64,
    /// Diameter D, m.
    pub diameter: f64,
    /// A csv file of the radial deviation of bush and shaft over the angle; empty for round ones.
    pub profile_file: String,
    /// The surfaces' asperities.
    pub surface: Surface,
    /// How temperatures change the clearance.
    pub expansion: Expansion,
    /// How the surfaces wear.
    pub wear: Wear,
    /// The oil that is fed to a Reynolds film.
    pub supply: Supply,
    /// How a Reynolds film is solved.
    pub resolution: Resolution,
    /// Film pressure that is still taken for possible, Pa.
    pub pressure_limit: f64,
}

/// The temperatures of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum FilmEnergy {
    /// One.
    #[default]
    Lumped,
    /// One around the bearing.
    Circumferential,
}

/// How a Reynolds film is solved.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Resolution {
    /// Whether the oil's mass is conserved where the film ruptures. If not, pressures only stay above the bath's.
    pub mass_conserving: bool,
    /// Pressure of the oil bath above that of the cavities, Pa, where `cavity_pressure` does not say it.
    pub side_pressure: f64,
    /// Absolute pressure in the cavities, Pa; negative where it is not given.
    pub cavity_pressure: f64,
    /// Columns of cells around the bush; 0 takes as many as the width needs.
    pub columns: i32,
    /// Rows of cells over half the width; 0 takes as many as the width needs.
    pub rows: i32,
    /// Whether the film has one temperature, or one around the bearing.
    pub energy: FilmEnergy,
    /// Displacement of the journal's end at `z = B/2` by its tilt, along and across the load, m.
    pub tilt: [f64; 2],
    /// Whether the film sees the surfaces' roughness (mean gap and flow factors) when the bearing is round and aligned, too.
    pub flow_factors: bool,
    /// The journal's share of the composite roughness' variance, 1.
    pub journal_roughness_share: f64,
}

impl Default for Bearing {
    fn default() -> Self {
        Self {
            radial_clearance: 2.0e-5,
            width: 0.019,
            diameter: 0.025,
            profile_file: String::new(),
            surface: Surface::default(),
            expansion: Expansion::default(),
            wear: Wear::default(),
            supply: Supply::default(),
            resolution: Resolution::default(),
            pressure_limit: 2e8,
        }
    }
}

impl Default for Resolution {
    fn default() -> Self {
        Self {
            mass_conserving: true,
            side_pressure: 1e5,
            cavity_pressure: -1.0,
            columns: 0,
            rows: 0,
            energy: FilmEnergy::Lumped,
            tilt: [0.0; 2],
            flow_factors: false,
            journal_roughness_share: 0.5,
        }
    }
}

/// The standard atmosphere, Pa (ISO 2533:1975): the absolute pressure of the surroundings and so of the oil bath.
const ATMOSPHERE: f64 = 101_325.0;

impl Resolution {
    /// Pressure of the oil bath above that of the cavities, Pa.
    pub fn bath_above_cavities(&self) -> f64 {
        if self.cavity_pressure < 0.0 {
            return self.side_pressure;
        }
        (ATMOSPHERE - self.cavity_pressure).max(0.0)
    }
}

impl Bearing {
    /// Radius R, m.
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter
    }

    /// Friction coefficient of the touching asperities at a speed of the shaft against the bush, rad/s, with its sign. Zero between smooth surfaces.
    pub fn contact_friction(&self, speed: f64) -> f64 {
        if self.surface.roughness == 0.0 {
            return 0.0;
        }
        self.surface.friction(speed * self.radius())
    }

    /// Relative clearance psi = c/R, 1, as it was measured.
    pub fn relative_clearance(&self) -> f64 {
        self.radial_clearance / self.radius()
    }

    /// The clearance that expansion and wear leave at temperatures of bush and shaft (K) and a mean wear depth (m). It may be
    /// negative: then the shaft is larger than the bore.
    pub fn hot_clearance(&self, at: [f64; 2], worn: f64) -> f64 {
        let radii = [self.radius(), self.radius() - self.radial_clearance];
        self.radial_clearance + self.expansion.growth(radii, at) + worn
    }

    /// Rate of the mean wear depth, m/s, while the asperities turn `heat` watts into heat at a speed of the shaft against the bush, rad/s.
    #[inline]
    pub fn wear_rate(&self, heat: f64, speed: f64) -> f64 {
        if self.wear.coefficient == 0.0 {
            return 0.0;
        }
        let area = std::f64::consts::PI * self.diameter * self.width;
        self.wear.rate(heat, self.contact_friction(speed).abs(), area)
    }

    /// A clearance below this, m, counts as closed: the bearing seizes.
    pub fn closed_clearance(&self) -> f64 {
        const CLOSED: f64 = 0.01;
        CLOSED * self.radial_clearance
    }
}
