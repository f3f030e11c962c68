//! `--budget`: every run of the FMU counts, and the answer is that of the exact share.

use std::fs;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use crate::durability::{KEYS_OF_HOW, without};
use crate::support::{Bench, Said, model};

/// Two parameters of a lag, one of them with a logarithm that is normal.
const LAG: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1
[parameters."lag.length"]
distribution = "lognormal"
mean = 0.02
deviation = 0.004
unit = "mm"
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.02
[criteria.L]
variable = "lag.micrometres"
nominal = 17.2
tolerance = 4
[verdict]
share = "40 %"
"#;

/// Three normal parameters; the criteria are completed by each test.
fn functions(lines: &str) -> String {
    let parameter = |k: usize| format!("[parameters.x{k}]\ndistribution = \"normal\"\nmean = 0\ndeviation = 1\n");
    let parameters: String = (1..=3).map(parameter).collect();
    format!("fmu = \"functions.fmu\"\n[simulation]\nstop = 1\n{parameters}{lines}")
}

fn lag() -> Bench {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["NAP=2000"], &model("", ""));
    bench.write("study.toml", LAG);
    bench
}

/// A run whose FMU counts its own instances in a file.
fn counted(bench: &Bench, folder: &str, log: &str, options: &[&str]) -> Said {
    let arguments = [&["verify", "study.toml", "--jobs", "2", "--output", folder], options].concat();
    let mut command = bench.command(&arguments);
    command.env("LAG_INSTANCES", bench.path(log)).output().unwrap().into()
}

fn instances(bench: &Bench, log: &str) -> usize {
    fs::read(bench.path(log)).map_or(0, |bytes| bytes.len())
}

fn files(bench: &Bench, folder: &str) -> [String; 2] {
    [bench.read(&format!("{folder}/points.csv")), without(&bench.summary(folder), &KEYS_OF_HOW)]
}

#[test]
fn the_fmu_counts_no_more_runs_than_the_budget_and_a_larger_one_goes_on() {
    let bench = lag();
    let said = counted(&bench, "out", "log", &["--budget", "40"]);
    assert!([0, 1, 3].contains(&said.code), "{}", said.err);
    assert!(said.out.contains("y surrogate from 40 runs"), "{}", said.out);
    assert_eq!(instances(&bench, "log"), 40, "{}", said.out);
    let first = bench.read("out/points.csv");
    assert_eq!(first.lines().count(), 1 + 36);
    // Once more: nothing is run, and the answer is the same.
    let again = counted(&bench, "out", "log", &["--budget", "40", "--resume"]);
    assert_eq!((again.code, again.out), (said.code, said.out));
    assert_eq!(instances(&bench, "log"), 40);
    let more = counted(&bench, "out", "log", &["--budget", "60", "--resume"]);
    assert!(more.out.contains("y surrogate from 60 runs"), "{}{}", more.out, more.err);
    assert_eq!(instances(&bench, "log"), 60);
    assert!(bench.read("out/points.csv").starts_with(&first));
    counted(&bench, "out", "log", &["--budget", "40", "--resume"]).is_mistake(&["budget", "60"]);
    // A point of the budget can be run again.
    let replayed = bench.run(&["replay", "out", "33"]);
    assert!(replayed.code < 2 && !replayed.out.contains("warning"), "{}{}", replayed.out, replayed.err);
}

#[test]
fn a_rare_share_keeps_its_budget() {
    let bench = lag();
    bench.write("study.toml", &LAG.replace("tolerance = 0.02", "tolerance = 0.15"));
    let said = counted(&bench, "out", "log", &["--rare", "not-conforming", "--budget", "24"]);
    let ran = instances(&bench, "log");
    assert!(said.out.contains(&format!("\n{ran} runs")) && ran <= 24, "{ran} {}{}", said.out, said.err);
    let again = counted(&bench, "out", "log", &["--rare", "not-conforming", "--budget", "24", "--resume"]);
    assert_eq!((again.code, again.out), (said.code, said.out));
}

