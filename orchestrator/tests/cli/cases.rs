//! Studies with cases: each case is as a study of its own, and a point is verified when it holds in all of them.
//! The fixture's closed form is y = u (1 - exp(-rate t)).

use std::fmt::Write;

use crate::support::{Bench, Said, model};

/// Two cases that differ in everything that a case may give.
const CASES: &str = r#"
[[cases]]
name = "low"
fixed = { "drive.u" = 1.0 }
criteria.Y = { variable = "lag.y", nominal = 0.86, tolerance = 0.04 }
[[cases]]
name = "high"
held-out = true
fixed = { "drive.u" = 2.0, "lag.count" = 3 }
simulation = { stop = 1.0, step = 0.02, window = 0.3 }
criteria.Y = { variable = "lag.y", statistic = "mean", nominal = 1.2, tolerance = 0.1 }
criteria.T = { variable = "lag.temperature", nominal = 40, tolerance = 3, unit = "degC" }
"#;

/// The same as two studies.
const LOW: &str = r#"
[fixed]
"drive.u" = 1.0
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.04
[simulation]
stop = 2
step = 0.05
"#;
const HIGH: &str = r#"
[fixed]
"drive.u" = 2.0
"lag.count" = 3
[criteria]
Y = { variable = "lag.y", statistic = "mean", nominal = 1.2, tolerance = 0.1 }
T = { variable = "lag.temperature", nominal = 40, tolerance = 3, unit = "degC" }
[simulation]
stop = 1.0
step = 0.02
window = 0.3
"#;

const HEAD: &str = r#"
fmu = "lag.fmu"
[design]
points = 40
seed = 3
[parameters."lag.rate"]
distribution = "uniform"
min = 0.8
max = 1.4
"#;

const TIMES: &str = "[simulation]\nstop = 2\nstep = 0.05\n";

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("cases.toml", &format!("{HEAD}{TIMES}{CASES}"));
    bench
}

fn verify(bench: &Bench, study: &str, into: &str, options: &[&str]) -> Said {
    let said = bench.run(&[&["verify", study, "--output", into], options].concat());
    assert!(said.code < 2, "{}", said.err);
    said
}

/// The columns of points.csv by their names.
fn columns(bench: &Bench, folder: &str) -> Vec<(String, Vec<String>)> {
    let text = bench.read(&format!("{folder}/points.csv"));
    let mut lines = text.lines();
    let names = lines.next().unwrap().split(',').map(str::to_owned);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    let column = |(k, name): (usize, String)| {
        let cells = rows.iter().map(|row| row[k].to_owned());
        (name, cells.collect())
    };
    names.enumerate().map(column).collect()
}

fn column(table: &[(String, Vec<String>)], name: &str) -> Vec<String> {
    let found = table.iter().find(|(own, _)| own == name);
    found.unwrap_or_else(|| panic!("no column {name}")).1.clone()
}

/// The points of a study with cases are those of studies of one case each, to the last digit, however they share
/// processes; and each is verified when it is in all of them.
#[test]
fn two_cases_are_two_studies() {
    let bench = bench();
    for (case, study) in [("low", LOW), ("high", HIGH)] {
        bench.write("study.toml", &format!("{HEAD}{study}"));
        verify(&bench, "study.toml", case, &["--isolation", "none"]);
    }
    for isolation in ["fresh", "shared"] {
        verify(&bench, "cases.toml", "cases", &["--isolation", isolation, "--force"]);
        let own = columns(&bench, "cases");
        let mut all = vec![true; 40];
        for case in ["low", "high"] {
            let alone = columns(&bench, case);
            assert_eq!(column(&own, "lag.rate"), column(&alone, "lag.rate"));
            for name in if case == "low" { &["Y"][..] } else { &["Y", "T"] } {
                for name in [(*name).to_owned(), format!("{name}.ok")] {
                    let full = format!("{case}/{name}");
                    assert_eq!(column(&own, &full), column(&alone, &name), "{full}");
                }
            }
            let verified = column(&alone, "verified");
            all = all.iter().zip(&verified).map(|(all, own)| *all && own == "true").collect();
            let [ours, theirs] = [bench.summary("cases"), bench.summary(case)];
            assert_eq!(ours["cases"][case]["passed"], theirs["verified"]);
            assert_eq!(ours["cases"][case]["interval"], theirs["verified_interval"]);
            assert_eq!(ours["cases"][case]["held_out"], case == "high");
        }
        let verified: Vec<bool> = column(&own, "verified").iter().map(|cell| cell == "true").collect();
        assert_eq!(verified, all);
        // Neither case decides alone, so that the test could fail.
        let summary = bench.summary("cases");
        let count = |value: &serde_json::Value| value.as_u64().unwrap();
        let both = count(&summary["verified"]);
        assert!(both > 0);
        for case in ["low", "high"] {
            assert!(count(&summary["cases"][case]["passed"]) > both, "{summary}");
        }
        let page = bench.read("cases/report.html");
        assert!(page.contains("By case") && page.contains("held out"));
        assert!(bench.path("cases/plots/history-low_Y.svg").exists());
        assert!(bench.path("cases/plots/history-high_T.svg").exists());
    }
}

