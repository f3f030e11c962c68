//! `modelDescription.xml` as the rules see it: its elements with their lines, its variables in their order.

use roxmltree::Node;

/// A finding at an element.
pub(super) fn at(node: Node<'_, '_>, text: &str) -> String {
    let before = &node.document().input_text().as_bytes()[..node.range().start];
    let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
    format!("modelDescription.xml, line {line}: {text}")
}

/// The child elements; those of foreign namespaces don't count.
pub(super) fn elements<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children()
        .filter(|child| child.is_element() && child.tag_name().namespace().is_none())
}

/// The child elements of this name.
pub(super) fn named<'a>(
    node: Node<'a, 'a>,
    name: &'static str,
) -> impl Iterator<Item = Node<'a, 'a>> {
    elements(node).filter(move |child| child.tag_name().name() == name)
}

/// A variable as it is written.
#[derive(Clone, Copy)]
pub(super) struct Scalar<'a> {
    pub(super) node: Node<'a, 'a>,
    /// The element of its type, `Real` for instance.
    pub(super) typed: Node<'a, 'a>,
    pub(super) name: &'a str,
    pub(super) causality: &'a str,
    pub(super) variability: &'a str,
    /// As written, or as the standard has it for the causality and variability; empty where there is none.
    pub(super) initial: &'a str,
}

impl<'a> Scalar<'a> {
    fn new(node: Node<'a, 'a>) -> Option<Self> {
        let types = ["Real", "Integer", "Boolean", "String", "Enumeration"];
        let typed = elements(node).find(|child| types.contains(&child.tag_name().name()))?;
        let causality = node.attribute("causality").unwrap_or("local");
        // The standard's default is continuous, which only a Real can be; tools mean discrete.
        let otherwise = match typed.tag_name().name() {
            "Real" => "continuous",
            _ => "discrete",
        };
        let variability = node.attribute("variability").unwrap_or(otherwise);
        let default = match (causality, variability) {
            ("input" | "independent", _) => "",
            ("parameter", _) | (_, "constant") => "exact",
            _ => "calculated",
        };
        Some(Self {
            node,
            typed,
            name: node
                .attribute("name")
                .unwrap_or("a variable without a name"),
            causality,
            variability,
            initial: node.attribute("initial").unwrap_or(default),
        })
    }

    /// `Real`, `Integer`, `Boolean`, `String` or `Enumeration`.
    pub(super) fn kind(&self) -> &'a str {
        self.typed.tag_name().name()
    }

    pub(super) fn start(&self) -> Option<&'a str> {
        self.typed.attribute("start")
    }

    /// A finding at this variable.
    pub(super) fn finding(&self, text: &str) -> String {
        at(self.node, &format!("{}: {text}", self.name))
    }
}

/// The variables in their order, which `ModelStructure` counts; none where one cannot be read.
pub(super) fn scalars<'a>(root: Node<'a, 'a>) -> Vec<Option<Scalar<'a>>> {
    named(root, "ModelVariables")
        .flat_map(|list| named(list, "ScalarVariable"))
        .map(Scalar::new)
        .collect()
}
