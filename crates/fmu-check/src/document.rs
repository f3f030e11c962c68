//! `modelDescription.xml` as the rules see it: its elements with their lines, its variables in their order.

use std::{collections::HashMap, fmt::Display, ops::Deref};

use roxmltree::Node;

use crate::{combinations, hit::Hit};
pub(crate) use fmu_import::xml::{children as named, elements, tag};
use fmu_import::{Description, Version, description::About};

/// The name of the file.
pub const NAME: &str = "modelDescription.xml";

/// A model description, as it is written and as it was read.
pub struct Document<'a> {
    pub root: Node<'a, 'a>,
    /// The variables in their order, which `ModelStructure` counts; none where one cannot be read.
    pub scalars: Vec<Option<Scalar<'a>>>,
    /// The element of each type definition, in FMI 2.0 `Real` for instance, by its name.
    pub types: HashMap<&'a str, Node<'a, 'a>>,
    pub read: &'a Description,
    /// The first names of the variables, by what names of one variable share.
    pub aliases: HashMap<TypedReference<'a>, Firsts>,
    /// Where each line begins, bytes.
    lines: Vec<usize>,
}

/// The place of a value in the binary: the type of the calls that reach it, and its reference.
pub type TypedReference<'a> = (&'a str, &'a str);

/// What is looked for among the names of a variable.
pub enum Sort {
    Any,
    Settable,
    Independent,
    Started,
    WithUnit,
}

/// The position of the first name of each [`Sort`]: a variable may have a hundred thousand names, each of which asks.
pub type Firsts = [Option<usize>; 5];

/// Notes a further name of a variable.
fn note(firsts: &mut Firsts, scalar: Variable) {
    for sort in [Sort::Any, Sort::Settable, Sort::Independent, Sort::Started, Sort::WithUnit] {
        let is = match sort {
            Sort::Any => true,
            Sort::Settable => scalar.is_settable(),
            Sort::Independent => scalar.causality == "independent",
            Sort::Started => scalar.start().is_some(),
            Sort::WithUnit => scalar.effective("unit").is_some(),
        };
        let first = &mut firsts[sort as usize];
        *first = first.or(is.then_some(scalar.position));
    }
}

impl<'a> Document<'a> {
    pub fn new(root: Node<'a, 'a>, read: &'a Description) -> Self {
        let version = read.standard;
        let scalars: Vec<Option<Scalar<'a>>> = named(root, "ModelVariables")
            .flat_map(elements)
            .filter(|node| version == Version::Three || node.has_tag_name("ScalarVariable"))
            .enumerate()
            .map(|(position, node)| Scalar::new(version, node, position))
            .collect();
        let types = named(root, "TypeDefinitions").flat_map(elements);
        let typed = |node: Node<'a, 'a>| match version {
            Version::Two => elements(node).next().filter(|_| node.has_tag_name("SimpleType")),
            Version::Three => Some(node),
        };
        let types = types.filter_map(|node| Some((node.attribute("name")?, typed(node)?))).collect();
        let lines = starts_of_lines(root.document().input_text());
        let mut document = Self { root, scalars, types, read, aliases: HashMap::new(), lines };
        let mut aliases: HashMap<TypedReference<'a>, Firsts> = HashMap::new();
        for scalar in document.known() {
            if let Some(place) = scalar.place() {
                note(aliases.entry(place).or_default(), document.variable(scalar));
            }
        }
        document.aliases = aliases;
        document
    }

    /// Gives a finding its line.
    pub fn locate(&self, hit: &mut Hit) {
        if let Some(position) = hit.position {
            hit.line.get_or_insert(self.line(position));
        }
    }

    /// The remarks of the reader on a part of the description.
    pub fn remarks(&self, about: About) -> Vec<Hit> {
        self.read
            .remarks
            .iter()
            .filter(|remark| remark.about == about)
            .map(|remark| Hit { line: Some(remark.line), ..Hit::of(NAME, remark.text.clone()) })
            .collect()
    }

    /// The line of a position, from 1.
    pub fn line(&self, position: usize) -> usize {
        self.lines.partition_point(|start| *start <= position)
    }

