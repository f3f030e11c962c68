//! The stand for hosts that integrate it themselves (Model Exchange): shaft angle, eccentricity, temperatures and wear depth
//! are their states, and the stand gives the rates.

use crate::Result;
use fmu_export::{
    model::{Complete, Continuous, Fault, State},
    units,
};
use nalgebra::{ComplexField, Vector2};

use super::{Stand, temperatures, unknowns, validity::SeenByLimits};

/// A state that hosts see as it is: its name, what it is, its unit and that of its rate, a typical magnitude, and where it stands.
macro_rules! state {
    ($name:literal, $description:literal, $unit:ident, $rate_unit:ident, $nominal:literal, $($place:ident).+) => {
        State {
            name: $name,
            description: $description,
            unit: &units::$unit,
            rate_unit: &units::$rate_unit,
            nominal: $nominal,
            get: |stand| stand.state.$($place).+,
            set: |stand, value| stand.state.$($place).+ = value,
        }
    };
}

/// The states in the order of their declaration: the shaft angle, then the unknowns of the stand's own integration.
#[rustfmt::skip]
static STATES: [State<Stand>; 8] = [
    state!("state.angle", "Shaft angle since the start", RADIAN, RADIAN_PER_SECOND, 1.0, angle),
    State { name: "state.eccentricityX", description: "Eccentricity ratio in the direction of the load; its length e as sinh(5 e)/5",
        unit: &units::ONE, rate_unit: &units::PER_SECOND, nominal: 1.0,
        get: |stand| stand.stretched()[0], set: |stand, value| stand.set_stretched(0, value) },
    State { name: "state.eccentricityY", description: "Eccentricity ratio across the load; its length e as sinh(5 e)/5",
        unit: &units::ONE, rate_unit: &units::PER_SECOND, nominal: 1.0,
        get: |stand| stand.stretched()[1], set: |stand, value| stand.set_stretched(1, value) },
    state!("state.filmTemperature", "Temperature of the film", KELVIN, KELVIN_PER_SECOND, 100.0, temperatures.film),
    state!("state.bushTemperature", "Temperature of the bush", KELVIN, KELVIN_PER_SECOND, 100.0, temperatures.bush),
    state!("state.shaftTemperature", "Temperature of the shaft", KELVIN, KELVIN_PER_SECOND, 100.0, temperatures.shaft),
    state!("state.oilTemperature", "Temperature of the oil bath", KELVIN, KELVIN_PER_SECOND, 100.0, temperatures.oil),
    state!("state.wearDepth", "Mean wear depth", METRE, METRE_PER_SECOND, 1e-5, worn),
];

/// Temperatures, K, beyond which the rates are those at these bounds: no run comes there, but a trial step of a solver that is unaware
/// of `Discard` may, and with numbers it takes a smaller one.
const COLDEST: f64 = 100.0;
const WARMEST: f64 = 3e3;

/// To hosts the eccentricity has the length `sinh(5 e)/5`: contact and friction rise steeply with it, and a relative error of this
/// length is a far smaller one of `e`. Trial steps far outside end near the bush.
const STEEP: f64 = 5.0;

impl Stand {
    fn stretched(&self) -> Vector2<f64> {
        let e = Vector2::from(self.state.eccentricity);
        self.state.stretched.unwrap_or_else(|| e * (STEEP * e.norm()).sinhc())
    }

    fn set_stretched(&mut self, axis: usize, value: f64) {
        let mut stretched = self.stretched();
        stretched[axis] = value;
        self.state.stretched = Some(stretched);
        // Squares of larger numbers might not be finite.
        let near = stretched.map(|length| length.clamp(-1e100, 1e100));
        self.state.eccentricity = (near / (STEEP * near.norm()).asinh().sinhc()).into();
    }
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

    fn allow(&self) -> Result {
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
    fn rates(&self, rates: &mut [f64]) -> Result {
        let mut y = unknowns(&self.state);
        for temperature in &mut y[2..6] {
            *temperature = temperature.clamp(COLDEST, WARMEST);
        }
        let film = temperatures(&y).film;
        let viscosity = self.oil.viscosity_scale * self.fluid.real(film);
        let (mut course, _) = self.course_with(0.0, &y, viscosity, &mut SeenByLimits::default());
        let place = Vector2::new(y[0], y[1]);
        let (e, outwards) = (place.norm(), place.try_normalize(0.0).unwrap_or_default());
        let velocity = Vector2::new(course[0], course[1]);
        let (along, across) = ((STEEP * e).cosh(), (STEEP * e).sinhc());
        let more = (along - across) * outwards.dot(&velocity);
        [course[0], course[1]] = (velocity * across + outwards * more).into();
        rates[0] = self.drive.speed(&self.command(), 0.0);
        rates[1..].copy_from_slice(&course);
        if rates.iter().all(|rate| rate.is_finite()) {
            return Ok(());
        }
        Err(Fault::Failed(format!("no rates exist at eccentricity ratio {e:.6e} and film temperature {film:.6e} K")))
    }
}
