//! Builds a model's library and packs it into an FMU. [`package!`](crate::package!) makes a program of it.

mod arguments;
mod build;

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Write},
    path::{Path, PathBuf},
    process::ExitCode,
};

use thiserror::Error;
use zip::{CompressionMethod, DateTime, ZipWriter, write::SimpleFileOptions};

use crate::{
    description::{self, Interface, Version},
    model::{Model, faults, offered},
};
use arguments::{Arguments, HELP};

/// Defines the `main` of a program that packs the model of its package into an FMU.
///
/// With this one line in `src/main.rs`, `cargo run` makes the FMU; `cargo run -- --help` tells the options.
///
/// ```ignore
/// fmu_export::package!(my_model::Tank);
/// ```
///
/// The library is built with `cargo rustc --lib --crate-type cdylib` in the release profile, on Linux linked so that it
/// stays in memory when a host unloads it. Into the FMU go the model description, the
/// library, the package's `LICENSE*` files, and everything in the folder `fmu` beside its `Cargo.toml`, such as
/// `resources/` and `documentation/`, if there is one.
#[macro_export]
macro_rules! package {
    ($model:ty) => {
        fn main() -> std::process::ExitCode {
            $crate::package::main::<$model>(env!("CARGO_PKG_NAME"), env!("CARGO_MANIFEST_DIR"))
        }
    };
}

/// Why there is no FMU.
#[derive(Debug, Error)]
pub enum PackageError {
    /// The command line cannot be understood.
    #[error("{0}\n\n{HELP}")]
    Usage(String),
    /// The model's declaration has mistakes.
    #[error("the model is not sound:\n  {}", .0.join("\n  "))]
    Unsound(Vec<String>),
    /// Cargo could not be started, or failed; it has said why.
    #[error("the library was not built: {0}")]
    Build(String),
    /// A file could not be read or written.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
}

/// What an FMU offers: version and kind. Every library serves all of them; the model description says which it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Form {
    /// The version of the standard.
    pub version: Version,
    /// Whether it steps itself.
    pub interface: Interface,
}

impl Form {
    /// The end of the FMU's name, after the model's identifier.
    pub fn suffix(self) -> &'static str {
        match (self.version, self.interface) {
            (Version::Two, Interface::CoSimulation) => "",
            (Version::Three, Interface::CoSimulation) => "-fmi3",
            (Version::Two, Interface::ModelExchange) => "-me",
            (Version::Three, Interface::ModelExchange) => "-me-fmi3",
        }
    }
}

/// The binary of one platform.
#[derive(Debug)]
pub struct Binary {
    /// The platform's folder in the FMU, such as `linux64`, or `x86_64-linux` for FMI 3.0.
    pub platform: &'static str,
    /// The library.
    pub library: PathBuf,
}

/// The program that [`package!`](crate::package!) defines, for a package of this name with its `Cargo.toml` in `folder`.
pub fn main<M: Model>(package: &str, folder: &str) -> ExitCode {
    let done = arguments::parse(std::env::args().skip(1)).and_then(|arguments| match arguments {
        Some(arguments) => make::<M>(package, Path::new(folder), &arguments),
        None => Ok(HELP.to_owned()),
    });
    match done {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{package}: {error}");
            ExitCode::from(2)
        }
    }
}

/// Builds and packs; tells the file, its size and its platforms.
fn make<M: Model>(package: &str, folder: &Path, arguments: &Arguments) -> Result<String, PackageError> {
    let faults = faults::<M>();
    if !faults.is_empty() {
        return Err(PackageError::Unsound(faults));
    }
    let form = arguments.form;
    if form.interface == Interface::ModelExchange && offered::<M>().is_none() {
        return Err(PackageError::Usage(
            "--exchange: the model is not `Continuous`, or does not say so in `Model::EXCHANGE`".to_owned(),
        ));
    }
    let mut binaries = arguments.added()?;
    for target in arguments.targets() {
        binaries.push(build::library(package, folder, &arguments.profile, target, form)?);
    }
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None => binaries[0].library.with_file_name(format!("{}{}.fmu", M::INFO.identifier, form.suffix())),
    };
    let files = contents::<M>(folder, &binaries, form)?;
    let size = write(&output, &files).map_err(|error| at(&output, error))?;
    let platforms: Vec<_> = binaries.iter().map(|binary| binary.platform).collect();
    Ok(format!("{}  {:.2} MB, {}", output.display(), size as f64 / 1e6, platforms.join(", ")))
}

/// The files of an FMU with their places in it.
///
/// # Errors
/// When a file cannot be read, or two binaries are for the same platform.
pub fn contents<M: Model>(
    folder: &Path,
    binaries: &[Binary],
    form: Form,
) -> Result<BTreeMap<String, Vec<u8>>, PackageError> {
    let mut files = BTreeMap::new();
    let extra = folder.join("fmu");
    if extra.is_dir() {
        collect(&extra, "", &mut files)?;
    }
    for entry in list(folder)? {
        let name = name_of(&entry);
        if name.starts_with("LICENSE") && entry.is_file() {
            files.insert(format!("documentation/licenses/{name}"), read(&entry)?);
        }
    }
    for Binary { platform, library } in binaries {
        let extension = library.extension().unwrap_or_default().to_string_lossy();
        if files.insert(format!("binaries/{platform}/{}.{extension}", M::INFO.identifier), read(library)?).is_some() {
            return Err(PackageError::Usage(format!("there are two binaries for {platform}")));
        }
    }
    let description = description::xml::<M>(form.version, form.interface);
    files.insert("modelDescription.xml".to_owned(), description.into_bytes());
    Ok(files)
}

