//! All rules of a check, a line each. A new rule is a function and a line here.

use fmu_import::{Version, description::About};

use crate::{
    aliases,
    definitions::{self, alike},
    dependencies,
    finding::{
        Find::{Document, Each, Either, Elsewhere, Remark, Three, Variable},
        Rule,
        Severity::{Error, Note, Warning},
    },
    names, schema, structure, three,
    values::{self, positive},
    variables,
};

/// The rules of standards, each with its section, or with a source of its own.
macro_rules! rules {
    ($($standard:tt {$($id:tt $severity:ident $section:tt $wants:tt $find:expr;)*})*) => {
        &[$($(Rule {
            id: $id,
            severity: $severity,
            source: source!($standard $section),
            wants: $wants,
            find: $find,
        },)*)*]
    };
}

macro_rules! source {
    (own $source:tt) => {
        $source
    };
    ($standard:tt $section:tt) => {
        concat!($standard, ", ", $section)
    };
}

/// The sections of FMI 2.0.5 and where their rules stand in FMI 3.0.2.
const SECTIONS: [(&str, &str); 18] = [
    ("2.1.1", "2.2.2"),
    ("2.1.3", "2.2.4"),
    ("2.1.4", "2.2.5"),
    ("2.1.5", "2.3.1"),
    ("2.1.6", "2.3.1"),
    ("2.2", "2.4"),
    ("2.2.1", "2.4.1"),
    ("2.2.2", "2.4.3"),
    ("2.2.3", "2.4.4"),
    ("2.2.4", "2.4.5"),
    ("2.2.5", "2.4.6"),
    ("2.2.7", "2.4.7"),
    ("2.2.9", "2.4.7"),
    ("2.2.8", "2.4.8"),
    ("2.3", "2.5.1"),
    ("4.2.2", "4.2.1"),
    ("4.2.4", "4.2"),
    ("4.3.1", "2.4.2"),
];

/// The rule of this name, which one of the files of this crate writes.
pub(crate) fn named(id: &str) -> &'static Rule {
    RULES.iter().find(|rule| rule.id == id).unwrap_or_else(|| panic!("there is no rule `{id}`"))
}

impl Rule {
    /// Where it stands in a version of the standard.
    pub fn source_in(&self, version: Version) -> String {
        let later = |two: &str| {
            SECTIONS.iter().find(|(known, _)| *known == two).map(|(_, three)| format!("FMI 3.0.2, {three}"))
        };
        match version {
            Version::Two => self.source.to_owned(),
            Version::Three => (self.source.strip_prefix("FMI 2.0.5, ").and_then(later))
                .unwrap_or_else(|| self.source.replace("fmi2Scalar", "fmi2").replace("fmi2", "fmi3")),
        }
    }
}

