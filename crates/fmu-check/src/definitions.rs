//! Rules about the definitions that come before the variables: names that come twice, factors of nothing, the date, and what
//! is for Model Exchange only (FMI 2.0.5, sections 2.2.1 to 2.2.4, 2.2.6 and 2.2.7).

use std::collections::{HashMap, HashSet};

use fmu_import::Version;
use roxmltree::Node;

use crate::{
    document::{Document, Scalar, at, elements, named, tag},
    hit::Hit,
};

/// Of each parent the first element that has an attribute's value of an earlier one: of several attributes, the first by
/// which two are alike. `path` leads from the root to the elements, with `*` for those of any name.
pub fn alike(document: &Document, path: &'static str, attributes: &[&'static str]) -> Vec<Hit> {
    let is = |node: &Node, step: &str| step == "*" || tag(*node) == step;
    let mut steps = path.split('/');
    let last = steps.next_back().unwrap_or_default();
    steps
        .fold(vec![document.root], |nodes, step| {
            nodes.into_iter().flat_map(elements).filter(|node| is(node, step)).collect()
        })
        .into_iter()
        .filter_map(|parent| {
            let nodes = || elements(parent).filter(|node| is(node, last));
            attributes.iter().find_map(|attribute| twice(nodes(), attribute))
        })
        .collect()
}

/// Units are converted by a factor.
pub fn factors(document: &Document) -> Vec<Hit> {
    document
        .all("UnitDefinitions", "Unit")
        .flat_map(elements)
        .filter_map(|node| {
            let nothing = node.attribute("factor")?.trim().parse::<f64>() == Ok(0.0);
            let element = tag(node);
            let text = format!("{element}: factor is 0: nothing can be converted with it");
            nothing.then(|| at(node, text))
        })
        .collect()
}

/// Units and ranges of types that cannot be.
pub fn type_attributes(document: &Document) -> Vec<Hit> {
    let types = document.all("TypeDefinitions", "SimpleType").flat_map(elements);
    let wrong = |node: Node| {
        let number = |name| node.attribute(name)?.trim().parse::<f64>().ok();
        if let Some((min, max)) = number("min").zip(number("max"))
            && min > max
        {
            return Some(format!("min {min} is greater than max {max}: exchange or correct them"));
        }
        match (node.attribute("unit"), node.attribute("displayUnit")) {
            (None, shown) => shown.map(unit_missing),
            (Some(unit), _) => document.undefined_unit(unit),
        }
    };
    // Where a variable uses the type, the finding is the variable's.
    let used: HashSet<&str> = document.known().filter_map(|s| s.typed.attribute("declaredType")).collect();
    types
        .filter(|node| {
            let name = node.parent().and_then(|parent| parent.attribute("name"));
            name.is_none_or(|name| !used.contains(name))
        })
        .filter_map(|node| wrong(node).map(|text| at(node, text)))
        .collect()
}

/// States can only be turned into bytes where there are states.
pub fn serialized_states(document: &Document) -> Vec<Hit> {
    let capabilities = &document.read.capabilities;
    let is_wrong = capabilities.can_serialize_fmu_state && !capabilities.can_get_and_set_fmu_state;
    let state = match document.read.standard {
        Version::Two => "FMUstate",
        Version::Three => "FMUState",
    };
    let text = format!("canSerialize{state} without canGetAndSet{state}: set both or none");
    let part = ["CoSimulation", "ModelExchange"].into_iter().find_map(|part| named(document.root, part).next());
    Vec::from_iter(part.filter(|_| is_wrong).map(|node| at(node, text)))
}

/// The fault of a display unit without a unit.
pub fn unit_missing(shown: &str) -> String {
    format!("displayUnit \"{shown}\" without a unit: add the unit")
}

/// The first of these elements with an attribute that an earlier one has, too.
fn twice<'a>(nodes: impl Iterator<Item = Node<'a, 'a>>, attribute: &str) -> Option<Hit> {
    let mut seen = HashSet::new();
    let mut known = nodes.filter_map(|node| Some((node, node.attribute(attribute)?)));
    let (node, value) = known.find(|(_, value)| !seen.insert(*value))?;
    let element = tag(node);
    Some(at(node, format!("a second `{element}` with {attribute}=\"{value}\": rename or remove it")))
}

