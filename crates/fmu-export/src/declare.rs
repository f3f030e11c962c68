//! Short forms for the lines of a variable table.
//!
//! [`input`], [`parameter`], [`tunable`] and [`output`] start a real variable, [`variable`] one of any type. Methods of
//! [`Variable`] add what not every variable has: [`within`](Variable::within), [`shown_in`](Variable::shown_in),
//! [`about`](Variable::about), [`slope`](Variable::slope), [`derivative`](Variable::derivative),
//! [`depends_on`](Variable::depends_on), [`array`](Variable::array) and [`clocked`](Variable::clocked). [`field!`](crate::field) reads and writes a field of the model,
//! [`text!`](crate::text) one that holds a text, and [`choice!`](crate::choice) one that is a Rust enum.
//!
//! ```
//! use fmu_export::declare::{input, output, parameter};
//! use fmu_export::model::{Role, Variable};
//! use fmu_export::{field, units};
//!
//! struct Tank {
//!     inflow: f64,
//!     area: f64,
//!     level: f64,
//! }
//!
//! static VARIABLES: [Variable<Tank>; 3] = [
//!     input("inflow", &units::CUBIC_METRE_PER_SECOND, field!(Tank: inflow), "Flow into the tank").within(0.0, 1.0),
//!     parameter("area", &units::SQUARE_METRE, field!(Tank: area), "Area of the tank").within(1e-3, 1e3),
//!     output("level", &units::METRE, |tank: &Tank| tank.level, "Height of the water").shown_in("mm"),
//! ];
//!
//! assert_eq!(VARIABLES[1].role, Role::Parameter);
//! ```

use crate::model::{Access, Kind, Quantity, Role, Unit, Variable};

/// A variable of any type.
pub const fn variable<M>(name: &'static str, role: Role, kind: Kind<M>, description: &'static str) -> Variable<M> {
    Variable { name, description, role, kind, depends_on: &[], elements: 1, clock: None }
}

/// A real variable without range, display unit and nominal value.
pub const fn real<M>(
    name: &'static str,
    role: Role,
    unit: &'static Unit,
    access: Access<M, f64, f64>,
    description: &'static str,
) -> Variable<M> {
    variable(name, role, Kind::Real(Quantity::of(access, unit)), description)
}

impl<M> Quantity<M> {
    /// A real number without range, display unit and nominal value.
    pub const fn of(access: Access<M, f64, f64>, unit: &'static Unit) -> Self {
        Self { access, unit, display: None, min: None, max: None, nominal: None, slope: None, derivative: None }
    }
}

/// Makes a function for real variables that hosts set.
macro_rules! set_by_hosts {
    ($($(#[$doc:meta])* $name:ident: $role:ident;)*) => {
        $($(#[$doc])*
        pub const fn $name<M>(
            name: &'static str,
            unit: &'static Unit,
            access: Access<M, f64, f64>,
            description: &'static str,
        ) -> Variable<M> {
            real(name, Role::$role, unit, access, description)
        })*
    };
}

set_by_hosts! {
    /// A real input: set at any communication point.
    input: Input;
    /// A real parameter: set before the start.
    parameter: Parameter;
    /// A real parameter that may change while the simulation runs.
    tunable: TunableParameter;
}

/// A real value that the model computes.
pub const fn output<M>(
    name: &'static str,
    unit: &'static Unit,
    get: fn(&M) -> f64,
    description: &'static str,
) -> Variable<M> {
    real(name, Role::Output, unit, Access { get, set: None }, description)
}

/// Makes methods that state what a real variable has besides.
macro_rules! stated_of_real {
    ($($(#[$doc:meta])* $name:ident($($field:ident = $argument:ident: $type:ty),+);)*) => {
        impl<M> Variable<M> {
            $($(#[$doc])*
            #[must_use]
            pub const fn $name(mut self, $($argument: $type),+) -> Self {
                if let Kind::Real(real) = &mut self.kind {
                    $(real.$field = Some($argument);)+
                }
                self
            })*
        }
    };
}

stated_of_real! {
    /// The same, shown to people in this display unit, which is one of its unit's.
    shown_in(display = unit: &'static str);
    /// The same with the smallest and the largest value that make sense.
    within(min = least: f64, max = most: f64);
    /// The same with a typical magnitude.
    about(nominal = typical: f64);
    /// The same for an input that may vary linearly within a step: `set` sets its rate, per second.
    slope(slope = set: fn(&mut M, f64));
    /// The same for an output whose time derivative the model knows, per second.
    derivative(derivative = get: fn(&M) -> f64);
}

impl<M> Variable<M> {
    /// The same for an output that follows these inputs at once.
    #[must_use]
    pub const fn depends_on(mut self, inputs: &'static [&'static str]) -> Self {
        self.depends_on = inputs;
        self
    }

    /// The same as the first of so many elements of an array: `zone[1]`, with `zone[2]` and so on behind it in the table. FMI 3.0
    /// has it as one variable, `zone`, FMI 2.0 as several. An array of one element is a scalar, `zone[1]`, in both; clocks have no arrays.
    #[must_use]
    pub const fn array(mut self, elements: usize) -> Self {
        self.elements = elements;
        self
    }

    /// The same for what the model computes at the ticks of this clock alone.
    #[must_use]
    pub const fn clocked(mut self, clock: &'static str) -> Self {
        self.clock = Some(clock);
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
    ($model:ty: $($path:tt)+) => {
        $crate::model::Access {
            get: |model: &$model| model.$($path)+.clone(),
            set: Some(|model: &mut $model, value| model.$($path)+ = value.to_owned()),
        }
    };
}

/// Defines enumerations: name, description, and the items with their values and descriptions.
///
/// ```
/// fmu_export::enumerations! {
///     /// The laws of friction.
///     FRICTION = "Friction", "Law of friction", [
///         Coulomb = 1 "Independent of speed",
///         Viscous = 2 "Proportional to speed"
///     ];
/// }
/// assert_eq!(FRICTION.items[1].name, "Viscous");
/// ```
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

/// The type of a variable that is one of several named values: a Rust enum, and an enumeration with the same items. Hosts
/// cannot set a value that is no item, so that it does not matter that such a value would become the first item.
///
/// ```
/// use fmu_export::declare::variable;
/// use fmu_export::model::{Role, Variable};
///
/// enum Friction { Coulomb, Viscous }
/// struct Brake { friction: Friction }
///
/// fmu_export::enumerations! {
///     /// The laws of friction.
///     FRICTION = "Friction", "Law of friction", [Coulomb = 1 "Independent of speed", Viscous = 2 "Proportional to speed"];
/// }
/// static VARIABLE: Variable<Brake> = variable(
///     "friction",
///     Role::Parameter,
///     fmu_export::choice!(Brake: FRICTION, Friction { Coulomb = 1, Viscous = 2 }, friction),
///     "Law of friction",
/// );
/// assert_eq!(VARIABLE.type_name(), "Enumeration");
/// ```
#[macro_export]
macro_rules! choice {
    ($model:ty: $of:ident, $type:ident { $first:ident = $first_value:literal $(, $item:ident = $value:literal)* }, $($path:tt)+) => {
        $crate::model::Kind::Enumeration {
            access: $crate::model::Access {
                get: |model: &$model| match model.$($path)+ {
                    $type::$first => $first_value,
                    $($type::$item => $value,)*
                },
                set: Some(|model: &mut $model, value| {
                    model.$($path)+ = match *value {
                        $($value => $type::$item,)*
                        _ => $type::$first,
                    };
                }),
            },
            of: &$of,
        }
    };
}
