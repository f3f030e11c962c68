//! SSP parameter sets (System Structure Parameter Values, SSP 1.0): start values that other tools read and
//! write.

mod write;

use std::path::{Path, PathBuf};

use roxmltree::Node;
use thiserror::Error;

use super::Setting;
use super::values::{find, value_of};
use crate::files::{self, reason};
use fmu_import::{Description, Value, XmlError, xml};

pub use write::write;
pub(crate) use write::{Xml, document, printable};

/// Why a parameter set cannot be used.
#[derive(Debug, Error)]
pub enum SsvError {
    /// The file cannot be read.
    #[error("{path}: {}", reason(path, .source))]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's message.
        source: std::io::Error,
    },
    /// It is no XML that can be read.
    #[error("{path}: no SSP parameter set: {source}")]
    Xml {
        /// The file.
        path: PathBuf,
        /// The problem and its place.
        source: XmlError,
    },
    /// Something in it is wrong.
    #[error("{path}:{line}: {message}")]
    At {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u32,
        /// The problem.
        message: String,
    },
}

/// The content of a parameter set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParameterSet {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    name: String,
    setting: Setting,
    line: u32,
}

const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
const TYPES: [&str; 5] = ["Real", "Integer", "Boolean", "Enumeration", "String"];

/// Reads a parameter set.
///
/// # Errors
/// When it cannot be read or is not a parameter set, with the line.
pub fn read(path: &Path) -> Result<ParameterSet, SsvError> {
    let text = files::text(path).map_err(|source| SsvError::Read {
        path: path.to_owned(),
        source,
    })?;
    parse(path, &text)
}

fn parse(path: &Path, text: &str) -> Result<ParameterSet, SsvError> {
    let text = text.trim_start_matches('\u{feff}');
    let document = xml::parse(text).map_err(|source| SsvError::Xml {
        path: path.to_owned(),
        source,
    })?;
    let at = |node: Node<'_, '_>, message: String| SsvError::At {
        path: path.to_owned(),
        line: document.text_pos_at(node.range().start).row,
        message,
    };
    let root = document.root_element();
    if root.tag_name().name() != "ParameterSet" {
        let name = root.tag_name().name();
        return Err(at(
            root,
            format!("`{name}` is no SSP parameter set (`ParameterSet`)"),
        ));
    }
    let parameters = root
        .descendants()
        .filter(|node| node.has_tag_name((NAMESPACE, "Parameter")));
    let entry = |node: Node<'_, '_>| {
        let name = node.attribute("name");
        let name = name.ok_or_else(|| at(node, "a parameter without a name".to_owned()))?;
        let typed = node
            .children()
            .find(|child| TYPES.contains(&child.tag_name().name()));
        let value = typed.and_then(|typed| typed.attribute("value"));
        let (Some(typed), Some(value)) = (typed, value) else {
            let types = TYPES.join(", ");
            return Err(at(
                node,
                format!("`{name}` has no value of the types {types}"),
            ));
        };
        let text = match typed.attribute("unit").filter(|unit| !unit.is_empty()) {
            Some(unit) => format!("{value} {unit}"),
            None => value.to_owned(),
        };
        Ok(Entry {
            name: name.to_owned(),
            setting: Setting::Text(text),
            line: document.text_pos_at(node.range().start).row,
        })
    };
    let entries = parameters.map(entry).collect::<Result<_, _>>()?;
    Ok(ParameterSet { entries })
}

impl ParameterSet {
    /// The start values for an FMU, by value reference.
    ///
    /// # Errors
    /// When a name, a type or a unit does not fit the FMU, with the line.
    pub fn settings(&self, path: &Path, fmu: &Description) -> Result<Vec<(u32, Value)>, SsvError> {
        let named = self.named(path, fmu)?;
        Ok(named
            .into_iter()
            .map(|(_, reference, value)| (reference, value))
            .collect())
    }

    /// The same, with the names.
    ///
    /// # Errors
    /// As [`settings`](Self::settings).
    pub fn named(
        &self,
        path: &Path,
        fmu: &Description,
    ) -> Result<Vec<(String, u32, Value)>, SsvError> {
        let bind = |entry: &Entry| {
            let variable = find(fmu, &entry.name)?;
            let value = value_of(fmu, variable, &entry.setting)?;
            Ok((entry.name.clone(), variable.handle().reference, value))
        };
        let bind = |entry: &Entry| {
            bind(entry).map_err(|message: String| SsvError::At {
                path: path.to_owned(),
                line: entry.line,
                message,
            })
        };
        self.entries.iter().map(bind).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fmu_import::{Kind, Variable};
    use proptest::prelude::*;

    fn set(body: &str) -> Result<ParameterSet, SsvError> {
        let text = format!(
            "<ParameterSet xmlns=\"{NAMESPACE}\" version=\"1.0\" name=\"x\"><Parameters>\n{body}\
             </Parameters></ParameterSet>"
        );
        parse(Path::new("p.ssv"), &text)
    }

    #[test]
    fn mistakes_have_their_line() {
        let error = |body: &str| set(body).unwrap_err().to_string();
        assert!(error("<Parameter/>").starts_with("p.ssv:2: a parameter without a name"));
        assert!(
            error("\n<Parameter name=\"a\"><Binary/></Parameter>")
                .starts_with("p.ssv:3: `a` has no value")
        );
        assert!(error("<Parameter").starts_with("p.ssv: "));
        let other = parse(Path::new("p.ssv"), "<html/>")
            .unwrap_err()
            .to_string();
        assert!(other.contains("no SSP parameter set"), "{other}");
    }

    #[test]
    fn units_belong_to_the_value() {
        let set = set("<Parameter name=\"a\"><Real value=\"2\" unit=\"mm\"/></Parameter>").unwrap();
        assert!(matches!(&set.entries[0].setting, Setting::Text(text) if text == "2 mm"));
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
                kind: Kind::String { start: None },
            };
            let values = [(&variable, Value::String(text.clone()))];
            let written = write("s", &Description::default(), &values).unwrap();
            let read = parse(Path::new("p.ssv"), &written).unwrap();
            prop_assert_eq!(&read.entries[0].name, &name);
            prop_assert_eq!(&read.entries[0].setting, &Setting::Text(text));
        }
    }
}
