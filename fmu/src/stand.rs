//! The stand: the blocks wired as in Fig. 3 of the paper.
//!
//! ```text
//!             speed                 load
//!   drive ────────────► load ───────────────► bearing ──► friction heat ──► thermal
//!     │     angle      mechanism             film + contact                   │
//!     └──────────────────────────────────────►   ▲                            │
//!                                                └───── oil ◄─ temperatures ◄─┘
//! ```
//!
//! The unknowns of the time integration are the journal's eccentricity-ratio vector, the four temperatures and the wear depth.
//! The shaft angle is not one of them: it follows from the speed in closed form.

mod clearance;
mod cycle;
mod exchange;
mod film_leap;
mod inputs;
mod march;
mod operation;
mod remembered;
mod resting;
mod scout;
mod slowest;
pub mod steady;
mod stiff;
mod stuck;
pub mod validity;

use crate::{
    Result,
    bearing::{Bearing, Drift, Film, FilmSetup, Flows, Situation},
    drive::{Command, Drive},
    load::Load,
    multirate::Departure,
    oil::{Nearby, Oil, Properties},
    sensors::{self, Readings, Sensed, TurnMeans},
    thermal::{Heat, Temperatures, Thermal},
};
use fmu_export::model::{self, Exchange, Experiment, Fault, Info, Log, Model, Variable};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

pub use inputs::{Input, Inputs};
pub use operation::{Operation, Permitted};
use remembered::Remembered;
use std::sync::OnceLock;
use validity::{Passing, SeenByLimits};

/// The parameters of the time integration.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solver {
    /// Relative tolerance per internal step, 1.
    pub tolerance: f64,
    /// Whether communication steps much longer than a turn leap over whole turns.
    pub multirate: bool,
}

impl Default for Solver {
    fn default() -> Self {
        Self { tolerance: 1e-6, multirate: true }
    }
}

/// The stand's state between two steps.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct State {
    /// Time, s.
    time: f64,
    /// Shaft angle since the start, rad.
    angle: f64,
    /// Eccentricity-ratio vector in the load frame, 1.
    eccentricity: [f64; 2],
    /// The same as a host that integrates it has set it.
    stretched: Option<Vector2<f64>>,
    /// The nodes' temperatures, K.
    temperatures: Temperatures,
    /// Mean wear depth, m.
    worn: f64,
    /// The internal step to try next, s.
    next_step: f64,
    /// The sensors' means over the last turn.
    means: TurnMeans,
    /// Whether the log has told that the journal does not rest.
    moves: bool,
    /// The limits that have been passed.
    validity: i32,
}

impl State {
    /// The same as the place where a leap begins.
    fn departure(&self) -> Departure {
        Departure::at(self.eccentricity, self.temperatures, self.worn)
    }
}

/// The plain-bearing test stand.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Stand {
    /// The drive.
    pub drive: Drive,
    /// The load mechanism.
    pub load: Load,
    /// The bearing.
    pub bearing: Bearing,
    /// Its film.
    pub film: Film,
    /// The oil.
    pub oil: Oil,
    /// The heat transfer.
    pub thermal: Thermal,
    /// The time integration.
    pub solver: Solver,
    /// What the check by ISO 7902 permits.
    pub permitted: Permitted,
    /// The inputs.
    pub inputs: Inputs,
    /// The coefficients of the oil's laws. They are kept as they may come from a file, which is read only at the start.
    pub fluid: Properties,
    /// The oil's viscosity around the film's temperature.
    #[serde(skip)]
    nearby: Nearby,
    state: State,
    readings: Readings,
    /// The outputs' time derivatives, as [`differentiate`](Model::differentiate) last computed them.
    #[serde(skip)]
    rates: Readings,
    /// Oil that feeds bring besides what the film says, m³/s: where a film that knows no feeds stands for one that does.
    #[serde(skip)]
    assumed_feed: f64,
    /// The limits that this step has passed, until the log tells them.
    #[serde(skip)]
    passed: Passing,
    #[serde(skip)]
    arrival: Remembered<Option<march::Arrival>>,
    #[serde(skip)]
    slowest: Remembered<slowest::Last>,
    /// The linearised film at the present communication point, once a host has asked for it.
    #[serde(skip)]
    resting: Remembered<OnceLock<resting::Resting>>,
    /// The check by ISO 7902, likewise.
    #[serde(skip)]
    operation: Remembered<OnceLock<Operation>>,
}

