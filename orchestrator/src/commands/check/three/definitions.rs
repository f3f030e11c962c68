//! Definitions that FMI 3.0 writes in its own way: types and their items, and names of whatever a list holds (sections 2.4.1
//! and 2.4.5).

use crate::commands::check::definitions::twice;
use crate::commands::check::document::{Document, at, elements, named};
use crate::commands::check::hit::Hit;

pub(in super::super) fn types(document: &Document<'_>) -> Vec<Hit> {
    twice(
        named(document.root, "TypeDefinitions").flat_map(elements),
        "name",
    )
}

pub(in super::super) fn items(document: &Document<'_>) -> Vec<Hit> {
    let types = document.all("TypeDefinitions", "EnumerationType");
    let clash = |node| {
        let names = twice(named(node, "Item"), "name");
        let values = || twice(named(node, "Item"), "value");
        if names.is_empty() { values() } else { names }
    };
    types.flat_map(clash).collect()
}

pub(in super::super) fn empty_names(document: &Document<'_>) -> Vec<Hit> {
    let all = document.root.descendants();
    let nameless = all.filter(|node| node.attribute("name").is_some_and(str::is_empty));
    nameless
        .map(|node| {
            let element = node.tag_name().name();
            at(node, &format!("{element}: an empty name: give it one"))
        })
        .collect()
}