/// Each case has a process of its own where points need one: of this FMU, all simulations of a process but the first are
/// wrong.
#[test]
fn cases_are_separated_like_points() {
    let bench = bench();
    verify(&bench, "cases.toml", "good", &["--isolation", "none"]);
    bench.fmu("lag.fmu", &["DRIFT=1"], &model("Lag", "Lag"));
    verify(&bench, "cases.toml", "fresh", &[]);
    assert_eq!(bench.read("fresh/points.csv"), bench.read("good/points.csv"));
    verify(&bench, "cases.toml", "shared", &["--isolation", "shared"]);
    assert_ne!(bench.read("shared/points.csv"), bench.read("good/points.csv"));
}

#[test]
fn shards_and_a_resumed_run_give_the_same_files() {
    let bench = bench();
    let said = verify(&bench, "cases.toml", "whole", &["--verbose"]);
    assert!(said.out.contains("case low "), "{}", said.out);
    assert!(said.out.contains("case high, held out "), "{}", said.out);
    for shard in ["1", "2"] {
        let (into, part) = (format!("shard-{shard}"), format!("{shard}/2"));
        let said = bench.run(&["verify", "cases.toml", "--output", &into, "--shard", &part]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let said = bench.run(&["merge", "shard-1", "shard-2", "--output", "merged"]);
    assert!(said.code < 2, "{}", said.err);
    assert_eq!(bench.read("merged/points.csv"), bench.read("whole/points.csv"));
    // A run that was cut off in the middle of a line.
    let journal = bench.read("whole/journal.txt");
    let end = journal.len() * 2 / 3;
    std::fs::create_dir(bench.path("resumed")).unwrap();
    for file in ["request.json", "study.toml"] {
        bench.write(&format!("resumed/{file}"), &bench.read(&format!("whole/{file}")));
    }
    bench.write("resumed/journal.txt", &journal[..end]);
    verify(&bench, "cases.toml", "resumed", &["--resume"]);
    assert_eq!(bench.read("resumed/points.csv"), bench.read("whole/points.csv"));
}

/// A case that breaks costs its points, not the run, and not what the other case says of them.
#[test]
fn a_broken_case_costs_the_point() {
    for (fault, status) in [("Fail", "fmi2Error"), ("Crash", "SIGSEGV"), ("NotANumber", "not finite")] {
        let bench = bench();
        let broken = CASES.replace("\"lag.count\" = 3", &format!("\"lag.fault\" = \"{fault}\""));
        bench.write("broken.toml", &format!("{HEAD}{TIMES}{broken}").replace("points = 40", "points = 8"));
        // Where every point failed, nothing is decided.
        let said = bench.run(&["verify", "broken.toml", "--output", "out"]);
        assert_eq!(said.code, 3, "{}{}", said.out, said.err);
        let table = columns(&bench, "out");
        for cell in column(&table, "status") {
            assert!(cell.starts_with("case high: ") && cell.contains(status), "{cell}");
        }
        assert!(column(&table, "low/Y").iter().all(|cell| !cell.is_empty()));
        assert!(column(&table, "low/Y.ok").contains(&"true".to_owned()));
        assert!(column(&table, "high/Y.ok").iter().all(|cell| cell == "false"));
        let summary = bench.summary("out");
        assert_eq!(summary["failed"], 8);
        assert_eq!(summary["cases"]["high"]["failed"], 8);
        assert_eq!(summary["cases"]["low"]["failed"], 0);
        assert!(summary["cases"]["low"]["passed"].as_u64().unwrap() > 0);
    }
}

#[test]
fn tables_are_judged_by_case() {
    let bench = bench();
    bench.write("table.csv", "point,low/Y,high/Y,high/T\n1,0.86,1.2,40\n2,0.86,1.2,44\n3,0.95,1.2,40\n4,0.86,,40\n");
    let said = bench.run(&["judge", "cases.toml", "table.csv", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let summary = bench.summary("out");
    assert_eq!(summary["verified"], 1);
    assert_eq!(summary["cases"]["low"]["passed"], 3);
    assert_eq!(summary["cases"]["high"]["passed"], 2);
    assert_eq!(summary["cases"]["high"]["failed"], 1);
    // What depends on parameters that the table does not have is not told.
    for analysis in ["robustness", "pareto"] {
        bench.run(&[analysis, "cases.toml", "--from", "out"]).is_mistake(&["--from", "no parameters"]);
    }
    // The variable's name would be that of both cases.
    bench.write("table.csv", "lag.y,lag.temperature\n0.86,13\n");
    bench.run(&["judge", "cases.toml", "table.csv"]).is_mistake(&["table.csv", "low/Y"]);
}

#[test]
fn points_of_a_table_run_in_every_case() {
    let bench = bench();
    bench.write("points.csv", "point,lag.rate\n7,1.0\n9,1.1\n");
    verify(&bench, "cases.toml", "out", &["--points-from", "points.csv"]);
    let table = columns(&bench, "out");
    assert_eq!(column(&table, "point"), ["7", "9"]);
    for (k, rate) in [1.0_f64, 1.1].into_iter().enumerate() {
        let value: f64 = column(&table, "low/Y")[k].parse().unwrap();
        assert!((value - (1.0 - (-2.0 * rate).exp())).abs() < 1e-9, "{value}");
    }
}

#[test]
fn a_case_is_replayed() {
    let bench = bench();
    verify(&bench, "cases.toml", "out", &[]);
    let said = bench.run(&["replay", "out", "5", "--case", "high", "--output", "one.csv"]);
    assert!(said.code < 2, "{}", said.err);
    assert!(said.out.contains("trajectory of the case high in one.csv"), "{}", said.out);
    let trajectory = bench.read("one.csv");
    assert!(trajectory.lines().last().unwrap().starts_with("1,"), "{trajectory}");
    let said = bench.run(&["replay", "out", "5"]);
    assert!(said.code < 2, "{}", said.err);
    // Without the folder of the FMU, which stands in the last cell.
    let last = |file: &str| {
        let text = bench.read(file);
        let row = text.lines().last().unwrap();
        row.rsplit_once(',').unwrap().0.to_owned()
    };
    assert!(last("out/point-5-case-1.csv").starts_with("2,"));
    assert_eq!(last("out/point-5-case-2.csv"), last("one.csv"));
    bench.run(&["replay", "out", "5", "--output", "one.csv"]).is_mistake(&["--case NAME"]);
    bench.run(&["replay", "out", "5", "--case", "hihg"]).is_mistake(&["no case `hihg`; did you mean `high`?"]);
}

/// Every analysis sees the criteria of all cases.
#[test]
fn analyses_work_with_cases() {
    let bench = bench().in_process();
    let goal = bench.read("cases.toml") + "[tolerances]\nshare = \"30 %\"\n";
    bench.write("goal.toml", &goal);
    verify(&bench, "cases.toml", "out", &[]);
    for command in [
        &["sensitivity", "cases.toml", "--base", "16", "--output", "s"][..],
        &["robustness", "cases.toml", "--from", "out"],
        // Each case of a point is a run.
        &["robustness", "cases.toml", "--from", "out", "--budget", "33", "--output", "b"],
        &["pareto", "cases.toml", "--from", "out"],
        &["verify", "cases.toml", "--rare", "--budget", "40", "--output", "rare"],
        &["tolerances", "goal.toml", "--points", "256", "--output", "t"],
        &["verify", "cases.toml", "--validation", "--output", "v"],
        &["report", "out"],
    ] {
        let said = bench.run(command);
        assert!(said.code < 2, "{command:?}: {}{}", said.out, said.err);
    }
    let robust: serde_json::Value = serde_json::from_str(&bench.read("b/robustness.json")).unwrap();
    assert_eq!(robust["region"]["fresh"]["points"], 14, "{robust}");
    let found: serde_json::Value = serde_json::from_str(&bench.read("s/sensitivity.json")).unwrap();
    let outputs = found["outputs"].as_array().unwrap().iter();
    let names: Vec<&str> = outputs.map(|output| output["name"].as_str().unwrap()).collect();
    for name in ["low/Y", "high/Y", "high/T"] {
        assert!(names.contains(&name), "{names:?}");
    }
}

/// A study of two curves with noise, each of another input and uncertainty, and a third case that is held out and wrong.
fn curves(bench: &Bench) -> String {
    let mut cases = String::new();
    let wave = |k: f64| (12.9898 * k).sin() * 0.01;
    for (number, (name, u)) in [("one", 1.0), ("two", 2.0), ("off", 5.0)].into_iter().enumerate() {
        let mut table = String::from("time,y\n");
        for k in 1..=19_u32 {
            let time = 0.1 * f64::from(k);
            let noise = wave(f64::from(k) + 100.0 * number as f64);
            let wrong = if name == "off" { 1.0 } else { 0.0 };
            let y = u * (1.0 - (-1.1 * time).exp()) + noise + wrong;
            writeln!(table, "{time},{y}").unwrap();
        }
        bench.write(&format!("{name}.csv"), &table);
        let held_out = name == "off";
        write!(
            cases,
            r#"
[[cases]]
name = "{name}"
held-out = {held_out}
fixed = {{ "drive.u" = {u} }}
criteria.Y = {{ variable = "lag.y", reference = {{ file = "{name}.csv", column = "y", noise = 0.0075 }}, metric = "rmse", tolerance = 0.02 }}
"#
        )
        .unwrap();
    }
    let times = TIMES.replace("0.05", "0.01");
    let head = HEAD.replace("points = 40", "points = 20");
    format!("{head}{times}{cases}")
}

/// The cases that are not held out are the data of `identify`: the true rate is within its interval, which is narrow, and
/// a wrong case that is held out changes nothing.
#[test]
fn identify_fits_the_cases_that_are_not_held_out() {
    let bench = Bench::new();
    let study = curves(&bench);
    bench.write("study.toml", &study);
    let said = bench.run(&["identify", "study.toml", "--output", "found", "--starts", "4"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let found = bench.read("found/identification.json");
    let outcome: serde_json::Value = serde_json::from_str(&found).unwrap();
    let free = &outcome["free"][0];
    assert_eq!(free["name"], "lag.rate");
    let [low, high] = [0, 1].map(|k| free["interval"][k].as_f64().unwrap());
    assert!(low < 1.1 && 1.1 < high && high - low < 0.03, "{low} .. {high}");
    assert_eq!(outcome["cases"][0]["residuals"].as_array().unwrap().len(), 38);
    // Fitted too, the wrong case would pull the rate away.
    bench.write("all.toml", &study.replace("held-out = true", "held-out = false"));
    let said = bench.run(&["identify", "all.toml", "--output", "all", "--starts", "4"]);
    assert!(said.code < 2, "{}{}", said.out, said.err);
    let all: serde_json::Value = serde_json::from_str(&bench.read("all/identification.json")).unwrap();
    assert!(all["free"][0]["value"].as_f64().unwrap() > 1.2);
    // The optimum holds in the fitted cases and not in the other one.
    bench.write("points.csv", &format!("lag.rate\n{}\n", free["value"]));
    verify(&bench, "study.toml", "out", &["--points-from", "points.csv"]);
    let summary = bench.summary("out");
    for (case, passed) in [("one", 1), ("two", 1), ("off", 0)] {
        assert_eq!(summary["cases"][case]["passed"], passed, "{summary}");
    }
}

/// Both curves come from a sensor whose zero is off by 0.06, within its uncertainty: the true rate is within its interval, and
/// the zero error is told. With each row's error independent the rate would be far off.
#[test]
fn identify_tells_the_zero_error_of_a_sensor() {
    let bench = Bench::new();
    let study = curves(&bench).replace("noise = 0.0075", "uncertainty = 0.1, noise = 0.0075");
    for name in ["one", "two"] {
        let table = bench.read(&format!("{name}.csv"));
        let mut rows = table.lines();
        let mut shifted = format!("{}\n", rows.next().unwrap());
        for row in rows {
            let (time, y) = row.split_once(',').unwrap();
            writeln!(shifted, "{time},{}", y.parse::<f64>().unwrap() + 0.06).unwrap();
        }
        bench.write(&format!("{name}.csv"), &shifted);
    }
    let pair = "[[uncertainty-correlations]]\nbetween = [\"one/Y\", \"two/Y\"]\ncoefficient = 1\n";
    let identify = |study: &str| {
        bench.write("study.toml", study);
        let call = ["identify", "study.toml", "--output", "found", "--starts", "4"];
        let said = bench.run(&[&call[..], &["--force"]].concat());
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let found = bench.read("found/identification.json");
        let outcome: serde_json::Value = serde_json::from_str(&found).unwrap();
        let rate = [0, 1].map(|k| outcome["free"][0]["interval"][k].as_f64().unwrap());
        // Whatever the terminal's width.
        let words = said.out.split_whitespace().collect::<Vec<_>>().join(" ");
        (words, outcome, rate)
    };
    let (said, outcome, [low, high]) = identify(&format!("{study}{pair}"));
    assert!(low < 1.1 && 1.1 < high && high - low < 0.05, "{low} .. {high}");
    let errors = outcome["shared"].as_array().unwrap();
    assert_eq!(errors.len(), 1, "both curves have one sensor");
    let [low, high] = [0, 1].map(|k| errors[0]["interval"][k].as_f64().unwrap());
    assert!(low < 0.06 && 0.06 < high && high - low < 0.03, "{low} .. {high}");
    assert!(said.contains("The sensor of one/Y and two/Y most likely reads 0.0"), "{said}");
    // A sensor each: two zero errors, and a rate that is known less.
    let (_, outcome, rates) = identify(&study);
    assert_eq!(outcome["shared"].as_array().unwrap().len(), 2);
    assert!(rates[0] < 1.1 && 1.1 < rates[1], "{rates:?}");
    // Taken as noise it is missed.
    let noise = study.replace("uncertainty = 0.1,", "uncertainty = 0.1, correlation = 0,");
    let (_, _, rates) = identify(&noise);
    assert!(rates[0] > 1.1, "{rates:?}");
    // Without a word on noise it says what it takes, and why the answer is another one.
    let (said, ..) = identify(&study.replace(", noise = 0.0075", ""));
    assert!(said.contains("one/Y states no noise"), "{said}");
}

/// The curves are late by 30 ms, each logger with a clock of its own: the lags are found with the rate.
#[test]
fn identify_finds_the_lag_of_a_case() {
    let bench = Bench::new();
    let range = "lag = { min = \"-20 ms\", max = \"80 ms\" }\ncriteria.Y";
    let study = curves(&bench).replace("criteria.Y", range);
    for (name, u) in [("one", 1.0), ("two", 2.0)] {
        let mut table = String::from("time,y\n");
        for k in 1..=19_u32 {
            let time = 0.1 * f64::from(k);
            let noise = 0.005 * (12.9898 * f64::from(k) + u).sin();
            let y = u * (1.0 - (-1.1 * (time - 0.03)).exp()) + noise;
            writeln!(table, "{time},{y}").unwrap();
        }
        bench.write(&format!("{name}.csv"), &table);
    }
    bench.write("study.toml", &study);
    let call = ["identify", "study.toml", "--output", "found", "--starts", "4"];
    let said = bench.run(&call);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let found = bench.read("found/identification.json");
    let outcome: serde_json::Value = serde_json::from_str(&found).unwrap();
    let free = outcome["free"].as_array().unwrap();
    for (parameter, (name, truth)) in free.iter().zip([("lag.rate", 1.1), ("one/lag", 0.03), ("two/lag", 0.03)]) {
        assert_eq!(parameter["name"], name);
        let [low, high] = [0, 1].map(|k| parameter["interval"][k].as_f64().unwrap());
        assert!(low < truth && truth < high, "{name}: {low} .. {high}");
        assert!(high - low < 0.06, "{name}: {low} .. {high}");
    }
    assert_eq!(free.len(), 3);
    // A lag is no start value of the FMU.
    assert!(!bench.read("found/optimum.toml").contains("one/lag"));
    // The run must reach as far as the lags.
    bench.write("study.toml", &study.replace("-20 ms", "-200 ms"));
    bench.run(&["identify", "study.toml"]).is_mistake(&["one/Y", "set `window`"]);
    bench.write("study.toml", &study.replace("-20 ms", "90 ms"));
    bench.run(&["identify", "study.toml"]).is_mistake(&["one", "are no range"]);
}

#[test]
fn identify_says_what_it_needs_of_cases() {
    let bench = bench();
    bench.run(&["identify", "cases.toml"]).is_mistake(&["cases.toml:", "low/Y: identify weighs", "add `uncertainty`"]);
    let study = curves(&bench).replace(", noise = 0.0075", "");
    bench.write("study.toml", &study);
    bench.run(&["identify", "study.toml"]).is_mistake(&["study.toml:", "one/Y", "add `uncertainty` and `noise`"]);
    let study = curves(&bench).replace("held-out = false", "held-out = true");
    bench.write("study.toml", &study);
    bench.run(&["identify", "study.toml"]).is_mistake(&["study.toml:", "every case is held out"]);
    bench.write("study.toml", &(curves(&bench) + "[identify]\ncases = \"one.csv\"\n"));
    bench.run(&["identify", "study.toml"]).is_mistake(&["the criteria of the study are the data of identify"]);
}

#[test]
fn mistakes_in_cases_have_file_line_and_remedy() {
    let bench = bench();
    for (from, to, words) in [
        ("name = \"high\"", "name = \"low\"", ["two cases have the name `low`", "rename"]),
        (
            "criteria.Y = { variable = \"lag.y\", nominal = 0.86, tolerance = 0.04 }",
            "",
            ["the case `low` has no criteria", "add [cases.criteria.NAME]"],
        ),
        (
            "\"drive.u\" = 2.0,",
            "\"lag.rate\" = 2.0,",
            ["lag.rate is under [parameters]", "remove it there or from the case `high`"],
        ),
        ("\"drive.u\" = 2.0,", "\"drive.v\" = 2.0,", ["no variable `drive.v`", "did you mean `drive.u`?"]),
        ("unit = \"degC\"", "unit = \"m\"", ["high/T", "m"]),
        ("stop = 1.0", "stop = -1", ["the simulation of the case `high`", "stop time"]),
        ("variable = \"lag.temperature\"", "variable = \"drive.u\"", ["drive.u is an input", "name an output"]),
        ("\"drive.u\" = 1.0", "\"drive.u\" = \"1 mm\"", ["cases.toml:", "drive.u"]),
    ] {
        assert!(CASES.contains(from), "{from}");
        bench.write("cases.toml", &format!("{HEAD}{TIMES}{}", CASES.replacen(from, to, 1)));
        let said = bench.run(&["verify", "cases.toml", "--output", "out"]);
        said.is_mistake(&["cases.toml:"]);
        said.is_mistake(&words);
    }
}
