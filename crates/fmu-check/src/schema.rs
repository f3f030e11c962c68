//! The elements and attributes of `modelDescription.xml` (FMI 2.0.5, sections 2.2 and 4.3.1; FMI 3.0.2, section 2.4): what is none
//! of them is a typing error, or belongs into an annotation.

use std::sync::LazyLock;

use roxmltree::Node;

use crate::{
    document::{Document, at, elements, tag},
    hit::Hit,
};
use fmu_import::Version;
use fmu_points::names::{did_you_mean, nearest};

/// An element, or several that are alike: the name, with the parent's where it has several; its attributes and its children. Those that must
/// be there are marked by `!`, unless the reader remarks on them itself; children of which there may be many by `*`, in any
/// order by `~`, and those of which there must be at least one by `+`.
type Element = (&'static str, &'static str, &'static str);

/// The children of an element in which anything may be.
const ANYTHING: &str = "anything";

/// The elements of FMI 2.0.
static TWO: LazyLock<Vec<Element>> = LazyLock::new(|| table(include_str!("schema/two.txt")));
/// The elements of FMI 3.0.
static THREE: LazyLock<Vec<Element>> = LazyLock::new(|| table(include_str!("schema/three.txt")));

/// The rows of a table, below its head.
fn table(text: &'static str) -> Vec<Element> {
    let row = |row: &'static str| {
        let mut cells = row.split('|').map(str::trim);
        let mut cell = || cells.next().unwrap_or_default();
        (cell(), cell(), cell())
    };
    text.lines().skip(1).map(row).collect()
}

fn element(version: Version, parent: &str, name: &str) -> Option<Element> {
    let all = match version {
        Version::Two => &TWO,
        Version::Three => &THREE,
    };
    let named = |wanted: &str| all.iter().copied().find(|(names, ..)| names.split(' ').any(|name| name == wanted));
    named(&format!("{parent}/{name}")).or_else(|| named(name))
}

/// Elements of which a variable or a type has one.
const TYPES: [&str; 5] = ["Real", "Integer", "Boolean", "String", "Enumeration"];

/// A namespace that the elements of FMI have not.
pub fn namespace(document: &Document) -> Vec<Hit> {
    let space = document.root.tag_name().namespace();
    let version = document.read.standard.number();
    let text = |space: &str| format!("the namespace \"{space}\": the elements of FMI {version} have none, remove it");
    Vec::from_iter(space.map(|space| at(document.root, text(space))))
}

/// The namespace of attributes that every document may have, to name its schema.
const INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";

/// Attributes that are none of FMI.
pub fn unknown_attributes(document: &Document) -> Vec<Hit> {
    let version = document.read.standard.number();
    visit(document, |node, (_, attributes, _), hits| {
        let given = node.attributes().filter(|a| a.namespace() != Some(INSTANCE));
        for attribute in given {
            let (foreign, attribute) = (attribute.namespace().is_some(), attribute.name());
            if foreign || known(attributes).all(|known| known != attribute) {
                let meant = did_you_mean(nearest(attribute, known(attributes)));
                let name = tag(node);
                hits.push(at(
                    node,
                    format!("`{name}` has no attribute `{attribute}` in FMI {version}: remove it{meant}"),
                ));
            }
        }
    })
}

/// Attributes that must be there.
pub fn missing_attributes(document: &Document) -> Vec<Hit> {
    visit(document, |node, (_, attributes, _), hits| {
        for attribute in missing(attributes).filter(|wanted| !node.has_attribute(*wanted)) {
            let name = tag(node);
            hits.push(at(node, format!("`{name}` needs the attribute `{attribute}`: add it")));
        }
    })
}

/// Elements that are none of FMI.
pub fn unknown_elements(document: &Document) -> Vec<Hit> {
    let version = document.read.standard.number();
    visit(document, |node, (_, _, children), hits| {
        for child in node.children().filter(Node::is_element) {
            let inner = tag(child);
            let foreign = child.tag_name().namespace().is_some();
            let strange = foreign || known(children).all(|known| known != inner);
            if children != ANYTHING && strange {
                let meant = did_you_mean(nearest(inner, known(children)));
                hits.push(at(child, format!(
                    "`{}` has no element `{inner}` in FMI {version}: remove it, or put it into an annotation{meant}",
                    tag(node)
                )));
            }
        }
    })
}

/// Text between elements.
pub fn text(document: &Document) -> Vec<Hit> {
    visit(document, |node, (_, _, children), hits| {
        let stray = node
            .children()
            .filter(Node::is_text)
            .filter_map(|text| Some(text.text()?.trim()))
            .find(|text| !text.is_empty());
        if let Some(stray) = stray.filter(|_| children != ANYTHING) {
            hits.push(at(node, format!("the text `{}` in `{}`: remove it", start_of(stray), tag(node))));
        }
    })
}

/// The first characters of a text.
fn start_of(text: &str) -> String {
    const FEW: usize = 20;
    let mut start: String = text.chars().take(FEW).collect();
    if text.chars().nth(FEW).is_some() {
        start += "...";
    }
    start
}

/// Elements that must be there.
pub fn missing_elements(document: &Document) -> Vec<Hit> {
    visit(document, |node, (_, _, children), hits| {
        for wanted in missing(children) {
            if elements(node).all(|child| tag(child) != wanted) {
                let name = tag(node);
                hits.push(at(node, format!("`{name}` needs the element `{wanted}`: add it")));
            }
        }
    })
}

