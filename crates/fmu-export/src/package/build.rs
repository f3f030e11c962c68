//! Building a model's library with cargo.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::{Binary, PackageError};

/// The folders that FMI 2.0 names for platforms. It names none for 64-bit Arm on Linux, where importers look into the
/// folder of FMI 3.0.
pub(super) mod platform {
    /// The folders' names.
    pub(in crate::package) const NAMES: [&str; 6] = [
        "linux64",
        "linux32",
        "win64",
        "win32",
        "darwin64",
        "aarch64-linux",
    ];

    /// The folder of this name.
    pub(in crate::package) fn named(name: &str) -> Option<&'static str> {
        NAMES.into_iter().find(|known| *known == name)
    }

    /// The folder for a processor and an operating system, as Rust names them.
    pub(super) fn of(processor: &str, system: &str) -> Option<&'static str> {
        named(match (processor, system) {
            ("x86_64", "linux") => "linux64",
            ("i586" | "i686" | "x86", "linux") => "linux32",
            ("x86_64", "windows") => "win64",
            ("i586" | "i686" | "x86", "windows") => "win32",
            ("x86_64" | "aarch64", "macos" | "darwin") => "darwin64",
            ("aarch64", "linux") => "aarch64-linux",
            _ => return None,
        })
    }
}

/// Keeps the library's code in memory after a host has unloaded it: threads of the host may still hold destructors of
/// Rust's thread-local variables (rust-lang/rust issues 91979 and 134820).
const STAY: &str = "link-arg=-Wl,-z,nodelete";

/// Builds the library of a package for a target; without one for this machine.
pub(super) fn library(
    package: &str,
    folder: &Path,
    profile: &str,
    target: Option<&str>,
) -> Result<Binary, PackageError> {
    let (processor, system) = match target {
        Some(triple) => {
            let mut parts = triple.split('-');
            let processor = parts.next().unwrap_or_default();
            (processor, parts.nth(1).unwrap_or_default())
        }
        None => (std::env::consts::ARCH, std::env::consts::OS),
    };
    let platform = platform::of(processor, system).ok_or_else(|| {
        PackageError::Usage(format!(
            "FMI 2.0 has no platform for {processor} and {system}"
        ))
    })?;
    let manifest = folder.join("Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.args([
        "rustc",
        "--lib",
        "--crate-type",
        "cdylib",
        "--package",
        package,
    ]);
    command
        .args(["--profile", profile])
        .arg("--manifest-path")
        .arg(&manifest);
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
        return Err(PackageError::Build(format!(
            "cargo failed with {}",
            done.status
        )));
    }
    let library = built(&String::from_utf8_lossy(&done.stdout), &manifest)
        .ok_or_else(|| PackageError::Build("cargo does not name the library".to_owned()))?;
    Ok(Binary { platform, library })
}

/// The library among the files that cargo tells it has made for the package with this manifest.
fn built(messages: &str, manifest: &Path) -> Option<PathBuf> {
    messages.lines().rev().find_map(|line| {
        let message: serde_json::Value = serde_json::from_str(line).ok()?;
        let ours = message["reason"] == "compiler-artifact"
            && Path::new(message["manifest_path"].as_str()?) == manifest;
        let files = message["filenames"].as_array().filter(|_| ours)?;
        let paths = files
            .iter()
            .filter_map(|file| Some(PathBuf::from(file.as_str()?)));
        let shared = |path: &PathBuf| {
            let extension = path.extension().unwrap_or_default();
            ["so", "dll", "dylib"]
                .iter()
                .any(|known| extension == *known)
        };
        paths.into_iter().find(shared)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn platforms_have_the_folders_of_the_standard() {
        for (processor, system, folder) in [
            ("x86_64", "linux", Some("linux64")),
            ("x86_64", "windows", Some("win64")),
            ("aarch64", "darwin", Some("darwin64")),
            ("wasm32", "unknown", None),
        ] {
            assert_eq!(
                platform::of(processor, system),
                folder,
                "{processor} {system}"
            );
        }
    }

    #[test]
    fn the_library_is_that_of_the_package() {
        let artifact = |manifest: &str, files: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","manifest_path":"{manifest}","filenames":[{files}]}}"#
            )
        };
        let messages = [
            artifact("/a/Cargo.toml", r#""/t/libother.so""#),
            artifact("/b/Cargo.toml", r#""/t/tank.dll.a","/t/tank.dll""#),
            r#"{"reason":"build-finished","success":true}"#.to_owned(),
        ]
        .join("\n");
        assert_eq!(
            built(&messages, Path::new("/b/Cargo.toml")),
            Some("/t/tank.dll".into())
        );
        assert_eq!(built(&messages, Path::new("/c/Cargo.toml")), None);
    }
}
