//! The layers of the house: which module may import which, and that no files import each other in a circle.
//!
//! A module on a floor may use modules of the floors below it, and no others. To put a module elsewhere, move its
//! name in [`FLOORS`], the only place that knows the order.
#![allow(clippy::unwrap_used)]

#[path = "layers/arrows.rs"]
mod arrows;

use std::collections::BTreeSet;

use arrows::{Tree, circles};

/// The orchestrator's modules, from the ground up.
const FLOORS: [&[&str]; 14] = [
    &["error"],
    &["junit"],
    &["source", "recording", "plain"],
    &["results"],
    &["session", "identify"],
    &["options"],
    &["methods"],
    &["report"],
    &["compare", "packed"],
    &["reruns"],
    &["cli"],
    &["commands"],
    &["lib"],
    &["main"],
];

/// The sources in which no files may import each other in a circle.
const HOUSES: [&str; 19] = [
    "../crates/calibration/src",
    "../crates/conformity/src",
    "../crates/curves/src",
    "../crates/fmu-check/src",
    "../crates/fmu-export/src",
    "../crates/fmu-import/src",
    "../crates/fmu-points/src",
    "../crates/journal-bearing/src",
    "../crates/number-tables/src",
    "../crates/parameter-regions/src",
    "../crates/point-journal/src",
    "../crates/result-document/src",
    "../crates/rig-signals/src",
    "../crates/run-budget/src",
    "../crates/sampling/src",
    "../crates/sensitivity/src",
    "../crates/study/src",
    "../fmu/src",
    "src",
];

/// Files that are meant to know each other: the stand has variables, and these say where in the stand they are.
const MEANT: [&[&str]; 1] = [&["stand.rs", "variables.rs", "variables/"]];

fn floor(module: &str) -> usize {
    let floor = FLOORS.iter().position(|floor| floor.contains(&module));
    floor.unwrap_or_else(|| panic!("the module `{module}` is on no floor: add it to FLOORS"))
}

#[test]
fn no_arrow_goes_back_up() {
    let tree = Tree::read("src".as_ref());
    let mut seen = BTreeSet::new();
    for (from, to, name) in tree.arrows() {
        let [upper, lower] = [from, to].map(arrows::module);
        seen.insert(upper.clone());
        if upper != lower {
            assert!(
                floor(&upper) > floor(&lower),
                "src/{from} uses `{name}` of `{lower}`, which is not below `{upper}`: \
                 move what both need to a lower floor"
            );
        }
    }
    let known: BTreeSet<String> = tree.files().map(arrows::module).collect();
    for module in FLOORS.concat() {
        assert!(known.contains(module), "FLOORS names `{module}`, which is gone");
    }
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut found = Vec::new();
    for house in HOUSES {
        for circle in circles(&Tree::read(house.as_ref())) {
            let meant = MEANT.iter().any(|meant| {
                let known = |file: &String| meant.iter().any(|start| file.starts_with(start));
                circle.files.iter().all(known)
            });
            if !meant {
                found.push(format!("in {house}: {}", circle.arrows.join("\n  ")));
            }
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn an_arrow_up_and_a_circle_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write("lib.rs", "pub mod high;\npub mod low;\n");
    write("low.rs", "pub struct Low;\nfn f() { crate::high::part::g(); }");
    write("high/mod.rs", "pub mod part;\npub use part::Part;\n");
    write(
        "high/part.rs",
        "use crate::low::{self, Low};\npub struct Part(Low);\n#[cfg(test)]\nmod tests { use crate::main::X; }",
    );
    let tree = Tree::read(folder.path());
    let found: Vec<(&str, &str)> = tree.arrows().map(|(from, to, _)| (from, to)).collect();
    assert!(found.contains(&("low.rs", "high/part.rs")), "{found:?}");
    let circles = circles(&tree);
    assert_eq!(circles.len(), 1);
    assert_eq!(circles[0].files, ["high/part.rs", "low.rs"]);
    // Names that a module hands on belong to the file that defines them.
    write("low.rs", "use crate::high::Part;\npub struct Low;");
    let tree = Tree::read(folder.path());
    assert!(tree.arrows().any(|arrow| arrow == ("low.rs", "high/part.rs", "Part")));
    // A name that is handed on is used, and so is one within a macro, and one that only tests do without.
    for text in [
        "pub(crate) use crate::high::part::Part;",
        "fn f() { println!(\"{}\", crate::high::part::g()); }",
        "#[cfg(not(test))]\nuse crate::high::part::Part;",
    ] {
        write("low.rs", text);
        let tree = Tree::read(folder.path());
        let mut arrows = tree.arrows();
        let found = arrows.any(|(from, to, _)| (from, to) == ("low.rs", "high/part.rs"));
        assert!(found, "{text}");
    }
}
