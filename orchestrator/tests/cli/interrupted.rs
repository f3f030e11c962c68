//! Analyses that ask for points of their own are as durable as `verify`: interrupted by Ctrl-C or killed, and
//! resumed, they end with the same files; so do their shards, joined.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::durability::{KEYS_OF_HOW, without};
use crate::support::{Bench, Said};

const STUDY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[design]
method = "sobol"
points = 64
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
[criteria.Z]
variable = "lag.y"
statistic = "mean"
nominal = 0.6
tolerance = 0.03
"#;

/// An analysis: its command, the folder of its journal, and its files.
struct Analysis {
    command: &'static [&'static str],
    state: &'static str,
    files: &'static [&'static str],
}

const SENSITIVITY: Analysis = Analysis {
    command: &["sensitivity", "study.toml", "--base", "20"],
    state: "sensitivity",
    files: &["sensitivity.json", "sensitivity-runs.csv"],
};
const SCREENING: Analysis = Analysis {
    command: &["sensitivity", "study.toml", "--morris", "20"],
    state: "sensitivity",
    files: &["sensitivity.json", "sensitivity-runs.csv"],
};
const ROBUSTNESS: Analysis = Analysis {
    command: &["robustness", "study.toml", "--from", "verified", "--confirm", "40", "--level", "0.8"],
    state: "robustness",
    files: &["robustness.json"],
};
const IDENTIFICATION: Analysis = Analysis {
    command: &["identify", "identify.toml"],
    state: "identify",
    files: &["identification.json", "optimum.toml"],
};

const POSTERIOR: Analysis = Analysis {
    command: &["identify", "identify.toml", "--posterior", "200"],
    state: "identify",
    files: &["identification.json", "posterior.csv"],
};

const RARE: Analysis =
    Analysis { command: &["verify", "rare.toml", "--rare", "--budget", "60"], state: "rare", files: &["rare.json"] };

/// The lag's answer to four inputs, with an unknown rate.
const CASES: &str = "point,u,y\n3,0.5,0.434\n5,1,0.866\n8,1.5,1.29\n9,2,1.73\n";

const IDENTIFY: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[identify]
starts = 16
descents = 2
[identify.free."lag.rate"]
min = 0.1
max = 10
scale = "log"
[identify.measured.Y]
variable = "lag.y"
value = 0.86
accuracy = 0.01
"#;

/// The moments at which runs were stopped.
#[derive(Debug, Default)]
struct Struck {
    before_the_first_point: u64,
    between_points: u64,
    in_the_finale: u64,
    /// Runs that told how to go on.
    by_message: u64,
    /// Runs that were done before they could be stopped.
    missed: u64,
}

impl Struck {
    fn moments(&self) -> u64 {
        self.before_the_first_point + self.between_points + self.in_the_finale
    }

    /// Notes one more moment, when `noted` of the points were in the journal.
    fn note(&mut self, noted: u64, points: u64) {
        let count = match noted {
            0 => &mut self.before_the_first_point,
            _ if noted < points => &mut self.between_points,
            _ => &mut self.in_the_finale,
        };
        *count += 1;
    }
}

/// A folder with a slow FMU (2 ms a point, asleep) and the points of a finished study.
fn bench() -> Bench {
    let bench = Bench::empty();
    bench.fmu("lag.fmu", &["SLOW"], &crate::support::model("", ""));
    bench.write("study.toml", STUDY);
    bench.write("identify.toml", IDENTIFY);
    let table = "[identify]\ncases = \"cases.csv\"\nknown.\"drive.u\" = { column = \"u\" }";
    let cases = IDENTIFY.replace("[identify]", table);
    bench.write("cases.toml", &cases.replace("value = 0.86", "column = \"y\""));
    bench.write("cases.csv", CASES);
    // The rate must be 3.3 to 4.1 deviations above its mean.
    let (one, _) = STUDY.split_once("[criteria.Z]").unwrap();
    let rare = one.replace("0.86", "0.935").replace("tolerance = 0.02", "tolerance = 0.005");
    bench.write("rare.toml", &rare);
    let said = bench.run(&["verify", "study.toml", "--output", "verified"]);
    assert_eq!(said.code, 0, "{}", said.err);
    bench
}

