//! The parts of `modelDescription.xml` that FMI 3.0 writes in its own way: capabilities, types and variables.
//!
//! An array becomes as many variables as it has elements, named `x[1]`, `x[2]` or `A[1,2]` in row order, so that each
//! can be varied, fed and judged. Its size is that of the start values of structural parameters.

use std::collections::HashMap;

use roxmltree::Node;

use crate::description::{
    About, Capabilities, Description, Kind, Place, Storage, Variability, Variable,
};
use crate::parse::{Reader, Types, child, children, text};

/// More elements than an array can have that is useful by its elements.
const MOST_ELEMENTS: usize = 100_000;

/// The values of structural parameters by their value references: the sizes of arrays.
type Sizes = HashMap<u32, usize>;

/// A variable of any size, as it is written.
struct Written<'a> {
    node: Node<'a, 'a>,
    storage: Storage,
    /// The number of its first element.
    first: u32,
    /// The sizes of its dimensions; none where it is no array.
    sizes: Vec<usize>,
}

impl Written<'_> {
    /// How many elements it has.
    fn count(&self) -> usize {
        self.sizes.iter().product()
    }

    /// The end of the name of an element: its indices from 1.
    fn indices(&self, element: usize) -> String {
        if self.sizes.is_empty() {
            return String::new();
        }
        let mut rest = element;
        let mut indices: Vec<String> = Vec::new();
        for size in self.sizes.iter().rev() {
            indices.push((rest % size + 1).to_string());
            rest /= size;
        }
        indices.reverse();
        format!("[{}]", indices.join(","))
    }
}

impl Reader {
    /// The capabilities of FMI 3.0.
    pub(crate) fn capabilities_of_three(&mut self, node: Node<'_, '_>) -> Capabilities {
        let mut flag = |name| self.boolean(node, name).unwrap_or(false);
        Capabilities {
            can_handle_variable_communication_step_size: flag(
                "canHandleVariableCommunicationStepSize",
            ),
            can_get_and_set_fmu_state: flag("canGetAndSetFMUState"),
            can_serialize_fmu_state: flag("canSerializeFMUState"),
            can_be_instantiated_only_once_per_process: flag("canBeInstantiatedOnlyOncePerProcess"),
            needs_execution_tool: flag("needsExecutionTool"),
            might_return_early_from_do_step: flag("mightReturnEarlyFromDoStep"),
            has_event_mode: flag("hasEventMode"),
            ..Capabilities::default()
        }
    }

    /// The variables of FMI 3.0.
    pub(crate) fn variables_of_three(&mut self, root: Node<'_, '_>, into: &mut Description) {
        let types = types(root);
        let list = child(root, "ModelVariables");
        let nodes = || list.into_iter().flat_map(|list| list.children());
        let sizes: Sizes = nodes().filter_map(structural).collect();
        let mut first = 0;
        for node in nodes().filter(Node::is_element) {
            let Some(written) = self.written(node, first, &sizes, into) else {
                continue;
            };
            // `written` refuses more elements than have numbers.
            first += u32::try_from(written.count()).unwrap_or(u32::MAX);
            self.elements(&written, &types, into);
        }
    }

