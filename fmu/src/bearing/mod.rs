//! The bearing: film, asperity contact and friction of the journal in its bush.
//!
//! Frame: the origin is the bush's centre, x points along the load, y a quarter turn ahead of it in
//! the direction of positive shaft rotation. The journal's centre stands at `c*(ex, ey)` with the
//! radial clearance c and the eccentricity-ratio vector `(ex, ey)`. The attitude angle is the angle
//! from the load line to the eccentricity, positive in the direction of rotation.

pub mod friction;
pub mod resolved;

use journal_bearing::contact::{self, Contact, ContactTable};
use journal_bearing::mobility::{LookUp, MapError, MobilityMap, MobilitySlice, SliceFamily};
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
    scales: Scales,
    /// None before the bearing is prepared.
    film: Option<MobilitySlice>,
}

/// Factors of the dimensionless quantities.
#[derive(Clone, Copy, Debug, Default)]
struct Scales {
    /// `psi^2/(B*D)`, 1/m²: the mobility's, times force over viscosity.
    mobility: f64,
    /// `c^3/(3*B^2)`, m: the side flow's, times force over viscosity.
    side_flow: f64,
    /// `1/(B*D)`, 1/m²: the largest pressure's, times force.
    pressure: f64,
    /// The concentric journal's Couette torque over viscosity and speed, m³; the others' goes as `1/sqrt(1 - e^2)`.
    couette: f64,
}

impl Scales {
    fn new(bearing: &Bearing) -> Self {
        let Bearing {
            radial_clearance: c,
            width,
            diameter,
            ..
        } = *bearing;
        Self {
            mobility: bearing.relative_clearance().powi(2) / (width * diameter),
            side_flow: c.powi(3) / (3.0 * width * width),
            pressure: 1.0 / (width * diameter),
            couette: friction::couette(bearing, 0.0),
        }
    }
}

/// The journal's motion with the film and the contact that make it.
struct Instant<'a> {
    /// None without a load on the film.
    film: Option<LookUp<'a>>,
    /// The film's share of the load, N.
    force: f64,
    contact: Contact,
    couette: f64,
    boundary_torque: f64,
    velocity: [f64; 2],
    flows: Flows,
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
            scales: Scales::new(bearing),
            film: Some(map.slice(bearing.width / bearing.diameter)),
        })
    }

    /// The journal at an eccentricity-ratio vector, under a load along x (N), at a film viscosity (Pa.s)
    /// and a shaft speed (rad/s); the bush stands still.
    pub fn motion(
        &self,
        bearing: &Bearing,
        load: f64,
        eccentricity: [f64; 2],
        viscosity: f64,
        speed: f64,
    ) -> Motion {
        let [x, y] = eccentricity;
        let ratio = x.hypot(y).min(LARGEST_ECCENTRICITY_RATIO);
        let clearance = bearing.radial_clearance;
        let at = self.instant(bearing, load, eccentricity, viscosity, speed, true);
        let poiseuille = friction::poiseuille(clearance, [load, 0.0], eccentricity);
        let pressure = at.film.map_or(0.0, |film| film.max_pressure());
        Motion {
            eccentricity_ratio: ratio,
            velocity: at.velocity,
            torque: at.couette + poiseuille + at.boundary_torque,
            boundary_torque: at.boundary_torque,
            contact: at.contact,
            min_film_thickness: clearance * (1.0 - ratio),
            max_film_pressure: pressure * at.force * self.scales.pressure,
            flows: at.flows,
        }
    }

    /// Only what moves the journal and the temperatures: the rate of the eccentricity-ratio vector, 1/s,
    /// and the flows; the side flow where it is asked for, else zero.
    #[inline]
    pub fn drift(
        &self,
        bearing: &Bearing,
        load: f64,
        eccentricity: [f64; 2],
        viscosity: f64,
        speed: f64,
        side_flow: bool,
    ) -> ([f64; 2], Flows) {
        let at = self.instant(bearing, load, eccentricity, viscosity, speed, side_flow);
        (at.velocity, at.flows)
    }

    /// Eq. 2 of the paper (Booker 1965, J. Basic Eng. 87, 537-546): the film's share F of the load moves
    /// the journal at `|F|*psi^2/(eta*B*D) * M`, in a frame that turns with the mean speed of journal and
    /// bush. The paper's omega must be that mean: half the shaft speed.
    #[inline(always)]
    fn instant(
        &self,
        bearing: &Bearing,
        load: f64,
        eccentricity: [f64; 2],
        viscosity: f64,
        speed: f64,
        side_flow: bool,
    ) -> Instant<'_> {
        let e = Vector2::from(eccentricity);
        let length = e.norm();
        let ratio = length.min(LARGEST_ECCENTRICITY_RATIO);
        let contact = self.contact.at(ratio);
        let (mut force, mut direction) = (Vector2::new(load, 0.0), Vector2::x());
        let mut magnitude = load;
        // Without contact, which is cheaper, the force is the load.
        if load < 0.0 || contact.force > 0.0 {
            if length > 0.0 {
                force -= e * (contact.force / length);
            }
            magnitude = force.norm();
            direction = force / magnitude;
        }
        let scales = &self.scales;
        let (mut squeeze, mut leaving) = (Vector2::zeros(), 0.0);
        let film = self.film.as_ref().filter(|_| magnitude > 0.0);
        let film = film.map(|film| film.look_up(e, length, direction));
        if let Some(film) = &film {
            let driven = magnitude / viscosity;
            squeeze = film.mobility() * (driven * scales.mobility);
            if side_flow {
                leaving = film.side_flow() * driven * scales.side_flow;
            }
        }
        let couette = viscosity * speed * scales.couette / (1.0 - ratio * ratio).sqrt();
        let boundary_torque = if contact.normal > 0.0 {
            friction::boundary(bearing, contact.normal, speed)
        } else {
            0.0
        };
        Instant {
            film,
            force: magnitude,
            contact,
            couette,
            boundary_torque,
            velocity: [squeeze.x - 0.5 * speed * e.y, squeeze.y + 0.5 * speed * e.x],
            // Of the film's whole dissipation M*omega + F*de/dt, the terms with the mean rotation cancel.
            flows: Flows {
                viscous: couette * speed + bearing.radial_clearance * force.dot(&squeeze),
                boundary: boundary_torque * speed,
                side_flow: leaving,
            },
        }
    }

    /// The contact of the aligned, round journal.
    pub fn contact(&self) -> &ContactTable {
        &self.contact
    }
}
