//! Causality, variability and `initial` in FMI 3.0, and what refers to a variable of a certain kind (sections 2.4.7 and 2.4.8).

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use fmu_import::Version;

use super::{listed, reference};
use crate::combinations;
use crate::document::{Document, Scalar, at, elements, named};
use crate::hit::Hit;
use crate::variables::is_clear;

/// The table of combinations of causality and variability.
pub(crate) fn variabilities(scalar: &Scalar<'_>, _: &Document<'_>) -> Option<String> {
    let (causality, variability) = (scalar.causality, scalar.variability);
    let allowed = combinations::variabilities(causality);
    if is_clear(scalar, Version::Three) && !allowed.contains(&variability) {
        let instead = allowed.join(" or ");
        return Some(format!(
            "causality {causality} and variability {variability} do not go together: set variability to {instead}"
        ));
    }
    let kind = scalar.kind();
    // The type of the time is another rule's.
    let wrong = variability == "continuous" && !scalar.is_float() && causality != "independent";
    wrong.then(|| {
        format!(
            "only a Float32 or Float64 is continuous: set variability to discrete for this {kind}"
        )
    })
}

/// Numbers that the schema takes and no model can start from.
pub(crate) fn not_finite(scalar: &Scalar<'_>, _: &Document<'_>) -> Option<String> {
    let start = scalar.start().filter(|_| scalar.is_float())?;
    let wrong = start.split_whitespace().find(|text| {
        let value = text.parse::<f64>();
        value.is_ok_and(|value| !value.is_finite())
    })?;
    Some(format!("start {wrong} is no finite number: give one"))
}

/// The variables by their value references.
fn by_reference<'d, 'a>(document: &'d Document<'a>) -> HashMap<u32, &'d Scalar<'a>> {
    let known = document.known();
    known
        .filter_map(|scalar| Some((reference(scalar.node)?, scalar)))
        .collect()
}

pub(crate) fn derivatives(document: &Document<'_>) -> Vec<Hit> {
    let known = by_reference(document);
    let of_variables = document.of_each(|scalar| {
        let text = scalar.node.attribute("derivative")?;
        let of = text.trim().parse().ok().and_then(|of: u32| known.get(&of));
        let right = of.is_some_and(|of| of.is_float() && of.variability == "continuous");
        (!right).then(|| {
            format!("derivative=\"{text}\" is the reference of no continuous float: correct it")
        })
    });
    let listed = listed(document, "ContinuousStateDerivative").filter_map(|element| {
        let scalar = known.get(&reference(element)?)?;
        let text = format!(
            "ContinuousStateDerivative: {} has no attribute `derivative`: add it, with the state's reference",
            scalar.name
        );
        (!scalar.node.has_attribute("derivative")).then(|| at(element, text))
    });
    of_variables.into_iter().chain(listed).collect()
}

pub(crate) fn clocks(document: &Document<'_>) -> Vec<Hit> {
    let known = by_reference(document);
    document.of_each(|scalar| {
        let mut clocks = scalar.node.attribute("clocks")?.split_whitespace();
        let wrong = clocks.find(|text| {
            let clock = text.parse().ok().and_then(|of: u32| known.get(&of));
            clock.is_none_or(|clock| clock.kind() != "Clock")
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
