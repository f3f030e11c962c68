//! Tolerance and measurement uncertainty through the command line: verdicts, risks, exit codes.

use std::fmt::Write;

use crate::support::Bench;
use serde_json::Value;
use statrs::distribution::{ContinuousCDF, Normal};

const STUDY: &str = r#"
fmu = "none.fmu"
[parameters.p]
distribution = "uniform"
min = 0
max = 1
[criteria.T_bearing]
variable = "T"
nominal = 82
tolerance = "0.75 %"
uncertainty = "0.615 degC"
unit = "degC"
[criteria.F_N]
variable = "F"
nominal = 750
tolerance = "7 %"
uncertainty = "7 %"
unit = "N"
"#;

/// Judges points at the quantiles of the two populations of `studies/paper-table3.toml`.
fn judge(study: &str, rows: u32) -> (i32, Value) {
    let bench = Bench::empty();
    let temperature = Normal::new(81.486_108, 0.345_215).unwrap();
    let load = Normal::new(769.503_815, 89.266_864).unwrap();
    let mut table = String::from("point,T,F\n");
    for i in 0..rows {
        let u = (f64::from(i) + 0.5) / f64::from(rows);
        // The loads in an order of their own, as good as independent of the temperatures.
        let v = (f64::from(i) * 0.618_033_988_749_894_9 + 0.5 / f64::from(rows)).fract();
        let (t, f) = (temperature.inverse_cdf(u), load.inverse_cdf(v));
        writeln!(table, "{},{t},{f}", i + 1).unwrap();
    }
    bench.write("study.toml", study);
    bench.write("table.csv", &table);
    let said = bench.run(&["judge", "study.toml", "table.csv", "--output", "out"]);
    assert!(said.code != 2, "{}", said.err);
    (said.code, bench.summary("out"))
}

fn numbers(rows: u32) {
    let precise = STUDY
        .replace("\"0.615 degC\"", "\"0.15375 degC\"")
        .replace("uncertainty = \"7 %\"", "uncertainty = \"13.125 N\"");
    for (study, expected) in
        [(STUDY, [[0.1338, 0.0984], [0.0837, 0.0685]]), (&precise, [[0.0351, 0.0322], [0.0199, 0.0188]])]
    {
        let (code, summary) = judge(study, rows);
        assert_eq!(code, 0);
        for (name, [consumer, producer]) in ["T_bearing", "F_N"].into_iter().zip(expected) {
            let risk = &summary["criteria"][name]["risk"];
            let found = |key: &str| risk[key].as_f64().unwrap();
            assert!((found("consumer") - consumer).abs() < 1e-4, "{name}: {risk}");
            assert!((found("producer") - producer).abs() < 1e-4, "{name}: {risk}");
        }
        let expected = summary["expected_verified"].as_f64().unwrap() / f64::from(rows);
        let joint = summary["risk"]["conformance_probability"].as_f64().unwrap();
        assert!((expected - joint).abs() < 1e-12);
    }
}

#[test]
fn risks_of_a_table_at_the_quantiles() {
    // A number of Fibonacci: so many multiples of the golden ratio are as even as can be.
    numbers(17_711);
}

#[test]
#[ignore = "takes a minute; run by scripts/test --long"]
fn risks_of_a_million_rows_at_the_quantiles() {
    numbers(1_000_000);
}

#[test]
fn nothing_is_stated_without_uncertainties() {
    let study = STUDY.replacen("uncertainty = \"0.615 degC\"\n", "", 1);
    let (code, summary) = judge(&study, 200);
    assert_eq!(code, 0);
    assert_eq!(summary["verdict"], "verified");
    assert_eq!(summary["rule"], "one point");
    assert!(summary["risk"].is_null() && summary["expected_verified"].is_null());
    assert!(summary["criteria"]["T_bearing"].get("risk").is_none());
    assert!(summary["criteria"]["F_N"]["risk"]["consumer"].is_number());
    assert_eq!(summary["accepted"], summary["verified"]);
}

