//! Rules about model descriptions of FMI 3.0 (sections 2.4 to 2.4.8).

mod variables;

use std::collections::{HashMap, HashSet};
pub(crate) use variables::{
    clocks, derivatives, initial_unknowns, not_finite, structure as lists, timing, variabilities,
};

use roxmltree::Node;

use crate::{
    document::{Document, Scalar, Variable, at, elements, named, tag},
    hit::Hit,
};

/// The value reference that an element states.
fn reference(node: Node) -> Option<u32> {
    node.attribute("valueReference")?.trim().parse().ok()
}

/// A model description without its token.
pub fn token(document: &Document) -> Vec<Hit> {
    if !document.read.guid.is_empty() {
        return Vec::new();
    }
    let text = "instantiationToken is missing or empty: write that of the binary";
    vec![at(document.root, text)]
}

/// Another version than the one whose rules these are.
pub fn version(document: &Document) -> Vec<Hit> {
    let version = &document.read.fmi_version;
    let rest = version.strip_prefix("3.0");
    let is_known = rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '-']));
    let text = format!("fmiVersion is {version}: it was read as 3.0");
    Vec::from_iter((!is_known).then(|| at(document.root, text)))
}

/// Internal steps that are no steps.
pub fn internal_step(document: &Document) -> Vec<Hit> {
    document
        .root
        .descendants()
        .filter_map(|node| Some((node, node.attribute("fixedInternalStepSize")?)))
        .filter(|(_, step)| step.trim().parse::<f64>().is_ok_and(|step| step <= 0.0))
        .map(|(node, step)| at(node, format!("fixedInternalStepSize is {step}; it must be greater than 0")))
        .collect()
}

/// Elements whose name is empty.
pub fn empty_names(document: &Document) -> Vec<Hit> {
    document
        .root
        .descendants()
        .filter(|node| node.attribute("name").is_some_and(str::is_empty))
        .map(|node| {
            let element = tag(node);
            at(node, format!("{element}: an empty name: give it one"))
        })
        .collect()
}

/// Why this program cannot set or judge a variable.
pub fn unusable(scalar: Variable) -> Option<String> {
    // Unknown types and sizes, and clocks without event mode, are errors of other rules.
    let why = scalar.document.read.unusable.get(scalar.name);
    let why = why.filter(|why| why.contains("more than"))?;
    Some(format!("it cannot be set or judged here: {why}"))
}

/// Variables that share a value reference.
pub fn references(document: &Document) -> Vec<Hit> {
    let mut known: HashMap<u32, &str> = HashMap::new();
    document
        .known()
        .filter_map(|scalar| {
            let reference = reference(scalar.node)?;
            let other = known.insert(reference, scalar.name)?;
            Some(
                scalar
                    .finding(format!("valueReference {reference} is {other}'s, too: give each its own, or use Alias")),
            )
        })
        .collect()
}

/// The time: none, several, or one that is no time.
pub fn independent(document: &Document) -> Vec<Hit> {
    let times: Vec<_> = document.known().filter(|s| s.causality == "independent").collect();
    let [one] = times[..] else {
        let text = format!("{} independent variables: FMI 3.0 wants one, usually `time`", times.len());
        return vec![at(document.root, text)];
    };
    let is_right = one.is_float() && one.start().is_none();
    let text = "the time is a float without a start value";
    Vec::from_iter((!is_right).then(|| one.finding(text)))
}

/// Start values that are missing, or have no place.
pub fn starts(scalar: Variable) -> Option<String> {
    let Scalar { node, causality, initial, .. } = *scalar;
    // The time has a rule of its own.
    if scalar.kind() == "Clock" || causality == "independent" {
        return None;
    }
    let given = scalar.start().is_some() || named(node, "Start").next().is_some();
    let needed = matches!(causality, "parameter" | "structuralParameter" | "input")
        || scalar.variability == "constant"
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

/// Ranges that hold no value, or not the start value.
pub fn ranges(document: &Document) -> Vec<Hit> {
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
            ..Hit::of(crate::document::NAME, format!("{}: {text}: correct one of them", variable.name))
        })
    });
    wrong.collect()
}

