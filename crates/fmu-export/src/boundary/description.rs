//! The model description, `modelDescription.xml`, written from the model's variable table: the same content in the forms of all
//! versions.

use std::ops::Range;

use super::describe::{
    convention, enumerations, experiment, hash, initially_known, listed, log_categories, origin,
    states, units,
};
use super::exchange::{RATE, STATE};
use super::intermediate::is_intermediate;
use super::types::ValueReference;
use super::values::TIME;
use super::xml::{Number, Tag, Xml};
use crate::model::{Kind, Model, Role, Variable};

pub use super::describe::{Interface, token};
pub use super::version::Version;

/// The text of `modelDescription.xml`.
pub fn xml<M: Model>(version: Version, interface: Interface) -> String {
    let token = token(fingerprint::<M>(version, interface));
    with_token::<M>(version, interface, &token)
}

/// A hash of the whole description, token apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>(version: Version, interface: Interface) -> u128 {
    hash(&with_token::<M>(version, interface, ""))
}

fn with_token<M: Model>(version: Version, interface: Interface, token: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let (number, token_name) = match version {
        Version::Two => ("2.0", "guid"),
        Version::Three => ("3.0", "instantiationToken"),
    };
    let root = Tag::new("fmiModelDescription")
        .with("fmiVersion", number)
        .with("modelName", info.name)
        .with(token_name, token);
    xml.open(origin(root, &info).with("variableNamingConvention", convention::<M>()));
    xml.leaf(match (interface, version) {
        (Interface::CoSimulation, Version::Two) => co_simulation_2::<M>(),
        (Interface::CoSimulation, Version::Three) => co_simulation_3::<M>(),
        (Interface::ModelExchange, _) => model_exchange::<M>(version),
    });
    units::<M>(&mut xml, interface);
    types::<M>(&mut xml, version);
    log_categories::<M>(&mut xml);
    experiment(&mut xml, &info);
    variables::<M>(&mut xml, version, interface);
    structure::<M>(&mut xml, version, interface);
    xml.close("fmiModelDescription");
    xml.text()
}

fn co_simulation_2<M: Model>() -> Tag {
    let sloped = (M::variables().iter())
        .any(|v| matches!(&v.kind, Kind::Real(real) if real.slope.is_some()));
    Tag::new("CoSimulation")
        .with("modelIdentifier", M::INFO.identifier)
        .with("canHandleVariableCommunicationStepSize", true)
        .with("canInterpolateInputs", sloped)
        .with("maxOutputDerivativeOrder", 1)
        .with("canNotUseMemoryManagementFunctions", true)
        .with("canGetAndSetFMUstate", true)
        .with("canSerializeFMUstate", true)
        .with("providesDirectionalDerivative", true)
}

/// All that can be done, and nothing that cannot: a model without inner steps is stepped through without a stop. There is no
/// event mode.
fn co_simulation_3<M: Model>() -> Tag {
    let inner = M::INNER_STEP.is_some();
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
        .with("hasEventMode", false)
}

/// A completed step changes nothing, so the host need not tell of it.
fn model_exchange<M: Model>(version: Version) -> Tag {
    let tag = Tag::new("ModelExchange").with("modelIdentifier", M::INFO.identifier);
    match version {
        Version::Two => tag
            .with("completedIntegratorStepNotNeeded", true)
            .with("canNotUseMemoryManagementFunctions", true)
            .with("canGetAndSetFMUstate", true)
            .with("canSerializeFMUstate", true),
        Version::Three => tag
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("needsCompletedIntegratorStep", false),
    }
}

fn types<M: Model>(xml: &mut Xml, version: Version) {
    let types = enumerations::<M>();
    if types.is_empty() {
        return;
    }
    xml.open(Tag::new("TypeDefinitions"));
    let elements = match version {
        Version::Two => &["SimpleType", "Enumeration"][..],
        Version::Three => &["EnumerationType"],
    };
    for of in types {
        let tag = Tag::new(elements[0]).with("name", of.name);
        xml.open(tag.with("description", of.description));
        for inner in &elements[1..] {
            xml.open(Tag::new(inner));
        }
        for item in of.items {
            xml.leaf(
                Tag::new("Item")
                    .with("name", item.name)
                    .with("value", item.value)
                    .with("description", item.description),
            );
        }
        for element in elements.iter().rev() {
            xml.close(element);
        }
    }
    xml.close("TypeDefinitions");
}

