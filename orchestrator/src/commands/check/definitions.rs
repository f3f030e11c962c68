//! What the definitions say before any variable does: names that come twice, factors of nothing, the date, and how
//! variables are named (FMI 2.0.4, sections 2.2.1 to 2.2.4, 2.2.6 and 2.2.9).

use std::collections::{HashMap, HashSet};

use roxmltree::Node;

use super::document::{Scalar, at, elements, named};

/// All that is wrong with the definitions.
pub(super) fn broken(root: Node<'_, '_>, scalars: &[Option<Scalar<'_>>]) -> Vec<String> {
    let mut findings = Vec::new();
    let all = |list, of| named(root, list).flat_map(move |list| named(list, of));
    findings.extend(twice(all("UnitDefinitions", "Unit"), "name"));
    for unit in all("UnitDefinitions", "Unit") {
        findings.extend(twice(named(unit, "DisplayUnit"), "name"));
        findings.extend(elements(unit).filter_map(factor));
    }
    findings.extend(twice(all("TypeDefinitions", "SimpleType"), "name"));
    for items in all("TypeDefinitions", "SimpleType").flat_map(elements) {
        let names = twice(named(items, "Item"), "name");
        findings.extend(names.or_else(|| twice(named(items, "Item"), "value")));
    }
    findings.extend(types_and_variables(
        all("TypeDefinitions", "SimpleType"),
        scalars,
    ));
    findings.extend(twice(all("LogCategories", "Category"), "name"));
    findings.extend(twice(all("VendorAnnotations", "Tool"), "name"));
    findings.extend(date(root));
    findings.extend(convention(root, scalars));
    findings.extend(exchange_only(root, scalars));
    findings
}

/// The first of these elements with an attribute that an earlier one has, too.
fn twice<'a>(nodes: impl Iterator<Item = Node<'a, 'a>>, attribute: &'static str) -> Option<String> {
    let mut seen = HashSet::new();
    let mut known = nodes.filter_map(|node| Some((node, node.attribute(attribute)?)));
    let (node, value) = known.find(|(_, value)| !seen.insert(*value))?;
    let element = node.tag_name().name();
    Some(at(
        node,
        &format!("a second `{element}` with {attribute}=\"{value}\": rename or remove it"),
    ))
}

