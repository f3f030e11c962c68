//! The stand's variable table and the model description that follows from it.
#![allow(clippy::unwrap_used)]

use fmu_export::fmi2::description::xml;
use fmu_export::model::{Kind, Model};
use plain_bearing_stand::stand::Stand;

#[test]
fn the_committed_description_is_fresh() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../modelDescription/modelDescription.xml"
    );
    let committed = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        committed.replace("\r\n", "\n") == xml::<Stand>(),
        "{path} is stale: run `cargo run -p plain-bearing-stand --bin model-description`"
    );
}

/// What holds for every sound table, shown on the stand's.
#[test]
fn the_stands_table_is_sound() {
    let initial = Stand::default();
    let mut names = std::collections::HashSet::new();
    for variable in Stand::variables() {
        assert!(names.insert(variable.name), "{} twice", variable.name);
        assert!(!variable.description.is_empty(), "{}", variable.name);
        if let Kind::Real {
            access,
            unit,
            display,
            min,
            max,
            nominal,
            ..
        } = &variable.kind
        {
            let start = (access.get)(&initial);
            let inside = min.is_none_or(|min| start >= min) && max.is_none_or(|max| start <= max);
            assert!(inside || access.set.is_none(), "{}", variable.name);
            let bounded = min.is_some() && max.is_some() && min < max;
            assert!(bounded || access.set.is_none(), "{}", variable.name);
            assert!(
                nominal.is_some_and(|nominal| nominal > 0.0),
                "{}",
                variable.name
            );
            let known = |name: &str| unit.display.iter().any(|unit| unit.name == name);
            assert!(display.is_none_or(known), "{}", variable.name);
        }
    }
    for variable in Stand::variables() {
        for name in variable.depends_on {
            assert!(names.contains(name), "{}: {name}", variable.name);
        }
    }
}
