//! Rules about the definitions that come before the variables: names that come twice, factors of nothing, the date, and what
//! is for Model Exchange only (FMI 2.0.5, sections 2.2.1 to 2.2.4, 2.2.6 and 2.2.7).

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::document::{Document, Scalar, at, elements, named};
use super::hit::Hit;

pub(super) fn units(document: &Document<'_>) -> Vec<Hit> {
    twice(document.all("UnitDefinitions", "Unit"), "name")
}

pub(super) fn display_units(document: &Document<'_>) -> Vec<Hit> {
    let units = document.all("UnitDefinitions", "Unit");
    units
        .flat_map(|unit| twice(named(unit, "DisplayUnit"), "name"))
        .collect()
}

pub(super) fn factors(document: &Document<'_>) -> Vec<Hit> {
    let units = document.all("UnitDefinitions", "Unit");
    units.flat_map(elements).filter_map(factor).collect()
}

pub(super) fn types(document: &Document<'_>) -> Vec<Hit> {
    twice(document.all("TypeDefinitions", "SimpleType"), "name")
}

pub(super) fn items(document: &Document<'_>) -> Vec<Hit> {
    let types = document
        .all("TypeDefinitions", "SimpleType")
        .flat_map(elements);
    let clash = |node| {
        let names = twice(named(node, "Item"), "name");
        if names.is_empty() {
            return twice(named(node, "Item"), "value");
        }
        names
    };
    types.flat_map(clash).collect()
}

/// Units and ranges of types that cannot be.
pub(super) fn type_attributes(document: &Document<'_>) -> Vec<Hit> {
    let types = document
        .all("TypeDefinitions", "SimpleType")
        .flat_map(elements);
    let wrong = |node: Node<'_, '_>| {
        let number = |name| node.attribute(name)?.trim().parse::<f64>().ok();
        if let Some((min, max)) = number("min").zip(number("max"))
            && min > max
        {
            return Some(format!(
                "min {min} is greater than max {max}: exchange or correct them"
            ));
        }
        let shown = node.attribute("displayUnit");
        match node.attribute("unit") {
            None => {
                shown.map(|shown| format!("displayUnit \"{shown}\" without a unit: add the unit"))
            }
            Some(unit) => {
                let defined = document.read.units.get(unit).is_some();
                (!defined)
                    .then(|| format!("unit \"{unit}\" is not defined: add it to UnitDefinitions"))
            }
        }
    };
    // Where a variable uses the type, the finding is the variable's.
    let used: HashSet<&str> = document
        .known()
        .filter_map(|s| s.typed.attribute("declaredType"))
        .collect();
    types
        .filter(|node| {
            let name = node.parent().and_then(|parent| parent.attribute("name"));
            name.is_none_or(|name| !used.contains(name))
        })
        .filter_map(|node| wrong(node).map(|text| at(node, &text)))
        .collect()
}

pub(super) fn categories(document: &Document<'_>) -> Vec<Hit> {
    twice(document.all("LogCategories", "Category"), "name")
}

pub(super) fn tools(document: &Document<'_>) -> Vec<Hit> {
    let root = twice(document.all("VendorAnnotations", "Tool"), "name");
    let of_variables = document.known().flat_map(|scalar| {
        named(scalar.node, "Annotations").flat_map(|list| twice(named(list, "Tool"), "name"))
    });
    root.into_iter().chain(of_variables).collect()
}

pub(super) fn source_files(document: &Document<'_>) -> Vec<Hit> {
    let lists = document.all("CoSimulation", "SourceFiles");
    lists
        .flat_map(|list| twice(named(list, "File"), "name"))
        .collect()
}

/// States can only be turned into bytes where there are states.
pub(super) fn serialized_states(document: &Document<'_>) -> Vec<Hit> {
    let parts = named(document.root, "CoSimulation");
    let on = |node: Node<'_, '_>, name| matches!(node.attribute(name), Some("true" | "1"));
    let wrong = parts
        .filter(|node| on(*node, "canSerializeFMUstate") && !on(*node, "canGetAndSetFMUstate"));
    wrong
        .map(|node| {
            at(
                node,
                "canSerializeFMUstate without canGetAndSetFMUstate: set both or none",
            )
        })
        .collect()
}

/// The first of these elements with an attribute that an earlier one has, too.
pub(super) fn twice<'a>(
    nodes: impl Iterator<Item = Node<'a, 'a>>,
    attribute: &'static str,
) -> Vec<Hit> {
    let mut seen = HashSet::new();
    let mut known = nodes.filter_map(|node| Some((node, node.attribute(attribute)?)));
    let second = known.find(|(_, value)| !seen.insert(*value));
    let hit = |(node, value): (Node<'a, 'a>, &str)| {
        let element = node.tag_name().name();
        let text =
            format!("a second `{element}` with {attribute}=\"{value}\": rename or remove it");
        at(node, &text)
    };
    second.map(hit).into_iter().collect()
}

