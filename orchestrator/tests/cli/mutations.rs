//! Damaged files are no panic: each one gives a clear error of one line, or still makes sense.

use std::fs;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::support::Bench;
use fmu_import::Package;
use number_tables::Table;
use orchestrator::results::table;
use orchestrator::source::PointSource;
use point_journal::{Finished, Journal, lines};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use study::judge::Judge;
use study::plan::Plan;
use study::{Study, ssv};

const STUDY: &str = r#"
title = "Mutated"
fmu = "lag.fmu"
fixed-from = "start.ssv"
[simulation]
stop = 2
step = 0.01
warm-up = 0.5
[design]
method = "latin-hypercube"
points = 2
seed = 3
[parameters."lag.rate"]
distribution = "truncated-normal"
mean = 1
deviation = 0.3
min = "0.1 1/s"
[parameters."lag.length"]
distribution = "lognormal"
mean = 0.02
deviation = 0.005
unit = "mm"
[[correlations]]
between = ["lag.rate", "lag.length"]
coefficient = 0.5
[fixed]
"lag.flag" = true
[inputs."drive.u"]
file = "drive.csv"
[criteria.Y]
variable = "lag.y"
nominal = 0.86
tolerance = "50 %"
group = "all"
"#;

const SET: &str = "<ParameterSet xmlns=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\" \
    version=\"1.0\" name=\"x\"><Parameters><Parameter name=\"lag.count\"><Integer value=\"2\"/></Parameter>\
    <Parameter name=\"lag.text\"><String value=\"&lt;\"/></Parameter></Parameters></ParameterSet>";

/// Words that are likely to hurt.
const WORDS: [&str; 24] = [
    "nan",
    "-1",
    "0",
    "1e999",
    "inf",
    "18446744073709551616",
    "-9223372036854775808",
    "\0",
    "\"",
    "[",
    "]]",
    "=",
    "\n",
    "ä",
    "\u{feff}",
    "<",
    "&a;",
    "1e-320",
    " mm",
    "true",
    "{",
    "<!DOCTYPE x [",
    "..",
    "99999999",
];

/// Some changes to a file.
fn mutate(original: &[u8], random: &mut StdRng) -> Vec<u8> {
    let mut bytes = original.to_vec();
    if random.random() {
        // Gentle: what can still be read, with other content.
        rearrange(&mut bytes, random);
        return bytes;
    }
    for _ in 0..random.random_range(1..4) {
        let place = random.random_range(0..=bytes.len());
        let end = (place + random.random_range(0..40)).min(bytes.len());
        match random.random_range(0..7) {
            0 if place < bytes.len() => bytes[place] ^= 1 << random.random_range(0..8),
            1 if place < bytes.len() => bytes[place] = random.random(),
            2 => drop(bytes.drain(place..end)),
            3 => bytes.truncate(place),
            4 => {
                let copy = bytes[place..end].to_vec();
                let target = random.random_range(0..=bytes.len());
                bytes.splice(target..target, copy);
            }
            5 => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                bytes.splice(place..end.min(place + 8), word.bytes());
            }
            _ => {
                let word = WORDS[random.random_range(0..WORDS.len())];
                bytes.splice(place..place, word.bytes());
            }
        }
    }
    bytes
}

/// Changes a number, or removes, doubles or moves a line.
fn rearrange(bytes: &mut Vec<u8>, random: &mut StdRng) {
    let digits: Vec<usize> = (0..bytes.len()).filter(|&k| bytes[k].is_ascii_digit()).collect();
    let mut lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').collect();
    let (from, to) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
    match random.random_range(0..5) {
        0 => drop(lines.remove(from)),
        1 => lines.insert(to, lines[from]),
        2 => lines.swap(from, to),
        _ if digits.is_empty() => {}
        _ => {
            bytes[digits[random.random_range(0..digits.len())]] = random.random_range(b'0'..=b'9');
            return;
        }
    }
    *bytes = lines.concat();
}

type Attempt = Result<(), String>;

fn text(error: impl ToString) -> String {
    error.to_string()
}

