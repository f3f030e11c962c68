//! The model description, `modelDescription.xml`, written from the model's variable table.

use std::ops::Range;

use crate::boundary::describe::{
    Interface, convention, enumerations, experiment, hash, initially_known, listed, log_categories,
    origin, states, units, uuid,
};
use crate::boundary::exchange::{RATE, STATE};
use crate::boundary::types::ValueReference;
use crate::boundary::xml::{Number, Tag, Xml};
use crate::model::{Enumeration, Kind, Model, Role, Variable};

/// The text of `modelDescription.xml` for Co-Simulation.
pub fn xml<M: Model>() -> String {
    with_guid::<M>(Interface::CoSimulation, &guid(fingerprint::<M>()))
}

/// The text of `modelDescription.xml` for Model Exchange, of a model with [`Model::EXCHANGE`].
pub fn exchange_xml<M: Model>() -> String {
    with_guid::<M>(Interface::ModelExchange, &guid(exchange_fingerprint::<M>()))
}

/// A hash of the whole description, GUID apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>() -> u128 {
    hash(&with_guid::<M>(Interface::CoSimulation, ""))
}

/// The same of the description for Model Exchange.
pub fn exchange_fingerprint<M: Model>() -> u128 {
    hash(&with_guid::<M>(Interface::ModelExchange, ""))
}

/// A fingerprint in the usual form of a GUID. `fmi2Instantiate` compares it, so that a binary never runs with another
/// version's description.
pub fn guid(fingerprint: u128) -> String {
    format!("{{{}}}", uuid(fingerprint))
}

fn with_guid<M: Model>(interface: Interface, guid: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let root = Tag::new("fmiModelDescription")
        .with("fmiVersion", "2.0")
        .with("modelName", info.name)
        .with("guid", guid);
    xml.open(origin(root, &info).with("variableNamingConvention", convention::<M>()));
    match interface {
        Interface::CoSimulation => co_simulation::<M>(&mut xml),
        Interface::ModelExchange => model_exchange::<M>(&mut xml),
    }
    units::<M>(&mut xml, interface);
    types::<M>(&mut xml);
    log_categories::<M>(&mut xml);
    experiment(&mut xml, &info);
    variables::<M>(&mut xml, interface);
    structure::<M>(&mut xml, interface);
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

/// A completed step changes nothing, so the host need not tell of it.
fn model_exchange<M: Model>(xml: &mut Xml) {
    xml.leaf(
        Tag::new("ModelExchange")
            .with("modelIdentifier", M::INFO.identifier)
            .with("completedIntegratorStepNotNeeded", true)
            .with("canNotUseMemoryManagementFunctions", true)
            .with("canGetAndSetFMUstate", true)
            .with("canSerializeFMUstate", true),
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

fn variables<M: Model>(xml: &mut Xml, interface: Interface) {
    let initial = M::default();
    xml.open(Tag::new("ModelVariables"));
    let listed = listed::<M>(interface);
    for (reference, variable) in listed.iter().copied() {
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
    let states = states::<M>(interface);
    for (reference, state) in (STATE..).zip(states) {
        let tag = Tag::new("Real")
            .with("unit", state.unit.name)
            .with("nominal", Number(state.nominal));
        local(xml, state.name, reference, state.description, tag);
    }
    // Indices count from 1.
    for ((reference, index), state) in (RATE..).zip(listed.len() + 1..).zip(states) {
        let tag = Tag::new("Real")
            .with("unit", state.rate_unit.name)
            .with("derivative", index);
        let (name, description) = (
            format!("der({})", state.name),
            format!("Rate of: {}", state.description),
        );
        local(xml, &name, reference, &description, tag);
    }
    xml.close("ModelVariables");
}

/// A state or a derivative.
fn local(xml: &mut Xml, name: &str, reference: ValueReference, description: &str, typed: Tag) {
    xml.open(
        Tag::new("ScalarVariable")
            .with("name", name)
            .with("valueReference", reference)
            .with("description", description)
            .with("causality", "local")
            .with("variability", "continuous")
            .with("initial", "calculated"),
    );
    xml.leaf(typed);
    xml.close("ScalarVariable");
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

/// Indices count from 1, in the order of the listing; states follow the variables, and derivatives the states.
fn structure<M: Model>(xml: &mut Xml, interface: Interface) {
    let listed = listed::<M>(interface);
    let states = states::<M>(interface).len();
    let first = listed.len() + 1;
    let outputs = |xml: &mut Xml,
                   known: fn(&Variable<M>, &Variable<M>) -> bool,
                   on_states: bool| {
        for (index, (_, output)) in (1..).zip(&listed) {
            if output.role != Role::Output {
                continue;
            }
            let known = |(_, (_, other)): &(usize, &(usize, &Variable<M>))| known(output, other);
            let variables = (1..).zip(&listed).filter(known).map(|(index, _)| index);
            let states = first..first + if on_states { states } else { 0 };
            let indices: Vec<_> = variables
                .chain(states)
                .map(|index| index.to_string())
                .collect();
            xml.leaf(
                Tag::new("Unknown")
                    .with("index", index)
                    .with("dependencies", indices.join(" ")),
            );
        }
    };
    // Without a list of dependencies an unknown depends on all that is known.
    let others = |xml: &mut Xml, indices: Range<usize>| {
        for index in indices {
            xml.leaf(Tag::new("Unknown").with("index", index));
        }
    };
    xml.open(Tag::new("ModelStructure"));
    let any = listed
        .iter()
        .any(|(_, variable)| variable.role == Role::Output);
    if any {
        xml.open(Tag::new("Outputs"));
        outputs(
            xml,
            |output, other| output.depends_on.contains(&other.name),
            true,
        );
        xml.close("Outputs");
    }
    if states > 0 {
        xml.open(Tag::new("Derivatives"));
        others(xml, first + states..first + 2 * states);
        xml.close("Derivatives");
    }
    if any || states > 0 {
        xml.open(Tag::new("InitialUnknowns"));
        outputs(xml, initially_known, false);
        others(xml, first..first + 2 * states);
        xml.close("InitialUnknowns");
    }
    xml.close("ModelStructure");
}
