//! Why a file cannot be read or written, with a remedy.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::names::{did_you_mean, nearest};

/// The operating system's message in plain words, with a remedy where we know one.
pub fn reason(path: &Path, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => missing(path),
        io::ErrorKind::InvalidData => "not a text file in UTF-8".to_owned(),
        io::ErrorKind::IsADirectory => "a folder; give a file".to_owned(),
        io::ErrorKind::PermissionDenied => "no permission; look at its owner and mode".to_owned(),
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            format!(
                "{error}: nothing more can be written; make room and run the command again, with --resume where it has it"
            )
        }
        _ => error.to_string(),
    }
}

/// Says which folder was searched, or which one is missing, and names a file that is spelt nearly so.
pub fn missing(path: &Path) -> String {
    let full = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let lost = first_missing(&full);
    let Some(folder) = lost.parent() else {
        return "no such file".to_owned();
    };
    if lost != full {
        return format!("no such file: there is no folder {}", lost.display());
    }
    let names = names_in(folder);
    let wanted = full.file_name().unwrap_or_default().to_string_lossy();
    let meant = did_you_mean(nearest(&wanted, names.iter().map(String::as_str)));
    format!("no such file in {}{meant}", folder.display())
}

/// The first part of a path that is not there.
fn first_missing(full: &Path) -> PathBuf {
    let mut parts: Vec<&Path> = full.ancestors().collect();
    parts.reverse();
    let lost = parts.into_iter().find(|part| !part.exists());
    lost.unwrap_or(full).to_owned()
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_file_is_told_with_its_folder_and_a_name_like_it() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("study.toml"), "").unwrap();
        let here = folder.path().display();
        let told = |name: &str| {
            let path = folder.path().join(name);
            reason(&path, &fs::read(&path).unwrap_err())
        };
        assert_eq!(
            told("studdy.toml"),
            format!("no such file in {here}; did you mean `study.toml`?")
        );
        assert_eq!(told("q.csv"), format!("no such file in {here}"));
        assert_eq!(
            told("runs/a/q.csv"),
            format!("no such file: there is no folder {here}/runs")
        );
        let folder = reason(folder.path(), &fs::read(folder.path()).unwrap_err());
        assert_eq!(folder, "a folder; give a file");
    }
}
