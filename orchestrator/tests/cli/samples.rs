//! Parameters that are drawn together from a sample.

use super::support::Bench;

fn json(bench: &Bench, file: &str) -> serde_json::Value {
    serde_json::from_str(&bench.read(file)).unwrap()
}

/// A sample along the diagonal x1 = x2 with two modes: parameters that come from it stay together.
#[test]
fn parameters_from_a_sample_are_drawn_together() {
    let bench = Bench::functions();
    let rows = (0..100).map(|k| {
        let x = if k % 2 == 0 { 0.2 } else { 0.8 } + 0.001 * f64::from(k / 2);
        format!("{},{x},{x}\n", k + 1)
    });
    let rows: String = rows.collect();
    bench.write("sample.csv", &format!("# a in 1, x2 in 1\npoint,a,x2\n{rows}"));
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[design]
method = "sobol"
points = 64
[parameters.x1]
distribution = "sample"
file = "sample.csv"
column = "a"
[parameters.x3]
distribution = "uniform"
min = 0
max = 1
[parameters.x2]
distribution = "sample"
file = "./sample.csv"
[criteria.P]
variable = "product"
nominal = 0.04
tolerance = 0.03
"#;
    bench.write("study.toml", study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let mut table = csv::Reader::from_reader(bench.read("out/points.csv").into_bytes().leak() as &[u8]);
    let mut low = 0;
    for record in table.records() {
        let record = record.unwrap();
        let x: Vec<f64> = (1..4).map(|k| record[k].parse().unwrap()).collect();
        assert_eq!(x[0], x[2], "{record:?}");
        assert!((0.2..0.25).contains(&x[0]) || (0.8..0.85).contains(&x[0]));
        assert!((0.0..1.0).contains(&x[1]));
        low += u32::from(x[0] < 0.5);
    }
    // A net takes just as many rows of each half, and the product of the low ones is within the tolerance.
    assert_eq!(low, 32);
    assert_eq!(bench.summary("out")["verified"], 32);
    let robust = ["robustness", "study.toml", "--from", "out", "--output", "safe"];
    let said = bench.run(&robust);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("x1, x2 are drawn together"), "{}", said.out);
    let result = json(&bench, "safe/robustness.json");
    let margins = result["margins"].as_array().unwrap();
    assert_eq!(margins.len(), 1);
    assert_eq!(margins[0]["parameter"], "x3");
    assert!(result["maps"].as_array().unwrap().is_empty());
    // The rows of one half are verified, and half of the rows stay inside.
    let region = &result["region"];
    assert!((region["share"].as_f64().unwrap() - 0.5).abs() < 0.06, "{region}");
    let one_alone: [&[&str]; 3] = [
        &["sensitivity", "study.toml"],
        &["sensitivity", "study.toml", "--morris", "8"],
        &["verify", "study.toml", "--rare", "verified"],
    ];
    for command in one_alone {
        bench.run(&[command, &["--output", "none"]].concat()).is_mistake(&["study.toml", "x1", "from a sample"]);
    }
    assert!(!bench.path("none").join("points.csv").exists());
    let mistakes = [
        ("column = \"a\"", "column = \"b\"", vec!["wrong.toml:10", "sample.csv", "column"]),
        ("file = \"sample.csv\"\ncolumn", "column", vec!["wrong.toml:8", "`file` is missing"]),
        ("sample.csv\"\n[crit", "none.csv\"\n[crit", vec!["wrong.toml:18", "none.csv"]),
        ("column = \"a\"", "column = \"a\"\nmin = 0", vec!["wrong.toml:8", "does not use `min`"]),
    ];
    for (from, to, words) in mistakes {
        assert!(study.contains(from), "{from}");
        bench.write("wrong.toml", &study.replacen(from, to, 1));
        bench.run(&["verify", "wrong.toml", "--output", "none"]).is_mistake(&words);
    }
    let pair = "[[correlations]]\nbetween = [\"x1\", \"x3\"]\ncoefficient = 0.5\n";
    bench.write("wrong.toml", &format!("{study}{pair}"));
    bench.run(&["verify", "wrong.toml", "--output", "none"]).is_mistake(&["wrong.toml:24", "comes from a sample"]);
    let other = bench.read("sample.csv").replace("a in 1", "a in mm");
    bench.write("sample.csv", &other);
    bench.run(&["verify", "study.toml", "--output", "none"]).is_mistake(&[
        "study.toml:8",
        "has it in mm, the study in 1",
        "unit = \"mm\"",
    ]);
}

