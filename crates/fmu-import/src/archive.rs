//! The FMU as a file: a zip archive, or a folder that holds an unpacked one.
//!
//! Nothing in an archive is trusted: no entry leaves the target folder, links are refused, and
//! the number of entries and the unpacked size are limited.

mod error;
mod repack;
mod unpack;

use std::{
    borrow::Cow,
    collections::HashSet,
    fs::{self, File},
    io::{self, BufReader, Read},
    path::{Path, PathBuf},
};

use tempfile::TempDir;
use zip::{
    ZipArchive,
    read::Config,
    result::{ZipError, ZipResult},
    unstable::read::ZipIterable,
};

use crate::version::Version;

pub use error::ArchiveError;

/// More entries than any FMU has.
const MAX_ENTRIES: usize = 100_000;
/// The largest unpacked size, bytes.
const MAX_UNPACKED: u64 = 8 << 30;
/// The largest file that is looked into, bytes.
const MAX_FILE: u64 = 1 << 30;
/// The largest model description, bytes.
const MAX_DESCRIPTION: u64 = 256 << 20;

const DESCRIPTION: &str = "modelDescription.xml";

/// The folder name that FMI 2.0 gives to this platform's binaries.
pub const PLATFORM: &str = Version::Two.platform();

/// The extension of a shared library on this platform.
const EXTENSION: &str = if cfg!(target_os = "windows") {
    "dll"
} else if cfg!(target_os = "macos") {
    "dylib"
} else {
    "so"
};

/// An FMU's files.
#[derive(Debug)]
pub(crate) enum Archive {
    Folder(PathBuf),
    Zip {
        path: PathBuf,
        zip: ZipArchive<File>,
        /// The names that more than one entry has.
        twice: Vec<String>,
    },
}

