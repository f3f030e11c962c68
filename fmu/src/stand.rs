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
//! The drive's angle follows in closed form. The unknowns of the time integration are the journal's
//! eccentricity-ratio vector and the four temperatures.

use crate::bearing::contact::{Contact, ContactTable};
use crate::bearing::{Bearing, friction};
use crate::drive::{Command, Drive};
use crate::load::Load;
use crate::model::{self, Experiment, Fault, Info, Log, Model, Variable};
use crate::oil::{Oil, Properties};
use crate::sensors::{self, Readings};
use crate::solver::DormandPrince;
use crate::thermal::{Heat, Temperatures, Thermal};
use serde::{Deserialize, Serialize};

/// An input and its rate over the present step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Input {
    /// Value at the start of the step.
    pub value: f64,
    /// Time derivative during the step.
    pub slope: f64,
}

impl Input {
    const fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    fn at(&self, tau: f64) -> f64 {
        self.value + self.slope * tau
    }
}

/// What the host drives the stand with.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inputs {
    /// Mean shaft speed, rad/s.
    pub speed: Input,
    /// Force added to the load mechanism's, N.
    pub external_force: Input,
    /// Temperature of the surroundings, K.
    pub ambient_temperature: Input,
}

impl Default for Inputs {
    fn default() -> Self {
        Self {
            speed: Input::constant(10.0 * std::f64::consts::PI),
            external_force: Input::constant(0.0),
            ambient_temperature: Input::constant(295.15),
        }
    }
}

/// How the stand is integrated over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    /// Relative tolerance per internal step, 1.
    pub tolerance: f64,
}

impl Default for Solver {
    fn default() -> Self {
        Self { tolerance: 1e-6 }
    }
}

/// The stand's state between two steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    /// Time, s.
    time: f64,
    /// Shaft angle since the start, rad.
    angle: f64,
    /// Eccentricity-ratio vector in the load frame, 1.
    eccentricity: [f64; 2],
    /// The nodes' temperatures, K.
    temperatures: Temperatures,
    /// The internal step to try next, s.
    next_step: f64,
}

/// What follows from the parameters and is prepared once.
#[derive(Clone, Debug, Default)]
struct Prepared {
    contact: ContactTable,
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
    /// The oil.
    pub oil: Oil,
    /// The heat transfer.
    pub thermal: Thermal,
    /// The time integration.
    pub solver: Solver,
    /// The inputs.
    pub inputs: Inputs,
    /// The oil law of `oil`, which may come from a file that is read only once.
    fluid: Properties,
    state: State,
    readings: Readings,
    #[serde(skip)]
    prepared: Prepared,
}

const UNKNOWNS: usize = 6;
/// The unknowns: eccentricity ratio along x and y, temperatures of film, bush, shaft and oil.
type Unknowns = [f64; UNKNOWNS];

/// The change of each unknown that a relative tolerance of one allows: the whole clearance, 100 K.
const SCALES: Unknowns = [1.0, 1.0, 100.0, 100.0, 100.0, 100.0];

/// The journal never reaches the bush: beyond this ratio the film is computed as at it.
const LARGEST_ECCENTRICITY_RATIO: f64 = 1.0 - 1e-9;

/// The internal step to try first, s.
const FIRST_STEP: f64 = 1e-4;

/// The most internal steps in one communication step.
const STEP_LIMIT: usize = 20_000_000;

/// All that the blocks tell each other at one instant.
struct Instant {
    speed: f64,
    angle: f64,
    load: f64,
    eccentricity_ratio: f64,
    contact: Contact,
    viscosity: f64,
    temperatures: Temperatures,
    boundary_torque: f64,
    torque: f64,
    /// Rate of the eccentricity-ratio vector, 1/s.
    velocity: [f64; 2],
    eccentricity: [f64; 2],
    heat: Heat,
}

impl Stand {
    /// The outputs at the present communication point.
    pub fn readings(&self) -> &Readings {
        &self.readings
    }

    /// Time derivative of an output at the present communication point, per second.
    pub fn rate_of(&self, output: fn(&Readings) -> f64) -> f64 {
        const AHEAD: f64 = 1e-6;
        let now = self.unknowns();
        let rates = self.rates(&self.instant(0.0, &now));
        let mut then = now;
        for (value, rate) in then.iter_mut().zip(rates) {
            *value += AHEAD * rate;
        }
        let ahead = self.read(&self.instant(AHEAD, &then));
        let here = self.read(&self.instant(0.0, &now));
        (output(&ahead) - output(&here)) / AHEAD
    }

