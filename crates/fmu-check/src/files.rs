//! Checks of the archive: safe paths, and binaries of the right name, machine and functions.

use std::collections::HashSet;

use object::{Architecture, BinaryFormat, NameOrOrdinal, Object};

use crate::{
    document::NAME,
    exported::functions,
    hit::{Breach, Hit, breach},
    structure::short,
};
use fmu_import::{Description, FmuError, Interface, Package, Version};

/// Faults of the files, and whether this machine's binary has one.
pub struct Faults {
    pub findings: Vec<Breach>,
    pub fatal: bool,
}

/// A platform: the folder, and the format and machine of its binaries.
type Platform = (&'static str, BinaryFormat, Architecture);

/// The platforms that a version names; in FMI 2.0 also aarch64 Linux and macOS as tools name them.
fn platforms(version: Version) -> [Platform; 8] {
    use Architecture::{Aarch64, I386, X86_64};
    use BinaryFormat::{Elf, MachO, Pe};
    [
        ("linux64", "x86_64-linux", Elf, X86_64),
        ("linux32", "x86-linux", Elf, I386),
        ("win64", "x86_64-windows", Pe, X86_64),
        ("win32", "x86-windows", Pe, I386),
        ("darwin64", "x86_64-darwin", MachO, X86_64),
        ("darwin32", "x86-darwin", MachO, I386),
        ("aarch64-linux", "aarch64-linux", Elf, Aarch64),
        ("aarch64-darwin", "aarch64-darwin", MachO, Aarch64),
    ]
    .map(|(two, three, format, machine)| match version {
        Version::Two => (two, format, machine),
        Version::Three => (three, format, machine),
    })
}

/// The extension of a shared library.
fn extension(format: BinaryFormat) -> &'static str {
    match format {
        BinaryFormat::Pe => "dll",
        BinaryFormat::MachO => "dylib",
        _ => "so",
    }
}

pub fn broken(package: &mut Package) -> Result<Faults, FmuError> {
    let entries = package.entries();
    let identifier = package.description().model_identifier.clone();
    let (mut findings, mut fatal) = (Vec::new(), false);
    for wrong in [OUTSIDE, BACKSLASH] {
        let those: Vec<String> = entries.iter().filter(|entry| path(entry) == Some(wrong)).cloned().collect();
        if !those.is_empty() {
            findings.push(breach("archive-path", format!("{}: {wrong}", short(&those))));
            fatal = true;
        }
    }
    if fatal {
        return Ok(Faults { findings, fatal });
    }
    if !is_identifier(&identifier) {
        findings.push((
            "model-identifier",
            Hit::of(
                NAME,
                format!("modelIdentifier `{identifier}` is no C identifier: use letters, digits and underscores"),
            ),
        ));
    }
    let version = package.description().standard;
    for platform in platforms(version) {
        let wrong = of_platform(package, &entries, &identifier, platform)?;
        fatal |= wrong.is_some() && platform.0 == version.platform();
        if let Some(breach) = wrong {
            add(&mut findings, breach, platform.0);
        }
    }
    let twice = package.entries_twice();
    if !twice.is_empty() {
        findings.push(breach(
            "archive-entry-unique",
            format!("two entries of each of these names: {}: remove one", short(twice)),
        ));
    }
    Ok(Faults { findings, fatal })
}

/// Adds a breach, or the platform to the one of the same rule: a wrong name is wrong on all platforms.
fn add(findings: &mut Vec<Breach>, (rule, hit): Breach, platform: &str) {
    match findings.iter_mut().find(|(known, _)| *known == rule) {
        Some((_, known)) => known.text += &format!("; the same for {platform}"),
        None => findings.push((rule, hit)),
    }
}

