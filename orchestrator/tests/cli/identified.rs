//! What `identify` tells beyond an optimum: specimens with a common mean and spread, the evidence of two models on the same
//! data, lags of single curves, and its page. The fixture's closed form is y = u (1 - exp(-rate t)).

use std::fmt::Write;

use serde_json::Value;

use crate::support::{Bench, Said};

/// Three specimens with the rates 1, 1.1 and 1.2, each of which is measured at its end.
fn specimens() -> String {
    let mut study = r#"
fmu = "lag.fmu"
[simulation]
stop = 1
step = 0.05
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
varies = "case"
"#
    .to_owned();
    for (name, rate) in [("a", 1.0_f64), ("b", 1.1), ("c", 1.2)] {
        let end = 1.0 - (-rate).exp();
        write!(
            study,
            r#"
[[cases]]
name = "{name}"
fixed = {{ "drive.u" = 1.0 }}
criteria.Y = {{ variable = "lag.y", nominal = {end}, tolerance = 0.1, uncertainty = 0.006 }}
"#
        )
        .unwrap();
    }
    study
}

fn identify(bench: &Bench, study: &str, options: &[&str]) -> (Said, Value) {
    bench.write("study.toml", study);
    let call = ["identify", "study.toml", "--starts", "4", "--isolation", "none", "--output", "out"];
    let said = bench.run(&[&call[..], options].concat());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let outcome = serde_json::from_str(&bench.read("out/identification.json")).unwrap();
    (said, outcome)
}

fn ends(interval: &Value) -> [f64; 2] {
    [0, 1].map(|k| interval[k].as_f64().unwrap())
}

#[test]
fn specimens_have_a_common_mean_and_a_spread() {
    let bench = Bench::new();
    let (said, outcome) = identify(&bench, &specimens(), &["--posterior", "240"]);
    let populations = outcome["posterior"]["populations"].as_array().unwrap();
    assert_eq!(populations.len(), 1);
    let population = &populations[0];
    assert_eq!(population["name"], "lag.rate");
    for (what, truth) in [("mean", 1.1), ("spread", 0.1)] {
        let [low, high] = ends(&population[what]["intervals"][0]);
        assert!(low < truth && truth < high, "{what}: {low} .. {high}");
    }
    for (free, (name, truth)) in
        outcome["free"].as_array().unwrap().iter().zip([("a/lag.rate", 1.0), ("b/lag.rate", 1.1), ("c/lag.rate", 1.2)])
    {
        assert_eq!(free["name"], name);
        let [low, high] = ends(&free["interval"]);
        assert!(low < truth && truth < high && high - low < 0.06, "{free}");
    }
    let table = bench.read("out/posterior.csv");
    assert!(table.contains("c/lag.rate,lag.rate.mean,lag.rate.spread,log_likelihood"), "{table}");
    for words in [
        "lag.rate differs from specimen to specimen",
        "lag.rate, mean of all cases",
        "lag.rate, spread from case to case",
    ] {
        assert!(said.out.contains(words), "no `{words}` in {}", said.out);
    }
    let page = bench.read("out/report.html");
    for words in ["Fit and residuals", "Sample of the posterior", "lag.rate, spread from case to case", "ln evidence"] {
        assert!(page.contains(words), "no `{words}` on the page");
    }
    // No other command knows which specimen is meant.
    bench.run(&["verify", "study.toml", "--output", "v"]).is_mistake(&["varies"]);
    let one = specimens().split("[[cases]]\nname = \"b\"").next().unwrap().to_owned();
    bench.write("one.toml", &one);
    bench.run(&["identify", "one.toml"]).is_mistake(&["shows no spread from case to case"]);
}

