//! The mobility film: the journal's velocity follows from the load at the instant.

use crate::bearing::{
    friction::{self, Boundary},
    journal::{Drift, FilmSetup, Flows, JournalFilm, Motion, Press, Situation, Strain},
    parameters::{Bearing, FilmEnergy},
};
use fmu_export::model::Fault;
use journal_bearing::{
    contact::{Contact, ContactAt, ContactFamily, Touch},
    mobility::{LookUp, MapError, MobilityMap, MobilitySlice, RoughAt, RoughSlices, SliceFamily},
    reynolds::mean_gap,
};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, LazyLock};

/// Largest eccentricity ratio between smooth surfaces: the journal never reaches the bush.
const LARGEST_ECCENTRICITY_RATIO: f64 = 1.0 - 1e-9;

/// The map that ships with the library, prepared once.
static MAP: LazyLock<Result<SliceFamily, MapError>> =
    LazyLock::new(|| MobilityMap::built_in().map(|map| SliceFamily::new(&map)));

/// The Sommerfeld number of ISO 7902 under which a journal rests at an eccentricity ratio in a smooth bearing of this `B/D`.
pub fn sommerfeld(width_to_diameter: f64, eccentricity_ratio: f64) -> f64 {
    MAP.as_ref().map_or(0.0, |map| map.slice(width_to_diameter).sommerfeld(eccentricity_ratio))
}

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
    contact: ContactFamily,
    factors: Factors,
    /// `None` before the bearing is prepared.
    slice: Option<MobilitySlice>,
    /// The film where the asperities touch; `None` between smooth surfaces.
    rough: Option<RoughSlices>,
}

/// The film at one clearance.
pub struct AtClearance<'a> {
    prepared: &'a Prepared,
    contact: ContactAt<'a>,
    rough: Option<RoughAt<'a>>,
}

/// Contact and film where the asperities touch.
struct Touching<'a> {
    touch: Touch,
    rough: Option<RoughAt<'a>>,
}

/// Factors of the dimensionless quantities, at the clearance as it was measured.
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
    /// The same over the film's shear.
    shear: f64,
}

impl Factors {
    fn new(bearing: &Bearing) -> Self {
        let Bearing { radial_clearance: c, width, diameter, .. } = *bearing;
        Self {
            mobility: bearing.relative_clearance().powi(2) / (width * diameter),
            side_flow: c.powi(3) / (3.0 * width * width),
            pressure: 1.0 / (width * diameter),
            couette: friction::couette(bearing, 0.0),
            shear: friction::couette(bearing, 0.0) / std::f64::consts::TAU,
        }
    }
}

/// The journal's motion under the part of the load that contact and friction leave to the film.
struct Push {
    /// `None` without a load on the film.
    film: Option<LookUp>,
    /// The film's share of the load, N, and its magnitude.
    force: Vector2<f64>,
    magnitude: f64,
    /// The velocity in the frame that turns with the mean speed, and in the fixed one, 1/s.
    squeeze: Vector2<f64>,
    velocity: [f64; 2],
    boundary: Boundary,
}

/// The journal's motion with the film and the contact that cause it.
struct Instant {
    push: Push,
    /// Eccentricity ratio.
    ratio: f64,
    /// Whether the asperities meet.
    touches: bool,
    contact: Contact,
    couette: f64,
    flows: Flows,
}

impl JournalFilm for MobilityFilm {
    fn new(setup: &FilmSetup) -> Result<Self, Fault> {
        setup.bearing.supply.refuse()?;
        if setup.bearing.resolution.energy == FilmEnergy::Circumferential {
            return Err(Fault::Invalid(
                "bearing.filmEnergy = Circumferential: the mobility film has one viscosity; set bearing.film = Reynolds, or \
                 bearing.filmEnergy = Lumped"
                    .to_owned(),
            ));
        }
        let mut film = Self::default();
        film.prepare(setup.bearing)?;
        Ok(film)
    }

    fn prepare(&mut self, bearing: &Bearing) -> Result<(), Fault> {
        let map = MAP.as_ref().map_err(|error| Fault::Failed(error.to_string()))?;
        let width_to_diameter = bearing.width / bearing.diameter;
        // Variables have limits; the bytes of a saved state may hold anything.
        if width_to_diameter.is_nan() || width_to_diameter <= 0.0 {
            return Err(Fault::Invalid(format!(
                "the bearing's width and diameter must be positive, and are {:?} m and {:?} m",
                bearing.width, bearing.diameter
            )));
        }
        let slice = map.slice(width_to_diameter);
        let roughness = bearing.surface.roughness;
        let rough = bearing
            .surface
            .touches()
            .then(|| RoughSlices::new(&slice, width_to_diameter, roughness, bearing.radial_clearance));
        let rough = rough.transpose();
        self.prepared = Arc::new(Prepared {
            contact: ContactFamily::new(&bearing.surface, bearing.radial_clearance, bearing.width, bearing.diameter),
            factors: Factors::new(bearing),
            slice: Some(slice),
            rough: rough.map_err(|error| Fault::Failed(error.to_string()))?,
        });
        Ok(())
    }

