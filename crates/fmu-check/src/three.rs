//! Rules about model descriptions of FMI 3.0 (sections 2.4 to 2.4.8).

mod variables;

use std::collections::{HashMap, HashSet};
pub(crate) use variables::{
    clocks, derivatives, initial_values, not_finite, structure as lists, variabilities,
};

use roxmltree::Node;

use crate::document::{Document, at, elements, named};
use crate::hit::Hit;
use fmu_import::Kind;

/// The variables in their order.
fn variables<'a>(document: &Document<'a>) -> impl Iterator<Item = Node<'a, 'a>> + use<'a> {
    named(document.root, "ModelVariables").flat_map(elements)
}

fn name<'a>(node: Node<'a, 'a>) -> &'a str {
    node.attribute("name")
        .unwrap_or("a variable without a name")
}

fn reference(node: Node<'_, '_>) -> Option<u32> {
    node.attribute("valueReference")?.trim().parse().ok()
}

/// A finding at each variable where `wrong` says something.
pub(crate) fn of_each(
    document: &Document<'_>,
    wrong: impl Fn(Node<'_, '_>) -> Option<String>,
) -> Vec<Hit> {
    variables(document)
        .filter_map(|node| Some(at(node, format!("{}: {}", name(node), wrong(node)?))))
        .collect()
}

pub(crate) fn token(document: &Document<'_>) -> Vec<Hit> {
    if !document.read.guid.is_empty() {
        return Vec::new();
    }
    let text = "instantiationToken is missing or empty: write that of the binary";
    vec![at(document.root, text)]
}

pub(crate) fn empty_names(document: &Document<'_>) -> Vec<Hit> {
    let all = document.root.descendants();
    let nameless = all.filter(|node| node.attribute("name").is_some_and(str::is_empty));
    nameless
        .map(|node| {
            let element = node.tag_name().name();
            at(node, format!("{element}: an empty name: give it one"))
        })
        .collect()
}

/// The types that are known, usable or not.
const TYPES: &str = "Float32 Float64 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Enumeration Binary \
    Clock";

pub(crate) fn types(node: Node<'_, '_>, _: &Document<'_>) -> Option<String> {
    let kind = node.tag_name().name();
    TYPES
        .split(' ')
        .all(|known| known != kind)
        .then(|| format!("FMI 3.0 has no type `{kind}`: use one of its own"))
}

pub(crate) fn unusable(node: Node<'_, '_>, document: &Document<'_>) -> Option<String> {
    // Unknown types and sizes are errors of other rules.
    let is_other = matches!(node.tag_name().name(), "Binary" | "Clock");
    let why = document.read.unusable.get(name(node));
    let why = why.filter(|why| is_other || why.contains("more than"))?;
    Some(format!("it cannot be set or judged here: {why}"))
}

pub(crate) fn references(document: &Document<'_>) -> Vec<Hit> {
    let mut known: HashMap<u32, &str> = HashMap::new();
    let mut hits = Vec::new();
    for node in variables(document) {
        let Some(reference) = reference(node) else {
            continue;
        };
        if let Some(other) = known.insert(reference, name(node)) {
            let text = format!(
                "{}: valueReference {reference} is {other}'s, too: give each its own, or use Alias",
                name(node)
            );
            hits.push(at(node, text));
        }
    }
    hits
}

pub(crate) fn independent(document: &Document<'_>) -> Vec<Hit> {
    let is = |node: &Node<'_, '_>| node.attribute("causality") == Some("independent");
    let all: Vec<Node<'_, '_>> = variables(document).filter(is).collect();
    let [one] = all[..] else {
        let text = format!(
            "{} independent variables: FMI 3.0 wants one, usually `time`",
            all.len()
        );
        return vec![at(document.root, text)];
    };
    let is_float = matches!(one.tag_name().name(), "Float32" | "Float64");
    if is_float && !one.has_attribute("start") {
        return Vec::new();
    }
    let text = format!("{}: the time is a float without a start value", name(one));
    vec![at(one, text)]
}

pub(crate) fn starts(node: Node<'_, '_>, _: &Document<'_>) -> Option<String> {
    let causality = node.attribute("causality").unwrap_or("local");
    // The time has a rule of its own.
    if node.tag_name().name() == "Clock" || causality == "independent" {
        return None;
    }
    let initial = variables::initial(node);
    let given = node.has_attribute("start") || named(node, "Start").next().is_some();
    let needed = matches!(causality, "parameter" | "structuralParameter" | "input")
        || node.attribute("variability") == Some("constant")
        || matches!(initial, "exact" | "approx");
    let forbidden = initial == "calculated";
    if needed && !given {
        Some("it needs a start value".to_owned())
    } else if forbidden && !needed && given {
        Some("it is calculated, and has no start value: remove it".to_owned())
    } else {
        None
    }
}

