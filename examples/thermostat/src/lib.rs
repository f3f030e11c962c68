//! A house with three zones, each with a heater that a thermostat switches: an example of events, arrays and a clock.
//!
//! A zone's temperature tends to that outside, or to `rise` above it while its heater is on. The heater is switched off at
//! `setpoint + band` and on at `setpoint - band` (events of the states); at `nightStart` the setpoint falls by `setback` (an event
//! that is known beforehand). The clock `switched` ticks where a heater is switched.

use fmu_export::declare::{input, output, parameter, tunable, variable};
use fmu_export::model::{
    Access, Continuous, Events, Exchange, Experiment, Fault, Info, Kind, Log, Model, Role, State, Variable,
    check_ranges,
};
use fmu_export::units::{KELVIN, KELVIN_DIFFERENCE, KELVIN_PER_SECOND, SECOND};
use fmu_export::{field, info};
use serde::{Deserialize, Serialize};

/// How many zones there are.
const ZONES: usize = 3;
/// What counts as nothing, in K and in s: rounding may leave so much of the way to an event.
const NEAR: f64 = 1e-9;

/// Input, parameters and state of the house, in SI units.
#[derive(Clone, Serialize, Deserialize)]
pub struct House {
    outside: f64,
    setpoint: f64,
    band: f64,
    rise: f64,
    initial: f64,
    night_start: f64,
    setback: f64,
    time_constant: [f64; ZONES],
    time: f64,
    temperature: [f64; ZONES],
    heating: [bool; ZONES],
    is_night: bool,
    switched: bool,
    switches: i32,
    switch_time: f64,
}

/// The start values.
#[rustfmt::skip]
impl Default for House {
    fn default() -> Self {
        Self {
            outside: 278.15, setpoint: 293.15, band: 1.0, rise: 30.0, initial: 288.15, night_start: 79_200.0, setback: 3.0,
            time_constant: [7_200.0, 10_800.0, 18_000.0],
            time: 0.0, temperature: [288.15; ZONES], heating: [false; ZONES], is_night: false,
            switched: false, switches: 0, switch_time: 0.0,
        }
    }
}

impl House {
    /// The temperature that a zone tends to.
    fn end(&self, zone: usize) -> f64 {
        self.outside + if self.heating[zone] { self.rise } else { 0.0 }
    }

    fn rate(&self, zone: usize) -> f64 {
        (self.end(zone) - self.temperature[zone]) / self.time_constant[zone]
    }

    /// The temperature at which a zone's heater is switched next.
    fn threshold(&self, zone: usize) -> f64 {
        let setpoint = self.setpoint - if self.is_night { self.setback } else { 0.0 };
        setpoint + if self.heating[zone] { self.band } else { -self.band }
    }

    /// What is left to that, K: an event indicator.
    fn margin(&self, zone: usize) -> f64 {
        let left = self.threshold(zone) - self.temperature[zone];
        if self.heating[zone] { left } else { -left }
    }

    /// The seconds until then, if the zone goes there.
    fn left(&self, zone: usize) -> f64 {
        let (end, constant) = (self.end(zone), self.time_constant[zone]);
        let ratio = (self.temperature[zone] - end) / (self.threshold(zone) - end);
        match self.margin(zone) <= NEAR {
            true => 0.0,
            false if ratio > 1.0 => constant * ratio.ln(),
            false => f64::INFINITY,
        }
    }

    /// The event that is known beforehand.
    fn next(&self) -> Option<f64> {
        (!self.is_night).then_some(self.night_start)
    }

    /// Follows the exact solution to the next event, or to the end of the step.
    #[rustfmt::skip]
    fn until(&mut self, time: f64, step: f64, _: &mut dyn Log) -> Result<Option<f64>, Fault> {
        let night = self.next().map(|at| at - time);
        let left = (0..ZONES).map(|zone| self.left(zone)).chain(night).fold(f64::INFINITY, f64::min).max(0.0);
        let part = left.min(step);
        for zone in 0..ZONES {
            let end = self.end(zone);
            self.temperature[zone] = end + (self.temperature[zone] - end) * (-part / self.time_constant[zone]).exp();
        }
        self.time = time + part;
        Ok((left <= step).then_some(part))
    }

    /// Handles what is due: nightfall first, as it moves the thresholds.
    fn handle(&mut self) -> Result<bool, Fault> {
        let night_falls = !self.is_night && self.time >= self.night_start - NEAR;
        self.is_night |= night_falls;
        self.switched = false;
        for zone in 0..ZONES {
            if self.margin(zone) <= NEAR {
                self.heating[zone] = !self.heating[zone];
                (self.switched, self.switch_time) = (true, self.time);
                self.switches += 1;
            }
        }
        Ok(night_falls || self.switched)
    }
}

/// Elements of the arrays: their zone counts from 0, their name from 1.
#[rustfmt::skip]
mod element {
    use super::*;

    pub const fn time_constant<const ZONE: usize>(name: &'static str) -> Variable<House> {
        parameter(name, &SECOND, field!(House: time_constant[ZONE]), "How fast a zone follows").within(1.0, 1e7)
    }

