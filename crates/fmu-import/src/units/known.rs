//! Units that people and loggers write, whether an FMU defines them or not.

use std::{f64::consts::TAU, sync::LazyLock};

use super::{BaseUnit, Conversion, plain};

type Exponents = [i32; 8];

/// Names of a unit, the usual one first, and its factor to base units.
type Named = (&'static str, f64);

/// Units that `known.txt` has a row for: names, the usual one first, exponents and factor to base units. A turn a minute is an angular
/// velocity in one FMU and a frequency in another one; an energy has the base units of a torque.
static KNOWN: LazyLock<Vec<(Exponents, Named)>> =
    LazyLock::new(|| include_str!("known.txt").lines().skip(1).map(row).collect());

fn row(row: &'static str) -> (Exponents, Named) {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let [names, exponents, factor] = cells[..] else { panic!("a row has three cells: {row}") };
    let exponents: Vec<i32> = exponents.split(' ').map(|one| one.parse().expect("it is a whole number")).collect();
    let number = |text: &str| if text == "tau" { TAU } else { text.parse().expect("it is a number") };
    let factor = factor.split_once('/').map_or_else(|| number(factor), |(over, under)| number(over) / number(under));
    (exponents.try_into().expect("there are eight base units"), (names, factor))
}

/// The units of a name: none, one, or several of different kinds, each with its exponents.
fn named(name: &str) -> impl Iterator<Item = (Exponents, Named)> {
    let name = plain(name).replace('*', ".");
    KNOWN.iter().copied().filter(move |(_, (names, _))| names.split(' ').any(|known| known == name))
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
    let bare = named
        .strip_prefix(['n', 'u', 'm', 'c', 'k', 'M', 'G'])
        .filter(|bare| !["1", "-", "h", "d", "%"].contains(bare));
    let mut names = KNOWN.iter().flat_map(|(_, (names, _))| names.split(' '));
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
    KNOWN.iter().filter(|(kind, _)| kinds.contains(kind)).map(|(_, (names, _))| first(names)).collect()
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
