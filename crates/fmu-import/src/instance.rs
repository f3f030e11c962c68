//! One simulation of an FMU.

use std::ffi::{CString, c_char, c_int};
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::call::{Call, Status, Warnings};
use crate::floating_point::{Mode, within};
use crate::library::{Component, Functions, Library};
use crate::logger::Log;
use crate::value::{Content, Handle, Value};

/// One instance. It may move between threads, but only one at a time may use it.
#[derive(Debug)]
pub struct Instance {
    /// Unlike that of every other instance of this process: a state says with it whose it is.
    pub(crate) number: u64,
    library: Arc<Library>,
    /// The library's, close at hand.
    pub(crate) functions: Functions,
    pub(crate) component: Component,
    pub(crate) log: Log,
    warned: Warned,
    /// The FMU's own mode, which its next call finds again.
    pub(crate) mode: Mode,
    pub(crate) dead: bool,
}

/// Calls that returned `fmi2Warning`.
#[derive(Debug, Default)]
struct Warned {
    /// How many of them logged no warning.
    silent: u64,
    /// How many warnings had been logged at the last of them.
    logged: u64,
    /// The first one: its function and the FMU's message.
    first: Option<String>,
}

// SAFETY: FMI 2.0 ties an instance to no thread; it only forbids concurrent calls, which `&mut self`
// and the missing `Sync` rule out.
unsafe impl Send for Instance {}

