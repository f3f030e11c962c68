//! `init`: what it writes runs at once, and says that nothing is measured yet.

use crate::support::{Bench, Said, THREE, model};

fn good(said: Said) -> Said {
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    said
}

/// `study.toml` of `lag.fmu` with a description.
fn started(description: &str, options: &[&str]) -> (Bench, String) {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &[], description);
    good(bench.run(&[&["init", "lag.fmu", "--output", "study.toml"], options].concat()));
    let study = bench.read("study.toml");
    (bench, study)
}

#[test]
fn a_starting_study_runs_at_once_and_verifies_nothing() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("studies")).unwrap();
    let arguments = ["init", "lag.fmu", "--output", "studies/new.toml"];
    let said = good(bench.run(&arguments));
    assert!(said.out.contains("no measured value yet"), "{}", said.out);
    bench.run(&arguments).is_mistake(&["exists already"]);
    let study = bench.read("studies/new.toml");
    assert!(study.lines().count() <= 60, "{study}");
    for lines in [
        "fmu = \"../lag.fmu\"\n",
        "stop = 2 # s\nstep = 0.01 # s\n",
        "\"lag.rate\" = { distribution = \"uniform\", min = 0.9, max = 1.1, unit = \"1/s\" }\n",
        "\"lag.length\" = { distribution = \"uniform\", min = 0.018, max = 0.022, unit = \"mm\" }\n",
        "statistic = \"final\"\nnominal = 0.864",
        "\nnominal-from = \"model\"",
    ] {
        assert!(study.contains(lines), "no {lines} in {study}");
    }
    // It has the same value at all times, and others are no numbers that could vary.
    for name in ["micrometres", "count", "fault", "flag", "text", "resources"] {
        assert!(!study.contains(&format!("\"lag.{name}\"")), "{study}");
    }

    let said = bench.run(&["verify", "studies/new.toml", "--output", "out"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.starts_with("? No measured value yet\n"), "{}", said.out);
    assert!(!said.out.contains("erified"), "{}", said.out);
    let summary = bench.summary("out");
    assert_eq!(summary["verdict"], "not verified");
    let words = summary["verdict_words"].as_str().unwrap();
    assert!(words.starts_with("no measured value yet: "), "{words}");
    assert!(summary["verified"].as_u64() > Some(0));
    let concern = &summary["concerns"][0];
    assert_eq!(concern["code"], "nominal-from-model");
    assert_eq!(concern["severity"], "warning");
    assert_eq!(summary["validation"], serde_json::json!({}));
    let page = bench.read("out/report.html");
    let verdict = page.split("<section").nth(1).unwrap();
    assert!(verdict.contains("<h2 id=\"verdict-title\">No measured value yet</h2>"), "{verdict}");
    assert!(!verdict.contains("erified:") && !page.contains("Select verified"));
}

#[test]
fn measured_values_in_place_of_the_models_verify_it() {
    let (bench, study) = started(&model("Lag", "Lag"), &[]);
    let lines = study.lines().filter(|line| !line.starts_with("nominal-from"));
    let measured: Vec<&str> = lines.collect();
    bench.write("measured.toml", &measured.join("\n"));
    let said = good(bench.run(&["verify", "measured.toml", "--output", "out"]));
    assert!(said.out.contains(" The model can be right: it meets "), "{}", said.out);
    let concerns = bench.summary("out")["concerns"].to_string();
    assert!(!concerns.contains("nominal-from-model"), "{concerns}");
    // One that is left is enough.
    let half = study.replacen("nominal-from =", "# nominal-from =", 1);
    assert_ne!(half, study);
    bench.write("half.toml", &half);
    let said = bench.run(&["verify", "half.toml", "--output", "half"]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.out.contains("No measured value yet"), "{}", said.out);
}