/// Reads an FMU file and unpacks it.
fn fmu(bench: &Bench, path: &Path) -> Attempt {
    let mut package = Package::open(path).map_err(text)?;
    let _ = (package.platforms(), package.digest().map_err(text)?);
    package.unpack(&bench.path("")).map(drop).map_err(text)
}

/// Reads an FMU, ties the study to it and asks for points.
fn study(path: &Path, study: &Path) -> Attempt {
    let package = Package::open(path).map_err(text)?;
    let study = Study::read(study).map_err(text)?;
    let judge = Judge::new(&study, Some(package.description())).map_err(text)?;
    let plan = Plan::new(&study, package.description()).map_err(text)?;
    let design = plan.design(&study.design)?;
    let mut values = Vec::new();
    for index in [0, design.len() / 2, design.len() - 1] {
        plan.to_fmu(&design.point(index), &mut values);
    }
    judge.verdict(Some(&vec![1.0; judge.criteria.len()]));
    Ok(())
}

fn journal(folder: &Path) -> Attempt {
    let finished = Finished::read(folder).map_err(text)?;
    let mut outcomes = finished.outcomes().map_err(text)?;
    for index in 0..10 {
        outcomes.get(index).map_err(text)?;
    }
    let header = lines::header(folder).map_err(text)?;
    let (mut journal, _) = Journal::resume(folder, &header).map_err(text)?;
    journal.append(3, &Ok(vec![1.0]), None).map_err(text)
}

fn table(bench: &Bench, path: &Path) -> Attempt {
    let package = Package::open(&bench.path("lag.fmu")).map_err(text)?;
    let study = Study::read(&bench.path("study.toml")).map_err(text)?;
    let plan = Plan::new(&study, package.description()).map_err(text)?;
    let source = PointSource::from_table(&study, &plan.inputs, path).map_err(text)?;
    let _ = (source.label(0), source.parameters(source.len() - 1), source.index_of(7));
    Table::read(path, &[]).map(drop).map_err(text)
}

fn set(bench: &Bench, path: &Path) -> Attempt {
    let package = Package::open(&bench.path("lag.fmu")).map_err(text)?;
    ssv::read(path, package.description()).map(drop).map_err(text)
}

/// A folder with everything in it, and a finished study in `out`.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.write("study.toml", STUDY);
    bench.write("start.ssv", SET);
    bench.write("drive.csv", "time,drive.u\n0,0\n1,1\n2,1\n");
    let said = bench.run(&["verify", "study.toml", "--output", "out"]);
    assert_eq!(said.code, 0, "{}", said.err);
    fs::create_dir(bench.path("folder")).unwrap();
    bench.write("folder/modelDescription.xml", &crate::support::model("", ""));
    bench
}

/// A kind of file to mutate, and its reader.
type Kind<'a> = (&'a str, Box<dyn Fn(&Path) -> Attempt + 'a>);

fn kinds(bench: &Bench) -> Vec<Kind<'_>> {
    let results = |_: &Path| table::read(&bench.path("out")).map(drop).map_err(text);
    vec![
        ("lag.fmu", Box::new(|path| fmu(bench, path))),
        ("folder/modelDescription.xml", Box::new(|_| study(&bench.path("folder"), &bench.path("study.toml")))),
        ("study.toml", Box::new(|path| study(&bench.path("lag.fmu"), path))),
        ("out/journal.txt", Box::new(|_| journal(&bench.path("out")))),
        ("out/points.csv", Box::new(move |path| table(bench, path).and_then(|()| results(path)))),
        ("out/summary.json", Box::new(results)),
        ("start.ssv", Box::new(|path| set(bench, path))),
        ("drive.csv", Box::new(|_| study(&bench.path("lag.fmu"), &bench.path("study.toml")))),
    ]
}

