//! A component of a binary, and the functions whose signature is the same in both versions of FMI.

use std::ffi::{CString, c_char, c_int};
use std::ptr;

use crate::call::Call;
use crate::caller::Caller;
use crate::symbols::{Component, Function, LibraryError, Plain, Saved, Symbols, Text};
use crate::version::Version;

/// The functions to get and to free a state.
type TakeState = unsafe extern "C" fn(Component, *mut Saved) -> c_int;
type PutState = unsafe extern "C" fn(Component, Saved) -> c_int;

/// The functions that have the same signature in every version.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Common {
    pub(crate) get_version: Function<Text>,
    free_instance: Function<unsafe extern "C" fn(Component)>,
    exit_initialization_mode: Function<Plain>,
    terminate: Function<Plain>,
    reset: Function<Plain>,
    get_state: Function<TakeState>,
    set_state: Function<PutState>,
    free_state: Function<TakeState>,
    /// Whether it says that it can save states, and has the functions: some FMUs export what they cannot do.
    saves: bool,
}

impl Common {
    /// Finds them in a loaded binary. `states` says whether the FMU can save states.
    pub(crate) fn find(symbols: &Symbols<'_>, states: bool) -> Result<Self, LibraryError> {
        let state = match symbols.version {
            Version::Two => "FMUstate",
            Version::Three => "FMUState",
        };
        let get_state = symbols.find(&format!("Get{state}"));
        let set_state = symbols.find(&format!("Set{state}"));
        let free_state = symbols.find(&format!("Free{state}"));
        Ok(Self {
            get_version: symbols.find("GetVersion"),
            free_instance: symbols.need("FreeInstance")?,
            exit_initialization_mode: symbols.need("ExitInitializationMode")?,
            terminate: symbols.find("Terminate"),
            reset: symbols.find("Reset"),
            saves: states && get_state.is_there() && set_state.is_there() && free_state.is_there(),
            get_state,
            set_state,
            free_state,
        })
    }
}

/// A component, called by the functions that every version has.
#[derive(Debug)]
pub(crate) struct Base {
    pub(crate) component: Component,
    pub(crate) common: Common,
}

impl Component {
    /// Calls a function of nothing but the component.
    pub(crate) fn plain(self, caller: &mut Caller, function: Function<Plain>) -> Result<(), Call> {
        let code = function.get()?;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { code(self) });
        caller.check(function.name, status)
    }
}

impl Base {
    pub(crate) fn exit_initialization_mode(&self, caller: &mut Caller) -> Result<(), Call> {
        self.component
            .plain(caller, self.common.exit_initialization_mode)
    }

    pub(crate) fn reset(&self, caller: &mut Caller) -> Result<(), Call> {
        self.component.plain(caller, self.common.reset)
    }

    /// Ends the simulation; nothing is done where the FMU has no function for that.
    pub(crate) fn terminate(&self, caller: &mut Caller) -> Result<(), Call> {
        match self.common.terminate {
            terminate if terminate.is_there() => self.component.plain(caller, terminate),
            _ => Ok(()),
        }
    }

    pub(crate) fn save(&self, caller: &mut Caller) -> Option<Saved> {
        let function = self.common.get_state;
        let get = function.get().ok().filter(|_| self.common.saves)?;
        let mut state = Saved(ptr::null_mut());
        // SAFETY: the component is alive, and the state is a valid place to write to.
        let status = caller.call(|| unsafe { get(self.component, &raw mut state) });
        caller.check(function.name, status).ok()?;
        Some(state)
    }

    pub(crate) fn restore(&self, caller: &mut Caller, state: Saved) -> Result<(), Call> {
        let set = self.common.set_state.get()?;
        // SAFETY: the component is alive, and the state is one of its own.
        let status = caller.call(|| unsafe { set(self.component, state) });
        caller.check(self.common.set_state.name, status)
    }

    pub(crate) fn forget(&self, caller: &mut Caller, mut state: Saved) -> Result<(), Call> {
        let free = self.common.free_state.get()?;
        // SAFETY: the component is alive, and the state is one of its own, used no more.
        let status = caller.call(|| unsafe { free(self.component, &raw mut state) });
        caller.check(self.common.free_state.name, status)
    }

    pub(crate) fn free(&self, caller: &mut Caller) {
        if let Ok(free) = self.common.free_instance.get() {
            // SAFETY: the component is alive and never used again.
            caller.call(|| unsafe { free(self.component) });
        }
    }
}

/// A C string. A zero byte cannot be told to C: the text ends before it.
pub(crate) fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).expect("the text ends before its first zero byte")
}

/// C strings, and the pointers to them.
pub(crate) fn c_strings(texts: &[String]) -> (Vec<CString>, Vec<*const c_char>) {
    let texts: Vec<CString> = texts.iter().map(|text| c_string(text)).collect();
    let pointers = texts.iter().map(|text| text.as_ptr()).collect();
    (texts, pointers)
}
