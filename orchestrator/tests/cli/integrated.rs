//! FMUs for Model Exchange: the orchestrator integrates their equations.

use crate::support::{BALL, Bench};

const STUDY: &str = r#"
fmu = "ball.fmu"
[simulation]
stop = 1.5
step = 0.05
tolerance = 1e-10
[design]
method = "sobol"
points = 48
seed = 5
[parameters.height]
distribution = "uniform"
min = 0.5
max = 1.5
[parameters.restitution]
distribution = "uniform"
min = 0.8
max = 0.95
[criteria.h]
variable = "h"
statistic = "max"
nominal = 1
tolerance = "80 %"
[criteria.v]
variable = "v"
statistic = "final"
nominal = 0
tolerance = 3
"#;

fn bench() -> Bench {
    let bench = Bench::empty();
    bench.ball("ball.fmu", &[], BALL);
    bench.write("study.toml", STUDY);
    bench
}

/// Height and speed of a ball that fell from a height.
fn ball(time: f64, height: f64, restitution: f64) -> (f64, f64) {
    const GRAVITY: f64 = 9.81;
    let mut speed = (2.0 * GRAVITY * height).sqrt();
    let mut left = time - speed / GRAVITY;
    if left < 0.0 {
        return (height - 0.5 * GRAVITY * time * time, -GRAVITY * time);
    }
    loop {
        speed *= restitution;
        let flight = 2.0 * speed / GRAVITY;
        if left < flight {
            let height = speed * left - 0.5 * GRAVITY * left * left;
            return (height, speed - GRAVITY * left);
        }
        left -= flight;
    }
}

#[test]
fn inspect_and_check_know_the_interface() {
    let bench = bench();
    let said = bench.run(&["inspect", "ball.fmu"]);
    assert!(said.out.contains("Ball (FMI 2.0 for Model Exchange)"), "{}{}", said.out, said.err);
    let said = bench.run(&["check", "ball.fmu"]);
    assert_eq!((said.code, said.out.trim()), (0, "ball.fmu: nothing found"), "{}", said.err);
    bench.ball("spoilt.fmu", &["SPOILT"], BALL);
    let said = bench.run(&["check", "spoilt.fmu"]);
    assert_eq!(said.code, 1);
    assert!(said.out.contains("the rate of the continuous state 3 is NaN at 0 s"), "{}", said.out);
    // What an FMU writes beyond the counted ones nobody sees; what it leaves out is seen.
    bench.ball("few.fmu", &["ONE_INDICATOR"], BALL);
    let said = bench.run(&["check", "few.fmu"]);
    assert!(said.out.contains("counts 2 event indicators, of which the FMU computes 1"), "{}{}", said.out, said.err);
}

#[test]
fn simulate_finds_every_bounce() {
    let bench = bench();
    let said = bench.run(&["simulate", "ball.fmu", "--step", "0.01", "--stop", "2", "--output", "out.csv"]);
    assert_eq!(said.code, 0, "{}", said.err);
    let text = bench.read("out.csv");
    assert!(text.starts_with("time,h,v,y,s,count,bounces\n"), "{text}");
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let (height, speed) = ball(cells[0], 1.0, 0.7);
        assert!((cells[1] - height).abs() < 1e-7 && (cells[2] - speed).abs() < 1e-7, "{line}");
        assert_eq!(cells[5], (cells[0] / 0.25 + 1e-9).floor(), "{line}");
    }
    assert_eq!(text.lines().count(), 202);
}

#[test]
fn an_input_from_a_file_is_followed_within_steps() {
    let bench = bench();
    bench.write("u.csv", "time,u\n0,0\n2,2\n");
    let ramped = STUDY.replace(
        "[parameters.height]",
        "[inputs.u]\nfile = \"u.csv\"\ncolumn = \"u\"\nramp = true\n[parameters.height]",
    );
    let ramped = ramped + "[criteria.y]\nvariable = \"y\"\nstatistic = \"final\"\nnominal = 1\ntolerance = 1\n";
    bench.write("ramped.toml", &ramped);
    let said = bench.run(&["verify", "ramped.toml", "--points", "4", "--output", "ramped"]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let text = bench.read("ramped/points.csv");
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let place = rows.headers().unwrap().iter().position(|cell| cell == "y").unwrap();
    // y' = 2 (t - y).
    let exact = 1.5 - 0.5 + 0.5 * (-3.0_f64).exp();
    for row in rows.records() {
        let y: f64 = row.unwrap()[place].parse().unwrap();
        assert!((y - exact).abs() < 1e-8, "{y} {exact}");
    }
}

#[test]
fn verify_gives_the_same_in_every_way() {
    let bench = bench();
    let run = |isolation: &str, jobs: &str, output: &str| {
        let options = ["--points", "6", "--isolation", isolation, "--jobs", jobs, "--output", output];
        let said = bench.run(&[&["verify", "study.toml"], &options[..]].concat());
        assert_eq!(said.code, 0, "{}{}", said.out, said.err);
        bench.read(&format!("{output}/points.csv"))
    };
    let alone = run("fresh", "1", "fresh");
    assert_eq!(run("shared", "2", "shared"), alone);
    let mut rows = csv::Reader::from_reader(alone.as_bytes());
    let head = rows.headers().unwrap().clone();
    let place = |name: &str| head.iter().position(|cell| cell == name).unwrap();
    for row in rows.records() {
        let row = row.unwrap();
        let cell = |name: &str| row[place(name)].parse::<f64>().unwrap();
        let (_, speed) = ball(1.5, cell("height"), cell("restitution"));
        assert!((cell("v") - speed).abs() < 1e-6, "{row:?} {speed}");
    }
}
