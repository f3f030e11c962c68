//! Parameter sets as XML.

use std::borrow::Cow;
use std::io;

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};

use super::NAMESPACE;
use fmu_import::units::{Conversion, Unit};
use fmu_import::{Description, Kind, Value, Variable};

const COMMON: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";

/// A document that is being written.
pub(crate) type Xml = Writer<Vec<u8>>;

/// A parameter set with these values, in the FMU's units.
///
/// # Errors
/// Never: memory takes whatever is written.
pub fn write(name: &str, fmu: &Description, values: &[(&Variable, Value)]) -> io::Result<String> {
    document(|xml| {
        let name = printable(name);
        let set = xml.create_element("ssv:ParameterSet").with_attributes([
            ("xmlns:ssv", NAMESPACE),
            ("xmlns:ssc", COMMON),
            ("version", "1.0"),
            ("name", &name),
        ]);
        set.write_inner_content(|xml| {
            let parameters = xml.create_element("ssv:Parameters");
            parameters.write_inner_content(|xml| {
                let mut values = values.iter();
                values.try_for_each(|(variable, value)| parameter(xml, variable, value))
            })?;
            units(xml, fmu, values)
        })?;
        Ok(())
    })
}

/// An XML document with this content.
pub(crate) fn document(content: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<String> {
    let mut xml = Writer::new_with_indent(Vec::new(), b' ', 2);
    let declaration = BytesDecl::new("1.0", Some("UTF-8"), None);
    xml.write_event(Event::Decl(declaration))?;
    content(&mut xml)?;
    let mut text = String::from_utf8(xml.into_inner()).map_err(io::Error::other)?;
    text.push('\n');
    Ok(text)
}

fn parameter(xml: &mut Xml, variable: &Variable, value: &Value) -> io::Result<()> {
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
    let name = printable(&variable.name);
    let parameter = xml.create_element("ssv:Parameter");
    let parameter = parameter.with_attribute(("name", name));
    parameter.write_inner_content(|xml| {
        let value = xml.create_element(element);
        let value = value.with_attribute(("value", printable(&text)));
        let value = value.with_attributes(unit.map(|unit| ("unit", printable(unit))));
        value.write_empty().map(drop)
    })?;
    Ok(())
}

/// The definitions of the units that occur.
fn units(xml: &mut Xml, fmu: &Description, values: &[(&Variable, Value)]) -> io::Result<()> {
    let used = |name: &str| {
        values
            .iter()
            .any(|(variable, _)| variable.unit() == Some(name))
    };
    let used: Vec<(&str, &Unit)> = fmu.units.iter().filter(|(name, _)| used(name)).collect();
    if used.is_empty() {
        return Ok(());
    }
    let units = xml.create_element("ssv:Units");
    units.write_inner_content(|xml| used.iter().try_for_each(|(name, u)| unit(xml, name, u)))?;
    Ok(())
}

fn unit(xml: &mut Xml, name: &str, unit: &Unit) -> io::Result<()> {
    const NAMES: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];
    let mut attributes: Vec<(&str, Cow<'_, str>)> = Vec::new();
    if let Some(base) = unit.base {
        let exponents = NAMES.into_iter().zip(base.exponents);
        let exponents = exponents.filter(|(_, exponent)| *exponent != 0);
        attributes.extend(exponents.map(|(name, e)| (name, e.to_string().into())));
        let Conversion { factor, offset } = base.to_base;
        if factor != 1.0 {
            attributes.push(("factor", format!("{factor:e}").into()));
        }
        if offset != 0.0 {
            attributes.push(("offset", format!("{offset:e}").into()));
        }
    }
    let unit = xml.create_element("ssc:Unit");
    let unit = unit.with_attribute(("name", printable(name)));
    unit.write_inner_content(|xml| {
        let base = xml.create_element("ssc:BaseUnit");
        base.with_attributes(attributes).write_empty().map(drop)
    })?;
    Ok(())
}

/// A text without the control characters that XML has no way to write.
pub(crate) fn printable(text: &str) -> Cow<'_, str> {
    let foreign = |c: char| c < ' ' && !['\n', '\t', '\r'].contains(&c);
    if text.contains(foreign) {
        Cow::Owned(text.replace(foreign, " "))
    } else {
        Cow::Borrowed(text)
    }
}
