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

/// An output with the rate that the stand knows of it.
macro_rules! output {
    ($name:literal, $unit:expr, $field:ident, [$($input:literal),*], $description:literal) => {{
        let mut variable: V = output($name, $unit, |s: &Stand| s.readings().$field, $description);
        variable.depends_on = &[$($input),*];
        if let Kind::Real { derivative, .. } = &mut variable.kind {
            *derivative = Some(|s| s.rate_of(|r: &Readings| r.$field));
        }
        variable
    }};
}

/// An input that may vary linearly within a step.
macro_rules! input {
    ($name:literal, $unit:expr, $field:ident, $description:literal) => {{
        let mut variable = real(
            $name,
            Role::Input,
            $unit,
            field!(inputs.$field.value),
            $description,
        );
        if let Kind::Real { slope, .. } = &mut variable.kind {
            *slope = Some(|s, rate| s.inputs.$field.slope = rate);
        }
        variable
    }};
}
