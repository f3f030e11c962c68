//! Checks of two further files: the manifest of the layered standard FMI-LS-REF (its schema is that of versions
//! 1.0.0-alpha.1 and 1.0.0-beta.1), and the version in `terminalsAndIcons.xml`.

use std::str;

use roxmltree::Node;

use super::hit::{Breach, Hit};
use fmu_import::{FmuError, Package, xml};

const MANIFEST: &str = "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml";
const TERMINALS: &str = "terminalsAndIcons/terminalsAndIcons.xml";
const NAMESPACE: &str = "http://fmi-standard.org/fmi-ls-manifest";
const SCHEMA_INSTANCE: &str = "http://www.w3.org/2001/XMLSchema-instance";
/// Both files are short; a tree of elements takes many times its text's memory.
const LARGEST: usize = 1_000_000;

/// The manifest's own attributes; where the schema fixes the value, with it.
const FIXED: [(&str, Option<&str>); 3] = [
    ("fmi-ls-name", Some("org.fmi-standard.fmi-ls-ref")),
    ("fmi-ls-version", None),
    (
        "fmi-ls-description",
        Some("Layered Standard providing information on related files included in an FMU."),
    ),
];

const ROLES: &str = "document requirement specification model parameter system testcase experiment experiment/smoke-test \
    experiment/validation experiment/uncertainty-analysis result method rationale report request delivery configuration \
    signature serialized-state meta-data other";

/// The breaches in both files, as far as they are there.
pub(super) fn broken(package: &mut Package) -> Result<Vec<Breach>, FmuError> {
    let version = package.description().fmi_version.clone();
    let same = move |root: Node<'_, '_>| {
        let theirs = root.attribute("fmiVersion").unwrap_or_default();
        let text = format!(
            "fmiVersion is \"{theirs}\" here and \"{version}\" in modelDescription.xml: write the same"
        );
        Vec::from_iter((theirs != version).then_some(text))
    };
    let mut found = in_file(package, TERMINALS, "terminals-version", same)?;
    found.extend(in_file(package, MANIFEST, "references-manifest", manifest)?);
    Ok(found)
}

/// The breaches that `look` finds in an XML file.
fn in_file(
    package: &mut Package,
    file: &str,
    rule: &'static str,
    look: impl FnOnce(Node<'_, '_>) -> Vec<String>,
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
    let breach = |text| (rule, Hit::of(file, text));
    Ok(texts.into_iter().map(breach).collect())
}

/// The breaches of the manifest's schema.
fn manifest(root: Node<'_, '_>) -> Vec<String> {
    if !root.has_tag_name("fmiReferences") {
        return vec![format!(
            "`{}` instead of `fmiReferences`",
            root.tag_name().name()
        )];
    }
    let mut wrong = Vec::new();
    for (name, value) in FIXED {
        match (root.attribute((NAMESPACE, name)), value) {
            (None, _) => wrong.push(format!(
                "`fmiReferences` needs the attribute `fmi-ls:{name}`"
            )),
            (Some(given), Some(value)) if given != value => {
                wrong.push(format!(
                    "fmi-ls:{name} is \"{given}\", and must be \"{value}\""
                ));
            }
            _ => {}
        }
    }
    let own = |name: &str| FIXED.iter().any(|(known, _)| *known == name);
    attributes(
        root,
        &[],
        |space, name| space == NAMESPACE && own(name),
        &mut wrong,
    );
    children(root, "Related", &mut wrong);
    for related in root.children().filter(|node| node.has_tag_name("Related")) {
        attributes(
            related,
            &["type", "source!", "role!", "description"],
            |_, _| false,
            &mut wrong,
        );
        let known = |role: &str| {
            ROLES.split(' ').any(|known| known == role) || role.starts_with("serialized-state/")
        };
        if let Some(role) = related.attribute("role").filter(|role| !known(role)) {
            wrong.push(format!(
                "role=\"{role}\" is none of {}",
                ROLES.replace(' ', ", ")
            ));
        }
        children(related, "Label", &mut wrong);
        for label in related.children().filter(|node| node.has_tag_name("Label")) {
            attributes(label, &["name!", "description"], |_, _| false, &mut wrong);
            children(label, "", &mut wrong);
        }
    }
    wrong
}

/// Attributes that are missing (those with `!` must be there), and those that the schema does not know.
fn attributes(
    node: Node<'_, '_>,
    known: &[&str],
    of_namespace: impl Fn(&str, &str) -> bool,
    wrong: &mut Vec<String>,
) {
    let element = node.tag_name().name();
    for needed in known.iter().filter_map(|name| name.strip_suffix('!')) {
        if node.attribute(needed).is_none() {
            wrong.push(format!("`{element}` needs the attribute `{needed}`"));
        }
    }
    for given in node.attributes() {
        let name = given.name();
        let fits = match given.namespace() {
            None => known
                .iter()
                .any(|known| known.trim_end_matches('!') == name),
            Some(space) => space == SCHEMA_INSTANCE || of_namespace(space, name),
        };
        if !fits {
            wrong.push(format!("`{element}` has no attribute `{name}`"));
        }
    }
}

/// Children that the schema does not know: after those of one name may come one `Annotations`, and no text.
fn children(node: Node<'_, '_>, name: &str, wrong: &mut Vec<String>) {
    let element = node.tag_name().name();
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
            wrong.push(format!(
                "`{}` cannot stand here in `{element}`",
                child.tag_name().name()
            ));
        }
        ended |= last;
    }
}