    /// Reads the shape of a variable; none of one that cannot be used.
    fn written<'a>(
        &mut self,
        node: Node<'a, 'a>,
        first: u32,
        sizes: &Sizes,
        into: &mut Description,
    ) -> Option<Written<'a>> {
        let Some(name) = text(node, "name") else {
            let text = "a variable without a name is left out";
            self.remark(node, About::Variable, text);
            return None;
        };
        let mut refuse = |why: String| {
            into.unusable.insert(name.clone(), why);
            None
        };
        let storage = match node.tag_name().name() {
            "Binary" => {
                return refuse("a Binary has no value that could be set or judged".to_owned());
            }
            "Clock" => {
                return refuse(
                    "a Clock ticks in event mode, which is not used here: the FMU handles events within its steps"
                        .to_owned(),
                );
            }
            other => storage_of(other),
        };
        let Some(storage) = storage else {
            return refuse(format!("unknown type `{}`", node.tag_name().name()));
        };
        let mut dimensions = Vec::new();
        for dimension in children(node, "Dimension") {
            let fixed = self.number::<usize>(dimension, "start");
            let of = self.number::<u32>(dimension, "valueReference");
            let size = fixed.or_else(|| sizes.get(&of?).copied());
            let Some(size) = size else {
                return refuse("the size of its array is not known".to_owned());
            };
            dimensions.push(size);
        }
        let count = dimensions
            .iter()
            .try_fold(1_usize, |all, size| all.checked_mul(*size));
        let within = |count: &usize| {
            *count <= MOST_ELEMENTS && first.checked_add(MOST_ELEMENTS as u32).is_some()
        };
        if count.filter(within).is_none() {
            return refuse(format!(
                "an array of more than {MOST_ELEMENTS} elements is not read"
            ));
        }
        Some(Written {
            node,
            storage,
            first,
            sizes: dimensions,
        })
    }

    /// Adds the elements of a variable, by its name and by its aliases.
    fn elements(&mut self, written: &Written<'_>, types: &Types<'_>, into: &mut Description) {
        let node = written.node;
        let name = text(node, "name").unwrap_or_default();
        let reference = node.attribute("valueReference");
        let Some(value_reference) = reference.and_then(|text| text.trim().parse().ok()) else {
            let text =
                format!("`{name}` has no valueReference from 0 to 4294967295 and is left out");
            self.remark(node, About::Variable, &text);
            return;
        };
        let declared = node.attribute("declaredType");
        let declared = declared.and_then(|name| types.get(name)).copied();
        let starts = starts(node);
        let variable = Variable {
            name,
            line: self.line(node),
            value_reference,
            place: None,
            description: node.attribute("description").map(str::to_owned),
            causality: self.causality(node),
            variability: self.variability_of_three(written),
            kind: self.kind_of_three(written, declared),
        };
        let count = written.count();
        if !matches!(starts.len(), 0 | 1) && starts.len() != count {
            let text = format!(
                "`{}` has {} start values for {count} elements; they are not read",
                variable.name,
                starts.len()
            );
            self.remark(node, About::Value, &text);
        }
        let elements: Vec<Variable> = (0..count)
            .map(|index| {
                let start = match &starts[..] {
                    [one] => Some(one),
                    all if all.len() == count => all.get(index),
                    _ => None,
                };
                let mut element = variable.clone();
                element.place = Some(Place {
                    storage: written.storage,
                    // A variable has no more elements than there are numbers.
                    number: written.first + index as u32,
                    index,
                    of: count,
                });
                if let Some(start) = start {
                    self.begin(written, &mut element.kind, start);
                }
                element
            })
            .collect();
        for alias in std::iter::once(node).chain(children(node, "Alias")) {
            let Some(name) = text(alias, "name") else {
                continue;
            };
            for (index, element) in elements.iter().enumerate() {
                let mut element = element.clone();
                element.name = format!("{name}{}", written.indices(index));
                if let Some(text) = alias.attribute("description") {
                    element.description = Some(text.to_owned());
                }
                self.add(alias, element, into);
            }
        }
    }

    fn add(&mut self, node: Node<'_, '_>, variable: Variable, into: &mut Description) {
        if into.variables.contains_key(&variable.name) {
            let text = format!(
                "a second variable `{}`; the first one counts",
                variable.name
            );
            self.remark(node, About::Name, &text);
            return;
        }
        into.variables.insert(variable.name.clone(), variable);
    }

    /// As written, or the default of FMI 3.0.
    fn variability_of_three(&mut self, written: &Written<'_>) -> Variability {
        let node = written.node;
        if node.has_attribute("variability") {
            return self.variability(node);
        }
        let is_float = matches!(written.storage, Storage::Float32 | Storage::Float64);
        match node.attribute("causality") {
            Some("parameter" | "structuralParameter" | "calculatedParameter") => {
                Variability::Tunable
            }
            _ if is_float => Variability::Continuous,
            _ => Variability::Discrete,
        }
    }

    /// The type's attributes without the start value: the variable's own, or else those of its declared type.
    fn kind_of_three(&mut self, written: &Written<'_>, declared: Option<Node<'_, '_>>) -> Kind {
        let own = written.node;
        let source = |name: &str| {
            let declared = declared.filter(|node| node.has_attribute(name));
            if own.has_attribute(name) {
                own
            } else {
                declared.unwrap_or(own)
            }
        };
        let text = |name: &str| text(source(name), name);
        match written.storage {
            Storage::Float32 | Storage::Float64 => Kind::Real {
                unit: text("unit"),
                relative: self
                    .boolean(source("relativeQuantity"), "relativeQuantity")
                    .unwrap_or(false),
                display_unit: text("displayUnit"),
                start: None,
                min: self.number(source("min"), "min"),
                max: self.number(source("max"), "max"),
                nominal: self.number(source("nominal"), "nominal"),
            },
            Storage::Boolean => Kind::Boolean { start: None },
            Storage::String => Kind::String { start: None },
            Storage::Enumeration => Kind::Enumeration {
                start: None,
                items: declared.map_or_else(Vec::new, |node| self.items(node)),
            },
            whole => {
                let (least, most) = range(whole);
                Kind::Integer {
                    start: None,
                    min: self.bound(source("min"), "min", whole).or(least),
                    max: self.bound(source("max"), "max", whole).or(most),
                }
            }
        }
    }

    /// Reads a bound of whole numbers; none where it lies beyond what can be set here.
    fn bound(&mut self, node: Node<'_, '_>, name: &str, storage: Storage) -> Option<i64> {
        let beyond = node
            .attribute(name)
            .is_some_and(|text| is_beyond(storage, text));
        if beyond {
            return None;
        }
        self.number(node, name)
    }

    /// Reads a start value.
    fn begin(&mut self, written: &Written<'_>, kind: &mut Kind, text: &str) {
        let node = written.node;
        if is_beyond(written.storage, text) {
            return;
        }
        let read = match kind {
            Kind::Real { start, .. } => {
                *start = text.parse().ok();
                start.is_some()
            }
            Kind::Integer { start, .. } | Kind::Enumeration { start, .. } => {
                *start = text.parse().ok();
                start.is_some()
            }
            Kind::Boolean { start } => {
                *start = match text {
                    "true" | "1" => Some(true),
                    "false" | "0" => Some(false),
                    _ => None,
                };
                start.is_some()
            }
            Kind::String { start } => {
                *start = Some(text.to_owned());
                true
            }
        };
        if !read {
            let text = format!("start=\"{text}\" cannot be read as a value of the variable's type");
            self.remark(node, About::Value, &text);
        }
    }
}

