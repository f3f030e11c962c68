//! The mobility film: the journal's velocity follows from the load at the instant.

use crate::bearing::friction;
use crate::bearing::journal::{Drift, Flows, JournalFilm, Motion, Setup, Situation};
use crate::bearing::parameters::Bearing;
use fmu_export::model::Fault;
use journal_bearing::contact::{Contact, ContactTable};
use journal_bearing::mobility::{LookUp, MapError, MobilityMap, MobilitySlice, SliceFamily};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, LazyLock};

/// Largest eccentricity ratio at which contact and friction are computed: the journal never reaches the bush.
const LARGEST_ECCENTRICITY_RATIO: f64 = 1.0 - 1e-9;

/// The map that ships with the library, prepared once.
static MAP: LazyLock<Result<SliceFamily, MapError>> =
    LazyLock::new(|| MobilityMap::built_in().map(|map| SliceFamily::new(&map)));

/// The mobility method on the map of Reynolds solutions.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct MobilityFilm {
    /// Follows from the bearing's parameters; clones share it.
    #[serde(skip)]
    prepared: Arc<Prepared>,
}

/// All that follows from the bearing's parameters.
#[derive(Debug, Default)]
struct Prepared {
    contact: ContactTable,
    factors: Factors,
    /// `None` before the bearing is prepared.
    slice: Option<MobilitySlice>,
}

/// Factors of the dimensionless quantities.
#[derive(Clone, Copy, Debug, Default)]
struct Factors {
    /// `psi^2/(B*D)`, 1/m²: of the mobility, times force over viscosity.
    mobility: f64,
    /// `c^3/(3*B^2)`, m: of the side flow, times force over viscosity.
    side_flow: f64,
    /// `1/(B*D)`, 1/m²: of the largest pressure, times force.
    pressure: f64,
    /// Couette torque of a concentric journal over viscosity and speed, m³; it goes with `1/sqrt(1 - e^2)`.
    couette: f64,
}

impl Factors {
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

/// The journal's motion with the film and the contact that cause it.
struct Instant<'a> {
    /// `None` without a load on the film.
    film: Option<LookUp<'a>>,
    /// The film's share of the load, N.
    force: f64,
    contact: Contact,
    couette: f64,
    boundary_torque: f64,
    velocity: [f64; 2],
    flows: Flows,
}

impl JournalFilm for MobilityFilm {
    fn new(setup: &Setup<'_>) -> Result<Self, Fault> {
        let mut film = Self::default();
        film.prepare(setup.bearing)?;
        Ok(film)
    }

    fn prepare(&mut self, bearing: &Bearing) -> Result<(), Fault> {
        let map = MAP
            .as_ref()
            .map_err(|error| Fault::Failed(error.to_string()))?;
        self.prepared = Arc::new(Prepared {
            contact: ContactTable::new(
                &bearing.surface,
                bearing.radial_clearance,
                bearing.width,
                bearing.diameter,
            ),
            factors: Factors::new(bearing),
            slice: Some(map.slice(bearing.width / bearing.diameter)),
        });
        Ok(())
    }

    fn motion(&self, bearing: &Bearing, at: &Situation) -> Motion {
        let [x, y] = at.eccentricity;
        let ratio = x.hypot(y).min(LARGEST_ECCENTRICITY_RATIO);
        let clearance = bearing.radial_clearance;
        let now = self.prepared.instant(bearing, at, true);
        let pressure = now.film.map_or(0.0, |film| film.max_pressure());
        Motion {
            eccentricity_ratio: ratio,
            velocity: now.velocity,
            torque: now.torque(bearing, at),
            boundary_torque: now.boundary_torque,
            contact: now.contact,
            min_film_thickness: clearance * (1.0 - ratio),
            max_film_pressure: pressure * now.force * self.prepared.factors.pressure,
            flows: now.flows,
        }
    }

    #[inline]
    fn drift(&self, bearing: &Bearing, at: &Situation, side_flow: bool) -> Drift {
        let now = self.prepared.instant(bearing, at, side_flow);
        Drift {
            velocity: now.velocity,
            torque: now.torque(bearing, at),
            flows: now.flows,
        }
    }
}

impl Instant<'_> {
    /// Friction torque on the journal, N.m.
    #[inline(always)]
    fn torque(&self, bearing: &Bearing, at: &Situation) -> f64 {
        let clearance = bearing.radial_clearance;
        let poiseuille = friction::poiseuille(clearance, [at.load, 0.0], at.eccentricity);
        self.couette + poiseuille + self.boundary_torque
    }
}

impl Prepared {
    /// Booker's equation (1965, J. Basic Eng. 87, 537-546; eq. 2 of the paper). The film's share F of the load moves the
    /// journal at `|F|*psi^2/(eta*B*D) * M` in a frame that turns with the mean speed of journal and bush. The paper's omega
    /// must be that mean: half the shaft speed.
    #[inline(always)]
    fn instant(&self, bearing: &Bearing, at: &Situation, side_flow: bool) -> Instant<'_> {
        let Situation {
            load,
            eccentricity,
            viscosity,
            speed,
        } = *at;
        let e = Vector2::from(eccentricity);
        let length = e.norm();
        let ratio = length.min(LARGEST_ECCENTRICITY_RATIO);
        let contact = self.contact.at(ratio);
        let (mut force, mut direction) = (Vector2::new(load, 0.0), Vector2::x());
        let mut magnitude = load;
        // Without contact the force is the load, which saves the root.
        if load < 0.0 || contact.force > 0.0 {
            if length > 0.0 {
                force -= e * (contact.force / length);
            }
            magnitude = force.norm();
            direction = force / magnitude;
        }
        let factors = &self.factors;
        let (mut squeeze, mut leaving) = (Vector2::zeros(), 0.0);
        let slice = self.slice.as_ref().filter(|_| magnitude > 0.0);
        let film = slice.map(|slice| slice.look_up(e, length, direction));
        if let Some(film) = &film {
            let driven = magnitude / viscosity;
            squeeze = film.mobility() * (driven * factors.mobility);
            if side_flow {
                leaving = film.side_flow() * driven * factors.side_flow;
            }
        }
        let couette = viscosity * speed * factors.couette / (1.0 - ratio * ratio).sqrt();
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
            // In the film's whole dissipation M*omega + F*de/dt, the terms with the mean rotation cancel.
            flows: Flows {
                viscous: couette * speed + bearing.radial_clearance * force.dot(&squeeze),
                boundary: boundary_torque * speed,
                side_flow: leaving,
            },
        }
    }
}
