//! Checks of two further files: the manifest of the layered standard FMI-LS-REF (its schema is that of versions
//! 1.0.0-alpha.1 and 1.0.0-beta.1), and the version in `terminalsAndIcons.xml`.

use std::str;

use roxmltree::Node;

use crate::{
    document::tag,
    hit::{Breach, Hit},
};
use fmu_import::{FmuError, Package, xml};

const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml";
const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";
const NAMESPACE: &str = "http://fmi-standard.org/fmi-ls-manifest";
const SCHEMA_INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";
/// Both files are short; a tree of elements takes many times its text's memory.
const LARGEST: usize = 1_000_000;

/// The elements of the manifest by their depth: the attributes, with `!` where they must be there, and the elements within.
const LEVELS: [(&str, &str); 3] = [
    ("fmi-ls:fmi-ls-name! fmi-ls:fmi-ls-version! fmi-ls:fmi-ls-description!", "Related"),
    ("type source! role! description", "Label"),
    ("name! description", ""),
];

/// Attributes of which the schema fixes the value.
const FIXED: [(&str, &str); 2] = [
    ("fmi-ls:fmi-ls-name", "org.fmi-standard.fmi-ls-ref"),
    ("fmi-ls:fmi-ls-description", "Layered Standard providing information on related files included in an FMU."),
];

const ROLES: &str = "document requirement specification model parameter system testcase experiment experiment/smoke-test \
    experiment/validation experiment/uncertainty-analysis result method rationale report request delivery configuration \
    signature serialized-state meta-data other";

/// The breaches in both files, as far as they are there.
pub fn broken(package: &mut Package) -> Result<Vec<Breach>, FmuError> {
    let version = package.description().fmi_version.clone();
    let mut breaches = in_file(package, TERMINALS, "terminals-version", move |root| {
        let theirs = root.attribute("fmiVersion").unwrap_or_default();
        Vec::from_iter((theirs != version).then_some(format!(
            "fmiVersion is \"{theirs}\" here and \"{version}\" in modelDescription.xml: write the same"
        )))
    })?;
    breaches.extend(in_file(package, MANIFEST, "references-manifest", manifest)?);
    Ok(breaches)
}

/// The breaches that `look` finds in an XML file.
fn in_file(
    package: &mut Package,
    file: &str,
    rule: &'static str,
    look: impl FnOnce(Node) -> Vec<String>,
) -> Result<Vec<Breach>, FmuError> {
    if !package.entries().iter().any(|entry| entry == file) {
        return Ok(Vec::new());
    }
    let texts = match package.bytes_of(file) {
        Ok(bytes) if bytes.len() > LARGEST => {
            vec![format!("longer than {LARGEST} bytes, and not looked at")]
        }
        Ok(bytes) => match str::from_utf8(&bytes).map(xml::parse) {
            Ok(Ok(document)) => look(document.root_element()),
            Ok(Err(error)) => vec![error.to_string()],
            Err(error) => vec![error.to_string()],
        },
        Err(FmuError { fault, .. }) if fault.is_in_fmu() => vec![fault.to_string()],
        Err(error) => return Err(error),
    };
    Ok(texts.into_iter().map(|text| (rule, Hit::of(file, text))).collect())
}

/// The breaches of the manifest's schema.
fn manifest(root: Node) -> Vec<String> {
    if !root.has_tag_name("fmiReferences") {
        return vec![format!("`{}` instead of `fmiReferences`", tag(root))];
    }
    let mut wrong = Vec::new();
    element(root, 0, &mut wrong);
    wrong
}

/// The breaches in an element of a depth and in those within it.
fn element(node: Node, depth: usize, wrong: &mut Vec<String>) {
    let (attributes, inner) = LEVELS[depth];
    let name = tag(node);
    let given: Vec<(String, &str)> = node
        .attributes()
        .filter(|attribute| attribute.namespace() != Some(SCHEMA_INSTANCE))
        .map(|attribute| {
            let name = match attribute.namespace() {
                Some(NAMESPACE) => format!("fmi-ls:{}", attribute.name()),
                Some(other) => format!("{other}:{}", attribute.name()),
                None => attribute.name().to_owned(),
            };
            (name, attribute.value())
        })
        .collect();
    for needed in attributes.split(' ').filter_map(|name| name.strip_suffix('!')) {
        if given.iter().all(|(given, _)| given != needed) {
            wrong.push(format!("`{name}` needs the attribute `{needed}`"));
        }
    }
    for (given, value) in &given {
        let mut known = attributes.split(' ').map(|name| name.trim_end_matches('!'));
        if known.all(|known| known != given) {
            wrong.push(format!("`{name}` has no attribute `{given}`"));
        }
        let fixed = FIXED.iter().find(|(known, _)| known == given);
        if let Some((_, fixed)) = fixed.filter(|(_, fixed)| fixed != value) {
            wrong.push(format!("{given} is \"{value}\", and must be \"{fixed}\""));
        }
        if given == "role" && !ROLES.split(' ').any(|known| known == *value) && !value.starts_with("serialized-state/")
        {
            let roles = ROLES.replace(' ', ", ");
            wrong.push(format!("role=\"{value}\" is none of {roles}"));
        }
    }
    children(node, inner, wrong);
    for child in node.children().filter(|node| node.has_tag_name(inner)) {
        element(child, depth + 1, wrong);
    }
}

/// Children that the schema does not know: after those of one name may come one `Annotations`, and no text.
fn children(node: Node, name: &str, wrong: &mut Vec<String>) {
    let element = tag(node);
    let mut ended = name.is_empty();
    for child in node.children() {
        if child.is_text() && !child.text().unwrap_or_default().trim().is_empty() {
            wrong.push(format!("text in `{element}`"));
        }
        if !child.is_element() {
            continue;
        }
        let last = child.has_tag_name("Annotations") && !name.is_empty();
        if ended || !(last || child.has_tag_name(name)) {
            wrong.push(format!("`{}` cannot stand here in `{element}`", tag(child)));
        }
        ended |= last;
    }
}
