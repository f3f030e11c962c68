//! A small FMU of FMI 3.0 of our own, compiled here, seen through the public interface.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;
use std::sync::Arc;

use fmu_import::{Call, Content, Instance, Library, Package, Status, Value, Version};
use tempfile::TempDir;

const DESCRIPTION: &str = include_str!("fixtures/three.xml");

/// An unpacked FMU, compiled with these macros.
fn three(macros: &[&str], description: &str) -> (TempDir, Package) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("modelDescription.xml"), description).unwrap();
    let binaries = folder.path().join("binaries").join(Version::Three.platform());
    fs::create_dir_all(&binaries).unwrap();
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .arg(binaries.join("three.so"))
        .args(macros.iter().map(|name| format!("-D{name}")))
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/three.c"))
        .arg("-lm")
        .status()
        .unwrap();
    assert!(status.success());
    let package = Package::open(folder.path()).unwrap();
    (folder, package)
}

/// An FMU with an instance, and how its variables are reached.
struct Bench {
    _folder: TempDir,
    package: Package,
    library: Arc<Library>,
    instance: Instance,
}

impl Bench {
    fn new() -> Self {
        Self::of(&[], DESCRIPTION)
    }

    fn of(macros: &[&str], description: &str) -> Self {
        let (folder, mut package) = three(macros, description);
        let library = package.load().unwrap();
        let instance = Instance::new(&library, "one").unwrap();
        Self { _folder: folder, package, library, instance }
    }

    fn reference(&self, name: &str) -> u32 {
        self.package.description().variables[name].handle().reference
    }

    fn set(&mut self, name: &str, value: Value) -> Result<(), Call> {
        let reference = self.reference(name);
        self.instance.set(reference, &value)
    }

    fn get(&mut self, name: &str) -> Value {
        let handle = self.package.description().variables[name].handle();
        self.instance.value(handle).unwrap()
    }

    fn start(&mut self) {
        self.instance.setup_experiment(0.0, 2.0, None).unwrap();
        self.instance.initialise().unwrap();
    }
}

#[test]
fn it_steps_to_the_exact_solution() {
    let mut bench = Bench::new();
    bench.set("rate", Value::Real(3.0)).unwrap();
    bench.start();
    for index in 0..10 {
        bench.instance.step(f64::from(index) * 0.1, 0.1).unwrap();
    }
    let exact = 1.0 - (-3.0_f64).exp();
    let y = bench.get("y").number();
    assert!((y - exact).abs() < 1e-14, "{y} {exact}");
    assert_eq!(bench.get("weighted"), Value::Real(y + 2.0 * y + 3.0 * y));
    let folder = bench.get("resources");
    assert!(matches!(&folder, Value::String(path) if path.ends_with("/resources/")), "{folder:?}");
    bench.instance.terminate().unwrap();
    assert_eq!(bench.library.version().as_deref(), Some("3.0"));
    assert_eq!(bench.library.odd_version(), None);
}

/// An FMU may refuse to tell values before its initialisation.
#[test]
fn elements_are_set_without_reading_the_others() {
    let mut bench = Bench::of(&["SILENT"], DESCRIPTION);
    let weights = |bench: &mut Bench| {
        bench.start();
        ["weights[1]", "weights[2]", "weights[3]"].map(|name| bench.get(name).number())
    };
    bench.set("weights[2]", Value::Real(20.0)).unwrap();
    bench.set("text[2]", Value::String("b".to_owned())).unwrap();
    bench.set("weights[1]", Value::Real(10.0)).unwrap();
    assert_eq!(weights(&mut bench), [10.0, 20.0, 3.0]);
    assert_eq!(bench.get("text[2]"), Value::String("b".to_owned()));
    // An element that changes later leaves the others as they are then.
    bench.set("weights[1]", Value::Real(11.0)).unwrap();
    assert_eq!(bench.get("weights[2]"), Value::Real(20.0));
    bench.instance.reset().unwrap();
    bench.set("weights[1]", Value::Real(7.0)).unwrap();
    assert_eq!(weights(&mut bench), [7.0, 2.0, 3.0]);
    // Where the description has no start values, only the FMU could tell the other elements.
    let description = DESCRIPTION.replace(" start=\"1 2 3\"", "");
    let mut bench = Bench::of(&["SILENT"], &description);
    let call = bench.set("weights[2]", Value::Real(20.0)).unwrap_err();
    let text = call.to_string();
    assert!(text.contains("no start values for its other elements"), "{text}");
    assert!(text.contains("no values before the initialisation"), "{text}");
    let mut bench = Bench::of(&[], &description);
    bench.set("weights[2]", Value::Real(20.0)).unwrap();
    assert_eq!(weights(&mut bench), [1.0, 20.0, 3.0]);
}

