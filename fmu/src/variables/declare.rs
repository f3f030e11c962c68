//! Short forms for the stand's lines of the variable table.

use crate::stand::Stand;
use fmu_export::model::Variable;

pub(super) type V = Variable<Stand>;

/// Reads and writes a field of the stand.
macro_rules! field {
    ($($path:tt)+) => { fmu_export::field!(Stand: $($path)+) };
}

/// Reads and writes a text of the stand.
macro_rules! text {
    ($($path:tt)+) => { fmu_export::text!(Stand: $($path)+) };
}

/// A parameter of the stand that is one of several named values.
macro_rules! choice {
    ($($line:tt)+) => { fmu_export::choice!(Stand: $($line)+) };
}

/// An output with its time derivative.
macro_rules! output {
    ($name:literal, $unit:expr, $field:ident, [$($input:literal),*], $description:literal) => {
        output($name, $unit, |s: &Stand| s.readings().$field, $description)
            .derivative(|s| s.rates().$field)
            .depends_on(&[$($input),*])
    };
}

/// An input that may vary linearly within a step.
macro_rules! input {
    ($name:literal, $unit:expr, $field:ident, $description:literal) => {
        fmu_export::declare::input($name, $unit, field!(inputs.$field.value), $description)
            .slope(|s: &mut Stand, rate| s.inputs.$field.slope = rate)
    };
}

/// The mean of a sensor over the last whole turn of the load.
macro_rules! mean {
    ($name:literal, $unit:expr, $number:literal, [$($input:literal),*], $of:literal) => {
        output($name, $unit, |s: &Stand| s.means()[$number],
            concat!($of, ", mean over the last whole turn of the load; until one is complete, since the start"))
            .depends_on(&[$($input),*])
    };
}
