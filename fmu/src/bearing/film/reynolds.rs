//! The Reynolds film at work in the stand: it takes steps of its own and carries its journal along.

use crate::{
    Result,
    bearing::{
        friction::Boundary,
        journal::{
            Drift, FilmSetup, Flows, Interval, JournalFilm, Motion, Passed, Press, Situation, Strain, TransientFilm,
        },
        parameters::{Bearing, FilmEnergy, Resolution},
    },
};
use fmu_export::model::{Experiment, Fault};
use journal_bearing::{
    contact::ContactFamily,
    profile::Profile,
    reynolds::{
        Cavitation, Coefficients, Drive, FilmError, FilmSettings, FilmState, Grid, HeatExchange, PeriodicSearch,
        ReynoldsFilm, RoughFilm,
    },
};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The transient Reynolds film with the journal that floats in it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ReynoldsJournal {
    /// Clones share it until one of them takes a step.
    film: Arc<ReynoldsFilm>,
    /// The journal as the last interval left it.
    motion: Motion,
    /// Whether the bearing is round and aligned. Contact then comes from the table, else from the film's cells.
    plain: bool,
    /// The contact of a round, aligned journal; follows from the bearing's parameters.
    #[serde(skip)]
    contact: Arc<ContactFamily>,
    /// State, motion and clearance that [`keep`](TransientFilm::keep) remembers.
    #[serde(skip)]
    kept: Passing<(FilmState, Motion, f64)>,
    /// The search for the periodic orbit, while there is one.
    #[serde(skip)]
    search: Passing<PeriodicSearch>,
}

/// Something that matters within one step only, so that clones go without it: a host may save a state before every step.
#[derive(Debug)]
struct Passing<T>(Option<Box<T>>);

impl<T> Default for Passing<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> Clone for Passing<T> {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl JournalFilm for ReynoldsJournal {
    fn new(setup: &FilmSetup) -> Result<Self> {
        let (bearing, resolution) = (setup.bearing, &setup.bearing.resolution);
        if resolution.energy == FilmEnergy::Circumferential && !resolution.mass_conserving {
            return Err(Fault::Invalid(
                "bearing.filmEnergy = Circumferential: the oil carries the heat, so its mass must be conserved; set \
                 bearing.massConserving = true, or bearing.filmEnergy = Lumped"
                    .to_owned(),
            ));
        }
        let profile = read_profile(bearing, setup.experiment)?;
        let plain = profile.is_round() && resolution.tilt == [0.0; 2];
        let rough = bearing.surface.touches();
        let settings = FilmSettings {
            cavitation: if resolution.mass_conserving { Cavitation::MassConserving } else { Cavitation::NonNegative },
            side_pressure: resolution.bath_above_cavities(),
            cells: cells(bearing),
            rheology: setup.rheology,
            profile,
            tilt: resolution.tilt,
            feed: bearing.supply.in_film(),
            asperities: (rough && !plain).then(|| bearing.surface.clone()),
            roughness: if rough { bearing.surface.roughness } else { 0.0 },
            rough_film: if resolution.flow_factors {
                RoughFilm::FlowFactors { journal_share: resolution.journal_roughness_share }
            } else {
                RoughFilm::MeanGap
            },
            ..FilmSettings::new(bearing.width, bearing.diameter, setup.clearance)
        };
        let film = ReynoldsFilm::new(settings).map_err(|error| Fault::Invalid(message(&error)))?;
        let motion = Motion { min_film_thickness: film.smallest_gap(), ..Motion::default() };
        let mut film = Self {
            film: Arc::new(film),
            motion,
            plain,
            contact: Arc::default(),
            kept: Passing::default(),
            search: Passing::default(),
        };
        film.prepare(bearing)?;
        Ok(film)
    }

    fn prepare(&mut self, bearing: &Bearing) -> Result {
        self.contact =
            Arc::new(ContactFamily::new(&bearing.surface, bearing.radial_clearance, bearing.width, bearing.diameter));
        Ok(())
    }

    fn motion(&self, _: &Bearing, _: &Situation) -> Motion {
        self.motion
    }

    fn drift(&self, _: &Bearing, _: &Situation, _: bool, _: &mut Press) -> Drift {
        let Motion { velocity, torque, flows, .. } = self.motion;
        Drift { velocity, torque, flows }
    }

    fn strain(&self, bearing: &Bearing, at: &Situation, _: &Press) -> Strain {
        let Motion { contact, contact_reach, min_film_thickness, max_film_pressure, eccentricity_ratio, .. } =
            self.motion;
        let distance = match contact_reach {
            _ if self.plain => at.clearance * (1.0 - eccentricity_ratio),
            0.0 => min_film_thickness,
            crossed => -crossed * bearing.surface.roughness,
        };
        Strain { log_peak: 0.0, unit: [max_film_pressure, 1.0], contact, contact_reach, min_film_thickness, distance }
    }

    fn coefficients(&self, bearing: &Bearing, at: &Situation) -> Coefficients {
        let drive = Drive {
            contact_friction: bearing.contact_friction(at.sliding()),
            bush_speed: at.bush_speed,
            ..Drive::steady(at.load.into(), at.speed, at.viscosity)
        };
        let contact = self.plain.then_some(&*self.contact);
        self.film.coefficients(&drive, &|ratio| aligned(contact, ratio, at.clearance))
    }

    fn columns(&self) -> Option<usize> {
        Some(self.film.grid().columns())
    }

    fn hottest(&self) -> Option<f64> {
        self.film.temperatures().reduce(f64::max)
    }

    fn is_transient(&self) -> bool {
        true
    }

