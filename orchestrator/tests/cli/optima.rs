//! `identify` on analytic functions: every optimum, and nothing called determined that is not.

use crate::support::{Bench, Said};

const STUDY: &str = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify.free.x1]
min = 0.1
max = 3.1
[identify.measured.W]
variable = "wave"
value = 0.5
accuracy = 0.02
"#;

/// Calibrates `study.toml`. The FMU is known to keep nothing from one point to the next.
fn identify(bench: &Bench, options: &[&str]) -> Said {
    let common = ["identify", "study.toml", "--isolation", "none"];
    bench.run(&[&common, options].concat())
}

fn json(bench: &Bench, file: &str) -> serde_json::Value {
    serde_json::from_str(&bench.read(file)).unwrap()
}

#[test]
fn six_exact_solutions_are_six_optima() {
    let bench = Bench::functions();
    bench.write("study.toml", STUDY);
    let said = identify(&bench, &["--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for words in ["6 distinct sets of parameters fit", "optimum 6: ", "None of them is \"the\" value"] {
        assert!(said.out.contains(words), "{}", said.out);
    }
    assert!(!said.out.contains("determine every parameter"), "{}", said.out);
    let found = json(&bench, "out/identification.json");
    assert_eq!(found["ambiguous"], true);
    let optima = found["optima"].as_array().unwrap();
    let mut places: Vec<f64> = optima.iter().map(|own| own["free"][0]["value"].as_f64().unwrap()).collect();
    places.sort_by(f64::total_cmp);
    // The roots of sin(6 x) + 0.3 x = 0.5 between 0.1 and 3.1, by halving.
    let exact = [0.46197, 1.07684, 1.56575, 2.07398, 2.66889, 3.06921];
    assert_eq!(places.len(), exact.len(), "{places:?}");
    for (place, exact) in places.iter().zip(exact) {
        assert!((place - exact).abs() < 1e-4, "{place} {exact}");
    }
    let weights = optima.iter().map(|own| own["weight"].as_f64().unwrap());
    assert!((weights.sum::<f64>() - 1.0).abs() < 1e-9);
    // A section to paste for each, and none that claims to be the only one.
    assert!(bench.read("out/optimum-1.toml").contains("Optimum 1 of 6"));
    assert!(bench.path("out/optimum-6.toml").exists());
    assert!(!bench.path("out/optimum.toml").exists());
    // What a second measured value decides leaves one optimum, and one file.
    let decided = "[identify.measured.X]\nvariable = \"first\"\nvalue = 1.5\naccuracy = 0.05\n";
    bench.write("study.toml", &format!("{STUDY}{decided}"));
    let said = identify(&bench, &["--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("they are normal approximations"), "{}", said.out);
    assert!(bench.path("out/optimum.toml").exists());
    assert!(!bench.path("out/optimum-1.toml").exists());
    assert!(!bench.path("out/optimum-6.toml").exists());
}

#[test]
fn a_product_is_one_valley_and_not_determined() {
    let bench = Bench::functions();
    let study = STUDY
        .replace("\"wave\"", "\"product\"")
        .replace("[identify.measured", "[identify.free.x2]\nmin = 0.1\nmax = 3.1\n[identify.measured");
    bench.write("study.toml", &study);
    let said = identify(&bench, &["--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("The data do not determine:"), "{}", said.out);
    let found = json(&bench, "out/identification.json");
    assert_eq!(found["optima"].as_array().unwrap().len(), 1);
}

#[test]
fn a_sample_of_the_posterior_holds_all_modes_and_can_be_predicted_from() {
    let bench = Bench::functions();
    bench.write("study.toml", STUDY);
    let said = identify(&bench, &["--posterior", "240", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for words in ["posterior sample: 240 particles (", " or 3.0"] {
        assert!(said.out.contains(words), "no `{words}` in {}", said.out);
    }
    let sample = &json(&bench, "out/identification.json")["posterior"];
    assert_eq!(sample["free"][0]["intervals"].as_array().unwrap().len(), 6);
    let table = bench.read("out/posterior.csv");
    assert!(table.starts_with("# x1 in 1\npoint,x1,log_likelihood\n1,"), "{table}");
    assert_eq!(table.lines().count(), 242);
    // The file is a table of points: what the model predicts with them is what was measured.
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[parameters.x1]
distribution = "uniform"
min = 0.1
max = 3.1
[criteria.W]
variable = "wave"
nominal = 0.5
tolerance = 0.04
"#;
    bench.write("predict.toml", study);
    let predict = ["verify", "predict.toml", "--points-from", "out/posterior.csv"];
    let said = bench.run(&[&predict[..], &["--output", "predicted"]].concat());
    assert_eq!(said.code, 0, "{}", said.err);
    let summary = bench.summary("predicted");
    assert_eq!(summary["points"], 240);
    // Two standard deviations to both sides: 95.4 %.
    let share = summary["verified_fraction"].as_f64().unwrap();
    assert!((share - 0.954).abs() < 0.045, "{share}");
    // Without the option an earlier sample goes.
    let said = identify(&bench, &["--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!bench.path("out/posterior.csv").exists());
    assert!(json(&bench, "out/identification.json")["posterior"].is_null());
    bench.run(&["identify", "study.toml", "--posterior", "20"]).is_mistake(&[
        "--posterior",
        "20 particles",
        "give 200 or more",
    ]);
    let few = STUDY.replace("[identify.free.x1]", "[identify]\nposterior = 20\n[identify.free.x1]");
    bench.write("few.toml", &few);
    bench.run(&["identify", "few.toml"]).is_mistake(&["few.toml:6", "20 particles", "give 200 or more"]);
}

/// y = x1 x2 at ten known x2, with misfits ten times as large as the stated accuracy.
#[test]
fn a_model_that_misses_is_told_and_its_own_error_is_part_of_the_accuracy() {
    let bench = Bench::functions();
    let misfits = [0.09, -0.12, 0.05, 0.14, -0.07, -0.02, 0.11, -0.1, 0.06, -0.13];
    let rows = misfits.iter().enumerate().map(|(k, misfit)| {
        let x2 = 1.0 + 0.1 * k as f64;
        format!("{},{x2},{}\n", k + 1, 2.0 * x2 + misfit)
    });
    let rows: String = rows.collect();
    bench.write("cases.csv", &format!("point,b,y\n{rows}"));
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify]
cases = "cases.csv"
[identify.free.x1]
min = 0
max = 10
[identify.known.x2]
column = "b"
[identify.measured.Y]
variable = "product"
column = "y"
accuracy = 0.01
"#;
    let deviation = |text: &str, more: &[&str]| {
        bench.write("study.toml", text);
        let command = ["identify", "study.toml", "--output", "out"];
        let said = bench.run(&[&command[..], more].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        let found = json(&bench, "out/identification.json");
        (found["free"][0]["deviation"].as_f64().unwrap(), said.out)
    };
    let (narrow, said) = deviation(study, &[]);
    assert!(said.contains("A right model would miss by this much in fewer than 1 of a million tests"), "{said}");
    // The model's own error is part of the accuracy.
    let (wide, _) = deviation(&study.replace("accuracy = 0.01", "accuracy = 0.1"), &[]);
    assert!((wide / narrow - 10.0).abs() < 0.01, "{wide} {narrow}");
}

/// x1 + x3 without a value where x1 > 0.8 and x2 > 0.7, next to the optimum; and a model without a value where the answer is.
#[test]
fn what_failed_runs_exclude_is_said() {
    let bench = Bench::functions();
    let study = |output: &str, max: f64, value: f64| {
        format!(
            r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify]
starts = 256
[identify.free.x1]
min = 0
max = {max}
[identify.free.x2]
min = 0
max = 1
[identify.measured.Y]
variable = "{output}"
value = {value}
accuracy = 0.02
"#
        )
    };
    // x2 = 0.65 +- 0.1 stands near the places that fail, and its interval reaches into them.
    let second = "[identify.measured.Z]\nvariable = \"second\"\nvalue = 0.65\naccuracy = 0.1\n";
    let holed = study("holed", 1.0, 1.4) + second;
    bench.write("study.toml", &holed);
    let command = ["identify", "study.toml", "--output", "out", "--posterior", "400"];
    let said = bench.run(&command);
    assert_eq!(said.code, 0, "{}", said.err);
    let found = json(&bench, "out/identification.json");
    let starts = &found["excluded"]["starts"];
    assert_eq!(starts[0], 256);
    // 6 % of a net.
    assert!((13..=18).contains(&starts[1].as_u64().unwrap()), "{starts}");
    let within = &found["excluded"]["within"];
    for (k, limit) in [0.8, 0.7].iter().enumerate() {
        let low = within[k]["range"][0].as_f64().unwrap();
        assert!((*limit..limit + 0.1).contains(&low), "{within}");
    }
    assert_eq!(found["optima"][0]["edge"]["blocked"], false);
    for words in [
        "about 6 % of the space is excluded",
        "ends of the 95 % region of the optimum",
        "count as impossible, though nothing is known",
        "last steps led there: the sample borders",
    ] {
        assert!(said.out.contains(words), "{words}: {}", said.out);
    }
    assert!(!said.out.contains("determine every parameter"), "{}", said.out);
    // x1 = 5 is the answer, and the model has no value above 4.75.
    bench.write("study.toml", &study("gap", 6.0, 5.0));
    let said = bench.run(&["identify", "study.toml", "--output", "out"]);
    let found = json(&bench, "out/identification.json");
    let value = found["free"][0]["value"].as_f64().unwrap();
    assert!((4.6..=4.75).contains(&value), "{value}");
    assert_eq!(found["optima"][0]["edge"]["blocked"], true, "{}", said.out);
    assert!(said.out.contains("so it is no minimum"), "{}", said.out);
}

/// sin(8 x1) + x2 = 1.8 +- 0.02 at x1 = 0.2 +- 0.02: few runs, their error told, and the optimum run.
#[test]
fn a_surrogate_saves_runs_and_states_its_error() {
    let bench = Bench::functions();
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify.free.x1]
min = 0.1
max = 0.5
[identify.free.x2]
min = 0.5
max = 2
[identify.measured.R]
variable = "ripple"
value = 1.8
accuracy = 0.02
[identify.measured.X]
variable = "first"
value = 0.2
accuracy = 0.02
"#;
    bench.write("study.toml", study);
    let command = ["identify", "study.toml", "--budget", "60", "--output", "out"];
    let said = bench.run(&command);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    for words in ["By surrogate from", "its error is largest in", "the optimum run in the model"] {
        assert!(said.out.contains(words), "no `{words}` in {}", said.out);
    }
    let found = json(&bench, "out/identification.json");
    let own = &found["surrogate"];
    assert!(own["runs"].as_u64().unwrap() <= 55 && own["holds"] == true, "{own}");
    let value = |k: usize| found["free"][k]["value"].as_f64().unwrap();
    let interval = |k: usize| [0, 1].map(|end| found["free"][k]["interval"][end].as_f64().unwrap());
    assert!((value(0) - 0.2).abs() < 0.005, "{}", found["free"]);
    let x2 = 1.8 - 1.6_f64.sin();
    let [low, high] = interval(1);
    assert!(low < x2 && x2 < high && high - low < 0.12, "{}", found["free"]);
    assert!(found["posterior"]["free"].is_array() && found["evidence"].is_object());
    bench.run(&["identify", "study.toml", "--budget", "20"]).is_mistake(&["--budget", "20 runs", "give 23 or more"]);
}

/// A wave of a dozen bends that few runs do not show: it says so, and searches with the runs that are left.
#[test]
fn where_no_surrogate_holds_the_model_is_searched_within_the_budget() {
    let bench = Bench::functions();
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify.free.x1]
min = 0.1
max = 30
[identify.measured.R]
variable = "ripple"
value = 0.5
accuracy = 0.001
"#;
    bench.write("study.toml", study);
    let said = bench.run(&["identify", "study.toml", "--budget", "60", "--output", "out"]);
    assert!(said.out.contains("The surrogate does not hold here"), "{}{}", said.out, said.err);
    let found = json(&bench, "out/identification.json");
    assert!(found["posterior"].is_null() && found["surrogate"]["holds"] == false);
}

/// Where the runs next to every start fail, the best place is told, and that it is no minimum.
#[test]
fn an_optimum_amid_failures_is_told() {
    let bench = Bench::functions();
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify.free.x1]
min = 0
max = 1
[identify.measured.S]
variable = "stripes"
value = 0.4
accuracy = 0.1
"#;
    bench.write("study.toml", study);
    let said = bench.run(&["identify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for words in ["no minimum is known", "the interval is that of the prior"] {
        assert!(said.out.contains(words), "no `{words}` in {}", said.out);
    }
    let found = json(&bench, "out/identification.json");
    assert_eq!(found["free"][0]["surrounded"], true);
    assert_eq!(found["optima"][0]["edge"]["blocked"], true);
}
