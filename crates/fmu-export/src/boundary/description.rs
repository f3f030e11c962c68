//! The model description, `modelDescription.xml`, written from the model's variable table: the same content in the forms of all
//! versions.

use std::{any::TypeId, fmt, ops::Range, sync::OnceLock};

use super::{
    describe::{
        convention, depends, enumerations, experiment, hash, initially_known, listed, log_categories, origin, states,
        units,
    },
    exchange::{RATE, STATE},
    types::ValueReference,
    values::TIME,
    watch::is_intermediate,
    xml::{Number, Tag, Xml},
};
use crate::model::{Kind, Model, Role, Variable, indicators, named, offered};

pub use super::{
    describe::{Interface, token},
    version::Version,
};

/// The text of `modelDescription.xml`.
pub fn xml<M: Model>(version: Version, interface: Interface) -> String {
    let token = token(fingerprint::<M>(version, interface));
    with_token::<M>(version, interface, &token)
}

/// A hash of the whole description, token apart: binaries with the same fingerprint have the same description.
pub fn fingerprint<M: Model>(version: Version, interface: Interface) -> u128 {
    /// Of the model that came first, by version and interface: a library has one, and to write its description takes longer than
    /// a short simulation.
    static FIRST: [[OnceLock<(TypeId, u128)>; 2]; 2] = [const { [const { OnceLock::new() }; 2] }; 2];
    let written = || hash(&with_token::<M>(version, interface, ""));
    let first = &FIRST[usize::from(version == Version::Three)][usize::from(interface == Interface::ModelExchange)];
    match first.get_or_init(|| (TypeId::of::<M>(), written())) {
        (model, fingerprint) if *model == TypeId::of::<M>() => *fingerprint,
        _ => written(),
    }
}

fn with_token<M: Model>(version: Version, interface: Interface, token: &str) -> String {
    let mut xml = Xml::new();
    let info = M::INFO;
    let (number, token_name) = match version {
        Version::Two => ("2.0", "guid"),
        Version::Three => ("3.0", "instantiationToken"),
    };
    let root =
        Tag::new("fmiModelDescription").with("fmiVersion", number).with("modelName", info.name).with(token_name, token);
    let indicators = watched::<M>(interface).len();
    let counted = version == Version::Two && indicators > 0;
    xml.open(
        origin(root, &info)
            .with("variableNamingConvention", convention::<M>())
            .with_some("numberOfEventIndicators", counted.then_some(indicators)),
    );
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
    let sloped = (M::variables().iter()).any(|v| matches!(&v.kind, Kind::Real(real) if real.slope.is_some()));
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

/// All that can be done, and nothing that cannot: a model without inner steps and events is stepped through without a stop.
fn co_simulation_3<M: Model>() -> Tag {
    let (inner, events) = (M::INNER_STEP.is_some(), M::EVENTS.is_some());
    Tag::new("CoSimulation")
        .with("modelIdentifier", M::INFO.identifier)
        .with("canGetAndSetFMUState", true)
        .with("canSerializeFMUState", true)
        .with("providesDirectionalDerivatives", true)
        .with("providesAdjointDerivatives", true)
        .with("canHandleVariableCommunicationStepSize", true)
        .with("maxOutputDerivativeOrder", 1)
        .with("providesIntermediateUpdate", inner)
        .with("mightReturnEarlyFromDoStep", inner || events)
        .with("canReturnEarlyAfterIntermediateUpdate", inner)
        .with("hasEventMode", events)
}

/// The host need not tell of completed steps that change nothing.
fn model_exchange<M: Model>(version: Version) -> Tag {
    let tag = Tag::new("ModelExchange").with("modelIdentifier", M::INFO.identifier);
    let completes = offered::<M>().is_some_and(|exchange| exchange.complete.is_some());
    match version {
        Version::Two => tag
            .with("completedIntegratorStepNotNeeded", !completes)
            .with("canNotUseMemoryManagementFunctions", true)
            .with("canGetAndSetFMUstate", true)
            .with("canSerializeFMUstate", true),
        Version::Three => tag
            .with("canGetAndSetFMUState", true)
            .with("canSerializeFMUState", true)
            .with("needsCompletedIntegratorStep", completes),
    }
}

/// The event indicators that the host watches: none in Co-Simulation.
fn watched<M: Model>(interface: Interface) -> &'static [&'static str] {
    match interface {
        Interface::CoSimulation => &[],
        Interface::ModelExchange => indicators::<M>(),
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
    let listed = listed::<M>(version, interface);
    xml.open(Tag::new("ModelVariables"));
    if version == Version::Three {
        independent::<M>(xml);
    }
    for (reference, elements) in &listed {
        let variable = &elements[0];
        let changing = match variable.kind {
            Kind::Real(_) if variable.clock.is_none() => "continuous",
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
            name: match version {
                Version::Two => variable.name,
                Version::Three => variable.array_name(),
            },
            reference: *reference,
            description: variable.description,
            causality,
            variability,
            initial: first.filter(|_| !matches!(variable.kind, Kind::Clock { .. })),
        };
        describe(xml, (version, interface), &head, elements, &initial);
    }
    let (real, states) = (version.real(), states::<M>(interface));
    for (reference, state) in (STATE..).zip(states) {
        Head::local(state.name, reference, state.description)
            .write(xml, version, real, |tag| tag.with("unit", state.unit.name).with("nominal", Number(state.nominal)));
    }
    let first = first_state(version, listed.len());
    for ((reference, of), state) in (RATE..).zip(first..).zip(states) {
        let name = format!("der({})", state.name);
        let description = format!("Rate of: {}", state.description);
        Head::local(&name, reference, &description)
            .write(xml, version, real, |tag| tag.with("unit", state.rate_unit.name).with("derivative", of));
    }
    xml.close("ModelVariables");
}

/// The independent variable, which FMI 3.0 lists. A model that has a variable called `time` keeps the name.
fn independent<M: Model>(xml: &mut Xml) {
    let name = ["time", "independentTime"].into_iter().find(|name| named::<M>(name).is_none());
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

/// The values of a variable's elements in a model, with spaces between them.
struct Starts<'a, M: 'static>(&'a [Variable<M>], &'a M);

impl<M> fmt::Display for Starts<'_, M> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for (place, variable) in self.0.iter().enumerate() {
            if place > 0 {
                f.write_str(" ")?;
            }
            match &variable.kind {
                Kind::Real(real) => Number((real.access.get)(self.1)).fmt(f)?,
                Kind::Integer { access, .. } | Kind::Enumeration { access, .. } => {
                    (access.get)(self.1).fmt(f)?;
                }
                Kind::Boolean { access } => (access.get)(self.1).fmt(f)?,
                Kind::String { access } => (access.get)(self.1).fmt(f)?,
                Kind::Clock { .. } => {}
            }
        }
        Ok(())
    }
}

