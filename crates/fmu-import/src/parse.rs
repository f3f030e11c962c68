//! Reads `modelDescription.xml` tolerantly.
//!
//! Unknown attributes, annotations, foreign namespaces and missing optional parts are no error;
//! a byte-order mark and Latin-1 are understood. What cannot be ignored silently becomes one of
//! [`Description::remarks`].

mod three;
mod two;

use std::{collections::HashMap, str::FromStr};

use indexmap::map::Entry;
use roxmltree::Node;
use serde::de::{DeserializeOwned, IntoDeserializer, value::StrDeserializer};
use thiserror::Error;

use crate::{
    decode::{self, decode},
    description::{About, Capabilities, DefaultExperiment, Description, Interface, Kind, Remark, Storage, Variable},
    units::{BaseUnit, Conversion, DisplayUnit, Unit, Units},
    version::Version,
    xml::{self, XmlError, child, children, tag, within},
};

/// Why a model description cannot be used.
#[derive(Debug, Error)]
pub enum DescriptionError {
    /// The file is no XML that is read here.
    #[error(transparent)]
    Xml(#[from] XmlError),
    /// The root element is another one.
    #[error("the root element is `{0}`, not `fmiModelDescription`")]
    Root(String),
    /// The FMU is of another version.
    #[error("the FMU is of FMI {0}; FMI 2.0 or 3.0 is needed")]
    Version(String),
    /// There is no part that can be run.
    #[error("the FMU has no Co-Simulation or Model Exchange part that can be run ({0})")]
    NoInterface(&'static str),
    /// A required attribute is missing.
    #[error("line {line}: `{element}` has no attribute `{attribute}`")]
    Missing {
        /// The element's name.
        element: String,
        /// The attribute's name.
        attribute: &'static str,
        /// The line, from 1.
        line: u32,
    },
    /// The model identifier would not name a file.
    #[error("modelIdentifier `{0}` is not a plain file name")]
    Identifier(String),
}

/// Reads a model description, with these values of structural parameters.
pub fn description(bytes: &[u8], sizes: &[(u32, u64)]) -> Result<Description, DescriptionError> {
    let content = decode(bytes);
    let document = xml::parse(&content)?;
    let root = document.root_element();
    if tag(root) != "fmiModelDescription" {
        return Err(DescriptionError::Root(tag(root).to_owned()));
    }
    let version = root.attribute("fmiVersion").unwrap_or("1.0").trim();
    let standard = Version::of(version).ok_or_else(|| DescriptionError::Version(version.to_owned()))?;
    let (interface, slave) = interface(root)?;
    let model_identifier = required(slave, "modelIdentifier")?.to_owned();
    if model_identifier.is_empty() || model_identifier.contains(['/', '\\', '\0']) {
        return Err(DescriptionError::Identifier(model_identifier));
    }
    let mut reader = Reader::default();
    let token = match standard {
        Version::Two => "guid",
        Version::Three => "instantiationToken",
    };
    let mut description = Description {
        fmi_version: version.to_owned(),
        standard,
        interface,
        model_name: text(root, "modelName").unwrap_or_default(),
        model_identifier,
        guid: root.attribute(token).unwrap_or("").to_owned(),
        description: root.attribute("description").map(str::to_owned),
        version: text(root, "version"),
        generation_tool: text(root, "generationTool"),
        capabilities: reader.capabilities(slave, standard),
        default_experiment: reader.default_experiment(root),
        log_categories: log_categories(root),
        units: reader.units(root),
        sizes: sizes.to_vec(),
        ..Description::default()
    };
    match standard {
        Version::Two => reader.variables_of_two(root, &mut description),
        Version::Three => reader.variables_of_three(root, &mut description),
    }
    if let Some((line, text)) = decode::misread(bytes) {
        reader.remarks.push(Remark { line, about: About::Encoding, text: text.to_owned() });
    }
    if interface == Interface::ModelExchange {
        description.exchange = reader.exchange_of_two(root, slave);
        // The integration takes inputs at the time of each evaluation.
        description.capabilities.can_interpolate_inputs = true;
        description.capabilities.can_handle_variable_communication_step_size = true;
    }
    let can_vary = description.capabilities.can_handle_variable_communication_step_size;
    description.exchange.even_steps = !can_vary;
    description.remarks = reader.remarks;
    Ok(description)
}

/// The interface that is run, with its element.
fn interface<'a>(root: Node<'a, 'a>) -> Result<(Interface, Node<'a, 'a>), DescriptionError> {
    if let Some(node) = child(root, "CoSimulation") {
        return Ok((Interface::CoSimulation, node));
    }
    if let Some(node) = child(root, "ModelExchange") {
        return Ok((Interface::ModelExchange, node));
    }
    Err(match child(root, "ScheduledExecution") {
        Some(_) => DescriptionError::NoInterface("Scheduled Execution only"),
        None => DescriptionError::NoInterface("neither of the two"),
    })
}

/// A text of one line (`xs:normalizedString`), in which line ends and tabs are blanks.
pub fn text(node: Node, attribute: &str) -> Option<String> {
    Some(node.attribute(attribute)?.replace(['\n', '\r', '\t'], " "))
}

pub fn line(node: Node) -> u32 {
    node.document().text_pos_at(node.range().start).row
}

fn required<'a>(node: Node<'a, 'a>, attribute: &'static str) -> Result<&'a str, DescriptionError> {
    node.attribute(attribute).ok_or_else(|| DescriptionError::Missing {
        element: tag(node).to_owned(),
        attribute,
        line: line(node),
    })
}