impl Archive {
    pub fn open(path: &Path) -> Result<Self, ArchiveError> {
        let metadata = fs::metadata(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => ArchiveError::Missing,
            _ => ArchiveError::Io(error),
        })?;
        if metadata.is_dir() {
            return Ok(Self::Folder(path.to_owned()));
        }
        let file = open(path)?;
        let unreadable = |error| match error {
            ZipError::Io(error) => ArchiveError::Io(error),
            _ => ArchiveError::NotZip,
        };
        // The crate keeps the last entry of a name, and all of them in memory.
        let entries = ZipIterable::try_new(BufReader::new(&file), Config::default()).map_err(unreadable)?;
        if entries.len() > MAX_ENTRIES {
            return Err(ArchiveError::TooLarge);
        }
        let twice = names_twice(entries).map_err(unreadable)?;
        let zip = ZipArchive::new(file).map_err(unreadable)?;
        // It may have taken another directory, further ahead in the file.
        if zip.len() > MAX_ENTRIES {
            return Err(ArchiveError::TooLarge);
        }
        let path = path.to_owned();
        Ok(Self::Zip { path, zip, twice })
    }

    /// The bytes of `modelDescription.xml`.
    pub fn description(&mut self) -> Result<Vec<u8>, ArchiveError> {
        let is_there = match self {
            Self::Folder(path) => path.join(DESCRIPTION).exists(),
            Self::Zip { zip, .. } => zip.index_for_name(DESCRIPTION).is_some(),
        };
        if !is_there {
            return Err(self.no_description());
        }
        if self.twice().iter().any(|name| name == DESCRIPTION) {
            return Err(ArchiveError::Twice(DESCRIPTION.to_owned()));
        }
        self.content(DESCRIPTION, MAX_DESCRIPTION)?.ok_or(ArchiveError::LargeDescription)
    }

    fn no_description(&self) -> ArchiveError {
        let entries = self.entries();
        if entries.iter().any(|entry| entry == "SystemStructure.ssd") {
            return ArchiveError::System;
        }
        entries
            .into_iter()
            .find(|entry| entry.eq_ignore_ascii_case(DESCRIPTION))
            .map_or(ArchiveError::NoDescription, ArchiveError::Misnamed)
    }

    /// The names of the files.
    pub fn entries(&self) -> Vec<String> {
        match self {
            Self::Folder(path) => files_below(path, path),
            // Not by the zip's own order of names: what could not be unpacked is to be seen, too.
            Self::Zip { zip, .. } => zip.file_names().filter_map(Result::ok).map(Cow::into_owned).collect(),
        }
    }

    /// The names that more than one entry has.
    pub fn twice(&self) -> &[String] {
        match self {
            Self::Folder(_) => &[],
            Self::Zip { twice, .. } => twice,
        }
    }

    /// A binary for this platform that has another name than the model.
    fn misnamed(&self, identifier: &str, platform: &str) -> Option<ArchiveError> {
        let (folder, end) = (format!("binaries/{platform}/"), format!(".{EXTENSION}"));
        let is_binary = |entry: &&String| {
            let file = entry.strip_prefix(&folder);
            file.is_some_and(|file| !file.contains('/') && file.ends_with(&end))
        };
        let entries = self.entries();
        let mut binaries = entries.iter().filter(is_binary);
        let only = binaries.next().filter(|_| binaries.next().is_none())?;
        Some(ArchiveError::OtherName(only.clone(), format!("{identifier}{end}")))
    }

    /// The content of one file.
    pub fn bytes_of(&mut self, entry: &str) -> Result<Vec<u8>, ArchiveError> {
        self.content(entry, MAX_FILE)?.ok_or_else(|| ArchiveError::LargeFile(entry.to_owned()))
    }

    /// The content of one file; none where it is larger than so many bytes, whatever the archive declares.
    fn content(&mut self, entry: &str, most: u64) -> Result<Option<Vec<u8>>, ArchiveError> {
        let mut bytes = Vec::new();
        match self {
            Self::Folder(path) => {
                open(&path.join(entry))?.take(most + 1).read_to_end(&mut bytes)?;
            }
            Self::Zip { zip, .. } => {
                let wrong = |error| ArchiveError::of_entry(entry, error);
                let file = zip.by_name(entry).map_err(wrong)?;
                if file.size() > most {
                    return Ok(None);
                }
                file.take(most + 1).read_to_end(&mut bytes).map_err(|error| wrong(error.into()))?;
            }
        }
        Ok(Some(bytes).filter(|bytes| bytes.len() as u64 <= most))
    }

    /// The file that identifies the content: the archive, or the description in a folder.
    pub fn identity(&self) -> Result<File, ArchiveError> {
        match self {
            Self::Folder(path) => open(&path.join(DESCRIPTION)),
            Self::Zip { path, .. } => open(path),
        }
    }

    pub fn folder(&self) -> Option<&Path> {
        match self {
            Self::Folder(path) => Some(path),
            Self::Zip { .. } => None,
        }
    }

    /// The platforms with a binary of this model, sorted.
    pub fn platforms(&self, identifier: &str) -> Vec<String> {
        let mut platforms: Vec<String> = match self {
            Self::Folder(path) => folder_platforms(&path.join("binaries"), identifier),
            Self::Zip { zip, .. } => zip.file_names().filter_map(|name| platform_of(&name.ok()?, identifier)).collect(),
        };
        platforms.sort();
        platforms.dedup();
        platforms
    }

    /// Unpacks the description, this platform's binaries and the resources into a new folder
    /// within `parent`; copies them from a folder, which an FMU that writes must not spoil.
    pub fn unpack(&mut self, identifier: &str, version: Version, parent: &Path) -> Result<TempDir, ArchiveError> {
        let platform = version.platform();
        let held = self.platforms(identifier);
        if !held.iter().any(|held| held == platform) {
            let source = self.entries().iter().any(|entry| entry.starts_with("sources/"));
            let source = source.then(|| "the source code (`fmpy compile` builds it)".to_owned());
            let mut held: Vec<String> = held.into_iter().chain(source).collect();
            if held.is_empty() {
                held.push("none at all".to_owned());
            }
            return Err(self.misnamed(identifier, platform).unwrap_or(ArchiveError::NoBinary { platform, held }));
        }
        let target = numbered(parent).map_err(ArchiveError::NoRoom)?;
        let unpacked = match self {
            Self::Zip { zip, .. } => unpack::unpack(zip, platform, target.path()),
            Self::Folder(folder) => unpack::Copy::default().needed(folder, platform, target.path()),
        };
        unpacked.map(|()| target).map_err(ArchiveError::of_room)
    }
}

