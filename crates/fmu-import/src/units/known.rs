//! Units that people and loggers write, whether an FMU defines them or not.

use super::{BaseUnit, Conversion, plain};

type Exponents = [i32; 8];

const NONE: Exponents = [0; 8];
const LENGTH: Exponents = [0, 1, 0, 0, 0, 0, 0, 0];
const TIME: Exponents = [0, 0, 1, 0, 0, 0, 0, 0];
const FREQUENCY: Exponents = [0, 0, -1, 0, 0, 0, 0, 0];
const TURNING: Exponents = [0, 0, -1, 0, 0, 0, 0, 1];
const ANGLE: Exponents = [0, 0, 0, 0, 0, 0, 0, 1];
const VELOCITY: Exponents = [0, 1, -1, 0, 0, 0, 0, 0];
const ACCELERATION: Exponents = [0, 1, -2, 0, 0, 0, 0, 0];
const MASS: Exponents = [1, 0, 0, 0, 0, 0, 0, 0];
const FORCE: Exponents = [1, 1, -2, 0, 0, 0, 0, 0];
const TORQUE: Exponents = [1, 2, -2, 0, 0, 0, 0, 0];
const PRESSURE: Exponents = [1, -1, -2, 0, 0, 0, 0, 0];
const POWER: Exponents = [1, 2, -3, 0, 0, 0, 0, 0];
const TEMPERATURE: Exponents = [0, 0, 0, 0, 1, 0, 0, 0];
const MASS_FLOW: Exponents = [1, 0, -1, 0, 0, 0, 0, 0];
const FLOW: Exponents = [0, 3, -1, 0, 0, 0, 0, 0];
const VOLTAGE: Exponents = [1, 2, -3, -1, 0, 0, 0, 0];
const CURRENT: Exponents = [0, 0, 0, 1, 0, 0, 0, 0];
const TURN: f64 = std::f64::consts::TAU;
const DEGREE: f64 = TURN / 360.0;

/// Names of a unit, the usual one first; its kind; factor and offset to base units. A turn a minute is an angular velocity in
/// one FMU and a frequency in another one.
const KNOWN: &[(&str, Exponents, f64, f64)] = &[
    ("1 -", NONE, 1.0, 0.0),
    ("%", NONE, 0.01, 0.0),
    ("m", LENGTH, 1.0, 0.0),
    ("cm", LENGTH, 1e-2, 0.0),
    ("mm", LENGTH, 1e-3, 0.0),
    ("um", LENGTH, 1e-6, 0.0),
    ("s sec seconds Sekunden", TIME, 1.0, 0.0),
    ("ms msec", TIME, 1e-3, 0.0),
    ("us usec", TIME, 1e-6, 0.0),
    ("ns", TIME, 1e-9, 0.0),
    ("min", TIME, 60.0, 0.0),
    ("h hr", TIME, 3600.0, 0.0),
    ("d", TIME, 86_400.0, 0.0),
    ("Hz 1/s", FREQUENCY, 1.0, 0.0),
    ("kHz", FREQUENCY, 1e3, 0.0),
    ("1/min rpm", FREQUENCY, 1.0 / 60.0, 0.0),
    ("rad/s", TURNING, 1.0, 0.0),
    ("deg/s", TURNING, DEGREE, 0.0),
    ("rpm 1/min /min min-1 min^-1 RPM U/min r/min rev/min", TURNING, TURN / 60.0, 0.0),
    ("rev/s", TURNING, TURN, 0.0),
    ("rad", ANGLE, 1.0, 0.0),
    ("deg degCA", ANGLE, DEGREE, 0.0),
    ("m/s", VELOCITY, 1.0, 0.0),
    ("mm/s", VELOCITY, 1e-3, 0.0),
    ("km/h kph KMPH", VELOCITY, 1.0 / 3.6, 0.0),
    ("mph MPH", VELOCITY, 0.447_04, 0.0),
    ("m/s2 m/s^2", ACCELERATION, 1.0, 0.0),
    ("kg", MASS, 1.0, 0.0),
    ("g", MASS, 1e-3, 0.0),
    ("N", FORCE, 1.0, 0.0),
    ("kN", FORCE, 1e3, 0.0),
    ("N.m Nm", TORQUE, 1.0, 0.0),
    ("N.mm Nmm", TORQUE, 1e-3, 0.0),
    ("mN.m mNm", TORQUE, 1e-3, 0.0),
    ("N.cm Ncm", TORQUE, 1e-2, 0.0),
    ("kN.m kNm", TORQUE, 1e3, 0.0),
    // An energy has the base units of a torque.
    ("J", TORQUE, 1.0, 0.0),
    ("kJ", TORQUE, 1e3, 0.0),
    ("kWh", TORQUE, 3.6e6, 0.0),
    ("Pa", PRESSURE, 1.0, 0.0),
    ("hPa mbar", PRESSURE, 1e2, 0.0),
    ("kPa", PRESSURE, 1e3, 0.0),
    ("bar", PRESSURE, 1e5, 0.0),
    ("MPa", PRESSURE, 1e6, 0.0),
    ("psi", PRESSURE, 6_894.757_293_168, 0.0),
    ("W", POWER, 1.0, 0.0),
    ("kW", POWER, 1e3, 0.0),
    ("K", TEMPERATURE, 1.0, 0.0),
    ("degC Celsius", TEMPERATURE, 1.0, 273.15),
    ("degF Fahrenheit", TEMPERATURE, 5.0 / 9.0, 459.67 * 5.0 / 9.0),
    ("kg/s", MASS_FLOW, 1.0, 0.0),
    ("g/s", MASS_FLOW, 1e-3, 0.0),
    ("kg/h", MASS_FLOW, 1.0 / 3600.0, 0.0),
    ("m3/s m^3/s", FLOW, 1.0, 0.0),
    ("m3/h m^3/h", FLOW, 1.0 / 3600.0, 0.0),
    ("l/min L/min", FLOW, 1e-3 / 60.0, 0.0),
    ("V Volts", VOLTAGE, 1.0, 0.0),
    ("mV", VOLTAGE, 1e-3, 0.0),
    ("A", CURRENT, 1.0, 0.0),
    ("mA", CURRENT, 1e-3, 0.0),
];

