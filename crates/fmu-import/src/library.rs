//! The binary of an FMU: its functions, loaded once and never unloaded.
//!
//! Unloading is left out on purpose: thread-local destructors and threads of an FMU that outlive
//! its code crash the process, and a process loads few FMUs.

use std::collections::HashMap;
use std::ffi::CStr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use libloading::Library as Loaded;
use tempfile::TempDir;

use crate::archive;
use crate::call::Call;
use crate::caller::Caller;
use crate::description::{
    Causality, Description, ExchangeSizes, Interface, Kind, Variability, Variable,
};
use crate::exchange::Exchange;
use crate::floating_point::{Mode, within};
use crate::fmi2;
use crate::fmi3::{self, Element};
use crate::needed;
use crate::simulation::{Birth, Simulation};
pub use crate::symbols::LibraryError;
use crate::symbols::Text;
use crate::value::Handle;
use crate::version::Version;

/// The functions of a binary, by its version of FMI.
#[derive(Debug)]
enum Functions {
    Two(fmi2::Functions),
    TwoExchange(fmi2::Functions, fmi2::ExchangeFunctions, ExchangeSizes),
    Three(
        Box<fmi3::Functions>,
        Option<fmi3::ExchangeFunctions>,
        Arc<[Element]>,
    ),
}

/// A loaded binary.
#[derive(Debug)]
pub struct Library {
    functions: Functions,
    guid: String,
    resources: String,
    categories: Vec<String>,
    /// The mode in which the binary's initialisers left the processor.
    pub(crate) mode: Mode,
    interface: Interface,
    /// The inputs, and whether each may change between events.
    inputs: Arc<HashMap<Handle, bool>>,
    name: String,
    once: bool,
    binary: PathBuf,
    /// The folder with its resources, which it may read at any time; none where that is not removed.
    _unpacked: Option<Arc<TempDir>>,
}