/// Faults of a platform's binary.
fn of_platform(
    package: &mut Package,
    entries: &[String],
    identifier: &str,
    (platform, format, machine): Platform,
) -> Result<Option<Breach>, FmuError> {
    let (folder, extension) = (format!("binaries/{platform}/"), extension(format));
    let binaries: Vec<&str> = entries
        .iter()
        .filter_map(|entry| entry.strip_prefix(&folder))
        .filter(|file| !file.contains('/') && file.ends_with(&format!(".{extension}")))
        .collect();
    let wanted = format!("{identifier}.{extension}");
    // Windows does not tell upper from lower case.
    if let Some(file) = binaries.iter().find(|file| match format {
        BinaryFormat::Pe => file.eq_ignore_ascii_case(&wanted),
        _ => **file == wanted,
    }) {
        let name = format!("{folder}{file}");
        return match package.bytes_of(&name) {
            Ok(bytes) => Ok(sound(&bytes, package.description(), format, machine)
                .err()
                .map(|(rule, wrong)| (rule, Hit::of(&name, wrong)))),
            Err(FmuError { fault, .. }) if fault.is_in_fmu() => Ok(Some(breach("archive-readable", fault.to_string()))),
            Err(error) => Err(error),
        };
    }
    if let Some(entry) = entries.iter().find(|entry| miswritten(entry, &folder)) {
        return Ok(Some((
            "binary-folder",
            Hit::of(entry, format!("the folder's name is {folder}, as names differ by upper and lower case")),
        )));
    }
    Ok(binaries.first().map(|other| {
        (
            "binary-name",
            Hit::of(
                &format!("{folder}{other}"),
                format!("the binary is named otherwise than modelIdentifier, `{identifier}`: call it {wanted}"),
            ),
        )
    }))
}

/// Whether an entry is in a folder that differs by upper and lower case only.
fn miswritten(entry: &str, folder: &str) -> bool {
    let start = entry.get(..folder.len());
    start.is_some_and(|start| start != folder && start.eq_ignore_ascii_case(folder))
}

const OUTSIDE: &str = "the path leads outside the archive: pack the FMU with relative paths below it";
const BACKSLASH: &str = "the path contains a backslash: pack the FMU with forward slashes";

/// Faults of an entry's path (FMI 2.0.5, section 2.3).
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
    name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') && !name.starts_with(|c: char| c.is_ascii_digit())
}

/// Whether a binary by itself is sound, or which rule it breaks.
fn sound(
    bytes: &[u8],
    fmu: &Description,
    format: BinaryFormat,
    machine: Architecture,
) -> Result<(), (&'static str, String)> {
    // A macOS library for several machines holds one for each.
    if format == BinaryFormat::MachO && bytes.starts_with(&[0xca, 0xfe, 0xba, 0xbe]) {
        return Ok(());
    }
    let unreadable = |text| ("binary-readable", text);
    let file = object::File::parse(bytes)
        .map_err(|error| unreadable(format!("no shared library ({error}): build the binary anew")))?;
    if (file.format(), file.architecture()) != (format, machine) {
        let text = format!(
            "a binary for {:?} in {:?} format, not for {machine:?} in {format:?}: put it into the folder of its \
             platform, or build it for this one",
            file.architecture(),
            file.format()
        );
        return Err(("binary-machine", text));
    }
    let exports =
        exports(&file).map_err(|error| unreadable(format!("its functions cannot be read ({error}): build it anew")))?;
    // macOS puts an underscore before the names of C.
    let has = |name: &str| exports.contains(name) || exports.contains(&format!("_{name}"));
    let (prefix, number) = (fmu.standard.prefix(), fmu.standard.number());
    let functions = functions(fmu);
    let absent: Vec<String> =
        functions.iter().map(|name| format!("{prefix}{name}")).filter(|name| !has(name)).collect();
    if absent.is_empty() {
        return Ok(());
    }
    let text = if absent.len() < functions.len() {
        let absent = short(&absent);
        format!("the binary does not export {absent}: every function of FMI {number} must be there")
    } else {
        let step = match fmu.interface {
            Interface::CoSimulation => format!("{prefix}DoStep"),
            Interface::ModelExchange => format!("{prefix}SetTime"),
        };
        let end = format!("_{step}");
        match exports.iter().find(|export| export.ends_with(&end)) {
            Some(name) => {
                format!("the binary exports {name} instead of {step}: build it without a prefix of the functions")
            }
            None => {
                format!("the binary exports none of the functions of FMI {number}: export them")
            }
        }
    };
    Err(("binary-functions", text))
}

/// The names that a library exports.
fn exports(file: &object::File) -> object::Result<HashSet<String>> {
    let name = |export: object::Export| match export.name() {
        NameOrOrdinal::Name(name) => String::from_utf8_lossy(name).into_owned(),
        NameOrOrdinal::Ordinal(_) => String::new(),
    };
    file.exports()?.map(|export| export.map(name)).collect()
}