pub fn types_and_variables(document: &Document) -> Vec<Hit> {
    let names: HashSet<&str> = document.known().map(|scalar| scalar.name).collect();
    let mut types = document.all("TypeDefinitions", "SimpleType");
    let same = types.find_map(|node| Some((node, names.get(node.attribute("name")?)?)));
    Vec::from_iter(same.map(|(node, name)| {
        at(node, format!("SimpleType: \"{name}\" is the name of a variable, too: rename the type"))
    }))
}

/// The date of the generation is an `xs:dateTime`.
pub fn date(document: &Document) -> Vec<Hit> {
    let text = document.root.attribute("generationDateAndTime");
    let wrong = text.filter(|text| !is_date(text.trim()));
    Vec::from_iter(wrong.map(|text| {
        let wanted = "write it as 2009-12-08T14:33:22Z, or remove it";
        at(document.root, format!("generationDateAndTime is \"{text}\": {wanted}"))
    }))
}

fn is_date(text: &str) -> bool {
    const SECONDS: &str = "0000-00-00T00:00:00";
    /// Where month, day, hour, minute and second are, and from where to where they go.
    const FIELDS: [(usize, u8, u8); 5] = [(5, 1, 12), (8, 1, 31), (11, 0, 24), (14, 0, 59), (17, 0, 59)];
    let Some((seconds, rest)) = text.split_at_checked(SECONDS.len()) else { return false };
    let is_digit = |c: char| c.is_ascii_digit();
    let zone = match rest.strip_prefix('.') {
        Some(fraction) => fraction.trim_start_matches(is_digit),
        None => rest,
    };
    let zone = zone.replace(is_digit, "0");
    seconds.replace(is_digit, "0") == SECONDS
        && ["", "Z", "+00:00", "-00:00"].contains(&&*zone)
        && FIELDS.iter().all(|(place, least, most)| {
            let field = seconds[*place..place + 2].parse();
            field.is_ok_and(|field: u8| (*least..=*most).contains(&field))
        })
}

/// Attributes that only FMUs for Model Exchange may have.
pub fn exchange_only(document: &Document) -> Vec<Hit> {
    if named(document.root, "ModelExchange").next().is_some() {
        return Vec::new();
    }
    let mut counts: HashMap<&str, (&Scalar, usize)> = HashMap::new();
    for scalar in document.known() {
        for (node, name) in [(scalar.node, "canHandleMultipleSetPerTimeInstant"), (scalar.typed, "reinit")] {
            if node.has_attribute(name) {
                counts.entry(name).or_insert((scalar, 0)).1 += 1;
            }
        }
    }
    let mut findings: Vec<Hit> = counts
        .into_iter()
        .map(|(name, (scalar, count))| {
            let more = match count {
                1 => String::new(),
                count => format!(" (so has each of {} more)", count - 1),
            };
            scalar.finding(format!(
                "it has the attribute {name}{more}, which only an FMU for Model Exchange may have: remove it"
            ))
        })
        .collect();
    findings.sort_by_key(|hit| hit.position);
    findings
}

/// `reinit` of something else than a state, which is what a derivative is one of: by its index, in FMI 3.0 by its reference.
pub fn reinit(document: &Document) -> Vec<Hit> {
    let of = |scalar: &Scalar| scalar.typed.attribute("derivative")?.trim().parse::<usize>().ok();
    let states: HashSet<usize> = document.known().filter_map(of).collect();
    let number = |scalar: &Scalar| match document.read.standard {
        Version::Two => Some(scalar.position + 1),
        Version::Three => scalar.node.attribute("valueReference")?.trim().parse().ok(),
    };
    let is_exchange =
        document.read.standard == Version::Three || named(document.root, "ModelExchange").next().is_some();
    document.of_each(|scalar| {
        let is_state = number(&scalar).is_some_and(|number| states.contains(&number));
        (is_exchange && scalar.typed.has_attribute("reinit") && !is_state)
            .then(|| "it has the attribute reinit, but is no continuous-time state: remove it".to_owned())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates() {
        for text in
            ["2009-12-08T14:33:22Z", "2009-12-08T14:33:22", "2009-12-08T14:33:22.123Z", "2009-12-08T14:33:22+01:00"]
        {
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