#[test]
fn every_width_keeps_its_limits() {
    let mut bench = Bench::new();
    for (name, least, most) in [
        ("i8", i8::MIN.into(), i8::MAX.into()),
        ("u8", 0, u8::MAX.into()),
        ("i16", i16::MIN.into(), i16::MAX.into()),
        ("u16", 0, u16::MAX.into()),
        ("i32", i32::MIN.into(), i32::MAX.into()),
        ("u32", 0, u32::MAX.into()),
        ("i64", i64::MIN.into(), i64::MAX.into()),
        ("u64", 0, u64::MAX.into()),
    ] {
        for value in [least, most, 1] {
            bench.set(name, Value::Integer(value)).unwrap();
            assert_eq!(bench.get(name), Value::Integer(value), "{name}");
        }
        // Beyond its limits a value is refused, never wrapped.
        for beyond in [least - 1, most + 1] {
            let refused = bench.set(name, Value::Integer(beyond)).unwrap_err();
            assert!(refused.to_string().contains("does not fit"), "{refused}");
            assert_eq!(bench.get(name), Value::Integer(1), "{name}");
        }
    }
    bench.set("gain", Value::Real(0.1)).unwrap();
    assert_eq!(bench.get("gain"), Value::Real(f64::from(0.1_f32)));
    assert!(bench.set("gain", Value::Real(1e300)).is_err());
    assert!(bench.set("gain", Value::Integer(1)).is_err());
    bench.set("way", Value::Integer(2)).unwrap();
    assert_eq!(bench.get("way"), Value::Integer(2));
    bench.set("fatal", Value::Boolean(true)).unwrap();
    assert_eq!(bench.get("fatal"), Value::Boolean(true));
}

#[test]
fn an_element_of_an_array_is_set_alone() {
    let mut bench = Bench::new();
    bench.set("weights[2]", Value::Real(20.0)).unwrap();
    let weights = ["weights[1]", "weights[2]", "weights[3]"];
    assert_eq!(weights.map(|name| bench.get(name).number()), [1.0, 20.0, 3.0]);
    let references = weights.map(|name| bench.reference(name));
    let [y, gained] = ["u", "gained"].map(|name| bench.reference(name));
    let mixed = [references[2], y, references[0], gained, references[1]];
    let mut values = [9.0; 5];
    bench.instance.reals(&mixed, &mut values).unwrap();
    assert_eq!(values, [3.0, 1.0, 1.0, 0.0, 20.0]);
    bench.set("text[2]", Value::String("two".to_owned())).unwrap();
    bench.set("text[1]", Value::String("one".to_owned())).unwrap();
    let texts = ["text[1]", "text[2]"].map(|name| bench.get(name));
    assert_eq!(texts, ["one", "two"].map(|text| Value::String(text.to_owned())));
}

/// One call reads all elements of an array, until another call may have changed them.
#[test]
fn elements_one_after_the_other_take_one_call() {
    let mut bench = Bench::new();
    bench.start();
    let before = bench.get("reached").number();
    let read = |bench: &mut Bench| ["weights[1]", "weights[3]", "weights[2]"].map(|name| bench.get(name).number());
    assert_eq!(read(&mut bench), [1.0, 3.0, 2.0]);
    assert_eq!(bench.get("reached").number() - before, 1.0);
    assert_eq!(read(&mut bench), [1.0, 3.0, 2.0]);
    assert_eq!(bench.get("reached").number() - before, 2.0);
}

