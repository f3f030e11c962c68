//! A small FMU of our own, compiled here, seen through the public interface.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use fmu_import::archive::PLATFORM;
use fmu_import::{Call, Content, EarlyEnd, Handle, Instance, Library, Package, Status, Value};
use tempfile::TempDir;

const DESCRIPTION: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="Counter" guid="c">
<CoSimulation modelIdentifier="counter"/>
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
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/counter.c"))
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

/// The FMU as one file.
fn packed(folder: &Path) -> PathBuf {
    let file = folder.join("counter.fmu");
    let mut archive = zip::ZipWriter::new(fs::File::create(&file).unwrap());
    let binary = format!("binaries/{PLATFORM}/counter.so");
    for entry in ["modelDescription.xml", &binary] {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(entry, options).unwrap();
        archive.write_all(&fs::read(folder.join(entry)).unwrap()).unwrap();
    }
    archive.finish().unwrap();
    file
}

/// An FMU may read its resources at any time, also when nobody needs its description any more.
#[test]
fn a_library_keeps_its_files() {
    let (folder, _) = counter();
    let parent = tempfile::tempdir().unwrap();
    let mut package = Package::open(&packed(folder.path())).unwrap();
    let library = package.load().unwrap();
    // The folder that is there already.
    let unpacked = package.unpack(parent.path()).unwrap();
    assert!(!unpacked.starts_with(parent.path()));
    drop(package);
    let instance = started(&library);
    drop(library);
    assert!(unpacked.join("modelDescription.xml").exists());
    drop(instance);
    assert!(!unpacked.exists());
}

/// Once the parent is gone, another program may have a folder of the same name there.
#[test]
fn a_folder_within_a_given_one_is_removed_with_that_alone() {
    let (folder, _) = counter();
    let parent = tempfile::tempdir().unwrap();
    let mut package = Package::open(&packed(folder.path())).unwrap();
    let unpacked = package.unpack(parent.path()).unwrap();
    drop(package);
    assert!(unpacked.join("modelDescription.xml").exists());
}

/// Steps from 0 to 1 with one of the faults that `counter.c` can be told to have.
fn whimsical(whim: i32) -> (Instance, Result<(), Call>) {
    let (_folder, mut package) = counter();
    let mut instance = started(&package.load().unwrap());
    instance.set(8, &Value::Integer(whim.into())).unwrap();
    let step = instance.step(0.0, 1.0);
    (instance, step)
}

#[test]
fn an_fmu_may_end_the_simulation() {
    for (whim, at) in [(2, 0.25), (3, 0.0)] {
        let (mut instance, step) = whimsical(whim);
        let call = step.unwrap_err();
        assert_eq!(call.status, Status::Discard);
        assert_eq!(call.ended, Some(EarlyEnd { from: 0.0, at }), "{whim}");
        instance.terminate().unwrap();
    }
    // A step that is only refused is no end.
    assert_eq!(whimsical(4).1.unwrap_err().ended, None);
}

#[test]
fn warnings_are_counted_until_a_new_start() {
    let (mut instance, step) = whimsical(1);
    step.unwrap();
    instance.step(1.0, 1.0).unwrap();
    let warnings = instance.warnings();
    let first = warnings.first.as_deref();
    assert_eq!((warnings.count, first), (2, Some("fmi2DoStep: take care")));
    let refused = instance.terminate().unwrap_err();
    assert_eq!((refused.function, refused.status), ("fmi2Terminate", Status::Error));
}

#[test]
fn a_pending_step_is_waited_for_or_named() {
    let (mut instance, step) = whimsical(6);
    step.unwrap();
    let handle = Handle { reference: 0, content: Content::Integer };
    assert_eq!(instance.value(handle).unwrap(), Value::Integer(1));
    let call = whimsical(5).1.unwrap_err();
    assert_eq!(call.status, Status::Pending);
    let text = call.to_string();
    assert!(text.contains("fmi2Pending") && text.contains("fmi2GetStatus returned fmi2Discard"), "{text}");
}

#[test]
fn a_logger_that_is_called_wildly_harms_nothing() {
    let (_instance, step) = whimsical(7);
    assert_eq!(step.unwrap_err().status, Status::Error);
}

#[test]
fn a_library_tells_its_version() {
    let (_folder, mut package) = counter();
    assert_eq!(package.load().unwrap().version().as_deref(), Some("1.0"));
}

/// With a library missing, the dynamic loader names that one only; we name all.
#[test]
#[cfg(target_os = "linux")]
fn all_missing_libraries_are_named() {
    let (folder, mut package) = counter();
    let binary = folder.path().join("binaries").join(PLATFORM).join("counter.so");
    let compile = |arguments: &[&str], output: &Path| {
        let status = Command::new("cc")
            .current_dir(folder.path())
            .args(["-shared", "-fPIC", "-x", "c", "/dev/null", "-o"])
            .arg(output)
            .args(arguments)
            .status();
        assert!(status.unwrap().success());
    };
    for name in ["one", "two"] {
        let file = folder.path().join(format!("libabsent{name}.so"));
        compile(&[], &file);
    }
    compile(&["-L.", "-Wl,--no-as-needed", "-labsentone", "-labsenttwo"], &binary);
    let missing = fmu_import::needed::missing(&binary);
    let text = "it needs libabsentone.so, libabsenttwo.so, not found on this machine: install what is missing";
    assert_eq!(missing.as_deref(), Some(text));
    let error = package.load().unwrap_err().to_string();
    assert!(error.contains(text), "{error}");
    fs::write(binary.with_file_name("libabsenttwo.so"), "").unwrap();
    let missing = fmu_import::needed::missing(&binary).unwrap();
    assert!(missing.contains("link it with -rpath '$ORIGIN'"), "{missing}");
}
