//! The journal in its film: the questions of the stand to a film model, and its answers.
//!
//! Film models are of two kinds. For most, the journal's velocity follows from the instant alone; the stand integrates it
//! together with the temperatures. A [`TransientFilm`] remembers how its oil is distributed; it takes steps of its own and
//! carries its journal along.

use crate::Result;
use fmu_export::model::Experiment;
use journal_bearing::{
    contact::Contact,
    reynolds::{Coefficients, HeatExchange, HeatGiven},
    rheology::Rheology,
};
use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::LOG2_E;

use super::parameters::Bearing;

/// Heat and oil flow of the film.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flows {
    /// Viscous friction heat, W.
    pub viscous: f64,
    /// Boundary friction heat of the asperities, W.
    pub boundary: f64,
    /// Oil that leaves the film at both ends, m³/s.
    pub side_flow: f64,
    /// Oil that enters through feeds, m³/s; negative where it leaves.
    pub feed: f64,
}

impl Flows {
    /// The whole friction heat, W.
    pub fn heat(&self) -> f64 {
        self.viscous + self.boundary
    }

    /// The flows times a factor.
    pub fn times(&self, factor: f64) -> Self {
        Self {
            viscous: self.viscous * factor,
            boundary: self.boundary * factor,
            side_flow: self.side_flow * factor,
            feed: self.feed * factor,
        }
    }

    /// The sum with other flows.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            viscous: self.viscous + other.viscous,
            boundary: self.boundary + other.boundary,
            side_flow: self.side_flow + other.side_flow,
            feed: self.feed + other.feed,
        }
    }

    /// The difference from other flows.
    pub fn minus(&self, other: &Self) -> Self {
        self.plus(&other.times(-1.0))
    }
}

/// The journal at one instant.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Motion {
    /// Eccentricity ratio, 1.
    pub eccentricity_ratio: f64,
    /// Rate of the eccentricity-ratio vector, 1/s.
    pub velocity: [f64; 2],
    /// Friction torque on the journal, N.m.
    pub torque: f64,
    /// The asperities' part of it, N.m.
    pub boundary_torque: f64,
    /// Forces of the touching asperities' pressure.
    pub contact: Contact,
    /// How far the mean planes of rough surfaces cross, over the roughness, 1; zero where they do not.
    pub contact_reach: f64,
    /// Smallest film thickness, m.
    pub min_film_thickness: f64,
    /// Largest film pressure, Pa.
    pub max_film_pressure: f64,
    /// Heat and oil flow.
    pub flows: Flows,
}

/// How film and asperities press at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Strain {
    /// Logarithm of the largest film pressure over its unit.
    pub log_peak: f64,
    /// That unit, as a force, N, and what it is multiplied by, 1/m².
    pub unit: [f64; 2],
    /// Forces of the touching asperities' pressure.
    pub contact: Contact,
    /// How far the mean planes cross, over the roughness, 1; zero where they do not.
    pub contact_reach: f64,
    /// Smallest film thickness, m.
    pub min_film_thickness: f64,
    /// The least distance of the mean planes, m, as far as the film knows it.
    pub distance: f64,
}

impl Strain {
    /// Largest film pressure, Pa.
    pub fn film_pressure(&self) -> f64 {
        let [force, per_area] = self.unit;
        if force > 0.0 { self.log_peak.exp() * force * per_area } else { 0.0 }
    }

    /// At least that, by the next power of two: it costs next to nothing.
    #[inline]
    pub fn most_film_pressure(&self) -> f64 {
        let exponent = 1024.0 + (self.log_peak * LOG2_E).clamp(-1000.0, 1000.0);
        f64::from_bits((exponent as u64) << 52) * self.unit[0] * self.unit[1]
    }
}

/// What of it is at hand in every stage of the time integration; the strain tells the rest.
#[derive(Clone, Copy, Debug, Default)]
pub struct Press {
    /// Logarithm of the largest film pressure over that of the film's force on the projected area.
    pub log_peak: f64,
    /// The film's force, N.
    pub force: f64,
    /// Forces of the touching asperities' pressure.
    pub contact: Contact,
    /// Eccentricity ratio.
    pub ratio: f64,
    /// Whether the asperities meet.
    pub touches: bool,
}

/// The rates of the journal and the temperatures at one instant, and the torque.
#[derive(Clone, Copy, Debug, Default)]
pub struct Drift {
    /// Rate of the eccentricity-ratio vector, 1/s.
    pub velocity: [f64; 2],
    /// Friction torque on the journal, N.m.
    pub torque: f64,
    /// Heat and oil flow.
    pub flows: Flows,
}

/// The parameters and files that a film starts from.
pub struct FilmSetup<'a> {
    /// The bearing.
    pub bearing: &'a Bearing,
    /// Radial clearance at the start, m.
    pub clearance: f64,
    /// The oil's laws over pressure and shear rate.
    pub rheology: Rheology,
    /// Where the files are that parameters name.
    pub experiment: &'a Experiment<'a>,
}

/// Load, position, clearance, oil and speeds at one instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Situation {
    /// Load along x and y, N.
    pub load: [f64; 2],
    /// Eccentricity-ratio vector, 1.
    pub eccentricity: [f64; 2],
    /// Radial clearance, m. Its own change is far too slow to squeeze oil.
    pub clearance: f64,
    /// Viscosity of the oil at ambient pressure and low shear, Pa.s.
    pub viscosity: f64,
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// Speed of the bush, rad/s.
    pub bush_speed: f64,
}

