//! Variables: role, type, unit, range, description, and how the model's value is read and written.

use super::{Fault, Model};

/// Who sets a variable, and when.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Set by the host at any communication point.
    Input,
    /// Set by the host before the start.
    Parameter,
    /// Set by the host before the start, and changeable while running.
    TunableParameter,
    /// Computed, for other models to use.
    Output,
    /// Computed, for people who look inside.
    Local,
}

/// A display unit: `display = factor * si + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayUnit {
    /// The name, as users write it.
    pub name: &'static str,
    /// Factor from the SI value.
    pub factor: f64,
    /// Offset, in the display unit.
    pub offset: f64,
}

/// Exponents of the SI base units and the radian, in the order of FMI.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BaseExponents {
    /// Kilogram.
    pub kg: i32,
    /// Metre.
    pub m: i32,
    /// Second.
    pub s: i32,
    /// Ampere.
    pub a: i32,
    /// Kelvin.
    pub k: i32,
    /// Mole.
    pub mol: i32,
    /// Candela.
    pub cd: i32,
    /// Radian.
    pub rad: i32,
}

impl BaseExponents {
    /// All exponents zero: a ratio or a count.
    pub const ONE: Self = Self { kg: 0, m: 0, s: 0, a: 0, k: 0, mol: 0, cd: 0, rad: 0 };

    /// The exponents with the names that FMI gives the base units.
    pub fn named(&self) -> [(&'static str, i32); 8] {
        [
            ("kg", self.kg),
            ("m", self.m),
            ("s", self.s),
            ("A", self.a),
            ("K", self.k),
            ("mol", self.mol),
            ("cd", self.cd),
            ("rad", self.rad),
        ]
    }
}

/// A unit, its SI base units, and the display units that go with it. All values of a model are in SI units;
/// [`units`](crate::units) has the usual ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The name, as users write it.
    pub name: &'static str,
    /// The exponents of the base units.
    pub base: BaseExponents,
    /// The display units.
    pub display: &'static [DisplayUnit],
    /// Values are differences, as of temperatures: offsets of display units do not count.
    pub relative: bool,
}

/// One item of an enumeration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// The item's name.
    pub name: &'static str,
    /// The item's value.
    pub value: i32,
    /// Its meaning, for people.
    pub description: &'static str,
}

/// An enumeration type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// The type's name.
    pub name: &'static str,
    /// Its meaning, for people.
    pub description: &'static str,
    /// Its items.
    pub items: &'static [Item],
}

impl Enumeration {
    /// The items' values and names, for messages.
    pub(crate) fn listed(&self) -> String {
        (self.items.iter()).map(|item| format!("{} ({})", item.value, item.name)).collect::<Vec<_>>().join(", ")
    }
}

/// How a value is read from the model and written to it. `set` is `None` for what the model computes.
pub struct Access<M, T: ?Sized + 'static, R> {
    /// Reads the value.
    pub get: fn(&M) -> R,
    /// Writes the value.
    pub set: Option<fn(&mut M, &T)>,
}

/// A real number in SI units.
pub struct Quantity<M: 'static> {
    /// Read and write.
    pub access: Access<M, f64, f64>,
    /// The unit.
    pub unit: &'static Unit,
    /// Name of the preferred display unit, one of `unit.display`.
    pub display: Option<&'static str>,
    /// The smallest value that makes sense (inclusive).
    pub min: Option<f64>,
    /// The largest value that makes sense (inclusive).
    pub max: Option<f64>,
    /// A typical magnitude.
    pub nominal: Option<f64>,
    /// For inputs that may vary linearly within a step: sets the rate, per second. It is set back to zero after the step.
    pub slope: Option<fn(&mut M, f64)>,
    /// For outputs whose time derivative the model knows: reads it, per second, after [`Model::differentiate`]. Without it,
    /// the boundary steps a copy a little ahead and takes the difference.
    pub derivative: Option<fn(&M) -> f64>,
}

/// A variable's type with its type-specific attributes and its access.
pub enum Kind<M: 'static> {
    /// A real number in SI units.
    Real(Quantity<M>),
    /// A whole number.
    Integer {
        /// Read and write.
        access: Access<M, i32, i32>,
        /// The smallest value (inclusive).
        min: Option<i32>,
        /// The largest value (inclusive).
        max: Option<i32>,
    },
    /// True or false.
    Boolean {
        /// Read and write.
        access: Access<M, bool, bool>,
    },
    /// One of several named values.
    Enumeration {
        /// Read and write.
        access: Access<M, i32, i32>,
        /// The type.
        of: &'static Enumeration,
    },
    /// A text.
    String {
        /// Read and write.
        access: Access<M, str, String>,
    },
    /// An output that ticks at [events](Model::EVENTS), in FMI 3.0; FMI 2.0 has no clocks.
    Clock {
        /// Whether the events that were handled last have let it tick.
        ticked: fn(&M) -> bool,
    },
}

