//! Parameter sets as XML.

use std::borrow::Cow;
use std::io;

use fmu_points::tell::is_hidden;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::NAMESPACE;
use fmu_import::units::{Conversion, Unit};
use fmu_import::{Description, Kind, Value, Variable};

const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";

/// A parameter set with these values, in the FMU's units.
pub fn write(name: &str, fmu: &Description, values: &[(&Variable, Value)]) -> String {
    let parameters = values.iter();
    let parameters = parameters.map(|(variable, value)| parameter(variable, value));
    let set = Element::new("ssv:ParameterSet").attributes([
        ("xmlns:ssv", NAMESPACE),
        ("xmlns:ssc", COMMON),
        ("version", "1.0"),
        ("name", name),
    ]);
    set.with([Element::new("ssv:Parameters").with(parameters)])
        .with(units(fmu, values))
        .document()
}

fn parameter(variable: &Variable, value: &Value) -> Element {
    let (element, text) = match (value, &variable.kind) {
        (Value::Real(value), _) => ("ssv:Real", format!("{value:e}")),
        (Value::Integer(value), Kind::Enumeration { items, .. }) => {
            let item = items.iter().find(|(_, number)| number == value);
            let item = item.map_or_else(|| value.to_string(), |(name, _)| name.clone());
            ("ssv:Enumeration", item)
        }
        (Value::Integer(value), _) => ("ssv:Integer", value.to_string()),
        (Value::Boolean(value), _) => ("ssv:Boolean", value.to_string()),
        (Value::String(value), _) => ("ssv:String", value.clone()),
    };
    let unit = variable.unit().filter(|_| element == "ssv:Real");
    let value = Element::new(element)
        .attributes([("value", text)])
        .attributes(unit.map(|unit| ("unit", unit)));
    Element::new("ssv:Parameter")
        .attributes([("name", variable.name.as_str())])
        .with([value])
}

/// The definitions of the units that occur.
fn units(fmu: &Description, values: &[(&Variable, Value)]) -> Option<Element> {
    let used = |name: &str| {
        let mut variables = values.iter().map(|(variable, _)| variable);
        variables.any(|variable| variable.unit() == Some(name))
    };
    let used = fmu.units.0.iter().filter(|(name, _)| used(name));
    let used: Vec<Element> = used.map(|(name, of)| unit(name, of)).collect();
    (!used.is_empty()).then(|| Element::new("ssv:Units").with(used))
}

fn unit(name: &str, unit: &Unit) -> Element {
    const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
    let mut attributes: Vec<(&str, String)> = Vec::new();
    if let Some(base) = unit.base {
        let exponents = NAMES.into_iter().zip(base.exponents);
        let exponents = exponents.filter(|(_, exponent)| *exponent != 0);
        attributes.extend(exponents.map(|(name, e)| (name, e.to_string())));
        let Conversion { factor, offset } = base.to_base;
        if factor != 1.0 {
            attributes.push(("factor", format!("{factor:e}")));
        }
        if offset != 0.0 {
            attributes.push(("offset", format!("{offset:e}")));
        }
    }
    Element::new("ssc:Unit")
        .attributes([("name", name)])
        .with([Element::new("ssc:BaseUnit").attributes(attributes)])
}

/// An element of an XML document.
pub(crate) struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    text: Option<String>,
    children: Vec<Self>,
}

impl Element {
    pub(crate) fn new(name: &'static str) -> Self {
        Self {
            name,
            attributes: Vec::new(),
            text: None,
            children: Vec::new(),
        }
    }

    pub(crate) fn attributes(
        mut self,
        attributes: impl IntoIterator<Item = (&'static str, impl Into<String>)>,
    ) -> Self {
        let attributes = attributes.into_iter();
        let attributes = attributes.map(|(name, value)| (name, value.into()));
        self.attributes.extend(attributes);
        self
    }

    pub(crate) fn text(mut self, text: &str) -> Self {
        self.text = Some(text.to_owned());
        self
    }

    pub(crate) fn with(mut self, children: impl IntoIterator<Item = Self>) -> Self {
        self.children.extend(children);
        self
    }

    /// A document with this root.
    pub(crate) fn document(&self) -> String {
        let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
        let declaration = BytesDecl::new("1.0", Some("UTF-8"), None);
        xml.write_event(Event::Decl(declaration))
            .and_then(|()| self.write(&mut xml))
            .expect("memory takes whatever is written");
        let text = String::from_utf8(xml.into_inner()).expect("all that is written is text");
        let mut shown = String::new();
        for c in text.chars() {
            match is_hidden(c) && !c.is_ascii_whitespace() {
                true => shown += &format!("&#x{:x};", u32::from(c)),
                false => shown.push(c),
            }
        }
        shown + "\n"
    }

    fn write(&self, xml: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let attributes = self.attributes.iter();
        let attributes = attributes.map(|(name, value)| (*name, printable(value)));
        let element = xml.create_element(self.name).with_attributes(attributes);
        let written = match &self.text {
            Some(text) => element.write_text_content(BytesText::new(&printable(text))),
            None if self.children.is_empty() => element.write_empty(),
            None => element.write_inner_content(|xml| {
                let mut children = self.children.iter();
                children.try_for_each(|child| child.write(xml))
            }),
        };
        written.map(drop)
    }
}

/// A text without the control characters that XML has no way to write.
fn printable(text: &str) -> Cow<'_, str> {
    let foreign = |c: char| c < ' ' && !['\n', '\t', '\r'].contains(&c);
    if text.contains(foreign) {
        Cow::Owned(text.replace(foreign, " "))
    } else {
        Cow::Borrowed(text)
    }
}
