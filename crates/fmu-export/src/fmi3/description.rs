//! The model description of FMI 3.0, `modelDescription.xml`, written from the model's variable table.

use crate::boundary::describe::{
    Interface, convention, enumerations, experiment, hash, initially_known, listed, log_categories,
    origin, states, units, uuid,
};
use crate::boundary::exchange::{RATE, STATE};
use crate::boundary::intermediate::is_intermediate;
use crate::boundary::types::ValueReference;
use crate::boundary::values::TIME;
use crate::boundary::version::Version;
use crate::boundary::xml::{Number, Tag, Xml};
use crate::model::{Kind, Model, Role, Variable};

/// The text of `modelDescription.xml` for Co-Simulation.
pub fn xml<M: Model>() -> String {
    with_token::<M>(Interface::CoSimulation, &token(fingerprint::<M>()))
}

/// The text of `modelDescription.xml` for Model Exchange, of a model with [`Model::EXCHANGE`].
pub fn exchange_xml<M: Model>() -> String {
    with_token::<M>(
        Interface::ModelExchange,
        &token(exchange_fingerprint::<M>()),
    )
}

/// A hash of the whole description, token apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>() -> u128 {
    hash(&with_token::<M>(Interface::CoSimulation, ""))
}

/// The same of the description for Model Exchange.
pub fn exchange_fingerprint<M: Model>() -> u128 {
    hash(&with_token::<M>(Interface::ModelExchange, ""))
}

/// The instantiation token of a fingerprint. `fmi3Instantiate...` compares it, so that a binary never runs with another
/// version's description.
pub fn token(fingerprint: u128) -> String {
    format!("{{{}}}", uuid(fingerprint))
}

fn with_token<M: Model>(interface: Interface, token: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let root = Tag::new("fmiModelDescription")
        .with("fmiVersion", "3.0")
        .with("modelName", info.name)
        .with("instantiationToken", token);
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

/// All that can be done, and nothing that cannot: a model without inner steps is stepped through without a stop. There is no
/// event mode.
fn co_simulation<M: Model>(xml: &mut Xml) {
    let inner = M::INNER_STEP.is_some();
    xml.leaf(
        Tag::new("CoSimulation")
            .with("modelIdentifier", M::INFO.identifier)
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("providesDirectionalDerivatives", true)
            .with("providesAdjointDerivatives", true)
            .with("canHandleVariableCommunicationStepSize", true)
            .with("maxOutputDerivativeOrder", 1)
            .with("providesIntermediateUpdate", inner)
            .with("mightReturnEarlyFromDoStep", inner)
            .with("canReturnEarlyAfterIntermediateUpdate", inner)
            .with("hasEventMode", false),
    );
}

/// A completed step changes nothing, so the host need not tell of it.
fn model_exchange<M: Model>(xml: &mut Xml) {
    xml.leaf(
        Tag::new("ModelExchange")
            .with("modelIdentifier", M::INFO.identifier)
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("needsCompletedIntegratorStep", false),
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
fn variables<M: Model>(xml: &mut Xml, interface: Interface) {
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
    for (reference, variable) in listed::<M>(interface) {
        let intermediate = interface == Interface::CoSimulation && is_intermediate(variable);
        describe(xml, reference, variable, &initial, intermediate);
    }
    let states = states::<M>(interface);
    let local = |name: &str, reference: ValueReference, description: &str| {
        Tag::new("Float64")
            .with("name", name)
            .with("valueReference", reference)
            .with("description", description)
            .with("causality", "local")
            .with("variability", "continuous")
            .with("initial", "calculated")
    };
    for (reference, state) in (STATE..).zip(states) {
        xml.leaf(
            local(state.name, reference, state.description)
                .with("unit", state.unit.name)
                .with("nominal", Number(state.nominal)),
        );
    }
    for ((reference, of), state) in (RATE..).zip(STATE..).zip(states) {
        let (name, description) = (
            format!("der({})", state.name),
            format!("Rate of: {}", state.description),
        );
        xml.leaf(
            local(&name, reference, &description)
                .with("unit", state.rate_unit.name)
                .with("derivative", of),
        );
    }
    xml.close("ModelVariables");
}

/// One variable. It has a start value if the host may set it.
fn describe<M: Model>(
    xml: &mut Xml,
    reference: usize,
    variable: &Variable<M>,
    initial: &M,
    intermediate: bool,
) {
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
        .with_some("initial", first)
        .with_some("intermediateUpdate", intermediate.then_some(true));
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

/// Outputs and what they depend on, by value references. Without a list of dependencies an unknown depends on all that is
/// known.
fn structure<M: Model>(xml: &mut Xml, interface: Interface) {
    let listed = listed::<M>(interface);
    let states = states::<M>(interface);
    let of = |first: ValueReference| (first..).zip(states).map(|(reference, _)| reference);
    let outputs = |xml: &mut Xml,
                   element: &str,
                   known: fn(&Variable<M>, &Variable<M>) -> bool,
                   more: &[ValueReference]| {
        for (reference, output) in &listed {
            if output.role != Role::Output {
                continue;
            }
            let variables = listed.iter().filter(|(_, other)| known(output, other));
            let references: Vec<_> = variables
                .map(|(other, _)| other.to_string())
                .chain(more.iter().map(ToString::to_string))
                .collect();
            xml.leaf(
                Tag::new(element)
                    .with("valueReference", reference)
                    .with("dependencies", references.join(" ")),
            );
        }
    };
    xml.open(Tag::new("ModelStructure"));
    let on_states: Vec<_> = of(STATE).collect();
    let inputs =
        |output: &Variable<M>, other: &Variable<M>| output.depends_on.contains(&other.name);
    outputs(xml, "Output", inputs, &on_states);
    for rate in of(RATE) {
        xml.leaf(Tag::new("ContinuousStateDerivative").with("valueReference", rate));
    }
    outputs(xml, "InitialUnknown", initially_known, &[]);
    for reference in of(STATE).chain(of(RATE)) {
        xml.leaf(Tag::new("InitialUnknown").with("valueReference", reference));
    }
    xml.close("ModelStructure");
}
