//! How a line of the table declares a variable.

use crate::model::{Access, Kind, Role, Unit, Variable};
use crate::stand::Stand;

pub(super) type V = Variable<Stand>;

/// Enumerations with their items' names, values and meanings.
macro_rules! enumerations {
    ($($(#[$doc:meta])* $id:ident = $name:literal, $about:literal, [$($item:ident = $value:literal $meaning:literal),*];)*) => {
        $($(#[$doc])* pub const $id: Enumeration = Enumeration {
            name: $name,
            description: $about,
            items: &[$(Item { name: stringify!($item), value: $value, description: $meaning }),*],
        };)*
    };
}

/// A parameter that is one of several named values: a Rust enum and the enumeration of the same items,
/// whose first item stands in for what is none of them (the boundary lets no such value through).
macro_rules! choice {
    ($name:literal, $of:ident, $type:ident { $first:ident = $first_value:literal $(, $item:ident = $value:literal)* }, $($path:ident).+, $description:literal) => {
        variable(
            $name,
            Role::Parameter,
            Kind::Enumeration {
                access: Access {
                    get: |s: &Stand| match s.$($path).+ {
                        $type::$first => $first_value,
                        $($type::$item => $value,)*
                    },
                    set: Some(|s: &mut Stand, v| {
                        s.$($path).+ = match *v {
                            $($value => $type::$item,)*
                            _ => $type::$first,
                        };
                    }),
                },
                of: &$of,
            },
            $description,
        )
    };
}

/// Reads and writes a field of the stand.
macro_rules! field {
    ($($path:tt)+) => {
        Access { get: |s: &Stand| s.$($path)+, set: Some(|s: &mut Stand, v| s.$($path)+ = *v) }
    };
}

/// Reads and writes a text of the stand.
macro_rules! text {
    ($($path:ident).+) => {
        Access { get: |s: &Stand| s.$($path).+.clone(), set: Some(|s: &mut Stand, v| s.$($path).+ = v.to_owned()) }
    };
}

/// An output with the rate that the stand knows of it.
macro_rules! output {
    ($name:literal, $unit:expr, $field:ident, [$($input:literal),*], $description:literal) => {{
        let access = Access { get: |s: &Stand| s.readings().$field, set: None };
        let mut variable = real($name, Role::Output, $unit, access, $description);
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

pub(super) const fn variable(
    name: &'static str,
    role: Role,
    kind: Kind<Stand>,
    description: &'static str,
) -> V {
    Variable {
        name,
        description,
        role,
        kind,
        depends_on: &[],
    }
}

pub(super) fn real(
    name: &'static str,
    role: Role,
    unit: &'static Unit,
    access: Access<Stand, f64, f64>,
    description: &'static str,
) -> V {
    let kind = Kind::Real {
        access,
        unit,
        display: None,
        min: None,
        max: None,
        nominal: None,
        slope: None,
        derivative: None,
    };
    variable(name, role, kind, description)
}

pub(super) fn fixed(
    name: &'static str,
    unit: &'static Unit,
    access: Access<Stand, f64, f64>,
    description: &'static str,
) -> V {
    real(name, Role::Parameter, unit, access, description)
}

pub(super) fn tunable(
    name: &'static str,
    unit: &'static Unit,
    access: Access<Stand, f64, f64>,
    description: &'static str,
) -> V {
    real(name, Role::TunableParameter, unit, access, description)
}

impl V {
    pub(super) fn shown_in(mut self, display_unit: &'static str) -> Self {
        if let Kind::Real { display, .. } = &mut self.kind {
            *display = Some(display_unit);
        }
        self
    }

    pub(super) fn within(mut self, least: f64, most: f64) -> Self {
        if let Kind::Real { min, max, .. } = &mut self.kind {
            (*min, *max) = (Some(least), Some(most));
        }
        self
    }

    pub(super) fn about(mut self, typical: f64) -> Self {
        if let Kind::Real { nominal, .. } = &mut self.kind {
            *nominal = Some(typical);
        }
        self
    }
}