fn log_categories(root: Node) -> Vec<String> {
    child(root, "LogCategories")
        .into_iter()
        .flat_map(|list| list.children())
        .filter_map(|category| category.attribute("name"))
        .map(str::to_owned)
        .collect()
}

/// Attributes that a variable takes over from its declared type.
pub type Types<'a> = HashMap<&'a str, Node<'a, 'a>>;

/// Collects remarks on the way.
#[derive(Default)]
pub struct Reader {
    remarks: Vec<Remark>,
    /// Where the line of a variable was last counted: its position, and the lines before that.
    counted: (usize, u32),
}

impl Reader {
    pub fn remark(&mut self, node: Node, about: About, text: impl Into<String>) {
        const ENOUGH: usize = 100;
        if self.remarks.len() < ENOUGH {
            self.remarks.push(Remark { line: line(node) as usize, about, text: text.into() });
        }
    }

    /// The line of a variable. They come in their order: counted from the last one on, as counting from the start
    /// each time would take minutes for a hundred thousand.
    pub fn line(&mut self, node: Node) -> u32 {
        let start = node.range().start;
        let (position, lines) = self.counted;
        let passed = node.document().input_text().as_bytes().get(position..start);
        let Some(passed) = passed else { return line(node) };
        let ends = passed.iter().filter(|byte| **byte == b'\n').count();
        self.counted = (start, lines.saturating_add(u32::try_from(ends).unwrap_or(u32::MAX)));
        self.counted.1 + 1
    }

    /// An optional attribute. One that cannot be read counts as missing, with a remark.
    pub fn number<T: FromStr>(&mut self, node: Node, name: &str) -> Option<T> {
        let text = node.attribute(name)?.trim();
        let value = text.parse().ok();
        if value.is_none() {
            // A number that cannot be read here is none of so many bits.
            let what = match text.parse::<f64>() {
                Ok(_) if size_of::<T>() > 4 => "a whole number of 64 bits",
                Ok(_) => "a whole number of 32 bits",
                Err(_) => "a number",
            };
            self.remark(node, About::Value, format!("{name}=\"{text}\" is not {what}"));
        }
        value
    }

