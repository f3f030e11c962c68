//! A small FMU of FMI 3.0 for Model Exchange of our own, compiled here, whose solution is known.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;

use fmu_import::{Instance, Interface, Package, Value, Version};
use tempfile::TempDir;

const DESCRIPTION: &str = include_str!("fixtures/lags.xml");

struct Bench {
    _folder: TempDir,
    package: Package,
    instance: Instance,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("modelDescription.xml"), DESCRIPTION).unwrap();
        let binaries = folder.path().join("binaries");
        let binaries = binaries.join(Version::Three.platform());
        fs::create_dir_all(&binaries).unwrap();
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/lags.c");
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O1", "-o"])
            .arg(binaries.join("lags.so"))
            .args([source, "-lm"])
            .status();
        assert!(status.unwrap().success());
        let mut package = Package::open(folder.path()).unwrap();
        assert_eq!(package.description().interface, Interface::ModelExchange);
        let library = package.load().unwrap();
        let instance = Instance::new(&library, "one").unwrap();
        Self { _folder: folder, package, instance }
    }

    fn set(&mut self, name: &str, value: Value) {
        let handle = self.package.description().variables[name].handle();
        self.instance.set(handle.reference, &value).unwrap();
    }

    fn get(&mut self, name: &str) -> f64 {
        let handle = self.package.description().variables[name].handle();
        self.instance.value(handle).unwrap().number()
    }

    fn start(&mut self) {
        self.instance.setup_experiment(0.0, 1.0, Some(1e-10)).unwrap();
        self.instance.initialise().unwrap();
    }
}

/// The binary has no function for steps of Co-Simulation, which Model Exchange never calls.
#[test]
fn inputs_of_every_width_and_elements_of_arrays_reach_the_states() {
    let mut bench = Bench::new();
    bench.set("begin[2]", Value::Real(3.0));
    bench.set("u", Value::Real(0.5));
    bench.start();
    bench.instance.step(0.0, 0.5).unwrap();
    // A continuous Float32 flows, and an integer changes by an event.
    bench.set("f", Value::Real(0.5));
    bench.set("n", Value::Integer(7));
    bench.instance.step(0.5, 0.5).unwrap();
    assert_eq!(bench.get("count"), 1.0);
    for (index, begin) in [0.0, 3.0, 0.0].into_iter().enumerate() {
        let number = index + 1;
        let decay = (-(number as f64)).exp();
        let middle = 0.75 + (begin - 0.75) * decay;
        let exact = 1.0 + (middle - 1.0) * decay;
        let y = bench.get(&format!("y[{number}]"));
        assert!((y - exact).abs() < 1e-8, "{number}: {y} {exact}");
    }
}

#[test]
fn a_failure_names_the_function_of_this_version() {
    let mut bench = Bench::new();
    bench.set("until", Value::Real(0.3));
    bench.start();
    let call = bench.instance.step(0.0, 0.5).unwrap_err();
    assert_eq!(call.function, "fmi3CompletedIntegratorStep");
    let text = call.to_string();
    assert!(text.contains("the internal step fell below"), "{text}");
    assert!(text.contains("s at 0.3 s") || text.contains("s at 0.29999"), "{text}");
}