#[test]
fn a_wrong_setting_loses_to_the_right_one() {
    let bench = Bench::new();
    let study = specimens().replace("varies = \"case\"\n", "");
    // One rate for all: the specimens' values are those of 1.1.
    let same = 1.0 - (-1.1_f64).exp();
    let study: String = study
        .lines()
        .map(|line| match line.split_once("nominal = ") {
            Some((before, after)) => {
                let rest = after.split_once(',').unwrap().1;
                format!("{before}nominal = {same},{rest}\n")
            }
            None => format!("{line}\n"),
        })
        .collect();
    let right = ["--posterior", "200"];
    let (said, outcome) = identify(&bench, &study, &right);
    assert!(said.out.contains("--against FOLDER"), "{}", said.out);
    let evidence = &outcome["evidence"];
    let [low, high] = ends(&evidence["interval"]);
    assert!(low < high && evidence["data"].is_string(), "{evidence}");
    std::fs::rename(bench.path("out"), bench.path("right")).unwrap();
    // No rate within the bounds explains these values with half of the input in one case.
    let wrong = study.replacen("\"drive.u\" = 1.0", "\"drive.u\" = 0.8", 1);
    let options = ["--posterior", "200", "--against", "right"];
    let (said, outcome) = identify(&bench, &wrong, &options);
    assert!(said.out.contains("the data favour the other one by a factor of"), "{}", said.out);
    let ratio = &outcome["evidence"]["against"];
    assert!(ratio["log"].as_f64().unwrap() < -3.0, "{ratio}");
    assert!(bench.read("out/report.html").contains("favour the other one"));
    // Other measured values cannot be compared, and without a sample there is no evidence.
    bench.write("other.toml", &study.replacen("nominal = 0.", "nominal = 0.1", 1));
    bench
        .run(&[&["identify", "other.toml", "--output", "o"][..], &options[..]].concat())
        .is_mistake(&["other measured values"]);
    bench.run(&["identify", "study.toml", "--against", "right", "--output", "n"]).is_mistake(&["--posterior"]);
}

/// Euler's method with steps h makes (1 - r h)^(1/h) of exp(-r), so it takes 1.1 for (1 - exp(-1.1 h)) / h.
#[test]
fn a_step_that_moves_a_parameter_is_warned_of() {
    let bench = Bench::empty();
    let description = crate::support::model("Lag", "Lag");
    bench.fmu("euler.fmu", &["EULER"], &description);
    bench.fmu("exact.fmu", &[], &description);
    let study = |fmu: &str, step: f64| {
        let exact = 1.0 - (-1.1_f64).exp();
        format!(
            r#"
fmu = "{fmu}"
[simulation]
stop = 1
step = {step}
[fixed]
"drive.u" = 1
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
[criteria.Y]
variable = "lag.y"
nominal = {exact}
tolerance = 0.1
uncertainty = 0.006
"#
        )
    };
    let (said, outcome) = identify(&bench, &study("euler.fmu", 0.25), &[]);
    let error = 1.1 - (1.0 - (-1.1_f64 * 0.25).exp()) / 0.25;
    let moved = &outcome["numerical_error"]["free"][0];
    let higher = moved["higher"].as_f64().unwrap();
    assert!((higher / error - 1.0).abs() < 0.2, "{higher} of {error}");
    let concern = &outcome["concerns"][0];
    assert_eq!(concern["code"], "coarse-step", "{concern}");
    let text = concern["text"].as_str().unwrap();
    let begin = "the communication step of 0.25 s is too coarse: with finer ones lag.rate would be about 0.12 ";
    assert!(text.starts_with(begin), "{text}");
    assert_eq!(concern["remedy"], "Choose a shorter `step` under [simulation], for a system `--step` of `system`.");
    let first =
        format!("warning: {text}. Choose a shorter `step` under [simulation], for a system `--step` of `system`\n");
    assert!(said.out.starts_with(&first), "{}", said.out);
    let page = bench.read("out/report.html");
    assert!(page.contains(&format!("Warning: {begin}")), "{page}");
    assert!(page.contains("class=\"verdict no\""), "{page}");
    for (fmu, step) in [("euler.fmu", 0.001), ("exact.fmu", 0.25)] {
        let (said, outcome) = identify(&bench, &study(fmu, step), &[]);
        assert_eq!(outcome["concerns"], serde_json::json!([]), "{fmu}");
        assert!(!said.out.contains("coarse"), "{fmu}: {}", said.out);
        assert!(outcome["numerical_error"]["free"][0]["part"].as_f64().unwrap() < 0.1);
    }
}

