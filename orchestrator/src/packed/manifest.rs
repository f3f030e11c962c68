//! `fmi-ls-manifest.xml`, which lists the related files (FMI-LS-REF 1.0.0-alpha.1).

use fmu_import::xml;
use result_document::format::escape;

/// A file that is listed.
pub struct Related {
    /// Its media type.
    pub kind: &'static str,
    /// Its path from the manifest's folder.
    pub source: String,
    /// Its role.
    pub role: &'static str,
    /// What it is.
    pub description: String,
}

impl Related {
    fn xml(&self) -> String {
        let Self { kind, role, .. } = self;
        let [source, description] = [&self.source, &self.description].map(|text| escape(text));
        format!("  <Related type=\"{kind}\" source=\"{source}\" role=\"{role}\" description=\"{description}\"/>\n")
    }
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiReferences \
    xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\" \
    fmi-ls:fmi-ls-version=\"1.0.0-alpha.1\" fmi-ls:fmi-ls-description=\"Layered Standard providing information on related files \
    included in an FMU.\">\n</fmiReferences>\n";

/// The manifest with further files at its end. Whatever else it says stays, but for files below `own`, which are replaced.
///
/// # Errors
/// When it is no such manifest.
pub fn with(before: Option<&str>, own: &str, files: &[Related]) -> Result<String, String> {
    let before = before.unwrap_or(HEAD);
    let document = xml::parse(before).map_err(|error| error.to_string())?;
    let root = document.root_element();
    if !root.has_tag_name("fmiReferences") {
        return Err(format!("`{}` instead of `fmiReferences`", root.tag_name().name()));
    }
    let new: String = files.iter().map(Related::xml).collect();
    let mut text = before.to_owned();
    // From the end on, so that what comes before keeps its place.
    let range = root.range();
    let end = root.children().find(|node| node.has_tag_name("Annotations")).map(|node| node.range().start);
    let close = before[range.clone()].rfind("</").map(|at| range.start + at);
    match (end, close) {
        (Some(end), _) => text.insert_str(end, new.trim_start()),
        (None, Some(close)) => text.insert_str(close, &new),
        (None, None) => text.replace_range(range.end - 2..range.end, &format!(">\n{new}</fmiReferences>")),
    }
    let ours: Vec<_> = root
        .children()
        .filter(|node| {
            node.has_tag_name("Related") && node.attribute("source").is_some_and(|source| source.starts_with(own))
        })
        .map(|node| node.range())
        .collect();
    for range in ours.into_iter().rev() {
        let line = text[range.end..].strip_prefix('\n').map_or(0, |_| 1);
        let indent = text[..range.start].len() - text[..range.start].trim_end_matches([' ', '\t']).len();
        text.replace_range(range.start - indent..range.end + line, "");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn related(source: &str) -> Related {
        Related { kind: "text/csv", source: source.to_owned(), role: "result", description: "a < b".to_owned() }
    }

    fn sources(text: &str) -> Vec<String> {
        let document = roxmltree::Document::parse(text).unwrap();
        let all = document.root_element().children().filter(roxmltree::Node::is_element);
        all.map(|node| node.attribute("source").unwrap_or(node.tag_name().name()).to_owned()).collect()
    }

    #[test]
    fn files_come_to_those_that_are_there_and_replace_their_own() {
        let first = with(None, "a/", &[related("a/x"), related("a/y")]).unwrap();
        assert_eq!(sources(&first), ["a/x", "a/y"]);
        let second = with(Some(&first), "b/", &[related("b/z")]).unwrap();
        assert_eq!(sources(&second), ["a/x", "a/y", "b/z"]);
        assert!(second.starts_with(first.split("</fmi").next().unwrap()));
        let third = with(Some(&second), "a/", &[related("a/x")]).unwrap();
        assert_eq!(sources(&third), ["b/z", "a/x"]);
        let again = with(Some(&third), "b/", &[related("b/z")]).unwrap();
        assert_eq!(again, with(Some(&again), "b/", &[related("b/z")]).unwrap());
    }

    #[test]
    fn annotations_stay_last_and_other_documents_are_refused() {
        let noted = "<fmiReferences><Related source=\"s\" role=\"other\"/><Annotations/></fmiReferences>";
        let told = with(Some(noted), "a/", &[related("a/x")]).unwrap();
        assert_eq!(sources(&told), ["s", "a/x", "Annotations"]);
        let told = with(Some("<fmiReferences/>"), "a/", &[related("a/x")]).unwrap();
        assert_eq!(sources(&told), ["a/x"]);
        assert!(with(Some("<others/>"), "a/", &[]).is_err());
        assert!(with(Some("no xml"), "a/", &[]).is_err());
    }
}