/// One variable of a model.
pub struct Variable<M: 'static> {
    /// The structured name, such as `bearing.radialClearance`.
    pub name: &'static str,
    /// One sentence for users.
    pub description: &'static str,
    /// Who sets it, and when.
    pub role: Role,
    /// Its type, attributes and access.
    pub kind: Kind<M>,
    /// For outputs: the names of the inputs on which the value depends directly, at the same instant
    /// (at the start, too).
    pub depends_on: &'static [&'static str],
    /// How many variables of the table from this one on are the elements of an array, which they are in FMI 3.0; else 1.
    pub elements: usize,
    /// The name of the clock at whose ticks alone it changes.
    pub clock: Option<&'static str>,
}

impl<M> Variable<M> {
    /// The name of the array whose first element it is; else its own.
    pub fn array_name(&self) -> &'static str {
        self.name.strip_suffix("[1]").filter(|_| self.elements > 1).unwrap_or(self.name)
    }

    /// The name that FMI gives the variable's type.
    pub fn type_name(&self) -> &'static str {
        match self.kind {
            Kind::Real(_) => "Real",
            Kind::Integer { .. } => "Integer",
            Kind::Boolean { .. } => "Boolean",
            Kind::Enumeration { .. } => "Enumeration",
            Kind::String { .. } => "String",
            Kind::Clock { .. } => "Clock",
        }
    }
}

/// The variables of a model's table that the one at a place stands for: the elements of an array, or itself.
pub fn elements<M: Model>(place: usize) -> &'static [Variable<M>] {
    let table = M::variables();
    let count = table.get(place).map_or(1, |variable| variable.elements);
    table.get(place..place + count).unwrap_or_default()
}

/// The variable of a name.
pub fn named<M: Model>(name: &str) -> Option<&'static Variable<M>> {
    M::variables().iter().find(|variable| variable.name == name)
}

/// Whether a value lies within the bounds, if there are any.
pub fn inside<T: PartialOrd>(value: T, min: Option<T>, max: Option<T>) -> bool {
    min.is_none_or(|min| value >= min) && max.is_none_or(|max| value <= max)
}

/// Checks every parameter and input of a model against its declared range.
///
/// # Errors
/// Names the first variable whose value lies outside.
pub fn check_ranges<M: Model>(model: &M) -> Result<(), Fault> {
    check_ranges_of(model, |_| true)
}

/// The same for what no host can have changed since the start: bytes of a saved state may hold anything.
///
/// # Errors
/// Names the first variable whose value lies outside.
pub fn check_fixed<M: Model>(model: &M) -> Result<(), Fault> {
    check_ranges_of(model, |role| role == Role::Parameter)
}

fn check_ranges_of<M: Model>(model: &M, wanted: impl Fn(Role) -> bool) -> Result<(), Fault> {
    for variable in M::variables().iter().filter(|variable| wanted(variable.role)) {
        match &variable.kind {
            Kind::Real(real) if real.access.set.is_some() => {
                let (value, unit) = ((real.access.get)(model), real.unit.name);
                let least = real.min.unwrap_or(f64::MIN);
                let most = real.max.unwrap_or(f64::MAX);
                // Written so that NaN is refused, too.
                if !(least <= value && value <= most) {
                    return Err(Fault::Invalid(format!(
                        "{} = {value:?} {unit}: it must lie between {least:?} and {most:?} {unit}",
                        variable.name
                    )));
                }
            }
            Kind::Integer { access, min, max } if access.set.is_some() => {
                let value = (access.get)(model);
                let (least, most) = (min.unwrap_or(i32::MIN), max.unwrap_or(i32::MAX));
                if !(least..=most).contains(&value) {
                    return Err(Fault::Invalid(format!(
                        "{} = {value}: it must lie between {least} and {most}",
                        variable.name
                    )));
                }
            }
            Kind::Enumeration { access, of } if access.set.is_some() => {
                let value = (access.get)(model);
                if !of.items.iter().any(|item| item.value == value) {
                    return Err(Fault::Invalid(format!(
                        "{} = {value}: it must be one of {}",
                        variable.name,
                        of.listed()
                    )));
                }
            }
            _ => {}
        }
    }
    Ok(())
}
