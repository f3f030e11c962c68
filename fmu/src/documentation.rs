//! The documentation page of the FMU: a text, and a table of all variables.

use crate::{
    stand::Stand,
    variables::{listing, table},
};
use fmu_export::model::{Kind, Quantity, Role, Variable};
use std::fmt::Write;

/// The whole page.
pub fn page() -> String {
    include_str!("documentation.html")
        .replace("{{version}}", env!("CARGO_PKG_VERSION"))
        .replace("{{variables}}", &tables())
}

fn tables() -> String {
    let stand = Stand::default();
    let mut html = String::new();
    for (heading, roles) in [
        ("Inputs", &[Role::Input][..]),
        ("Parameters", &[Role::Parameter, Role::TunableParameter]),
        ("Outputs", &[Role::Output]),
    ] {
        let _ = writeln!(
            html,
            "<h3>{heading}</h3>\n<table>\n<thead><tr><th>variable</th><th>start</th><th>unit</th><th>description</th></tr></thead>\n<tbody>"
        );
        let listed = listing().iter().map(|reference| &table()[*reference]);
        for variable in listed.filter(|v| roles.contains(&v.role)) {
            let (start, unit) = start(&stand, variable);
            let tunable = if variable.role == Role::TunableParameter { "; tunable" } else { "" };
            let _ = writeln!(
                html,
                "<tr><td><code>{}</code></td><td class=\"number\">{start}</td><td>{unit}</td><td>{}{tunable}</td></tr>",
                variable.name, variable.description
            );
        }
        html.push_str("</tbody>\n</table>\n");
    }
    html
}

/// Start value and unit, in the display unit if there is one. Outputs have no start value.
fn start(stand: &Stand, variable: &Variable<Stand>) -> (String, &'static str) {
    let settable = variable.role != Role::Output;
    let (value, unit) = match &variable.kind {
        Kind::Real(real) => shown(stand, real),
        Kind::Integer { access, .. } => ((access.get)(stand).to_string(), ""),
        Kind::Boolean { access } => ((access.get)(stand).to_string(), ""),
        Kind::Enumeration { access, of } => {
            let value = (access.get)(stand);
            let item = of.items.iter().find(|item| item.value == value);
            (item.map_or_else(|| value.to_string(), |item| item.name.to_owned()), "")
        }
        Kind::String { access } => (format!("\"{}\"", (access.get)(stand)), ""),
        Kind::Clock { .. } => (String::new(), ""),
    };
    (if settable { value } else { String::new() }, unit)
}

/// A value in its display unit, to twelve digits, which hides the rounding of the conversion.
fn shown(stand: &Stand, real: &Quantity<Stand>) -> (String, &'static str) {
    let value = (real.access.get)(stand);
    let mut units = real.unit.display.iter();
    let display = units.find(|known| Some(known.name) == real.display);
    let (value, name) =
        display.map_or((value, real.unit.name), |known| (value * known.factor + known.offset, known.name));
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    let text = match rounded.abs() {
        x if x == 0.0 || (1e-4..1e7).contains(&x) => rounded.to_string(),
        _ => format!("{rounded:e}"),
    };
    (text, name)
}