impl Analysis {
    fn arguments<'a>(&'a self, folder: &'a str, more: &[&'a str]) -> Vec<&'a str> {
        let own = ["--jobs", "2", "--output", folder];
        [self.command, &own[..], more].concat()
    }

    fn run(&self, bench: &Bench, folder: &str, more: &[&str]) -> Said {
        bench.run(&self.arguments(folder, more))
    }

    /// The contents of the analysis's result files.
    fn results(&self, bench: &Bench, folder: &str) -> Vec<String> {
        let files = self.files.iter();
        files.map(|file| bench.read(&format!("{folder}/{file}"))).collect()
    }

    /// The results of an undisturbed run, and its standard output.
    fn undisturbed(&self, bench: &Bench) -> (Vec<String>, String) {
        let said = self.run(bench, "whole", &[]);
        assert_eq!(said.code, 0, "{}", said.err);
        (self.results(bench, "whole"), said.out)
    }

    /// How many points the journal of a folder holds.
    fn noted(&self, bench: &Bench, folder: &str) -> u64 {
        let path = bench.path(&format!("{folder}/{}/journal.txt", self.state));
        let text = fs::read_to_string(path).unwrap_or_default();
        let points = text.lines().filter(|line| {
            let words: Vec<&str> = line.split(' ').take(3).collect();
            matches!(words[..], [_, _, "ok" | "failed"])
        });
        points.count() as u64
    }

    /// Stops runs at moments spread over the analysis, alternating between the signals, resumes each time, and compares
    /// the end with an undisturbed run. The first moment is the start, the last one is the finale, when all points are
    /// noted and the results are not yet written.
    fn stop_and_resume(&self, moments: u64, signals: &[&str]) {
        let bench = bench();
        let (whole, text) = self.undisturbed(&bench);
        let points = self.noted(&bench, "whole");
        let mut random = StdRng::seed_from_u64(moments);
        let mut struck = Struck::default();
        while struck.moments() < moments {
            let mut child = self.begin(&bench);
            // Two moments lie within the run; of more, one is its start and one its finale.
            let (place, last) = match moments {
                2 => (struck.moments() + 1, 3),
                _ => (struck.moments(), moments - 1),
            };
            let wanted = place * points / last;
            while self.noted(&bench, "stopped") < wanted && child.try_wait().unwrap().is_none() {
                sleep(Duration::from_micros(200));
            }
            if wanted < points {
                // At any moment of what happens between two points.
                sleep(Duration::from_micros(random.random_range(0..4000)));
            }
            let signal = signals[struck.moments() as usize % signals.len()];
            if let Some(status) = child.try_wait().unwrap() {
                // Done before it could be stopped: the other moments are those of another run.
                let output = child.wait_with_output().unwrap();
                let message = String::from_utf8_lossy(&output.stderr);
                assert!(status.success(), "{struck:?}: {message}");
                assert!(self.results(&bench, "stopped") == whole);
                fs::remove_dir_all(bench.path("stopped")).unwrap();
                struck.missed += 1;
                continue;
            }
            struck.by_message += u64::from(stop(child, signal));
            struck.note(self.noted(&bench, "stopped"), points);
        }
        println!("{} {signals:?}, {points} points: {struck:?}", self.state);
        let said = self.run(&bench, "stopped", &["--resume"]);
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(self.results(&bench, "stopped") == whole);
        assert_eq!(said.out, text.replace("in whole", "in stopped"));
        let left_over = fs::read_dir(bench.path(&format!("stopped/{}", self.state)));
        let hidden = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
        assert_eq!(left_over.unwrap().flatten().filter(hidden).count(), 0);
        if signals.contains(&"-INT") {
            assert!(struck.by_message > 0, "no run said how to go on");
        }
    }

    fn begin(&self, bench: &Bench) -> Child {
        let mut command = bench.command(&self.arguments("stopped", &["--resume"]));
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        command.spawn().unwrap()
    }
}

