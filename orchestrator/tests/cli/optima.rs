//! `identify` on analytic functions: every optimum, and nothing called determined that is not.

use crate::support::Bench;

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

fn json(bench: &Bench, file: &str) -> serde_json::Value {
    serde_json::from_str(&bench.read(file)).unwrap()
}

#[test]
fn six_exact_solutions_are_six_optima() {
    let bench = Bench::functions();
    bench.write("study.toml", STUDY);
    let said = bench.run(&["identify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for words in [
        "6 distinct sets of parameters fit",
        "optimum 6: ",
        "none of them is \"the\" value",
    ] {
        assert!(said.out.contains(words), "{}", said.out);
    }
    assert!(
        !said.out.contains("determine every parameter"),
        "{}",
        said.out
    );
    let found = json(&bench, "out/identification.json");
    assert_eq!(found["ambiguous"], true);
    let optima = found["optima"].as_array().unwrap();
    let mut places: Vec<f64> = optima
        .iter()
        .map(|own| own["free"][0]["value"].as_f64().unwrap())
        .collect();
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
    let said = bench.run(&["identify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("The data determine every parameter."),
        "{}",
        said.out
    );
    assert!(bench.path("out/optimum.toml").exists());
    assert!(!bench.path("out/optimum-1.toml").exists());
    assert!(!bench.path("out/optimum-6.toml").exists());
}

#[test]
fn a_product_is_one_valley_and_not_determined() {
    let bench = Bench::functions();
    let study = STUDY.replace("\"wave\"", "\"product\"").replace(
        "[identify.measured",
        "[identify.free.x2]\nmin = 0.1\nmax = 3.1\n[identify.measured",
    );
    bench.write("study.toml", &study);
    let said = bench.run(&["identify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(
        said.out.contains("The data do not determine:"),
        "{}",
        said.out
    );
    let found = json(&bench, "out/identification.json");
    assert_eq!(found["optima"].as_array().unwrap().len(), 1);
}