/// Elements in another order than the schema's, or twice.
pub fn order(document: &Document) -> Vec<Hit> {
    visit(document, |node, (_, _, children), hits| {
        if children != ANYTHING {
            let version = document.read.standard;
            hits.extend(disordered(version, node, children));
        }
    })
}

/// Lists in which there is nothing.
pub fn empty_lists(document: &Document) -> Vec<Hit> {
    visit(document, |node, (name, _, children), hits| {
        let inner = children.strip_suffix('+');
        if let Some(inner) = inner.filter(|_| elements(node).next().is_none()) {
            let remedy = match name {
                "SimpleType/Enumeration" => "add its items",
                _ => "remove it, or add one",
            };
            let list = tag(node);
            hits.push(at(node, format!("`{list}` has no `{inner}` in it: {remedy}")));
        }
    })
}

/// Type definitions without a type.
pub fn typeless(document: &Document) -> Vec<Hit> {
    document
        .all("TypeDefinitions", "SimpleType")
        .filter(|node| elements(*node).next().is_none())
        .map(|node| at(node, "`SimpleType` has no type in it: add Real, Integer, Boolean, String or Enumeration"))
        .collect()
}

/// Values that are not of their attribute's type, where nobody else reads them.
pub fn values(document: &Document) -> Vec<Hit> {
    let mut wrong = visit(document, |node, (element, attributes, _), hits| {
        let typed =
            TYPED.iter().filter(|(elements, ..)| elements.is_empty() || elements.split(' ').any(|one| one == element));
        for (_, names, of) in typed {
            let (is, what) = type_named(of);
            for name in names.split(' ').filter(|name| known(attributes).any(|known| known == *name)) {
                if let Some(text) = node.attribute(name).filter(|text| !is(text.trim())) {
                    hits.push(at(node, format!("{name}=\"{text}\" is {what}")));
                }
            }
        }
    });
    let remarks = &document.read.remarks;
    // The reader has remarked on faults in the parts that it uses.
    wrong.retain(|hit| {
        let line = hit.position.map(|position| document.line(position));
        remarks.iter().all(|remark| Some(remark.line) != line)
    });
    wrong
}

/// A type of values: whether a text is one of them, and what it is else.
type Values = (fn(&str) -> bool, &'static str);

const FLAG: Values = (|text| ["true", "false", "1", "0"].contains(&text), "neither true nor false");
const NUMBER: Values = (|text| text.parse::<f64>().is_ok(), "not a number");
const WHOLE: Values = (|text| text.parse::<i32>().is_ok(), "not a whole number");
const COUNT: Values = (|text| text.parse::<u32>().is_ok(), "not a whole number from 0 on");
const INITIAL: Values =
    (|text| ["exact", "approx", "calculated"].contains(&text), "none of exact, approx and calculated");

/// The type of this name.
fn type_named(name: &str) -> Values {
    match name {
        "flag" => FLAG,
        "number" => NUMBER,
        "whole" => WHOLE,
        "count" => COUNT,
        _ => INITIAL,
    }
}

/// Attributes that the reader does not use, with their types. It takes the capabilities from the Co-Simulation part.
static TYPED: LazyLock<Vec<Element>> = LazyLock::new(|| table(include_str!("schema/typed.txt")));

fn known(list: &'static str) -> impl Iterator<Item = &'static str> {
    list.split(' ').map(|word| word.trim_end_matches(['!', '*', '+', '~']))
}

fn missing(list: &'static str) -> impl Iterator<Item = &'static str> {
    list.split(' ').filter_map(|word| word.strip_suffix('!'))
}

/// Hands over all elements that the standard knows, and their descriptions.
fn visit(document: &Document, mut look: impl FnMut(Node, Element, &mut Vec<Hit>)) -> Vec<Hit> {
    let mut hits = Vec::new();
    let mut open = vec![(document.root, "")];
    while let Some((node, parent)) = open.pop() {
        let Some(element) = element(document.read.standard, parent, tag(node)) else { continue };
        look(node, element, &mut hits);
        let inner =
            elements(node).filter(|child| element.2 != ANYTHING && known(element.2).any(|known| known == tag(*child)));
        let begin = open.len();
        open.extend(inner.map(|child| (child, tag(node))));
        open[begin..].reverse();
    }
    hits
}

/// The first child that comes after one that it must come before, or comes a second time.
fn disordered(version: Version, node: Node, children: &'static str) -> Option<Hit> {
    if children.ends_with('~') {
        return None;
    }
    let order = Vec::from_iter(known(children));
    let many = |name: &str| {
        let mut all = children.split(' ');
        all.any(|child| child.strip_suffix(['*', '+']) == Some(name))
    };
    let mut last: Option<usize> = None;
    elements(node).find_map(|child| {
        let name = tag(child);
        let place = order.iter().position(|known| *known == name)?;
        let wrong = match last {
            Some(before) if TYPES.contains(&name) && TYPES.contains(&order[before]) => {
                format!("a second type `{name}`: leave the right one only")
            }
            // The schema of FMI 2.0 leaves the order of these two open.
            Some(before) if version == Version::Two && (name, order[before]) == ("ModelExchange", "CoSimulation") => {
                return None;
            }
            Some(before) if place < before => {
                format!("`{name}` after `{}`: put it before that", order[before])
            }
            Some(before) if place == before && !many(name) => {
                format!("a second `{name}`: put all into the first one")
            }
            _ => {
                last = Some(place);
                return None;
            }
        };
        Some(at(child, &wrong))
    })
}
