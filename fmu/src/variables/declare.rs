//! Short forms for the access to the stand's variables.

use crate::stand::Stand;
use fmu_export::{
    model::{Access, Kind, Quantity, Variable},
    units::ONE,
};

pub type V = Variable<Stand>;

/// A real number that the stand computes.
pub fn computed(get: fn(&Stand) -> f64) -> Quantity<Stand> {
    Quantity::of(Access { get, set: None }, &ONE)
}

/// A whole number; the table has its range.
pub fn whole(access: Access<Stand, i32, i32>) -> Kind<Stand> {
    let (min, max) = (None, None);
    Kind::Integer { access, min, max }
}

/// True or false.
pub fn flag(access: Access<Stand, bool, bool>) -> Kind<Stand> {
    Kind::Boolean { access }
}

/// A text.
pub fn label(access: Access<Stand, str, String>) -> Kind<Stand> {
    Kind::String { access }
}

/// Reads and writes a field of the stand.
macro_rules! field {
    ($($path:tt)+) => { fmu_export::field!(Stand: $($path)+) };
}

/// A field that is a real number; the table has its unit and range.
macro_rules! real {
    ($($path:tt)+) => { Kind::Real(Quantity::of(field!($($path)+), &units::ONE)) };
}

/// Reads and writes a text of the stand.
macro_rules! text {
    ($($path:tt)+) => { fmu_export::text!(Stand: $($path)+) };
}

/// One of several named values.
macro_rules! choice {
    ($($choice:tt)+) => { fmu_export::choice!(Stand: $($choice)+) };
}

/// An output with its time derivative.
macro_rules! output {
    ($field:ident) => {
        Kind::Real(Quantity { derivative: Some(|s| s.rates().$field), ..computed(|s| s.readings().$field) })
    };
}

/// A quantity of the film linearised about a resting journal.
macro_rules! resting {
    ($($path:tt)+) => { Kind::Real(computed(|s| s.resting().$($path)+)) };
}

/// A number of the check by ISO 7902.
macro_rules! operation {
    ($field:ident) => {
        Kind::Real(computed(|s| s.operation().$field))
    };
}

/// An input that may vary linearly within a step.
macro_rules! input {
    ($field:ident) => {
        Kind::Real(Quantity {
            slope: Some(|s, rate| s.inputs.$field.slope = rate),
            ..Quantity::of(field!(inputs.$field.value), &units::ONE)
        })
    };
}

/// The mean of a sensor over the last whole turn of the load.
macro_rules! mean {
    ($number:literal) => {
        Kind::Real(computed(|s| s.means()[$number]))
    };
}