/// About 29 % of the points meet both criteria.
#[test]
fn verdicts_have_their_exit_codes() {
    for (share, code, verdict) in [("10 %", 0, "verified"), ("60 %", 1, "not verified"), ("28 %", 3, "inconclusive")] {
        let (found, summary) = judge(&format!("{STUDY}[verdict]\nshare = \"{share}\"\n"), 200);
        assert_eq!((found, summary["verdict"].as_str()), (code, Some(verdict)), "{summary}");
        assert_eq!(summary["rule"], "share");
    }
}

#[test]
fn the_risk_sets_the_guard_band() {
    let guarded = format!("{STUDY}[verdict]\nshare = \"1 %\"\nrisk = \"30 %\"\n");
    let (_, summary) = judge(&guarded, 2000);
    let band = summary["guard_band"].as_f64().unwrap();
    let share = summary["risk"]["not_conforming_given_accepted"].as_f64().unwrap();
    assert!(band > 0.0 && share <= 0.3 && share > 0.27, "{band} {share}");
    assert!(summary["accepted"].as_u64() < summary["verified"].as_u64());
    let [narrowest, widest] = [0, 1].map(|k| summary["required"]["guard_bands"][k].as_f64().unwrap());
    assert!(narrowest < band && band == widest, "{narrowest} {band} {widest}");
    let given = guarded.replace("risk = \"30 %\"", &format!("guard-band = {band}"));
    assert_eq!(judge(&given, 2000).1["accepted"], summary["accepted"]);
}

/// Of this study about 40 % of the space is accepted: 1 - exp(-2 rate) between 0.817 and 0.903.
const LAG: &str = r#"
title = "Lag & more"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.01
[design]
method = "monte-carlo"
points = 300
seed = 3
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.3
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = "5 %"
uncertainty = "2 %"
[verdict]
share = "5 %"
[dossier]
responsible = "A. Engineer <test>"
rig = "Rig 2"
"#;

fn verify(bench: &Bench, study: &str, options: &[&str]) -> (crate::support::Said, Value) {
    bench.write("study.toml", study);
    let _ = std::fs::remove_dir_all(bench.path("out"));
    let command = ["verify", "study.toml", "--verbose", "--output", "out"];
    let said = bench.run(&[&command[..], options].concat());
    assert!(said.code != 2, "{}", said.err);
    (said, bench.summary("out"))
}

#[test]
fn a_study_ends_when_its_verdict_is_known() {
    let bench = Bench::new().in_process();
    let waiting = ["--until", "verdict", "--points", "3000"];
    for (share, code) in [("5 %", 0), ("90 %", 1)] {
        let study = LAG.replace("share = \"5 %\"", &format!("share = \"{share}\""));
        let (said, summary) = verify(&bench, &study, &waiting);
        assert_eq!(said.code, code, "{}", said.out);
        assert!(summary["points"].as_u64().unwrap() < 100, "{summary}");
        let method = summary["required"]["method"].as_str().unwrap();
        assert!(method.contains("confidence sequence"), "{method}");
        assert!(summary["required"]["points_needed"].is_null());
    }
    let nets = LAG.replace("monte-carlo\"", "sobol\"\nreplicates = 16");
    bench.write("nets.toml", &nets);
    bench.run(&["verify", "nets.toml", "--until", "verdict"]).is_mistake(&["until", "monte-carlo"]);
    let near = LAG.replace("\"5 %\"\n[dossier]", "\"40 %\"\n[dossier]");
    let (said, summary) = verify(&bench, &near, &["--until", "verdict", "--points", "60"]);
    assert_eq!((said.code, summary["points"].as_u64()), (3, Some(60)), "{}", said.out);
    assert!(summary["required"]["points_needed"].as_u64().unwrap() > 60);
    assert!(said.out.contains("points decide, computed anew, or"), "{}", said.out);
}

