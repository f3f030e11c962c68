//! A small FMU for Model Exchange of our own, compiled here, whose solution is known.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;
use std::sync::Arc;

use fmu_import::archive::PLATFORM;
use fmu_import::{Call, Instance, Interface, Library, Package, Value};
use tempfile::TempDir;

const DESCRIPTION: &str = include_str!("fixtures/ball.xml");
const GRAVITY: f64 = 9.81;
const RESTITUTION: f64 = 0.7;

/// An instance, and how its variables are reached.
struct Bench {
    _folder: TempDir,
    package: Package,
    _library: Arc<Library>,
    instance: Instance,
}

impl Bench {
    fn new(macros: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("modelDescription.xml"), DESCRIPTION).unwrap();
        let binaries = folder.path().join("binaries").join(PLATFORM);
        fs::create_dir_all(&binaries).unwrap();
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .arg(binaries.join("ball.so"))
            .args(macros.iter().map(|name| format!("-D{name}")))
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/ball.c"))
            .arg("-lm")
            .status()
            .unwrap();
        assert!(status.success());
        let mut package = Package::open(folder.path()).unwrap();
        assert_eq!(package.description().interface, Interface::ModelExchange);
        let library = package.load().unwrap();
        let instance = Instance::new(&library, "one").unwrap();
        Self { _folder: folder, package, _library: library, instance }
    }

    fn reference(&self, name: &str) -> u32 {
        self.package.description().variables[name].handle().reference
    }

    fn set(&mut self, name: &str, value: Value) {
        let reference = self.reference(name);
        self.instance.set(reference, &value).unwrap();
    }

    fn get(&mut self, name: &str) -> f64 {
        let handle = self.package.description().variables[name].handle();
        self.instance.value(handle).unwrap().number()
    }

    fn start(&mut self, tolerance: f64) {
        self.start_until(10.0, tolerance);
    }

    fn start_until(&mut self, stop: f64, tolerance: f64) {
        self.instance.setup_experiment(0.0, stop, Some(tolerance)).unwrap();
        self.instance.initialise().unwrap();
    }

    /// Even steps up to a time, s.
    fn run(&mut self, until: f64, steps: u32) -> Result<(), Call> {
        let at = |index: u32| until * f64::from(index) / f64::from(steps);
        (0..steps).try_for_each(|index| self.instance.step(at(index), at(index + 1) - at(index)))
    }
}

/// Height and speed of the ball, and how often it has bounced.
fn ball(time: f64) -> (f64, f64, u32) {
    let (mut bounces, mut speed) = (0, (2.0 * GRAVITY).sqrt());
    let mut left = time - speed / GRAVITY;
    if left < 0.0 {
        return (1.0 - 0.5 * GRAVITY * time * time, -GRAVITY * time, 0);
    }
    loop {
        bounces += 1;
        speed *= RESTITUTION;
        let flight = 2.0 * speed / GRAVITY;
        if left < flight {
            let height = speed * left - 0.5 * GRAVITY * left * left;
            return (height, speed - GRAVITY * left, bounces);
        }
        left -= flight;
    }
}

/// Some steps hold no bounce, others several; a bounce lies where it belongs, whatever the communication points.
#[test]
fn a_ball_bounces_when_it_should() {
    for steps in [1, 7, 100] {
        let mut bench = Bench::new(&[]);
        bench.start(1e-10);
        bench.run(2.0, steps).unwrap();
        let (height, speed, bounces) = ball(2.0);
        assert!((bench.get("h") - height).abs() < 1e-8, "{} {height}", bench.get("h"));
        assert!((bench.get("v") - speed).abs() < 1e-8, "{} {speed}", bench.get("v"));
        assert_eq!(bench.get("bounces"), f64::from(bounces));
        assert!(bounces > 2);
        // At 2 s the clock has counted its eighth quarter: an event at a communication point belongs to it.
        assert_eq!(bench.get("count"), 8.0);
        bench.instance.terminate().unwrap();
    }
}

#[test]
fn a_stiff_state_is_followed_in_few_steps() {
    let mut bench = Bench::new(&[]);
    bench.start(1e-6);
    bench.run(2.0, 20).unwrap();
    // s' = -k (s - cos t) is cos t but for 1/k.
    assert!((bench.get("s") - 2.0_f64.cos()).abs() < 2e-5, "{}", bench.get("s"));
    let handle = fmu_import::Handle { reference: 4, content: fmu_import::Content::Integer };
    let steps = bench.instance.value(handle).unwrap().number();
    assert!(steps < 500.0, "{steps} steps");
}

/// y' = 2 (u - y) with u = t is exact where u has its value of that time in every evaluation.
#[test]
fn an_input_varies_within_a_step() {
    let exact = |t: f64| t - 0.5 + 0.5 * (-2.0 * t).exp();
    let mut bench = Bench::new(&[]);
    bench.start(1e-10);
    let u = bench.reference("u");
    for index in 0..4 {
        let time = f64::from(index) * 0.5;
        bench.instance.set(u, &Value::Real(time)).unwrap();
        bench.instance.set_slope(u, 1.0).unwrap();
        bench.instance.step(time, 0.5).unwrap();
        let y = bench.get("y");
        assert!((y - exact(time + 0.5)).abs() < 1e-9, "{y} {}", exact(time + 0.5));
        assert!((bench.get("u") - time - 0.5).abs() < 1e-15);
    }
    // One that is set without a rate keeps its value.
    bench.instance.set(u, &Value::Real(3.0)).unwrap();
    let before = bench.get("y");
    bench.instance.step(2.0, 0.5).unwrap();
    let after = 3.0 + (before - 3.0) * (-1.0_f64).exp();
    assert!((bench.get("y") - after).abs() < 1e-9);
}

