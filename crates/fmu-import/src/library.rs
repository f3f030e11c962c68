//! The binary of an FMU: its functions, loaded once and never unloaded.
//!
//! Unloading is left out on purpose: thread-local destructors and threads of an FMU that outlive
//! its code crash the process, and a process loads few FMUs.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::{Path, PathBuf};

use libloading::Library as Loaded;
use thiserror::Error;

use crate::archive;
use crate::description::Description;
use crate::floating_point::{Mode, within};
use crate::needed;

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

pub(crate) type Component = *mut c_void;
type Get<T> = unsafe extern "C" fn(Component, *const u32, usize, *mut T) -> c_int;
type Set<T> = unsafe extern "C" fn(Component, *const u32, usize, *const T) -> c_int;
/// `fmi2GetFMUstate` and `fmi2FreeFMUstate`.
type TakeState = unsafe extern "C" fn(Component, *mut *mut c_void) -> c_int;
type PutState = unsafe extern "C" fn(Component, *mut c_void) -> c_int;
/// `fmi2SetRealInputDerivatives`.
type SetSlopes =
    unsafe extern "C" fn(Component, *const u32, usize, *const c_int, *const f64) -> c_int;
type Plain = unsafe extern "C" fn(Component) -> c_int;
/// `fmi2GetVersion` and `fmi2GetTypesPlatform`.
type Text = unsafe extern "C" fn() -> *const c_char;

/// The struct `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct Callbacks {
    pub(crate) logger: unsafe extern "C" fn(),
    pub(crate) allocate_memory: unsafe extern "C" fn(usize, usize) -> *mut c_void,
    pub(crate) free_memory: unsafe extern "C" fn(*mut c_void),
    pub(crate) step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    pub(crate) environment: *const c_void,
}

/// The functions of FMI 2.0 for Co-Simulation that an importer calls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Functions {
    pub(crate) get_version: Option<Text>,
    pub(crate) get_types_platform: Option<Text>,
    pub(crate) instantiate: unsafe extern "C" fn(
        *const c_char,
        c_int,
        *const c_char,
        *const c_char,
        *const Callbacks,
        c_int,
        c_int,
    ) -> Component,
    pub(crate) free_instance: unsafe extern "C" fn(Component),
    pub(crate) set_debug_logging:
        Option<unsafe extern "C" fn(Component, c_int, usize, *const *const c_char) -> c_int>,
    pub(crate) setup_experiment:
        unsafe extern "C" fn(Component, c_int, f64, f64, c_int, f64) -> c_int,
    pub(crate) enter_initialization_mode: Plain,
    pub(crate) exit_initialization_mode: Plain,
    pub(crate) terminate: Option<Plain>,
    pub(crate) reset: Option<Plain>,
    /// To get, set and free a state, where the FMU can.
    pub(crate) states: Option<(TakeState, PutState, TakeState)>,
    pub(crate) get_real: Get<f64>,
    pub(crate) get_integer: Get<c_int>,
    pub(crate) get_boolean: Get<c_int>,
    pub(crate) get_string: Option<Get<*const c_char>>,
    pub(crate) set_real: Set<f64>,
    pub(crate) set_integer: Set<c_int>,
    pub(crate) set_boolean: Set<c_int>,
    pub(crate) set_string: Option<Set<*const c_char>>,
    /// To set the rates of inputs, where the FMU interpolates them.
    pub(crate) set_slopes: Option<SetSlopes>,
    pub(crate) do_step: unsafe extern "C" fn(Component, f64, f64, c_int) -> c_int,
    pub(crate) get_status: Option<unsafe extern "C" fn(Component, c_int, *mut c_int) -> c_int>,
    pub(crate) get_real_status: Option<unsafe extern "C" fn(Component, c_int, *mut f64) -> c_int>,
    pub(crate) get_boolean_status:
        Option<unsafe extern "C" fn(Component, c_int, *mut c_int) -> c_int>,
}

/// A loaded binary.
#[derive(Debug)]
pub struct Library {
    pub(crate) functions: Functions,
    pub(crate) guid: String,
    pub(crate) resources: String,
    pub(crate) categories: Vec<String>,
    /// The mode in which the binary's initialisers left the processor.
    pub(crate) mode: Mode,
    name: String,
    once: bool,
    binary: PathBuf,
}