#[test]
fn a_killed_budget_goes_on_to_the_same_answer() {
    let bench = lag();
    assert!([0, 1, 3].contains(&counted(&bench, "whole", "log", &["--budget", "40"]).code));
    let whole = files(&bench, "whole");
    for patience in [150, 400, 700] {
        let arguments = ["verify", "study.toml", "--jobs", "1", "--output", "out", "--budget", "40", "--resume"];
        let mut command = bench.command(&arguments);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        sleep(Duration::from_millis(patience));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let said = counted(&bench, "out", "log", &["--budget", "40", "--resume"]);
    assert!([0, 1, 3].contains(&said.code), "{}", said.err);
    assert!(files(&bench, "out") == whole);
}

/// What the lag's end and size tell of its rate and length.
const FIT: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[identify.free."lag.rate"]
min = 0.5
max = 2
[identify.free."lag.length"]
min = 0.01
max = 0.05
unit = "mm"
[identify.measured.Y]
variable = "lag.y"
value = 0.86
accuracy = 0.002
[identify.measured.L]
variable = "lag.micrometres"
value = 17.2
accuracy = 0.4
"#;

#[test]
fn identify_counts_no_more_runs_and_goes_on_where_it_was_killed() {
    let bench = lag();
    bench.write("study.toml", FIT);
    let command = |folder: &str| {
        let arguments = ["identify", "study.toml", "--budget", "40", "--jobs", "1", "--resume", "--output", folder];
        let mut command = bench.command(&arguments);
        command.env("LAG_INSTANCES", bench.path(&format!("{folder}-log")));
        command
    };
    let said: Said = command("whole").output().unwrap().into();
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("By surrogate from"), "{}", said.out);
    assert!(instances(&bench, "whole-log") <= 40, "{}", instances(&bench, "whole-log"));
    for patience in [150, 400, 700] {
        let mut child = command("out").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        sleep(Duration::from_millis(patience));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let said: Said = command("out").output().unwrap().into();
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(bench.read("out/identification.json") == bench.read("whole/identification.json"));
}

/// The lag with uncertain readings, which can be identified.
fn measured_lag() -> Bench {
    let bench = lag();
    let normal = LAG.replace("lognormal", "normal").replace("tolerance = 4", "tolerance = 4\nuncertainty = 0.8");
    bench.write("study.toml", &normal.replace("tolerance = 0.02", "tolerance = 0.02\nuncertainty = 0.004"));
    bench
}

/// Any command on the study, whose FMU counts its own instances in a file.
fn asked(bench: &Bench, arguments: &[&str]) -> Said {
    let folder = ["study.toml", "--output", "out", "--jobs", "2"];
    let mut command = bench.command(&[&arguments[..1], &folder, &arguments[1..]].concat());
    command.env("LAG_INSTANCES", bench.path("log")).output().unwrap().into()
}

/// What the commands in a folder say that they have run.
fn accounts(bench: &Bench, folders: &[&str]) -> u64 {
    let own = |folder: &&str| {
        let text = bench.read(&format!("out/{folder}/request.json"));
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["account"]["own"].as_u64().unwrap()
    };
    folders.iter().map(own).sum()
}

/// A dear FMU's whole study in one folder: runs of one command serve the others, and count for all.
#[test]
fn a_whole_study_takes_a_hundred_runs() {
    let bench = measured_lag();
    let ask = |arguments: &[&str]| asked(&bench, arguments);
    assert!(ask(&["verify", "--budget", "50"]).code < 2);
    let said = ask(&["sensitivity", "--from", "out"]);
    assert_eq!((said.code, instances(&bench, "log")), (0, 50), "{}", said.err);
    let said = ask(&["identify", "--budget", "80"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("46 of them the study's points"), "{}", said.out);
    assert!(instances(&bench, "log") <= 80, "{}", instances(&bench, "log"));
    // The rate's end value is 1 - exp(-2 rate), known to 0.002 beside a prior of 0.1.
    let result: serde_json::Value = serde_json::from_str(&bench.read("out/identification.json")).unwrap();
    let optimum = &result["free"];
    assert!((optimum[0]["value"].as_f64().unwrap() - 0.983).abs() < 0.01, "{optimum}");
    let before = instances(&bench, "log");
    assert_eq!(accounts(&bench, &["", "identify"]), before as u64);
    let again = ask(&["identify", "--budget", "80", "--resume"]);
    assert_eq!(again.out, said.out);
    // Half the steps is in no journal, and the first run of a command is run twice.
    assert_eq!(instances(&bench, "log"), before + 2);
    let said = ask(&["robustness", "--from", "out", "--budget", &(before + 8).to_string()]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    ask(&["tolerances", "--from", "out", "--budget", "50"]).is_mistake(&[
        "--budget",
        "50 runs",
        "other commands have made",
    ]);
    let said = ask(&["tolerances", "--from", "out", "--budget", &(before + 20).to_string()]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(
        said.out.contains("which a surrogate of 46 runs judged") && said.out.contains("of 10 fresh runs"),
        "{}",
        said.out
    );
    assert_eq!(instances(&bench, "log"), before + 2 + 20);
    assert_eq!(accounts(&bench, &["", "identify", "robustness", "tolerances"]), before as u64 + 20);
    let page = bench.read("out/report.html");
    assert!(page.contains("identify") && page.contains("obustness"));
    // A larger budget goes on behind the points, and leaves to the others what they have run.
    let said = ask(&["verify", "--budget", "120", "--resume"]);
    assert!(said.code < 2, "{}", said.err);
    assert_eq!(instances(&bench, "log"), 2 + 120);
}

/// Where one command has spent all, the others answer without a run.
#[test]
fn runs_are_those_of_all_commands() {
    let bench = measured_lag();
    assert!(asked(&bench, &["verify", "--budget", "60"]).code < 2);
    assert_eq!(asked(&bench, &["sensitivity", "--budget", "60"]).code, 0);
    assert_eq!(instances(&bench, "log"), 60);
    let said = asked(&bench, &["identify", "--budget", "60"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("The budget has no run left: neither the optimum was run"), "{}", said.out);
    let said = asked(&bench, &["robustness", "--from", "out", "--budget", "60"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let note = "no run left to confirm the box; other commands have made 60 runs in this folder";
    assert!(said.out.contains(note), "{}", said.out);
    asked(&bench, &["tolerances", "--from", "out", "--budget", "60"]).is_mistake(&["60 runs: give 63 or more"]);
    asked(&bench, &["verify", "--rare", "--budget", "60"]).is_mistake(&["give 80 or more", "have made 60 runs"]);
    assert_eq!(instances(&bench, "log"), 60);
    // Where the points are made anew, so is the account, and what others made of the old points does not count.
    bench.write("study.toml", &bench.read("study.toml").replace("tolerance = 4", "tolerance = 5"));
    let stale = ["robustness", "--from", "out", "--budget", "160"];
    asked(&bench, &stale).is_mistake(&["verify it again"]);
    assert!(asked(&bench, &["verify", "--budget", "40", "--force"]).code < 2);
    assert_eq!(instances(&bench, "log"), 100);
    let said = asked(&bench, &["identify", "--budget", "70", "--force"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!((101..=130).contains(&instances(&bench, "log")), "{}", instances(&bench, "log"));
    // A file that is spoilt is named, with a remedy.
    bench.write("out/identify/request.json", "{");
    asked(&bench, &stale).is_mistake(&["identify/request.json", "remove that file, or choose another --output"]);
}

/// For what was killed its runs are held, and what failed before any run holds none.
#[test]
fn runs_are_held_for_what_is_to_be_resumed() {
    let bench = measured_lag();
    assert_eq!(asked(&bench, &["verify", "--points", "5"]).code, 3);
    asked(&bench, &["robustness", "--from", "out", "--budget", "60"]).is_mistake(&["too few"]);
    assert!(asked(&bench, &["verify", "--budget", "40", "--force"]).code < 2);
    let before = instances(&bench, "log");
    let arguments = ["identify", "study.toml", "--output", "out", "--jobs", "1", "--budget", "80"];
    let mut command = bench.command(&arguments);
    command.env("LAG_INSTANCES", bench.path("log")).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    while instances(&bench, "log") == before {
        sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let held = "made 80 runs in this folder, or hold them: `identify` has not ended, which --resume does";
    asked(&bench, &["tolerances", "--from", "out", "--budget", "80"]).is_mistake(&["80 runs: give 83 or more", held]);
    assert_eq!(asked(&bench, &["identify", "--budget", "80", "--resume"]).code, 0);
    assert_eq!(asked(&bench, &["tolerances", "--from", "out", "--budget", "80"]).code, 0);
}

/// In `identify`, too, each case of a study is a run.
#[test]
fn cases_that_are_identified_count() {
    let bench = lag();
    let case = |name: &str, stop: f64, value: f64| {
        format!(
            "[[cases]]\nname = \"{name}\"\nsimulation = {{ stop = {stop} }}\n\
             criteria.Y = {{ variable = \"lag.y\", nominal = {value}, tolerance = 0.04, uncertainty = 0.01 }}\n"
        )
    };
    let head = &LAG[..LAG.find("[parameters.\"lag.length\"]").unwrap()];
    bench.write("study.toml", &[head, &case("short", 1.0, 0.63), &case("long", 2.0, 0.86)].concat());
    asked(&bench, &["identify", "--budget", "40"])
        .is_mistake(&["40 runs: give 46 or more for these unknowns of 2 cases"]);
    let said = asked(&bench, &["identify", "--budget", "60"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let ran = instances(&bench, "log");
    assert!(ran <= 60 && accounts(&bench, &["identify"]) == ran as u64, "{ran}");
}

/// P(-1 <= x1 + 2 x2 + 3 x3 <= 4) of normal numbers, whose sum has the variance 14.
#[test]
fn the_interval_holds_the_exact_share_and_decides() {
    let bench = Bench::functions();
    let criterion =
        "[criteria.C]\nvariable = \"linear\"\nnominal = 1.5\ntolerance = 2.5\n[verdict]\nshare = \"40 %\"\n";
    bench.write("study.toml", &functions(criterion));
    let junit = ["verify", "study.toml", "--output", "out", "--budget", "60", "--junit", "out.xml"];
    let said = bench.run(&junit);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let summary = bench.summary("out");
    let exact = 0.462_841;
    let interval = summary["verified_interval"].as_array().unwrap();
    let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
    assert!(low < exact && exact < high && high - low < 0.05, "{low} {high}");
    assert_eq!(summary["surrogate"]["runs"], 60);
    assert_eq!(summary["surrogate"]["refuted"], false);
    assert!(summary["surrogate"]["criteria"]["C"]["error"].as_f64().unwrap() < 0.01);
    assert!(summary["verdict_words"].as_str().unwrap().contains("by surrogate"), "{}", summary["verdict_words"]);
    assert!(bench.read("out.xml").contains("failures=\"0\""));
    // What comes next is as dear.
    bench.write("high.toml", &functions(&criterion.replace("40 %", "90 %")));
    let said = bench.run(&["verify", "high.toml", "--output", "high", "--budget", "60"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let words: Vec<&str> = said.out.split_whitespace().collect();
    assert!(words.join(" ").contains("identify high.toml --output high --budget 90`"), "{}", said.out);
    // It ends when that is decided.
    let said = bench.run(&["verify", "study.toml", "--output", "soon", "--budget", "100", "--until", "verdict"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(bench.summary("soon")["points"].as_u64().unwrap() <= 72);
    // The same points tell the indices: 1, 4 and 9 of 14.
    let said = bench.run(&["sensitivity", "study.toml", "--from", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let told: serde_json::Value = serde_json::from_str(&bench.read("out/sensitivity.json")).unwrap();
    for (k, part) in [1.0, 4.0, 9.0].iter().enumerate() {
        for which in ["first", "total"] {
            let index = &told["outputs"][0]["sobol"][which][k];
            let [value, low, high] = ["value", "low", "high"].map(|key| index[key].as_f64().unwrap());
            assert!((value - part / 14.0).abs() < 0.02 && low < part / 14.0 && part / 14.0 < high, "{index}");
        }
    }
    assert_eq!(told["outputs"][1]["name"], "verified");
}

/// Of the stripes, whose runs fail in no place that a few runs could tell, those below 0 have a value, and 40 % of those above.
#[test]
fn what_no_surrogate_follows_is_counted() {
    let bench = Bench::functions();
    let criterion = "[criteria.C]\nvariable = \"stripes\"\nnominal = 0\ntolerance = 9\n";
    bench.write("study.toml", &functions(criterion));
    let said = bench.run(&["verify", "study.toml", "--output", "out", "--budget", "60"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("Counted instead"), "{}", said.out);
    let surrogate = &bench.summary("out")["surrogate"];
    assert_eq!(surrogate["refuted"], true);
    let [low, high] = [0, 1].map(|k| surrogate["interval"][k].as_f64().unwrap());
    assert!(low < 0.7 && 0.7 < high && high - low > 0.2, "{surrogate}");
    bench.run(&["sensitivity", "study.toml", "--from", "out"]);
    let told = bench.read("out/sensitivity.json");
    assert!(told.contains("--base 256") && told.contains("as the others continue them into where runs fail"), "{told}");
}

#[test]
fn budgets_that_cannot_be_kept_are_refused() {
    let bench = lag();
    counted(&bench, "out", "log", &["--budget", "5"]).is_mistake(&["budget", "20 to 1000"]);
    bench.write(
        "study.toml",
        &LAG.replace("share = \"40 %\"", "share = \"40 %\"\nrisk = \"5 %\"")
            .replace("tolerance = 0.02\n", "tolerance = 0.02\nuncertainty = 0.002\n")
            .replace("tolerance = 4\n", "tolerance = 4\nuncertainty = 0.4\n"),
    );
    counted(&bench, "out", "log", &["--budget", "40"]).is_mistake(&["guard-band"]);
    assert_eq!(instances(&bench, "log"), 0);
    bench.write("study.toml", LAG);
    let said = counted(&bench, "out", "log", &["--budget", "40", "--dry-run"]);
    assert!(said.out.contains("40 runs: 36 points, and 4 runs beside them"), "{}", said.out);
}