#[test]
fn many_steps_at_once_are_as_one_after_another() {
    let mut bench = Bench::new();
    let [y, gained] = ["y", "gained"].map(|name| bench.reference(name));
    bench.start();
    let times = [0.0, 0.1, 0.2];
    for references in [&[y][..], &[y, gained], &[]] {
        bench.instance.reset().unwrap();
        bench.start();
        let mut rows = [0.0; 6];
        let (done, outcome) = bench.instance.steps(&times, &[0.1; 3], references, &mut rows);
        outcome.unwrap();
        assert_eq!(done, 3);
        bench.instance.reset().unwrap();
        bench.start();
        for (index, time) in times.iter().enumerate() {
            bench.instance.step(*time, 0.1).unwrap();
            let mut row = [0.0; 2];
            let row = &mut row[..references.len()];
            bench.instance.reals(references, row).unwrap();
            let first = index * references.len();
            assert_eq!(rows[first..first + references.len()], *row);
        }
    }
}

/// What an early return leaves of a step is taken at once; to the importer the step is whole.
#[test]
fn a_step_that_returns_early_is_taken_to_its_end() {
    let mut bench = Bench::new();
    bench.set("early", Value::Real(0.3)).unwrap();
    bench.start();
    bench.instance.step(0.0, 0.5).unwrap();
    bench.instance.step(0.5, 0.5).unwrap();
    let exact = 1.0 - (-1.0_f64).exp();
    assert!((bench.get("y").number() - exact).abs() < 1e-14);
    assert!((bench.get("time").number() - 1.0).abs() < 1e-14);
    // One that gets nowhere is an error, not an endless loop.
    bench.instance.reset().unwrap();
    bench.set("early", Value::Real(2.0)).unwrap();
    bench.start();
    let stuck = bench.instance.step(0.0, 0.5).unwrap_err();
    assert!(stuck.to_string().contains("early") && stuck.ended.is_none(), "{stuck}");
}

#[test]
fn a_simulation_that_ends_by_itself_has_its_last_values() {
    let mut bench = Bench::new();
    bench.set("until", Value::Real(0.25)).unwrap();
    bench.start();
    bench.instance.step(0.0, 0.2).unwrap();
    let call = bench.instance.step(0.2, 0.2).unwrap_err();
    let end = call.ended.unwrap();
    assert_eq!((end.from, end.at), (0.2, 0.25));
    let exact = 1.0 - (-0.25_f64).exp();
    assert!((bench.get("y").number() - exact).abs() < 1e-14);
    bench.instance.terminate().unwrap();
}

#[test]
fn failures_have_the_names_of_their_version() {
    let mut bench = Bench::new();
    let early = bench.instance.step(0.0, 1.0).unwrap_err();
    let text = "fmi3Error: a step from another time (fmi3DoStep)";
    assert_eq!(early.to_string(), text);
    bench.start();
    let long = bench.instance.step(0.0, 11.0).unwrap_err();
    assert_eq!((long.status, long.ended), (Status::Discard, None));
    assert_eq!(long.to_string().split(':').next(), Some("fmi3Discard"));
    // That message came with the status of a warning.
    assert_eq!(bench.instance.warnings().count, 1);
    bench.instance.reset().unwrap();
    bench.set("until", Value::Real(0.0)).unwrap();
    bench.set("fatal", Value::Boolean(true)).unwrap();
    bench.start();
    assert_eq!(bench.instance.step(0.0, 1.0).unwrap_err().status, Status::Fatal);
    assert!(bench.instance.is_dead());
}

#[test]
fn a_function_that_is_not_there_is_missed_when_it_is_needed() {
    let (_folder, mut package) = three(&["NO_UINT8"], DESCRIPTION);
    let library = package.load().unwrap();
    let mut instance = Instance::new(&library, "one").unwrap();
    let handle = |name: &str| package.description().variables[name].handle();
    assert_eq!(handle("u8").content, Content::Integer);
    let missing = instance.value(handle("u8")).unwrap_err();
    assert_eq!(missing.function, "fmi3GetUInt8");
    assert!(instance.value(handle("i8")).is_ok());
}
