//! Building a model's library with cargo.

use std::{
    ffi::OsString,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use super::{Binary, Form, PackageError};

/// The folders that the standards name for platforms. FMI 2.0 names none for 64-bit Arm on Linux, where importers look
/// into the folder of FMI 3.0.
pub mod platform {
    use crate::{description::Version, package::Form};

    /// Its folders of FMI 2.0 and 3.0, with the processors and systems as Rust names them.
    type Platform = (&'static str, &'static str, &'static [&'static str], &'static [&'static str]);

    const ALL: [Platform; 7] = [
        ("linux64", "x86_64-linux", &["x86_64"], &["linux"]),
        ("linux32", "x86-linux", &["i586", "i686", "x86"], &["linux"]),
        ("win64", "x86_64-windows", &["x86_64"], &["windows"]),
        ("win32", "x86-windows", &["i586", "i686", "x86"], &["windows"]),
        ("darwin64", "x86_64-darwin", &["x86_64"], &["macos", "darwin"]),
        ("darwin64", "aarch64-darwin", &["aarch64"], &["macos", "darwin"]),
        ("aarch64-linux", "aarch64-linux", &["aarch64"], &["linux"]),
    ];

    fn folder(form: Form, is_meant: impl Fn(&&Platform) -> bool) -> Option<&'static str> {
        let (two, three, ..) = ALL.iter().find(is_meant)?;
        Some(match form.version {
            Version::Two => two,
            Version::Three => three,
        })
    }

    /// The names that a user may write: those of FMI 2.0.
    pub fn names() -> Vec<&'static str> {
        let mut names: Vec<_> = ALL.iter().map(|(two, ..)| *two).collect();
        names.dedup();
        names
    }

    /// The folder of the platform with this name, which may be that of either version.
    pub fn named(name: &str, form: Form) -> Option<&'static str> {
        folder(form, |(two, three, ..)| *two == name || *three == name)
    }

    /// The folder for a processor and an operating system, as Rust names them.
    pub fn of(processor: &str, system: &str, form: Form) -> Option<&'static str> {
        folder(form, |(.., processors, systems)| processors.contains(&processor) && systems.contains(&system))
    }
}

/// Keeps the library's code in memory after a host has unloaded it: threads of the host may still hold destructors of
/// Rust's thread-local variables (rust-lang/rust issues 91979 and 134820).
const STAY: &str = "link-arg=-Wl,-z,nodelete";

/// Builds the library of a package for a target; without one for this machine.
pub fn library(
    package: &str,
    folder: &Path,
    profile: &str,
    target: Option<&str>,
    form: Form,
) -> Result<Binary, PackageError> {
    let (processor, system) = match target {
        Some(triple) => {
            let mut parts = triple.split('-');
            let processor = parts.next().unwrap_or_default();
            (processor, parts.nth(1).unwrap_or_default())
        }
        None => (std::env::consts::ARCH, std::env::consts::OS),
    };
    let platform = platform::of(processor, system, form)
        .ok_or_else(|| PackageError::Usage(format!("FMI has no platform for {processor} and {system}")))?;
    let manifest = folder.join("Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.args(["rustc", "--lib", "--crate-type", "cdylib", "--package", package]);
    command.args(["--profile", profile]).arg("--manifest-path").arg(&manifest);
    command.args(["--message-format", "json-render-diagnostics"]);
    if let Some(triple) = target {
        command.args(["--target", triple]);
    }
    if system == "linux" {
        command.args(["--", "-C", STAY]);
    }
    let done = command
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| PackageError::Build(format!("cargo: {error}")))?;
    if !done.status.success() {
        return Err(PackageError::Build(format!("cargo failed with {}", done.status)));
    }
    let library = built(&String::from_utf8_lossy(&done.stdout), &manifest)
        .ok_or_else(|| PackageError::Build("cargo does not name the library".to_owned()))?;
    Ok(Binary { platform, library })
}

/// The library among the files that cargo tells it has made for the package with this manifest.
fn built(messages: &str, manifest: &Path) -> Option<PathBuf> {
    messages.lines().rev().find_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let ours =
            message["reason"] == "compiler-artifact" && Path::new(message["manifest_path"].as_str()?) == manifest;
        message["filenames"]
            .as_array()
            .filter(|_| ours)?
            .iter()
            .filter_map(|file| Some(PathBuf::from(file.as_str()?)))
            .into_iter()
            .find(|path| {
                let extension = path.extension().unwrap_or_default();
                ["so", "dll", "dylib"].iter().any(|known| extension == *known)
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn platforms_have_the_folders_of_the_standard() {
        for (processor, system, two, three) in [
            ("x86_64", "linux", Some("linux64"), Some("x86_64-linux")),
            ("x86_64", "windows", Some("win64"), Some("x86_64-windows")),
            ("aarch64", "darwin", Some("darwin64"), Some("aarch64-darwin")),
            ("wasm32", "unknown", None, None),
        ] {
            let three_form = Form { version: crate::description::Version::Three, ..Form::default() };
            let of = |form| platform::of(processor, system, form);
            assert_eq!((of(Form::default()), of(three_form)), (two, three), "{processor} {system}");
        }
    }

    #[test]
    fn the_library_is_that_of_the_package() {
        let artifact = |manifest: &str, files: &str| {
            format!(r#"{{"reason":"compiler-artifact","manifest_path":"{manifest}","filenames":[{files}]}}"#)
        };
        let messages = [
            artifact("/a/Cargo.toml", r#""/t/libother.so""#),
            artifact("/b/Cargo.toml", r#""/t/tank.dll.a","/t/tank.dll""#),
            r#"{"reason":"build-finished","success":true}"#.to_owned(),
        ]
        .join("\n");
        assert_eq!(built(&messages, Path::new("/b/Cargo.toml")), Some("/t/tank.dll".into()));
        assert_eq!(built(&messages, Path::new("/c/Cargo.toml")), None);
    }
}
