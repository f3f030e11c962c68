//! All rules of a check. `rules.txt` has a row for each with all that people know of it, in the order of the findings; `find` tells who
//! looks for breaches. A new rule is a row, a function and a line here.

use std::sync::LazyLock;

use fmu_import::{Version, description::About};

use crate::{
    aliases,
    definitions::{self, alike},
    dependencies,
    finding::{
        Find::{self, Document, Each, Either, Elsewhere, Remark, Three, Variable},
        Rule,
        Severity::{Error, Note, Warning},
    },
    names, schema, structure, three,
    values::{self, positive},
    variables,
};

/// All rules, in the order of their findings.
pub static RULES: LazyLock<Vec<Rule>> = LazyLock::new(|| {
    let rows = include_str!("rules.txt").lines().skip(1);
    rows.filter(|row| !row.starts_with('#')).map(rule).collect()
});

/// The rule of a row.
fn rule(row: &'static str) -> Rule {
    let cells: Vec<&str> = row.split('|').map(str::trim).collect();
    let [id, severity, source, source_of_three, wants] = cells[..] else {
        panic!("a row has five cells: {row}");
    };
    let severity = match severity {
        "error" => Error,
        "warning" => Warning,
        "note" => Note,
        _ => panic!("{severity} is no severity"),
    };
    Rule { id, severity, source, source_of_three, wants, find: find(id) }
}

/// The rule of this name, which one of the files of this crate writes.
pub fn named(id: &str) -> &'static Rule {
    RULES.iter().find(|rule| rule.id == id).unwrap_or_else(|| panic!("there is no rule `{id}`"))
}

impl Rule {
    /// Where it stands in a version of the standard.
    pub fn source_in(&self, version: Version) -> &'static str {
        match version {
            Version::Three if !self.source_of_three.is_empty() => self.source_of_three,
            _ => self.source,
        }
    }
}