/// The unknowns: eccentricity ratio along x and y, temperatures of film, bush, shaft and oil, wear depth.
pub type Unknowns = [f64; 7];

/// The error of each unknown that a relative tolerance of one allows: the whole clearance, 100 K, 10 um.
pub const SCALES: Unknowns = [1.0, 1.0, 100.0, 100.0, 100.0, 100.0, 1e-5];

/// The log category for the set-up and the steps.
const EVENTS: &str = "logEvents";

/// The first internal step to try, s.
const FIRST_STEP: f64 = 1e-4;

impl Stand {
    /// The outputs at the present communication point.
    pub fn readings(&self) -> &Readings {
        &self.readings
    }

    /// The sensors' means over the last whole turn of the load; until one is complete, since the start.
    pub fn means(&self) -> Sensed {
        let so_far = self.state.means.means();
        so_far.unwrap_or_else(|| self.readings.sensed())
    }

    /// The time derivatives of the outputs, per second, as [`differentiate`](Model::differentiate) has computed them.
    pub fn rates(&self) -> &Readings {
        &self.rates
    }

    /// The time derivatives of the outputs at the present communication point, per second: differences over a short
    /// step of a copy.
    fn differences(&self) -> Result<Readings> {
        const AHEAD: f64 = 1e-6;
        let mut ahead = self.clone();
        let mut later = || {
            ahead.check_inputs_after(AHEAD)?;
            ahead.resolve(AHEAD)?;
            Ok::<_, Fault>(ahead.read(0.0, &unknowns(&ahead.state)))
        };
        // A transient film's flows depend on the length of its last step, so two steps of the same length are compared.
        let begin = if self.film.is_transient() { later()? } else { self.readings };
        Ok(begin.rates_to(&later()?, AHEAD))
    }

    /// The friction heat that goes into film, bush and shaft at the present communication point, W.
    pub fn heat(&self) -> f64 {
        let at = self.situation(0.0, &unknowns(&self.state));
        self.film.motion(&self.bearing, &at).flows.heat()
    }

    /// The upper half of Fig. 3 up to the film, `tau` seconds into the step: what drive, load mechanism and oil give it.
    fn situation(&self, tau: f64, y: &Unknowns) -> Situation {
        let temperatures = temperatures(y);
        let viscosity = self.fluid.viscosity(temperatures.film);
        let clearance = self.clearance(&temperatures, worn(y));
        let mut seen = SeenByLimits::default();
        self.instant(tau, [y[0], y[1]], viscosity, clearance, &mut seen);
        seen.at
    }

    /// The part of the motion that the time integration needs.
    pub fn drift(
        &self,
        tau: f64,
        eccentricity: [f64; 2],
        viscosity: f64,
        clearance: f64,
        seen: &mut SeenByLimits,
    ) -> Drift {
        self.instant(tau, eccentricity, viscosity, clearance, seen);
        self.film.drift(&self.bearing, &seen.at, self.feels_side_flow(), &mut seen.press)
    }

    /// Whether the temperatures follow from the side flow.
    fn feels_side_flow(&self) -> bool {
        self.thermal.fresh_oil != 0.0 && !self.thermal.isothermal
    }

    /// The film's situation `tau` seconds into the step, with its place (1), viscosity (Pa.s) and clearance (m) given.
    #[inline]
    fn instant(&self, tau: f64, eccentricity: [f64; 2], viscosity: f64, clearance: f64, seen: &mut SeenByLimits) {
        let SeenByLimits { tau: before, at, .. } = seen;
        // The last two stages of a step are at the same time.
        if before.replace(tau) != Some(tau) {
            (at.speed, at.load) = self.driven(tau);
            at.bush_speed = self.inputs.bush_speed.at(tau);
        }
        (at.eccentricity, at.viscosity, at.clearance) = (eccentricity, viscosity, clearance);
    }