/// A curve that is later than it states, and a sensor whose zero is off: the page has fit, sensors and parameters.
#[test]
fn a_late_curve_and_a_zero_error_are_found_and_shown() {
    let bench = Bench::new();
    let mut table = String::from("time,y\n");
    for k in 4..=36_u32 {
        let time = 0.05 * f64::from(k);
        let noise = 0.003 * (12.9898 * f64::from(k)).sin();
        let y = 1.0 - (-1.1 * (time - 0.05)).exp() + noise;
        writeln!(table, "{time},{y}").unwrap();
    }
    bench.write("y.csv", &table);
    let study = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.01
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
[[cases]]
name = "one"
fixed = { "drive.u" = 1.0 }
[cases.criteria.Y]
variable = "lag.y"
reference = { file = "y.csv", column = "y", uncertainty = 0.02, uncertainty-distribution = "rectangular", noise = 0.003 }
metric = "rmse"
tolerance = 0.1
delay = "20 ms"
lag = { min = "-60 ms", max = "60 ms" }
"#;
    let (said, outcome) = identify(&bench, study, &[]);
    let free = outcome["free"].as_array().unwrap();
    for (free, (name, truth)) in free.iter().zip([("lag.rate", 1.1), ("one/Y/lag", 0.03)]) {
        assert_eq!(free["name"], name);
        let [low, high] = ends(&free["interval"]);
        assert!(low < truth && truth < high, "{name}: {low} .. {high}");
    }
    assert!(said.out.contains("as normal, though they are rectangular"), "{}", said.out);
    let page = bench.read("out/report.html");
    for words in ["Fit and residuals", "What the data say of the sensors"] {
        assert!(page.contains(words), "no `{words}` on the page");
    }
    // The other commands take the delay as stated.
    let said = bench.run(&["verify", "study.toml", "--points", "4", "--output", "v"]);
    assert!(said.code < 2, "{}", said.err);
    // Which of a range of delays it is says `lag`.
    let range = study.replace("\"20 ms\"", "{ from = \"0 ms\", to = \"40 ms\" }");
    bench.write("study.toml", &range);
    bench.run(&["identify", "study.toml"]).is_mistake(&["study.toml:18:9: expected a number"]);
}

/// A product has the noise of its factor: it is no second measurement, whatever it is measured with.
#[test]
fn a_product_tells_no_more_than_its_factor() {
    let bench = Bench::new();
    let end = 1.0 - (-1.1_f64).exp();
    let alone = format!(
        r#"
fmu = "lag.fmu"
[simulation]
stop = 1
step = 0.05
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
[[cases]]
name = "one"
fixed = {{ "drive.u" = 1.0 }}
criteria.Y = {{ variable = "lag.y", nominal = {end}, tolerance = 0.1, uncertainty = 0.002, noise = 0.01 }}
"#
    );
    let product = format!(
        "criteria.P = {{ variable = \"lag.y\", nominal = {end}, tolerance = 0.1, derived = {{ from = \"Y\", by = \"drive.u\" }} }}\n"
    );
    let width = |study: &str| {
        let (_, outcome) = identify(&bench, study, &["--force"]);
        let [low, high] = ends(&outcome["free"][0]["interval"]);
        high - low
    };
    let (one, both) = (width(&alone), width(&format!("{alone}{product}")));
    // As two measurements they would be a factor of 0.71 apart.
    assert!((both / one - 1.0).abs() < 0.01, "{one} {both}");
}

/// A correlation is that of the whole errors, noise as well as offsets: two values of the same quantity with the standard
/// uncertainty u and a correlation of 0.8 leave u sqrt((1 + 0.8) / 2).
#[test]
fn correlated_errors_are_whole_ones() {
    let bench = Bench::functions();
    for error in ["noise = 0.05", "uncertainty = 0.1", "uncertainty = 0.08\nnoise = 0.03"] {
        let of = |name: &str, statistic: &str| {
            format!(
                "[criteria.{name}]\nvariable = \"first\"\nstatistic = \"{statistic}\"\nnominal = 0.5\ntolerance = 0.1\n{error}\n"
            )
        };
        let study = format!(
            "fmu = \"functions.fmu\"\n[parameters.x1]\ndistribution = \"uniform\"\nmin = -5\nmax = 6\n{}{}\
             [[uncertainty-correlations]]\nbetween = [\"A\", \"B\"]\ncoefficient = 0.8\n",
            of("A", "final"),
            of("B", "mean")
        );
        let (_, outcome) = identify(&bench, &study, &[]);
        let deviation = outcome["free"][0]["deviation"].as_f64().unwrap();
        let expected = 0.05 * 0.9_f64.sqrt();
        assert!((deviation / expected - 1.0).abs() < 0.01, "{error}: {deviation}");
    }
}

