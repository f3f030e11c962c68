//! Why an archive cannot be used.

use std::{io, path::PathBuf};

use thiserror::Error;
use zip::result::ZipError;

use super::{DESCRIPTION, MAX_DESCRIPTION, MAX_ENTRIES, MAX_FILE, MAX_UNPACKED};

/// Why an archive cannot be used.
#[derive(Debug, Error)]
pub enum ArchiveError {
    /// There is no such file.
    #[error("no such file")]
    Missing,
    /// Reading or writing failed.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file is not a zip archive.
    #[error("not a zip archive, so not an FMU")]
    NotZip,
    /// An entry cannot be read.
    #[error("{entry}: {why}")]
    Damaged {
        /// The entry's name.
        entry: String,
        /// The problem and its remedy.
        why: String,
    },
    /// It is neither a file nor a folder.
    #[error("{0} is a device or a pipe, which may have no end; give a file")]
    NoFile(PathBuf),
    /// It is a folder, and a file is needed.
    #[error("{0} is a folder; give the FMU as a file")]
    Folder(PathBuf),
    /// There is no model description.
    #[error("not an FMU: it holds no modelDescription.xml")]
    NoDescription,
    /// It is a system of FMUs by the standard SSP.
    #[error("a system of FMUs (SSP), where one FMU is needed")]
    System,
    /// The model description has another name.
    #[error("{0}: call it {DESCRIPTION}, as names differ by upper and lower case")]
    Misnamed(String),
    /// A file is unreasonably large.
    #[error("refused: {0} is larger than {most} GiB", most = MAX_FILE >> 30)]
    LargeFile(String),
    /// The model description is unreasonably large.
    #[error("modelDescription.xml is larger than {} MiB", MAX_DESCRIPTION >> 20)]
    LargeDescription,
    /// The folder for the unpacked files takes no more.
    #[error("{0}: FMUs are unpacked here; set TMPDIR to a folder with room")]
    NoRoom(io::Error),
    /// There is no binary for this platform.
    #[error("no binary for this platform ({platform}); the FMU holds {}", held.join(", "))]
    NoBinary {
        /// This platform, as the FMU's version of the standard names it.
        platform: &'static str,
        /// The platforms for which the FMU holds a binary, and what else it does.
        held: Vec<String>,
    },
    /// The binary for this platform has another name than the model.
    #[error("{0}: the binary is named otherwise than modelIdentifier: call it {1}")]
    OtherName(String, String),
    /// An entry is there twice, and readers differ in which one they take.
    #[error("refused: two entries `{0}`: remove one of them")]
    Twice(String),
    /// An entry would be written outside the target folder, or is a link.
    #[error("refused: the entry `{0}` is a link, lies outside the archive or has a name that not every system takes")]
    Unsafe(String),
    /// The archive is a decompression bomb, or absurdly large.
    #[error("refused: more than {MAX_ENTRIES} entries or {} GiB", MAX_UNPACKED >> 30)]
    TooLarge,
}

impl ArchiveError {
    /// Whether the fault lies in the FMU rather than in the request.
    pub fn is_a_fault(&self) -> bool {
        !matches!(
            self,
            Self::Missing | Self::Io(_) | Self::NoRoom(_) | Self::NotZip | Self::NoFile(_) | Self::Folder(_)
        )
    }

    /// An error of unpacking, where the folder may be at fault.
    pub(super) fn of_room(self) -> Self {
        use io::ErrorKind::{FileTooLarge, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
        match self {
            Self::Io(error)
                if matches!(error.kind(), FileTooLarge | QuotaExceeded | ReadOnlyFilesystem | StorageFull) =>
            {
                Self::NoRoom(error)
            }
            other => other,
        }
    }

    /// The problem with an entry.
    pub(super) fn of_entry(entry: &str, error: ZipError) -> Self {
        use io::ErrorKind::{
            AlreadyExists, InvalidData, InvalidInput, IsADirectory, NotADirectory, UnexpectedEof, Unsupported,
        };
        let why = match error {
            ZipError::UnsupportedArchive(ZipError::PASSWORD_REQUIRED) => {
                "encrypted: pack it without a password".to_owned()
            }
            ZipError::Io(error) => match error.kind() {
                AlreadyExists | NotADirectory | IsADirectory => {
                    "another entry is a file, but a folder in this one's path, or the reverse: rename one".to_owned()
                }
                InvalidData | InvalidInput | UnexpectedEof => {
                    format!("damaged ({error}): pack it anew")
                }
                Unsupported => format!("{error}: pack it by the method deflate"),
                _ => return Self::Io(error),
            },
            other => format!("damaged ({other}): pack it anew"),
        };
        let entry = entry.to_owned();
        Self::Damaged { entry, why }
    }
}
