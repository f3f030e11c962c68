//! Rules about the variables' causality, variability, start values and each other (FMI 2.0.5, section 2.2.7).

use fmu_import::Version;

use crate::{
    combinations,
    document::{Document, Scalar, Variable, tag},
    hit::Hit,
};
use fmu_points::names::{did_you_mean, nearest};

/// Whether the words are known. The reader remarks on others, and nothing follows from them.
pub fn is_clear(scalar: Variable) -> bool {
    combinations::are_known(scalar.document.read.standard, scalar.causality, scalar.variability)
}

/// There can be one independent variable.
pub fn independents(document: &Document) -> Vec<Hit> {
    let mut all = document.known().filter(|s| s.causality == "independent");
    let text = "a second independent variable: there can be one, the time";
    Vec::from_iter(all.nth(1).map(|scalar| scalar.finding(text)))
}

/// The combination of causality and variability (section 2.2.7, the table of allowed combinations).
pub fn kind(scalar: Variable) -> Option<String> {
    let (causality, variability) = (scalar.causality, scalar.variability);
    let article = match causality {
        "input" | "output" | "independent" => "an",
        _ => "a",
    };
    let allowed = combinations::variabilities(causality);
    (is_clear(scalar) && !allowed.contains(&variability))
        .then(|| format!("{article} {causality} cannot be {variability}: set variability to {}", allowed.join(" or ")))
}

/// Only a Real is continuous, and the time is a Real.
pub fn continuous(scalar: Variable) -> Option<String> {
    let kind = scalar.kind();
    if kind == "Real" {
        return None;
    }
    if scalar.causality == "independent" {
        return Some(format!("the independent variable is a Real, not {kind}: change its type"));
    }
    (scalar.variability == "continuous").then(|| {
        format!("only a Real can be continuous: set variability to discrete, or fixed for a parameter, for this {kind}")
    })
}

/// The default is continuous, which only a Real can be; tools mean discrete.
pub fn variability_missing(scalar: Variable) -> Option<String> {
    let kind = scalar.kind();
    let missing = kind != "Real" && !scalar.node.has_attribute("variability");
    missing.then(|| {
        format!("no variability, and the default, continuous, is for a Real only: set it to discrete for this {kind}")
    })
}

/// Allowed values of `initial` (section 2.2.7, the table of allowed combinations; FMI 3.0.2, section 2.4.7).
pub fn initial(scalar: Variable) -> Option<String> {
    let Scalar { node, causality, variability, initial, .. } = *scalar;
    let version = scalar.document.read.standard;
    let initials = combinations::initials(version, causality, variability);
    // Unknown words are findings of the schema; in FMI 3.0 nothing follows from them.
    let is_word = ["exact", "approx", "calculated"].contains(&initial);
    let is_right = initials.contains(&initial) || initials.len() == 3;
    let is_right = is_right || version == Version::Three && !is_word;
    if !node.has_attribute("initial") || !is_clear(scalar) || is_right {
        return None;
    }
    Some(format!(
        "initial=\"{initial}\" is not allowed for causality {causality} and variability {variability}: {}",
        combinations::remedy(initials)
    ))
}

/// Start values that must be there.
pub fn startless(scalar: Variable) -> Option<String> {
    let reason = needs_start(scalar)?;
    (scalar.start().is_none() && is_clear(scalar)).then(|| format!("no start value, which {reason} needs: add start"))
}

/// Start values that must not be there.
pub fn started(scalar: Variable) -> Option<String> {
    if scalar.start().is_none() || needs_start(scalar).is_some() || !is_clear(scalar) {
        return None;
    }
    Some(
        match scalar.causality {
            "independent" => "the independent variable cannot have a start value: remove start",
            _ => {
                "a variable with initial=\"calculated\", which is the default here, cannot have a start value: remove \
                 start, or set initial to exact or approx"
            }
        }
        .to_owned(),
    )
}

/// Why a variable needs a start value.
fn needs_start(scalar: Variable) -> Option<String> {
    Some(match (scalar.causality, scalar.initial) {
        ("input", _) => "every input".to_owned(),
        ("parameter", _) => "every parameter".to_owned(),
        (_, "exact") if scalar.variability == "constant" => "every constant".to_owned(),
        (_, initial @ ("exact" | "approx")) => format!("initial=\"{initial}\""),
        _ => return None,
    })
}

/// Types that are declared nowhere.
pub fn undeclared(scalar: Variable) -> Option<String> {
    let name = scalar.typed.attribute("declaredType")?;
    let known = || scalar.document.types.keys().copied();
    (!scalar.document.types.contains_key(name)).then(|| {
        format!(
            "declaredType \"{name}\" is not defined: add it to TypeDefinitions or remove it{}",
            did_you_mean(nearest(name, known()))
        )
    })
}

/// Types of another kind.
pub fn mistyped(scalar: Variable) -> Option<String> {
    let wanted = scalar.kind();
    let kind = tag(scalar.declared()?);
    let name = scalar.typed.attribute("declaredType")?;
    (kind != wanted).then(|| {
        format!("declaredType \"{name}\" is a type of {kind}, but the variable is {wanted}: use a type of {wanted}")
    })
}

/// `derivative` is the index of the continuous Real of which this is the derivative.
pub fn derivative(scalar: Variable) -> Option<String> {
    let scalars = &scalar.document.scalars;
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
    Some(format!("derivative=\"{text}\" {wrong}: give the index of the state"))
}
