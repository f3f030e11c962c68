//! The model description and the check of a model's declaration.
#![allow(clippy::unwrap_used)]

use fmu_export::declare::{input, output, parameter, tunable, variable};
use fmu_export::description::{Interface, Version, fingerprint, token, xml};
use fmu_export::model::{
    BaseExponents, Events, Experiment, Fault, Info, Kind, Log, Model, Role, Unit, Variable, faults,
};
use fmu_export::{field, text, units};
use lag::Lag;
use serde::{Deserialize, Serialize};

#[test]
fn texts_are_escaped_and_types_complete() {
    let xml = xml::<Lag>(Version::Two, Interface::CoSimulation);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let node = |name: &str| document.descendants().find(|node| node.attribute("name") == Some(name)).unwrap();
    assert_eq!(node("label").attribute("description"), Some("A name with <&\"> in it"));
    assert_eq!(node("trouble").first_element_child().unwrap().attribute("declaredType"), Some("Trouble"));
    let outputs = document.descendants().find(|node| node.has_tag_name("Outputs")).unwrap();
    let feed = outputs.children().find(|node| node.attribute("index") == Some("6")).unwrap();
    assert_eq!(feed.attribute("dependencies"), Some("1 8"));
}

#[test]
fn a_guid_has_the_usual_form() {
    assert_eq!(token(1), "{00000000-0000-0000-0000-000000000001}");
}

const HENRY: Unit = Unit {
    name: "H",
    base: BaseExponents { kg: 1, m: 2, s: -2, a: -2, ..BaseExponents::ONE },
    display: &[],
    relative: false,
};

/// A model whose description says something of everything.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Coil {
    current: f64,
    inductance: f64,
}

static COIL: [Variable<Coil>; 3] = [
    input("current", &units::AMPERE, field!(Coil: current), "Current").shown_in("mA"),
    output("flux [Wb]", &units::ONE, |coil: &Coil| coil.inductance * coil.current, "Flux").depends_on(&["current"]),
    tunable("inductance", &HENRY, field!(Coil: inductance), "Inductance"),
];

impl Model for Coil {
    const INFO: Info = Info {
        version: "2.5",
        copyright: "(c) Joseph Henry",
        author: "Joseph Henry",
        license: "",
        ..fmu_export::info!()
    };

    fn variables() -> &'static [Variable<Self>] {
        &COIL
    }

    fn listing() -> Vec<usize> {
        vec![2, 0, 1]
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }
}

#[test]
fn the_models_own_words_are_in_its_description() {
    let guid = token(fingerprint::<Coil>(Version::Two, Interface::CoSimulation));
    let xml = xml::<Coil>(Version::Two, Interface::CoSimulation);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let root = document.root_element();
    for (attribute, value) in [
        ("modelName", Some("fmu-export")),
        ("version", Some("2.5")),
        ("author", Some("Joseph Henry")),
        ("copyright", Some("(c) Joseph Henry")),
        ("license", None),
        ("generationTool", Some(concat!("fmu-export ", env!("CARGO_PKG_VERSION")))),
        // The flux's name is no path of identifiers.
        ("variableNamingConvention", Some("flat")),
        ("guid", Some(guid.as_str())),
    ] {
        assert_eq!(root.attribute(attribute), value, "{attribute}");
    }
    let base = |unit: &str| {
        let mut units = document.descendants().filter(|node| node.has_tag_name("Unit"));
        let unit = units.find(|node| node.attribute("name") == Some(unit)).unwrap();
        let base = unit.first_element_child().unwrap();
        Vec::from_iter(base.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())))
    };
    let named = |pairs: &[(&str, &str)]| {
        Vec::from_iter(pairs.iter().map(|(name, value)| (name.to_string(), value.to_string())))
    };
    assert_eq!(base("A"), named(&[("A", "1")]));
    assert_eq!(base("H"), named(&[("kg", "1"), ("m", "2"), ("s", "-2"), ("A", "-2")]));
}

#[test]
fn the_listing_changes_the_order_but_no_reference() {
    assert_eq!(faults::<Coil>(), Vec::<String>::new());
    let xml = xml::<Coil>(Version::Two, Interface::CoSimulation);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let variables = document.descendants().filter(|node| node.has_tag_name("ScalarVariable"));
    let listed = variables.map(|node| (node.attribute("name"), node.attribute("valueReference")));
    assert_eq!(
        Vec::from_iter(listed),
        [(Some("inductance"), Some("2")), (Some("current"), Some("0")), (Some("flux [Wb]"), Some("1")),]
    );
    let mut unknowns = document.descendants().filter(|node| node.has_tag_name("Unknown"));
    // Indices count from 1 in the order of the listing: at the start the flux depends on the inductance, too.
    for dependencies in ["2", "1 2"] {
        let flux = unknowns.next().unwrap();
        assert_eq!(flux.attribute("index"), Some("3"));
        assert_eq!(flux.attribute("dependencies"), Some(dependencies));
    }
}

