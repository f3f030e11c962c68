//! Parameter sets as XML.

use std::borrow::Cow;

use minijinja::{
    AutoEscape, Environment, context,
    value::{Serde, Value as Cell},
};
use quick_xml::{escape::escape, events::attributes::Attribute};

use fmu_import::{
    Description, Kind, Value, Variable,
    units::{BaseUnit, Conversion, Unit},
};
use fmu_points::tell::is_hidden;

/// A parameter set with these values, in the FMU's units.
pub fn write(name: &str, fmu: &Description, values: &[(&Variable, Value)]) -> String {
    let parameters = values.iter().map(|(variable, value)| parameter(variable, value));
    // The definitions of the units that occur.
    let used = |name: &str| {
        let mut variables = values.iter().map(|(variable, _)| variable);
        variables.any(|variable| variable.unit() == Some(name))
    };
    let units = fmu
        .units
        .0
        .iter()
        .filter(|(name, _)| used(name))
        .map(|(name, of)| context! { name => name.as_str(), base => Serde(base(of)) });
    let values = context! {
        name,
        parameters => parameters.collect::<Vec<_>>(),
        units => units.collect::<Vec<_>>(),
    };
    filled(include_str!("set.xml"), values)
}

fn parameter(variable: &Variable, value: &Value) -> Cell {
    let (kind, text) = match (value, &variable.kind) {
        (Value::Real(value), _) => ("Real", format!("{value:e}")),
        (Value::Integer(value), Kind::Enumeration { items, .. }) => {
            let item = items
                .iter()
                .find(|(_, number)| number == value)
                .map_or_else(|| value.to_string(), |(name, _)| name.clone());
            ("Enumeration", item)
        }
        (Value::Integer(value), _) => ("Integer", value.to_string()),
        (Value::Boolean(value), _) => ("Boolean", value.to_string()),
        (Value::String(value), _) => ("String", value.clone()),
    };
    let unit = variable.unit().filter(|_| kind == "Real");
    context! { name => variable.name.as_str(), type => kind, value => text, unit }
}

/// The exponents of a unit's base units, its factor and its offset, as far as they say something.
fn base(unit: &Unit) -> Vec<(&'static str, String)> {
    let mut told = Vec::new();
    if let Some(base) = unit.base {
        let exponents = BaseUnit::NAMES.into_iter().zip(base.exponents).filter(|(_, exponent)| *exponent != 0);
        told.extend(exponents.map(|(name, e)| (name, e.to_string())));
        let Conversion { factor, offset } = base.to_base;
        if factor != 1.0 {
            told.push(("factor", format!("{factor:e}")));
        }
        if offset != 0.0 {
            told.push(("offset", format!("{offset:e}")));
        }
    }
    told
}

/// The document that a template makes of values. They stand in attributes, or by the filter `text` between tags.
fn filled(template: &str, values: Cell) -> String {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.set_formatter(|out, _, value| {
        let text = value.to_string();
        let written =
            if value.is_safe() { Cow::Borrowed(&*text) } else { Attribute::from(("", printable(&text))).value };
        Ok(out.write_str(&written)?)
    });
    environment.add_filter("text", |text: &str| Cell::from_safe_string(escape(printable(text)).into_owned()));
    let document = environment.render_str(template, values).expect("a template of ours has all that it needs");
    let mut shown = String::new();
    for c in document.chars() {
        if is_hidden(c) && !c.is_ascii_whitespace() {
            shown += &format!("&#x{:x};", u32::from(c))
        } else {
            shown.push(c)
        }
    }
    shown + "\n"
}

/// A text without the control characters that XML has no way to write.
fn printable(text: &str) -> Cow<'_, str> {
    let foreign = |c: char| c < ' ' && !['\n', '\t', '\r'].contains(&c);
    if text.contains(foreign) { Cow::Owned(text.replace(foreign, " ")) } else { Cow::Borrowed(text) }
}
