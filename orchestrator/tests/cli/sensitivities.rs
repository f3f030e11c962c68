//! `sensitivity` on analytic functions: failures that cost one output only.

use serde_json::Value;

use crate::support::{Bench, Said};

const HEAD: &str = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[design]
method = "sobol"
points = 512
[parameters]
x1 = { distribution = "uniform", min = 0, max = 1 }
x2 = { distribution = "uniform", min = 0, max = 1 }
x3 = { distribution = "uniform", min = 0, max = 1 }
x4 = { distribution = "uniform", min = 0, max = 1 }
"#;

fn criteria(names: &[&str]) -> String {
    let criterion = |name: &&str| format!("[criteria.{name}]\nvariable = \"{name}\"\nnominal = 1\ntolerance = 0.9\n");
    names.iter().map(criterion).collect()
}

fn result(bench: &Bench, folder: &str) -> Value {
    serde_json::from_str(&bench.read(&format!("{folder}/sensitivity.json"))).unwrap()
}

fn sensitive(bench: &Bench, study: &str, more: &[&str]) -> (Said, Value) {
    bench.write("study.toml", study);
    let command = ["sensitivity", "study.toml", "--output", "s"];
    let said = bench.run(&[&command[..], more].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    (said, result(bench, "s"))
}

fn output<'a>(result: &'a Value, name: &str) -> &'a Value {
    let outputs = result["outputs"].as_array().unwrap();
    let found = outputs.iter().find(|output| output["name"] == name);
    found.unwrap_or_else(|| panic!("no `{name}` in {result}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_failure_of_one_output_costs_that_output_only() {
    let seeds = ["1", "2", "3", "4"];
    let results = seeds.map(|seed| holed(&["--base", "256", "--seed", seed]));
    let mean = |of: &dyn Fn(&Value) -> f64| results.iter().map(of).sum::<f64>() / 4.0;
    // The corner is one of x1 and x2.
    let total = |both: &Value, k: usize, of: &str| number(&output(both, "failed")["sobol"]["total"][k][of]);
    for k in [0, 1] {
        let low = mean(&|both| total(both, k, "low"));
        assert!(low > 0.2, "{low}");
    }
    for k in [2, 3] {
        assert!(results.iter().all(|both| total(both, k, "value") == 0.0));
    }
}

/// The result of a study with an output that fails somewhere, which leaves the other output's as it is alone.
fn holed(options: &[&str]) -> Value {
    let bench = Bench::functions();
    let study = format!("{HEAD}{}", criteria(&["linear"]));
    let (_, alone) = sensitive(&bench, &study, options);
    assert!(alone["warnings"].as_array().unwrap().is_empty());
    std::fs::remove_dir_all(bench.path("s")).unwrap();
    let study = format!("{HEAD}{}", criteria(&["linear", "holed"]));
    let (said, both) = sensitive(&bench, &study, options);
    let linear = output(&both, "linear");
    assert_eq!(linear["missing"], 0);
    assert_eq!(linear["sobol"], output(&alone, "linear")["sobol"]);
    let missing = number(&output(&both, "holed")["missing"]);
    assert!(missing > 20.0 && both["failed"] == missing, "{both}");
    for words in ["holed: ", " of 1536 runs have no value of it", "would be others if"] {
        assert!(said.out.contains(words), "no `{words}` in {}", said.out);
    }
    // The runs' table has the values that there are.
    let runs = bench.read("s/sensitivity-runs.csv");
    let failed: Vec<&str> = runs.lines().filter(|line| line.contains("not finite")).collect();
    assert!(failed.iter().all(|line| line.ends_with(",,false,not finite: holed")));
    assert_eq!(failed.len() as f64, missing);
    both
}

#[test]
fn points_of_a_study_tell_indices_where_a_surrogate_holds() {
    told_by_points(96, "from the 96 points");
}

/// Surrogates learn from a part of many points.
#[test]
#[ignore = "takes a while: scripts/test --long"]
fn many_points_of_a_study_tell_indices_where_a_surrogate_holds() {
    told_by_points(512, "from 250 of the 512 points");
}

fn told_by_points(points: u32, words: &str) {
    let bench = Bench::functions();
    let head = HEAD.replace("points = 512", &format!("points = {points}"));
    bench.write("study.toml", &format!("{head}{}", criteria(&["linear", "holed"])));
    assert!(bench.run(&["verify", "study.toml", "--output", "out"]).code < 2);
    // By closed form x2 has 4 of 14; where runs fail without a pattern a design is asked for.
    let said = bench.run(&["sensitivity", "study.toml", "--from", "out"]);
    assert!(said.out.contains(words) && said.out.contains("--base 256"), "{}{}", said.out, said.err);
    let told: Value = serde_json::from_str(&bench.read("out/sensitivity.json")).unwrap();
    let total = &told["outputs"][0]["sobol"]["total"][1];
    let [value, low, high] = ["value", "low", "high"].map(|key| total[key].as_f64().unwrap());
    assert!((value - 4.0 / 14.0).abs() < 0.01 && low < 4.0 / 14.0 && 4.0 / 14.0 < high, "{total}");
    assert!(number(&told["failed"]) > 0.0);
    // The table of points has no value of a failed one, whichever criterion it failed by.
    for name in ["holed", "linear"] {
        assert_eq!(output(&told, name)["missing"], told["failed"], "{name}");
    }
    // Surrogates are told of failed runs.
    let said = bench.run(&["robustness", "study.toml", "--from", "out"]);
    assert!(said.out.contains(&format!("of {points} points failed")), "{}{}", said.out, said.err);
}

#[test]
fn shapley_effects_divide_the_variance_among_correlated_parameters() {
    let bench = Bench::functions();
    let correlated = "[[correlations]]\nbetween = [\"x1\", \"x4\"]\ncoefficient = 0.9\n";
    let study = format!("{HEAD}{}{correlated}", criteria(&["linear", "first"]));
    bench.write("study.toml", &study);
    let sobol = bench.run(&["sensitivity", "study.toml", "--base", "16"]);
    sobol.is_mistake(&["correlated ones cannot be changed alone", "study.toml --budget 100"]);
    let (said, found) = sensitive(&bench, &study, &["--budget", "60"]);
    assert!(number(&found["runs"]) <= 60.0);
    assert!(said.out.contains("warning: the parameters are correlated"), "{}", said.out);
    let effects = |name: &str| -> Vec<f64> {
        let effects = output(&found, name)["shapley"]["effects"].as_array().unwrap();
        effects.iter().map(|effect| number(&effect["value"])).collect()
    };
    for name in ["linear", "first"] {
        assert!((effects(name).iter().sum::<f64>() - 1.0).abs() < 0.01);
    }
    // x1 explains all of its own output, and x4 some 0.8 of it; half of what both explain goes to each.
    let first = effects("first");
    assert!((first[3] - 0.4).abs() < 0.05 && first[1].abs() < 0.03, "{first:?}");
    let linear = effects("linear");
    assert!((linear[1] - 4.0 / 14.0).abs() < 0.03 && (linear[2] - 9.0 / 14.0).abs() < 0.05);
}