/// Stops a run; says whether it told how to go on.
fn stop(child: Child, signal: &str) -> bool {
    let number = child.id().to_string();
    let sent = Command::new("kill").args([signal, &number]).status();
    assert!(sent.unwrap().success());
    let output = child.wait_with_output().unwrap();
    if output.status.code() == Some(130) {
        let message = String::from_utf8(output.stderr).unwrap();
        // A run that is not in order within 0.6 s, on a busy machine, leaves without the count.
        assert!(message.starts_with("interrupted") && message.ends_with("; --resume goes on\n"), "{message}");
        return true;
    }
    false
}

const BOTH: [&str; 2] = ["-INT", "-KILL"];

#[test]
fn an_analysis_of_one_set_of_points_goes_on() {
    SENSITIVITY.stop_and_resume(2, &BOTH);
}

#[test]
fn a_search_goes_on() {
    IDENTIFICATION.stop_and_resume(2, &BOTH);
}

#[test]
#[ignore = "takes minutes: cargo test --workspace --test cli interrupted -- --ignored --nocapture"]
fn every_analysis_goes_on_from_twenty_moments() {
    for analysis in [SENSITIVITY, SCREENING, ROBUSTNESS, RARE, IDENTIFICATION, POSTERIOR] {
        for signal in BOTH {
            analysis.stop_and_resume(20, &[signal]);
        }
    }
}

/// A verification that ends with its verdict.
const AWAITED: &str = r#"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.1
[design]
method = "monte-carlo"
seed = 5
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.1
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.02
[verdict]
share = "43 %"
"#;

/// So many points a batch has at most: 50 ms of points of 2 ms.
const BATCH: u64 = 25;
/// A run that goes on finds out anew how the FMU behaves: three points, each in three processes.
const PROBES: u64 = 9;

/// A result that a resumed run must give as an undisturbed one does.
fn result(bench: &Bench, file: &str) -> String {
    if file.ends_with("summary.json") {
        let folder = file.strip_suffix("/summary.json").unwrap();
        // Time decides how much is run once more.
        let of_time = ["left_out", "rest", "concerns"];
        let summary = bench.summary(folder);
        return without(&summary, &[&of_time[..], &KEYS_OF_HOW].concat());
    }
    bench.read(file)
}

/// Kills a command with SIGKILL at moments spread over its points, and resumes it each time. Returns how many simulations
/// all runs began together.
fn kill_and_resume(bench: &Bench, command: &[&str], journal: &str, files: &[&str], kills: u64) -> u64 {
    let all =
        |folder: &str| -> Vec<String> { files.iter().map(|file| result(bench, &format!("{folder}/{file}"))).collect() };
    let noted = |folder: &str| {
        let text = fs::read_to_string(bench.path(&format!("{folder}/{journal}"))).unwrap_or_default();
        let word = |line: &str| line.split(' ').nth(2).map(str::to_owned);
        let done = ["ok", "failed"];
        text.lines().filter(|line| word(line).is_some_and(|word| done.contains(&&*word))).count() as u64
    };
    let begun = bench.path("begun");
    let run = |folder: &str| {
        let mut own = bench.command(&[command, &["--output", folder, "--resume"]].concat());
        own.env("LAG_INSTANCES", &begun).stdout(Stdio::null()).stderr(Stdio::null());
        own.spawn().unwrap()
    };
    let simulations = || fs::metadata(&begun).map_or(0, |file| file.len());
    assert!(run("whole").wait().unwrap().code().is_some_and(|code| code < 2));
    let (points, undisturbed) = (noted("whole"), simulations());
    fs::remove_file(&begun).unwrap();
    let mut done = 0;
    while done < kills {
        let mut child = run("stopped");
        let wanted = (2 * done + 1) * points / (2 * kills);
        while noted("stopped") < wanted && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_micros(500));
        }
        if child.try_wait().unwrap().is_some() {
            // Done before it could be killed.
            assert!(all("stopped") == all("whole"));
            fs::remove_dir_all(bench.path("stopped")).unwrap();
            let _ = fs::remove_file(&begun);
            done = 0;
            continue;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        done += 1;
    }
    assert!(run("stopped").wait().unwrap().code().is_some_and(|code| code < 2));
    assert!(all("stopped") == all("whole"), "{command:?}");
    let more = simulations().saturating_sub(undisturbed);
    println!("{command:?}: {points} points, {kills} kills, {more} simulations more than undisturbed");
    for folder in ["whole", "stopped"] {
        fs::remove_dir_all(bench.path(folder)).unwrap();
    }
    fs::remove_file(&begun).unwrap();
    more
}