impl Situation {
    /// The speed of the shaft's surface against the bush's, rad/s: it shears the film and rubs.
    #[inline]
    pub fn sliding(&self) -> f64 {
        self.speed - self.bush_speed
    }

    /// The mean rotation, rad/s, which draws oil into the gap.
    #[inline]
    pub fn mean_rotation(&self) -> f64 {
        0.5 * (self.speed + self.bush_speed)
    }

    /// Magnitude of the load, N.
    pub fn load_magnitude(&self) -> f64 {
        Vector2::from(self.load).norm()
    }
}

/// A film model.
pub trait JournalFilm {
    /// The film of a bearing, with the journal in the middle.
    ///
    /// # Errors
    /// When a parameter or a file is not usable, or no such film exists.
    fn new(setup: &FilmSetup) -> Result<Self>
    where
        Self: Sized;

    /// Computes all that follows from the bearing's parameters alone: after a state was read back, or a parameter was
    /// changed.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    fn prepare(&mut self, bearing: &Bearing) -> Result;

    /// The journal's motion, with all that sensors read.
    fn motion(&self, bearing: &Bearing, at: &Situation) -> Motion;

    /// Only what the time integration needs, with what [`strain`](Self::strain) wants to know left in `press`. The side flow may be
    /// zero unless it is asked for.
    fn drift(&self, bearing: &Bearing, at: &Situation, side_flow: bool, press: &mut Press) -> Drift;

    /// How film and asperities press at an instant, of which `press` is known from [`drift`](Self::drift).
    fn strain(&self, bearing: &Bearing, at: &Situation, press: &Press) -> Strain;

    /// Stiffness, N/m, and damping, N.s/m, of film and contact about a journal that rests under a load, along x and y.
    ///
    /// Here from a velocity that follows from the instant alone, `de/dt = f(e, F)`, by differences: a force that keeps a displaced
    /// journal moving in some way is `dF = (df/dF)^-1 (dv - df/de de)`.
    fn coefficients(&self, bearing: &Bearing, at: &Situation) -> Coefficients {
        const NUDGE: f64 = 1e-6;
        let place = Vector2::from(at.eccentricity);
        let load = Vector2::from(at.load);
        let velocity = |place: Vector2<f64>, load: Vector2<f64>| {
            let at = Situation { eccentricity: place.into(), load: load.into(), ..*at };
            Vector2::from(self.drift(bearing, &at, false, &mut Press::default()).velocity)
        };
        let of_place = derivative(NUDGE, |by| velocity(place + by, load));
        let of_force = derivative(NUDGE * load.norm(), |by| velocity(place, load + by));
        let damping = of_force.try_inverse().unwrap_or_default() / at.clearance;
        Coefficients { stiffness: -damping * of_place, damping }
    }

    /// Columns of cells around the bearing, where the film has any.
    fn columns(&self) -> Option<usize> {
        None
    }

    /// The highest temperature around the bearing, K, where the film has more than one.
    fn hottest(&self) -> Option<f64> {
        None
    }

    /// Whether the film takes steps of its own.
    fn is_transient(&self) -> bool {
        false
    }

    /// The film as one that takes steps of its own, if it does.
    fn transient(&mut self) -> Option<&mut dyn TransientFilm> {
        None
    }
}

/// The derivative of a vector over a vector, by differences over a small step on both sides.
fn derivative(step: f64, of: impl Fn(Vector2<f64>) -> Vector2<f64>) -> Matrix2<f64> {
    let columns = [Vector2::x(), Vector2::y()].map(|towards| (of(towards * step) - of(towards * -step)) / (2.0 * step));
    Matrix2::from_columns(&columns)
}

/// An interval of a transient film. The load varies linearly, the rest is constant.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// Duration, s.
    pub duration: f64,
    /// Load along x and y, N, at its start and at its end.
    pub load: [[f64; 2]; 2],
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// Speed of the bush, rad/s.
    pub bush_speed: f64,
    /// Radial clearance, m.
    pub clearance: f64,
    /// Viscosity of the oil at ambient pressure and low shear, Pa.s.
    pub viscosity: f64,
}

/// What an interval has brought.
pub struct Passed {
    /// The mean flows over it.
    pub flows: Flows,
    /// The number of internal steps.
    pub steps: usize,
    /// Of a film with a temperature around the bearing: the heat that it gave away, and its mean temperature at the end, K.
    pub warm: Option<(HeatGiven, f64)>,
}

/// A film that takes steps of its own, and its journal with it.
pub trait TransientFilm {
    /// The eccentricity-ratio vector, 1.
    fn eccentricity(&self) -> [f64; 2];

    /// Lets an interval pass; with an `exchange` the film has a temperature around the bearing.
    ///
    /// # Errors
    /// When the film cannot be solved; it is then as before.
    fn advance(&mut self, bearing: &Bearing, interval: &Interval, exchange: Option<&HeatExchange>) -> Result<Passed>;

    /// Begins the search for the periodic orbit under a load that repeats itself: the first turn starts here.
    fn seek_orbit(&mut self);

    /// Ends a turn of the search, and moves journal and oil to where the next one should begin. Returns how far that is from
    /// where this turn began, as a share of the clearance and of its content.
    fn end_turn(&mut self) -> f64;

    /// Remembers the present state for [`take_back`](Self::take_back).
    fn keep(&mut self);

    /// Returns to the state that was kept.
    fn take_back(&mut self);
}