/// A model with mistakes.
#[derive(Clone, Serialize, Deserialize)]
struct Odd {
    value: f64,
    /// Serde skips it: fine, as the default stands in.
    #[serde(skip)]
    other: f64,
}

impl Default for Odd {
    fn default() -> Self {
        Self { value: 7.0, other: f64::NAN }
    }
}

const ODD_SECOND: Unit = Unit { base: BaseExponents::ONE, ..units::SECOND };

static ODD: [Variable<Odd>; 5] = [
    parameter("value", &units::SECOND, field!(Odd: value), "Out of range").within(0.0, 1.0),
    parameter("value", &ODD_SECOND, field!(Odd: value), "The same name, another unit"),
    parameter("other", &units::ONE, field!(Odd: other), "Not a number").about(-1.0),
    output("shown", &units::ONE, |odd: &Odd| odd.value, "No such display unit")
        .shown_in("furlong")
        .depends_on(&["other"]),
    input("slope", &units::ONE, field!(Odd: value), "An empty range").within(9.0, 5.0).derivative(|odd| odd.value),
];

impl Model for Odd {
    const INFO: Info = Info { identifier: "1st", default_step: 0.0, ..fmu_export::info!() };

    fn variables() -> &'static [Variable<Self>] {
        &ODD
    }

    fn listing() -> Vec<usize> {
        vec![0, 1, 1, 2, 3]
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn restore(&mut self, _: &[u8]) -> Result<(), Fault> {
        Err(Fault::Invalid("never".to_owned()))
    }
}

#[test]
fn mistakes_in_a_declaration_are_found() {
    assert_eq!(faults::<Lag>(), Vec::<String>::new());
    assert_eq!(
        faults::<Odd>(),
        [
            "the identifier \"1st\" is not a C identifier",
            "default_step = 0: it must be a number above 0",
            "the listing does not name every variable once",
            "value: two variables have this name",
            "shown: it depends on \"other\", which is not an input",
            "there are two units s",
            "value: its start value 7.0 is out of its range",
            "other: its start value, range and nominal value must be finite",
            "other: its nominal value must be above 0",
            "shown: furlong is not a display unit of 1",
            "slope: its range from 9.0 to 5.0 is empty",
            "slope: its start value 7.0 is out of its range",
            "slope: only outputs have derivatives",
            "a state that is saved and restored: never",
        ]
    );
}

/// Two pipes: arrays of texts and numbers.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Pipes {
    names: [String; 2],
    flows: [f64; 2],
}

static PIPES: [Variable<Pipes>; 6] = [
    variable("name[1]", Role::Parameter, Kind::String { access: text!(Pipes: names[0]) }, "A name").array(2),
    variable("name[2]", Role::Parameter, Kind::String { access: text!(Pipes: names[1]) }, "A name"),
    input("flow[1]", &units::ONE, field!(Pipes: flows[0]), "A flow").array(2),
    input("flow[2]", &units::ONE, field!(Pipes: flows[1]), "A flow"),
    output("out[1]", &units::ONE, |pipes: &Pipes| pipes.flows[0], "The same").array(2),
    output("out[2]", &units::ONE, |pipes: &Pipes| pipes.flows[1], "The same").depends_on(&["flow[2]"]),
];

impl Model for Pipes {
    const INFO: Info = fmu_export::info!();

    fn variables() -> &'static [Variable<Self>] {
        &PIPES
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }
}