impl Library {
    /// Loads the binary of an unpacked FMU.
    pub(crate) fn load(folder: &Path, description: &Description) -> Result<Self, LibraryError> {
        let resources = uri(&folder.join("resources"))?;
        let mut mode = Mode::USUAL;
        let binary = archive::binary(folder, &description.model_identifier);
        let mut functions = within(&mut mode, || functions(&binary))?;
        // Some FMUs export what they cannot do.
        if !description.capabilities.can_get_and_set_fmu_state {
            functions.states = None;
        }
        let categories = description
            .log_categories
            .iter()
            .filter(|name| {
                let name = name.to_lowercase();
                ["error", "fatal", "warning", "discard"]
                    .iter()
                    .any(|word| name.contains(word))
            })
            .cloned()
            .collect();
        Ok(Self {
            functions,
            once: description
                .capabilities
                .can_be_instantiated_only_once_per_process,
            guid: description.guid.clone(),
            resources,
            categories,
            mode,
            name: description.model_name.clone(),
            binary,
        })
    }

    /// Whether a process can hold one instance of it only, as the description says.
    pub fn is_for_one_instance(&self) -> bool {
        self.once
    }

    /// The likely cause where the FMU refuses an instance and does not say why.
    pub(crate) fn refusal(&self) -> String {
        let guid = &self.guid;
        // Exporters write the GUID into the binary, with braces or without.
        let bare = guid.trim_matches(['{', '}']);
        let cause = match std::fs::read(&self.binary) {
            Ok(binary) if !holds(&binary, bare.as_bytes()) => {
                "does not occur in the binary, so the two are probably not of one export"
            }
            _ => "may not be that of the binary, or resources may be missing",
        };
        format!(
            "the FMU refuses an instance without a message; the GUID of the description, {guid}, {cause}"
        )
    }

    /// The model's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The version of FMI that the binary was compiled with; usually `2.0`.
    pub fn version(&self) -> Option<String> {
        self.text(self.functions.get_version?)
    }

    /// The types that the binary was compiled with; usually `default`.
    pub fn types_platform(&self) -> Option<String> {
        self.text(self.functions.get_types_platform?)
    }

    /// The text that a function without arguments returns.
    fn text(&self, function: Text) -> Option<String> {
        let mut mode = self.mode;
        // SAFETY: FMI 2.0 lets these functions be called at any time.
        let text = within(&mut mode, || unsafe { function() });
        if text.is_null() {
            return None;
        }
        // SAFETY: FMI 2.0 returns a zero-terminated string that stays where it is.
        let text = unsafe { CStr::from_ptr(text) };
        Some(text.to_string_lossy().into_owned())
    }
}

/// Whether a text stands in a file.
fn holds(file: &[u8], text: &[u8]) -> bool {
    let Some(first) = text.first() else {
        return true;
    };
    let mut rest = file;
    while let Some(place) = rest.iter().position(|byte| byte == first) {
        if rest[place..].starts_with(text) {
            return true;
        }
        rest = &rest[place + 1..];
    }
    false
}

/// A folder as `file:///...`, percent-encoded.
fn uri(folder: &Path) -> Result<String, LibraryError> {
    let absolute = std::path::absolute(folder).map_err(|_| LibraryError::Folder(folder.into()))?;
    let text = absolute
        .to_str()
        .ok_or_else(|| LibraryError::Folder(absolute.clone()))?;
    let text = text.replace('\\', "/");
    let mut uri = String::from(if text.starts_with('/') {
        "file://"
    } else {
        "file:///"
    });
    for byte in text.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b':' | b'-' | b'.' | b'_' | b'~' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    Ok(uri)
}

fn functions(path: &Path) -> Result<Functions, LibraryError> {
    // The loader searches a bare relative path elsewhere.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    // SAFETY: running the initialisers of the binary is what the user asked for; the caller
    // decides in which process.
    let library = unsafe { Loaded::new(&path) }.map_err(|error| LibraryError::Load {
        reason: reason(&path, &error),
        path,
    })?;
    let functions = table(&library);
    // Never unloaded, see above.
    std::mem::forget(library);
    functions
}

