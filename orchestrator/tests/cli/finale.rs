//! The end of `verify`, when the points are done: it is in proportion to them, and what fails costs itself alone.

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
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.1
"#;

/// Ten thousand steps for a picture would take minutes, where the points took two seconds.
#[test]
fn runs_after_the_study_take_no_longer_than_its_points_did() {
    // The time ends before the study's stop, or between that and the later end of the runs.
    for nap in ["NAP=20000", "NAP=500"] {
        let bench = Bench::empty();
        bench.fmu("lag.fmu", &[nap], &model("", ""));
        bench.write("study.toml", STUDY);
        let said = bench.run(&["verify", "study.toml", "--output", "out", "--verbose"]);
        assert_eq!(said.code, 0, "{}", said.err);
        let summary = bench.summary("out");
        if nap == "NAP=20000" {
            // The study's own steps, of which the FMU makes as many in the time of a point.
            assert_eq!(bench.read("out/best-point.csv").lines().count(), 1 + 6);
            let told = "best-point.csv holds the study's own steps: with finer ones it would take longer";
            assert!(said.out.contains(told), "{}", said.out);
        }
        assert_eq!(summary["rest"]["until"], serde_json::Value::Null, "{nap}");
        let left_out = summary["left_out"].as_str().unwrap();
        assert!(left_out.contains("the best point was not re-run longer and finer"), "{left_out}");
        assert!(said.out.contains(left_out), "{}", said.out);
        let page = bench.read("out/report.html").replace("&#39;", "'");
        assert!(page.contains(left_out));
    }
}

/// Values of a diverged run have squares beyond all numbers, or are the largest numbers themselves.
#[test]
fn whatever_a_point_gives_the_files_are_written() {
    let bench = Bench::new().in_process();
    let study = STUDY
        .replace("lag.rate", "lag.length")
        .replace("lag.y", "lag.micrometres")
        .replace("0.86", "1.5e6")
        .replace("tolerance = 0.1", "tolerance = 1e5\nuncertainty = 1e4");
    let rms = "[criteria.R]\nvariable = \"lag.micrometres\"\nstatistic = \"rms\"\nnominal = 1.5e6\ntolerance = 1e5\n";
    for (length, largest) in [("1e154", "1e160"), ("1.7e302", "1.7000000000000001e308"), ("5e-324", "1450000")] {
        for study in [study.clone(), format!("{study}{rms}")] {
            bench.write("study.toml", &study);
            bench.write("table.csv", &format!("lag.length\n1.5\n1.45\n{length}\n1.4\n1.3\n"));
            let _ = std::fs::remove_dir_all(bench.path("out"));
            let from = ["verify", "study.toml", "--points-from", "table.csv", "--output", "out"];
            let said = bench.run(&from);
            assert_eq!(said.code, 0, "{length}: {}{}", said.out, said.err);
            let summary = bench.summary("out");
            assert_eq!((&summary["points"], &summary["failed"]), (&5.into(), &0.into()), "{length}");
            assert!(bench.read("out/points.csv").contains(largest), "{length}");
            assert_eq!(bench.run(&["report", "out"]).code, 0);
            let again = bench.run(&[&from[..], &["--resume"]].concat());
            assert_eq!(again.code, 0, "{length}: {}{}", again.out, again.err);
            let page = bench.read("out/report.html");
            assert!(!page.contains("NaN,") && !page.contains("inf,"), "{length}");
            let spread = summary["validation"]["Y"]["u_input"].as_f64();
            assert!(spread.is_none_or(|spread| spread > 1e4), "{length}: {spread:?}");
        }
    }
}

/// Names in Modelica may have hundreds of characters, most systems take 255 bytes for the name of a file.
#[test]
fn long_names_cost_no_page() {
    let bench = Bench::new().in_process();
    let name = "component.".repeat(25);
    let other = format!("[criteria.\"{name}z\"]\nvariable = \"lag.temperature\"\nnominal = 280\ntolerance = 9\n");
    let study = STUDY.replace("[criteria.Y]", &format!("[criteria.\"{name}y\"]")) + &other;
    bench.write("study.toml", &study);
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for command in [
        "report out",
        "robustness study.toml --from out --output out",
        "sensitivity study.toml --morris 10 --output out --force",
    ] {
        let arguments: Vec<&str> = command.split(' ').collect();
        let said = bench.run(&arguments);
        assert_eq!(said.code, 0, "{command}: {}", said.err);
        assert!(bench.read("out/report.html").contains(&name), "{command}");
    }
    let plots: Vec<_> = std::fs::read_dir(bench.path("out/plots")).unwrap().collect();
    assert!(plots.len() >= 4, "{plots:?}");
}

/// A plot, a picture of the page or a page that cannot be written costs itself: the verdict stands.
#[test]
fn a_page_that_cannot_be_written_costs_no_verdict() {
    let bench = Bench::new().in_process();
    bench.write("study.toml", STUDY);
    std::fs::create_dir_all(bench.path("out/report.html/in-the-way")).unwrap();
    std::fs::create_dir_all(bench.path("out/best-point.csv/in-the-way")).unwrap();
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.err.contains("note: there is no page: "), "{}", said.err);
    assert_eq!(bench.summary("out")["verdict"], "verified");
    assert!(said.out.contains("results in out"), "{}", said.out);
}

/// Pictures that a page cannot show are left out, and said.
#[test]
fn of_many_criteria_some_have_pictures() {
    let bench = Bench::new().in_process();
    let criterion = |k: i32| {
        let nominal = 0.86 + 0.001 * f64::from(k);
        format!("[criteria.Y{k}]\nvariable = \"lag.y\"\nnominal = {nominal}\ntolerance = 0.1\nuncertainty = 0.01\n")
    };
    let head = &STUDY[..STUDY.find("[criteria.Y]").unwrap()];
    let study: String = (0..120).map(criterion).collect();
    bench.write("study.toml", &format!("{head}{study}"));
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}", said.err);
    let head = bench.read("out/best-point.csv").lines().next().unwrap().to_owned();
    assert_eq!(head.split(',').count(), 61, "{head}");
    let page = bench.read("out/report.html");
    assert!(page.contains("the 60 criteria that the fewest points meet, of 120"));
    // Each of them is counted.
    assert!(page.contains("Y0<") && page.contains("Y119<"));
    let plots = std::fs::read_dir(bench.path("out/plots")).unwrap().count();
    assert!(plots < 150, "{plots}");
}
