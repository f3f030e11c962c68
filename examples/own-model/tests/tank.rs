//! The tank against Torricelli's solution, and its copy in the README of `fmu-export`.
#![allow(clippy::unwrap_used)]

use fmu_export::model::{Access, Experiment, Fault, Kind, Model, Quantity, faults};
use own_model::Tank;

fn access(name: &str) -> &'static Access<Tank, f64, f64> {
    let variable = Tank::variables().iter().find(|v| v.name == name).unwrap();
    match &variable.kind {
        Kind::Real(Quantity { access, .. }) => access,
        _ => panic!("{name} is no Real"),
    }
}

fn started(values: &[(&str, f64)]) -> Tank {
    let mut tank = Tank::default();
    for (name, value) in values {
        access(name).set.unwrap()(&mut tank, value);
    }
    tank.initialise(&Experiment::default(), &mut ()).unwrap();
    tank
}

#[test]
fn the_declaration_is_sound() {
    assert_eq!(faults::<Tank>(), Vec::<String>::new());
}

#[test]
fn the_level_falls_by_torricellis_law_until_the_tank_is_empty() {
    let mut tank = started(&[("initialLevel", 2.0)]);
    for second in 0..200 {
        tank.advance(f64::from(second), 1.0, &mut ()).unwrap();
        let t = f64::from(second + 1);
        let root = (2.0_f64.sqrt() - 2e-3 / 0.5 * (9.81_f64 / 2.0).sqrt() * t).max(0.0);
        let level = (access("level").get)(&tank);
        assert!((level - root * root).abs() < 1e-7, "{t} s: {level}");
    }
}

#[test]
fn parameters_out_of_range_are_refused() {
    let mut tank = Tank::default();
    access("area").set.unwrap()(&mut tank, &0.0);
    let refused = tank.initialise(&Experiment::default(), &mut ());
    assert!(matches!(refused, Err(Fault::Invalid(message)) if message.contains("area = 0.0 m2")));
}

#[test]
fn the_readme_shows_this_example() {
    let read = |path: &str| {
        let text = std::fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR")));
        text.unwrap().replace("\r\n", "\n")
    };
    let bare = |text: &str| text.replace(char::is_whitespace, "").replace(",}", "}");
    let readme = read("../../crates/fmu-export/README.md");
    let (_, block) = readme.split_once("```rust,ignore\n").unwrap();
    let (block, _) = block.split_once("```").unwrap();
    let source = bare(&read("src/lib.rs"));
    // Where the README leaves something out, what stands before it is in the source.
    let shown = block.lines().map(|line| line.split("...").next().unwrap());
    let shown = shown.filter(|line| !line.trim_start().starts_with("//") || line.contains("///"));
    for line in shown {
        assert!(source.contains(&bare(line)), "{line}");
    }
    assert!(readme.contains("fmu_export::package!(own_model::Tank);"));
}
