//! Units that people and loggers write, whether an FMU defines them or not.

use std::{f64::consts::TAU, sync::LazyLock};

use super::{BaseUnit, Conversion, plain};

/// A unit with a row in `known.txt`.
struct KnownUnit {
    /// Its names, the usual one first.
    names: Vec<&'static str>,
    /// What it is in SI base units.
    base: BaseUnit,
}

/// All rows. A turn a minute is an angular velocity in one FMU and a frequency in another one; an energy has the base units of a
/// torque.
static KNOWN: LazyLock<Vec<KnownUnit>> =
    LazyLock::new(|| include_str!("known.txt").lines().skip(1).map(KnownUnit::of_row).collect());

impl KnownUnit {
    fn of_row(row: &'static str) -> Self {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [names, exponents, factor, offset] = cells[..] else { panic!("a row has four cells: {row}") };
        let exponents: Vec<i32> = exponents.split(' ').map(|one| one.parse().expect("a whole number")).collect();
        let exponents = exponents.try_into().expect("there are eight base units");
        let to_base = Conversion { factor: quotient(factor), offset: quotient(offset) };
        Self { names: names.split(' ').collect(), base: BaseUnit { exponents, to_base } }
    }

    fn usual_name(&self) -> &'static str {
        self.names[0]
    }
}

/// A number of `known.txt`: `60`, `tau`, `1/3.6`.
fn quotient(text: &str) -> f64 {
    let number = |text: &str| if text == "tau" { TAU } else { text.parse().expect("a number") };
    text.split_once('/').map_or_else(|| number(text), |(over, under)| number(over) / number(under))
}

/// The units of a name: none, one, or several of different kinds.
fn named(name: &str) -> impl Iterator<Item = &'static KnownUnit> {
    let name = plain(name).replace('*', ".");
    KNOWN.iter().filter(move |unit| unit.names.contains(&name.as_str()))
}

/// The usual name of a unit, such as `N.m` for `Nm` and `rpm` for `1/min`; `None` of an unknown one.
pub fn usual(name: &str) -> Option<&'static str> {
    // Of `1/min`, the angular velocity is the last one.
    named(name).last().map(KnownUnit::usual_name)
}

/// Whether a name is a known unit, or one in other letters or with another prefix: `KN`, `mW`.
pub fn is_like(name: &str) -> bool {
    let named = plain(name);
    let bare = named
        .strip_prefix(['n', 'u', 'm', 'c', 'k', 'M', 'G'])
        .filter(|bare| !["1", "-", "h", "d", "%"].contains(bare));
    let mut names = KNOWN.iter().flat_map(|unit| &unit.names);
    [Some(name), bare].into_iter().flatten().any(|name| usual(name).is_some())
        || name.len() > 1 && names.any(|known| named.eq_ignore_ascii_case(known))
}

/// What a name means in SI base units: nothing, one thing, or several of different kinds.
pub(super) fn meanings(name: &str) -> impl Iterator<Item = BaseUnit> {
    named(name).map(|unit| unit.base)
}

/// How values in one unit become values in another one of the same kind, by their names alone.
pub fn between(from: &str, to: &str) -> Option<Conversion> {
    let mut alike =
        meanings(from).flat_map(|a| meanings(to).map(move |b| (a, b))).filter(|(a, b)| a.exponents == b.exponents);
    alike.next().map(|(from, to)| from.to_base.then(to.to_base.inverse()))
}

/// The usual names of all units of a unit's kind.
pub fn alike(unit: &str) -> Vec<&'static str> {
    let kinds: Vec<_> = meanings(unit).map(|base| base.exponents).collect();
    KNOWN.iter().filter(|known| kinds.contains(&known.base.exponents)).map(KnownUnit::usual_name).collect()
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
