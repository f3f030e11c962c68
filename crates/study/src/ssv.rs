//! SSP parameter sets (System Structure Parameter Values, SSP 1.0): start values that other tools read and
//! write.

mod write;

use std::path::Path;

use roxmltree::Node;

use super::{
    Setting,
    values::{find, value_of},
};
use fmu_import::{
    Description, Value,
    xml::{self, tag},
};
use number_tables::files::{self, FileError, Result};

pub use write::write;

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const TYPES: [&str; 5] = ["Real", "Integer", "Boolean", "Enumeration", "String"];

/// Reads the start values that a parameter set gives an FMU: name, value reference, value.
///
/// # Errors
/// When it cannot be read or is not a parameter set, and when a name, a type or a unit does not fit the FMU, with the line.
pub fn read(path: &Path, fmu: &Description) -> Result<Vec<(String, u32, Value)>> {
    parse(path, &files::text(path)?, |name, setting| {
        let variable = find(fmu, name)?;
        let value = value_of(fmu, variable, &setting)?;
        Ok((name.to_owned(), variable.handle().reference, value))
    })
}

/// The results of `take` on each entry.
fn parse<T>(path: &Path, text: &str, take: impl Fn(&str, Setting) -> Result<T, String>) -> Result<Vec<T>> {
    let text = text.trim_start_matches('\u{feff}');
    let document = xml::parse(text).map_err(|error| FileError::new(path, format!("no SSP parameter set: {error}")))?;
    let at = |node: Node, message| FileError::new(path, message).at_line(document.text_pos_at(node.range().start).row);
    let root = document.root_element();
    let name = tag(root);
    if name != "ParameterSet" {
        return Err(at(root, format!("`{name}` is no SSP parameter set (`ParameterSet`)")));
    }
    let parameters = root.descendants().filter(|node| node.has_tag_name((NAMESPACE, "Parameter")));
    let entry = |node: Node| {
        let name = node.attribute("name").ok_or("a parameter without a name")?;
        let mut children = node.children();
        let typed = children.find(|child| TYPES.contains(&tag(*child)));
        let value = typed.and_then(|typed| typed.attribute("value"));
        let (Some(typed), Some(value)) = (typed, value) else {
            let types = TYPES.join(", ");
            return Err(format!("`{name}` has no value of the types {types}"));
        };
        let text = match typed.attribute("unit").filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{value} {unit}"),
            None => value.to_owned(),
        };
        take(name, Setting::Text(text))
    };
    parameters.map(|node| entry(node).map_err(|message| at(node, message))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_import::{Kind, Variable};
    use proptest::prelude::*;

    type Entry = (String, Setting);

    fn entry(name: &str, setting: Setting) -> Result<Entry, String> {
        Ok((name.to_owned(), setting))
    }

    fn set(body: &str) -> Result<Vec<Entry>> {
        let text = format!(
            "<ParameterSet xmlns=\"{NAMESPACE}\" version=\"1.0\" name=\"x\"><Parameters>\n{body}\
             </Parameters></ParameterSet>"
        );
        parse(Path::new("p.ssv"), &text, entry)
    }

    #[test]
    fn mistakes_have_their_line() {
        let error = |body: &str| set(body).unwrap_err().to_string();
        assert!(error("<Parameter/>").starts_with("p.ssv:2: a parameter without a name"));
        assert!(error("\n<Parameter name=\"a\"><Binary/></Parameter>").starts_with("p.ssv:3: `a` has no value"));
        assert!(error("<Parameter").starts_with("p.ssv: "));
        let other = parse(Path::new("p.ssv"), "<html/>", entry).unwrap_err().to_string();
        assert!(other.contains("no SSP parameter set"), "{other}");
    }

    #[test]
    fn units_belong_to_the_value() {
        let set = set("<Parameter name=\"a\"><Real value=\"2\" unit=\"mm\"/></Parameter>").unwrap();
        assert!(matches!(&set[0].1, Setting::Text(text) if text == "2 mm"));
    }

    proptest! {
        #[test]
        fn texts_and_names_come_back(name in "[a-z<&\"]{1,8}", text in "[ -~äµ\t\n]{0,20}") {
            let variable = Variable {
                name: name.clone(),
                line: 1,
                value_reference: 1,
                place: None,
                description: None,
                causality: fmu_import::Causality::Parameter,
                variability: fmu_import::Variability::Fixed,
                clocks: Vec::new(),
                kind: Kind::String { start: None },
            };
            let values = [(&variable, Value::String(text.clone()))];
            let written = write("s", &Description::default(), &values);
            let read = parse(Path::new("p.ssv"), &written, entry).unwrap();
            prop_assert_eq!(&read[0], &(name, Setting::Text(text)));
        }
    }
}