/// An input of 1 that was recorded 0.05 too high, in the first two of three cases: its zero error is found with the rate. As an exact
/// one it would become one of the rate.
#[test]
fn a_recorded_input_has_a_zero_error() {
    let bench = Bench::new().in_process();
    let rate = 1.1_f64;
    let curve = |input: f64| {
        let rows = (1..=20).map(|k| {
            let time = 0.1 * f64::from(k);
            let noise = 0.002 * (12.9898 * f64::from(k)).sin();
            format!("{time},{}\n", input * (1.0 - (-rate * time).exp()) + noise)
        });
        "time,y\n".to_owned() + &rows.collect::<String>()
    };
    bench.write("u.csv", "time,u\n0,1.05\n1,1.05\n2,1.05\n");
    bench.write("y.csv", &curve(1.0));
    bench.write("other.csv", &curve(0.5));
    let reference = |file: &str| format!("{{ file = \"{file}\", column = \"y\", noise = 0.0015 }}");
    let case = |name: &str, drive: &str, file: &str| {
        format!(
            "[[cases]]\nname = \"{name}\"\n{drive}\ncriteria.Y = {{ variable = \"lag.y\", reference = {}, metric = \"rmse\", tolerance \
             = 0.1 }}\n",
            reference(file)
        )
    };
    let recorded = "inputs.\"drive.u\" = { file = \"u.csv\", column = \"u\", uncertainty = 0.1 }";
    let study = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.05
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 2
"#
    .to_owned()
        + &case("one", recorded, "y.csv")
        + &case("two", recorded, "y.csv")
        + &case("set", "fixed = { \"drive.u\" = 0.5 }", "other.csv");
    let (said, outcome) = identify(&bench, &study, &[]);
    let free = outcome["free"].as_array().unwrap();
    assert_eq!(free.len(), 2, "the two cases have one sensor: {free:?}");
    assert_eq!(free[1]["name"], "drive.u/offset");
    for (free, truth) in free.iter().zip([rate, 0.05]) {
        let [low, high] = ends(&free["interval"]);
        assert!(low < truth && truth < high && high - low < 0.02, "{truth}: {low} .. {high}");
    }
    assert!(!said.out.contains("count as exact"), "{}", said.out);
    // What it promises holds in a verdict that takes the offset off or draws it, and with an exact input does not.
    let optimum: toml::Table = bench.read("out/optimum.toml").parse().unwrap();
    let text = |of: &toml::Value| of.as_str().map_or_else(|| of.to_string(), |text| format!("\"{text}\""));
    let offset = text(&optimum["cases"][1]["inputs"]["drive.u"]["offset"]);
    let best = optimum["parameters"]["lag.rate"]["mean"].as_float().unwrap();
    let at_optimum = study
        .replace("min = 0.5\nmax = 2", &format!("min = {}\nmax = {}", best - 1e-6, best + 1e-6))
        .replace("tolerance = 0.1", "tolerance = 0.01");
    let taken_off = at_optimum.replace("uncertainty = 0.1", &format!("offset = {offset}"));
    let exact = at_optimum.replace(", uncertainty = 0.1", "");
    for (name, study, code) in [("off", &taken_off, 0), ("exact", &exact, 1), ("drawn", &at_optimum, 0)] {
        bench.write("at.toml", study);
        let said = bench.run(&["verify", "at.toml", "--output", name]);
        assert_eq!(said.code, code, "{name}: {}{}", said.out, said.err);
    }
    // The study that is written needs no edit.
    let said = bench.run(&["verify", "out/optimum.toml", "--points", "20", "--output", "as-written"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let of_case = |case: usize| optimum["cases"][case]["inputs"]["drive.u"]["offset"].clone();
    assert_eq!(of_case(0), of_case(1));
    let drawn = bench.summary("drawn");
    let offset = &drawn["best_point"]["parameters"]["drive.u/offset"];
    assert!((offset.as_f64().unwrap() - 0.05).abs() < 0.02, "{offset}");
    // Points of a table have the offset of their column, or none, which is said.
    bench.write("at.toml", &at_optimum);
    bench.write("bare.csv", &format!("lag.rate\n{best}\n"));
    for (table, code, exact) in [("drawn/points.csv", 0, false), ("bare.csv", 1, true)] {
        let said = bench.run(&["verify", "at.toml", "--points-from", table, "--output", "table", "--force"]);
        assert_eq!(said.code, code, "{table}: {}{}", said.out, said.err);
        let summary = bench.summary("table").to_string();
        assert_eq!(summary.contains("input-taken-as-exact"), exact, "{table}");
    }
    let exact = study.replace(", uncertainty = 0.1", "");
    let (said, outcome) = identify(&bench, &exact, &["--force"]);
    assert!(said.out.contains("Recorded inputs without an `uncertainty` count as exact: drive.u"), "{}", said.out);
    let [low, high] = ends(&outcome["free"][0]["interval"]);
    assert!(high < rate || low > rate, "{low} .. {high}");
    let wrong = study.replace("uncertainty = 0.1", "uncertainty = \"2 %\"");
    bench.write("study.toml", &wrong);
    let said = bench.run(&["identify", "study.toml", "--output", "wrong"]);
    assert!(said.err.contains("must be a positive number in the input's unit"), "{}", said.err);
    // Another calibration is another sensor: what is found adds to what each was known to read too high.
    bench.write("second.csv", "time,u\n0,1.25\n2,1.25\n");
    let second = "inputs.\"drive.u\" = { file = \"second.csv\", column = \"u\", offset = 0.2, uncertainty = 0.1 }";
    let cases = [("one", recorded), ("two", second), ("three", second)];
    let two = study.split("[[cases]]").next().unwrap().to_owned()
        + &cases.map(|(name, drive)| case(name, drive, "y.csv")).concat()
        + &case("set", "fixed = { \"drive.u\" = 0.5 }", "other.csv");
    let (_, outcome) = identify(&bench, &two, &["--force"]);
    assert_eq!(outcome["free"].as_array().unwrap().len(), 3, "{outcome}");
    let optimum: toml::Table = bench.read("out/optimum.toml").parse().unwrap();
    for (case, expected) in [0.05, 0.25, 0.25].into_iter().enumerate() {
        let found = optimum["cases"][case]["inputs"]["drive.u"]["offset"].to_string();
        let found: f64 = found.trim_matches('"').parse().unwrap();
        assert!((found - expected).abs() < 0.01, "{case}: {found}");
    }
}

/// A rate beyond its range, or a zero error, each from a curve with noise: the likeliest cause is the planted one, and without a
/// fault there is none.
#[test]
fn a_misfit_names_its_cause() {
    let record = |rate: f64, zero: f64| {
        let mut table = "t,y\n".to_owned();
        for k in 1..=40 {
            let t = 0.05 * f64::from(k);
            let noise = 0.006 * (f64::from(k * k) * 1.234).sin();
            writeln!(table, "{t},{}", 1.0 - (-rate * t).exp() + zero + noise).unwrap();
        }
        table
    };
    let study = r#"
fmu = "lag.fmu"
simulation = { stop = 2, step = 0.05 }
[parameters."lag.rate"]
distribution = "uniform"
min = 0.95
max = 1.05
[criteria.level]
variable = "lag.y"
reference = { file = "run.csv", time = "t", column = "y", uncertainty = 0.01, noise = 0.005 }
metric = "rmse"
tolerance = 0.02
"#;
    let bench = Bench::new();
    for (rate, zero, fault, value, words) in [
        (1.2, 0.0, "range", 1.2, "Likeliest cause: lag.rate is 1.2"),
        (1.0, 0.2, "offset", 0.2, "Likeliest cause: the sensor of level reads 0.19"),
    ] {
        bench.write("run.csv", &record(rate, zero));
        let (said, outcome) = identify(&bench, study, &[]);
        let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains(words), "{text}");
        let first = &outcome["suspects"][0];
        assert_eq!(first["fault"], fault, "{outcome}");
        assert!((first["value"].as_f64().unwrap() - value).abs() < 0.02, "{first}");
    }
    bench.write("run.csv", &record(1.01, 0.003));
    let (said, outcome) = identify(&bench, study, &[]);
    assert!(outcome["suspects"].is_null() && !said.out.contains("cause"), "{}", said.out);

    // Of what moves nothing no value is told.
    let idle = "[parameters.\"lag.length\"]\ndistribution = \"uniform\"\nmin = 1e-5\nmax = 2e-5\n[criteria";
    let (said, _) = identify(&bench, &study.replacen("[criteria", idle, 1), &[]);
    let lines: Vec<&str> = said.out.lines().filter(|line| line.contains("lag.length")).collect();
    assert!(lines[0].contains("the data do not tell") && lines[0].ends_with("100 %"), "{}", said.out);
    assert_eq!(lines[1].trim(), "lag.length: 100 % of the prior's spread is left", "{}", said.out);

    // A verdict of no names the cause, and one page has both. After a thousand points there is time for it at any load.
    bench.write("study.toml", study);
    for (rate, zero, words) in
        [(1.2, 0.0, "Likeliest cause: lag.rate is 1.2"), (1.0, 0.2, "Likeliest cause: the sensor of level reads 0.19")]
    {
        bench.write("run.csv", &record(rate, zero));
        let said = bench.run(&["verify", "study.toml", "--points", "1000", "--output", "no", "--force"]);
        let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.starts_with("\u{2717} Not verified") && text.contains(words), "{text}");
        assert!(bench.summary("no")["causes"][0].as_str().unwrap().contains(words));
        assert!(text.contains("Next `orchestrator identify study.toml --output no` tells the evidence"), "{text}");
        let page = bench.read("no/report.html");
        assert!(page.contains("id=\"identification\"") && page.contains("id=\"verdict\""), "{page}");
        let section = page.split_once("id=\"identification\"").unwrap().1;
        let [verdict, fit] = ["The verdict stays", "The model misses"].map(|words| section.find(words).unwrap());
        assert!(verdict < fit && section.contains("95 %, too narrow"), "{section}");
    }
    // Whoever wants no runs but the points gets none.
    let said = bench.run(&["verify", "study.toml", "--points", "100", "--output", "few", "--extra-runs", "0"]);
    assert!(!said.out.contains("Likeliest") && !bench.path("few/identify").exists(), "{}", said.out);
    // A search for it is told first, too.
    assert_eq!(bench.run(&["identify", "study.toml", "--output", "few"]).code, 0);
    let causes = &bench.summary("few")["causes"];
    assert!(causes[0].as_str().unwrap().starts_with("Likeliest cause: the sensor of level reads 0.19"), "{causes}");
    // A model that is verified has no cause, and one that parameters explain names their values.
    bench.write("run.csv", &record(1.01, 0.003));
    let said = bench.run(&["verify", "study.toml", "--output", "yes"]);
    assert!(said.out.starts_with('\u{2713}') && !bench.path("yes/identify").exists(), "{}", said.out);
    // What was found besides is told in a line.
    assert_eq!(bench.run(&["identify", "study.toml", "--output", "yes"]).code, 0);
    let told = "(The model fits the measured values)";
    let said = bench.run(&["verify", "study.toml", "--output", "yes", "--resume"]);
    let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.contains(&format!("Found as well (report.html): Identification {told}.")), "{text}");
    assert!(bench.read("yes/report.html").contains(&format!("Found as well (below): Identification {told}.")));
}

