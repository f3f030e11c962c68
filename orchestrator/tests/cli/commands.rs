//! The small commands around a study.

use crate::support::Bench;

#[test]
fn a_sound_fmu_has_no_findings() {
    let bench = Bench::new();
    let said = bench.run(&["check", "lag.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("nothing found"));
}

#[test]
fn a_doubtful_fmu_has_findings() {
    let bench = Bench::empty();
    let description = crate::support::model("valueReference=\"30\"", "valueReference=\"x\"");
    bench.fmu("odd.fmu", &[], &description);
    let said = bench.run(&["check", "odd.fmu"]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.out.contains("lag.text"), "{}", said.out);
    let startless = crate::support::model(
        "declaredType=\"Fault\" start=\"0\"",
        "declaredType=\"Fault\"",
    );
    bench.fmu("plain.fmu", &["NO_RESET"], &startless);
    let said = bench.run(&["check", "plain.fmu"]);
    assert_eq!(said.code, 1, "{}", said.out);
    for words in ["lag.fault: no start value", "does not export fmi2Reset"] {
        assert!(said.out.contains(words), "{}", said.out);
    }
}

#[test]
fn a_starting_study_becomes_a_study() {
    let bench = Bench::new();
    let said = bench.run(&["init", "lag.fmu", "--output", "study.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    bench
        .run(&["init", "lag.fmu", "--output", "study.toml"])
        .is_mistake(&["exists already"]);
    // As it is, it lacks only a criterion.
    bench
        .run(&["verify", "study.toml"])
        .is_mistake(&["no criteria"]);
    // With all marks removed, it is a study.
    let text = bench.read("study.toml");
    let useful = |line: &str| line.starts_with("[") || line.contains(" = ");
    let lines = text
        .lines()
        .map(|line| line.strip_prefix("# ").unwrap_or(line));
    let whole: Vec<&str> = lines
        .filter(|line| useful(line) && !line.starts_with("warm-up"))
        .collect();
    bench.write("whole.toml", &whole.join("\n"));
    let said = bench.run(&["verify", "whole.toml", "--points", "8", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    assert_eq!(bench.summary("out")["points"], 8);
    let dry = bench.run(&["verify", "whole.toml", "--dry-run", "--output", "dry"]);
    assert_eq!(dry.code, 0, "{}", dry.err);
    assert!(
        dry.out.contains("64 points") && dry.out.contains("lag.rate"),
        "{}",
        dry.out
    );
    assert!(!bench.path("dry").exists());
}

#[test]
fn shells_get_their_completion() {
    let bench = Bench::empty();
    for shell in ["bash", "zsh", "fish"] {
        let said = bench.run(&["completion", shell]);
        assert!(said.code == 0 && said.out.contains("verify"), "{shell}");
    }
}
