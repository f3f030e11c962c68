//! The libraries that a binary needs but this machine has not.

use std::path::Path;
use std::process::{Command, Stdio};

/// The dynamic loaders that list what a library needs without running any of it.
const LOADERS: [&str; 2] = ["/lib64/ld-linux-x86-64.so.2", "/lib/ld-linux-aarch64.so.1"];

/// The names of all libraries that are missing, those that other libraries need among them. The loader itself stops
/// at the first. Nothing where the machine has no loader that can tell.
pub fn missing(binary: &Path) -> Vec<String> {
    let Some(loader) = LOADERS.iter().find(|loader| Path::new(loader).exists()) else {
        return Vec::new();
    };
    let listing = Command::new(loader)
        .arg(binary)
        .env("LD_TRACE_LOADED_OBJECTS", "1")
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output();
    let text = listing.map(|listing| listing.stdout).unwrap_or_default();
    let mut names: Vec<String> = String::from_utf8_lossy(&text)
        .lines()
        .filter_map(|line| line.trim().strip_suffix("=> not found"))
        .map(|name| name.trim().to_owned())
        .collect();
    names.dedup();
    names
}