/// A fit by a parameter far from its distribution, or by a sensor far beyond its sheet, is no fit by the parameters alone: what is
/// strained is the cause. Within what is stated it is none. The study at the optimum is verified as it was written.
#[test]
fn what_a_fit_strains_is_its_cause() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("studies")).unwrap();
    let study = |rate: &str| {
        format!(
            "fmu = \"../lag.fmu\"\nsimulation = {{ stop = 2, step = 0.05 }}\n[parameters.\"lag.rate\"]\n{rate}\n\
             [criteria.level]\nvariable = \"lag.y\"\nmetric = \"rmse\"\ntolerance = 0.0065\n\
             reference = {{ file = \"run.csv\", time = \"t\", column = \"y\", uncertainty = 0.01, noise = 0.005 }}\n"
        )
    };
    let normal = "distribution = \"normal\"\nmean = 1\ndeviation = 0.04";
    let uniform = "distribution = \"uniform\"\nmin = 0.9\nmax = 1.3";
    // The zero error is six standard uncertainties: of these the rate takes a part.
    for (parameter, rate, zero, noise, cause) in [
        (normal, 1.2, 0.0, 0.006, Some(["lag.rate is 1.1", "instead of 0.92 .. 1.08", " standard deviations from 1)"])),
        (uniform, 1.05, 0.03, 0.004, Some(["the sensor of level reads 0.02", "too high (stated: at most 0.01)", ""])),
        (uniform, 1.2, 0.0, 0.006, None),
    ] {
        let row = |k: i32| {
            let t = 0.05 * f64::from(k);
            let noise = noise * (f64::from(k * k) * 1.234).sin();
            format!("{t},{}\n", 1.0 - (-rate * t).exp() + zero + noise)
        };
        bench.write("studies/run.csv", &format!("t,y\n{}", (1..=40).map(row).collect::<String>()));
        bench.write("studies/fit.toml", &study(parameter));
        let said = bench.run(&["verify", "studies/fit.toml", "--points", "40", "--extra-runs", "0", "--force"]);
        assert!(said.code < 2, "{}", said.err);
        let said = bench.run(&["identify", "studies/fit.toml", "--force"]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let text = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(text.contains("The model fits the measured values"), "{text}");
        let outcome: Value = serde_json::from_str(&bench.read("results/fit/identification.json")).unwrap();
        let told = outcome["causes"][0].as_str().unwrap();
        if parameter == normal {
            // Of five standard deviations the prior takes the part that the data leave of its variance.
            let free = &outcome["free"][0];
            let [value, left] = ["value", "left"].map(|key| free[key].as_f64().unwrap());
            let expected = 1.0 + 0.2 * (1.0 - left * left);
            assert!((value - expected).abs() < 0.01, "{value} {expected}");
        }
        match cause {
            Some(words) => {
                assert!(told.starts_with("Likeliest cause: "), "{told}");
                words
                    .iter()
                    .for_each(|words| assert!(told.contains(words) && text.contains(words), "{words}: {told} {text}"));
            }
            None => assert!(
                told.starts_with("The parameters alone would explain it: the model fits at lag.rate = 1.2"),
                "{told}"
            ),
        }
        let verify = "`orchestrator verify results/fit/optimum.toml`";
        assert!(text.contains(verify), "{text}");
        let said = bench.run(&["verify", "results/fit/optimum.toml", "--points", "20", "--output", "at", "--force"]);
        let fits = zero == 0.0;
        assert_eq!(said.code, i32::from(!fits), "{rate} {zero}: {}{}", said.out, said.err);
    }
}

