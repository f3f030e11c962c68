//! A component of FMI 3.0.
//!
//! One for Co-Simulation is created without event mode: the FMU handles its events within its steps, as FMI 3.0 demands of every FMU, and
//! inputs may be set between any two of them.

use std::collections::HashMap;
use std::ffi::{CString, c_char, c_void};
use std::ptr;
use std::sync::Arc;

use super::element::Element;
use super::functions::{Functions, Instantiates, LogMessage};
use crate::call::{Call, End, Status};
use crate::caller::Caller;
use crate::description::Storage;
use crate::logger::log_message;
use crate::simulation::{Birth, Component, Experiment, Simulation, c_string};
use crate::value::{Handle, Value};

const DO_STEP: &str = "fmi3DoStep";

/// The values of arrays, by the references of their variables.
type Written = HashMap<u32, Vec<Value>>;

/// A component for Co-Simulation; the equations of one for Model Exchange stand on it.
#[derive(Debug)]
pub(crate) struct Model {
    pub(super) functions: Functions,
    pub(super) component: Component,
    pub(super) elements: Arc<[Element]>,
    /// The values of the arrays that were written before the initialisation, by their references; none after it.
    pub(super) written: Option<Written>,
    /// The same in each state that was saved.
    saved: Vec<(*mut c_void, Option<Written>)>,
    experiment: Experiment,
    /// Numbers of plain elements that were read together last, and their value references.
    together: Vec<u32>,
    references: Vec<u32>,
}

// SAFETY: FMI 3.0 ties a component to no thread; it only forbids concurrent calls, which `&mut self`
// and the missing `Sync` rule out.
unsafe impl Send for Model {}

impl Model {
    /// Creates a component.
    pub(crate) fn new(
        functions: Functions,
        elements: Arc<[Element]>,
        birth: &Birth<'_>,
        caller: &mut Caller,
        name: &str,
    ) -> Result<Self, Call> {
        const LOGGER: LogMessage = log_message;
        let [name, token, resources] = [name, birth.guid, birth.resources].map(c_string);
        let environment = caller.log.environment();
        let strings = (name.as_ptr(), token.as_ptr(), resources.as_ptr());
        let (function, component) = match functions.instantiate {
            Instantiates::CoSimulation(create) => {
                // SAFETY: the strings live through the call; there are no intermediate variables, and no callback for
                // them.
                let component = caller.call(|| unsafe {
                    create(
                        strings.0,
                        strings.1,
                        strings.2,
                        false,
                        false,
                        false,
                        false,
                        ptr::null(),
                        0,
                        environment,
                        LOGGER,
                        ptr::null(),
                    )
                });
                ("fmi3InstantiateCoSimulation", component)
            }
            Instantiates::ModelExchange(create) => {
                // SAFETY: the strings live through the call.
                let component = caller.call(|| unsafe {
                    let (name, token, resources) = strings;
                    create(name, token, resources, false, false, environment, LOGGER)
                });
                ("fmi3InstantiateModelExchange", component)
            }
        };
        if component.is_null() {
            return Err(birth.refused(caller, function));
        }
        let mut simulation = Self {
            functions,
            component,
            elements,
            written: Some(Written::new()),
            saved: Vec::new(),
            experiment: Experiment::default(),
            together: Vec::new(),
            references: Vec::new(),
        };
        simulation.log_troubles(caller, birth.categories);
        Ok(simulation)
    }

    /// Asks the FMU for its errors and warnings, where it has categories for them.
    fn log_troubles(&mut self, caller: &mut Caller, categories: &[String]) {
        let names: Vec<CString> = categories.iter().map(|name| c_string(name)).collect();
        if let (Some(function), false) = (self.functions.set_debug_logging, names.is_empty()) {
            let pointers: Vec<*const c_char> = names.iter().map(|name| name.as_ptr()).collect();
            // SAFETY: the array holds as many valid strings as stated. What it returns does not
            // matter: without it there are fewer messages.
            caller.call(|| unsafe {
                function(self.component, true, pointers.len(), pointers.as_ptr())
            });
        }
    }