#[rustfmt::skip]
/// Who finds breaches of the rule of this name.
fn find(id: &str) -> Find {
    match id {
        "xml-encoding" => Remark(About::Encoding),
        "xml-utf-8" => Either(values::other_encoding),
        "xml-declaration" => Either(values::no_encoding),
        "schema-namespace" => Either(schema::namespace),
        "schema-attribute" => Either(schema::unknown_attributes),
        "schema-attribute-missing" => Either(schema::missing_attributes),
        "schema-element" => Either(schema::unknown_elements),
        "schema-element-missing" => Either(schema::missing_elements),
        "schema-text" => Either(schema::text),
        "schema-order" => Either(schema::order),
        "schema-empty-list" => Either(schema::empty_lists),
        "schema-type-missing" => Document(schema::typeless),
        "schema-value" => Either(schema::values),
        "schema-value-read" => Remark(About::Value),
        "variable-readable" => Remark(About::Variable),
        "version" => Document(values::version),
        "date" => Either(definitions::date),
        "naming-convention" => Either(names::convention),
        "structured-name" => Document(names::structured),
        "unit-unique" => Either(|d| alike(d, "UnitDefinitions/Unit", &["name"])),
        "display-unit-unique" => Either(|d| alike(d, "UnitDefinitions/Unit/DisplayUnit", &["name"])),
        "unit-factor" => Either(definitions::factors),
        "type-unique" => Document(|d| alike(d, "TypeDefinitions/SimpleType", &["name"])),
        "type-name" => Document(definitions::types_and_variables),
        "type-attributes" => Document(definitions::type_attributes),
        "item-unique" => Document(|d| alike(d, "TypeDefinitions/SimpleType/*/Item", &["name", "value"])),
        "category-unique" => Either(|d| alike(d, "LogCategories/Category", &["name"])),
        "step-size-positive" => Either(|d| positive("stepSize", d.read.default_experiment.step)),
        "tolerance-positive" => Either(|d| positive("tolerance", d.read.default_experiment.tolerance)),
        "stop-after-start" => Either(values::stop),
        "step-within" => Either(values::long_step),
        "tool-unique" => Document(|d| [alike(d, "VendorAnnotations/Tool", &["name"]), alike(d, "ModelVariables/ScalarVariable/Annotations/Tool", &["name"])].concat()),
        "source-file-unique" => Document(|d| alike(d, "CoSimulation/SourceFiles/File", &["name"])),
        "serialize-needs-state" => Document(definitions::serialized_states),
        "exchange-only" => Document(definitions::exchange_only),
        "reinit" => Document(definitions::reinit),
        "variable-name-unique" => Remark(About::Name),
        "independent-single" => Document(variables::independents),
        "name-legal" => Variable(names::legal),
        "variability" => Variable(variables::kind),
        "continuous-real" => Variable(variables::continuous),
        "initial" => Variable(variables::initial),
        "start-needed" => Variable(variables::startless),
        "start-forbidden" => Variable(variables::started),
        "type-declared" => Variable(variables::undeclared),
        "type-fits" => Variable(variables::mistyped),
        "derivative-name" => Variable(names::of_real),
        "derivative" => Variable(variables::derivative),
        "range" => Variable(values::range),
        "start-in-range" => Variable(values::start),
        "start-finite" => Variable(values::infinite),
        "start-item" => Variable(values::item),
        "nominal-positive" => Variable(values::nominal),
        "unit-defined" => Variable(values::unit),
        "display-unit-alone" => Variable(values::display_unit_alone),
        "alias" => Variable(aliases::alias),
        "alias-unit" => Variable(aliases::unit),
        "variability-given" => Variable(variables::variability_missing),
        "range-of-type" => Variable(values::beyond_type),
        "display-unit-defined" => Variable(values::display_unit),
        "alias-unit-missing" => Variable(aliases::without_unit),
        "alias-variability" => Variable(aliases::variability),
        "outputs" => Document(structure::outputs),
        "outputs-complete" => Document(structure::outputs_missing),
        "outputs-none" => Document(structure::no_outputs),
        "derivatives" => Document(structure::derivatives),
        "derivatives-continuous" => Document(structure::derivatives_discrete),
        "derivatives-complete" => Document(structure::derivatives_missing),
        "initial-unknowns" => Document(structure::initial_unknowns),
        "initial-unknowns-sorted" => Document(structure::initial_unknowns_unsorted),
        "initial-unknowns-complete" => Document(structure::initial_unknowns_missing),
        "initial-unknowns-surplus" => Document(structure::initial_unknowns_surplus),
        "dependencies" => Document(dependencies::dependencies),
        "dependencies-sorted" => Document(dependencies::unsorted),
        "dependencies-known" => Document(dependencies::unknown),
        "dependencies-factor" => Document(dependencies::factors),
        "three-token" => Three(three::token),
        "three-version" => Three(three::version),
        "three-state" => Three(definitions::serialized_states),
        "display-unit-usable" => Remark(About::Limit),
        "three-usable" => Each(three::unusable),
        "three-reference" => Three(three::references),
        "three-independent" => Three(three::independent),
        "three-start" => Each(three::starts),
        "three-range" => Three(three::ranges),
        "three-declared" => Three(three::declared),
        "three-dimension" => Three(three::dimensions),
        "three-name" => Three(three::empty_names),
        "three-type-unique" => Three(|d| alike(d, "TypeDefinitions/*", &["name"])),
        "three-item-unique" => Three(|d| alike(d, "TypeDefinitions/EnumerationType/Item", &["name", "value"])),
        "three-variability" => Each(three::variabilities),
        "three-initial" => Each(variables::initial),
        "three-finite" => Each(three::not_finite),
        "three-derivative" => Three(three::derivatives),
        "three-reinit" => Three(definitions::reinit),
        "three-internal-step" => Three(three::internal_step),
        "three-clocks" => Three(three::clocks),
        "three-clock" => Three(three::timing),
        "three-initial-unknowns" => Three(three::initial_unknowns),
        "three-lists" => Three(three::lists),
        "three-outputs" => Three(three::outputs),
        "three-structure" => Three(three::structure),
        _ => Elsewhere,
    }
}

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

    #[test]
    fn each_line_is_that_of_a_row() {
        let lines =
            include_str!("rules.rs").lines().filter_map(|line| line.trim().strip_prefix('"')?.split_once("\" => "));
        let ids: Vec<&str> = lines.map(|(id, _)| id).filter(|id| !["error", "warning", "note"].contains(id)).collect();
        assert!(ids.len() > 80);
        ids.into_iter().for_each(|id| assert!(!matches!(named(id).find, Elsewhere), "{id}"));
    }

    #[test]
    fn sources_are_those_of_the_version() {
        let sources = |id: &str| [Version::Two, Version::Three].map(|version| named(id).source_in(version));
        assert_eq!(sources("range"), ["FMI 2.0.5, 2.2.7", "FMI 3.0.2, 2.4.7"]);
        assert_eq!(sources("variable-readable"), ["fmi2ScalarVariable.xsd", "fmi3Variable.xsd"]);
        assert_eq!(sources("output-finite"), ["a study would be wrong"; 2]);
    }
}