    fn motion(&self, bearing: &Bearing, at: &Situation) -> Motion {
        let mut now = self.prepared.instant(bearing, at, true, None);
        if !now.touches {
            let [x, y] = at.eccentricity;
            now.ratio = x.hypot(y).min(LARGEST_ECCENTRICITY_RATIO);
        }
        let push = &now.push;
        let strain = self.strain(bearing, at, &now.press());
        Motion {
            eccentricity_ratio: now.ratio,
            velocity: push.velocity,
            torque: now.torque(at),
            boundary_torque: push.boundary.torque,
            contact: now.contact,
            contact_reach: strain.contact_reach,
            min_film_thickness: strain.min_film_thickness,
            max_film_pressure: strain.film_pressure(),
            flows: now.flows,
        }
    }

    #[inline]
    fn strain(&self, bearing: &Bearing, at: &Situation, press: &Press) -> Strain {
        let &Press { log_peak, force, contact, ratio, touches } = press;
        let roughness = bearing.surface.roughness;
        let distance = at.clearance * (1.0 - ratio);
        let (contact_reach, gap) = if touches {
            let crossed = (at.clearance * (ratio - 1.0) / roughness).max(0.0);
            (crossed, mean_gap(distance / roughness) * roughness)
        } else {
            (0.0, distance)
        };
        Strain {
            log_peak,
            unit: [force, self.prepared.factors.pressure],
            contact,
            contact_reach,
            min_film_thickness: gap,
            distance,
        }
    }

    #[inline]
    fn drift(&self, bearing: &Bearing, at: &Situation, side_flow: bool, press: &mut Press) -> Drift {
        let now = self.prepared.instant(bearing, at, side_flow, None);
        now.drift(at, press)
    }
}

impl MobilityFilm {
    /// The film at a clearance, m, for many instants.
    pub fn at_clearance(&self, clearance: f64) -> AtClearance<'_> {
        let prepared = &*self.prepared;
        let rough = prepared.rough.as_ref();
        AtClearance {
            prepared,
            contact: prepared.contact.with_clearance(clearance),
            rough: rough.map(|rough| rough.with_clearance(clearance)),
        }
    }
}

impl AtClearance<'_> {
    /// [`JournalFilm::drift`] at an instant of this clearance.
    #[inline]
    pub fn drift(&self, bearing: &Bearing, at: &Situation, side_flow: bool, press: &mut Press) -> Drift {
        let now = self.prepared.instant(bearing, at, side_flow, Some(self));
        now.drift(at, press)
    }
}

impl Instant {
    /// How film and asperities press.
    #[inline(always)]
    fn press(&self) -> Press {
        let Push { film, magnitude, .. } = &self.push;
        let (log_peak, force) = film.as_ref().map_or((0.0, 0.0), |film| (film.log_max_pressure(), *magnitude));
        Press { log_peak, force, contact: self.contact, ratio: self.ratio, touches: self.touches }
    }

    /// What the time integration needs.
    #[inline(always)]
    fn drift(&self, at: &Situation, press: &mut Press) -> Drift {
        *press = self.press();
        Drift { velocity: self.push.velocity, torque: self.torque(at), flows: self.flows }
    }

    /// Friction torque on the journal, N.m.
    #[inline(always)]
    fn torque(&self, at: &Situation) -> f64 {
        let film = self.push.force.into();
        let poiseuille = friction::poiseuille(at.clearance, film, at.eccentricity);
        self.couette + poiseuille + self.push.boundary.torque
    }
}

