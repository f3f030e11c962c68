//! `fmi-schema` of rust-fmi, which others wrote, reads the descriptions of FMI 2.0; and which legal ones it refuses
//! (`docs/evidence/refusals.md` reports them to its authors).
#![allow(clippy::unwrap_used)]

use fmi_schema::fmi2::{Fmi2ModelDescription, ScalarVariableElement};
use fmi_schema::fmi3::Fmi3ModelDescription;
use fmu_export::description::{Interface, Version, fingerprint, token, xml};
use fmu_export::model::{Continuous, Model};
use lag::Lag;

fn finds_each_declared_variable(interface: Interface) {
    let text = xml::<Lag>(Version::Two, interface);
    let read: Fmi2ModelDescription = fmi_schema::deserialize(&text).unwrap();
    assert_eq!(read.guid, token(fingerprint::<Lag>(Version::Two, interface)));
    let is_exchanged = interface == Interface::ModelExchange;
    assert_eq!((read.co_simulation.is_some(), read.model_exchange.is_some()), (!is_exchanged, is_exchanged));
    let left_out = if is_exchanged { Lag::without() } else { &[] };
    for declared in Lag::variables().iter().filter(|variable| !left_out.contains(&variable.name)) {
        let found = read.model_variables.variables.iter().find(|found| found.name == declared.name);
        let found = found.unwrap_or_else(|| panic!("{} is missing", declared.name));
        assert_eq!(found.description.as_deref(), Some(declared.description), "{}", declared.name);
        let type_name = match found.elem {
            ScalarVariableElement::Real(_) => "Real",
            ScalarVariableElement::Integer(_) => "Integer",
            ScalarVariableElement::Boolean(_) => "Boolean",
            ScalarVariableElement::String => "String",
            ScalarVariableElement::Enumeration => "Enumeration",
        };
        assert_eq!(type_name, declared.type_name(), "{}", declared.name);
    }
}

#[test]
fn it_reads_what_is_written() {
    finds_each_declared_variable(Interface::CoSimulation);
    finds_each_declared_variable(Interface::ModelExchange);
}

fn two(root: &str, variable: &str, after_type: &str) -> Result<(), String> {
    let text = format!(
        r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"{root}><CoSimulation modelIdentifier="m"/><ModelVariables>
<ScalarVariable name="x" valueReference="0"{variable}><Real/>{after_type}</ScalarVariable></ModelVariables><ModelStructure/>
</fmiModelDescription>"#
    );
    let read: Result<Fmi2ModelDescription, _> = fmi_schema::deserialize(&text);
    read.map(drop).map_err(|error| error.to_string())
}

fn three(base: &str, variable: &str) -> Result<(), String> {
    let text = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t"><CoSimulation modelIdentifier="m"/>
<UnitDefinitions><Unit name="u"><BaseUnit{base}/></Unit></UnitDefinitions>
<ModelVariables><Float64 name="x" valueReference="0"{variable}/></ModelVariables><ModelStructure/></fmiModelDescription>"#
    );
    let read: Result<Fmi3ModelDescription, _> = fmi_schema::deserialize(&text);
    read.map(drop).map_err(|error| error.to_string())
}

/// Where a newer version reads one of these, its row in `docs/evidence/refusals.md` goes.
#[test]
fn what_it_refuses_is_what_the_report_says() {
    let unknown = |field: &str, element: &str| Err(format!("unknown field \"{field}\" in element \"{element}\""));
    assert_eq!(two("", "", ""), Ok(()));
    let space = r#" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance""#;
    assert_eq!(two(space, "", ""), unknown("xmlns:xsi", "Fmi2ModelDescription"));
    let multiple = "canHandleMultipleSetPerTimeInstant";
    assert_eq!(two("", &format!(r#" {multiple}="true""#), ""), unknown(multiple, "ScalarVariable"));
    let annotations = r#"<Annotations><Tool name="t"/></Annotations>"#;
    assert_eq!(two("", "", annotations), unknown("Annotations", "ScalarVariable"));
    assert_eq!(three("", ""), Ok(()));
    for base in ["A", "K"] {
        assert_eq!(three(&format!(r#" {base}="1""#), ""), unknown(base, "BaseUnit"));
    }
    for (attribute, value) in [("unit", "u"), ("displayUnit", "d"), ("relativeQuantity", "true"), ("nominal", "2")] {
        assert_eq!(three("", &format!(r#" {attribute}="{value}""#)), unknown(attribute, "FmiFloat64"));
    }
}
