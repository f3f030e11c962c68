//! Why a file cannot be read or written, with a remedy.

use std::{
    fmt::Display,
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
};

use thiserror::Error;

use fmu_import::{archive::names_in, hexadecimal, sha256};
use fmu_points::names::{did_you_mean, nearest};

/// What a file says, or why it cannot be used.
pub type Result<T = (), E = FileError> = std::result::Result<T, E>;

/// Why a file that a user names cannot be used.
#[derive(Debug, Error)]
#[error("{}{place}: {message}", .path.display())]
pub struct FileError {
    path: PathBuf,
    /// Line and column as they stand behind the file's name, such as `:3:7`.
    place: String,
    message: String,
    /// The kind of error, where the system said no.
    pub kind: Option<io::ErrorKind>,
}

impl FileError {
    /// Something in the file is wrong.
    pub fn new(path: &Path, message: impl Into<String>) -> Self {
        Self { path: path.to_owned(), place: String::new(), message: message.into(), kind: None }
    }

    /// The system refuses to open, read, write, make or rename it.
    pub fn system(path: &Path, error: io::Error) -> Self {
        let error = of_the_system(error);
        Self { kind: Some(error.kind()), ..Self::new(path, reason(path, &error)) }
    }

    /// The same with a remedy behind it, unless it names that already.
    pub fn with(mut self, remedy: impl AsRef<str>) -> Self {
        let remedy = remedy.as_ref();
        if !self.message.contains(remedy.trim_start_matches("; ")) {
            self.message += remedy;
        }
        self
    }

    /// The same, of a line, counted from 1.
    pub fn at_line(self, line: impl Display) -> Self {
        Self { place: format!(":{line}"), ..self }
    }

    /// The same, of a character of its line, counted from 1.
    pub fn at_column(mut self, column: usize) -> Self {
        self.place += &format!(":{column}");
        self
    }
}

/// The operating system's error inside the csv writer's: its kind decides which remedy we name.
fn of_the_system(error: io::Error) -> io::Error {
    match error.downcast::<csv::Error>() {
        Ok(wrapped) if wrapped.is_io_error() => match wrapped.into_kind() {
            csv::ErrorKind::Io(error) => error,
            other => io::Error::other(format!("{other:?}")),
        },
        Ok(wrapped) => io::Error::other(wrapped),
        Err(error) => error,
    }
}

/// The largest text that is read at once: a study, settings, a parameter set. In MiB.
const MOST: u64 = 64;

/// Opens a file that a user names. A device or a pipe may have no end, and what is read twice is gone after the first time.
///
/// # Errors
/// When there is none, or it is none.
pub fn open(path: &Path) -> io::Result<File> {
    let kind = fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !kind.is_file() {
        return Err(io::Error::other(
            "a device or a pipe, which may have no end; write its content to a file and give that",
        ));
    }
    File::open(path)
}

/// The SHA-256 digest of a file, as hexadecimal digits.
///
/// # Errors
/// As [`open`], and when it cannot be read.
pub fn digest(path: &Path) -> io::Result<String> {
    open(path).and_then(sha256).map(|hash| hexadecimal(&hash))
}

/// Reads a text that a user names.
///
/// # Errors
/// As [`open`], when it is very large, and when it is not in UTF-8.
pub fn text(path: &Path) -> Result<String> {
    read(path).map_err(|error| FileError::system(path, error))
}

fn read(path: &Path) -> io::Result<String> {
    let mut bytes = Vec::new();
    open(path)?.take((MOST << 20) + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MOST << 20 {
        return Err(io::Error::other(format!("larger than {MOST} MiB, which is the most that is read here")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let sound = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = sound.iter().filter(|byte| **byte == b'\n').count() + 1;
        io::Error::other(format!("line {line} is not text in UTF-8; save the file as UTF-8"))
    })
}

/// The operating system's message in plain words, with a remedy where we know one.
pub fn reason(path: &Path, error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => missing(path),
        io::ErrorKind::IsADirectory => "a folder; give a file".to_owned(),
        io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
            let there = path.ancestors().find(|part| part.symlink_metadata().is_ok() && !part.is_dir()).unwrap_or(path);
            let kind = match (there.is_file(), there.exists()) {
                (true, _) => "a file",
                (_, true) => "a device or a pipe",
                _ => "a link that leads nowhere",
            };
            format!("{} is {kind}, where a folder is needed", there.display())
        }
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
    let Some(folder) = lost.parent() else { return "no such file".to_owned() };
    if lost != full {
        return format!("no such file: there is no folder {}", lost.display());
    }
    let names: Vec<String> = names_in(folder).collect();
    let meant = did_you_mean(nearest(&name(&full), names.iter().map(String::as_str)));
    format!("no such file in {}{meant}", folder.display())
}

/// The first part of a path that is not there.
fn first_missing(full: &Path) -> PathBuf {
    let parts: Vec<&Path> = full.ancestors().collect();
    parts.into_iter().rev().find(|part| !part.exists()).unwrap_or(full).to_owned()
}

/// The name of a file without its folder.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A text on one line, with single blanks.
pub fn in_a_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The command that makes a plain table of any other file.
pub fn convert(path: &Path) -> String {
    format!("`python -m fmu_orchestrator convert \"{}\"` makes a plain table of it", path.display())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_text_is_refused_with_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        let told = |path: &Path| text(path).unwrap_err().message;
        fs::write(&path, b"a\nb\n\xe9").unwrap();
        assert_eq!(told(&path), "line 3 is not text in UTF-8; save the file as UTF-8");
        File::create(&path).unwrap().set_len((64 << 20) + 1).unwrap();
        assert_eq!(told(&path), "larger than 64 MiB, which is the most that is read here");
        assert_eq!(told(folder.path()), "a folder; give a file");
        let below = told(&path.join("b"));
        assert_eq!(below, format!("{} is a file, where a folder is needed", path.display()));
        if cfg!(unix) {
            let device = told("/dev/zero".as_ref());
            assert!(device.starts_with("a device or a pipe"), "{device}");
            let device = told("/dev/null/a".as_ref());
            assert_eq!(device, "/dev/null is a device or a pipe, where a folder is needed");
        }
    }

    #[test]
    fn a_missing_file_is_told_with_its_folder_and_a_name_like_it() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("study.toml"), "").unwrap();
        let here = folder.path().display();
        let told = |name: &str| {
            let path = folder.path().join(name);
            reason(&path, &fs::read(&path).unwrap_err())
        };
        assert_eq!(told("studdy.toml"), format!("no such file in {here}; did you mean `study.toml`?"));
        assert_eq!(told("q.csv"), format!("no such file in {here}"));
        assert_eq!(told("runs/a/q.csv"), format!("no such file: there is no folder {here}/runs"));
        let folder = reason(folder.path(), &fs::read(folder.path()).unwrap_err());
        assert_eq!(folder, "a folder; give a file");
    }
}
