//! Shared by the tests of the command line: an FMU of their own, and a way to run commands.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::{LazyLock, Mutex};

use tempfile::TempDir;
use zip::write::{SimpleFileOptions, ZipWriter};

/// A folder of its own, gone at the end.
pub struct Bench {
    folder: TempDir,
    /// What commands that simulate are given beside their arguments.
    options: &'static [&'static str],
}

/// Output and exit code of a command.
pub struct Said {
    pub code: i32,
    pub out: String,
    pub err: String,
}

const MODEL: &str = include_str!("../fixtures/lag.xml");

const DAMAGE: &str = include_str!("../fixtures/damage.xml");

/// The description of the fixture of FMI 3.0, which is that of the importer.
pub const THREE: &str = include_str!("../../../crates/fmu-import/tests/fixtures/three.xml");

/// The same of the one with clocks.
pub const TICKS: &str = include_str!("../../../crates/fmu-import/tests/fixtures/ticks.xml");

/// The same of the one for Model Exchange.
pub const BALL: &str = include_str!("../../../crates/fmu-import/tests/fixtures/ball.xml");

impl Bench {
    /// A folder with `lag.fmu` in it.
    pub fn new() -> Self {
        let bench = Self::empty();
        bench.fmu("lag.fmu", &[], MODEL);
        bench
    }

    pub fn empty() -> Self {
        let folder = tempfile::tempdir().unwrap();
        Self { folder, options: &[] }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// For tests of what is made of many points: how these run is another test's matter, and a process for each of them would
    /// take ten times as long as all the rest.
    pub fn in_process(self) -> Self {
        Self { options: &["--isolation", "none"], ..self }
    }

    /// A folder with `functions.fmu` in it: analytic functions of x1 to x30.
    pub fn functions() -> Self {
        let bench = Self::empty().in_process();
        let binary = bench.compiled("functions", &[]);
        let description = functions();
        let entries: [(&str, &[u8]); 2] =
            [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/functions.so", &binary)];
        bench.zip("functions.fmu", &entries);
        bench
    }

    /// Packs `damage.fmu`, of which each point may spoil what it leaves.
    pub fn damage(&self) {
        let binary = self.compiled("damage", &[]);
        let entries: [(&str, &[u8]); 2] =
            [("modelDescription.xml", DAMAGE.as_bytes()), ("binaries/linux64/damage.so", &binary)];
        self.zip("damage.fmu", &entries);
    }

    /// Compiles the fixture with these macros and packs it with a model description.
    pub fn fmu(&self, name: &str, macros: &[&str], description: &str) {
        let binary = self.binary(macros);
        let entries: [(&str, &[u8]); 2] =
            [("modelDescription.xml", description.as_bytes()), ("binaries/linux64/lag.so", &binary)];
        self.zip(name, &entries);
    }

    /// The fixture, compiled with these macros.
    pub fn binary(&self, macros: &[&str]) -> Vec<u8> {
        self.compiled("lag", macros)
    }

    /// Compiles the fixture of FMI 3.0 with these macros and packs it with a model description.
    pub fn three(&self, name: &str, macros: &[&str], description: &str) {
        self.of_importer(name, "x86_64-linux", "three", macros, description);
    }

    /// The same of the fixture with clocks.
    pub fn ticks(&self, name: &str, description: &str) {
        self.of_importer(name, "x86_64-linux", "ticks", &[], description);
    }

    /// The same of the fixture for Model Exchange.
    pub fn ball(&self, name: &str, macros: &[&str], description: &str) {
        self.of_importer(name, "linux64", "ball", macros, description);
    }

    fn of_importer(&self, name: &str, platform: &str, fixture: &str, macros: &[&str], description: &str) {
        let folder = "../crates/fmu-import/tests/fixtures";
        let folder = format!("{}/{folder}", env!("CARGO_MANIFEST_DIR"));
        let binary = self.compiled_in(&folder, fixture, macros);
        let path = format!("binaries/{platform}/{fixture}.so");
        let entries: [(&str, &[u8]); 2] = [("modelDescription.xml", description.as_bytes()), (&path, &binary)];
        self.zip(name, &entries);
    }

    fn compiled(&self, fixture: &str, macros: &[&str]) -> Vec<u8> {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures");
        self.compiled_in(folder, fixture, macros)
    }

    /// Most tests want the same few libraries, and a compiler takes as long as many of the tests: each is made once.
    fn compiled_in(&self, folder: &str, fixture: &str, macros: &[&str]) -> Vec<u8> {
        static LIBRARIES: LazyLock<Mutex<HashMap<String, Vec<u8>>>> = LazyLock::new(Mutex::default);
        let key = format!("{folder}/{fixture} {macros:?}");
        if let Some(library) = LIBRARIES.lock().unwrap().get(&key) {
            return library.clone();
        }
        let source = format!("{folder}/{fixture}.c");
        let binary = self.path(&format!("{fixture}.so"));
        let status = Command::new("cc")
            // Not optimised: they run for moments.
            .args(["-shared", "-fPIC", "-o"])
            .arg(&binary)
            .args(macros.iter().map(|name| format!("-D{name}")))
            .args([&source, "-lm"])
            .status()
            .unwrap();
        assert!(status.success());
        let library = fs::read(&binary).unwrap();
        fs::remove_file(binary).unwrap();
        LIBRARIES.lock().unwrap().insert(key, library.clone());
        library
    }

    pub fn zip(&self, name: &str, entries: &[(&str, &[u8])]) {
        let mut zip = ZipWriter::new(File::create(self.path(name)).unwrap());
        for (name, content) in entries {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(content).unwrap();
        }
        zip.finish().unwrap();
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// A command in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_orchestrator"));
        command.args(arguments).current_dir(self.folder.path());
        let simulates = ["verify", "identify", "sensitivity", "robustness", "tolerances"];
        if arguments.first().is_some_and(|name| simulates.contains(name)) && !arguments.contains(&"--isolation") {
            command.args(self.options);
        }
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Said {
        self.command(arguments).output().unwrap().into()
    }

    /// The summary that a command left in a folder.
    pub fn summary(&self, folder: &str) -> serde_json::Value {
        serde_json::from_str(&self.read(&format!("{folder}/summary.json"))).unwrap()
    }
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
        Self { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) }
    }
}

impl Said {
    /// A mistake is one clear line that holds all the words, and exit code 2.
    pub fn is_mistake(&self, words: &[&str]) {
        assert_eq!(self.code, 2, "{}{}", self.out, self.err);
        assert_eq!(self.err.trim_end().lines().count(), 1, "{}", self.err);
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in: {}", self.err);
        }
    }
}