/// An input that was recorded 10 % too high makes the output so much lower: its sensor and that of the output explain it.
#[test]
fn the_sensor_of_an_input_is_a_cause() {
    let bench = Bench::new();
    bench.write("u.csv", "t,u\n0,1.1\n2,1.1\n");
    let row = |k: i32| {
        let t = 0.05 * f64::from(k);
        format!("{t},{}\n", 1.0 - (-t).exp() + 0.002 * (f64::from(k * k) * 1.234).sin())
    };
    bench.write("run.csv", &format!("t,y\n{}", (1..=40).map(row).collect::<String>()));
    let study = r#"
fmu = "lag.fmu"
simulation = { stop = 2, step = 0.05 }
[parameters."lag.rate"]
distribution = "uniform"
min = 0.98
max = 1.02
[inputs."drive.u"]
file = "u.csv"
time = "t"
column = "u"
[criteria.level]
variable = "lag.y"
reference = { file = "run.csv", time = "t", column = "y", uncertainty = 0.002, noise = 0.002 }
metric = "rmse"
tolerance = 0.02
"#;
    let (_, outcome) = identify(&bench, study, &[]);
    let suspects = outcome["suspects"].as_array().unwrap();
    let gain = |name: &str| {
        let its = suspects.iter().find(|suspect| suspect["fault"] == "gain" && suspect["name"] == name);
        its.unwrap_or_else(|| panic!("{name}: {suspects:?}"))["value"].as_f64().unwrap()
    };
    assert!((gain("drive.u") - 0.1).abs() < 0.01 && (gain("level") + 0.1 / 1.1).abs() < 0.01, "{suspects:?}");
}

