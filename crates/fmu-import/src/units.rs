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
#[error("unit `{from}` {fault}: the value is in {to}; use {}{remedy}", known.join(", "))]
pub struct UnitError {
    from: String,
    fault: &'static str,
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
    /// The FMU's definitions decide what a name means; [`known`] names fill in those that it does not define.
    ///
    /// # Errors
    /// When neither knows a way from one to the other, and when they leave a factor of 2 pi open.
    pub fn conversion(&self, from: &str, to: Option<&str>) -> Result<Conversion, UnitError> {
        let from = plain(from);
        let ways = self.ways(to);
        if let Some((_, way)) = ways.iter().find(|(name, _)| plain(name) == from) {
            return Ok(*way);
        }
        if let Some(way) = self.by_base(&from, to) {
            return Ok(way);
        }
        let to = to.filter(|_| !self.is_no_unit(to));
        let remedy = match to {
            Some(_) => "",
            None => "; give the number alone, or say that it has no unit",
        };
        // A unit that nobody defines, and one of another quantity, are two mistakes.
        let fault = if self.meanings(&from).is_empty() && !self.0.contains_key(&from) {
            "is not known"
        } else {
            "does not fit"
        };
        Err(UnitError {
            from,
            fault,
            remedy,
            to: to.unwrap_or("no unit").to_owned(),
            known: if ways.is_empty() {
                vec!["a number alone".to_owned()]
            } else {
                ways.into_iter().map(|(name, _)| name).collect()
            },
        })
    }

    /// Every unit in which a value of unit `to` may be given, and how it converts.
    fn ways(&self, to: Option<&str>) -> Vec<(String, Conversion)> {
        let Some(to) = to.filter(|_| !self.is_no_unit(to)) else {
            return [("1", 1.0, self.is_number("1")), ("%", 0.01, !self.defines("%"))]
                .into_iter()
                .filter(|(.., means_it)| *means_it)
                .map(|(name, factor, _)| (name.to_owned(), Conversion::scaled(factor)))
                .collect();
        };
        let mut ways = vec![(to.to_owned(), Conversion::IDENTITY)];
        let Some(unit) = self.0.get(to) else { return ways };
        ways.extend(unit.displays());
        let Some(base) = unit.base.filter(BaseUnit::converts) else { return ways };
        for (name, other) in &self.0 {
            let Some(other_base) =
                other.base.filter(|other| name != to && other.exponents == base.exponents && other.converts())
            else {
                continue;
            };
            let way = other_base.to_base.then(base.to_base.inverse());
            ways.push((name.clone(), way));
            ways.extend(other.displays().map(|(name, to_unit)| (name, to_unit.then(way))));
        }
        ways
    }

    /// The way by the meanings of both names in SI base units.
    fn by_base(&self, from: &str, to: Option<&str>) -> Option<Conversion> {
        let wanted = match to.filter(|_| !self.is_no_unit(to)) {
            Some(to) => self.meanings(&plain(to)),
            None => vec![BaseUnit::NUMBER],
        };
        let given = self.meanings(from);
        let (one, other) = given
            .iter()
            .flat_map(|from| wanted.iter().map(move |to| (from, to)))
            .clone()
            .find(|(from, to)| from.exponents == to.exponents)?;
        // Many FMUs leave out rad. Where the name of the FMU's unit does not say whether it is a frequency or an angular
        // velocity, a turn a minute could be either.
        let but_for_rad = |a: &BaseUnit, b: &BaseUnit| a.exponents[..7] == b.exponents[..7];
        let is_open = given.iter().any(|from| from.exponents != other.exponents && but_for_rad(from, other));
        if is_open && to.is_some_and(|to| known::meanings(to).next().is_none()) {
            return None;
        }
        Some(one.to_base.then(other.to_base.inverse()))
    }

    /// Whether a value of this unit has none. An FMU may define `1` or `-` as anything; a variable without a unit has nothing of
    /// that.
    fn is_no_unit(&self, unit: Option<&str>) -> bool {
        unit.is_none_or(|name| name.is_empty() || matches!(name, "1" | "-") && self.is_number(name))
    }

    /// Whether a name means a mere number.
    fn is_number(&self, name: &str) -> bool {
        self.meanings(name) == [BaseUnit::NUMBER]
    }

    /// What a name means: as the FMU defines it, else as people use it.
    fn meanings(&self, name: &str) -> Vec<BaseUnit> {
        if !self.defines(name) {
            return known::meanings(name).collect();
        }
        let mut meanings = Vec::new();
        for (unit_name, unit) in &self.0 {
            let bases: Vec<BaseUnit> = match unit.base {
                Some(base) => vec![with_rad(unit_name, base)],
                None => known::meanings(unit_name).collect(),
            };
            if plain(unit_name) == name {
                meanings.extend(&bases);
            }
            for (_, to_unit) in unit.displays().filter(|(display, _)| plain(display) == name) {
                meanings.extend(bases.iter().map(|base| BaseUnit { to_base: to_unit.then(base.to_base), ..*base }));
            }
        }
        meanings.retain(BaseUnit::converts);
        meanings
    }

    /// Whether the FMU says what a name means: a unit with its relation to SI base units, or a display unit.
    fn defines(&self, name: &str) -> bool {
        self.0.iter().any(|(unit_name, unit)| {
            unit.base.is_some() && plain(unit_name) == name
                || unit.display.iter().any(|shown| plain(&shown.name) == name)
        })
    }
}

/// The base of a unit whose usual meaning differs from it in nothing but rad, which the FMU left out, with that rad.
fn with_rad(name: &str, base: BaseUnit) -> BaseUnit {
    let usual: Vec<BaseUnit> = known::meanings(name)
        .filter(|usual| {
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b.abs();
            usual.exponents[..7] == base.exponents[..7]
                && close(base.to_base.factor, usual.to_base.factor)
                && close(base.to_base.offset, usual.to_base.offset)
        })
        .collect();
    match usual.first() {
        Some(first) if base.exponents[7] == 0 && usual.iter().all(|usual| usual.exponents[7] != 0) => {
            BaseUnit { exponents: first.exponents, ..base }
        }
        _ => base,
    }
}

impl BaseUnit {
    /// The names of the SI base units, in the order of the exponents.
    pub const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
    /// A number without a unit.
    const NUMBER: Self = Self { exponents: [0; 8], to_base: Conversion::IDENTITY };

    /// What an FMU defines twice, in two ways.
    pub(crate) const OPEN: Self = Self { exponents: [0; 8], to_base: Conversion::scaled(0.0) };

    /// Whether values convert both ways.
    fn converts(&self) -> bool {
        self.to_base.factor != 0.0 && self.to_base.factor.is_finite() && self.to_base.offset.is_finite()
    }
}

impl Unit {
    /// The display units, with the conversion to this unit. One with factor 0 converts nothing.
    fn displays(&self) -> impl Iterator<Item = (String, Conversion)> {
        self.display
            .iter()
            .filter(|display| display.from_unit.factor != 0.0)
            .map(|display| (display.name.clone(), display.from_unit.inverse()))
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
    if let Some(rest) = text.strip_prefix('±').or_else(|| text.strip_prefix("+-")) {
        return Err(format!("`{text}`: write it without the sign, `{}`", rest.trim()));
    }
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
mod systems_tests;

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
        assert_eq!(error.to_string(), "unit `degC` does not fit: the value is in m; use m, mm, um, in, mil");
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
