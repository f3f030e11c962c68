//! Units, as the FMU itself defines them, and values with units.
//!
//! FMI 2.0 defines a unit by its SI base exponents with `base = factor * value + offset`, and a
//! display unit of it by `display = factor * value + offset` (FMI 2.0.4, section 2.2.2).

pub mod known;

use indexmap::IndexMap;
use serde::Serialize;
use thiserror::Error;

/// A unit in terms of SI base units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct BaseUnit {
    /// Exponents of kg, m, s, A, K, mol, cd, rad.
    pub exponents: [i32; 8],
    /// How a value becomes one in base units.
    #[serde(flatten)]
    pub to_base: Conversion,
}

/// Another way to show a unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplayUnit {
    /// Its name.
    pub name: String,
    /// How a value in the unit becomes one in this.
    #[serde(flatten)]
    pub from_unit: Conversion,
}

/// A unit definition.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Unit {
    /// Its relation to SI base units, where that is known.
    pub base: Option<BaseUnit>,
    /// Other ways to show it.
    pub display: Vec<DisplayUnit>,
}

/// The unit definitions of an FMU, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Units(pub IndexMap<String, Unit>);

/// A change of unit: `to = factor * from + offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Conversion {
    /// The factor of a value.
    pub factor: f64,
    /// The offset that is added then.
    pub offset: f64,
}

/// Why a unit does not fit.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("unit `{from}` does not fit: the value is in {to}; use {}{remedy}", known.join(", "))]
pub struct UnitError {
    from: String,
    to: String,
    known: Vec<String>,
    remedy: &'static str,
}

impl Conversion {
    /// No change at all.
    pub const IDENTITY: Self = Self::scaled(1.0);

    /// The change between two units of the same zero.
    pub const fn scaled(factor: f64) -> Self {
        Self { factor, offset: 0.0 }
    }

    /// Converts a value.
    pub fn value(self, value: f64) -> f64 {
        self.factor * value + self.offset
    }

    /// Converts a difference of two values, such as a tolerance: 0.5 degC is 0.5 K.
    pub fn difference(self, difference: f64) -> f64 {
        self.factor * difference
    }

    /// The change of a difference of two values, which has no offset.
    pub fn of_differences(self) -> Self {
        Self { offset: 0.0, ..self }
    }

    /// The way back.
    pub fn inverse(self) -> Self {
        Self { factor: 1.0 / self.factor, offset: -self.offset / self.factor }
    }

    /// The conversion that applies this one, then another.
    pub fn then(self, next: Self) -> Self {
        Self { factor: self.factor * next.factor, offset: next.value(self.offset) }
    }
}

impl Units {
    /// How values in `from` become values in `to`; `None` is a value without a unit.
    ///
    /// The FMU's definitions decide. [`known`] names only fill in units that it does not define: another name is never
    /// converted by what it usually means.
    ///
    /// # Errors
    /// When neither the FMU's definitions nor [`known`] names know a way from one to the other.
    pub fn conversion(&self, from: &str, to: Option<&str>) -> Result<Conversion, UnitError> {
        let from = plain(from);
        let ways = self.ways(to);
        if let Some((_, way)) = ways.iter().find(|(name, _)| plain(name) == from) {
            return Ok(*way);
        }
        let to_unit = to.filter(|unit| !is_none(unit));
        if let Some(way) = way(&self.meanings(&from), &self.meanings(to_unit.unwrap_or("1"))) {
            return Ok(way);
        }
        let remedy = match to.filter(|unit| *unit != "1") {
            Some(_) => "",
            None => ", of a recording `unit = \"1\"` and its `scale` in the settings of synchronise",
        };
        Err(UnitError {
            from,
            remedy,
            to: to.filter(|unit| *unit != "1").unwrap_or("no unit").to_owned(),
            known: ways.into_iter().map(|(name, _)| name).collect(),
        })
    }