/// One variable of the table, or an array of several. It has start values if the host may set it, which are elements of their own
/// for texts in FMI 3.0.
fn describe<M: Model>(
    xml: &mut Xml,
    (version, interface): (Version, Interface),
    head: &Head,
    elements: &[Variable<M>],
    initial: &M,
) {
    let (variable, three) = (&elements[0], version == Version::Three);
    let set = !matches!(variable.role, Role::Output | Role::Local);
    let of = version.type_name(variable);
    let texts = set && three && matches!(variable.kind, Kind::String { .. });
    let intermediate = three && interface == Interface::CoSimulation && is_intermediate(variable);
    let clock =
        variable.clock.filter(|_| three).and_then(|clock| M::variables().iter().position(|other| other.name == clock));
    let typed = |tag: Tag| {
        let tag = tag.with_some("intermediateUpdate", intermediate.then_some(true)).with_some("clocks", clock);
        let tag = match &variable.kind {
            Kind::Real(real) => tag
                .with("unit", real.unit.name)
                .with_some("displayUnit", real.display)
                .with_some("relativeQuantity", real.unit.relative.then_some(true))
                .with_some("min", real.min.map(Number))
                .with_some("max", real.max.map(Number))
                .with_some("nominal", real.nominal.map(Number)),
            Kind::Integer { min, max, .. } => tag.with_some("min", *min).with_some("max", *max),
            Kind::Enumeration { of, .. } => tag.with("declaredType", of.name),
            Kind::Clock { .. } => tag.with("intervalVariability", "triggered"),
            Kind::Boolean { .. } | Kind::String { .. } => tag,
        };
        let starts = (set && !texts).then_some(Starts(elements, initial));
        tag.with_some("start", starts)
    };
    if !texts && elements.len() == 1 {
        return head.write(xml, version, of, typed);
    }
    xml.open(typed(head.tag(of)));
    if elements.len() > 1 {
        xml.leaf(Tag::new("Dimension").with("start", elements.len()));
    }
    for element in elements.chunks(1).filter(|_| texts) {
        xml.leaf(Tag::new("Start").with("value", Starts(element, initial)));
    }
    xml.close(of);
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
    type MayDepend<M> = fn(&[Variable<M>], &[Variable<M>]) -> bool;
    let listed = listed::<M>(version, interface);
    let numbered = (listed.iter().enumerate()).map(|(place, (reference, variable))| match version {
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
    let outputs = |known: MayDepend<M>, states: Range<usize>| -> Unknowns {
        (numbered.clone())
            .filter(|(_, one)| one[0].role == Role::Output)
            .map(|(number, output)| {
                let texts: Vec<_> = numbered
                    .clone()
                    .filter(|(_, other)| known(output, other))
                    .map(|(number, _)| number)
                    .chain(states.clone())
                    .map(|number| number.to_string())
                    .collect();
                (number, Some(texts.join(" ")))
            })
            .collect()
    };
    let others = |numbers: &Range<usize>| numbers.clone().map(|number| (number, None));
    let mut at_start = outputs(initially_known, 0..0);
    if version == Version::Three {
        at_start.retain(|(place, _)| M::variables()[*place].clock.is_none());
    }
    at_start.extend(others(&states).chain(others(&rates)));
    let watched =
        (watched::<M>(interface).iter()).filter_map(|name| numbered.clone().find(|(_, one)| one[0].name == *name));
    let watched = (watched.filter(|_| version == Version::Three)).map(|(number, _)| (number, None));
    xml.open(Tag::new("ModelStructure"));
    for (group, element, unknowns) in [
        ("Outputs", "Output", outputs(depends, states)),
        ("Derivatives", "ContinuousStateDerivative", others(&rates).collect()),
        ("InitialUnknowns", "InitialUnknown", at_start),
        ("", "EventIndicator", watched.collect()),
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
