//! The contents of `modelDescription.xml`.

use std::fmt;

use indexmap::IndexMap;
use serde::{Deserialize, Serialize, Serializer};

use crate::{
    units::{Conversion, UnitError, Units},
    value::{Content, Handle, Value},
    version::Version,
};

/// A model description of FMI 2.0 or 3.0.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Description {
    /// The version of FMI as it is written, such as `2.0`.
    pub fmi_version: String,
    /// The version of the standard by which the FMU is run.
    #[serde(skip)]
    pub standard: Version,
    /// The interface by which it is run: Co-Simulation where it has that.
    pub interface: Interface,
    /// The declarations of Model Exchange; nothing of another interface.
    #[serde(skip)]
    pub exchange: ExchangeSizes,
    /// The model's name, for people.
    pub model_name: String,
    /// The name of the binary.
    pub model_identifier: String,
    /// The GUID, which ties the description to the binary; in FMI 3.0 the instantiation token.
    pub guid: String,
    /// One sentence on its meaning.
    pub description: Option<String>,
    /// The model's version.
    pub version: Option<String>,
    /// The tool that wrote the FMU.
    pub generation_tool: Option<String>,
    /// The FMU's capabilities.
    pub capabilities: Capabilities,
    /// The suggested experiment.
    pub default_experiment: DefaultExperiment,
    /// The log categories.
    pub log_categories: Vec<String>,
    /// The unit definitions.
    pub units: Units,
    /// The variables by name, in the order of the file.
    pub variables: IndexMap<String, Variable>,
    /// The structural parameters, by value references, that have other values than in the file, since
    /// [`Package::resize`](crate::Package::resize).
    #[serde(skip)]
    pub sizes: Vec<(u32, u64)>,
    /// Variables that cannot be used here, with the reasons.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub unusable: IndexMap<String, String>,
    /// Violations of the standard that do not prevent a simulation.
    pub remarks: Vec<Remark>,
}

/// The interfaces of FMI that can be run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum Interface {
    /// The FMU steps by itself.
    #[default]
    #[serde(rename = "Co-Simulation")]
    CoSimulation,
    /// The FMU gives rates, which are integrated here.
    #[serde(rename = "Model Exchange")]
    ModelExchange,
}

impl Interface {
    /// Its name in the standard.
    pub fn name(self) -> &'static str {
        match self {
            Self::CoSimulation => "Co-Simulation",
            Self::ModelExchange => "Model Exchange",
        }
    }
}

/// The declarations of a description of Model Exchange, and of Co-Simulation with event mode.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExchangeSizes {
    /// How many continuous states there are.
    pub states: usize,
    /// How many event indicators there are.
    pub indicators: usize,
    /// Whether the FMU need not be told of completed steps.
    pub completed_not_needed: bool,
    /// Whether a step of Co-Simulation cannot be cut where an event is due: the event then follows the step.
    pub even_steps: bool,
}

/// Something in a model description that is not as the standard wants it, and was read all the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Remark {
    /// The line in `modelDescription.xml`, from 1.
    pub line: usize,
    /// The part of the description that it concerns.
    pub about: About,
    /// The fault, and how the reader went on.
    pub text: String,
}

/// The part of the description that a [`Remark`] concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The bytes of the file.
    Encoding,
    /// An attribute's value.
    Value,
    /// A variable's name.
    Name,
    /// A variable that cannot be used.
    Variable,
    /// Something that the standard allows, and that cannot be used here.
    Limit,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.text)
    }
}

impl Serialize for Remark {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The capabilities that an FMU declares.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Capabilities {
    /// The communication step may change from step to step.
    pub can_handle_variable_communication_step_size: bool,
    /// States can be saved and restored.
    pub can_get_and_set_fmu_state: bool,
    /// States can be turned into bytes.
    pub can_serialize_fmu_state: bool,
    /// Inputs may vary within a step.
    pub can_interpolate_inputs: bool,
    /// A process can hold no more than one instance.
    pub can_be_instantiated_only_once_per_process: bool,
    /// The FMU needs an installed tool.
    pub needs_execution_tool: bool,
    /// Steps may return before they are done.
    pub can_run_asynchronuously: bool,
    /// A step may end before its communication point (FMI 3.0).
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub might_return_early_from_do_step: bool,
    /// The importer may handle events itself (FMI 3.0). It does so here where the FMU has clocks or refuses to run
    /// otherwise; else the FMU handles them within its steps.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub has_event_mode: bool,
}

/// The suggested experiment.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct DefaultExperiment {
    /// Start time, s.
    pub start: Option<f64>,
    /// Stop time, s.
    pub stop: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
    /// Communication step, s.
    pub step: Option<f64>,
}

