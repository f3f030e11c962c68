//! The model description and the check of a model's declaration.
#![allow(clippy::unwrap_used)]

use fmu_export::declare::{input, output, parameter, tunable};
use fmu_export::description::{Interface, Version, fingerprint, token, xml};
use fmu_export::model::{Base, Experiment, Fault, Info, Log, Model, Unit, Variable, faults};
use fmu_export::{field, units};
use lag::Lag;
use serde::{Deserialize, Serialize};

#[test]
fn texts_are_escaped_and_types_complete() {
    let xml = xml::<Lag>(Version::Two, Interface::CoSimulation);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let node = |name: &str| {
        document
            .descendants()
            .find(|node| node.attribute("name") == Some(name))
            .unwrap()
    };
    assert_eq!(
        node("label").attribute("description"),
        Some("A name with <&\"> in it")
    );
    assert_eq!(
        node("trouble")
            .first_element_child()
            .unwrap()
            .attribute("declaredType"),
        Some("Trouble")
    );
    let outputs = document
        .descendants()
        .find(|node| node.has_tag_name("Outputs"))
        .unwrap();
    let feed = outputs
        .children()
        .find(|node| node.attribute("index") == Some("6"))
        .unwrap();
    assert_eq!(feed.attribute("dependencies"), Some("1 8"));
}

#[test]
fn a_guid_has_the_usual_form() {
    assert_eq!(token(1), "{00000000-0000-0000-0000-000000000001}");
}

const HENRY: Unit = Unit {
    name: "H",
    base: Base {
        kg: 1,
        m: 2,
        s: -2,
        a: -2,
        ..Base::ONE
    },
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
    output(
        "flux [Wb]",
        &units::ONE,
        |coil: &Coil| coil.inductance * coil.current,
        "Flux",
    )
    .depends_on(&["current"]),
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
        (
            "generationTool",
            Some(concat!("fmu-export ", env!("CARGO_PKG_VERSION"))),
        ),
        // The flux's name is no path of identifiers.
        ("variableNamingConvention", Some("flat")),
        ("guid", Some(guid.as_str())),
    ] {
        assert_eq!(root.attribute(attribute), value, "{attribute}");
    }
    let base = |unit: &str| {
        let mut units = document
            .descendants()
            .filter(|node| node.has_tag_name("Unit"));
        let unit = units
            .find(|node| node.attribute("name") == Some(unit))
            .unwrap();
        let base = unit.first_element_child().unwrap();
        Vec::from_iter(
            base.attributes()
                .map(|a| (a.name().to_owned(), a.value().to_owned())),
        )
    };
    let named = |pairs: &[(&str, &str)]| {
        Vec::from_iter(
            pairs
                .iter()
                .map(|(name, value)| (name.to_string(), value.to_string())),
        )
    };
    assert_eq!(base("A"), named(&[("A", "1")]));
    assert_eq!(
        base("H"),
        named(&[("kg", "1"), ("m", "2"), ("s", "-2"), ("A", "-2")])
    );
}

#[test]
fn the_listing_changes_the_order_but_no_reference() {
    assert_eq!(faults::<Coil>(), Vec::<String>::new());
    let xml = xml::<Coil>(Version::Two, Interface::CoSimulation);
    let document = roxmltree::Document::parse(&xml).unwrap();
    let variables = document
        .descendants()
        .filter(|node| node.has_tag_name("ScalarVariable"));
    let listed = variables.map(|node| (node.attribute("name"), node.attribute("valueReference")));
    assert_eq!(
        Vec::from_iter(listed),
        [
            (Some("inductance"), Some("2")),
            (Some("current"), Some("0")),
            (Some("flux [Wb]"), Some("1")),
        ]
    );
    let mut unknowns = document
        .descendants()
        .filter(|node| node.has_tag_name("Unknown"));
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
        Self {
            value: 7.0,
            other: f64::NAN,
        }
    }
}

const ODD_SECOND: Unit = Unit {
    base: Base::ONE,
    ..units::SECOND
};

static ODD: [Variable<Odd>; 5] = [
    parameter("value", &units::SECOND, field!(Odd: value), "Out of range").within(0.0, 1.0),
    parameter(
        "value",
        &ODD_SECOND,
        field!(Odd: value),
        "The same name, another unit",
    ),
    parameter("other", &units::ONE, field!(Odd: other), "Not a number").about(-1.0),
    output(
        "shown",
        &units::ONE,
        |odd: &Odd| odd.value,
        "No such display unit",
    )
    .shown_in("furlong")
    .depends_on(&["other"]),
    input("slope", &units::ONE, field!(Odd: value), "An empty range")
        .within(9.0, 5.0)
        .derivative(|odd| odd.value),
];

impl Model for Odd {
    const INFO: Info = Info {
        identifier: "1st",
        default_step: 0.0,
        ..fmu_export::info!()
    };

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