    fn transient(&mut self) -> Option<&mut dyn TransientFilm> {
        Some(self)
    }
}

impl TransientFilm for ReynoldsJournal {
    fn eccentricity(&self) -> [f64; 2] {
        self.film.eccentricity().into()
    }

    fn advance(&mut self, bearing: &Bearing, interval: &Interval, exchange: Option<&HeatExchange>) -> Result<Passed> {
        let Interval { duration, load, speed, bush_speed, clearance, viscosity } = *interval;
        let sliding = speed - bush_speed;
        self.widen(clearance)?;
        let friction = bearing.contact_friction(sliding);
        let drive = Drive {
            load_before: load[0].into(),
            load_after: load[1].into(),
            contact_friction: friction,
            bush_speed,
            ..Drive::steady(Vector2::zeros(), speed, viscosity)
        };
        let contact = self.plain.then_some(&*self.contact);
        let touching = |ratio: f64| aligned(contact, ratio, clearance);
        let film = Arc::make_mut(&mut self.film);
        let report = match exchange {
            Some(exchange) => film.advance_warm(duration, &drive, &touching, exchange),
            None => film.advance(duration, &drive, &touching),
        };
        let report = report.map_err(|error| Fault::Failed(message(&error)))?;

        let eccentricity = self.film.eccentricity();
        let ratio = eccentricity.norm();
        let mut touch = self.contact.at(ratio, clearance);
        if !self.plain {
            touch.normal = report.contact_normal;
            // Where nothing touches, the film's error of the load is all that is left.
            let carried = (drive.load_after - report.film_load).norm() / 1f64.hypot(friction);
            touch.force = if touch.normal > 0.0 { carried } else { 0.0 };
        }
        let velocity = report.velocity.into();
        let place = eccentricity.into();
        let boundary = Boundary::of(bearing, clearance, &touch, friction, sliding, place, velocity);
        self.motion = Motion {
            eccentricity_ratio: ratio,
            velocity,
            torque: report.journal_torque + boundary.torque,
            boundary_torque: boundary.torque,
            contact: touch,
            contact_reach: report.crossing,
            min_film_thickness: report.smallest_gap,
            max_film_pressure: report.max_pressure,
            flows: Flows {
                viscous: report.heat,
                boundary: boundary.heat,
                side_flow: report.outflow,
                feed: report.feed_flow,
            },
        };
        let flows = Flows {
            viscous: report.mean_heat,
            boundary: boundary.heat,
            side_flow: report.mean_outflow,
            feed: report.mean_feed_flow,
        };
        let temperature = exchange.and_then(|_| self.film.temperature());
        Ok(Passed { flows, steps: report.steps, warm: temperature.map(|temperature| (report.given, temperature)) })
    }

    fn seek_orbit(&mut self) {
        self.search = Passing(Some(Box::new(self.film.seek_orbit())));
    }

    fn end_turn(&mut self) -> f64 {
        let search = self.search.0.as_mut();
        let search = search.expect("a search has begun");
        Arc::make_mut(&mut self.film).end_turn(search)
    }

    fn keep(&mut self) {
        let clearance = self.film.settings().clearance;
        self.kept = Passing(Some(Box::new((self.film.state(), self.motion, clearance))));
    }

    fn take_back(&mut self) {
        let kept = self.kept.0.as_ref();
        let (state, motion, clearance) = kept.expect("a state was kept").as_ref();
        let film = Arc::make_mut(&mut self.film);
        let restored = film.restore(state);
        restored.and_then(|()| film.set_clearance(*clearance)).expect("state and clearance are this film's own");
        self.motion = *motion;
    }
}

impl ReynoldsJournal {
    /// Takes over the clearance of an interval, m.
    fn widen(&mut self, clearance: f64) -> Result {
        if clearance == self.film.settings().clearance {
            return Ok(());
        }
        Arc::make_mut(&mut self.film).set_clearance(clearance).map_err(|error| Fault::Failed(message(&error)))
    }
}

/// The force of a round, aligned journal's contact, N; other contact is that of the film's cells.
fn aligned(contact: Option<&ContactFamily>, ratio: f64, clearance: f64) -> f64 {
    contact.map_or(0.0, |contact| contact.at(ratio, clearance).force)
}

/// The form error of the file that `bearing.profileFile` names; round surfaces without one.
fn read_profile(bearing: &Bearing, experiment: &Experiment) -> Result<Profile> {
    match bearing.profile_file.as_str() {
        "" => Ok(Profile::default()),
        file => Profile::from_csv(&experiment.file(file))
            .map_err(|error| Fault::Invalid(format!("bearing.profileFile: {error}"))),
    }
}

/// Columns and rows: as asked for, or as many as the width needs.
fn cells(bearing: &Bearing) -> [usize; 2] {
    let Resolution { columns, rows, .. } = bearing.resolution;
    let enough = Grid::sufficient_cells(bearing.width / bearing.diameter);
    [0, 1].map(|k| match [columns, rows][k] {
        0 => enough[k],
        asked => asked.unsigned_abs() as usize,
    })
}

/// The film's error in the words of the stand's parameters.
fn message(error: &FilmError) -> String {
    match error {
        FilmError::Touches(ratio) => format!(
            "tilt or form error bring the smooth surfaces together at eccentricity ratio {ratio:?}, where no film carries the \
             load; give bearing.roughness, or reduce them"
        ),
        FilmError::Setting { name, value, must } if name.contains("feed") => {
            let variable = match *name {
                "feed angle" => "bearing.feedAngle",
                "feed extent" => "bearing.feedExtent",
                "feed length" => "bearing.feedLength",
                "feed pressure" => "bearing.feedPressure",
                _ => "bearing.feedCount",
            };
            format!("{variable} is {value:?} (SI units); it must be {must}")
        }
        error => error.to_string(),
    }
}