/// The outputs of `functions.c`, from value reference 101 on.
const OUTPUTS: [&str; 10] =
    ["wave", "first", "second", "ripple", "product", "radius", "gap", "linear", "holed", "stripes"];

/// The model description of `functions.c`.
fn functions() -> String {
    let parameter = |k: usize| {
        format!(
            r#"<ScalarVariable name="x{k}" valueReference="{k}" causality="parameter" variability="fixed"><Real start="0.5"/></ScalarVariable>"#
        )
    };
    let output = |(k, name): (usize, &&str)| {
        let reference = 101 + k;
        format!(
            r#"<ScalarVariable name="{name}" valueReference="{reference}" causality="output"><Real/></ScalarVariable>"#
        )
    };
    let variables: String = (1..=30).map(parameter).chain(OUTPUTS.iter().enumerate().map(output)).collect();
    let unknowns: String = (31..31 + OUTPUTS.len()).map(|index| format!(r#"<Unknown index="{index}"/>"#)).collect();
    format!(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Functions" guid="functions">
<CoSimulation modelIdentifier="functions" canHandleVariableCommunicationStepSize="true"/>
<DefaultExperiment startTime="0" stopTime="1" stepSize="1"/>
<ModelVariables>{variables}</ModelVariables>
<ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>
</fmiModelDescription>"#
    )
}

/// The model description with a part replaced, or several, which stand between `&&` then.
pub fn model(from: &str, to: &str) -> String {
    let parts = from.split(" && ").zip(to.split(" && "));
    parts.fold(MODEL.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "no `{from}` in the description");
        text.replace(from, to)
    })
}
