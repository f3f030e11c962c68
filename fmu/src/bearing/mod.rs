//! The bearing: film, asperity contact and friction of the journal in its bush.
//!
//! Frame: the origin is the bush's centre, x points along the load, y a quarter turn ahead of it in
//! the direction of positive shaft rotation. The journal's centre stands at `c*(ex, ey)` with the
//! radial clearance c and the eccentricity-ratio vector `(ex, ey)`. The attitude angle is the angle
//! from the load line to the eccentricity, positive in the direction of rotation.

pub mod contact;
pub mod friction;
pub mod mobility;
pub mod profile;
pub mod resolved;
pub mod reynolds;

use contact::{Contact, ContactTable};
use mobility::{MapError, MobilityMap, MobilitySlice, SliceFamily};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

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
    /// How the Reynolds film is solved.
    pub resolution: resolved::Resolution,
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
            resolution: resolved::Resolution::default(),
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

/// What the film takes in, per unit of time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flows {
    /// Viscous friction heat, W.
    pub viscous: f64,
    /// Boundary friction heat of the asperities, W.
    pub boundary: f64,
    /// Oil that leaves the film at both ends, m³/s.
    pub side_flow: f64,
}

/// The journal at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// Eccentricity ratio, 1.
    pub eccentricity_ratio: f64,
    /// Rate of the eccentricity-ratio vector, 1/s.
    pub velocity: [f64; 2],
    /// Friction torque on the journal, N.m.
    pub torque: f64,
    /// The asperities' part of it, N.m.
    pub boundary_torque: f64,
    /// What the asperities carry.
    pub contact: Contact,
    /// Smallest film thickness, m.
    pub min_film_thickness: f64,
    /// Largest film pressure, Pa.
    pub max_film_pressure: f64,
    /// Heat and side flow.
    pub flows: Flows,
}

/// What follows from a bearing's parameters, prepared once.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    contact: ContactTable,
    /// None before the bearing is prepared.
    film: Option<MobilitySlice>,
}

/// The journal never reaches the bush: beyond this ratio the film is computed as at it.
const LARGEST_ECCENTRICITY_RATIO: f64 = 1.0 - 1e-9;

/// The map as it was shipped; prepared once.
static MAP: LazyLock<Result<SliceFamily, MapError>> =
    LazyLock::new(|| MobilityMap::built_in().map(|map| SliceFamily::new(&map)));

impl Prepared {
    /// Prepares a bearing.
    pub fn new(bearing: &Bearing) -> Result<Self, MapError> {
        let map = MAP.as_ref().map_err(MapError::clone)?;
        Ok(Self {
            contact: ContactTable::new(
                &bearing.surface,
                bearing.radial_clearance,
                bearing.width,
                bearing.diameter,
            ),
            film: Some(map.slice(bearing.width / bearing.diameter)),
        })
    }

    /// The journal at an eccentricity-ratio vector, under a load along x (N), at a film viscosity (Pa.s)
    /// and a shaft speed (rad/s); the bush stands still.
    ///
    /// Eq. 2 of the paper (Booker 1965, J. Basic Eng. 87, 537-546): the film's share F of the load moves
    /// the journal at `|F|*psi^2/(eta*B*D) * M`, in a frame that turns with the mean speed of journal and
    /// bush. The paper's omega must be that mean: half the shaft speed.
    pub fn motion(
        &self,
        bearing: &Bearing,
        load: f64,
        eccentricity: [f64; 2],
        viscosity: f64,
        speed: f64,
    ) -> Motion {
        let Bearing {
            radial_clearance: c,
            width,
            diameter,
            ..
        } = *bearing;
        let e = Vector2::from(eccentricity);
        let length = e.norm();
        let ratio = length.min(LARGEST_ECCENTRICITY_RATIO);
        let contact = self.contact.at(ratio);
        let mut force = Vector2::new(load, 0.0);
        if length > 0.0 {
            force -= e * (contact.force / length);
        }

        let (mut squeeze, mut side_flow, mut max_film_pressure) = (Vector2::zeros(), 0.0, 0.0);
        let magnitude = force.norm();
        if let Some(film) = self.film.as_ref().filter(|_| magnitude > 0.0) {
            let direction = force / magnitude;
            let psi = bearing.relative_clearance();
            let film = film.film(e, direction);
            squeeze = film.mobility * (magnitude * psi * psi / (viscosity * width * diameter));
            side_flow =
                film.side_flow() * magnitude * c.powi(3) / (3.0 * viscosity * width * width);
            max_film_pressure = film.max_pressure() * magnitude / (width * diameter);
        }
        let couette = viscosity * speed * friction::couette(bearing, ratio);
        let poiseuille = friction::poiseuille(c, [load, 0.0], eccentricity);
        let boundary_torque = friction::boundary(bearing, contact.normal, speed);
        Motion {
            eccentricity_ratio: ratio,
            velocity: [squeeze.x - 0.5 * speed * e.y, squeeze.y + 0.5 * speed * e.x],
            torque: couette + poiseuille + boundary_torque,
            boundary_torque,
            contact,
            min_film_thickness: c * (1.0 - ratio),
            max_film_pressure,
            // Of the film's whole dissipation M*omega + F*de/dt, the terms with the mean rotation cancel.
            flows: Flows {
                viscous: couette * speed + c * force.dot(&squeeze),
                boundary: boundary_torque * speed,
                side_flow,
            },
        }
    }

    /// The contact of the aligned, round journal.
    pub fn contact(&self) -> &ContactTable {
        &self.contact
    }
}
