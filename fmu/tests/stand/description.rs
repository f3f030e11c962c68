//! The stand's variable table and the model description that follows from it.

use fmu_export::description::{self, Interface, Version};
use fmu_export::model::{Kind, Model, Quantity, faults};
use plain_bearing_stand::stand::Stand;

#[test]
fn the_committed_descriptions_are_fresh() {
    for (path, text) in [
        (
            concat!(env!("CARGO_MANIFEST_DIR"), "/../modelDescription/modelDescription.xml"),
            description::xml::<Stand>(Version::Two, Interface::CoSimulation),
        ),
        (
            concat!(env!("CARGO_MANIFEST_DIR"), "/descriptions/fmi3.xml"),
            description::xml::<Stand>(Version::Three, Interface::CoSimulation),
        ),
        (
            concat!(env!("CARGO_MANIFEST_DIR"), "/descriptions/me.xml"),
            description::xml::<Stand>(Version::Two, Interface::ModelExchange),
        ),
        (
            concat!(env!("CARGO_MANIFEST_DIR"), "/descriptions/me-fmi3.xml"),
            description::xml::<Stand>(Version::Three, Interface::ModelExchange),
        ),
    ] {
        let committed = std::fs::read_to_string(path).unwrap_or_default();
        assert!(
            committed.replace("\r\n", "\n") == text,
            "{path} is stale: run `cargo run -p plain-bearing-stand --bin model-description`"
        );
    }
}

#[test]
fn the_declaration_is_sound() {
    assert_eq!(faults::<Stand>(), Vec::<String>::new());
}

/// Tools scale by nominal values and refuse values out of range, so every number has both.
#[test]
fn every_real_variable_has_a_range_and_a_nominal_value() {
    for variable in Stand::variables() {
        assert!(!variable.description.is_empty(), "{}", variable.name);
        if let Kind::Real(Quantity { min, max, nominal, .. }) = &variable.kind {
            let complete = min.is_some() && max.is_some() && nominal.is_some();
            assert!(complete, "{}", variable.name);
        }
    }
}
