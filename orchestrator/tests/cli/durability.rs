//! Nothing is lost: interrupted, sharded and parallel runs end with the same files.

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use crate::support::Bench;

const STUDY: &str = r#"
title = "Durable"
fmu = "lag.fmu"
[simulation]
stop = 2
step = 0.01
[design]
method = "sobol"
points = 240
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

fn verify(bench: &Bench, folder: &str, options: &[&str]) -> crate::support::Said {
    bench.run(&[&["verify", "study.toml", "--output", folder], options].concat())
}

/// The keys of a summary that tell how the points were computed and how long it took: all that may differ between a
/// resumed and an undisturbed run.
pub const KEYS_OF_HOW: [&str; 4] = ["run", "isolation", "reproducible", "reproducibility"];

/// The text of an object without some keys, which it may lack.
pub fn without(object: &serde_json::Value, keys: &[&str]) -> String {
    let entries = object.as_object().unwrap().iter();
    let entries = entries.filter(|(key, _)| !keys.contains(&key.as_str()));
    entries.map(|(key, value)| format!("{key}: {value}\n")).collect()
}

/// The final files of a folder, without how they were computed and how long it took.
fn files(bench: &Bench, folder: &str) -> (String, String, String) {
    let summary = bench.summary(folder);
    (
        bench.read(&format!("{folder}/points.csv")),
        without(&summary, &KEYS_OF_HOW),
        bench.read(&format!("{folder}/best.ssv")),
    )
}

