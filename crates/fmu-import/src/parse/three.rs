//! The parts of `modelDescription.xml` that FMI 3.0 writes in its own way: capabilities, types and variables.
//!
//! An array becomes as many variables as it has elements, named `x[1]`, `x[2]` or `A[1,2]` in row order, so that each
//! can be varied, fed and judged. Its size is that of structural parameters: their start values, or those that were set.

use std::collections::HashMap;

use roxmltree::Node;

use crate::{
    description::{About, Description, Interface, Kind, Storage, StoragePlace, Timing, Variability, Variable},
    parse::{Reader, Types, item, text, truth},
    value::bytes_of,
    xml::{child, children, elements, tag},
};

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
    /// The variables of FMI 3.0.
    pub fn variables_of_three(&mut self, root: Node, into: &mut Description) {
        let types = types(root);
        let list = child(root, "ModelVariables");
        let nodes = || list.into_iter().flat_map(|list| list.children());
        let mut sizes: Sizes = nodes().filter_map(structural).collect();
        sizes.extend(into.sizes.iter().map(|(of, size)| (*of, *size as usize)));
        let mut first = 0;
        for node in nodes().filter(Node::is_element) {
            let Some(written) = self.written(node, first, &sizes, into) else { continue };
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
        let name = self.name(node)?;
        let mut refuse = |why| {
            into.unusable.insert(name.clone(), why);
            None
        };
        let Some(storage) = item(tag(node)) else {
            return refuse(format!("unknown type `{}`", tag(node)));
        };
        let is_silent = into.interface == Interface::CoSimulation && !into.capabilities.has_event_mode;
        if storage == Storage::Clock && is_silent {
            return refuse("a Clock ticks in event mode, which the FMU has not".to_owned());
        }
        let mut dimensions = Vec::new();
        for dimension in children(node, "Dimension") {
            let fixed = self.number::<usize>(dimension, "start");
            let of = self.number::<u32>(dimension, "valueReference");
            let size = fixed.or_else(|| sizes.get(&of?).copied());
            let Some(size) = size else { return refuse("the size of its array is not known".to_owned()) };
            dimensions.push(size);
        }
        let count = dimensions.iter().try_fold(1_usize, |all, size| all.checked_mul(*size));
        if count.filter(|count| *count <= MOST_ELEMENTS && first.checked_add(MOST_ELEMENTS as u32).is_some()).is_none()
        {
            return refuse(format!("an array of more than {MOST_ELEMENTS} elements is not read"));
        }
        Some(Written { node, storage, first, sizes: dimensions })
    }

    /// Adds the elements of a variable, by its name and by its aliases.
    fn elements(&mut self, written: &Written, types: &Types, into: &mut Description) {
        let node = written.node;
        let name = text(node, "name").unwrap_or_default();
        let Some(value_reference) = self.reference(node, &name) else { return };
        let declared = node.attribute("declaredType").and_then(|name| types.get(name)).copied();
        let mut starts = starts(node);
        let resized = into.sizes.iter().find(|(of, _)| *of == value_reference);
        if let Some((_, size)) = resized {
            starts = vec![size.to_string()];
        }
        let variable = Variable {
            name,
            line: self.line(node),
            value_reference,
            place: None,
            description: node.attribute("description").map(str::to_owned),
            causality: self.choice(node, "causality"),
            variability: self.variability_of_three(written),
            clocks: references(node.attribute("clocks")),
            kind: self.kind(node, declared, Some(written.storage)),
        };
        let count = written.count();
        // Other sizes leave the start values to the FMU.
        if !matches!(starts.len(), 0 | 1) && starts.len() != count && into.sizes.is_empty() {
            self.remark(
                node,
                About::Value,
                format!(
                    "`{}` has {} start values for {count} elements; they are not read",
                    variable.name,
                    starts.len()
                ),
            );
        }
        let elements: Vec<Variable> = (0..count)
            .map(|index| {
                let start = match &starts[..] {
                    [one] => Some(one),
                    all if all.len() == count => all.get(index),
                    _ => None,
                };
                let mut element = variable.clone();
                element.place = Some(StoragePlace {
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
            let Some(name) = text(alias, "name") else { continue };
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

    /// As written, or the default of FMI 3.0.
    fn variability_of_three(&mut self, written: &Written) -> Variability {
        let node = written.node;
        if node.has_attribute("variability") {
            return self.choice(node, "variability");
        }
        let is_float = matches!(written.storage, Storage::Float32 | Storage::Float64);
        match node.attribute("causality") {
            Some("parameter" | "structuralParameter" | "calculatedParameter") => Variability::Tunable,
            _ if is_float => Variability::Continuous,
            _ => Variability::Discrete,
        }
    }

    /// When a clock ticks: a fraction where there is one, as that is exact.
    pub fn timing(&mut self, node: Node, declared: Option<Node>) -> Timing {
        let declared = declared.unwrap_or(node);
        let source = |name: &str| {
            if node.has_attribute(name) { node } else { declared }
        };
        let resolution: Option<f64> = self.number(source("resolution"), "resolution");
        let mut time = |counter: &str, decimal: &str| {
            let counter: Option<f64> = self.number(source(counter), counter);
            counter.zip(resolution).map(|(counter, of)| counter / of).or_else(|| self.number(source(decimal), decimal))
        };
        let interval = time("intervalCounter", "intervalDecimal");
        let shift = time("shiftCounter", "shiftDecimal");
        Timing { by: self.choice(source("intervalVariability"), "intervalVariability"), interval, shift }
    }

    /// Reads a start value.
    fn begin(&mut self, written: &Written, kind: &mut Kind, text: &str) {
        let (node, storage) = (written.node, written.storage);
        match kind {
            Kind::Real { start, .. } => *start = text.parse().ok(),
            Kind::Integer { start, .. } | Kind::Enumeration { start, .. } => {
                *start = storage.whole(text);
            }
            Kind::Boolean { start } => *start = truth(text),
            Kind::String { start } if storage == Storage::Binary => {
                *start = bytes_of(text).map(|_| text.to_lowercase());
            }
            Kind::String { start } => *start = Some(text.to_owned()),
            Kind::Clock(_) => {}
        }
        if kind.start_value().is_none() {
            self.remark(
                node,
                About::Value,
                format!("start=\"{text}\" cannot be read as a value of the variable's type"),
            );
        }
    }
}

/// A list of value references.
fn references(list: Option<&str>) -> Vec<u32> {
    list.unwrap_or_default().split_whitespace().filter_map(|word| word.parse().ok()).collect()
}

/// Attributes of the types, by their names.
fn types<'a>(root: Node<'a, 'a>) -> Types<'a> {
    child(root, "TypeDefinitions")
        .into_iter()
        .flat_map(elements)
        .filter_map(|node| Some((node.attribute("name")?, node)))
        .collect()
}

/// The size that a structural parameter stands for, by its value reference.
fn structural(node: Node) -> Option<(u32, usize)> {
    let number = |name| node.attribute(name).map(str::trim);
    // A constant may be a size, too.
    let is_size =
        node.attribute("causality") == Some("structuralParameter") || node.attribute("variability") == Some("constant");
    let reference = number("valueReference")?.parse().ok()?;
    is_size.then_some((reference, number("start")?.parse().ok()?))
}

/// The start values of all elements: a list in an attribute, or elements for texts.
fn starts(node: Node) -> Vec<String> {
    if matches!(tag(node), "String" | "Binary") {
        return children(node, "Start").filter_map(|start| start.attribute("value")).map(str::to_owned).collect();
    }
    node.attribute("start").unwrap_or_default().split_whitespace().map(str::to_owned).collect()
}

#[cfg(test)]
#[path = "three_tests.rs"]
mod tests;
