//! Rules about `ModelStructure` (FMI 2.0.5, section 2.2.8): its lists name variables by their index, counted from 1.
//!
//! Where a list has wrong entries, what it lacks or has too much is not asked: correcting them may change that.

use std::collections::HashSet;

use roxmltree::Node;

use crate::{
    document::{Document, Scalar, at, named},
    hit::Hit,
};

/// The element itself. Without it the schema's rules have said so.
fn structure<'a>(document: &Document<'a>) -> Option<Node<'a, 'a>> {
    named(document.root, "ModelStructure").next()
}

fn is_output(scalar: &Scalar) -> bool {
    scalar.causality == "output"
}

/// Whether the FMU computes its value initially.
fn is_computed(scalar: &Scalar) -> bool {
    ["calculated", "approx"].contains(&scalar.initial)
}

/// Entries of `Outputs` that are no outputs.
pub fn outputs(document: &Document) -> Vec<Hit> {
    list(document, "Outputs", &|scalar| (!is_output(scalar)).then_some("is no output"))
}

/// Outputs that `Outputs` lacks.
pub fn outputs_missing(document: &Document) -> Vec<Hit> {
    if !outputs(document).is_empty() {
        return Vec::new();
    }
    missing(document, "Outputs", &is_output)
}

/// Entries of `Derivatives` that are no state derivatives.
pub fn derivatives(document: &Document) -> Vec<Hit> {
    list(document, "Derivatives", &|scalar| {
        if !scalar.typed.has_attribute("derivative") {
            return Some("has no attribute derivative");
        }
        let state = state_of(document, scalar);
        let local = state.is_none_or(|state| ["local", "output"].contains(&state.causality));
        (!local).then_some("is the derivative of a variable that is neither local nor an output")
    })
}

/// State derivatives that do not change continuously.
pub fn derivatives_discrete(document: &Document) -> Vec<Hit> {
    if !derivatives(document).is_empty() {
        return Vec::new();
    }
    list(document, "Derivatives", &|scalar| {
        let continuous = scalar.variability == "continuous";
        (!continuous).then_some("is not continuous")
    })
}

/// States are declared, but no state derivatives.
pub fn derivatives_missing(document: &Document) -> Vec<Hit> {
    if document.all("ModelStructure", "Derivatives").next().is_some() {
        return Vec::new();
    }
    missing(document, "Derivatives", &|scalar| {
        // A state that cannot be is a finding of its own.
        state_of(document, scalar).is_some_and(|state| {
            state.kind() == "Real" && state.variability == "continuous" && state.position != scalar.position
        }) && !scalar.is_settable()
    })
}

/// Entries of `InitialUnknowns` that are known initially.
pub fn initial_unknowns(document: &Document) -> Vec<Hit> {
    list(document, "InitialUnknowns", &|scalar| match scalar.causality {
        "parameter" => Some("is a parameter, so known initially"),
        "input" => Some("is an input, so known initially"),
        _ => None,
    })
}

/// Outputs, calculated parameters, states and their derivatives that are computed initially.
pub fn initial_unknowns_missing(document: &Document) -> Vec<Hit> {
    if !initial_unknowns(document).is_empty() {
        return Vec::new();
    }
    let states = states_and_derivatives(document);
    missing(document, "InitialUnknowns", &|scalar| {
        let computed = is_output(scalar) || states.contains(&scalar.position);
        scalar.causality == "calculatedParameter" || computed && is_computed(scalar)
    })
}

/// Entries of `InitialUnknowns` that the list is not made for.
pub fn initial_unknowns_surplus(document: &Document) -> Vec<Hit> {
    let Some(structure) = structure(document) else { return Vec::new() };
    if !initial_unknowns(document).is_empty() {
        return Vec::new();
    }
    let states = states_and_derivatives(document);
    // An output that is not computed does no harm here.
    let is_wanted = |scalar: &Scalar| {
        scalar.causality == "calculatedParameter"
            || is_output(scalar)
            || states.contains(&scalar.position) && is_computed(scalar)
    };
    let names: Vec<String> = entries(document, "InitialUnknowns")
        .filter(|scalar| !is_wanted(scalar))
        .map(|scalar| scalar.name.to_owned())
        .collect();
    let text = format!(
        "InitialUnknowns: {} is no output, calculated parameter, state or state derivative that is computed \
         initially: remove it",
        short(&names)
    );
    Vec::from_iter((!names.is_empty()).then(|| at(structure, text)))
}

