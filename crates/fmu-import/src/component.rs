//! An instance in an FMU's shared library (`fmi2Component`, `fmi3Instance`), and the functions with one signature in both versions.

use std::ffi::{CString, c_char, c_int};

use crate::{
    call::Called,
    caller::Caller,
    symbols::{Component, Function, LibraryError, Plain, Symbols, Text},
};

/// The functions that have the same signature in every version.
#[derive(Clone, Copy, Debug)]
pub struct CommonFunctions {
    pub get_version: Function<Text>,
    free_instance: Function<unsafe extern "C" fn(Component)>,
    exit_initialization_mode: Function<Plain>,
    terminate: Function<Plain>,
    reset: Function<Plain>,
}

impl CommonFunctions {
    /// Finds them in a loaded binary.
    pub fn find(symbols: &Symbols) -> Result<Self, LibraryError> {
        Ok(Self {
            get_version: symbols.find("GetVersion"),
            free_instance: symbols.need("FreeInstance")?,
            exit_initialization_mode: symbols.need("ExitInitializationMode")?,
            terminate: symbols.find("Terminate"),
            reset: symbols.find("Reset"),
        })
    }
}

/// A component, with the functions that every version has and the importer's side of its calls.
#[derive(Debug)]
pub struct ComponentBase {
    pub component: Component,
    pub common: CommonFunctions,
    pub caller: Caller,
}

impl ComponentBase {
    /// Lets the FMU tell its errors and warnings, where it has categories for them. What it answers does not matter:
    /// without it there are fewer messages. `log` gets the number of categories and their names.
    pub fn hear<F: Copy>(
        &mut self,
        categories: &[String],
        function: Function<F>,
        log: impl FnOnce(F, Component, usize, *const *const c_char) -> c_int,
    ) {
        let Ok(code) = function.get() else { return };
        let texts: Vec<CString> = categories.iter().map(|text| c_string(text)).collect();
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        if !pointers.is_empty() {
            let of = self.component;
            self.caller.call(|| log(code, of, pointers.len(), pointers.as_ptr()));
        }
    }

    /// Calls a function of the component in its own floating-point mode, and judges what it returns.
    #[inline(always)]
    pub fn call<F: Copy>(&mut self, function: Function<F>, call: impl FnOnce(F, Component) -> c_int) -> Called {
        let (code, component) = (function.get()?, self.component);
        let status = self.caller.call(|| call(code, component));
        self.caller.check(function.name, status)
    }

    /// Calls a function of nothing but the component.
    pub fn plain(&mut self, function: Function<Plain>) -> Called {
        // SAFETY: the component is alive.
        self.call(function, |call, component| unsafe { call(component) })
    }

    pub fn exit_initialization_mode(&mut self) -> Called {
        self.plain(self.common.exit_initialization_mode)
    }

    pub fn reset(&mut self) -> Called {
        self.plain(self.common.reset)
    }

    /// Ends the simulation; nothing is done where the FMU has no function for that.
    pub fn terminate(&mut self) -> Called {
        match self.common.terminate {
            terminate if terminate.is_there() => self.plain(terminate),
            _ => Ok(()),
        }
    }

    pub fn free(&mut self) {
        if let Ok(free) = self.common.free_instance.get() {
            // SAFETY: the component is alive and never used again.
            self.caller.call(|| unsafe { free(self.component) });
        }
    }
}

/// A C string. A zero byte cannot be told to C: the text ends before it.
pub fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).expect("the text ends before its first zero byte")
}
