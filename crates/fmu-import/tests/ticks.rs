//! An FMU of FMI 3.0 of our own with clocks, events, sizes and bytes, compiled here, whose solution is known: in Model Exchange, and in
//! Co-Simulation with event mode.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;

use fmu_import::{Instance, Interface, Package, Value, Version};
use tempfile::TempDir;

const DESCRIPTION: &str = include_str!("fixtures/ticks.xml");
const INTERFACES: [Interface; 2] = [Interface::CoSimulation, Interface::ModelExchange];

struct Bench {
    _folder: TempDir,
    package: Package,
    instance: Instance,
}

impl Bench {
    fn new(interface: Interface, sizes: &[(u32, u64)]) -> Self {
        Self::of(DESCRIPTION, interface, sizes)
    }

    fn of(description: &str, interface: Interface, sizes: &[(u32, u64)]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let other = match interface {
            Interface::CoSimulation => "<ModelExchange ",
            Interface::ModelExchange => "<CoSimulation ",
        };
        let lines = description.lines().filter(|line| !line.trim().starts_with(other));
        let description: Vec<&str> = lines.collect();
        fs::write(folder.path().join("modelDescription.xml"), description.join("\n")).unwrap();
        let binaries = folder.path().join("binaries");
        let binaries = binaries.join(Version::Three.platform());
        fs::create_dir_all(&binaries).unwrap();
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/ticks.c");
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-Wall", "-o"])
            .arg(binaries.join("ticks.so"))
            .args([source, "-lm"])
            .status();
        assert!(status.unwrap().success());
        let mut package = Package::open(folder.path()).unwrap();
        package.resize(sizes).unwrap();
        assert_eq!(package.description().interface, interface);
        let library = package.load().unwrap();
        let instance = Instance::new(&library, "one").unwrap();
        Self { _folder: folder, package, instance }
    }

    fn set(&mut self, name: &str, value: Value) {
        let handle = self.package.description().variables[name].handle();
        self.instance.set(handle.reference, &value).unwrap();
    }

    fn value(&mut self, name: &str) -> Value {
        let handle = self.package.description().variables[name].handle();
        self.instance.value(handle).unwrap()
    }

    fn number(&mut self, name: &str) -> f64 {
        self.value(name).number()
    }

    fn start(&mut self) {
        self.instance.setup_experiment(0.0, 2.0, None).unwrap();
        let sizes = self.package.description().sizes.clone();
        self.instance.resize(&sizes).unwrap();
    }
}

/// How many of the times are not after a time, and which was the last one.
fn passed(times: impl Iterator<Item = f64>, time: f64) -> (f64, f64) {
    let passed = times.take_while(|tick| *tick < time + 1e-9);
    passed.fold((0.0, f64::NAN), |(count, _), tick| (count + 1.0, tick))
}

fn every(first: f64, interval: f64) -> impl Iterator<Item = f64> {
    (0..).map(move |k| first + f64::from(k) * interval)
}