/// The path of a binary within its FMU: where that was unpacked tells a reader nothing.
fn place_in_fmu(path: &Path) -> String {
    // binaries, the platform, the file.
    const BELOW: usize = 3;
    let parts: Vec<_> = path.components().collect();
    let last: PathBuf = parts[parts.len().saturating_sub(BELOW)..].iter().collect();
    last.display().to_string()
}

/// Why the loader refused: all libraries that are missing, of which it names the first only, or else its own words.
fn reason(path: &Path, error: &libloading::Error) -> String {
    match &needed::missing(path)[..] {
        // It says the path once more.
        [] => plain(error).replace(&format!("{}: ", path.display()), ""),
        [one] => format!("it needs {one}, which is not there: install it"),
        some => format!(
            "it needs {}, which are not there: install them",
            some.join(", ")
        ),
    }
}

/// The loader's own words, on one line.
fn plain(error: &libloading::Error) -> String {
    let source = std::error::Error::source(error);
    let text = source.map_or_else(|| error.to_string(), ToString::to_string);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    // FMUs of pythonfmu and the like expect to be loaded by a Python.
    if text.contains("undefined symbol: _Py") || text.contains("undefined symbol: Py") {
        return format!("{text}; the FMU runs Python: set LD_PRELOAD to the path of libpython3.so");
    }
    text
}

/// A symbol as a function pointer of the type that the field asks for.
fn symbol<T: Copy>(library: &Loaded, name: &'static str) -> Result<T, LibraryError> {
    // SAFETY: `T` is the function type that FMI 2.0 gives to this name.
    let symbol = unsafe { library.get::<T>(name.as_bytes()) };
    symbol
        .map(|symbol| *symbol)
        .map_err(|_| LibraryError::Function(name))
}

fn table(library: &Loaded) -> Result<Functions, LibraryError> {
    let states = || {
        Some((
            symbol(library, "fmi2GetFMUstate").ok()?,
            symbol(library, "fmi2SetFMUstate").ok()?,
            symbol(library, "fmi2FreeFMUstate").ok()?,
        ))
    };
    Ok(Functions {
        get_version: symbol(library, "fmi2GetVersion").ok(),
        get_types_platform: symbol(library, "fmi2GetTypesPlatform").ok(),
        states: states(),
        instantiate: symbol(library, "fmi2Instantiate")?,
        free_instance: symbol(library, "fmi2FreeInstance")?,
        set_debug_logging: symbol(library, "fmi2SetDebugLogging").ok(),
        setup_experiment: symbol(library, "fmi2SetupExperiment")?,
        enter_initialization_mode: symbol(library, "fmi2EnterInitializationMode")?,
        exit_initialization_mode: symbol(library, "fmi2ExitInitializationMode")?,
        terminate: symbol(library, "fmi2Terminate").ok(),
        reset: symbol(library, "fmi2Reset").ok(),
        get_real: symbol(library, "fmi2GetReal")?,
        get_integer: symbol(library, "fmi2GetInteger")?,
        get_boolean: symbol(library, "fmi2GetBoolean")?,
        get_string: symbol(library, "fmi2GetString").ok(),
        set_real: symbol(library, "fmi2SetReal")?,
        set_integer: symbol(library, "fmi2SetInteger")?,
        set_boolean: symbol(library, "fmi2SetBoolean")?,
        set_string: symbol(library, "fmi2SetString").ok(),
        set_slopes: symbol(library, "fmi2SetRealInputDerivatives").ok(),
        do_step: symbol(library, "fmi2DoStep")?,
        get_status: symbol(library, "fmi2GetStatus").ok(),
        get_real_status: symbol(library, "fmi2GetRealStatus").ok(),
        get_boolean_status: symbol(library, "fmi2GetBooleanStatus").ok(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_become_uris() {
        let uri = uri(Path::new("/tmp/with space/ä")).unwrap();
        assert_eq!(uri, "file:///tmp/with%20space/%C3%A4");
    }
}
