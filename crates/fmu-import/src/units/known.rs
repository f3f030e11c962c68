//! Units that people and loggers write, whether an FMU defines them or not.

use super::{BaseUnit, Conversion, plain};

type Exponents = [i32; 8];

/// Names of a unit, the usual one first, and its factor to base units.
type Named = (&'static str, f64);

const TURN: f64 = std::f64::consts::TAU;
const DEGREE: f64 = TURN / 360.0;

/// The units by their exponents of kg, m, s, A, K, mol, cd, rad. A turn a minute is an angular velocity in one FMU and a frequency in
/// another one; an energy has the base units of a torque.
const KNOWN: &[(Exponents, &[Named])] = &[
    ([0; 8], &[("1 -", 1.0), ("%", 0.01)]),
    ([0, 1, 0, 0, 0, 0, 0, 0], &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6)]),
    (
        [0, 0, 1, 0, 0, 0, 0, 0],
        &[
            ("s sec seconds Sekunden", 1.0),
            ("ms msec", 1e-3),
            ("us usec", 1e-6),
            ("ns", 1e-9),
            ("min", 60.0),
            ("h hr", 3600.0),
            ("d", 86_400.0),
        ],
    ),
    ([0, 0, -1, 0, 0, 0, 0, 0], &[("Hz 1/s", 1.0), ("kHz", 1e3), ("1/min rpm", 1.0 / 60.0)]),
    (
        [0, 0, -1, 0, 0, 0, 0, 1],
        &[
            ("rad/s", 1.0),
            ("deg/s", DEGREE),
            ("rpm 1/min /min min-1 min^-1 RPM U/min r/min rev/min", TURN / 60.0),
            ("rev/s", TURN),
        ],
    ),
    ([0, 0, 0, 0, 0, 0, 0, 1], &[("rad", 1.0), ("mrad", 1e-3), ("deg degCA", DEGREE)]),
    ([0, 1, -1, 0, 0, 0, 0, 0], &[("m/s", 1.0), ("mm/s", 1e-3), ("km/h kph KMPH", 1.0 / 3.6), ("mph MPH", 0.447_04)]),
    ([0, 1, -2, 0, 0, 0, 0, 0], &[("m/s2 m/s^2", 1.0)]),
    ([1, 0, 0, 0, 0, 0, 0, 0], &[("kg", 1.0), ("g", 1e-3)]),
    ([1, 1, -2, 0, 0, 0, 0, 0], &[("N", 1.0), ("kN", 1e3)]),
    (
        [1, 2, -2, 0, 0, 0, 0, 0],
        &[
            ("N.m Nm", 1.0),
            ("N.mm Nmm", 1e-3),
            ("mN.m mNm", 1e-3),
            ("N.cm Ncm", 1e-2),
            ("kN.m kNm", 1e3),
            ("J", 1.0),
            ("kJ", 1e3),
            ("kWh", 3.6e6),
        ],
    ),
    (
        [1, -1, -2, 0, 0, 0, 0, 0],
        &[("Pa", 1.0), ("hPa mbar", 1e2), ("kPa", 1e3), ("bar", 1e5), ("MPa", 1e6), ("psi", 6_894.757_293_168)],
    ),
    ([1, 2, -3, 0, 0, 0, 0, 0], &[("W", 1.0), ("kW", 1e3)]),
    ([0, 0, 0, 0, 1, 0, 0, 0], &[("K", 1.0), ("degC Celsius", 1.0), ("degF Fahrenheit", 5.0 / 9.0)]),
    ([1, 0, -1, 0, 0, 0, 0, 0], &[("kg/s", 1.0), ("g/s", 1e-3), ("kg/h", 1.0 / 3600.0)]),
    ([0, 3, -1, 0, 0, 0, 0, 0], &[("m3/s m^3/s", 1.0), ("m3/h m^3/h", 1.0 / 3600.0), ("l/min L/min", 1e-3 / 60.0)]),
    ([1, 2, -3, -1, 0, 0, 0, 0], &[("V Volts", 1.0), ("mV", 1e-3)]),
    ([0, 0, 0, 1, 0, 0, 0, 0], &[("A", 1.0), ("mA", 1e-3)]),
];

/// The units of a name: none, one, or several of different kinds, each with its exponents.
fn named(name: &str) -> impl Iterator<Item = (Exponents, Named)> {
    let name = plain(name).replace('*', ".");
    KNOWN
        .iter()
        .flat_map(|(exponents, units)| units.iter().map(|unit| (*exponents, *unit)))
        .filter(move |(_, (names, _))| names.split(' ').any(|known| known == name))
}

fn first(names: &'static str) -> &'static str {
    names.split(' ').next().unwrap_or(names)
}

/// The usual name of a unit, such as `N.m` for `Nm` and `rpm` for `1/min`; `None` of an unknown one.
pub fn usual(name: &str) -> Option<&'static str> {
    named(name).last().map(|(_, (names, _))| first(names))
}

/// Whether a name is a known unit, or one in other letters or with another prefix: `KN`, `mW`.
pub fn is_like(name: &str) -> bool {
    let named = plain(name);
    let bare = named.strip_prefix(['n', 'u', 'm', 'c', 'k', 'M', 'G']).filter(|bare| !["h", "d", "%"].contains(bare));
    let mut names = KNOWN.iter().flat_map(|(_, units)| *units).flat_map(|(names, _)| names.split(' '));
    [Some(name), bare].into_iter().flatten().any(|name| usual(name).is_some())
        || name.len() > 1 && names.any(|known| named.eq_ignore_ascii_case(known))
}

/// What a name means in SI base units: nothing, one thing, or several of different kinds.
pub(super) fn meanings(name: &str) -> impl Iterator<Item = BaseUnit> {
    named(name).map(|(exponents, (names, factor))| {
        let offset = match first(names) {
            "degC" => 273.15,
            "degF" => 459.67 * 5.0 / 9.0,
            _ => 0.0,
        };
        BaseUnit { exponents, to_base: Conversion { factor, offset } }
    })
}

/// How values in one unit become values in another one of the same kind, by their names alone.
pub fn between(from: &str, to: &str) -> Option<Conversion> {
    let mut alike =
        meanings(from).flat_map(|a| meanings(to).map(move |b| (a, b))).filter(|(a, b)| a.exponents == b.exponents);
    alike.next().map(|(from, to)| from.to_base.then(to.to_base.inverse()))
}

/// The usual names of all units of a unit's kind.
pub fn alike(unit: &str) -> Vec<&'static str> {
    let kinds: Vec<Exponents> = named(unit).map(|(kind, _)| kind).collect();
    KNOWN
        .iter()
        .filter(|(kind, _)| kinds.contains(kind))
        .flat_map(|(_, units)| units.iter().map(|(names, _)| first(names)))
        .collect()
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