/// The part that a variable plays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Causality {
    /// Set before the start.
    Parameter,
    /// The size of arrays (FMI 3.0), set by [`Package::resize`](crate::Package::resize).
    StructuralParameter,
    /// Follows from other parameters.
    CalculatedParameter,
    /// Set by the importer.
    Input,
    /// Computed, for the importer.
    Output,
    /// Computed, for a look inside.
    #[default]
    Local,
    /// The time.
    Independent,
}

/// When a variable may change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Variability {
    /// Never.
    Constant,
    /// Before the start only.
    Fixed,
    /// At communication points.
    Tunable,
    /// At events.
    Discrete,
    /// Always.
    #[default]
    Continuous,
}

/// One variable.
#[derive(Clone, Debug, Serialize)]
pub struct Variable {
    /// Its unique name.
    pub name: String,
    /// The line in `modelDescription.xml`, from 1.
    #[serde(skip)]
    pub line: u32,
    /// The handle by which the binary knows it; in FMI 3.0 all elements of an array share it.
    pub value_reference: u32,
    /// Its place in FMI 3.0.
    #[serde(flatten)]
    pub place: Option<StoragePlace>,
    /// One sentence on its meaning.
    pub description: Option<String>,
    /// Its part.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// The value references of the clocks at whose ticks it is set and computed (FMI 3.0).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clocks: Vec<u32>,
    /// Its type with the attributes of that type.
    #[serde(flatten)]
    pub kind: Kind,
}

/// The place of a number, text or flag in a binary of FMI 3.0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct StoragePlace {
    /// The type under which it is stored.
    pub storage: Storage,
    /// Its number among the elements of all variables; names for the same element share it.
    #[serde(skip)]
    pub number: u32,
    /// Its index in its array, 0 where there is none.
    #[serde(skip)]
    pub index: usize,
    /// How many elements its array has, 1 where there is none.
    #[serde(skip)]
    pub of: usize,
}

/// The types of FMI 3.0 that can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)] // as the standard names them
pub enum Storage {
    Float32,
    Float64,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Boolean,
    String,
    Binary,
    Enumeration,
    Clock,
}

impl Storage {
    /// The smallest and the largest number of a type, where these bind: no value beyond them can be passed.
    pub(crate) fn range(self) -> (Option<i128>, Option<i128>) {
        match self {
            Self::Int8 => (Some(i8::MIN.into()), Some(i8::MAX.into())),
            Self::UInt8 => (Some(0), Some(u8::MAX.into())),
            Self::Int16 => (Some(i16::MIN.into()), Some(i16::MAX.into())),
            Self::UInt16 => (Some(0), Some(u16::MAX.into())),
            Self::Int32 => (Some(i32::MIN.into()), Some(i32::MAX.into())),
            Self::UInt32 => (Some(0), Some(u32::MAX.into())),
            Self::UInt64 => (Some(0), None),
            _ => (None, None),
        }
    }

    /// The whole number of a text, where 64 bits of the type hold it.
    pub(crate) fn whole(self, text: &str) -> Option<i128> {
        match self {
            Self::UInt64 => text.parse::<u64>().ok().map(i128::from),
            _ => text.parse::<i64>().ok().map(i128::from),
        }
    }
}

/// A variable's type and its attributes.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type")]
pub enum Kind {
    /// A real number.
    Real {
        /// The unit's name.
        unit: Option<String>,
        /// The unit in which people want to read it.
        display_unit: Option<String>,
        /// Whether it is a difference, such as a rise of temperature: units then convert without their offset.
        relative: bool,
        /// The start value.
        start: Option<f64>,
        /// The smallest value.
        min: Option<f64>,
        /// The largest value.
        max: Option<f64>,
        /// A typical magnitude.
        nominal: Option<f64>,
    },
    /// A whole number.
    Integer {
        /// The start value.
        start: Option<i128>,
        /// The smallest value.
        min: Option<i128>,
        /// The largest value.
        max: Option<i128>,
    },
    /// Yes or no.
    Boolean {
        /// The start value.
        start: Option<bool>,
    },
    /// A text.
    String {
        /// The start value.
        start: Option<String>,
    },
    /// One of several named values.
    Enumeration {
        /// The start value.
        start: Option<i128>,
        /// The names and their values.
        items: Vec<(String, i128)>,
    },
    /// A clock (FMI 3.0): whether it has ticked since the last communication point.
    Clock(Timing),
}

