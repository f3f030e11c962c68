//! Short forms for the lines of a variable table.
//!
//! [`real`], [`parameter`] and [`tunable`] start a variable; [`Variable::within`], [`Variable::shown_in`] and
//! [`Variable::about`] add what not every variable has. [`field!`](crate::field) reads and writes a field of the
//! model, [`text!`](crate::text) one that holds a text, and [`choice!`](crate::choice) one that is a Rust enum.

use crate::model::{Access, Kind, Role, Unit, Variable};

/// A variable of any type.
pub const fn variable<M>(
    name: &'static str,
    role: Role,
    kind: Kind<M>,
    description: &'static str,
) -> Variable<M> {
    Variable {
        name,
        description,
        role,
        kind,
        depends_on: &[],
    }
}

/// A real variable without range, display unit and nominal value.
pub const fn real<M>(
    name: &'static str,
    role: Role,
    unit: &'static Unit,
    access: Access<M, f64, f64>,
    description: &'static str,
) -> Variable<M> {
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

/// A real parameter: set before the start.
pub const fn parameter<M>(
    name: &'static str,
    unit: &'static Unit,
    access: Access<M, f64, f64>,
    description: &'static str,
) -> Variable<M> {
    real(name, Role::Parameter, unit, access, description)
}

/// A real parameter that may change while the simulation runs.
pub const fn tunable<M>(
    name: &'static str,
    unit: &'static Unit,
    access: Access<M, f64, f64>,
    description: &'static str,
) -> Variable<M> {
    real(name, Role::TunableParameter, unit, access, description)
}

/// A computed real value that hosts read.
pub const fn output<M>(
    name: &'static str,
    unit: &'static Unit,
    get: fn(&M) -> f64,
    description: &'static str,
) -> Variable<M> {
    real(
        name,
        Role::Output,
        unit,
        Access { get, set: None },
        description,
    )
}

impl<M> Variable<M> {
    /// The same, shown to people in this display unit.
    #[must_use]
    pub const fn shown_in(mut self, display_unit: &'static str) -> Self {
        if let Kind::Real { display, .. } = &mut self.kind {
            *display = Some(display_unit);
        }
        self
    }

    /// The same with the smallest and the largest value that make sense.
    #[must_use]
    pub const fn within(mut self, least: f64, most: f64) -> Self {
        if let Kind::Real { min, max, .. } = &mut self.kind {
            *min = Some(least);
            *max = Some(most);
        }
        self
    }

    /// The same with a typical magnitude.
    #[must_use]
    pub const fn about(mut self, typical: f64) -> Self {
        if let Kind::Real { nominal, .. } = &mut self.kind {
            *nominal = Some(typical);
        }
        self
    }
}

/// Reads and writes a field: `field!(Model: load.stiffness)`.
#[macro_export]
macro_rules! field {
    ($model:ty: $($path:tt)+) => {
        $crate::model::Access {
            get: |model: &$model| model.$($path)+,
            set: Some(|model: &mut $model, value| model.$($path)+ = *value),
        }
    };
}

/// Reads and writes a field that holds a text: `text!(Model: oil.file)`.
#[macro_export]
macro_rules! text {
    ($model:ty: $($path:ident).+) => {
        $crate::model::Access {
            get: |model: &$model| model.$($path).+.clone(),
            set: Some(|model: &mut $model, value| model.$($path).+ = value.to_owned()),
        }
    };
}

/// Enumerations with their items' names, values and meanings.
#[macro_export]
macro_rules! enumerations {
    ($($(#[$doc:meta])* $id:ident = $name:literal, $about:literal, [$($item:ident = $value:literal $meaning:literal),*];)*) => {
        $($(#[$doc])* pub const $id: $crate::model::Enumeration = $crate::model::Enumeration {
            name: $name,
            description: $about,
            items: &[$($crate::model::Item { name: stringify!($item), value: $value, description: $meaning }),*],
        };)*
    };
}

/// A parameter that is one of several named values: a Rust enum and the enumeration with the same items. The first
/// item stands in for a value that is none of them; the boundary lets no such value through.
#[macro_export]
macro_rules! choice {
    ($model:ty: $name:literal, $of:ident, $type:ident { $first:ident = $first_value:literal $(, $item:ident = $value:literal)* }, $($path:ident).+, $description:literal) => {
        $crate::declare::variable(
            $name,
            $crate::model::Role::Parameter,
            $crate::model::Kind::Enumeration {
                access: $crate::model::Access {
                    get: |model: &$model| match model.$($path).+ {
                        $type::$first => $first_value,
                        $($type::$item => $value,)*
                    },
                    set: Some(|model: &mut $model, value| {
                        model.$($path).+ = match *value {
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
