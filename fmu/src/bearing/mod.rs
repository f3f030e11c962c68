//! The bearing: film, asperity contact and friction of the journal in its bush.
//!
//! Frame: the origin is the bush's centre, x points along the load, y a quarter turn ahead of it in
//! the direction of positive shaft rotation. The journal's centre stands at `c*(ex, ey)` with the
//! radial clearance c and the eccentricity-ratio vector `(ex, ey)`. The attitude angle is the angle
//! from the load line to the eccentricity, positive in the direction of rotation.

pub mod contact;
pub mod friction;

use serde::{Deserialize, Serialize};

/// Which film model carries the load.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FilmModel {
    /// The mobility method on the map of our own Reynolds solutions.
    Mobility,
    /// The transient two-dimensional Reynolds equation with mass conservation.
    Reynolds,
}

/// The bearing's parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bearing {
    /// Radial clearance c, m.
    pub radial_clearance: f64,
    /// Width B, m.
    pub width: f64,
    /// Diameter D, m.
    pub diameter: f64,
    /// The film model.
    pub film: FilmModel,
    /// A csv file of the radial deviation of bush and shaft over the angle; empty for round ones.
    pub profile_file: String,
    /// The surfaces' asperities.
    pub surface: contact::Surface,
}

impl Default for Bearing {
    fn default() -> Self {
        Self {
            radial_clearance: 2.0e-5,
            width: 0.019,
            diameter: 0.025,
            film: FilmModel::Mobility,
            profile_file: String::new(),
            surface: contact::Surface::default(),
        }
    }
}

impl Bearing {
    /// Radius R, m.
    pub fn radius(&self) -> f64 {
        0.5 * self.diameter
    }

    /// Relative clearance psi = c/R, 1.
    pub fn relative_clearance(&self) -> f64 {
        self.radial_clearance / self.radius()
    }
}