    pub fn boolean(&mut self, node: Node, name: &str) -> Option<bool> {
        let text = node.attribute(name)?.trim();
        let value = truth(text);
        if value.is_none() {
            self.remark(node, About::Value, format!("{name}=\"{text}\" is neither true nor false"));
        }
        value
    }

    /// The item of an enumeration that an attribute names, or else the default.
    pub fn choice<T: DeserializeOwned + Default>(&mut self, node: Node, name: &str) -> T {
        let Some(text) = node.attribute(name) else { return T::default() };
        item(text).unwrap_or_else(|| {
            self.remark(node, About::Value, format!("unknown {name} \"{text}\""));
            T::default()
        })
    }

    fn capabilities(&mut self, node: Node, standard: Version) -> Capabilities {
        let mut flag = |name| self.boolean(node, name).unwrap_or(false);
        let usual = Capabilities {
            can_handle_variable_communication_step_size: flag("canHandleVariableCommunicationStepSize"),
            can_be_instantiated_only_once_per_process: flag("canBeInstantiatedOnlyOncePerProcess"),
            needs_execution_tool: flag("needsExecutionTool"),
            ..Capabilities::default()
        };
        match standard {
            Version::Two => Capabilities {
                can_get_and_set_fmu_state: flag("canGetAndSetFMUstate"),
                can_serialize_fmu_state: flag("canSerializeFMUstate"),
                can_interpolate_inputs: flag("canInterpolateInputs"),
                can_run_asynchronuously: flag("canRunAsynchronuously"),
                ..usual
            },
            Version::Three => Capabilities {
                can_get_and_set_fmu_state: flag("canGetAndSetFMUState"),
                can_serialize_fmu_state: flag("canSerializeFMUState"),
                might_return_early_from_do_step: flag("mightReturnEarlyFromDoStep"),
                has_event_mode: flag("hasEventMode"),
                ..usual
            },
        }
    }

    fn default_experiment(&mut self, root: Node) -> DefaultExperiment {
        let Some(node) = child(root, "DefaultExperiment") else { return DefaultExperiment::default() };
        DefaultExperiment {
            start: self.number(node, "startTime"),
            stop: self.number(node, "stopTime"),
            tolerance: self.number(node, "tolerance"),
            step: self.number(node, "stepSize"),
        }
    }

    fn units(&mut self, root: Node) -> Units {
        let mut units = Units::default();
        for node in within(root, "UnitDefinitions", "Unit") {
            let Some(name) = text(node, "name") else {
                self.remark(node, About::Value, "a unit without a name");
                continue;
            };
            let base = child(node, "BaseUnit").map(|base| BaseUnit {
                exponents: BaseUnit::NAMES.map(|name| self.number(base, name).unwrap_or(0)),
                to_base: self.conversion(base),
            });
            let display = children(node, "DisplayUnit")
                .filter_map(|display| {
                    // FMI 3.0: the display unit of the reciprocal, which no factor and offset make.
                    if self.boolean(display, "inverse") == Some(true) {
                        self.remark(
                            display,
                            About::Limit,
                            "an inverse display unit, which is left out: give values in the unit",
                        );
                        return None;
                    }
                    Some(DisplayUnit { name: text(display, "name")?, from_unit: self.conversion(display) })
                })
                .collect();
            let unit = Unit { base, display };
            // A name alone says nothing. Of two meanings nobody knows the right one, so that the unit converts to none.
            match units.0.entry(name) {
                Entry::Occupied(first) if unit == Unit::default() || *first.get() == unit => {}
                Entry::Occupied(mut first) if *first.get() != Unit::default() => {
                    first.get_mut().base = Some(BaseUnit::OPEN)
                }
                Entry::Occupied(mut first) => *first.get_mut() = unit,
                Entry::Vacant(place) => {
                    place.insert(unit);
                }
            }
        }
        units
    }

    fn conversion(&mut self, node: Node) -> Conversion {
        Conversion {
            factor: self.number(node, "factor").unwrap_or(1.0),
            offset: self.number(node, "offset").unwrap_or(0.0),
        }
    }

