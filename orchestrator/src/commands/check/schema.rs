//! The elements and attributes of `modelDescription.xml` (FMI 2.0.4, sections 2.2 and 4.3.1): what is none of
//! them is a typing error, or belongs into an annotation.

use roxmltree::Node;

use super::document::{at, elements};
use crate::names::{did_you_mean, nearest};

/// An element: its name, with its parent's where it has several; its attributes and its children. Those that must
/// be there are marked by `!`, unless the reader remarks on them itself.
type Element = (&'static str, &'static str, &'static str);

const ELEMENTS: [Element; 32] = [
    (
        "fmiModelDescription",
        "fmiVersion modelName! guid! description author version copyright license generationTool \
         generationDateAndTime variableNamingConvention numberOfEventIndicators",
        "ModelExchange CoSimulation UnitDefinitions TypeDefinitions LogCategories DefaultExperiment \
         VendorAnnotations ModelVariables! ModelStructure!",
    ),
    (
        "ModelExchange",
        "modelIdentifier! needsExecutionTool completedIntegratorStepNotNeeded \
         canBeInstantiatedOnlyOncePerProcess canNotUseMemoryManagementFunctions canGetAndSetFMUstate \
         canSerializeFMUstate providesDirectionalDerivative",
        "SourceFiles",
    ),
    (
        "CoSimulation",
        "modelIdentifier! needsExecutionTool canHandleVariableCommunicationStepSize canInterpolateInputs \
         maxOutputDerivativeOrder canRunAsynchronuously canBeInstantiatedOnlyOncePerProcess \
         canNotUseMemoryManagementFunctions canGetAndSetFMUstate canSerializeFMUstate \
         providesDirectionalDerivative",
        "SourceFiles",
    ),
    ("SourceFiles", "", "File"),
    ("File", "name!", ""),
    ("UnitDefinitions", "", "Unit"),
    ("Unit", "name", "BaseUnit DisplayUnit"),
    ("BaseUnit", "kg m s A K mol cd rad factor offset", ""),
    ("DisplayUnit", "name! factor offset", ""),
    ("TypeDefinitions", "", "SimpleType"),
    (
        "SimpleType",
        "name! description",
        "Real Integer Boolean String Enumeration",
    ),
    (
        "SimpleType/Real",
        "quantity unit displayUnit relativeQuantity min max nominal unbounded",
        "",
    ),
    ("SimpleType/Integer", "quantity min max", ""),
    ("SimpleType/Boolean", "", ""),
    ("SimpleType/String", "", ""),
    ("SimpleType/Enumeration", "quantity", "Item"),
    ("Item", "name! value! description", ""),
    ("LogCategories", "", "Category"),
    ("Category", "name! description", ""),
    (
        "DefaultExperiment",
        "startTime stopTime tolerance stepSize",
        "",
    ),
    ("VendorAnnotations", "", "Tool"),
    ("ModelVariables", "", "ScalarVariable"),
    (
        "ScalarVariable",
        "name valueReference description causality variability initial canHandleMultipleSetPerTimeInstant",
        "Real Integer Boolean String Enumeration Annotations",
    ),
    (
        "ScalarVariable/Real",
        "declaredType quantity unit displayUnit relativeQuantity min max nominal unbounded start derivative reinit",
        "",
    ),
    (
        "ScalarVariable/Integer",
        "declaredType quantity min max start",
        "",
    ),
    ("ScalarVariable/Boolean", "declaredType start", ""),
    ("ScalarVariable/String", "declaredType start", ""),
    (
        "ScalarVariable/Enumeration",
        "declaredType! quantity min max start",
        "",
    ),
    ("Annotations", "", "Tool"),
    // Anything may be in it.
    ("Tool", "name", "*"),
    ("ModelStructure", "", "Outputs Derivatives InitialUnknowns"),
    ("Unknown", "index! dependencies dependenciesKind", ""),
];

/// The three lists of `ModelStructure`.
const UNKNOWNS: Element = ("", "", "Unknown");

fn element(parent: &str, name: &str) -> Option<Element> {
    if parent == "ModelStructure" {
        return Some(UNKNOWNS);
    }
    let found = |wanted: &str| ELEMENTS.into_iter().find(|(known, ..)| *known == wanted);
    found(&format!("{parent}/{name}")).or_else(|| found(name))
}

/// Elements of which there may be many beside each other.
const MANY: [&str; 9] = [
    "File",
    "Unit",
    "DisplayUnit",
    "SimpleType",
    "Item",
    "Category",
    "Tool",
    "ScalarVariable",
    "Unknown",
];

/// All that is in the document but not in the standard, and what the standard wants but is not there.
pub(super) fn broken(root: Node<'_, '_>) -> Vec<String> {
    let mut findings = Vec::new();
    if let Some(space) = root.tag_name().namespace() {
        let text =
            format!("the namespace \"{space}\": the elements of FMI 2.0 have none, remove it");
        findings.push(at(root, &text));
    }
    visit(root, "", &mut findings);
    findings
}

fn visit(node: Node<'_, '_>, parent: &str, findings: &mut Vec<String>) {
    let name = node.tag_name().name();
    let Some((_, attributes, children)) = element(parent, name) else {
        return;
    };
    let known = |list: &'static str| list.split(' ').map(|word| word.trim_end_matches('!'));
    let missing = |list: &'static str| list.split(' ').filter_map(|word| word.strip_suffix('!'));
    let own = node.attributes().filter(|a| a.namespace().is_none());
    for attribute in own.map(|attribute| attribute.name()) {
        if known(attributes).all(|known| known != attribute) {
            let meant = did_you_mean(nearest(attribute, known(attributes)));
            let text =
                format!("`{name}` has no attribute `{attribute}` in FMI 2.0: remove it{meant}");
            findings.push(at(node, &text));
        }
    }
    for attribute in missing(attributes).filter(|attribute| !node.has_attribute(*attribute)) {
        findings.push(at(
            node,
            &format!("`{name}` needs the attribute `{attribute}`: add it"),
        ));
    }
    if children == "*" {
        return;
    }
    for wanted in missing(children) {
        if elements(node).all(|child| child.tag_name().name() != wanted) {
            findings.push(at(
                node,
                &format!("`{name}` needs the element `{wanted}`: add it"),
            ));
        }
    }
    findings.extend(disordered(node, &Vec::from_iter(known(children))));
    for child in elements(node) {
        let inner = child.tag_name().name();
        if known(children).any(|known| known == inner) {
            visit(child, name, findings);
        } else {
            let meant = did_you_mean(nearest(inner, known(children)));
            let text = format!(
                "`{name}` has no element `{inner}` in FMI 2.0: remove it, or put it into an annotation{meant}"
            );
            findings.push(at(child, &text));
        }
    }
}

/// The first child that comes after one that it must come before, or comes a second time.
fn disordered(node: Node<'_, '_>, order: &[&str]) -> Option<String> {
    let mut last: Option<usize> = None;
    elements(node).find_map(|child| {
        let name = child.tag_name().name();
        let place = order.iter().position(|known| *known == name)?;
        let wrong = match last {
            Some(before) if place < before => {
                format!("`{name}` after `{}`: put it before that", order[before])
            }
            Some(before) if place == before && !MANY.contains(&name) => {
                format!("a second `{name}`: put all into the first one")
            }
            _ => {
                last = Some(place);
                return None;
            }
        };
        Some(at(child, &wrong))
    })
}
