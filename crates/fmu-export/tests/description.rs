//! The generated model description, shown on the lag's.
#![allow(clippy::unwrap_used)]

use fmu_export::fmi2::description::{guid, xml};
use lag::Lag;

#[test]
fn texts_are_escaped_and_types_complete() {
    let xml = xml::<Lag>();
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
    assert_eq!(guid(1), "{00000000-0000-0000-0000-000000000001}");
}
