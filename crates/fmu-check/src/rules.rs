//! All rules of a check, a line each. A new rule is a function and a line here.

use fmu_import::Version;
use fmu_import::description::About;

use crate::definitions::alike;
use crate::finding::Find::{Document, Each, Either, Elsewhere, Remark, Three, Variable};
use crate::finding::Severity::{Error, Note, Warning};
use crate::finding::{Find, Rule, Severity};
use crate::values::positive;
use crate::{aliases, definitions, dependencies, names, schema, structure, three, values, variables};

const fn rule(id: &'static str, severity: Severity, source: &'static str, wants: &'static str, find: Find) -> Rule {
    Rule { id, severity, source, wants, find }
}

const XML: &str = "XML 1.0, 4.3.3";
const MODEL: &str = "fmi2ModelDescription.xsd";
const SCALAR: &str = "fmi2ScalarVariable.xsd";
const TYPE: &str = "fmi2Type.xsd";

/// The rule of this name, which one of the files of this crate writes.
pub(crate) fn named(id: &str) -> &'static Rule {
    let rule = RULES.iter().find(|rule| rule.id == id);
    rule.unwrap_or_else(|| panic!("there is no rule `{id}`"))
}

impl Rule {
    /// Where it stands in a version of the standard.
    pub fn source_in(&self, version: Version) -> &'static str {
        match (version, self.source) {
            (Version::Two, own) => own,
            (_, MODEL) => "fmi3ModelDescription.xsd",
            (_, SCALAR) => "fmi3Variable.xsd",
            (_, TYPE) => "fmi3Type.xsd",
            (_, "FMI 2.0.5, 2.1.1") => "FMI 3.0.2, 2.2.2",
            (_, "FMI 2.0.5, 2.1.3") => "FMI 3.0.2, 2.2.4",
            (_, "FMI 2.0.5, 2.1.4") => "FMI 3.0.2, 2.2.5",
            (_, "FMI 2.0.5, 2.1.5" | "FMI 2.0.5, 2.1.6") => "FMI 3.0.2, 2.3.1",
            (_, "FMI 2.0.5, 2.2") => "FMI 3.0.2, 2.4",
            (_, "FMI 2.0.5, 2.2.1") => "FMI 3.0.2, 2.4.1",
            (_, "FMI 2.0.5, 2.2.2") => "FMI 3.0.2, 2.4.3",
            (_, "FMI 2.0.5, 2.2.3") => "FMI 3.0.2, 2.4.4",
            (_, "FMI 2.0.5, 2.2.4") => "FMI 3.0.2, 2.4.5",
            (_, "FMI 2.0.5, 2.2.5") => "FMI 3.0.2, 2.4.6",
            (_, "FMI 2.0.5, 2.2.7" | "FMI 2.0.5, 2.2.9") => "FMI 3.0.2, 2.4.7",
            (_, "FMI 2.0.5, 2.2.8") => "FMI 3.0.2, 2.4.8",
            (_, "FMI 2.0.5, 2.3") => "FMI 3.0.2, 2.5.1",
            (_, "FMI 2.0.5, 4.2.2") => "FMI 3.0.2, 4.2.1",
            (_, "FMI 2.0.5, 4.2.4") => "FMI 3.0.2, 4.2",
            (_, "FMI 2.0.5, 4.3.1") => "FMI 3.0.2, 2.4.2",
            (_, own) => own,
        }
    }
}

