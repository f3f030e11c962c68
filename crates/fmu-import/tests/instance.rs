//! A small FMU of our own, compiled here, seen through the public interface.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::Command;
use std::sync::Arc;

use fmu_import::archive::PLATFORM;
use fmu_import::{Instance, Library, Package, State, StateError, Status, Value};
use tempfile::TempDir;

const DESCRIPTION: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Counter" guid="c">
<CoSimulation modelIdentifier="counter" canGetAndSetFMUstate="true"/>
<ModelVariables>
<ScalarVariable name="count" valueReference="0" causality="output"><Integer/></ScalarVariable>
<ScalarVariable name="last" valueReference="9" causality="parameter" variability="fixed"><Integer start="1000"/></ScalarVariable>
</ModelVariables></fmiModelDescription>"#;

/// An unpacked FMU, and its description.
fn counter() -> (TempDir, Package) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("modelDescription.xml"), DESCRIPTION).unwrap();
    let binaries = folder.path().join("binaries").join(PLATFORM);
    fs::create_dir_all(&binaries).unwrap();
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .arg(binaries.join("counter.so"))
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/fixtures/counter.c"
        ))
        .status()
        .unwrap();
    assert!(status.success());
    let package = Package::open(folder.path()).unwrap();
    (folder, package)
}

fn started(library: &Arc<Library>) -> Instance {
    let mut instance = Instance::new(library, "one").unwrap();
    instance.setup_experiment(0.0, 1.0, None).unwrap();
    instance.initialise().unwrap();
    instance
}

/// The instance after some steps, with the state in which it is then.
fn stepped(library: &Arc<Library>, steps: i32) -> (Instance, State) {
    let mut instance = started(library);
    for _ in 0..steps {
        instance.step(0.0, 1.0).unwrap();
    }
    let state = instance.save().unwrap();
    (instance, state)
}

#[test]
fn an_instance_goes_back_to_its_own_state_only() {
    let (_folder, mut package) = counter();
    let library = package.load().unwrap();
    let count = package.description().variables["count"].handle();
    let (mut one, of_one) = stepped(&library, 3);
    let (mut other, of_other) = stepped(&library, 5);
    one.step(0.0, 1.0).unwrap();
    one.restore(&of_one).unwrap();
    assert_eq!(one.value(count).unwrap(), Value::Integer(3));

    let refused = one.restore(&of_other);
    assert!(matches!(refused, Err(StateError::OfAnother)), "{refused:?}");
    let refused = other.forget(of_one);
    assert!(matches!(refused, Err(StateError::OfAnother)), "{refused:?}");
    assert_eq!(one.value(count).unwrap(), Value::Integer(3));
    other.forget(of_other).unwrap();
}

#[test]
fn a_state_of_another_library_is_refused() {
    let (_first, mut first) = counter();
    let (_second, mut second) = counter();
    let (_one, state) = stepped(&first.load().unwrap(), 1);
    let mut other = started(&second.load().unwrap());
    let refused = other.restore(&state);
    assert!(matches!(refused, Err(StateError::OfAnother)), "{refused:?}");
}

#[test]
fn a_state_of_a_freed_instance_is_refused() {
    let (_folder, mut package) = counter();
    let library = package.load().unwrap();
    let (gone, state) = stepped(&library, 1);
    drop(gone);
    // The new instance may lie at the address of the old one.
    let mut next = started(&library);
    assert!(matches!(next.restore(&state), Err(StateError::OfAnother)));
    assert!(matches!(next.forget(state), Err(StateError::OfAnother)));
}

#[test]
fn a_dead_instance_takes_no_state() {
    let (_folder, mut package) = counter();
    let library = package.load().unwrap();
    let last = package.description().variables["last"].handle();
    let (mut instance, state) = stepped(&library, 2);
    instance.set(last.reference, &Value::Integer(2)).unwrap();
    let fatal = instance.step(0.0, 1.0).unwrap_err();
    assert_eq!(fatal.status, Status::Fatal);
    assert!(instance.is_dead());
    assert!(matches!(instance.restore(&state), Err(StateError::Dead)));
    assert!(instance.save().is_none());
    assert!(matches!(instance.forget(state), Err(StateError::Dead)));
}