/// The attributes that variables of all types have.
#[derive(Clone, Copy)]
struct Head<'a> {
    name: &'a str,
    reference: usize,
    description: &'a str,
    causality: &'a str,
    variability: &'a str,
    initial: Option<&'a str>,
}

impl<'a> Head<'a> {
    /// Those of a state or a rate.
    fn local(name: &'a str, reference: ValueReference, description: &'a str) -> Self {
        Self {
            name,
            reference: reference as usize,
            description,
            causality: "local",
            variability: "continuous",
            initial: Some("calculated"),
        }
    }

    fn tag(&self, element: &str) -> Tag {
        Tag::new(element)
            .with("name", self.name)
            .with("valueReference", self.reference)
            .with("description", self.description)
            .with("causality", self.causality)
            .with("variability", self.variability)
            .with_some("initial", self.initial)
    }

    /// Writes a variable with the attributes of its type: those of an element within in FMI 2.0, and its own in FMI 3.0.
    fn write(&self, xml: &mut Xml, version: Version, of: &str, typed: impl FnOnce(Tag) -> Tag) {
        match version {
            Version::Two => {
                xml.open(self.tag("ScalarVariable"));
                xml.leaf(typed(Tag::new(of)));
                xml.close("ScalarVariable");
            }
            Version::Three => xml.leaf(typed(self.tag(of))),
        }
    }
}

fn variables<M: Model>(xml: &mut Xml, version: Version, interface: Interface) {
    let initial = M::default();
    let listed = listed::<M>(interface);
    xml.open(Tag::new("ModelVariables"));
    if version == Version::Three {
        independent::<M>(xml);
    }
    for (reference, variable) in &listed {
        let changing = match variable.kind {
            Kind::Real(_) => "continuous",
            _ => "discrete",
        };
        let (causality, variability, first) = match variable.role {
            Role::Input => ("input", changing, None),
            Role::Parameter => ("parameter", "fixed", Some("exact")),
            Role::TunableParameter => ("parameter", "tunable", Some("exact")),
            Role::Output => ("output", changing, Some("calculated")),
            Role::Local => ("local", changing, Some("calculated")),
        };
        let head = Head {
            name: variable.name,
            reference: *reference,
            description: variable.description,
            causality,
            variability,
            initial: first,
        };
        describe(xml, (version, interface), &head, variable, &initial);
    }
    let (real, states) = (version.real(), states::<M>(interface));
    for (reference, state) in (STATE..).zip(states) {
        let typed = |tag: Tag| {
            tag.with("unit", state.unit.name)
                .with("nominal", Number(state.nominal))
        };
        Head::local(state.name, reference, state.description).write(xml, version, real, typed);
    }
    let first = first_state(version, listed.len());
    for ((reference, of), state) in (RATE..).zip(first..).zip(states) {
        let name = format!("der({})", state.name);
        let description = format!("Rate of: {}", state.description);
        let typed = |tag: Tag| {
            tag.with("unit", state.rate_unit.name)
                .with("derivative", of)
        };
        Head::local(&name, reference, &description).write(xml, version, real, typed);
    }
    xml.close("ModelVariables");
}

/// The independent variable, which FMI 3.0 lists. A model that has a variable called `time` keeps the name.
fn independent<M: Model>(xml: &mut Xml) {
    let taken = |name: &str| M::variables().iter().any(|variable| variable.name == name);
    let name = ["time", "independentTime"]
        .into_iter()
        .find(|name| !taken(name));
    let head = Head {
        name: name.unwrap_or("simulationTime"),
        reference: TIME as usize,
        description: "Time, in seconds",
        causality: "independent",
        variability: "continuous",
        initial: None,
    };
    xml.leaf(head.tag("Float64"));
}