impl Instance {
    /// Creates an instance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn new(library: &Arc<Library>, name: &str) -> Result<Self, Call> {
        let log = Log::open();
        let [name, guid, resources] =
            [name, library.guid.as_str(), library.resources.as_str()].map(c_string);
        const CO_SIMULATION: c_int = 1;
        let mut mode = library.mode;
        // SAFETY: the strings live through the call, and the callbacks for ever.
        let component = within(&mut mode, || unsafe {
            (library.functions.instantiate)(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ptr(),
                log.callbacks(),
                0,
                0,
            )
        });
        if component.is_null() {
            return Err(Call {
                function: "fmi2Instantiate",
                status: Status::Error,
                message: log.last().or_else(|| Some(library.refusal())),
                ended: None,
            });
        }
        static CREATED: AtomicU64 = AtomicU64::new(0);
        let mut instance = Self {
            number: CREATED.fetch_add(1, Ordering::Relaxed),
            library: Arc::clone(library),
            functions: library.functions,
            component,
            log,
            warned: Warned::default(),
            mode,
            dead: false,
        };
        instance.log_troubles();
        Ok(instance)
    }

    /// Asks the FMU for its errors and warnings, where it has categories for them.
    fn log_troubles(&mut self) {
        let library = Arc::clone(&self.library);
        let names: Vec<CString> = library
            .categories
            .iter()
            .map(|name| c_string(name))
            .collect();
        if let (Some(function), false) = (self.functions.set_debug_logging, names.is_empty()) {
            let pointers: Vec<*const c_char> = names.iter().map(|name| name.as_ptr()).collect();
            // SAFETY: the array holds as many valid strings as stated. What it returns does not
            // matter: without it there are fewer messages.
            within(&mut self.mode, || unsafe {
                function(self.component, 1, pointers.len(), pointers.as_ptr())
            });
        }
    }

    /// Whether the FMU is unusable after `fmi2Fatal`: nothing may be called any more.
    pub fn is_dead(&self) -> bool {
        self.dead
    }

    #[inline]
    pub(crate) fn check(&mut self, function: &'static str, status: c_int) -> Result<(), Call> {
        match status {
            0 => Ok(()),
            1 => {
                self.warned(function);
                Ok(())
            }
            status => Err(self.failed(function, Status::from(status))),
        }
    }

    #[cold]
    fn warned(&mut self, function: &str) {
        let logged = self.log.warnings().count;
        self.warned.silent += u64::from(logged == self.warned.logged);
        self.warned.logged = logged;
        if self.warned.first.is_none() {
            self.warned.first = Some(match self.log.last() {
                Some(message) => format!("{function}: {message}"),
                None => function.to_owned(),
            });
        }
    }

    /// The warnings since the instance was created or reset, or since they were
    /// [forgotten](Self::forget_warnings).
    pub fn warnings(&self) -> Warnings {
        let logged = self.log.warnings();
        Warnings {
            count: logged.count + self.warned.silent,
            first: self.warned.first.clone().or(logged.first),
        }
    }

    /// Counts warnings from zero again.
    pub fn forget_warnings(&mut self) {
        self.log.forget_warnings();
        self.warned = Warned::default();
    }

    /// Forgets what the FMU has said so far.
    pub(crate) fn forget_messages(&mut self) {
        self.log.clear();
        self.warned = Warned::default();
    }

    /// How many messages the FMU has passed to the logger with an environment that is not its own.
    pub fn strays(&self) -> u64 {
        self.log.strays()
    }

    #[cold]
    fn failed(&mut self, function: &'static str, status: Status) -> Call {
        self.dead |= status == Status::Fatal;
        Call {
            function,
            status,
            message: self.log.last(),
            ended: None,
        }
    }

    /// A call of the optional function `function`, which some FMUs leave out.
    pub(crate) fn missing(function: &'static str) -> Call {
        Call {
            function,
            status: Status::Error,
            message: Some("the FMU does not export the function".to_owned()),
            ended: None,
        }
    }

    /// Announces the experiment: start and stop time in s, and the relative tolerance.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn setup_experiment(
        &mut self,
        start: f64,
        stop: f64,
        tolerance: Option<f64>,
    ) -> Result<(), Call> {
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe {
            (self.functions.setup_experiment)(
                self.component,
                c_int::from(tolerance.is_some()),
                tolerance.unwrap_or(0.0),
                start,
                1,
                stop,
            )
        });
        self.check("fmi2SetupExperiment", status)
    }

    /// Enters and leaves initialisation mode.
    ///
    /// # Errors
    /// When the FMU cannot be initialised.
    pub fn initialise(&mut self) -> Result<(), Call> {
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe {
            (self.functions.enter_initialization_mode)(self.component)
        });
        self.check("fmi2EnterInitializationMode", status)?;
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe {
            (self.functions.exit_initialization_mode)(self.component)
        });
        self.check("fmi2ExitInitializationMode", status)
    }

    /// Reads real variables.
    ///
    /// # Errors
    /// When the FMU refuses.
    #[inline(never)]
    pub fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Result<(), Call> {
        let count = references.len().min(into.len());
        // SAFETY: both arrays hold `count` elements.
        let status = within(&mut self.mode, || unsafe {
            let get = self.functions.get_real;
            get(
                self.component,
                references.as_ptr(),
                count,
                into.as_mut_ptr(),
            )
        });
        self.check("fmi2GetReal", status)
    }

    /// Reads an integer or an item of an enumeration.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn integer(&mut self, reference: u32) -> Result<i32, Call> {
        let mut value: c_int = 0;
        // SAFETY: both pointers are to one element.
        let status = within(&mut self.mode, || unsafe {
            let get = self.functions.get_integer;
            get(self.component, &raw const reference, 1, &raw mut value)
        });
        self.check("fmi2GetInteger", status)?;
        Ok(value)
    }

    /// Reads a Boolean.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn boolean(&mut self, reference: u32) -> Result<bool, Call> {
        let mut value: c_int = 0;
        // SAFETY: both pointers are to one element.
        let status = within(&mut self.mode, || unsafe {
            let get = self.functions.get_boolean;
            get(self.component, &raw const reference, 1, &raw mut value)
        });
        self.check("fmi2GetBoolean", status)?;
        Ok(value != 0)
    }

    /// Reads a text.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn string(&mut self, reference: u32) -> Result<String, Call> {
        let get = self.functions.get_string;
        let get = get.ok_or_else(|| Self::missing("fmi2GetString"))?;
        let mut value: *const c_char = ptr::null();
        // SAFETY: both pointers are to one element.
        let status = within(&mut self.mode, || unsafe {
            get(self.component, &raw const reference, 1, &raw mut value)
        });
        self.check("fmi2GetString", status)?;
        if value.is_null() {
            return Ok(String::new());
        }
        // SAFETY: FMI 2.0 returns a zero-terminated string that is valid until the next call.
        let text = unsafe { std::ffi::CStr::from_ptr(value) };
        Ok(text.to_string_lossy().into_owned())
    }

    /// Reads a variable of any kind.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn value(&mut self, handle: Handle) -> Result<Value, Call> {
        let reference = handle.reference;
        Ok(match handle.content {
            Content::Real => {
                let mut value = [0.0];
                self.reals(&[reference], &mut value)?;
                Value::Real(value[0])
            }
            Content::Integer => Value::Integer(self.integer(reference)?),
            Content::Boolean => Value::Boolean(self.boolean(reference)?),
            Content::Text => Value::String(self.string(reference)?),
        })
    }

    /// Lets an input vary linearly over the next step.
    ///
    /// # Errors
    /// When the FMU refuses, or cannot.
    pub fn set_slope(&mut self, reference: u32, slope: f64) -> Result<(), Call> {
        const FUNCTION: &str = "fmi2SetRealInputDerivatives";
        let set = self.functions.set_slopes;
        let set = set.ok_or_else(|| Self::missing(FUNCTION))?;
        // SAFETY: all three pointers are to one element.
        let status = within(&mut self.mode, || unsafe {
            set(
                self.component,
                &raw const reference,
                1,
                &1,
                &raw const slope,
            )
        });
        self.check(FUNCTION, status)
    }

    /// Writes one variable.
    ///
    /// # Errors
    /// When the FMU refuses.
    pub fn set(&mut self, reference: u32, value: &Value) -> Result<(), Call> {
        let functions = self.functions;
        let (component, reference) = (self.component, &raw const reference);
        match value {
            Value::Real(value) => {
                // SAFETY: both pointers are to one element.
                let status = within(&mut self.mode, || unsafe {
                    (functions.set_real)(component, reference, 1, value)
                });
                self.check("fmi2SetReal", status)
            }
            Value::Integer(value) => {
                // SAFETY: both pointers are to one element.
                let status = within(&mut self.mode, || unsafe {
                    (functions.set_integer)(component, reference, 1, value)
                });
                self.check("fmi2SetInteger", status)
            }
            Value::Boolean(value) => {
                let value = c_int::from(*value);
                // SAFETY: both pointers are to one element.
                let status = within(&mut self.mode, || unsafe {
                    (functions.set_boolean)(component, reference, 1, &value)
                });
                self.check("fmi2SetBoolean", status)
            }
            Value::String(value) => {
                let set = functions.set_string;
                let set = set.ok_or_else(|| Self::missing("fmi2SetString"))?;
                let text = c_string(value);
                // SAFETY: both pointers are to one element, the text lives through the call.
                let status = within(&mut self.mode, || unsafe {
                    set(component, reference, 1, &text.as_ptr())
                });
                self.check("fmi2SetString", status)
            }
        }
    }

    /// Takes the instance back to where it was after its creation.
    ///
    /// # Errors
    /// When the FMU cannot; then a new instance is needed.
    pub fn reset(&mut self) -> Result<(), Call> {
        let reset = self.functions.reset;
        let reset = reset.ok_or_else(|| Self::missing("fmi2Reset"))?;
        self.forget_messages();
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe { reset(self.component) });
        // As after its creation.
        self.mode = self.library.mode;
        self.check("fmi2Reset", status)
    }

    /// Ends a simulation that was initialised.
    ///
    /// # Errors
    /// When the FMU refuses. What was computed before holds all the same.
    pub fn terminate(&mut self) -> Result<(), Call> {
        let (Some(terminate), false) = (self.functions.terminate, self.dead) else {
            return Ok(());
        };
        // SAFETY: the component is alive.
        let status = within(&mut self.mode, || unsafe { terminate(self.component) });
        self.check("fmi2Terminate", status)
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if !self.dead {
            // SAFETY: the component is alive and never used again.
            within(&mut self.mode, || unsafe {
                (self.functions.free_instance)(self.component);
            });
        }
    }
}

/// A C string. A zero byte cannot be told to C: the text ends before it.
fn c_string(text: &str) -> CString {
    let end = text.find('\0').unwrap_or(text.len());
    CString::new(&text[..end]).unwrap_or_default()
}
