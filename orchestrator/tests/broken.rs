//! `check` finds what is wrong with FMUs that were broken on purpose, each with one clear line; and nothing in a
//! good one.
#![allow(clippy::unwrap_used)]

mod support;

use support::{Bench, Said, model};

/// What was broken: the change in the model description, and a word of what is found.
const DESCRIPTIONS: [(&str, &str, &str, &str); 56] = [
    (
        "another FMU's description",
        "guid=\"lag\"",
        "guid=\"other\"",
        "wrong guid other",
    ),
    ("no guid", " guid=\"lag\"", "", "needs the attribute `guid`"),
    (
        "another version",
        "fmiVersion=\"2.0\"",
        "fmiVersion=\"3.0\"",
        "FMI 2.0 is needed",
    ),
    (
        "no such version",
        "fmiVersion=\"2.0\"",
        "fmiVersion=\"2.5\"",
        "FMI 2.0 is needed",
    ),
    (
        "no co-simulation",
        "<CoSimulation",
        "<ModelExchange",
        "no Co-Simulation part",
    ),
    (
        "no identifier",
        "modelIdentifier=\"lag\"",
        "",
        "`modelIdentifier`",
    ),
    (
        "not well-formed",
        "</ModelVariables>",
        "",
        "modelDescription.xml: ",
    ),
    (
        "not even XML",
        "<?xml",
        "PK <?xml",
        "modelDescription.xml: ",
    ),
    (
        "another element",
        "<LogCategories>",
        "<Nonsense/><LogCategories>",
        "no element `Nonsense`",
    ),
    (
        "a mistyped element",
        "DefaultExperiment ",
        "DefaultExperimant ",
        "did you mean `DefaultExperiment`",
    ),
    (
        "another attribute",
        "causality=\"input\"",
        "causality=\"input\" colour=\"red\"",
        "no attribute `colour`",
    ),
    (
        "a mistyped attribute",
        "stepSize",
        "stepsize",
        "did you mean `stepSize`",
    ),
    (
        "undefined unit",
        "unit=\"1/s\"",
        "unit=\"1/min\"",
        "unit \"1/min\" is not defined",
    ),
    (
        "undefined display unit",
        "displayUnit=\"mm\"",
        "displayUnit=\"km\"",
        "displayUnit \"km\" is not defined",
    ),
    (
        "display unit alone",
        "unit=\"m\" displayUnit",
        "displayUnit",
        "\"mm\" without a unit",
    ),
    (
        "undefined type",
        "declaredType=\"Fault\"",
        "declaredType=\"Faults\"",
        "did you mean `Fault`",
    ),
    (
        "type of another kind",
        "<Integer start=\"1\"",
        "<Integer declaredType=\"Fault\" start=\"1\"",
        "a type of Enumeration",
    ),
    (
        "enumeration without a type",
        " declaredType=\"Fault\"",
        "",
        "needs the attribute `declaredType`",
    ),
    (
        "start is no item",
        "\"Fault\" start=\"0\"",
        "\"Fault\" start=\"99\"",
        "none of its type's items",
    ),
    (
        "min above max",
        "min=\"0\" max=\"9\"",
        "min=\"9\" max=\"0\"",
        "min 9 is greater than max 0",
    ),
    (
        "start below min",
        "min=\"0\" start=\"2e-5\"",
        "min=\"1\" start=\"2e-5\"",
        "start 0.00002 is less than min 1",
    ),
    (
        "start above max",
        "start=\"1\" min=\"0\" max=\"9\"",
        "start=\"10\" min=\"0\" max=\"9\"",
        "start 10 is greater than max 9",
    ),
    (
        "start is no number",
        "<Real start=\"1\"/>",
        "<Real start=\"one\"/>",
        "\"one\" is not a number",
    ),
    (
        "start is infinite",
        "<Real start=\"1\"/>",
        "<Real start=\"INF\"/>",
        "it must be a finite number",
    ),
    (
        "nominal of zero",
        "min=\"0\" start=\"1\"",
        "min=\"0\" start=\"1\" nominal=\"0\"",
        "nominal is 0",
    ),
    (
        "negative nominal",
        "min=\"0\" start=\"1\"",
        "min=\"0\" start=\"1\" nominal=\"-1\"",
        "nominal is -1",
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
        "no tolerance",
        "stepSize=\"0.01\"",
        "stepSize=\"0.01\" tolerance=\"0\"",
        "tolerance is 0",
    ),
    (
        "output out of range",
        "<Real unit=\"K\" displayUnit=\"degC\"/>",
        "<Real unit=\"K\" displayUnit=\"degC\" max=\"1\"/>",
        "beyond its max of 1",
    ),
    (
        "output below its range",
        "<Real unit=\"K\" displayUnit=\"degC\"/>",
        "<Real unit=\"K\" displayUnit=\"degC\" min=\"1e4\"/>",
        "beyond its min of 10000",
    ),
    (
        "two of a name",
        "name=\"lag.y\"",
        "name=\"lag.temperature\"",
        "a second variable `lag.temperature`",
    ),
    (
        "no value reference",
        " valueReference=\"30\"",
        "",
        "no valueReference",
    ),
    (
        "a reference that the binary does not know",
        "valueReference=\"2\"",
        "valueReference=\"99\"",
        "fmi2GetReal",
    ),
    (
        "a start that is not the binary's",
        "min=\"0\" start=\"1\"",
        "min=\"0\" start=\"2\"",
        "lag.rate (line 23): start is 2, but the binary's is 1",
    ),
    (
        "two that can be set",
        "valueReference=\"2\"",
        "valueReference=\"1\"",
        "valueReference 1 is lag.rate's, too, and both can be set",
    ),
    (
        "two units of one",
        "\"lag.temperature\" valueReference=\"4\"",
        "\"lag.temperature\" valueReference=\"2\"",
        "their units differ",
    ),
    (
        "two starts of one",
        "valueReference=\"3\" causality=\"output\"><Real/>",
        "valueReference=\"0\" causality=\"output\" initial=\"exact\"><Real start=\"1\"/>",
        "both have a start value",
    ),
    (
        "parameter without start",
        "min=\"0\" start=\"1\"/>",
        "min=\"0\"/>",
        "which every parameter needs",
    ),
    (
        "input without start",
        "<Real start=\"1\"/>",
        "<Real/>",
        "which every input needs",
    ),
    (
        "exact without start",
        "name=\"lag.y\" valueReference=\"3\"",
        "name=\"lag.y\" initial=\"exact\" valueReference=\"3\"",
        "initial=\"exact\" needs",
    ),
    (
        "calculated with start",
        "valueReference=\"3\" causality=\"output\"><Real/>",
        "valueReference=\"3\" causality=\"output\"><Real start=\"1\"/>",
        "remove start",
    ),
    (
        "input with initial",
        "causality=\"input\"",
        "causality=\"input\" initial=\"exact\"",
        "remove it",
    ),
    (
        "unknown causality",
        "causality=\"input\"",
        "causality=\"entry\"",
        "unknown causality \"entry\"",
    ),
    (
        "unknown variability",
        "variability=\"discrete\"",
        "variability=\"jumpy\"",
        "unknown variability \"jumpy\"",
    ),
    (
        "continuous parameter",
        "variability=\"fixed\"><Boolean",
        "variability=\"continuous\"><Boolean",
        "a parameter cannot be continuous",
    ),
    (
        "continuous text",
        "variability=\"discrete\"><String",
        "variability=\"continuous\"><String",
        "only a Real can be continuous",
    ),
    (
        "derivative of nothing",
        "valueReference=\"3\" causality=\"output\"><Real/>",
        "valueReference=\"3\" causality=\"output\"><Real derivative=\"99\"/>",
        "none of the 11 variables",
    ),
    (
        "derivative of a text",
        "valueReference=\"3\" causality=\"output\"><Real/>",
        "valueReference=\"3\" causality=\"output\"><Real derivative=\"10\"/>",
        "is lag.text, no continuous Real",
    ),
    (
        "structure without an output",
        "<Outputs>\n    <Unknown index=\"4\"/>",
        "<Outputs>",
        "does not list lag.y (index 4) in Outputs",
    ),
    (
        "structure beyond the end",
        "<Outputs>\n    <Unknown index=\"4\"/>",
        "<Outputs><Unknown index=\"12\"/>",
        "index 12 is none of the 11 variables",
    ),
    (
        "structure with a parameter",
        "<Outputs>\n    <Unknown index=\"4\"/>",
        "<Outputs><Unknown index=\"2\"/>",
        "index 2 is lag.rate, which is no output",
    ),
    (
        "dependency on nothing",
        "<Outputs>\n    <Unknown index=\"4\"/>",
        "<Outputs><Unknown index=\"4\" dependencies=\"1 0\"/>",
        "a dependency on index 0",
    ),
    (
        "too few kinds",
        "<Outputs>\n    <Unknown index=\"4\"/>",
        "<Outputs><Unknown index=\"4\" dependencies=\"1 2\" dependenciesKind=\"fixed\"/>",
        "2 dependencies, but 1 dependenciesKind",
    ),
    (
        "initially unknown",
        "<InitialUnknowns>\n    <Unknown index=\"4\"/>",
        "<InitialUnknowns>",
        "does not list lag.y (index 4) in InitialUnknowns",
    ),
];

