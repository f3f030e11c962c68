//! The Reynolds film at work in the stand: the journal's motion is the film's own.

use super::{Bearing, Flows, Motion, friction};
use journal_bearing::contact::ContactTable;
use journal_bearing::profile::Profile;
use journal_bearing::reynolds::{
    Cavitation, Drive, FilmError, FilmSettings, Grid, ReynoldsFilm, RoughFilm,
};
use journal_bearing::rheology::Rheology;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// How the Reynolds film is solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Resolution {
    /// The oil's mass is conserved where the film ruptures; else pressures are only kept from falling below the bath's.
    pub mass_conserving: bool,
    /// Pressure of the oil bath above that of the cavities, Pa.
    pub side_pressure: f64,
    /// Columns of cells around the bush; 0 takes as many as the width needs.
    pub columns: i32,
    /// Rows of cells over half the width; 0 takes as many as the width needs.
    pub rows: i32,
    /// Displacement of the journal's end at `z = B/2` by its tilt, along and across the load, m.
    pub tilt: [f64; 2],
    /// The film sees the surfaces' roughness, also of a round and aligned bearing: mean gap and flow factors.
    pub flow_factors: bool,
    /// The journal's share of the composite roughness' variance, 1.
    pub journal_roughness_share: f64,
}

impl Default for Resolution {
    fn default() -> Self {
        Self {
            mass_conserving: true,
            side_pressure: 1e5,
            columns: 0,
            rows: 0,
            tilt: [0.0; 2],
            flow_factors: false,
            journal_roughness_share: 0.5,
        }
    }
}

/// A Reynolds film with the journal that floats in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResolvedFilm {
    film: ReynoldsFilm,
    motion: Motion,
    /// Round, aligned and without flow factors: contact comes from the table, else from the film's cells.
    plain: bool,
}

impl ResolvedFilm {
    /// A flooded film with the journal in the middle.
    pub fn new(bearing: &Bearing, rheology: Rheology, profile: Profile) -> Result<Self, FilmError> {
        let Resolution {
            mass_conserving,
            side_pressure,
            columns,
            rows,
            tilt,
            flow_factors,
            journal_roughness_share: journal_share,
        } = bearing.resolution;
        let plain = profile.is_round() && tilt == [0.0; 2] && !flow_factors;
        let enough = Grid::sufficient_cells(bearing.width / bearing.diameter);
        let rough = bearing.surface.roughness > 0.0;
        let settings = FilmSettings {
            cavitation: if mass_conserving {
                Cavitation::MassConserving
            } else {
                Cavitation::NonNegative
            },
            side_pressure,
            cells: [0, 1].map(|k| match [columns, rows][k] {
                0 => enough[k],
                asked => asked.unsigned_abs() as usize,
            }),
            rheology,
            profile,
            tilt,
            asperities: (rough && !plain).then(|| bearing.surface.clone()),
            rough_film: if flow_factors {
                RoughFilm::FlowFactors { journal_share }
            } else {
                RoughFilm::MeanGap
            },
            ..FilmSettings::new(bearing.width, bearing.diameter, bearing.radial_clearance)
        };
        let film = ReynoldsFilm::new(settings)?;
        let motion = Motion {
            min_film_thickness: film.smallest_gap(),
            ..Motion::default()
        };
        Ok(Self {
            film,
            motion,
            plain,
        })
    }

    /// The journal as the last interval left it.
    pub fn motion(&self) -> Motion {
        self.motion
    }

    /// The eccentricity-ratio vector in the middle plane.
    pub fn eccentricity(&self) -> [f64; 2] {
        self.film.eccentricity().into()
    }

    /// Lets `interval` seconds pass under a load along x (N, at its start and end), a shaft speed (rad/s) and a
    /// viscosity (Pa.s); the bush stands still. Returns the mean flows and the number of internal steps.
    pub fn advance(
        &mut self,
        bearing: &Bearing,
        contact: &ContactTable,
        interval: f64,
        load: [f64; 2],
        speed: f64,
        viscosity: f64,
    ) -> Result<(Flows, usize), FilmError> {
        let drive = Drive {
            load_before: Vector2::new(load[0], 0.0),
            load_after: Vector2::new(load[1], 0.0),
            ..Drive::steady(Vector2::zeros(), speed, viscosity)
        };
        let aligned = |ratio: f64| {
            if self.plain {
                contact.at(ratio).force
            } else {
                0.0
            }
        };
        let report = self.film.advance(interval, &drive, &aligned)?;

        let ratio = self.film.eccentricity().norm();
        let mut touch = contact.at(ratio);
        if !self.plain {
            touch.normal = report.contact_normal;
            touch.force = (Vector2::new(load[1], 0.0) - report.film_load).norm();
        }
        let boundary_torque = friction::boundary(bearing, touch.normal, speed);
        let boundary = boundary_torque * speed;
        self.motion = Motion {
            eccentricity_ratio: ratio,
            velocity: report.velocity.into(),
            torque: report.journal_torque + boundary_torque,
            boundary_torque,
            contact: touch,
            min_film_thickness: report.smallest_gap,
            max_film_pressure: report.max_pressure,
            flows: Flows {
                viscous: report.heat,
                boundary,
                side_flow: report.outflow,
            },
        };
        let flows = Flows {
            viscous: report.mean_heat,
            boundary,
            side_flow: report.mean_outflow,
        };
        Ok((flows, report.steps))
    }
}
