//! Tests of the tolerant reader.

use super::*;

fn description(bytes: &[u8]) -> Result<Description, DescriptionError> {
    super::description(bytes, &[])
}

fn read(body: &str) -> Description {
    let xml = format!(
        "<?xml version=\"1.0\"?><fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" \
         guid=\"g\"><CoSimulation modelIdentifier=\"m\"/>{body}</fmiModelDescription>"
    );
    description(xml.as_bytes()).unwrap()
}

#[test]
fn declared_types_give_what_a_variable_leaves_out() {
    let description = read(
        r#"<TypeDefinitions><SimpleType name="Length"><Real unit="m" min="0" max="1"/></SimpleType>
        <SimpleType name="Film"><Enumeration><Item name="A" value="1"/><Item name="B" value="7"/></Enumeration></SimpleType>
        </TypeDefinitions><ModelVariables>
        <ScalarVariable name="c" valueReference="3" causality="parameter" variability="fixed">
          <Real declaredType="Length" max="0.5" start="0.1"/></ScalarVariable>
        <ScalarVariable name="film" valueReference="4"><Enumeration declaredType="Film" start="7"/></ScalarVariable>
        </ModelVariables>"#,
    );
    let Kind::Real { unit, min, max, start, .. } = &description.variables["c"].kind else { panic!("not a Real") };
    assert_eq!((unit.as_deref(), *min, *max, *start), (Some("m"), Some(0.0), Some(0.5), Some(0.1)));
    let Kind::Enumeration { items, start } = &description.variables["film"].kind else { panic!("not an Enumeration") };
    assert_eq!(items[1], ("B".to_owned(), 7));
    assert_eq!(*start, Some(7));
}

/// A state of the ball of the tests begins at its start value; its height is computed from a parameter.
#[test]
fn results_with_a_start_value_can_be_set() {
    let ball = description(include_bytes!("../../tests/fixtures/ball.xml")).unwrap();
    let settable = |name: &str| ball.variables[name].is_settable();
    assert!(settable("y") && !settable("h") && !settable("count") && !settable("der(y)"));
}

#[test]
fn a_relative_quantity_converts_without_offset() {
    let description = read(
        r#"<UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit></UnitDefinitions>
        <TypeDefinitions><SimpleType name="Rise"><Real unit="K" relativeQuantity="true"/></SimpleType></TypeDefinitions>
        <ModelVariables>
        <ScalarVariable name="rise" valueReference="1"><Real declaredType="Rise"/></ScalarVariable>
        <ScalarVariable name="level" valueReference="2"><Real unit="K"/></ScalarVariable>
        </ModelVariables>"#,
    );
    let kelvin = |name: &str| {
        let way = description.conversion("degC", &description.variables[name]);
        way.unwrap().value(10.0)
    };
    assert_eq!((kelvin("rise"), kelvin("level")), (10.0, 283.15));
}

/// A unit that is defined twice alike is one; of two meanings nobody knows the right one.
#[test]
fn a_unit_of_two_meanings_converts_to_none() {
    for (second, converts) in [("1e5", true), ("2e5", false)] {
        let description = read(&format!(
            r#"<UnitDefinitions><Unit name="Pa"><BaseUnit kg="1" m="-1" s="-2"/></Unit>
            <Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="1e5"/></Unit>
            <Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="{second}"/></Unit></UnitDefinitions>
            <ModelVariables><ScalarVariable name="p" valueReference="1"><Real unit="bar"/></ScalarVariable></ModelVariables>"#
        ));
        let way = |unit: &str| description.conversion(unit, &description.variables["p"]).ok();
        assert_eq!([way("Pa").is_some(), way("MPa").is_some()], [converts; 2], "{second}");
        assert_eq!(way("bar").map(|way| way.value(1.0)), Some(1.0));
    }
}