#[test]
fn a_starting_study_keeps_to_the_limits_of_the_fmu() {
    let near = model(
        "min=\"0\" start=\"1\" && min=\"0\" start=\"2e-5\"",
        "min=\"0.95\" max=\"1.2\" start=\"1\" && start=\"0\"",
    );
    let (bench, study) = started(&near, &[]);
    let rate = "\"lag.rate\" = { distribution = \"uniform\", min = 0.95, max = 1.1, unit = \"1/s\" }";
    assert!(study.contains(rate), "{study}");
    // What starts at 0 stays there.
    assert!(!study.contains("lag.length"), "{study}");
    assert_eq!(bench.run(&["verify", "study.toml", "--dry-run"]).code, 0);
}

#[test]
fn a_starting_study_of_a_strange_fmu_is_a_study() {
    for limits in [
        "min=\"0\" max=\"0\" start=\"0\"",
        "max=\"1\" start=\"5\"",
        "start=\"INF\"",
        "min=\"-1.797e308\" max=\"1.797e308\" start=\"1e308\"",
    ] {
        let text = model("min=\"0\" start=\"2e-5\"", limits);
        // A line break would turn the rest of a comment into a part of the study.
        let text = text.replace("name=\"lag.y\"", "name=\"lag.y\" description=\"first&#10;second=3 &quot;\"");
        let bench = Bench::empty();
        bench.fmu("lag.fmu", &[], &text);
        good(bench.run(&["init", "lag.fmu", "--output", "study.toml"]));
        let study = bench.read("study.toml");
        assert!(!study.contains("\nsecond"), "{study}");
        let said = bench.run(&["verify", "study.toml", "--points", "4", "--dry-run"]);
        assert_eq!(said.code, 0, "{}\n{study}", said.err);
    }
}

#[test]
fn what_cannot_vary_is_no_study() {
    let bench = Bench::empty();
    let text = model(
        "min=\"0\" start=\"1\" && min=\"0\" start=\"2e-5\" && <Real start=\"1\"/>",
        "start=\"0\" && start=\"0\" && <Real start=\"0\"/>",
    );
    bench.fmu("lag.fmu", &[], &text);
    bench.run(&["init", "lag.fmu"]).is_mistake(&["lag.fmu", "start value other than 0", "--set NAME=VALUE"]);
    let set = ["init", "lag.fmu", "--set", "drive.u=2", "--set", "lag.rate=1", "--output", "study.toml"];
    good(bench.run(&set));
    let study = bench.read("study.toml");
    assert!(study.contains("\"drive.u\" = { distribution = \"uniform\", min = 1.8, max = 2.2"), "{study}");
    good(bench.run(&["verify", "study.toml", "--points", "4", "--dry-run"]));
}

#[test]
fn what_the_user_sets_is_fixed() {
    let bench = Bench::new();
    let study = good(bench.run(&["init", "lag.fmu", "--set", "drive.u=2"])).out;
    assert!(study.contains("[fixed]\n\"drive.u\" = \"2\"\n") && study.contains("nominal = 1.72"), "{study}");
    bench.run(&["init", "lag.fmu", "--set", "drive.uu=2"]).is_mistake(&["--set", "did you mean `drive.u`?"]);
}

const MEASURED: &str = "time,lag.y,lag.temperature [degC],drive.u,lag.yy,lag.text,lag.micrometres\n\
                        0,0,20,1,0,0,20\n1,0.632,20.6,1,0,0,20\n1.5,0.777,20.8,1,0,0,20\n";

/// FMI 3.0 and the Reference FMUs have the time as a variable: a column of its name is that of the times.
#[test]
fn the_fmus_own_time_is_the_time_of_a_recording() {
    let bench = Bench::empty();
    bench.three("three.fmu", &[], THREE);
    bench.write("data.csv", "time [s],y\n0,1\n0.5,2\n1,4\n");
    good(bench.run(&["init", "three.fmu", "--measured", "data.csv", "--output", "study.toml"]));
    let study = bench.read("study.toml");
    assert!(study.contains("reference = { file = \"data.csv\", time = \"time [s]\", column = \"y\" }"), "{study}");
}