    /// The name of a variable.
    pub fn name(&mut self, node: Node) -> Option<String> {
        let name = text(node, "name");
        if name.is_none() {
            self.remark(node, About::Variable, "a variable without a name is left out");
        }
        name
    }

    /// The value reference of a variable.
    pub fn reference(&mut self, node: Node, name: &str) -> Option<u32> {
        let text = node.attribute("valueReference");
        let reference = text.and_then(|text| text.trim().parse().ok());
        if reference.is_none() {
            let wrong = match text {
                Some(text) => {
                    format!("the valueReference \"{text}\", which is none from 0 to 4294967295,")
                }
                None => "no valueReference".to_owned(),
            };
            self.remark(node, About::Variable, format!("`{name}` has {wrong} and is left out"));
        }
        reference
    }

    /// Adds a variable, unless there is one of its name.
    pub fn add(&mut self, node: Node, variable: Variable, into: &mut Description) {
        if into.variables.contains_key(&variable.name) {
            let name = &variable.name;
            self.remark(node, About::Name, format!("a second variable `{name}`; the first one counts"));
            return;
        }
        into.variables.insert(variable.name.clone(), variable);
    }

    /// The type's attributes without the start value: the variable's own, or else those of its declared type. Whole
    /// numbers of FMI 3.0 have a `storage`; those of FMI 2.0 are of 32 bits.
    pub fn kind(&mut self, node: Node, declared: Option<Node>, storage: Option<Storage>) -> Kind {
        let source = |name: &str| {
            declared.filter(|node| node.has_attribute(name)).filter(|_| !node.has_attribute(name)).unwrap_or(node)
        };
        let text = |name: &str| text(source(name), name);
        let (min, max) = (source("min"), source("max"));
        match (tag(node), storage) {
            ("Real" | "Float32" | "Float64", _) => Kind::Real {
                unit: text("unit"),
                relative: self.boolean(source("relativeQuantity"), "relativeQuantity").unwrap_or(false),
                display_unit: text("displayUnit"),
                start: None,
                min: self.number(min, "min"),
                max: self.number(max, "max"),
                nominal: self.number(source("nominal"), "nominal"),
            },
            ("Boolean", _) => Kind::Boolean { start: None },
            ("String" | "Binary", _) => Kind::String { start: None },
            ("Enumeration", _) => {
                Kind::Enumeration { start: None, items: declared.map(|node| self.items(node)).unwrap_or_default() }
            }
            (_, None) => Kind::Integer {
                start: None,
                min: self.number::<i32>(min, "min").map(i128::from),
                max: self.number::<i32>(max, "max").map(i128::from),
            },
            ("Clock", _) => Kind::Clock(self.timing(node, declared)),
            (_, Some(storage)) => {
                let (least, most) = storage.range();
                Kind::Integer {
                    start: None,
                    min: self.bound(min, "min", storage).or(least),
                    max: self.bound(max, "max", storage).or(most),
                }
            }
        }
    }

    fn bound(&mut self, node: Node, name: &str, storage: Storage) -> Option<i128> {
        match storage {
            Storage::UInt64 => self.number::<u64>(node, name).map(i128::from),
            _ => self.number::<i64>(node, name).map(i128::from),
        }
    }

    fn items(&mut self, declared: Node) -> Vec<(String, i128)> {
        children(declared, "Item")
            .filter_map(|item| {
                let value = self.number::<i64>(item, "value")?.into();
                Some((text(item, "name")?, value))
            })
            .collect()
    }
}

/// A flag (`xs:boolean`).
pub fn truth(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// The item of an enumeration that a word names.
pub fn item<T: DeserializeOwned>(word: &str) -> Option<T> {
    let word: StrDeserializer<'_, serde::de::value::Error> = word.into_deserializer();
    T::deserialize(word).ok()
}

#[cfg(test)]
mod tests;