    pub const fn temperature<const ZONE: usize>(name: &'static str) -> Variable<House> {
        output(name, &KELVIN, |h: &House| h.temperature[ZONE], "Temperature of a zone").shown_in("degC").derivative(|h| h.rate(ZONE))
    }

    pub const fn heating<const ZONE: usize>(name: &'static str) -> Variable<House> {
        let access = Access { get: |h: &House| h.heating[ZONE], set: None };
        variable(name, Role::Output, Kind::Boolean { access }, "Whether a zone's heater is on")
    }

    pub const fn margin<const ZONE: usize>(name: &'static str) -> Variable<House> {
        output(name, &KELVIN_DIFFERENCE, |h: &House| h.margin(ZONE), "What is left until the heater is switched")
    }

    pub const fn state<const ZONE: usize>(name: &'static str) -> State<House> {
        State {
            name, description: "Temperature of a zone", unit: &KELVIN, rate_unit: &KELVIN_PER_SECOND, nominal: 300.0,
            get: |h| h.temperature[ZONE], set: |h, value| h.temperature[ZONE] = value,
        }
    }
}
use element::{heating, margin, state, temperature, time_constant};

#[rustfmt::skip]
static VARIABLES: [Variable<House>; 22] = [
    input("outside", &KELVIN, field!(House: outside), "Temperature outside").within(200.0, 330.0).shown_in("degC"),
    tunable("setpoint", &KELVIN, field!(House: setpoint), "Temperature by day").within(270.0, 320.0).shown_in("degC"),
    parameter("band", &KELVIN_DIFFERENCE, field!(House: band), "From the setpoint to where a heater is switched").within(0.01, 10.0),
    parameter("rise", &KELVIN_DIFFERENCE, field!(House: rise), "How much a heater warms its zone in the end").within(0.0, 100.0),
    parameter("initialTemperature", &KELVIN, field!(House: initial), "Temperature at the start").within(200.0, 330.0).shown_in("degC"),
    parameter("nightStart", &SECOND, field!(House: night_start), "Time at which the setpoint falls").within(0.0, 1e9),
    parameter("setback", &KELVIN_DIFFERENCE, field!(House: setback), "By how much it does").within(0.0, 20.0),
    time_constant::<0>("timeConstant[1]").array(ZONES), time_constant::<1>("timeConstant[2]"), time_constant::<2>("timeConstant[3]"),
    temperature::<0>("temperature[1]").array(ZONES), temperature::<1>("temperature[2]"), temperature::<2>("temperature[3]"),
    heating::<0>("heating[1]").array(ZONES), heating::<1>("heating[2]"), heating::<2>("heating[3]"),
    margin::<0>("margin[1]").array(ZONES), margin::<1>("margin[2]"), margin::<2>("margin[3]"),
    variable("switched", Role::Output, Kind::Clock { ticked: |h| h.switched }, "Ticks where a heater is switched"),
    variable("switches", Role::Output, Kind::Integer { access: Access { get: |h: &House| h.switches, set: None }, min: Some(0), max: None },
        "How often heaters were switched").clocked("switched"),
    output("switchTime", &SECOND, |h: &House| h.switch_time, "When one was switched last").clocked("switched"),
];

static STATES: [State<House>; ZONES] =
    [state::<0>("state.temperature[1]"), state::<1>("state.temperature[2]"), state::<2>("state.temperature[3]")];

impl Model for House {
    #[rustfmt::skip]
    const INFO: Info = Info { name: "Thermostat", identifier: "Thermostat", default_step: 60.0, default_stop: 86_400.0, ..info!() };

    const EXCHANGE: Option<Exchange<Self>> = Some(Exchange::of());

    const EVENTS: Option<Events<Self>> = Some(Events {
        indicators: &["margin[1]", "margin[2]", "margin[3]"],
        next: Self::next,
        until: Self::until,
        handle: Self::handle,
    });

    fn variables() -> &'static [Variable<Self>] {
        &VARIABLES
    }

    fn initialise(&mut self, experiment: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        check_ranges(self)?;
        self.time = experiment.start;
        self.switch_time = experiment.start;
        self.is_night = self.time >= self.night_start;
        self.temperature = [self.initial; ZONES];
        self.heating = [self.initial < self.setpoint; ZONES];
        // Where the first heater should be off, or on, at once.
        self.handle()?;
        (self.switched, self.switches) = (false, 0);
        Ok(())
    }

    /// For hosts that do not see events.
    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault> {
        Self::EVENTS.map_or(Ok(()), |events| events.pass(self, time, step, log))
    }
}

/// For hosts that integrate (Model Exchange).
impl Continuous for House {
    fn states() -> &'static [State<Self>] {
        &STATES
    }

    fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    fn rates(&self, rates: &mut [f64]) -> Result<(), Fault> {
        for (zone, rate) in rates.iter_mut().enumerate() {
            *rate = self.rate(zone);
        }
        Ok(())
    }
}

fmu_export::export!(House);
