//! `check` finds what is wrong with FMUs that were broken on purpose, each with one clear line; and nothing in a
//! good one.

use std::sync::Mutex;
use std::thread;

use crate::support::{BALL, Bench, Said, THREE, model};

/// A broken description: the change that breaks it, and the finding, as [`amiss`] has it.
const DESCRIPTIONS: &str = include_str!("../fixtures/broken.txt");

/// The same for binaries, broken by a macro of `lag.c`.
const BINARIES: &str = include_str!("../fixtures/broken-binaries.txt");

/// The same for descriptions of FMI 3.0.
const THREES: &str = include_str!("../fixtures/broken-three.txt");

/// All cases, with those of this file: every rule stands there.
const CASES: [&str; 4] = [DESCRIPTIONS, BINARIES, THREES, include_str!("broken.rs")];

/// The difference from the expected findings: one, of this rule and with these words. `found` is `RULE: WORDS`; a
/// severity other than `error` stands before the rule.
fn amiss(bench: &Bench, name: &str, found: &str) -> Option<String> {
    amiss_with(bench, "0", name, found)
}

fn amiss_with(bench: &Bench, fault: &str, name: &str, found: &str) -> Option<String> {
    let (severity, _) = expected(found);
    let (findings, Said { out, err, code }) = findings_with(bench, fault);
    let right = is_alone(&findings, found) && code == i32::from(severity == "error");
    (!right).then(|| format!("{name}: not one finding `{found}` alone in: {out}{err}"))
}

/// Severity and rule of an expected finding.
fn expected(found: &str) -> (&str, &str) {
    let rule = found.split_once(": ").unwrap().0;
    rule.split_once(' ').unwrap_or(("error", rule))
}

/// What is found in `broken.fmu`, and the command's output.
fn findings(bench: &Bench) -> (Vec<serde_json::Value>, Said) {
    findings_with(bench, "0")
}

/// The same with this fault of an FMU that takes it from the environment.
fn findings_with(bench: &Bench, fault: &str) -> (Vec<serde_json::Value>, Said) {
    // One case hangs; the others are done in milliseconds, or in a second on a machine that is overloaded.
    let mut command = bench.command(&["check", "broken.fmu", "--patience", "10", "--format", "json"]);
    let said: Said = command.env("LAG_FAULT", fault).output().unwrap().into();
    let report: serde_json::Value = serde_json::from_str(&said.out).unwrap_or_default();
    (report["findings"].as_array().cloned().unwrap_or_default(), said)
}

fn is_alone(findings: &[serde_json::Value], found: &str) -> bool {
    let [finding] = findings else { return false };
    let (severity, rule) = expected(found);
    let place = [&finding["file"], &finding["message"]].map(|part| part.as_str().unwrap_or(""));
    let words = found.split_once(": ").unwrap().1;
    finding["rule"] == rule && finding["severity"] == severity && place.join(": ").contains(words)
}

fn none(amiss: &[String]) {
    assert!(amiss.is_empty(), "{}", amiss.join("\n"));
}

/// Every case is as its test wants it. Eight at a time: a check waits for a second, to see whether the FMU looks at the clock.
fn every<Case: Send>(cases: impl Iterator<Item = Case> + Send, test: impl Fn(&Bench, Case) -> Option<String> + Sync) {
    let cases = Mutex::new(cases);
    let some = || {
        let bench = Bench::empty();
        let mut wrong = Vec::new();
        loop {
            let next = cases.lock().unwrap().next();
            let Some(case) = next else { return wrong };
            wrong.extend(test(&bench, case));
        }
    };
    let wrong: Vec<String> = thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(some)).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    none(&wrong);
}

#[test]
fn a_good_fmu_has_nothing() {
    let bench = Bench::new();
    let said = bench.run(&["check", "lag.fmu"]);
    assert_eq!((said.code, said.out.trim()), (0, "lag.fmu: nothing found"));
}