/// An order of `InitialUnknowns` that is not that of the variables.
pub fn initial_unknowns_unsorted(document: &Document) -> Vec<Hit> {
    if !initial_unknowns(document).is_empty() {
        return Vec::new();
    }
    let mut greatest = 0;
    // The first one that comes after one of a greater index.
    let unsorted = listed(document, "InitialUnknowns").find_map(|unknown| {
        let index = unknown.attribute("index")?.trim().parse::<usize>().ok()?;
        if index < greatest {
            let text = format!("InitialUnknowns: index {index} after {greatest}: sort the list by index");
            return Some(at(unknown, text));
        }
        greatest = index;
        None
    });
    Vec::from_iter(unsorted)
}

/// Nothing is forbidden about it, but a study has to look elsewhere.
pub fn no_outputs(document: &Document) -> Vec<Hit> {
    if document.known().any(is_output) {
        return Vec::new();
    }
    let text = "no outputs: simulate records the local variables, and criteria may use them";
    vec![Hit::of(crate::document::NAME, text)]
}

/// The positions of the states and their derivatives, as `Derivatives` lists them.
fn states_and_derivatives(document: &Document) -> HashSet<usize> {
    entries(document, "Derivatives").map(|scalar| scalar.position).chain(states(document)).collect()
}

/// The positions of the states: the variables of which `Derivatives` lists the derivatives.
pub fn states(document: &Document) -> HashSet<usize> {
    entries(document, "Derivatives").filter_map(|scalar| Some(state_of(document, scalar)?.position)).collect()
}

/// The variable of which this one is the derivative.
fn state_of<'d, 'a>(document: &'d Document<'a>, scalar: &Scalar) -> Option<&'d Scalar<'a>> {
    scalar_of(document, scalar.typed.attribute("derivative")?)
}

/// The variable of an index.
pub fn scalar_of<'d, 'a>(document: &'d Document<'a>, index: &str) -> Option<&'d Scalar<'a>> {
    document.scalars[position(document, index)?].as_ref()
}

/// The variables of one list.
fn entries<'d, 'a>(document: &'d Document<'a>, name: &'static str) -> impl Iterator<Item = &'d Scalar<'a>> {
    listed(document, name).filter_map(|unknown| scalar_of(document, unknown.attribute("index")?))
}

/// The unknowns of one list, where there is a `ModelStructure`.
pub fn listed<'a>(document: &Document<'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> + use<'a> {
    document.all("ModelStructure", name).flat_map(|list| named(list, "Unknown"))
}

/// The position of the variable of an index.
fn position(document: &Document, index: &str) -> Option<usize> {
    let position = index.trim().parse::<usize>().ok()?.checked_sub(1)?;
    (position < document.scalars.len()).then_some(position)
}

/// The unknowns of one list that cannot be: `unfit` says why a variable cannot be in it.
fn list(document: &Document, name: &'static str, unfit: &dyn Fn(&Scalar) -> Option<&'static str>) -> Vec<Hit> {
    let scalars = &document.scalars;
    let mut seen = HashSet::new();
    listed(document, name)
        .filter_map(|unknown| {
            let index = unknown.attribute("index")?;
            let wrong = match position(document, index) {
                None => format!("is none of the {} variables: indexes count them from 1", scalars.len()),
                Some(position) if !seen.insert(position) => "is listed twice: remove one of them".to_owned(),
                Some(position) => {
                    let scalar = scalars[position].as_ref()?;
                    format!("is {}, which {}: correct the index or remove it", scalar.name, unfit(scalar)?)
                }
            };
            Some(at(unknown, format!("{name}: index {index} {wrong}")))
        })
        .collect()
}

/// The variables that a list must have but has not, in one finding.
fn missing(document: &Document, name: &'static str, wanted: &dyn Fn(&Scalar) -> bool) -> Vec<Hit> {
    let Some(structure) = structure(document) else { return Vec::new() };
    // An entry without an index means nothing.
    if listed(document, name).any(|unknown| !unknown.has_attribute("index")) {
        return Vec::new();
    }
    let listed: HashSet<usize> = entries(document, name).map(|scalar| scalar.position).collect();
    let absent: Vec<String> = document
        .known()
        .filter(|scalar| wanted(scalar) && !listed.contains(&scalar.position))
        .map(|scalar| format!("{} (index {})", scalar.name, scalar.position + 1))
        .collect();
    if absent.is_empty() {
        return Vec::new();
    }
    let text = format!(
        "ModelStructure does not list {} in {name}: add {} there",
        short(&absent),
        if absent.len() == 1 { "it" } else { "them" }
    );
    vec![at(structure, text)]
}

/// The first few of many.
pub fn short(names: &[String]) -> String {
    const FEW: usize = 5;
    let mut text = names[..names.len().min(FEW)].join(", ");
    if names.len() > FEW {
        text += &format!(" and {} more", names.len() - FEW);
    }
    text
}
