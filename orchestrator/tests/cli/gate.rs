//! What build servers want: JUnit files, exit codes of warnings, findings that are known.

use crate::support::{Bench, model};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.4
[design]
points = 20
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1
[[cases]]
name = "cold"
criteria.Y = { variable = "lag.y", nominal = 0.86, tolerance = 0.1 }
[[cases]]
name = "hot"
criteria.Y = { variable = "lag.y", nominal = 3, tolerance = 0.1 }
"#;

/// A test of a JUnit file: its class, its name, and what it holds.
pub type Test = (String, String, Option<String>);

/// The tests of a JUnit file, of which the counts must be right.
pub fn tests(bench: &Bench, file: &str) -> Vec<Test> {
    let text = bench.read(file);
    let document = roxmltree::Document::parse(&text).unwrap();
    let suite = document.root_element().first_element_child().unwrap();
    let cases = suite.children().filter(|node| node.is_element());
    let test = |case: roxmltree::Node<'_, '_>| {
        let of = |name| case.attribute(name).unwrap().to_owned();
        let inner = case.first_element_child();
        let inner = inner.map(|inner| {
            let message = inner.attribute("message").unwrap();
            format!("{}: {message}", inner.tag_name().name())
        });
        (of("classname"), of("name"), inner)
    };
    let tests: Vec<Test> = cases.map(test).collect();
    let count = |what: &str| {
        let of_it = tests.iter().filter(|(.., inner)| inner.as_ref().is_some_and(|i| i.starts_with(what)));
        of_it.count().to_string()
    };
    for (name, of) in [("failures", "failure"), ("errors", "error"), ("skipped", "skipped")] {
        assert_eq!(suite.attribute(name), Some(&*count(of)), "{text}");
    }
    assert_eq!(suite.attribute("tests"), Some(&*tests.len().to_string()));
    tests
}

fn find<'a>(tests: &'a [Test], class: &str, name: &str) -> Option<&'a str> {
    let is_it = |test: &&Test| test.0 == class && test.1 == name;
    let test = tests.iter().find(is_it);
    test.unwrap_or_else(|| panic!("no {class} {name} in {tests:?}")).2.as_deref()
}

/// A green file of an earlier run does not stand for one that could not be done.
#[test]
fn a_mistake_is_an_error_of_the_file() {
    let bench = Bench::new();
    bench.write("green.xml", "<testsuites/>");
    bench.write("study.toml", &STUDY.replace("lag.fmu", "none.fmu"));
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--junit", "green.xml"]);
    said.is_mistake(&["none.fmu"]);
    let told = tests(&bench, "green.xml");
    assert!(find(&told, "orchestrator", "run").unwrap().starts_with("error: "), "{told:?}");
    bench.write("green.xml", "<testsuites/>");
    bench.run(&["verify", "study.toml", "--strct", "--junit", "green.xml"]).is_mistake(&["--strict"]);
    assert!(find(&tests(&bench, "green.xml"), "orchestrator", "run").unwrap().contains("--strct"));
}

#[test]
fn a_verdict_has_a_test_a_criterion_and_a_case() {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--junit", "new/junit.xml"]);
    assert_eq!(said.code, 1, "{}", said.err);
    let all = tests(&bench, "new/junit.xml");
    assert_eq!(find(&all, "study.cold", "Y"), None);
    let failure = "failure: 3 +-0.1: 0 of 20 points meet it";
    assert_eq!(find(&all, "study.hot", "Y"), Some(failure));
    assert!(find(&all, "study.hot", "all criteria").unwrap().starts_with("failure: "));
    assert!(find(&all, "study", "verdict").unwrap().starts_with("failure: "));
    // A part of the points has no verdict.
    bench.run(&["verify", "study.toml", "--shard", "1/2", "--junit", "junit.xml"]).is_mistake(&["--junit", "merge"]);
}

