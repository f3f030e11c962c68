//! `pack` and `verify MODEL.fmu`: an FMU that carries its own verification.

use std::fs::{self, File};
use std::io::Read;

use crate::gate::tests;
use crate::support::{Bench, model};
use zip::ZipArchive;

const STUDY: &str = r#"
fmu = "../models/lag.fmu"
[simulation]
stop = 2
step = 0.1
[design]
points = 40
seed = 7
[parameters."lag.rate"]
distribution = "uniform"
min = 0.5
max = 1.5
[inputs."drive.u"]
file = "../data/measured input.csv"
time = "t"
column = "u"
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = 0.05
"#;

/// The test of the FMU's own files.
const SAME: &str = "the FMU is the one that was verified";

/// Another content of an entry, if it changes.
type Change<'a> = &'a dyn Fn(&str, &[u8]) -> Option<Vec<u8>>;

/// A project whose study and data lie in folders of their own, with results.
fn bench() -> Bench {
    let bench = Bench::empty();
    for folder in ["models", "studies", "data"] {
        fs::create_dir(bench.path(folder)).unwrap();
    }
    bench.fmu("models/lag.fmu", &[], &model("", ""));
    bench.write("studies/lag.toml", STUDY);
    bench.write("data/measured input.csv", "t,u\n0,1\n2,1\n");
    let said = bench.run(&["verify", "studies/lag.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    bench
}

fn packed(bench: &Bench) {
    let said = bench.run(&["pack", "studies/lag.toml", "--from", "out", "--output", "new/carrier.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

/// The files of an archive, with their content and their packed bytes.
fn entries(bench: &Bench, name: &str) -> Vec<(String, Vec<u8>)> {
    let mut zip = ZipArchive::new(File::open(bench.path(name)).unwrap()).unwrap();
    (0..zip.len())
        .map(|index| {
            let mut entry = zip.by_index(index).unwrap();
            let mut content = Vec::new();
            entry.read_to_end(&mut content).unwrap();
            (entry.name().unwrap().into_owned(), content)
        })
        .collect()
}

fn repacked(bench: &Bench, name: &str, entries: &[(String, Vec<u8>)]) {
    let entries: Vec<(&str, &[u8])> = entries.iter().map(|(name, content)| (&**name, &**content)).collect();
    bench.zip(name, &entries);
}

#[test]
fn a_packed_study_is_run_elsewhere_and_gives_its_result() {
    let bench = bench();
    packed(&bench);
    // What was there stays; what came is listed, and the FMU is as sound as before.
    let before = entries(&bench, "models/lag.fmu");
    let after = entries(&bench, "new/carrier.fmu");
    assert!(before.iter().all(|entry| after.contains(entry)));
    let said = bench.run(&["check", "new/carrier.fmu", "--strict"]);
    assert_eq!(said.code, 0, "{}", said.out);
    let folder = "extra/org.fmi-standard.fmi-ls-ref/";
    let manifest = after.iter().find(|(name, _)| name.ends_with("fmi-ls-manifest.xml")).unwrap();
    let manifest = String::from_utf8(manifest.1.clone()).unwrap();
    for (name, _) in after.iter().filter(|(name, _)| name.starts_with(folder) && !name.ends_with(".xml")) {
        let source = name.strip_prefix(folder).unwrap().replace(' ', "%20");
        assert!(manifest.contains(&format!("source=\"{source}\"")), "{source} in {manifest}");
    }
    for gone in ["studies", "data", "models", "out"] {
        fs::remove_dir_all(bench.path(gone)).unwrap();
    }
    let verify = ["verify", "new/carrier.fmu", "--output", "there", "--jobs", "1", "--junit", "junit.xml"];
    let said = bench.run(&verify);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let words = "The study lag, which the FMU carries, against its result: No difference";
    assert!(said.out.contains(words), "{}", said.out);
    let words = "The carried result is met again: verified.";
    assert!(said.out.contains(words), "{}", said.out);
    assert!(said.out.contains("as packed"), "{}", said.out);
    assert_eq!(bench.summary("there")["points"], 40);
    let all = tests(&bench, "junit.xml");
    for name in ["Y", "verdict", SAME] {
        let is_it = |test: &&crate::gate::Test| test.0 == "compare" && test.1 == name;
        let test = all.iter().find(is_it).unwrap();
        assert_eq!(test.2, None, "{name}");
    }
    // The folder is as any other one.
    assert_eq!(bench.run(&["replay", "there", "3"]).code, bench.run(&["replay", "there", "3"]).code);
    let said = bench.run(&["verify", "new/carrier.fmu", "--study", "lga"]);
    said.is_mistake(&["no study `lga`, but lag"]);
}

#[test]
fn a_changed_model_does_not_give_the_carried_result() {
    let bench = bench();
    packed(&bench);
    // The same model with another binary: told, and nothing else.
    let whole = entries(&bench, "new/carrier.fmu");
    let with = |change: Change<'_>| {
        let changed = whole
            .iter()
            .map(|(name, content)| (name.clone(), change(name, content).unwrap_or_else(|| content.clone())));
        repacked(&bench, "changed.fmu", &changed.collect::<Vec<_>>());
        let usual = ["verify", "changed.fmu", "--output", "there", "--force"];
        bench.run(&[&usual[..], &["--junit", "junit.xml"]].concat())
    };
    let outcome = || {
        let all = tests(&bench, "junit.xml");
        let test = all.into_iter().find(|test| test.1 == SAME).unwrap();
        test.2.unwrap_or_default()
    };
    let is_binary = |name: &str| name.starts_with("binaries/");
    let other = bench.binary(&["SILENT"]);
    let said = with(&|name, _| is_binary(name).then(|| other.clone()));
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let told = "warning: not the FMU that was verified: binaries/linux64/lag.so is another one";
    assert!(said.out.contains(told), "{}", said.out);
    assert!(!said.out.contains("as packed"), "{}", said.out);
    assert!(outcome().starts_with("skipped"), "{}", outcome());
    let usual = ["verify", "changed.fmu", "--output", "there", "--force"];
    let said = bench.run(&[&usual[..], &["--strict", "--junit", "junit.xml"]].concat());
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(outcome().starts_with("failure"), "{}", outcome());
    // A page or a measured curve that is another one: told by its name.
    for file in ["results/report.html", "study/data/measured input.csv"] {
        let said = with(&|name, content| {
            let longer = [content, b"\n"].concat();
            name.ends_with(file).then_some(longer)
        });
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        let told = format!("warning: changed after it was packed: {file} is another one");
        assert!(said.out.contains(&told), "{}", said.out);
        let usual = ["verify", "changed.fmu", "--output", "there", "--force"];
        assert_eq!(bench.run(&[&usual[..], &["--strict"]].concat()).code, 1);
    }
    // A result that the model does not give.
    let said = with(&|name, content| {
        if !name.ends_with("results/points.csv") {
            return None;
        }
        let text = String::from_utf8_lossy(content);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut cells: Vec<&str> = lines[1].split(',').collect();
        cells[2] = "0.5";
        lines[1] = cells.join(",");
        Some((lines.join("\n") + "\n").into_bytes())
    });
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.contains("Y changed at 1 point beyond rounding"), "{}", said.out);
    assert!(!said.out.contains("met again"), "{}", said.out);
    // A study that lies elsewhere is refused.
    let said = with(&|name, content| {
        let text = String::from_utf8_lossy(content);
        let evil = text.replace("\"study/", "\"../../study/");
        name.ends_with("ties.json").then(|| evil.into_bytes())
    });
    said.is_mistake(&["ties.json", "is no path within the study's folder"]);
    // A path that leads out of the folder is refused.
    let mut evil = whole.clone();
    evil.push(("extra/org.fmi-standard.fmi-ls-ref/lag/../../../evil".to_owned(), Vec::new()));
    repacked(&bench, "evil.fmu", &evil);
    bench.run(&["verify", "evil.fmu", "--output", "evil"]).is_mistake(&["leads out"]);
    bench.run(&["verify", "models/lag.fmu"]).is_mistake(&["carries no study", "orchestrator pack"]);
}

/// What an FMU carries is written below its results alone, reads nothing else, and leaves nothing of an earlier release.
#[test]
fn a_carried_study_stays_in_its_folder() {
    let bench = bench();
    packed(&bench);
    let whole = entries(&bench, "new/carrier.fmu");
    let changed = |change: Change<'_>| {
        let all = whole.iter().map(|(name, content)| (name.clone(), change(name, content).unwrap_or(content.clone())));
        repacked(&bench, "changed.fmu", &all.collect::<Vec<_>>());
    };
    // A study called `..`, and the like on Windows.
    let own = "extra/org.fmi-standard.fmi-ls-ref/";
    for name in ["..", "C:", "a\\..\\..", ".. "] {
        let all = whole
            .iter()
            .map(|(entry, content)| (entry.replace("ls-ref/lag/", &format!("ls-ref/{name}/")), content.clone()));
        let all: Vec<_> = all.filter(|(entry, _)| entry.starts_with(own) || !entry.contains("extra")).collect();
        repacked(&bench, "evil.fmu", &all);
        bench.run(&["verify", "evil.fmu", "--output", "evil"]).is_mistake(&["evil.fmu/extra"]);
        assert!(!bench.path("evil").exists(), "{name}");
    }
    // A file of the customer.
    for file in ["/etc/hostname", "../../../secret.csv", "..\\secret.csv"] {
        let file = format!("file = '{file}'");
        changed(&|name, content| {
            let text = String::from_utf8_lossy(content);
            let evil = text.replace("file = \"../data/measured input.csv\"", &file);
            name.ends_with("lag.toml").then(|| evil.into_bytes())
        });
        bench.run(&["verify", "changed.fmu", "--output", "evil"]).is_mistake(&["its study reads", "none of the files"]);
        assert!(!bench.path("evil").exists(), "{file}");
    }
    // The results of another study are as they were.
    let kept = || [bench.read("out/study.toml"), bench.read("out/points.csv")];
    let before = kept();
    bench.run(&["verify", "new/carrier.fmu", "--output", "out"]).is_mistake(&["another study file"]);
    assert!(kept() == before && !bench.path("out/carried").exists());
    // A folder that no FMU has made is nobody's to empty.
    fs::create_dir_all(bench.path("mine/carried")).unwrap();
    bench.run(&["verify", "new/carrier.fmu", "--output", "mine"]).is_mistake(&["was there before any FMU"]);
    // The next release of the FMU carries a study without results, which meets none of the earlier ones.
    assert_eq!(bench.run(&["verify", "new/carrier.fmu", "--output", "there"]).code, 0);
    let without: Vec<_> = whole.iter().filter(|(name, _)| !name.contains("lag/results/")).cloned().collect();
    repacked(&bench, "new/carrier.fmu", &without);
    let said = bench.run(&["verify", "new/carrier.fmu", "--output", "there"]);
    said.is_mistake(&["carries no results/summary.json"]);
    // What the plan alone needs is written nowhere.
    repacked(&bench, "new/carrier.fmu", &whole);
    assert_eq!(bench.run(&["verify", "new/carrier.fmu", "--output", "plan", "--dry-run"]).code, 0);
    assert!(!bench.path("plan").exists());
    bench.write("there/carried/stale", "");
    assert_eq!(bench.run(&["verify", "new/carrier.fmu", "--output", "there"]).code, 0);
    assert!(!bench.path("there/carried/stale").exists());
}

#[test]
fn the_study_that_was_packed_last_is_run_and_the_others_are_named() {
    let bench = bench();
    packed(&bench);
    bench.write("studies/other.toml", &STUDY.replace("points = 40", "points = 20"));
    let said = bench.run(&["verify", "studies/other.toml", "--output", "other"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let both = ["pack", "studies/other.toml", "--from", "other", "--fmu", "new/carrier.fmu", "--output", "both.fmu"];
    let said = bench.run(&both);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let said = bench.run(&["verify", "both.fmu", "--output", "there"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(said.out.contains("The study other,") && said.out.contains("It also carries lag:"), "{}", said.out);
    let said = bench.run(&["verify", "both.fmu", "--study", "lag", "--output", "lag"]);
    assert_eq!((said.code, &bench.summary("lag")["points"]), (0, &40.into()));
    // One that is packed again replaces itself.
    let again = ["pack", "studies/lag.toml", "--from", "out", "--fmu", "both.fmu", "--output", "both.fmu", "--force"];
    assert_eq!(bench.run(&again).code, 0);
    let said = bench.run(&["verify", "both.fmu", "--output", "again"]);
    assert!(said.out.contains("The study lag,") && said.out.contains("It also carries other:"), "{}", said.out);
    assert_eq!(bench.run(&["check", "both.fmu", "--strict"]).code, 0);
    // Results of another study or another model do not belong to it.
    let said = bench.run(&["pack", "studies/lag.toml", "--from", "other", "--output", "wrong.fmu"]);
    said.is_mistake(&["other holds results of another study"]);
    bench.fmu("models/lag.fmu", &["SILENT"], &model("", ""));
    let said = bench.run(&["pack", "studies/lag.toml", "--from", "out", "--output", "wrong.fmu"]);
    said.is_mistake(&["out holds results of another FMU"]);
    assert!(!bench.path("wrong.fmu").exists());
}

#[test]
fn pack_runs_the_study_and_files_that_only_this_machine_has_are_refused() {
    let bench = bench();
    let said = bench.run(&["pack", "studies/lag.toml", "--output", "carrier.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(bench.path("results/lag/report.html").exists());
    // The carried study has a folder of its own.
    let said = bench.run(&["verify", "carrier.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert!(bench.path("results/carrier.fmu/lag/summary.json").exists());
    // A file of that name is replaced at the user's word, the study's own FMU never.
    bench
        .run(&["pack", "studies/lag.toml", "--output", "carrier.fmu"])
        .is_mistake(&["carrier.fmu exists already", "--force"]);
    let own = ["pack", "studies/lag.toml", "--output", "models/lag.fmu", "--force"];
    bench.run(&own).is_mistake(&["the study's own FMU"]);
    // Results of the study with its own FMU are none of the carrier: packed anew into itself, it says what to do.
    let said = bench.run(&["pack", "studies/lag.toml", "--fmu", "carrier.fmu", "--output", "carrier.fmu", "--force"]);
    said.is_mistake(&["another FMU", "name that by --from"]);
    assert!(!said.err.contains("--force"), "{}", said.err);
    // The folder of the study's results is that of another study, and its name may hold any sign.
    for folder in ["studies", "models"] {
        bench.write(&format!("{folder}/la;g.toml"), STUDY);
    }
    assert_eq!(bench.run(&["verify", "studies/la;g.toml"]).code, 0);
    let said = bench.run(&["pack", "models/la;g.toml", "--output", "carrier.fmu", "--force"]);
    said.is_mistake(&["results/la;g holds results of another study file", "name that by --from"]);
    assert!(!said.err.contains("--force"), "{}", said.err);
    // A study in the folder itself.
    bench.write("here.toml", &STUDY.replace("../", ""));
    let said = bench.run(&["pack", "here.toml", "--output", "carrier.fmu", "--force"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    assert_eq!(bench.run(&["verify", "carrier.fmu", "--output", "here"]).code, 0);
    let absolute = bench.path("data").display().to_string();
    bench.write("studies/lag.toml", &STUDY.replace("../data", &absolute));
    bench.run(&["verify", "studies/lag.toml", "--output", "out", "--force"]);
    let said = bench.run(&["pack", "studies/lag.toml", "--from", "out", "--output", "carrier.fmu", "--force"]);
    said.is_mistake(&["absolute path"]);
}

/// A number of points or runs that would say nothing.
#[test]
fn a_carried_study_keeps_its_points() {
    let bench = bench();
    packed(&bench);
    let said = bench.run(&["verify", "new/carrier.fmu", "--budget", "30"]);
    said.is_mistake(&["--budget", "give a budget to a study's file"]);
    bench.write("table.csv", "lag.rate\n0.8\n0.9\n1\n1.1\n1.2\n");
    let said = bench.run(&["verify", "studies/lag.toml", "--points-from", "table.csv", "--output", "table"]);
    assert!(said.code < 2, "{}", said.err);
    let said = bench.run(&["pack", "studies/lag.toml", "--from", "table", "--output", "table.fmu"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    for option in ["--points", "--seed"] {
        bench.run(&["verify", "table.fmu", option, "9"]).is_mistake(&[option, "has a table of points"]);
    }
    let said = bench.run(&["verify", "table.fmu", "--output", "there"]);
    assert!(said.code < 2, "{}", said.err);
    assert_eq!(bench.summary("there")["points"], 5);
}

#[test]
fn a_result_that_is_not_verified_and_met_again_says_so() {
    let bench = bench();
    let study = STUDY.replace("nominal = 0.86", "nominal = 8.6");
    bench.write("studies/far.toml", &study);
    let pack = ["pack", "studies/far.toml", "--output", "far.fmu"];
    let said = bench.run(&pack);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let said = bench.run(&["verify", "far.fmu"]);
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    let words = "The carried result is met again: not verified.";
    assert!(said.out.contains(words), "{}", said.out);
}
