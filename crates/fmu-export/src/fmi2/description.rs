//! The model description, generated from the model's variable table.

use std::fmt::{self, Display, Write};

use super::logger::categories;
use super::values::type_name;
use crate::model::{DisplayUnit, Enumeration, Kind, Model, Role, Unit, Variable};

/// `modelDescription.xml`.
pub fn xml<M: Model>() -> String {
    with_guid::<M>(&guid(fingerprint::<M>()))
}

/// A number for the variable table and all else that the description says: two binaries with the
/// same fingerprint have the same description. FNV-1a of 128 bits (Fowler, Noll and Vo, 1991).
pub fn fingerprint<M: Model>() -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    with_guid::<M>("").bytes().fold(BASIS, |hash, byte| {
        (hash ^ u128::from(byte)).wrapping_mul(PRIME)
    })
}

/// The GUID of a fingerprint.
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
    let mut xml = Xml {
        text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
        depth: 0,
    };
    let info = M::INFO;
    xml.open(
        Tag::new("fmiModelDescription")
            .with("fmiVersion", "2.0")
            .with("modelName", info.name)
            .with("guid", guid)
            .with("description", info.description)
            .with("version", env!("CARGO_PKG_VERSION"))
            .with("license", env!("CARGO_PKG_LICENSE"))
            .with(
                "generationTool",
                concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")),
            )
            .with("variableNamingConvention", "structured"),
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
    xml.text
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

fn units<M: Model>(xml: &mut Xml) {
    let mut units: Vec<&Unit> = Vec::new();
    for variable in M::variables() {
        if let Kind::Real { unit, .. } = variable.kind
            && units.iter().all(|other| other.name != unit.name)
        {
            units.push(unit);
        }
    }
    if units.is_empty() {
        return;
    }
    xml.open(Tag::new("UnitDefinitions"));
    for unit in units {
        xml.open(Tag::new("Unit").with("name", unit.name));
        let mut base = Tag::new("BaseUnit");
        for (name, exponent) in ["kg", "m", "s", "K", "rad"].into_iter().zip(unit.exponents) {
            base = base.with_some(name, (exponent != 0).then_some(exponent));
        }
        xml.leaf(base);
        for DisplayUnit {
            name,
            factor,
            offset,
        } in unit.display
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
    for variable in M::variables() {
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

fn variables<M: Model>(xml: &mut Xml) {
    let initial = M::default();
    xml.open(Tag::new("ModelVariables"));
    for (index, variable) in M::variables().iter().enumerate() {
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
                .with("valueReference", index)
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

/// The element of a variable's type; with the start value, where the host may set one.
fn typed<M: Model>(variable: &Variable<M>, initial: &M) -> Tag {
    let set = !matches!(variable.role, Role::Output | Role::Local);
    let tag = Tag::new(type_name(variable));
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
    let table = M::variables();
    let outputs = || {
        table
            .iter()
            .enumerate()
            .filter(|(_, v)| v.role == Role::Output)
    };
    xml.open(Tag::new("ModelStructure"));
    if outputs().next().is_some() {
        xml.open(Tag::new("Outputs"));
        for (index, variable) in outputs() {
            let known = |name: &str| variable.depends_on.contains(&name);
            xml.leaf(unknown(index, |_, v: &Variable<M>| known(v.name), table));
        }
        xml.close("Outputs");
        // At the start, outputs may depend on parameters too. On no more inputs than later: hosts
        // that couple FMUs take each one for a part of a loop that must be solved.
        xml.open(Tag::new("InitialUnknowns"));
        for (index, variable) in outputs() {
            let known = |v: &Variable<M>| match v.role {
                Role::Input => variable.depends_on.contains(&v.name),
                Role::Parameter | Role::TunableParameter => true,
                Role::Output | Role::Local => false,
            };
            xml.leaf(unknown(index, |_, v| known(v), table));
        }
        xml.close("InitialUnknowns");
    }
    xml.close("ModelStructure");
}

/// An `Unknown` with the variables on which it depends. Indices count from 1.
fn unknown<M>(
    index: usize,
    depends: impl Fn(usize, &Variable<M>) -> bool,
    table: &[Variable<M>],
) -> Tag {
    let dependencies = table
        .iter()
        .enumerate()
        .filter(|(index, variable)| depends(*index, variable))
        .map(|(index, _)| (index + 1).to_string())
        .collect::<Vec<_>>();
    Tag::new("Unknown")
        .with("index", index + 1)
        .with("dependencies", dependencies.join(" "))
}

/// A real number as `xs:double` writes it, with all its digits.
struct Number(f64);

impl Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

/// A start tag in the making.
struct Tag(String);

impl Tag {
    fn new(name: &str) -> Self {
        Self(name.to_owned())
    }

    fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0
            .push_str(&format!(" {name}=\"{}\"", escaped(&value.to_string())));
        self
    }

    fn with_some(self, name: &str, value: Option<impl Display>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }
}

/// A document in the making.
struct Xml {
    text: String,
    depth: usize,
}

impl Xml {
    fn line(&mut self, line: impl Display) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{:1$}{line}", "", 2 * self.depth);
    }

    fn open(&mut self, tag: Tag) {
        self.line(format_args!("<{}>", tag.0));
        self.depth += 1;
    }

    fn leaf(&mut self, tag: Tag) {
        self.line(format_args!("<{}/>", tag.0));
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.line(format_args!("</{name}>"));
    }
}

fn escaped(text: &str) -> String {
    text.chars()
        .fold(String::with_capacity(text.len()), |mut out, character| {
            match character {
                '&' => out.push_str("&amp;"),
                '<' => out.push_str("&lt;"),
                '>' => out.push_str("&gt;"),
                '"' => out.push_str("&quot;"),
                '\n' => out.push_str("&#10;"),
                '\t' => out.push_str("&#9;"),
                _ => out.push(character),
            }
            out
        })
}