/// Whether a text is a value of an `UInt64` that is legal, but too large to be kept here.
fn is_beyond(storage: Storage, text: &str) -> bool {
    let value = text.trim().parse::<u64>().ok();
    storage == Storage::UInt64 && value.is_some_and(|value| i64::try_from(value).is_err())
}

/// Attributes of the types, by their names.
fn types<'a>(root: Node<'a, 'a>) -> Types<'a> {
    let definitions = child(root, "TypeDefinitions");
    let types = definitions
        .into_iter()
        .flat_map(|list| list.children())
        .filter(Node::is_element);
    types
        .filter_map(|node| Some((node.attribute("name")?, node)))
        .collect()
}

/// The size that a structural parameter stands for, by its value reference.
fn structural(node: Node<'_, '_>) -> Option<(u32, usize)> {
    let number = |name| node.attribute(name).map(str::trim);
    // A constant may be a size, too.
    let is_size = node.attribute("causality") == Some("structuralParameter")
        || node.attribute("variability") == Some("constant");
    let reference = number("valueReference")?.parse().ok()?;
    is_size.then_some((reference, number("start")?.parse().ok()?))
}

/// The start values of all elements: a list in an attribute, or elements for texts.
fn starts(node: Node<'_, '_>) -> Vec<String> {
    if node.tag_name().name() == "String" {
        return children(node, "Start")
            .filter_map(|start| start.attribute("value"))
            .map(str::to_owned)
            .collect();
    }
    let list = node.attribute("start").unwrap_or_default();
    list.split_whitespace().map(str::to_owned).collect()
}

/// The type of an element of this name.
fn storage_of(name: &str) -> Option<Storage> {
    Some(match name {
        "Float32" => Storage::Float32,
        "Float64" => Storage::Float64,
        "Int8" => Storage::Int8,
        "UInt8" => Storage::UInt8,
        "Int16" => Storage::Int16,
        "UInt16" => Storage::UInt16,
        "Int32" => Storage::Int32,
        "UInt32" => Storage::UInt32,
        "Int64" => Storage::Int64,
        "UInt64" => Storage::UInt64,
        "Boolean" => Storage::Boolean,
        "String" => Storage::String,
        "Enumeration" => Storage::Enumeration,
        _ => return None,
    })
}

/// The smallest and the largest number of a type, where these bind: no value beyond them can be passed.
fn range(storage: Storage) -> (Option<i64>, Option<i64>) {
    match storage {
        Storage::Int8 => (Some(i8::MIN.into()), Some(i8::MAX.into())),
        Storage::UInt8 => (Some(0), Some(u8::MAX.into())),
        Storage::Int16 => (Some(i16::MIN.into()), Some(i16::MAX.into())),
        Storage::UInt16 => (Some(0), Some(u16::MAX.into())),
        Storage::Int32 => (Some(i32::MIN.into()), Some(i32::MAX.into())),
        Storage::UInt32 => (Some(0), Some(u32::MAX.into())),
        Storage::UInt64 => (Some(0), None),
        _ => (None, None),
    }
}

#[cfg(test)]
#[path = "parse_three_tests.rs"]
mod tests;