#[rustfmt::skip]
/// All rules, in the order of their findings.
pub static RULES: &[Rule] = rules! {
    "FMI 2.0.5" {
        // The needs of any simulation.
        "description-readable" Error "2.2" "modelDescription.xml is well-formed and one of FMI 2.0 or 3.0 for Co-Simulation" Elsewhere;
        "archive-readable" Error "2.3" "the FMU is a sound zip archive with modelDescription.xml at its top" Elsewhere;
    }
    own {
        // The schema.
        "xml-encoding" Error "XML 1.0, 4.3.3" "the bytes are of the declared encoding" Remark(About::Encoding);
    }
    "FMI 2.0.5" {
        "xml-utf-8" Error "2.2" "the encoding is UTF-8" Either(values::other_encoding);
        "xml-declaration" Warning "2.2" "the first line names the encoding" Either(values::no_encoding);
    }
    own {
        "schema-namespace" Error "fmi2ModelDescription.xsd" "the elements are in no namespace" Either(schema::namespace);
        "schema-attribute" Error "fmi2ModelDescription.xsd" "only attributes of the standard" Either(schema::unknown_attributes);
        "schema-attribute-missing" Error "fmi2ModelDescription.xsd" "all required attributes" Either(schema::missing_attributes);
        "schema-element" Error "fmi2ModelDescription.xsd" "only elements of the standard" Either(schema::unknown_elements);
        "schema-element-missing" Error "fmi2ModelDescription.xsd" "all required elements" Either(schema::missing_elements);
        "schema-text" Error "fmi2ModelDescription.xsd" "no text between elements" Either(schema::text);
        "schema-order" Error "fmi2ModelDescription.xsd" "elements in the schema's order, single ones once" Either(schema::order);
        "schema-empty-list" Error "fmi2ModelDescription.xsd" "a list that is there holds something" Either(schema::empty_lists);
        "schema-type-missing" Error "fmi2Type.xsd" "a SimpleType says of which type it is" Document(schema::typeless);
        "schema-value" Error "fmi2ModelDescription.xsd" "values of their attribute's type" Either(schema::values);
        "schema-value-read" Error "fmi2ModelDescription.xsd" "values of their attribute's type" Remark(About::Value);
        "variable-readable" Error "fmi2ScalarVariable.xsd" "a variable has a name, a value reference and a type" Remark(About::Variable);
    }
    "FMI 2.0.5" {
        // The definitions.
        "version" Error "2.2.1" "fmiVersion is 2.0" Document(values::version);
        "date" Error "2.2.1" "generationDateAndTime is an xs:dateTime" Either(definitions::date);
        "naming-convention" Error "2.2.1" "variableNamingConvention is flat or structured" Either(names::convention);
        "structured-name" Error "2.2.9" "structured names follow the grammar" Document(names::structured);
        "unit-unique" Error "2.2.2" "units have names of their own" Either(|d| alike(d, "UnitDefinitions/Unit", &["name"]));
        "display-unit-unique" Error "2.2.2" "display units of a unit have names of their own" Either(|d| alike(d, "UnitDefinitions/Unit/DisplayUnit", &["name"]));
        "unit-factor" Error "2.2.2" "a factor is not zero" Either(definitions::factors);
        "type-unique" Error "2.2.3" "types have names of their own" Document(|d| alike(d, "TypeDefinitions/SimpleType", &["name"]));
        "type-name" Error "2.2.3" "a type is not called as a variable" Document(definitions::types_and_variables);
        "type-attributes" Error "2.2.3" "a type's range and units make sense" Document(definitions::type_attributes);
        "item-unique" Error "2.2.3" "items have names and values of their own" Document(|d| alike(d, "TypeDefinitions/SimpleType/*/Item", &["name", "value"]));
        "category-unique" Error "2.2.4" "log categories have names of their own" Either(|d| alike(d, "LogCategories/Category", &["name"]));
        "step-size-positive" Error "2.2.5" "stepSize is greater than 0" Either(|d| positive("stepSize", d.read.default_experiment.step));
        "tolerance-positive" Error "2.2.5" "tolerance is greater than 0" Either(|d| positive("tolerance", d.read.default_experiment.tolerance));
        "stop-after-start" Error "2.2.5" "stopTime is later than startTime" Either(values::stop);
        "step-within" Warning "2.2.5" "stepSize is not longer than the experiment" Either(values::long_step);
        "tool-unique" Error "2.2.6" "annotations are of a tool each" Document(|d| [alike(d, "VendorAnnotations/Tool", &["name"]), alike(d, "ModelVariables/ScalarVariable/Annotations/Tool", &["name"])].concat());
        "source-file-unique" Warning "4.3.1" "source files have names of their own" Document(|d| alike(d, "CoSimulation/SourceFiles/File", &["name"]));
        "serialize-needs-state" Error "4.3.1" "canSerializeFMUstate implies canGetAndSetFMUstate" Document(definitions::serialized_states);
        "exchange-only" Error "2.2.7" "reinit and canHandleMultipleSetPerTimeInstant are for Model Exchange" Document(definitions::exchange_only);
        "reinit" Error "2.2.7" "reinit is for continuous-time states" Document(definitions::reinit);
        // Variables.
        "variable-name-unique" Error "2.2.7" "variables have names of their own" Remark(About::Name);
        "independent-single" Error "2.2.7" "one independent variable" Document(variables::independents);
        "name-legal" Error "2.2.9" "a name is not empty, without line breaks and tabs" Variable(names::legal);
        "variability" Error "2.2.7" "causality and variability go together" Variable(variables::kind);
        "continuous-real" Error "2.2.7" "only a Real is continuous" Variable(variables::continuous);
        "initial" Error "2.2.7" "initial goes with causality and variability" Variable(variables::initial);
        "start-needed" Error "2.2.7" "inputs, parameters, constants and exact ones have a start value" Variable(variables::startless);
        "start-forbidden" Error "2.2.7" "calculated ones and the time have no start value" Variable(variables::started);
        "type-declared" Error "2.2.7" "declaredType is defined" Variable(variables::undeclared);
        "type-fits" Error "2.2.7" "declaredType is of the variable's type" Variable(variables::mistyped);
        "derivative-name" Error "2.2.9" "a structured name der(...) is the one of a Real" Variable(names::of_real);
        "derivative" Error "2.2.7" "derivative is the index of a continuous Real" Variable(variables::derivative);
        "range" Error "2.2.7" "max is not less than min" Variable(values::range);
        "start-in-range" Error "2.2.7" "start lies between min and max" Variable(values::start);
        "start-finite" Error "2.2.7" "start is a finite number" Variable(values::infinite);
        "start-item" Error "2.2.7" "start is an item of the type" Variable(values::item);
        "nominal-positive" Error "2.2.7" "nominal is greater than 0" Variable(values::nominal);
        "unit-defined" Error "2.2.7" "unit is defined" Variable(values::unit);
        "display-unit-alone" Error "2.2.3" "displayUnit has a unit" Variable(values::display_unit_alone);
        "alias" Error "2.2.7" "of several names one can be set and has a start value; all are constant or none is" Variable(aliases::alias);
        "alias-unit" Error "2.2.7" "several names have one unit" Variable(aliases::unit);
        "variability-given" Warning "2.2.7" "what is no Real has a variability, as the default is continuous" Variable(variables::variability_missing);
        "range-of-type" Warning "2.2.7" "a variable's range lies within its type's" Variable(values::beyond_type);
        "display-unit-defined" Warning "2.2.3" "displayUnit is defined for the unit, as it is ignored otherwise" Variable(values::display_unit);
        "alias-unit-missing" Warning "2.2.7" "several names all have a unit or none has" Variable(aliases::without_unit);
        "alias-variability" Note "2.2.7" "several names have one variability" Variable(aliases::variability);
        // The structure.
        "outputs" Error "2.2.8" "Outputs lists outputs, each once" Document(structure::outputs);
        "outputs-complete" Error "2.2.8" "Outputs lists every output" Document(structure::outputs_missing);
        "outputs-none" Note "2.2.8" "there is something to compare with" Document(structure::no_outputs);
        "derivatives" Error "2.2.8" "Derivatives lists derivatives of local variables and outputs, each once" Document(structure::derivatives);
        "derivatives-continuous" Warning "2.2.8" "state derivatives are continuous" Document(structure::derivatives_discrete);
        "derivatives-complete" Warning "2.2.8" "Derivatives is there where states are declared" Document(structure::derivatives_missing);
        "initial-unknowns" Error "2.2.8" "InitialUnknowns lists variables that are computed initially, each once" Document(structure::initial_unknowns);
        "initial-unknowns-sorted" Error "2.2.8" "InitialUnknowns is sorted by index" Document(structure::initial_unknowns_unsorted);
        "initial-unknowns-complete" Warning "2.2.8" "InitialUnknowns lists all outputs, calculated parameters, states and derivatives that are computed" Document(structure::initial_unknowns_missing);
        "initial-unknowns-surplus" Warning "2.2.8" "InitialUnknowns lists nothing else" Document(structure::initial_unknowns_surplus);
        "dependencies" Error "2.2.8" "dependencies are on variables, with a kind each where kinds are given" Document(dependencies::dependencies);
        "dependencies-sorted" Error "2.2.8" "dependencies are sorted by index, each once" Document(dependencies::unsorted);
        "dependencies-known" Warning "2.2.8" "dependencies are on inputs, states and what else is known" Document(dependencies::unknown);
        "dependencies-factor" Warning "2.2.8" "only a Real depends on something by a factor" Document(dependencies::factors);
        // The archive.
        "archive-path" Error "2.3" "paths are relative, with forward slashes" Elsewhere;
        "archive-entry-unique" Warning "2.3" "entries have names of their own" Elsewhere;
    }
    "FMI 3.0.2" {
        "terminals-version" Warning "2.4.9" "terminalsAndIcons.xml and modelDescription.xml name the same version" Elsewhere;
    }
    own {
        "references-manifest" Warning "FMI-LS-REF 1.0.0-beta.1" "the manifest of related files keeps to its schema" Elsewhere;
    }
    "FMI 2.0.5" {
        "model-identifier" Error "4.3.1" "modelIdentifier is a C identifier" Elsewhere;
        "binary-there" Error "2.3" "there is a binary for this machine" Elsewhere;
        "binary-folder" Error "2.3" "binaries lie in binaries/PLATFORM" Elsewhere;
        "binary-name" Error "2.3" "a binary is named as modelIdentifier" Elsewhere;
        "binary-machine" Error "2.3" "a binary is one for its platform" Elsewhere;
        "binary-readable" Error "2.3" "a binary is a shared library" Elsewhere;
        "binary-functions" Error "2.1.1" "a binary exports every function of its version of FMI" Elsewhere;
        "binary-libraries" Error "2.3" "the libraries that a binary needs are there" Elsewhere;
        // The life of an FMU.
        "execution-tool" Note "4.3.1" "the FMU runs by itself" Elsewhere;
        "binary-loads" Error "2.3" "the binary can be loaded" Elsewhere;
        "binary-version" Warning "2.1.4" "the binary calls itself one of its description's version" Elsewhere;
        "binary-types" Warning "2.1.4" "fmi2GetTypesPlatform returns default" Elsewhere;
        "simulation-runs" Error "4.2.4" "a simulation with the start values runs" Elsewhere;
        "step-suggested" Note "2.2.5" "an FMU that refuses steps suggests one that it takes" Elsewhere;
    }
    own {
        "output-finite" Error "a study would be wrong" "outputs are finite numbers" Elsewhere;
    }
    "FMI 2.0.5" {
        "output-range" Warning "2.2.3" "outputs keep to their range" Elsewhere;
        "start-agrees" Error "2.2.7" "the binary starts with the start values of the description" Elsewhere;
        "warnings" Warning "2.1.3" "calls return fmi2OK" Elsewhere;
        "logger-environment" Warning "2.1.5" "the logger gets its environment" Elsewhere;
        "early-end" Note "4.2.2" "a simulation goes on to its stop time" Elsewhere;
        "life-ends" Error "2.1.6" "a simulation ends and is freed in order" Elsewhere;
    }
    own {
        "reproducible" Warning "a study would differ from run to run" "the same simulation gives the same values" Elsewhere;
        "files-kept" Warning "a study would take longer" "the FMU leaves the files of its own folder as they are" Elsewhere;
        "held" Note "points of a study would meet" "no port, socket or lock of the machine is held" Elsewhere;
        "memory-written" Error "a study would be wrong" "no memory is read that was never written" Elsewhere;
    }
    "FMI 2.0.5" {
        "life-reset" Error "2.1.6" "fmi2Reset takes everything back" Elsewhere;
        "life-again" Error "2.1.5" "a second instance is as the first" Elsewhere;
        "life-instances" Error "4.3.1" "several instances do not disturb each other, or canBeInstantiatedOnlyOncePerProcess is set" Elsewhere;
    }
    own {
        "step-coarse" Warning "a study would be wrong" "half the suggested communication step hardly changes the values" Elsewhere;
    }
    "FMI 2.0.5" {
        "step-size" Note "4.2.2" "half the communication step never changes a value much, and is taken" Elsewhere;
    }
    "FMI 3.0.2" {
        // Rules of FMI 3.0 alone.
        "three-token" Error "2.4" "instantiationToken is there" Three(three::token);
        "three-version" Warning "2.4.1" "fmiVersion is 3.0 or one of its corrections" Three(three::version);
        "three-state" Error "2.4.2" "canSerializeFMUState implies canGetAndSetFMUState" Three(definitions::serialized_states);
        "display-unit-usable" Note "2.4.3" "every display unit can be used here" Remark(About::Limit);
        "three-usable" Note "2.4.7" "every variable can be set or judged here" Each(three::unusable);
        "three-reference" Error "2.4.7" "a value reference is that of one variable" Three(three::references);
        "three-independent" Error "2.4.7" "one independent variable, a float without a start value" Three(three::independent);
        "three-start" Error "2.4.7" "what is set or exact has a start value, what is calculated has none" Each(three::starts);
        "three-range" Error "2.4.7" "min, start and max do not contradict each other" Three(three::ranges);
        "three-declared" Error "2.4.7" "declaredType and unit are defined" Three(three::declared);
        "three-dimension" Error "2.4.7" "a dimension is a number, or a structural parameter or constant of type UInt64" Three(three::dimensions);
        "three-name" Error "2.4.1" "a name is not empty" Three(three::empty_names);
        "three-type-unique" Error "2.4.4" "types have names of their own" Three(|d| alike(d, "TypeDefinitions/*", &["name"]));
        "three-item-unique" Error "2.4.4" "items have names and values of their own" Three(|d| alike(d, "TypeDefinitions/EnumerationType/Item", &["name", "value"]));
        "three-variability" Error "2.4.7" "causality, variability and type go together" Each(three::variabilities);
        "three-initial" Error "2.4.7" "initial goes with causality and variability" Each(variables::initial);
    }
    own {
        "three-finite" Warning "a study would be wrong" "start is a finite number" Each(three::not_finite);
    }
    "FMI 3.0.2" {
        "three-derivative" Error "2.4.8" "a derivative is one of a continuous float" Three(three::derivatives);
        "three-reinit" Error "2.4.7" "reinit is for continuous-time states" Three(definitions::reinit);
        "three-internal-step" Error "4.4.1" "fixedInternalStepSize is greater than 0" Three(three::internal_step);
        "three-clocks" Error "2.4.7" "clocks refers to Clocks" Three(three::clocks);
        "three-clock" Error "2.2.9" "a clock is as its kind needs it, and Co-Simulation with clocks has event mode" Three(three::timing);
        "three-initial-unknowns" Error "2.4.8" "ModelStructure lists what is computed initially, and nothing else" Three(three::initial_unknowns);
        "three-lists" Error "2.4.8" "ModelStructure has each element once, with a kind for each dependency where kinds are given" Three(three::lists);
        "three-outputs" Error "2.4.8" "ModelStructure lists every output, and only outputs" Three(three::outputs);
        "three-structure" Error "2.4.8" "ModelStructure refers to variables" Three(three::structure);
    }
};

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