#[test]
fn a_verdict_cannot_be_waited_for_where_nothing_tells_how_points_depend() {
    let bench = Bench::new().in_process();
    for (from, to, words) in [
        ("monte-carlo", "sobol", ["until", "use method = \"monte-carlo\""]),
        ("monte-carlo", "latin-hypercube", ["until", "this design needs all its points"]),
        ("[verdict]\nshare = \"5 %\"\n", "", ["until", "add [verdict]"]),
        ("share = \"5 %\"", "share = 0.05\nrisk = 0.1", ["until", "guard-band"]),
    ] {
        bench.write("study.toml", &LAG.replace(from, to));
        bench.run(&["verify", "study.toml", "--until", "verdict"]).is_mistake(&words);
    }
}

#[test]
fn shards_have_no_verdict_and_their_union_has() {
    let bench = Bench::new().in_process();
    let study = LAG.replace("\"5 %\"\n[dossier]", "\"90 %\"\n[dossier]");
    bench.write("study.toml", &study);
    for shard in ["1/2", "2/2"] {
        let folder = shard.replace('/', "-");
        let said = bench.run(&["verify", "study.toml", "--shard", shard, "--output", &folder]);
        assert_eq!(said.code, 0, "{}", said.err);
    }
    let said = bench.run(&["merge", "1-2", "2-2", "--output", "out"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert_eq!(bench.summary("out")["verdict"], "not verified");
}

#[test]
fn the_dossier_is_in_summary_and_page() {
    let bench = Bench::new().in_process();
    let (_, summary) = verify(&bench, LAG, &[]);
    assert_eq!(summary["dossier"]["rig"], "Rig 2");
    let date = summary["run"]["date"].as_str().unwrap();
    assert!(date.ends_with('Z') && date.len() == 20, "{date}");
    let page = bench.read("out/report.html");
    for part in ["A. Engineer &lt;test&gt;", "Rig 2", date, "mean = 1"] {
        assert!(page.contains(part), "no {part}");
    }
}

#[test]
fn the_page_says_what_accepting_risks() {
    let bench = Bench::new().in_process();
    let (said, _) = verify(&bench, LAG, &[]);
    let page = bench.read("out/report.html");
    for part in [
        "accepted points",
        "are expected to be outside of a tolerance of the true values",
        "The risk of accepting",
        "Conforms %",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    let wrong = "are expected to be outside of a tolerance of the true values";
    assert!(said.out.contains(wrong), "{}", said.out);
    let unknown = LAG.replace("uncertainty = \"2 %\"\n", "");
    let (said, _) = verify(&bench, &unknown, &[]);
    let page = bench.read("out/report.html");
    assert!(page.contains("no uncertainty of Y, and nothing is assumed"));
    assert!(!page.contains("The risk of accepting") && !page.contains("Conforms %"));
    assert!(said.out.contains("no uncertainty of Y"), "{}", said.out);
}

/// The column `accepted` of a folder's points, with the values of the criterion.
fn accepted(bench: &Bench, folder: &str) -> Vec<(f64, bool)> {
    let table = bench.read(&format!("{folder}/points.csv"));
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let header = reader.headers().unwrap().clone();
    let place = |name: &str| header.iter().position(|column| column == name).unwrap();
    let (value, accepted) = (place("Y"), place("accepted"));
    assert_eq!(place("verified") + 1, accepted);
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        (row[value].parse().unwrap(), row[accepted].parse().unwrap())
    });
    rows.collect()
}

/// The guarded decision on every point stands in the table: those are accepted that lie within the tolerance less the band,
/// as many as the summary says, whether the band is given or found, and by every command alike.
#[test]
fn points_tell_which_of_them_a_guard_band_accepts() {
    let bench = Bench::new().in_process();
    let (_, _) = verify(&bench, LAG, &[]);
    assert!(!bench.read("out/points.csv").starts_with("point,lag.rate,Y,Y.ok,verified,accepted"));
    for rule in ["risk = \"3 %\"", "guard-band = 0.8"] {
        let study = LAG.replace("share = \"5 %\"", &format!("share = \"5 %\"\n{rule}"));
        let (_, summary) = verify(&bench, &study, &[]);
        let band = summary["guard_band"].as_f64().unwrap();
        let rows = accepted(&bench, "out");
        assert!(band > 0.0 && rows.len() == 300, "{band}");
        let limit = 0.043 - band * 0.0172;
        for (value, accepted) in &rows {
            assert_eq!(*accepted, (value - 0.86).abs() <= limit, "{value}");
        }
        let count = rows.iter().filter(|(_, accepted)| *accepted).count();
        assert_eq!(summary["accepted"], count);
        assert!(count > 20 && summary["verified"].as_u64().unwrap() > count as u64);

        let said = bench.run(&["judge", "study.toml", "out/points.csv", "--output", "again"]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert_eq!(accepted_only(&accepted(&bench, "again")), accepted_only(&rows));
        for shard in ["1/2", "2/2"] {
            let folder = shard.replace('/', "-");
            bench.run(&["verify", "study.toml", "--shard", shard, "--output", &folder]);
        }
        bench.run(&["merge", "1-2", "2-2", "--output", "joined"]);
        assert_eq!(bench.read("joined/points.csv"), bench.read("out/points.csv"));
        let page = bench.run(&["report", "out"]);
        assert_eq!(page.code, 0, "{}", page.err);
        for (within, code) in [(true, 0), (false, 1)] {
            let outside = |(value, accepted): &(f64, bool)| *accepted == within && (value - 0.86).abs() <= 0.043;
            let point = rows.iter().position(outside).unwrap() + 1;
            let said = bench.run(&["replay", "out", &point.to_string()]);
            assert_eq!(said.code, code, "{}{}", said.out, said.err);
            assert_eq!(said.out.contains("not accepted, with the guard band"), !within);
        }
        for folder in ["1-2", "2-2", "joined", "again"] {
            std::fs::remove_dir_all(bench.path(folder)).unwrap();
        }
    }
}

fn accepted_only(rows: &[(f64, bool)]) -> Vec<bool> {
    rows.iter().map(|(_, accepted)| *accepted).collect()
}

/// The verdict of a folder with so many points, which goes on from what is there.
fn resumed(bench: &Bench, options: &[&str]) -> (crate::support::Said, Value) {
    let call = ["verify", "study.toml", "--verbose", "--output", "out", "--resume"];
    let said = bench.run(&[&call[..], options].concat());
    assert!(said.code != 2, "{}", said.err);
    (said, bench.summary("out"))
}

#[test]
fn a_study_that_is_looked_at_again_has_an_interval_for_that() {
    let bench = Bench::new().in_process();
    let near = LAG.replace("\"5 %\"\n[dossier]", "\"40 %\"\n[dossier]");
    let interval = |summary: &Value| {
        let ends = &summary["required"]["interval"];
        [0, 1].map(|k| ends[k].as_f64().unwrap())
    };
    let (said, first) = verify(&bench, &near, &["--points", "100"]);
    assert_eq!(first["required"]["method"], "Clopper and Pearson's");
    assert_eq!(first["required"]["looks"], 1);
    assert!(!said.out.contains("The study was looked at"), "{}", said.out);
    // The same points once more are no further look.
    let (_, again) = resumed(&bench, &["--points", "100"]);
    assert_eq!(again["required"], first["required"]);
    let (said, second) = resumed(&bench, &["--points", "200"]);
    let method = second["required"]["method"].as_str().unwrap();
    assert!(method.contains("confidence sequence"), "{method}");
    assert_eq!(second["required"]["looks"], 2);
    assert!(said.out.contains("looked at 2 times"), "{}", said.out);
    // Who asks for as many points at once looks once.
    let fresh = bench.run(&["verify", "study.toml", "--output", "once", "--points", "200"]);
    assert!(fresh.code != 2, "{}", fresh.err);
    let (once, twice) = (interval(&bench.summary("once")), interval(&second));
    assert!(twice[0] < once[0] && once[1] < twice[1], "{once:?} {twice:?}");
    // Beginning anew with the same seed shows the same points.
    let anew = bench.run(&["verify", "study.toml", "--output", "out", "--points", "150"]);
    assert!(anew.code != 2, "{}", anew.err);
    assert_eq!(bench.summary("out")["required"]["looks"], 3);
    // Another seed does not.
    let seed = ["verify", "study.toml", "--output", "out", "--seed", "8"];
    bench.run(&seed);
    assert_eq!(bench.summary("out")["required"]["looks"], 1);
}

#[test]
fn a_study_that_was_waited_for_stays_one() {
    let bench = Bench::new().in_process();
    let near = LAG.replace("\"5 %\"\n[dossier]", "\"40 %\"\n[dossier]");
    let (_, waited) = verify(&bench, &near, &["--until", "verdict", "--points", "60"]);
    let (_, resumed) = resumed(&bench, &["--points", "60"]);
    assert_eq!(resumed["required"], waited["required"]);
    bench.run(&["report", "out"]);
    let page = std::fs::read_to_string(bench.path("out/report.html")).unwrap();
    assert!(page.contains(" in 40 % of the sampled space or more?"));
}

#[test]
fn shards_that_grow_and_are_joined_again_are_looked_at_again() {
    let bench = Bench::new().in_process();
    let near = LAG.replace("\"5 %\"\n[dossier]", "\"40 %\"\n[dossier]");
    bench.write("study.toml", &near);
    for (points, output, looks) in [("60", "first", 1), ("120", "second", 2)] {
        for shard in ["1/2", "2/2"] {
            let folder = shard.replace('/', "-");
            let call = ["verify", "study.toml", "--shard", shard, "--output", &folder];
            let said = bench.run(&[&call[..], &["--points", points, "--resume"]].concat());
            assert_eq!(said.code, 0, "{}", said.err);
        }
        let said = bench.run(&["merge", "1-2", "2-2", "--output", output]);
        assert_eq!(said.code, 3, "{}", said.err);
        assert_eq!(bench.summary(output)["required"]["looks"], looks);
    }
}

/// Half of a net is in the tolerance whatever the true share: its points are no sample.
#[test]
fn one_net_has_neither_a_verdict_by_share_nor_intervals() {
    let bench = Bench::new().in_process();
    let net = LAG.replace("method = \"monte-carlo\"\npoints = 300\nseed = 3", "method = \"sobol\"\npoints = 8");
    bench.write("study.toml", &net);
    let said = bench.run(&["verify", "study.toml", "--output", "net"]);
    assert_eq!(said.code, 3, "{}", said.err);
    let (before, after) = net.split_once("[verdict]\nshare = \"5 %\"\n").unwrap();
    let (said, summary) = verify(&bench, &format!("{before}{after}"), &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(!said.out.contains("95 % interval"), "{}", said.out);
    assert!(!said.out.contains("were repeated"), "{}", said.out);
    assert!(summary["verified_interval"].is_null());
    assert!(summary["criteria"]["Y"]["interval"].is_null());
    assert!(summary["risk"]["intervals"].is_null());
    assert!(summary["risk"]["consumer"].as_f64().unwrap() > 0.0);
    let page = std::fs::read_to_string(bench.path("out/report.html")).unwrap();
    assert!(page.contains(" of 8 points (") && !page.contains(" %, 95 % interval "));
}

/// The rig is so bad that no point conforms with 95 %: that contradicts no model.
#[test]
fn a_measurement_that_cannot_decide_leaves_the_model_open() {
    let bad = format!("{STUDY}[verdict]\nshare = \"5 %\"\nrisk = \"0.1 %\"\n");
    let (code, summary) = judge(&bad, 200);
    assert_eq!((code, summary["verdict"].as_str()), (3, Some("inconclusive")), "{summary}");
    let words = summary["verdict_words"].as_str().unwrap();
    assert!(words.contains("the measurement cannot decide"), "{words}");
    assert!(summary["required"]["interval"].is_null());
    // A guard band as wide as a tolerance is warned of at its line.
    let bench = Bench::empty();
    let wide = format!("{STUDY}[verdict]\nshare = \"5 %\"\nguard-band = 1.1\n");
    bench.write("study.toml", &wide);
    bench.write("table.csv", &format!("T,F\n{}", "82,750\n".repeat(9)));
    let said = bench.run(&["judge", "study.toml", "table.csv"]);
    assert_eq!(said.code, 3, "{}", said.out);
    assert!(said.err.contains("study.toml:21:") && said.err.contains("leaves nothing"), "{}", said.err);
    assert!(said.out.contains("as wide as a tolerance"), "{}", said.out);
    assert!(said.out.contains("within all tolerances                      9"), "{}", said.out);
}

#[test]
fn every_command_with_a_verdict_tells_its_exit_codes() {
    let bench = Bench::new().in_process();
    let words = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let all = words(bench.run(&["--help"]).out);
    for words in ["1 not verified", "3 inconclusive", "130 interrupted", "[verdict]"] {
        assert!(all.contains(words), "{all}");
    }
    for command in ["verify", "judge", "merge"] {
        let help = words(bench.run(&[command, "--help"]).out);
        for words in ["[verdict]", "3 inconclusive", "Example: "] {
            assert!(help.contains(words), "{help}");
        }
    }
}

/// Under a guard band the page shows what was decided: the accepted points, not all within tolerance.
#[test]
fn the_page_shows_the_share_that_was_decided() {
    let bench = Bench::new().in_process();
    let (_, summary) = verify(&bench, LAG, &[]);
    let page = bench.read("out/report.html");
    assert!(page.contains("\"guarded\":false") && !page.contains("less the guard bands"));
    let [accepted, verified] = ["accepted", "verified"].map(|key| summary[key].as_u64().unwrap());
    assert_eq!(accepted, verified);
    let guarded = LAG.replace("[verdict]", "[verdict]\nguard-band = 0.5");
    let (_, summary) = verify(&bench, &guarded, &[]);
    let [accepted, verified] = ["accepted", "verified"].map(|key| summary[key].as_u64().unwrap());
    assert!(0 < accepted && accepted < verified);
    let page = bench.read("out/report.html");
    let headline = format!("Yes: at {accepted} of {} points, which is ", summary["points"]);
    let row = format!("within all tolerances</th>|<strong>{verified}</strong>");
    for part in std::iter::once(headline.as_str()).chain(row.split('|')) {
        assert!(page.contains(part), "no {part}");
    }
    assert!(page.contains("\"guarded\":true") && page.contains("\"drawn_in\":["));
}

/// Many criteria that all still move, long names and a path that takes two lines: the answer fits a terminal, --verbose says all.
#[test]
fn the_answer_fits_a_terminal() {
    let bench = Bench::new();
    let (head, criterion) = LAG.split_once("[criteria.Y]").unwrap();
    let (criterion, _) = criterion.split_once("[verdict]").unwrap();
    let names = |k: u32| format!("[criteria.a-criterion-with-a-name-of-some-length-{k}]{criterion}");
    let all: String = (0..12).map(names).collect();
    bench.write("study.toml", &format!("{head}{all}"));
    let folder = format!("out-{}", "x".repeat(90));
    let command = ["verify", "study.toml", "--points", "40", "--output", &folder];
    let said = bench.run(&command);
    assert!(said.code < 2, "{}", said.err);
    let lines = said.out.lines();
    let height: usize = lines.map(|line| line.chars().count().div_ceil(80).max(1)).sum();
    assert!(height <= 24, "{height}: {}", said.out);
    for words in ["Asked ", "Answer ", "Decides ", "Next ", " more criteria", "results in out-"] {
        assert!(said.out.contains(words), "no {words}: {}", said.out);
    }
    let long = bench.run(&[&command[..], &["--verbose", "--force"]].concat());
    assert!(long.out.lines().count() > 24 && long.out.contains("The risk of accepting"));
    // No warning is left out before advice, and what is left out is counted.
    let warnings = |text: &str| text.matches("Warning: ").count();
    assert!(warnings(&long.out) > 0 && warnings(&said.out) == warnings(&long.out));
    assert!(said.out.contains("here: --verbose tells "), "{}", said.out);
}

/// In K or degC, an amplitude or a slope is a difference: 3 degC of it are 3 K, and not 276.15 K.
#[test]
fn amplitudes_and_slopes_convert_as_differences() {
    let bench = Bench::new().in_process();
    for (statistic, stated, expected) in [
        ("amplitude", "at-most = \"3 degC\"", 3.0),
        ("slope", "at-least = \"-1 degC\"", -1.0),
        ("amplitude", "nominal = \"2 K\"\ntolerance = 3\nunit = \"degC\"", 2.0),
        ("max", "at-most = \"3 degC\"", 276.15),
    ] {
        let study = format!(
            "fmu = \"lag.fmu\"\n[design]\npoints = 2\n[parameters.\"lag.rate\"]\ndistribution = \"uniform\"\nmin = 1\nmax = 2\n\
             [criteria.T]\nvariable = \"lag.temperature\"\nstatistic = \"{statistic}\"\n{stated}\n"
        );
        bench.write("study.toml", &study);
        let said = bench.run(&["verify", "study.toml", "--output", "out", "--force"]);
        assert!(said.code < 2, "{}", said.err);
        let criterion = &bench.summary("out")["criteria"]["T"];
        let mut keys = ["nominal", "upper", "lower"].into_iter();
        let limit = keys.find_map(|key| criterion[key].as_f64()).unwrap();
        assert!((limit - expected).abs() < 1e-9, "{statistic} {stated}: {limit}");
    }
}

#[test]
fn a_gain_of_nothing_is_no_uncertainty() {
    let bench = Bench::empty();
    bench.write("table.csv", "point,T,F\n1,0,750\n");
    let zero = STUDY
        .replace("nominal = 82\ntolerance = \"0.75 %\"", "at-most = 0")
        .replace("uncertainty = \"0.615 degC\"", "gain-uncertainty = \"1 %\"");
    bench.write("study.toml", &zero);
    let said = bench.run(&["judge", "study.toml", "table.csv"]);
    said.is_mistake(&["study.toml:10:", "measured value of 0", "add `uncertainty`"]);
}

/// Conformance probabilities by scipy: the sum of a normal error of 0.25 and one of Student's with 2 degrees of freedom and the
/// scale 0.1 / sqrt(3), integrated between the tolerances.
#[test]
fn each_accepted_point_conforms_with_the_required_probability() {
    let bench = Bench::new().in_process();
    let study = "fmu = \"none.fmu\"\n[design]\nmethod = \"monte-carlo\"\npoints = 4\n[criteria.T]\nvariable = \"t\"\nnominal = 82\n\
                 tolerance = \"1 degC\"\nunit = \"degC\"\nuncertainty = \"0.5 degC\"\nnoise = \"0.1 degC\"\nrepeats = 3\n\
                 [verdict]\nshare = \"5 %\"\npoint-risk = \"5 %\"\n";
    bench.write("s.toml", study);
    bench.write("t.csv", "t\n82\n82.4\n82.6\n82.9\n");
    // 2 of 4: the interval begins at 6.8 %.
    assert_eq!(bench.run(&["judge", "s.toml", "t.csv", "--output", "out"]).code, 0);
    let text = bench.read("out/points.csv");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("point,T,T.ok,verified,accepted,conformance,status"));
    let expected = [("true", 0.995_619), ("true", 0.981_208), ("false", 0.925_928), ("false", 0.643_403)];
    for (line, (accepted, probability)) in lines.zip(expected) {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells[4], accepted, "{line}");
        assert!((cells[5].parse::<f64>().unwrap() - probability).abs() < 1e-4, "{line}");
    }
    let summary = bench.summary("out");
    assert_eq!((&summary["accepted"], &summary["point_risk"]), (&2.into(), &0.05.into()));
}