    /// What a name means, in base units: as the FMU defines it, or as usual where it does not.
    fn meanings(&self, name: &str) -> Vec<BaseUnit> {
        let name = plain(name);
        let usual = known::meanings(&name);
        if let Some((_, unit)) = self.0.iter().find(|(own, _)| plain(own) == name) {
            return match unit.base {
                Some(base) => vec![with_radians(base, &usual)],
                None => usual,
            };
        }
        let shown = self.0.values().filter_map(|unit| {
            let (_, to_unit) = unit.displays().find(|(own, _)| plain(own) == name)?;
            Some(unit.base.map(|base| BaseUnit { to_base: to_unit.then(base.to_base), ..base }))
        });
        let shown: Vec<Option<BaseUnit>> = shown.collect();
        if shown.is_empty() { usual } else { shown.into_iter().flatten().collect() }
    }

    /// Every unit in which a value of unit `to` may be given, and how it converts.
    fn ways(&self, to: Option<&str>) -> Vec<(String, Conversion)> {
        let Some(to) = to.filter(|unit| !is_none(unit)) else {
            let percent = way(&self.meanings("%"), &known::meanings("1"));
            let percent = percent.map(|way| ("%".to_owned(), way));
            return [("1".to_owned(), Conversion::IDENTITY)].into_iter().chain(percent).collect();
        };
        let mut ways = vec![(to.to_owned(), Conversion::IDENTITY)];
        let Some(unit) = self.0.get(to) else {
            return ways;
        };
        ways.extend(unit.displays());
        let Some(base) = unit.base.filter(BaseUnit::is_usable) else { return ways };
        for (name, other) in &self.0 {
            let alike = |other: &BaseUnit| name != to && other.exponents == base.exponents && other.is_usable();
            let Some(other_base) = other.base.filter(alike) else {
                continue;
            };
            let way = other_base.to_base.then(base.to_base.inverse());
            ways.push((name.clone(), way));
            ways.extend(other.displays().map(|(name, to_unit)| (name, to_unit.then(way))));
        }
        ways
    }
}

impl BaseUnit {
    /// Whether values convert at all: with factor 0 they do not.
    fn is_usable(&self) -> bool {
        self.to_base.factor != 0.0
    }
}

/// Whether a unit's name says that there is none.
fn is_none(unit: &str) -> bool {
    matches!(unit, "1" | "" | "-")
}

/// The way from a unit of several meanings to another one: by the first two of the same kind.
fn way(from: &[BaseUnit], to: &[BaseUnit]) -> Option<Conversion> {
    let mut pairs = from.iter().flat_map(|a| to.iter().map(move |b| (a, b)));
    let (from, to) = pairs.find(|(a, b)| a.exponents == b.exponents && a.is_usable() && b.is_usable())?;
    Some(from.to_base.then(to.to_base.inverse()))
}

/// The unit with the exponent of rad that its name has: many tools leave it out, as before FMI 2.0 there was none. Whatever
/// else differs from the usual meaning is meant.
fn with_radians(base: BaseUnit, usual: &[BaseUnit]) -> BaseUnit {
    const RAD: usize = 7;
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs();
    let is_same = |usual: &&BaseUnit, ignoring_rad: bool| {
        let mut exponents = usual.exponents;
        if ignoring_rad && base.exponents[RAD] == 0 {
            exponents[RAD] = 0;
        }
        let [own, other] = [base.to_base, usual.to_base];
        exponents == base.exponents && near(own.factor, other.factor) && near(own.offset, other.offset)
    };
    let same = |ignoring| usual.iter().find(|usual| is_same(usual, ignoring));
    same(false).or_else(|| same(true)).copied().map_or(base, |usual| BaseUnit { exponents: usual.exponents, ..base })
}

impl Unit {
    /// The display units, with the conversion to this unit. One with factor 0 converts nothing.
    fn displays(&self) -> impl Iterator<Item = (String, Conversion)> {
        let usable = self.display.iter().filter(|display| display.from_unit.factor != 0.0);
        usable.map(|display| (display.name.clone(), display.from_unit.inverse()))
    }
}

