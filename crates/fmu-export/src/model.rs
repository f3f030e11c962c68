//! "A model with variables": all that a simulation boundary needs to know of the physics.
//!
//! A [`Model`] declares its variables once, in a table of [`Variable`]s; value references, units,
//! start values, descriptions and the generated model description follow from that table.
//! Nothing here knows FMI, and nothing here knows bearings.

use std::fmt;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A simulation model that a boundary (an FMU, a test, a benchmark) can drive.
///
/// The life of a model: `default()`, set parameters and inputs, [`initialise`](Model::initialise),
/// then any number of: set inputs, [`advance`](Model::advance), read outputs.
/// `Clone` is a complete snapshot of the simulation at a communication point.
pub trait Model: Clone + Default + Send + Sync + 'static {
    /// Name, identifier and description.
    const INFO: Info;

    /// All variables, in the order in which they are listed to users. The order is the
    /// identity: a variable's index in this table never changes while the model lives.
    fn variables() -> &'static [Variable<Self>];

    /// Checks the parameters and computes the state at the start time. Outputs are valid afterwards.
    fn initialise(&mut self, experiment: &Experiment<'_>, log: &mut dyn Log) -> Result<(), Fault>;

    /// Recomputes the outputs from the present state, inputs and tunable parameters, without
    /// letting time pass. Called after inputs or tunable parameters were set.
    fn update(&mut self) -> Result<(), Fault>;

    /// Lets `step` seconds pass from `time`, with inputs held or, where
    /// a [slope](Kind::Real) was set, varying linearly. Outputs are valid at `time + step` afterwards.
    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault>;

    /// The complete snapshot as bytes. [`restore`](Model::restore) of them continues bit for bit.
    fn save(&self) -> Vec<u8>;

    /// Takes a snapshot back. On an error, nothing has changed.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), Fault>;
}

/// What a model is called.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// The model's name, for people.
    pub name: &'static str,
    /// The model's identifier: a valid C identifier, the name of the binary.
    pub identifier: &'static str,
    /// One sentence.
    pub description: &'static str,
    /// The step size at which a simulation is suggested to communicate, s.
    pub default_step: f64,
    /// The time at which a simulation is suggested to stop, s.
    pub default_stop: f64,
    /// The suggested relative tolerance of the time integration.
    pub default_tolerance: f64,
    /// Log categories with their descriptions.
    pub log_categories: &'static [(&'static str, &'static str)],
}

/// What the model learns of the experiment when it is initialised. By default it begins at zero, and nothing else is known.
#[derive(Clone, Copy, Debug, Default)]
pub struct Experiment<'a> {
    /// The time at which the simulation starts, s.
    pub start: f64,
    /// The time at which it stops, s, where that is known.
    pub stop: Option<f64>,
    /// The relative tolerance that the host asks for, where it does.
    pub tolerance: Option<f64>,
    /// The folder of the model's resource files, where there is one.
    pub resources: Option<&'a Path>,
}

impl Experiment<'_> {
    /// Where a file that a parameter names is: a relative name is looked up among the model's resources first,
    /// then in the working directory.
    pub fn file(&self, name: &str) -> PathBuf {
        let shipped = self.resources.map(|folder| folder.join(name));
        shipped
            .filter(|path| path.is_file())
            .unwrap_or_else(|| PathBuf::from(name))
    }
}

/// Why a model cannot go on.
#[derive(Clone, Debug, Error)]
pub enum Fault {
    /// A parameter, an input, a file or a snapshot is not usable. The message names it, its value and the remedy.
    #[error("{0}")]
    Invalid(String),
    /// The computation of this step failed; the state is as before the call.
    #[error("{0}")]
    Failed(String),
}

/// Where a model's messages go.
pub trait Log {
    /// Takes one message of a category of [`Info::log_categories`].
    fn log(&mut self, category: &'static str, message: fmt::Arguments<'_>);
}

/// Drops every message.
impl Log for () {
    fn log(&mut self, _: &'static str, _: fmt::Arguments<'_>) {}
}

/// The part that a variable plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Set by the host at any communication point.
    Input,
    /// Set by the host before the start.
    Parameter,
    /// Set by the host before the start, and changeable while running.
    TunableParameter,
    /// Computed; for the host to read.
    Output,
    /// Computed; for people who look inside.
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

/// A unit, its SI base exponents, and the display units that go with it. All model values are SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// The name, as users write it.
    pub name: &'static str,
    /// Exponents of kg, m, s, K, rad.
    pub exponents: [i32; 5],
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
    /// What it means.
    pub description: &'static str,
}

/// An enumeration type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Enumeration {
    /// The type's name.
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Its items.
    pub items: &'static [Item],
}

/// How a value is read from and written to the model; `set` is `None` for what is computed.
pub struct Access<M, T: ?Sized + 'static, R> {
    /// Reads the value.
    pub get: fn(&M) -> R,
    /// Writes the value.
    pub set: Option<fn(&mut M, &T)>,
}

/// A variable's type with its type-specific attributes and its access.
pub enum Kind<M: 'static> {
    /// A real number in SI units.
    Real {
        /// Read and write.
        access: Access<M, f64, f64>,
        /// The unit.
        unit: &'static Unit,
        /// Name of the preferred display unit, one of `unit.display`.
        display: Option<&'static str>,
        /// The smallest value that makes sense (inclusive).
        min: Option<f64>,
        /// The largest value that makes sense (inclusive).
        max: Option<f64>,
        /// A typical magnitude.
        nominal: Option<f64>,
        /// For inputs that may vary linearly within a step: sets the time derivative.
        slope: Option<fn(&mut M, f64)>,
        /// For outputs whose time derivative the model knows: reads it.
        derivative: Option<fn(&M) -> f64>,
    },
    /// A whole number.
    Integer {
        /// Read and write.
        access: Access<M, i32, i32>,
        /// The smallest value (inclusive).
        min: Option<i32>,
        /// The largest value (inclusive).
        max: Option<i32>,
    },
    /// Yes or no.
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
}

/// One variable of a model.
pub struct Variable<M: 'static> {
    /// The structured name, such as `bearing.radialClearance`.
    pub name: &'static str,
    /// One sentence for users.
    pub description: &'static str,
    /// Its part.
    pub role: Role,
    /// Its type, attributes and access.
    pub kind: Kind<M>,
    /// For outputs: the names of the inputs on which the value depends directly, at the same instant
    /// (at the start, too).
    pub depends_on: &'static [&'static str],
}

/// Checks every parameter and input of a model against its declared range.
pub fn check_ranges<M: Model>(model: &M) -> Result<(), Fault> {
    for variable in M::variables() {
        match &variable.kind {
            Kind::Real {
                access,
                unit,
                min,
                max,
                ..
            } if access.set.is_some() => {
                let value = (access.get)(model);
                let (least, most) = (min.unwrap_or(f64::MIN), max.unwrap_or(f64::MAX));
                // Written so that what is not a number is refused too.
                if !(least <= value && value <= most) {
                    return Err(Fault::Invalid(format!(
                        "{} = {value} {}: it must lie between {least} and {most} {}",
                        variable.name, unit.name, unit.name
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
                    let known: Vec<_> = of
                        .items
                        .iter()
                        .map(|item| format!("{} ({})", item.value, item.name))
                        .collect();
                    return Err(Fault::Invalid(format!(
                        "{} = {value}: it must be one of {}",
                        variable.name,
                        known.join(", ")
                    )));
                }
            }
            _ => {}
        }
    }
    Ok(())
}