/// A new folder, which is removed with the value. Its name is the same in every run, since an FMU may see it.
fn numbered(parent: &Path) -> io::Result<TempDir> {
    for number in 1_u32.. {
        let name = format!("fmu-{number}");
        match tempfile::Builder::new().prefix(&name).rand_bytes(0).tempdir_in(parent) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            made => return made,
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Opens a file. Opening a pipe would wait for its writer, and a device may have no end.
fn open(path: &Path) -> Result<File, ArchiveError> {
    if fs::metadata(path)?.is_file() { Ok(File::open(path)?) } else { Err(ArchiveError::NoFile(path.to_owned())) }
}

/// The names that more than one entry has, each once.
fn names_twice(mut entries: ZipIterable<BufReader<&File>>) -> ZipResult<Vec<String>> {
    let (mut seen, mut told, mut twice) = (HashSet::new(), HashSet::new(), Vec::new());
    for entry in entries.files()? {
        let name = entry?.name_raw().to_owned();
        if let Some(name) = seen.replace(name)
            && told.insert(name.clone())
        {
            twice.push(String::from_utf8_lossy(&name).into_owned());
        }
    }
    Ok(twice)
}

/// The path of the binary below an unpacked FMU.
pub(crate) fn binary(folder: &Path, identifier: &str, version: Version) -> PathBuf {
    folder.join("binaries").join(version.platform()).join(format!("{identifier}.{EXTENSION}"))
}

fn platform_of(name: &str, identifier: &str) -> Option<String> {
    let name = name.replace('\\', "/");
    let (platform, file) = name.strip_prefix("binaries/")?.split_once('/')?;
    let stem = file.rsplit_once('.')?.0;
    (stem == identifier).then(|| platform.to_owned())
}

/// What a folder holds, as far as it can be read.
pub fn entries_in(folder: &Path) -> impl Iterator<Item = fs::DirEntry> {
    fs::read_dir(folder).into_iter().flatten().flatten()
}

/// The names of that.
pub fn names_in(folder: &Path) -> impl Iterator<Item = String> {
    entries_in(folder).map(|entry| entry.file_name().to_string_lossy().into_owned())
}

/// The files below a folder, by their paths from `root`, with forward slashes.
fn files_below(folder: &Path, root: &Path) -> Vec<String> {
    entries_in(folder)
        .flat_map(|entry| match entry.file_type() {
            Ok(kind) if kind.is_dir() => files_below(&entry.path(), root),
            _ => {
                let path = entry.path();
                let below = path.strip_prefix(root).unwrap_or(&path);
                vec![below.to_string_lossy().replace('\\', "/")]
            }
        })
        .collect()
}

fn folder_platforms(binaries: &Path, identifier: &str) -> Vec<String> {
    entries_in(binaries)
        .filter(|platform| {
            entries_in(&platform.path())
                .map(|file| file.path())
                .any(|file| file.file_stem().is_some_and(|stem| stem == identifier))
        })
        .map(|platform| platform.file_name().to_string_lossy().into_owned())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use zip::write::{SimpleFileOptions, ZipWriter};

    fn archive(entries: &[(&str, &[u8])]) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.fmu");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        for (name, content) in entries {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(content).unwrap();
        }
        zip.finish().unwrap();
        (folder, path)
    }

    /// An archive whose directory has these names, all of one empty file.
    fn directory(names: &[String]) -> (TempDir, PathBuf) {
        let mut bytes = b"PK\x03\x04\x14".to_vec();
        bytes.resize(30, 0);
        bytes[26] = 1;
        bytes.push(b'a');
        let start = bytes.len() as u64;
        for name in names {
            let mut head = [0; 46];
            head[..7].copy_from_slice(b"PK\x01\x02\x14\0\x14");
            head[28] = u8::try_from(name.len()).unwrap();
            bytes.extend(head);
            bytes.extend(name.as_bytes());
        }
        let end = bytes.len() as u64;
        let count = names.len() as u64;
        bytes.extend(b"PK\x06\x06\x2c\0\0\0\0\0\0\0\x2d\0\x2d\0\0\0\0\0\0\0\0\0");
        for number in [count, count, end - start, start] {
            bytes.extend(number.to_le_bytes());
        }
        bytes.extend(b"PK\x06\x07\0\0\0\0");
        bytes.extend(end.to_le_bytes());
        bytes.extend(b"\x01\0\0\0PK\x05\x06\0\0\0\0");
        bytes.extend([0xff; 12]);
        bytes.extend(b"\0\0");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.fmu");
        fs::write(&path, bytes).unwrap();
        (folder, path)
    }

    #[test]
    fn every_entry_counts_however_often_its_name_comes() {
        let names = |count: usize| -> Vec<String> { (0..count).map(|k| format!("n{k}")).collect() };
        let (_folder, path) = directory(&[names(40_000), names(40_000)].concat());
        let archive = Archive::open(&path).unwrap();
        assert_eq!(archive.twice(), names(40_000));
        for many in [[names(60_000), names(60_000)].concat(), vec!["a".to_owned(); 100_001]] {
            let (_folder, path) = directory(&many);
            let error = Archive::open(&path).unwrap_err().to_string();
            assert_eq!(error, "refused: more than 100000 entries or 8 GiB");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_may_hold_no_device_and_no_circle() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let ours = format!("binaries/{PLATFORM}");
        fs::create_dir_all(path(&ours)).unwrap();
        fs::write(path(&format!("{ours}/m.{EXTENSION}")), "").unwrap();
        fs::write(path(DESCRIPTION), "<x/>").unwrap();
        fs::create_dir(path("resources")).unwrap();
        let refused = |target: &Path| {
            let link = path("resources/link");
            std::os::unix::fs::symlink(target, &link).unwrap();
            let mut archive = Archive::open(folder.path()).unwrap();
            let error = archive.unpack("m", Version::Two, &std::env::temp_dir());
            fs::remove_file(link).unwrap();
            error.unwrap_err().to_string()
        };
        let device = refused(Path::new("/dev/zero"));
        assert!(device.ends_with("link is a device or a pipe, which may have no end; give a file"));
        // The system ends a circle of links.
        refused(&path("resources"));
        fs::remove_file(path(DESCRIPTION)).unwrap();
        std::os::unix::fs::symlink("/dev/zero", path(DESCRIPTION)).unwrap();
        let error = Archive::open(folder.path()).unwrap().description();
        assert!(matches!(error, Err(ArchiveError::NoFile(_))));
    }

    #[test]
    fn unpacks_only_what_this_platform_needs() {
        let ours = format!("binaries/{PLATFORM}/m.{EXTENSION}");
        let (_folder, path) = archive(&[
            (DESCRIPTION, b"<x/>"),
            (&ours, b"binary"),
            ("binaries/other/m.dll", b"binary"),
            ("resources/table.csv", b"1,2"),
            ("sources/m.c", b"int x;"),
        ]);
        let mut archive = Archive::open(&path).unwrap();
        assert_eq!(archive.description().unwrap(), b"<x/>");
        let target = archive.unpack("m", Version::Two, &std::env::temp_dir()).unwrap();
        assert!(binary(target.path(), "m", Version::Two).exists());
        assert!(target.path().join("resources/table.csv").exists());
        assert!(!target.path().join("binaries/other").exists());
        assert!(!target.path().join("sources").exists());
    }

    #[test]
    fn refuses_to_write_outside_the_folder() {
        let ours = format!("binaries/{PLATFORM}/m.{EXTENSION}");
        let (_folder, path) = archive(&[(DESCRIPTION, b"<x/>"), (&ours, b""), ("../outside.txt", b"gotcha")]);
        let error = Archive::open(&path).unwrap().unpack("m", Version::Two, &std::env::temp_dir()).unwrap_err();
        assert!(matches!(error, ArchiveError::Unsafe(_)), "{error}");
    }

    #[test]
    fn names_the_platforms_when_ours_is_missing() {
        let (_folder, path) = archive(&[(DESCRIPTION, b"<x/>"), ("binaries/other/m.dll", b"")]);
        let error = Archive::open(&path).unwrap().unpack("m", Version::Two, &std::env::temp_dir()).unwrap_err();
        assert!(error.to_string().contains("holds other"), "{error}");
    }

    #[test]
    fn names_a_binary_of_another_name() {
        let other = format!("binaries/{PLATFORM}/n.{EXTENSION}");
        let (_folder, path) = archive(&[(DESCRIPTION, b"<x/>"), (&other, b"")]);
        let error = Archive::open(&path).unwrap().unpack("m", Version::Two, &std::env::temp_dir()).unwrap_err();
        let text = error.to_string();
        assert!(text.starts_with(&other), "{text}");
        assert!(text.ends_with(&format!("call it m.{EXTENSION}")), "{text}");
    }

    #[test]
    fn refuses_two_descriptions() {
        // The writer refuses a second entry of a name, so it gets its name afterwards.
        let (_folder, path) = archive(&[(DESCRIPTION, b"<x/>"), ("modelDescription.XML", b"<y/>")]);
        let mut bytes = fs::read(&path).unwrap();
        let other = b"modelDescription.XML";
        while let Some(at) = bytes.windows(other.len()).position(|part| part == other) {
            bytes[at..at + other.len()].copy_from_slice(DESCRIPTION.as_bytes());
        }
        fs::write(&path, bytes).unwrap();
        let mut archive = Archive::open(&path).unwrap();
        let error = archive.description().unwrap_err();
        assert!(matches!(error, ArchiveError::Twice(_)), "{error}");
    }

    #[test]
    fn tells_what_is_no_fmu() {
        let (folder, path) = archive(&[("readme.txt", b"")]);
        let mut empty = Archive::open(&path).unwrap();
        assert!(matches!(empty.description(), Err(ArchiveError::NoDescription)));
        assert!(matches!(Archive::open(&folder.path().join("none.fmu")), Err(ArchiveError::Missing)));
        let text = folder.path().join("text.fmu");
        fs::write(&text, "not a zip").unwrap();
        assert!(matches!(Archive::open(&text), Err(ArchiveError::NotZip)));
    }
}
