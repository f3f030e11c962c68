//! The model description, `modelDescription.xml`, written from the model's variable table.

use crate::boundary::describe::{
    convention, enumerations, experiment, hash, initially_known, listed, log_categories, origin,
    units, uuid,
};
use crate::boundary::xml::{Number, Tag, Xml};
use crate::model::{Enumeration, Kind, Model, Role, Variable};

/// The text of `modelDescription.xml`.
pub fn xml<M: Model>() -> String {
    with_guid::<M>(&guid(fingerprint::<M>()))
}

/// A hash of the whole description, GUID apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>() -> u128 {
    hash(&with_guid::<M>(""))
}

/// A fingerprint in the usual form of a GUID. `fmi2Instantiate` compares it, so that a binary never runs with another
/// version's description.
pub fn guid(fingerprint: u128) -> String {
    format!("{{{}}}", uuid(fingerprint))
}

fn with_guid<M: Model>(guid: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let root = Tag::new("fmiModelDescription")
        .with("fmiVersion", "2.0")
        .with("modelName", info.name)
        .with("guid", guid);
    xml.open(origin(root, &info).with("variableNamingConvention", convention::<M>()));
    co_simulation::<M>(&mut xml);
    units::<M>(&mut xml);
    types::<M>(&mut xml);
    log_categories::<M>(&mut xml);
    experiment(&mut xml, &info);
    variables::<M>(&mut xml);
    structure::<M>(&mut xml);
    xml.close("fmiModelDescription");
    xml.text()
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

fn types<M: Model>(xml: &mut Xml) {
    let types = enumerations::<M>();
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
        unknowns(xml, "InitialUnknowns", initially_known);
    }
    xml.close("ModelStructure");
}