/// The FMU itself refuses ticks at other times.
#[test]
fn clocks_tick_at_their_times() {
    for interface in INTERFACES {
        let mut bench = Bench::new(interface, &[]);
        bench.start();
        bench.set("period", Value::Real(0.35));
        bench.instance.initialise().unwrap();
        for step in 0..20 {
            let before = 0.1 * f64::from(step);
            bench.instance.step(before, 0.1).unwrap();
            let time = 0.1 * f64::from(step + 1);
            let at = |what: &str| format!("{what} at {time} s of {interface:?}");
            let (samples, last) = passed(every(0.1, 0.25), time);
            let ramp = |time: f64| (time + 0.25).fract();
            let sampled = bench.number("sampled");
            assert!((sampled - ramp(last)).abs() < 1e-9, "{}", at("sampled"));
            assert!((bench.number("ramp") - ramp(time)).abs() < 1e-9, "{}", at("ramp"));
            let growing = (1..).map(|n| 0.05 * f64::from(n * (n + 1)));
            for (name, count) in [
                ("counted", passed(every(0.05, 0.35), time).0),
                ("grown", passed(growing, time).0),
                ("delayed", passed(every(0.15, 0.25), time).0),
                ("bells", passed(every(0.4, 0.4), time).0),
                ("edges", passed(every(0.75, 1.0), time).0),
                ("tunedTicks", passed(every(0.02, 0.3), time).0),
                ("givenTicks", passed(every(0.15, 0.2), time).0),
            ] {
                assert_eq!(bench.number(name), count, "{}", at(name));
            }
            // A clock says whether it has ticked in the step.
            let ticked = samples > passed(every(0.1, 0.25), before).0;
            assert_eq!(bench.value("sample"), Value::Boolean(ticked), "{}", at("sample"));
            let rung = passed(every(0.4, 0.4), time).0 > passed(every(0.4, 0.4), before).0;
            assert_eq!(bench.value("rung"), Value::Boolean(rung), "{}", at("rung"));
        }
        bench.instance.terminate().unwrap();
        // Another simulation on the same instance is as the first.
        bench.instance.reset().unwrap();
        bench.start();
        bench.instance.initialise().unwrap();
        bench.instance.step(0.0, 0.1).unwrap();
        assert_eq!(bench.number("grown"), 1.0);
        assert_eq!(bench.number("counted"), 1.0);
    }
}

/// A tunable clock counts its interval from where it changes: 0.02 s, 0.32 s; from 0.5 s on every 0.15 s; from 1 s on every 0.5 s.
#[test]
fn a_clock_follows_its_tunable_parameter() {
    let times = [0.02, 0.32, 0.65, 0.8, 0.95, 1.5, 2.0];
    for interface in INTERFACES {
        let mut bench = Bench::new(interface, &[]);
        bench.start();
        bench.instance.initialise().unwrap();
        for step in 0..20 {
            let before = 0.1 * f64::from(step);
            match step {
                5 => bench.set("pace", Value::Real(0.15)),
                10 => bench.set("pace", Value::Real(0.5)),
                _ => {}
            }
            bench.instance.step(before, 0.1).unwrap();
            let time = 0.1 * f64::from(step + 1);
            let (count, _) = passed(times.into_iter(), time);
            assert_eq!(bench.number("tunedTicks"), count, "{time} s of {interface:?}");
        }
    }
}

#[test]
fn a_triggered_input_ticks_where_it_is_set_with_its_input() {
    for interface in INTERFACES {
        let mut bench = Bench::new(interface, &[]);
        bench.start();
        bench.set("push", Value::Boolean(false));
        bench.set("amount", Value::Real(1.0));
        bench.instance.initialise().unwrap();
        assert_eq!(bench.number("sum"), 0.0);
        let mut sums = Vec::new();
        for (step, (push, amount)) in [(true, 2.0), (false, 5.0), (true, 5.0), (true, 7.0)].into_iter().enumerate() {
            bench.set("amount", Value::Real(amount));
            bench.set("push", Value::Boolean(push));
            bench.instance.step(0.1 * step as f64, 0.1).unwrap();
            sums.push(bench.number("sum"));
            assert_eq!(bench.value("push"), Value::Boolean(push));
        }
        assert_eq!(sums, [2.0, 2.0, 7.0, 14.0], "{interface:?}");
    }
}

#[test]
fn a_discrete_input_changes_by_an_event() {
    for interface in INTERFACES {
        let mut bench = Bench::new(interface, &[]);
        bench.start();
        bench.instance.initialise().unwrap();
        for (step, value) in [0.0, 3.0, 3.0, 4.0].into_iter().enumerate() {
            bench.set("step", Value::Real(value));
            bench.instance.step(0.1 * step as f64, 0.1).unwrap();
        }
        assert_eq!(bench.number("steps"), 2.0, "{interface:?}");
    }
}