/// Types and units that are not defined.
pub fn declared(document: &Document) -> Vec<Hit> {
    document.of_each(|scalar| {
        let declared = scalar.typed.attribute("declaredType");
        if let Some(declared) = declared.filter(|name| !document.types.contains_key(name)) {
            return Some(format!("declaredType \"{declared}\" is not defined: define it"));
        }
        if declared.is_none() && scalar.kind() == "Enumeration" {
            return Some("an Enumeration needs a declaredType".to_owned());
        }
        document.undefined_unit(document.read.variables.get(scalar.name)?.unit()?)
    })
}

/// Dimensions that are no sizes.
pub fn dimensions(document: &Document) -> Vec<Hit> {
    let sizes: HashSet<u32> = document
        .known()
        .filter(|scalar| {
            scalar.kind() == "UInt64" && (scalar.causality == "structuralParameter" || scalar.variability == "constant")
        })
        .filter_map(|size| reference(size.node))
        .collect();
    document.of_each(|scalar| {
        named(scalar.node, "Dimension").find_map(|dimension| {
            let start = dimension.attribute("start");
            match (start, dimension.attribute("valueReference")) {
                (Some(start), None) => {
                    start.trim().parse::<u64>().is_err().then(|| format!("the dimension \"{start}\" is no size"))
                }
                (None, Some(_)) => {
                    let known = reference(dimension).is_some_and(|of| sizes.contains(&of));
                    (!known)
                        .then(|| "a dimension refers to no structural parameter or constant of type UInt64".to_owned())
                }
                _ => Some("a dimension has either a start or a valueReference".to_owned()),
            }
        })
    })
}

/// The value references of all variables.
fn known(document: &Document) -> HashSet<u32> {
    document.known().filter_map(|scalar| reference(scalar.node)).collect()
}

/// Outputs that `ModelStructure` does not list, and entries that are no outputs.
pub fn outputs(document: &Document) -> Vec<Hit> {
    let list: HashSet<u32> = document.all("ModelStructure", "Output").filter_map(reference).collect();
    let is_output = |scalar: &Scalar| scalar.causality == "output";
    let outputs: HashSet<u32> =
        document.known().filter(|scalar| is_output(scalar)).filter_map(|one| reference(one.node)).collect();
    let missing = document.of_each(|scalar| {
        let listed = reference(scalar.node).is_some_and(|of| list.contains(&of));
        let missing = is_output(&scalar) && !listed;
        missing.then(|| "ModelStructure has no Output for it: add it".to_owned())
    });
    let known = known(document);
    let surplus = document.all("ModelStructure", "Output").filter_map(|node| {
        let of = reference(node).filter(|of| known.contains(of) && !outputs.contains(of))?;
        Some(at(node, format!("Output {of} is the reference of no output: remove it")))
    });
    missing.into_iter().chain(surplus).collect()
}

/// Entries of `ModelStructure` that name no variables.
pub fn structure(document: &Document) -> Vec<Hit> {
    let known = known(document);
    named(document.root, "ModelStructure")
        .flat_map(elements)
        .filter_map(|node| {
            let kind = tag(node);
            let Some(of) = reference(node).filter(|of| known.contains(of)) else {
                return Some(at(node, format!("{kind} refers to no variable: correct its valueReference")));
            };
            let wrong = node.attribute("dependencies").unwrap_or_default().split_whitespace().find(|text| {
                let of = text.parse().ok();
                !of.is_some_and(|of: u32| known.contains(&of))
            })?;
            Some(at(node, format!("{kind} {of} depends on {wrong}, which is no variable: correct it")))
        })
        .collect()
}