/// An FMU that works with some start values and steps only is checked with these.
#[test]
fn a_check_takes_start_values_and_a_step() {
    let bench = Bench::new();
    bench.fmu("coarse.fmu", &["COARSE"], &model("", ""));
    let check = |options: &[&str]| bench.run(&[&["check", "coarse.fmu"], options].concat());
    assert_eq!(check(&[]).code, 0);
    for (options, told) in [(["--step", "0.0005"], "SIGSEGV"), (["--set", "lag.fault=Fail"], "fmi2DoStep")] {
        let said = check(&options);
        assert!(said.code == 1 && said.out.contains(told), "{options:?}: {}{}", said.out, said.err);
    }
    check(&["--set", "lag.fail=1"]).is_mistake(&["lag.fault"]);
    check(&["--step", "0"]).is_mistake(&["--step"]);
}

/// A new rule comes with a fault that it finds.
#[test]
fn every_rule_has_a_case() {
    let bench = Bench::empty();
    bench.zip("lag.fmu", &[("modelDescription.xml", model("guid", "guid").as_bytes())]);
    let said = bench.run(&["check", "lag.fmu", "--format", "sarif"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let rules = report["runs"][0]["tool"]["driver"]["rules"].as_array().unwrap();
    let without: Vec<&str> = rules
        .iter()
        .map(|rule| rule["id"].as_str().unwrap())
        .filter(|rule| {
            let found = [format!("\"{rule}: "), format!(" {rule}: ")];
            let stands = |text: &&str| found.iter().any(|found| text.contains(found));
            !CASES.iter().any(stands)
        })
        .collect();
    assert!(rules.len() > 80 && without.is_empty(), "no case for {without:?}");
}

#[test]
fn every_broken_description_is_found() {
    broken_descriptions(40);
}

#[test]
fn every_broken_description_of_fmi_3_is_found() {
    broken_descriptions_of_fmi_3(30);
}

#[test]
#[ignore = "takes a minute: scripts/test --long"]
fn running_what_is_described_badly_finds_no_more() {
    broken_descriptions(1);
    broken_descriptions_of_fmi_3(1);
    faults_beside_the_description(1);
    broken_documents(1);
    strange_descriptions(1);
}

/// What the description alone tells is found without running the FMU, which takes ten times as long: the FMU is run where it has to
/// be, and in one case of `run`, to see that this finds no more.
fn described(
    bench: &Bench,
    (case, run): (usize, usize),
    pack: impl Fn(bool),
    name: &str,
    found: &str,
) -> Option<String> {
    pack(false);
    let mut told = findings(bench).0;
    told.retain(|finding| finding["rule"] != "binary-there");
    if is_alone(&told, found) && !case.is_multiple_of(run) {
        return None;
    }
    pack(true);
    amiss(bench, name, found)
}

fn broken_descriptions(run: usize) {
    let binary = Bench::empty().binary(&[]);
    every(DESCRIPTIONS.lines().skip(1).enumerate(), |bench, (case, line)| {
        let cells: Vec<String> = line.split(" | ").map(|cell| cell.replace("\\n", "\n")).collect();
        let [name, from, to, words] = &cells[..] else {
            panic!("{line}: not four cells");
        };
        let description = model(from, to);
        let files: [(&str, &[u8]); 2] =
            [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", &binary)];
        let pack = |whole: bool| bench.zip("broken.fmu", &files[..1 + usize::from(whole)]);
        described(bench, (case, run), pack, name, words)
    });
}

fn broken_descriptions_of_fmi_3(run: usize) {
    every(THREES.lines().skip(1).enumerate(), |bench, (case, line)| {
        let cells: Vec<&str> = line.split(" | ").collect();
        let [name, from, to, words] = cells[..] else {
            panic!("{line}: not four cells");
        };
        assert!(THREE.contains(from), "{name}: no {from}");
        let description = THREE.replacen(from, to, 1);
        let pack = |whole: bool| match whole {
            true => bench.three("broken.fmu", &[], &description),
            false => bench.zip("broken.fmu", &[("modelDescription.xml", description.as_bytes())]),
        };
        described(bench, (case, run), pack, name, words)
    });
}

/// What an FMU for Model Exchange writes beyond the event indicators that it counts, nobody sees.
#[test]
fn faults_of_an_fmu_for_model_exchange_are_found() {
    let bench = Bench::empty();
    let found = [
        (
            "Real start=\"0.7\"",
            &[][..],
            "reinit: restitution: it has the attribute reinit, but is no continuous-time state",
        ),
        ("", &["ONE_INDICATOR"], "warning warnings: counts 2 event indicators, of which the FMU computes 1"),
    ];
    let wrong = found.into_iter().filter_map(|(of, macros, found)| {
        let description =
            if of.is_empty() { BALL.to_owned() } else { BALL.replace(of, &format!("{of} reinit=\"false\"")) };
        bench.ball("broken.fmu", macros, &description);
        amiss(&bench, found, found)
    });
    none(&Vec::from_iter(wrong));
    bench.ball("state.fmu", &[], &BALL.replace("Real derivative=\"1\"", "Real derivative=\"1\" reinit=\"true\""));
    assert_eq!(bench.run(&["check", "state.fmu"]).code, 0);
}

#[test]
fn faults_of_a_binary_of_fmi_3_are_found() {
    let bench = Bench::empty();
    let mut wrong = Vec::new();
    for (fault, found) in [
        ("NO_UINT8", "binary-functions: does not export fmi3GetUInt8"),
        ("OTHER_START=2", "start-agrees: start is 1, but the binary's is 2"),
        ("OTHER_START=INFINITY", "start-agrees: start is 1, but the binary's is inf"),
        ("KEEPS_RATE", "life-reset: after a simulation with changed parameters"),
    ] {
        bench.three("broken.fmu", &[fault], THREE);
        wrong.extend(amiss(&bench, fault, found));
    }
    none(&wrong);
}

#[test]
fn every_broken_binary_is_found() {
    every(BINARIES.lines().skip(1), |bench, line| {
        let cells: Vec<&str> = line.split(" | ").collect();
        let [name, fault, from, to, found] = cells[..] else {
            panic!("{line}: not five cells");
        };
        // A compiler takes as long as a check: one library has all faults of a simulation.
        let (fault, own) = match fault.strip_prefix("FAULT=") {
            Some(fault) => (fault_number(fault), "FAULT=atoi(getenv(\"LAG_FAULT\"))"),
            None => ("0".to_owned(), fault),
        };
        bench.fmu("broken.fmu", &[own], &model(from, to));
        amiss_with(bench, &fault, name, found)
    });
}

/// The number of a fault of `lag.c`: the place of its name in the enumeration there.
fn fault_number(name: &str) -> String {
    let source = include_str!("../fixtures/lag.c");
    let names = source[source.find("NONE, CRASH").unwrap()..].split('}').next().unwrap();
    let place = names.split(',').position(|own| own.trim() == name);
    place.unwrap().to_string()
}

/// A symbol is missing, and a library too: both are named.
#[test]
fn missing_libraries_are_found_beside_a_missing_function() {
    let bench = Bench::empty();
    let compile = |arguments: &[&str]| {
        let mut compiler = std::process::Command::new("cc");
        let compiler = compiler.current_dir(bench.path("")).args(["-shared", "-fPIC"]);
        assert!(compiler.args(arguments).status().unwrap().success());
    };
    compile(&["-x", "c", "/dev/null", "-o", "libabsent.so"]);
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/lag.c");
    let link = ["-o", "lag.so", "-L.", "-Wl,--no-as-needed", "-labsent", "-lm"];
    compile(&[&["-Dfmi2DoStep=anotherName", source], &link[..]].concat());
    let binary = std::fs::read(bench.path("lag.so")).unwrap();
    let description = model("guid", "guid");
    bench.zip("broken.fmu", &[("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", &binary)]);
    let Said { code, out, .. } = bench.run(&["check", "broken.fmu"]);
    assert_eq!((code, out.lines().count()), (1, 3), "{out}");
    assert!(out.contains("does not export fmi2DoStep") && out.contains("needs libabsent.so"), "{out}");
    compile(&[&[source], &link[..]].concat());
    let binary = std::fs::read(bench.path("lag.so")).unwrap();
    bench.zip("broken.fmu", &[("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", &binary)]);
    let found = "binary-libraries: lag.so: it needs libabsent.so";
    none(&Vec::from_iter(amiss(&bench, "a missing library", found)));
}

/// Files that other programs read beside the description.
#[test]
fn faults_of_files_beside_the_description_are_found() {
    faults_beside_the_description(13);
}

fn faults_beside_the_description(run: usize) {
    let bench = Bench::empty();
    let (description, binary) = (model("guid", "guid"), bench.binary(&[]));
    let terminals = |version: &str| format!("<fmiTerminalsAndIcons fmiVersion=\"{version}\"/>");
    let manifest = |more: &str, related: &str| {
        format!(
            "<fmiReferences xmlns:fmi-ls=\"http://fmi-standard.org/fmi-ls-manifest\" {more} \
             fmi-ls:fmi-ls-name=\"org.fmi-standard.fmi-ls-ref\" fmi-ls:fmi-ls-version=\"1.0.0-alpha.1\">{related}</fmiReferences>"
        )
    };
    let about =
        "fmi-ls:fmi-ls-description=\"Layered Standard providing information on related files included in an FMU.\"";
    let listed = |attributes: &str, inside: &str| {
        manifest(about, &format!("<Related source=\"a.ssv\" {attributes}>{inside}</Related>"))
    };
    let [terminal, references] =
        ["terminalsAndIcons/terminalsAndIcons.xml", "extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"];
    let pack = |file, content: &str, whole: bool| {
        let files: [(&str, &[u8]); 3] = [
            ("modelDescription.xml", description.as_bytes()),
            (file, content.as_bytes()),
            ("binaries/linux64/lag.so", &binary),
        ];
        bench.zip("broken.fmu", &files[..2 + usize::from(whole)]);
    };
    let mut wrong = Vec::new();
    let cases = [
        (terminal, terminals("3.0"), "warning terminals-version: fmiVersion is \"3.0\" here and \"2.0\""),
        (terminal, "<".to_owned(), "warning terminals-version: "),
        (
            references,
            listed("role=\"parameter\" checksum=\"1\"", ""),
            "warning references-manifest: has no attribute `checksum`",
        ),
        (references, listed("role=\"guess\"", ""), "warning references-manifest: role=\"guess\" is none of document"),
        (references, listed("", ""), "warning references-manifest: needs the attribute `role`"),
        (
            references,
            listed("role=\"model\"", "<Label/>"),
            "warning references-manifest: `Label` needs the attribute `name`",
        ),
        (
            references,
            listed("role=\"model\"", "<Annotations/><Label name=\"a\"/>"),
            "warning references-manifest: `Label` cannot stand here",
        ),
        (references, listed("role=\"model\"", "a.mo"), "warning references-manifest: text in `Related`"),
        (references, manifest("", ""), "warning references-manifest: needs the attribute `fmi-ls:fmi-ls-description`"),
        (references, "<References/>".to_owned(), "warning references-manifest: `References` instead of"),
        (
            references,
            format!("{}{}", manifest(about, ""), " ".repeat(1_000_000)),
            "warning references-manifest: longer than 1000000 bytes",
        ),
    ];
    for (case, (file, content, found)) in cases.into_iter().enumerate() {
        let pack = |whole: bool| pack(file, &content, whole);
        wrong.extend(described(&bench, (case, run), pack, &content[..content.len().min(200)], found));
    }
    none(&wrong);
    let label = "<Label name=\"variant\" description=\"b\"/><Annotations><Annotation type=\"x\"/></Annotations>";
    for (file, content) in [
        (terminal, terminals("2.0")),
        (references, listed("role=\"serialized-state/linux64\" type=\"text/xml\" description=\"d\"", label)),
    ] {
        pack(file, &content, true);
        let said = bench.run(&["check", "broken.fmu"]);
        assert_eq!(said.out.trim(), "broken.fmu: nothing found");
    }
}

/// Strange descriptions that are allowed: no error, and exit code 0.
#[test]
fn legal_things_are_no_errors() {
    strange_descriptions(2);
}

/// One description of each `run` is also run.
fn strange_descriptions(run: usize) {
    let bench = Bench::empty();
    let binary = bench.binary(&[]);
    let text = model("guid", "guid");
    let (before, rest) = text.split_once("<ModelStructure>").unwrap();
    let after = rest.split_once("</ModelStructure>").unwrap().1;
    let bare = format!("{before}<ModelStructure/>{after}");
    let constants = "<ScalarVariable name=\"a\" valueReference=\"0\" variability=\"constant\"><Integer start=\"0\"/></ScalarVariable>\
        <ScalarVariable name=\"b\" valueReference=\"0\" variability=\"constant\"><Integer start=\"-0\"/></ScalarVariable>\
        </ModelVariables>";
    let cases = [
        ("no outputs", bare.replace("causality=\"output\"", "causality=\"local\"")),
        ("zero with a sign", text.replace("declaredType=\"Fault\" start=\"0\"", "declaredType=\"Fault\" start=\"-0\"")),
        (
            "Model Exchange after Co-Simulation",
            text.replace("<UnitDefinitions>", "<ModelExchange modelIdentifier=\"lag\"/><UnitDefinitions>"),
        ),
        ("zero twice", text.replace("</ModelVariables>", constants)),
        ("no initial unknowns", format!("{}</ModelStructure>{after}", text.split("<InitialUnknowns>").next().unwrap())),
    ];
    for (case, (name, description)) in cases.into_iter().enumerate() {
        let files: [(&str, &[u8]); 2] =
            [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", &binary)];
        let whole = case.is_multiple_of(run);
        bench.zip("broken.fmu", &files[..1 + usize::from(whole)]);
        let (mut told, said) = findings(&bench);
        told.retain(|finding| finding["severity"] == "error" && (whole || finding["rule"] != "binary-there"));
        assert!(told.is_empty() && said.code == i32::from(!whole), "{name}: {}", said.out);
    }
}

#[test]
fn findings_are_written_for_people_and_programs() {
    let bench = Bench::empty();
    let described = model("stepSize=\"0.01\" && displayUnit=\"mm\"", "stepSize=\"0\" && displayUnit=\"km\"");
    bench.zip("a b.fmu", &[("modelDescription.xml", described.as_bytes())]);
    let run = |options: &[&str]| bench.run(&[&["check", "a b.fmu"], options].concat());
    let json: serde_json::Value = serde_json::from_str(&run(&["--format", "json"]).out).unwrap();
    // The step, the binary that is not there, and the unit.
    assert_eq!((&json["errors"], &json["warnings"]), (&2.into(), &1.into()));
    let sarif: serde_json::Value = serde_json::from_str(&run(&["--format", "sarif"]).out).unwrap();
    assert_eq!(sarif["version"], "2.1.0");
    let run_of_it = &sarif["runs"][0];
    let driver = &run_of_it["tool"]["driver"];
    assert!(driver["name"].is_string());
    let rules = driver["rules"].as_array().unwrap();
    let mut ids: Vec<&str> = rules.iter().map(|rule| rule["id"].as_str().unwrap()).collect();
    let results = run_of_it["results"].as_array().unwrap();
    assert_eq!(results.len(), 3);
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

/// One fault over and over is told some times and counted; programs get all of it.
#[test]
fn a_fault_of_many_variables_is_no_flood() {
    let bench = Bench::empty();
    let variable = |number: usize| {
        let reference = number + 100;
        format!(
            "<ScalarVariable name=\"v{number}\" valueReference=\"{reference}\" colour=\"red\"><Real/></ScalarVariable>\n"
        )
    };
    let many: String = (0..500).map(variable).collect();
    let description = model("</ModelVariables>", &format!("{many}</ModelVariables>"));
    // Without a binary, which is a line more.
    bench.zip("broken.fmu", &[("modelDescription.xml", description.as_bytes())]);
    let said = bench.run(&["check", "broken.fmu"]);
    assert_eq!((said.code, said.out.lines().count()), (1, 23), "{}", said.out);
    assert!(said.out.contains("error: 480 more of this kind"), "{}", said.out);
    let said = bench.run(&["check", "broken.fmu", "--format", "json"]);
    let report: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let findings = report["findings"].as_array().unwrap().iter().filter(|f| f["rule"] != "binary-there");
    let lines: Vec<_> = findings.map(|f| f["line"].as_u64().unwrap()).collect();
    assert_eq!(lines.len(), 500);
    assert!(lines.windows(2).all(|pair| pair[1] == pair[0] + 1), "{lines:?}");
}

/// The functions' names as a build for static linking changes them.
#[test]
fn a_prefix_is_found() {
    let word = |c: char| !c.is_ascii_alphanumeric();
    let source = include_str!("../fixtures/lag.c");
    let names = source.split(word).filter(|name| name.starts_with("fmi2"));
    let macros: Vec<String> = names.map(|name| format!("{name}=lag_{name}")).collect();
    let macros: Vec<&str> = macros.iter().map(String::as_str).collect();
    let bench = Bench::empty();
    bench.fmu("broken.fmu", &macros, &model("guid", "guid"));
    let words = "binary-functions: exports lag_fmi2DoStep instead of fmi2DoStep";
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
        ("no binary", "resources/none", b"", "binary-there: no binary for this platform"),
        ("no folder of a platform", "binaries/lag.so", &good, "binary-there: no binary for this platform"),
        ("another machine", place, &arm, "binary-machine: lag.so: a binary for Aarch64"),
        ("another width", place, &narrow, "binary-readable: lag.so: "),
        ("no library", place, b"not a library", "binary-readable: lag.so: no shared library"),
        ("half a library", place, &good[..good.len() / 2], "binary-readable: lag.so: "),
        ("another name", "binaries/linux64/leg.so", &good, "binary-name: call it lag.so"),
        (
            "a folder in upper case",
            "Binaries/Linux64/lag.so",
            &good,
            "binary-folder: Binaries/Linux64/lag.so: the folder's name is binaries/linux64/",
        ),
        ("a way out", "../outside.txt", b"", "archive-path: ../outside.txt: the path leads outside"),
    ];
    let mut wrong = Vec::new();
    for (name, entry, content, words) in cases {
        let description = description.as_bytes();
        bench.zip("broken.fmu", &[("modelDescription.xml", description), (entry, content)]);
        wrong.extend(amiss(&bench, name, words));
    }
    // A good binary, and beside it one that lies in the folder of another platform.
    let entries: [(&str, &[u8]); 3] =
        [("modelDescription.xml", description.as_bytes()), (place, &good), ("binaries/linux32/lag.so", &good)];
    bench.zip("broken.fmu", &entries);
    let words = "binary-machine: linux32/lag.so: a binary for X86_64";
    wrong.extend(amiss(&bench, "another platform", words));
    let whole = description.split("<ModelStructure>").next().unwrap();
    let cut = format!("{whole}</fmiModelDescription>");
    bench.zip("broken.fmu", &[("modelDescription.xml", cut.as_bytes()), (place, &good)]);
    let words = "schema-element-missing: needs the element `ModelStructure`";
    wrong.extend(amiss(&bench, "no structure", words));
    let entries: [(&str, &[u8]); 3] =
        [("modelDescription.xml", description.as_bytes()), (place, &good), ("binaries/darwin64/LAG.dylib", b"")];
    bench.zip("broken.fmu", &entries);
    let found = "binary-name: darwin64/LAG.dylib: the binary is named otherwise";
    wrong.extend(amiss(&bench, "another name beside it", found));
    let identifier = model("modelIdentifier=\"lag\"", "modelIdentifier=\"la-g\"");
    let entries: [(&str, &[u8]); 2] =
        [("modelDescription.xml", identifier.as_bytes()), ("binaries/linux64/la-g.so", &good)];
    bench.zip("broken.fmu", &entries);
    let found = "model-identifier: `la-g` is no C identifier";
    wrong.extend(amiss(&bench, "no identifier", found));
    bench.zip("broken.fmu", &[("lag/modelDescription.xml", description.as_bytes())]);
    let (name, words) = ("a folder around it", "archive-readable: belongs to the top of the archive");
    wrong.extend(amiss(&bench, name, words));
    none(&wrong);
}

/// Cases that take more than one change of the description, or other bytes.
#[test]
fn every_broken_document_is_found() {
    broken_documents(7);
}

fn broken_documents(run: usize) {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let binary = bench.binary(&[]);
    let place = "binaries/linux64/lag.so";
    let structured = model("guid=", "variableNamingConvention=\"structured\" guid=").replace("lag.y", "lag y");
    let latin: Vec<u8> = description.replace("first-order", "b\u{e4}d").chars().map(|c| c as u8).collect();
    let wide: Vec<u8> = ["\u{feff}", &description].concat().encode_utf16().flat_map(u16::to_le_bytes).collect();
    let states = "<ScalarVariable name=\"x\" valueReference=\"3\"><Real/></ScalarVariable>\
        <ScalarVariable name=\"der(x)\" valueReference=\"4\"><Real unit=\"K\" derivative=\"12\"/></ScalarVariable>\
        </ModelVariables>";
    let listed = "</Outputs><Derivatives><Unknown index=\"13\"/></Derivatives>";
    let stateful = description.replace("</ModelVariables>", states).replace("</Outputs>", listed);
    let spaced = model("<fmiModelDescription", "<f:fmiModelDescription xmlns:f=\"f\"").replace("</fmi", "</f:fmi");
    let (before, rest) = description.split_once("<ModelStructure>").unwrap();
    let after = rest.split_once("</ModelStructure>").unwrap().1;
    let without = format!("{before}<ModelStructure/>{after}").replace("causality=\"output\"", "causality=\"local\"");
    let mut wrong = Vec::new();
    let cases = [
        (
            "upper case",
            "ModelDescription.xml",
            description.as_bytes(),
            "archive-readable: call it modelDescription.xml",
        ),
        ("another encoding", "modelDescription.xml", &latin, "xml-encoding: not UTF-8"),
        (
            "two bytes a character",
            "modelDescription.xml",
            &wide,
            "xml-encoding: the bytes are UTF-16, but the file is declared as UTF-8",
        ),
        (
            "a state that is computed initially, but not listed",
            "modelDescription.xml",
            stateful.as_bytes(),
            "warning initial-unknowns-complete: does not list x (index 12), der(x) (index 13) in InitialUnknowns",
        ),
        ("a namespace", "modelDescription.xml", spaced.as_bytes(), "schema-namespace: the namespace \"f\""),
        ("no outputs", "modelDescription.xml", without.as_bytes(), "note outputs-none: no outputs"),
        (
            "names out of the convention",
            "modelDescription.xml",
            structured.as_bytes(),
            "structured-name: lag y: no structured name",
        ),
    ];
    for (case, (name, entry, content, words)) in cases.into_iter().enumerate() {
        let files: [(&str, &[u8]); 2] = [(entry, content), (place, &binary)];
        let pack = |whole: bool| bench.zip("broken.fmu", &files[..1 + usize::from(whole)]);
        wrong.extend(described(&bench, (case, run), pack, name, words));
    }
    none(&wrong);
}

/// Damage in the zip itself: a bit in a compressed file, its mark as encrypted, its method, an entry's name.
#[test]
fn every_damaged_archive_is_found() {
    let bench = Bench::empty();
    let description = model("guid", "guid");
    let binary = bench.binary(&[]);
    let files: [(&str, &[u8]); 4] = [
        ("modelDescription.xml", description.as_bytes()),
        ("binaries/linux64/lag.so", &binary),
        ("resources/one", b""),
        ("resources/two", b""),
    ];
    bench.zip("broken.fmu", &files);
    let path = bench.path("broken.fmu");
    let good = std::fs::read(&path).unwrap();
    // The heads of the entries, before them and in the directory, and where they have their flags.
    let heads = |mark: [u8; 4], flags: usize| {
        let places = 0..good.len() - 4;
        places.filter(|at| good[*at..].starts_with(&mark)).map(move |at| at + flags).collect::<Vec<_>>()
    };
    let names: Vec<usize> =
        (0..good.len() - 13).filter(|at| good[*at..].starts_with(b"resources/two")).map(|at| at + 10).collect();
    let flags = [heads(*b"PK\x01\x02", 8), heads(*b"PK\x03\x04", 6)].concat();
    let mut wrong = Vec::new();
    for (name, words) in [
        ("a flipped bit", "archive-readable: damaged ("),
        ("encrypted", "archive-readable: modelDescription.xml: encrypted"),
        ("another method", "archive-readable: deflate"),
        ("two entries of a name", "warning archive-entry-unique: resources/one: remove one"),
    ] {
        let mut bytes = good.clone();
        match name {
            "a flipped bit" => bytes[200] ^= 0x10,
            "encrypted" => flags.iter().for_each(|at| bytes[*at] |= 1),
            "two entries of a name" => names.iter().for_each(|at| bytes[*at..at + 3].copy_from_slice(b"one")),
            _ => flags.iter().for_each(|at| bytes[at + 2] = 14),
        }
        std::fs::write(&path, &bytes).unwrap();
        wrong.extend(amiss(&bench, name, words));
    }
    none(&wrong);
}
