//! `ModelStructure` (FMI 2.0.4, section 2.2.8): its lists name variables by their index, counted from 1.

use std::collections::HashSet;

use roxmltree::Node;

use super::document::{Scalar, at, named};

type Scalars<'a> = [Option<Scalar<'a>>];

/// All that is wrong with the lists.
pub(super) fn broken(root: Node<'_, '_>, scalars: &Scalars<'_>) -> Vec<String> {
    let Some(structure) = named(root, "ModelStructure").next() else {
        return Vec::new();
    };
    let output = |scalar: &Scalar<'_>| scalar.causality == "output";
    let mut findings = list(structure, "Outputs", scalars, &|scalar| {
        (!output(scalar)).then_some("is no output")
    });
    if findings.is_empty() {
        findings = missing(structure, "Outputs", scalars, &output);
    }
    findings.extend(list(structure, "Derivatives", scalars, &|scalar| {
        let derivative = scalar.typed.has_attribute("derivative");
        (!derivative).then_some("has no attribute derivative")
    }));
    let mut initial = list(
        structure,
        "InitialUnknowns",
        scalars,
        &|scalar| match scalar.causality {
            "parameter" => Some("is a parameter, so known initially"),
            "input" => Some("is an input, so known initially"),
            _ => None,
        },
    );
    if initial.is_empty() {
        initial.extend(unsorted(structure, "InitialUnknowns"));
        findings.extend(missing(structure, "InitialUnknowns", scalars, &|scalar| {
            scalar.causality == "calculatedParameter"
                || output(scalar) && ["calculated", "approx"].contains(&scalar.initial)
        }));
    }
    findings.extend(initial);
    findings
}

fn unknowns<'a>(structure: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    named(structure, name).flat_map(|list| named(list, "Unknown"))
}

/// The first unknown of a list that comes after one of a greater index.
fn unsorted(structure: Node<'_, '_>, name: &'static str) -> Option<String> {
    let index = |unknown: &Node<'_, '_>| unknown.attribute("index")?.trim().parse::<usize>().ok();
    let mut greatest = 0;
    unknowns(structure, name).find_map(|unknown| {
        let index = index(&unknown)?;
        if index < greatest {
            let text = format!("{name}: index {index} after {greatest}: sort the list by index");
            return Some(at(unknown, &text));
        }
        greatest = index;
        None
    })
}

/// The position of the variable of an index.
fn position(index: &str, scalars: &Scalars<'_>) -> Option<usize> {
    let position = index.trim().parse::<usize>().ok()?.checked_sub(1)?;
    (position < scalars.len()).then_some(position)
}

/// The unknowns of one list that cannot be: `unfit` says why a variable cannot be in it.
fn list(
    structure: Node<'_, '_>,
    name: &'static str,
    scalars: &Scalars<'_>,
    unfit: &dyn Fn(&Scalar<'_>) -> Option<&'static str>,
) -> Vec<String> {
    let mut seen = HashSet::new();
    let mut findings = Vec::new();
    for unknown in unknowns(structure, name) {
        let Some(index) = unknown.attribute("index") else {
            continue;
        };
        let wrong = match position(index, scalars) {
            None => Some(format!(
                "is none of the {} variables: indexes count them from 1",
                scalars.len()
            )),
            Some(position) if !seen.insert(position) => {
                Some("is listed twice: remove one of them".to_owned())
            }
            Some(position) => scalars[position].as_ref().and_then(|scalar| {
                let why = unfit(scalar)?;
                Some(format!(
                    "is {}, which {why}: correct the index or remove it",
                    scalar.name
                ))
            }),
        };
        let found = wrong.map(|wrong| format!("index {index} {wrong}"));
        if let Some(found) = found.or_else(|| dependencies(unknown, scalars)) {
            findings.push(at(unknown, &format!("{name}: {found}")));
        }
    }
    findings
}

fn dependencies(unknown: Node<'_, '_>, scalars: &Scalars<'_>) -> Option<String> {
    const KINDS: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];
    let words = |name| {
        unknown
            .attribute(name)
            .map(|text| text.split_whitespace().collect::<Vec<_>>())
    };
    let (on, kinds) = (words("dependencies"), words("dependenciesKind"));
    let strange = on
        .iter()
        .flatten()
        .find(|index| position(index, scalars).is_none());
    if let Some(index) = strange {
        return Some(format!(
            "a dependency on index {index}, which is none of the {} variables: indexes count them from 1",
            scalars.len()
        ));
    }
    let kinds = kinds?;
    if let Some(kind) = kinds.iter().find(|kind| !KINDS.contains(*kind)) {
        return Some(format!(
            "dependenciesKind {kind} is none of {}",
            KINDS.join(", ")
        ));
    }
    let count = on.map_or(0, |on| on.len());
    (count != kinds.len()).then(|| {
        format!(
            "{count} dependencies, but {} dependenciesKind: give one for each",
            kinds.len()
        )
    })
}

/// The variables that a list must have but has not, in one finding.
fn missing(
    structure: Node<'_, '_>,
    name: &'static str,
    scalars: &Scalars<'_>,
    wanted: &dyn Fn(&Scalar<'_>) -> bool,
) -> Vec<String> {
    let listed: HashSet<usize> = unknowns(structure, name)
        .filter_map(|unknown| position(unknown.attribute("index")?, scalars))
        .collect();
    let absent: Vec<String> = (1..)
        .zip(scalars)
        .filter_map(|(index, scalar)| Some((index, scalar.as_ref()?)))
        .filter(|(index, scalar)| wanted(scalar) && !listed.contains(&(index - 1)))
        .map(|(index, scalar)| format!("{} (index {index})", scalar.name))
        .collect();
    if absent.is_empty() {
        return Vec::new();
    }
    let text = format!(
        "ModelStructure does not list {} in {name}: add {} there",
        short(&absent),
        if absent.len() == 1 { "it" } else { "them" }
    );
    vec![at(structure, &text)]
}

/// The first few of many.
pub(super) fn short(names: &[String]) -> String {
    const FEW: usize = 5;
    let mut text = names[..names.len().min(FEW)].join(", ");
    if names.len() > FEW {
        text += &format!(" and {} more", names.len() - FEW);
    }
    text
}
