//! `check` finds what is wrong with twelve FMUs that were broken on purpose.

mod support;

use support::{Bench, model};

/// What was broken: the change in the model description, and a word of what is found.
const BROKEN: [(&str, &str, &str, &str); 10] = [
    (
        "another FMU's description",
        "guid=\"lag\"",
        "guid=\"other\"",
        "wrong guid other",
    ),
    (
        "undefined unit",
        "unit=\"1/s\"",
        "unit=\"1/min\"",
        "unit \"1/min\" is not defined",
    ),
    (
        "min above max",
        "min=\"0\" max=\"9\"",
        "min=\"9\" max=\"0\"",
        "min 9 is greater than max 0",
    ),
    (
        "start out of range",
        "min=\"0\" start=\"2e-5\"",
        "min=\"1\" start=\"2e-5\"",
        "start 0.00002 is less than min 1",
    ),
    (
        "negative step size",
        "stepSize=\"0.01\"",
        "stepSize=\"-0.01\"",
        "stepSize is -0.01",
    ),
    (
        "no step size",
        "stepSize=\"0.01\"",
        "stepSize=\"0\"",
        "stepSize is 0",
    ),
    (
        "stop before start",
        "stopTime=\"2\"",
        "stopTime=\"-2\"",
        "stopTime is -2",
    ),
    (
        "output out of range",
        "<Real unit=\"K\" displayUnit=\"degC\"/>",
        "<Real unit=\"K\" displayUnit=\"degC\" max=\"1\"/>",
        "beyond its max of 1",
    ),
    (
        "another version",
        "fmiVersion=\"2.0\"",
        "fmiVersion=\"3.0\"",
        "FMI 2.0 is needed",
    ),
    (
        "structure without an output",
        "<Unknown index=\"4\"/>",
        "",
        "an output that ModelStructure does not list",
    ),
];

#[test]
fn every_broken_fmu_is_found() {
    let bench = Bench::empty();
    for (name, from, to, finding) in BROKEN {
        bench.fmu("broken.fmu", &[], &model(from, to));
        let said = bench.run(&["check", "broken.fmu"]);
        assert_eq!(said.code, 1, "{name}: {}{}", said.out, said.err);
        assert!(said.out.contains(finding), "{name}: {}", said.out);
    }
    let description = model("guid=\"lag\"", "guid=\"lag\"");
    // A binary that lacks a function of the standard.
    bench.fmu("broken.fmu", &["fmi2DoStep=anotherName"], &description);
    let said = bench.run(&["check", "broken.fmu"]);
    assert_ne!(said.code, 0, "{}{}", said.out, said.err);
    assert!(
        format!("{}{}", said.out, said.err).contains("fmi2DoStep"),
        "{}{}",
        said.out,
        said.err
    );
    bench.zip(
        "empty.fmu",
        &[("modelDescription.xml", description.as_bytes())],
    );
    let said = bench.run(&["check", "empty.fmu"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.contains("binar"), "{}", said.out);
}
