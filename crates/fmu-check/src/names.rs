//! Names of variables (FMI 2.0.5, section 2.2.9).

use crate::{
    document::{Document, Scalar, Variable, at},
    hit::Hit,
};

/// A naming convention that is none.
pub fn convention(document: &Document) -> Vec<Hit> {
    let other =
        document.root.attribute("variableNamingConvention").filter(|word| !["flat", "structured"].contains(word));
    let text = |word: &str| format!("variableNamingConvention is \"{word}\": it is flat or structured");
    Vec::from_iter(other.map(|word| at(document.root, text(word))))
}

/// Names of which nothing can be made: empty ones, and such with line breaks or tabs.
pub fn legal(scalar: Variable) -> Option<String> {
    if scalar.name.is_empty() {
        return Some("an empty name: give the variable a name".to_owned());
    }
    scalar.name.contains(['\n', '\r', '\t']).then(|| "a line break or a tab in the name: remove it".to_owned())
}

/// Derivatives, by their structured names, that are no Reals.
pub fn of_real(scalar: Variable) -> Option<String> {
    let structured = scalar.document.root.attribute("variableNamingConvention") == Some("structured");
    let derivative = structured && scalar.name.starts_with("der(") && scalar.kind() != "Real";
    derivative
        .then(|| format!("the name is the one of a derivative, which is a Real, not {}: rename it", scalar.kind()))
}

/// The first name that the naming convention does not allow.
pub fn structured(document: &Document) -> Vec<Hit> {
    let convention = document.root.attribute("variableNamingConvention");
    if convention != Some("structured") {
        return Vec::new();
    }
    let strange = |scalar: &&Scalar| scalar.node.has_attribute("name") && !is_structured(scalar.name);
    let strange: Vec<&Scalar> = document.known().filter(strange).collect();
    let more = match strange.len() {
        0 | 1 => String::new(),
        count => format!(" (nor are {} more)", count - 1),
    };
    let text = format!(
        "no structured name{more}: use names as `a.b[1].c`, quoted where they hold other characters, or set \
         variableNamingConvention to flat"
    );
    Vec::from_iter(strange.first().map(|first| first.finding(&text)))
}

/// The grammar of section 2.2.9. Derivatives of derivatives are taken, too, which tools nest instead of counting.
fn is_structured(name: &str) -> bool {
    derivative(name) == Some("")
}

/// The rest of a name after an identifier or a derivative of one.
fn derivative(text: &str) -> Option<&str> {
    let Some(inner) = text.strip_prefix("der(") else { return identifier(text) };
    let rest = derivative(inner)?;
    rest.strip_prefix(',')
        .map(|order| {
            let after = order.trim_start_matches(|c: char| c.is_ascii_digit());
            (after.len() < order.len()).then_some(after)
        })
        .unwrap_or(Some(rest))?
        .strip_prefix(')')
}

/// The rest of a name after an identifier: names with indices, joined by dots.
fn identifier(text: &str) -> Option<&str> {
    let mut rest = indices(simple(text)?)?;
    while let Some(next) = rest.strip_prefix('.') {
        rest = indices(simple(next)?)?;
    }
    Some(rest)
}

/// The rest after a name, or after a name in quotes.
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

/// The rest after indices in brackets, where there are any.
fn indices(text: &str) -> Option<&str> {
    let Some(inner) = text.strip_prefix('[') else { return Some(text) };
    let (list, rest) = inner.split_once(']')?;
    let number = |word: &str| !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    // Modelica tools write a space after the comma.
    list.split(',').all(|word| number(word.trim())).then_some(rest)
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
        for name in ["", "1a", "a.", ".a", "a b", "a[]", "a[i]", "der(a", "der(a,)", "''", "'a", "a-b", "é"] {
            assert!(!is_structured(name), "{name}");
        }
    }
}
