//! The parts that the model descriptions of all versions share.

use super::{
    logger::categories,
    version::Version,
    xml::{Number, Tag, Xml},
};
use crate::model::{
    DisplayUnit, Enumeration, Info, Kind, Model, Quantity, Role, State, Unit, Variable, elements, offered,
};

/// The interface that a description is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interface {
    /// The FMU steps itself.
    #[default]
    CoSimulation,
    /// The host integrates the FMU's states.
    ModelExchange,
}

/// FNV-1a of 128 bits (Fowler, Noll and Vo, 1991).
pub const fn hash(text: &str) -> u128 {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let (bytes, mut at) = (text.as_bytes(), 0);
    let mut hash: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    while at < bytes.len() {
        hash = (hash ^ bytes[at] as u128).wrapping_mul(PRIME);
        at += 1;
    }
    hash
}

/// The token of a description with this hash, which its instantiation function compares: so a binary never runs with another
/// version's description. It has the usual form of a GUID.
pub fn token(fingerprint: u128) -> String {
    let digits = format!("{fingerprint:032x}");
    let [a, b, c, d] = [&digits[..8], &digits[8..12], &digits[12..16], &digits[16..20]];
    format!("{{{a}-{b}-{c}-{d}-{}}}", &digits[20..])
}

/// The root with the attributes that say where the model comes from.
pub fn origin(root: Tag, info: &Info) -> Tag {
    root.with_some("description", filled(info.description))
        .with_some("author", filled(info.author))
        .with_some("version", filled(info.version))
        .with_some("copyright", filled(info.copyright))
        .with_some("license", filled(info.license))
        .with("generationTool", concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")))
}

/// `structured` if all names are paths such as `bearing.film[2].pressure`, else `flat`, which allows any name.
pub fn convention<M: Model>() -> &'static str {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    let part = |part: &str| {
        let (name, index) = part.split_once('[').unwrap_or((part, "1]"));
        let index = index.strip_suffix(']').unwrap_or_default();
        name.starts_with(letter)
            && name.chars().all(|c| letter(c) || c.is_ascii_digit())
            && index.split(',').all(|index| index.parse::<u32>().is_ok())
    };
    let structured = M::variables().iter().all(|v| v.name.split('.').all(part));
    if structured { "structured" } else { "flat" }
}

fn filled(text: &str) -> Option<&str> {
    (!text.is_empty()).then_some(text)
}

/// The log categories.
pub fn log_categories<M: Model>(xml: &mut Xml) {
    xml.open(Tag::new("LogCategories"));
    for (name, description) in categories::<M>() {
        xml.leaf(Tag::new("Category").with("name", name).with("description", description));
    }
    xml.close("LogCategories");
}

/// The default experiment.
pub fn experiment(xml: &mut Xml, info: &Info) {
    xml.leaf(
        Tag::new("DefaultExperiment")
            .with("startTime", Number(0.0))
            .with("stopTime", Number(info.default_stop))
            .with("tolerance", Number(info.default_tolerance))
            .with("stepSize", Number(info.default_step)),
    );
}

/// The units of all variables, each once, with the display units that any of them has.
pub fn units<M: Model>(xml: &mut Xml, interface: Interface) {
    let mut units: Vec<(&Unit, Vec<&DisplayUnit>)> = Vec::new();
    let of_variables =
        listed::<M>(Version::Two, interface).into_iter().filter_map(|(_, variable)| match variable[0].kind {
            Kind::Real(Quantity { unit, .. }) => Some(unit),
            _ => None,
        });
    let of_states = (states::<M>(interface).iter()).flat_map(|state| [state.unit, state.rate_unit]);
    for unit in of_variables.chain(of_states) {
        let place = units.iter().position(|(other, _)| other.name == unit.name).unwrap_or_else(|| {
            units.push((unit, Vec::new()));
            units.len() - 1
        });
        let shown = &mut units[place].1;
        for display in unit.display {
            if shown.iter().all(|other| other.name != display.name) {
                shown.push(display);
            }
        }
    }
    if units.is_empty() {
        return;
    }
    xml.open(Tag::new("UnitDefinitions"));
    for (unit, shown) in units {
        xml.open(Tag::new("Unit").with("name", unit.name));
        let mut base = Tag::new("BaseUnit");
        for (name, exponent) in unit.base.named() {
            base = base.with_some(name, (exponent != 0).then_some(exponent));
        }
        xml.leaf(base);
        for DisplayUnit { name, factor, offset } in shown {
            xml.leaf(
                Tag::new("DisplayUnit")
                    .with("name", name)
                    .with("factor", Number(*factor))
                    .with_some("offset", (*offset != 0.0).then_some(Number(*offset))),
            );
        }
        xml.close("Unit");
    }
    xml.close("UnitDefinitions");
}

/// The enumerations of all variables, each once.
pub fn enumerations<M: Model>() -> Vec<&'static Enumeration> {
    let mut types: Vec<&Enumeration> = Vec::new();
    for (_, variable) in listed::<M>(Version::Two, Interface::CoSimulation) {
        if let Kind::Enumeration { of, .. } = variable[0].kind
            && types.iter().all(|other| other.name != of.name)
        {
            types.push(of);
        }
    }
    types
}

/// What a version lists in the order of the listing: each variable with its value reference, and an array in FMI 3.0 as the
/// slice of its elements. FMI 2.0 has no clocks, and Model Exchange leaves out what needs the model's own steps.
pub fn listed<M: Model>(version: Version, interface: Interface) -> Vec<(usize, &'static [Variable<M>])> {
    let (table, mut next) = (M::variables(), 0);
    let mut starts = vec![false; table.len()];
    while let Some(variable) = table.get(next) {
        starts[next] = true;
        next += variable.elements.max(1);
    }
    let left_out = match (interface, offered::<M>()) {
        (Interface::ModelExchange, Some(exchange)) => (exchange.without)(),
        _ => &[],
    };
    M::listing()
        .into_iter()
        .filter_map(|place| {
            let elements = match version {
                Version::Two => table.get(place..=place)?,
                Version::Three => elements::<M>(place),
            };
            let first = elements.first()?;
            let is_shown = match version {
                Version::Two => !matches!(first.kind, Kind::Clock { .. }),
                Version::Three => starts[place],
            };
            (is_shown && !left_out.contains(&first.name)).then_some((place, elements))
        })
        .collect()
}

/// The states that the host integrates; none in Co-Simulation.
pub fn states<M: Model>(interface: Interface) -> &'static [State<M>] {
    match (interface, offered::<M>()) {
        (Interface::ModelExchange, Some(exchange)) => (exchange.states)(),
        _ => &[],
    }
}

/// Whether the output depends on the input without delay. Each slice holds the elements of one variable.
pub fn depends<M>(output: &[Variable<M>], input: &[Variable<M>]) -> bool {
    let on = |name| output.iter().any(|output| output.depends_on.contains(name));
    input.iter().any(|input| on(&input.name))
}

/// Whether an output may depend on another variable at the start: on parameters, too, but on no more inputs than later,
/// as hosts that couple FMUs take each such input for a part of an algebraic loop.
pub fn initially_known<M>(output: &[Variable<M>], other: &[Variable<M>]) -> bool {
    match other[0].role {
        Role::Input => depends(output, other),
        Role::Parameter | Role::TunableParameter => true,
        Role::Output | Role::Local => false,
    }
}
