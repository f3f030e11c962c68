//! A control group ends what a process group cannot: a daemon that an FMU has started.
//!
//! None of the other means is at work here: nobody adopts the daemon, looks for its mark or signals its group.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used)]

use std::fs;
use std::io::{Write, stdin};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use fmu_import::archive::PLATFORM;
use fmu_import::isolation::ControlGroup;
use fmu_import::{Instance, Package, Value};

const DESCRIPTION: &str = r#"<fmiModelDescription fmiVersion="2.0" modelName="faulty" guid="faulty">
<CoSimulation modelIdentifier="faulty"/>
<ModelVariables>
<ScalarVariable name="fault" valueReference="1" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
</ModelVariables></fmiModelDescription>"#;
/// The environment variable with the folder of the FMU.
const FMU: &str = "FMU_WITH_A_DAEMON";

/// The unpacked FMU of `starts_a_daemon` in `tests/faulty`.
fn build(folder: &Path) {
    fs::write(folder.join("modelDescription.xml"), DESCRIPTION).unwrap();
    let binaries = folder.join("binaries").join(PLATFORM);
    fs::create_dir_all(&binaries).unwrap();
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/faulty");
    let sources = fs::read_dir(sources).unwrap().flatten();
    let sources = sources.map(|entry| entry.path());
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-w", "-Wl,-Bsymbolic"])
        .arg("-DBEHAVIOUR=starts_a_daemon")
        .args(sources.filter(|path| path.extension().is_some_and(|end| end == "c")))
        .arg("-o")
        .arg(binaries.join("faulty.so"))
        .args(["-lm", "-lpthread"])
        .status()
        .unwrap();
    assert!(status.success());
}

/// Runs the FMU until it has started its daemon, once it is told to begin.
#[test]
#[ignore = "a process that the other test starts"]
fn host() {
    let Some(folder) = std::env::var_os(FMU) else {
        return;
    };
    stdin().read_line(&mut String::new()).unwrap();
    let library = Package::open(Path::new(&folder)).unwrap().load().unwrap();
    let mut instance = Instance::new(&library, "one").unwrap();
    instance.setup_experiment(0.0, 1.0, None).unwrap();
    instance.set(1, &Value::Integer(1)).unwrap();
    instance.initialise().unwrap();
    for step in 0..20 {
        instance.step(0.05 * f64::from(step), 0.05).unwrap();
    }
}

/// The process group of a process that lives.
fn alive(pid: u32) -> Option<u32> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (_, fields) = stat.rsplit_once(')')?;
    let fields: Vec<&str> = fields.split_whitespace().collect();
    (!["Z", "X"].contains(&fields[0])).then(|| fields[2].parse().unwrap())
}

#[test]
fn a_daemon_ends_with_the_group() {
    let Some(group) = ControlGroup::new() else {
        eprintln!("this process may make no control group: nothing to see");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    build(folder.path());
    let mut host = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "host"])
        .env(FMU, folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    assert!(group.take(host.id()));
    host.stdin.take().unwrap().write_all(b"begin\n").unwrap();
    assert!(host.wait().unwrap().success());

    // The daemon's parent leads its process group and may live a moment longer than the host.
    let end = Instant::now() + Duration::from_secs(10);
    let daemon = loop {
        if let [daemon] = group.processes()[..]
            && alive(daemon).is_some_and(|group| group != daemon && group != host.id())
        {
            break daemon;
        }
        assert!(Instant::now() < end, "no daemon alone: {:?}", group.processes());
        std::thread::sleep(Duration::from_millis(1));
    };
    drop(group);
    let end = Instant::now() + Duration::from_secs(10);
    while alive(daemon).is_some() {
        assert!(Instant::now() < end, "the daemon lives");
        std::thread::sleep(Duration::from_millis(1));
    }
}