/// A unit's name without typographic differences: `°C` is `degC`, `µm` is `um`.
fn plain(name: &str) -> String {
    name.trim()
        .replace('°', "deg")
        .replace(['µ', 'μ'], "u")
        .replace(['·', '⋅'], ".")
        .replace('²', "2")
        .replace('³', "3")
}

/// Splits `0.02 mm` into its number and its unit.
///
/// # Errors
/// Says what is wrong when the text does not start with a number.
pub fn split(text: &str) -> Result<(f64, Option<&str>), String> {
    let text = text.trim();
    let numeric = |start: &str| start.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
    // The longest start that is a number: `1e-5 m`, `3 eV`, `5%`.
    let end = (1..=text.len())
        .filter(|&end| text.is_char_boundary(end) && numeric(&text[..end]))
        .rfind(|&end| text[..end].parse::<f64>().is_ok())
        .ok_or_else(|| format!("`{text}` is not a number, or a number with a unit"))?;
    let number = text[..end].parse::<f64>().unwrap_or(f64::NAN);
    let unit = text[end..].trim();
    if unit.starts_with(',') {
        return Err(format!("`{text}`: write a point in the number instead of the comma"));
    }
    Ok((number, (!unit.is_empty()).then_some(unit)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn units() -> Units {
        let mut units = Units::default();
        let mut unit = |name: &str, exponents, factor, offset, display: &[(&str, f64, f64)]| {
            let display = display.iter().map(|(name, factor, offset)| DisplayUnit {
                name: (*name).to_owned(),
                from_unit: Conversion { factor: *factor, offset: *offset },
            });
            let base = Some(BaseUnit { exponents, to_base: Conversion { factor, offset } });
            units.0.insert(name.to_owned(), Unit { base, display: display.collect() });
        };
        let (length, temperature) = ([0, 1, 0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 1, 0, 0, 0]);
        unit("m", length, 1.0, 0.0, &[("mm", 1e3, 0.0), ("um", 1e6, 0.0)]);
        unit("in", length, 0.0254, 0.0, &[("mil", 1e3, 0.0)]);
        unit("K", temperature, 1.0, 0.0, &[("degC", 1.0, -273.15)]);
        unit("cel", temperature, 1.0, 273.15, &[]);
        unit("t", [1, 0, 0, 0, 0, 0, 0, 0], 1e3, 0.0, &[]);
        unit("kcal", [1, 2, -2, 0, 0, 0, 0, 0], 4184.0, 0.0, &[]);
        // Names that usually mean something else.
        unit("h", length, 1.0, 0.0, &[("g", 100.0, 0.0)]);
        unit("1/s", [0, 0, -1, 0, 0, 0, 0, 0], 1.0, 0.0, &[]);
        unit("rad/s", [0, 0, -1, 0, 0, 0, 0, 1], 1.0, 0.0, &[("rpm", 10.0, 0.0)]);
        unit("deg/s", [0, 0, -1, 0, 0, 0, 0, 0], std::f64::consts::PI / 180.0, 0.0, &[]);
        unit("bar", [0; 8], 0.5, 0.0, &[]);
        unit("W", [1, 2, -3, 0, 0, 0, 0, 0], 0.0, 0.0, &[]);
        unit("degF", temperature, 5.0 / 9.0, 459.67 * 5.0 / 9.0, &[]);
        units
    }

    #[test]
    fn display_units_and_units_of_the_same_kind_convert() {
        let units = units();
        let close = |from: &str, to: &str, value: f64, expected: f64| {
            let result = units.conversion(from, Some(to)).unwrap().value(value);
            assert!((result - expected).abs() < 1e-9 * expected.abs(), "{result} {expected}");
        };
        close("mm", "m", 0.02, 2e-5);
        close("degC", "K", 82.0, 355.15);
        close("°C", "K", 82.0, 355.15);
        close("mil", "m", 10.0, 2.54e-4);
        close("um", "in", 25_400.0, 1.0);
        close("degC", "degF", 100.0, 212.0);
    }

    /// By hand from the base units above: `base = factor * value + offset`.
    #[test]
    fn the_definitions_of_the_fmu_decide() {
        let mut units = units();
        units.0.insert("N".to_owned(), Unit::default());
        for (from, to, value, expected) in [
            ("degC", "cel", 20.0, Some(20.0)),
            ("cel", "degF", 100.0, Some(212.0)),
            ("K", "cel", 300.0, Some(26.85)),
            ("kg", "t", 500.0, Some(0.5)),
            ("g", "t", 500.0, None),
            ("J", "kcal", 8368.0, Some(2.0)),
            ("kcal", "kJ", 1.0, Some(4.184)),
            ("m", "h", 3.0, Some(3.0)),
            ("g", "m", 100.0, Some(1.0)),
            ("s", "h", 60.0, None),
            ("min", "h", 60.0, None),
            ("h", "s", 1.0, None),
            ("Hz", "1/s", 5.0, Some(5.0)),
            ("kHz", "1/s", 1.0, Some(1000.0)),
            ("1/s", "rad/s", 1.0, None),
            ("rad/s", "1/s", 1.0, None),
            ("rev/s", "rad/s", 1.0, Some(std::f64::consts::TAU)),
            ("rpm", "rad/s", 10.0, Some(1.0)),
            ("rpm", "1/s", 60.0, None),
            ("deg/s", "rad/s", 180.0, Some(std::f64::consts::PI)),
            ("bar", "Pa", 1.0, None),
            ("Pa", "bar", 1.0, None),
            ("bar", "1", 1.0, Some(0.5)),
            ("%", "1", 5.0, Some(0.05)),
            ("kW", "W", 1.0, None),
            ("kN", "N", 2.0, Some(2000.0)),
            ("Nm", "bar", 2.0, None),
            ("mm", "in", 25.4, Some(1.0)),
            ("cm", "in", 2.54, Some(1.0)),
            ("ft", "in", 1.0, None),
        ] {
            let got = units.conversion(from, Some(to)).ok().map(|way| way.value(value));
            let same = match (got, expected) {
                (Some(got), Some(expected)) => (got - expected).abs() < 1e-9 * expected.abs(),
                (got, expected) => got == expected,
            };
            assert!(same, "{value} {from} in {to}: {got:?}, not {expected:?}");
        }
        // A unit of its own for per cent.
        let percent = BaseUnit { exponents: [0; 8], to_base: Conversion::scaled(0.02) };
        units.0.insert("%".to_owned(), Unit { base: Some(percent), display: Vec::new() });
        assert_eq!(units.conversion("%", None).unwrap().value(5.0), 0.1);
    }

    #[test]
    fn differences_have_no_offset() {
        let conversion = units().conversion("degC", Some("K")).unwrap();
        assert_eq!(conversion.difference(0.5), 0.5);
    }

    #[test]
    fn percent_goes_with_no_unit() {
        let conversion = units().conversion("%", None).unwrap();
        assert_eq!(conversion.value(5.0), 0.05);
    }

    #[test]
    fn an_unfit_unit_is_answered_with_those_that_fit() {
        let error = units().conversion("degC", Some("m")).unwrap_err();
        assert_eq!(error.to_string(), "unit `degC` does not fit: the value is in m; use m, mm, um, in, mil, h, g");
    }

    #[test]
    fn texts_split_into_number_and_unit() {
        assert_eq!(split("0.02 mm"), Ok((0.02, Some("mm"))));
        assert_eq!(split("-1.5e-3"), Ok((-1.5e-3, None)));
        assert_eq!(split("7%"), Ok((7.0, Some("%"))));
        assert_eq!(split("3 eV"), Ok((3.0, Some("eV"))));
        assert!(split("mm").is_err());
        assert!(split("").is_err());
    }
}