    /// Shaft speed (rad/s) and load on the journal (N, along x and y), `tau` seconds into the step.
    #[inline]
    fn driven(&self, tau: f64) -> (f64, [f64; 2]) {
        let speed = self.drive.speed(&self.command(), tau);
        let inputs = &self.inputs;
        let along = inputs.external_force.at(tau) + inputs.external_force_x.at(tau);
        let along = self.load.force(self.angle(tau), speed) + along;
        (speed, [along, inputs.external_force_y.at(tau)])
    }

    /// Shaft angle, rad, `tau` seconds into the step.
    fn angle(&self, tau: f64) -> f64 {
        self.state.angle + self.drive.turned(&self.command(), tau)
    }

    /// The lower half of Fig. 3: rates of the temperatures from friction heat and heat transfer, K/s, at a clearance, m.
    #[inline]
    fn thermal_rates(&self, tau: f64, temperatures: &Temperatures, clearance: f64, flows: &Flows) -> Temperatures {
        let heat = self.heat_of(tau, temperatures, clearance, flows);
        self.thermal.rates(temperatures, &heat)
    }

    /// Heat sources and flows under these flows of the film.
    #[inline]
    fn heat_of(&self, tau: f64, temperatures: &Temperatures, clearance: f64, flows: &Flows) -> Heat {
        let oil = &self.fluid;
        let film = temperatures.film;
        let carried = |flow: f64, temperature: f64| match flow {
            // No flow, or one that was not computed because the temperatures do not depend on it.
            0.0 => 0.0,
            flow => flow * oil.density(temperature) * oil.heat_capacity(temperature),
        };
        Heat {
            viscous: flows.viscous,
            boundary: flows.boundary,
            side_flow: carried(flows.side_flow + self.assumed_feed, film),
            fed: carried(flows.feed + self.assumed_feed, self.bearing.supply.temperature),
            fed_temperature: self.bearing.supply.temperature,
            bath: self.bath_capacity(temperatures.oil),
            ambient: self.inputs.ambient_temperature.at(tau),
            clearance,
        }
    }

    /// Heat capacity of the oil bath at its temperature (K), J/K.
    fn bath_capacity(&self, oil: f64) -> f64 {
        let mass = self.thermal.oil_volume * self.fluid.density_15;
        mass * self.fluid.heat_capacity(oil)
    }

    /// Rates of the unknowns, and what the physical stand's sensors read, `tau` seconds into the step.
    #[inline(always)]
    fn course_at(&self, tau: f64, y: &Unknowns, oil: &mut Nearby, seen: &mut SeenByLimits) -> (Unknowns, Sensed) {
        let viscosity = oil.viscosity(&self.fluid, temperatures(y).film);
        self.course_with(tau, y, viscosity, seen)
    }

    /// The same with the oil's viscosity, Pa.s, at the film's temperature.
    #[inline(always)]
    fn course_with(&self, tau: f64, y: &Unknowns, viscosity: f64, seen: &mut SeenByLimits) -> (Unknowns, Sensed) {
        let temperatures = temperatures(y);
        seen.temperatures = temperatures;
        let clearance = self.clearance(&temperatures, worn(y));
        let drift = self.drift(tau, [y[0], y[1]], viscosity, clearance, seen);
        let at = &seen.at;
        let t = self.thermal_rates(tau, &temperatures, clearance, &drift.flows);
        let wear = self.bearing.wear_rate(drift.flows.boundary, at.sliding());
        let [vx, vy] = drift.velocity;
        let load = at.load_magnitude();
        let torque = drift.torque + self.support_torque(load, at.speed);
        (
            [vx, vy, t.film, t.bush, t.shaft, t.oil, wear],
            [
                at.load[0],
                torque,
                torque * at.speed,
                self.friction_coefficient(torque, load),
                temperatures.oil,
                temperatures.bush,
            ],
        )
    }

    /// Friction torque of the support bearings, N.m, at a load (N) and a shaft speed (rad/s).
    fn support_torque(&self, load: f64, speed: f64) -> f64 {
        self.drive.support_torque(load, self.bearing.radius(), speed)
    }

