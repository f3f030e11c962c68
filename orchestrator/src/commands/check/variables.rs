//! What the variables say of causality, variability, start values and each other (FMI 2.0.4, section 2.2.7).

use std::collections::HashMap;

use roxmltree::Node;

use super::document::{Scalar, named};

const CAUSALITIES: [&str; 6] = [
    "parameter",
    "calculatedParameter",
    "input",
    "output",
    "local",
    "independent",
];

const VARIABILITIES: [&str; 5] = ["constant", "fixed", "tunable", "discrete", "continuous"];

/// All that is wrong with the variables beside their values.
pub(super) fn broken(root: Node<'_, '_>, scalars: &[Option<Scalar<'_>>]) -> Vec<String> {
    let types: HashMap<&str, &str> = named(root, "TypeDefinitions")
        .flat_map(|list| named(list, "SimpleType"))
        .filter_map(|node| {
            let kind = node.children().find(Node::is_element)?;
            Some((node.attribute("name")?, kind.tag_name().name()))
        })
        .collect();
    let known = || scalars.iter().flatten();
    let mut findings: Vec<String> = known()
        .filter_map(|scalar| {
            // The reader remarks on unknown words, and nothing follows from them.
            if !CAUSALITIES.contains(&scalar.causality)
                || !VARIABILITIES.contains(&scalar.variability)
            {
                return None;
            }
            kind(scalar)
                .or_else(|| start(scalar))
                .or_else(|| declared(scalar, &types))
                .or_else(|| derivative(scalar, scalars))
        })
        .collect();
    findings.extend(aliases(scalars));
    if let Some(second) = known().filter(|s| s.causality == "independent").nth(1) {
        findings.push(second.finding("a second independent variable: there can be one, the time"));
    }
    findings
}

/// The combination of causality, variability and initial (section 2.2.7, the table of allowed combinations).
fn kind(scalar: &Scalar<'_>) -> Option<String> {
    let &Scalar {
        node,
        causality,
        variability,
        initial,
        ..
    } = scalar;
    let (variabilities, article): (&[_], _) = match causality {
        "parameter" => (&["fixed", "tunable"], "a"),
        "calculatedParameter" => (&["fixed", "tunable"], "a"),
        "input" => (&["discrete", "continuous"], "an"),
        "output" => (&["constant", "discrete", "continuous"], "an"),
        "independent" => (&["continuous"], "an"),
        _ => (&VARIABILITIES, "a"),
    };
    if !variabilities.contains(&variability) {
        return Some(scalar.finding(&format!(
            "{article} {causality} cannot be {variability}: set variability to {}",
            variabilities.join(" or ")
        )));
    }
    if variability == "continuous" && scalar.kind() != "Real" {
        return Some(scalar.finding(&format!(
            "only a Real can be continuous: set variability to discrete, or fixed for a parameter, for this {}",
            scalar.kind()
        )));
    }
    let initials: &[_] = match (causality, variability) {
        ("input" | "independent", _) => &[],
        ("parameter", _) | (_, "constant") => &["exact"],
        ("calculatedParameter", _) | ("local", "fixed" | "tunable") => &["calculated", "approx"],
        _ => &["exact", "approx", "calculated"],
    };
    if node.has_attribute("initial") && !initials.contains(&initial) {
        let remedy = match initials {
            [] => "remove it".to_owned(),
            some => format!("set it to {}", some.join(" or ")),
        };
        return Some(scalar.finding(&format!(
            "initial=\"{initial}\" is not allowed for causality {causality} and variability {variability}: {remedy}"
        )));
    }
    None
}

/// Start values that must be there, or must not.
fn start(scalar: &Scalar<'_>) -> Option<String> {
    let reason = match (scalar.causality, scalar.initial) {
        ("input", _) => "every input".to_owned(),
        ("parameter", _) => "every parameter".to_owned(),
        (_, "exact") if scalar.variability == "constant" => "every constant".to_owned(),
        (_, initial @ ("exact" | "approx")) => format!("initial=\"{initial}\""),
        _ => String::new(),
    };
    match (scalar.start(), reason.as_str()) {
        (None, reason) if !reason.is_empty() => {
            Some(scalar.finding(&format!("no start value, which {reason} needs: add start")))
        }
        (Some(_), "") => {
            let what = match scalar.causality {
                "independent" => "the independent variable",
                _ => "a variable with initial=\"calculated\", which is the default here,",
            };
            Some(scalar.finding(&format!(
                "{what} cannot have a start value: remove start, or set initial to exact or approx"
            )))
        }
        _ => None,
    }
}

fn declared(scalar: &Scalar<'_>, types: &HashMap<&str, &str>) -> Option<String> {
    let name = scalar.typed.attribute("declaredType")?;
    let own = scalar.kind();
    match types.get(name) {
        None => Some(scalar.finding(&format!(
            "declaredType \"{name}\" is not defined: add it to TypeDefinitions or remove it{}",
            crate::names::did_you_mean(crate::names::nearest(name, types.keys().copied()))
        ))),
        Some(kind) if *kind != own => Some(scalar.finding(&format!(
            "declaredType \"{name}\" is a type of {kind}, but the variable is {own}: use a type of {own}"
        ))),
        Some(_) => None,
    }
}

/// `derivative` is the index of the continuous Real of which this is the derivative.
fn derivative(scalar: &Scalar<'_>, scalars: &[Option<Scalar<'_>>]) -> Option<String> {
    let text = scalar.typed.attribute("derivative")?;
    let index = text.trim().parse::<usize>().ok();
    let state = index.and_then(|index| scalars.get(index.checked_sub(1)?)?.as_ref());
    let wrong = match state {
        None => format!("is none of the {} variables, counted from 1", scalars.len()),
        Some(state) if state.node == scalar.node => "is the variable itself".to_owned(),
        Some(state) if state.kind() != "Real" || state.variability != "continuous" => {
            format!("is {}, no continuous Real", state.name)
        }
        Some(_) => return None,
    };
    Some(scalar.finding(&format!(
        "derivative=\"{text}\" {wrong}: give the index of the state"
    )))
}