#[test]
fn arrays_are_one_variable_in_fmi_3_and_several_in_fmi_2() {
    assert_eq!(faults::<Pipes>(), Vec::<String>::new());
    let [two, three] = [Version::Two, Version::Three].map(|version| xml::<Pipes>(version, Interface::CoSimulation));
    assert_eq!(two.matches("<ScalarVariable ").count(), 6);
    assert!(!two.contains("Dimension"));
    for line in [r#"<Unknown index="5" dependencies=""/>"#, r#"<Unknown index="6" dependencies="4"/>"#] {
        assert!(two.contains(line), "{two}");
    }
    let document = roxmltree::Document::parse(&three).unwrap();
    let named = |name: &str| {
        let mut nodes = document.descendants();
        nodes.find(|node| node.attribute("name") == Some(name)).unwrap()
    };
    let children = |name: &str| -> Vec<String> {
        let children = named(name).children().filter(roxmltree::Node::is_element);
        let text = |node: roxmltree::Node<'_, '_>| {
            let value = node.attribute("value").or(node.attribute("start"));
            format!("{} {}", node.tag_name().name(), value.unwrap())
        };
        children.map(text).collect()
    };
    assert_eq!(children("name"), ["Dimension 2", "Start ", "Start "]);
    assert_eq!(children("flow"), ["Dimension 2"]);
    assert_eq!(named("flow").attribute("start"), Some("0.0 0.0"));
    assert_eq!(named("out").attribute("valueReference"), Some("4"));
    assert!(three.contains(r#"<Output valueReference="4" dependencies="2"/>"#), "{three}");
    assert!(!three.contains("name=\"out[2]\"") && !three.contains("valueReference=\"5\""));
}

/// Arrays, clocks and indicators with mistakes.
#[derive(Clone, Default, Serialize, Deserialize)]
struct Torn(f64);

const BEAT: Kind<Torn> = Kind::Clock { ticked: |_| false };

static TORN: [Variable<Torn>; 9] = [
    output("one[1]", &units::ONE, |torn: &Torn| torn.0, "An array").array(2),
    output("one[3]", &units::ONE, |torn: &Torn| torn.0, "The wrong number"),
    variable("tick", Role::Local, Kind::Clock { ticked: |_| false }, "No output"),
    parameter("set", &units::ONE, field!(Torn: 0), "Not computed").clocked("tick"),
    output("range[1]", &units::ONE, |torn: &Torn| torn.0, "In part").within(0.0, 1.0).array(2),
    output("range[2]", &units::ONE, |torn: &Torn| torn.0, "Without"),
    variable("beat[1]", Role::Output, BEAT, "Clocks are scalars").array(2),
    variable("beat[2]", Role::Output, BEAT, "Clocks are scalars"),
    output("long[1]", &units::ONE, |torn: &Torn| torn.0, "Too long").array(2),
];

impl Model for Torn {
    const INFO: Info = fmu_export::info!();

    const INNER_STEP: Option<fn(&Self, f64) -> f64> = Some(|_, step| step);

    const EVENTS: Option<Events<Self>> = Some(Events {
        indicators: &["one[1]", "none"],
        next: |_| None,
        until: |torn, time, step, _| match torn.0 {
            12.0 => Ok(None),
            10.0 => Ok(Some(step)),
            // No time, and a time in place of seconds.
            20.0 => Ok(Some(f64::NAN)),
            30.0 => Ok(Some(time + step)),
            // Too little to be seen in the time.
            _ => Ok(Some(1e-20)),
        },
        handle: |torn| {
            torn.0 += if torn.0 < 10.0 { 0.0 } else { 1.0 };
            Ok(true)
        },
    });

    fn variables() -> &'static [Variable<Self>] {
        &TORN
    }

    fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
        Ok(())
    }

    fn advance(&mut self, time: f64, step: f64, log: &mut dyn Log) -> Result<(), Fault> {
        self.0 += 1.0;
        Self::EVENTS.unwrap().pass(self, time, step, log)
    }
}

#[test]
fn mistakes_in_arrays_and_events_are_found() {
    let found = faults::<Torn>();
    let ends = "of an array stand in the table as name[1], name[2], ..., with the same role, type, unit, range and clock, and are no clocks";
    let expected = [
        "tick: a clock must be an output, and the model have events",
        "set: the model must compute what ticks with a clock, and \"tick\" must be one",
        "a model with events has no INNER_STEP",
        "none: an indicator is a real variable, also in Model Exchange",
        &format!("one[1]: the 2 elements {ends}"),
        "one: an array's elements are left out or are indicators all in their order, or none",
        &format!("range[1]: the 2 elements {ends}"),
        &format!("beat[1]: the 2 elements {ends}"),
        &format!("long[1]: the 2 elements {ends}"),
    ];
    assert_eq!(found, expected);
}

#[test]
fn events_without_an_end_fail_the_step() {
    let mut torn = Torn::default();
    let failed = torn.advance(1.0, 2.0, &mut ());
    assert!(matches!(failed, Err(Fault::Failed(why)) if why.starts_with("the events at 1 s do not end")));
}

/// The event at the end of a step makes another one due.
#[test]
fn a_step_ends_after_all_events_of_its_end() {
    let mut torn = Torn(9.0);
    torn.advance(1.0, 2.0, &mut ()).unwrap();
    assert_eq!(torn.0, 12.0);
}

#[test]
fn a_stop_outside_the_step_is_refused() {
    for (start, passed) in [(19.0, "NaN"), (29.0, "3")] {
        let failed = Torn(start).advance(1.0, 2.0, &mut ());
        let expected = format!("`until` has stopped after {passed} s of a step of 2 s from 1 s");
        assert!(matches!(failed, Err(Fault::Failed(why)) if why == expected));
    }
}
