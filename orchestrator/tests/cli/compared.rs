//! `compare`: two results of a study, point by point.

use crate::gate::tests;
use crate::support::{Bench, Said};
use serde_json::{Value, json};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.4
[fixed]
"drive.u" = 1
[design]
points = 200
seed = 7
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 1.5
[parameters."lag.length"]
distribution = "uniform"
min = 1e-5
max = 3e-5
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.05
"#;

/// A folder with the results of the study in `old`.
fn bench() -> Bench {
    let bench = Bench::new().in_process();
    verified(&bench, "old", STUDY, &[]);
    bench
}

fn verified(bench: &Bench, folder: &str, study: &str, more: &[&str]) {
    let file = format!("{folder}.toml");
    bench.write(&file, study);
    let usual = ["verify", &file, "--output", folder, "--extra-runs", "0", "--force"];
    let said = bench.run(&[&usual[..], more].concat());
    assert!(said.code < 2, "{}", said.err);
}

fn compared(bench: &Bench, new: &str, more: &[&str]) -> (Said, Value) {
    let said = bench.run(&[&["compare", "old", new, "--output", "changes"], more].concat());
    let file = bench.read("changes/compare.json");
    (said, serde_json::from_str(&file).unwrap())
}

#[test]
fn the_same_study_gives_no_difference_however_it_is_run() {
    let bench = bench();
    for more in [&["--isolation", "fresh", "--jobs", "3"][..], &["--isolation", "none", "--jobs", "1"]] {
        verified(&bench, "new", STUDY, more);
        let (said, file) = compared(&bench, "new", &["--strict"]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        assert!(said.out.starts_with("No difference\n"), "{}", said.out);
        assert_eq!((&file["same"], &file["pairs"]), (&json!(true), &json!(200)));
        assert_eq!(file["criteria"]["Y"]["changed"], 0);
        assert!(bench.read("changes/compare.html").contains("No difference"));
    }
    // What `judge` has read has no parameters.
    let judged = ["judge", "old.toml", "old/points.csv", "--output", "judged"];
    assert_eq!(bench.run(&judged).code, 0);
    let (said, file) = compared(&bench, "judged", &[]);
    assert_eq!((said.code, &file["pairs"]), (0, &json!(200)), "{}", said.out);
}

#[test]
fn changed_values_are_told_and_a_point_that_flips_is_a_difference() {
    let bench = bench();
    // The output is proportional to the input: 0.01 % of it, of a tolerance of 0.05.
    verified(&bench, "new", &STUDY.replace("\"drive.u\" = 1", "\"drive.u\" = 1.0001"), &[]);
    let (said, file) = compared(&bench, "new", &["--junit", "junit.xml"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let change = &file["criteria"]["Y"];
    assert_eq!((&change["changed"], &change["beyond"]), (&json!(200), &json!(200)));
    let largest = &change["largest"];
    let number = |value: &Value| value.as_f64().unwrap();
    let share = 1e-4 * number(&largest["old"]) / 0.05;
    assert!((number(&largest["of_tolerance"]) - share).abs() < 1e-6 * share);
    // The larger the rate, the larger the output, and with it the change; the length plays no part.
    let place = change["place"].as_str().unwrap();
    let low = place.strip_prefix("lag.rate is above ").and_then(|rest| rest.split(' ').next()).unwrap();
    assert!(low.parse::<f64>().unwrap() > 1.35, "{place}");
    let page = bench.read("changes/compare.html");
    assert!(page.contains(&format!("Y changed most, or changed sides, where {place}.")), "{page}");
    let skipped = |all: &[crate::gate::Test]| all[2].2.as_deref().unwrap().split(':').next().unwrap().to_owned();
    let all = tests(&bench, "junit.xml");
    assert_eq!((&*all[2].1, &*skipped(&all)), ("Y", "skipped"));
    let (said, _) = compared(&bench, "new", &["--junit", "junit.xml", "--strict"]);
    assert_eq!((said.code, &*skipped(&tests(&bench, "junit.xml"))), (1, "failure"));

    verified(&bench, "new", &STUDY.replace("\"drive.u\" = 1", "\"drive.u\" = 1.02"), &[]);
    let (said, file) = compared(&bench, "new", &["--junit", "junit.xml"]);
    assert_eq!(said.code, 1, "{}", said.out);
    let flipped = file["flipped"]["count"].as_u64().unwrap();
    assert!(flipped > 5 && file["criteria"]["Y"]["flipped"]["count"] == flipped, "{file}");
    let all = tests(&bench, "junit.xml");
    assert!(all[1].2.as_deref().unwrap().starts_with("failure: "), "{all:?}");
    assert!(all[2].2.as_deref().unwrap().contains("changed sides"), "{all:?}");
    // With an uncertainty of both runs that explains it, nothing has happened.
    for folder in ["old", "new"] {
        let mut summary = bench.summary(folder);
        summary["validation"]["Y"]["u_num"] = json!(0.02 / 2.0_f64.sqrt());
        bench.write(&format!("{folder}/summary.json"), &summary.to_string());
    }
    let (said, file) = compared(&bench, "new", &["--strict"]);
    assert_eq!(said.code, 0, "{}", said.out);
    let change = &file["criteria"]["Y"];
    assert_eq!((&change["changed"], &change["beyond"]), (&json!(200), &json!(0)));
    assert_eq!(change["flipped_within"]["count"], flipped);
    assert!((number(&change["numerical_uncertainty"]) - 0.04).abs() < 1e-12);
    assert!(said.out.starts_with("No difference beyond the numerical uncertainty"), "{}", said.out);
    // A coarser solution does not excuse itself.
    let mut summary = bench.summary("new");
    for (now, words) in [(json!(0.05), "was 0.01414 and is 0.05"), (Value::Null, "and is not stated")] {
        summary["validation"]["Y"]["u_num"] = now;
        bench.write("new/summary.json", &summary.to_string());
        let (said, _) = compared(&bench, "new", &["--strict", "--junit", "junit.xml"]);
        assert_eq!(said.code, 1, "{}", said.out);
        assert!(said.out.contains(words), "{}", said.out);
        let of_settings = tests(&bench, "junit.xml").into_iter().find(|test| test.1 == "settings");
        assert!(of_settings.unwrap().2.unwrap().starts_with("failure: "));
    }
}

#[test]
fn points_and_criteria_without_a_partner_are_differences() {
    let bench = bench();
    let cases = [
        ("points = 200", "points = 190", "10 points only in the old result: 191, 192"),
        ("seed = 7", "seed = 8", "200 points with other parameters: 1, 2"),
        ("max = 3e-5", "max = 3.1e-5", "200 points with other parameters"),
        ("[criteria.Y]", "[criteria.Z]", "The criterion Y is only in the old result"),
        (
            "variable = \"lag.y\"",
            "variable = \"lag.y\"\nstatistic = \"max\"",
            "was the final value of lag.y and is the greatest of lag.y",
        ),
        ("nominal = 0.86", "nominal = 8.6", "The verdict was `verified` and is `not verified`"),
    ];
    for (from, to, words) in cases {
        assert!(STUDY.contains(from));
        verified(&bench, "new", &STUDY.replacen(from, to, 1), &[]);
        let (said, file) = compared(&bench, "new", &[]);
        assert_eq!(said.code, 1, "{to}: {}", said.out);
        assert!(said.out.contains(words), "{to}: no `{words}` in {}", said.out);
        assert_eq!(file["same"], false);
    }
    // Another tolerance is told; where no point changes sides, nothing differs.
    verified(&bench, "new", &STUDY.replace("tolerance = 0.05", "tolerance = 0.0500001"), &[]);
    let (said, _) = compared(&bench, "new", &[]);
    assert_eq!(said.code, 0, "{}", said.out);
    let words = "warning: The criterion Y was `0.86 +-0.05` and is `0.86 +-0.0500001`";
    assert!(said.out.contains(words), "{}", said.out);
}

#[test]
fn points_that_lose_their_result_are_differences() {
    let bench = bench();
    let table = bench.read("old/points.csv");
    let lines: Vec<String> = table
        .lines()
        .map(|line| match line.strip_prefix("17,") {
            Some(_) => {
                let cells: Vec<&str> = line.split(',').collect();
                format!("17,{},{},,false,false,the simulation failed", cells[1], cells[2])
            }
            None => line.to_owned(),
        })
        .collect();
    std::fs::create_dir(bench.path("new")).unwrap();
    bench.write("new/summary.json", &bench.read("old/summary.json"));
    bench.write("new/points.csv", &(lines.join("\n") + "\n"));
    let (said, file) = compared(&bench, "new", &[]);
    assert_eq!(said.code, 1, "{}", said.out);
    assert!(said.out.contains("1 point without a result that had one: 17"), "{}", said.out);
    assert_eq!(file["lost"], json!({"count": 1, "first": [17]}));
    bench.run(&["compare", "old", "none"]).is_mistake(&["none holds no study"]);
}

/// The old result as the new one, with another table and another summary.
fn forged(bench: &Bench, table: &dyn Fn(String) -> String, summary: &dyn Fn(&mut Value)) -> Said {
    std::fs::create_dir_all(bench.path("new")).unwrap();
    let mut document = bench.summary("old");
    summary(&mut document);
    bench.write("new/summary.json", &document.to_string());
    bench.write("new/points.csv", &table(bench.read("old/points.csv")));
    bench.run(&["compare", "old", "new"])
}

#[test]
fn another_answer_at_the_same_values_is_a_difference() {
    // About a quarter of the points meet it.
    let bench = Bench::new().in_process();
    let narrow = STUDY.replace("tolerance = 0.05", "tolerance = 0.02");
    verified(&bench, "old", &narrow, &[]);
    let before = bench.summary("old");
    let count = before["verified"].as_u64().unwrap();
    assert!(0 < count && count < 200);
    let same = |text: String| text;
    let said = forged(&bench, &same, &|_| ());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let said = forged(&bench, &same, &|s| s["accepted"] = json!(199));
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.starts_with("The results differ\n"), "{}", said.out);
    assert!(said.out.contains("points were accepted and 199 are"), "{}", said.out);
    let all = |text: String| text.replace(",false", ",true");
    let said = forged(&bench, &all, &|s| {
        s["verified"] = json!(200);
        s["criteria"]["Y"]["passed"] = json!(200);
    });
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let words = format!("{} points on the other side of the tolerances", 200 - count);
    assert!(said.out.contains(&words), "{words}: {}", said.out);
}

#[test]
fn flags_are_read_as_other_programs_write_them_and_nothing_else() {
    let bench = bench();
    let python = |text: String| text.replace(",true", ",True").replace(",false", ",False");
    let said = forged(&bench, &python, &|_| ());
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.starts_with("No difference\n"), "{}", said.out);
    let numbers = |text: String| text.replacen(",true,true", ",true,1", 1);
    let said = forged(&bench, &numbers, &|_| ());
    said.is_mistake(&["line ", "column `verified`: `1` is neither true nor false"]);
}
