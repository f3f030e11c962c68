//! The libraries that a binary needs but this machine has not.

use std::{
    path::Path,
    process::{Command, Stdio},
};

/// The dynamic loaders that list what a library needs without running any of it.
const LOADERS: [&str; 2] = ["/lib64/ld-linux-x86-64.so.2", "/lib/ld-linux-aarch64.so.1"];

/// Which libraries are missing, those that other libraries need among them, and what to do. The loader itself stops
/// at the first. Nothing where the machine has no loader that can tell.
pub fn missing(binary: &Path) -> Option<String> {
    let loader = LOADERS.iter().find(|loader| Path::new(loader).exists())?;
    let text = Command::new(loader)
        .arg(binary)
        .env("LD_TRACE_LOADED_OBJECTS", "1")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?
        .stdout;
    let mut names: Vec<String> = String::from_utf8_lossy(&text)
        .lines()
        .filter_map(|line| line.trim().strip_suffix("=> not found"))
        .map(|name| name.trim().to_owned())
        .collect();
    names.dedup();
    let remedy = if names.iter().any(|name| binary.with_file_name(name).exists()) {
        "link it with -rpath '$ORIGIN', as the loader does not look beside the binary"
    } else {
        "install what is missing"
    };
    (!names.is_empty()).then(|| format!("it needs {}, not found on this machine: {remedy}", names.join(", ")))
}