    /// The variables that can be read.
    pub fn known(&self) -> impl Iterator<Item = &Scalar<'a>> {
        self.scalars.iter().flatten()
    }

    /// A finding at each variable where `wrong` says something.
    pub fn of_each(&self, wrong: impl Fn(Variable) -> Option<String>) -> Vec<Hit> {
        self.known().filter_map(|scalar| Some(scalar.finding(wrong(self.variable(scalar))?))).collect()
    }

    /// One of its variables.
    pub fn variable<'s>(&'s self, scalar: &'s Scalar<'a>) -> Variable<'s> {
        Variable { scalar, document: self }
    }

    /// All elements of one kind within the lists of another.
    pub fn all(&self, list: &'static str, of: &'static str) -> impl Iterator<Item = Node<'a, 'a>> + use<'a> {
        named(self.root, list).flat_map(move |list| named(list, of))
    }

    /// The fault of a unit that is not defined.
    pub fn undefined_unit(&self, unit: &str) -> Option<String> {
        self.read
            .units
            .0
            .get(unit)
            .is_none()
            .then(|| format!("unit \"{unit}\" is not defined: add it to UnitDefinitions"))
    }
}

/// A variable within its document.
#[derive(Clone, Copy)]
pub struct Variable<'a> {
    scalar: &'a Scalar<'a>,
    pub document: &'a Document<'a>,
}

impl<'a> Deref for Variable<'a> {
    type Target = Scalar<'a>;

    fn deref(&self) -> &Scalar<'a> {
        self.scalar
    }
}

impl<'a> Variable<'a> {
    /// The same as it was read.
    pub fn read(&self) -> Option<&'a fmu_import::Variable> {
        self.document.read.variables.get(self.name)
    }

    /// The definition of its declared type.
    pub fn declared(&self) -> Option<Node<'a, 'a>> {
        let name = self.typed.attribute("declaredType")?;
        self.document.types.get(name).copied()
    }

    /// An attribute of its type: its own, or else that of its declared type.
    pub fn effective(&self, name: &str) -> Option<&'a str> {
        self.typed.attribute(name).or_else(|| self.declared()?.attribute(name))
    }
}

fn starts_of_lines(text: &str) -> Vec<usize> {
    let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    std::iter::once(0).chain(ends.map(|(at, _)| at + 1)).collect()
}

/// A finding at an element.
pub fn at(node: Node, text: impl Into<String>) -> Hit {
    Hit { position: Some(node.range().start), ..Hit::of(NAME, text) }
}

/// A variable as it is written.
pub struct Scalar<'a> {
    pub node: Node<'a, 'a>,
    /// The element of its type: in FMI 2.0 `Real` for instance, in FMI 3.0 that of the variable.
    pub typed: Node<'a, 'a>,
    /// Its place among the variables, from 0.
    pub position: usize,
    pub name: &'a str,
    pub causality: &'a str,
    pub variability: &'a str,
    /// As written, or as the standard has it for the causality and variability; empty where there is none.
    pub initial: &'a str,
}

impl<'a> Scalar<'a> {
    fn new(version: Version, node: Node<'a, 'a>, position: usize) -> Option<Self> {
        let types = ["Real", "Integer", "Boolean", "String", "Enumeration"];
        let typed = match version {
            Version::Two => elements(node).find(|child| types.contains(&tag(*child)))?,
            Version::Three => node,
        };
        let causality = node.attribute("causality").unwrap_or("local");
        let usual = match (causality, tag(typed)) {
            ("parameter" | "calculatedParameter" | "structuralParameter", _) if version == Version::Three => "fixed",
            (_, "Real" | "Float32" | "Float64") => "continuous",
            // The default of FMI 2.0 is continuous, which only a Real can be; tools mean discrete.
            _ => "discrete",
        };
        let variability = node.attribute("variability").unwrap_or(usual);
        let initials = combinations::initials(version, causality, variability);
        let default = match initials {
            [usual, ..] if version == Version::Two || combinations::are_known(version, causality, variability) => usual,
            _ => "",
        };
        Some(Self {
            node,
            typed,
            position,
            name: node.attribute("name").unwrap_or("a variable without a name"),
            causality,
            variability,
            initial: node.attribute("initial").unwrap_or(default),
        })
    }

    /// The name of its type, such as `Real` or `Float64`.
    pub fn kind(&self) -> &'a str {
        tag(self.typed)
    }

    /// Where its value is; enumerations are integers to calls.
    pub fn place(&self) -> Option<TypedReference<'a>> {
        let base = match self.kind() {
            "Enumeration" => "Integer",
            kind => kind,
        };
        Some((base, self.node.attribute("valueReference")?.trim()))
    }

    pub fn is_float(&self) -> bool {
        matches!(self.kind(), "Real" | "Float32" | "Float64")
    }

    pub fn start(&self) -> Option<&'a str> {
        self.typed.attribute("start")
    }

    /// Whether an importer may set it freely.
    pub fn is_settable(&self) -> bool {
        matches!(self.causality, "parameter" | "input")
    }

    /// A finding at this variable.
    pub fn finding(&self, text: impl Display) -> Hit {
        at(self.node, format!("{}: {text}", self.name))
    }
}
