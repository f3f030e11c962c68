//! What strangers wrote, in an FMU or a table, neither steers a terminal nor takes time or memory without end.

use crate::support::{Bench, model};

/// Clears a terminal and turns the text after it around.
const STEER: &str = "\u{9b}2J\u{202e}";
const SHOWN: &str = r"\u009b2J\u202e";

const STUDY: &str = r#"fmu = "lag.fmu"
[design]
points = 4
[parameters."lag.rate\u009b2J\u202e"]
distribution = "uniform"
min = 1
max = 2
[fixed]
"lag.fault" = "Fail"
[criteria.Y]
variable = "lag.y\u009b2J\u202e"
nominal = 0.86
tolerance = 0.5
"#;

/// An FMU whose names, description and log messages steer the terminal.
fn steering() -> Bench {
    let bench = Bench::empty();
    let description = model("lag.rate\"", &format!("lag.rate{STEER}\""));
    let description = description.replace("lag.y\"", &format!("lag.y{STEER}\""));
    let description = description.replace("first-order", &format!("first&#10;{STEER}"));
    bench.fmu("lag.fmu", &[r#"PART="\033]0;owned\007""#], &description);
    bench.write("study.toml", STUDY);
    bench
}

fn is_hidden(c: char) -> bool {
    c.is_control() && c != '\n' || matches!(c, '\u{202a}'..='\u{202e}')
}

fn hides_nothing(what: &str, text: &str) {
    let hidden = text.chars().find(|c| is_hidden(*c));
    assert_eq!(hidden, None, "{what}: {text}");
}

#[test]
fn no_output_steers_the_terminal() {
    let bench = steering();
    for (command, shown) in [
        ("inspect lag.fmu", SHOWN),
        ("inspect lag.fmu --json", SHOWN),
        ("check lag.fmu", ""),
        ("check lag.fmu --format json", ""),
        ("check lag.fmu --format sarif", ""),
        ("init lag.fmu", SHOWN),
        ("simulate lag.fmu --stop 0.1", SHOWN),
        ("simulate lag.fmu --stop 0.1 --output run.csv", SHOWN),
        ("simulate lag.fmu --set lag.fault=Fail", r"the \u001b]0;owned\u0007 broke"),
        ("simulate lag.fmu --set lag.rat\u{9b}=1", SHOWN),
        ("verify study.toml", r"the \u001b]0;owned\u0007 broke"),
        ("verify \u{9b}.toml", r"\u009b.toml"),
        ("verify --\u{9b}", r"\u009b"),
    ] {
        let said = bench.run(&command.split(' ').collect::<Vec<_>>());
        let said = said.out + &said.err;
        hides_nothing(command, &said);
        assert!(said.contains(shown), "{command}: {said}");
    }
    // A line end in a description makes no line of its own.
    let said = bench.run(&["inspect", "lag.fmu"]).out;
    assert!(said.contains(&format!(r"A first\u000a{SHOWN} lag")), "{said}");
    let json = bench.run(&["inspect", "lag.fmu", "--json"]).out;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["variables"][3]["name"], format!("lag.y{STEER}"));
    for file in ["points.csv", "report.html", "journal.txt", "summary.json"] {
        let text = bench.read(&format!("results/study/{file}"));
        assert!(text.contains(r"the \u001b]0;owned\u0007 broke"), "{file}");
    }
    no_file_hides_anything(&bench);
}

/// Of those in the folder of results.
fn no_file_hides_anything(bench: &Bench) {
    let entries = std::fs::read_dir(bench.path("results/study")).unwrap();
    for entry in entries.map(|entry| entry.unwrap().path()) {
        if entry.is_file() {
            let text = std::fs::read_to_string(&entry).unwrap();
            hides_nothing(&entry.display().to_string(), &text);
        }
    }
}

#[test]
fn texts_of_a_csv_file_come_back() {
    let bench = steering();
    let text = format!("lag.text=\x1b[31mred{STEER}");
    let record = format!("lag.text,lag.y{STEER}");
    let run = ["simulate", "lag.fmu", "--set", &text, "--record", &record];
    let said = bench.run(&run);
    assert_eq!(said.code, 0, "{}", said.err);
    let mut lines = said.out.lines();
    assert_eq!(lines.next(), Some(&*format!("time,lag.text,lag.y{SHOWN}")));
    let row = format!(r"0,\u001b[31mred{SHOWN},0");
    assert_eq!(lines.next(), Some(&*row));
    // The columns are found by the names that the FMU gives them.
    bench.write("study.toml", &STUDY.replace("Fail", "None").replace("points = 4", "points = 12"));
    for command in ["verify", "robustness", "pareto", "sensitivity"] {
        let said = bench.run(&[command, "study.toml", "--output", "results/study"]);
        assert!(said.code < 2, "{command}: {}", said.err);
    }
    no_file_hides_anything(&bench);
    let again = ["verify", "study.toml", "--output", "again", "--points-from"];
    let again = bench.run(&[&again[..], &["results/study/points.csv"]].concat());
    assert!(again.code < 2, "{}", again.err);
    assert_eq!(bench.read("again/points.csv"), bench.read("results/study/points.csv"));
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_files() {
    let bench = Bench::new();
    let plain = STUDY.replace(r"\u009b2J\u202e", "").replace("Fail", "None");
    bench.write("study.toml", &plain);
    let pipe = bench.path("pipe").display().to_string();
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    for endless in ["/dev/zero", &pipe] {
        let refused = |command: &[&str]| {
            bench.run(command).is_mistake(&[endless, "a device or a pipe, which may have no end"]);
        };
        refused(&["verify", endless]);
        refused(&["verify", "study.toml", "--points-from", endless]);
        refused(&["judge", "study.toml", endless]);
        refused(&["simulate", "lag.fmu", "--set-from", endless]);
        refused(&["simulate", "lag.fmu", "--input", endless]);
        refused(&["inspect", endless]);
        for keys in [
            format!("fixed-from = \"{endless}\"\n{plain}"),
            format!("{plain}[inputs]\n\"drive.u\" = {{ file = \"{endless}\" }}\n"),
            plain.replace("nominal = 0.86", &format!("reference = {{ file = \"{endless}\" }}\nmetric = \"rmse\"")),
            plain.replace("\"uniform\"\nmin = 1\nmax = 2", &format!("\"sample\"\nfile = \"{endless}\"")),
        ] {
            bench.write("other.toml", &keys);
            refused(&["verify", "other.toml"]);
        }
    }
}

/// To round it would give the FMU a number that nobody recorded.
#[test]
fn a_recording_of_a_whole_number_has_no_others() {
    let bench = Bench::empty();
    let parameter = r#"valueReference="10" causality="parameter" variability="fixed""#;
    let input = r#"valueReference="10" causality="input" variability="discrete""#;
    bench.fmu("lag.fmu", &[], &model(parameter, input));
    let run = ["simulate", "lag.fmu", "--stop", "1", "--input", "count.csv"];
    bench.write("count.csv", "time,lag.count\n0,1\n0.5,2.5\n1,3\n");
    bench.run(&run).is_mistake(&["time = 0.5: 2.5 is no whole number"]);
    bench.write("count.csv", "time,lag.count\n0,1\n0.5,2.0\n1,3\n");
    let said = bench.run(&run);
    assert_eq!(said.code, 0, "{}", said.err);
}

/// A straight line over a hole is an input that nobody recorded; the corners of a line that somebody drew are no recording.
#[test]
fn a_hole_in_a_recording_is_told() {
    let bench = Bench::new();
    let even = |is_there: fn(f64) -> bool| -> Vec<f64> {
        let times = (0..=100).map(|k| 0.1 * f64::from(k));
        times.filter(|time| is_there(*time)).collect()
    };
    for (times, hole) in [
        (even(|time| !(1.05..8.95).contains(&time)), "between 1 s and 9 s, 80 % of the run"),
        (even(|time| !(1.05..1.85).contains(&time)), ""),
        (even(|_| true), ""),
        (vec![0.0, 10.0], ""),
        (vec![0.0, 0.1, 0.1, 9.0, 10.0], ""),
    ] {
        let rows = times.iter().map(|time| format!("{time:.1},1\n"));
        bench.write("drive.csv", &format!("time,drive.u\n{}", rows.collect::<String>()));
        let said = bench.run(&["simulate", "lag.fmu", "--stop", "10", "--input", "drive.csv"]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert_eq!(said.err.lines().count(), usize::from(!hole.is_empty()), "{}", said.err);
        assert!(said.err.contains(hole), "{}", said.err);
        let study = STUDY.replace(r"\u009b2J\u202e", "").replace("Fail", "None");
        let study = format!("{study}[inputs]\n\"drive.u\" = {{ file = \"drive.csv\" }}\n[simulation]\nstop = 10\n");
        bench.write("study.toml", &study);
        assert!(bench.run(&["verify", "study.toml"]).code < 2);
        let concerns = bench.summary("results/study")["concerns"].to_string();
        assert_eq!(concerns.contains(r#""code":"hole","severity":"warning""#), !hole.is_empty());
    }
}