/// The units of a name: none, one, or several of different kinds.
fn named(name: &str) -> impl Iterator<Item = &'static (&'static str, Exponents, f64, f64)> {
    let name = plain(name).replace('*', ".");
    let is_it = move |names: &str| names.split(' ').any(|known| known == name);
    KNOWN.iter().filter(move |(names, ..)| is_it(names))
}

fn first(names: &'static str) -> &'static str {
    names.split(' ').next().unwrap_or(names)
}

/// The usual name of a unit, such as `N.m` for `Nm` and `rpm` for `1/min`; `None` of an unknown one.
pub fn usual(name: &str) -> Option<&'static str> {
    named(name).last().map(|(names, ..)| first(names))
}

/// What a name means in SI base units: nothing, one thing, or several of different kinds.
pub(super) fn meanings(name: &str) -> impl Iterator<Item = BaseUnit> {
    named(name).map(|&(_, exponents, factor, offset)| BaseUnit { exponents, to_base: Conversion { factor, offset } })
}

/// How values in one unit become values in another one of the same kind, by their names alone.
pub fn between(from: &str, to: &str) -> Option<Conversion> {
    let pairs = meanings(from).flat_map(|a| meanings(to).map(move |b| (a, b)));
    let mut alike = pairs.filter(|(a, b)| a.exponents == b.exponents);
    alike.next().map(|(from, to)| from.to_base.then(to.to_base.inverse()))
}

/// The usual names of all units of a unit's kind.
pub fn alike(unit: &str) -> Vec<&'static str> {
    let kinds: Vec<_> = named(unit).map(|(_, kind, ..)| kind).collect();
    let of_kind = KNOWN.iter().filter(|(_, kind, ..)| kinds.contains(&kind));
    of_kind.map(|(names, ..)| first(names)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_convert_by_their_names() {
        for (from, to, value, expected) in [
            ("Nm", "N.m", 3.0, 3.0),
            ("N*mm", "Nm", 3.0, 3e-3),
            ("1/min", "rpm", 300.0, 300.0),
            ("1/min", "rad/s", 300.0, 10.0 * std::f64::consts::PI),
            ("1/min", "Hz", 300.0, 5.0),
            ("°C", "K", 20.0, 293.15),
            ("K", "degC", 293.15, 20.0),
            ("bar", "Pa", 1.5, 1.5e5),
            ("%", "-", 5.0, 0.05),
        ] {
            let got = between(from, to).unwrap().value(value);
            assert!((got - expected).abs() < 1e-9 * expected, "{from} {to} {got}");
        }
        // A turn is no radian, and a torque no pressure.
        assert_eq!(between("Hz", "rad/s"), None);
        assert_eq!(between("Nm", "bar"), None);
        assert_eq!(between("furlong", "furlong"), None);
        assert_eq!(["Nm", "U/min", "mbar", "x"].map(usual), [Some("N.m"), Some("rpm"), Some("hPa"), None]);
        assert_eq!(alike("N"), ["N", "kN"]);
    }
}
