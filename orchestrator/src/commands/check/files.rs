//! What lies in the archive: safe paths, and binaries of the right name, machine and functions.

use std::collections::HashSet;

use object::{Architecture, BinaryFormat, NameOrOrdinal, Object};

use super::structure::short;
use fmu_import::archive::PLATFORM;
use fmu_import::{FmuError, Package};

/// What is wrong with the files, and whether this machine's binary is among it.
pub(super) struct Found {
    pub(super) findings: Vec<String>,
    pub(super) fatal: bool,
}

/// The platforms that FMI 2.0 names, and aarch64 Linux and macOS as tools name them: extension, format, machine.
const PLATFORMS: [(&str, &str, BinaryFormat, Architecture); 8] = [
    ("linux64", "so", BinaryFormat::Elf, Architecture::X86_64),
    ("linux32", "so", BinaryFormat::Elf, Architecture::I386),
    ("win64", "dll", BinaryFormat::Pe, Architecture::X86_64),
    ("win32", "dll", BinaryFormat::Pe, Architecture::I386),
    (
        "darwin64",
        "dylib",
        BinaryFormat::MachO,
        Architecture::X86_64,
    ),
    ("darwin32", "dylib", BinaryFormat::MachO, Architecture::I386),
    (
        "aarch64-linux",
        "so",
        BinaryFormat::Elf,
        Architecture::Aarch64,
    ),
    (
        "aarch64-darwin",
        "dylib",
        BinaryFormat::MachO,
        Architecture::Aarch64,
    ),
];

/// The functions of FMI 2.0 for Co-Simulation, without their prefix: a binary has them all, even those of
/// capabilities that it has not (FMI 2.0.4, section 2.1.1).
const FUNCTIONS: [&str; 34] = [
    "GetTypesPlatform",
    "GetVersion",
    "SetDebugLogging",
    "Instantiate",
    "FreeInstance",
    "SetupExperiment",
    "EnterInitializationMode",
    "ExitInitializationMode",
    "Terminate",
    "Reset",
    "GetReal",
    "GetInteger",
    "GetBoolean",
    "GetString",
    "SetReal",
    "SetInteger",
    "SetBoolean",
    "SetString",
    "GetFMUstate",
    "SetFMUstate",
    "FreeFMUstate",
    "SerializedFMUstateSize",
    "SerializeFMUstate",
    "DeSerializeFMUstate",
    "GetDirectionalDerivative",
    "SetRealInputDerivatives",
    "GetRealOutputDerivatives",
    "DoStep",
    "CancelStep",
    "GetStatus",
    "GetRealStatus",
    "GetIntegerStatus",
    "GetBooleanStatus",
    "GetStringStatus",
];

pub(super) fn broken(package: &mut Package) -> Result<Found, FmuError> {
    let entries = package.entries();
    let identifier = package.description().model_identifier.clone();
    let mut found = Found {
        findings: Vec::new(),
        fatal: false,
    };
    for wrong in [OUTSIDE, BACKSLASH] {
        let those = entries.iter().filter(|entry| path(entry) == Some(wrong));
        let those: Vec<String> = those.cloned().collect();
        if !those.is_empty() {
            found.findings.push(format!("{}: {wrong}", short(&those)));
            found.fatal = true;
        }
    }
    if found.fatal {
        return Ok(found);
    }
    if !is_identifier(&identifier) {
        found.findings.push(format!(
            "modelDescription.xml: modelIdentifier `{identifier}` is no C identifier: use letters, digits and underscores"
        ));
    }
    for (platform, extension, format, machine) in PLATFORMS {
        let folder = format!("binaries/{platform}/");
        let binaries: Vec<&str> = entries
            .iter()
            .filter_map(|entry| entry.strip_prefix(&folder))
            .filter(|file| !file.contains('/') && file.ends_with(&format!(".{extension}")))
            .collect();
        let wanted = format!("{identifier}.{extension}");
        let wrong = if binaries.contains(&wanted.as_str()) {
            let name = format!("{folder}{wanted}");
            match package.bytes_of(&name) {
                Ok(bytes) => {
                    binary(&bytes, format, machine).map(|wrong| format!("{name}: {wrong}"))
                }
                Err(FmuError::Archive { source, .. }) if source.is_a_fault() => {
                    Some(source.to_string())
                }
                Err(error) => return Err(error),
            }
        } else if let Some(entry) = entries.iter().find(|entry| miswritten(entry, &folder)) {
            Some(format!(
                "{entry}: the folder's name is {folder}, as names differ by upper and lower case"
            ))
        } else {
            let first = binaries.first();
            first.map(|other| {
                format!(
                    "{folder}{other}: the binary is named otherwise than modelIdentifier, `{identifier}`: call it {wanted}"
                )
            })
        };
        found.fatal |= wrong.is_some() && platform == PLATFORM;
        found.findings.extend(wrong);
    }
    Ok(found)
}

