//! Nothing is lost: interrupted, sharded and parallel runs end with the same files.

mod support;

use std::fs;
use std::thread::sleep;
use std::time::Duration;

use support::Bench;

const STUDY: &str = r#"
title = "Durable"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.001
[design]
method = "sobol"
points = 600
seed = 3
[parameters."lag.rate"]
distribution = "normal"
mean = 1
deviation = 0.3
[parameters."lag.length"]
distribution = "lognormal"
mean = 0.02
deviation = 0.005
unit = "mm"
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = "5 %"
[criteria.mean]
variable = "lag.temperature"
statistic = "mean"
nominal = 5.7
tolerance = "1 degC"
unit = "degC"
"#;

fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    bench
}

fn verify(bench: &Bench, folder: &str, options: &[&str]) -> support::Said {
    bench.run(&[&["verify", "study.toml", "--output", folder], options].concat())
}

/// The final files of a folder, without how long it took.
fn files(bench: &Bench, folder: &str) -> (String, String) {
    let mut summary = bench.summary(folder);
    summary["run"].take();
    (
        bench.read(&format!("{folder}/points.csv")),
        summary.to_string(),
    )
}

/// The files of an undisturbed run.
fn reference(bench: &Bench) -> (String, String) {
    let said = verify(bench, "whole", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    files(bench, "whole")
}

#[test]
fn workers_and_places_do_not_matter() {
    let bench = bench();
    let reference = reference(&bench);
    for (folder, options) in [
        ("one", &["--jobs", "1"][..]),
        ("five", &["--jobs", "5"]),
        ("here", &["--in-process", "--jobs", "3"]),
    ] {
        assert_eq!(verify(&bench, folder, options).code, 0);
        assert!(files(&bench, folder) == reference, "{folder}");
    }
}

#[test]
fn a_study_that_was_killed_again_and_again_ends_with_the_same_files() {
    let bench = bench();
    let reference = reference(&bench);
    let mut kills = 0;
    for round in 0..40 {
        let command = [
            "verify",
            "study.toml",
            "--output",
            "killed",
            "--resume",
            "--jobs",
            "2",
        ];
        let mut child = bench.command(&command).spawn().unwrap();
        // Anywhere from before the first point to after many.
        sleep(Duration::from_millis(15 + 7 * (round % 9)));
        if child.try_wait().unwrap().is_some() {
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
    assert!(kills > 0);
    assert_eq!(verify(&bench, "killed", &["--resume"]).code, 0);
    assert!(files(&bench, "killed") == reference);
    let left_over = fs::read_dir(bench.path("killed")).unwrap().flatten();
    let hidden = |entry: &fs::DirEntry| entry.file_name().to_string_lossy().starts_with('.');
    assert_eq!(left_over.filter(hidden).count(), 0);
}

#[test]
fn shards_join_to_the_same_files() {
    let bench = bench();
    let reference = reference(&bench);
    for shard in ["1/3", "2/3", "3/3"] {
        let folder = format!("part{}", &shard[..1]);
        assert_eq!(verify(&bench, &folder, &["--shard", shard]).code, 0);
    }
    let merge =
        |parts: &[&str], into: &str| bench.run(&[&["merge"], parts, &["--output", into]].concat());
    let said = merge(&["part3", "part1", "part2"], "joined");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(files(&bench, "joined") == reference);
    merge(&["part1", "part3"], "short").is_mistake(&["200 of 600 points", "--resume"]);
    // What is missing can be computed afterwards.
    assert_eq!(verify(&bench, "short", &["--resume"]).code, 0);
    assert!(files(&bench, "short") == reference);
}

#[test]
fn what_has_changed_is_not_resumed() {
    let bench = bench();
    verify(&bench, "whole", &["--points", "20"]);
    bench.write("study.toml", &STUDY.replace("5 %", "6 %"));
    verify(&bench, "whole", &["--points", "20", "--resume"]).is_mistake(&["another study"]);
    bench.write("study.toml", STUDY);
    verify(&bench, "whole", &["--points", "30", "--resume"])
        .is_mistake(&["another number of points (20 then, 30 now)"]);
    verify(
        &bench,
        "whole",
        &["--points", "20", "--seed", "4", "--resume"],
    )
    .is_mistake(&["another seed (3 then, 4 now)"]);
    bench.fmu(
        "lag.fmu",
        &["OTHER"],
        &support::model("A first-order lag", "Another lag"),
    );
    verify(&bench, "whole", &["--points", "20", "--resume"]).is_mistake(&["another FMU"]);
    fs::remove_file(bench.path("whole/summary.json")).unwrap();
    verify(&bench, "whole", &["--points", "20"]).is_mistake(&["begun already", "--resume"]);
}

#[test]
fn a_point_can_be_run_again() {
    let bench = bench();
    verify(&bench, "whole", &["--points", "20"]);
    // Even when the study has been edited since.
    bench.write("study.toml", "");
    let said = bench.run(&["replay", "whole", "7"]);
    assert!(said.code < 2, "{}", said.err);
    let table = bench.read("whole/points.csv");
    let row: Vec<&str> = table.lines().nth(7).unwrap().split(',').collect();
    assert!(
        said.out.contains(&format!("lag.rate = {} 1/s", row[1])),
        "{}",
        said.out
    );
    assert!(
        said.out.contains(&format!("Y = {}", row[3])),
        "{}",
        said.out
    );
    let trajectory = bench.read("whole/point-7.csv");
    assert_eq!(trajectory.lines().count(), 2002);
    let last = trajectory.lines().last().unwrap();
    assert!(
        last.starts_with(&format!("2,{}", row[3])),
        "{last} {}",
        row[3]
    );
    bench
        .run(&["replay", "whole", "21"])
        .is_mistake(&["no point 21"]);
}

#[test]
fn a_study_ends_by_itself_when_enough_is_known() {
    let bench = bench();
    let until = ["--until", "ci 0.15"];
    let counts: Vec<(String, String)> = ["1", "4"]
        .iter()
        .map(|jobs| {
            let folder = format!("until{jobs}");
            assert_eq!(
                verify(&bench, &folder, &[&until[..], &["--jobs", jobs]].concat()).code,
                0
            );
            files(&bench, &folder)
        })
        .collect();
    assert!(counts[0] == counts[1]);
    let summary = bench.summary("until1");
    let points = summary["points"].as_u64().unwrap();
    assert!(points.is_multiple_of(100) && points < 2000, "{points}");
    let interval = &summary["verified_interval"];
    assert!(interval[1].as_f64().unwrap() - interval[0].as_f64().unwrap() <= 0.15);
}

#[test]
fn two_runs_do_not_write_the_same_folder() {
    let bench = bench();
    let slow = [
        "verify",
        "study.toml",
        "--output",
        "busy",
        "--points",
        "5000",
        "--jobs",
        "1",
    ];
    let mut child = bench.command(&slow).spawn().unwrap();
    while !bench.path("busy/journal.txt").exists() {
        sleep(Duration::from_millis(2));
    }
    let second = bench.run(&[&slow[..], &["--resume"]].concat());
    child.kill().unwrap();
    child.wait().unwrap();
    second.is_mistake(&["another run"]);
}