#[test]
fn foreign_parts_are_ignored_and_doubtful_ones_remarked() {
    let description = read(
        r#"<VendorAnnotations><Tool name="x"><any/></Tool></VendorAnnotations>
        <ModelVariables xmlns:v="http://example.org/v">
        <ScalarVariable name="a" valueReference="1" v:more="1" unknown="2"><Real start="abc"/>
          <Annotations><Tool name="y"/></Annotations></ScalarVariable>
        <ScalarVariable name="a" valueReference="2"><Real/></ScalarVariable>
        <ScalarVariable name="b"><Real/></ScalarVariable>
        </ModelVariables>"#,
    );
    assert_eq!(description.variables.len(), 1);
    assert_eq!(description.variables["a"].value_reference, 1);
    assert_eq!(description.remarks.len(), 3, "{:?}", description.remarks);
}

#[test]
fn latin_1_and_byte_order_marks_are_understood() {
    let xml = "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><fmiModelDescription \
               fmiVersion=\"2.0\" modelName=\"K\u{e4}lte\" guid=\"g\">\
               <CoSimulation modelIdentifier=\"m\"/></fmiModelDescription>";
    let latin: Vec<u8> = xml.chars().map(|c| c as u8).collect();
    assert_eq!(description(&latin).unwrap().model_name, "Kälte");
    let utf8 = xml.replace("ISO-8859-1", "UTF-8");
    let marked = [b"\xef\xbb\xbf", utf8.as_bytes()].concat();
    assert_eq!(description(&marked).unwrap().model_name, "Kälte");
    let mut utf16 = vec![0xff, 0xfe];
    utf16.extend(utf8.encode_utf16().flat_map(u16::to_le_bytes));
    let read = description(&utf16).unwrap();
    assert_eq!(read.model_name, "Kälte");
    // The bytes are not what the declaration says.
    assert_eq!(read.remarks.len(), 1, "{:?}", read.remarks);
    assert_eq!(read.remarks[0].about, About::Encoding);
    for declaration in [" encoding=\"UTF-16\"", ""] {
        let declared = utf8.replace(" encoding=\"UTF-8\"", declaration);
        assert_ne!(declared, utf8);
        // Without a mark, too: the first character tells.
        let bytes: Vec<u8> = declared.encode_utf16().flat_map(u16::to_be_bytes).collect();
        let read = description(&bytes).unwrap();
        assert_eq!((read.model_name.as_str(), read.remarks.len()), ("Kälte", 0));
    }
}

#[test]
fn other_kinds_of_fmu_are_refused_by_name() {
    let version = description(b"<fmiModelDescription fmiVersion=\"4.0\"/>").unwrap_err();
    assert!(version.to_string().contains("FMI 4.0"), "{version}");
    let exchange = description(b"<fmiModelDescription fmiVersion=\"2.0\"/>").unwrap_err();
    assert!(matches!(exchange, DescriptionError::NoInterface(_)));
    assert!(matches!(description(b"<html/>"), Err(DescriptionError::Root(_))));
}

#[test]
fn entity_bombs_are_refused() {
    let bomb = b"<!DOCTYPE x [<!ENTITY a \"aaaaaaaaaa\"><!ENTITY b \"&a;&a;&a;\">]>\
        <fmiModelDescription fmiVersion=\"2.0\" modelName=\"&b;\"/>";
    assert!(matches!(description(bomb), Err(DescriptionError::Xml(XmlError::DocumentType))));
}

#[test]
fn states_that_the_structure_does_not_list_are_counted_by_their_derivatives() {
    let read = |structure: &str| {
        let xml = format!(
            r#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g" numberOfEventIndicators="3">
            <ModelExchange modelIdentifier="m"/><ModelVariables>
            <ScalarVariable name="x" valueReference="1"><Real/></ScalarVariable>
            <ScalarVariable name="v" valueReference="2"><Real derivative="1"/></ScalarVariable>
            <ScalarVariable name="alias" valueReference="2"><Real derivative="1"/></ScalarVariable>
            <ScalarVariable name="a" valueReference="3"><Real derivative="2"/></ScalarVariable>
            </ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"#
        );
        let read = description(xml.as_bytes()).unwrap();
        (read.exchange.states, read.exchange.indicators, read.remarks.len())
    };
    assert_eq!(read(""), (2, 3, 1));
    let listed = r#"<Derivatives><Unknown index="2"/><Unknown index="4"/></Derivatives>"#;
    assert_eq!(read(listed), (2, 3, 0));
}