    /// `M/(F_N*D/2)`, 1, with the magnitude of the load.
    fn friction_coefficient(&self, torque: f64, load: f64) -> f64 {
        sensors::load_ratio(torque / self.bearing.radius(), load)
    }

    /// The sensors' readings, `tau` seconds into the step.
    fn read(&self, tau: f64, y: &Unknowns) -> Readings {
        let temperatures = temperatures(y);
        let at = self.situation(tau, y);
        let motion = self.film.motion(&self.bearing, &at);
        let load = at.load_magnitude();
        let torque = motion.torque + self.support_torque(load, at.speed);
        Readings {
            load_force: at.load[0],
            friction_torque: torque,
            friction_power: torque * at.speed,
            friction_coefficient: self.friction_coefficient(torque, load),
            oil_temperature: temperatures.oil,
            bearing_temperature: temperatures.bush,
            shaft_temperature: temperatures.shaft,
            eccentricity_ratio: motion.eccentricity_ratio,
            attitude_angle: y[1].atan2(y[0]),
            min_film_thickness: motion.min_film_thickness,
            contact_reach: motion.contact_reach,
            max_film_pressure: motion.max_film_pressure,
            film_viscosity: at.viscosity,
            film_temperature: temperatures.film,
            max_film_temperature: self.film.hottest().unwrap_or(temperatures.film),
            side_flow: motion.flows.side_flow,
            feed_flow: motion.flows.feed,
            contact_share: sensors::load_ratio(motion.contact.force, load),
            contact_torque: motion.boundary_torque,
            shaft_speed: at.speed,
            shaft_angle: self.angle(tau),
            hot_radial_clearance: at.clearance,
            journal_velocity: at.clearance * motion.velocity[0],
            wear_depth: worn(y),
            ambient_heat_flow: self.thermal.loss(&temperatures, self.inputs.ambient_temperature.at(tau)),
            oil_bath_capacity: self.bath_capacity(temperatures.oil),
        }
    }

    /// Logs once that the journal moves, so that the linearised film is none.
    fn tell_of_motion(&mut self, log: &mut dyn Log) {
        if self.state.moves || self.rests(&self.situation(0.0, &unknowns(&self.state))) {
            return;
        }
        self.state.moves = true;
        log.log(
            EVENTS,
            format_args!(
                "the journal does not rest at {:?} s: stiffness, damping and whirl threshold are 0 there",
                self.state.time
            ),
        );
    }

    fn command(&self) -> Command {
        Command { time: self.state.time, speed: self.inputs.speed.value, slope: self.inputs.speed.slope }
    }
}

fn unknowns(state: &State) -> Unknowns {
    let ([ex, ey], [film, bush, shaft, oil]) = (state.eccentricity, state.temperatures.array());
    [ex, ey, film, bush, shaft, oil, state.worn]
}

fn temperatures(&[_, _, film, bush, shaft, oil, _]: &Unknowns) -> Temperatures {
    Temperatures::of([film, bush, shaft, oil])
}

/// The mean wear depth, m.
fn worn(y: &Unknowns) -> f64 {
    y[6]
}

impl Model for Stand {
    const INFO: Info = Info {
        name: "PlainBearingStand",
        identifier: "PlainBearingStand",
        description: "Plain-bearing test stand: drive, load mechanism, bearing in mixed lubrication, oil, heat transfer and sensors",
        copyright: "Copyright (c) 2026 The plain-bearing-stand authors",
        default_step: 0.001,
        default_stop: 150.0,
        log_categories: &[
            (EVENTS, "The model's set-up, and how each step is made: with every turn resolved, or in a leap"),
            (validity::VALIDITY, "Limits of the model's laws that a run passes, once each"),
        ],
        ..fmu_export::info!()
    };

    const EXCHANGE: Option<Exchange<Self>> = Some(Exchange::of());

    const INNER_STEP: Option<fn(&Self, f64) -> f64> = Some(Self::inner_step);