/// Writes an FMU: the same bytes for the same files. Returns its size.
///
/// # Errors
/// When the file cannot be written. A file that was there before is then untouched.
pub fn write(output: &Path, files: &BTreeMap<String, Vec<u8>>) -> io::Result<u64> {
    if let Some(folder) = output.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let partial = output.with_extension("fmu.partial");
    let mut archive = ZipWriter::new(File::create(&partial)?);
    for (name, bytes) in files {
        let permissions = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(DateTime::default())
            .unix_permissions(permissions);
        archive.start_file(name.as_str(), options)?;
        archive.write_all(bytes)?;
    }
    let size = archive.finish()?.metadata()?.len();
    std::fs::rename(&partial, output)?;
    Ok(size)
}

/// Collects the files below a folder under their paths with `/`.
fn collect(folder: &Path, place: &str, files: &mut BTreeMap<String, Vec<u8>>) -> Result<(), PackageError> {
    for path in list(folder)? {
        let name = name_of(&path);
        if path.is_dir() {
            collect(&path, &format!("{place}{name}/"), files)?;
        } else {
            files.insert(format!("{place}{name}"), read(&path)?);
        }
    }
    Ok(())
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, PackageError> {
    let entries = std::fs::read_dir(folder);
    entries.and_then(|entries| entries.map(|entry| Ok(entry?.path())).collect()).map_err(|error| at(folder, error))
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn read(path: &Path) -> Result<Vec<u8>, PackageError> {
    std::fs::read(path).map_err(|error| at(path, error))
}

fn at(path: &Path, error: io::Error) -> PackageError {
    let path = path.to_owned();
    PackageError::File { path, error }
}

#[cfg(test)]
mod tests {
    use serde::{Deserialize, Serialize};
    use zip::ZipArchive;

    use super::*;
    use crate::model::{Experiment, Fault, Info, Log, Variable};

    #[derive(Clone, Default, Serialize, Deserialize)]
    struct Nothing;

    impl Model for Nothing {
        const INFO: Info = Info { identifier: "Nothing", ..crate::info!() };

        fn variables() -> &'static [Variable<Self>] {
            &[]
        }

        fn initialise(&mut self, _: &Experiment, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }

        fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }
    }

    /// A package with a library, a licence and a resource.
    fn package() -> (tempfile::TempDir, Vec<Binary>) {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("fmu/resources/deep")).unwrap();
        std::fs::write(at("fmu/resources/deep/table.csv"), "1,2\n").unwrap();
        std::fs::write(at("LICENSE-MIT"), "free").unwrap();
        std::fs::write(at("libnothing.so"), [1, 2, 3]).unwrap();
        let binary = Binary { platform: "linux64", library: at("libnothing.so") };
        (folder, vec![binary])
    }

    #[test]
    fn an_fmu_holds_what_belongs_to_it_and_is_the_same_every_time() {
        let (folder, binaries) = package();
        let files = contents::<Nothing>(folder.path(), &binaries, Form::default()).unwrap();
        let (one, two) = (folder.path().join("a/one.fmu"), folder.path().join("two.fmu"));
        let size = write(&one, &files).unwrap();
        write(&two, &files).unwrap();
        let bytes = std::fs::read(&one).unwrap();
        assert_eq!(bytes.len() as u64, size);
        assert_eq!(bytes, std::fs::read(&two).unwrap());
        let mut archive = ZipArchive::new(File::open(&one).unwrap()).unwrap();
        let names: Vec<_> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(
            names,
            [
                "binaries/linux64/Nothing.so",
                "documentation/licenses/LICENSE-MIT",
                "modelDescription.xml",
                "resources/deep/table.csv",
            ]
        );
        let mode = archive.by_name("binaries/linux64/Nothing.so").unwrap().unix_mode();
        assert_eq!(mode.unwrap() & 0o777, 0o755);
        let mut xml = String::new();
        let mut entry = archive.by_name("modelDescription.xml").unwrap();
        io::Read::read_to_string(&mut entry, &mut xml).unwrap();
        let form = Form::default();
        assert_eq!(xml, description::xml::<Nothing>(form.version, form.interface));
    }

    #[test]
    fn two_binaries_for_a_platform_and_missing_files_are_refused() {
        let (folder, mut binaries) = package();
        binaries.push(Binary { platform: "linux64", library: folder.path().join("libnothing.so") });
        let refused = contents::<Nothing>(folder.path(), &binaries, Form::default()).unwrap_err().to_string();
        assert!(refused.starts_with("there are two binaries for linux64"), "{refused}");
        binaries[1].library = folder.path().join("missing.so");
        let refused = contents::<Nothing>(folder.path(), &binaries, Form::default()).unwrap_err().to_string();
        assert!(refused.contains("missing.so: "), "{refused}");
    }
}