/// A verdict that nothing could have made another one is no pass of a strict gate: recordings and tolerances, with the kind of
/// the doubt, or none.
#[test]
fn a_strict_gate_does_not_pass_what_decides_nothing() {
    let bench = Bench::new().in_process();
    bench.write("two.csv", "time,lag.y\n0.4,0.33\n2,0.86\n");
    let rows = (1..=5).map(|k| 0.4 * f64::from(k)).map(|t| format!("{t},{}\n", 1.0 - (-t).exp())).collect::<String>();
    bench.write("run.csv", &format!("time,lag.y\n{rows}"));
    bench.write("zero.csv", "time,lag.y\n0.4,0.001\n1.2,-0.002\n2,0.001\n");
    let curve = |more: &str, tolerance: &str| {
        format!("variable = \"lag.y\"\nreference = {{ file = {more} }}\nmetric = \"rmse\"\ntolerance = {tolerance}\n")
    };
    let single = |tolerance: &str| format!("variable = \"lag.y\"\nnominal = 1\ntolerance = {tolerance}\n");
    // The level has settled then; the points differ by some 0.006.
    let head = STUDY.split("[[cases]]").next().unwrap().replace("stop = 2", "stop = 6.8");
    for (criterion, doubt) in [
        (curve("\"two.csv\"", "0.2"), Some("few-rows")),
        (curve("\"run.csv\"", "0.2"), None),
        (curve("\"run.csv\"", "2"), Some("wide-tolerance")),
        // What is 0 within its uncertainty may be 0.
        (curve("\"zero.csv\", uncertainty = 0.1", "2"), None),
        (curve("\"zero.csv\"", "2"), Some("wide-tolerance")),
        (single("0.3"), None),
        (single("1"), Some("wide-tolerance")),
        (single("0.9"), Some("wide-tolerance")),
    ] {
        let study = format!("{head}[criteria.Y]\n{criterion}");
        is_doubted(&bench, &study, doubt);
    }
    let cases = |first: &str| {
        let case = |name: &str, more: &str| format!("[[cases]]\nname = \"{name}\"\n{more}\n");
        let all = case("a", first) + &case("b", "held-out = true");
        format!("{head}{all}[criteria.Y]\n{}", single("0.3"))
    };
    is_doubted(&bench, &cases(""), None);
    is_doubted(&bench, &cases("held-out = true"), Some("all-held-out"));
    // Where the gate is not strict, a doubt lets a study pass.
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--force", "--extra-runs", "0"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

/// A verified study passes; of such doubts alone, a strict gate fails.
fn is_doubted(bench: &Bench, study: &str, doubt: Option<&str>) {
    bench.write("study.toml", study);
    let run = ["verify", "study.toml", "--output", "out", "--force", "--extra-runs", "0", "--strict"];
    let said = bench.run(&run);
    assert_eq!(said.code, i32::from(doubt.is_some()), "{study}{}{}", said.out, said.err);
    let summary = bench.summary("out");
    let found = summary["concerns"].as_array().unwrap().iter().filter(|concern| concern["severity"] == "warning");
    let found: Vec<&str> = found.map(|concern| concern["code"].as_str().unwrap()).collect();
    assert_eq!(found, Vec::from_iter(doubt), "{study}{summary}");
    assert!(summary["verdict"].as_str().unwrap() == "verified", "{study}{summary}");
}

/// One point of a design that happens to agree shows no doubt, so it passes no strict gate.
#[test]
fn few_points_pass_no_strict_gate() {
    let bench = Bench::new();
    // The level has settled then, and nothing else is doubtful.
    let study = STUDY.split("[[cases]]").next().unwrap().replace("stop = 2", "stop = 6.8")
        + "[criteria.Y]\nvariable = \"lag.y\"\nnominal = 1\ntolerance = 0.3\n";
    bench.write("study.toml", &study);
    for (points, more, code) in [("1", &[][..], 0), ("9", &["--strict"], 1), ("10", &["--strict"], 0)] {
        let run = ["verify", "study.toml", "--output", "out", "--force", "--junit", "junit.xml", "--points", points];
        let said = bench.run(&[&run[..], &["--extra-runs", "0"], more].concat());
        assert_eq!(said.code, code, "{points}: {}{}", said.out, said.err);
        let few = "fewer than 10 points show no doubt: run more";
        assert_eq!(said.err.contains(few), code == 1, "{}", said.err);
        let told = tests(&bench, "junit.xml").iter().any(|test| test.2.as_ref().is_some_and(|text| text.contains(few)));
        assert_eq!(told, code == 1);
    }
}

#[test]
fn warnings_end_a_strict_run_with_1() {
    let bench = Bench::new();
    let study = STUDY.split("[[cases]]").next().unwrap().to_owned()
        + "[criteria.Y]\nvariable = \"lag.y\"\nnominal = 0.86\ntolerance = 0.1\nuncertainty = 0.2\n";
    bench.write("study.toml", &study);
    bench.write("table.csv", "Y\n0.86\n0.9\n");
    for command in ["verify study.toml --output out", "judge study.toml table.csv"] {
        let arguments: Vec<&str> = command.split(' ').collect();
        let run = |more: &[&str]| bench.run(&[&arguments[..], more].concat());
        let said = run(&["--junit", "junit.xml"]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let class = "study.warnings";
        let name = "uncertainty-above-tolerance";
        let doubt = |all: &[Test]| find(all, class, name).unwrap().to_owned();
        assert!(doubt(&tests(&bench, "junit.xml")).starts_with("skipped: warning: "));
        let force: &[&str] = if command.starts_with("verify") { &["--force"] } else { &[] };
        let said = run(&[force, &["--junit", "junit.xml", "--strict"]].concat());
        assert_eq!(said.code, 1, "{}{}", said.out, said.err);
        assert!(said.err.contains("--strict"), "{}", said.err);
        let all = tests(&bench, "junit.xml");
        assert!(doubt(&all).starts_with("failure: "));
        assert_eq!(find(&all, "study", "verdict"), None);
    }
}

#[test]
fn a_strict_run_says_how_many_warnings_there_are() {
    let bench = Bench::new();
    let criterion = |name: &str| {
        format!("[criteria.{name}]\nvariable = \"lag.y\"\nnominal = 0.86\ntolerance = 0.1\nuncertainty = 0.2\n")
    };
    let study = STUDY.split("[[cases]]").next().unwrap().to_owned() + &criterion("Y") + &criterion("Z");
    bench.write("study.toml", &study);
    bench.write("table.csv", "Y,Z\n0.86,0.86\n0.9,0.9\n");
    let said = bench.run(&["judge", "study.toml", "table.csv", "--strict"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.err.contains("--strict allows for no warning (found: 2)\n"), "{}", said.err);
}

#[test]
fn findings_that_are_known_do_not_count_and_have_a_reason() {
    let bench = Bench::new();
    let broken = model("unit=\"K\" displayUnit=\"degC\"", "unit=\"kelvin\"");
    bench.fmu("lag.fmu", &[], &broken);
    let said = bench.run(&["check", "lag.fmu", "--format", "json", "--junit", "junit.xml"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let report: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let rule = report["findings"][0]["rule"].as_str().unwrap();
    let all = tests(&bench, "junit.xml");
    assert!(find(&all, "lag", "check").unwrap().starts_with("failure: 1 findings"));
    let entry = |more: &str| {
        format!("[[ignore]]\nrule = \"{rule}\"\nvariable = \"lag.temperature\"\nreason = \"as delivered\"\n{more}")
    };
    bench.write("known.toml", &entry(""));
    let known = ["check", "lag.fmu", "--ignore", "known.toml", "--junit", "junit.xml"];
    let said = bench.run(&known);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("nothing found, 1 known and ignored"), "{}", said.out);
    assert_eq!(said.err, "");
    let all = tests(&bench, "junit.xml");
    assert_eq!(find(&all, "lag", "check"), None);
    assert!(all[1].2.as_deref().unwrap().starts_with("skipped: known: as delivered"));
    let said = bench.run(&["check", "lag.fmu", "--ignore", "known.toml", "--format", "sarif"]);
    let log: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let suppression = &log["runs"][0]["results"][0]["suppressions"][0];
    assert_eq!(suppression["justification"], "as delivered");
    // An entry that nothing needs is told, and one of another variable hides nothing.
    bench.write("known.toml", &entry("").replace("lag.temperature", "lag.y"));
    let said = bench.run(&known);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.err.contains("of lag.y is left to ignore"), "{}", said.err);
    bench.write("known.toml", &entry("").replace(rule, "unit"));
    bench.run(&known).is_mistake(&["known.toml", "no rule `unit`"]);
    bench.write("known.toml", &entry("").replace("as delivered", " "));
    bench.run(&known).is_mistake(&["has no reason"]);
    let no_reason = format!("[[ignore]]\nrule = \"{rule}\"\n");
    bench.write("known.toml", &no_reason);
    bench.run(&known).is_mistake(&["has no reason"]);
    bench.write("known.toml", &entry("because = 1"));
    let said = bench.run(&known);
    said.is_mistake(&["known.toml", "because"]);
    assert!(!said.err.contains("u000a"), "{}", said.err);
}