    fn command(&self) -> Command {
        Command {
            time: self.state.time,
            speed: self.inputs.speed.value,
            slope: self.inputs.speed.slope,
        }
    }

    /// Fig. 3 of the paper: every block in turn, `tau` seconds into the step.
    fn instant(&self, tau: f64, y: &Unknowns) -> Instant {
        let command = self.command();
        let speed = self.drive.speed(&command, tau);
        let angle = self.state.angle + self.drive.turned(&command, tau);
        let load = self.load.force(angle, speed) + self.inputs.external_force.at(tau);

        let temperatures = Temperatures {
            film: y[2],
            bush: y[3],
            shaft: y[4],
            oil: y[5],
        };
        let viscosity = self.fluid.viscosity(temperatures.film);

        let eccentricity = [y[0], y[1]];
        let eccentricity_ratio = y[0].hypot(y[1]).min(LARGEST_ECCENTRICITY_RATIO);
        let contact = self.prepared.contact.at(eccentricity_ratio);
        let (velocity, squeeze) =
            self.film_velocity(load, &contact, eccentricity, viscosity, speed);

        let couette = viscosity * speed * friction::couette(&self.bearing, eccentricity_ratio);
        let poiseuille =
            friction::poiseuille(self.bearing.radial_clearance, [load, 0.0], eccentricity);
        let boundary_torque = friction::boundary(&self.bearing, contact.normal, speed);
        let heat = Heat {
            viscous: couette * speed + squeeze,
            boundary: boundary_torque * speed,
            side_flow: 0.0,
            bath: self.bath_capacity(temperatures.oil),
            ambient: self.inputs.ambient_temperature.at(tau),
        };
        Instant {
            speed,
            angle,
            load,
            eccentricity_ratio,
            contact,
            viscosity,
            temperatures,
            boundary_torque,
            torque: couette + poiseuille + boundary_torque,
            velocity,
            eccentricity,
            heat,
        }
    }

    /// Rate of the eccentricity-ratio vector, 1/s, and the heat that squeezing the film makes, W.
    ///
    /// Eq. 2 of the paper (Booker 1965, J. Basic Eng. 87, 537-546): the film's share F of the load
    /// moves the journal at `F*psi^2/(eta*B*D) * M`, in a frame that turns with the mean speed of
    /// journal and bush. The paper's omega must be that mean, half the shaft speed.
    fn film_velocity(
        &self,
        load: f64,
        contact: &Contact,
        e: [f64; 2],
        viscosity: f64,
        speed: f64,
    ) -> ([f64; 2], f64) {
        let ratio = e[0].hypot(e[1]);
        let towards = if ratio > 0.0 {
            [e[0] / ratio, e[1] / ratio]
        } else {
            [1.0, 0.0]
        };
        let force = [
            load - contact.force * towards[0],
            -contact.force * towards[1],
        ];
        let magnitude = force[0].hypot(force[1]);
        let turning = [-0.5 * speed * e[1], 0.5 * speed * e[0]];
        if magnitude == 0.0 {
            return (turning, 0.0);
        }
        // TEMPORARY short mobility until the map lands.
        let along = (force[0] * towards[0] + force[1] * towards[1]) / magnitude;
        let across = (force[1] * towards[0] - force[0] * towards[1]) / magnitude;
        let open: f64 = (1.0 - ratio * along).max(1e-12);
        let m = [
            open.powf(1.5) * along,
            open.powf(0.5) * (1.0 - ratio).max(0.0) * across,
        ];
        let mobility = [
            m[0] * towards[0] - m[1] * towards[1],
            m[0] * towards[1] + m[1] * towards[0],
        ];
        let psi = self.bearing.relative_clearance();
        let scale =
            magnitude * psi * psi / (viscosity * self.bearing.width * self.bearing.diameter);
        let squeeze = [scale * mobility[0], scale * mobility[1]];
        let heat = self.bearing.radial_clearance * (force[0] * squeeze[0] + force[1] * squeeze[1]);
        ([squeeze[0] + turning[0], squeeze[1] + turning[1]], heat)
    }

    fn bath_capacity(&self, oil_temperature: f64) -> f64 {
        self.thermal.oil_volume * self.oil.density_15 * self.fluid.heat_capacity(oil_temperature)
    }

    fn rates(&self, instant: &Instant) -> Unknowns {
        let t = self.thermal.rates(&instant.temperatures, &instant.heat);
        let v = instant.velocity;
        [v[0], v[1], t.film, t.bush, t.shaft, t.oil]
    }