/// The files of an undisturbed run.
fn reference(bench: &Bench) -> (String, String, String) {
    let said = verify(bench, "whole", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
    files(bench, "whole")
}

#[test]
fn workers_and_places_do_not_matter() {
    let bench = bench();
    let reference = reference(&bench);
    for (folder, options) in
        [("one", &["--jobs", "1"][..]), ("five", &["--jobs", "5"]), ("here", &["--isolation", "none", "--jobs", "3"])]
    {
        assert_eq!(verify(&bench, folder, options).code, 0);
        assert!(files(&bench, folder) == reference, "{folder}");
    }
}

/// Kills a study so often at random moments, resumes it each time, and compares the final files with those
/// of an undisturbed run. Every third time a worker is killed before its supervisor. The killed runs may go on from a
/// finished study of fewer points.
fn kill(points: u32, kills: u32, finished: u32) {
    let bench = Bench::empty();
    // 5 ms a point, asleep before its steps: whether the best point runs once more, in finer steps, must not hang on how long
    // the machine takes to wake up.
    bench.fmu("lag.fmu", &["SLOW_START"], &crate::support::model("", ""));
    bench.write("study.toml", &STUDY.replace("0.01", "0.1"));
    let points = points.to_string();
    // What runs after the points depends on how long they took.
    let extra = ["--extra-runs", "0"];
    let whole = ["verify", "study.toml", "--points", &points, "--jobs", "2"];
    let whole = [&whole[..], &extra].concat();
    let run = |folder: &str, more: &[&str]| {
        let mut command = bench.command(&[&whole[..], &["--output", folder], more].concat());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().unwrap()
    };
    assert!(run("whole", &[]).wait().unwrap().success());
    if finished > 0 {
        let fewer = finished.to_string();
        let mut command = bench.command(&["verify", "study.toml", "--points", &fewer, "--output", "killed"]);
        assert!(command.output().unwrap().status.success());
    }
    let mut random = StdRng::seed_from_u64(kills.into());
    let (mut killed, mut workers) = (0, 0);
    while killed < kills {
        let mut child = run("killed", &["--resume"]);
        // Anywhere from before the first point to after many, slower where it would be done too early.
        let journal = fs::read_to_string(bench.path("killed/journal.txt")).unwrap_or_default();
        let ahead =
            journal.lines().count() as u64 * u64::from(kills) > u64::from(killed + 1) * points.parse::<u64>().unwrap();
        sleep(Duration::from_micros(random.random_range(0..if ahead { 15_000 } else { 80_000 })));
        if killed % 3 == 0 {
            workers += u32::from(kill_worker(&mut child));
            sleep(Duration::from_micros(random.random_range(0..10_000)));
        }
        if let Some(status) = child.try_wait().unwrap() {
            // Done before it could be killed, which depends on the machine's load: the other kills strike a run anew.
            assert!(status.success(), "after {killed} kills: {status}");
            assert!(files(&bench, "killed") == files(&bench, "whole"));
            fs::remove_dir_all(bench.path("killed")).unwrap();
            continue;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        killed += 1;
    }
    assert!(run("killed", &["--resume"]).wait().unwrap().success());
    assert!(workers > 0, "no worker was killed");
    println!("{killed} supervisors and {workers} workers killed over {points} points");
    assert!(files(&bench, "killed") == files(&bench, "whole"));
    for file in ["best.ssv", "best-point.csv"] {
        assert_eq!(bench.read(&format!("killed/{file}")), bench.read(&format!("whole/{file}")));
    }
    let entries = fs::read_dir(bench.path("killed")).unwrap().flatten();
    let mut left_over = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    assert_eq!(left_over.find(|name| name.starts_with('.')), None);
}

/// Kills a worker of a supervisor as soon as it has one; false where the supervisor ends before.
fn kill_worker(supervisor: &mut Child) -> bool {
    while supervisor.try_wait().unwrap().is_none() {
        if let Some(worker) = worker_of(supervisor.id()) {
            let mut kill = Command::new("kill");
            let signal = kill.args(["-9", &worker]).stderr(Stdio::null()).status();
            if signal.unwrap().success() {
                return true;
            }
        }
        sleep(Duration::from_micros(200));
    }
    false
}

/// The number of a process that another one has started: every thread has children of its own.
fn worker_of(supervisor: u32) -> Option<String> {
    let threads = fs::read_dir(format!("/proc/{supervisor}/task")).ok()?.flatten();
    let children = |thread: fs::DirEntry| fs::read_to_string(thread.path().join("children")).ok();
    threads.filter_map(children).find_map(|children| {
        let first = children.split_whitespace().next();
        first.map(str::to_owned)
    })
}

#[test]
fn a_study_that_was_killed_again_and_again_ends_with_the_same_files() {
    kill(300, 2, 0);
}

#[test]
fn a_study_that_grew_and_was_killed_meanwhile_ends_with_the_same_files() {
    kill(300, 2, 100);
}

#[test]
#[ignore = "takes a minute: cargo test -p orchestrator --test cli durability -- --ignored --nocapture"]
fn two_hundred_kills_over_five_thousand_points() {
    kill(5000, 200, 0);
}

/// Runs a study with a limit on the size of its files, KiB, as on a full disk.
fn verify_in(bench: &Bench, folder: &str, kibibytes: u32) -> crate::support::Said {
    let program = env!("CARGO_BIN_EXE_orchestrator");
    let script = format!(
        "trap '' XFSZ; ulimit -f {kibibytes}; exec {program} verify study.toml --extra-runs 0 --points 600 --output {folder}"
    );
    let mut command = Command::new("bash");
    command.args(["-c", &script]).current_dir(bench.path(""));
    command.output().unwrap().into()
}

#[test]
fn a_full_disk_is_told_and_costs_nothing() {
    let bench = bench();
    // How many points run again to see whether values rest depends on how long the others took.
    let settled = ["--extra-runs", "0", "--points", "600"];
    assert_eq!(verify(&bench, "whole", &settled).code, 0);
    let reference = files(&bench, "whole");
    // Room for the FMU, but not for the whole journal, the table, or the page.
    for kibibytes in [24, 48, 64, 128] {
        let folder = format!("full{kibibytes}");
        let said = verify_in(&bench, &folder, kibibytes);
        if kibibytes < 64 {
            said.is_mistake(&["make room and run the command again, with --resume"]);
        } else {
            // The page comes later, and costs itself alone.
            let page = bench.path(&format!("{folder}/report.html")).exists();
            assert_eq!((said.code, said.err.lines().count()), (0, usize::from(!page)), "{}", said.err);
        }
        let said = verify(&bench, &folder, &[&settled[..], &["--resume"]].concat());
        assert_eq!(said.code, 0, "{kibibytes} KiB: {}", said.err);
        assert_eq!(files(&bench, &folder), reference, "{kibibytes} KiB");
    }
}

#[test]
fn shards_join_to_the_same_files() {
    let bench = bench();
    let reference = reference(&bench);
    for shard in ["1/3", "2/3", "3/3"] {
        let folder = format!("part{}", &shard[..1]);
        assert_eq!(verify(&bench, &folder, &["--shard", shard]).code, 0);
    }
    let merge = |parts: &[&str], into: &str| bench.run(&[&["merge"], parts, &["--output", into]].concat());
    let said = merge(&["part3", "part1", "part2"], "joined");
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(files(&bench, "joined") == reference);
    merge(&["part1", "part3"], "short")
        .is_mistake(&["80 of 240 points are in none of the shards 1/3, 3/3", "study.toml --output short --resume`"]);
    // Merged once more with all of them, or computed afterwards.
    merge(&["part1", "part3"], "again").is_mistake(&["80 of 240 points"]);
    assert_eq!(merge(&["part1", "part2", "part3"], "again").code, 0);
    assert!(files(&bench, "again") == reference);
    assert_eq!(verify(&bench, "short", &["--resume"]).code, 0);
    assert!(files(&bench, "short") == reference);
    // A merged study is as good as any: its points can be run again, also without the shards.
    for part in ["part1", "part2", "part3"] {
        fs::remove_dir_all(bench.path(part)).unwrap();
    }
    assert!(bench.run(&["replay", "joined", "7"]).code < 2);
}

/// The points of a folder, as its journal names them: their indexes.
fn points_in(bench: &Bench, folder: &str) -> Vec<usize> {
    let journal = bench.read(&format!("{folder}/journal.txt"));
    let index = |line: &str| line.split(' ').nth(1).and_then(|word| word.parse().ok());
    journal.lines().filter_map(index).collect()
}

#[test]
fn shards_share_the_dear_points_and_grow() {
    let bench = bench().in_process();
    bench.write("study.toml", &STUDY.replace("0.01", "2"));
    let many = ["--points", "1024", "--extra-runs", "0"];
    verify(&bench, "whole", &many);
    let table = bench.read("whole/points.csv");
    let cell = |row: &str| row.split(',').nth(1).and_then(|cell| cell.parse().ok());
    let rates: Vec<f64> = table.lines().skip(1).filter_map(cell).collect();
    let mut sorted = rates.clone();
    sorted.sort_by(f64::total_cmp);
    // Where the rate is in its upper tenth, a point may take 100 times as long.
    let cost = |index: usize| {
        if rates[index] > sorted[921] { 100.0 } else { 1.0 }
    };
    let costs = ["0", "1", "2", "3", "4", "5", "6", "7"].map(|index| {
        let shard = ["--shard-index", index, "--shards", "8"];
        let folder = format!("part{index}");
        assert_eq!(verify(&bench, &folder, &[&many[..], &shard].concat()).code, 0);
        let points = points_in(&bench, &folder);
        assert_eq!(points.len(), 128);
        points.into_iter().map(cost).sum::<f64>()
    });
    let mean = costs.iter().sum::<f64>() / 8.0;
    assert!(costs.iter().all(|&cost| cost < 1.3 * mean), "{costs:?}");
    // Counted from 1 they are the same; a longer study goes on with what they have.
    let more = ["--points", "1250", "--resume"];
    for shard in 1..=8 {
        let (folder, shard) = (format!("part{}", shard - 1), format!("{shard}/8"));
        let shard = ["--shard", &shard];
        assert_eq!(verify(&bench, &folder, &[&more[..], &shard].concat()).code, 0);
    }
    let parts: Vec<String> = (0..8).map(|part| format!("part{part}")).collect();
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    let merge = [&["merge"], &parts[..], &["--output", "joined"]].concat();
    assert!(bench.run(&merge).code < 2);
    verify(&bench, "longer", &["--points", "1250"]);
    assert!(files(&bench, "joined") == files(&bench, "longer"));
    let without = [&["merge"], &parts[..], &["--output", "not-again", "--extra-runs", "0"]].concat();
    assert!(bench.run(&without).code < 2);
    assert!(bench.summary("not-again")["concerns"].to_string().contains("--extra-runs 0 asked for none"));
    let wrong = ["--shard-index", "8", "--shards", "8"];
    verify(&bench, "wrong", &wrong).is_mistake(&["--shard-index", "8 is none of 8 parts"]);
}

/// A folder with the journal of another one, of which some lines were changed, and nothing else that a killed run would
/// not have.
pub fn killed(bench: &Bench, from: &str, into: &str, change: impl Fn(&mut Vec<String>)) {
    fs::create_dir_all(bench.path(into)).unwrap();
    for file in ["request.json", "study.toml"] {
        fs::copy(bench.path(&format!("{from}/{file}")), bench.path(&format!("{into}/{file}"))).unwrap();
    }
    let journal = bench.read(&format!("{from}/journal.txt"));
    let mut lines: Vec<String> = journal.lines().map(str::to_owned).collect();
    change(&mut lines);
    bench.write(&format!("{into}/journal.txt"), &(lines.join("\n") + "\n"));
}

/// Whether a line of the journal is that of a point.
pub fn is_of_point(line: &str) -> bool {
    line.split(' ').nth(1).is_some_and(|word| word.parse::<u64>().is_ok())
}

#[test]
fn a_study_that_waits_for_its_verdict_sees_all_finished_points_whatever_gaps_there_are() {
    let bench = bench();
    let awaited = STUDY.replace("sobol", "monte-carlo") + "[verdict]\nshare = \"1 %\"\n";
    bench.write("study.toml", &awaited);
    let until = ["--until", "verdict", "--points", "1000", "--jobs", "1"];
    assert_eq!(verify(&bench, "whole", &until).code, 0);
    let needed = bench.summary("whole")["points"].as_u64().unwrap();
    assert!((3..500).contains(&needed), "{needed}");
    // Two workers were at work when the run was killed: the second point is missing.
    killed(&bench, "whole", "gap", |lines| {
        lines.retain(|line| line.split(' ').nth(1) != Some("1"));
    });
    assert_eq!(verify(&bench, "gap", &[&until[..], &["--resume"]].concat()).code, 0);
    // The worker may have begun another one before the verdict was there.
    assert!(bench.summary("gap")["run"]["computed"].as_u64() >= Some(1));
    assert!(files(&bench, "gap") == files(&bench, "whole"));
}

#[test]
fn a_damaged_line_of_the_journal_costs_its_line() {
    let bench = bench();
    let few = ["--points", "60"];
    assert_eq!(verify(&bench, "whole", &few).code, 0);
    let flip = |line: &mut String| *line = line.replacen(' ', "!", 1);
    for (folder, lines, told) in [
        // The first line says which study it is; it stands there once more.
        ("first", 0..1, "1 damaged line "),
        ("three", 4..7, "3 damaged lines "),
    ] {
        killed(&bench, "whole", folder, |journal| {
            journal[lines.clone()].iter_mut().for_each(flip);
        });
        let damaged = bench.read(&format!("{folder}/journal.txt"));
        let lost = damaged.lines().filter(|line| !line.contains(' ') || line.split(' ').next().unwrap().contains('!'));
        let lost = lost.filter(|line| is_of_point(&line.replacen('!', " ", 1))).count();
        let said = verify(&bench, folder, &[&few[..], &["--resume"]].concat());
        assert_eq!(said.code, 0, "{}", said.err);
        assert!(said.err.contains(told) && said.err.lines().count() == 1, "{}", said.err);
        assert_eq!(bench.summary(folder)["run"]["computed"], lost);
        assert!(files(&bench, folder) == files(&bench, "whole"), "{folder}");
        // What has been told once is mended.
        let again = verify(&bench, folder, &[&few[..], &["--resume"]].concat());
        assert_eq!(again.err, "");
    }
}

#[test]
fn the_documents_name_all_that_differs_in_the_summary_of_a_resumed_run() {
    let bench = bench();
    assert_eq!(verify(&bench, "whole", &[]).code, 0);
    killed(&bench, "whole", "resumed", |lines| lines.truncate(120));
    assert_eq!(verify(&bench, "resumed", &["--resume"]).code, 0);
    let [whole, resumed] = ["whole", "resumed"].map(|folder| bench.summary(folder));
    let engine = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/evidence/engine.md");
    let engine = fs::read_to_string(engine).unwrap();
    let (_, named) = engine.split_once("`summary.json` except for").unwrap();
    for (key, value) in whole.as_object().unwrap() {
        assert!(*value == resumed[key] || named.contains(&format!("`{key}`")), "{key}: {value} {}", resumed[key]);
    }
    for key in KEYS_OF_HOW {
        assert!(named.contains(&format!("`{key}`")), "{key}");
    }
}

#[test]
fn shards_of_other_studies_are_not_joined() {
    let bench = bench();
    assert_eq!(verify(&bench, "a", &["--shard", "1/2"]).code, 0);
    assert_eq!(verify(&bench, "b", &["--shard", "2/2", "--seed", "8"]).code, 0);
    let merge = |into: &str| bench.run(&["merge", "a", "b", "--output", into]);
    merge("c").is_mistake(&["b has another seed (8) than a (3)", "leave it out"]);
    assert!(!bench.path("c").exists());
    let into_itself = bench.run(&["merge", "a", "--output", "a"]);
    into_itself.is_mistake(&["another shard", "choose another --output"]);
}

#[test]
fn what_has_changed_is_not_resumed() {
    let bench = bench();
    verify(&bench, "whole", &["--points", "20"]);
    bench.write("study.toml", &STUDY.replace("5 %", "6 %"));
    verify(&bench, "whole", &["--points", "20", "--resume"]).is_mistake(&["another study"]);
    bench.write("study.toml", STUDY);
    verify(&bench, "whole", &["--points", "10", "--resume"])
        .is_mistake(&["another number of points (20 then, 10 now)"]);
    verify(&bench, "whole", &["--points", "20", "--seed", "4", "--resume"])
        .is_mistake(&["another seed (3 then, 4 now)"]);
    bench.fmu("lag.fmu", &["OTHER"], &crate::support::model("A first-order lag", "Another lag"));
    verify(&bench, "whole", &["--points", "20", "--resume"]).is_mistake(&["another FMU"]);
    fs::remove_file(bench.path("whole/summary.json")).unwrap();
    verify(&bench, "whole", &["--points", "20"]).is_mistake(&["begun already", "--resume"]);
}

#[test]
fn a_run_that_came_to_no_point_is_begun_again() {
    let bench = bench();
    let binary: (&str, &[u8]) = ("binaries/linux64/lag.so", b"junk");
    let description = crate::support::model("", "");
    bench.zip("lag.fmu", &[("modelDescription.xml", description.as_bytes()), binary]);
    verify(&bench, "out", &[]).is_mistake(&["cannot load"]);
    bench.fmu("lag.fmu", &[], &description);
    let said = verify(&bench, "out", &[]);
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn a_point_can_be_run_again() {
    let bench = bench();
    verify(&bench, "whole", &["--points", "20"]);
    // `replay` takes the copy of the study in the folder, so an edit of the file does not matter.
    bench.write("study.toml", "");
    let said = bench.run(&["replay", "whole", "7"]);
    assert!(said.code < 2, "{}", said.err);
    let table = bench.read("whole/points.csv");
    let row: Vec<&str> = table.lines().nth(7).unwrap().split(',').collect();
    assert!(said.out.contains(&format!("lag.rate = {} 1/s", row[1])), "{}", said.out);
    assert!(said.out.contains(&format!("Y = {}", row[3])), "{}", said.out);
    let trajectory = bench.read("whole/point-7.csv");
    assert_eq!(trajectory.lines().count(), 202);
    let last = trajectory.lines().last().unwrap();
    assert!(last.starts_with(&format!("2,{}", row[3])), "{last} {}", row[3]);
    bench.run(&["replay", "whole", "21"]).is_mistake(&["no point 21"]);
}

#[test]
fn a_study_ends_by_itself_when_enough_is_known() {
    let bench = bench();
    let until = ["--until", "ci 0.15"];
    bench.run(&["verify", "study.toml", "--until", "ci 0.15"]).is_mistake(&["until", "monte-carlo"]);
    bench.write("study.toml", &STUDY.replace("sobol", "monte-carlo"));
    let counts: Vec<(String, String, String)> = ["1", "4"]
        .iter()
        .map(|jobs| {
            let folder = format!("until{jobs}");
            assert_eq!(verify(&bench, &folder, &[&until[..], &["--jobs", jobs]].concat()).code, 0);
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
    let slow = ["verify", "study.toml", "--output", "busy", "--points", "100000", "--jobs", "1"];
    let mut child = bench.command(&slow).spawn().unwrap();
    while !bench.path("busy/journal.txt").exists() {
        sleep(Duration::from_millis(2));
    }
    let second = bench.run(&[&slow[..], &["--resume"]].concat());
    child.kill().unwrap();
    child.wait().unwrap();
    second.is_mistake(&["another run"]);
}

#[test]
fn a_finished_study_goes_on_with_more_points() {
    let bench = bench();
    let small = |method| STUDY.replace("sobol", method).replace("points = 240", "points = 40");
    for (method, isolation) in [("sobol", "fresh"), ("monte-carlo", "shared"), ("monte-carlo", "none")] {
        bench.write("study.toml", &small(method));
        let folder = |name: &str| format!("{name}-{isolation}");
        let more = ["--points", "100"];
        assert_eq!(verify(&bench, &folder("whole"), &more).code, 0);
        assert_eq!(verify(&bench, &folder("grown"), &[]).code, 0);
        let grown = folder("grown");
        let options = [&more[..], &["--resume", "--isolation", isolation]].concat();
        let said = verify(&bench, &grown, &options);
        assert_eq!(said.code, 0, "{}", said.err);
        let computed = bench.summary(&grown)["run"]["computed"].as_u64().unwrap();
        assert_eq!(computed, 60, "{method}");
        assert!(files(&bench, &grown) == files(&bench, &folder("whole")), "{method}");
        // Points that there are do not go away.
        verify(&bench, &grown, &["--resume"]).is_mistake(&["another number of points (100 then, 40 now)"]);
    }
    bench.write("study.toml", &small("latin-hypercube"));
    assert_eq!(verify(&bench, "hypercube", &[]).code, 0);
    verify(&bench, "hypercube", &["--points", "100", "--resume"]).is_mistake(&[
        "--points",
        "latin-hypercube",
        "40",
        "monte-carlo or sobol",
    ]);
}
