//! Causality, variability and `initial` in FMI 3.0, and what refers to a variable of a certain kind (sections 2.4.7 and 2.4.8).

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use fmu_import::Interface;

use super::reference;
use crate::{
    combinations,
    document::{Document, Scalar, Variable, at, elements, named, tag},
    hit::Hit,
    variables::is_clear,
};

/// The table of combinations of causality and variability.
pub fn variabilities(scalar: Variable) -> Option<String> {
    let (causality, variability) = (scalar.causality, scalar.variability);
    let allowed = combinations::variabilities(causality);
    if is_clear(scalar) && !allowed.contains(&variability) {
        let instead = allowed.join(" or ");
        return Some(format!(
            "causality {causality} and variability {variability} do not go together: set variability to {instead}"
        ));
    }
    if is_clocked(&scalar) && variability == "continuous" {
        return Some("a clocked variable changes at ticks only: set variability to discrete".to_owned());
    }
    let kind = scalar.kind();
    // The type of the time is another rule's.
    let wrong = variability == "continuous" && !scalar.is_float() && causality != "independent";
    wrong.then(|| format!("only a Float32 or Float64 is continuous: set variability to discrete for this {kind}"))
}

/// Numbers that the schema takes and no model can start from.
pub fn not_finite(scalar: Variable) -> Option<String> {
    let wrong = scalar.start().filter(|_| scalar.is_float())?.split_whitespace().find(|text| {
        let value = text.parse::<f64>();
        value.is_ok_and(|value| !value.is_finite())
    })?;
    Some(format!("start {wrong} is no finite number: give one"))
}

/// The variables by their value references.
fn by_reference<'d, 'a>(document: &'d Document<'a>) -> HashMap<u32, &'d Scalar<'a>> {
    document.known().filter_map(|scalar| Some((reference(scalar.node)?, scalar))).collect()
}

pub fn derivatives(document: &Document) -> Vec<Hit> {
    let known = by_reference(document);
    let of_variables = document.of_each(|scalar| {
        let text = scalar.node.attribute("derivative")?;
        let of = text.trim().parse().ok().and_then(|of: u32| known.get(&of));
        let right = of.is_some_and(|of| of.is_float() && of.variability == "continuous");
        (!right).then(|| format!("derivative=\"{text}\" is the reference of no continuous float: correct it"))
    });
    let listed = document.all("ModelStructure", "ContinuousStateDerivative").filter_map(|element| {
        let scalar = known.get(&reference(element)?)?;
        let text = format!(
            "ContinuousStateDerivative: {} has no attribute `derivative`: add it, with the state's reference",
            scalar.name
        );
        (!scalar.node.has_attribute("derivative")).then(|| at(element, text))
    });
    of_variables.into_iter().chain(listed).collect()
}

pub fn clocks(document: &Document) -> Vec<Hit> {
    let known = by_reference(document);
    document.of_each(|scalar| {
        let mut clocks = scalar.node.attribute("clocks")?.split_whitespace();
        let wrong = clocks.find(|text| {
            let clock = text.parse().ok().and_then(|of: u32| known.get(&of));
            clock.is_none_or(|clock| clock.kind() != "Clock")
        })?;
        Some(format!("clocks: {wrong} is the reference of no Clock: correct it"))
    })
}

/// The values of a clock that belong to its kind.
pub fn timing(document: &Document) -> Vec<Hit> {
    let clocks = || document.known().filter(|scalar| scalar.kind() == "Clock");
    let has_event_mode =
        document.read.interface != Interface::CoSimulation || document.read.capabilities.has_event_mode;
    let silent = clocks()
        .next()
        .filter(|_| !has_event_mode)
        .map(|clock| clock.finding("Co-Simulation with clocks needs event mode: set hasEventMode to true"));
    let wrong = document.of_each(|scalar| {
        let given = |name| scalar.effective(name);
        let kind = given("intervalVariability").filter(|_| scalar.kind() == "Clock")?;
        let is_input = scalar.causality == "input";
        if !is_input && kind != "triggered" {
            return Some(format!("only an input ticks by time: {kind} and {} do not go together", scalar.causality));
        }
        let interval = given("intervalDecimal").map(|text| text.trim().parse::<f64>());
        match (kind, interval) {
            (_, Some(Ok(interval))) if interval <= 0.0 => Some("intervalDecimal is greater than 0".to_owned()),
            ("constant", None) => Some("a constant clock needs intervalDecimal".to_owned()),
            ("changing" | "countdown" | "triggered", Some(_)) => {
                Some(format!("a {kind} clock has no intervalDecimal: remove it"))
            }
            _ => None,
        }
    });
    silent.into_iter().chain(wrong).collect()
}

/// Unknowns of the initialisation that are missing or none.
pub fn initial_unknowns(document: &Document) -> Vec<Hit> {
    let known = by_reference(document);
    let rates: HashSet<u32> =
        document.all("ModelStructure", "ContinuousStateDerivative").filter_map(reference).collect();
    let states: HashSet<u32> =
        rates.iter().filter_map(|rate| known.get(rate)?.node.attribute("derivative")?.trim().parse().ok()).collect();
    let list: HashSet<u32> = document.all("ModelStructure", "InitialUnknown").filter_map(reference).collect();
    let is_wanted = |scalar: &Scalar, of: u32| {
        let is_computed = matches!(scalar.initial, "approx" | "calculated");
        let is_unknown = scalar.causality == "output" || states.contains(&of) || rates.contains(&of);
        !is_clocked(scalar) && is_computed && (scalar.causality == "calculatedParameter" || is_unknown)
    };
    let missing = document.of_each(|scalar| {
        let of = reference(scalar.node)?;
        // A clock has no value before the first event.
        let missing = scalar.kind() != "Clock" && is_wanted(&scalar, of) && !list.contains(&of);
        missing.then(|| "ModelStructure has no InitialUnknown for it: add it".to_owned())
    });
    let surplus = document.all("ModelStructure", "InitialUnknown").filter_map(|node| {
        let of = reference(node)?;
        let scalar = known.get(&of)?;
        let text = format!("InitialUnknown: {} is none that is computed initially: remove it", scalar.name);
        (!is_wanted(scalar, of) && !is_clocked(scalar)).then(|| at(node, text))
    });
    missing.into_iter().chain(surplus).collect()
}

fn is_clocked(scalar: &Scalar) -> bool {
    scalar.node.has_attribute("clocks")
}

/// An element that `ModelStructure` has twice, and kinds of dependencies that are not as many as these.
pub fn structure(document: &Document) -> Vec<Hit> {
    let all: Vec<Node> = named(document.root, "ModelStructure").flat_map(elements).collect();
    let mut seen = HashSet::new();
    let second = all
        .iter()
        .copied()
        .find(|node| {
            let of = reference(*node);
            of.is_some_and(|of| !seen.insert((tag(*node), of)))
        })
        .map(|node| {
            let kind = tag(node);
            let of = node.attribute("valueReference").unwrap_or_default();
            at(node, format!("a second {kind} {of}: remove it"))
        });
    let counts = all.iter().filter_map(|&node| {
        let kinds = node.attribute("dependenciesKind")?;
        let count = |text: Option<&str>| text.unwrap_or_default().split_whitespace().count();
        let (kinds, dependencies) = (count(Some(kinds)), count(node.attribute("dependencies")));
        let text = format!("{} has {dependencies} dependencies and {kinds} kinds of them: give one each", tag(node));
        (kinds != dependencies).then(|| at(node, text))
    });
    second.into_iter().chain(counts).collect()
}
