//! An FMU at rest: its description, and its files.

use std::{
    io::{self, Read, Seek, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

use roxmltree::Node;
use sha2::{Digest, Sha256};
use tempfile::TempDir;
use thiserror::Error;

use crate::{
    archive::{self, Archive, ArchiveError},
    decode,
    description::Description,
    isolation::watch::Snapshot,
    library::{Library, LibraryError},
    parse::{self, DescriptionError},
    value::hexadecimal,
    xml,
};

/// Why an FMU cannot be used.
#[derive(Debug, Error)]
#[error("{path}: {fault}")]
pub struct FmuError {
    /// The FMU, as the user calls it.
    pub path: PathBuf,
    /// The problem.
    #[source]
    pub fault: FmuFault,
}

impl FmuError {
    /// The same, of the FMU that the user calls so.
    pub fn at(self, name: &Path) -> Self {
        let path = name.to_owned();
        Self { path, ..self }
    }
}

/// The part of an FMU that cannot be used.
#[derive(Debug, Error)]
pub enum FmuFault {
    /// The file cannot be read or unpacked.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// `modelDescription.xml` cannot be used.
    #[error("modelDescription.xml: {0}")]
    Description(#[from] DescriptionError),
    /// The binary cannot be loaded.
    #[error(transparent)]
    Library(#[from] LibraryError),
}

impl FmuFault {
    /// Whether the fault lies in the FMU rather than in the request.
    pub fn is_in_fmu(&self) -> bool {
        match self {
            Self::Archive(fault) => fault.is_a_fault(),
            Self::Description(_) | Self::Library(_) => true,
        }
    }
}

/// An FMU at rest: its description, and its files once they are unpacked.
#[derive(Debug)]
pub struct Package {
    path: PathBuf,
    archive: Archive,
    description: Description,
    /// Where it was unpacked, and how that folder was then.
    unpacked: Option<(PathBuf, Snapshot)>,
    /// The folder around it, where it was made here.
    own: Option<Arc<TempDir>>,
}

impl Package {
    /// Opens an FMU file, or a folder that holds an unpacked one, and reads its description.
    ///
    /// # Errors
    /// When there is no such file, when it is not an FMU, and when it is not one of FMI 2.0 or 3.0 for
    /// Co-Simulation.
    pub fn open(path: &Path) -> Result<Self, FmuError> {
        let unusable = |fault| FmuError { path: path.to_owned(), fault };
        let mut archive = Archive::open(path).map_err(|fault| unusable(fault.into()))?;
        let description = described(&mut archive, &[]).map_err(unusable)?;
        Ok(Self { path: path.to_owned(), archive, description, unpacked: None, own: None })
    }

    /// Reads the description again with these values of structural parameters, by their value references: its arrays have
    /// these sizes. Simulations set them with [`Instance::resize`](crate::Instance::resize).
    ///
    /// # Errors
    /// When it cannot be read any more.
    pub fn resize(&mut self, sizes: &[(u32, u64)]) -> Result<(), FmuError> {
        if sizes != self.description.sizes {
            let read = described(&mut self.archive, sizes);
            self.description = read.map_err(|fault| self.unusable(fault))?;
        }
        Ok(())
    }

    /// Path of the FMU.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The contents of its `modelDescription.xml`.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The platforms for which it holds a binary, such as `linux64`.
    pub fn platforms(&self) -> Vec<String> {
        self.archive.platforms(&self.description.model_identifier)
    }

    /// The names of its files, as they are written in the archive.
    pub fn entries(&self) -> Vec<String> {
        self.archive.entries()
    }

    /// The names that more than one of its files has.
    pub fn entries_twice(&self) -> &[String] {
        self.archive.twice()
    }

    /// The content of one file.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn bytes_of(&mut self, entry: &str) -> Result<Vec<u8>, FmuError> {
        self.archive.bytes_of(entry).map_err(|fault| self.unusable(fault))
    }

    /// Writes a copy of the FMU with these files, and without those that `leave_out` names. Whatever else was there stays as it
    /// is, byte for byte.
    ///
    /// # Errors
    /// When the FMU is a folder or has two files of one name, and when the system says no.
    pub fn copy_with(
        &mut self,
        into: impl Write + Seek,
        leave_out: impl Fn(&str) -> bool,
        files: &[(String, Vec<u8>)],
    ) -> Result<(), FmuError> {
        self.archive.copy_with(into, leave_out, files).map_err(|fault| self.unusable(fault))
    }

    /// Hands the document of `modelDescription.xml` to `read`.
    ///
    /// # Errors
    /// When it cannot be read any more.
    pub fn with_document<T>(&mut self, read: impl FnOnce(Node) -> T) -> Result<T, FmuError> {
        let bytes = self.archive.description().map_err(|fault| self.unusable(fault))?;
        let text = decode::decode(&bytes);
        let document = xml::parse(&text).map_err(|fault| self.unusable(DescriptionError::from(fault)))?;
        Ok(read(document.root_element()))
    }

    /// The SHA-256 digest of the FMU file, as hexadecimal digits; of the description alone for a folder.
    ///
    /// # Errors
    /// When the file cannot be read any more.
    pub fn digest(&self) -> Result<String, FmuError> {
        let hash = self.archive.identity().and_then(|file| Ok(sha256(file)?)).map_err(|fault| self.unusable(fault))?;
        Ok(hexadecimal(&hash))
    }

    fn unusable(&self, fault: impl Into<FmuFault>) -> FmuError {
        FmuError { path: self.path.clone(), fault: fault.into() }
    }

    /// Unpacks what a simulation on this platform needs into a new folder within `parent`, and returns that. One that
    /// is there already is used again, unless the FMU has changed anything in it. It stays until whoever made `parent` removes
    /// that: another program may have a folder of the same name then.
    ///
    /// # Errors
    /// When there is no binary for this platform, when the archive is unsafe or damaged, and when
    /// there is no room.
    pub fn unpack(&mut self, parent: &Path) -> Result<PathBuf, FmuError> {
        // The folder unpacked for workers may be gone with their other files.
        let kept = self.unpacked.take().filter(|(folder, then)| Snapshot::of(folder) == *then);
        let (folder, then) = match kept {
            Some(kept) => kept,
            None => {
                let folder = self.unpack_anew(parent)?.keep();
                let then = Snapshot::of(&folder);
                (folder, then)
            }
        };
        self.unpacked = Some((folder.clone(), then));
        Ok(folder)
    }

    /// Unpacks what a simulation on this platform needs into a new folder within `parent`, which is removed with
    /// the value: `parent` must still be there then.
    ///
    /// # Errors
    /// As [`unpack`](Self::unpack).
    pub fn unpack_anew(&mut self, parent: &Path) -> Result<TempDir, FmuError> {
        let Description { model_identifier, standard, .. } = &self.description;
        self.archive.unpack(model_identifier, *standard, parent).map_err(|fault| match fault {
            // The FMU is not to blame.
            ArchiveError::NoRoom(_) => FmuError { path: parent.to_owned(), fault: fault.into() },
            fault => self.unusable(fault),
        })
    }

    /// The binary for this platform in the folder into which the FMU was unpacked; none where there is none.
    pub fn binary(&self, folder: &Path) -> Option<PathBuf> {
        let binary = archive::binary(folder, &self.description.model_identifier, self.description.standard);
        binary.exists().then_some(binary)
    }

    /// Unpacks the FMU, unless it is a folder, and loads its binary into this process. The library keeps the files that it
    /// may read later, also when the package is gone.
    ///
    /// # Errors
    /// As [`unpack`](Self::unpack), and when the binary cannot be loaded.
    pub fn load(&mut self) -> Result<Arc<Library>, FmuError> {
        let folder = match self.archive.folder() {
            Some(folder) => folder.to_owned(),
            None => {
                let own = match self.own.take() {
                    Some(own) => own,
                    None => Arc::new(tempfile::tempdir().map_err(|error| self.unusable(ArchiveError::from(error)))?),
                };
                let folder = self.unpack(own.path())?;
                self.own = Some(own);
                folder
            }
        };
        let library = Library::load(&folder, self.own.clone(), &self.description);
        Ok(Arc::new(library.map_err(|fault| self.unusable(fault))?))
    }
}

/// The description, with these values of structural parameters.
fn described(archive: &mut Archive, sizes: &[(u32, u64)]) -> Result<Description, FmuFault> {
    Ok(parse::description(&archive.description()?, sizes)?)
}

/// The SHA-256 digest of bytes as lower-case hexadecimal digits: what tells two files apart.
pub fn digest(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// The SHA-256 digest of all that can be read.
///
/// # Errors
/// When it cannot be read.
pub fn sha256(mut from: impl Read) -> io::Result<[u8; 32]> {
    let (mut hash, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match from.read(&mut buffer)? {
            0 => return Ok(hash.finalize().into()),
            count => hash.update(&buffer[..count]),
        }
    }
}
