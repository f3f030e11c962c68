//! The parts of `modelDescription.xml` that FMI 2.0 writes in its own way: types, variables, and the sizes of Model Exchange.

use std::collections::HashSet;

use roxmltree::Node;

use crate::{
    description::{About, Description, ExchangeSizes, Kind, Variable},
    parse::{Reader, Types},
    xml::{child, children, within},
};

impl Reader {
    /// The variables of FMI 2.0.
    pub fn variables_of_two(&mut self, root: Node, into: &mut Description) {
        let types: Types = within(root, "TypeDefinitions", "SimpleType")
            .filter_map(|node| Some((node.attribute("name")?, typed(node)?)))
            .collect();
        for node in within(root, "ModelVariables", "ScalarVariable") {
            if let Some(variable) = self.variable_of_two(node, &types) {
                self.add(node, variable, into);
            }
        }
    }

    fn variable_of_two(&mut self, node: Node, types: &Types) -> Option<Variable> {
        let name = self.name(node)?;
        let value_reference = self.reference(node, &name)?;
        let Some(element) = typed(node) else {
            self.remark(node, About::Variable, format!("`{name}` has no type and is left out"));
            return None;
        };
        let declared = element.attribute("declaredType").and_then(|name| types.get(name));
        let mut kind = self.kind(element, declared.copied(), None);
        match &mut kind {
            Kind::Real { start, .. } => *start = self.number(element, "start"),
            Kind::Integer { start, .. } | Kind::Enumeration { start, .. } => {
                *start = self.number::<i32>(element, "start").map(i128::from);
            }
            Kind::Boolean { start } => *start = self.boolean(element, "start"),
            Kind::String { start } => *start = element.attribute("start").map(str::to_owned),
            Kind::Clock(_) => {}
        }
        Some(Variable {
            name,
            line: self.line(node),
            value_reference,
            place: None,
            description: node.attribute("description").map(str::to_owned),
            causality: self.choice(node, "causality"),
            variability: self.choice(node, "variability"),
            clocks: Vec::new(),
            kind,
        })
    }

    /// The declarations of Model Exchange beside its capabilities.
    pub fn exchange_of_two(&mut self, root: Node, node: Node) -> ExchangeSizes {
        let structure = child(root, "ModelStructure");
        let listed = structure
            .and_then(|structure| child(structure, "Derivatives"))
            .map_or(0, |list| children(list, "Unknown").count());
        // Without its states an FMU would stand still and look well.
        let states = if listed == 0 { rates(root) } else { listed };
        if states > listed {
            self.remark(
                root,
                About::Value,
                format!(
                    "ModelStructure lists no derivatives; the {states} variables with the attribute derivative count"
                ),
            );
        }
        ExchangeSizes {
            states,
            indicators: self.number(root, "numberOfEventIndicators").unwrap_or(0),
            completed_not_needed: self.boolean(node, "completedIntegratorStepNotNeeded").unwrap_or(false),
            even_steps: false,
        }
    }
}

/// How many variables are derivatives; aliases share a reference and count once.
fn rates(root: Node) -> usize {
    let references: HashSet<_> = within(root, "ModelVariables", "ScalarVariable")
        .filter(|node| child(*node, "Real").is_some_and(|real| real.has_attribute("derivative")))
        .map(|node| node.attribute("valueReference"))
        .collect();
    references.len()
}

/// The element that carries the type's attributes.
fn typed<'a>(node: Node<'a, 'a>) -> Option<Node<'a, 'a>> {
    ["Real", "Integer", "Boolean", "String", "Enumeration"].iter().find_map(|name| child(node, name))
}