#[test]
#[ignore = "takes minutes: cargo test --workspace --test cli interrupted -- --ignored --nocapture"]
fn a_hundred_kills_with_one_two_and_five_workers_cost_a_batch_a_worker_at_most() {
    const KILLS: u64 = 9;
    let bench = bench();
    bench.write("awaited.toml", AWAITED);
    let until: &[&str] = &[
        "verify",
        "awaited.toml",
        "--until",
        "verdict",
        "--points",
        "3000",
        // How many of these there is time for depends on the machine.
        "--extra-runs",
        "0",
    ];
    let commands: [(&[&str], &str, &[&str]); 4] = [
        (until, "journal.txt", &["points.csv", "summary.json", "best.ssv"]),
        (POSTERIOR.command, "identify/journal.txt", POSTERIOR.files),
        (SENSITIVITY.command, "sensitivity/journal.txt", SENSITIVITY.files),
        (ROBUSTNESS.command, "robustness/journal.txt", ROBUSTNESS.files),
    ];
    for jobs in [1, 2, 5] {
        let number = jobs.to_string();
        for (command, journal, files) in commands {
            let command = [command, &["--jobs", &number]].concat();
            // Each point has an instance of its own, so these count the points that were computed.
            let more = kill_and_resume(&bench, &command, journal, files, KILLS);
            let most = KILLS * (jobs * BATCH + PROBES);
            assert!(more <= most, "{command:?}: {more}");
        }
    }
}

#[test]
fn what_has_no_parts_is_refused() {
    let bench = bench();
    for analysis in [IDENTIFICATION, SENSITIVITY, ROBUSTNESS] {
        analysis.run(&bench, "i", &["--shard", "1/2"]).is_mistake(&["--shard"]);
    }
}

#[test]
fn other_analyses_are_not_resumed_and_an_unfinished_one_is_not_overwritten() {
    let bench = bench();
    let run = |more: &[&str]| SENSITIVITY.run(&bench, "s", more);
    assert_eq!(run(&[]).code, 0);
    // As a run leaves it that was stopped half way.
    let journal = bench.read("s/sensitivity/journal.txt");
    let lines: Vec<&str> = journal.lines().collect();
    bench.write("s/sensitivity/journal.txt", &(lines[..lines.len() / 2].join("\n") + "\n"));
    run(&["--resume", "--seed", "9"]).is_mistake(&["another seed (1 then, 9 now)"]);
    run(&[]).is_mistake(&["begun already", "--resume"]);
    SCREENING.run(&bench, "s", &["--resume"]).is_mistake(&[
        "another analysis",
        "20 base points then",
        "20 trajectories now",
    ]);
    // One that is complete is simply done again.
    for _ in 0..2 {
        assert_eq!(SENSITIVITY.run(&bench, "whole", &[]).code, 0);
    }
}