#[test]
fn a_discrete_input_changes_by_an_event() {
    let mut bench = Bench::new(&[]);
    bench.start(1e-10);
    bench.run(0.2, 2).unwrap();
    bench.set("kick", Value::Integer(3));
    bench.instance.step(0.2, 0.1).unwrap();
    let speed = -GRAVITY * 0.3 + 3.0;
    assert!((bench.get("v") - speed).abs() < 1e-10);
}

#[test]
fn an_fmu_is_not_told_the_tolerance_of_the_solver() {
    let mut bench = Bench::new(&[]);
    bench.start(1e-10);
    assert_eq!(bench.instance.warnings().count, 0);
}

/// By the standard it is set in initialisation mode, not before.
#[test]
fn a_discrete_input_has_its_first_value_in_initialisation_mode() {
    let mut bench = Bench::new(&["LATE"]);
    bench.set("kick", Value::Integer(2));
    bench.set("kick", Value::Integer(3));
    bench.start(1e-10);
    assert_eq!(bench.get("kick"), 3.0);
    bench.instance.reset().unwrap();
    bench.start(1e-10);
    assert_eq!(bench.get("kick"), 0.0);
}

/// By rounding a step ends before or after the communication point, and its derivative over time looks ahead.
#[test]
fn time_never_goes_back_nor_past_the_stop() {
    // The event at 0.25 s belongs to the communication point that lies one rounding before it.
    let mut bench = Bench::new(&["STRICT"]);
    bench.start_until(10.0, 1e-6);
    let point = 0.25_f64.next_down();
    bench.instance.step(0.0, point).unwrap();
    assert_eq!(bench.get("count"), 1.0);
    bench.instance.step(point, 0.1).unwrap();
    // An event that lies one rounding after the stop is none of this simulation.
    let mut bench = Bench::new(&["STRICT"]);
    bench.start_until(point, 1e-6);
    bench.instance.step(0.0, point).unwrap();
    assert_eq!(bench.get("count"), 0.0);
    // The clock's event lies just before the stop.
    let mut bench = Bench::new(&["STRICT"]);
    bench.start_until(0.25 + 1e-10, 1e-6);
    bench.instance.step(0.0, 0.25 + 1e-10).unwrap();
    assert_eq!(bench.get("count"), 1.0);
}

#[test]
fn the_fmu_may_end_the_simulation_at_an_event() {
    let mut bench = Bench::new(&[]);
    bench.set("last", Value::Integer(1));
    bench.start(1e-10);
    let call = bench.run(2.0, 3).unwrap_err();
    let fall = (2.0 / GRAVITY).sqrt();
    let end = call.ended.unwrap();
    assert!((end.at - fall).abs() < 1e-9 && end.from == 0.0, "{end:?} {fall}");
    bench.instance.terminate().unwrap();
}

#[test]
fn an_end_at_a_communication_point_is_told_by_the_step_to_it() {
    let mut bench = Bench::new(&["ENDS"]);
    bench.start(1e-6);
    bench.instance.step(0.0, 0.5).unwrap();
    let call = bench.instance.step(0.5, 0.25).unwrap_err();
    let end = call.ended.unwrap();
    assert_eq!((end.from, end.at), (0.5, 0.75));
}

#[test]
fn a_reset_takes_everything_back() {
    let mut bench = Bench::new(&[]);
    let run = |bench: &mut Bench| {
        bench.start(1e-8);
        bench.run(1.7, 9).unwrap();
        ["h", "v", "s", "y", "count"].map(|name| bench.get(name).to_bits())
    };
    bench.set("rate", Value::Real(5.0));
    bench.set("u", Value::Real(2.0));
    let other = run(&mut bench);
    bench.instance.reset().unwrap();
    let first = run(&mut bench);
    assert_ne!(first, other);
    assert_eq!(first, run(&mut Bench::new(&[])));
}

#[test]
fn what_cannot_be_integrated_is_an_error() {
    let mut bench = Bench::new(&["SPOILT"]);
    bench.start(1e-6);
    let call = bench.run(1.0, 1).unwrap_err();
    assert!(call.to_string().contains("the rate of the continuous state 3 is NaN at 0 s"), "{call}");
    assert!(call.ended.is_none());
}

#[test]
fn many_steps_at_once_are_as_one_after_another() {
    let mut one = Bench::new(&[]);
    let mut other = Bench::new(&[]);
    one.start(1e-6);
    other.start(1e-6);
    let references = ["h", "v", "s"].map(|name| one.reference(name));
    let times: Vec<f64> = (0..20).map(|index| f64::from(index) * 0.05).collect();
    let mut rows = [0.0; 60];
    let (done, outcome) = one.instance.steps(&times, &[0.05; 20], &references, &mut rows);
    outcome.unwrap();
    assert_eq!(done, 20);
    for (time, row) in times.iter().zip(rows.chunks(3)) {
        other.instance.step(*time, 0.05).unwrap();
        let mut values = [0.0; 3];
        other.instance.reals(&references, &mut values).unwrap();
        assert_eq!(row, values);
    }
}
