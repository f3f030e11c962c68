//! `check` finds what is wrong with FMUs that were broken on purpose, each with one clear line; and nothing in a
//! good one.
#![allow(clippy::unwrap_used)]

mod support;

use support::{Bench, Said, model};

/// What was broken: the change in the model description, and a word of what is found, after its severity where that is
/// no error.
const DESCRIPTIONS: &str = include_str!("fixtures/broken.txt");

/// What is not as it should be: one line beside the verdict, with these words and of this severity, `error` unless they
/// begin with another one.
fn amiss(bench: &Bench, name: &str, words: &str) -> Option<String> {
    let (severity, code, words) = match words.split_once(": ") {
        Some(("warning", words)) => ("warning", 0, words),
        Some(("note", words)) => ("note", 0, words),
        _ => ("error", 1, words),
    };
    let said = bench.run(&["check", "broken.fmu", "--patience", "1"]);
    let Said { out, err, .. } = &said;
    let line = out.lines().nth(1).unwrap_or_default();
    let right = line.starts_with(&format!("  {severity}: ")) && line.ends_with(']');
    let right = right && said.code == code && out.lines().count() == 2 && line.contains(words);
    (!right).then(|| format!("{name}: no {severity} `{words}` alone in: {out}{err}"))
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
    for line in DESCRIPTIONS.lines().skip(1) {
        let cells: Vec<String> = line
            .split(" | ")
            .map(|cell| cell.replace("\\n", "\n"))
            .collect();
        let [name, from, to, words] = &cells[..] else {
            panic!("{line}: not four cells");
        };
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
        (
            "a parameter that survives",
            "KEEPS_RATE",
            "after a simulation with changed parameters and fmi2Reset, lag.rate is 1.01",
        ),
        (
            "an end that fails",
            "FAILING_TERMINATE",
            "the simulation is whole, but: fmi2Error",
        ),
        (
            "a double free",
            "DOUBLE_FREE",
            "fmi2FreeInstance failed after a whole simulation: SIGABRT",
        ),
        (
            "unwritten memory",
            "UNWRITTEN",
            "memory that it never wrote",
        ),
        (
            "the time of day",
            "CLOCK",
            "warning: two simulations of the same differ",
        ),
        (
            "a count in the library",
            "COUNTING",
            "in a second instance after the first was freed, lag.y",
        ),
        (
            "a second instance refused",
            "ALONE",
            "with two instances at once",
        ),
        ("one state for all", "GLOBAL", "with two instances at once"),
        (
            "an early end",
            "FAULT=END",
            "note: ends the simulation by itself, at 0.05 s",
        ),
        (
            "a warning",
            "FAULT=WARN",
            "warning: fmi2Warning: 1; the first: fmi2DoStep: take care",
        ),
        ("a step for ever", "FAULT=PEND", "fmi2Pending"),
        (
            "another version",
            "VERSION=\"1.0\"",
            "warning: fmi2GetVersion returns \"1.0\"",
        ),
        (
            "a foreign environment",
            "STRAY",
            "warning: the logger is called with an environment",
        ),
    ] {
        // What the description says of the fault is not what is looked for.
        let fault = macros
            .strip_prefix("FAULT=")
            .is_some_and(|name| ["END", "WARN", "NOT_A_NUMBER"].contains(&name));
        let number = match macros {
            "FAULT=END" => "13",
            "FAULT=WARN" => "12",
            _ => "9",
        };
        let told = description.replace(
            "declaredType=\"Fault\" start=\"0\"",
            &format!("declaredType=\"Fault\" start=\"{number}\""),
        );
        let description = if fault { &told } else { &description };
        bench.fmu("broken.fmu", &[macros], description);
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}

/// A symbol is missing, and a library too: both are named.
#[test]
fn missing_libraries_are_found_beside_a_missing_function() {
    let bench = Bench::empty();
    let compile = |arguments: &[&str]| {
        let mut compiler = std::process::Command::new("cc");
        let compiler = compiler
            .current_dir(bench.path(""))
            .args(["-shared", "-fPIC"]);
        assert!(compiler.args(arguments).status().unwrap().success());
    };
    compile(&["-x", "c", "/dev/null", "-o", "libabsent.so"]);
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/lag.c");
    let link = [
        "-o",
        "lag.so",
        "-L.",
        "-Wl,--no-as-needed",
        "-labsent",
        "-lm",
    ];
    compile(&[&["-Dfmi2DoStep=anotherName", source], &link[..]].concat());
    let binary = std::fs::read(bench.path("lag.so")).unwrap();
    let description = model("guid", "guid");
    bench.zip(
        "broken.fmu",
        &[
            ("modelDescription.xml", description.as_bytes()),
            ("binaries/linux64/lag.so", &binary),
        ],
    );
    let Said { code, out, .. } = bench.run(&["check", "broken.fmu"]);
    assert_eq!((code, out.lines().count()), (1, 3), "{out}");
    assert!(
        out.contains("does not export fmi2DoStep") && out.contains("needs libabsent.so"),
        "{out}"
    );
}

/// What looks strange and is allowed: no error, and exit code 0.
#[test]
fn legal_things_are_no_errors() {
    let bench = Bench::empty();
    let binary = bench.binary(&[]);
    let text = model("guid", "guid");
    let (before, rest) = text.split_once("<ModelStructure>").unwrap();
    let after = rest.split_once("</ModelStructure>").unwrap().1;
    let bare = format!("{before}<ModelStructure/>{after}");
    let constants = "<ScalarVariable name=\"a\" valueReference=\"0\" variability=\"constant\"><Integer start=\"0\"/></ScalarVariable>\
        <ScalarVariable name=\"b\" valueReference=\"0\" variability=\"constant\"><Integer start=\"-0\"/></ScalarVariable>\
        </ModelVariables>";
    for (name, description) in [
        (
            "no outputs",
            bare.replace("causality=\"output\"", "causality=\"local\""),
        ),
        (
            "zero with a sign",
            text.replace(
                "declaredType=\"Fault\" start=\"0\"",
                "declaredType=\"Fault\" start=\"-0\"",
            ),
        ),
        ("zero twice", text.replace("</ModelVariables>", constants)),
        (
            "no initial unknowns",
            format!(
                "{}</ModelStructure>{after}",
                text.split("<InitialUnknowns>").next().unwrap()
            ),
        ),
    ] {
        let files: [(&str, &[u8]); 2] = [
            ("modelDescription.xml", description.as_bytes()),
            ("binaries/linux64/lag.so", &binary),
        ];
        bench.zip("legal.fmu", &files);
        let Said { code, out, .. } = bench.run(&["check", "legal.fmu"]);
        assert!(code == 0 && !out.contains("error"), "{name}: {out}");
    }
}

#[test]
fn findings_are_written_for_people_and_programs() {
    let bench = Bench::empty();
    bench.fmu(
        "a b.fmu",
        &["FAULT=WARN"],
        &model("stepSize=\"0.01\"", "stepSize=\"0\""),
    );
    let run = |options: &[&str]| bench.run(&[&["check", "a b.fmu"], options].concat());
    let json: serde_json::Value = serde_json::from_str(&run(&["--format", "json"]).out).unwrap();
    assert_eq!((&json["errors"], &json["warnings"]), (&1.into(), &1.into()));
    let sarif: serde_json::Value = serde_json::from_str(&run(&["--format", "sarif"]).out).unwrap();
    assert_eq!(sarif["version"], "2.1.0");
    let run_of_it = &sarif["runs"][0];
    let driver = &run_of_it["tool"]["driver"];
    assert!(driver["name"].is_string());
    let rules = driver["rules"].as_array().unwrap();
    let mut ids: Vec<&str> = rules
        .iter()
        .map(|rule| rule["id"].as_str().unwrap())
        .collect();
    let results = run_of_it["results"].as_array().unwrap();
    assert_eq!(results.len(), 2);
    for result in results {
        let index = usize::try_from(result["ruleIndex"].as_u64().unwrap()).unwrap();
        assert_eq!(result["ruleId"], ids[index]);
        assert!(["error", "warning", "note"].contains(&result["level"].as_str().unwrap()));
        assert!(!result["message"]["text"].as_str().unwrap().is_empty());
        let place = &result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"];
        assert!(place.as_str().unwrap().starts_with("a%20b.fmu"), "{place}");
    }
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count, "a rule's name comes twice");
    assert_eq!(run(&["--strict"]).code, 1);
    bench.fmu(
        "a b.fmu",
        &["FAULT=WARN"],
        &model("guid", "guid").replace("\"Fault\" start=\"0\"", "\"Fault\" start=\"12\""),
    );
    assert_eq!((run(&[]).code, run(&["--strict"]).code), (0, 1));
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
    let cases: [(&str, &str, &[u8], &str); 9] = [
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
            "a folder in upper case",
            "Binaries/Linux64/lag.so",
            &good,
            "Binaries/Linux64/lag.so: the folder's name is binaries/linux64/",
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

/// What takes more than one change of the description, or other bytes.
#[test]
fn every_broken_document_is_found() {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let binary = bench.binary(&[]);
    let place = "binaries/linux64/lag.so";
    let structured = model("guid=", "variableNamingConvention=\"structured\" guid=");
    let latin: Vec<u8> = description
        .replace("first-order", "b\u{e4}d")
        .chars()
        .map(|c| c as u8)
        .collect();
    let wide: Vec<u8> = ["\u{feff}", &description]
        .concat()
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let states = "<ScalarVariable name=\"x\" valueReference=\"3\"><Real/></ScalarVariable>\
        <ScalarVariable name=\"der(x)\" valueReference=\"4\"><Real unit=\"K\" derivative=\"12\"/></ScalarVariable>\
        </ModelVariables>";
    let listed = "</Outputs><Derivatives><Unknown index=\"13\"/></Derivatives>";
    let stateful = description
        .replace("</ModelVariables>", states)
        .replace("</Outputs>", listed);
    let spaced = model(
        "<fmiModelDescription",
        "<f:fmiModelDescription xmlns:f=\"f\"",
    )
    .replace("</fmi", "</f:fmi");
    let mut wrong = Vec::new();
    for (name, entry, content, words) in [
        (
            "upper case",
            "ModelDescription.xml",
            description.as_bytes(),
            "call it modelDescription.xml",
        ),
        (
            "another encoding",
            "modelDescription.xml",
            &latin,
            "line 2: not UTF-8",
        ),
        (
            "two bytes a character",
            "modelDescription.xml",
            &wide,
            "the bytes are UTF-16, but the file is declared as UTF-8",
        ),
        (
            "a state that is computed initially, but not listed",
            "modelDescription.xml",
            stateful.as_bytes(),
            "warning: does not list x (index 12), der(x) (index 13) in InitialUnknowns",
        ),
        (
            "a namespace",
            "modelDescription.xml",
            spaced.as_bytes(),
            "the namespace \"f\"",
        ),
        (
            "names out of the convention",
            "modelDescription.xml",
            structured.replace("lag.y", "lag y").as_bytes(),
            "lag y: no structured name",
        ),
    ] {
        bench.zip("broken.fmu", &[(entry, content), (place, &binary)]);
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}

/// Damage in the zip itself: a bit in a compressed file, its mark as encrypted, its method.
#[test]
fn every_damaged_archive_is_found() {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let binary = bench.binary(&[]);
    let files: [(&str, &[u8]); 2] = [
        ("modelDescription.xml", description.as_bytes()),
        ("binaries/linux64/lag.so", &binary),
    ];
    bench.zip("broken.fmu", &files);
    let path = bench.path("broken.fmu");
    let good = std::fs::read(&path).unwrap();
    // The heads of the entries, before them and in the directory, and where they have their flags.
    let heads = |mark: [u8; 4], flags: usize| {
        let places = 0..good.len() - 4;
        places
            .filter(|at| good[*at..].starts_with(&mark))
            .map(move |at| at + flags)
            .collect::<Vec<_>>()
    };
    let flags = [heads(*b"PK\x01\x02", 8), heads(*b"PK\x03\x04", 6)].concat();
    let mut wrong = Vec::new();
    for (name, words) in [
        ("a flipped bit", "damaged ("),
        ("encrypted", "modelDescription.xml: encrypted"),
        ("another method", "deflate"),
    ] {
        let mut bytes = good.clone();
        match name {
            "a flipped bit" => bytes[200] ^= 0x10,
            "encrypted" => flags.iter().for_each(|at| bytes[*at] |= 1),
            _ => flags.iter().for_each(|at| bytes[at + 2] = 14),
        }
        std::fs::write(&path, &bytes).unwrap();
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}
