//! Causality, variability and `initial` in FMI 3.0, and what refers to a variable of a certain kind (sections 2.4.7 and 2.4.8).

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use fmu_import::Version;

use super::{listed, name, of_each, reference, variables};
use crate::combinations;
use crate::document::{Document, at, elements, named};
use crate::hit::Hit;

fn is_float(node: Node<'_, '_>) -> bool {
    matches!(node.tag_name().name(), "Float32" | "Float64")
}

fn causality<'a>(node: Node<'a, 'a>) -> &'a str {
    node.attribute("causality").unwrap_or("local")
}

fn variability<'a>(node: Node<'a, 'a>) -> &'a str {
    let usual = match causality(node) {
        "parameter" | "calculatedParameter" | "structuralParameter" => "fixed",
        _ if is_float(node) => "continuous",
        _ => "discrete",
    };
    node.attribute("variability").unwrap_or(usual)
}

/// Whether the words are known. Others are findings of the schema, and nothing follows from them.
fn is_clear(node: Node<'_, '_>) -> bool {
    combinations::are_known(Version::Three, causality(node), variability(node))
}

/// The table of combinations of causality and variability.
pub(crate) fn variabilities(node: Node<'_, '_>, _: &Document<'_>) -> Option<String> {
    let (causality, variability) = (causality(node), variability(node));
    let allowed = combinations::variabilities(causality);
    if is_clear(node) && !allowed.contains(&variability) {
        let instead = allowed.join(" or ");
        return Some(format!(
            "causality {causality} and variability {variability} do not go together: set variability to {instead}"
        ));
    }
    let kind = node.tag_name().name();
    // The type of the time is another rule's.
    let wrong = variability == "continuous" && !is_float(node) && causality != "independent";
    wrong.then(|| {
        format!(
            "only a Float32 or Float64 is continuous: set variability to discrete for this {kind}"
        )
    })
}

/// The values of `initial` that are allowed, the usual one first; none for kinds that are unknown.
fn initials(node: Node<'_, '_>) -> &'static [&'static str] {
    match is_clear(node) {
        true => combinations::initials(Version::Three, causality(node), variability(node)),
        false => &[],
    }
}

/// How a variable is initialised: as it says, or as is usual for its kind.
pub(crate) fn initial<'a>(node: Node<'a, 'a>) -> &'a str {
    let usual = || initials(node).first().copied().unwrap_or_default();
    node.attribute("initial").unwrap_or_else(usual)
}

pub(crate) fn initial_values(node: Node<'_, '_>, _: &Document<'_>) -> Option<String> {
    let initial = node.attribute("initial")?;
    let allowed = initials(node);
    if !is_clear(node)
        || allowed.contains(&initial)
        || !["exact", "approx", "calculated"].contains(&initial)
    {
        return None;
    }
    Some(format!(
        "initial=\"{initial}\" is not allowed for causality {} and variability {}: {}",
        causality(node),
        variability(node),
        combinations::remedy(allowed)
    ))
}

/// Numbers that the schema takes and no model can start from.
pub(crate) fn not_finite(node: Node<'_, '_>, _: &Document<'_>) -> Option<String> {
    let start = node.attribute("start").filter(|_| is_float(node))?;
    let wrong = start.split_whitespace().find(|text| {
        let value = text.parse::<f64>();
        value.is_ok_and(|value| !value.is_finite())
    })?;
    Some(format!("start {wrong} is no finite number: give one"))
}

/// The variables by their value references.
fn by_reference<'a>(document: &Document<'a>) -> HashMap<u32, Node<'a, 'a>> {
    let known = variables(document).filter_map(|node| Some((reference(node)?, node)));
    known.collect()
}

pub(crate) fn derivatives(document: &Document<'_>) -> Vec<Hit> {
    let known = by_reference(document);
    let of_variables = of_each(document, |node| {
        let text = node.attribute("derivative")?;
        let of = text.trim().parse().ok().and_then(|of: u32| known.get(&of));
        let right = of.is_some_and(|of| is_float(*of) && variability(*of) == "continuous");
        (!right).then(|| {
            format!("derivative=\"{text}\" is the reference of no continuous float: correct it")
        })
    });
    let listed = listed(document, "ContinuousStateDerivative").filter_map(|element| {
        let node = *known.get(&reference(element)?)?;
        let text = format!(
            "ContinuousStateDerivative: {} has no attribute `derivative`: add it, with the state's reference",
            name(node)
        );
        (!node.has_attribute("derivative")).then(|| at(element, text))
    });
    of_variables.into_iter().chain(listed).collect()
}

pub(crate) fn clocks(document: &Document<'_>) -> Vec<Hit> {
    let known = by_reference(document);
    of_each(document, |node| {
        let mut clocks = node.attribute("clocks")?.split_whitespace();
        let wrong = clocks.find(|text| {
            let clock = text.parse().ok().and_then(|of: u32| known.get(&of));
            clock.is_none_or(|clock| clock.tag_name().name() != "Clock")
        })?;
        Some(format!(
            "clocks: {wrong} is the reference of no Clock: correct it"
        ))
    })
}

/// An element that `ModelStructure` has twice, and kinds of dependencies that are not as many as these.
pub(crate) fn structure(document: &Document<'_>) -> Vec<Hit> {
    let lists = named(document.root, "ModelStructure");
    let all: Vec<Node<'_, '_>> = lists.flat_map(elements).collect();
    let mut seen = HashSet::new();
    let second = all.iter().find(|node| {
        let of = reference(**node);
        of.is_some_and(|of| !seen.insert((node.tag_name().name(), of)))
    });
    let second = second.map(|node| {
        let kind = node.tag_name().name();
        let of = node.attribute("valueReference").unwrap_or_default();
        at(*node, format!("a second {kind} {of}: remove it"))
    });
    let counts = all.iter().filter_map(|node| {
        let kinds = node.attribute("dependenciesKind")?;
        let count = |text: Option<&str>| text.unwrap_or_default().split_whitespace().count();
        let (kinds, dependencies) = (count(Some(kinds)), count(node.attribute("dependencies")));
        let text = format!(
            "{} has {dependencies} dependencies and {kinds} kinds of them: give one each",
            node.tag_name().name()
        );
        (kinds != dependencies).then(|| at(*node, text))
    });
    second.into_iter().chain(counts).collect()
}
