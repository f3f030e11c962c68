//! The model description, `modelDescription.xml`, written from the model's variable table.

use super::logger::categories;
use super::xml::{Number, Tag, Xml};
use crate::model::{DisplayUnit, Enumeration, Kind, Model, Role, Unit, Variable};

/// The text of `modelDescription.xml`.
pub fn xml<M: Model>() -> String {
    with_guid::<M>(&guid(fingerprint::<M>()))
}

/// A hash of the whole description, GUID apart: binaries with the same fingerprint have the same description. FNV-1a of
/// 128 bits (Fowler, Noll and Vo, 1991).
pub fn fingerprint<M: Model>() -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    with_guid::<M>("").bytes().fold(BASIS, |hash, byte| {
        (hash ^ u128::from(byte)).wrapping_mul(PRIME)
    })
}

/// A fingerprint in the usual form of a GUID. `fmi2Instantiate` compares it, so that a binary never runs with another
/// version's description.
pub fn guid(fingerprint: u128) -> String {
    let digits = format!("{fingerprint:032x}");
    format!(
        "{{{}-{}-{}-{}-{}}}",
        &digits[..8],
        &digits[8..12],
        &digits[12..16],
        &digits[16..20],
        &digits[20..]
    )
}

fn with_guid<M: Model>(guid: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    xml.open(
        Tag::new("fmiModelDescription")
            .with("fmiVersion", "2.0")
            .with("modelName", info.name)
            .with("guid", guid)
            .with_some("description", filled(info.description))
            .with_some("author", filled(info.author))
            .with_some("version", filled(info.version))
            .with_some("copyright", filled(info.copyright))
            .with_some("license", filled(info.license))
            .with(
                "generationTool",
                concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
            )
            .with("variableNamingConvention", convention::<M>()),
    );
    co_simulation::<M>(&mut xml);
    units::<M>(&mut xml);
    types::<M>(&mut xml);
    xml.open(Tag::new("LogCategories"));
    for (name, description) in categories::<M>() {
        xml.leaf(
            Tag::new("Category")
                .with("name", name)
                .with("description", description),
        );
    }
    xml.close("LogCategories");
    xml.leaf(
        Tag::new("DefaultExperiment")
            .with("startTime", Number(0.0))
            .with("stopTime", Number(info.default_stop))
            .with("tolerance", Number(info.default_tolerance))
            .with("stepSize", Number(info.default_step)),
    );
    variables::<M>(&mut xml);
    structure::<M>(&mut xml);
    xml.close("fmiModelDescription");
    xml.text()
}

/// `structured` if all names are paths such as `bearing.film[2].pressure`, else `flat`, which allows any name.
fn convention<M: Model>() -> &'static str {
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

fn co_simulation<M: Model>(xml: &mut Xml) {
    let sloped = M::variables()
        .iter()
        .any(|v| matches!(v.kind, Kind::Real { slope: Some(_), .. }));
    xml.leaf(
        Tag::new("CoSimulation")
            .with("modelIdentifier", M::INFO.identifier)
            .with("canHandleVariableCommunicationStepSize", true)
            .with("canInterpolateInputs", sloped)
            .with("maxOutputDerivativeOrder", 1)
            .with("canNotUseMemoryManagementFunctions", true)
            .with("canGetAndSetFMUstate", true)
            .with("canSerializeFMUstate", true)
            .with("providesDirectionalDerivative", true),
    );
}

