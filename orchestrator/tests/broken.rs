//! `check` finds what is wrong with FMUs that were broken on purpose, each with one clear line; and nothing in a
//! good one.
#![allow(clippy::unwrap_used)]

mod support;

use support::{Bench, Said, model};

/// What was broken: the change in the model description, and a word of what is found.
const DESCRIPTIONS: &str = include_str!("fixtures/broken.txt");

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