/// One variable of the table. It has a start value if the host may set it, which is an element of its own for a text in
/// FMI 3.0.
fn describe<M: Model>(
    xml: &mut Xml,
    (version, interface): (Version, Interface),
    head: &Head<'_>,
    variable: &Variable<M>,
    initial: &M,
) {
    let set = !matches!(variable.role, Role::Output | Role::Local);
    let of = version.type_name(variable);
    let intermediate = version == Version::Three
        && interface == Interface::CoSimulation
        && is_intermediate(variable);
    let typed = |tag: Tag| {
        let tag = tag.with_some("intermediateUpdate", intermediate.then_some(true));
        match &variable.kind {
            Kind::Real(real) => tag
                .with("unit", real.unit.name)
                .with_some("displayUnit", real.display)
                .with_some("relativeQuantity", real.unit.relative.then_some(true))
                .with_some("min", real.min.map(Number))
                .with_some("max", real.max.map(Number))
                .with_some("nominal", real.nominal.map(Number))
                .with_some("start", set.then(|| Number((real.access.get)(initial)))),
            Kind::Integer { access, min, max } => tag
                .with_some("min", *min)
                .with_some("max", *max)
                .with_some("start", set.then(|| (access.get)(initial))),
            Kind::Boolean { access } => tag.with_some("start", set.then(|| (access.get)(initial))),
            Kind::Enumeration { access, of } => tag
                .with("declaredType", of.name)
                .with_some("start", set.then(|| (access.get)(initial))),
            Kind::String { access } if version == Version::Two => {
                tag.with_some("start", set.then(|| (access.get)(initial)))
            }
            Kind::String { .. } => tag,
        }
    };
    match &variable.kind {
        Kind::String { access } if set && version == Version::Three => {
            xml.open(typed(head.tag(of)));
            xml.leaf(Tag::new("Start").with("value", (access.get)(initial)));
            xml.close(of);
        }
        _ => head.write(xml, version, of, typed),
    }
}

/// The number by which a description refers to the first state. FMI 2.0 counts the variables as they are listed, from 1, then the
/// states and then their rates; FMI 3.0 takes value references.
fn first_state(version: Version, listed: usize) -> usize {
    match version {
        Version::Two => listed + 1,
        Version::Three => STATE as usize,
    }
}

/// Outputs and what they depend on, rates, and what is unknown at the start. Without a list of dependencies an unknown depends on
/// all that is known.
fn structure<M: Model>(xml: &mut Xml, version: Version, interface: Interface) {
    type Unknowns = Vec<(usize, Option<String>)>;
    let listed = listed::<M>(interface);
    let numbered =
        (listed.iter().enumerate()).map(|(place, (reference, variable))| match version {
            Version::Two => (place + 1, *variable),
            Version::Three => (*reference, *variable),
        });
    let count = states::<M>(interface).len();
    let first = first_state(version, listed.len());
    let states = first..first + count;
    let rates = match version {
        Version::Two => states.end..states.end + count,
        Version::Three => RATE as usize..RATE as usize + count,
    };
    let outputs =
        |known: fn(&Variable<M>, &Variable<M>) -> bool, states: Range<usize>| -> Unknowns {
            let outputs = (numbered.clone()).filter(|(_, variable)| variable.role == Role::Output);
            outputs
                .map(|(number, output)| {
                    let known = numbered.clone().filter(|(_, other)| known(output, other));
                    let numbers = known.map(|(number, _)| number).chain(states.clone());
                    let texts: Vec<_> = numbers.map(|number| number.to_string()).collect();
                    (number, Some(texts.join(" ")))
                })
                .collect()
        };
    let others = |numbers: &Range<usize>| numbers.clone().map(|number| (number, None));
    let inputs =
        |output: &Variable<M>, other: &Variable<M>| output.depends_on.contains(&other.name);
    let mut at_start = outputs(initially_known, 0..0);
    at_start.extend(others(&states).chain(others(&rates)));
    xml.open(Tag::new("ModelStructure"));
    for (group, element, unknowns) in [
        ("Outputs", "Output", outputs(inputs, states)),
        (
            "Derivatives",
            "ContinuousStateDerivative",
            others(&rates).collect(),
        ),
        ("InitialUnknowns", "InitialUnknown", at_start),
    ] {
        let (element, attribute) = match version {
            Version::Two => ("Unknown", "index"),
            Version::Three => (element, "valueReference"),
        };
        let grouped = version == Version::Two && !unknowns.is_empty();
        if grouped {
            xml.open(Tag::new(group));
        }
        for (number, dependencies) in unknowns {
            let tag = Tag::new(element).with(attribute, number);
            xml.leaf(tag.with_some("dependencies", dependencies));
        }
        if grouped {
            xml.close(group);
        }
    }
    xml.close("ModelStructure");
}
