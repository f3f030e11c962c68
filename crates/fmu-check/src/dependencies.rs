//! Dependencies of the unknowns in `ModelStructure` (FMI 2.0.5, section 2.2.8).

use std::collections::HashSet;

use roxmltree::Node;

use crate::{
    document::{Document, Scalar, at},
    hit::Hit,
    structure::{listed, scalar_of, states},
};

const LISTS: [&str; 3] = ["Outputs", "Derivatives", "InitialUnknowns"];

/// The kinds that every list knows, and those of `Outputs` and `Derivatives` only.
const KINDS: [&str; 2] = ["dependent", "constant"];
const LATER_KINDS: [&str; 3] = ["fixed", "tunable", "discrete"];

/// Dependencies are on variables, with a kind each where kinds are given.
pub fn dependencies(document: &Document) -> Vec<Hit> {
    every(document, |name, unknown| {
        let strange =
            dependencies_on(unknown).find(|(_, place)| place.is_none_or(|place| place >= document.scalars.len()));
        if let Some((index, _)) = strange {
            return Some(format!(
                "a dependency on index {index}, which is none of the {} variables: indexes count them from 1",
                document.scalars.len()
            ));
        }
        kinds(name, unknown)
    })
}

/// Faults of the kinds.
fn kinds(list: &str, unknown: Node) -> Option<String> {
    let kinds: Vec<&str> = unknown.attribute("dependenciesKind")?.split_whitespace().collect();
    let later: &[&str] = match list {
        "InitialUnknowns" => &[],
        _ => &LATER_KINDS,
    };
    if let Some(kind) = kinds.iter().find(|kind| !KINDS.contains(kind) && !later.contains(kind)) {
        let known = [&KINDS[..], later].concat();
        return Some(format!("dependenciesKind {kind} is none of {}", known.join(", ")));
    }
    let count = dependencies_on(unknown).count();
    (count != kinds.len())
        .then(|| format!("{count} dependencies, but {} dependenciesKind: give one for each", kinds.len()))
}

/// Dependencies are sorted by index, each there once.
pub fn unsorted(document: &Document) -> Vec<Hit> {
    every(document, |_, unknown| {
        let places: Vec<usize> = dependencies_on(unknown).filter_map(|(_, place)| place).collect();
        let pair = places.windows(2).find(|pair| pair[0] >= pair[1])?;
        Some(format!("dependencies: index {} after {}: sort them by index, each once", pair[1] + 1, pair[0] + 1))
    })
}

/// Of `dependenciesKind`, all but `dependent` is for Reals.
pub fn factors(document: &Document) -> Vec<Hit> {
    let wrong = every(document, |_, unknown| {
        let scalar = scalar_of(document, unknown.attribute("index")?)?;
        let factor = unknown.attribute("dependenciesKind")?.split_whitespace().find(|kind| *kind != "dependent")?;
        let (name, kind) = (scalar.name, scalar.kind());
        (kind != "Real")
            .then(|| format!("dependenciesKind {factor} for {name}, which is no Real but {kind}: write dependent"))
    });
    first_of(wrong)
}

/// Dependencies are on variables that are known: not on what is computed itself.
pub fn unknown(document: &Document) -> Vec<Hit> {
    let states = states(document);
    let wrong = every(document, |name, unknown| {
        let computed = dependencies_on(unknown).find_map(|(_, place)| {
            let scalar = document.scalars.get(place?)?.as_ref()?;
            (!is_known(scalar, name, &states)).then_some(scalar)
        })?;
        Some(format!(
            "a dependency on {}, which is neither {}: remove it",
            computed.name,
            match name {
                "InitialUnknowns" => "an input nor has initial=\"exact\"",
                _ => "an input nor a state",
            }
        ))
    });
    first_of(wrong)
}

/// Whether unknowns of a list may depend on a variable.
fn is_known(scalar: &Scalar, list: &str, states: &HashSet<usize>) -> bool {
    let always = matches!(scalar.causality, "input" | "independent");
    let tunable = scalar.causality == "parameter" && scalar.variability == "tunable";
    match list {
        "InitialUnknowns" => always || scalar.initial == "exact",
        _ => always || tunable || states.contains(&scalar.position),
    }
}

/// Faults of each unknown.
fn every(document: &Document, wrong: impl Fn(&'static str, Node) -> Option<String>) -> Vec<Hit> {
    let mut hits = Vec::new();
    for name in LISTS {
        hits.extend(
            listed(document, name).filter_map(|node| Some(at(node, format!("{name}: {}", wrong(name, node)?)))),
        );
    }
    hits
}

/// The first of many that are all alike.
fn first_of(mut hits: Vec<Hit>) -> Vec<Hit> {
    let more = hits.len().saturating_sub(1);
    hits.truncate(1);
    if let Some(first) = hits.first_mut().filter(|_| more > 0) {
        first.text += &format!(" (so it is with {more} more)");
    }
    hits
}

/// The indexes on which an unknown depends, with their places among the variables, from 0.
fn dependencies_on<'a>(unknown: Node<'a, 'a>) -> impl Iterator<Item = (&'a str, Option<usize>)> {
    unknown
        .attribute("dependencies")
        .unwrap_or_default()
        .split_whitespace()
        .map(|index| (index, index.parse::<usize>().ok().and_then(|index| index.checked_sub(1))))
}