/// Offset, gain and noise of a recorded input's sensor against the closed form: held for steps of h, u becomes y = (1 - a) sum of
/// a^k u_(n-k) with a = exp(-rate h). A product by the input is formed with what the sensor read.
#[test]
fn the_sensor_of_an_input_has_offset_gain_and_noise() {
    let bench = Bench::new().in_process();
    let rows: String = (0..=20).map(|k| format!("{},2\n", 0.05 * f64::from(k))).collect();
    bench.write("u.csv", &format!("time,u\n{rows}"));
    let (rate, end) = (1.1_f64, 1.0 - (-1.1_f64).exp());
    let study = |errors: &str, of_product: &str| {
        format!(
            "fmu = \"lag.fmu\"\n[simulation]\nstop = 1\nstep = 0.05\n[design]\nmethod = \"monte-carlo\"\npoints = 400\n\
             [parameters.\"lag.rate\"]\ndistribution = \"uniform\"\nmin = 1.0999999\nmax = 1.1000001\n\
             [inputs.\"drive.u\"]\nfile = \"u.csv\"\ncolumn = \"u\"\nhold = true\n{errors}\n\
             [criteria.Y]\nvariable = \"lag.y\"\nnominal = {}\ntolerance = 0.5\nuncertainty = 0.02\n{of_product}",
            2.0 * end
        )
    };
    let errors = "uncertainty = 0.1\ngain-uncertainty = \"4 %\"\nnoise = 0.03\n";
    // For the model product and factor are one variable, so that each is tried on its own.
    let product = "[criteria.P]\nvariable = \"lag.y\"\nnominal = 2.5\ntolerance = 2\nderived = { from = \"Y\", by = \"drive.u\" }\n";
    bench.write("s.toml", &study(errors, product));
    let header = "lag.rate,drive.u/offset,drive.u/gain,drive.u/noise\n";
    let given = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 2.0, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 0.7]];
    let lines = given.map(|[offset, gain, noise]| format!("{rate},{offset},{gain},{noise}\n"));
    bench.write("p.csv", &(header.to_owned() + &lines.concat()));
    let said = bench.run(&["verify", "s.toml", "--points-from", "p.csv", "--output", "table"]);
    assert!(said.code < 2, "{}", said.err);
    let points = |folder: &str, column: &str| -> Vec<f64> {
        let text = bench.read(&format!("{folder}/points.csv"));
        let mut lines =
            text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
        let place = lines.next().unwrap().iter().position(|name| *name == column).unwrap();
        lines.map(|row| row[place].parse().unwrap()).collect()
    };
    let (found, products) = (points("table", "Y"), points("table", "P"));
    for (k, [offset, gain, _]) in given[..4].iter().enumerate() {
        let value = (2.0 - offset) / (1.0 + gain / 100.0) * end;
        assert!((found[k] - value).abs() < 1e-9, "{k}: {} {value}", found[k]);
        let product = (1.0 + gain / 100.0) * value + offset * value;
        assert!((products[k] - product).abs() < 1e-9, "{k}: {} {product}", products[k]);
    }
    assert!((found[4] - found[0]).abs() > 1e-4, "{found:?}");
    let summary = bench.summary("table").to_string();
    assert!(summary.contains("drive.u/noise: the product P"), "{summary}");
    // Drawn, each has the spread of its closed form.
    let one = (-rate * 0.05_f64).exp();
    let of_noise = 0.03 * (1.0 - one) * (0..20).map(|k| one.powi(2 * k)).sum::<f64>().sqrt();
    let cases = [
        ("uncertainty = 0.1", 0.05 * end),
        ("gain-uncertainty = \"4 %\"", 0.02 * 2.0 * end),
        ("noise = 0.03", of_noise),
    ];
    for (k, (error, expected)) in cases.into_iter().enumerate() {
        bench.write("s.toml", &study(error, ""));
        let folder = k.to_string();
        let said = bench.run(&["verify", "s.toml", "--output", &folder]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let values = points(&folder, "Y");
        let mean = values.iter().sum::<f64>() / 400.0;
        let deviation = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / 399.0).sqrt();
        // Four standard errors of a deviation from 400 points.
        assert!((deviation / expected - 1.0).abs() < 0.15, "{error}: {deviation} {expected}");
    }
    // What identify finds of the gain is taken off the recording: it was 4 % too high.
    let fit = study("gain-uncertainty = \"10 %\"", "")
        .replace(&format!("nominal = {}", 2.0 * end), &format!("nominal = {}", 2.0 / 1.04 * end));
    let fit = fit.replace("tolerance = 0.5\nuncertainty = 0.02", "tolerance = 0.01\nuncertainty = 0.002");
    let (_, outcome) = identify(&bench, &fit, &[]);
    let [low, high] = ends(&outcome["free"][1]["interval"]);
    assert!(
        outcome["free"][1]["name"] == "drive.u/gain" && low < 4.0 && 4.0 < high && high - low < 1.0,
        "{low} {high}"
    );
    let optimum: toml::Table = bench.read("out/optimum.toml").parse().unwrap();
    let gain = optimum["inputs"]["drive.u"]["gain"].as_str().unwrap();
    bench.write("s.toml", &fit.replace("gain-uncertainty = \"10 %\"", &format!("gain = \"{gain}\"")));
    let said = bench.run(&["verify", "s.toml", "--output", "at"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}
