//! The functions of a loaded binary by their names, and why there are none.

use std::{
    ffi::{c_char, c_int, c_void},
    path::{Path, PathBuf},
};

use libloading::Library as Loaded;
use thiserror::Error;

use crate::{
    call::{Call, Called},
    version::Version,
};

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

/// The path of a binary within its FMU: where that was unpacked tells a reader nothing.
fn place_in_fmu(path: &Path) -> String {
    // binaries, the platform, the file.
    const BELOW: usize = 3;
    let parts: Vec<_> = path.components().collect();
    let last: PathBuf = parts[parts.len().saturating_sub(BELOW)..].iter().collect();
    last.display().to_string()
}

/// The pointer by which a binary knows an instance.
#[repr(transparent)]
#[derive(Clone, Copy, Debug)]
pub struct Component(pub *mut c_void);

// SAFETY: neither version of FMI ties a component to a thread; they only forbid concurrent calls, which `&mut` at every
// call and the missing `Sync` rule out.
unsafe impl Send for Component {}

/// A function without arguments that returns a text, such as `fmi2GetVersion`.
pub type Text = unsafe extern "C" fn() -> *const c_char;
/// A function of nothing but the component.
pub type Plain = unsafe extern "C" fn(Component) -> c_int;

/// The functions of a binary by their names.
pub struct Symbols<'a> {
    pub library: &'a Loaded,
    pub version: Version,
}

impl Symbols<'_> {
    /// Looks for a function that the binary may lack. The name is without its prefix, and `F` the function type that the
    /// standard gives to it.
    pub fn find<F: Copy>(&self, name: &str) -> Function<F> {
        // Kept for ever, as the library is.
        let name = String::leak(format!("{}{name}", self.version.prefix()));
        // SAFETY: the caller names the type of the standard.
        let symbol = unsafe { self.library.get::<F>(name.as_bytes()) };
        let code = symbol.ok().map(|symbol| *symbol);
        Function { name, code }
    }

    /// The same of a function without which the FMU cannot be used.
    pub fn need<F: Copy>(&self, name: &str) -> Result<Function<F>, LibraryError> {
        let function = self.find(name);
        match function.code {
            Some(_) => Ok(function),
            None => Err(LibraryError::Function(function.name)),
        }
    }

    /// The same of a function that only some FMUs must have.
    pub fn need_if<F: Copy>(&self, is_needed: bool, name: &str) -> Result<Function<F>, LibraryError> {
        if is_needed { self.need(name) } else { Ok(self.find(name)) }
    }

    /// Looks for the functions that read and write variables of a type.
    pub fn access<G: Copy, S: Copy>(&self, kind: &str) -> Access<G, S> {
        Access { get: self.find(&format!("Get{kind}")), set: self.find(&format!("Set{kind}")) }
    }

    /// The same where the FMU cannot be used without them.
    pub fn needed_access<G: Copy, S: Copy>(&self, kind: &str) -> Result<Access<G, S>, LibraryError> {
        Ok(Access { get: self.need(&format!("Get{kind}"))?, set: self.need(&format!("Set{kind}"))? })
    }
}

/// The functions that read and write variables of one type.
#[derive(Clone, Copy, Debug)]
pub struct Access<G, S> {
    pub get: Function<G>,
    pub set: Function<S>,
}

/// A function of a binary, which may lack it.
#[derive(Clone, Copy, Debug)]
pub struct Function<F> {
    pub name: &'static str,
    code: Option<F>,
}

impl<F: Copy> Function<F> {
    pub fn is_there(&self) -> bool {
        self.code.is_some()
    }

    /// The function, or why it cannot be called.
    #[inline]
    pub fn get(self) -> Called<F> {
        self.code.ok_or_else(|| Call::missing(self.name))
    }
}
