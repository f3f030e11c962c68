//! The binary of an FMU: its functions, loaded once and never unloaded.
//!
//! Unloading is left out on purpose: thread-local destructors and threads of an FMU that outlive
//! its code crash the process, and a process loads few FMUs.

use std::{collections::HashMap, ffi::CStr, path::Path, sync::Arc};

use libloading::Library as Loaded;
use tempfile::TempDir;

pub use crate::symbols::LibraryError;
use crate::{
    archive,
    call::Called,
    caller::Caller,
    component::CommonFunctions,
    description::{Causality, Description, ExchangeSizes, Interface, Kind, Variability, Variable},
    exchange::{self, Clocks, Exchange},
    floating_point::{Mode, within},
    fmi2,
    fmi3::{self, Element},
    needed,
    simulation::{Birth, Simulation},
    symbols::{Function, Symbols, Text},
    validity,
    value::Handle,
    version::Version,
};

/// The functions of a binary, by its version of FMI.
#[derive(Debug)]
enum Functions {
    Two(Arc<fmi2::Functions>),
    Three(Arc<fmi3::Functions>, Arc<[Element]>),
}

impl Functions {
    fn find(symbols: &Symbols, description: &Description) -> Result<Self, LibraryError> {
        let interface = description.interface;
        Ok(match symbols.version {
            Version::Two => Self::Two(Arc::new(fmi2::Functions::find(symbols, interface)?)),
            Version::Three => {
                Self::Three(Arc::new(fmi3::Functions::find(symbols, interface)?), Element::all(description))
            }
        })
    }
}

/// A loaded binary.
#[derive(Debug)]
pub struct Library {
    functions: Functions,
    common: CommonFunctions,
    /// Those of Model Exchange or of event mode, and what the description says of it.
    exchange: Option<(exchange::Functions, ExchangeSizes)>,
    clocks: Clocks,
    /// Whether all steps of a simulation must have one size.
    pub(crate) one_size: bool,
    birth: Birth,
    /// The mode in which the binary's initialisers left the processor.
    pub(crate) mode: Mode,
    /// The inputs, and whether each may change between events.
    inputs: Arc<HashMap<Handle, bool>>,
    once: bool,
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
        let (version, interface) = (description.standard, description.interface);
        let birth = Birth {
            guid: description.guid.clone(),
            resources: resources(folder, version)?,
            categories: heard_categories(description),
            interface,
            binary: archive::binary(folder, &description.model_identifier, version),
        };
        let mut mode = Mode::USUAL;
        let library = within(&mut mode, || loaded(&birth.binary))?;
        let symbols = Symbols { library, version };
        Ok(Self {
            functions: Functions::find(&symbols, description)?,
            common: CommonFunctions::find(&symbols)?,
            exchange: match interface {
                Interface::CoSimulation if !description.capabilities.has_event_mode => None,
                Interface::CoSimulation => exchange::Functions::find(&symbols, interface).ok(),
                Interface::ModelExchange => Some(exchange::Functions::find(&symbols, interface)?),
            }
            .map(|functions| (functions, description.exchange)),
            clocks: Clocks::find(&symbols, description),
            one_size: !description.capabilities.can_handle_variable_communication_step_size,
            once: description.capabilities.can_be_instantiated_only_once_per_process,
            birth,
            mode,
            inputs: Arc::new(inputs(description)),
            _unpacked: unpacked,
        })
    }

    /// Whether a process can hold one instance of it only, as the description says.
    pub fn is_for_one_instance(&self) -> bool {
        self.once
    }

    /// Creates a component.
    pub(crate) fn instantiate(&self, name: &str) -> Called<Box<dyn Simulation>> {
        let is_exchange = self.birth.interface == Interface::ModelExchange;
        let handles = is_exchange || self.clocks.are_there();
        let mut exchange = self.exchange.filter(|_| handles);
        let mut model = self.component(name, exchange.is_some());
        // The FMU may want its events handled. One that refuses for another reason may do so but once, as for want of a
        // licence: then it must not run in another way.
        if let (Err(call), None, Some(_)) = (&model, exchange, self.exchange)
            && names_events(&call.to_string())
        {
            (model, exchange) = (self.component(name, true), self.exchange);
        }
        let mut model = model?;
        model.hear(&self.birth.categories);
        Ok(match exchange {
            None => model,
            Some((functions, declared)) => {
                let (inputs, clocks) = (Arc::clone(&self.inputs), self.clocks.clone());
                Box::new(Exchange::new(model, functions, declared, inputs, clocks))
            }
        })
    }

    /// A component alone; `events` says whether events are handled here.
    fn component(&self, name: &str, events: bool) -> Called<Box<dyn Simulation>> {
        let (birth, common, caller) = (&self.birth, self.common, Caller::new(self.mode));
        Ok(match &self.functions {
            Functions::Two(functions) => {
                Box::new(fmi2::Model::new(Arc::clone(functions), common, birth, caller, name)?)
            }
            Functions::Three(functions, elements) => Box::new(fmi3::Model::new(
                Arc::clone(functions),
                common,
                Arc::clone(elements),
                birth,
                events,
                caller,
                name,
            )?),
        })
    }

    /// Lets a component that was reset tell its model's limits again: by the standard it is as it was created, without
    /// logging. Of errors it need not log more than it returns.
    pub(crate) fn hear_again(&self, simulation: &mut dyn Simulation) {
        let categories = &self.birth.categories;
        if categories.iter().any(|name| name == validity::CATEGORY) {
            simulation.hear(categories);
        }
    }

    /// The version of FMI that the binary was compiled with; usually that of the description.
    pub fn version(&self) -> Option<String> {
        self.text(self.common.get_version)
    }

    /// The same of a binary of FMI 2.0 where it is another one.
    pub fn odd_version(&self) -> Option<String> {
        match &self.functions {
            Functions::Two(_) => self.version().filter(|text| text != Version::Two.number()),
            // FMI 3.0.1 and 3.0.2 call themselves so, and changed no function.
            Functions::Three(..) => None,
        }
    }

    /// The types that a binary of FMI 2.0 was compiled with; usually `default`.
    pub fn types_platform(&self) -> Option<String> {
        match &self.functions {
            Functions::Two(functions) => self.text(functions.get_types_platform),
            Functions::Three(..) => None,
        }
    }

    /// The text that a function without arguments returns; none where the binary has no such function.
    fn text(&self, function: Function<Text>) -> Option<String> {
        let function = function.get().ok()?;
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

/// A path as part of a URI, in which `also` stays as it is, too.
pub fn percent_encoded(path: &str, also: &str) -> String {
    path.bytes()
        .map(|byte| {
            let c = char::from(byte);
            if c.is_ascii_alphanumeric() || "/-._~".contains(c) || also.contains(c) {
                c.to_string()
            } else {
                format!("%{byte:02X}")
            }
        })
        .collect()
}

/// The log categories whose messages are wanted: those about faults, and about the limits of the model.
fn heard_categories(description: &Description) -> Vec<String> {
    const OF_FAULTS: [&str; 4] = ["error", "fatal", "warning", "discard"];
    let is_heard = |name: &&String| {
        let lower = name.to_lowercase();
        *name == validity::CATEGORY || OF_FAULTS.iter().any(|word| lower.contains(word))
    };
    description.log_categories.iter().filter(is_heard).cloned().collect()
}

/// The folder of the resources as an FMU of this version is told it.
fn resources(folder: &Path, version: Version) -> Result<String, LibraryError> {
    let resources = folder.join("resources");
    match version {
        Version::Two => uri(&resources),
        // An absolute path that ends with a separator.
        Version::Three => Ok(absolute(&resources)? + std::path::MAIN_SEPARATOR_STR),
    }
}

/// A folder as FMI 2.0 passes it: `file:///...`, percent-encoded.
fn uri(folder: &Path) -> Result<String, LibraryError> {
    let text = absolute(folder)?.replace('\\', "/");
    let scheme = if text.starts_with('/') { "file://" } else { "file:///" };
    Ok(format!("{scheme}{}", percent_encoded(&text, ":")))
}

fn absolute(folder: &Path) -> Result<String, LibraryError> {
    std::path::absolute(folder)
        .ok()
        .and_then(|path| path.to_str().map(str::to_owned))
        .ok_or_else(|| LibraryError::Folder(folder.to_owned()))
}

/// Loads a binary, for ever: see above.
fn loaded(path: &Path) -> Result<&'static Loaded, LibraryError> {
    // The loader searches a bare relative path elsewhere.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let library = open(&path).map_err(|error| LibraryError::Load { reason: reason(&path, &error), path })?;
    Ok(Box::leak(Box::new(library)))
}