    fn read(&self, instant: &Instant) -> Readings {
        let bearing = &self.bearing;
        Readings {
            load_force: instant.load,
            friction_torque: instant.torque,
            friction_power: instant.torque * instant.speed,
            friction_coefficient: sensors::friction_coefficient(
                instant.torque,
                instant.load,
                bearing.diameter,
            ),
            oil_temperature: instant.temperatures.oil,
            bearing_temperature: instant.temperatures.bush,
            shaft_temperature: instant.temperatures.shaft,
            eccentricity_ratio: instant.eccentricity_ratio,
            attitude_angle: instant.eccentricity[1].atan2(instant.eccentricity[0]),
            min_film_thickness: bearing.radial_clearance * (1.0 - instant.eccentricity_ratio),
            max_film_pressure: 0.0,
            film_viscosity: instant.viscosity,
            film_temperature: instant.temperatures.film,
            side_flow: 0.0,
            contact_share: if instant.load == 0.0 {
                0.0
            } else {
                instant.contact.force / instant.load.abs()
            },
            contact_torque: instant.boundary_torque,
            shaft_speed: instant.speed,
            shaft_angle: instant.angle,
        }
    }

    fn unknowns(&self) -> Unknowns {
        let State {
            eccentricity: e,
            temperatures: t,
            ..
        } = self.state;
        [e[0], e[1], t.film, t.bush, t.shaft, t.oil]
    }

    fn prepare(&mut self) {
        let Bearing {
            radial_clearance,
            width,
            diameter,
            ref surface,
            ..
        } = self.bearing;
        self.prepared = Prepared {
            contact: ContactTable::new(surface, radial_clearance, width, diameter),
        };
    }
}

impl Model for Stand {
    const INFO: Info = Info {
        name: "PlainBearingStand",
        identifier: "PlainBearingStand",
        description: "Plain-bearing test stand: drive, load mechanism, bearing in mixed lubrication, oil, heat transfer and sensors",
        default_step: 0.001,
        default_stop: 150.0,
        default_tolerance: 1e-6,
        log_categories: &[
            ("logStatusError", "Why a call was refused or failed"),
            ("logStatusWarning", "What was accepted but deserves a look"),
            (
                "logEvents",
                "What the model was set up with and how the solver works",
            ),
        ],
    };

    fn variables() -> &'static [Variable<Self>] {
        crate::variables::table()
    }

    fn initialise(&mut self, experiment: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        model::check_ranges(self)?;
        if let Some(tolerance) = experiment.tolerance {
            self.solver.tolerance = tolerance.clamp(1e-12, 1e-2);
        }
        self.fluid = self.oil.properties(experiment.resources)?;
        self.prepare();
        self.state = State {
            time: experiment.start,
            angle: 0.0,
            eccentricity: [0.0, 0.0],
            temperatures: self.thermal.initial(),
            next_step: FIRST_STEP,
        };
        self.update()
    }

    fn update(&mut self) -> Result<(), Fault> {
        self.fluid.viscosity_scale = self.oil.viscosity_scale;
        self.readings = self.read(&self.instant(0.0, &self.unknowns()));
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64, _: &mut dyn Log) -> Result<(), Fault> {
        self.state.time = time;
        let integrator = DormandPrince {
            allowed: SCALES.map(|scale| self.solver.tolerance * scale),
            limit: STEP_LIMIT,
        };
        let mut y = self.unknowns();
        let mut next_step = self.state.next_step;
        integrator
            .integrate(
                |tau, y| self.rates(&self.instant(tau, y)),
                &mut y,
                step,
                &mut next_step,
            )
            .map_err(|failure| {
                Fault::Failed(format!(
                    "the step from {time} s over {step} s failed: {failure}"
                ))
            })?;
        let angle = self.state.angle + self.drive.turned(&self.command(), step);
        self.state = State {
            time: time + step,
            angle,
            eccentricity: [y[0], y[1]],
            temperatures: Temperatures {
                film: y[2],
                bush: y[3],
                shaft: y[4],
                oil: y[5],
            },
            next_step,
        };
        for input in [
            &mut self.inputs.speed,
            &mut self.inputs.external_force,
            &mut self.inputs.ambient_temperature,
        ] {
            *input = Input::constant(input.at(step));
        }
        self.update()
    }

    fn save(&self) -> Vec<u8> {
        // Writing plain numbers and texts into memory has no way to fail.
        postcard::to_stdvec(self).unwrap_or_default()
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let mut saved: Self = postcard::from_bytes(bytes)
            .map_err(|error| Fault::Invalid(format!("the saved state cannot be read: {error}")))?;
        saved.prepare();
        *self = saved;
        Ok(())
    }
}