    /// Whether all are numbers by themselves, whose value references are in `references` then.
    fn are_plain(&mut self, numbers: &[u32]) -> bool {
        if self.together == numbers {
            return true;
        }
        let elements = &self.elements;
        let plain = |number: &u32| elements.get(*number as usize).filter(|one| one.is_plain());
        let references = numbers
            .iter()
            .map(|number| plain(number).map(|element| element.reference));
        let Some(references) = references.collect::<Option<Vec<u32>>>() else {
            return false;
        };
        self.references = references;
        self.together = numbers.to_vec();
        true
    }

    /// Lets time pass up to the next return of the FMU, s.
    fn part(&mut self, caller: &mut Caller, time: f64, step: f64) -> Result<Return, Call> {
        let (mut event, mut terminate, mut early) = (0_u8, 0_u8, 0_u8);
        let mut reached = f64::NAN;
        let do_step = self.functions.do_step;
        // SAFETY: the component is alive, and the four places are valid.
        let status = caller.call(|| unsafe {
            do_step(
                self.component,
                time,
                step,
                true,
                &raw mut event,
                &raw mut terminate,
                &raw mut early,
                &raw mut reached,
            )
        });
        let ended = terminate != 0;
        let known = (time..=time + step).contains(&reached);
        match caller.check(DO_STEP, status) {
            Err(call) if ended && call.status == Status::Discard => {
                Ok(Return::Ended(if known { reached } else { time }))
            }
            Err(call) => Err(call),
            Ok(()) if ended => Ok(Return::Ended(if known { reached } else { time + step })),
            Ok(()) if early == 0 || reached == time + step => Ok(Return::Done),
            Ok(()) if known && reached > time => Ok(Return::Early(reached)),
            Ok(()) => {
                let why = format!("it returned early, at {reached} s of a step from {time} s");
                Err(Call::impossible(DO_STEP, why))
            }
        }
    }
}

/// How a step returned.
enum Return {
    /// It was done.
    Done,
    /// Before its end, at this time, s.
    Early(f64),
    /// The FMU wants no further step; the time that it reached, s.
    Ended(f64),
}

impl Simulation for Model {
    fn set_up(&mut self, _: &mut Caller, experiment: Experiment) -> Result<(), Call> {
        // Told when the initialisation begins.
        self.experiment = experiment;
        Ok(())
    }