    fn variables() -> &'static [Variable<Self>] {
        crate::variables::table()
    }

    fn listing() -> Vec<usize> {
        crate::variables::listing().to_vec()
    }

    fn initialise(&mut self, experiment: &Experiment, log: &mut dyn Log) -> Result {
        model::check_ranges(self)?;
        Self::check_time(experiment.start).map_err(Fault::Invalid)?;
        if let Some(tolerance) = experiment.tolerance {
            self.solver.tolerance = tolerance.clamp(1e-12, 1e-2);
        }
        self.fluid = self.oil.properties(experiment)?;
        self.check_oil()?;
        self.check_energy()?;
        self.nearby = Nearby::default();
        let temperatures = self.thermal.initial();
        self.film.start(&FilmSetup {
            bearing: &self.bearing,
            clearance: self.clearance(&temperatures, 0.0),
            rheology: self.oil.thickening,
            experiment,
        })?;
        self.state = State { time: experiment.start, temperatures, next_step: FIRST_STEP, ..State::default() };
        self.check_wear_and_clearance()?;
        self.settle(log)?;
        self.update()?;
        // What was tried to find the steady state is no part of the run.
        self.state.validity = 0;
        self.passed = Passing::default();
        self.look();
        self.tell(log);
        log.log(
            EVENTS,
            format_args!(
                "set up at {:?} s: {:?} film, radial clearance {:e} m, film of {:e} Pa.s at {:?} K, load {:?} N, \
                 tolerance {:e}",
                experiment.start,
                self.film.model,
                self.readings.hot_radial_clearance,
                self.readings.film_viscosity,
                self.readings.film_temperature,
                self.readings.load_force,
                self.solver.tolerance
            ),
        );
        Ok(())
    }

    fn update(&mut self) -> Result {
        self.arrival = Remembered::default();
        self.slowest = Remembered::default();
        self.resting = Remembered::default();
        self.operation = Remembered::default();
        self.fluid.viscosity_scale = self.oil.viscosity_scale;
        self.readings = self.read(0.0, &unknowns(&self.state));
        Ok(())
    }

    fn differentiate(&mut self) -> Result {
        self.rates = self.differences().map_err(|stuck| {
            Fault::Failed(format!("the outputs have no time derivatives here: a short step ahead failed: {stuck}"))
        })?;
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result {
        Self::check_time(time + step).map_err(Fault::Failed)?;
        self.check_inputs_after(step)?;
        self.state.time = time;
        let before = (self.state, self.inputs);
        self.passed = Passing::default();
        self.film.keep();
        let long = self.is_long(step);
        let hindrance = long.then(|| self.hindrance()).flatten();
        let leaps = long && hindrance.is_none();
        let how = if leaps { "in a leap over most of its turns" } else { "with every turn resolved" };
        log.log(EVENTS, format_args!("{step:?} s from {time:?} s {how}"));
        if let Some(why) = hindrance {
            log.log(EVENTS, format_args!("no leap: {why}"));
        }
        let done = if leaps { self.leap(step, log) } else { self.resolve(step) };
        if let Err(failure) = done {
            (self.state, self.inputs) = before;
            self.film.take_back();
            return Err(Fault::Failed(format!("the step from {time:?} s over {step:?} s failed: {failure}")));
        }
        self.inputs.each(|input| input.slope = 0.0);
        self.readings = self.read(0.0, &unknowns(&self.state));
        self.resting = Remembered::default();
        self.operation = Remembered::default();
        self.tell_of_motion(log);
        self.tell(log);
        Ok(())
    }

    fn restore(&mut self, bytes: &[u8]) -> Result {
        let mut saved: Self = postcard::from_bytes(bytes)
            .map_err(|error| Fault::Invalid(format!("the saved state cannot be read: {error}")))?;
        if saved.film.is_running() {
            model::check_fixed(&saved)?;
        }
        if !unknowns(&saved.state).iter().all(|unknown| unknown.is_finite()) {
            return Err(Fault::Invalid("the saved state has values that are no finite numbers".to_owned()));
        }
        saved.film.prepare(&saved.bearing)?;
        *self = saved;
        Ok(())
    }
}