/// Units are converted by a factor.
fn factor(node: Node<'_, '_>) -> Option<String> {
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

fn types_and_variables<'a>(
    mut types: impl Iterator<Item = Node<'a, 'a>>,
    scalars: &[Option<Scalar<'_>>],
) -> Option<String> {
    let names: HashSet<&str> = scalars.iter().flatten().map(|scalar| scalar.name).collect();
    let node = types.find(|node| {
        node.attribute("name")
            .is_some_and(|name| names.contains(name))
    })?;
    let name = node.attribute("name").unwrap_or_default();
    Some(at(
        node,
        &format!("SimpleType: \"{name}\" is the name of a variable, too: rename the type"),
    ))
}

/// The date of the generation is an `xs:dateTime`.
fn date(root: Node<'_, '_>) -> Option<String> {
    let text = root.attribute("generationDateAndTime")?;
    (!is_date(text.trim())).then(|| {
        let wanted = "write it as 2009-12-08T14:33:22Z, or remove it";
        at(
            root,
            &format!("generationDateAndTime is \"{text}\": {wanted}"),
        )
    })
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
    let (Some(seconds), Some(rest)) = (text.get(..SECONDS.len()), text.get(SECONDS.len()..)) else {
        return false;
    };
    let zone = match rest.strip_prefix('.') {
        Some(fraction) => fraction.trim_start_matches(|c: char| c.is_ascii_digit()),
        None => rest,
    };
    like(seconds, SECONDS) && (["", "Z"].contains(&zone) || like(zone, "+00:00"))
}

/// The first name that the naming convention does not allow.
fn convention(root: Node<'_, '_>, scalars: &[Option<Scalar<'_>>]) -> Option<String> {
    match root.attribute("variableNamingConvention").unwrap_or("flat") {
        "flat" => None,
        "structured" => {
            let strange: Vec<&Scalar<'_>> = scalars
                .iter()
                .flatten()
                .filter(|scalar| scalar.node.has_attribute("name") && !is_structured(scalar.name))
                .collect();
            let first = strange.first()?;
            let more = match strange.len() {
                1 => String::new(),
                count => format!(" ({} more are none, either)", count - 1),
            };
            Some(first.finding(&format!(
                "no structured name{more}: use names as `a.b[1].c`, quoted where they hold other characters, or set \
                 variableNamingConvention to flat"
            )))
        }
        other => Some(at(
            root,
            &format!("variableNamingConvention is \"{other}\": it is flat or structured"),
        )),
    }
}

/// The grammar of section 2.2.9. Derivatives of derivatives are taken, too, which tools nest instead of counting.
fn is_structured(name: &str) -> bool {
    derivative(name) == Some("")
}

/// What follows an identifier or a derivative of one.
fn derivative(text: &str) -> Option<&str> {
    let Some(inner) = text.strip_prefix("der(") else {
        return identifier(text);
    };
    let rest = derivative(inner)?;
    let order = rest.strip_prefix(',').map(|order| {
        let after = order.trim_start_matches(|c: char| c.is_ascii_digit());
        (after.len() < order.len()).then_some(after)
    });
    order.unwrap_or(Some(rest))?.strip_prefix(')')
}

/// What follows an identifier: names with indices, joined by dots.
fn identifier(text: &str) -> Option<&str> {
    let mut rest = indices(simple(text)?)?;
    while let Some(next) = rest.strip_prefix('.') {
        rest = indices(simple(next)?)?;
    }
    Some(rest)
}

/// What follows a name, or a name in quotes.
fn simple(text: &str) -> Option<&str> {
    if let Some(quoted) = text.strip_prefix('\'') {
        let mut escaped = false;
        let end = quoted.find(|c| {
            let closes = c == '\'' && !escaped;
            escaped = c == '\\' && !escaped;
            closes
        })?;
        return (end > 0).then(|| &quoted[end + 1..]);
    }
    let rest = text.trim_start_matches(|c: char| c.is_ascii_alphanumeric() || c == '_');
    (rest.len() < text.len() && !text.starts_with(|c: char| c.is_ascii_digit())).then_some(rest)
}

/// What follows indices in brackets, where there are any.
fn indices(text: &str) -> Option<&str> {
    let Some(inner) = text.strip_prefix('[') else {
        return Some(text);
    };
    let (list, rest) = inner.split_once(']')?;
    let number = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    // Modelica tools write a space after the comma.
    list.split(',')
        .all(|word| number(word.trim()))
        .then_some(rest)
}

/// Attributes that only FMUs for Model Exchange may have.
fn exchange_only(root: Node<'_, '_>, scalars: &[Option<Scalar<'_>>]) -> Vec<String> {
    if named(root, "ModelExchange").next().is_some() {
        return Vec::new();
    }
    let mut counts: HashMap<&str, (&Scalar<'_>, usize)> = HashMap::new();
    for scalar in scalars.iter().flatten() {
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
    let mut findings: Vec<String> = findings.collect();
    findings.sort();
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn structured_names() {
        for name in [
            "a",
            "_a1.b",
            "a[1]",
            "a[1,2].b[3]",
            "a[1, 2]",
            "der(a.b)",
            "der(a[1],2)",
            "der(der(a.b))",
            "'a b!'.c",
            r"'it\'s'",
        ] {
            assert!(is_structured(name), "{name}");
        }
        for name in [
            "", "1a", "a.", ".a", "a b", "a[]", "a[i]", "der(a", "der(a,)", "''", "'a", "a-b", "é",
        ] {
            assert!(!is_structured(name), "{name}");
        }
    }

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
        ] {
            assert!(!is_date(text), "{text}");
        }
    }
}