/// Units are converted by a factor.
fn factor(node: Node<'_, '_>) -> Option<Hit> {
    let text = node.attribute("factor")?;
    let nothing = text.trim().parse::<f64>() == Ok(0.0);
    let element = node.tag_name().name();
    nothing.then(|| {
        at(
            node,
            &format!("{element}: factor is 0: nothing can be converted with it"),
        )
    })
}

pub(super) fn types_and_variables(document: &Document<'_>) -> Vec<Hit> {
    let names: HashSet<&str> = document.known().map(|scalar| scalar.name).collect();
    let mut types = document.all("TypeDefinitions", "SimpleType");
    let same = types.find_map(|node| Some((node, names.get(node.attribute("name")?)?)));
    let hit = |(node, name)| {
        let text =
            format!("SimpleType: \"{name}\" is the name of a variable, too: rename the type");
        at(node, &text)
    };
    same.map(hit).into_iter().collect()
}

/// The date of the generation is an `xs:dateTime`.
pub(super) fn date(document: &Document<'_>) -> Vec<Hit> {
    let text = document.root.attribute("generationDateAndTime");
    let wrong = text.filter(|text| !is_date(text.trim()));
    let hit = |text| {
        let wanted = "write it as 2009-12-08T14:33:22Z, or remove it";
        at(
            document.root,
            &format!("generationDateAndTime is \"{text}\": {wanted}"),
        )
    };
    wrong.map(hit).into_iter().collect()
}

fn is_date(text: &str) -> bool {
    let like = |text: &str, pattern: &str| {
        text.len() == pattern.len()
            && text
                .bytes()
                .zip(pattern.bytes())
                .all(|(is, wanted)| match wanted {
                    b'0' => is.is_ascii_digit(),
                    b'+' => matches!(is, b'+' | b'-'),
                    other => is == other,
                })
    };
    const SECONDS: &str = "0000-00-00T00:00:00";
    /// Where month, day, hour, minute and second are, and from where to where they go.
    const FIELDS: [(usize, u8, u8); 5] = [
        (5, 1, 12),
        (8, 1, 31),
        (11, 0, 24),
        (14, 0, 59),
        (17, 0, 59),
    ];
    let (Some(seconds), Some(rest)) = (text.get(..SECONDS.len()), text.get(SECONDS.len()..)) else {
        return false;
    };
    let zone = match rest.strip_prefix('.') {
        Some(fraction) => fraction.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => rest,
    };
    like(seconds, SECONDS)
        && (["", "Z"].contains(&zone) || like(zone, "+00:00"))
        && FIELDS.iter().all(|(place, least, most)| {
            let field = seconds
                .get(*place..place + 2)
                .and_then(|text| text.parse().ok());
            field.is_some_and(|field: u8| (*least..=*most).contains(&field))
        })
}

/// Attributes that only FMUs for Model Exchange may have.
pub(super) fn exchange_only(document: &Document<'_>) -> Vec<Hit> {
    if named(document.root, "ModelExchange").next().is_some() {
        return Vec::new();
    }
    let mut counts: HashMap<&str, (&Scalar<'_>, usize)> = HashMap::new();
    for scalar in document.known() {
        for (node, name) in [
            (scalar.node, "canHandleMultipleSetPerTimeInstant"),
            (scalar.typed, "reinit"),
        ] {
            if node.has_attribute(name) {
                counts.entry(name).or_insert((scalar, 0)).1 += 1;
            }
        }
    }
    let findings = counts.into_iter().map(|(name, (scalar, count))| {
        let more = match count {
            1 => String::new(),
            count => format!(" (so has each of {} more)", count - 1),
        };
        scalar.finding(&format!(
            "it has the attribute {name}{more}, which only an FMU for Model Exchange may have: remove it"
        ))
    });
    let mut findings: Vec<Hit> = findings.collect();
    findings.sort_by_key(|hit| hit.position);
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates() {
        for text in [
            "2009-12-08T14:33:22Z",
            "2009-12-08T14:33:22",
            "2009-12-08T14:33:22.123Z",
            "2009-12-08T14:33:22+01:00",
        ] {
            assert!(is_date(text), "{text}");
        }
        for text in [
            "",
            "yesterday",
            "2009-12-08",
            "2009-12-08 14:33:22",
            "2009-12-08T14:33:22X",
            "08.12.2009 14:33:22",
            "2009-13-08T14:33:22Z",
            "2009-12-08T14:63:22Z",
        ] {
            assert!(!is_date(text), "{text}");
        }
    }
}
