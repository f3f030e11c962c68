//! The functions of a loaded binary by their names, and why there are none.

use std::ffi::c_char;
use std::path::{Path, PathBuf};

use libloading::Library as Loaded;
use thiserror::Error;

/// Why a binary cannot be loaded.
#[derive(Debug, Error)]
pub enum LibraryError {
    /// The dynamic loader refused it.
    #[error("cannot load {}: {reason}", place_in_fmu(path))]
    Load {
        /// The binary.
        path: PathBuf,
        /// The loader's message.
        reason: String,
    },
    /// A function is missing.
    #[error("the binary does not export `{0}`")]
    Function(&'static str),
    /// The resource folder has no URI.
    #[error("the folder {0} cannot be written as a URI")]
    Folder(PathBuf),
}

/// A function without arguments that returns a text, such as `fmi2GetVersion`.
pub(crate) type Text = unsafe extern "C" fn() -> *const c_char;

/// The path of a binary within its FMU: where that was unpacked tells a reader nothing.
fn place_in_fmu(path: &Path) -> String {
    // binaries, the platform, the file.
    const BELOW: usize = 3;
    let parts: Vec<_> = path.components().collect();
    let last: PathBuf = parts[parts.len().saturating_sub(BELOW)..].iter().collect();
    last.display().to_string()
}

/// A symbol as a function pointer of the type that the field asks for.
pub(crate) fn symbol<T: Copy>(library: &Loaded, name: &'static str) -> Result<T, LibraryError> {
    // SAFETY: `T` is the function type that the standard gives to this name.
    let symbol = unsafe { library.get::<T>(name.as_bytes()) };
    symbol
        .map(|symbol| *symbol)
        .map_err(|_| LibraryError::Function(name))
}
