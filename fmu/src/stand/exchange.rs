//! The stand for hosts that integrate it themselves (Model Exchange): shaft angle, eccentricity, temperatures and wear depth
//! are their states, and the stand gives the rates.

use fmu_export::model::{Complete, Continuous, Fault, State};
use fmu_export::units;

use super::validity::Seen;
use super::{Stand, Unknowns, temperatures, unknowns};

/// The states in the order of their declaration: the shaft angle, then the unknowns of the stand's own integration.
#[rustfmt::skip]
static STATES: [State<Stand>; 8] = [
    State { name: "state.angle", description: "Shaft angle since the start", unit: &units::RADIAN,
        rate_unit: &units::RADIAN_PER_SECOND, nominal: 1.0,
        get: |stand| stand.state.angle, set: |stand, value| stand.state.angle = value },
    State { name: "state.eccentricityX", description: "Eccentricity ratio in the direction of the load", unit: &units::ONE,
        rate_unit: &units::PER_SECOND, nominal: 1.0,
        get: |stand| stand.state.eccentricity[0], set: |stand, value| stand.state.eccentricity[0] = value },
    State { name: "state.eccentricityY", description: "Eccentricity ratio across the load", unit: &units::ONE,
        rate_unit: &units::PER_SECOND, nominal: 1.0,
        get: |stand| stand.state.eccentricity[1], set: |stand, value| stand.state.eccentricity[1] = value },
    State { name: "state.filmTemperature", description: "Temperature of the film", unit: &units::KELVIN,
        rate_unit: &units::KELVIN_PER_SECOND, nominal: 100.0,
        get: |stand| stand.state.temperatures.film, set: |stand, value| stand.state.temperatures.film = value },
    State { name: "state.bushTemperature", description: "Temperature of the bush", unit: &units::KELVIN,
        rate_unit: &units::KELVIN_PER_SECOND, nominal: 100.0,
        get: |stand| stand.state.temperatures.bush, set: |stand, value| stand.state.temperatures.bush = value },
    State { name: "state.shaftTemperature", description: "Temperature of the shaft", unit: &units::KELVIN,
        rate_unit: &units::KELVIN_PER_SECOND, nominal: 100.0,
        get: |stand| stand.state.temperatures.shaft, set: |stand, value| stand.state.temperatures.shaft = value },
    State { name: "state.oilTemperature", description: "Temperature of the oil bath", unit: &units::KELVIN,
        rate_unit: &units::KELVIN_PER_SECOND, nominal: 100.0,
        get: |stand| stand.state.temperatures.oil, set: |stand, value| stand.state.temperatures.oil = value },
    State { name: "state.wearDepth", description: "Mean wear depth", unit: &units::METRE,
        rate_unit: &units::METRE_PER_SECOND, nominal: 1e-5,
        get: |stand| stand.state.worn, set: |stand, value| stand.state.worn = value },
];

/// Eccentricity ratios and temperatures, K, beyond which the rates are those at these bounds: no run comes there, but a trial step
/// of a solver that is unaware of `Discard` may, and with numbers it takes a smaller one.
const FARTHEST: f64 = 1e3;
const COLDEST: f64 = 100.0;
const WARMEST: f64 = 3e3;

/// The nearest unknowns within these bounds.
fn within_bounds(mut y: Unknowns) -> Unknowns {
    let far = y[0].hypot(y[1]) / FARTHEST;
    if far > 1.0 {
        (y[0], y[1]) = (y[0] / far, y[1] / far);
    }
    for temperature in &mut y[2..6] {
        *temperature = temperature.clamp(COLDEST, WARMEST);
    }
    y
}

impl Continuous for Stand {
    fn states() -> &'static [State<Self>] {
        &STATES
    }

    /// The means over a turn are taken along the stand's own steps.
    fn without() -> &'static [&'static str] {
        &[
            "sensor.loadForceMean",
            "sensor.frictionTorqueMean",
            "sensor.frictionPowerMean",
            "sensor.frictionCoefficientMean",
            "sensor.oilTemperatureMean",
            "sensor.bearingTemperatureMean",
        ]
    }

    /// Looks for limits that the states have passed.
    const COMPLETE: Option<Complete<Self>> = Some(|stand, log| {
        let before = stand.state.validity;
        stand.look();
        stand.tell(log);
        stand.state.validity != before
    });

    fn allow(&self) -> Result<(), Fault> {
        if !self.film.is_transient() {
            return Ok(());
        }
        Err(Fault::Invalid(format!(
            "bearing.film = {:?}: this film steps its oil content itself, so another solver cannot integrate it. Choose \
             Mobility, or an FMU for Co-Simulation",
            self.film.model
        )))
    }

    fn set_time(&mut self, time: f64) {
        self.state.time = time;
    }

    /// Without the cache of the viscosity, whose last digits depend on the calls before, and with the viscosity's scale as
    /// the host has set it last.
    fn rates(&self, rates: &mut [f64]) -> Result<(), Fault> {
        let y = within_bounds(unknowns(&self.state));
        let viscosity = self.oil.viscosity_scale * self.fluid.real(temperatures(&y).film);
        let (course, _) = self.course_with(0.0, &y, viscosity, &mut Seen::default());
        let speed = self.drive.speed(&self.command(), 0.0);
        let all = std::iter::once(speed).chain(course);
        for (rate, value) in rates.iter_mut().zip(all) {
            *rate = value;
        }
        if rates.iter().all(|rate| rate.is_finite()) {
            return Ok(());
        }
        let film = temperatures(&y).film;
        Err(Fault::Failed(format!(
            "no rates exist at eccentricity ratio {:.6e} and film temperature {film:.6e} K",
            y[0].hypot(y[1])
        )))
    }
}