    fn initialise(&mut self, caller: &mut Caller, inputs: &[(u32, Value)]) -> Result<(), Call> {
        let Experiment {
            start,
            stop,
            tolerance,
        } = self.experiment;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe {
            (self.functions.enter_initialization_mode)(
                self.component,
                tolerance.is_some(),
                tolerance.unwrap_or(0.0),
                start,
                true,
                stop,
            )
        });
        caller.check("fmi3EnterInitializationMode", status)?;
        for (reference, value) in inputs {
            self.set(caller, *reference, value)?;
        }
        self.written = None;
        // SAFETY: the component is alive.
        let status =
            caller.call(|| unsafe { (self.functions.exit_initialization_mode)(self.component) });
        caller.check("fmi3ExitInitializationMode", status)
    }

    #[inline(never)]
    fn reals(
        &mut self,
        caller: &mut Caller,
        references: &[u32],
        into: &mut [f64],
    ) -> Result<(), Call> {
        assert_eq!(references.len(), into.len(), "a place for each reference");
        let access = self.functions.float64;
        if let Some(get) = access.get.filter(|_| self.are_plain(references)) {
            let count = into.len();
            // SAFETY: both arrays hold `count` elements.
            let status = caller.call(|| unsafe {
                get(
                    self.component,
                    self.references.as_ptr(),
                    count,
                    into.as_mut_ptr(),
                    count,
                )
            });
            return caller.check(access.getter, status);
        }
        // The elements of an array are read together.
        let mut array: Option<(u32, Vec<f64>)> = None;
        let elements = Arc::clone(&self.elements);
        for (number, place) in references.iter().zip(into) {
            let element = Element::of(&elements, *number)?;
            if element.of == 1 || element.storage != Storage::Float64 {
                *place = self.read(caller, *number)?.number();
                continue;
            }
            let known = array.take().filter(|(of, _)| *of == element.reference);
            let (_, values) = array.insert(match known {
                Some(known) => known,
                None => (element.reference, self.all(caller, access, element, 0.0)?),
            });
            *place = values[element.index];
        }
        Ok(())
    }

    fn value(&mut self, caller: &mut Caller, handle: Handle) -> Result<Value, Call> {
        self.read(caller, handle.reference)
    }

    fn set(&mut self, caller: &mut Caller, reference: u32, value: &Value) -> Result<(), Call> {
        self.write(caller, reference, value)
    }

    fn set_slope(&mut self, _: &mut Caller, _: u32, _: f64) -> Result<(), Call> {
        let why = "FMI 3.0 has no function for rates of inputs".to_owned();
        Err(Call::impossible("fmi3SetRealInputDerivatives", why))
    }

    #[inline(never)]
    fn step(&mut self, caller: &mut Caller, time: f64, step: f64) -> Result<(), Call> {
        let end = time + step;
        let (mut from, mut rest) = (time, step);
        loop {
            match self.part(caller, from, rest)? {
                Return::Done => return Ok(()),
                // The rest of the step.
                Return::Early(at) => (from, rest) = (at, end - at),
                Return::Ended(at) => {
                    return Err(Call {
                        function: DO_STEP,
                        status: Status::Discard,
                        message: Some("the FMU wants no further step".to_owned()),
                        ended: Some(End { from: time, at }),
                    });
                }
            }
        }
    }

    fn reset(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let reset = self.functions.reset;
        let reset = reset.ok_or_else(|| Call::missing("fmi3Reset"))?;
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { reset(self.component) });
        self.written = Some(Written::new());
        caller.check("fmi3Reset", status)
    }

    fn terminate(&mut self, caller: &mut Caller) -> Result<(), Call> {
        let Some(terminate) = self.functions.terminate else {
            return Ok(());
        };
        // SAFETY: the component is alive.
        let status = caller.call(|| unsafe { terminate(self.component) });
        caller.check("fmi3Terminate", status)
    }

    fn save(&mut self, caller: &mut Caller) -> Option<*mut c_void> {
        let (get, _, _) = self.functions.states?;
        let mut state = ptr::null_mut();
        // SAFETY: the component is alive, and the state is a valid place to write to.
        let status = caller.call(|| unsafe { get(self.component, &raw mut state) });
        caller.check("fmi3GetFMUState", status).ok()?;
        self.saved.retain(|(saved, _)| *saved != state);
        self.saved.push((state, self.written.clone()));
        Some(state)
    }

    fn restore(&mut self, caller: &mut Caller, state: *mut c_void) -> Result<(), Call> {
        let states = self.functions.states;
        let (_, set, _) = states.ok_or_else(|| Call::missing("fmi3SetFMUState"))?;
        // SAFETY: the component is alive, and the state is one of its own.
        let status = caller.call(|| unsafe { set(self.component, state) });
        let saved = self.saved.iter().find(|(saved, _)| *saved == state);
        // An FMU may give one address to several states.
        self.written = saved.and_then(|(_, written)| written.clone());
        caller.check("fmi3SetFMUState", status)
    }

    fn forget(&mut self, caller: &mut Caller, mut state: *mut c_void) -> Result<(), Call> {
        let states = self.functions.states;
        let (_, _, free) = states.ok_or_else(|| Call::missing("fmi3FreeFMUState"))?;
        self.saved.retain(|(saved, _)| *saved != state);
        // SAFETY: the component is alive, and the state is one of its own, used no more.
        let status = caller.call(|| unsafe { free(self.component, &raw mut state) });
        caller.check("fmi3FreeFMUState", status)
    }

    fn free(&mut self, caller: &mut Caller) {
        // SAFETY: the component is alive and never used again.
        caller.call(|| unsafe { (self.functions.free_instance)(self.component) });
    }
}