/// Reads mutated files in this process, one of each kind for every seed.
fn mutations(seeds: Range<u64>) {
    let bench = bench();
    for (name, read) in kinds(&bench) {
        let original = fs::read(bench.path(name)).unwrap();
        assert!(read(&bench.path(name)).is_ok(), "{name}");
        fs::write(bench.path(name), &original).unwrap();
        let [mut errors, mut sound] = [0, 0];
        for seed in seeds.clone() {
            let mutated = mutate(&original, &mut StdRng::seed_from_u64(seed));
            fs::write(bench.path(name), &mutated).unwrap();
            match catch_unwind(AssertUnwindSafe(|| read(&bench.path(name)))) {
                Ok(Ok(())) => sound += 1,
                Ok(Err(error)) => {
                    errors += 1;
                    assert!(!error.trim().is_empty() && !error.contains('\n'), "{name}, seed {seed}: {error}");
                }
                Err(_) => panic!("{name}, seed {seed}: a panic"),
            }
        }
        fs::write(bench.path(name), &original).unwrap();
        println!("{name}: seeds {seeds:?}, {errors} clear errors, {sound} still make sense");
    }
}

/// The note on a journal's lines whose checksum is wrong. A last line without an end is none.
fn note_of_damage(journal: &[u8]) -> String {
    let is_sound = |line: &[u8]| {
        let text = std::str::from_utf8(line).ok();
        let parts = text.and_then(|text| text.split_once(' '));
        parts.is_some_and(|(sum, text)| u32::from_str_radix(sum, 16) == Ok(crc32fast::hash(text.as_bytes())))
    };
    let lines = journal.split_inclusive(|&byte| byte == b'\n');
    let whole = lines.filter_map(|line| line.strip_suffix(b"\n"));
    let what = match whole.filter(|line| !is_sound(line)).count() {
        0 => return String::new(),
        1 => "1 damaged line".to_owned(),
        damaged => format!("{damaged} damaged lines"),
    };
    format!("note: {what} of out/journal.txt: those points run again")
}

/// Hands mutated files to the command line, one of each kind for every seed.
fn commands(seeds: Range<u64>) {
    let bench = bench();
    let dry = ["verify", "study.toml", "--dry-run"];
    let cases: [(&str, &[&str]); 6] = [
        ("lag.fmu", &["inspect", "lag.fmu"]),
        ("folder/modelDescription.xml", &["inspect", "folder", "--json"]),
        ("study.toml", &dry),
        ("out/journal.txt", &["verify", "study.toml", "--output", "out", "--resume"]),
        ("out/points.csv", &["judge", "study.toml", "out/points.csv"]),
        ("start.ssv", &dry),
    ];
    for (name, command) in &cases {
        let original = fs::read(bench.path(name)).unwrap();
        for seed in seeds.clone() {
            let mutated = mutate(&original, &mut StdRng::seed_from_u64(seed));
            fs::write(bench.path(name), &mutated).unwrap();
            let said = bench.run(command);
            let lines = said.err.trim_end().lines().count();
            // A damaged line of the journal costs that line, and is told.
            let told = match *name {
                "out/journal.txt" => note_of_damage(&mutated),
                _ => String::new(),
            };
            let clear = match said.code {
                0 | 1 => said.err.trim_end() == told,
                2 => lines == 1 && said.err.starts_with("error: "),
                _ => false,
            };
            assert!(clear, "{name}, seed {seed}: {} {}", said.code, said.err);
        }
        fs::write(bench.path(name), &original).unwrap();
    }
    println!(
        "{} commands with mutated files (seeds {seeds:?}), none of them surprised",
        (seeds.end - seeds.start) * cases.len() as u64
    );
}

// The ordinary run damages the same files in the same way every time. A seed that fails in the long run gets a
// test of its own here, of the range that holds it alone.

#[test]
fn damaged_files_give_clear_errors() {
    mutations(0..40);
}

#[test]
fn damaged_files_on_the_command_line() {
    commands(1_000_000..1_000_003);
}

/// From the seed `MUTATION_SEED` on: `scripts/test --long` draws one.
#[test]
#[ignore = "takes minutes: cargo test -p orchestrator --test cli mutations -- --ignored --nocapture"]
fn ten_thousand_damaged_files() {
    let first = std::env::var("MUTATION_SEED").map_or(0, |seed| seed.parse().unwrap());
    mutations(first..first + 1200);
    commands(first + 1_000_000..first + 1_000_075);
}