#[test]
fn measured_columns_become_curves() {
    let bench = Bench::new();
    bench.write("data.csv", MEASURED);
    let said = good(bench.run(&["init", "lag.fmu", "--measured", "data.csv", "--output", "study.toml"]));
    for words in [
        "`lag.yy`: the FMU has no such variable; did you mean `lag.y`?",
        "`lag.text`: it is no output",
        "`lag.micrometres`: it is the same in all rows",
        "data.csv: `time` is the time; inputs over time: `drive.u`; curves: `lag.y`, `lag.temperature [degC]`",
    ] {
        assert!(said.err.contains(words), "no {words} in {}", said.err);
    }
    let study = bench.read("study.toml");
    for lines in [
        "\nstop = 1.5 # s\n",
        "reference = { file = \"data.csv\", time = \"time\", column = \"lag.y\" }\n",
        "reference = { file = \"data.csv\", time = \"time\", column = \"lag.temperature [degC]\", unit = \"degC\" }\n",
    ] {
        assert!(study.contains(lines), "no {lines} in {study}");
    }
    assert!(!study.contains("nominal"), "{study}");
    // What drove the rig drives the model, and varies no more.
    let driven = "[inputs]\n\"drive.u\" = { file = \"data.csv\", time = \"time\", column = \"drive.u\"";
    assert!(study.contains(driven) && study.matches("drive.u").count() == 2, "{study}");
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(said.code < 2, "{}{}", said.out, said.err);
    assert!(!said.out.contains("No measured value yet"), "{}", said.out);
}

#[test]
fn rows_without_a_time_are_repeats() {
    let bench = Bench::new();
    bench.write("data.csv", "lag.y\n0.86\n0.87\n0.865\n");
    let measured = ["init", "lag.fmu", "--measured", "data.csv"];
    let said = good(bench.run(&measured));
    assert!(said.err.contains("3 rows count as repeats of one measurement: `lag.y`"), "{}", said.err);
    let study = said.out;
    let lines = "nominal = 0.865\nnoise = 0.005 # the standard deviation of one row\nrepeats = 3\n";
    assert!(study.contains(lines), "{study}");
    bench.write("study.toml", &study);
    good(bench.run(&["verify", "study.toml"]));
    bench.write("data.csv", "lag.yy,drive.u\n1,2\n");
    bench.run(&measured).is_mistake(&["no column is an output", "lag.yy: the FMU"]);
    bench.write("data.csv", "drive.u;lag.y\n1;0,632\n2;1,264\n");
    let said = good(bench.run(&measured));
    let told = "each of 2 rows became a case, an operating point: inputs `drive.u`, final values `lag.y`";
    assert!(said.err.contains(told), "{}", said.err);
    let study = said.out;
    let point = "name = \"row 2\"\nfixed.\"drive.u\" = \"2\"\ncriteria.\"lag.y\" = { variable = \"lag.y\", nominal = 1.264, tolerance = \"5 %\" }\n";
    assert!(study.contains(point), "{study}");
    bench.write("study.toml", &study);
    let said = bench.run(&["verify", "study.toml", "--output", "points"]);
    assert!(said.code < 2, "{}{}", said.out, said.err);
    bench.write("data.csv", "time,lag.y\n0,1\n0,2\n");
    bench.run(&measured).is_mistake(&["no column is the time: `time` does not rise"]);
    bench.write("data.csv", "time [ms],lag.y\n0,1\n1500,2\n");
    assert!(good(bench.run(&measured)).out.contains("stop = 1.5 # s"));
    bench.write("data.csv", "time,lag.temperature,lag.y\n0,20,1\n1,21,2\n");
    bench
        .run(&measured)
        .is_mistake(&["`lag.temperature` has no unit, and the FMU has it in K", "`lag.temperature [unit]`"]);
    bench.write("data.csv", "time,lag.temperature [degC],lag.y\n0,20,1\n1,NaN,2\n");
    let said = good(bench.run(&measured));
    assert!(said.err.contains("`lag.temperature [degC]`: its value in row 2 is not a finite number"), "{}", said.err);
    bench.write("data.csv", "time [bar],lag.y\n0,1\n1,2\n");
    bench.run(&measured).is_mistake(&["none has a unit of time"]);
    // An input is never left out: the FMU would run with its start value.
    bench.write("data.csv", "time,drive.u [furlong],lag.y\n0,1,1\n1,1,2\n");
    bench.run(&measured).is_mistake(&["column `drive.u [furlong]`: unit `furlong`"]);
    bench.write("data.csv", "time;lag.y\ns;-\n0;1\n1;2\n");
    bench.run(&measured).is_mistake(&["line 2 below the names has no number", "python -m fmu_orchestrator convert"]);
}