pub(crate) fn ranges(document: &Document<'_>) -> Vec<Hit> {
    let mut told = HashSet::new();
    let wrong = document.read.variables.values().filter_map(|variable| {
        let (min, max) = variable.kind.range();
        let start = variable.kind.start();
        let text = match (min, start, max) {
            (Some(min), _, Some(max)) if min > max => {
                format!("min {min} is greater than max {max}")
            }
            (Some(min), Some(start), _) if start < min => {
                format!("start {start} is less than min {min}")
            }
            (_, Some(start), Some(max)) if start > max => {
                format!("start {start} is greater than max {max}")
            }
            _ => return None,
        };
        // All names and elements of a variable stand in one line.
        told.insert(variable.value_reference).then(|| Hit {
            line: Some(variable.line as usize),
            ..Hit::of(
                crate::document::NAME,
                format!("{}: {text}: correct one of them", variable.name),
            )
        })
    });
    wrong.collect()
}

pub(crate) fn declared(document: &Document<'_>) -> Vec<Hit> {
    let types: HashSet<&str> = named(document.root, "TypeDefinitions")
        .flat_map(elements)
        .filter_map(|node| node.attribute("name"))
        .collect();
    of_each(document, |node| {
        let declared = node.attribute("declaredType");
        if let Some(declared) = declared.filter(|name| !types.contains(name)) {
            return Some(format!(
                "declaredType \"{declared}\" is not defined: define it"
            ));
        }
        if declared.is_none() && node.tag_name().name() == "Enumeration" {
            return Some("an Enumeration needs a declaredType".to_owned());
        }
        let read = document.read.variables.get(name(node))?;
        let Kind::Real {
            unit: Some(unit), ..
        } = &read.kind
        else {
            return None;
        };
        document.undefined_unit(unit)
    })
}

pub(crate) fn dimensions(document: &Document<'_>) -> Vec<Hit> {
    let sizes: HashSet<u32> = variables(document)
        .filter(|node| {
            node.tag_name().name() == "UInt64"
                && (node.attribute("causality") == Some("structuralParameter")
                    || node.attribute("variability") == Some("constant"))
        })
        .filter_map(reference)
        .collect();
    of_each(document, |node| {
        named(node, "Dimension").find_map(|dimension| {
            let start = dimension.attribute("start");
            match (start, dimension.attribute("valueReference")) {
                (Some(start), None) => start
                    .trim()
                    .parse::<u64>()
                    .is_err()
                    .then(|| format!("the dimension \"{start}\" is no size")),
                (None, Some(_)) => {
                    let known = reference(dimension).is_some_and(|of| sizes.contains(&of));
                    (!known).then(|| {
                        "a dimension refers to no structural parameter or constant of type UInt64"
                            .to_owned()
                    })
                }
                _ => Some("a dimension has either a start or a valueReference".to_owned()),
            }
        })
    })
}

/// The elements of `ModelStructure` of one kind.
fn listed<'a>(
    document: &Document<'a>,
    kind: &'static str,
) -> impl Iterator<Item = Node<'a, 'a>> + use<'a> {
    named(document.root, "ModelStructure").flat_map(move |list| named(list, kind))
}

pub(crate) fn outputs(document: &Document<'_>) -> Vec<Hit> {
    let list: HashSet<u32> = listed(document, "Output").filter_map(reference).collect();
    let is_output = |node: &Node<'_, '_>| node.attribute("causality") == Some("output");
    let outputs: HashSet<u32> = variables(document)
        .filter(is_output)
        .filter_map(reference)
        .collect();
    let missing = of_each(document, |node| {
        let listed = !is_output(&node) || reference(node).is_some_and(|of| list.contains(&of));
        (!listed).then(|| "ModelStructure has no Output for it: add it".to_owned())
    });
    let known: HashSet<u32> = variables(document).filter_map(reference).collect();
    let surplus = listed(document, "Output").filter_map(|node| {
        let of = reference(node).filter(|of| known.contains(of) && !outputs.contains(of))?;
        Some(at(
            node,
            format!("Output {of} is the reference of no output: remove it"),
        ))
    });
    let surplus: Vec<Hit> = surplus.collect();
    missing.into_iter().chain(surplus).collect()
}

pub(crate) fn structure(document: &Document<'_>) -> Vec<Hit> {
    let known: HashSet<u32> = variables(document).filter_map(reference).collect();
    let all = named(document.root, "ModelStructure").flat_map(elements);
    all.filter_map(|node| {
        let kind = node.tag_name().name();
        let Some(of) = reference(node).filter(|of| known.contains(of)) else {
            return Some(at(
                node,
                format!("{kind} refers to no variable: correct its valueReference"),
            ));
        };
        let dependencies = node.attribute("dependencies").unwrap_or_default();
        let wrong = dependencies.split_whitespace().find(|text| {
            let of = text.parse().ok();
            !of.is_some_and(|of: u32| known.contains(&of))
        })?;
        Some(at(
            node,
            format!("{kind} {of} depends on {wrong}, which is no variable: correct it"),
        ))
    })
    .collect()
}