/// Loads a binary with all the functions that it calls, which each fork would have to look up again; where some are not there,
/// it may never call them, and is loaded without.
fn open(path: &Path) -> Result<Loaded, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix;
        // SAFETY: running the initialisers of the binary is what the user asked for; the caller decides in which process.
        // Where the loader refuses, it has run none.
        let library = unsafe { unix::Library::open(Some(path), unix::RTLD_NOW | unix::RTLD_LOCAL) };
        if let Ok(library) = library {
            return Ok(library.into());
        }
    }
    // SAFETY: as above.
    unsafe { Loaded::new(path) }
}

/// The inputs, and whether each may change between events.
fn inputs(description: &Description) -> HashMap<Handle, bool> {
    let is_continuous = |variable: &Variable| {
        variable.variability == Variability::Continuous && matches!(variable.kind, Kind::Real { .. })
    };
    description.with(Causality::Input).map(|variable| (variable.handle(), is_continuous(variable))).collect()
}

/// Why the loader refused: all libraries that are missing, of which it names the first only, or else its own words.
fn reason(path: &Path, error: &libloading::Error) -> String {
    match needed::missing(path) {
        Some(missing) => missing,
        // So does the loader say that nothing in a folder may be run.
        None if plain(error).contains("failed to map segment") => format!(
            "{}: no program may run from this folder (mounted noexec?); set TMPDIR to another one",
            path.parent().unwrap_or(path).display()
        ),
        // It says the path once more.
        None => plain(error).replace(&format!("{}: ", path.display()), ""),
    }
}

/// The loader's own words, on one line.
fn plain(error: &libloading::Error) -> String {
    let text = std::error::Error::source(error)
        .map_or_else(|| error.to_string(), ToString::to_string)
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    // FMUs of pythonfmu and the like expect to be loaded by a Python.
    if text.contains("undefined symbol: _Py") || text.contains("undefined symbol: Py") {
        return format!("{text}; the FMU runs Python: set LD_PRELOAD to the path of libpython3.so");
    }
    text
}

/// Whether a refusal speaks of events.
fn names_events(refusal: &str) -> bool {
    refusal.to_lowercase().split(|c: char| !c.is_alphanumeric()).any(|word| word.starts_with("event"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_that_prevents_speaks_of_no_event() {
        assert!(names_events("the argument eventModeUsed must be true") && names_events("it needs Event Mode"));
        assert!(!names_events("instantiation prevented: no licence"));
    }

    #[test]
    fn folders_become_uris() {
        let uri = uri(Path::new("/tmp/with space/ä")).unwrap();
        assert_eq!(uri, "file:///tmp/with%20space/%C3%A4");
    }
}