impl Prepared {
    /// The journal at an instant, with the film at its clearance where that is known; the side flow where it is asked for.
    #[inline(always)]
    fn instant<'a>(
        &'a self,
        bearing: &Bearing,
        at: &Situation,
        side_flow: bool,
        known: Option<&AtClearance<'a>>,
    ) -> Instant {
        let Situation { viscosity, clearance, .. } = *at;
        let sliding = at.sliding();
        // The clearance as a multiple of the measured one.
        let wider = clearance / bearing.radial_clearance;
        let e = Vector2::from(at.eccentricity);
        let length = e.norm();
        let touch = match known {
            Some(film) => film.contact.touch(length).map(|touch| Touching { touch, rough: film.rough }),
            None => (self.contact.touch(length, clearance)).map(|touch| Touching {
                touch,
                rough: (self.rough.as_ref()).map(|rough| rough.with_clearance(clearance)),
            }),
        };
        let ratio = match touch {
            None => length.min(LARGEST_ECCENTRICITY_RATIO),
            Some(_) => length,
        };
        let push = self.rub(bearing, at, (e, length), touch.as_ref());
        let leaving = match &push.film {
            Some(film) if side_flow => {
                let factor = self.factors.side_flow * wider * wider * wider;
                film.side_flow() * (push.magnitude / viscosity) * factor
            }
            _ => 0.0,
        };
        let couette = match &touch {
            None => {
                let factor = self.factors.couette / wider;
                viscosity * sliding * factor / (1.0 - ratio * ratio).sqrt()
            }
            Some(now) => viscosity * sliding * (self.factors.shear / wider) * now.touch.shear,
        };
        let squeezed = clearance * push.force.dot(&push.squeeze);
        Instant {
            // In the film's whole dissipation, sum of M*omega of journal and bush + F*de/dt, the terms with the mean rotation cancel.
            flows: Flows {
                viscous: couette * sliding + squeezed,
                boundary: push.boundary.heat,
                side_flow: leaving,
                feed: 0.0,
            },
            push,
            ratio,
            touches: touch.is_some(),
            contact: touch.map_or_else(Contact::default, |now| now.touch.contact),
            couette,
        }
    }

    /// The journal's motion with the friction of its contact.
    ///
    /// Friction has the shaft's direction, unless the journal itself moves along the bush faster than the shaft turns, which
    /// happens next to standstill only. There friction takes the direction of the sliding, or, where it would turn that
    /// round, the value between that makes the contact stick. So it never drives the journal.
    #[inline(always)]
    fn rub(&self, bearing: &Bearing, at: &Situation, place: (Vector2<f64>, f64), touch: Option<&Touching>) -> Push {
        let friction = match touch {
            Some(now) if now.touch.contact.normal > 0.0 => bearing.contact_friction(at.sliding()),
            _ => 0.0,
        };
        let push = self.push(bearing, at, place, touch, friction);
        if push.boundary.heat >= 0.0 {
            return push;
        }
        let friction =
            Self::stick(friction.abs(), |friction| self.push(bearing, at, place, touch, friction).boundary.sliding);
        let mut push = self.push(bearing, at, place, touch, friction);
        push.boundary.heat = push.boundary.heat.max(0.0);
        push
    }

    /// The friction coefficient of at most `most` in either direction at which nothing slides, or the nearest to it. The sliding falls
    /// as friction grows; where it vanishes is found by the Illinois method (Dowell & Jarratt 1971, BIT 11, 168-174).
    #[cold]
    fn stick(most: f64, sliding: impl Fn(f64) -> f64) -> f64 {
        const TRIALS: usize = 50;
        const CLOSE: f64 = 1e-12;
        let (mut low, mut high) = (-most, most);
        let (mut ahead, mut back) = (sliding(low), sliding(high));
        if ahead <= 0.0 {
            return low;
        }
        if back >= 0.0 {
            return high;
        }
        let close = CLOSE * (ahead - back);
        let (mut friction, mut last) = (0.0, 0.0);
        for _ in 0..TRIALS {
            friction = low + (high - low) * ahead / (ahead - back);
            let slides = sliding(friction);
            if slides.abs() <= close {
                break;
            }
            let again = slides * last > 0.0;
            if slides > 0.0 {
                (low, ahead) = (friction, slides);
                back *= if again { 0.5 } else { 1.0 };
            } else {
                (high, back) = (friction, slides);
                ahead *= if again { 0.5 } else { 1.0 };
            }
            last = slides;
        }
        friction
    }

    /// Booker's equation (1965, J. Basic Eng. 87, 537-546; eq. 2 of the paper). The film's share F of the load is what
    /// contact and friction leave. It moves the journal at `|F|*psi^2/(eta*B*D) * M` in a frame that turns with the mean
    /// speed of journal and bush. The paper's omega must be that mean.
    #[inline(always)]
    fn push(
        &self,
        bearing: &Bearing,
        at: &Situation,
        (e, length): (Vector2<f64>, f64),
        touch: Option<&Touching>,
        friction: f64,
    ) -> Push {
        let (load, rotation) = (at.load, at.mean_rotation());
        let contact = touch.map_or_else(Contact::default, |now| now.touch.contact);
        let [along, across] = load;
        let (mut force, mut direction) = (Vector2::new(along, across), Vector2::x());
        let mut magnitude = along;
        // A force along x saves the root.
        if along < 0.0 || across != 0.0 || contact.force > 0.0 {
            if length > 0.0 {
                let touched = e + Vector2::new(-e.y, e.x) * friction;
                force -= touched * (contact.force / length);
            }
            magnitude = force.norm();
            direction = force / magnitude;
        }
        let film = match (&self.slice, touch) {
            (Some(_), Some(Touching { touch, rough: Some(rough) })) if magnitude > 0.0 => {
                Some(rough.look_up(e, length, touch, direction))
            }
            (Some(slice), _) if magnitude > 0.0 => Some(slice.look_up(e, length, direction)),
            _ => None,
        };
        let wider = at.clearance / bearing.radial_clearance;
        let driven = magnitude / at.viscosity * (self.factors.mobility * wider * wider);
        let squeeze = film.as_ref().map_or(Vector2::zeros(), |film| film.mobility() * driven);
        let velocity = [squeeze.x - rotation * e.y, squeeze.y + rotation * e.x];
        let place = at.eccentricity;
        let clearance = at.clearance;
        let boundary = Boundary::of(bearing, clearance, &contact, friction, at.sliding(), place, velocity);
        Push { film, force, magnitude, squeeze, velocity, boundary }
    }
}