impl Library {
    /// Loads the binary of an unpacked FMU, in a folder that is removed with the last user of `unpacked`.
    pub(crate) fn load(
        folder: &Path,
        unpacked: Option<Arc<TempDir>>,
        description: &Description,
    ) -> Result<Self, LibraryError> {
        let version = description.standard;
        let resources = folder.join("resources");
        let resources = match version {
            Version::Two => uri(&resources)?,
            Version::Three => path_of_resources(&resources)?,
        };
        let mut mode = Mode::USUAL;
        let binary = archive::binary(folder, &description.model_identifier, version);
        let states = description.capabilities.can_get_and_set_fmu_state;
        let functions = within(&mut mode, || functions(&binary, description))?;
        // Some FMUs export what they cannot do.
        let functions = if states {
            functions
        } else {
            functions.without_states()
        };
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
            interface: description.interface,
            inputs: Arc::new(inputs(description)),
            name: description.model_name.clone(),
            binary,
            _unpacked: unpacked,
        })
    }

    /// Whether a process can hold one instance of it only, as the description says.
    pub fn is_for_one_instance(&self) -> bool {
        self.once
    }

    /// Creates a component.
    pub(crate) fn instantiate(
        &self,
        caller: &mut Caller,
        name: &str,
    ) -> Result<Box<dyn Simulation>, Call> {
        let refusal = || self.refusal();
        let birth = Birth {
            guid: &self.guid,
            resources: &self.resources,
            categories: &self.categories,
            interface: self.interface,
            refusal: &refusal,
        };
        Ok(match &self.functions {
            Functions::Two(functions) => {
                Box::new(fmi2::Model::new(*functions, &birth, caller, name)?)
            }
            Functions::TwoExchange(functions, exchange, sizes) => {
                let model = fmi2::Model::new(*functions, &birth, caller, name)?;
                let equations = fmi2::ExchangeModel::new(model, *exchange, *sizes);
                Box::new(Exchange::new(equations, Arc::clone(&self.inputs)))
            }
            Functions::Three(functions, exchange, elements) => {
                let elements = Arc::clone(elements);
                let model = fmi3::Model::new(**functions, elements, &birth, caller, name)?;
                let Some(exchange) = exchange else {
                    return Ok(Box::new(model));
                };
                let equations = fmi3::ExchangeModel::new(model, *exchange);
                Box::new(Exchange::new(equations, Arc::clone(&self.inputs)))
            }
        })
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

    /// The version of FMI that the binary was compiled with; usually that of the description.
    pub fn version(&self) -> Option<String> {
        self.text(match &self.functions {
            Functions::Two(functions) | Functions::TwoExchange(functions, ..) => {
                functions.get_version?
            }
            Functions::Three(functions, ..) => functions.get_version?,
        })
    }

    /// The same of a binary of FMI 2.0 where it is another one.
    pub fn odd_version(&self) -> Option<String> {
        match &self.functions {
            Functions::Two(_) | Functions::TwoExchange(..) => self
                .version()
                .filter(|version| version != Version::Two.number()),
            // FMI 3.0.1 and 3.0.2 call themselves so, and changed no function.
            Functions::Three(..) => None,
        }
    }

    /// The types that a binary of FMI 2.0 was compiled with; usually `default`.
    pub fn types_platform(&self) -> Option<String> {
        match &self.functions {
            Functions::Two(functions) | Functions::TwoExchange(functions, ..) => {
                self.text(functions.get_types_platform?)
            }
            Functions::Three(..) => None,
        }
    }

    /// The text that a function without arguments returns.
    fn text(&self, function: Text) -> Option<String> {
        let mut mode = self.mode;
        // SAFETY: these functions may be called at any time.
        let text = within(&mut mode, || unsafe { function() });
        if text.is_null() {
            return None;
        }
        // SAFETY: they return a zero-terminated string that stays where it is.
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

/// The resources as FMI 3.0 passes them: an absolute path that ends with a separator.
fn path_of_resources(folder: &Path) -> Result<String, LibraryError> {
    let absolute = std::path::absolute(folder).map_err(|_| LibraryError::Folder(folder.into()))?;
    let text = absolute
        .to_str()
        .ok_or_else(|| LibraryError::Folder(absolute.clone()))?;
    Ok(format!("{text}{}", std::path::MAIN_SEPARATOR))
}

impl Functions {
    fn without_states(mut self) -> Self {
        match &mut self {
            Self::Two(functions) | Self::TwoExchange(functions, ..) => functions.states = None,
            Self::Three(functions, ..) => functions.states = None,
        }
        self
    }
}

fn functions(path: &Path, description: &Description) -> Result<Functions, LibraryError> {
    // The loader searches a bare relative path elsewhere.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    // SAFETY: running the initialisers of the binary is what the user asked for; the caller
    // decides in which process.
    let library = unsafe { Loaded::new(&path) }.map_err(|error| LibraryError::Load {
        reason: reason(&path, &error),
        path,
    })?;
    let functions = match description.standard {
        Version::Two => of_two(&library, description),
        Version::Three => of_three(&library, description),
    };
    // Never unloaded, see above.
    std::mem::forget(library);
    functions
}

fn of_two(library: &Loaded, description: &Description) -> Result<Functions, LibraryError> {
    let functions = fmi2::Functions::find(library, description.interface)?;
    Ok(match description.interface {
        Interface::CoSimulation => Functions::Two(functions),
        Interface::ModelExchange => Functions::TwoExchange(
            functions,
            fmi2::ExchangeFunctions::find(library)?,
            description.exchange,
        ),
    })
}

fn of_three(library: &Loaded, description: &Description) -> Result<Functions, LibraryError> {
    let functions = fmi3::Functions::find(library, description.interface)?;
    let exchange = match description.interface {
        Interface::CoSimulation => None,
        Interface::ModelExchange => Some(fmi3::ExchangeFunctions::find(library)?),
    };
    let elements = Element::all(description);
    Ok(Functions::Three(Box::new(functions), exchange, elements))
}

/// The inputs, and whether each may change between events.
fn inputs(description: &Description) -> HashMap<Handle, bool> {
    let is_continuous = |variable: &Variable| {
        variable.variability == Variability::Continuous
            && matches!(variable.kind, Kind::Real { .. })
    };
    let inputs = description.with(Causality::Input);
    inputs
        .map(|variable| (variable.handle(), is_continuous(variable)))
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_become_uris() {
        let uri = uri(Path::new("/tmp/with space/ä")).unwrap();
        assert_eq!(uri, "file:///tmp/with%20space/%C3%A4");
    }
}