/// What is not as it should be: one line beside the verdict, with these words.
fn amiss(bench: &Bench, name: &str, words: &str) -> Option<String> {
    let Said { code, out, err } = bench.run(&["check", "broken.fmu", "--patience", "1"]);
    let right = code == 1 && out.lines().count() == 2 && out.contains(words);
    (!right).then(|| format!("{name}: no `{words}` alone in: {out}{err}"))
}

fn none(amiss: &[String]) {
    assert!(amiss.is_empty(), "{}", amiss.join("\n"));
}

#[test]
fn a_good_fmu_has_nothing() {
    let bench = Bench::new();
    let said = bench.run(&["check", "lag.fmu"]);
    assert_eq!((said.code, said.out.trim()), (0, "lag.fmu: nothing found"));
}

#[test]
fn every_broken_description_is_found() {
    let bench = Bench::empty();
    let binary = bench.binary(&[]);
    let mut wrong = Vec::new();
    for (name, from, to, words) in DESCRIPTIONS {
        let description = model(from, to);
        let files: [(&str, &[u8]); 2] = [
            ("modelDescription.xml", description.as_bytes()),
            ("binaries/linux64/lag.so", &binary),
        ];
        bench.zip("broken.fmu", &files);
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}

#[test]
fn every_broken_binary_is_found() {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let mut wrong = Vec::new();
    for (name, macros, words) in [
        (
            "a missing function",
            "fmi2DoStep=anotherName",
            "lag.so: the binary does not export fmi2DoStep",
        ),
        ("a crash", "FAULT=CRASH", "SIGSEGV"),
        ("an abort", "FAULT=ABORT", "SIGABRT: lag: assertion failed"),
        ("an end", "FAULT=EXIT", "with code 3"),
        ("a hang", "FAULT=HANG", "timeout"),
        ("an error", "FAULT=FAIL", "the spring broke"),
        ("no number", "FAULT=NOT_A_NUMBER", "lag.y"),
        (
            "a state that survives",
            "BROKEN_RESET",
            "after fmi2Reset, lag.y",
        ),
        ("no reset", "FAILING_RESET", "fmi2Reset"),
    ] {
        bench.fmu("broken.fmu", &[macros], &description);
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}

/// What a build for static linking does to the functions' names.
#[test]
fn a_prefix_is_found() {
    let word = |c: char| !c.is_ascii_alphanumeric();
    let source = include_str!("fixtures/lag.c");
    let names = source.split(word).filter(|name| name.starts_with("fmi2"));
    let macros: Vec<String> = names.map(|name| format!("{name}=lag_{name}")).collect();
    let macros: Vec<&str> = macros.iter().map(String::as_str).collect();
    let bench = Bench::empty();
    bench.fmu("broken.fmu", &macros, &model("guid", "guid"));
    let words = "exports lag_fmi2DoStep instead of fmi2DoStep";
    none(&Vec::from_iter(amiss(&bench, "a prefix", words)));
}

#[test]
fn every_broken_archive_is_found() {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let good = bench.binary(&[]);
    let (mut arm, mut narrow) = (good.clone(), good.clone());
    // The machine and the class in the head of an ELF file.
    arm[18] = 183;
    narrow[4] = 1;
    let place = "binaries/linux64/lag.so";
    let cases: [(&str, &str, &[u8], &str); 8] = [
        (
            "no binary",
            "resources/none",
            b"",
            "no binary for this platform",
        ),
        (
            "no folder of a platform",
            "binaries/lag.so",
            &good,
            "no binary for this platform",
        ),
        (
            "another machine",
            place,
            &arm,
            "lag.so: a binary for Aarch64",
        ),
        ("another width", place, &narrow, "lag.so: "),
        (
            "no library",
            place,
            b"not a library",
            "lag.so: no shared library",
        ),
        ("half a library", place, &good[..good.len() / 2], "lag.so: "),
        (
            "another name",
            "binaries/linux64/leg.so",
            &good,
            "call it lag.so",
        ),
        (
            "a way out",
            "../outside.txt",
            b"",
            "../outside.txt: the path leads outside",
        ),
    ];
    let mut wrong = Vec::new();
    for (name, entry, content, words) in cases {
        let description = description.as_bytes();
        bench.zip(
            "broken.fmu",
            &[("modelDescription.xml", description), (entry, content)],
        );
        wrong.extend(amiss(&bench, name, words));
    }
    // Beside a good one.
    let entries: [(&str, &[u8]); 3] = [
        ("modelDescription.xml", description.as_bytes()),
        (place, &good),
        ("binaries/linux32/lag.so", &good),
    ];
    bench.zip("broken.fmu", &entries);
    let words = "linux32/lag.so: a binary for X86_64";
    wrong.extend(amiss(&bench, "another platform", words));
    let whole = description.split("<ModelStructure>").next().unwrap();
    let cut = format!("{whole}</fmiModelDescription>");
    bench.zip(
        "broken.fmu",
        &[("modelDescription.xml", cut.as_bytes()), (place, &good)],
    );
    let words = "needs the element `ModelStructure`";
    wrong.extend(amiss(&bench, "no structure", words));
    bench.zip(
        "broken.fmu",
        &[("lag/modelDescription.xml", description.as_bytes())],
    );
    let (name, words) = ("a folder around it", "belongs to the top of the archive");
    wrong.extend(amiss(&bench, name, words));
    none(&wrong);
}