/// y = x1 + 2 x2 + 3 x3 with x1 + 2 x2 = 1 in each row of the sample: the share within the tolerance is that of x3 alone.
/// Columns drawn apart would spread y by 1.2 more, and no tolerance of x3 would do.
#[test]
fn tolerances_scale_what_is_no_sample() {
    let bench = Bench::functions();
    let rows = (0..400).map(|k| {
        let x1 = f64::from(k) / 100.0;
        format!("{x1},{}\n", 0.5 * (1.0 - x1))
    });
    bench.write("sample.csv", &format!("x1,x2\n{}", rows.collect::<String>()));
    let study = r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[design]
method = "latin-hypercube"
points = 800
[parameters.x1]
distribution = "sample"
file = "sample.csv"
[parameters.x3]
distribution = "normal"
mean = 0
deviation = 0.5
[parameters.x2]
distribution = "sample"
file = "sample.csv"
[criteria.L]
variable = "linear"
nominal = 1
tolerance = 1.5
[tolerances]
share = "90 %"
"#;
    bench.write("study.toml", study);
    // From rounds of its own, and from the points of the study.
    for verified in [false, true] {
        if verified {
            let said = bench.run(&["verify", "study.toml", "--verbose"]);
            assert_eq!(said.code, 0, "{}", said.err);
            assert!(said.out.contains("repeat the 400 rows"), "{}", said.out);
        }
        let said = bench.run(&["tolerances", "study.toml", "--output", "out"]);
        assert_eq!(said.code, 0, "{} {}", said.out, said.err);
        let found = json(&bench, "out/tolerances.json");
        let parameters = found["parameters"].as_array().unwrap();
        assert_eq!(parameters.len(), 1);
        // 90 % of a normal quantity lie within 1.6449 deviations.
        let scale = parameters[0]["widest_scale"].as_f64().unwrap();
        assert!((scale - 1.0 / 1.6449).abs() < 0.02, "{scale}");
        assert_eq!(found["confirmed"]["decision"], "verified");
    }
    bench.write("wrong.toml", &format!("{study}[tolerances.costs]\nx1 = 2\n"));
    bench.run(&["tolerances", "wrong.toml", "--output", "none"]).is_mistake(&["wrong.toml", "`x1` has a tolerance"]);
    // Half of the rows miss y = 1 +- 0.5 by themselves.
    let rows = (0..400).map(|k| format!("{},{}\n", k % 2, 0));
    bench.write("sample.csv", &format!("x1,x2\n{}", rows.collect::<String>()));
    let narrow = study.replace("tolerance = 1.5", "tolerance = 0.5");
    bench.write("study.toml", &narrow);
    let said = bench.run(&["tolerances", "study.toml", "--output", "out"]);
    assert!(said.out.contains("50 % of 128 points conform as wanted"), "{}", said.out);
}

/// Points that follow the posterior of y = x1 x2 = 1 +- 0.1 on the square from 0.5 to 2: a curved valley. Shares are
/// compared with those of the sample, and with the posterior's by a grid.
#[test]
fn a_posterior_goes_into_a_study() {
    let bench = Bench::functions();
    bench.write(
        "fit.toml",
        r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[identify]
[identify.free.x1]
min = 0.5
max = 2
[identify.free.x2]
min = 0.5
max = 2
[identify.measured.P]
variable = "product"
value = 1
accuracy = 0.1
"#,
    );
    let said = bench.run(&["identify", "fit.toml", "--posterior", "1000", "--output", "fit"]);
    assert_eq!(said.code, 0, "{}", said.err);
    bench.write(
        "study.toml",
        r#"
fmu = "functions.fmu"
[simulation]
stop = 1
[design]
method = "sobol"
points = 1000
[parameters.x1]
distribution = "sample"
file = "fit/posterior.csv"
[parameters.x2]
distribution = "sample"
file = "fit/posterior.csv"
[criteria.P]
variable = "product"
nominal = 1
tolerance = 0.1
[criteria.L]
variable = "linear"
nominal = 4.3
tolerance = 0.5
"#,
    );
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let good = |x1: f64, x2: f64| (x1 * x2 - 1.0).abs() <= 0.1 && (x1 + 2.0 * x2 + 1.5 - 4.3).abs() <= 0.5;
    let text = bench.read("fit/posterior.csv");
    let mut table = csv::ReaderBuilder::new();
    let mut table = table.comment(Some(b'#')).from_reader(text.as_bytes());
    let rows: Vec<[f64; 2]> = table
        .records()
        .map(|row| {
            let row = row.unwrap();
            [row[1].parse().unwrap(), row[2].parse().unwrap()]
        })
        .collect();
    assert_eq!(rows.len(), 1000);
    let of_sample = rows.iter().filter(|[a, b]| good(*a, *b)).count() as f64 / 1000.0;
    let found = bench.summary("out")["verified_fraction"].as_f64().unwrap();
    // The net takes each row about once.
    assert!((found - of_sample).abs() < 0.02, "{found} {of_sample}");
    let (mut inside, mut all) = (0.0, 0.0);
    for i in 0..600 {
        for j in 0..600 {
            let x = [i, j].map(|k| 0.5 + 1.5 * (f64::from(k) + 0.5) / 600.0);
            let density = (-0.5 * ((x[0] * x[1] - 1.0) / 0.1).powi(2)).exp();
            all += density;
            inside += density * f64::from(u8::from(good(x[0], x[1])));
        }
    }
    let exact = inside / all;
    // 1000 draws that the sample is said to be worth less than.
    let worth = json(&bench, "fit/identification.json")["posterior"]["effective_draws"].as_f64();
    let error = (exact * (1.0 - exact) / worth.unwrap_or(200.0)).sqrt();
    assert!((found - exact).abs() < 4.0 * error, "{found} {exact} {error}");
}