/// Variables of one base type with the same value reference are one variable of several names (alias
/// variables): only one of them can be set, and have a start value; they agree in unit and constancy.
fn aliases(scalars: &[Option<Scalar<'_>>]) -> Vec<String> {
    let mut first: HashMap<(&str, &str), &Scalar<'_>> = HashMap::new();
    let mut findings = Vec::new();
    for scalar in scalars.iter().flatten() {
        let Some(reference) = scalar.node.attribute("valueReference") else {
            continue;
        };
        let Some(other) = first.get(&(scalar.kind(), reference)) else {
            first.insert((scalar.kind(), reference), scalar);
            continue;
        };
        if let Some(wrong) = clash(other, scalar) {
            findings.push(scalar.finding(&format!(
                "valueReference {reference} is {}'s, too, {wrong}: give one of them a valueReference of its own",
                other.name
            )));
        }
        // The one that can be set stands for all.
        if settable(scalar) {
            first.insert((scalar.kind(), reference), scalar);
        }
    }
    findings
}

fn settable(scalar: &Scalar<'_>) -> bool {
    matches!(scalar.causality, "parameter" | "input")
}

fn clash(one: &Scalar<'_>, other: &Scalar<'_>) -> Option<&'static str> {
    let constant = |scalar: &Scalar<'_>| scalar.variability == "constant";
    let unit = |scalar: &Scalar<'_>| scalar.typed.attribute("unit").map(str::to_owned);
    if one.name == other.name {
        // The reader remarks on the second of a name.
        return None;
    }
    if settable(one) && settable(other) {
        Some("and both can be set")
    } else if constant(one) != constant(other) {
        Some("but only one of them is constant")
    } else if constant(one) {
        (one.start() != other.start()).then_some("but their values differ")
    } else if one.start().is_some() && other.start().is_some() {
        Some("and both have a start value")
    } else if unit(one) != unit(other) && unit(one).is_some() && unit(other).is_some() {
        Some("but their units differ")
    } else {
        None
    }
}