#[rustfmt::skip]
/// All rules, in the order of their findings.
pub static RULES: &[Rule] = &[
    // The needs of any simulation.
    rule("description-readable", Error, "FMI 2.0.5, 2.2", "modelDescription.xml is well-formed and one of FMI 2.0 or 3.0 for Co-Simulation", Elsewhere),
    rule("archive-readable", Error, "FMI 2.0.5, 2.3", "the FMU is a sound zip archive with modelDescription.xml at its top", Elsewhere),
    // The schema.
    rule("xml-encoding", Error, XML, "the bytes are of the declared encoding", Remark(About::Encoding)),
    rule("xml-utf-8", Error, "FMI 2.0.5, 2.2", "the encoding is UTF-8", Either(values::other_encoding)),
    rule("xml-declaration", Warning, "FMI 2.0.5, 2.2", "the first line names the encoding", Either(values::no_encoding)),
    rule("schema-namespace", Error, MODEL, "the elements are in no namespace", Either(schema::namespace)),
    rule("schema-attribute", Error, MODEL, "only attributes of the standard", Either(schema::unknown_attributes)),
    rule("schema-attribute-missing", Error, MODEL, "all required attributes", Either(schema::missing_attributes)),
    rule("schema-element", Error, MODEL, "only elements of the standard", Either(schema::unknown_elements)),
    rule("schema-element-missing", Error, MODEL, "all required elements", Either(schema::missing_elements)),
    rule("schema-text", Error, MODEL, "no text between elements", Either(schema::text)),
    rule("schema-order", Error, MODEL, "elements in the schema's order, single ones once", Either(schema::order)),
    rule("schema-empty-list", Error, MODEL, "a list that is there holds something", Either(schema::empty_lists)),
    rule("schema-type-missing", Error, TYPE, "a SimpleType says of which type it is", Document(schema::typeless)),
    rule("schema-value", Error, MODEL, "values of their attribute's type", Either(schema::values)),
    rule("schema-value-read", Error, MODEL, "values of their attribute's type", Remark(About::Value)),
    rule("variable-readable", Error, SCALAR, "a variable has a name, a value reference and a type", Remark(About::Variable)),
    // The definitions.
    rule("version", Error, "FMI 2.0.5, 2.2.1", "fmiVersion is 2.0", Document(values::version)),
    rule("date", Error, "FMI 2.0.5, 2.2.1", "generationDateAndTime is an xs:dateTime", Either(definitions::date)),
    rule("naming-convention", Error, "FMI 2.0.5, 2.2.1", "variableNamingConvention is flat or structured", Either(names::convention)),
    rule("structured-name", Error, "FMI 2.0.5, 2.2.9", "structured names follow the grammar", Document(names::structured)),
    rule("unit-unique", Error, "FMI 2.0.5, 2.2.2", "units have names of their own", Either(|d| alike(d, "UnitDefinitions/Unit", &["name"]))),
    rule("display-unit-unique", Error, "FMI 2.0.5, 2.2.2", "display units of a unit have names of their own", Either(|d| alike(d, "UnitDefinitions/Unit/DisplayUnit", &["name"]))),
    rule("unit-factor", Error, "FMI 2.0.5, 2.2.2", "a factor is not zero", Either(definitions::factors)),
    rule("type-unique", Error, "FMI 2.0.5, 2.2.3", "types have names of their own", Document(|d| alike(d, "TypeDefinitions/SimpleType", &["name"]))),
    rule("type-name", Error, "FMI 2.0.5, 2.2.3", "a type is not called as a variable", Document(definitions::types_and_variables)),
    rule("type-attributes", Error, "FMI 2.0.5, 2.2.3", "a type's range and units make sense", Document(definitions::type_attributes)),
    rule("item-unique", Error, "FMI 2.0.5, 2.2.3", "items have names and values of their own", Document(|d| alike(d, "TypeDefinitions/SimpleType/*/Item", &["name", "value"]))),
    rule("category-unique", Error, "FMI 2.0.5, 2.2.4", "log categories have names of their own", Either(|d| alike(d, "LogCategories/Category", &["name"]))),
    rule("step-size-positive", Error, "FMI 2.0.5, 2.2.5", "stepSize is greater than 0", Either(|d| positive("stepSize", d.read.default_experiment.step))),
    rule("tolerance-positive", Error, "FMI 2.0.5, 2.2.5", "tolerance is greater than 0", Either(|d| positive("tolerance", d.read.default_experiment.tolerance))),
    rule("stop-after-start", Error, "FMI 2.0.5, 2.2.5", "stopTime is later than startTime", Either(values::stop)),
    rule("step-within", Warning, "FMI 2.0.5, 2.2.5", "stepSize is not longer than the experiment", Either(values::long_step)),
    rule("tool-unique", Error, "FMI 2.0.5, 2.2.6", "annotations are of a tool each", Document(|d| [alike(d, "VendorAnnotations/Tool", &["name"]), alike(d, "ModelVariables/ScalarVariable/Annotations/Tool", &["name"])].concat())),
    rule("source-file-unique", Warning, "FMI 2.0.5, 4.3.1", "source files have names of their own", Document(|d| alike(d, "CoSimulation/SourceFiles/File", &["name"]))),
    rule("serialize-needs-state", Error, "FMI 2.0.5, 4.3.1", "canSerializeFMUstate implies canGetAndSetFMUstate", Document(definitions::serialized_states)),
    rule("exchange-only", Error, "FMI 2.0.5, 2.2.7", "reinit and canHandleMultipleSetPerTimeInstant are for Model Exchange", Document(definitions::exchange_only)),
    rule("reinit", Error, "FMI 2.0.5, 2.2.7", "reinit is for continuous-time states", Document(definitions::reinit)),
    // Variables.
    rule("variable-name-unique", Error, "FMI 2.0.5, 2.2.7", "variables have names of their own", Remark(About::Name)),
    rule("independent-single", Error, "FMI 2.0.5, 2.2.7", "one independent variable", Document(variables::independents)),
    rule("name-legal", Error, "FMI 2.0.5, 2.2.9", "a name is not empty, without line breaks and tabs", Variable(names::legal)),
    rule("variability", Error, "FMI 2.0.5, 2.2.7", "causality and variability go together", Variable(variables::kind)),
    rule("continuous-real", Error, "FMI 2.0.5, 2.2.7", "only a Real is continuous", Variable(variables::continuous)),
    rule("initial", Error, "FMI 2.0.5, 2.2.7", "initial goes with causality and variability", Variable(variables::initial)),
    rule("start-needed", Error, "FMI 2.0.5, 2.2.7", "inputs, parameters, constants and exact ones have a start value", Variable(variables::startless)),
    rule("start-forbidden", Error, "FMI 2.0.5, 2.2.7", "calculated ones and the time have no start value", Variable(variables::started)),
    rule("type-declared", Error, "FMI 2.0.5, 2.2.7", "declaredType is defined", Variable(variables::undeclared)),
    rule("type-fits", Error, "FMI 2.0.5, 2.2.7", "declaredType is of the variable's type", Variable(variables::mistyped)),
    rule("derivative-name", Error, "FMI 2.0.5, 2.2.9", "a structured name der(...) is the one of a Real", Variable(names::of_real)),
    rule("derivative", Error, "FMI 2.0.5, 2.2.7", "derivative is the index of a continuous Real", Variable(variables::derivative)),
    rule("range", Error, "FMI 2.0.5, 2.2.7", "max is not less than min", Variable(values::range)),
    rule("start-in-range", Error, "FMI 2.0.5, 2.2.7", "start lies between min and max", Variable(values::start)),
    rule("start-finite", Error, "FMI 2.0.5, 2.2.7", "start is a finite number", Variable(values::infinite)),
    rule("start-item", Error, "FMI 2.0.5, 2.2.7", "start is an item of the type", Variable(values::item)),
    rule("nominal-positive", Error, "FMI 2.0.5, 2.2.7", "nominal is greater than 0", Variable(values::nominal)),
    rule("unit-defined", Error, "FMI 2.0.5, 2.2.7", "unit is defined", Variable(values::unit)),
    rule("display-unit-alone", Error, "FMI 2.0.5, 2.2.3", "displayUnit has a unit", Variable(values::display_unit_alone)),
    rule("alias", Error, "FMI 2.0.5, 2.2.7", "of several names one can be set and has a start value; all are constant or none is", Variable(aliases::alias)),
    rule("alias-unit", Error, "FMI 2.0.5, 2.2.7", "several names have one unit", Variable(aliases::unit)),
    rule("variability-given", Warning, "FMI 2.0.5, 2.2.7", "what is no Real has a variability, as the default is continuous", Variable(variables::variability_missing)),
    rule("range-of-type", Warning, "FMI 2.0.5, 2.2.7", "a variable's range lies within its type's", Variable(values::beyond_type)),
    rule("display-unit-defined", Warning, "FMI 2.0.5, 2.2.3", "displayUnit is defined for the unit, as it is ignored otherwise", Variable(values::display_unit)),
    rule("alias-unit-missing", Warning, "FMI 2.0.5, 2.2.7", "several names all have a unit or none has", Variable(aliases::without_unit)),
    rule("alias-variability", Note, "FMI 2.0.5, 2.2.7", "several names have one variability", Variable(aliases::variability)),
    // The structure.
    rule("outputs", Error, "FMI 2.0.5, 2.2.8", "Outputs lists outputs, each once", Document(structure::outputs)),
    rule("outputs-complete", Error, "FMI 2.0.5, 2.2.8", "Outputs lists every output", Document(structure::outputs_missing)),
    rule("outputs-none", Note, "FMI 2.0.5, 2.2.8", "there is something to compare with", Document(structure::no_outputs)),
    rule("derivatives", Error, "FMI 2.0.5, 2.2.8", "Derivatives lists derivatives of local variables and outputs, each once", Document(structure::derivatives)),
    rule("derivatives-continuous", Warning, "FMI 2.0.5, 2.2.8", "state derivatives are continuous", Document(structure::derivatives_discrete)),
    rule("derivatives-complete", Warning, "FMI 2.0.5, 2.2.8", "Derivatives is there where states are declared", Document(structure::derivatives_missing)),
    rule("initial-unknowns", Error, "FMI 2.0.5, 2.2.8", "InitialUnknowns lists variables that are computed initially, each once", Document(structure::initial_unknowns)),
    rule("initial-unknowns-sorted", Error, "FMI 2.0.5, 2.2.8", "InitialUnknowns is sorted by index", Document(structure::initial_unknowns_unsorted)),
    rule("initial-unknowns-complete", Warning, "FMI 2.0.5, 2.2.8", "InitialUnknowns lists all outputs, calculated parameters, states and derivatives that are computed", Document(structure::initial_unknowns_missing)),
    rule("initial-unknowns-surplus", Warning, "FMI 2.0.5, 2.2.8", "InitialUnknowns lists nothing else", Document(structure::initial_unknowns_surplus)),
    rule("dependencies", Error, "FMI 2.0.5, 2.2.8", "dependencies are on variables, with a kind each where kinds are given", Document(dependencies::dependencies)),
    rule("dependencies-sorted", Error, "FMI 2.0.5, 2.2.8", "dependencies are sorted by index, each once", Document(dependencies::unsorted)),
    rule("dependencies-known", Warning, "FMI 2.0.5, 2.2.8", "dependencies are on inputs, states and what else is known", Document(dependencies::unknown)),
    rule("dependencies-factor", Warning, "FMI 2.0.5, 2.2.8", "only a Real depends on something by a factor", Document(dependencies::factors)),
    // The archive.
    rule("archive-path", Error, "FMI 2.0.5, 2.3", "paths are relative, with forward slashes", Elsewhere),
    rule("archive-entry-unique", Warning, "FMI 2.0.5, 2.3", "entries have names of their own", Elsewhere),
    rule("terminals-version", Warning, "FMI 3.0.2, 2.4.9", "terminalsAndIcons.xml and modelDescription.xml name the same version", Elsewhere),
    rule("references-manifest", Warning, "FMI-LS-REF 1.0.0-beta.1", "the manifest of related files keeps to its schema", Elsewhere),
    rule("model-identifier", Error, "FMI 2.0.5, 4.3.1", "modelIdentifier is a C identifier", Elsewhere),
    rule("binary-there", Error, "FMI 2.0.5, 2.3", "there is a binary for this machine", Elsewhere),
    rule("binary-folder", Error, "FMI 2.0.5, 2.3", "binaries lie in binaries/PLATFORM", Elsewhere),
    rule("binary-name", Error, "FMI 2.0.5, 2.3", "a binary is named as modelIdentifier", Elsewhere),
    rule("binary-machine", Error, "FMI 2.0.5, 2.3", "a binary is one for its platform", Elsewhere),
    rule("binary-readable", Error, "FMI 2.0.5, 2.3", "a binary is a shared library", Elsewhere),
    rule("binary-functions", Error, "FMI 2.0.5, 2.1.1", "a binary exports every function of its version of FMI", Elsewhere),
    rule("binary-libraries", Error, "FMI 2.0.5, 2.3", "the libraries that a binary needs are there", Elsewhere),
    // The life of an FMU.
    rule("execution-tool", Note, "FMI 2.0.5, 4.3.1", "the FMU runs by itself", Elsewhere),
    rule("binary-loads", Error, "FMI 2.0.5, 2.3", "the binary can be loaded", Elsewhere),
    rule("binary-version", Warning, "FMI 2.0.5, 2.1.4", "the binary calls itself one of its description's version", Elsewhere),
    rule("binary-types", Warning, "FMI 2.0.5, 2.1.4", "fmi2GetTypesPlatform returns default", Elsewhere),
    rule("simulation-runs", Error, "FMI 2.0.5, 4.2.4", "a simulation with the start values runs", Elsewhere),
    rule("step-suggested", Note, "FMI 2.0.5, 2.2.5", "an FMU that refuses steps suggests one that it takes", Elsewhere),
    rule("output-finite", Error, "a study would be wrong", "outputs are finite numbers", Elsewhere),
    rule("output-range", Warning, "FMI 2.0.5, 2.2.3", "outputs keep to their range", Elsewhere),
    rule("start-agrees", Error, "FMI 2.0.5, 2.2.7", "the binary starts with the start values of the description", Elsewhere),
    rule("warnings", Warning, "FMI 2.0.5, 2.1.3", "calls return fmi2OK", Elsewhere),
    rule("logger-environment", Warning, "FMI 2.0.5, 2.1.5", "the logger gets its environment", Elsewhere),
    rule("early-end", Note, "FMI 2.0.5, 4.2.2", "a simulation goes on to its stop time", Elsewhere),
    rule("life-ends", Error, "FMI 2.0.5, 2.1.6", "a simulation ends and is freed in order", Elsewhere),
    rule("reproducible", Warning, "a study would differ from run to run", "the same simulation gives the same values", Elsewhere),
    rule("files-kept", Warning, "a study would take longer", "the FMU leaves the files of its own folder as they are", Elsewhere),
    rule("held", Note, "points of a study would meet", "no port, socket or lock of the machine is held", Elsewhere),
    rule("memory-written", Error, "a study would be wrong", "no memory is read that was never written", Elsewhere),
    rule("life-reset", Error, "FMI 2.0.5, 2.1.6", "fmi2Reset takes everything back", Elsewhere),
    rule("life-again", Error, "FMI 2.0.5, 2.1.5", "a second instance is as the first", Elsewhere),
    rule("life-instances", Error, "FMI 2.0.5, 4.3.1", "several instances do not disturb each other, or canBeInstantiatedOnlyOncePerProcess is set", Elsewhere),
    rule("step-coarse", Warning, "a study would be wrong", "half the suggested communication step hardly changes the values", Elsewhere),
    rule("step-size", Note, "FMI 2.0.5, 4.2.2", "half the communication step never changes a value much, and is taken", Elsewhere),
    // Rules of FMI 3.0 alone.
    rule("three-token", Error, "FMI 3.0.2, 2.4", "instantiationToken is there", Three(three::token)),
    rule("three-version", Warning, "FMI 3.0.2, 2.4.1", "fmiVersion is 3.0 or one of its corrections", Three(three::version)),
    rule("three-state", Error, "FMI 3.0.2, 2.4.2", "canSerializeFMUState implies canGetAndSetFMUState", Three(definitions::serialized_states)),
    rule("display-unit-usable", Note, "FMI 3.0.2, 2.4.3", "every display unit can be used here", Remark(About::Limit)),
    rule("three-usable", Note, "FMI 3.0.2, 2.4.7", "every variable can be set or judged here", Each(three::unusable)),
    rule("three-reference", Error, "FMI 3.0.2, 2.4.7", "a value reference is that of one variable", Three(three::references)),
    rule("three-independent", Error, "FMI 3.0.2, 2.4.7", "one independent variable, a float without a start value", Three(three::independent)),
    rule("three-start", Error, "FMI 3.0.2, 2.4.7", "what is set or exact has a start value, what is calculated has none", Each(three::starts)),
    rule("three-range", Error, "FMI 3.0.2, 2.4.7", "min, start and max do not contradict each other", Three(three::ranges)),
    rule("three-declared", Error, "FMI 3.0.2, 2.4.7", "declaredType and unit are defined", Three(three::declared)),
    rule("three-dimension", Error, "FMI 3.0.2, 2.4.7", "a dimension is a number, or a structural parameter or constant of type UInt64", Three(three::dimensions)),
    rule("three-name", Error, "FMI 3.0.2, 2.4.1", "a name is not empty", Three(three::empty_names)),
    rule("three-type-unique", Error, "FMI 3.0.2, 2.4.4", "types have names of their own", Three(|d| alike(d, "TypeDefinitions/*", &["name"]))),
    rule("three-item-unique", Error, "FMI 3.0.2, 2.4.4", "items have names and values of their own", Three(|d| alike(d, "TypeDefinitions/EnumerationType/Item", &["name", "value"]))),
    rule("three-variability", Error, "FMI 3.0.2, 2.4.7", "causality, variability and type go together", Each(three::variabilities)),
    rule("three-initial", Error, "FMI 3.0.2, 2.4.7", "initial goes with causality and variability", Each(variables::initial)),
    rule("three-finite", Warning, "a study would be wrong", "start is a finite number", Each(three::not_finite)),
    rule("three-derivative", Error, "FMI 3.0.2, 2.4.8", "a derivative is one of a continuous float", Three(three::derivatives)),
    rule("three-reinit", Error, "FMI 3.0.2, 2.4.7", "reinit is for continuous-time states", Three(definitions::reinit)),
    rule("three-internal-step", Error, "FMI 3.0.2, 4.4.1", "fixedInternalStepSize is greater than 0", Three(three::internal_step)),
    rule("three-clocks", Error, "FMI 3.0.2, 2.4.7", "clocks refers to Clocks", Three(three::clocks)),
    rule("three-clock", Error, "FMI 3.0.2, 2.2.9", "a clock is as its kind needs it, and Co-Simulation with clocks has event mode", Three(three::timing)),
    rule("three-initial-unknowns", Error, "FMI 3.0.2, 2.4.8", "ModelStructure lists what is computed initially, and nothing else", Three(three::initial_unknowns)),
    rule("three-lists", Error, "FMI 3.0.2, 2.4.8", "ModelStructure has each element once, with a kind for each dependency where kinds are given", Three(three::lists)),
    rule("three-outputs", Error, "FMI 3.0.2, 2.4.8", "ModelStructure lists every output, and only outputs", Three(three::outputs)),
    rule("three-structure", Error, "FMI 3.0.2, 2.4.8", "ModelStructure refers to variables", Three(three::structure)),
];

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn each_rule_has_a_name_of_its_own() {
        let names: HashSet<&str> = RULES.iter().map(|rule| rule.id).collect();
        assert_eq!(names.len(), RULES.len());
        assert_eq!(named("range").wants, "max is not less than min");
    }
}
