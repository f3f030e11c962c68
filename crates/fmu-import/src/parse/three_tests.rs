use super::*;
use crate::{
    description::Causality,
    parse::description,
    value::{Content, Value},
    version::Version,
};

fn read(variables: &str) -> Description {
    let xml = format!(
        r#"<fmiModelDescription fmiVersion="3.0" modelName="M" instantiationToken="token">
        <CoSimulation modelIdentifier="m" canGetAndSetFMUState="true" hasEventMode="true"/>
        <UnitDefinitions><Unit name="s"><BaseUnit s="1"/><DisplayUnit name="Hz" inverse="true"/>
        <DisplayUnit name="ms" factor="1000"/></Unit></UnitDefinitions>
        <TypeDefinitions>
        <Float64Type name="Time" unit="s" displayUnit="ms" min="0"/>
        <EnumerationType name="Way"><Item name="up" value="-1"/><Item name="down" value="2"/></EnumerationType>
        </TypeDefinitions>
        <ModelVariables>{variables}</ModelVariables></fmiModelDescription>"#
    );
    description(xml.as_bytes(), &[]).unwrap()
}

#[test]
fn the_head_of_a_description() {
    let read = read(r#"<Float64 name="time" valueReference="0" causality="independent"/>"#);
    assert_eq!(read.standard, Version::Three);
    assert_eq!(read.guid, "token");
    assert!(read.capabilities.can_get_and_set_fmu_state && read.capabilities.has_event_mode);
    // The inverse display unit is left out with a word on it: factor and offset would say something wrong.
    assert_eq!(read.remarks.len(), 1, "{:?}", read.remarks);
    assert!(read.remarks[0].text.contains("inverse"));
    assert!(read.units.conversion("Hz", Some("s")).is_err());
    assert_eq!(read.variables["time"].causality, Causality::Independent);
}

#[test]
fn types_with_their_ranges_and_starts() {
    let read = read(
        r#"<Float32 name="f" valueReference="1" causality="parameter" declaredType="Time" start="0.5"/>
        <UInt8 name="u" valueReference="2" causality="input" start="7"/>
        <Int64 name="i" valueReference="3" causality="output" max="9007199254740993"/>
        <UInt64 name="w" valueReference="4" causality="local" start="18446744073709551615"/>
        <Boolean name="b" valueReference="5" causality="parameter" start="true"/>
        <String name="s" valueReference="6" causality="parameter"><Start value="two words"/></String>
        <Enumeration name="e" valueReference="7" causality="parameter" declaredType="Way" start="-1"/>"#,
    );
    let all = &read.variables;
    let Kind::Real { unit, min, start, .. } = &all["f"].kind else { panic!() };
    assert_eq!((unit.as_deref(), *min, *start), (Some("s"), Some(0.0), Some(0.5)));
    assert_eq!(all["f"].variability, Variability::Tunable);
    assert_eq!(all["f"].place.unwrap().storage, Storage::Float32);
    assert_eq!(all["u"].kind.range(), (Some(0.0), Some(255.0)));
    assert_eq!(all["u"].variability, Variability::Discrete);
    let Kind::Integer { max, .. } = all["i"].kind else { panic!() };
    assert_eq!(max, Some(9_007_199_254_740_993));
    let Kind::Integer { start, .. } = all["w"].kind else { panic!() };
    assert_eq!(start, Some(u64::MAX.into()));
    assert_eq!(all["b"].kind.start(), Some(1.0));
    let Kind::String { start } = &all["s"].kind else { panic!() };
    assert_eq!(start.as_deref(), Some("two words"));
    let Kind::Enumeration { items, start } = &all["e"].kind else { panic!() };
    assert_eq!((items[0].1, *start), (-1, Some(-1)));
    assert_eq!(all["e"].handle().content, Content::Integer);
}

#[test]
fn arrays_become_elements() {
    let read = read(
        r#"<UInt64 name="n" valueReference="1" causality="structuralParameter" start="3"/>
        <Float64 name="A" valueReference="2" causality="parameter" start="1 2 3 4 5 6">
          <Dimension start="2"/><Dimension valueReference="1"/></Float64>
        <Float64 name="x" valueReference="3" causality="input" start="9"><Dimension valueReference="1"/>
          <Alias name="y" description="the same"/></Float64>
        <Float64 name="bad" valueReference="4" start="1 2"><Dimension start="3"/></Float64>
        <Float64 name="none" valueReference="5"><Dimension start="0"/></Float64>
        <Float64 name="huge" valueReference="6"><Dimension start="99999999"/><Dimension start="99999999999999"/></Float64>
        <Float64 name="open" valueReference="7"><Dimension valueReference="77"/></Float64>
        <Int8 name="last" valueReference="8"/>"#,
    );
    let all = &read.variables;
    let start = |name: &str| all[name].kind.start();
    assert_eq!(start("A[1,1]"), Some(1.0));
    assert_eq!(start("A[1,3]"), Some(3.0));
    assert_eq!(start("A[2,1]"), Some(4.0));
    assert_eq!(start("A[2,3]"), Some(6.0));
    assert_eq!([start("x[1]"), start("x[3]"), start("y[2]")], [Some(9.0); 3]);
    assert_eq!(all["y[2]"].handle(), all["x[2]"].handle());
    assert_eq!(all["y[2]"].description.as_deref(), Some("the same"));
    assert_eq!(start("bad[1]"), None);
    let place = all["A[2,3]"].place.unwrap();
    assert_eq!((place.number, place.index, place.of), (1 + 5, 5, 6));
    assert!(!all.contains_key("none[1]") && !all.contains_key("n[1]"));
    assert!(read.unusable["huge"].contains("more than"));
    assert!(read.unusable["open"].contains("not known"));
    // No two variables share a number unless they are the same.
    let numbers: std::collections::HashSet<u32> = all
        .values()
        .filter(|variable| !variable.name.starts_with('y'))
        .map(|variable| variable.handle().reference)
        .collect();
    assert_eq!(numbers.len(), all.len() - 3);
}

#[test]
fn clocks_bytes_and_what_belongs_to_them() {
    let variables = r#"<Binary name="data" valueReference="1" causality="input"><Start value="0AfF"/></Binary>
        <Binary name="bad" valueReference="2" causality="input"><Start value="0x1"/></Binary>
        <Clock name="tick" valueReference="3" causality="input" intervalVariability="constant" resolution="3" intervalCounter="2" intervalDecimal="0.6" shiftDecimal="0.5"/>
        <Clock name="push" valueReference="4" causality="input" intervalVariability="triggered"/>
        <Int32 name="n" valueReference="5" causality="input" clocks="3 4" start="0"/>
        <Int128 name="wide" valueReference="6"/>"#;
    let all = read(variables);
    let start = |name: &str| all.variables[name].kind.start_value();
    assert_eq!(start("data"), Some(Value::String("0aff".to_owned())));
    assert_eq!(start("bad"), None);
    let Kind::Clock(timing) = all.variables["tick"].kind else { panic!() };
    assert_eq!((timing.interval, timing.shift), (Some(2.0 / 3.0), Some(0.5)));
    assert!(!all.variables["tick"].is_settable() && all.variables["push"].is_settable());
    assert_eq!(all.variables["n"].clocks, [3, 4]);
    assert_eq!(all.unusable.keys().collect::<Vec<_>>(), ["wide"]);
    // Without event mode no clock ticks.
    let xml = format!(
        r#"<fmiModelDescription fmiVersion="3.0"><CoSimulation modelIdentifier="m"/>
        <ModelVariables>{variables}</ModelVariables></fmiModelDescription>"#
    );
    let silent = description(xml.as_bytes(), &[]).unwrap();
    assert!(silent.unusable["tick"].contains("event mode"));
}

#[test]
fn sizes_replace_those_of_the_file() {
    let xml = r#"<fmiModelDescription fmiVersion="3.0"><CoSimulation modelIdentifier="m"/><ModelVariables>
        <UInt64 name="n" valueReference="1" causality="structuralParameter" start="2"/>
        <Float64 name="x" valueReference="2" causality="parameter" start="1 2"><Dimension valueReference="1"/></Float64>
        </ModelVariables></fmiModelDescription>"#;
    let read = description(xml.as_bytes(), &[(1, 3)]).unwrap();
    assert_eq!(read.variables["n"].kind.start(), Some(3.0));
    assert_eq!(read.variables["x[3]"].place.unwrap().of, 3);
    assert_eq!(read.variables["x[1]"].kind.start(), None);
    assert!(read.remarks.is_empty(), "{:?}", read.remarks);
}

#[test]
fn whole_numbers_are_kept_up_to_the_width_of_their_type() {
    let read = read(
        r#"<UInt64 name="most" valueReference="1" start="18446744073709551615" max="18446744073709551615"/>
        <Int64 name="over" valueReference="2" start="18446744073709551615"/>
        <UInt64 name="list" valueReference="3" start="7 9223372036854775808"><Dimension start="2"/></UInt64>"#,
    );
    let whole = |name: &str| match read.variables[name].kind {
        Kind::Integer { start, min, max } => (start, min, max),
        _ => panic!("not a whole number"),
    };
    let most = Some(u64::MAX.into());
    assert_eq!(whole("most"), (most, Some(0), most));
    assert_eq!(whole("list[1]").0, Some(7));
    assert_eq!(whole("list[2]").0, Some(1 << 63));
    assert_eq!(whole("over").0, None);
    // A number that its own type cannot hold is remarked.
    let start = |remark: &&crate::description::Remark| remark.text.contains("start");
    assert_eq!(read.remarks.iter().filter(start).count(), 1);
}

#[test]
fn other_interfaces_are_named() {
    let with = |interfaces: &str| {
        let xml = format!(r#"<fmiModelDescription fmiVersion="3.0">{interfaces}</fmiModelDescription>"#);
        description(xml.as_bytes(), &[]).unwrap_err().to_string()
    };
    assert!(with("<ScheduledExecution/>").contains("Scheduled Execution only"));
    assert!(with("").contains("neither of the two"));
}
