//! FMUs of FMI 3.0: every command takes them as it takes those of 2.0.

use crate::support::{Bench, THREE, TICKS};

const STUDY: &str = r#"
fmu = "three.fmu"
[simulation]
stop = 2
step = 0.01
[design]
method = "sobol"
points = 64
seed = 3
[fixed]
"weights[3]" = 0
way = "down"
u16 = 65535
"text[2]" = "two"
[parameters.rate]
distribution = "uniform"
min = 30
max = 120
unit = "1/min"
[parameters."weights[1]"]
distribution = "uniform"
min = 0.5
max = 1.5
[parameters.gain]
distribution = "uniform"
min = 0.2
max = 0.8
[criteria.weighted]
variable = "weighted"
statistic = "final"
nominal = 2.6
tolerance = "10 %"
[criteria.gained]
variable = "gained"
statistic = "mean"
nominal = 0.3
tolerance = "50 %"
"#;

/// A folder with `three.fmu` and a study of it.
fn bench() -> Bench {
    let bench = Bench::empty();
    bench.three("three.fmu", &[], THREE);
    bench.write("study.toml", STUDY);
    bench
}

#[test]
fn inspect_and_init_show_its_variables() {
    let bench = bench();
    let said = bench.run(&["inspect", "three.fmu"]);
    assert_eq!(said.code, 0, "{}", said.err);
    for words in ["FMI 3.0 for Co-Simulation", "x86_64-linux", "weights[3]", "up"] {
        assert!(said.out.contains(words), "no {words} in {}", said.out);
    }
    let said = bench.run(&["inspect", "three.fmu", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    let named = |name: &str| {
        let all = json["variables"].as_array().unwrap();
        all.iter().find(|one| one["name"] == name).unwrap().clone()
    };
    assert_eq!(named("gain")["storage"], "Float32");
    assert_eq!(named("u8")["max"], 255);
    assert_eq!(named("weights[2]")["start"], 2.0);
    assert_eq!(named("weights[2]")["value_reference"], 6);
    let said = bench.run(&["init", "three.fmu", "--output", "new.toml"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(bench.read("new.toml").contains("\n\"weights[1]\" = {"));
}

#[test]
fn clocks_without_event_mode_are_refused_with_a_reason() {
    let bench = Bench::empty();
    let clock = "<Clock name=\"tick\" valueReference=\"77\" causality=\"input\" intervalVariability=\"triggered\"/>";
    let with = THREE.replace("  </ModelVariables>", &format!("{clock}</ModelVariables>"));
    bench.three("three.fmu", &[], &with);
    let said = bench.run(&["inspect", "three.fmu"]);
    assert!(said.out.contains("tick (a Clock"), "{}", said.out);
    bench.run(&["simulate", "three.fmu", "--set", "tick=1"]).is_mistake(&["`tick` cannot be used", "event mode"]);
    let said = bench.run(&["simulate", "three.fmu", "--output", "out.csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
}

#[test]
fn simulate_gives_the_exact_solution() {
    let bench = bench();
    let too_much = "u64=18446744073709551616";
    let said = bench.run(&["simulate", "three.fmu", "--set", too_much]);
    assert!(said.err.contains("does not fit into UInt64"), "{}", said.err);
    let said = bench.run(&[
        "simulate",
        "three.fmu",
        "--set",
        "rate=2",
        "--set",
        "weights[1]=5",
        "--set",
        "gain=0.25",
        "--set",
        "text[1]=a",
        "--output",
        "out.csv",
    ]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = bench.read("out.csv");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[0].split(',').take(4).collect::<Vec<_>>(), ["time", "y", "weighted", "gained"]);
    assert_eq!(lines.len(), 202);
    for line in &lines[1..] {
        let cell = |k: usize| line.split(',').nth(k).unwrap().parse::<f64>().unwrap();
        let y = 1.0 - (-2.0 * cell(0)).exp();
        assert!((cell(1) - y).abs() < 1e-13, "{line}");
        assert!((cell(2) - 10.0 * y).abs() < 1e-12, "{line}");
        assert_eq!(cell(3), f64::from(0.25_f32 * cell(1) as f32));
    }
    bench.run(&["simulate", "three.fmu", "--set", "u8=256"]).is_mistake(&["u8", "255"]);
    let ended = bench.run(&["simulate", "three.fmu", "--set", "until=0.5", "--output", "end.csv"]);
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert!(bench.read("end.csv").lines().last().unwrap().starts_with("0.5,"));
}

#[test]
fn verify_gives_the_same_in_every_way() {
    let bench = bench();
    let run = |isolation: &str, jobs: &str, output: &str| {
        let said = bench.run(&["verify", "study.toml", "--isolation", isolation, "--jobs", jobs, "--output", output]);
        assert_eq!(said.code, 0, "{}", said.err);
        bench.read(&format!("{output}/points.csv"))
    };
    let alone = run("fresh", "1", "fresh");
    assert_eq!(run("shared", "2", "shared"), alone);
    let summary = bench.summary("shared");
    assert_eq!((&summary["points"], &summary["failed"]), (&64.into(), &0.into()));
    let mut rows = csv::Reader::from_reader(alone.as_bytes());
    let head = rows.headers().unwrap().clone();
    let place = |name: &str| head.iter().position(|cell| cell == name).unwrap();
    for row in rows.records() {
        let row = row.unwrap();
        let cell = |name: &str| row[place(name)].parse::<f64>().unwrap();
        let y = 1.0 - (-2.0 * cell("rate") / 60.0).exp();
        let weighted = (cell("weights[1]") + 2.0) * y;
        assert!((cell("weighted") - weighted).abs() < 1e-12, "{row:?}");
    }
    // A resumed study is the same study.
    let half = bench.run(&["verify", "study.toml", "--points", "20", "--output", "half"]);
    assert_eq!(half.code, 0, "{}", half.err);
    let whole = bench.run(&["verify", "study.toml", "--resume", "--output", "fresh"]);
    assert_eq!(whole.code, 0, "{}", whole.err);
    assert_eq!(bench.read("fresh/points.csv"), alone);
}

#[test]
fn a_failed_point_has_the_words_of_its_version() {
    let bench = bench();
    bench.write("short.toml", &STUDY.replace("[fixed]", "[fixed]\nuntil = 1\nfatal = true"));
    let said = bench.run(&["verify", "short.toml", "--points", "4", "--output", "failed"]);
    assert_eq!(said.code, 3, "{}{}", said.out, said.err);
    let points = bench.read("failed/points.csv");
    assert!(points.contains("fmi3Fatal") && !points.contains("fmi2"), "{points}");
}

#[test]
fn a_good_fmu_has_nothing() {
    let bench = bench();
    let said = bench.run(&["check", "three.fmu"]);
    assert_eq!((said.code, said.out.trim()), (0, "three.fmu: nothing found"), "{}", said.err);
}

/// The columns of a csv file by their names.
fn column(text: &str, name: &str) -> Vec<String> {
    let mut lines = text.lines();
    let place = lines.next().unwrap().split(',').position(|n| n == name);
    let cell = |line: &str| line.split(',').nth(place.unwrap()).unwrap().to_owned();
    lines.map(cell).collect()
}

/// The FMU refuses a tick at another time; a triggered clock ticks where its column says so.
#[test]
fn clocks_tick_and_arrays_are_resized() {
    for interface in ["<ModelExchange ", "<CoSimulation "] {
        let bench = Bench::empty();
        let lines = TICKS.lines().filter(|line| !line.trim().starts_with(interface));
        bench.ticks("ticks.fmu", &lines.collect::<Vec<_>>().join("\n"));
        let said = bench.run(&["inspect", "ticks.fmu"]);
        for words in ["Sizes of arrays", "constant clock 0.25 s", "18446744073709551615", "\"00ff\""] {
            assert!(said.out.contains(words), "no {words} in {}", said.out);
        }
        let pushes = "time,push,amount\n0,false,0\n0.5,TRUE,2\n0.6,false,2\n1,true,3\n1.1,0,3\n2,0,3\n";
        bench.write("pushes.csv", pushes);
        let arguments = ["simulate", "ticks.fmu", "--input", "pushes.csv", "--set", "weights[3]=5", "--set", "N=3"];
        let more =
            ["--set", "data=0a0B", "--record", "sum,doubled[3],N,big,turned,grown,sample", "--output", "out.csv"];
        let said = bench.run(&[&arguments[..], &more[..]].concat());
        // Where the description has no start values for a size, those of the FMU count.
        assert_eq!(said.code, 0, "{}", said.err);
        let text = bench.read("out.csv");
        let sums = column(&text, "sum");
        assert_eq!([0, 5, 6, 10, 11, 20].map(|row| &*sums[row]), ["0", "0", "2", "2", "5", "5"]);
        for (name, value) in
            [("doubled[3]", "10"), ("N", "3"), ("big", "18446744073709551615"), ("turned", "0b0a"), ("grown", "5")]
        {
            assert_eq!(column(&text, name)[20], value, "{name}");
        }
        let ticks = column(&text, "sample").iter().filter(|cell| *cell == "1").count();
        assert_eq!(ticks, 8);
    }
}

/// Points run in processes of their own, which know the sizes, too.
#[test]
fn a_study_fixes_sizes() {
    let study = r#"
fmu = "ticks.fmu"
[simulation]
stop = 1
step = 0.1
[design]
method = "sobol"
points = 8
seed = 1
[fixed]
N = 4
"weights[4]" = 2
[parameters."weights[3]"]
distribution = "uniform"
min = 1
max = 3
[parameters.period]
distribution = "uniform"
min = 0.2
max = 0.4
[criteria.third]
variable = "doubled[3]"
statistic = "final"
nominal = 4
tolerance = 2
[criteria.fourth]
variable = "doubled[4]"
statistic = "final"
nominal = 4
tolerance = 0.001
[criteria.counted]
variable = "counted"
statistic = "final"
nominal = 3
tolerance = 2
"#;
    let bench = Bench::empty();
    bench.ticks("ticks.fmu", TICKS);
    bench.write("study.toml", study);
    for isolation in ["fresh", "shared"] {
        let said = bench.run(&["verify", "study.toml", "--isolation", isolation, "--output", isolation]);
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    }
    let points = bench.read("fresh/points.csv");
    assert_eq!(points, bench.read("shared/points.csv"));
    let smaller = study.replace("[3]", "[1]").replace("[4]", "[2]");
    let varied = smaller.replace("N = 4\n", "");
    bench.write("study.toml", &varied.replace("[parameters.period]", "[parameters.N]"));
    bench.run(&["verify", "study.toml"]).is_mistake(&["the size of arrays", "[fixed]"]);
}
