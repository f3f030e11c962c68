//! The commands that make an answer of points and signals, seen from outside.

use std::f64::consts::TAU;

use crate::support::Bench;
use orchestrator::results::table::read_some;
use parameter_regions::table::PointTable;

const STUDY: &str = r#"
fmu = "lag.fmu"

[simulation]
stop = 2

[design]
points = 60

[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1

[parameters."lag.length"]
distribution = "uniform"
min = 0.01
max = 0.03
unit = "mm"

[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.02
"#;

fn bench() -> Bench {
    let bench = Bench::new().in_process();
    bench.write("study.toml", STUDY);
    bench
}

fn json(bench: &Bench, file: &str) -> serde_json::Value {
    serde_json::from_str(&bench.read(file)).unwrap()
}

#[test]
fn verify_leaves_a_page_and_report_writes_it_again() {
    let bench = bench();
    assert_eq!(bench.run(&["verify", "study.toml", "--output", "out"]).code, 0);
    let page = bench.read("out/report.html");
    assert!(page.contains("Does the model meet the criterion at one") && page.contains("Time histories"));
    assert!(bench.path("out/plots/distribution-Y.svg").exists());
    std::fs::remove_file(bench.path("out/report.html")).unwrap();
    assert_eq!(bench.run(&["report", "out"]).code, 0);
    assert_eq!(bench.read("out/report.html"), page);
    bench.run(&["report", "nowhere"]).is_mistake(&["nowhere holds no study"]);
}

/// A crossing is a time, whatever the variable's unit.
#[test]
fn the_columns_of_sensitivity_have_the_units_of_the_criteria() {
    let bench = bench();
    let crossing = "statistic = \"crossing\"\nlevel = 0.5\nnominal = 0.7";
    bench.write("study.toml", &STUDY.replace("nominal = 0.86", crossing));
    let said = bench.run(&["sensitivity", "study.toml", "--base", "4", "--output", "s"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let units = &json(&bench, "s/sensitivity.json")["units"];
    assert_eq!((&units["Y"], &units["lag.length"]), (&"s".into(), &"mm".into()));
}

/// Criteria without cases are fitted as those of a single case.
#[test]
fn identify_takes_plain_criteria_as_one_case() {
    let bench = Bench::new();
    let study = STUDY.split("[parameters.\"lag.length\"]").next().unwrap();
    let free = |name: &str, section: &str| {
        let criterion = "variable = \"lag.y\"\nnominal = 0.86\ntolerance = 0.02\nuncertainty = 0.01";
        bench.write(name, &format!("{study}{section}\n{criterion}\n"));
        let said = bench.run(&["identify", name, "--output", "found", "--force", "--starts", "4"]);
        assert_eq!(said.code, 0, "{}", said.err);
        json(&bench, "found/identification.json")["free"].clone()
    };
    let plain = free("plain.toml", "[criteria.Y]");
    let case = free("case.toml", "[[cases]]\nname = \"one\"\n[cases.criteria.Y]");
    assert_eq!(plain, case);
    // 1 - exp(-2 x) = 0.86
    let value = plain[0]["value"].as_f64().unwrap();
    assert!((value - 0.983).abs() < 0.01, "{value}");
}

#[test]
fn sensitivity_finds_the_only_parameter_that_matters() {
    let bench = bench();
    let said = bench.run(&["sensitivity", "study.toml", "--base", "64", "--output", "s"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let result = json(&bench, "s/sensitivity.json");
    assert_eq!(result["runs"], 64 * 4);
    let y = &result["outputs"][0];
    assert_eq!(y["name"], "Y");
    assert_eq!(y["dominant"], "lag.rate");
    // Of a part of the variance that no other parameter has, 64 base points tell an interval that holds 1.
    let total = &y["sobol"]["total"][0];
    let [low, value, high] = ["low", "value", "high"].map(|key| total[key].as_f64().unwrap());
    assert!(low <= 1.0 && 1.0 <= high && (value - 1.0).abs() < 0.35, "{y}");
    assert_eq!(y["sobol"]["total"][1]["value"], 0.0);
    assert_eq!(result["outputs"][1]["name"], "verified");
}

#[test]
fn sensitivity_by_screening() {
    let bench = bench();
    let said = bench.run(&["sensitivity", "study.toml", "--morris", "8", "--output", "m"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert_eq!(json(&bench, "m/sensitivity.json")["outputs"][0]["dominant"], "lag.rate");
}

#[test]
fn findings_of_another_study_are_not_shown() {
    let bench = bench();
    let has = |id: &str| bench.read("out/report.html").contains(&format!("id=\"{id}\""));
    let shown = || has("sensitivity");
    let verify = || bench.run(&["verify", "study.toml", "--output", "out"]).code;
    assert_eq!(verify(), 0);
    let from = ["robustness", "study.toml", "--from", "out"];
    assert_eq!(bench.run(&from).code, 0);
    assert!(has("robustness"));
    // Other points of the same study: what was found from the old ones is gone from the page.
    bench.run(&["verify", "study.toml", "--output", "out", "--seed", "9"]);
    assert!(!has("robustness"));
    // Results from runs of its own hold for all points of the study, but not for another study.
    let runs = ["sensitivity", "study.toml", "--base", "16", "--output", "out"];
    assert_eq!(bench.run(&runs).code, 0);
    assert!(shown());
    assert_eq!(verify(), 0);
    assert!(shown());
    bench.write("study.toml", &STUDY.replace("0.02", "0.03"));
    bench.run(&from).is_mistake(&["out", "study.toml", "verify it again"]);
    let said = bench.run(&runs);
    assert_eq!(said.code, 0);
    assert!(said.err.contains("does not show this"), "{}", said.err);
    assert_eq!(verify(), 0);
    assert!(shown());
}

#[test]
fn a_study_says_what_the_command_line_leaves_open() {
    let bench = bench();
    let runs = |section: &str, more: &[&str]| {
        bench.write("study.toml", &format!("{STUDY}{section}"));
        let own = ["sensitivity", "study.toml", "--output", "s"];
        let said = bench.run(&[&own[..], more].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        let result = json(&bench, "s/sensitivity.json");
        (result["method"].as_str().unwrap().to_owned(), result["runs"].as_u64().unwrap())
    };
    let screening = "[sensitivity]\nmethod = \"morris\"\nsize = 6\n";
    let (method, count) = runs(screening, &[]);
    assert_eq!((method.as_str(), count), ("Morris screening, 18 runs", 18));
    assert_eq!(runs(screening, &["--morris", "4"]).1, 12);
    // The study's size is that of its own method.
    assert_eq!(runs(screening, &["--base", "16"]).1, 64);
    assert_eq!(runs("[sensitivity]\nsize = 16\n", &[]).1, 64);

    let level = |section: &str, more: &[&str]| {
        bench.write("study.toml", &format!("{STUDY}{section}"));
        assert_eq!(bench.run(&["verify", "study.toml", "--output", "out", "--points", "24"]).code, 0);
        let own = ["robustness", "study.toml", "--from", "out"];
        let said = bench.run(&[&own[..], more].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        json(&bench, "out/robustness.json")["level"].as_f64().unwrap()
    };
    assert_eq!(level("[robustness]\nlevel = 0.75\n", &[]), 0.75);
    assert_eq!(level("[robustness]\nlevel = 0.75\n", &["--level", "0.6"]), 0.6);
    assert_eq!(level("", &[]), 0.9);
}

#[test]
fn too_few_runs_are_refused() {
    let bench = bench();
    for (option, number) in [("--base", "1"), ("--morris", "0"), ("--morris", "1")] {
        let said = bench.run(&["sensitivity", "study.toml", option, number]);
        said.is_mistake(&[option, "at least 2"]);
    }
}

#[test]
fn robustness_finds_the_room_and_confirms_it() {
    let bench = bench();
    bench.run(&["verify", "study.toml", "--output", "out"]);
    let said = bench.run(&["robustness", "study.toml", "--from", "out", "--confirm", "200"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let result = json(&bench, "out/robustness.json");
    // y = 1 - exp(-2 rate) within 0.86 +- 0.02 is rate = 0.9163 .. 1.0601.
    let margin = |side: &str| result["margins"][0][side][0].as_f64().unwrap();
    assert!((margin("low") - 0.9163).abs() < 0.01 && (margin("high") - 1.0601).abs() < 0.01, "{result}");
    let fresh = &result["region"]["fresh"];
    assert_eq!(fresh["points"], 200, "{result}");
    let (stated, interval) = (&result["region"]["interval"], &fresh["interval"]);
    let end = |of: &serde_json::Value, k: usize| of[k].as_f64().unwrap();
    assert!(end(interval, 0) <= end(stated, 1) && end(stated, 0) <= end(interval, 1), "{stated} {fresh}");
    assert!(end(stated, 0) >= 0.9, "{stated}");
    assert!(said.out.contains("stated probability holds"), "{}", said.out);
    assert!(bench.read("out/report.html").contains("id=\"robustness\""));
    bench.run(&["robustness", "study.toml", "--from", "out", "--level", "1.5"]).is_mistake(&["--level"]);
    bench.run(&["robustness", "study.toml", "--from", "none"]).is_mistake(&["none holds no study"]);
}

const TWO_CRITERIA: &str = r#"
[criteria.Z]
variable = "lag.y"
statistic = "mean"
nominal = 0.6
tolerance = 0.03
"#;

#[test]
fn pareto_weighs_the_criteria_against_each_other() {
    let bench = bench();
    bench.write("two.toml", &format!("{STUDY}{TWO_CRITERIA}"));
    bench.run(&["verify", "two.toml", "--output", "out"]);
    let said = bench.run(&["pareto", "two.toml", "--from", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let cloud = json(&bench, "out/pareto.json");
    let largest = |member: &serde_json::Value| {
        let deviations = member["deviations"].as_array().unwrap();
        deviations.iter().map(|d| d.as_f64().unwrap()).fold(0.0, f64::max)
    };
    let front = cloud["front"].as_array().unwrap();
    assert!(front.iter().all(|member| largest(&front[0]) <= largest(member)), "{cloud}");
    assert!(bench.read("out/report.html").contains("id=\"pareto\""));
    assert!(bench.path("out/plots/pareto-Y-Z.svg").exists());
    assert!(said.out.contains("Best compromise"), "{}", said.out);
    bench.run(&["pareto", "two.toml", "--from", "none"]).is_mistake(&["none holds no study"]);
}

#[test]
fn one_net_states_no_interval_and_replicates_do() {
    let bench = bench();
    let study = |design: &str| {
        let text = STUDY.replace("points = 60", &format!("points = 512\nmethod = \"{design}"));
        bench.write("sobol.toml", &text);
        bench.run(&["verify", "sobol.toml", "--output", "s"])
    };
    assert_eq!(study("sobol\"").code, 0);
    let summary = json(&bench, "s/summary.json");
    assert!(summary["verified_interval"].is_null(), "{summary}");
    assert!(summary["interval_method"].as_str().unwrap().contains("depend on each other"), "{summary}");
    assert_eq!(study("sobol\"\nreplicates = 16").code, 0);
    let summary = json(&bench, "s/summary.json");
    let end = |k: usize| summary["verified_interval"][k].as_f64().unwrap();
    let share = summary["verified_fraction"].as_f64().unwrap();
    // The rate lies within 0.9163 .. 1.0601 of a normal distribution of 1 +- 0.1.
    assert!((share - 0.5248).abs() < 0.02 && end(0) < share && share < end(1));
    let y = &summary["criteria"]["Y"];
    assert_eq!((&y["binds"], &summary["points"]), (&512.into(), &512.into()));
    assert_eq!(y["only_failure"], 512 - summary["verified"].as_u64().unwrap());
    assert_eq!(summary["provenance"]["replicates"], 16);
    assert!(bench.read("s/report.html").contains("16 independently scrambled nets"));
    study("monte-carlo\"\nreplicates = 16").is_mistake(&["sobol.toml", "replicates"]);
}

const SETTINGS: &str = r#"
diameter = "25 mm"
smoothing = { method = "butterworth", cutoff = 40, order = 3 }
time = { column = "t", unit = "ms" }
load = { column = "F", variable = "sensor.loadForce", unit = "kN", accuracy = "1 %", group = "power" }
torque = { column = "M", variable = "sensor.frictionTorque", unit = "N.m", accuracy = 0.01 }
speed = { value = 300, unit = "rpm", accuracy = "2.5 rpm" }
signals.T_oil = { column = "T", variable = "sensor.oilTemperature", unit = "degC", accuracy = "0.5 degC" }
"#;

fn recording() -> String {
    let force = |t: f64| 0.75 * (1.0 + 0.4 * (TAU * 5.0 * t).sin());
    let row = |k: i32| {
        let t = f64::from(k) * 1e-3;
        let (f, m) = (force(t), 0.047 * 0.0125 * 1e3 * force(t - 0.0123));
        format!("{k},{f},{m},{}\n", 48.0 + 0.01 * f64::from(k % 7))
    };
    String::from("t,F,M,T\n") + &(0..12_000).map(row).collect::<String>()
}

#[test]
fn synchronise_writes_criteria() {
    let bench = Bench::empty();
    bench.write("measured.csv", &recording());
    bench.write("settings.toml", SETTINGS);
    let said = bench.run(&["synchronise", "measured.csv", "--settings", "settings.toml", "--output", "m"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = bench.read("m/criteria.toml");
    assert!(text.contains("torque shifted by 12.30"), "{text}");
    let criteria: toml::Table = text.parse().unwrap();
    let nominal = |name: &str| criteria["criteria"][name]["nominal"].as_float().unwrap();
    assert!((nominal("F_N") - 750.0).abs() < 1.0);
    assert!((nominal("T_oil") - 48.03).abs() < 0.05);
    let load = &criteria["criteria"]["F_N"];
    assert_eq!(load["group"].as_str(), Some("power"));
    // How far the model may be off is not in the recording.
    assert!(load["uncertainty"].is_str() && load.get("tolerance").is_none());
    assert!(text.contains("\n# tolerance = "), "{text}");
    assert!(bench.path("m/plots/friction.svg").exists());
    let page = bench.read("m/report.html");
    assert!(page.contains("Torque later than the load by 12.3"));
    assert!(page.contains("Butterworth low pass, order 3 at 40 Hz"));
    for text in ["criteria.toml", "F_N: means of blocks"] {
        assert!(page.contains(text), "{text}: {page}");
    }
}

/// The model has no units: the recording's values are taken as they are, and the reader is told what will fail.
#[test]
fn synchronise_takes_values_as_they_are_where_the_model_has_no_unit() {
    let bench = Bench::empty();
    let noise = |k: i32| f64::from(k * 7919 % 1013) / 100.0;
    let row = |k: i32| format!("{},{}\n", f64::from(k) / 100.0, 50.0 + noise(k));
    let rows: String = (0..2000).map(row).collect();
    bench.write("measured.csv", &format!("t,y [degC]\n{rows}"));
    let settings = "[signals.y]\ncolumn = \"y\"\nvariable = \"y\"\nunit = \"none\"\naccuracy = \"0.5 degC\"\n\
                    tolerance = \"1 degC\"\n";
    bench.write("settings.toml", settings);
    let run = ["synchronise", "measured.csv", "--settings", "settings.toml", "--case", "a", "--output", "m"];
    let said = bench.run(&run);
    assert_eq!(said.code, 0, "{}", said.err);
    for line in [
        "signals.y: the model has no unit, so the values are those in `degC`, as they are",
        "measured.csv: time: `t`, which has no unit and is read as s, 0 .. 19.99 s",
        "y: the rows' noise alone (",
    ] {
        assert!(said.out.contains(line), "{line}: {}", said.out);
    }
    let study: toml::Table = bench.read("m/case.toml").parse().unwrap();
    let criterion = &study["cases"][0]["criteria"]["y"];
    assert_eq!(criterion["unit"].as_str(), Some("1"));
    assert_eq!(criterion["tolerance"].as_str(), Some("1"));
    // 13:15:50 and on, by a clock or in seconds.
    let clock = |k: i32| format!("{},{}\n", if k < 10 { 131_550 + k } else { 131_590 + k }, 50.0 + noise(k));
    bench.write("measured.csv", &format!("time,y [degC]\n{}", (0..20).map(clock).collect::<String>()));
    let said = bench.run(&run);
    assert!(
        said.code == 2 && said.err.contains("begins at 131550, which is too much for s, or a clock"),
        "{}",
        said.err
    );
    bench.write("settings.toml", &format!("time = {{ unit = \"s\" }}\n{settings}"));
    assert_eq!(bench.run(&run[..6]).code, 0);
    bench.write("settings.toml", settings);
    // Each minute late in the day; hours and minutes, from midnight; a clock beside a day.
    type Row = fn(i32) -> String;
    let minutes: Row = |k| format!("{}", 131_500 + 100 * k);
    let hours: Row = |k| format!("{}", k / 4 * 100 + k % 4 * 15);
    let beside: Row = |k| format!("20261103,{}", 5900 + k + k / 10 * 4090);
    for (head, row) in [("time", minutes), ("time", hours), ("Date,time", beside)] {
        let rows: String = (0..20).map(|k| format!("{},{}\n", row(k), 50.0 + noise(k))).collect();
        bench.write("measured.csv", &format!("{head},y [degC]\n{rows}"));
        bench.run(&run).is_mistake(&["or a clock such as 131507", "\"%H%M\""]);
    }
}

/// A recording as a case: what drove the rig, and the signals as curves with their delay and uncertainty.
#[test]
fn synchronise_writes_a_case() {
    let bench = Bench::empty();
    // A spike, and a lost sample.
    let recording = recording().replacen("\n3000,", "\n3000,9,0.4,48\n3000.4,", 1);
    let lost = recording.replacen("\n4000,", "\n4000,,", 1);
    let head = lost.lines().next().unwrap();
    let column = |row: &str| row.split(',').take(4).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = lost.lines().skip(1).map(column).collect();
    bench.write("measured.csv", &format!("{head}\n{}\n", rows.join("\n")));
    bench.write("settings.toml", SETTINGS);
    let run = |more: &[&str]| {
        let all = ["synchronise", "measured.csv", "--settings", "settings.toml"];
        bench.run(&[&all, &["--case", "300 rpm", "--output", "m"], more].concat())
    };
    run(&[]).is_mistake(&["settings.toml", "nothing drives the model", "variable = "]);
    let driven = SETTINGS
        .replace("speed = { ", "lag = \"2 ms\"\nspeed = { variable = \"drive.speed\", ")
        .replace("accuracy = \"1 %\", group", "accuracy = \"1 %\", tolerance = \"15 N\", drop = [\"spikes\"], group")
        .replace("accuracy = 0.01 }", "accuracy = 0.01, drop = [\"spikes\"] }");
    bench.write("settings.toml", &driven);
    let said = run(&["--held-out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = bench.read("m/case.toml");
    let study: toml::Table = text.parse().unwrap();
    let case = &study["cases"][0];
    assert_eq!(case["held-out"].as_bool(), Some(true));
    assert_eq!(case["fixed"]["drive.speed"].as_str(), Some("300 rpm"));
    let [load, torque] = ["F_N", "M"].map(|name| &case["criteria"][name]);
    // A rectangle of 1 % to both sides has a standard deviation of 1 % / sqrt(3).
    let reference = &load["reference"];
    assert_eq!(reference["gain-uncertainty"].as_str(), Some("1.1547 %"));
    assert!(reference.get("uncertainty").is_none() && torque["reference"]["noise"].is_str());
    assert_eq!(load["tolerance"].as_str(), Some("15 N"));
    assert!(load.get("delay").is_none() && torque.get("tolerance").is_none());
    // Found are 12.3 ms, of which 2 ms are the rig's.
    let delay = torque["delay"].as_str().unwrap().strip_suffix(" ms").unwrap();
    assert!((delay.parse::<f64>().unwrap() - 10.3).abs() < 0.01, "{delay}");
    assert!(torque["window"]["from"].as_float().unwrap() >= 0.0103);
    assert!(
        text.contains("# case.csv, F_N: 12001 rows, 11999 used, 1 empty, 1 spikes.")
            && text.contains("# case.csv, M: 12001 rows, 11999 used, 1 spikes, 1 in rows where"),
        "{text}"
    );
    let table = bench.read("m/case.csv");
    assert!(table.starts_with("time,F_N,M,T_oil\n0.000000000,7.5"), "{}", &table[..80]);
    assert_eq!(table.lines().count(), 1 + 12_001 - 2);
    bench.write("settings.toml", &driven.replace("\"15 N\"", "\"2 %\""));
    run(&[]).is_mistake(&["settings.toml", "F_N: the tolerance 2 %", "with a unit"]);
}

#[test]
fn mistakes_of_a_recording_are_named() {
    let bench = Bench::empty();
    bench.write("measured.csv", &recording());
    let say = |from: &str, to: &str| {
        assert!(SETTINGS.contains(from));
        bench.write("settings.toml", &SETTINGS.replace(from, to));
        bench.run(&["synchronise", "measured.csv", "--settings", "settings.toml", "--output", "m"])
    };
    say("column = \"F\"", "column = \"G\"").is_mistake(&["measured.csv", "no column `G`"]);
    say("\"kN\"", "\"lbf\"").is_mistake(&["settings.toml", "unit `lbf`", "kN"]);
    say("accuracy = 0.01", "acuracy = 0.01").is_mistake(&["settings.toml", "line 6"]);
    say("\"25 mm\"", "\"-25 mm\"").is_mistake(&["diameter must be positive"]);
}

/// Units in the header, and none in the settings; what a logger writes otherwise is for `convert`.
#[test]
fn units_of_a_recording_stand_in_its_header() {
    let bench = Bench::empty();
    bench.write("measured.csv", &recording().replacen("t,F,M,T", "t [ms],F [kN],M [N.m],T [degC]", 1));
    let settings = SETTINGS.replace(", unit = \"ms\"", "").replace(" unit = \"kN\",", "");
    bench.write("settings.toml", &settings.replace(" unit = \"degC\",", ""));
    let run = ["synchronise", "measured.csv", "--settings", "settings.toml", "--output", "m"];
    let said = bench.run(&run);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = bench.read("m/criteria.toml");
    assert!(text.contains("torque shifted by 12.30"), "{text}");
    assert!(text.contains("nominal = 750") && text.contains("unit = \"degC\""), "{text}");
    bench.write("settings.toml", &SETTINGS.replace("\"kN\"", "\"N\""));
    bench.run(&run).is_mistake(&["measured.csv: column `F` is in `kN`", "`unit` says `N`"]);
    bench.write("measured.csv", &recording().replacen("\n", "\n;kN;N.m;degC\n", 1));
    bench.run(&run).is_mistake(&["measured.csv", "convert"]);
}

/// Any signals, from two loggers that share nothing: other times, volts, units in names. The case runs as it is written.
#[test]
fn two_files_of_any_signals_become_a_case_that_runs() {
    let bench = Bench::new();
    let mut fast = String::from("t [ms],u [-],U_y (V)\n");
    let mut random = 1_u64;
    for k in 0..2000_u32 {
        random = (random * 1_103_515_245 + 12_345) % (1 << 31);
        let (t, noise) = (f64::from(k) * 1e-3, random as f64 / f64::from(1 << 30) - 1.0);
        // The logger hangs for 40 ms.
        let y = 2.0 * (1.0 - (-if (1500..1540).contains(&k) { 1.5 } else { t }).exp());
        fast += &format!("{k},{},{y}\n", 1.0 + 0.01 * noise);
    }
    bench.write("fast.csv", &fast);
    let mut slow = "Zeit [s],T [\u{b0}C]\n".to_owned();
    for k in 0..20_u32 {
        slow += &format!("{},{:.3}\n", 0.1 * f64::from(k), 20.0 + 0.01 * f64::from(k));
    }
    bench.write("slow.csv", &slow);
    let settings = r#"
[[files]]
time = { column = "t" }
[[files]]
time = { column = "Zeit" }
[signals]
Y = { column = "U_y", scale = 0.5, unit = "1", variable = "lag.y", accuracy = 0.01, tolerance = 0.1 }
T = { column = "T", variable = "lag.temperature", accuracy = "0.5 degC", tolerance = "900 degC" }
[inputs]
"drive.u" = { column = "u", accuracy = 0.01 }
"#;
    bench.write("settings.toml", settings);
    let run = ["synchronise", "fast.csv", "slow.csv", "--settings", "settings.toml", "--case", "idle", "--output", "m"];
    let said = bench.run(&run);
    assert_eq!(said.code, 0, "{}", said.err);
    for line in [
        "# case.csv, Y: 2000 rows, 2000 used.",
        "# case-2.csv, T: 20 rows, 20 used.",
        "slow.csv: time: `Zeit`, 0 .. 1.9 s",
        "2000 used for a line with 2 corners",
    ] {
        assert!(said.out.contains(line), "{line}: {}", said.out);
    }
    let criteria: toml::Table = bench.read("m/criteria.toml").parse().unwrap();
    let oil = criteria["criteria"]["T"]["nominal"].as_float().unwrap();
    assert!((oil - 20.095).abs() < 0.01, "{oil}");
    let page = bench.read("m/report.html");
    assert!(page.contains("Y: as recorded") && !page.contains("friction"), "no bearing");
    let head = "fmu = \"lag.fmu\"\n[design]\npoints = 20\n[parameters.\"lag.rate\"]\ndistribution = \"uniform\"\nmin = 0.8\n\
                max = 1.4\n[simulation]\nstep = 0.05\n";
    bench.write("study.toml", &(head.to_owned() + &bench.read("m/case.toml")));
    let verified = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert!(verified.code < 2, "{} {}", verified.err, bench.read("m/case.toml"));
    let concerns = bench.summary("out")["concerns"].to_string();
    assert!(
        concerns.contains("\"code\":\"doubtful\"") && concerns.contains("case idle: Y stands at 0.77"),
        "{concerns}"
    );

    let say = |from: &str, to: &str| {
        assert!(settings.contains(from), "{from}");
        bench.write("settings.toml", &settings.replace(from, to));
        bench.run(&run)
    };
    // Studies know no unit `none`.
    let case = bench.read("m/case.toml");
    assert_eq!(say("unit = \"1\"", "unit = \"none\"").code, 0);
    assert_eq!(bench.read("m/case.toml"), case);
    // What was recorded before the model starts is left out, and told.
    let start = |text: &str| {
        say("\n[[files]]\ntime = { column = \"t\"", &format!("\nstart = {text}\n[[files]]\ntime = {{ column = \"t\""))
    };
    for text in ["0.5", "\"500 ms\""] {
        let said = start(text);
        for line in [
            "# The model starts at 0.5 s of the recording.",
            "# case.csv, Y: 2000 rows, 1500 used, 500 before the model's start.",
            "# case-2.csv, T: 20 rows, 15 used, 5 before the model's start.",
        ] {
            assert!(said.out.contains(line), "{line}: {} {}", said.out, said.err);
        }
        for table in ["case", "case-2", "case-inputs"] {
            assert!(bench.read(&format!("m/{table}.csv")).contains("\n0.000000000,"));
        }
    }
    start("5.0").is_mistake(&["settings.toml: line 2: start: 5 s is not before 1.9 s"]);
    start("\"5 kg\"").is_mistake(&["settings.toml: line 2: start: ", "kg"]);
    start("nan").is_mistake(&["settings.toml: line 2: start: NaN"]);
    // An offset has the signal's unit, or its own.
    let shifted = |offset: &str| {
        let accuracy = "accuracy = \"0.5 degC\"";
        let said = say(accuracy, &format!("{accuracy}, offset = {offset}"));
        assert_eq!(said.code, 0, "{}", said.err);
        let criteria: toml::Table = bench.read("m/criteria.toml").parse().unwrap();
        criteria["criteria"]["T"]["nominal"].as_float().unwrap() - oil
    };
    for offset in ["1.8", "\"1.8 K\"", "\"3.24 degF\""] {
        assert!((shifted(offset) - 1.8).abs() < 0.01, "{offset}");
    }
    say("column = \"t\"", "column = \"t\", offset = \"soon\"").is_mistake(&["settings.toml", "line 3", "`soon`"]);
    say("column = \"U_y\"", "column = \"U_z\"").is_mistake(&[
        "fast.csv",
        "no column `U_z`",
        "did you mean",
        "it has t [ms], u [-], U_y (V); slow.csv has Zeit [s], T [\u{b0}C]",
    ]);
    say("variable = \"lag.y\",", "").is_mistake(&["settings.toml", "signals.Y", "`variable` is missing"]);
    say("[[files]]", "[[files]]\n[[files]]").is_mistake(&["settings.toml", "files: 4", "2 given"]);
    bench.write("settings.toml", settings);
    bench.write("fast.csv", &(fast.clone() + "end of record,,\n"));
    bench.run(&run).is_mistake(&["fast.csv: line 2002: `end of record` in column `t` is no number", "missing = ["]);
    std::fs::write(bench.path("x.mf4"), b"MDF     4.10").unwrap();
    bench.run(&["synchronise", "x.mf4", "--settings", "settings.toml"]).is_mistake(&["settings.toml: files: 2"]);
    bench.write(
        "settings.toml",
        settings.split("[signals]").last().map(|rest| format!("[signals]{rest}")).unwrap().as_str(),
    );
    bench
        .run(&["synchronise", "x.mf4", "--settings", "settings.toml"])
        .is_mistake(&["x.mf4: not a plain table", "python -m fmu_orchestrator convert \"x.mf4\""]);
}

#[test]
fn of_many_points_an_even_choice_and_the_best_are_read() {
    let bench = bench();
    let run = ["verify", "study.toml", "--points", "1900", "--isolation", "none", "--output", "out"];
    assert_eq!(bench.run(&run).code, 0);
    let folder = bench.path("out");
    let (_, all) = read_some(&folder, u64::MAX).unwrap();
    let (_, some) = read_some(&folder, 190).unwrap();
    // One of every ten points, and the thousand best of the others, in their order.
    assert_eq!((all.len(), some.len()), (1900, 1190));
    assert!(some.ids.is_sorted());
    let places: Vec<usize> = some.ids.iter().map(|id| *id as usize - 1).collect();
    assert_eq!(some, all.subset(&places));
    let ids = |table: &PointTable| -> Vec<u64> {
        let best = table.best(1000);
        best.iter().map(|ranked| table.ids[ranked.point]).collect()
    };
    assert_eq!(ids(&some), ids(&all));
    // Where the best are all others, nothing is missing.
    let (_, whole) = read_some(&folder, 1000).unwrap();
    assert_eq!(whole, all.subset(&(0..1900).collect::<Vec<_>>()));
}
