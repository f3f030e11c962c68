//! The model description of FMI 3.0, `modelDescription.xml`, written from the model's variable table.

use crate::boundary::describe::{
    convention, enumerations, experiment, hash, initially_known, listed, log_categories, origin,
    units, uuid,
};
use crate::boundary::values::TIME;
use crate::boundary::version::Version;
use crate::boundary::xml::{Number, Tag, Xml};
use crate::model::{Kind, Model, Role, Variable};

/// The text of `modelDescription.xml`.
pub fn xml<M: Model>() -> String {
    with_token::<M>(&token(fingerprint::<M>()))
}

/// A hash of the whole description, token apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>() -> u128 {
    hash(&with_token::<M>(""))
}

/// The instantiation token of a fingerprint. `fmi3Instantiate...` compares it, so that a binary never runs with another
/// version's description.
pub fn token(fingerprint: u128) -> String {
    format!("{{{}}}", uuid(fingerprint))
}

fn with_token<M: Model>(token: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let root = Tag::new("fmiModelDescription")
        .with("fmiVersion", "3.0")
        .with("modelName", info.name)
        .with("instantiationToken", token);
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

/// All that can be done, and nothing that cannot: the boundary steps through without a stop, so there is no intermediate
/// update, no early return and no event mode.
fn co_simulation<M: Model>(xml: &mut Xml) {
    xml.leaf(
        Tag::new("CoSimulation")
            .with("modelIdentifier", M::INFO.identifier)
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("providesDirectionalDerivatives", true)
            .with("providesAdjointDerivatives", true)
            .with("canHandleVariableCommunicationStepSize", true)
            .with("maxOutputDerivativeOrder", 1)
            .with("providesIntermediateUpdate", false)
            .with("mightReturnEarlyFromDoStep", false)
            .with("canReturnEarlyAfterIntermediateUpdate", false)
            .with("hasEventMode", false),
    );
}

fn types<M: Model>(xml: &mut Xml) {
    let types = enumerations::<M>();
    if types.is_empty() {
        return;
    }
    xml.open(Tag::new("TypeDefinitions"));
    for of in types {
        xml.open(
            Tag::new("EnumerationType")
                .with("name", of.name)
                .with("description", of.description),
        );
        for item in of.items {
            xml.leaf(
                Tag::new("Item")
                    .with("name", item.name)
                    .with("value", item.value)
                    .with("description", item.description),
            );
        }
        xml.close("EnumerationType");
    }
    xml.close("TypeDefinitions");
}

/// The independent variable, then those of the table. A model that has a variable called `time` keeps the name.
fn variables<M: Model>(xml: &mut Xml) {
    let taken = |name: &str| M::variables().iter().any(|variable| variable.name == name);
    let name = ["time", "independentTime"]
        .into_iter()
        .find(|name| !taken(name));
    let initial = M::default();
    xml.open(Tag::new("ModelVariables"));
    xml.leaf(
        Tag::new("Float64")
            .with("name", name.unwrap_or("simulationTime"))
            .with("valueReference", TIME)
            .with("description", "Time, in seconds")
            .with("causality", "independent")
            .with("variability", "continuous"),
    );
    for (reference, variable) in listed::<M>() {
        describe(xml, reference, variable, &initial);
    }
    xml.close("ModelVariables");
}

/// One variable. It has a start value if the host may set it.
fn describe<M: Model>(xml: &mut Xml, reference: usize, variable: &Variable<M>, initial: &M) {
    let changing = match variable.kind {
        Kind::Real { .. } => "continuous",
        _ => "discrete",
    };
    let (causality, variability, first) = match variable.role {
        Role::Input => ("input", changing, None),
        Role::Parameter => ("parameter", "fixed", Some("exact")),
        Role::TunableParameter => ("parameter", "tunable", Some("exact")),
        Role::Output => ("output", changing, Some("calculated")),
        Role::Local => ("local", changing, Some("calculated")),
    };
    let set = !matches!(variable.role, Role::Output | Role::Local);
    let name = Version::Three.type_name(variable);
    let tag = Tag::new(name)
        .with("name", variable.name)
        .with("valueReference", reference)
        .with("description", variable.description)
        .with("causality", causality)
        .with("variability", variability)
        .with_some("initial", first);
    match &variable.kind {
        Kind::Real {
            access,
            unit,
            display,
            min,
            max,
            nominal,
            ..
        } => xml.leaf(
            tag.with("unit", unit.name)
                .with_some("displayUnit", *display)
                .with_some("relativeQuantity", unit.relative.then_some(true))
                .with_some("min", min.map(Number))
                .with_some("max", max.map(Number))
                .with_some("nominal", nominal.map(Number))
                .with_some("start", set.then(|| Number((access.get)(initial)))),
        ),
        Kind::Integer { access, min, max } => xml.leaf(
            tag.with_some("min", *min)
                .with_some("max", *max)
                .with_some("start", set.then(|| (access.get)(initial))),
        ),
        Kind::Boolean { access } => {
            xml.leaf(tag.with_some("start", set.then(|| (access.get)(initial))));
        }
        Kind::Enumeration { access, of } => xml.leaf(
            tag.with("declaredType", of.name)
                .with_some("start", set.then(|| (access.get)(initial))),
        ),
        Kind::String { access } if set => {
            xml.open(tag);
            xml.leaf(Tag::new("Start").with("value", (access.get)(initial)));
            xml.close(name);
        }
        Kind::String { .. } => xml.leaf(tag),
    }
}

/// Outputs and what they depend on, by value references.
fn structure<M: Model>(xml: &mut Xml) {
    let listed = listed::<M>();
    xml.open(Tag::new("ModelStructure"));
    let mut unknowns = |element: &str, known: fn(&Variable<M>, &Variable<M>) -> bool| {
        for (reference, output) in &listed {
            if output.role != Role::Output {
                continue;
            }
            let dependencies = listed.iter().filter(|(_, other)| known(output, other));
            let references: Vec<_> = dependencies.map(|(other, _)| other.to_string()).collect();
            xml.leaf(
                Tag::new(element)
                    .with("valueReference", reference)
                    .with("dependencies", references.join(" ")),
            );
        }
    };
    unknowns("Output", |output, other| {
        output.depends_on.contains(&other.name)
    });
    unknowns("InitialUnknown", initially_known);
    xml.close("ModelStructure");
}