/// When a clock ticks, in s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Timing {
    /// What determines its ticks.
    #[serde(rename = "interval_variability")]
    pub by: Ticking,
    /// From one tick to the next, where the description says that.
    pub interval: Option<f64>,
    /// From the start to the first tick, likewise.
    pub shift: Option<f64>,
}

/// What determines the ticks of a clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Ticking {
    /// An interval.
    Constant,
    /// An interval that is known after the initialisation.
    Fixed,
    /// An interval that changes with parameters.
    Tunable,
    /// An interval that is known at the tick before.
    Changing,
    /// An interval that becomes known at any event.
    Countdown,
    /// The importer, or of outputs the FMU.
    #[default]
    Triggered,
}

impl Description {
    /// How values in `unit` become values of a variable.
    ///
    /// # Errors
    /// When the units don't fit.
    pub fn conversion(&self, unit: &str, variable: &Variable) -> Result<Conversion, UnitError> {
        let conversion = self.units.conversion(unit, variable.unit())?;
        Ok(match variable.kind {
            Kind::Real { relative: true, .. } => conversion.of_differences(),
            _ => conversion,
        })
    }

    /// The variables of one causality, in the order of the file.
    pub fn with(&self, causality: Causality) -> impl Iterator<Item = &Variable> {
        self.variables.values().filter(move |variable| variable.causality == causality)
    }
}

impl Kind {
    /// How the binary stores values of this type.
    pub fn content(&self) -> Content {
        match self {
            Self::Real { .. } => Content::Real,
            Self::Integer { .. } | Self::Enumeration { .. } => Content::Integer,
            Self::Boolean { .. } | Self::Clock(_) => Content::Boolean,
            Self::String { .. } => Content::Text,
        }
    }

    /// The start value, where there is one.
    pub fn start_value(&self) -> Option<Value> {
        match self {
            Self::Real { start, .. } => start.map(Value::Real),
            Self::Integer { start, .. } | Self::Enumeration { start, .. } => start.map(Value::Integer),
            Self::Boolean { start } => start.map(Value::Boolean),
            Self::String { start } => start.clone().map(Value::String),
            Self::Clock(_) => None,
        }
    }

    /// The start value as a number, where there is one.
    pub fn start(&self) -> Option<f64> {
        self.start_value().and_then(|value| (value.content() != Content::Text).then(|| value.number()))
    }

    /// The smallest and the largest value, where these are declared.
    pub fn range(&self) -> (Option<f64>, Option<f64>) {
        match self {
            Self::Real { min, max, .. } => (*min, *max),
            Self::Integer { min, max, .. } => (min.map(|min| min as f64), max.map(|max| max as f64)),
            _ => (None, None),
        }
    }
}

impl Variable {
    /// How calls reach it.
    pub fn handle(&self) -> Handle {
        Handle {
            reference: self.place.map_or(self.value_reference, |place| place.number),
            content: self.kind.content(),
        }
    }

    /// The same where its values are numbers; a text is none.
    pub fn number_handle(&self) -> Option<Handle> {
        Some(self.handle()).filter(|handle| handle.content != Content::Text)
    }

    /// The name of its unit, where it has one.
    pub fn unit(&self) -> Option<&str> {
        match &self.kind {
            Kind::Real { unit, .. } => unit.as_deref(),
            _ => None,
        }
    }

    /// The unit in which people want to read it: the display unit, or else the unit.
    pub fn display_unit(&self) -> Option<&str> {
        match &self.kind {
            Kind::Real { unit, display_unit, .. } => display_unit.as_deref().or(unit.as_deref()),
            _ => None,
        }
    }

    /// Whether an importer may set it before the start: a result as well where it has a start value, as a state has. The
    /// ticks of a clock are set where nothing else determines them.
    pub fn is_settable(&self) -> bool {
        let has_part = match self.causality {
            Causality::Parameter | Causality::Input => true,
            Causality::Local | Causality::Output => self.kind.start_value().is_some(),
            _ => false,
        };
        let is_due = matches!(self.kind, Kind::Clock(timing) if timing.by != Ticking::Triggered);
        has_part && !is_due && self.variability != Variability::Constant
    }
}