/// Whether an entry is in a folder that differs by upper and lower case only.
fn miswritten(entry: &str, folder: &str) -> bool {
    let start = entry.get(..folder.len());
    start.is_some_and(|start| start != folder && start.eq_ignore_ascii_case(folder))
}

const OUTSIDE: &str =
    "the path leads outside the archive: pack the FMU with relative paths below it";
const BACKSLASH: &str = "the path contains a backslash: pack the FMU with forward slashes";

/// What is wrong with an entry's path (FMI 2.0.4, section 2.3).
fn path(entry: &str) -> Option<&'static str> {
    let outside = entry.starts_with('/')
        || entry.split(['/', '\\']).any(|part| part == "..")
        || entry.get(1..3) == Some(":\\")
        || entry.get(1..3) == Some(":/");
    if outside {
        Some(OUTSIDE)
    } else if entry.contains('\\') {
        Some(BACKSLASH)
    } else {
        None
    }
}

fn is_identifier(name: &str) -> bool {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    name.chars().all(word) && !name.starts_with(|c: char| c.is_ascii_digit())
}

/// What is wrong with a binary by itself.
fn binary(bytes: &[u8], format: BinaryFormat, machine: Architecture) -> Option<String> {
    // A macOS library for several machines holds one for each.
    if format == BinaryFormat::MachO && bytes.starts_with(&[0xca, 0xfe, 0xba, 0xbe]) {
        return None;
    }
    let file = match object::File::parse(bytes) {
        Ok(file) => file,
        Err(error) => {
            return Some(format!(
                "no shared library ({error}): build the binary anew"
            ));
        }
    };
    if (file.format(), file.architecture()) != (format, machine) {
        return Some(format!(
            "a binary for {:?} in {:?} format, not for {machine:?} in {format:?}: put it into the folder of its \
             platform, or build it for this one",
            file.architecture(),
            file.format()
        ));
    }
    let exports = match exports(&file) {
        Ok(exports) => exports,
        Err(error) => {
            return Some(format!(
                "its functions cannot be read ({error}): build it anew"
            ));
        }
    };
    // macOS puts an underscore before the names of C.
    let has = |name: &str| exports.contains(name) || exports.contains(&format!("_{name}"));
    let absent: Vec<String> = FUNCTIONS
        .iter()
        .map(|name| format!("fmi2{name}"))
        .filter(|name| !has(name))
        .collect();
    if absent.len() == FUNCTIONS.len() {
        let prefixed = exports
            .iter()
            .find(|export| export.ends_with("_fmi2DoStep"));
        return Some(prefixed.map_or_else(
            || "the binary exports none of the functions of FMI 2.0: export them".to_owned(),
            |name| {
                format!("the binary exports {name} instead of fmi2DoStep: build it without a prefix of the functions")
            },
        ));
    }
    (!absent.is_empty()).then(|| {
        format!(
            "the binary does not export {}: every function of FMI 2.0 must be there",
            short(&absent)
        )
    })
}

/// The names that a library exports.
fn exports(file: &object::File<'_>) -> object::Result<HashSet<String>> {
    let name = |export: object::Export<'_>| match export.name() {
        NameOrOrdinal::Name(name) => String::from_utf8_lossy(name).into_owned(),
        NameOrOrdinal::Ordinal(_) => String::new(),
    };
    file.exports()?.map(|export| export.map(name)).collect()
}