/// 09:15 is neither 915 s nor a day of 20,260,311 s, and of two columns that may be the time nobody knows which it is, whoever reads
/// the table.
#[test]
fn doubtful_times_are_asked_about() {
    let bench = Bench::new();
    let clock: &[&str] =
        &["`time`", "a clock such as 131507", "write `time [ms]`", "python -m fmu_orchestrator convert"];
    let begin = "fmu = \"lag.fmu\"\n[simulation]\nstop = 2\n[design]\npoints = 8\n[parameters.\"lag.rate\"]\n\
                 distribution = \"uniform\"\nmin = 1\nmax = 2\n";
    let criterion = "[criteria.Y]\nvariable = \"lag.y\"\ntolerance = 1\n";
    let recorded = [
        ("inputs.toml", "nominal = 1\n[inputs.\"drive.u\"]\nfile = \"m.csv\"\n"),
        ("reference.toml", "metric = \"rmse\"\nreference = { file = \"m.csv\", column = \"lag.y\" }\n"),
    ];
    let several: &[&str] = &["the time may be `time` or `t [s]`"];
    for (table, asked) in [
        ("Date,time,drive.u,lag.y\n20260311,915,1,1\n20260311,1000,1,2\n", clock),
        ("time,drive.u,lag.y\n20260311,1,1\n20260312,1,2\n", clock),
        ("time,t [s],drive.u,lag.y\n0,0,1,1\n1,2,1,2\n", several),
        ("drive.u,t [h],lag.y\n1,2,1\n1,2,2\n1,1,2\n", &["no column is the time: `t [h]` falls from 2 to 1 in row 3"]),
    ] {
        bench.write("m.csv", table);
        bench.run(&["init", "lag.fmu", "--measured", "m.csv"]).is_mistake(asked);
        for (study, rest) in recorded {
            bench.write(study, &format!("{begin}{criterion}{rest}"));
            bench.run(&["verify", study]).is_mistake(asked);
        }
    }
    let simulated = ["simulate", "lag.fmu", "--input", "m.csv", "--stop", "2", "--extrapolate", "hold"];
    for (table, asked) in [
        ("time,drive.u\n91500,1\n91600,1\n91700,2\n", clock),
        ("time,t [s],drive.u\n0,0,1\n1,2,1\n", several),
        ("time,drive.u\n0,1\n2,1\n1,2\n", &["no column is the time: `time` falls from 2 to 1 in row 3"]),
    ] {
        bench.write("m.csv", table);
        bench.run(&simulated).is_mistake(asked);
    }
    bench.write("m.csv", "drive.u,Zeit [min]\n1,0\n2,1\n");
    good(bench.run(&simulated));
}

#[test]
fn a_nominal_value_of_the_model_has_no_uncertainty() {
    let (bench, study) = started(&model("Lag", "Lag"), &[]);
    for (key, words) in
        [("uncertainty = \"1 %\"", "no error of a measurement"), ("noise = 0.1", "no error of a measurement")]
    {
        let wrong = study.replacen("nominal-from =", &format!("{key}\nnominal-from ="), 1);
        bench.write("wrong.toml", &wrong);
        bench.run(&["verify", "wrong.toml"]).is_mistake(&["wrong.toml:", words]);
    }
    let without = study.replacen("nominal =", "at-most =", 1).replacen("\ntolerance =", "\n# tolerance =", 1);
    bench.write("wrong.toml", &without);
    bench.run(&["verify", "wrong.toml"]).is_mistake(&["`nominal-from` says where `nominal` comes from"]);
    bench.run(&["verify", "study.toml", "--rare"]).is_mistake(&["needs measured values"]);
}