/// Without clocks an FMU handles its events within its steps, unless it says that it cannot.
#[test]
fn an_fmu_that_insists_on_event_mode_gets_it() {
    let clocks = |line: &&str| line.contains("<Clock ");
    let lines = DESCRIPTION.lines().filter(|line| !clocks(line));
    let description = lines.collect::<Vec<_>>().join("\n");
    let mut bench = Bench::of(&description, Interface::CoSimulation, &[]);
    bench.start();
    bench.instance.initialise().unwrap();
    assert_eq!(bench.number("ramp"), 0.25);
}

/// Real variables are read together, whether they belong to a clock or not.
#[test]
fn clocked_variables_are_read_with_others() {
    let mut bench = Bench::new(Interface::CoSimulation, &[]);
    bench.start();
    bench.instance.initialise().unwrap();
    let reference = |name: &str| {
        let handle = bench.package.description().variables[name].handle();
        handle.reference
    };
    let references = ["ramp", "sampled", "doubled[2]"].map(reference);
    let mut rows = [0.0; 6];
    let (times, sizes) = ([0.0, 0.25], [0.25, 0.25]);
    let (done, outcome) = bench.instance.steps(&times, &sizes, &references, &mut rows);
    outcome.unwrap();
    assert_eq!(done, 2);
    for (value, expected) in rows.iter().zip([0.5, 0.35, 4.0, 0.75, 0.6, 4.0]) {
        assert!((value - expected).abs() < 1e-9, "{rows:?}");
    }
}

#[test]
fn sizes_are_set_before_all_else() {
    for interface in INTERFACES {
        for size in [1_u64, 2, 3] {
            let mut bench = Bench::new(interface, &[(200, size)]);
            let variables = &bench.package.description().variables;
            let of_array = |name: &&String| name.starts_with("weights[");
            assert_eq!(variables.keys().filter(of_array).count() as u64, size);
            assert_eq!(variables["N"].kind.start(), Some(size as f64));
            for _ in 0..2 {
                bench.start();
                for index in 1..=size {
                    bench.set(&format!("weights[{index}]"), Value::Real(index as f64));
                }
                bench.instance.initialise().unwrap();
                // There are as many event indicators, the last of which changes its sign at 0.75 s.
                for step in 0..8 {
                    bench.instance.step(0.1 * f64::from(step), 0.1).unwrap();
                }
                assert_eq!(bench.number("edges"), 1.0);
                assert_eq!(bench.number(&format!("doubled[{size}]")), 2.0 * size as f64);
                assert_eq!(bench.number("N"), size as f64);
                bench.instance.reset().unwrap();
            }
        }
    }
}

#[test]
fn every_whole_number_and_bytes_come_back() {
    let mut bench = Bench::new(Interface::CoSimulation, &[]);
    bench.start();
    let start = |name: &str| bench.package.description().variables[name].kind.start_value();
    assert_eq!(start("big"), Some(Value::Integer(u64::MAX.into())));
    assert_eq!(start("data"), Some(Value::String("00ff".to_owned())));
    assert_eq!(bench.value("big"), Value::Integer(u64::MAX.into()));
    bench.set("big", Value::Integer((1 << 63) + 1));
    bench.instance.initialise().unwrap();
    assert_eq!(bench.value("big"), Value::Integer((1 << 63) + 1));
    assert_eq!(bench.value("turned"), Value::String("ff00".to_owned()));
    bench.set("data", Value::String("0A0b0c".to_owned()));
    assert_eq!(bench.value("turned"), Value::String("0c0b0a".to_owned()));
    bench.set("data", Value::String(String::new()));
    assert_eq!(bench.value("turned"), Value::String(String::new()));
    let data = bench.package.description().variables["data"].handle();
    let wrong = Value::String("abc".to_owned());
    let refused = bench.instance.set(data.reference, &wrong).unwrap_err();
    assert!(refused.to_string().contains("does not fit"), "{refused}");
}