/// The units of all variables, each once, with the display units that any of them has.
fn units<M: Model>(xml: &mut Xml) {
    let mut units: Vec<(&Unit, Vec<&DisplayUnit>)> = Vec::new();
    for (_, variable) in listed::<M>() {
        let Kind::Real { unit, .. } = variable.kind else {
            continue;
        };
        let known = units.iter().position(|(other, _)| other.name == unit.name);
        let place = known.unwrap_or_else(|| {
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
        for DisplayUnit {
            name,
            factor,
            offset,
        } in shown
        {
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

fn types<M: Model>(xml: &mut Xml) {
    let mut types: Vec<&Enumeration> = Vec::new();
    for (_, variable) in listed::<M>() {
        if let Kind::Enumeration { of, .. } = variable.kind
            && types.iter().all(|other| other.name != of.name)
        {
            types.push(of);
        }
    }
    if types.is_empty() {
        return;
    }
    xml.open(Tag::new("TypeDefinitions"));
    for Enumeration {
        name,
        description,
        items,
    } in types
    {
        xml.open(
            Tag::new("SimpleType")
                .with("name", name)
                .with("description", description),
        );
        xml.open(Tag::new("Enumeration"));
        for item in *items {
            xml.leaf(
                Tag::new("Item")
                    .with("name", item.name)
                    .with("value", item.value)
                    .with("description", item.description),
            );
        }
        xml.close("Enumeration");
        xml.close("SimpleType");
    }
    xml.close("TypeDefinitions");
}

/// The variables in the order of their listing, each with its value reference.
fn listed<M: Model>() -> Vec<(usize, &'static Variable<M>)> {
    let table = M::variables();
    (M::listing().into_iter())
        .filter_map(|reference| Some((reference, table.get(reference)?)))
        .collect()
}

fn variables<M: Model>(xml: &mut Xml) {
    let initial = M::default();
    xml.open(Tag::new("ModelVariables"));
    for (reference, variable) in listed::<M>() {
        let continuous = matches!(variable.kind, Kind::Real { .. });
        let changing = if continuous { "continuous" } else { "discrete" };
        let (causality, variability, first) = match variable.role {
            Role::Input => ("input", changing, None),
            Role::Parameter => ("parameter", "fixed", Some("exact")),
            Role::TunableParameter => ("parameter", "tunable", Some("exact")),
            Role::Output => ("output", changing, Some("calculated")),
            Role::Local => ("local", changing, Some("calculated")),
        };
        xml.open(
            Tag::new("ScalarVariable")
                .with("name", variable.name)
                .with("valueReference", reference)
                .with("description", variable.description)
                .with("causality", causality)
                .with("variability", variability)
                .with_some("initial", first),
        );
        xml.leaf(typed(variable, &initial));
        xml.close("ScalarVariable");
    }
    xml.close("ModelVariables");
}

/// The element that names a variable's type. It has a start value if the host may set the variable.
fn typed<M: Model>(variable: &Variable<M>, initial: &M) -> Tag {
    let set = !matches!(variable.role, Role::Output | Role::Local);
    let tag = Tag::new(variable.type_name());
    match &variable.kind {
        Kind::Real {
            access,
            unit,
            display,
            min,
            max,
            nominal,
            ..
        } => tag
            .with("unit", unit.name)
            .with_some("displayUnit", *display)
            .with_some("relativeQuantity", unit.relative.then_some(true))
            .with_some("min", min.map(Number))
            .with_some("max", max.map(Number))
            .with_some("nominal", nominal.map(Number))
            .with_some("start", set.then(|| Number((access.get)(initial)))),
        Kind::Integer { access, min, max } => tag
            .with_some("min", *min)
            .with_some("max", *max)
            .with_some("start", set.then(|| (access.get)(initial))),
        Kind::Boolean { access } => tag.with_some("start", set.then(|| (access.get)(initial))),
        Kind::Enumeration { access, of } => tag
            .with("declaredType", of.name)
            .with_some("start", set.then(|| (access.get)(initial))),
        Kind::String { access } => tag.with_some("start", set.then(|| (access.get)(initial))),
    }
}

fn structure<M: Model>(xml: &mut Xml) {
    let listed = listed::<M>();
    let unknowns = |xml: &mut Xml, list: &str, known: fn(&Variable<M>, &Variable<M>) -> bool| {
        xml.open(Tag::new(list));
        // Indices count from 1, in the order of the listing.
        for (index, (_, output)) in (1..).zip(&listed) {
            if output.role == Role::Output {
                let known =
                    |(_, (_, other)): &(usize, &(usize, &Variable<M>))| known(output, other);
                let dependencies = (1..).zip(&listed).filter(known);
                let indices: Vec<_> = dependencies.map(|(index, _)| index.to_string()).collect();
                xml.leaf(
                    Tag::new("Unknown")
                        .with("index", index)
                        .with("dependencies", indices.join(" ")),
                );
            }
        }
        xml.close(list);
    };
    xml.open(Tag::new("ModelStructure"));
    if listed
        .iter()
        .any(|(_, variable)| variable.role == Role::Output)
    {
        unknowns(xml, "Outputs", |output, other| {
            output.depends_on.contains(&other.name)
        });
        // At the start, outputs may depend on parameters, too, but on no more inputs than later: hosts that couple
        // FMUs take each such input for a part of an algebraic loop.
        unknowns(xml, "InitialUnknowns", |output, other| match other.role {
            Role::Input => output.depends_on.contains(&other.name),
            Role::Parameter | Role::TunableParameter => true,
            Role::Output | Role::Local => false,
        });
    }
    xml.close("ModelStructure");
}
